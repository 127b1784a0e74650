//! A test picture of a sphere, against the analytic answer.

use std::path::PathBuf;
use std::sync::Arc;

use decor_api::{
    Adapter, Bounds, Camera, Csg, Geometry, Instance, LayerRequest, LayerShot, Optics, Output,
    Pose, Prototype, PrototypeTable, Region, Rgb, RunContext, Scene, Size,
};
use glam::DVec3;

use crate::adapter::Reference;

/// Every depth of the picture of a sphere is the one of the formula.
pub(crate) fn sphere_is_where_it_should_be(
    adapter: &Reference,
    run: &RunContext,
) -> Result<String, String> {
    const RADIUS: f64 = 1.0;
    const AWAY: f64 = 3.0;
    let size = Size {
        width: 64,
        height: 48,
    };
    let camera = Camera::look_at(DVec3::Z * -AWAY, DVec3::ZERO, DVec3::Y, (60.0, 45.0))
        .map_err(|e| e.to_string())?;
    let mut prototypes = PrototypeTable::default();
    let prototype = prototypes.insert(Prototype {
        extent: None,
        path: PathBuf::from("sphere"),
        hash: "sphere".to_owned(),
        geometry: Geometry::Neutral(Csg::Sphere {
            centre: DVec3::ZERO,
            radius: RADIUS,
        }),
        bounds: Bounds::sphere(DVec3::ZERO, RADIUS),
        optics: Optics::Opaque,
        unlayerable: None,
    });
    let scene = Scene {
        camera,
        lights: Vec::new(),
        shadows: false,
        background: Rgb::default(),
        includes: Vec::new(),
        sky: None,
        instances: vec![Instance {
            prototype,
            pose: Pose::IDENTITY,
        }],
        hidden: Vec::new(),
    };
    let request = LayerRequest {
        prototypes: &prototypes,
        size,
        output: Output::Depth,
        antialias: None,
        shots: vec![LayerShot {
            frame: 0,
            scene: Arc::new(scene),
            region: Region::Window(size.window()),
        }],
        film: None,
        label: "health".to_owned(),
    };
    let layers = adapter.render(&request, run).map_err(|e| e.to_string())?;
    let depths = layers.first().and_then(|layer| layer.depth.as_deref());
    let depths = depths.ok_or("no depth came back")?;

    let mut worst = 0.0_f64;
    for (i, &depth) in (0_u32..).zip(depths) {
        let centre = |v: u32| f64::from(v) + 0.5;
        let direction = camera.direction(size, centre(i % size.width), centre(i / size.width));
        // The angle to the axis gives the side of the triangle eye – centre –
        // surface.
        let cosine = direction.normalize().z;
        let chord = RADIUS * RADIUS - AWAY * AWAY * (1.0 - cosine * cosine);
        if (chord > 0.0) != depth.is_finite() {
            return Err(format!("pixel {i} of the sphere's outline is wrong"));
        }
        if chord > 0.0 {
            let expected = AWAY * cosine - chord.sqrt();
            worst = worst.max((depth - expected).abs());
        }
    }
    if worst < 1e-6 {
        Ok(format!("largest error {worst:.1e} at a distance of {AWAY}"))
    } else {
        Err(format!("the depth of a sphere is off by {worst:.1e}"))
    }
}

//! Is POV-Ray there, and does it do what decor relies on?

use std::sync::Arc;

use decor_api::{
    Adapter, AdapterError, Bounds, Camera, Csg, Geometry, Health, Instance, Layer, LayerRequest,
    LayerShot, Material, Optics, Output, Pose, Prototype, PrototypeTable, Region, Rgb, RunContext,
    Scene, Size,
};
use glam::DVec3;

use crate::{INSTALL, LayerSource, PovRay};

const SIZE: Size = Size {
    width: 64,
    height: 48,
};

/// Renders a ball in the middle of a tiny picture, and looks at it.
pub fn check(adapter: &PovRay, run: &RunContext) -> Health {
    let checks = vec![
        (
            "colour".to_owned(),
            colour(adapter, run).map_err(|e| e.to_string()),
        ),
        (
            "depth".to_owned(),
            depth(adapter, run).map_err(|e| e.to_string()),
        ),
        (
            "blocks by the state file".to_owned(),
            blocks(adapter, run).map_err(|e| e.to_string()),
        ),
    ];
    Health {
        program: Some(adapter.program().to_owned()),
        version: Some(adapter.abilities().version.clone()),
        checks,
        install: INSTALL.to_owned(),
    }
}

fn colour(adapter: &PovRay, run: &RunContext) -> Result<String, AdapterError> {
    let layer = ball(
        adapter,
        run,
        Output::ColourOverBackground,
        Region::Window(SIZE.window()),
    )?;
    let colours = layer.colour.unwrap_or_default();
    let (corner, middle) = (colours[0], colours[24 * 64 + 32]);
    if corner == middle || middle[0] == 0.0 {
        return Err(wrong("a red ball was rendered and is not to be seen"));
    }
    Ok(match adapter.source() {
        LayerSource::StateFile => "read in single precision".into(),
        LayerSource::Pictures => "read with 16 bits".into(),
    })
}

fn depth(adapter: &PovRay, run: &RunContext) -> Result<String, AdapterError> {
    let layer = ball(adapter, run, Output::Depth, Region::Window(SIZE.window()))?;
    let depths = layer.depth.unwrap_or_default();
    // Half a pixel beside the axis, the ray meets the ball of radius 1 at 5 at
    // 5·cos θ − √(1 − 25·sin² θ).
    let direction = camera()?.direction(SIZE, 32.5, 24.5);
    let cosine = direction.z / direction.length();
    let expected = 5.0 * cosine - (1.0 - 25.0 * (1.0 - cosine * cosine)).sqrt();
    let found = depths[24 * 64 + 32];
    if (found - expected).abs() > 1e-4 || depths[0] != f64::INFINITY {
        return Err(wrong(&format!(
            "a surface at {expected} was measured at {found}"
        )));
    }
    Ok(format!(
        "right to {:.0e}",
        (found - expected).abs().max(1e-9)
    ))
}

fn blocks(adapter: &PovRay, run: &RunContext) -> Result<String, AdapterError> {
    if adapter.source() == LayerSource::Pictures {
        return Ok("not relied on with this version: windows are rendered instead".into());
    }
    let whole = ball(
        adapter,
        run,
        Output::ColourOverBackground,
        Region::Window(SIZE.window()),
    )?;
    let part = ball(
        adapter,
        run,
        Output::ColourOverBackground,
        Region::Blocks(vec![1]),
    )?;
    let (whole_colours, colours) = (whole.colour.clone(), part.colour.clone());
    let (Some(whole_colours), Some(colours)) = (whole_colours, colours) else {
        return Err(wrong("no colours were read"));
    };
    for y in part.window.y..part.window.bottom() {
        for x in part.window.x..part.window.right() {
            if colours[part.index(x, y)] != whole_colours[whole.index(x, y)] {
                return Err(wrong(
                    "a block alone differs from the same block of a whole picture",
                ));
            }
        }
    }
    Ok("a block alone is identical to the whole picture's".into())
}

fn wrong(reason: &str) -> AdapterError {
    AdapterError::BadOutput {
        program: "povray".into(),
        file: "a test picture".into(),
        reason: reason.to_owned(),
    }
}

fn camera() -> Result<Camera, AdapterError> {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 45.0)).map_err(|e| {
        AdapterError::Unsupported {
            adapter: "povray".into(),
            what: e.to_string(),
        }
    })
}

fn ball(
    adapter: &PovRay,
    run: &RunContext,
    output: Output,
    region: Region,
) -> Result<Layer, AdapterError> {
    let mut prototypes = PrototypeTable::default();
    let look = Material {
        colour: Rgb([1.0, 0.1, 0.1]),
        ambient: 1.0,
        diffuse: 0.0,
        ..Material::default()
    };
    let sphere = Csg::Sphere {
        centre: DVec3::ZERO,
        radius: 1.0,
    };
    let prototype = prototypes.insert(Prototype {
        extent: None,
        path: "ball".into(),
        hash: "ball".into(),
        geometry: Geometry::Neutral(Csg::Look(look, Box::new(sphere))),
        bounds: Bounds::sphere(DVec3::ZERO, 1.0),
        optics: Optics::Opaque,
        unlayerable: None,
    });
    let scene = Scene {
        camera: camera()?,
        lights: Vec::new(),
        shadows: false,
        background: Rgb([0.0, 0.0, 0.2]),
        includes: Vec::new(),
        sky: None,
        instances: vec![Instance {
            prototype,
            pose: Pose {
                position: DVec3::new(0.0, 0.0, 5.0),
                angles_deg: DVec3::ZERO,
            },
        }],
        hidden: Vec::new(),
    };
    let request = LayerRequest {
        prototypes: &prototypes,
        size: SIZE,
        output,
        antialias: None,
        shots: vec![LayerShot {
            frame: 0,
            scene: Arc::new(scene),
            region,
        }],
        film: None,
        label: "health".into(),
    };
    adapter
        .render(&request, run)?
        .pop()
        .ok_or_else(|| wrong("no layer came back"))
}

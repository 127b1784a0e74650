//! Is Mitsuba there, and does it do what decor relies on?

use std::sync::Arc;

use decor_api::{
    Adapter, AdapterError, Camera, Csg, Geometry, Health, Instance, LayerRequest, LayerShot, Light,
    LightKind, Optics, Output, Pose, Prototype, PrototypeTable, Region, Rgb, RunContext, Scene,
    Size, health,
};
use glam::DVec3;

use crate::{INSTALL, Mitsuba};

const SIZE: Size = Size {
    width: 64,
    height: 48,
};

/// Renders a ball over a floor in tiny pictures, and looks at them.
pub(crate) fn check(adapter: &Mitsuba, run: &RunContext) -> Health {
    let said = |name: &str, result: Result<String, AdapterError>| {
        (name.to_owned(), result.map_err(|e| e.to_string()))
    };
    Health {
        program: Some(adapter.program().to_owned()),
        version: Some(adapter.abilities().version.clone()),
        checks: vec![
            said("depth", health::depth(adapter, run, 1e-5)),
            said("shadows", shadows(adapter, run)),
            said("blocks behind a mask", health::blocks(adapter, run)),
        ],
        install: INSTALL.to_owned(),
    }
}

/// The sun stands behind the ball: the floor before it is in its shadow.
fn shadows(adapter: &Mitsuba, run: &RunContext) -> Result<String, AdapterError> {
    let red_under_the_ball = |shadows: bool| {
        let layer = draw(adapter, run, shadows)?;
        let colours = layer.colour.unwrap_or_default();
        Ok(colours.get(44 * 64 + 32).map_or(0.0, |c| c[0]))
    };
    let (dark, lit) = (red_under_the_ball(true)?, red_under_the_ball(false)?);
    if dark > 0.01 {
        return Err(health::wrong(
            adapter,
            "what is in a ball's shadow is lit".to_owned(),
        ));
    }
    if lit < 0.1 {
        return Err(health::wrong(
            adapter,
            "what is lit without shadows is dark".to_owned(),
        ));
    }
    Ok("cast where they are asked for, and nowhere else".to_owned())
}

fn camera() -> Result<Camera, AdapterError> {
    // Squares: tan 22.5° is 3/4 of the other half's.
    let half = (0.75 * 30.0_f64.to_radians().tan()).atan().to_degrees();
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 2.0 * half))
        .map_err(|e| crate::unsupported(&e.to_string()))
}

fn draw(
    adapter: &Mitsuba,
    run: &RunContext,
    shadows: bool,
) -> Result<decor_api::Layer, AdapterError> {
    let mut prototypes = PrototypeTable::default();
    let mut put = |name: &str, solid: Csg, position: DVec3| Instance {
        prototype: prototypes.insert(Prototype {
            path: name.into(),
            hash: format!("health: {name}"),
            bounds: solid.bounds(),
            geometry: Geometry::Neutral(solid),
            extents: Vec::new(),
            optics: Optics::Opaque,
            unlayerable: None,
        }),
        pose: Pose {
            position,
            angles_deg: DVec3::ZERO,
        },
    };
    let look = |node: Csg| {
        let material = decor_api::Material {
            ambient: 0.0,
            ..decor_api::Material::default()
        };
        Csg::Look(material, Box::new(node))
    };
    let ball = look(Csg::Sphere {
        centre: DVec3::ZERO,
        radius: 1.0,
    });
    let floor = look(Csg::Plane {
        normal: DVec3::Y,
        distance: 0.0,
    });
    let instances = vec![
        put("ball", ball, DVec3::Z * 5.0),
        put("floor", floor, DVec3::Y * -1.6),
    ];
    let scene = Scene {
        camera: camera()?,
        lights: vec![Light {
            position: DVec3::new(0.0, 2.0, 6.0),
            colour: Rgb([1.0; 3]),
            kind: LightKind::Sun {
                towards: DVec3::new(0.0, -1.6, 4.0),
            },
            fade: None,
        }],
        shadows,
        background: Rgb::default(),
        includes: Vec::new(),
        sky: None,
        instances,
        hidden: Vec::new(),
    };
    let request = LayerRequest {
        prototypes: &prototypes,
        size: SIZE,
        output: Output::ColourOverBackground,
        antialias: None,
        shots: vec![LayerShot {
            frame: 0,
            scene: Arc::new(scene),
            region: Region::Window(SIZE.window()),
        }],
        film: None,
        label: "health".to_owned(),
    };
    let mut layers = adapter.render(&request, run)?;
    layers
        .pop()
        .ok_or_else(|| health::wrong(adapter, "no layer came back".to_owned()))
}

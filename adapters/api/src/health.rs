//! Test pictures for `doctor`: a ball before the observer, which any renderer can
//! draw, and what is known of it beforehand.

use std::sync::Arc;

use glam::DVec3;

use crate::adapter::{Adapter, AdapterError, LayerRequest, LayerShot, Output, Region, RunContext};
use crate::blocks::Blocks;
use crate::bounds::Bounds;
use crate::camera::Camera;
use crate::csg::Csg;
use crate::layer::{Layer, Size};
use crate::material::Material;
use crate::prototype::{Geometry, Optics, Prototype, PrototypeTable};
use crate::scene::{Instance, Pose, Rgb, Scene};

const SIZE: Size = Size {
    width: 64,
    height: 48,
};
const RADIUS: f64 = 1.0;
const AWAY: f64 = 5.0;

/// Is the depth right, in every pixel of the ball and around it? `limit`: by how
/// much it may be off, in scene units, at distances of about 4.
///
/// # Errors
/// What the adapter says, or what is wrong.
pub fn depth(adapter: &dyn Adapter, run: &RunContext, limit: f64) -> Result<String, AdapterError> {
    let whole = Region::Window(SIZE.window());
    let layer = ball(adapter, run, Output::Depth, whole)?;
    let wrong = |reason: String| wrong(adapter, reason);
    let depths = layer.depth.unwrap_or_default();
    if depths.len() != SIZE.pixels() {
        return Err(wrong("no depth came back".to_owned()));
    }
    let camera = camera(adapter)?;
    let mut worst = 0.0_f64;
    for (pixel, &found) in (0_u32..).zip(&depths) {
        let centre = |v: u32| f64::from(v) + 0.5;
        let direction =
            camera.direction(SIZE, centre(pixel % SIZE.width), centre(pixel / SIZE.width));
        // The angle to the axis gives the side of the triangle eye – centre –
        // surface.
        let cosine = direction.normalize().z;
        let chord = RADIUS * RADIUS - AWAY * AWAY * (1.0 - cosine * cosine);
        if (chord > 0.0) != found.is_finite() {
            return Err(wrong(format!("pixel {pixel} of a ball's outline is wrong")));
        }
        if chord > 0.0 {
            let expected = AWAY * cosine - chord.sqrt();
            let off = (found - expected).abs();
            if off > limit {
                let reason = format!("a surface at {expected} was measured at {found}");
                return Err(wrong(reason));
            }
            worst = worst.max(off);
        }
    }
    Ok(format!("right to {:.0e}", worst.max(1e-9)))
}

/// Is a glowing ball to be seen before the background?
///
/// # Errors
/// What the adapter says, or what is wrong.
pub fn colour(adapter: &dyn Adapter, run: &RunContext) -> Result<String, AdapterError> {
    let whole = Region::Window(SIZE.window());
    let layer = ball(adapter, run, Output::ColourOverBackground, whole)?;
    let colours = layer.colour.unwrap_or_default();
    let (corner, middle) = (colours.first(), colours.get(SIZE.pixels() / 2 + 32));
    match (corner, middle) {
        (Some(corner), Some(middle)) if corner != middle && middle[0] > 0.0 => {
            Ok("a red ball is red".to_owned())
        }
        _ => {
            let reason = "a red ball was rendered and is not to be seen";
            Err(wrong(adapter, reason.to_owned()))
        }
    }
}

/// Is a block by itself the whole picture's?
///
/// # Errors
/// What the adapter says, or what is wrong.
pub fn blocks(adapter: &dyn Adapter, run: &RunContext) -> Result<String, AdapterError> {
    let colour = Output::ColourOverBackground;
    let whole = ball(adapter, run, colour, Region::Window(SIZE.window()))?;
    let part = ball(adapter, run, colour, Region::Blocks(Blocks::usual(vec![1])))?;
    let (Some(of_whole), Some(of_part)) = (&whole.colour, &part.colour) else {
        return Err(wrong(adapter, "no colours were read".to_owned()));
    };
    for y in part.window.y..part.window.bottom() {
        for x in part.window.x..part.window.right() {
            if of_part[part.index(x, y)] != of_whole[whole.index(x, y)] {
                let reason = "a block alone differs from the same block of a whole picture";
                return Err(wrong(adapter, reason.to_owned()));
            }
        }
    }
    Ok("a block alone is identical to the whole picture's".to_owned())
}

/// A test picture that is wrong.
pub fn wrong(adapter: &dyn Adapter, reason: String) -> AdapterError {
    AdapterError::BadOutput {
        program: adapter.name().to_owned(),
        file: "a test picture".into(),
        reason,
    }
}

fn camera(adapter: &dyn Adapter) -> Result<Camera, AdapterError> {
    // Pixels are squares: not every renderer has others.
    let aspect = f64::from(SIZE.height) / f64::from(SIZE.width);
    let vertical = 2.0 * (aspect * 30.0_f64.to_radians().tan()).atan().to_degrees();
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, vertical)).map_err(|error| {
        AdapterError::Unsupported {
            adapter: adapter.name().to_owned(),
            what: error.to_string(),
        }
    })
}

fn ball(
    adapter: &dyn Adapter,
    run: &RunContext,
    output: Output,
    region: Region,
) -> Result<Layer, AdapterError> {
    let mut prototypes = PrototypeTable::default();
    // Seen without any light.
    let look = Material {
        colour: Rgb([1.0, 0.1, 0.1]),
        ambient: 1.0,
        diffuse: 0.0,
        ..Material::default()
    };
    let sphere = Csg::Sphere {
        centre: DVec3::ZERO,
        radius: RADIUS,
    };
    let prototype = prototypes.insert(Prototype {
        path: "ball".into(),
        hash: "ball".into(),
        geometry: Geometry::Neutral(Csg::Look(look, Box::new(sphere))),
        bounds: Bounds::sphere(DVec3::ZERO, RADIUS),
        extents: Vec::new(),
        optics: Optics::Opaque,
        unlayerable: None,
    });
    let scene = Scene {
        camera: camera(adapter)?,
        lights: Vec::new(),
        shadows: false,
        background: Rgb([0.0, 0.0, 0.2]),
        includes: Vec::new(),
        sky: None,
        instances: vec![Instance {
            prototype,
            pose: Pose {
                position: DVec3::Z * AWAY,
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
        label: "health".to_owned(),
    };
    let layer = adapter.render(&request, run)?.pop();
    layer.ok_or_else(|| wrong(adapter, "no layer came back".to_owned()))
}

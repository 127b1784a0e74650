//! The unit of length that a scene is written in, and where its lights are full.
//!
//! Coordinates are written from the eye, in single precision: what is near the
//! eye keeps its digits wherever the scene is. They are multiplied by a power of
//! two, which costs no digit and decides one thing: Mitsuba starts a shadow ray
//! `1.8e-4 · (1 + the largest coordinate)` off the surface.
//!
//! - With shadows the scene is written large, so that the 1 does not count and
//!   small scenes have shadows too.
//! - *Without* shadows it is written so small that every shadow ray starts far
//!   outside of the scene, and ends, a share of 1.8e-3 before its light, still
//!   outside: nothing is in its way. Mitsuba has no other way to light without
//!   shadows.

use decor_api::{AdapterError, Bounds, Light, LightKind, Scene};

use crate::solid::Model;
use crate::unsupported;

/// The exponent of two of scenes with shadows, and of those without up to a
/// reach of 2¹⁰.
const LARGE: i32 = 10;
const SMALL: i32 = -36;

/// The nearest that the camera sees, as it is written. Its square must be a
/// normal number of single precision.
const NEAR_LARGE: f64 = 1e-3;
const NEAR_SMALL: f64 = 4e-15;

/// How a scene's lengths are written.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Units {
    /// What a length is multiplied by: a power of two.
    pub scale: f64,
    /// The distance of the near plane, as it is written.
    pub near: f64,
    /// The distance of the far plane, as it is written.
    pub far: f64,
}

impl Units {
    /// `models`: those of the scene's instances, in order.
    pub fn of(scene: &Scene, models: &[Placed<'_>]) -> Result<Self, AdapterError> {
        let far = |scale: f64| 1e12 * scale;
        if scene.shadows || scene.lights.is_empty() {
            let scale = 2.0_f64.powi(LARGE);
            return Ok(Self {
                scale,
                near: NEAR_LARGE,
                far: far(scale),
            });
        }
        let lights = scene.lights.iter().map(|light| reach_of(scene, light));
        let solids = models.iter().map(|placed| placed.farthest);
        let reach = lights.chain(solids).fold(0.0, f64::max);
        let beyond = (reach.log2().ceil() as i32 - 10).max(0);
        let scale = 2.0_f64.powi(SMALL - beyond);
        let units = Self {
            scale,
            near: NEAR_SMALL,
            far: far(scale),
        };
        let nearest = models.iter().map(|placed| placed.nearest);
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        // Single precision ends at 1e-38; squares of lengths are computed.
        if beyond > 20 || beyond > 0 && nearest * scale < units.near {
            return Err(unsupported(&format!(
                "without shadows what is {nearest} from the eye together with what is {reach} from it"
            )));
        }
        Ok(units)
    }
}

fn reach_of(scene: &Scene, light: &Light) -> f64 {
    match light.kind {
        LightKind::Sun { .. } => 0.0,
        LightKind::Area { u, v, .. } => {
            light.position.distance(scene.camera.eye) + u.length() + v.length()
        }
        _ => light.position.distance(scene.camera.eye),
    }
}

/// An instance of a scene with its model.
#[derive(Clone, Debug)]
pub(crate) struct Placed<'a> {
    pub model: &'a Model,
    /// Its prototype's number: what its files are called by.
    pub number: u32,
    /// From the model's coordinates to those from the eye.
    pub from_eye: glam::DAffine3,
    /// How near and how far it is; its half-spaces' planes are as far as their
    /// nearest points.
    pub nearest: f64,
    pub farthest: f64,
}

impl<'a> Placed<'a> {
    /// `bounds`: in the world.
    pub fn new(
        model: &'a Model,
        number: u32,
        bounds: Bounds,
        from_eye: glam::DAffine3,
        eye: glam::DVec3,
    ) -> Self {
        let (mut nearest, mut farthest) = match bounds {
            Bounds::Sphere(s) => {
                let distance = s.centre.distance(eye);
                ((distance - s.radius).max(0.0), distance + s.radius)
            }
            _ => (f64::INFINITY, 0.0),
        };
        for half in &model.half_spaces {
            let point = from_eye.transform_point3(half.point);
            let height = point.dot(from_eye.matrix3 * half.normal).abs();
            nearest = nearest.min(height);
            farthest = farthest.max(height);
        }
        Self {
            model,
            number,
            from_eye,
            nearest,
            farthest,
        }
    }
}

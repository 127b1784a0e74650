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
//!   shadows. The price: what is nearer to the eye than about 3e-4 of its height
//!   above a floor, or 3e-7 of the whole scene's size, is cut off.

use decor_api::{AdapterError, Bounds, Light, LightKind, Scene};

use crate::solid::Model;
use crate::unsupported;

/// What lengths are multiplied by where there are shadows.
const LARGE: f64 = 1024.0;

/// How large all that is drawn may be where there are none: well below the
/// 3.2e-7 before a light at which a shadow ray ends.
const SMALL: f64 = 1.0 / 4_194_304.0;

/// Below this, squares of lengths leave single precision.
const SMALLEST: f64 = 1e-17;

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
            return Ok(Self {
                scale: LARGE,
                near: NEAR_LARGE,
                far: far(LARGE),
            });
        }
        let lights = scene.lights.iter().map(|light| reach_of(scene, light));
        let reach = lights.fold(farthest(models), f64::max);
        let highest = models.iter().map(|placed| placed.highest);
        let drawn = highest.fold(reach, |drawn, height| drawn.max(drawn_to(height, reach)));
        let scale = SMALL / 2.0_f64.powi(drawn.max(1e-9).log2().ceil() as i32);
        if scale < SMALLEST {
            return Err(unsupported(&format!(
                "a scene of {reach} units without shadows: it is too large"
            )));
        }
        Ok(Self {
            scale,
            near: NEAR_SMALL,
            far: far(scale),
        })
    }
}

/// How far plane surfaces without an end are drawn, in heights of the eye above
/// them: their edge is a tenth of a pixel below the horizon of a picture of
/// 1000 pixels.
const HORIZON: f64 = 1e4;

/// How far a plane is drawn around the point below the eye, which is `height`
/// above it; other things reach as far as `reach`. A power of two: how far it
/// is drawn rounds nothing else.
pub(crate) fn drawn_to(height: f64, reach: f64) -> f64 {
    let far = (HORIZON * height).max(4.0 * reach);
    if far > 0.0 {
        2.0_f64.powi(far.log2().ceil() as i32)
    } else {
        1.0
    }
}

/// The distance of the farthest thing that has an end.
pub(crate) fn farthest(models: &[Placed<'_>]) -> f64 {
    models.iter().map(|p| p.farthest).fold(0.0, f64::max)
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
    /// How far it reaches; of its half-spaces, how far the nearest points are.
    pub farthest: f64,
    /// How far the eye is from the planes of its half-spaces, at most; 0 where
    /// there are none.
    pub highest: f64,
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
        let heights = model.half_spaces.iter();
        let heights = heights.map(|half| half.seen_by(&from_eye).1.abs());
        let highest = heights.fold(0.0, f64::max);
        let farthest = match bounds {
            Bounds::Sphere(s) => s.centre.distance(eye) + s.radius,
            _ => highest,
        };
        Self {
            model,
            number,
            from_eye,
            farthest,
            highest,
        }
    }
}

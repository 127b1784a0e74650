//! Lights as Mitsuba's emitters.
//!
//! Mitsuba draws lots which light a ray asks. One light alone leaves it no
//! choice: every emitter is rendered by itself, without noise, and the pictures
//! are added. An area light is the grid of points that the film says it is.
//!
//! Points and spots fall off with the square of the distance; a light has its
//! full colour at its fade distance, or, where none is stated, at the distance
//! of the origin. Full colour means that a white surface across the way looks
//! as the light does: Mitsuba divides by π, so its powers are multiplied by it.

use std::f64::consts::PI;

use decor_api::{AdapterError, Light, LightKind, Rgb, Scene, area_samples};
use glam::{DMat3, DVec3};

use crate::units::Units;
use crate::unsupported;
use crate::xml::{matrix, number, point, rgb, vector};

/// One light that Mitsuba has, from the eye.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Emitter {
    /// A point's intensity, at a distance of 1.
    Point { position: DVec3, intensity: Rgb },
    /// Parallel rays.
    Sun { direction: DVec3, irradiance: Rgb },
    /// A cone.
    Spot {
        position: DVec3,
        axis: DVec3,
        intensity: Rgb,
        radius_deg: f64,
        falloff_deg: f64,
    },
}

/// All emitters of a scene; none is black. `squeezed`: what is done to the
/// world, from the eye.
pub(crate) fn emitters(scene: &Scene, squeezed: DMat3) -> Result<Vec<Emitter>, AdapterError> {
    let mut all = Vec::new();
    for light in &scene.lights {
        if light.colour.0.iter().any(|c| *c > 0.0) {
            add(&mut all, light, scene.camera.eye)?;
        }
    }
    for emitter in &mut all {
        match emitter {
            Emitter::Point { position, .. } => *position = squeezed * *position,
            Emitter::Sun { direction, .. } => *direction = squeezed * *direction,
            Emitter::Spot { position, axis, .. } => {
                *position = squeezed * *position;
                *axis = (squeezed * *axis).normalize_or(*axis);
            }
        }
    }
    Ok(all)
}

fn add(all: &mut Vec<Emitter>, light: &Light, eye: DVec3) -> Result<(), AdapterError> {
    let full_at = full_distance(light)?;
    let times = |by: f64| Rgb(light.colour.0.map(|c| c * PI * by));
    let intensity = times(full_at * full_at);
    let position = light.position - eye;
    match light.kind {
        LightKind::Point => all.push(Emitter::Point {
            position,
            intensity,
        }),
        LightKind::Sun { towards } => {
            if let Some(direction) = (towards - light.position).try_normalize() {
                all.push(Emitter::Sun {
                    direction,
                    irradiance: times(1.0),
                });
            }
        }
        LightKind::Spot {
            towards,
            radius_deg,
            falloff_deg,
            ..
        } => {
            if let Some(axis) = (towards - light.position).try_normalize() {
                all.push(Emitter::Spot {
                    position,
                    axis,
                    intensity,
                    radius_deg,
                    falloff_deg,
                });
            }
        }
        LightKind::Area { u, v, nu, nv } => {
            for (j, q) in area_samples(nv) {
                for (i, p) in area_samples(nu) {
                    all.push(Emitter::Point {
                        position: position + u * i + v * j,
                        intensity: times(full_at * full_at * p * q),
                    });
                }
            }
        }
    }
    Ok(())
}

/// Where a light has its full colour.
fn full_distance(light: &Light) -> Result<f64, AdapterError> {
    let fade = light.fade.filter(|f| f.power > 0.0 && f.distance > 0.0);
    match (light.kind, fade) {
        (LightKind::Sun { .. }, None) => Ok(1.0),
        (LightKind::Sun { .. }, Some(_)) => Err(unsupported("parallel light that fades")),
        (_, Some(fade)) if fade.power != 2.0 => Err(unsupported(&format!(
            "a light that fades by the power of {}: Mitsuba's fade by the square",
            fade.power
        ))),
        (_, Some(fade)) => Ok(fade.distance),
        (_, None) => {
            let distance = light.position.length();
            Ok(if distance > 0.0 { distance } else { 1.0 })
        }
    }
}

impl Emitter {
    /// Its element. `share`: what the reflectances are divided by.
    pub fn text(&self, units: Units, share: f64) -> String {
        let scale = units.scale;
        // The fall-off is by written lengths.
        let power = |c: &Rgb| rgb("intensity", c.0.map(|c| c * share * scale * scale));
        match self {
            Self::Point {
                position,
                intensity,
            } => format!(
                "<emitter type=\"point\">{}{}</emitter>",
                point("position", *position * scale),
                power(intensity)
            ),
            Self::Sun {
                direction,
                irradiance,
            } => format!(
                "<emitter type=\"directional\">{}{}</emitter>",
                vector("direction", *direction),
                rgb("irradiance", irradiance.0.map(|c| c * share))
            ),
            Self::Spot {
                position,
                axis,
                intensity,
                radius_deg,
                falloff_deg,
            } => {
                let (u, v) = axis.any_orthonormal_pair();
                let falloff = falloff_deg.clamp(1e-3, 179.0);
                // Mitsuba divides by their difference.
                let radius = radius_deg.clamp(0.0, falloff * (1.0 - 1e-4));
                format!(
                    "<emitter type=\"spot\"><transform name=\"to_world\">{}</transform>{}\
                     <float name=\"cutoff_angle\" value=\"{}\"/>\
                     <float name=\"beam_width\" value=\"{}\"/></emitter>",
                    matrix([u, v, *axis], *position * scale),
                    power(intensity),
                    number(falloff),
                    number(radius)
                )
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_samples_share_the_whole_light() {
        for n in 1..20 {
            let sum: f64 = area_samples(n).iter().map(|s| s.1).sum();
            assert!((sum - 1.0).abs() < 1e-12, "{n}");
        }
        assert_eq!(area_samples(3), [(-0.5, 0.25), (0.0, 0.5), (0.5, 0.25)]);
    }
}

//! The colour of what a ray meets.
//!
//! colour = pigment · (ambient + Σ diffuse · cos · light) + Σ highlight · light,
//! the first part by the share that does not pass through; then what is
//! mirrored, and what passes through tinted by the pigment.

use decor_api::{Highlight, Material, Scene};
use glam::DVec3;

use crate::light::{Arriving, arriving, colour};
use crate::ray::Ray;
use crate::shadow::unshadowed;
use crate::world::{Found, World};

/// How often a ray is mirrored or bent before what is behind counts as black:
/// POV-Ray's default.
const BOUNCES: u32 = 5;

/// Colours rays in a scene.
pub(crate) struct Shader<'a> {
    /// What the camera sees, also through glass.
    pub seen: &'a World,
    /// That, and what is hidden from it: what mirrors show and what casts
    /// shadows.
    pub world: &'a World,
    pub scene: &'a Scene,
}

impl Shader<'_> {
    /// The linear colour and the distance of the first surface; the direction
    /// of the ray has length 1.
    pub fn look(&self, ray: &Ray) -> Option<(DVec3, f64)> {
        let found = self.seen.nearest(ray, 0.0, f64::INFINITY)?;
        let colour = self.colour(ray, &found, BOUNCES, self.seen);
        Some((colour, found.t))
    }

    /// The distance of the first surface alone.
    pub fn distance(&self, ray: &Ray) -> Option<f64> {
        let found = self.seen.nearest(ray, 0.0, f64::INFINITY)?;
        Some(found.t)
    }

    /// `among`: what the ray met it among, and what is seen through it.
    fn colour(&self, ray: &Ray, found: &Found<'_>, bounces: u32, among: &World) -> DVec3 {
        let material = found.material;
        let pigment = colour(material.colour);
        // Towards whoever looks: a surface has two sides, and both are lit.
        let faces = found.normal.dot(ray.direction) < 0.0;
        let normal = if faces { found.normal } else { -found.normal };
        let point = ray.at(found.t);
        // Off the surface, by what its point may be wrong: far more than a unit
        // in the last place of any coordinate that went into it, far less than
        // anything that one sees.
        let size = point.abs().max(ray.origin.abs()).max_element() + found.t;
        let clear = normal * (size * 1e-12);
        let outside = point + clear;

        let mut scattered = pigment * material.ambient;
        let mut glints = DVec3::ZERO;
        for light in &self.scene.lights {
            let Some(from) = arriving(light, outside) else {
                continue;
            };
            let cosine = normal.dot(from.towards);
            if cosine <= 0.0 {
                continue;
            }
            let lit = if self.scene.shadows {
                from.colour * unshadowed(self.world, light, outside)
            } else {
                from.colour
            };
            scattered += pigment * lit * (material.diffuse * cosine);
            glints += lit * highlight(material, &from, normal, ray.direction);
        }
        let mut seen = scattered * (1.0 - material.transmission.clamp(0.0, 1.0)) + glints;

        if bounces == 0 {
            return seen;
        }
        if material.reflection > 0.0 {
            let mirrored = Ray {
                origin: outside,
                direction: ray.direction.reflect(normal),
            };
            seen += self.follow(&mirrored, bounces - 1, self.world) * material.reflection;
        }
        if material.transmission > 0.0 {
            let (direction, passes) = bent(ray.direction, normal, material.ior, found.enters);
            let onwards = Ray {
                origin: if passes { point - clear } else { outside },
                direction,
            };
            seen += self.follow(&onwards, bounces - 1, among) * pigment * material.transmission;
        }
        seen
    }

    fn follow(&self, ray: &Ray, bounces: u32, among: &World) -> DVec3 {
        match among.nearest(ray, 0.0, f64::INFINITY) {
            Some(found) => self.colour(ray, &found, bounces, among),
            None => colour(self.scene.background),
        }
    }
}

fn highlight(material: &Material, from: &Arriving, normal: DVec3, view: DVec3) -> f64 {
    match material.highlight {
        Highlight::None => 0.0,
        Highlight::Phong { amount, size } => {
            amount * view.reflect(normal).dot(from.towards).max(0.0).powf(size)
        }
        Highlight::Specular { amount, roughness } => {
            let half = (from.towards - view).normalize_or_zero();
            amount * half.dot(normal).max(0.0).powf(roughness.recip())
        }
    }
}

/// Snell's law: the direction behind the surface, and whether the ray passes
/// it; where it is totally reflected, it does not.
fn bent(direction: DVec3, normal: DVec3, ior: f64, enters: bool) -> (DVec3, bool) {
    let ratio = if enters { ior.recip() } else { ior };
    if ratio == 1.0 {
        return (direction, true);
    }
    let cosine = -direction.dot(normal);
    let behind = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
    if behind < 0.0 {
        return (direction.reflect(normal), false);
    }
    let bent = direction * ratio + normal * (ratio * cosine - behind.sqrt());
    (bent.normalize_or(direction), true)
}

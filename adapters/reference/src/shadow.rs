//! What gets through to a point: the share of a light that solids let pass.

use decor_api::Light;
use glam::DVec3;

use crate::light::{Way, colour, ways};
use crate::ray::Ray;
use crate::world::World;

/// How many surfaces of glass a shadow ray passes through.
const PANES: u32 = 64;

/// The share of each colour of a light that gets through to a point.
pub(crate) fn unshadowed(world: &World, light: &Light, origin: DVec3) -> DVec3 {
    ways(light, origin)
        .iter()
        .map(|way| through(world, origin, way) * way.share)
        .sum()
}

fn through(world: &World, origin: DVec3, way: &Way) -> DVec3 {
    let ray = Ray {
        origin,
        direction: way.towards,
    };
    let (mut share, mut after) = (DVec3::ONE, 0.0);
    for _ in 0..PANES {
        let Some(found) = world.nearest(&ray, after, way.distance) else {
            break;
        };
        let material = found.material;
        if material.transmission <= 0.0 {
            return DVec3::ZERO;
        }
        share *= colour(material.colour) * material.transmission;
        after = found.t;
    }
    share
}

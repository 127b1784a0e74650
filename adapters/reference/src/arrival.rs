//! How much of a light arrives at points: one shadow ray each, or one a sample
//! of an area light.

use decor_api::{AdapterError, ArrivalRequest, ArrivalShot, SurfacePoint};
use glam::DVec3;
use rayon::prelude::*;

use crate::light::arriving;
use crate::model::Models;
use crate::shadow::unshadowed;
use crate::world::World;

/// How far above its point a ray starts, in footprints: the point may lie on
/// one of the casters.
const ABOVE: f64 = 1e-3;

/// Points that are answered before it is asked whether to go on.
const AT_ONCE: usize = 1024;

/// The fractions of all shots. `may_go_on` is asked now and then, with the
/// frame's number.
pub(crate) fn fractions(
    request: &ArrivalRequest<'_>,
    may_go_on: &(dyn Fn(u32) -> Result<(), AdapterError> + Sync),
) -> Result<Vec<Vec<[f32; 3]>>, AdapterError> {
    let casters = || request.shots.iter().flat_map(|shot| shot.casters.iter());
    let models = Models::of_instances(request.prototypes, casters())?;
    request
        .shots
        .iter()
        .map(|shot| of_shot(&models, shot, &|| may_go_on(shot.frame)))
        .collect()
}

fn of_shot(
    models: &Models,
    shot: &ArrivalShot,
    may_go_on: &(dyn Fn() -> Result<(), AdapterError> + Sync),
) -> Result<Vec<[f32; 3]>, AdapterError> {
    let world = World::posed(models, shot.casters.iter())?;
    let parts: Vec<Vec<[f32; 3]>> = shot
        .points
        .par_chunks(AT_ONCE)
        .map(|points| {
            may_go_on()?;
            Ok(points.iter().map(|p| at(&world, shot, p)).collect())
        })
        .collect::<Result<_, AdapterError>>()?;
    Ok(parts.concat())
}

fn at(world: &World, shot: &ArrivalShot, point: &SurfacePoint) -> [f32; 3] {
    // The light's colour does not matter, not even black.
    let white = decor_api::Light {
        colour: decor_api::Rgb([1.0; 3]),
        fade: None,
        ..shot.light
    };
    if !white.may_reach(point.position) {
        return [1.0; 3];
    }
    let Some(from) = arriving(&white, point.position) else {
        return [1.0; 3];
    };
    let above = if point.footprint > 0.0 {
        point.footprint.min(f64::MAX) * ABOVE
    } else {
        0.0
    };
    let start: DVec3 = point.position + from.towards * above;
    unshadowed(world, &white, start).as_vec3().to_array()
}

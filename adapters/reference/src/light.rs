//! What arrives from a light where nothing is in the way. The forms are
//! POV-Ray's, which the neutral lights are described by.

use decor_api::{Fade, Light, LightKind, Rgb, area_samples};
use glam::DVec3;

use crate::ray::unit;

/// A light as seen from a point.
pub(crate) struct Arriving {
    /// From the point towards the light, of length 1.
    pub towards: DVec3,
    /// The light's colour there.
    pub colour: DVec3,
}

/// What arrives at `point`; `None` where nothing does.
pub(crate) fn arriving(light: &Light, point: DVec3) -> Option<Arriving> {
    let (towards, distance) = way(light, light.position, point)?;
    let share = within_cone(light, towards) * faded(light.fade, distance);
    (share > 0.0).then(|| Arriving {
        towards,
        colour: colour(light.colour) * share,
    })
}

/// A way from a point to a light, on which a shadow is looked for.
pub(crate) struct Way {
    /// Towards the light, of length 1.
    pub towards: DVec3,
    /// How far the light is.
    pub distance: f64,
    /// This way's share of the light; together they are 1.
    pub share: f64,
}

/// One way, or, for an area light, one a sample.
pub(crate) fn ways(light: &Light, point: DVec3) -> Vec<Way> {
    let to = |from: DVec3, share: f64| {
        let (towards, distance) = way(light, from, point)?;
        Some(Way {
            towards,
            distance,
            share,
        })
    };
    let LightKind::Area { u, v, nu, nv } = light.kind else {
        return to(light.position, 1.0).into_iter().collect();
    };
    let (columns, rows) = (area_samples(nu), area_samples(nv));
    let grid = rows
        .iter()
        .flat_map(|row| columns.iter().map(move |column| (column, row)));
    grid.filter_map(|(&(i, p), &(j, q))| to(light.position + u * i + v * j, p * q))
        .collect()
}

/// A neutral colour as a vector, for arithmetic.
pub(crate) fn colour(rgb: Rgb) -> DVec3 {
    DVec3::from_array(rgb.0)
}

fn way(light: &Light, from: DVec3, point: DVec3) -> Option<(DVec3, f64)> {
    match light.kind {
        // The distance is that to the plane across the rays; a point behind it
        // is lit too, and nothing is in between.
        LightKind::Sun { towards } => {
            let back = unit(from - towards)?;
            Some((back, (from - point).dot(back)))
        }
        _ => {
            let way = from - point;
            Some((unit(way)?, way.length()))
        }
    }
}

fn within_cone(light: &Light, towards: DVec3) -> f64 {
    let LightKind::Spot {
        towards: aim,
        radius_deg,
        falloff_deg,
        tightness,
    } = light.kind
    else {
        return 1.0;
    };
    let Some(axis) = unit(aim - light.position) else {
        return 0.0;
    };
    let cosine = -towards.dot(axis);
    if cosine <= 0.0 {
        return 0.0;
    }
    let (full, none) = (
        radius_deg.to_radians().cos(),
        falloff_deg.to_radians().cos(),
    );
    cosine.powf(tightness) * eased(none, full, cosine)
}

/// From 0 at `low` to 1 at `high`, level at both.
fn eased(low: f64, high: f64, x: f64) -> f64 {
    if x >= high {
        1.0
    } else if x < low {
        0.0
    } else {
        let x = (x - low) / (high - low);
        (3.0 - 2.0 * x) * x * x
    }
}

fn faded(fade: Option<Fade>, distance: f64) -> f64 {
    match fade {
        Some(Fade {
            distance: full,
            power,
        }) if power > 0.0 && full > 0.0 => 2.0 / (1.0 + (distance.abs() / full).powf(power)),
        _ => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn light(kind: LightKind) -> Light {
        Light {
            position: DVec3::Y * 10.0,
            colour: Rgb([1.0, 0.5, 0.25]),
            kind,
            fade: None,
        }
    }

    fn red_at(light: &Light, point: DVec3) -> f64 {
        arriving(light, point).map_or(0.0, |a| a.colour.x)
    }

    #[test]
    fn a_sun_shines_the_same_way_everywhere() {
        let sun = light(LightKind::Sun {
            towards: DVec3::ZERO,
        });
        for point in [DVec3::ZERO, DVec3::X * 1e6, DVec3::Y * 20.0] {
            assert_eq!(arriving(&sun, point).unwrap().towards, DVec3::Y);
        }
        let way = &ways(&sun, DVec3::Y * 4.0)[0];
        assert_eq!((way.towards, way.distance, way.share), (DVec3::Y, 6.0, 1.0));
    }

    #[test]
    fn a_spot_is_full_eased_and_dark() {
        let spot = light(LightKind::Spot {
            towards: DVec3::ZERO,
            radius_deg: 10.0,
            falloff_deg: 20.0,
            tightness: 0.0,
        });
        let at = |degrees: f64| red_at(&spot, DVec3::X * 10.0 * degrees.to_radians().tan());
        assert_eq!(at(0.0), 1.0);
        assert_eq!(at(9.9), 1.0);
        assert_eq!(at(20.1), 0.0);
        // The ease runs over the cosine.
        let (low, high) = (20_f64.to_radians().cos(), 10_f64.to_radians().cos());
        let half = (0.5 * (low + high)).acos().to_degrees();
        assert!((at(half) - 0.5).abs() < 1e-9);
        assert_eq!(red_at(&spot, DVec3::Y * 20.0), 0.0, "behind");
    }

    #[test]
    fn fading_halves_nothing_at_its_distance() {
        let mut lamp = light(LightKind::Point);
        lamp.fade = Some(Fade {
            distance: 10.0,
            power: 2.0,
        });
        assert_eq!(red_at(&lamp, DVec3::ZERO), 1.0);
        assert_eq!(red_at(&lamp, DVec3::Y * -20.0), 0.2);
        assert!(arriving(&lamp, lamp.position).is_none());
    }

    #[test]
    fn an_area_is_sampled_from_edge_to_edge() {
        let area = light(LightKind::Area {
            u: DVec3::X * 4.0,
            v: DVec3::Z,
            nu: 3,
            nv: 1,
        });
        let ways = ways(&area, DVec3::ZERO);
        assert_eq!(ways.len(), 3);
        for (way, (x, share)) in ways.iter().zip([(-2.0, 0.25), (0.0, 0.5), (2.0, 0.25)]) {
            let end = way.towards * way.distance;
            assert!(end.distance(DVec3::new(x, 10.0, 0.0)) < 1e-12);
            assert_eq!(way.share, share);
        }
    }

    #[test]
    fn the_samples_share_the_whole_light() {
        let weights = |n| area_samples(n).iter().map(|s| s.1).collect::<Vec<_>>();
        assert_eq!(weights(0), [1.0]);
        assert_eq!(weights(4), [0.25; 4]);
        assert_eq!(weights(5), [0.125, 0.25, 0.25, 0.25, 0.125]);
        for n in 1..40 {
            let sum: f64 = weights(n).iter().sum();
            assert!((sum - 1.0).abs() < 1e-15, "{n}");
        }
    }
}

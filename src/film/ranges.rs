//! Which values are allowed. Both forms of a film ask here, each with its own
//! places.

use decor_api::{Fade, Light, LightKind, Rgb, Size};
use glam::DVec3;

use super::problem::Problem;

type Checked<T> = Result<T, Problem>;

/// The largest width and height, in pixels.
const LARGEST_SIDE: u64 = 65_535;

/// The most samples along a side of an area light.
const MOST_SAMPLES: u64 = 65_535;

/// An opening angle below this has no focal length that is a number.
const SMALLEST_ANGLE_DEG: f64 = 1e-290;

/// A full opening angle, in degrees: above 0, below 180.
pub(super) fn opening_angle(value: f64) -> Checked<f64> {
    if value > SMALLEST_ANGLE_DEG && value < 180.0 {
        return Ok(value);
    }
    Err(Problem::OpeningAngle { value })
}

/// A width or a height, in pixels.
pub(super) fn side(value: u64) -> Checked<u32> {
    match u32::try_from(value) {
        Ok(side) if (1..=LARGEST_SIDE).contains(&value) => Ok(side),
        _ => Err(Problem::SizeOutOfRange {
            value: value.to_string(),
        }),
    }
}

/// A size of which both sides were checked.
pub(super) fn size(sides: [Option<u32>; 2]) -> Option<Size> {
    let [width, height] = sides;
    Some(Size {
        width: width?,
        height: height?,
    })
}

/// An up direction: any but none.
pub(super) fn up(value: DVec3) -> Checked<DVec3> {
    if value == DVec3::ZERO {
        return Err(Problem::UpWithoutLength);
    }
    Ok(value)
}

/// A number of frames.
pub(super) fn images(value: u32) -> Checked<u32> {
    if value == 0 {
        return Err(Problem::NoImages);
    }
    Ok(value)
}

/// A channel of a linear colour. Light that takes light away is not allowed:
/// the energy that arrives somewhere would no longer only grow with the lights.
pub(super) fn channel(value: f64) -> Checked<f64> {
    if value < 0.0 {
        return Err(Problem::NegativeColour { value });
    }
    Ok(value)
}

/// A colour of which all channels were checked.
pub(super) fn colour(channels: [Option<f64>; 3]) -> Option<Rgb> {
    let [red, green, blue] = channels;
    Some(Rgb([red?, green?, blue?]))
}

/// Half the angle of a spot's full light, in degrees.
pub(super) fn spot_radius(value: f64) -> Checked<f64> {
    if (0.0..=90.0).contains(&value) {
        return Ok(value);
    }
    let what = "radius";
    Err(Problem::SpotAngle { what, value })
}

/// Half the angle where a spot's light ends, in degrees.
pub(super) fn spot_falloff(value: f64) -> Checked<f64> {
    if value > 0.0 && value <= 90.0 {
        return Ok(value);
    }
    let what = "falloff";
    Err(Problem::SpotAngle { what, value })
}

/// The exponent of a spot's fall-off.
pub(super) fn tightness(value: f64) -> Checked<f64> {
    if value < 0.0 {
        return Err(Problem::Tightness { value });
    }
    Ok(value)
}

/// The samples along a side of an area light.
pub(super) fn samples(value: u64) -> Checked<u32> {
    match u32::try_from(value) {
        Ok(samples) if (1..=MOST_SAMPLES).contains(&value) => Ok(samples),
        _ => Err(Problem::AreaSamples {
            value: value.to_string(),
        }),
    }
}

/// The distance at which a fading light has its full colour.
pub(super) fn fade_distance(value: f64) -> Checked<f64> {
    if value > 0.0 {
        return Ok(value);
    }
    Err(Problem::FadeDistance { value })
}

/// The power of a light's fall-off with the distance.
pub(super) fn fade_power(value: f64) -> Checked<f64> {
    if value < 0.0 {
        return Err(Problem::FadePower { value });
    }
    Ok(value)
}

/// A fall-off of which both numbers were checked.
pub(super) fn fade(distance: Option<f64>, power: Option<f64>) -> Option<Fade> {
    Some(Fade {
        distance: distance?,
        power: power?,
    })
}

/// What a light's numbers, each allowed by itself, must keep together.
pub(super) fn light(light: Light) -> Checked<Light> {
    match light.kind {
        LightKind::Sun { towards } | LightKind::Spot { towards, .. }
            if towards == light.position =>
        {
            Err(Problem::LightWithoutDirection)
        }
        LightKind::Spot {
            radius_deg: radius,
            falloff_deg: falloff,
            ..
        } if radius > falloff => Err(Problem::SpotOrder { radius, falloff }),
        LightKind::Area { u, v, nu, nv }
            if (nu > 1 && u == DVec3::ZERO) || (nv > 1 && v == DVec3::ZERO) =>
        {
            Err(Problem::AreaSide)
        }
        _ => Ok(light),
    }
}

/// The colour difference that asks for more rays.
pub(super) fn antialias_threshold(value: f64) -> Checked<f64> {
    if value < 0.0 {
        return Err(Problem::AntialiasThreshold { value });
    }
    Ok(value)
}

/// The depth of the antialiasing: up to depth² rays a pixel.
pub(super) fn antialias_depth(value: u64) -> Checked<u32> {
    match u32::try_from(value) {
        Ok(depth) if (1..=9).contains(&depth) => Ok(depth),
        _ => Err(Problem::AntialiasDepth {
            value: value.to_string(),
        }),
    }
}

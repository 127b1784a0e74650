//! Lights in POV-Ray's words.

use std::fmt::Write as _;

use decor_api::{Light, LightKind};

use crate::number::{colour, number, vector};

/// The text of a light.
pub fn light(light: &Light) -> String {
    let mut text = format!(
        "light_source {{ {} rgb {}",
        vector(light.position),
        colour(light.colour)
    );
    // Writing to a string cannot fail.
    let _ = match &light.kind {
        LightKind::Point => Ok(()),
        LightKind::Sun { towards } => write!(text, " parallel point_at {}", vector(*towards)),
        LightKind::Spot {
            towards,
            radius_deg,
            falloff_deg,
            tightness,
        } => write!(
            text,
            " spotlight radius {} falloff {} tightness {} point_at {}",
            number(*radius_deg),
            number(*falloff_deg),
            number(*tightness),
            vector(*towards)
        ),
        LightKind::Area { u, v, nu, nv } => {
            write!(
                text,
                " area_light {}, {}, {nu}, {nv}",
                vector(*u),
                vector(*v)
            )
        }
    };
    if let Some(fade) = &light.fade {
        let _ = write!(
            text,
            " fade_distance {} fade_power {}",
            number(fade.distance),
            number(fade.power)
        );
    }
    text.push_str(" }\n");
    text
}

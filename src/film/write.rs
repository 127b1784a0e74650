//! The film as the thesis writes it (Annexe A-1): writing.

use std::fmt::Write as _;

use decor_api::{Light, LightKind};
use glam::DVec3;

use super::model::{Film, Moving, Placed, Scene, Tables};

/// The film as the text of an `.anim` file. Reading it gives the same film,
/// every number bit for bit.
///
/// Paths are written as they were stated: the text belongs into the film's
/// folder.
pub fn write(film: &Film) -> String {
    let mut text = String::new();
    for scene in &film.scenes {
        let _ = writeln!(text, "@{}", scene.number);
        for line in environment(scene, &film.tables) {
            let _ = writeln!(text, "*{line}");
        }
        for placed in scene.stated.objects.iter() {
            let _ = writeln!(text, "!{}", object(placed, &film.tables));
        }
    }
    text
}

fn environment(scene: &Scene, tables: &Tables) -> Vec<String> {
    let stated = &scene.stated;
    let native = |i: &u32| quoted(&tables.natives[*i as usize].path);
    let mut lines = Vec::new();
    let mut line = |word: &str, rest: String| lines.push(format!("{word} {rest}"));
    if let Some(size) = stated.size {
        line("size", format!("{} {}", size.width, size.height));
    }
    if let Some(images) = stated.images {
        line("frames", images.to_string());
    }
    if let Some(eye) = stated.eye {
        line("eye", moving(eye));
    }
    if let Some(aim) = stated.aim {
        line("aim", moving(aim));
    }
    if let Some(up) = stated.up {
        line("up", numbers(&up.to_array()));
    }
    if let Some((a, b)) = stated.angles_deg {
        line("angles", numbers(&[a, b]));
    }
    if let Some(shadows) = stated.shadows {
        line("shadows", u8::from(shadows).to_string());
    }
    if let Some(background) = stated.background {
        line("background", numbers(&background.0));
    }
    match stated.antialias {
        None => {}
        Some(None) => line("antialias", "off".to_owned()),
        Some(Some(antialias)) => {
            let threshold = number(antialias.threshold);
            line("antialias", format!("{threshold} {}", antialias.depth));
        }
    }
    for include in &stated.includes {
        line("include", native(include));
    }
    if let Some(sky) = &stated.sky {
        line("sky", native(sky));
    }
    for each in stated.lights.iter() {
        line("light", light(each));
    }
    lines
}

fn moving(point: Moving) -> String {
    let mut text = numbers(&point.position.to_array());
    if !is_plain_zero(point.velocity) {
        text = format!("{text} {}", numbers(&point.velocity.to_array()));
    }
    text
}

fn light(light: &Light) -> String {
    let vector = |v: DVec3| numbers(&v.to_array());
    let kind = match light.kind {
        LightKind::Point => "point".to_owned(),
        LightKind::Sun { towards } => format!("sun {}", vector(towards)),
        LightKind::Spot {
            towards,
            radius_deg,
            falloff_deg,
            tightness,
        } => {
            let rest = numbers(&[radius_deg, falloff_deg, tightness]);
            format!("spot {} {rest}", vector(towards))
        }
        LightKind::Area { u, v, nu, nv } => {
            format!("area {} {} {nu} {nv}", vector(u), vector(v))
        }
    };
    let fade = light.fade.map_or(String::new(), |fade| {
        format!(" fade {}", numbers(&[fade.distance, fade.power]))
    });
    let (position, colour) = (vector(light.position), numbers(&light.colour.0));
    format!("{position} {colour} {kind}{fade}")
}

fn object(placed: &Placed, tables: &Tables) -> String {
    let path = &tables.descriptions[placed.description.0 as usize].path;
    let identity = &tables.identities[placed.object.0 as usize];
    let mut text = quoted(path);
    let mut vector = |v: DVec3| {
        let _ = write!(text, " {}", numbers(&v.to_array()));
    };
    vector(placed.pose.position);
    vector(placed.pose.angles_deg);
    let motion = placed.motion;
    if !is_plain_zero(motion.velocity) || !is_plain_zero(motion.angles_velocity_deg) {
        vector(motion.velocity);
        vector(motion.angles_velocity_deg);
    }
    if identity.named {
        let _ = write!(text, " name={}", quoted(&identity.name));
    }
    text
}

/// What a left-out velocity reads as; −0 is written.
fn is_plain_zero(v: DVec3) -> bool {
    v.to_array().iter().all(|x| x.to_bits() == 0)
}

fn numbers(list: &[f64]) -> String {
    let words: Vec<String> = list.iter().map(|x| number(*x)).collect();
    words.join(" ")
}

/// The shortest decimal that reads back as the same bits, without a tail of
/// zeros where it is very large or very small.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-6..1e16).contains(&x.abs()) {
        format!("{x}")
    } else {
        format!("{x:e}")
    }
}

/// The text as a field: in quotation marks where it would not be one otherwise.
fn quoted(text: &str) -> String {
    let plain = |c: char| !c.is_ascii_whitespace() && c != '#';
    if !text.is_empty() && text.chars().all(plain) {
        text.to_owned()
    } else {
        format!("\"{text}\"")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_exact() {
        assert_eq!(number(1.0), "1");
        assert_eq!(number(-0.0), "-0");
        assert_eq!(number(0.1), "0.1");
        assert_eq!(number(1e300), "1e300");
        assert_eq!(number(-5e-324), "-5e-324");
    }

    #[test]
    fn blanks_are_quoted() {
        assert_eq!(quoted("a.inc"), "a.inc");
        assert_eq!(quoted("a b.inc"), "\"a b.inc\"");
        assert_eq!(quoted("#1"), "\"#1\"");
    }
}

//! The statements of an `.anim` line: what each keyword's fields mean.

use decor_api::{Antialias, Fade, Light, LightKind, Pose, Rgb};
use glam::DVec3;

use super::draft::{At, Draft, DraftObject, restate_images, restate_size};
use super::fields::Fields;
use super::keyword::{Keyword, near_keyword, nearest};
use super::lines::{Field, Line, shortened};
use super::mark::Faults;
use super::model::{Motion, Moving};
use super::problem::Problem;
use super::ranges;

/// Puts a `*` line into the draft.
pub(super) fn environment(line: &Line<'_>, draft: &mut Draft, faults: &mut Faults) {
    let word = line.fields.first().map_or("", |field| &field.text);
    let Some(keyword) = Keyword::of(word) else {
        // What it would have stated is not missing, it is misspelt.
        draft.riddled = true;
        let mark = line.fields.first().map_or(line.mark, |field| field.mark);
        let (near, word) = (near_keyword(word), shortened(word));
        faults.push(mark, Problem::UnknownKeyword { word, near });
        return;
    };
    draft.attempt(keyword, line.mark, faults);
    let mark = line.mark;
    let mut fields = Fields {
        statement: keyword.name(),
        mark,
        list: &line.fields[1..],
        faults,
    };
    let f = &mut fields;
    match keyword {
        Keyword::Eye => draft.eye = moving(f).map(|value| At { value, mark }).or(draft.eye),
        Keyword::Aim => draft.aim = moving(f).map(|value| At { value, mark }).or(draft.aim),
        Keyword::Up => draft.up = up(f).map(|value| At { value, mark }).or(draft.up),
        Keyword::Angles => draft.angles_deg = angles(f).or(draft.angles_deg),
        Keyword::Shadows => draft.shadows = shadows(f).or(draft.shadows),
        Keyword::Size => {
            if let Some(value) = size(f) {
                restate_size(&mut draft.size, At { value, mark }, f.faults);
            }
        }
        Keyword::Light => draft.lights.extend(light(f)),
        Keyword::Background => draft.background = background(f).or(draft.background),
        Keyword::Antialias => draft.antialias = antialias(f).or(draft.antialias),
        Keyword::Images => {
            if let Some(value) = images(f) {
                restate_images(&mut draft.images, At { value, mark }, f.faults);
            }
        }
        Keyword::Include => draft.includes.extend(path(f)),
        Keyword::Sky => draft.sky = path(f).or(draft.sky.take()),
    }
}

/// Puts a `!` line into the draft.
pub(super) fn object(line: &Line<'_>, draft: &mut Draft, faults: &mut Faults) {
    let value = match placed_object(line, faults) {
        Some(value) => value,
        None => {
            // The scene has a list of objects, even if this one cannot be used.
            draft.riddled_objects = true;
            return;
        }
    };
    let mark = line.mark;
    draft.objects.push(At { value, mark });
}

fn moving(f: &mut Fields<'_>) -> Option<Moving> {
    f.expect(&[3, 6], "3 numbers, or 6 with the velocity")?;
    let position = f.vector(0);
    let velocity = if f.list.len() == 6 {
        f.vector(3)
    } else {
        Some(DVec3::ZERO)
    };
    Some(Moving {
        position: position?,
        velocity: velocity?,
    })
}

fn up(f: &mut Fields<'_>) -> Option<DVec3> {
    f.expect(&[3], "3 numbers")?;
    let direction = f.vector(0)?;
    f.faults.check(f.mark, ranges::up(direction))
}

fn angles(f: &mut Fields<'_>) -> Option<(f64, f64)> {
    f.expect(&[2], "2 numbers, horizontal and vertical")?;
    let [a, b] = [0, 1].map(|i| f.checked(i, ranges::opening_angle));
    Some((a?, b?))
}

fn shadows(f: &mut Fields<'_>) -> Option<bool> {
    f.expect(&[1], "0 or 1")?;
    f.boolean(0)
}

fn size(f: &mut Fields<'_>) -> Option<decor_api::Size> {
    f.expect(&[2], "2 whole numbers, width and height")?;
    ranges::size([0, 1].map(|i| f.whole(i, ranges::side)))
}

fn background(f: &mut Fields<'_>) -> Option<Rgb> {
    f.expect(&[3], "3 numbers, red, green and blue")?;
    colour(f, 0)
}

fn colour(f: &mut Fields<'_>, i: usize) -> Option<Rgb> {
    ranges::colour([i, i + 1, i + 2].map(|i| f.checked(i, ranges::channel)))
}

fn antialias(f: &mut Fields<'_>) -> Option<Option<Antialias>> {
    let expected = "off, or a threshold and a depth";
    if f.list.len() == 1 && f.list[0].text == "off" {
        return Some(None);
    }
    f.expect(&[2], expected)?;
    let threshold = f.checked(0, ranges::antialias_threshold);
    let depth = f.whole(1, ranges::antialias_depth);
    Some(Some(Antialias {
        threshold: threshold?,
        depth: depth?,
    }))
}

fn images(f: &mut Fields<'_>) -> Option<u32> {
    f.expect(&[1], "1 whole number")?;
    f.whole(0, |value| {
        // A film beyond all frame numbers is refused with its first scene.
        ranges::images(u32::try_from(value).unwrap_or(u32::MAX))
    })
}

fn path(f: &mut Fields<'_>) -> Option<At<String>> {
    f.expect(&[1], "1 path, in quotation marks if it holds blanks")?;
    let Field { text, mark, .. } = &f.list[0];
    Some(At {
        value: text.to_string(),
        mark: *mark,
    })
}

fn light(f: &mut Fields<'_>) -> Option<Light> {
    const SHORT: &str = "x y z, r g b and a type";
    const COMMON: usize = 7;
    let all = f.list;
    if all.len() < COMMON {
        f.expect(&[], SHORT)?;
    }
    let fade_at = all[COMMON..].iter().position(|field| field.text == "fade");
    let kind_end = fade_at.map_or(all.len(), |i| COMMON + i);
    let fade = match fade_at {
        Some(_) => fade(f, kind_end).map(Some),
        None => Some(None),
    };
    let position = f.vector(0);
    let colour = colour(f, 3);
    f.list = &all[..kind_end];
    let kind = light_kind(f, COMMON);
    let light = Light {
        position: position?,
        colour: colour?,
        kind: kind?,
        fade: fade?,
    };
    f.faults.check(f.mark, ranges::light(light))
}

/// The words `fade distance power` at the end of a light.
fn fade(f: &mut Fields<'_>, i: usize) -> Option<Fade> {
    f.statement = "the fading of a light";
    let all = f.list;
    f.list = &all[i + 1..];
    let complete = f.expect(&[2], "fade, a distance and a power");
    f.statement = Keyword::Light.name();
    f.list = all;
    complete?;
    let distance = f.checked(i + 1, ranges::fade_distance);
    let power = f.checked(i + 2, ranges::fade_power);
    ranges::fade(distance, power)
}

fn light_kind(f: &mut Fields<'_>, i: usize) -> Option<LightKind> {
    let kind = &f.list[i - 1];
    match &*kind.text {
        "ponctuelle" | "point" => {
            f.expect(&[i], "nothing after `point` but `fade`")?;
            Some(LightKind::Point)
        }
        "soleil" | "sun" => {
            f.expect(&[i, i + 3], "nothing or px py pz after `sun`")?;
            let towards = if f.list.len() > i {
                f.vector(i)
            } else {
                Some(DVec3::ZERO)
            };
            Some(LightKind::Sun { towards: towards? })
        }
        "spot" => {
            f.expect(&[i + 6], "px py pz radius falloff tightness after `spot`")?;
            let towards = f.vector(i);
            let radius_deg = f.checked(i + 3, ranges::spot_radius);
            let falloff_deg = f.checked(i + 4, ranges::spot_falloff);
            let tightness = f.checked(i + 5, ranges::tightness);
            Some(LightKind::Spot {
                towards: towards?,
                radius_deg: radius_deg?,
                falloff_deg: falloff_deg?,
                tightness: tightness?,
            })
        }
        "zone" | "area" => {
            f.expect(&[i + 8], "ux uy uz vx vy vz nu nv after `area`")?;
            let (u, v) = (f.vector(i), f.vector(i + 3));
            let nu = f.whole(i + 6, ranges::samples);
            let nv = f.whole(i + 7, ranges::samples);
            Some(LightKind::Area {
                u: u?,
                v: v?,
                nu: nu?,
                nv: nv?,
            })
        }
        text => {
            const TYPES: [&str; 7] = [
                "ponctuelle",
                "point",
                "soleil",
                "sun",
                "spot",
                "zone",
                "area",
            ];
            let near = nearest(text, TYPES.into_iter());
            let text = shortened(text);
            f.faults
                .push(kind.mark, Problem::UnknownLight { text, near });
            None
        }
    }
}

fn placed_object(line: &Line<'_>, faults: &mut Faults) -> Option<DraftObject> {
    let (name, numbers) = match line.fields.split_last() {
        Some((last, before)) if last.after("name=").is_some() => (Some(last), before),
        _ => (None, &line.fields[..]),
    };
    for field in numbers.iter().skip(1) {
        if field.after("name=").is_some() {
            faults.push(field.mark, Problem::NameNotLast);
            return None;
        }
    }
    let mut fields = Fields {
        statement: "an object",
        mark: line.mark,
        list: numbers,
        faults,
    };
    let f = &mut fields;
    f.expect(
        &[7, 13],
        "a path and 6 numbers, or 12 with the velocities, and perhaps `name=…`",
    )?;
    let path = At {
        value: f.list[0].text.to_string(),
        mark: f.list[0].mark,
    };
    let (position, angles_deg) = (f.vector(1), f.vector(4));
    let motion = if f.list.len() == 13 {
        let (velocity, angles_velocity_deg) = (f.vector(7), f.vector(10));
        Motion {
            velocity: velocity?,
            angles_velocity_deg: angles_velocity_deg?,
        }
    } else {
        Motion::default()
    };
    let name = name.map(|field| At {
        value: field.after("name=").unwrap_or_default().to_owned(),
        mark: field.mark,
    });
    Some(DraftObject {
        path,
        name,
        pose: Pose {
            position: position?,
            angles_deg: angles_deg?,
        },
        motion,
    })
}

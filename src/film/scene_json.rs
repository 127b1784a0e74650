//! Between a scene's JSON object and its draft.

use decor_api::{Antialias, Light, LightKind, Pose};
use glam::DVec3;

use super::draft::{At, Draft, DraftObject};
use super::keyword::Keyword;
use super::locate::Step::{Index, Key};
use super::mark::{Faults, Mark};
use super::model::{Motion, Moving, Placed, Scene, Tables};
use super::problem::Problem;
use super::ranges;
use super::schema::{
    JsonAdaptive, JsonAntialias, JsonFade, JsonLight, JsonLightKind, JsonObject, JsonPoint,
    JsonScene, Object,
};

/// The draft of a scene; `mark` is its whole object.
pub(super) fn draft(json: JsonScene, mark: Mark, faults: &mut Faults) -> Draft {
    let key = |name: &'static str| mark.inside(Key(name));
    let mut draft = Draft::new(Some(json.scene), key("scene"));
    if let Some(sides) = json.size {
        let mark = key("size");
        draft.attempt(Keyword::Size, mark, faults);
        let sides = checked(sides, mark, ranges::side, faults);
        draft.size = ranges::size(sides).map(|value| At { value, mark });
    }
    if let Some(images) = json.frames {
        let mark = key("frames");
        let images = faults.check(mark, ranges::images(images));
        draft.images = images.map(|value| At { value, mark });
    }
    let mut point = |keyword, name, point: Option<Object<JsonPoint>>| {
        let value = moving(&point?.0);
        draft.attempt(keyword, key(name), faults);
        let mark = key(name);
        Some(At { value, mark })
    };
    let eye = point(Keyword::Eye, "eye", json.eye);
    let aim = point(Keyword::Aim, "aim", json.aim);
    (draft.eye, draft.aim) = (eye, aim);
    if let Some(up) = json.up {
        let mark = key("up");
        let up = faults.check(mark, ranges::up(up.into()));
        draft.up = up.map(|value| At { value, mark });
    }
    if let Some(angles) = json.angles {
        let mark = key("angles");
        draft.attempt(Keyword::Angles, mark, faults);
        if let [Some(a), Some(b)] = checked(angles, mark, ranges::opening_angle, faults) {
            draft.angles_deg = Some((a, b));
        }
    }
    draft.shadows = json.shadows;
    if let Some(background) = json.background {
        let channels = checked(background, key("background"), ranges::channel, faults);
        draft.background = ranges::colour(channels);
    }
    draft.antialias = json
        .antialias
        .and_then(|json| antialias(&json, key("antialias"), faults));
    for (i, value) in json.include.into_iter().flatten().enumerate() {
        let mark = key("include").inside(Index(i));
        draft.includes.push(At { value, mark });
    }
    draft.sky = json.sky.map(|value| At {
        value,
        mark: key("sky"),
    });
    if let Some(lights) = &json.lights {
        note_empty(lights, "lights", mark, &mut draft);
        for (i, Object(json)) in lights.iter().enumerate() {
            draft
                .lights
                .extend(light(json, key("lights").inside(Index(i)), faults));
        }
    }
    if let Some(objects) = json.objects {
        note_empty(&objects, "objects", mark, &mut draft);
        for (i, Object(json)) in objects.into_iter().enumerate() {
            draft
                .objects
                .push(object(json, key("objects").inside(Index(i))));
        }
    }
    draft
}

fn note_empty<T>(list: &[T], value: &'static str, mark: Mark, draft: &mut Draft) {
    if list.is_empty() {
        let mark = mark.inside(Key(value));
        draft.empty_lists.push(At { value, mark });
    }
}

/// Every element of an array, in its range.
fn checked<T: Copy, U, const N: usize>(
    list: [T; N],
    mark: Mark,
    check: impl Fn(T) -> Result<U, Problem>,
    faults: &mut Faults,
) -> [Option<U>; N] {
    std::array::from_fn(|i| faults.check(mark.inside(Index(i)), check(list[i])))
}

fn moving(json: &JsonPoint) -> Moving {
    Moving {
        position: json.position.into(),
        velocity: json.velocity.into(),
    }
}

fn antialias(json: &JsonAntialias, mark: Mark, faults: &mut Faults) -> Option<Option<Antialias>> {
    let JsonAntialias::On(adaptive) = json else {
        return Some(None);
    };
    let threshold = ranges::antialias_threshold(adaptive.threshold);
    let threshold = faults.check(mark.inside(Key("threshold")), threshold);
    let depth = ranges::antialias_depth(adaptive.depth);
    let depth = faults.check(mark.inside(Key("depth")), depth);
    Some(Some(Antialias {
        threshold: threshold?,
        depth: depth?,
    }))
}

fn object(json: JsonObject, mark: Mark) -> At<DraftObject> {
    let at = |value: String, name: &'static str| At {
        value,
        mark: mark.inside(Key(name)),
    };
    let value = DraftObject {
        path: at(json.path, "path"),
        name: json.name.map(|name| at(name, "name")),
        pose: Pose {
            position: json.position.into(),
            angles_deg: json.angles.into(),
        },
        motion: Motion {
            velocity: json.velocity.into(),
            angles_velocity_deg: json.angles_velocity.into(),
        },
    };
    At { value, mark }
}

impl JsonLightKind {
    fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Sun => "sun",
            Self::Spot => "spot",
            Self::Area => "area",
        }
    }

    /// The fields that a light of this type may have.
    fn own(self) -> &'static [&'static str] {
        match self {
            Self::Point => &[],
            Self::Sun => &["towards"],
            Self::Spot => &["towards", "radius", "falloff", "tightness"],
            Self::Area => &["u", "v", "nu", "nv"],
        }
    }
}

fn light(json: &JsonLight, mark: Mark, faults: &mut Faults) -> Option<Light> {
    let key = |name: &'static str| mark.inside(Key(name));
    let given = [
        ("towards", json.towards.is_some()),
        ("radius", json.radius.is_some()),
        ("falloff", json.falloff.is_some()),
        ("tightness", json.tightness.is_some()),
        ("u", json.u.is_some()),
        ("v", json.v.is_some()),
        ("nu", json.nu.is_some()),
        ("nv", json.nv.is_some()),
    ];
    let kind = json.kind.name();
    let mut fits = true;
    for (field, given) in given {
        let own = json.kind.own().contains(&field);
        // The sun's rays go to the origin where nothing else is said.
        let needed = own && !matches!(json.kind, JsonLightKind::Sun);
        if given && !own {
            faults.push(key(field), Problem::LightWithForeign { kind, field });
            fits = false;
        } else if needed && !given {
            faults.push(mark, Problem::LightWithout { kind, field });
            fits = false;
        }
    }
    let colour = checked(json.colour, key("colour"), ranges::channel, faults);
    let fade = match &json.fade {
        None => Some(None),
        Some(Object(json)) => {
            let mark = key("fade");
            let distance = ranges::fade_distance(json.distance);
            let distance = faults.check(mark.inside(Key("distance")), distance);
            let power = ranges::fade_power(json.power);
            let power = faults.check(mark.inside(Key("power")), power);
            ranges::fade(distance, power).map(Some)
        }
    };
    let shape = light_kind(json, &key, faults);
    if !fits {
        return None;
    }
    let light = Light {
        position: json.position.into(),
        colour: ranges::colour(colour)?,
        kind: shape?,
        fade: fade?,
    };
    faults.check(mark, ranges::light(light))
}

/// The shape, where all its fields are there and in their ranges.
fn light_kind(
    json: &JsonLight,
    key: &impl Fn(&'static str) -> Mark,
    faults: &mut Faults,
) -> Option<LightKind> {
    let towards = json.towards.map(DVec3::from);
    Some(match json.kind {
        JsonLightKind::Point => LightKind::Point,
        JsonLightKind::Sun => LightKind::Sun {
            towards: towards.unwrap_or_default(),
        },
        JsonLightKind::Spot => {
            let radius = faults.check(key("radius"), ranges::spot_radius(json.radius?));
            let falloff = faults.check(key("falloff"), ranges::spot_falloff(json.falloff?));
            let tightness = faults.check(key("tightness"), ranges::tightness(json.tightness?));
            LightKind::Spot {
                towards: towards?,
                radius_deg: radius?,
                falloff_deg: falloff?,
                tightness: tightness?,
            }
        }
        JsonLightKind::Area => {
            let nu = faults.check(key("nu"), ranges::samples(json.nu?));
            let nv = faults.check(key("nv"), ranges::samples(json.nv?));
            LightKind::Area {
                u: json.u?.into(),
                v: json.v?.into(),
                nu: nu?,
                nv: nv?,
            }
        }
    })
}

/// The JSON object of a scene of a film.
pub(super) fn json(scene: &Scene, tables: &Tables) -> JsonScene {
    let stated = &scene.stated;
    let native = |i: &u32| tables.natives[*i as usize].path.clone();
    let point = |moving: Moving| {
        Object(JsonPoint {
            position: moving.position.into(),
            velocity: moving.velocity.into(),
        })
    };
    let includes: Vec<String> = stated.includes.iter().map(native).collect();
    let lights = stated.lights.iter();
    let lights: Vec<_> = lights.map(|light| Object(json_light(light))).collect();
    let objects = stated.objects.iter();
    let objects: Vec<_> = objects
        .map(|placed| Object(json_object(placed, tables)))
        .collect();
    JsonScene {
        scene: scene.number,
        size: stated.size.map(|s| [s.width.into(), s.height.into()]),
        frames: stated.images,
        eye: stated.eye.map(point),
        aim: stated.aim.map(point),
        up: stated.up.map(Into::into),
        angles: stated.angles_deg.map(Into::into),
        shadows: stated.shadows,
        background: stated.background.map(|colour| colour.0),
        antialias: stated.antialias.map(|antialias| match antialias {
            None => JsonAntialias::Off,
            Some(Antialias { threshold, depth }) => JsonAntialias::On(JsonAdaptive {
                threshold,
                depth: depth.into(),
            }),
        }),
        include: some_list(includes),
        sky: stated.sky.as_ref().map(native),
        lights: some_list(lights),
        objects: some_list(objects),
    }
}

fn some_list<T>(list: Vec<T>) -> Option<Vec<T>> {
    (!list.is_empty()).then_some(list)
}

fn json_light(light: &Light) -> JsonLight {
    let mut json = JsonLight {
        kind: JsonLightKind::Point,
        position: light.position.into(),
        colour: light.colour.0,
        towards: None,
        radius: None,
        falloff: None,
        tightness: None,
        u: None,
        v: None,
        nu: None,
        nv: None,
        fade: light.fade.map(|fade| {
            Object(JsonFade {
                distance: fade.distance,
                power: fade.power,
            })
        }),
    };
    match light.kind {
        LightKind::Point => {}
        LightKind::Sun { towards } => {
            json.kind = JsonLightKind::Sun;
            json.towards = Some(towards.into());
        }
        LightKind::Spot {
            towards,
            radius_deg,
            falloff_deg,
            tightness,
        } => {
            json.kind = JsonLightKind::Spot;
            json.towards = Some(towards.into());
            json.radius = Some(radius_deg);
            json.falloff = Some(falloff_deg);
            json.tightness = Some(tightness);
        }
        LightKind::Area { u, v, nu, nv } => {
            json.kind = JsonLightKind::Area;
            (json.u, json.v) = (Some(u.into()), Some(v.into()));
            (json.nu, json.nv) = (Some(nu.into()), Some(nv.into()));
        }
    }
    json
}

fn json_object(placed: &Placed, tables: &Tables) -> JsonObject {
    let identity = &tables.identities[placed.object.0 as usize];
    JsonObject {
        path: tables.descriptions[placed.description.0 as usize]
            .path
            .clone(),
        name: identity.named.then(|| identity.name.clone()),
        position: placed.pose.position.into(),
        angles: placed.pose.angles_deg.into(),
        velocity: placed.motion.velocity.into(),
        angles_velocity: placed.motion.angles_velocity_deg.into(),
    }
}

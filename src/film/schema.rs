//! The JSON object of a scene, as serde reads and writes it.

use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, MapAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

type Vector = [f64; 3];

/// A `T` from a JSON object alone: serde would take an array of its fields too.
#[derive(Debug, Serialize)]
#[serde(transparent)]
pub(super) struct Object<T>(pub(super) T);

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Object<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Fields<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Fields<T> {
            type Value = Object<T>;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an object")
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                T::deserialize(MapAccessDeserializer::new(map)).map(Object)
            }
        }
        deserializer.deserialize_map(Fields(PhantomData))
    }
}

/// One scene. Everything but its number may be left out.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonScene {
    pub(super) scene: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) size: Option<[u64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) frames: Option<u32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) eye: Option<Object<JsonPoint>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) aim: Option<Object<JsonPoint>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) up: Option<Vector>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) angles: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) shadows: Option<bool>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) background: Option<Vector>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) antialias: Option<JsonAntialias>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) include: Option<Vec<String>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) sky: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) lights: Option<Vec<Object<JsonLight>>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) objects: Option<Vec<Object<JsonObject>>>,
}

/// The eye or the aim.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonPoint {
    pub(super) position: Vector,
    #[serde(default, skip_serializing_if = "is_plain_zero")]
    pub(super) velocity: Vector,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonObject {
    pub(super) path: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) name: Option<String>,
    pub(super) position: Vector,
    #[serde(default, skip_serializing_if = "is_plain_zero")]
    pub(super) angles: Vector,
    #[serde(default, skip_serializing_if = "is_plain_zero")]
    pub(super) velocity: Vector,
    #[serde(default, skip_serializing_if = "is_plain_zero")]
    pub(super) angles_velocity: Vector,
}

/// A light, flat: which fields belong together is checked with their places.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonLight {
    #[serde(rename = "type")]
    pub(super) kind: JsonLightKind,
    pub(super) position: Vector,
    #[serde(alias = "color")]
    pub(super) colour: Vector,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) towards: Option<Vector>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) radius: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) falloff: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) tightness: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) u: Option<Vector>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) v: Option<Vector>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) nu: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) nv: Option<u64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) fade: Option<Object<JsonFade>>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum JsonLightKind {
    Point,
    Sun,
    Spot,
    Area,
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonFade {
    pub(super) distance: f64,
    pub(super) power: f64,
}

/// `"off"`, or an object.
#[derive(Debug)]
pub(super) enum JsonAntialias {
    Off,
    On(JsonAdaptive),
}

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JsonAdaptive {
    pub(super) threshold: f64,
    pub(super) depth: u64,
}

impl Serialize for JsonAntialias {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Off => serializer.serialize_str("off"),
            Self::On(adaptive) => adaptive.serialize(serializer),
        }
    }
}

// By hand: an untagged enum would not say what is wrong inside.
impl<'de> Deserialize<'de> for JsonAntialias {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = JsonAntialias;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("\"off\", or an object of `threshold` and `depth`")
            }

            fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Self::Value, E> {
                match text {
                    "off" => Ok(JsonAntialias::Off),
                    _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
                }
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Self::Value, A::Error> {
                let adaptive = JsonAdaptive::deserialize(MapAccessDeserializer::new(map))?;
                Ok(JsonAntialias::On(adaptive))
            }
        }
        deserializer.deserialize_any(Either)
    }
}

/// What a left-out vector reads as; −0 is written.
fn is_plain_zero(v: &Vector) -> bool {
    v.iter().all(|x| x.to_bits() == 0)
}

//! The numbers of a neutral description. Each is checked where it is read, so
//! that an error points at it.

use std::fmt;

use decor_api::{Highlight, Material, Rgb};
use glam::DVec3;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// A finite number that passes a test.
fn number<'de, D: Deserializer<'de>>(
    deserializer: D,
    expected: &str,
    is_good: impl Fn(f64) -> bool,
) -> Result<f64, D::Error> {
    let value = f64::deserialize(deserializer)?;
    if value.is_finite() && is_good(value) {
        Ok(value)
    } else {
        Err(D::Error::custom(format_args!(
            "expected {expected}, found {value}"
        )))
    }
}

macro_rules! checked_number {
    ($($(#[$attribute:meta])* $name:ident: $expected:literal, $test:expr;)*) => {$(
        $(#[$attribute])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        pub(super) struct $name(pub f64);

        impl<'de> Deserialize<'de> for $name {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                number(deserializer, $expected, $test).map(Self)
            }
        }
    )*};
}

checked_number! {
    /// Any finite number.
    #[derive(Default)]
    Finite: "a finite number", |_| true;
    /// A length.
    Positive: "a number above 0", |v| v > 0.0;
    /// A length or an amount that may be nothing.
    #[derive(Default)]
    NotNegative: "a number that is not negative", |v| v >= 0.0;
    /// A share.
    Share: "a number from 0 to 1", |v| (0.0..=1.0).contains(&v);
    /// An exponent.
    Exponent: "a number from 1 up", |v| v >= 1.0;
    /// A roughness.
    Roughness: "a number above 0 and up to 1", |v| v > 0.0 && v <= 1.0;
    /// A factor.
    Factor: "a factor that is not 0", |v| v != 0.0;
}

/// A point or a vector: `(x, y, z)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Point(pub DVec3);

impl<'de> Deserialize<'de> for Point {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (x, y, z) = <(Finite, Finite, Finite)>::deserialize(deserializer)?;
        Ok(Self(DVec3::new(x.0, y.0, z.0)))
    }
}

/// A direction: a vector that is not 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Direction(pub DVec3);

impl<'de> Deserialize<'de> for Direction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let Point(vector) = Point::deserialize(deserializer)?;
        // Its square may be 0 or infinite where the vector is not.
        if vector.try_normalize().is_none() {
            return Err(D::Error::custom("expected a direction of a usable length"));
        }
        Ok(Self(vector))
    }
}

/// Factors along the axes, `(x, y, z)`, or one for all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Factors(pub DVec3);

impl<'de> Deserialize<'de> for Factors {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOrThree;

        impl OneOrThree {
            fn one<E: Error>(value: f64) -> Result<Factors, E> {
                if value.is_finite() && value != 0.0 {
                    return Ok(Factors(DVec3::splat(value)));
                }
                Err(E::custom(format_args!(
                    "expected a factor that is not 0, found {value}"
                )))
            }
        }

        impl<'de> Visitor<'de> for OneOrThree {
            type Value = Factors;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a factor, or three factors (x, y, z)")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Factors, E> {
                Self::one(value)
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Factors, E> {
                Self::one(value as f64)
            }

            fn visit_u64<E: Error>(self, value: u64) -> Result<Factors, E> {
                Self::one(value as f64)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Factors, A::Error> {
                let mut factors = [0.0; 3];
                for (i, factor) in factors.iter_mut().enumerate() {
                    let next: Option<Factor> = seq.next_element()?;
                    *factor = next.ok_or_else(|| A::Error::invalid_length(i, &self))?.0;
                }
                if seq.next_element::<Factor>()?.is_some() {
                    return Err(A::Error::invalid_length(4, &self));
                }
                Ok(Factors(DVec3::from_array(factors)))
            }
        }

        deserializer.deserialize_any(OneOrThree)
    }
}

/// A linear colour: `(red, green, blue)`.
#[derive(Clone, Copy, Debug)]
struct Colour(Rgb);

impl<'de> Deserialize<'de> for Colour {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (r, g, b) = <(NotNegative, NotNegative, NotNegative)>::deserialize(deserializer)?;
        Ok(Self(Rgb([r.0, g.0, b.0])))
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename = "phong", deny_unknown_fields)]
struct Phong {
    amount: NotNegative,
    #[serde(default = "Phong::usual_size")]
    size: Exponent,
}

impl Phong {
    fn usual_size() -> Exponent {
        Exponent(40.0)
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename = "specular", deny_unknown_fields)]
struct Specular {
    amount: NotNegative,
    #[serde(default = "Specular::usual_roughness")]
    roughness: Roughness,
}

impl Specular {
    fn usual_roughness() -> Roughness {
        Roughness(0.05)
    }
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename = "material", deny_unknown_fields)]
struct LookText {
    #[serde(alias = "color")]
    colour: Option<Colour>,
    ambient: Option<NotNegative>,
    diffuse: Option<NotNegative>,
    phong: Option<Phong>,
    specular: Option<Specular>,
    reflection: Option<Share>,
    transmission: Option<Share>,
    ior: Option<Positive>,
}

/// A material; what is left out is [`Material::default`].
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(try_from = "LookText")]
pub(super) struct Look(pub Material);

impl TryFrom<LookText> for Look {
    type Error = &'static str;

    fn try_from(text: LookText) -> Result<Self, Self::Error> {
        let usual = Material::default();
        let highlight = match (text.phong, text.specular) {
            (None, None) => usual.highlight,
            (Some(phong), None) => Highlight::Phong {
                amount: phong.amount.0,
                size: phong.size.0,
            },
            (None, Some(specular)) => Highlight::Specular {
                amount: specular.amount.0,
                roughness: specular.roughness.0,
            },
            (Some(_), Some(_)) => return Err("expected phong or specular, not both"),
        };
        Ok(Self(Material {
            colour: text.colour.map_or(usual.colour, |c| c.0),
            ambient: text.ambient.map_or(usual.ambient, |v| v.0),
            diffuse: text.diffuse.map_or(usual.diffuse, |v| v.0),
            highlight,
            reflection: text.reflection.map_or(usual.reflection, |v| v.0),
            transmission: text.transmission.map_or(usual.transmission, |v| v.0),
            ior: text.ior.map_or(usual.ior, |v| v.0),
        }))
    }
}

//! Depth out of a renderer that has none: two ways to write the distance into
//! a picture's colours, and to read it back.
//!
//! **Pigment**, where decor writes the materials: one texture for all objects,
//! without light, whose pigment is a function of the surface point. A code u in
//! [0, 1) of the distance stands in two channels, red = u and green = the
//! fraction of 4096·u; a third says that something is there.
//!
//! **Veil**, for objects with textures of their own: no light at all, and
//! constant fogs. A fog of distance 1e-6 hides every surface; what the others
//! add along the ray, 1 − e^(−d/D), is the depth.
//!
//! Each is written for the pictures that it is read from: single-precision
//! pixels of the state file, or 16-bit integers.

use decor_api::Rgb;
use glam::DVec3;

use crate::number::{number, vector};

/// Surfaces farther than this do not exist for POV-Ray (its `MAX_DISTANCE`).
pub const FARTHEST: f64 = 1e7;

/// What the pixels are read from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// Single-precision numbers, of any size.
    Single,
    /// 16-bit integers that stand for [0, 1].
    Integer16,
}

/// One way of writing distances, for one layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthCode {
    /// u = (d − near) / (far − near).
    Linear {
        /// No surface is nearer.
        near: f64,
        /// No surface is farther.
        far: f64,
    },
    /// u = ln(d / near) / ln(far / near): the same relative precision
    /// everywhere, for ranges that begin near or have no end.
    Logarithmic {
        /// No surface is nearer; > 0.
        near: f64,
        /// No surface is farther.
        far: f64,
    },
    /// Fogs read with single precision: one of the layer's own range, one that
    /// reaches as far as POV-Ray sees.
    VeilSingle {
        /// The distance of the first fog.
        range: f64,
    },
    /// One fog cut in three thirds, one a channel, read from integers.
    VeilInteger16 {
        /// The distance of the fog.
        range: f64,
    },
}

/// How the fractions of u are scaled in the second channel.
const FINE: f64 = 4096.0;

/// The far fog's distance: at [`FARTHEST`] it has one tenth of its colour, where
/// nothing is (2e10) all of it.
const FAR_FOG: f64 = 1e8;

impl DepthCode {
    /// The pigment's code for surfaces between `near` and `far`.
    pub fn pigment(near: f64, far: f64, precision: Precision) -> Self {
        let far = if far.is_finite() {
            far.min(FARTHEST)
        } else {
            FARTHEST
        };
        // Room on both sides, so that rounding stays inside [0, 1).
        let far = far * (1.0 + 1e-6);
        let near = (near * (1.0 - 1e-6)).clamp(0.0, far * 0.5);
        match precision {
            Precision::Single => Self::Logarithmic {
                near: near.max(far * 1e-12),
                far,
            },
            Precision::Integer16 => Self::Linear { near, far },
        }
    }

    /// The veil's code for surfaces up to `far`.
    pub fn veil(far: f64, precision: Precision) -> Self {
        let far = if far.is_finite() {
            far.min(FARTHEST)
        } else {
            FARTHEST
        };
        let range = far.max(1e-9);
        match precision {
            Precision::Single => Self::VeilSingle { range },
            Precision::Integer16 => Self::VeilInteger16 { range },
        }
    }

    /// Is it a pigment?
    pub fn is_pigment(&self) -> bool {
        matches!(self, Self::Linear { .. } | Self::Logarithmic { .. })
    }

    /// What it needs at the top of the scene: a texture named `name`, or fogs
    /// and the end of all light.
    pub fn declaration(&self, eye: DVec3, name: &str) -> String {
        match *self {
            Self::Linear { near, far } => pigment(
                name,
                eye,
                &format!("(D-{})/{}", number(near), number(far - near)),
            ),
            Self::Logarithmic { near, far } => pigment(
                name,
                eye,
                &format!(
                    "ln(max(D,{0})/{0})/{1}",
                    number(near),
                    number((far / near).ln())
                ),
            ),
            Self::VeilSingle { range } => veil(&[
                (range, Rgb([1.0, 0.0, 0.0])),
                (FAR_FOG, Rgb([0.0, 1.0, 0.0])),
            ]),
            // The hiding fog has its whole colour everywhere, so that the sum
            // of both is 3·v, 3·v − 1, 3·v − 2.
            Self::VeilInteger16 { range } => {
                hiding_fog(Rgb([0.0, -1.0, -2.0])) + &fog(range, Rgb([3.0, 3.0, 3.0]))
            }
        }
    }

    /// The distance that a pixel stands for; +∞ where nothing is.
    pub fn decode(&self, [red, green, blue, _]: [f32; 4]) -> f64 {
        let (r, g, b) = (f64::from(red), f64::from(green), f64::from(blue));
        match *self {
            Self::Linear { near, far } => {
                refine(r, g, b).map_or(f64::INFINITY, |u| near + u * (far - near))
            }
            Self::Logarithmic { near, far } => {
                refine(r, g, b).map_or(f64::INFINITY, |u| near * (u * (far / near).ln()).exp())
            }
            Self::VeilSingle { range } => {
                if g > 0.5 {
                    f64::INFINITY
                } else if r < 0.95 {
                    -range * (-r).ln_1p()
                } else {
                    -FAR_FOG * (-g).ln_1p()
                }
            }
            Self::VeilInteger16 { range } => {
                let v = (r.clamp(0.0, 1.0) + g.clamp(0.0, 1.0) + b.clamp(0.0, 1.0)) / 3.0;
                // At `range` v is 0.63; the last step is where nothing is.
                if v > 0.95 {
                    f64::INFINITY
                } else {
                    -range * (-v).ln_1p()
                }
            }
        }
        .max(0.0)
    }

    /// How exact a decoded distance is: an absolute and a relative part.
    pub fn quantum(&self, precision: Precision) -> (f64, f64) {
        /// Half a unit in the last place of a single, as a share.
        const SINGLE: f64 = 6e-8;
        /// What POV-Ray's own intersection leaves of a distance.
        const HIT: f64 = 1e-11;
        let code = match precision {
            Precision::Single => SINGLE,
            Precision::Integer16 => 0.5 / 65535.0,
        };
        let (absolute, relative) = match *self {
            Self::Linear { near, far } => (2.0 * code / FINE * (far - near), HIT),
            Self::Logarithmic { near, far } => (0.0, HIT + 2.0 * code / FINE * (far / near).ln()),
            // Rounding of v, at most 0.95, and of 1 − e^(−d/D) in double.
            Self::VeilSingle { range } => (1e-15 * range, 4.0 * SINGLE),
            Self::VeilInteger16 { range } => (4.0 * code / 3.0 * range, HIT),
        };
        (absolute, relative)
    }
}

/// u out of its channels; `None` where nothing is.
fn refine(coarse: f64, fraction: f64, there: f64) -> Option<f64> {
    if there.is_nan() || there < 0.5 {
        return None;
    }
    let whole = (coarse * FINE - fraction).round();
    Some((whole + fraction) / FINE)
}

/// A texture that shines with u(D), D being the distance to `eye`. An average
/// divides by the number of its entries: each is multiplied by it.
fn pigment(name: &str, eye: DVec3, u: &str) -> String {
    let (x, y, z) = (number(eye.x), number(eye.y), number(eye.z));
    format!(
        "#declare {name}_U = function(D) {{ {u} }}\n\
         #declare {name}_D = function(x,y,z) {{ {name}_U(sqrt(pow(x-({x}),2)+pow(y-({y}),2)+pow(z-({z}),2))) }}\n\
         #declare {name} = texture {{ pigment {{ average pigment_map {{\n\
         [1 function {{ {name}_D(x,y,z) }} color_map {{ [0 rgb 0][1 rgb <3,0,0>] }}]\n\
         [1 function {{ {name}_D(x,y,z)*{FINE} }} color_map {{ [0 rgb 0][1 rgb <0,3,0>] }}]\n\
         [1 rgb <0,0,3>] }} }} finish {{ ambient 0 diffuse 0 emission 1 }} }}\n"
    )
}

fn veil(fogs: &[(f64, Rgb)]) -> String {
    let mut text = hiding_fog(Rgb::default());
    for &(distance, colour) in fogs {
        text.push_str(&fog(distance, colour));
    }
    text
}

/// A fog that no surface shines through.
fn hiding_fog(colour: Rgb) -> String {
    fog(1e-6, colour)
}

fn fog(distance: f64, colour: Rgb) -> String {
    format!(
        "fog {{ fog_type 1 distance {} rgb {} }}\n",
        number(distance),
        vector(DVec3::from_array(colour.0))
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// What an ideal renderer writes for a distance.
    fn write(code: DepthCode, d: f64, round: impl Fn(f64) -> f64) -> [f32; 4] {
        let u = match code {
            DepthCode::Linear { near, far } => (d - near) / (far - near),
            DepthCode::Logarithmic { near, far } => (d / near).ln() / (far / near).ln(),
            DepthCode::VeilSingle { range } => {
                let v = |s: f64| 1.0 - (-d / s).exp();
                return [v(range) as f32, v(FAR_FOG) as f32, 0.0, 1.0];
            }
            DepthCode::VeilInteger16 { range } => {
                let v = 3.0 * (1.0 - (-d / range).exp());
                return [v, v - 1.0, v - 2.0, 1.0].map(|c| round(c.clamp(0.0, 1.0)) as f32);
            }
        };
        [u, (u * FINE).fract(), 1.0, 1.0].map(|c| round(c) as f32)
    }

    fn single(c: f64) -> f64 {
        f64::from(c as f32)
    }

    fn integer(c: f64) -> f64 {
        (c * 65535.0).round() / 65535.0
    }

    proptest! {
        #[test]
        fn distances_come_back_to_within_the_quantum(
            near in 1e-3..10.0_f64, ratio in 1.5..1e6_f64, at in 0.0..1.0_f64
        ) {
            let far = near * ratio;
            let d = near + at * (far - near);
            for (precision, round) in [
                (Precision::Single, single as fn(f64) -> f64),
                (Precision::Integer16, integer),
            ] {
                for code in [DepthCode::pigment(near, far, precision), DepthCode::veil(far, precision)] {
                    let back = code.decode(write(code, d, round));
                    let (absolute, relative) = code.quantum(precision);
                    let allowed = 1.01 * absolute + 1.5 * relative * d;
                    prop_assert!((back - d).abs() <= allowed, "{code:?}: {d} came back as {back}");
                }
            }
        }
    }

    #[test]
    fn nothing_is_infinitely_far() {
        let code = DepthCode::pigment(1.0, 10.0, Precision::Single);
        assert_eq!(code.decode([0.0; 4]), f64::INFINITY);
        assert_eq!(code.decode([f32::NAN; 4]), f64::INFINITY);
        let veil = DepthCode::veil(10.0, Precision::Single);
        assert_eq!(veil.decode([1.0, 1.0, 0.0, 1.0]), f64::INFINITY);
    }
}

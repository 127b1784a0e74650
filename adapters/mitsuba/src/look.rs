//! Materials as Mitsuba's reflectances.
//!
//! What is scattered is Lambert's, as it is in the film. A bright spot is a
//! microfacet lobe that is as high and as wide where light and eye are straight
//! above. What mirrors and what lets light through is drawn opaque and dull.
//!
//! The colour that shines without any light (ambient) is Mitsuba's to find, but
//! not to colour: a surface that shines would be one more light, and instances
//! must not shine. A picture of its own, lit from the eye, tells looks apart:
//! its blue is the same for all, and red is a share of it that says which look
//! it is, whatever the light does.

use decor_api::{Highlight, Material};

use crate::xml::{number, rgb};

/// The looks of a request, each once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Looks {
    list: Vec<Material>,
}

impl Looks {
    /// The number of a look.
    pub fn number(&mut self, material: &Material) -> usize {
        let known = self.list.iter().position(|known| known == material);
        known.unwrap_or_else(|| {
            self.list.push(*material);
            self.list.len() - 1
        })
    }

    /// What reflectances are divided by, and lights multiplied by: a power of
    /// two that leaves none above 1, which Mitsuba refuses.
    pub fn share(&self) -> f64 {
        let largest = self.list.iter().flat_map(|material| {
            let scattered = scattered(material).into_iter();
            scattered.chain(spot(material).map(|(_, height)| height))
        });
        let largest = largest.fold(1.0, f64::max);
        2.0_f64.powi(largest.log2().ceil() as i32)
    }

    /// All of them, as they are lit.
    pub fn lit(&self) -> String {
        let share = self.share();
        self.file(|_, material| {
            let scale = |colour: [f64; 3]| colour.map(|c| (c / share).clamp(0.0, 1.0));
            let dull = diffuse(scale(scattered(material)));
            match spot(material) {
                None => dull,
                Some((width, height)) => format!(
                    "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"0.5\"/>{dull}\
                     <bsdf type=\"roughconductor\"><string name=\"material\" value=\"none\"/>\
                     <string name=\"distribution\" value=\"beckmann\"/>\
                     <float name=\"alpha\" value=\"{}\"/>{}</bsdf></bsdf>",
                    number(width),
                    rgb("specular_reflectance", scale([height; 3]))
                ),
            }
        })
    }

    /// All of them, told apart.
    pub fn told_apart(&self) -> String {
        let count = self.list.len() as f64;
        self.file(|k, _| diffuse([(k as f64 + 0.5) / count, 0.0, 1.0]))
    }

    fn file(&self, bsdf: impl Fn(usize, &Material) -> String) -> String {
        let mut text = String::from("<scene version=\"3.0.0\">\n");
        for (k, material) in self.list.iter().enumerate() {
            let inner = bsdf(k, material);
            text.push_str(&format!(
                "<bsdf type=\"twosided\" id=\"look{k}\">{inner}</bsdf>\n"
            ));
        }
        text.push_str("</scene>\n");
        text
    }

    /// What shines without any light, by look.
    pub fn ambient(&self) -> Ambient {
        let shine = |m: &Material| m.colour.0.map(|c| (c * m.ambient) as f32);
        Ambient {
            shines: self.list.iter().map(shine).collect(),
        }
    }
}

/// What shines without any light.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Ambient {
    shines: Vec<[f32; 3]>,
}

impl Ambient {
    /// The colour of all surfaces, where there is only one.
    pub fn uniform(&self) -> Option<[f32; 3]> {
        let first = self.shines.first().copied().unwrap_or_default();
        self.shines.iter().all(|s| *s == first).then_some(first)
    }

    /// The colour of a pixel of the picture that tells looks apart.
    pub fn of(&self, [red, _, blue, _]: [f32; 4]) -> [f32; 3] {
        if blue <= 0.0 {
            return [0.0; 3];
        }
        let look = f64::from(red) / f64::from(blue) * self.shines.len() as f64;
        self.shines.get(look as usize).copied().unwrap_or_default()
    }
}

/// The reflectance, times two where half of it makes room for a bright spot.
fn scattered(material: &Material) -> [f64; 3] {
    let twice = if spot(material).is_some() { 2.0 } else { 1.0 };
    material.colour.0.map(|c| twice * c * material.diffuse)
}

/// The width of a bright spot, as the root mean square slope of its facets, and
/// its reflectance.
fn spot(material: &Material) -> Option<(f64, f64)> {
    // The exponent of the cosine between the normal and the middle of the ways
    // to light and eye. Phong's angle is between the mirrored way and the eye:
    // twice as wide, so four times the exponent.
    let (amount, exponent) = match material.highlight {
        Highlight::None => return None,
        Highlight::Phong { amount, size } => (amount, 4.0 * size),
        Highlight::Specular { amount, roughness } => (amount, roughness.recip()),
    };
    if amount <= 0.0 {
        return None;
    }
    let width = (2.0 / (exponent + 2.0)).sqrt().clamp(1e-3, 1.0);
    // Straight from above the lobe is R / (4π · width²) as high, and a light of
    // full colour has a strength of π; half of it is blended in.
    Some((width, 2.0 * 4.0 * width * width * amount))
}

fn diffuse(colour: [f64; 3]) -> String {
    format!(
        "<bsdf type=\"diffuse\">{}</bsdf>",
        rgb("reflectance", colour)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Rgb;

    #[test]
    fn looks_are_found_again_by_their_share_of_red() {
        let mut looks = Looks::default();
        for k in 0..1000 {
            let material = Material {
                colour: Rgb([f64::from(k); 3]),
                ambient: 1.0,
                ..Material::default()
            };
            assert_eq!(looks.number(&material), k as usize);
        }
        let ambient = looks.ambient();
        assert_eq!(ambient.uniform(), None);
        for k in 0..1000 {
            let light = 3.7e-9 * (1.0 + k as f32);
            let red = ((k as f32 + 0.5) / 1000.0) * light;
            assert_eq!(ambient.of([red, 0.0, light, 1.0]), [k as f32; 3]);
        }
        assert_eq!(ambient.of([0.0; 4]), [0.0; 3]);
    }

    #[test]
    fn no_reflectance_is_above_one() {
        let mut looks = Looks::default();
        looks.number(&Material {
            colour: Rgb([3.0, 1.0, 0.5]),
            diffuse: 1.0,
            highlight: Highlight::Phong {
                amount: 1.0,
                size: 1.0,
            },
            ..Material::default()
        });
        assert_eq!(looks.share(), 8.0);
        assert!(looks.lit().contains("value=\"0.75 0.25 0.125\""));
    }
}

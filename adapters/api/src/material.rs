//! The look of a neutral solid, in terms that every renderer has.

use serde::{Deserialize, Serialize};

use crate::scene::Rgb;

/// How a light is mirrored as a bright spot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Highlight {
    /// No bright spot.
    None,
    /// Phong's: amount ≥ 0, and the exponent of the cosine.
    Phong {
        /// Brightness at the centre of the spot.
        amount: f64,
        /// The exponent, ≥ 1: larger is smaller and sharper.
        size: f64,
    },
    /// Blinn's half-vector form: amount ≥ 0 and roughness in (0, 1].
    Specular {
        /// Brightness at the centre of the spot.
        amount: f64,
        /// Smaller is sharper; the exponent is its inverse.
        roughness: f64,
    },
}

/// A uniform material.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Material {
    /// Linear colour.
    pub colour: Rgb,
    /// Share of the colour that shines without any light.
    pub ambient: f64,
    /// Share of the arriving light that is scattered.
    pub diffuse: f64,
    /// The bright spot.
    pub highlight: Highlight,
    /// Share of what is mirrored, 0 to 1.
    pub reflection: f64,
    /// Share of the light that passes through, tinted by the colour, 0 to 1.
    pub transmission: f64,
    /// Index of refraction, > 0; 1 bends nothing.
    pub ior: f64,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            colour: Rgb([0.8, 0.8, 0.8]),
            ambient: 0.1,
            diffuse: 0.7,
            highlight: Highlight::None,
            reflection: 0.0,
            transmission: 0.0,
            ior: 1.0,
        }
    }
}

impl Material {
    /// Does it mirror or let light through, so that a pixel that shows it
    /// depends on other objects too?
    pub fn is_optical(&self) -> bool {
        self.reflection > 0.0 || self.transmission > 0.0
    }
}

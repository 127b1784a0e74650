//! The shadow map: what light still arrives at the décor through what moves.
//!
//! Thesis, III-3-4. A renderer adds up over the lights. So of a décor three kinds
//! of pictures are kept: without light, and for each light that something fast
//! can block the picture of that light alone, less the one without light. In a
//! frame, the share of each light that arrives at a pixel's surface is asked of
//! the renderer, and its part of the colour is exchanged:
//! ```text
//! colour = décor + Σ (light alone · share − light alone)
//! ```
//! The shares of two groups of casters multiply where a light is a point; the
//! penumbrae of an area light do not. There the share is that of all casters,
//! and what it is multiplied by is the light without any shadow.
//!
//! It holds for surfaces that neither mirror nor let light through; others are
//! rendered again.

use decor_api::Layer;

/// What one light does to a décor.
#[derive(Clone, Debug)]
pub struct LightLayers {
    /// Its number among the scene's lights.
    pub light: usize,
    /// What it adds to the picture without light.
    pub shaded: Vec<[f32; 3]>,
    /// What it would add if nothing stood in its way; where the light has an
    /// area.
    pub unshaded: Option<Vec<[f32; 3]>>,
}

impl LightLayers {
    /// From pictures: without light, with this light alone, and with it alone
    /// and no shadows.
    pub fn new(light: usize, dark: &Layer, lit: &Layer, unshaded: Option<&Layer>) -> Self {
        Self {
            light,
            shaded: added(dark, lit),
            unshaded: unshaded.map(|unshaded| added(dark, unshaded)),
        }
    }

    /// By how much pixel `index` changes where `share` of the light arrives.
    pub fn change(&self, index: usize, share: [f32; 3]) -> [f32; 3] {
        let now = self.shaded[index];
        let full = self.unshaded.as_ref().map_or(now, |full| full[index]);
        std::array::from_fn(|k| full[k] * share[k] - now[k])
    }
}

/// What `lit` has more than `dark`. A light can only add.
fn added(dark: &Layer, lit: &Layer) -> Vec<[f32; 3]> {
    let of = |layer: &Layer| layer.colour.clone().unwrap_or_default();
    let (dark, lit) = (of(dark), of(lit));
    dark.iter()
        .zip(&lit)
        .map(|(dark, lit)| std::array::from_fn(|k| (lit[k] - dark[k]).max(0.0)))
        .collect()
}

/// The pixels of a frame that light reaches otherwise than in the décor:
/// ascending by index.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shade {
    pixels: Vec<(u32, [f32; 4])>,
}

impl Shade {
    /// Those pixels with their colours.
    pub fn new(mut pixels: Vec<(u32, [f32; 4])>) -> Self {
        pixels.sort_unstable_by_key(|(index, _)| *index);
        Self { pixels }
    }

    /// Those with an index in `range`.
    pub fn within(&self, range: std::ops::Range<usize>) -> &[(u32, [f32; 4])] {
        let at = |index: usize| self.pixels.partition_point(|(i, _)| (*i as usize) < index);
        &self.pixels[at(range.start)..at(range.end)]
    }

    /// All of them.
    pub fn pixels(&self) -> &[(u32, [f32; 4])] {
        &self.pixels
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Window;

    fn layer(pixels: &[f32]) -> Layer {
        Layer {
            window: Window {
                x: 0,
                y: 0,
                width: pixels.len() as u32,
                height: 1,
            },
            colour: Some(pixels.iter().map(|&p| [p, p, p, 1.0]).collect()),
            depth: None,
            depth_quantum: (0.0, 0.0),
        }
    }

    #[test]
    fn a_point_light_is_dimmed_where_it_shone() {
        let (dark, lit) = (layer(&[0.1, 0.1]), layer(&[0.6, 0.1]));
        let layers = LightLayers::new(0, &dark, &lit, None);
        let change = layers.change(0, [0.0, 0.5, 1.0]);
        assert!((change[0] + 0.5).abs() < 1e-6);
        assert!((change[1] + 0.25).abs() < 1e-6);
        assert_eq!(change[2], 0.0);
        // Where the décor's own shadow falls, there is nothing to take.
        assert_eq!(layers.change(1, [0.0; 3]), [0.0; 3]);
    }

    #[test]
    fn the_penumbrae_of_an_area_light_are_asked_for_together() {
        let (dark, lit, full) = (layer(&[0.0]), layer(&[0.5]), layer(&[1.0]));
        let layers = LightLayers::new(0, &dark, &lit, Some(&full));
        // Half of the light is hidden by the décor; by both, three quarters.
        assert_eq!(layers.change(0, [0.25; 3]), [-0.25; 3]);
    }

    #[test]
    fn pixels_are_found_by_row() {
        let shade = Shade::new(vec![(7, [0.0; 4]), (2, [1.0; 4]), (5, [0.5; 4])]);
        let found: Vec<u32> = shade.within(3..7).iter().map(|p| p.0).collect();
        assert_eq!(found, [5]);
        assert_eq!(shade.pixels().len(), 3);
    }
}

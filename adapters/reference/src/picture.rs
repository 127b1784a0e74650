//! Pixels: which to trace, and how often.
//!
//! A pixel's value depends on the scene and its own place, and, with
//! antialiasing, on the rays through the centres of its four neighbours in the
//! full picture. These are traced even where they lie outside the window: that
//! is why a window is the full frame's, bit for bit.

use decor_api::encode::srgb;
use decor_api::{AdapterError, Antialias, Camera, Layer, Output, Size, Window};
use glam::DVec3;
use rayon::prelude::*;

use crate::light::colour;
use crate::ray::{Ray, unit};
use crate::shade::Shader;

/// One frame to draw.
pub(crate) struct Frame<'a> {
    pub shader: Shader<'a>,
    pub camera: &'a Camera,
    pub size: Size,
    pub output: Output,
    pub antialias: Option<Antialias>,
}

/// What one ray from the eye sees.
#[derive(Clone, Copy)]
struct Sample {
    /// Linear red, green, blue, and coverage: 0 or 1.
    colour: [f64; 4],
    /// +∞ where nothing is.
    distance: f64,
}

impl Frame<'_> {
    /// Draws the pixels of `window` that are `wanted`; the others stay empty.
    /// `may_go_on` is asked before every row.
    pub fn draw(
        &self,
        window: Window,
        wanted: &(dyn Fn(u32, u32) -> bool + Sync),
        may_go_on: &(dyn Fn() -> Result<(), AdapterError> + Sync),
    ) -> Result<Layer, AdapterError> {
        let antialias = self.antialias.filter(|_| self.output != Output::Depth);
        let ring = u32::from(antialias.is_some());
        let around = grown(window, ring, self.size);
        let is_near = |x: u32, y: u32| {
            let (xs, ys) = (
                x.saturating_sub(ring)..=x + ring,
                y.saturating_sub(ring)..=y + ring,
            );
            ys.into_iter()
                .any(|y| xs.clone().any(|x| window.contains(x, y) && wanted(x, y)))
        };
        let centres: Vec<Vec<Option<Sample>>> = (around.y..around.bottom())
            .into_par_iter()
            .map(|y| {
                may_go_on()?;
                Ok((around.x..around.right())
                    .map(|x| is_near(x, y).then(|| self.sample(x, y, 0.5, 0.5)))
                    .collect())
            })
            .collect::<Result<_, AdapterError>>()?;
        let centre = |x: u32, y: u32| {
            let inside = around.contains(x, y);
            inside
                .then(|| centres[(y - around.y) as usize][(x - around.x) as usize])
                .flatten()
        };

        let rows: Vec<Vec<([f32; 4], f64)>> = (window.y..window.bottom())
            .into_par_iter()
            .map(|y| {
                may_go_on()?;
                let pixel = |x| {
                    let sample = centre(x, y).filter(|_| wanted(x, y));
                    let Some(own) = sample else {
                        return ([0.0; 4], f64::INFINITY);
                    };
                    let colour = match antialias {
                        Some(Antialias { threshold, depth })
                            if depth > 1 && self.is_edge(x, y, &own, &centre, threshold) =>
                        {
                            self.supersampled(x, y, depth)
                        }
                        _ => own.colour,
                    };
                    (colour.map(finite), own.distance)
                };
                Ok((window.x..window.right()).map(pixel).collect())
            })
            .collect::<Result<_, AdapterError>>()?;

        let (colours, depths): (Vec<[f32; 4]>, Vec<f64>) = rows.into_iter().flatten().unzip();
        Ok(Layer {
            window,
            colour: (self.output != Output::Depth).then_some(colours),
            depth: Some(depths),
            depth_quantum: self.depth_quantum(),
        })
    }

    /// A ray through the pixel, at a share of its width and height.
    fn sample(&self, x: u32, y: u32, right: f64, down: f64) -> Sample {
        let (x, y) = (f64::from(x) + right, f64::from(y) + down);
        let direction = self.camera.direction(self.size, x, y);
        let ray = Ray {
            origin: self.camera.eye,
            direction: unit(direction).unwrap_or(self.camera.forward),
        };
        let nothing = match self.output {
            Output::ColourOverBackground => {
                colour(self.shader.scene.background).extend(1.0).to_array()
            }
            Output::ColourAlone { .. } | Output::Depth => [0.0; 4],
        };
        let hit = match self.output {
            Output::Depth => self.shader.distance(&ray).map(|t| (DVec3::ZERO, t)),
            _ => self.shader.look(&ray),
        };
        match hit {
            Some((colour, distance)) => Sample {
                colour: colour.extend(1.0).to_array(),
                distance,
            },
            None => Sample {
                colour: nothing,
                distance: f64::INFINITY,
            },
        }
    }

    /// Does a neighbour differ by more than the threshold? The sum over the
    /// channels as they are shown, and coverage.
    fn is_edge(
        &self,
        x: u32,
        y: u32,
        own: &Sample,
        centre: &dyn Fn(u32, u32) -> Option<Sample>,
        threshold: f64,
    ) -> bool {
        let shown = |s: &Sample| {
            let [r, g, b, a] = s.colour.map(|c| c as f32);
            [srgb(r), srgb(g), srgb(b), a].map(f64::from)
        };
        let own = shown(own);
        let neighbours = [
            (x.wrapping_sub(1), y),
            (x + 1, y),
            (x, y.wrapping_sub(1)),
            (x, y + 1),
        ];
        neighbours
            .into_iter()
            .filter_map(|(x, y)| centre(x, y))
            .any(|other| {
                let other = shown(&other);
                let apart: f64 = own.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
                apart > threshold
            })
    }

    /// The mean of a regular grid of rays.
    fn supersampled(&self, x: u32, y: u32, depth: u32) -> [f64; 4] {
        let depth = depth.min(9);
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(depth);
        let mut sum = [0.0; 4];
        for (i, j) in (0..depth).flat_map(|j| (0..depth).map(move |i| (i, j))) {
            let sample = self.sample(x, y, at(i), at(j));
            for (sum, channel) in sum.iter_mut().zip(sample.colour) {
                *sum += channel;
            }
        }
        sum.map(|channel| channel / f64::from(depth * depth))
    }

    /// What f64 leaves of the largest coordinate that went into a distance, and
    /// of the distance.
    fn depth_quantum(&self) -> (f64, f64) {
        let reach = self.shader.seen.reach();
        let eye = self.camera.eye.abs().max_element();
        (f64::from(finite(1e-12 * reach.max(eye))), 1e-12)
    }
}

/// The window with `by` pixels more on every side, inside the picture.
fn grown(window: Window, by: u32, size: Size) -> Window {
    if window.is_empty() {
        return Window::EMPTY;
    }
    let (x, y) = (window.x.saturating_sub(by), window.y.saturating_sub(by));
    Window {
        x,
        y,
        width: (window.right() + by).min(size.width) - x,
        height: (window.bottom() + by).min(size.height) - y,
    }
}

/// A colour that files and sums can hold: lights may be given any number.
fn finite(v: f64) -> f32 {
    if v.is_nan() {
        return 0.0;
    }
    v.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32
}

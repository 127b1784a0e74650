//! The dissolve: one décor brought over into the next a few pixels per frame, at
//! random, so that the eye does not catch the joint.
//!
//! Thesis, III-3-2-2. Objects of a décor may move by the threshold while it
//! serves. What they look like at its end is rendered too (the *target*), and
//! the pixels that differ, in colour or in depth, are brought in at random,
//! evenly over the frames. When the next décor takes over, this one equals the
//! target exactly.

use std::sync::Arc;

use decor_api::Layer;
use rand::RngExt as _;
use rand::SeedableRng as _;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::shadow::Shade;

/// A pixel that is the same in both pictures is never brought in.
const STAYS: u32 = u32::MAX;

/// How many of `total` changed pixels are in place after `step` of `steps`
/// steps: each step brings in what remains divided by the steps that remain, in
/// whole numbers. No two steps differ by more than one pixel.
///
/// Of 247 in 25 steps: 9, 9, 9, and 10 in each of the other 22.
pub fn in_place(total: u32, step: u32, steps: u32) -> u32 {
    if step >= steps {
        return total;
    }
    let (each, left) = (total / steps, total % steps);
    // The remainder goes to the last steps, one pixel to each.
    each * step + (step + left).saturating_sub(steps)
}

/// A décor's way to its target.
#[derive(Clone, Debug)]
pub struct Dissolve {
    target: Arc<Layer>,
    /// Of every pixel: how many others are brought in before it, or [`STAYS`].
    rank: Vec<u32>,
    total: u32,
    steps: u32,
}

impl Dissolve {
    /// The way from `decor` to `target` in `steps` frames. The order of the
    /// pixels depends on `seed` alone. Those change that look different in the
    /// frames' files, or are at another depth.
    ///
    /// Both layers cover the same window, with or without depth.
    pub fn between(
        decor: &Layer,
        target: Arc<Layer>,
        looks_different: impl Fn(usize) -> bool + Sync,
        steps: u32,
        seed: u64,
    ) -> Self {
        debug_assert_eq!(decor.window, target.window);
        let mut changed = changed_pixels(decor, &target, looks_different);
        let total = changed.len() as u32;
        let mut rank = vec![STAYS; target.window.pixels()];
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for next in 0..total {
            // The thesis's draw: any of those that remain; the last takes its place.
            let drawn = random.random_range(0..changed.len());
            rank[changed.swap_remove(drawn) as usize] = next;
        }
        Self {
            target,
            rank,
            total,
            steps: steps.max(1),
        }
    }

    /// How many pixels change.
    pub fn total(&self) -> u32 {
        self.total
    }

    /// How many pixels are in place after so many frames.
    pub fn in_place(&self, step: u32) -> u32 {
        in_place(self.total, step, self.steps)
    }

    /// Does pixel `index` show the target when so many are in place?
    pub fn shows_target(&self, index: usize, in_place: u32) -> bool {
        self.rank[index] < in_place
    }

    /// What the décor turns into.
    pub fn target(&self) -> &Layer {
        &self.target
    }
}

/// The pixels that differ, ascending.
fn changed_pixels(
    decor: &Layer,
    target: &Layer,
    looks_different: impl Fn(usize) -> bool + Sync,
) -> Vec<u32> {
    let (from_depth, to_depth) = (depths(decor), depths(target));
    let depth_differs =
        |i: usize| matches!((from_depth.get(i), to_depth.get(i)), (Some(a), Some(b)) if a != b);
    (0..target.window.pixels() as u32)
        .into_par_iter()
        .filter(|&i| {
            let i = i as usize;
            looks_different(i) || depth_differs(i)
        })
        .collect()
}

fn colours(layer: &Layer) -> &[[f32; 4]] {
    layer.colour.as_deref().unwrap_or_default()
}

fn depths(layer: &Layer) -> &[f64] {
    layer.depth.as_deref().unwrap_or_default()
}

/// A décor as one frame shows it: dissolved so far, before its sky.
#[derive(Clone, Copy)]
pub struct Backdrop<'a> {
    /// The décor as it was rendered.
    pub decor: &'a Layer,
    /// Its way to its target, and how many pixels are in place.
    pub dissolve: Option<(&'a Dissolve, u32)>,
    /// What is seen where no object is, where that is not the décor's own.
    pub sky: Option<&'a Layer>,
    /// Pixels that are in the shadow of what moves.
    pub shade: Option<&'a Shade>,
}

impl<'a> Backdrop<'a> {
    /// The décor as it was rendered.
    pub fn plain(decor: &'a Layer) -> Self {
        Self {
            decor,
            dissolve: None,
            sky: None,
            shade: None,
        }
    }

    /// How exact depths are, absolutely and relatively: see
    /// [`Layer::depth_quantum`].
    pub fn depth_quantum(&self) -> (f64, f64) {
        let decor = self.decor.depth_quantum;
        match self.dissolve {
            None => decor,
            Some((dissolve, _)) => {
                let target = dissolve.target.depth_quantum;
                (decor.0.max(target.0), decor.1.max(target.1))
            }
        }
    }

    /// Colours and depths of `colour.len()` pixels from column `x` of row `y` on.
    /// Without a depth in the décor, depths are +∞.
    pub fn row(&self, x: u32, y: u32, colour: &mut [[f32; 4]], depth: &mut [f64]) {
        self.depths(x, y, depth);
        self.colours(x, y, depth, colour);
    }

    /// Depths of `depth.len()` pixels from column `x` of row `y` on; +∞ where the
    /// décor has none.
    pub fn depths(&self, x: u32, y: u32, depth: &mut [f64]) {
        let from = self.decor.index(x, y);
        let pixels = from..from + depth.len();
        match depths(self.decor).get(pixels.clone()) {
            Some(known) => depth.copy_from_slice(known),
            None => depth.fill(f64::INFINITY),
        }
        if let Some((dissolve, in_place)) = self.dissolve {
            let target = depths(&dissolve.target);
            let ranks = &dissolve.rank[pixels.clone()];
            for ((depth, &rank), i) in depth.iter_mut().zip(ranks).zip(pixels) {
                if rank < in_place {
                    *depth = target.get(i).copied().unwrap_or(f64::INFINITY);
                }
            }
        }
    }

    /// The same, without a copy where the décor is shown as it was rendered.
    pub fn depths_of<'b>(&'b self, x: u32, y: u32, space: &'b mut [f64]) -> &'b [f64] {
        if self.dissolve.is_none() {
            let from = self.decor.index(x, y);
            if let Some(known) = depths(self.decor).get(from..from + space.len()) {
                return known;
            }
        }
        self.depths(x, y, space);
        space
    }

    /// Colours of `colour.len()` pixels from column `x` of row `y` on, whose
    /// [`depths`](Self::depths) are known.
    pub fn colours(&self, x: u32, y: u32, depth: &[f64], colour: &mut [[f32; 4]]) {
        let from = self.decor.index(x, y);
        let pixels = from..from + colour.len();
        colour.copy_from_slice(&colours(self.decor)[pixels.clone()]);
        if let Some((dissolve, in_place)) = self.dissolve {
            let target = &colours(&dissolve.target)[pixels.clone()];
            let ranks = &dissolve.rank[pixels.clone()];
            for ((colour, &rank), target) in colour.iter_mut().zip(ranks).zip(target) {
                if rank < in_place {
                    *colour = *target;
                }
            }
        }
        if let Some(shade) = self.shade {
            for (i, shaded) in shade.within(pixels.clone()) {
                colour[*i as usize - from] = *shaded;
            }
        }
        if let Some(sky) = self.sky {
            let sky = &colours(sky)[pixels];
            for ((colour, depth), sky) in colour.iter_mut().zip(depth).zip(sky) {
                if *depth == f64::INFINITY {
                    *colour = *sky;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Window;
    use proptest::prelude::*;

    /// The schedule as the thesis words it.
    fn by_the_thesis(total: u32, steps: u32) -> Vec<u32> {
        let mut left = total;
        (0..steps)
            .map(|step| {
                let now = left / (steps - step);
                left -= now;
                now
            })
            .collect()
    }

    #[test]
    fn the_schedule_is_the_thesis_s_own() {
        for total in 0..=5000 {
            for steps in 1..=60 {
                let thesis = by_the_thesis(total, steps);
                let mut before = 0;
                let (mut least, mut most) = (u32::MAX, 0);
                for (step, &now) in (1..).zip(&thesis) {
                    let after = in_place(total, step, steps);
                    assert_eq!(
                        after - before,
                        now,
                        "step {step} of {steps}, {total} pixels"
                    );
                    (least, most) = (least.min(now), most.max(now));
                    before = after;
                }
                assert_eq!(before, total);
                assert!(most - least <= 1);
            }
        }
    }

    #[test]
    fn the_thesis_s_example() {
        let thesis: Vec<u32> = (1..=25)
            .map(|step| in_place(247, step, 25) - in_place(247, step - 1, 25))
            .collect();
        assert_eq!(thesis[..4], [9, 9, 9, 10]);
        assert!(thesis[3..].iter().all(|&n| n == 10));
    }

    fn layer(pixels: &[(u8, u8)]) -> Layer {
        Layer {
            window: Window {
                x: 0,
                y: 0,
                width: pixels.len() as u32,
                height: 1,
            },
            colour: Some(pixels.iter().map(|p| [f32::from(p.0); 4]).collect()),
            depth: Some(pixels.iter().map(|p| f64::from(p.1)).collect()),
            depth_quantum: (0.0, 0.0),
        }
    }

    fn shown(decor: &Layer, dissolve: &Dissolve, step: u32) -> (Vec<[f32; 4]>, Vec<f64>) {
        let count = decor.window.pixels();
        let (mut colour, mut depth) = (vec![[0.0; 4]; count], vec![0.0; count]);
        let backdrop = Backdrop {
            decor,
            dissolve: Some((dissolve, dissolve.in_place(step))),
            ..Backdrop::plain(decor)
        };
        backdrop.row(0, 0, &mut colour, &mut depth);
        (colour, depth)
    }

    proptest! {
        #[test]
        fn pixels_change_once_evenly_and_end_at_the_target(
            pixels in prop::collection::vec(((0_u8..3, 0_u8..2), (0_u8..3, 0_u8..2)), 1..200),
            steps in 1_u32..30,
            seed: u64,
        ) {
            let (from, to): (Vec<_>, Vec<_>) = pixels.into_iter().unzip();
            let (decor, target) = (layer(&from), layer(&to));
            let total = from.iter().zip(&to).filter(|(a, b)| a != b).count() as u32;
            let differs = |i: usize| colours(&decor)[i] != colours(&target)[i];
            let dissolve =
                Dissolve::between(&decor, Arc::new(target.clone()), differs, steps, seed);
            prop_assert_eq!(dissolve.total(), total);
            let mut before = shown(&decor, &dissolve, 0);
            prop_assert_eq!(&before, &(decor.colour.clone().unwrap(), decor.depth.clone().unwrap()));
            let mut changes = vec![0; from.len()];
            for step in 1..=steps {
                let now = shown(&decor, &dissolve, step);
                let mut count = 0;
                for (i, changes) in changes.iter_mut().enumerate() {
                    if (now.0[i], now.1[i]) != (before.0[i], before.1[i]) {
                        *changes += 1;
                        count += 1;
                    }
                }
                prop_assert_eq!(count, in_place(total, step, steps) - in_place(total, step - 1, steps));
                before = now;
            }
            prop_assert!(changes.iter().all(|&n| n <= 1));
            prop_assert_eq!(before, (target.colour.unwrap(), target.depth.unwrap()));
        }
    }

    #[test]
    fn the_order_depends_on_the_seed_alone() {
        let (decor, target) = (layer(&[(0, 0); 300]), layer(&[(1, 0); 300]));
        let of =
            |seed| Dissolve::between(&decor, Arc::new(target.clone()), |_| true, 10, seed).rank;
        assert_eq!(of(7), of(7));
        assert_ne!(of(7), of(8));
        // It is one: every rank once.
        let mut ranks = of(7);
        ranks.sort_unstable();
        assert!(ranks.iter().copied().eq(0..300));
    }

    #[test]
    fn the_sky_is_seen_where_nothing_is() {
        let mut decor = layer(&[(1, 1), (1, 1)]);
        decor.depth = Some(vec![4.0, f64::INFINITY]);
        let sky = layer(&[(9, 0), (9, 0)]);
        let (mut colour, mut depth) = ([[0.0; 4]; 2], [0.0; 2]);
        let backdrop = Backdrop {
            sky: Some(&sky),
            ..Backdrop::plain(&decor)
        };
        backdrop.row(0, 0, &mut colour, &mut depth);
        assert_eq!((colour[0][0], colour[1][0]), (1.0, 9.0));
    }
}

//! Which blocks are dirty in which frame: geometry, where it knows enough, and
//! POV-Ray's proxies, where they cost less than they may save.
//!
//! The first proxies stand for all frames at once. Then for each quarter or half,
//! and so on, as long as a pass over the blocks that are still dirty costs less than
//! what it may save: a little less than the one before it. A pass costs about what a
//! frame costs, by the block.

use std::ops::Range;

use decor_api::RunContext;
use decor_povray::plain::PlainScene;
use decor_povray::unedited::{
    Blocks, FrameBoxes, Geometry, Grid, Hulls, Pixels, Proxy, Sampling, View,
};

use super::Look;
use super::price::Costs;
use super::purse::Purse;
use super::unlike::Unlike;
use crate::plain::pool::{Workers, side_by_side};
use crate::render::RenderError;

/// Proxies for half as many frames are expected to save this share of what they
/// look at, where nothing has told yet …
const SAVES: f64 = 0.25;

/// … and this share of what those for twice as many frames saved.
const FADES: f64 = 0.65;

/// A pass shall save so many times what it costs: it is waited for, too.
const PAYS: f64 = 1.3;

/// Groups of so many frames become four at once: what is saved by the first halving
/// alone is little more, and each pass sleeps.
const FOURS: usize = 16;

/// One block of so many tells what share of them is touched.
const SAMPLE: usize = 7;

/// The dirty blocks of each frame.
#[derive(Debug)]
pub struct Masks {
    /// In the order of the frames.
    pub dirty: Vec<Blocks>,
    /// Pixels that proxies were traced for.
    pub pixels: u64,
    /// Why geometry alone does not tell, where it does not.
    pub proxies_only: Option<String>,
    /// A block that is clean in two frames, and not the same in them.
    pub unlike: Option<usize>,
}

impl Masks {
    /// The share of all blocks that are dirty.
    pub fn share(&self) -> f64 {
        let sum: f64 = self.dirty.iter().map(Blocks::share).sum();
        sum / self.dirty.len().max(1) as f64
    }
}

/// What some blocks of a frame tell.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The share of all blocks that is touched.
    pub share: f64,
    /// Those of the sample that are.
    pub touched: Blocks,
    /// Pixels that were traced to know.
    pub pixels: u64,
}

/// One block of some, spread evenly.
fn one_of_some(dirty: &Blocks, grid: Grid) -> Blocks {
    let mut number = 0;
    Blocks::of(grid, |block| {
        number += usize::from(dirty.has(block));
        dirty.has(block) && number % SAMPLE == 1
    })
}

/// What finding them needs.
pub struct Finding<'a> {
    pub scene: &'a PlainScene,
    pub look: &'a Look,
    pub boxes: &'a [FrameBoxes],
    pub workers: Workers,
    pub run: &'a RunContext,
    /// Where it knows enough.
    geometry: Option<Geometry>,
    /// The camera, where it is a plain one, and the same in all frames.
    view: Option<View>,
}

impl<'a> Finding<'a> {
    /// What geometry says; all blocks where it says nothing.
    pub fn by_geometry(
        scene: &'a PlainScene,
        look: &'a Look,
        boxes: &'a [FrameBoxes],
        workers: Workers,
        run: &'a RunContext,
    ) -> (Self, Masks) {
        let grid = scene.grid();
        let first = boxes.first().cloned().unwrap_or_default();
        let (geometry, proxies_only) = match Geometry::new(grid, &look.analysis, &first) {
            Ok(geometry) => (Some(geometry), None),
            Err(reason) => (None, Some(reason)),
        };
        let dirty = boxes.iter().map(|frame| match &geometry {
            Some(geometry) => geometry.dirty(frame),
            None => Blocks::all(grid),
        });
        let masks = Masks {
            dirty: dirty.collect(),
            pixels: 0,
            proxies_only,
            unlike: None,
        };
        tracing::debug!(dirty = masks.share(), only = ?masks.proxies_only, "geometry");
        let same = boxes.iter().all(|frame| frame.camera == first.camera);
        let words = first
            .camera
            .as_ref()
            .filter(|words| same && !words.is_empty());
        let view = words.and_then(|words| View::of(words, grid.size));
        let finding = Self {
            scene,
            look,
            boxes,
            workers,
            run,
            geometry,
            view,
        };
        (finding, masks)
    }

    /// Makes them tighter by proxies, where that pays, or at least once; and no
    /// further where what is clean turns out not to be the same in two frames.
    pub fn by_proxies(
        &self,
        masks: &mut Masks,
        costs: &Costs,
        unlike: &Unlike,
        at_least_once: bool,
    ) -> Result<(), RenderError> {
        let grid = self.scene.grid();
        let block_s = costs.trace_s / grid.count() as f64;
        // What is asked for costs as much to trace.
        let mut asked_s = block_s;
        let mut saves = SAVES;
        let mut purse = Purse::for_film(costs.whole_s() * self.boxes.len() as f64);
        let mut groups = vec![Group {
            frames: 0..self.boxes.len(),
            touchable: Blocks::all(grid),
            halvings: 1,
        }];
        for level in 0.. {
            masks.unlike = unlike.clean_in(&masks.dirty);
            if masks.unlike.is_some() {
                return Ok(());
            }
            let mut passes = Vec::new();
            for group in groups {
                // Something moves that has no end: no proxies.
                let Some(pass) = self.pass(group, masks) else {
                    return Ok(());
                };
                let dirty = pass.dirty_frames(masks);
                let cost_s = costs.parse_s + costs.other_s + pass.asked.len() as f64 * asked_s;
                let must = at_least_once && level == 0;
                let saves = share_saved(saves, pass.group.halvings);
                let pays = PAYS * cost_s < saves * dirty as f64 * asked_s;
                if !pass.asked.is_empty() && (must || pays) {
                    passes.push(pass);
                }
            }
            let asked: usize = passes.iter().map(|pass| pass.asked.len()).sum();
            let calls = passes.len().max(self.workers.busy()) as f64;
            let cost_s = calls * (costs.parse_s + costs.other_s) + asked as f64 * asked_s;
            // The first pass was promised to pay.
            if passes.is_empty() || !purse.pay(cost_s, level == 0) {
                break;
            }
            let sum = |masks: &Masks| -> usize { masks.dirty.iter().map(Blocks::len).sum() };
            let before = sum(masks);
            let looked: usize = passes.iter().map(|pass| pass.dirty_frames(masks)).sum();
            // Most of the border is clean: nothing is lost by asking at once.
            let (touched, beyond) = rayon::join(
                || self.touched(&passes),
                || self.beyond(&passes, costs, block_s, at_least_once),
            );
            let ((touched, trace_s), beyond) = (touched?, beyond?);
            asked_s = block_s.max(trace_s / asked as f64);
            let halvings = passes.iter().map(|pass| pass.group.halvings).max();
            masks.pixels += self.pixels(passes.iter().flat_map(|pass| pass.asked.iter()));
            groups = Vec::new();
            masks.pixels += beyond.pixels;
            let pixels = touched.into_iter().zip(&beyond.untouched);
            for (pass, (touched, untouched)) in passes.into_iter().zip(pixels) {
                let sampling = self.scene.sampling();
                let within = touched.dirty_within(sampling);
                let now = within.or(&touched.dirty(sampling).without(untouched));
                let frames = pass.group.frames;
                tracing::debug!(
                    ?frames,
                    asked = pass.asked.len(),
                    dirty = now.and(&pass.asked).len(),
                    "proxies"
                );
                for dirty in &mut masks.dirty[frames.clone()] {
                    *dirty = dirty.and(&now);
                }
                let shown = touched.dirty(Sampling::Once);
                let touchable = pass.group.touchable.without(&pass.asked.without(&shown));
                let parts = parts(frames);
                let halvings = if parts.len() > 2 { 2 } else { 1 };
                groups.extend(parts.into_iter().map(|frames| Group {
                    frames,
                    touchable: touchable.clone(),
                    halvings,
                }));
            }
            let saved = (before - sum(masks)) as f64;
            purse.saved(saved * asked_s);
            if level > 0 {
                // Of each halving, in one pass or two.
                let share = saved / looked.max(1) as f64;
                let each = 1.0 / f64::from(halvings.unwrap_or(1).max(1));
                saves = FADES * (1.0 - (1.0 - share).powf(each));
            }
        }
        Ok(())
    }

    /// The share of the first frame's blocks that is touched, by one block of some;
    /// which of these are; and the pixels that were traced to know.
    pub fn sample(&self, masks: &Masks) -> Result<Sample, RenderError> {
        let grid = self.scene.grid();
        let group = Group {
            frames: 0..1,
            touchable: Blocks::all(grid),
            halvings: 1,
        };
        let mut sample = Sample {
            share: 1.0,
            touched: Blocks::none(grid),
            pixels: 0,
        };
        let Some(mut pass) = self.pass(group, masks) else {
            return Ok(sample);
        };
        pass.asked = one_of_some(&pass.dirty, grid);
        let (asked, dirty) = (pass.asked.len(), pass.dirty.share());
        if asked == 0 {
            sample.share = dirty;
            return Ok(sample);
        }
        sample.pixels = self.pixels(pass.asked.iter());
        let (touched, _) = self.touched(&[pass])?;
        for pixels in touched {
            sample.touched = sample.touched.or(&pixels.dirty(Sampling::Once));
        }
        sample.share = dirty * sample.touched.len() as f64 / asked as f64;
        Ok(sample)
    }

    fn pixels(&self, blocks: impl Iterator<Item = usize>) -> u64 {
        let grid = self.scene.grid();
        blocks.map(|block| grid.window(block).pixels() as u64).sum()
    }

    /// What proxies for a group are asked for: the blocks that may be touched, of
    /// those that are dirty in any frame, and of those that show their first rays
    /// above and to the left.
    fn pass(&self, mut group: Group, masks: &Masks) -> Option<Pass> {
        let grid = self.scene.grid();
        let boxes = &self.boxes[group.frames.clone()];
        let hulls = Hulls::of(&self.look.analysis, boxes)?;
        if let Some(geometry) = &self.geometry {
            group.touchable = group.touchable.and(&geometry.dirty_in(&hulls, &boxes[0]));
        }
        let dirty = masks.dirty[group.frames.clone()]
            .iter()
            .fold(Blocks::none(grid), |sum, dirty| sum.or(dirty));
        let asked = match self.scene.sampling() {
            Sampling::Neighbours => dirty.or(&grid.above_and_left_of(&dirty)),
            Sampling::Once | Sampling::Corners => dirty.clone(),
        };
        Some(Pass {
            asked: asked.and(&group.touchable),
            dirty,
            hulls,
            group,
        })
    }

    /// Border blocks: does anything beyond the picture make them dirty? Asked where
    /// that may save more than it costs.
    fn beyond(
        &self,
        passes: &[Pass],
        costs: &Costs,
        block_s: f64,
        always: bool,
    ) -> Result<Beyond, RenderError> {
        let grid = self.scene.grid();
        let sampling = self.scene.sampling();
        let mut found = Beyond {
            untouched: vec![Blocks::none(grid); passes.len()],
            pixels: 0,
        };
        let (Some(view), Sampling::Neighbours) = (&self.view, sampling) else {
            return Ok(found);
        };
        let mut asked = Vec::new();
        for (k, pass) in passes.iter().enumerate() {
            let open = pass.dirty.and(&grid.border());
            let shown = grid.showing_beyond(&open);
            let frames = pass.group.frames.len() as f64;
            let cost_s = costs.parse_s + costs.other_s + shown.len() as f64 * block_s;
            let pays = cost_s < SAVES * frames * open.len() as f64 * block_s;
            if !open.is_empty() && (pays || always) {
                asked.push((k, open, shown));
            }
        }
        let looked = side_by_side(&asked, self.workers.busy(), |(k, _, shown)| {
            let (sources, analysis) = (&self.look.sources, &self.look.analysis);
            let hulls = &passes[*k].hulls;
            Proxy::beyond(self.scene, sources, analysis, hulls, view, self.run)?
                .touched(shown, self.run)
        })?;
        for ((k, open, shown), (pixels, _)) in asked.into_iter().zip(looked) {
            let untouched = pixels.untouched_beyond().and(&open);
            tracing::debug!(asked = open.len(), clean = untouched.len(), "border");
            found.untouched[k] = untouched;
            found.pixels += self.pixels(shown.iter());
        }
        Ok(found)
    }

    /// The pixels that each group of frames touches, and the seconds of CPU for all.
    fn touched(&self, passes: &[Pass]) -> Result<(Vec<Pixels>, f64), RenderError> {
        let grid = self.scene.grid();
        // Each of them sleeps for longer than some take to trace.
        let processes = self.workers.all().min(2 * self.workers.busy());
        let parts = self.workers.busy().div_ceil(passes.len());
        let mut shares = Vec::new();
        for (k, pass) in passes.iter().enumerate() {
            // Neighbours cost alike: each part gets some of every place.
            let mut own = vec![Blocks::none(grid); parts];
            for (k, block) in pass.asked.iter().enumerate() {
                own[k % parts].insert(block);
            }
            own.retain(|share| !share.is_empty());
            shares.extend(own.into_iter().map(|share| (k, share)));
        }
        let proxies = passes.iter().map(|pass| {
            let (sources, analysis) = (&self.look.sources, &self.look.analysis);
            Proxy::new(self.scene, sources, analysis, &pass.hulls, self.run)
        });
        let proxies = proxies.collect::<Result<Vec<_>, _>>()?;
        let looked = side_by_side(&shares, processes, |(k, share)| {
            proxies[*k].touched(share, self.run)
        })?;
        let mut all = vec![Pixels::none(grid.size); passes.len()];
        let mut trace_s = 0.0;
        for ((k, _), (pixels, timing)) in shares.iter().zip(looked) {
            all[*k].merge(&pixels);
            trace_s += timing.trace_s;
        }
        Ok((all, trace_s))
    }
}

/// Frames that follow each other.
struct Group {
    frames: Range<usize>,
    /// All other blocks show no box of the group's.
    touchable: Blocks,
    /// By how many halvings it is smaller than the one that was asked for last.
    halvings: i32,
}

/// Parts of a group, whose boxes are within the group's.
fn parts(frames: Range<usize>) -> Vec<Range<usize>> {
    let halves = |frames: Range<usize>| {
        let middle = frames.start + frames.len() / 2;
        [frames.start..middle, middle..frames.end]
    };
    match frames.len() {
        0..=1 => Vec::new(),
        FOURS.. => halves(frames).into_iter().flat_map(halves).collect(),
        _ => halves(frames).to_vec(),
    }
}

/// What so many halvings save, of which each saves this share.
fn share_saved(each: f64, halvings: i32) -> f64 {
    1.0 - (1.0 - each).powi(halvings)
}

/// What proxies are rendered for.
struct Pass {
    group: Group,
    hulls: Hulls,
    /// In any of the frames.
    dirty: Blocks,
    asked: Blocks,
}

impl Pass {
    /// The dirty blocks of all its frames.
    fn dirty_frames(&self, masks: &Masks) -> usize {
        let dirty = masks.dirty[self.group.frames.clone()].iter();
        dirty.map(Blocks::len).sum()
    }
}

/// What is known of rays beyond the picture's border.
struct Beyond {
    /// Border blocks of each group that have none that is touched.
    untouched: Vec<Blocks>,
    /// Pixels that were traced to know.
    pixels: u64,
}

#[cfg(test)]
mod tests {
    use decor_api::Size;

    use super::*;

    #[test]
    fn parts_are_halves_of_halves() {
        assert!(parts(0..1).is_empty());
        assert_eq!(parts(3..8), [3..5, 5..8]);
        assert_eq!(parts(0..41), [0..10, 10..20, 20..30, 30..41]);
        assert!((share_saved(0.5, 2) - 0.75).abs() < 1e-9);
    }

    #[test]
    fn a_sample_is_spread_over_what_is_dirty() {
        let size = Size {
            width: 32 * 10,
            height: 32 * 7,
        };
        let grid = Grid { size };
        let even = Blocks::of(grid, |block| block % 2 == 0);
        let sample = one_of_some(&even, grid);
        let expected: Vec<usize> = (0..70).step_by(2 * SAMPLE).collect();
        assert_eq!(sample.iter().collect::<Vec<_>>(), expected);
        assert!(one_of_some(&Blocks::none(grid), grid).is_empty());
        // Something dirty is never overlooked.
        let last = Blocks::of(grid, |block| block == 69);
        assert_eq!(one_of_some(&last, grid), last);
    }
}

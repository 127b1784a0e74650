//! Which blocks are dirty in which frame: geometry, where it knows enough, and
//! POV-Ray's proxies, where they cost less than they may save.
//!
//! The first proxies stand for all frames at once. Then for each half, and so on,
//! as long as a pass over the blocks that are still dirty costs less than what it
//! may save.

use std::ops::Range;

use decor_api::RunContext;
use decor_povray::plain::PlainScene;
use decor_povray::unedited::{Blocks, FrameBoxes, Geometry, Pixels, Proxy, Sampling};

use super::Look;
use super::price::Costs;
use crate::plain::pool::{Workers, side_by_side};
use crate::render::RenderError;

/// A pass of proxies is expected to save this share of what it looks at.
const SAVES: f64 = 0.25;

/// Tracing proxies against tracing frames, before any were: every pixel is
/// sampled again. It took 2.5 to 5 times as long as frames of small scenes, 3
/// times as long as heavy ones.
const SAMPLED_AGAIN: f64 = 3.0;

/// The dirty blocks of each frame.
#[derive(Debug)]
pub struct Masks {
    /// In the order of the frames.
    pub dirty: Vec<Blocks>,
    /// Pixels that proxies were traced for.
    pub pixels: u64,
    /// Why geometry alone does not tell, where it does not.
    pub proxies_only: Option<String>,
}

impl Masks {
    /// The share of all blocks that are dirty.
    pub fn share(&self) -> f64 {
        let sum: f64 = self.dirty.iter().map(Blocks::share).sum();
        sum / self.dirty.len().max(1) as f64
    }
}

/// What finding them needs.
pub struct Finding<'a> {
    pub scene: &'a PlainScene,
    pub look: &'a Look,
    pub boxes: &'a [FrameBoxes],
    pub workers: Workers,
    pub run: &'a RunContext,
}

impl Finding<'_> {
    /// What geometry says; all blocks where it says nothing.
    pub fn by_geometry(&self) -> Masks {
        let grid = self.scene.grid();
        let first = self.boxes.first().cloned().unwrap_or_default();
        let geometry = Geometry::new(grid, &self.look.analysis, &first);
        let dirty = self.boxes.iter().map(|frame| match &geometry {
            Ok(geometry) => geometry.dirty(frame),
            Err(_) => Blocks::all(grid),
        });
        Masks {
            dirty: dirty.collect(),
            pixels: 0,
            proxies_only: geometry.err(),
        }
    }

    /// Makes them tighter by proxies, where that pays, or at least once.
    pub fn by_proxies(
        &self,
        masks: &mut Masks,
        costs: &Costs,
        at_least_once: bool,
    ) -> Result<(), RenderError> {
        let grid = self.scene.grid();
        let block_s = costs.trace_s / grid.count() as f64;
        let mut proxy_s = match self.scene.sampling() {
            Sampling::Once => block_s,
            _ => block_s * SAMPLED_AGAIN,
        };
        let whole = 0..self.boxes.len();
        let mut groups: Vec<Range<usize>> = vec![whole.clone()];
        while let Some(group) = groups.pop() {
            let asked = masks.dirty[group.clone()]
                .iter()
                .fold(Blocks::none(grid), |sum, dirty| sum.or(dirty));
            let dirty: usize = masks.dirty[group.clone()].iter().map(Blocks::len).sum();
            let calls = self.workers.busy().min(asked.len().max(1)) as f64;
            let cost_s = calls * (costs.parse_s + costs.other_s) + asked.len() as f64 * proxy_s;
            let must = at_least_once && group == whole;
            if asked.is_empty() || (!must && cost_s >= SAVES * dirty as f64 * block_s) {
                continue;
            }
            let Some((touched, trace_s)) = self.touched(&group, &asked)? else {
                return Ok(());
            };
            proxy_s = trace_s / asked.len() as f64;
            masks.pixels += asked
                .iter()
                .map(|block| grid.window(block).pixels() as u64)
                .sum::<u64>();
            let now = touched.dirty(self.scene.sampling());
            for dirty in &mut masks.dirty[group.clone()] {
                *dirty = dirty.and(&now);
            }
            if group.len() > 1 {
                let middle = group.start + group.len() / 2;
                groups.extend([group.start..middle, middle..group.end]);
            }
        }
        Ok(())
    }

    /// The pixels that a group of frames touches, and the seconds of CPU for them.
    fn touched(
        &self,
        group: &Range<usize>,
        asked: &Blocks,
    ) -> Result<Option<(Pixels, f64)>, RenderError> {
        let grid = self.scene.grid();
        let proxy = Proxy::new(
            self.scene,
            &self.look.sources,
            &self.look.analysis,
            &self.boxes[group.clone()],
            self.run,
        )?;
        let Some(proxy) = proxy else {
            return Ok(None);
        };
        // Neighbours cost alike: each part gets some of every place.
        let parts = self.workers.busy();
        let mut shares = vec![Blocks::none(grid); parts];
        for (k, block) in asked.iter().enumerate() {
            shares[k % parts].insert(block);
        }
        shares.retain(|share| !share.is_empty());
        let looked = side_by_side(&shares, parts, |share| proxy.touched(share, self.run))?;
        let mut all = Pixels::none(grid.size);
        let mut trace_s = 0.0;
        for (pixels, timing) in looked {
            all.merge(&pixels);
            trace_s += timing.trace_s;
        }
        Ok(Some((all, trace_s)))
    }
}

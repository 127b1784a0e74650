//! A film that is rendered by coherence: two of its frames whole, where everything
//! is, what that touches, and what all of it costs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::{Mutex, PoisonError};

use decor_api::{AdapterError, RunContext};
use decor_povray::PovRay;
use decor_povray::plain::{Part, PlainScene};
use decor_povray::unedited::{self, Blocks, Finished, FrameBoxes, Placed, Schedule, Traced};

use super::Look;
use super::beside::Promise;
use super::masks::{Finding, Masks};
use super::price::{Costs, Price};
use super::unlike::{NO_BLOCKS, Unlike};
use crate::plain::delivery::Delivery;
use crate::plain::pool::{Workers, side_by_side};
use crate::render::RenderError;

/// A film.
pub struct Film<'a> {
    pub povray: &'a PovRay,
    pub scene: &'a PlainScene,
    pub look: &'a Look,
    pub frames: Vec<u32>,
    pub workers: Workers,
    pub run: &'a RunContext,
    /// Frames that were handed over.
    pub given: Mutex<BTreeSet<u32>>,
    /// How many of them are put together from known and traced blocks.
    pub composed: AtomicU64,
}

/// Two frames, rendered whole.
pub struct Trial {
    /// Which ones, of the film's.
    pub frames: [usize; 2],
    /// What they gave.
    pub traced: Vec<Traced>,
    pub costs: Costs,
}

impl Trial {
    /// The state file of the k-th.
    pub fn blocks(&self, k: usize) -> Option<&PathBuf> {
        self.traced.get(k)?.blocks.first().map(|(_, file)| file)
    }

    /// Nobody needs the state files any longer.
    pub fn remove_blocks(&self) {
        for (_, file) in self.traced.iter().flat_map(|traced| &traced.blocks) {
            let _ = std::fs::remove_file(file);
        }
    }
}

/// What is said instead of a result: why the rest is rendered whole.
pub enum Found<T> {
    This(T),
    Whole(Vec<String>),
}

/// Where proxies cannot be rendered, the copy is at fault: the scene itself can be.
pub fn unless_copy_fails<T>(found: Result<T, RenderError>) -> Result<Found<T>, RenderError> {
    match found {
        Err(RenderError::Adapter(
            error @ (AdapterError::Failed { .. } | AdapterError::BadOutput { .. }),
        )) => {
            let reason = format!("proxies could not be rendered: {error}");
            Ok(Found::Whole(vec![reason]))
        }
        other => Ok(Found::This(other?)),
    }
}

impl Film<'_> {
    /// The first frame and the middle one.
    pub fn first_frames(&self) -> [usize; 2] {
        [0, self.frames.len() / 2]
    }

    /// From now on the film has only the frames of the trial and those that were not
    /// handed over.
    pub fn forget_given(&mut self, trial: &mut Trial, promise: &mut Promise) {
        let first = trial.frames.map(|frame| self.frames[frame]);
        let stays: Vec<bool> = self
            .frames
            .iter()
            .map(|frame| first.contains(frame) || !self.is_given(*frame))
            .collect();
        let mut all = stays.iter();
        self.frames.retain(|_| all.next() == Some(&true));
        if let Some(Found::This(boxes)) = &mut promise.boxes {
            let mut all = stays.iter();
            boxes.retain(|_| all.next() == Some(&true));
        }
        let place = |number| self.frames.iter().position(|frame| *frame == number);
        trial.frames = first.map(|number| place(number).unwrap_or_default());
    }

    /// Renders them whole.
    pub fn trial(&self) -> Result<Trial, RenderError> {
        let frames = self.first_frames();
        let own = self.run.counted_apart();
        let traced = side_by_side(&frames, self.workers.busy(), |at| {
            self.trace_one(self.frames[*at], &Finished::default(), None, &own)
        })?;
        let sum = |of: fn(&Traced) -> f64| traced.iter().map(of).sum::<f64>();
        let costs = Costs::of(
            sum(|t| t.timing.parse_s),
            sum(|t| t.timing.trace_s),
            own.tally.cpu().as_secs_f64(),
            frames.len(),
            frames.len(),
        );
        Ok(Trial {
            frames,
            traced,
            costs,
        })
    }

    /// A frame in a call of its own; these blocks of it, or all.
    pub fn trace_one(
        &self,
        frame: u32,
        finished: &Finished,
        blocks: Option<&Blocks>,
        run: &RunContext,
    ) -> Result<Traced, RenderError> {
        let all = Blocks::all(self.scene.grid());
        let state = |_| finished.state(blocks.unwrap_or(&all));
        let part = Part {
            first: frame,
            last: frame,
            threads: None,
        };
        Ok(self.scene.trace(part, &state, run)?)
    }

    /// Where everything is, in each of these frames.
    pub fn boxes(
        &self,
        frames: &[u32],
        run: &RunContext,
    ) -> Result<Found<Vec<FrameBoxes>>, RenderError> {
        let step = self.scene.frames.step;
        let parts = runs(frames, step, frames.len().div_ceil(self.workers.all()));
        let asked = side_by_side(&parts, self.workers.all(), |part| {
            let (scene, look) = (self.scene, self.look);
            let (sources, analysis) = (&look.sources, &look.analysis);
            unedited::boxes(self.povray, scene, sources, analysis, *part, run)
        })?;
        let whole: BTreeSet<String> = asked
            .iter()
            .flat_map(|boxes| boxes.whole.iter().map(ToString::to_string))
            .collect();
        if !whole.is_empty() {
            return Ok(Found::Whole(whole.into_iter().collect()));
        }
        let mut found: BTreeMap<u32, FrameBoxes> = BTreeMap::new();
        for boxes in asked {
            found.extend(boxes.frames.into_iter().map(|frame| (frame.frame, frame)));
        }
        let boxes = frames.iter().map(|frame| found.remove(frame));
        let Some(boxes) = boxes.collect::<Option<Vec<FrameBoxes>>>() else {
            let reason = "POV-Ray did not say where things are";
            return Ok(Found::Whole(vec![reason.into()]));
        };
        // Each part was looked at by itself.
        let still = |frame: &FrameBoxes| -> Vec<Placed> {
            let statements = &self.look.analysis.statements;
            let all = frame.objects.iter();
            all.filter(|o| statements.get(o.statement).is_some_and(|s| !s.moves))
                .copied()
                .collect()
        };
        let first = boxes.first().map(still).unwrap_or_default();
        if boxes.iter().any(|frame| still(frame) != first) {
            let reason = "what does not move is not always in one place";
            return Ok(Found::Whole(vec![reason.into()]));
        }
        Ok(Found::This(boxes))
    }

    /// The dirty blocks of each frame; by proxies where frames were tried, at least
    /// once or where they pay.
    pub fn masks(
        &self,
        boxes: &[FrameBoxes],
        trial: Option<(&Trial, bool)>,
    ) -> Result<Found<Masks>, RenderError> {
        let (finding, mut masks) =
            Finding::by_geometry(self.scene, self.look, boxes, self.workers, self.run);
        if let Some((trial, at_least_once)) = trial {
            let Some(unlike) = Unlike::of(trial, self.scene.grid())? else {
                return Ok(Found::Whole(vec![NO_BLOCKS.into()]));
            };
            let found = finding.by_proxies(&mut masks, &trial.costs, &unlike, at_least_once);
            if let Found::Whole(reasons) = unless_copy_fails(found)? {
                return Ok(Found::Whole(reasons));
            }
        }
        Ok(Found::This(masks))
    }

    /// What the frames that are not in `trial` cost by coherence; `dirtier` is what
    /// a dirty block costs, in average blocks.
    pub fn price(&self, costs: &Costs, plan: &Schedule, dirtier: f64) -> Price {
        let blocks = self.scene.grid().count() as f64;
        let of = |list: &[(usize, Blocks)]| {
            let traced: usize = list.iter().map(|(_, blocks)| blocks.len()).sum();
            let share = traced as f64 / (list.len().max(1) as f64 * blocks);
            let each_s = costs.partial_s((share * dirtier).min(1.0));
            Price::of(list.len(), each_s, &self.workers)
        };
        of(&plan.sources).and(of(&plan.rest))
    }

    /// Hands a frame over.
    pub fn give(
        &self,
        delivery: &Delivery<'_>,
        frame: u32,
        file: &Path,
    ) -> Result<(), RenderError> {
        delivery.hand_over(frame, file)?;
        let mut given = self.given.lock().unwrap_or_else(PoisonError::into_inner);
        given.insert(frame);
        Ok(())
    }

    /// Was the frame handed over?
    pub fn is_given(&self, frame: u32) -> bool {
        let given = self.given.lock().unwrap_or_else(PoisonError::into_inner);
        given.contains(&frame)
    }

    /// The pixels of some blocks.
    pub fn pixels(&self, blocks: &Blocks) -> u64 {
        let grid = self.scene.grid();
        let each = blocks
            .iter()
            .map(|block| grid.window(block).pixels() as u64);
        each.sum()
    }
}

/// Frames that follow each other, at most so many: their first and last ones.
fn runs(frames: &[u32], step: u32, longest: usize) -> Vec<(u32, u32)> {
    let mut list: Vec<(u32, u32)> = Vec::new();
    let mut length = 0;
    for &frame in frames {
        match list.last_mut() {
            Some((_, last)) if *last + step == frame && length < longest => {
                *last = frame;
                length += 1;
            }
            _ => {
                list.push((frame, frame));
                length = 1;
            }
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_frames() {
        assert_eq!(runs(&[1, 2, 3, 4, 5], 1, 2), [(1, 2), (3, 4), (5, 5)]);
        assert_eq!(runs(&[1, 3, 5, 9], 2, 9), [(1, 5), (9, 9)]);
        assert_eq!(runs(&[], 1, 3), []);
    }
}

//! What the trial did not render: frames that trace for others, and then the rest,
//! while one frame is traced both ways. Nothing is handed over before that has
//! ended well.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::Ordering;
use std::sync::{Condvar, Mutex, PoisonError};

use decor_povray::plain::Part;
use decor_povray::unedited::{self, Blocks, Finished, Schedule, Traced};

use super::film::{Film, Found, Trial};
use super::masks::Masks;
use super::price::Price;
use super::unlike::{self, NO_BLOCKS, Unlike};
use super::{DEAR, Done};
use crate::plain::delivery::Delivery;
use crate::plain::pace::Pace;
use crate::plain::pool::{pool, side_by_side};
use crate::render::RenderError;

/// No state files of a part may be larger than this, in bytes.
const PART_BYTES: u64 = 256 << 20;

/// A number of a state file takes four bytes, a pixel five numbers.
const PIXEL_BYTES: u64 = 20;

/// What the frame that was traced both ways says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Verdict {
    /// The frames are right: go on.
    Right,
    /// They are, but cost more than whole ones: stop.
    Dear,
    /// They are not.
    Wrong,
}

/// Where frames wait for the verdict.
#[derive(Default)]
struct Gate {
    verdict: Mutex<Option<Verdict>>,
    said: Condvar,
}

impl Gate {
    /// Says it, once.
    fn say(&self, verdict: Verdict) {
        let mut said = self.verdict.lock().unwrap_or_else(PoisonError::into_inner);
        said.get_or_insert(verdict);
        self.said.notify_all();
    }

    /// Shall nothing more begin?
    fn is_shut(&self) -> bool {
        let said = self.verdict.lock().unwrap_or_else(PoisonError::into_inner);
        said.is_some_and(|verdict| verdict != Verdict::Right)
    }

    /// Waits: may frames be handed over?
    fn passes(&self) -> bool {
        let said = self.verdict.lock().unwrap_or_else(PoisonError::into_inner);
        let said = self.said.wait_while(said, |verdict| verdict.is_none());
        *said.unwrap_or_else(PoisonError::into_inner) != Some(Verdict::Wrong)
    }
}

/// However the check ends, nobody waits for it any longer.
struct Last<'g>(&'g Gate);

impl Drop for Last<'_> {
    fn drop(&mut self) {
        self.0.say(Verdict::Wrong);
    }
}

/// What is to be rendered, and from what.
pub struct Rest<'r, 'd> {
    pub film: &'r Film<'r>,
    pub delivery: &'r Delivery<'d>,
    pub trial: &'r Trial,
    pub masks: &'r Masks,
    pub plan: &'r Schedule,
    /// Also where it does not pay.
    pub always: bool,
}

impl Rest<'_, '_> {
    /// Renders it, or says why what is left is better rendered whole.
    pub fn render(&self, done: &mut Done) -> Result<Found<()>, RenderError> {
        let mut finished = Finished::default();
        for (k, frame) in self.trial.frames.into_iter().enumerate() {
            if let Some(file) = self.trial.blocks(k) {
                finished.add(file, &self.clean(frame))?;
            }
        }
        let gate = Gate::default();
        let known = finished.clone();
        let found = std::thread::scope(|scope| {
            let check = scope.spawn(|| {
                let _last = Last(&gate);
                let found = self.check(&known)?;
                gate.say(match &found {
                    Found::This(()) => Verdict::Right,
                    Found::Whole(reasons) if reasons[..] == [DEAR] => Verdict::Dear,
                    Found::Whole(_) => Verdict::Wrong,
                });
                Ok::<_, RenderError>(found)
            });
            let rendered = self.frames(&mut finished, &gate);
            let found = check.join();
            let found = found.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            rendered?;
            found
        })?;
        let film = self.film;
        let planned = self.plan.sources.iter().chain(&self.plan.rest);
        let given = planned.filter(|(frame, _)| film.is_given(film.frames[*frame]));
        done.block_pixels += given.map(|(_, blocks)| film.pixels(blocks)).sum::<u64>();
        done.block_pixels += film.pixels(&self.masks.dirty[self.trial.frames[1]]);
        Ok(found)
    }

    fn clean(&self, frame: usize) -> Blocks {
        Blocks::all(self.film.scene.grid()).without(&self.masks.dirty[frame])
    }

    /// Traces what is dirty of a frame that is known whole, and compares; and what
    /// that took tells the price anew.
    fn check(&self, finished: &Finished) -> Result<Found<()>, RenderError> {
        let (film, trial) = (self.film, self.trial);
        let unlike = Unlike::of(trial, film.scene.grid())?;
        let (Some(second), Some(unlike)) = (trial.blocks(1), unlike) else {
            return Ok(Found::Whole(vec![NO_BLOCKS.into()]));
        };
        // The last masks are the tightest ones.
        if let Some(block) = unlike.clean_in(&self.masks.dirty) {
            return Ok(Found::Whole(vec![unlike::reason(block)]));
        }
        let at = trial.frames[1];
        let dirty = &self.masks.dirty[at];
        if dirty.is_empty() {
            return Ok(Found::This(()));
        }
        let traced = film.trace_one(film.frames[at], finished, Some(dirty), film.run)?;
        for (_, file) in &traced.blocks {
            let unlike = unedited::differing(second, file, dirty)?;
            let _ = std::fs::remove_file(file);
            if let Some(block) = unlike.iter().next() {
                return Ok(Found::Whole(vec![depends(block)]));
            }
        }
        let usual_s = trial.costs.trace_s * dirty.share();
        let took_s = traced.timing.trace_s;
        let dirtier = if usual_s > 0.0 && took_s > 0.0 {
            took_s / usual_s
        } else {
            1.0
        };
        tracing::debug!(dirtier, "a frame both ways");
        let stock = Price::of(self.plan.frames(), trial.costs.whole_s(), &film.workers);
        if self.always || film.price(&trial.costs, self.plan, dirtier).beats(&stock) {
            Ok(Found::This(()))
        } else {
            Ok(Found::Whole(vec![DEAR.into()]))
        }
    }

    /// Renders the frames that trace for others, then those that do not.
    fn frames(&self, finished: &mut Finished, gate: &Gate) -> Result<(), RenderError> {
        let film = self.film;
        let sources = side_by_side(
            &self.plan.sources,
            film.workers.busy(),
            |(frame, blocks)| -> Result<_, RenderError> {
                if gate.is_shut() {
                    return Ok(None);
                }
                let number = film.frames[*frame];
                let traced = film.trace_one(number, finished, Some(blocks), film.run)?;
                let passed = gate.passes();
                if passed {
                    self.give(&traced)?;
                }
                Ok(passed.then_some((*frame, traced)))
            },
        )?;
        for (frame, traced) in sources.into_iter().flatten() {
            for (_, file) in &traced.blocks {
                finished.add(file, &self.clean(frame))?;
                let _ = std::fs::remove_file(file);
            }
        }
        self.others(finished, gate)
    }

    fn give(&self, traced: &Traced) -> Result<(), RenderError> {
        for (frame, file) in &traced.pictures {
            self.film.give(self.delivery, *frame, file)?;
            self.film.composed.fetch_add(1, Ordering::Relaxed);
        }
        Ok(())
    }

    /// Renders the frames that trace for nobody else.
    fn others(&self, finished: &Finished, gate: &Gate) -> Result<(), RenderError> {
        let film = self.film;
        let traced: BTreeMap<u32, &Blocks> = self
            .plan
            .rest
            .iter()
            .map(|(frame, blocks)| (film.frames[*frame], blocks))
            .collect();
        let frames: BTreeSet<u32> = traced.keys().copied().collect();
        if frames.is_empty() {
            return Ok(());
        }
        let blocks: usize = traced.values().map(|blocks| blocks.len()).sum();
        let share = blocks as f64 / (frames.len() * film.scene.grid().count()) as f64;
        let pace = Pace::of(self.trial.costs.partial_s(share), &film.workers);
        let step = film.scene.frames.step;
        let all = Blocks::all(film.scene.grid());
        pool(
            &frames,
            &[],
            step,
            self.longest(),
            Some(pace),
            film.workers,
            film.run,
            None,
            |first, last| {
                if gate.is_shut() {
                    return Ok(0);
                }
                let part = Part {
                    first,
                    last,
                    threads: None,
                };
                let state = |frame| finished.state(traced.get(&frame).copied().unwrap_or(&all));
                let called = film.scene.trace(part, &state, film.run)?;
                if gate.passes() {
                    self.give(&called)?;
                }
                for (_, file) in &called.blocks {
                    let _ = std::fs::remove_file(file);
                }
                Ok(called.pictures.len() as u64)
            },
        )
    }

    /// A part's state files shall fit on the disk.
    fn longest(&self) -> usize {
        let (width, height) = self.film.scene.size;
        let bytes = u64::from(width) * u64::from(height) * PIXEL_BYTES;
        usize::try_from(PART_BYTES / bytes.max(1))
            .unwrap_or(1)
            .max(1)
    }
}

/// Why a scene in which a block came out otherwise is rendered whole.
pub fn depends(block: usize) -> String {
    format!("pixels depend on those that were traced before them (block {block})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;
    use std::time::Duration;

    #[test]
    fn nothing_is_handed_over_before_the_verdict() {
        let gate = Gate::default();
        let passed = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| passed.store(gate.passes(), Ordering::SeqCst));
            std::thread::sleep(Duration::from_millis(50));
            assert!(!passed.load(Ordering::SeqCst));
            gate.say(Verdict::Right);
        });
        assert!(passed.load(Ordering::SeqCst) && !gate.is_shut());
        // The first word counts.
        gate.say(Verdict::Wrong);
        assert!(gate.passes());
    }

    #[test]
    fn wrong_frames_stay_and_dear_ones_are_the_last() {
        let gate = Gate::default();
        assert!(!gate.is_shut());
        gate.say(Verdict::Dear);
        assert!(gate.passes() && gate.is_shut());
        let gate = Gate::default();
        gate.say(Verdict::Wrong);
        assert!(!gate.passes() && gate.is_shut());
    }

    #[test]
    fn a_check_that_fails_lets_nobody_wait() {
        let gate = Gate::default();
        drop(Last(&gate));
        assert!(!gate.passes());
    }
}

//! Whole frames from the first moment on, as `--mode full` has them; and beside
//! them the question whether those that are left are better rendered by coherence.
//!
//! Two frames of the film come first, and tell what one costs. Only where the
//! answer then costs little of what the film still takes is it looked for
//! ([`super::sounding`]), and whole frames go on until it is there, in short parts.
//! So a film that is better rendered whole loses no time by the question. Where
//! coherence pays, no further frame begins, and those that run end or are stopped,
//! whichever wastes less.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Instant;

use decor_api::{AdapterError, RunContext};
use decor_povray::plain::Part;
use decor_povray::unedited::{Finished, FrameBoxes, Traced};

use super::DEAR;
use super::Done;
use super::film::{Film, Found, Trial};
use super::price::{self, Costs};
use super::rest::depends;
use super::sounding::{Asked, TICK, promises};
use crate::plain::delivery::Delivery;
use crate::plain::pool::{Reins, pool};
use crate::render::RenderError;

/// Coherence pays for what is left.
pub struct Promise {
    /// What a dirty block costs, in average blocks.
    pub dirtier: f64,
    /// Where everything is in all frames, where that was asked for already.
    pub boxes: Option<Found<Vec<FrameBoxes>>>,
}

/// One of the first two frames.
struct First {
    traced: Traced,
    cpu_s: f64,
    wall_s: f64,
}

/// A part of the pool's that runs.
struct Running {
    first: u32,
    frames: usize,
    since: Instant,
    stop: Arc<AtomicBool>,
}

/// What the pool and those who decide share.
struct Shared {
    first: [Mutex<Option<First>>; 2],
    running: Mutex<Vec<Running>>,
    /// The pool has ended, well or not.
    is_over: AtomicBool,
}

/// However the pool ends, nobody waits for it any longer.
struct Over<'s>(&'s AtomicBool);

impl Drop for Over<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Is it better to stop a part that has run so long, of what it takes, where its
/// frames take this share of that by coherence?
fn wastes_less_stopped(ran_s: f64, takes_s: f64, share: f64) -> bool {
    takes_s - ran_s > share * takes_s
}

impl Shared {
    /// The costs of the first frames and what they took on the clock, when both
    /// are there.
    fn costs(&self) -> Option<(Costs, f64)> {
        let (a, b) = (lock(&self.first[0]), lock(&self.first[1]));
        let both = [a.as_ref()?, b.as_ref()?];
        let sum = |of: fn(&First) -> f64| both.iter().map(|first| of(first)).sum::<f64>();
        let costs = Costs::of(
            sum(|first| first.traced.timing.parse_s),
            sum(|first| first.traced.timing.trace_s),
            sum(|first| first.cpu_s),
            both.len(),
            both.len(),
        );
        Some((costs, sum(|first| first.wall_s) / both.len() as f64))
    }

    fn stop_if(&self, is_to_stop: impl Fn(&Running) -> bool) {
        for part in lock(&self.running).iter().filter(|part| is_to_stop(part)) {
            part.stop.store(true, Ordering::Relaxed);
        }
    }
}

impl Film<'_> {
    /// Renders frames whole, all of them, or until coherence promises to pay. Of
    /// two frames the blocks are kept.
    pub fn whole_or_promise(
        &self,
        delivery: &Delivery<'_>,
        done: &mut Done,
    ) -> Result<(Trial, Found<Promise>), RenderError> {
        let frames = self.first_frames();
        let numbers = frames.map(|frame| self.frames[frame]);
        let shared = Shared {
            first: Default::default(),
            running: Mutex::default(),
            is_over: AtomicBool::new(false),
        };
        let workers = self.workers;
        // What a frame costs is all that the pool knows: at best it is all tracing.
        let reins = Reins::short_where(move |frame_s, left| {
            let costs = Costs {
                trace_s: frame_s,
                ..Costs::default()
            };
            price::may_pay(&costs, left, &workers)
        });
        let answer = std::thread::scope(|scope| {
            let decider = scope.spawn(|| {
                let answer = self.decide(&shared, &reins, done);
                // What runs knows nothing of the film's own end.
                while !shared.is_over.load(Ordering::Relaxed) {
                    if self.run.is_cancelled() {
                        shared.stop_if(|_| true);
                    }
                    std::thread::sleep(TICK);
                }
                answer
            });
            let rendered = {
                let _over = Over(&shared.is_over);
                self.whole_frames(delivery, &shared, &reins, numbers)
            };
            let answer = decider.join();
            let answer = answer.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            rendered?;
            answer
        })?;
        let (costs, _) = shared.costs().ok_or(AdapterError::Cancelled)?;
        let first = shared.first.into_iter().filter_map(|first| {
            let first = first.into_inner();
            first.unwrap_or_else(PoisonError::into_inner)
        });
        let trial = Trial {
            frames,
            traced: first.map(|first| first.traced).collect(),
            costs,
        };
        Ok((trial, answer))
    }

    /// The pool, until it is halted.
    fn whole_frames(
        &self,
        delivery: &Delivery<'_>,
        shared: &Shared,
        reins: &Reins<'_>,
        first: [u32; 2],
    ) -> Result<(), RenderError> {
        let frames: BTreeSet<u32> = self.frames.iter().copied().collect();
        pool(
            &frames,
            &first,
            self.scene.frames.step,
            usize::MAX,
            None,
            self.workers,
            self.run,
            Some(reins),
            |a, b| match first.iter().position(|number| *number == a) {
                Some(k) => self.first_frame(delivery, a, &shared.first[k]),
                None => self.part(delivery, shared, (a, b)),
            },
        )
    }

    fn first_frame(
        &self,
        delivery: &Delivery<'_>,
        frame: u32,
        place: &Mutex<Option<First>>,
    ) -> Result<u64, RenderError> {
        let (began, own) = (Instant::now(), self.run.counted_apart());
        let traced = self.trace_one(frame, &Finished::default(), None, &own)?;
        for (frame, file) in &traced.pictures {
            self.give(delivery, *frame, file)?;
        }
        *lock(place) = Some(First {
            traced,
            cpu_s: own.tally.cpu().as_secs_f64(),
            wall_s: began.elapsed().as_secs_f64(),
        });
        Ok(1)
    }

    /// A part, unless it is stopped.
    fn part(
        &self,
        delivery: &Delivery<'_>,
        shared: &Shared,
        (first, last): (u32, u32),
    ) -> Result<u64, RenderError> {
        let run = RunContext {
            cancel: Arc::default(),
            ..self.run.clone()
        };
        lock(&shared.running).push(Running {
            first,
            frames: ((last - first) / self.scene.frames.step + 1) as usize,
            since: Instant::now(),
            stop: Arc::clone(&run.cancel),
        });
        let part = Part {
            first,
            last,
            threads: Some(1),
        };
        let files = self.scene.render(part, &run);
        lock(&shared.running).retain(|part| part.first != first);
        let files = match files {
            Err(AdapterError::Cancelled) if !self.run.is_cancelled() => return Ok(0),
            other => other?,
        };
        for (frame, file) in &files {
            self.give(delivery, *frame, file)?;
        }
        Ok(files.len() as u64)
    }

    /// Does coherence pay? Halts the pool, or lets it go on freely.
    fn decide(
        &self,
        shared: &Shared,
        reins: &Reins<'_>,
        done: &mut Done,
    ) -> Result<Found<Promise>, RenderError> {
        let answer = self.answer(shared, reins, done);
        match &answer {
            Ok(Found::This((promise, share))) => {
                reins.halt();
                if let Some((costs, wall_s)) = shared.costs() {
                    let share = costs.partial_s(share * promise.dirtier) / costs.whole_s();
                    shared.stop_if(|part| {
                        let takes_s = part.frames as f64 * wall_s;
                        wastes_less_stopped(part.since.elapsed().as_secs_f64(), takes_s, share)
                    });
                }
            }
            _ => reins.loosen(),
        }
        Ok(match answer? {
            Found::This((promise, _)) => Found::This(promise),
            Found::Whole(reasons) => Found::Whole(reasons),
        })
    }

    /// The promise, and the share of blocks that is dirty.
    fn answer(
        &self,
        shared: &Shared,
        reins: &Reins<'_>,
        done: &mut Done,
    ) -> Result<Found<(Promise, f64)>, RenderError> {
        let dear = || Ok(Found::Whole(vec![DEAR.into()]));
        let known: OnceLock<Costs> = OnceLock::new();
        let own = RunContext {
            cancel: Arc::default(),
            ..self.run.clone()
        };
        let ends = || self.run.is_cancelled() || shared.is_over.load(Ordering::Relaxed);
        std::thread::scope(|scope| {
            let look = scope.spawn(|| self.look(&known, &own));
            while shared.costs().is_none() && !ends() {
                std::thread::sleep(TICK);
            }
            let Some((costs, _)) = shared.costs() else {
                own.cancel.store(true, Ordering::Relaxed);
                return dear();
            };
            tracing::debug!(?costs, left = reins.left(), "the first frames");
            if !price::may_pay(&costs, reins.left(), &self.workers) {
                own.cancel.store(true, Ordering::Relaxed);
                return dear();
            }
            let _ = known.set(costs);
            while !look.is_finished() {
                if ends() {
                    own.cancel.store(true, Ordering::Relaxed);
                }
                std::thread::sleep(TICK);
            }
            let look = look.join();
            let look = look.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            let Asked { sounding, boxes } = match look {
                // There is nothing left to decide on.
                Err(RenderError::Adapter(AdapterError::Cancelled)) => return dear(),
                other => other?,
            };
            let sounding = match sounding {
                Found::This(sounding) => sounding,
                Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
            };
            done.block_pixels += sounding.pixels;
            done.dirty = Some(sounding.share);
            let middle = lock(&shared.first[1]);
            let blocks = middle
                .as_ref()
                .and_then(|first| first.traced.blocks.first());
            if let Some((_, whole)) = blocks
                && let Some(block) = sounding.unlike(whole)?
            {
                return Ok(Found::Whole(vec![depends(block)]));
            }
            let dirtier = sounding.dirtier(&costs);
            tracing::debug!(dirtier, left = reins.left(), "some blocks both ways");
            if !promises(
                &costs,
                sounding.share * dirtier,
                reins.left(),
                &self.workers,
            ) {
                return dear();
            }
            Ok(Found::This((Promise { dirtier, boxes }, sounding.share)))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_is_stopped_where_most_of_it_is_to_come() {
        // A frame of ten seconds, three by coherence.
        assert!(wastes_less_stopped(1.0, 10.0, 0.3));
        assert!(wastes_less_stopped(6.9, 10.0, 0.3));
        assert!(!wastes_less_stopped(7.1, 10.0, 0.3));
        assert!(!wastes_less_stopped(11.0, 10.0, 0.3), "it takes longer");
        assert!(!wastes_less_stopped(0.0, 10.0, 1.0), "nothing is won");
    }

    fn first(trace_s: f64) -> Mutex<Option<First>> {
        Mutex::new(Some(First {
            traced: Traced {
                pictures: Vec::new(),
                blocks: Vec::new(),
                timing: decor_povray::unedited::Timing {
                    parse_s: 0.5,
                    trace_s,
                },
            },
            cpu_s: trace_s + 1.0,
            wall_s: 2.0 * trace_s,
        }))
    }

    #[test]
    fn costs_are_known_when_both_frames_are_there() {
        let shared = Shared {
            first: [first(1.0), Mutex::default()],
            running: Mutex::default(),
            is_over: AtomicBool::new(false),
        };
        assert!(shared.costs().is_none());
        *lock(&shared.first[1]) = first(3.0).into_inner().unwrap();
        let (costs, wall_s) = shared.costs().unwrap();
        assert!((costs.trace_s - 2.0).abs() < 1e-9 && (costs.parse_s - 0.5).abs() < 1e-9);
        assert!((wall_s - 4.0).abs() < 1e-9);
        drop(Over(&shared.is_over));
        assert!(shared.is_over.into_inner());
    }
}

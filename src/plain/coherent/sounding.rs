//! A sounding: what the middle frame says before all others are looked at. It costs
//! little, and often says that all the rest is not worth while: a sample of its
//! blocks tells what share of them is dirty; those of them that are dirty are traced
//! apart from the others, which tells what a dirty block costs, and whether it comes
//! out as in the whole frame.
//!
//! It needs nothing of the frames that are rendered whole, so it is done beside
//! them, and so is the question where everything is in all frames: POV-Ray sleeps
//! most of that time. But it takes CPU, and whether frames are dear is not known
//! yet. Known is how long they have taken so far: what is asked beside them may
//! cost [`BESIDE`] of what the film takes if no frame takes longer than that.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use decor_api::RunContext;
use decor_povray::plain::Part;
use decor_povray::unedited::{Blocks, FrameBoxes, Traced, differing, only};

use super::film::{Film, Found, Trial, add, measured, unless_copy_fails};
use super::masks::{Finding, Sample};
use super::price::{CALL_S, Costs, Price};
use super::rest::depends;
use super::{DEAR, Done};
use crate::plain::delivery::Delivery;
use crate::plain::pace::Pace;
use crate::plain::pool::{Workers, pool};
use crate::render::RenderError;

/// What is asked beside the first frames may cost this share of the film.
const BESIDE: f64 = 0.03;

/// To ask for one frame costs a whole one at most: films have as many for one.
const FRAMES_BESIDE: usize = 34;

/// Between two looks at the clock.
const TICK: Duration = Duration::from_millis(25);

/// A group of frames has more dirty blocks than one of them.
const GROUPED: f64 = 1.2;

/// Proxies cost about so many frames: one or two for all frames at once, and as
/// much again for parts of them.
const PROXIES: usize = 3;

/// A dirty block costs so many average ones, which is taken for certain as if so
/// many blocks had said it.
const USUAL: (f64, f64) = (1.2, 4.0);

/// So long a sounding takes on the clock, nearly all of it asleep: three calls.
const SOUNDING_S: f64 = 2.2;

/// Where it takes more than this share of the film, whole frames are rendered
/// meanwhile.
const IDLE: f64 = 0.04;

/// What a sounding says.
#[derive(Debug)]
pub struct Sounding {
    /// The share of blocks that is dirty in the middle frame.
    pub share: f64,
    /// Pixels that were traced to know.
    pub pixels: u64,
    /// Some of the dirty blocks, and what they took apart from the others.
    apart: Option<(Blocks, Traced)>,
}

impl Sounding {
    /// What a dirty block costs, in average blocks: the fewer were traced, the nearer
    /// to what is usual.
    pub fn dirtier(&self, costs: &Costs) -> f64 {
        let (count, took) = self.apart.as_ref().map_or((0.0, 0.0), |(blocks, traced)| {
            let average_s = costs.trace_s * blocks.share() / blocks.len() as f64;
            (blocks.len() as f64, traced.timing.trace_s / average_s)
        });
        if took.is_finite() {
            (took + USUAL.0 * USUAL.1) / (count + USUAL.1)
        } else {
            USUAL.0
        }
    }

    /// A block that came out otherwise than in the whole frame.
    pub fn unlike(&self, trial: &Trial) -> Result<Option<usize>, RenderError> {
        let (Some((blocks, traced)), Some(whole)) = (&self.apart, trial.blocks(1)) else {
            return Ok(None);
        };
        let mut found = None;
        for (_, file) in &traced.blocks {
            found = found.or(differing(whole, file, blocks)?.iter().next());
            let _ = std::fs::remove_file(file);
        }
        Ok(found)
    }
}

/// What was found out beside the first frames, where that was done.
#[derive(Default)]
pub struct Early {
    pub sounding: Option<Found<Sounding>>,
    pub boxes: Option<Found<Vec<FrameBoxes>>>,
}

/// May be asked beside frames that have taken so long so far, where it takes so
/// much CPU a frame?
fn is_cheap(asked_s: f64, so_far: Duration) -> bool {
    asked_s <= BESIDE * (so_far.as_secs_f64() - CALL_S)
}

/// Does coherence pay for so many frames of which this share is dirty, in blocks of
/// average price?
pub fn promises(costs: &Costs, share: f64, frames: usize, workers: &Workers) -> bool {
    let asked = Price::of(frames, costs.asked_s(), workers);
    let proxies = Price::of(PROXIES, costs.whole_s(), workers);
    let rest = Price::of(frames, costs.partial_s((GROUPED * share).min(1.0)), workers);
    let stock = Price::of(frames, costs.whole_s(), workers);
    asked.and(proxies).and(rest).beats(&stock)
}

impl Film<'_> {
    /// Is it worth while to look at all frames? In the end what a dirty block costs,
    /// in average blocks. Short films are rendered whole meanwhile.
    pub fn sounded(
        &self,
        delivery: &Delivery<'_>,
        trial: &Trial,
        early: Option<Found<Sounding>>,
        always: bool,
        done: &mut Done,
    ) -> Result<Found<f64>, RenderError> {
        let left = self.frames.len() - trial.frames.len();
        let mut decide = |early: Option<Found<Sounding>>| {
            let sounding = match early {
                Some(known) => known,
                None if always => return Ok(Found::This(USUAL.0)),
                None => self.sounding()?,
            };
            let sounding = match sounding {
                Found::This(sounding) => sounding,
                Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
            };
            done.block_pixels += sounding.pixels;
            done.dirty = Some(sounding.share);
            if let Some(block) = sounding.unlike(trial)? {
                return Ok(Found::Whole(vec![depends(block)]));
            }
            let dirtier = sounding.dirtier(&trial.costs);
            let share = sounding.share * dirtier;
            tracing::debug!(dirtier, "some blocks both ways");
            if always || promises(&trial.costs, share, left, &self.workers) {
                Ok(Found::This(dirtier))
            } else {
                Ok(Found::Whole(vec![DEAR.into()]))
            }
        };
        let each_s = trial.costs.whole_s();
        let stock = Price::of(left, each_s, &self.workers);
        if always || early.is_some() || SOUNDING_S < IDLE * stock.wall_s {
            return decide(early);
        }
        let halt = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let sounding = scope.spawn(|| {
                let found = decide(early);
                // Where frames are rendered whole, they go on.
                let go_on = matches!(found, Ok(Found::Whole(_)));
                halt.store(!go_on, Ordering::Relaxed);
                found
            });
            let meanwhile = self.meanwhile(delivery, each_s, &halt);
            let found = sounding.join();
            let found = found.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            meanwhile?;
            found
        })
    }

    /// Renders frames whole until it is told to halt.
    fn meanwhile(
        &self,
        delivery: &Delivery<'_>,
        each_s: f64,
        halt: &AtomicBool,
    ) -> Result<(), RenderError> {
        let left = self.frames.iter().filter(|frame| !self.is_given(**frame));
        let left: BTreeSet<u32> = left.copied().collect();
        let pace = Pace::of(Some(each_s), &self.workers);
        pool(
            &left,
            self.scene.frames.step,
            pace.shortest(),
            pace,
            self.workers,
            self.run,
            Some(halt),
            |first, last| {
                let part = Part {
                    first,
                    last,
                    threads: Some(1),
                };
                let files = self.scene.render(part, self.run)?;
                for (frame, file) in &files {
                    self.give(delivery, *frame, file)?;
                }
                Ok(files.len() as u64)
            },
        )
    }

    /// Where everything is in the middle frame, and what a sample of its blocks
    /// says.
    pub fn sounding(&self) -> Result<Found<Sounding>, RenderError> {
        match self.boxes(&[self.middle()], self.run)? {
            Found::This(boxes) => self.sampled(&boxes),
            Found::Whole(reasons) => Ok(Found::Whole(reasons)),
        }
    }

    fn middle(&self) -> u32 {
        self.frames[self.frames.len() / 2]
    }

    fn sampled(&self, boxes: &[FrameBoxes]) -> Result<Found<Sounding>, RenderError> {
        unless_copy_fails(self.sample(boxes))
    }

    fn sample(&self, boxes: &[FrameBoxes]) -> Result<Sounding, RenderError> {
        let (finding, masks) =
            Finding::by_geometry(self.scene, self.look, boxes, self.workers, self.run);
        let Sample {
            share,
            touched,
            mut pixels,
        } = finding.sample(&masks)?;
        let mut apart = None;
        if !touched.is_empty() {
            let state = |_| only(self.scene.grid(), &touched);
            let part = Part {
                first: self.middle(),
                last: self.middle(),
                threads: None,
            };
            let traced = self.scene.trace(part, &state, self.run)?;
            for (_, picture) in &traced.pictures {
                let _ = std::fs::remove_file(picture);
            }
            pixels += self.pixels(&touched);
            apart = Some((touched, traced));
        }
        tracing::debug!(share, "sounding");
        Ok(Sounding {
            share,
            pixels,
            apart,
        })
    }

    /// The trial, and what can be found out beside it.
    pub fn trial_and_sounding(&self) -> Result<(Trial, Early), RenderError> {
        if self.frames.len() < FRAMES_BESIDE {
            return Ok((self.trial()?, Early::default()));
        }
        let over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let beside = scope.spawn(|| self.beside(&over));
            let trial = self.trial();
            over.store(true, Ordering::Relaxed);
            let early = beside.join();
            let early = early.unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            Ok((trial?, early?))
        })
    }

    fn beside(&self, over: &AtomicBool) -> Result<Early, RenderError> {
        let began = Instant::now();
        let mut early = Early::default();
        let own: RunContext = measured(self.run);
        let middle = self.boxes(&[self.middle()], &own);
        add(&own, self.run);
        let middle = match middle? {
            Found::This(boxes) => boxes,
            Found::Whole(reasons) => {
                early.sounding = Some(Found::Whole(reasons));
                return Ok(early);
            }
        };
        let asked_s = own.tally.cpu().as_secs_f64();
        let done = || over.load(Ordering::Relaxed) || self.run.is_cancelled();
        while !done() && !is_cheap(asked_s, began.elapsed()) {
            std::thread::sleep(TICK);
        }
        if done() {
            return Ok(early);
        }
        std::thread::scope(|scope| {
            let all = scope.spawn(|| self.boxes(&self.frames, self.run));
            early.sounding = Some(self.sampled(&middle)?);
            let all = all.join();
            early.boxes = Some(all.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?);
            Ok(early)
        })
    }
}

#[cfg(test)]
mod tests {
    use decor_api::Size;
    use decor_povray::unedited::{Grid, Timing};

    use super::*;

    const WORKERS: Workers = Workers {
        stated: None,
        most: 16,
        cores: 2,
    };

    fn costs(parse_s: f64, trace_s: f64) -> Costs {
        Costs {
            parse_s,
            trace_s,
            other_s: 0.1,
        }
    }

    #[test]
    fn few_dirty_blocks_of_heavy_frames_promise_much() {
        let heavy = costs(0.02, 3.0);
        assert!(promises(&heavy, 0.2, 38, &WORKERS));
        assert!(!promises(&heavy, 0.8, 38, &WORKERS), "nearly all is dirty");
        assert!(
            !promises(&heavy, 0.2, 4, &WORKERS),
            "proxies for four frames"
        );
        assert!(!promises(&costs(0.02, 0.03), 0.2, 38, &WORKERS), "light");
        assert!(
            !promises(&costs(3.0, 1.0), 0.2, 38, &WORKERS),
            "all is text"
        );
    }

    #[test]
    fn what_dirty_blocks_take_tells_their_price() {
        let grid = Grid {
            size: Size {
                width: 320,
                height: 320,
            },
        };
        let some = Blocks::of(grid, |block| block < 10);
        let sounding = |trace_s| Sounding {
            share: 0.3,
            pixels: 0,
            apart: Some((
                some.clone(),
                Traced {
                    pictures: Vec::new(),
                    blocks: Vec::new(),
                    timing: Timing {
                        parse_s: 1.0,
                        trace_s,
                    },
                },
            )),
        };
        let costs = costs(0.5, 4.0);
        // A tenth of the blocks: 0.4 s if they were average ones. Ten of them say 2,
        // and four 1.2.
        assert!((sounding(0.8).dirtier(&costs) - 24.8 / 14.0).abs() < 1e-9);
        let nothing = Sounding {
            share: 0.3,
            pixels: 0,
            apart: None,
        };
        assert!((nothing.dirtier(&costs) - 1.2).abs() < 1e-9);
        // A frame that takes no time says nothing.
        let none = Costs::default();
        assert!((sounding(0.8).dirtier(&none) - 1.2).abs() < 1e-9);
    }

    #[test]
    fn what_is_asked_beside_costs_little_of_the_film() {
        let after = |seconds| Duration::from_secs_f64(CALL_S + seconds);
        assert!(is_cheap(0.02, after(1.0)));
        assert!(!is_cheap(0.02, after(0.5)), "frames may be light");
        assert!(!is_cheap(0.5, after(5.0)), "it takes long to read");
        assert!(!is_cheap(0.02, Duration::ZERO));
        // One frame is asked for in any case.
        assert!(1.0 / FRAMES_BESIDE as f64 <= BESIDE);
    }
}

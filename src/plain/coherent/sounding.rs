//! A sounding: what the middle frame says before all others are looked at. It costs
//! little, and often says that all the rest is not worth while: a sample of its
//! blocks tells what share of them is dirty; those of them that are dirty are traced
//! apart from the others, which tells what a dirty block costs, and whether it comes
//! out as in the whole frame.
//!
//! It needs nothing of the frames that are rendered whole, so it is done beside
//! them, and so is the question where everything is in all frames: POV-Ray sleeps
//! most of that time. But it takes CPU. So it begins where frames have taken so long
//! already that it costs [`RISK`] of the film at most, or when the first ones have
//! come and say so ([`price::may_pay`](super::price::may_pay)).

use std::path::Path;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use decor_api::{AdapterError, RunContext};
use decor_povray::plain::Part;
use decor_povray::unedited::{Blocks, FrameBoxes, Traced, differing, only};

use super::film::{Film, Found, unless_copy_fails};
use super::masks::{Finding, Sample};
use super::price::{self, Costs, Price, RISK, SHORT_CALL_S};
use crate::plain::pool::Workers;
use crate::render::RenderError;

/// To ask for one frame costs a whole one at most: shorter films wait for the first
/// frames.
const FRAMES_BESIDE: usize = 34;

/// Wall time of a call of one frame that costs nothing: what it took longer is the
/// frame's.
const EMPTY_CALL_S: f64 = 0.65;

/// Between two looks at the clock.
pub const TICK: Duration = Duration::from_millis(25);

/// A group of frames has more dirty blocks than one of them.
const GROUPED: f64 = 1.2;

/// Proxies cost about so many frames: one or two for all frames at once, and as
/// much again for parts of them.
const PROXIES: usize = 3;

/// A dirty block costs so many average ones, which is taken for certain as if so
/// many blocks had said it.
pub const USUAL: (f64, f64) = (1.2, 4.0);

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

    /// A block that came out otherwise than in the whole frame, whose state file
    /// this is.
    pub fn unlike(&self, whole: &Path) -> Result<Option<usize>, RenderError> {
        let mut found = None;
        if let Some((blocks, traced)) = &self.apart {
            for (_, file) in &traced.blocks {
                found = found.or(differing(whole, file, blocks)?.iter().next());
                let _ = std::fs::remove_file(file);
            }
        }
        Ok(found)
    }
}

/// What was found out beside whole frames.
pub struct Asked {
    pub sounding: Found<Sounding>,
    /// Where everything is in all frames, where that was asked for.
    pub boxes: Option<Found<Vec<FrameBoxes>>>,
}

/// Does what takes so much CPU cost little of a film of so many frames, of which
/// the first have not come after so long?
fn is_cheap(cost_s: f64, frames: usize, so_far: Duration) -> bool {
    cost_s <= RISK * frames as f64 * (so_far.as_secs_f64() - EMPTY_CALL_S)
}

/// Does coherence pay for so many frames of which this share is dirty, in blocks of
/// average price?
pub fn promises(costs: &Costs, share: f64, frames: usize, workers: &Workers) -> bool {
    let asked = Price::of(frames, costs.asked_s(), workers);
    let proxies = Price::of(PROXIES, costs.whole_s(), workers);
    let rest = Price::of(frames, costs.partial_s((GROUPED * share).min(1.0)), workers);
    let stock = Price::of(frames, costs.whole_s(), workers);
    price::pays(asked.and(proxies).and(rest), &stock)
}

impl Film<'_> {
    /// Where everything is in the middle frame, and what a sample of its blocks
    /// says.
    pub fn sounding(&self) -> Result<Found<Sounding>, RenderError> {
        match self.boxes(&[self.middle()], self.run)? {
            Found::This(boxes) => self.sampled(&boxes, self.run),
            Found::Whole(reasons) => Ok(Found::Whole(reasons)),
        }
    }

    fn middle(&self) -> u32 {
        self.frames[self.frames.len() / 2]
    }

    fn sampled(
        &self,
        boxes: &[FrameBoxes],
        run: &RunContext,
    ) -> Result<Found<Sounding>, RenderError> {
        unless_copy_fails(self.sample(boxes, run))
    }

    fn sample(&self, boxes: &[FrameBoxes], run: &RunContext) -> Result<Sounding, RenderError> {
        let (finding, masks) =
            Finding::by_geometry(self.scene, self.look, boxes, self.workers, run);
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
            let traced = self.scene.trace(part, &state, run)?;
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

    /// Looks at the middle frame, and at all others where that costs little; when
    /// frames have taken long enough, or are `known` to.
    ///
    /// # Errors
    /// [`AdapterError::Cancelled`] where `run` was stopped, and what goes wrong with
    /// POV-Ray.
    pub fn look(&self, known: &OnceLock<Costs>, run: &RunContext) -> Result<Asked, RenderError> {
        let began = Instant::now();
        let count = self.frames.len();
        let beside = count >= FRAMES_BESIDE;
        let wait_until_cheap = |cost_s: f64| {
            while known.get().is_none() && !(beside && is_cheap(cost_s, count, began.elapsed())) {
                if run.is_cancelled() {
                    return Err(AdapterError::Cancelled);
                }
                std::thread::sleep(TICK);
            }
            Ok(())
        };
        wait_until_cheap(2.0 * SHORT_CALL_S)?;
        let own = run.counted_apart();
        let middle = match self.boxes(&[self.middle()], &own)? {
            Found::This(boxes) => boxes,
            Found::Whole(reasons) => {
                return Ok(Asked {
                    sounding: Found::Whole(reasons),
                    boxes: None,
                });
            }
        };
        let asked_s = count as f64 * own.tally.cpu().as_secs_f64();
        wait_until_cheap(asked_s)?;
        let all = match known.get() {
            Some(costs) => {
                let film_s = count as f64 * costs.whole_s();
                costs.sounding_s() + asked_s <= RISK * film_s
            }
            None => true,
        };
        std::thread::scope(|scope| {
            let all = all.then(|| scope.spawn(|| self.boxes(&self.frames, run)));
            let sounding = self.sampled(&middle, run)?;
            let all = all.map(|all| {
                let boxes = all.join();
                boxes.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            });
            Ok(Asked {
                sounding,
                boxes: all.transpose()?,
            })
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
        let after = |seconds| Duration::from_secs_f64(EMPTY_CALL_S + seconds);
        assert!(is_cheap(1.0, 50, after(1.01)));
        assert!(!is_cheap(1.0, 50, after(0.9)), "frames may be light");
        assert!(!is_cheap(1.0, 40, after(1.0)), "they are few");
        assert!(!is_cheap(0.02, 50, Duration::ZERO));
        // One frame is asked for in any case.
        assert!(1.0 / FRAMES_BESIDE as f64 <= 1.5 * RISK);
    }
}

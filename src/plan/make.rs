//! From a stage to its plan: where periods begin and end.

use super::lay::zooms;
use super::outlines::Outlines;
use super::{Costs, End, FramePlan, Mode, Period, Plan, WholeReason, Wishes, Work, jobs};
use crate::film::FrameState;
use crate::segmentation::same_environment;
use crate::stage::Stage;

/// Lengths of periods that are tried where the observer moves.
const LENGTHS: [u32; 11] = [2, 3, 5, 8, 12, 18, 25, 50, 100, 200, 400];

/// Longer periods that cost more, one after the other, before no more are tried.
const PATIENCE: u32 = 3;

/// Frames that are rendered whole before a décor is tried again.
const WHOLE_RUN: u32 = 12;

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
pub enum PlanError {
    /// An object cannot be put into a layer.
    #[error("object `{object}` cannot be put into a layer: it {reason}")]
    #[diagnostic(help("`--mode full` renders such a film, frame by frame"))]
    Unlayerable {
        /// Its name.
        object: String,
        /// Why.
        reason: String,
    },
    /// The last number that there is cannot be a frame's.
    #[error("frame {} is one too many: frame numbers end before it", u32::MAX)]
    LastNumber,
    /// Frames were asked for that the film does not have.
    #[error("the film has frames {} to {}; {} to {} were asked for", film.0, film.1, asked.0, asked.1)]
    NoSuchFrames {
        /// The film's first and last.
        film: (u32, u32),
        /// The first and last that were asked for.
        asked: (u32, u32),
    },
}

/// Plans the frames of a film.
///
/// # Errors
/// Where an object cannot be put into a layer, or the film lacks the frames.
pub fn plan(stage: &Stage, wishes: Wishes, costs: &Costs) -> Result<Plan, PlanError> {
    let film = (*stage.film.frames().start(), *stage.film.frames().end());
    let (first, last) = wishes.frames;
    if first < film.0 || last > film.1 || first > last {
        return Err(PlanError::NoSuchFrames {
            film,
            asked: wishes.frames,
        });
    }
    if last == u32::MAX {
        return Err(PlanError::LastNumber);
    }
    let outlines = Outlines::default();
    let mut maker = Maker {
        stage,
        wishes: &wishes,
        costs,
        jobs: jobs(stage),
        cores: crate::probe::cores(),
        threshold_px: wishes.threshold_px,
        outlines: &outlines,
        live: false,
    };
    if wishes.mode != Mode::Full {
        maker.check_layerable()?;
    }
    let mut periods: Vec<Period> = Vec::new();
    let mut start = first;
    while start <= last {
        outlines.forget_before(start);
        let period = match wishes.budget {
            None => maker.next_period(start),
            Some(budget) => {
                let chosen = budget.choose(maker.threshold_px, |threshold_px| {
                    let period = Maker {
                        threshold_px,
                        ..maker
                    }
                    .next_period(start);
                    (maker.frame_seconds(&period), period)
                });
                // The next period goes on from there.
                maker.threshold_px = chosen.0;
                chosen.1
            }
        };
        start += period.len();
        match periods.last_mut() {
            // Whole frames need no décor in common: they are one period, and
            // rendered by the same calls.
            Some(before) if before.whole.is_some() && before.whole == period.whole => {
                before.frames.extend(period.frames);
                before.end = period.end;
            }
            _ => periods.push(period),
        }
    }
    Ok(Plan { wishes, periods })
}

/// What periods are made with.
#[derive(Clone, Copy)]
pub struct Maker<'a> {
    pub stage: &'a Stage,
    pub wishes: &'a Wishes,
    pub costs: &'a Costs,
    pub jobs: usize,
    pub cores: usize,
    /// The threshold of the next period, in pixels.
    pub threshold_px: f64,
    /// Where objects are seen.
    pub outlines: &'a Outlines,
    /// Do frames arrive one at a time?
    pub live: bool,
}

impl<'a> Maker<'a> {
    /// Every description of the film: a named object may change its own.
    pub fn check_layerable(&self) -> Result<(), PlanError> {
        for description in self.stage.film.descriptions() {
            let prototype = self.stage.library.by_path[description.path()];
            if let Some(reason) = &self.stage.library.table.get(prototype).unlayerable {
                return Err(PlanError::Unlayerable {
                    object: description.path().display().to_string(),
                    reason: reason.clone(),
                });
            }
        }
        Ok(())
    }

    pub fn abilities(&self) -> &decor_api::Abilities {
        self.stage.adapter.abilities()
    }

    pub fn state(&self, number: u32) -> FrameState<'a> {
        self.stage.film.frame(number)
    }

    /// The period that begins at `start`.
    pub fn next_period(&self, start: u32) -> Period {
        let last = self.wishes.frames.1;
        if self.wishes.mode == Mode::Full {
            return self.whole((start, last), End::Done, WholeReason::Asked);
        }
        let end_at = |at: u32, why: End| if at == last { End::Done } else { why };
        let first = self.state(start);
        let surroundings = self.stage.surroundings(&first);
        if let Some(what) = &surroundings.unlayerable {
            let until = self.run(start, last, |a, b| a.sky == b.sky);
            let end = end_at(until, End::SurroundingsChange);
            return self.whole((start, until), end, WholeReason::Unconfined(what.clone()));
        }
        let environment = self.run(start, last, same_environment);
        let still = self.run(start, environment, |a, b| a.camera == b.camera);
        if still > start || start == last {
            let end = if still < environment {
                End::ObserverStarts
            } else {
                end_at(still, End::SurroundingsChange)
            };
            return self.stated(start, (still, end));
        }
        if environment == start {
            let until = self.changing_run(start, last);
            let end = end_at(until, End::SurroundingsChange);
            return self.whole((start, until), end, WholeReason::SurroundingsChange);
        }
        // The observer moves in an environment that stays.
        let until = self.moving_run(start, environment);
        let end = if until == environment {
            end_at(until, End::SurroundingsChange)
        } else if self.state(until).camera == self.state(until + 1).camera
            || until + 1 < environment
                && self.state(until + 1).camera == self.state(until + 2).camera
        {
            End::ObserverRests
        } else {
            End::SurroundingsChange
        };
        if self.threshold_px <= 0.0 {
            return self.whole((start, until), end, WholeReason::ObserverMoves);
        }
        if surroundings.sky_on_objects {
            return self.whole((start, until), end, WholeReason::SkyMoves);
        }
        if self.wishes.period.is_some() {
            return self.stated(start, (until, end));
        }
        self.cheapest_period(start, until, end)
    }

    /// A period as long as it can be, and not longer than was asked for.
    fn stated(&self, start: u32, (until, end): (u32, End)) -> Period {
        match self.wishes.period {
            Some(length) if start.saturating_add(length - 1) < until => {
                self.period((start, start + length - 1), End::Asked)
            }
            _ => self.period((start, until), end),
        }
    }

    /// What a frame of a period costs, in seconds on the clock, in the midst of
    /// others.
    fn frame_seconds(&self, period: &Period) -> f64 {
        let work = Work::of(self.stage, period, self.wishes);
        let price = self.costs.in_a_row(&work, self.jobs, self.cores);
        price.wall_s / f64::from(period.len())
    }

    /// How dear a frame of a period is: less is better.
    pub fn weight(&self, period: &Period, alone: bool) -> f64 {
        let work = Work::of(self.stage, period, self.wishes);
        let price = if self.live {
            self.costs.one_by_one(&work, self.jobs, self.cores)
        } else if alone {
            self.costs.price(&work, self.jobs, self.cores)
        } else {
            self.costs.in_a_row(&work, self.jobs, self.cores)
        };
        price.weight(self.cores) / f64::from(period.len())
    }

    /// Renders the frames whole, where that is not dearer. `alone`: no other
    /// period runs beside it.
    pub fn give_up_if_dear(&self, period: &mut Period, alone: bool) {
        if !self.wishes.fallback || period.whole.is_some() {
            return;
        }
        let whole = Period {
            frames: vec![FramePlan::Whole; period.frames.len()],
            dissolve_until: None,
            whole: Some(WholeReason::NoGain),
            ..period.clone()
        };
        if self.weight(&whole, alone) <= self.weight(period, alone) {
            *period = whole;
        }
    }

    /// The last frame up to `last` until which every frame is `like` the first.
    fn run(
        &self,
        start: u32,
        last: u32,
        like: impl Fn(&FrameState<'_>, &FrameState<'_>) -> bool,
    ) -> u32 {
        let first = self.state(start);
        let different = (start + 1..=last).find(|&n| !like(&first, &self.state(n)));
        different.map_or(last, |n| n - 1)
    }

    /// The last frame of a run in which each differs from the one before.
    fn changing_run(&self, start: u32, last: u32) -> u32 {
        let pairs = (start..last).find(|&n| same_environment(&self.state(n), &self.state(n + 1)));
        pairs.map_or(last, |n| n.saturating_sub(1).max(start))
    }

    /// The last frame of a run in which the observer moves from each to the next,
    /// and in which the opening of the view changes from each to the next or not
    /// at all.
    fn moving_run(&self, start: u32, last: u32) -> u32 {
        let zoom = zooms(&self.state(start), &self.state(start + 1));
        for n in start..last {
            let (now, next) = (self.state(n), self.state(n + 1));
            if now.camera == next.camera {
                return n.saturating_sub(1).max(start);
            }
            if zooms(&now, &next) != zoom {
                return n;
            }
        }
        last
    }

    /// The period that costs least per frame, of those that are tried. Too short
    /// a period wins little, too long a one keeps little: after the best length
    /// the costs only grow, and no longer ones are tried.
    fn cheapest_period(&self, start: u32, until: u32, end: End) -> Period {
        let longest = until - start + 1;
        let lengths = LENGTHS.iter().copied().filter(|&l| l < longest);
        let mut best: Option<(f64, Period)> = None;
        let mut in_vain = 0;
        for length in lengths.chain((longest > 1).then_some(longest)) {
            let last = start + length - 1;
            let end = if last == until { end } else { End::Cheapest };
            let mut period = self.laid((start, last), end);
            self.give_up_if_dear(&mut period, false);
            let cost = self.weight(&period, false);
            if best.as_ref().is_none_or(|(least, _)| cost < *least) {
                (best, in_vain) = (Some((cost, period)), 0);
            } else {
                in_vain += 1;
                if in_vain == PATIENCE {
                    break;
                }
            }
        }
        match best {
            Some((_, period)) if period.whole.is_none() => period,
            other => {
                let reason = other.and_then(|(_, period)| period.whole);
                let last = until.min(start + WHOLE_RUN - 1);
                let end = if last == until { end } else { End::TriedAgain };
                self.whole((start, last), end, reason.unwrap_or(WholeReason::NoGain))
            }
        }
    }
}

//! From a stage to its plan.

use std::collections::HashSet;

use decor_api::{Optics, Window};

use super::windows::gathered;
use super::{BlockSet, FramePlan, Mode, Period, Plan, WholeReason, Wishes};
use crate::film::{FrameState, ObjectId};
use crate::motion::screen_box;
use crate::segmentation::{Class, same_surroundings, segment};
use crate::stage::Stage;

/// A layered frame traces its windows twice, for colour and for depth; depth
/// rays are cheap. Above this share of a frame's pixels nothing is won.
const WORTHWHILE: f64 = 0.9;

/// The cost of a depth ray, as a share of a colour ray's.
const DEPTH_SHARE: f64 = 0.4;

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
pub fn plan(stage: &Stage, wishes: Wishes) -> Result<Plan, PlanError> {
    let film = (*stage.film.frames().start(), *stage.film.frames().end());
    let (first, last) = wishes.frames;
    if first < film.0 || last > film.1 || first > last {
        return Err(PlanError::NoSuchFrames {
            film,
            asked: wishes.frames,
        });
    }
    let maker = Maker {
        stage,
        wishes: &wishes,
    };
    let mut periods = Vec::new();
    let mut start = first;
    while start <= last {
        let end = maker.end_of_period(start);
        periods.push(maker.period(start, end)?);
        start = end + 1;
    }
    Ok(Plan { wishes, periods })
}

struct Maker<'a> {
    stage: &'a Stage,
    wishes: &'a Wishes,
}

impl Maker<'_> {
    /// The last frame of the period that begins at `start`. Whole frames need
    /// no décor in common, so that frames whose surroundings change one by one
    /// are gathered into one period.
    fn end_of_period(&self, start: u32) -> u32 {
        let last = self.wishes.frames.1;
        if self.wishes.mode == Mode::Full {
            return last;
        }
        let longest = match self.wishes.period {
            Some(length) => start.saturating_add(length - 1).min(last),
            None => last,
        };
        let mut previous = self.stage.film.frame(start);
        let mut end = start;
        let mut alone = false;
        while end < longest {
            let next = self.stage.film.frame(end + 1);
            let same = same_surroundings(&previous, &next);
            if end == start {
                alone = !same;
            }
            // A run of frames that differ ends where two are the same.
            if alone == same {
                return if alone { end - 1 } else { end };
            }
            previous = next;
            end += 1;
        }
        end
    }

    fn period(&self, start: u32, end: u32) -> Result<Period, PlanError> {
        let frames = || (start..=end).map(|n| self.stage.film.frame(n));
        let same = frames()
            .zip(frames().skip(1))
            .all(|(a, b)| same_surroundings(&a, &b));
        let mut objects = segment(frames());
        if !same {
            for object in &mut objects {
                object.class = Class::Fast;
                object.reason = crate::segmentation::Reason::SurroundingsChange;
            }
        }
        let whole = self.whole_reason(start, same, &objects)?;
        let count = (end - start + 1) as usize;
        let mut period = Period {
            start,
            frames: vec![FramePlan::Whole; count],
            objects,
            whole,
        };
        if period.whole.is_none() {
            self.lay(&mut period);
        }
        Ok(period)
    }

    /// Why the period has no décor, if it is so before pixels are counted.
    fn whole_reason(
        &self,
        start: u32,
        same_surroundings: bool,
        objects: &[crate::segmentation::Segmented],
    ) -> Result<Option<WholeReason>, PlanError> {
        if self.wishes.mode == Mode::Full {
            return Ok(Some(WholeReason::Asked));
        }
        let state = self.stage.film.frame(start);
        self.check_layerable()?;
        if let Some(what) = &self.stage.surroundings(&state).unlayerable {
            return Ok(Some(WholeReason::Unconfined(what.clone())));
        }
        if !same_surroundings {
            return Ok(Some(WholeReason::SurroundingsChange));
        }
        let moving = objects.iter().any(|o| o.class == Class::Fast);
        if objects.iter().all(|o| o.class == Class::Fast) && moving {
            return Ok(Some(WholeReason::NothingStays));
        }
        let casts = state.shadows && !state.lights.is_empty() && self.abilities().shadows;
        if casts && moving && self.wishes.mode != Mode::Preview {
            return Ok(Some(WholeReason::Shadows));
        }
        Ok(None)
    }

    /// Every description of the film: a named object may change its own.
    fn check_layerable(&self) -> Result<(), PlanError> {
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

    fn abilities(&self) -> &decor_api::Abilities {
        self.stage.adapter.abilities()
    }

    /// Decides what is rendered where, frame by frame.
    fn lay(&self, period: &mut Period) {
        let fast: HashSet<ObjectId> = period
            .objects
            .iter()
            .filter(|o| o.class == Class::Fast)
            .map(|o| o.object)
            .collect();
        let size = self.stage.size();
        let all = size.pixels() as f64;
        let mut cost = all;
        for (number, frame) in (period.start..).zip(&mut period.frames) {
            let state = self.stage.film.frame(number);
            let layered = self.lay_frame(&state, &fast);
            let pixels = match &layered {
                FramePlan::Whole => all,
                FramePlan::Layered { fast, blocks } => {
                    let fast: usize = fast.iter().map(|window| window.pixels()).sum();
                    fast as f64 * (1.0 + DEPTH_SHARE) + blocks.pixels() as f64
                }
            };
            if self.wishes.fallback && pixels > WORTHWHILE * all {
                *frame = FramePlan::Whole;
                cost += all;
            } else {
                *frame = layered;
                cost += pixels;
            }
        }
        if self.wishes.fallback && cost > WORTHWHILE * all * period.frames.len() as f64 {
            period.frames.fill(FramePlan::Whole);
            period.whole = Some(WholeReason::NoGain);
        }
    }

    fn lay_frame(&self, state: &FrameState<'_>, fast: &HashSet<ObjectId>) -> FramePlan {
        let size = self.stage.size();
        let mut blocks = BlockSet::none(size);
        let mut merged: Vec<Window> = Vec::new();
        let optics = self.abilities().optics && self.wishes.mode != Mode::Preview;
        // What is drawn from the full scene as a whole, and what is merged.
        let all_from_scene = self.wishes.mode == Mode::Exact || self.no_coverage(state);
        for object in &state.objects {
            let is_fast = fast.contains(&object.id);
            let prototype = self.stage.prototype(object);
            let window =
                screen_box(&prototype.bounds.posed(&object.pose), &state.camera, size).window();
            if optics && prototype.optics != Optics::Opaque && !fast.is_empty() {
                // What it mirrors or lets through may be in the other layer.
                blocks.insert(window);
                if is_fast && self.wishes.with_depth {
                    merged.push(window);
                }
            } else if is_fast && all_from_scene {
                blocks.insert(window);
                if self.wishes.with_depth {
                    merged.push(window);
                }
            } else if is_fast {
                merged.push(window);
            }
        }
        if !self.wishes.with_depth {
            merged.retain(|&window| !blocks.contains(window));
        }
        FramePlan::Layered {
            fast: gathered(&merged, size),
            blocks,
        }
    }

    /// Is antialiasing on, and coverage not to be had?
    fn no_coverage(&self, state: &FrameState<'_>) -> bool {
        let surroundings = self.stage.surroundings(state);
        state.antialias.is_some() && (surroundings.sky_on_objects || !self.abilities().coverage)
    }
}

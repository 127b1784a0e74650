//! From a stage to its plan.

use std::collections::HashMap;

use decor_api::{Bounds, Optics, Window};

use super::windows::gathered;
use super::{BlockSet, FramePlan, Mode, Period, Plan, WholeReason, Wishes};
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::motion::screen_box;
use crate::segmentation::{Class, Reason, Rule, Segmented, same_environment, segment};
use crate::stage::Stage;

/// A layered frame traces its windows twice, for colour and for depth; depth
/// rays are cheap. Above this share of a frame's pixels nothing is won.
const WORTHWHILE: f64 = 0.9;

/// The cost of a depth ray, as a share of a colour ray's.
const DEPTH_SHARE: f64 = 0.4;

/// Lengths of periods that are tried where the observer moves.
const LENGTHS: [u32; 7] = [2, 3, 5, 8, 12, 25, 50];

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
pub fn plan(stage: &Stage, wishes: Wishes) -> Result<Plan, PlanError> {
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
    let maker = Maker {
        stage,
        wishes: &wishes,
    };
    if wishes.mode != Mode::Full {
        maker.check_layerable()?;
    }
    let mut periods: Vec<Period> = Vec::new();
    let mut start = first;
    while start <= last {
        let period = maker.next_period(start);
        start += period.len();
        match periods.last_mut() {
            // Whole frames need no décor in common: they are one period, and
            // rendered by the same calls.
            Some(before) if before.whole.is_some() && before.whole == period.whole => {
                before.frames.extend(period.frames);
            }
            _ => periods.push(period),
        }
    }
    Ok(Plan { wishes, periods })
}

struct Maker<'a> {
    stage: &'a Stage,
    wishes: &'a Wishes,
}

impl<'a> Maker<'a> {
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

    fn state(&self, number: u32) -> FrameState<'a> {
        self.stage.film.frame(number)
    }

    /// The period that begins at `start`.
    fn next_period(&self, start: u32) -> Period {
        let last = self.wishes.frames.1;
        if self.wishes.mode == Mode::Full {
            return self.whole(start, last, WholeReason::Asked);
        }
        let first = self.state(start);
        if let Some(what) = &self.stage.surroundings(&first).unlayerable {
            let end = self.run(start, last, |a, b| a.sky == b.sky);
            return self.whole(start, end, WholeReason::Unconfined(what.clone()));
        }
        let stated = |end: u32| match self.wishes.period {
            Some(length) => end.min(start.saturating_add(length - 1)),
            None => end,
        };
        let still = self.run(start, last, |a, b| {
            same_environment(a, b) && a.camera == b.camera
        });
        if still > start || start == last {
            return self.period(start, stated(still));
        }
        let environment = self.run(start, last, same_environment);
        if environment == start {
            let end = self.changing_run(start, last);
            return self.whole(start, end, WholeReason::SurroundingsChange);
        }
        // The observer moves in an environment that stays.
        let end = self.moving_run(start, environment);
        if self.wishes.threshold_px <= 0.0 {
            return self.whole(start, end, WholeReason::ObserverMoves);
        }
        if first.sky.is_some() {
            return self.whole(start, end, WholeReason::SkyMoves);
        }
        if self.wishes.period.is_some() {
            return self.period(start, stated(end));
        }
        self.cheapest_period(start, end)
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

    /// The last frame of a run in which the observer moves from each to the next.
    fn moving_run(&self, start: u32, last: u32) -> u32 {
        let rests = (start..last).find(|&n| self.state(n).camera == self.state(n + 1).camera);
        rests.map_or(last, |n| n.saturating_sub(1).max(start))
    }

    /// The period that costs least per frame, of those that are tried.
    fn cheapest_period(&self, start: u32, end: u32) -> Period {
        let longest = end - start + 1;
        let lengths = LENGTHS.iter().copied().filter(|&l| l <= longest);
        let lengths =
            lengths.chain((longest > 1 && !LENGTHS.contains(&longest)).then_some(longest));
        let tried = lengths.map(|length| {
            let mut period = self.laid(start, start + length - 1);
            let cost = self.cost(&period) / f64::from(length);
            self.give_up_if_dear(&mut period);
            (cost, period)
        });
        let best = tried.min_by(|(a, _), (b, _)| a.total_cmp(b));
        match best {
            Some((_, period)) if period.whole.is_none() => period,
            other => {
                let reason = other.and_then(|(_, period)| period.whole);
                let end = end.min(start + WHOLE_RUN - 1);
                self.whole(start, end, reason.unwrap_or(WholeReason::NoGain))
            }
        }
    }

    /// Frames that are all rendered whole.
    fn whole(&self, start: u32, end: u32, reason: WholeReason) -> Period {
        let mut objects = self.segmented(start, end);
        if reason == WholeReason::SurroundingsChange {
            for object in &mut objects {
                object.class = Class::Fast;
                object.reason = Reason::SurroundingsChange;
            }
        }
        Period {
            start,
            frames: vec![FramePlan::Whole; (end - start + 1) as usize],
            objects,
            whole: Some(reason),
        }
    }

    /// A period with a décor, where one is of use.
    fn period(&self, start: u32, end: u32) -> Period {
        let mut period = self.laid(start, end);
        if period.whole.is_none() {
            self.give_up_if_dear(&mut period);
        }
        period
    }

    /// The classes of the objects over some frames.
    fn segmented(&self, start: u32, end: u32) -> Vec<Segmented> {
        let states: Vec<FrameState<'_>> = (start..=end).map(|n| self.state(n)).collect();
        let rule = Rule {
            threshold_px: self.wishes.threshold_px,
            measure: self.wishes.measure,
            size: self.stage.size(),
        };
        segment(&states, |object| self.stage.prototype(object).bounds, &rule)
    }

    /// A period with its classes, and what is rendered where.
    fn laid(&self, start: u32, end: u32) -> Period {
        let objects = self.segmented(start, end);
        let first = self.state(start);
        let moving = objects.iter().any(|o| o.class == Class::Fast);
        let stays = objects.iter().any(|o| o.class.in_decor());
        let casts = first.shadows && !first.lights.is_empty() && self.abilities().shadows;
        let whole = if !stays && moving {
            Some(WholeReason::NothingStays)
        } else if casts && moving && self.wishes.mode != Mode::Preview {
            Some(WholeReason::Shadows)
        } else {
            None
        };
        let count = (end - start + 1) as usize;
        let mut period = Period {
            start,
            frames: vec![FramePlan::Whole; count],
            objects,
            whole,
        };
        if period.whole.is_none() {
            self.lay(&mut period, &first);
        }
        period
    }

    /// Decides what is rendered where, frame by frame.
    fn lay(&self, period: &mut Period, first: &FrameState<'_>) {
        let classes: HashMap<ObjectId, Class> =
            period.objects.iter().map(|o| (o.object, o.class)).collect();
        // What the décor shows of optical objects has to be drawn over.
        let shown: Vec<Window> = first
            .objects
            .iter()
            .filter(|object| {
                classes
                    .get(&object.id)
                    .is_some_and(|class| class.in_decor())
            })
            .filter(|object| self.is_optical(object))
            .map(|object| self.window(object, first))
            .collect();
        let limit = WORTHWHILE * self.stage.size().pixels() as f64;
        for (number, frame) in (period.start..).zip(&mut period.frames) {
            let layered = self.lay_frame(&self.state(number), &classes, &shown);
            if !self.wishes.fallback || self.frame_cost(&layered) <= limit {
                *frame = layered;
            }
        }
    }

    /// The pixels of colour that a frame is worth.
    fn frame_cost(&self, frame: &FramePlan) -> f64 {
        match frame {
            FramePlan::Whole => self.stage.size().pixels() as f64,
            FramePlan::Layered { fast, blocks } => {
                let fast: usize = fast.iter().map(|window| window.pixels()).sum();
                fast as f64 * (1.0 + DEPTH_SHARE) + blocks.pixels() as f64
            }
        }
    }

    fn cost(&self, period: &Period) -> f64 {
        let all = self.stage.size().pixels() as f64;
        let decor = if period.merges() {
            all * (1.0 + DEPTH_SHARE)
        } else {
            all
        };
        let frames: f64 = period
            .frames
            .iter()
            .map(|frame| self.frame_cost(frame))
            .sum();
        if period.has_decor() {
            decor + frames
        } else {
            frames
        }
    }

    fn give_up_if_dear(&self, period: &mut Period) {
        let all = self.stage.size().pixels() as f64 * f64::from(period.len());
        if self.wishes.fallback && self.cost(period) > WORTHWHILE * all {
            period.frames.fill(FramePlan::Whole);
            period.whole.get_or_insert(WholeReason::NoGain);
        }
    }

    fn window(&self, object: &ObjectState<'_>, state: &FrameState<'_>) -> Window {
        let bounds: Bounds = self.stage.prototype(object).bounds.posed(&object.pose);
        screen_box(&bounds, &state.camera, self.stage.size()).window()
    }

    /// May what is seen of the object depend on the other layer?
    fn is_optical(&self, object: &ObjectState<'_>) -> bool {
        self.abilities().optics
            && self.wishes.mode != Mode::Preview
            && self.stage.prototype(object).optics != Optics::Opaque
    }

    fn lay_frame(
        &self,
        state: &FrameState<'_>,
        classes: &HashMap<ObjectId, Class>,
        shown: &[Window],
    ) -> FramePlan {
        let size = self.stage.size();
        let mut blocks = BlockSet::none(size);
        let mut merged: Vec<Window> = Vec::new();
        // Where nothing moves, mirrors show nothing new.
        let alive = classes
            .values()
            .any(|class| !matches!(class, Class::Immobile));
        // Is what moves drawn from the full scene, and not merged?
        let all_from_scene = self.wishes.mode == Mode::Exact || self.no_coverage(state);
        for object in &state.objects {
            let is_fast = classes.get(&object.id) == Some(&Class::Fast);
            let optical = self.is_optical(object);
            if !(is_fast || optical && alive) {
                continue;
            }
            let window = self.window(object, state);
            if optical || all_from_scene {
                blocks.insert(window);
            }
            let is_merged = !optical && !all_from_scene || self.wishes.with_depth;
            if is_fast && is_merged {
                merged.push(window);
            }
        }
        if alive {
            for window in shown {
                blocks.insert(*window);
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

//! A period of a stream: planned on what velocities predict, verified against
//! every frame that arrives.
//!
//! Thesis, III-3-1. What the period's classes promise has to hold for the real
//! frame as it did for the predicted one; the first that does not ends the
//! period, and the frame begins another. So no frame is ever shown with a décor
//! that is not valid for it.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use decor_api::{Bounds, Camera, Layer};

use super::pace::Pace;
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::motion::{Sighting, first_in_view, infinity_px};
use crate::plan::{
    Costs, End, FramePlan, Maker, Mode, Outlines, Period, PlanError, WholeReason, Wishes, jobs,
};
use crate::probe::cores;
use crate::render::PeriodGround;
use crate::segmentation::{Class, Reason, Rule, Segmented, same_environment, segment_towards};
use crate::stage::Stage;

/// Frames that are rendered whole before a décor is tried again, also where
/// nothing turns.
const WHOLE_RUN: u32 = 12;

/// Why a period does not serve a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Over {
    /// It was planned so.
    Planned(End),
    /// The frame is not as predicted: what, and in which way.
    Failed(String),
}

/// The period at hand.
pub struct Open {
    /// Its first frame, and after it what velocities predict.
    pub stage: Arc<Stage>,
    /// Its plan; of its frames the first alone is real. What appears in it is
    /// added to its objects.
    pub period: Period,
    /// The last frame that it may serve; `None`: as long as all is as predicted.
    last: Option<u32>,
    /// Was the observer to stay?
    still: bool,
    /// Its décor, when that is rendered.
    pub decor: Option<Arc<Layer>>,
    /// What its frames begin with, when that is there.
    pub ground: Option<PeriodGround>,
    /// Is what the décor dissolves into part of it?
    pub has_target: bool,
    /// The real frame before the one that arrives.
    before: (Arc<Stage>, u32),
    /// Frames that it has served.
    pub served: u32,
    /// Seconds that they took.
    pub seconds: f64,
}

/// What periods of a stream are planned with.
pub struct Planner<'a> {
    /// The wishes; frames, threshold and budget are not looked at.
    pub wishes: &'a Wishes,
    /// What things cost.
    pub costs: &'a Costs,
    /// How far ahead, and with what threshold.
    pub pace: &'a Pace,
}

impl Planner<'_> {
    fn with<T>(
        &self,
        stage: &Stage,
        frames: (u32, u32),
        threshold_px: f64,
        make: impl FnOnce(&Maker<'_>) -> T,
    ) -> T {
        let wishes = Wishes {
            frames,
            threshold_px,
            budget: None,
            ..self.wishes.clone()
        };
        make(&Maker {
            stage,
            wishes: &wishes,
            costs: self.costs,
            jobs: jobs(stage),
            cores: cores(),
            threshold_px,
            outlines: &Outlines::default(),
            live: true,
        })
    }

    /// The period that begins with the first frame of `stage`, whose later
    /// frames are predictions. `end` is the last frame of all, where it is
    /// known. `changes`: what surrounds the objects is not what it was a frame
    /// before, and is thought to change again.
    pub fn open(
        &self,
        stage: &Arc<Stage>,
        end: Option<u32>,
        changes: bool,
    ) -> Result<Open, PlanError> {
        let (start, last) = (*stage.film.frames().start(), *stage.film.frames().end());
        if start == u32::MAX {
            return Err(PlanError::LastNumber);
        }
        let last = last.min(u32::MAX - 1);
        let period = self.with(stage, (start, last), self.pace.threshold_px, |maker| {
            if changes && self.wishes.mode != Mode::Full {
                let end = End::SurroundingsChange;
                return maker.whole((start, start), end, WholeReason::SurroundingsChange);
            }
            let period = maker.next_period(start);
            if period.whole.is_some() || period.numbers().end <= last || last == start {
                return period;
            }
            if end == Some(last) {
                return period;
            }
            // A frame is left over for the décor to dissolve towards.
            let mut period = maker.laid((start, last - 1), self.usual_end());
            maker.give_up_if_dear(&mut period, true);
            period
        });
        let first = stage.film.frame(start);
        let still = last > start && stage.film.frame(start + 1).camera == first.camera;
        let planned = period.numbers().end - 1;
        Ok(Open {
            last: if period.whole.is_some() {
                Some(planned.min(start.saturating_add(WHOLE_RUN - 1)))
            } else if self.pace.is_free() && still && stays_as_it_is(&period) {
                None
            } else {
                Some(planned)
            },
            still,
            decor: None,
            ground: None,
            has_target: false,
            before: (Arc::clone(stage), start),
            served: 0,
            seconds: 0.0,
            stage: Arc::clone(stage),
            period,
        })
    }

    /// Why a period ends where it was planned to.
    fn usual_end(&self) -> End {
        if self.pace.is_free() {
            End::Cheapest
        } else {
            End::Asked
        }
    }

    /// Can every description that the stage names be put into a layer?
    pub fn check(&self, stage: &Stage) -> Result<(), PlanError> {
        if self.wishes.mode == Mode::Full {
            return Ok(());
        }
        let frames = (*stage.film.frames().start(), *stage.film.frames().end());
        self.with(stage, frames, 0.0, |maker| maker.check_layerable())
    }

    /// What is rendered where in the first frame of `stage`, which `open` is to
    /// serve: a period of that frame alone.
    pub fn serve(&self, open: &mut Open, stage: &Arc<Stage>) -> Result<Period, Over> {
        let number = *stage.film.frames().start();
        let now = stage.film.frame(number);
        if number == open.period.start {
            return Ok(Period {
                frames: open.period.frames[..1].to_vec(),
                ..open.period.clone()
            });
        }
        if open.last.is_some_and(|last| number > last) {
            let end = match open.period.end {
                // The prediction ends there; the stream does not.
                End::Done => self.usual_end(),
                end => end,
            };
            return Err(Over::Planned(end));
        }
        let (before, number_before) = &open.before;
        let before = before.film.frame(*number_before);
        let appeared = if open.period.whole.is_some() {
            open.turned(&before, &now)?;
            Vec::new()
        } else {
            open.verify(stage, &before, &now, self.wishes)?
        };
        let mut frame = Period {
            start: number,
            frames: vec![FramePlan::Whole],
            ..open.period.clone()
        };
        frame.objects.extend(appeared.iter().cloned());
        if frame.whole.is_none() {
            let first = open.stage.film.frame(open.period.start);
            let threshold_px = open.period.threshold_px;
            self.with(stage, (number, number), threshold_px, |maker| {
                maker.lay(&mut frame, &first);
            });
            open.can_show(&frame)?;
        }
        open.period.objects.extend(appeared);
        open.before = (Arc::clone(stage), number);
        Ok(frame)
    }
}

/// Can the period go on for as long as everything is as predicted? Where
/// nothing moves there is nothing to dissolve, and nothing to look at again.
fn stays_as_it_is(period: &Period) -> bool {
    let rests = |o: &Segmented| matches!(o.class, Class::Immobile | Class::Clipped);
    period.sky.is_none() && period.dissolve_until.is_none() && period.objects.iter().all(rests)
}

impl Open {
    /// The frames of a period without a décor are right whatever happens; but
    /// where something turns, a décor may be of use again.
    fn turned(&self, before: &FrameState<'_>, now: &FrameState<'_>) -> Result<(), Over> {
        let course = |state: &FrameState<'_>| {
            let objects = state.objects.iter();
            let objects: Vec<_> = objects.map(|o| (o.id, o.description, o.motion)).collect();
            (state.eye_velocity, state.aim_velocity, objects)
        };
        if !same_environment(before, now) || course(before) != course(now) {
            return Err(Over::Failed("what moves has turned".into()));
        }
        Ok(())
    }

    /// Is the real frame `now` as the period's classes promise? Gives what has
    /// appeared in it.
    fn verify(
        &self,
        stage: &Stage,
        before: &FrameState<'_>,
        now: &FrameState<'_>,
        wishes: &Wishes,
    ) -> Result<Vec<Segmented>, Over> {
        let failed = |what: &str| Err(Over::Failed(what.into()));
        let first = self.stage.film.frame(self.period.start);
        let until = self.period.dissolve_until;
        let target = until.map(|until| self.stage.film.frame(until));
        if !same_environment(&first, now) {
            return failed("a light, the background or the sky is another");
        }
        if !stage.same_props(&self.stage) {
            return failed("a file of the stream is another");
        }
        let opening = |camera: &Camera| (camera.half_width, camera.half_height);
        if opening(&first.camera) != opening(&now.camera) {
            return failed("the opening of the view is another");
        }
        if self.still && first.camera != now.camera {
            return failed("the observer moves");
        }
        let rule = Rule {
            threshold_px: self.period.threshold_px,
            measure: wishes.measure,
            size: stage.size(),
        };
        if stage.has_shadows(now)
            && wishes.mode != Mode::Preview
            && let Some(name) = self.shadow_moves(&first, now)
        {
            return Err(Over::Failed(format!("{name} moves, and its shadow")));
        }
        if !self.sky_holds(&first, now, target.as_ref(), &rule) {
            return failed("the sky moves farther in the picture");
        }
        let bounds = |object: &ObjectState<'_>| stage.prototype(object).bounds;
        let pair = [first, now.clone()];
        let found = segment_towards(&pair, target.as_ref(), bounds, &rule);
        let promised: HashMap<ObjectId, Class> = self
            .period
            .objects
            .iter()
            .map(|o| (o.object, o.class))
            .collect();
        let mut appeared = Vec::new();
        for object in found {
            let Some(&class) = promised.get(&object.object) else {
                appeared.push(object);
                continue;
            };
            let keeps = match class {
                Class::Fast => true,
                Class::Immobile => object.class == Class::Immobile,
                Class::Slow => object.class != Class::Fast,
                Class::Clipped => {
                    matches!(object.class, Class::Clipped | Class::Immobile)
                        || stays_out(stage, object.object, before, now)
                }
            };
            if !keeps {
                let name = stage.film.identity(object.object).name();
                let does = what_it_does(class, &object.reason);
                return Err(Over::Failed(format!("{name} {does}")));
            }
        }
        // Where nothing was to move, nothing was prepared for what does.
        if let Some(new) = appeared.first()
            && self.period.count(Class::Fast) == 0
        {
            let name = stage.film.identity(new.object).name();
            return Err(Over::Failed(format!("{name} appears")));
        }
        Ok(appeared)
    }

    /// An object that the décor has the shadow of, and that is not where it was.
    fn shadow_moves<'f>(&self, first: &FrameState<'f>, now: &FrameState<'_>) -> Option<&'f str> {
        let objects = self.period.objects.iter();
        let resting: HashSet<ObjectId> = objects
            .filter(|o| !self.period.is_moving(o) && o.reason != Reason::Empty)
            .map(|o| o.object)
            .collect();
        let now: HashMap<ObjectId, &ObjectState<'_>> =
            now.objects.iter().map(|o| (o.id, o)).collect();
        let mut objects = first.objects.iter().filter(|o| resting.contains(&o.id));
        let moved = objects.find(|before| {
            now.get(&before.id)
                .is_none_or(|now| (now.pose, now.description) != (before.pose, before.description))
        });
        moved.map(|object| object.name)
    }

    fn sky_holds(
        &self,
        first: &FrameState<'_>,
        now: &FrameState<'_>,
        target: Option<&FrameState<'_>>,
        rule: &Rule,
    ) -> bool {
        if first.sky.is_none() {
            return true;
        }
        let limit_px = match self.period.sky.map(|sky| sky.class) {
            // Drawn anew in every frame.
            Some(Class::Fast) => return true,
            Some(Class::Slow) => rule.threshold_px,
            Some(_) => 0.0,
            None => return first.camera == now.camera,
        };
        let moved = infinity_px(&first.camera, &now.camera, rule.size);
        let onward = target.map_or(0.0, |t| infinity_px(&now.camera, &t.camera, rule.size));
        moved <= limit_px && onward <= limit_px
    }

    /// Was the depth that a frame needs rendered with the décor?
    fn can_show(&self, frame: &Period) -> Result<(), Over> {
        let has_depth = self.decor.as_ref().is_some_and(|d| d.depth.is_some());
        let layered = matches!(frame.frames[0], FramePlan::Layered { .. });
        if layered && self.decor.is_none() || frame.needs_depth() && !has_depth {
            return Err(Over::Failed("something comes into view".into()));
        }
        Ok(())
    }

    /// Goes on with the period that would follow: both render whole frames.
    pub fn go_on_as(&mut self, next: Self) {
        self.last = next.last;
        self.stage = next.stage;
        self.before = next.before;
        self.still = next.still;
    }

    /// The décor of the period before, where that shows what this one's has to.
    pub fn take_decor_of(&mut self, earlier: &Self, with_depth: bool) {
        let Some(decor) = &earlier.decor else { return };
        let (then, now) = (
            earlier.stage.film.frame(earlier.period.start),
            self.stage.film.frame(self.period.start),
        );
        let needs_depth = self.period.needs_depth() || with_depth;
        let shown = |open: &Self, state: &FrameState<'_>| -> Vec<_> {
            let kept: HashSet<ObjectId> = open
                .period
                .objects
                .iter()
                .filter(|o| o.class.in_decor())
                .map(|o| o.object)
                .collect();
            let in_light = |id| kept.contains(id) || open.period.resting.contains(id);
            let objects = state.objects.iter().filter(|o| in_light(&o.id));
            objects
                .map(|o| (o.id, o.description, o.pose, kept.contains(&o.id)))
                .collect()
        };
        if self.period.has_decor()
            && (decor.depth.is_some() || !needs_depth)
            && then.camera == now.camera
            && same_environment(&then, &now)
            && self.stage.same_props(&earlier.stage)
            && shown(earlier, &then) == shown(self, &now)
        {
            self.decor = Some(Arc::clone(decor));
        }
    }
}

/// Is an object that was out of view `before` out of view `now` as well, and on
/// the way? One that is not there any more, or has another description, is not.
fn stays_out(stage: &Stage, id: ObjectId, before: &FrameState<'_>, now: &FrameState<'_>) -> bool {
    let find = |state: &FrameState<'_>| {
        let object = state.objects.iter().find(|object| object.id == id)?;
        Some((
            object.description,
            object.pose,
            stage.prototype(object).bounds,
        ))
    };
    let (Some((then, pose_before, _)), Some((description, pose, bounds))) =
        (find(before), find(now))
    else {
        return false;
    };
    let way = [(before.camera, pose_before), (now.camera, pose)]
        .map(|(camera, pose)| Sighting { camera, pose });
    description == then
        && match bounds {
            Bounds::Empty => true,
            Bounds::Unbounded => false,
            Bounds::Sphere(sphere) => first_in_view(way, &sphere, stage.size()).is_none(),
        }
}

fn what_it_does(promised: Class, reason: &Reason) -> String {
    match (promised, reason) {
        (Class::Immobile, Reason::MovesLittle { .. } | Reason::OutOfView) => "moves".into(),
        (Class::Clipped, Reason::MovesLittle { .. } | Reason::MovesFar { .. }) => {
            "comes into view".into()
        }
        (_, reason) => reason.to_string(),
    }
}

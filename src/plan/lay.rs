//! What is rendered where in the frames of one period.

use std::collections::{HashMap, HashSet};

use decor_api::{Bounds, Optics, Window};

use super::islands::islands;
use super::make::Maker;
use super::screened::Screens;
use super::ways::Way;
use super::windows::gathered;
use super::{BlockSet, End, FramePlan, Mode, Period, ShadowPlan, SkyMotion, WholeReason};
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::influence::{Changed, estimated_shadows};
use crate::motion::infinity_px;
use crate::segmentation::{Class, Reason, Rule, Segmented, same_environment, segment_towards};

/// A layered frame traces its windows twice, for colour and for depth; depth
/// rays are cheap. Above this share of a frame's pixels nothing is won.
const WORTHWHILE: f64 = 0.9;

/// The cost of a depth ray, as a share of a colour ray's.
const DEPTH_SHARE: f64 = 0.4;

/// The cost of a ray that meets the sky alone, as a share of another's.
const SKY_SHARE: f64 = 0.4;

impl Maker<'_> {
    /// Frames that are all rendered whole.
    pub fn whole(&self, (start, last): (u32, u32), end: End, reason: WholeReason) -> Period {
        let mut objects = self.segmented(start, last, None);
        if reason == WholeReason::SurroundingsChange {
            for object in &mut objects {
                object.class = Class::Fast;
                object.reason = Reason::SurroundingsChange;
            }
        }
        Period {
            start,
            frames: vec![FramePlan::Whole; (last - start + 1) as usize],
            objects,
            resting: HashSet::new(),
            threshold_px: self.threshold_px,
            still: false,
            before: false,
            sky: None,
            dissolve_until: None,
            end,
            whole: Some(reason),
        }
    }

    /// A period with a décor, where one is of use.
    pub fn period(&self, frames: (u32, u32), end: End) -> Period {
        if frames.0 == frames.1 && self.wishes.fallback {
            // A décor for one frame is that frame.
            return self.whole(frames, end, WholeReason::NoGain);
        }
        let mut period = self.laid(frames, end);
        // Where the observer rests, the period is the film or a long part of it.
        self.give_up_if_dear(&mut period, true);
        period
    }

    /// The classes of the objects over some frames.
    fn segmented(&self, start: u32, last: u32, target: Option<u32>) -> Vec<Segmented> {
        let states: Vec<FrameState<'_>> = (start..=last).map(|n| self.state(n)).collect();
        let target = target.map(|n| self.state(n));
        let rule = Rule {
            threshold_px: self.threshold_px,
            measure: self.wishes.measure,
            size: self.stage.size(),
        };
        let bounds = |object: &ObjectState<'_>| self.stage.prototype(object).bounds;
        let mut objects = segment_towards(&states, target.as_ref(), bounds, &rule);
        if self.casts(&states[0]) {
            self.follow_shadows(&states, &mut objects);
        }
        objects
    }

    /// Do shadows fall, and does the mode care?
    pub fn casts(&self, state: &FrameState<'_>) -> bool {
        self.stage.has_shadows(state) && self.wishes.mode != Mode::Preview
    }

    /// What moves under lights is not kept, however little it moves in the
    /// picture: nobody knows how far its shadow does.
    fn follow_shadows(&self, states: &[FrameState<'_>], objects: &mut [Segmented]) {
        let first: HashMap<ObjectId, &ObjectState<'_>> =
            states[0].objects.iter().map(|o| (o.id, o)).collect();
        let moving: HashSet<ObjectId> = states[1..]
            .iter()
            .flat_map(|state| &state.objects)
            .filter(|object| {
                let before = first.get(&object.id);
                before.is_none_or(|before| before.pose != object.pose)
            })
            .map(|object| object.id)
            .collect();
        for object in objects {
            let kept = matches!(object.class, Class::Clipped | Class::Slow);
            if kept && object.reason != Reason::Empty && moving.contains(&object.object) {
                object.class = Class::Fast;
                object.reason = Reason::ShadowMoves;
            }
        }
    }

    /// The fast objects that are the same in all these frames: only the observer
    /// moves. The décor can have their shadows once and for all, where the renderer
    /// draws shadows of what is not seen.
    fn resting(
        &self,
        (start, last): (u32, u32),
        target: Option<u32>,
        objects: &[Segmented],
    ) -> HashSet<ObjectId> {
        let first = self.state(start);
        let observer_moves = || (start..=last).any(|n| self.state(n).camera != first.camera);
        let is_of_use = self.wishes.mode == Mode::Equivalent
            && self.casts(&first)
            && self.abilities().hidden_casters
            && observer_moves();
        if !is_of_use {
            return HashSet::new();
        }
        let fast = objects.iter().filter(|o| o.class == Class::Fast);
        let fast: HashSet<ObjectId> = fast.map(|o| o.object).collect();
        let as_at_first = first.objects.iter().filter(|o| fast.contains(&o.id));
        let mut resting: HashMap<ObjectId, &ObjectState<'_>> =
            as_at_first.map(|o| (o.id, o)).collect();
        for number in (start + 1..=last).chain(target) {
            let state = self.state(number);
            let now: HashMap<ObjectId, &ObjectState<'_>> =
                state.objects.iter().map(|o| (o.id, o)).collect();
            resting.retain(|id, before| {
                now.get(id).is_some_and(|now| {
                    (now.pose, now.description) == (before.pose, before.description)
                })
            });
        }
        resting.into_keys().collect()
    }

    /// The frame whose poses a décor of `start` dissolves towards: the first one
    /// after the period, where that shows the same surroundings; else the
    /// period's last. None where nothing follows that the eye could compare.
    fn target(&self, start: u32, last: u32) -> Option<u32> {
        let next = last + 1;
        let dissolves = self.wishes.mode == Mode::Equivalent && self.threshold_px > 0.0;
        if !dissolves || last == start || next > self.wishes.frames.1 {
            return None;
        }
        let (first, after) = (self.state(start), self.state(next));
        if !same_environment(&first, &after) {
            return None;
        }
        let stays = (start..=last).all(|n| self.state(n).camera == first.camera);
        let goes_on = if stays {
            after.camera == first.camera
        } else {
            !zooms(&self.state(last), &after) || zooms(&first, &self.state(start + 1))
        };
        Some(if goes_on { next } else { last })
    }

    /// How far the sky moves, where there is one and the observer moves.
    fn sky_motion(&self, start: u32, last: u32, target: Option<u32>) -> Option<SkyMotion> {
        let first = self.state(start);
        first.sky?;
        let cameras = (start..=last).chain(target).map(|n| self.state(n).camera);
        let cameras: Vec<_> = cameras.collect();
        if cameras.iter().all(|camera| *camera == first.camera) {
            return None;
        }
        let moved = |from: &decor_api::Camera| {
            let moved = cameras
                .iter()
                .map(|to| infinity_px(from, to, self.stage.size()));
            moved.fold(0.0, f64::max)
        };
        // While the décor dissolves, from each frame to the target too.
        let onward = target.map(|n| moved(&self.state(n).camera));
        let motion_px = moved(&first.camera).max(onward.unwrap_or(0.0));
        let class = if motion_px == 0.0 {
            Class::Immobile
        } else if motion_px <= self.threshold_px {
            Class::Slow
        } else {
            Class::Fast
        };
        Some(SkyMotion { class, motion_px })
    }

    /// A period with its classes, and what is rendered where.
    pub fn laid(&self, (start, last): (u32, u32), end: End) -> Period {
        let target = self.target(start, last);
        let objects = self.segmented(start, last, target);
        let first = self.state(start);
        let sky = self.sky_motion(start, last, target);
        let sky_moves = sky.is_some_and(|sky| sky.class == Class::Fast);
        let moving = sky_moves || objects.iter().any(|o| o.class == Class::Fast);
        let stays = objects.iter().any(|o| o.class.in_decor());
        let resting = self.resting((start, last), target, &objects);
        let casts = self.casts(&first)
            && objects
                .iter()
                .any(|o| o.class == Class::Fast && !resting.contains(&o.object));
        let whole = if !stays && moving {
            Some(WholeReason::NothingStays)
        } else if casts && !self.stage.draws_blocks() {
            Some(WholeReason::Shadows)
        } else if moving && self.wishes.mode == Mode::Exact && !self.stage.draws_blocks() {
            Some(WholeReason::NoParts)
        } else if casts && self.endless_moves(&objects, &resting, &first) {
            Some(WholeReason::Unconfined("something without an end".into()))
        } else if sky_moves && self.stage.antialias().is_some() {
            // Pixels that are half sky are neither's.
            Some(WholeReason::SkyMoves)
        } else {
            None
        };
        let slow = objects.iter().any(|o| o.class == Class::Slow)
            || sky.is_some_and(|sky| sky.class == Class::Slow);
        let rests = (start..=last).all(|n| self.state(n).camera == first.camera);
        let still = rests && !slow;
        let count = (last - start + 1) as usize;
        let mut period = Period {
            start,
            frames: vec![FramePlan::Whole; count],
            objects,
            resting,
            threshold_px: self.threshold_px,
            still,
            before: false,
            sky,
            dissolve_until: target.filter(|_| slow && whole.is_none()),
            end,
            whole,
        };
        if period.whole.is_none() {
            self.lay(&mut period, &first);
        }
        period
    }

    /// Is there something without an end among what moves in the world?
    fn endless_moves(
        &self,
        objects: &[Segmented],
        resting: &HashSet<ObjectId>,
        first: &FrameState<'_>,
    ) -> bool {
        let endless = |id: ObjectId| {
            let object = first.objects.iter().find(|object| object.id == id);
            object.is_none_or(|o| self.stage.prototype(o).bounds == Bounds::Unbounded)
        };
        // What is not there at first is looked at by its identity's description.
        let mut fast = objects
            .iter()
            .filter(|o| o.class == Class::Fast && !resting.contains(&o.object));
        fast.any(|o| {
            if first.objects.iter().any(|object| object.id == o.object) {
                endless(o.object)
            } else {
                let description = self.stage.film.identity(o.object).description();
                let path = self.stage.film.descriptions()[description.0 as usize].path();
                let prototype = self.stage.library.by_path[path];
                self.stage.library.table.get(prototype).bounds == Bounds::Unbounded
            }
        })
    }

    /// Plans the frames of a period in one way, where that is worth while.
    pub fn lay_by(&self, period: &mut Period, first: &FrameState<'_>, way: Way) {
        let classes = period.classes();
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
            .flat_map(|object| self.stage.silhouette(object, &first.camera))
            .collect();
        let sky_moves = period.sky.is_some_and(|sky| sky.class == Class::Fast);
        let limit = WORTHWHILE * self.stage.size().pixels() as f64;
        for (number, frame) in (period.start..).zip(&mut period.frames) {
            let state = self.state(number);
            let layered = self.lay_frame(&state, &classes, &period.resting, &shown, sky_moves, way);
            let Some(layered) = layered else { continue };
            if !self.wishes.fallback || self.frame_cost(&layered) <= limit {
                *frame = layered;
            }
        }
    }

    /// The pixels of colour that a frame is worth.
    fn frame_cost(&self, frame: &FramePlan) -> f64 {
        match frame {
            FramePlan::Whole => self.stage.size().pixels() as f64,
            FramePlan::Layered {
                fast,
                blocks,
                sky,
                shadows,
            } => {
                let fast: usize = fast.iter().map(|window| window.pixels()).sum();
                let sky = if *sky { SKY_SHARE } else { 0.0 };
                fast as f64 * (1.0 + DEPTH_SHARE)
                    + block_pixels(blocks, *shadows)
                    + self.stage.size().pixels() as f64 * sky
            }
        }
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
        resting: &HashSet<ObjectId>,
        shown: &[Window],
        sky: bool,
        way: Way,
    ) -> Option<FramePlan> {
        let size = self.stage.size();
        let mut blocks = self.stage.no_blocks(self.wishes);
        let mut merged: Vec<Window> = Vec::new();
        // Where nothing moves, mirrors show nothing new.
        let alive = classes
            .values()
            .any(|class| !matches!(class, Class::Immobile));
        // Is what moves drawn from the full scene, and not merged?
        let casts = self.casts(state)
            && classes
                .iter()
                .any(|(id, class)| *class == Class::Fast && !resting.contains(id));
        let all_from_scene = way != Way::Merged || self.all_from_scene(state, classes, casts);
        for object in &state.objects {
            let is_fast = classes.get(&object.id) == Some(&Class::Fast);
            let optical = self.is_optical(object);
            if !(is_fast || optical && alive) {
                continue;
            }
            let seen = self.outlines.of(self.stage, object, state);
            let window = seen.iter().copied().fold(Window::EMPTY, Window::union);
            if optical || all_from_scene {
                blocks.insert_all(seen.iter().copied());
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
        if !blocks.is_empty() && !self.stage.draws_blocks() {
            return None;
        }
        if way == Way::Islands {
            blocks = islands(self.stage, state, classes, self.threshold_px, blocks)?;
        }
        let shadows = if casts {
            Some(ShadowPlan {
                expected_pixels: self.shadow_pixels(state, classes, resting, &blocks),
                replaces_boxes: all_from_scene,
                by_map: !all_from_scene && self.by_map(state),
            })
        } else if way == Way::ByDepth && !blocks.is_empty() {
            let screens = Screens::of(self.stage, state, classes);
            let (seen, all) = screens.seen(self.stage, state, classes, self.wishes);
            let hidden = (all.pixels() - seen.pixels()) as f64;
            Some(ShadowPlan {
                expected_pixels: blocks.pixels() as f64 - hidden,
                replaces_boxes: true,
                by_map: false,
            })
        } else {
            None
        };
        Some(FramePlan::Layered {
            fast: gathered(&merged, size, state.antialias.is_some()),
            blocks,
            sky,
            shadows,
        })
    }

    /// About how many pixels the blocks have with those that what moves may shade.
    fn shadow_pixels(
        &self,
        state: &FrameState<'_>,
        classes: &HashMap<ObjectId, Class>,
        resting: &HashSet<ObjectId>,
        blocks: &BlockSet,
    ) -> f64 {
        let (mut changed, mut decor) = (Vec::new(), Vec::new());
        for object in &state.objects {
            let prototype = self.stage.prototype(object);
            if classes
                .get(&object.id)
                .is_some_and(|class| class.in_decor())
            {
                decor.push(prototype.bounds.posed(&object.pose));
            } else if !resting.contains(&object.id) {
                let parts = self.stage.parts(object);
                changed.push(Changed::placed(prototype, parts, &object.pose));
            }
        }
        let size = self.stage.size();
        let (lights, blocks) = (state.lights, blocks.clone());
        let shaded = estimated_shadows(&state.camera, size, lights, &changed, &decor, blocks);
        shaded.pixels() as f64
    }
}

/// Pixels of the blocks of a frame, as far as they are known.
pub fn block_pixels(blocks: &BlockSet, shadows: Option<ShadowPlan>) -> f64 {
    shadows.map_or(blocks.pixels() as f64, |shadows| shadows.expected_pixels)
}

/// Does the opening of the view change between two frames?
pub fn zooms(a: &FrameState<'_>, b: &FrameState<'_>) -> bool {
    (a.camera.half_width, a.camera.half_height) != (b.camera.half_width, b.camera.half_height)
}

//! The ways in which what is fast comes into the frames of a period: which of them
//! are possible, and which costs least.

use std::collections::HashMap;

use decor_api::Optics;

use super::make::Maker;
use super::screened::Screens;
use super::{FramePlan, Mode, Period, ShadowWay};
use crate::film::{FrameState, ObjectId};
use crate::influence::{Changed, Depths, Order, Still};
use crate::segmentation::Class;

/// How fast objects come into a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// Rendered by themselves, and merged by depth, but for what cannot be.
    Merged,
    /// In blocks from the full scene that split no object.
    Islands,
    /// In blocks from the full scene, where the décor's depth shows that something
    /// fast can be seen: none where it is hidden.
    ByDepth,
}

impl Maker<'_> {
    /// Decides what is rendered where, frame by frame: the fast objects merged, or
    /// blocks around them from the full scene, where that costs less.
    pub fn lay(&self, period: &mut Period, first: &FrameState<'_>) {
        let whole = period.frames.clone();
        self.lay_by(period, first, Way::Merged);
        period.before = self.is_before(period, first);
        let ways = [
            (Way::Islands, self.may_have_islands(period, first)),
            (Way::ByDepth, self.may_be_by_depth(period, first)),
        ];
        for (way, _) in ways.into_iter().filter(|(_, may)| *may) {
            let mut other = Period {
                frames: whole.clone(),
                before: false,
                ..period.clone()
            };
            self.lay_by(&mut other, first, way);
            let mut laid = other.frames.iter().filter(|f| **f != FramePlan::Whole);
            if laid.next().is_some() && self.weight(&other, false) < self.weight(period, false) {
                *period = other;
            }
        }
    }

    /// Is all that is merged nearer than whatever of the décor it is seen over? Only
    /// where the décor is still, and coverage tells what is there.
    fn is_before(&self, period: &Period, first: &FrameState<'_>) -> bool {
        let by_coverage = |frame: &FramePlan| {
            matches!(
                frame,
                FramePlan::Layered {
                    sky: false,
                    shadows: None,
                    ..
                }
            )
        };
        let merges = |frame: &FramePlan| matches!(frame, FramePlan::Layered { fast, .. } if !fast.is_empty());
        let frames = &period.frames;
        let can = period.still
            && !self.live
            && !self.wishes.with_depth
            && self.abilities().coverage
            && !self.stage.surroundings(first).sky_on_objects;
        if !can || !frames.iter().any(merges) || !frames.iter().all(by_coverage) {
            return false;
        }
        let still = Still {
            camera: &first.camera,
            size: self.stage.size(),
            lights: &[],
            shadows: false,
            antialiased: first.antialias.is_some(),
            by_blocks: None,
            depths: Depths::unknown(),
            optical: &[],
            slender: &[],
        };
        let classes = period.classes();
        let in_decor = |id: &ObjectId| {
            classes
                .get(id)
                .is_some_and(|class: &Class| class.in_decor())
        };
        let decor = first.objects.iter().filter(|object| in_decor(&object.id));
        let decor: Vec<Changed> = decor.map(|object| self.stage.changed(object)).collect();
        let mut order = Order::of(&still, &decor);
        (period.start..).zip(frames).all(|(number, frame)| {
            let FramePlan::Layered { fast, .. } = frame else {
                return true;
            };
            let state = self.state(number);
            let mut moving = state.objects.iter().filter(|o| !in_decor(&o.id));
            fast.is_empty()
                || moving.all(|object| {
                    let front = [self.stage.changed(object)];
                    let is_solid = self.stage.prototype(object).optics == Optics::Opaque;
                    let seen = self.outlines.of(self.stage, object, &state);
                    is_solid && seen.iter().all(|&w| order.is_before(&still, &front, w))
                })
        })
    }

    /// May what is fast be hidden by the décor, so that its depth tells where blocks
    /// are not needed?
    fn may_be_by_depth(&self, period: &Period, first: &FrameState<'_>) -> bool {
        let changes = |frame: &FramePlan| {
            matches!(frame, FramePlan::Layered { fast, blocks, shadows: None, .. }
                if !fast.is_empty() || !blocks.is_empty())
        };
        let can = period.still
            && self.wishes.mode != Mode::Preview
            && !self.wishes.with_depth
            && first.antialias.is_none()
            && self.stage.draws_blocks();
        if !can || !period.frames.iter().any(changes) {
            return false;
        }
        let classes = period.classes();
        let last = period.numbers().end - 1;
        // Some frames tell, as a rule.
        [period.start, period.start.midpoint(last), last]
            .iter()
            .any(|&number| {
                let state = self.state(number);
                let screens = Screens::of(self.stage, &state, &classes);
                let (seen, all) = screens.seen(self.stage, &state, &classes, self.wishes);
                seen.pixels() < all.pixels()
            })
    }

    /// May fast objects be drawn in blocks from the full scene, although there are
    /// objects in the décor that move?
    fn may_have_islands(&self, period: &Period, first: &FrameState<'_>) -> bool {
        let fast = |frame: &FramePlan| matches!(frame, FramePlan::Layered { fast, .. } if !fast.is_empty());
        if !period.frames.iter().any(fast) {
            return false;
        }
        let moving = || period.objects.iter().any(|object| period.is_moving(object));
        self.wishes.mode == Mode::Equivalent
            && self.abilities().block_mask
            && !self.wishes.with_depth
            && !(self.casts(first) && moving())
            && first.antialias.is_none()
    }

    /// Is what moves drawn from the full scene, in blocks, and not merged?
    ///
    /// - Always in `exact`.
    /// - Where pixels are shared: with antialiasing an edge is neither layer's.
    /// - Under shadows, where the observer rests and nothing in the décor moves:
    ///   the blocks are the renderer's own pixels, and need no second layer with
    ///   its depth and its hidden casters. Where the décor is up to the threshold
    ///   off, blocks would show their borders: there, layers are merged.
    pub fn all_from_scene(
        &self,
        state: &FrameState<'_>,
        classes: &HashMap<ObjectId, Class>,
        casts: bool,
    ) -> bool {
        let shares_pixels = self.wishes.mode == Mode::Equivalent && state.antialias.is_some();
        let rests = !classes.values().any(|class| *class == Class::Slow);
        self.wishes.mode == Mode::Exact
            || shares_pixels
            || casts && rests && !self.by_map(state)
            || self.no_coverage(state)
    }

    /// Are shadow maps made? They keep what is seen of the décor, but asking for
    /// the light at a point costs more than most scenes' pixels do: by themselves
    /// they are chosen where pixels are dear.
    pub fn by_map(&self, state: &FrameState<'_>) -> bool {
        let can = self.abilities().ray_list
            && self.abilities().hidden_casters
            && self.wishes.mode == Mode::Equivalent
            && state.antialias.is_none();
        // Blocks have pixels that are not shaded.
        const AROUND: f64 = 1.5;
        let colour = self.costs.colour;
        let by_blocks = AROUND * (colour.any_s + colour.covered_s);
        let by_map = self.costs.arrival_s * state.lights.len() as f64;
        can && match self.wishes.shadow_way {
            ShadowWay::Auto => by_map < by_blocks,
            ShadowWay::Blocks => false,
            ShadowWay::Map => true,
        }
    }

    /// Is antialiasing on, and coverage not to be had?
    fn no_coverage(&self, state: &FrameState<'_>) -> bool {
        let surroundings = self.stage.surroundings(state);
        state.antialias.is_some() && (surroundings.sky_on_objects || !self.abilities().coverage)
    }
}

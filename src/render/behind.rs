//! Fast objects that the décor hides wholly: they need not be rendered.

use std::collections::HashSet;
use std::ops::Range;

use decor_api::{Bounds, Camera, Sphere};

use super::execution::Execution;
use super::ground::PeriodGround;
use crate::film::{FrameState, ObjectId};
use crate::plan::{FramePlan, Period, Screens};

impl Execution<'_> {
    /// Can the décor hide a fast object of these frames wholly, by where its objects
    /// are? A guess, for the first of the frames: only the décor's depth tells. Where
    /// it may, waiting for that depth may save more than it delays.
    pub fn may_hide(&self, period: &Period, frames: Range<u32>) -> bool {
        let number = frames.start;
        let FramePlan::Layered { fast, .. } = &period.frames[(number - period.start) as usize]
        else {
            return false;
        };
        if !period.merges_by_depth(fast) {
            return false;
        }
        let classes = period.classes();
        let state = self.stage.film.frame(number);
        let screens = Screens::of(self.stage, &state, &classes);
        let is_fast = |id: &ObjectId| classes.get(id).is_none_or(|class| !class.in_decor());
        let mut fast = state.objects.iter().filter(|o| is_fast(&o.id));
        let none = || self.stage.no_blocks(&self.plan.wishes);
        fast.any(|object| screens.may_hide(self.stage, &state, object, none()))
    }

    /// Which of the objects are seen nowhere in a frame, because what the frame
    /// shows of the décor is nearer wherever they are.
    pub fn behind(
        &self,
        state: &FrameState<'_>,
        objects: &HashSet<ObjectId>,
        ground: &PeriodGround,
    ) -> HashSet<ObjectId> {
        let those = state.objects.iter().filter(|o| objects.contains(&o.id));
        let hidden = those.filter(|object| {
            let bounds = self.stage.prototype(object).bounds.posed(&object.pose);
            let Bounds::Sphere(ball) = bounds else {
                return false;
            };
            let near = nearest(&ball, &state.camera);
            let window = self.stage.window(object, &state.camera);
            ground.is_nearer(state.number, window, near)
        });
        hidden.map(|object| object.id).collect()
    }
}

/// How far a ball is, at least.
fn nearest(ball: &Sphere, camera: &Camera) -> f64 {
    let distance = ball.centre.distance(camera.eye);
    // What the coordinates' rounding takes off.
    let slack = 1e-12 * (distance + camera.eye.abs().max_element());
    distance - ball.radius - slack
}

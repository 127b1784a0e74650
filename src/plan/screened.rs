//! What stands before something fast, before any depth is known: for prices only.
//! It is neither conservative nor exact.

use std::collections::HashMap;

use decor_api::Window;

use super::{BlockSet, Wishes};
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::segmentation::Class;
use crate::stage::Stage;

/// With more objects in the décor nobody looks whether one of them hides
/// something: looking would cost more than it wins.
const MOST_OBJECTS: usize = 500;

/// The décor's objects that can hide something: how far the middle of each is, and
/// the rectangles that it is seen in.
pub struct Screens(Vec<(f64, Vec<Window>)>);

impl Screens {
    /// Those of a frame. What has no end hides nothing that is before it, as a rule.
    pub fn of(stage: &Stage, state: &FrameState<'_>, classes: &HashMap<ObjectId, Class>) -> Self {
        let stays = |id: &ObjectId| classes.get(id).is_some_and(|class| class.in_decor());
        let those = || state.objects.iter().filter(|o| stays(&o.id));
        if those().count() > MOST_OBJECTS {
            return Self(Vec::new());
        }
        let screens = those().filter_map(|object| {
            let seen = stage.silhouette(object, &state.camera);
            // Not where its ball begins: a floor's is near everywhere, and hides nothing.
            let (middle, _) = ball(stage, state, object)?;
            Some((middle, seen))
        });
        Self(screens.collect())
    }

    /// Can they hide all of an object? Not where it has no end, or is not seen.
    pub fn may_hide(
        &self,
        stage: &Stage,
        state: &FrameState<'_>,
        object: &ObjectState<'_>,
        mut none: BlockSet,
    ) -> bool {
        let Some((middle, radius)) = ball(stage, state, object) else {
            return false;
        };
        let near = middle - radius;
        let window = stage.window(object, &state.camera);
        if window.is_empty() {
            return false;
        }
        for (_, windows) in self.0.iter().filter(|screen| screen.0 < near) {
            none.insert_all(windows.iter().copied());
        }
        none.contains(window)
    }

    /// About in which blocks what is fast can be seen, and in which it would be if
    /// nothing stood before it.
    pub fn seen(
        &self,
        stage: &Stage,
        state: &FrameState<'_>,
        classes: &HashMap<ObjectId, Class>,
        wishes: &Wishes,
    ) -> (BlockSet, BlockSet) {
        let none = || stage.no_blocks(wishes);
        let (mut seen, mut all) = (none(), none());
        let is_fast = |id: &ObjectId| classes.get(id) == Some(&Class::Fast);
        for object in state.objects.iter().filter(|o| is_fast(&o.id)) {
            let own = stage.silhouette(object, &state.camera);
            all.insert_all(own.iter().copied());
            if !self.may_hide(stage, state, object, none()) {
                seen.insert_all(own);
            }
        }
        (seen, all)
    }
}

/// How far the ball around an object is, and its radius; nothing without an end has
/// one.
fn ball(stage: &Stage, state: &FrameState<'_>, object: &ObjectState<'_>) -> Option<(f64, f64)> {
    let bounds = stage.prototype(object).bounds.posed(&object.pose);
    let ball = bounds.as_sphere()?;
    Some((ball.centre.distance(state.camera.eye), ball.radius))
}

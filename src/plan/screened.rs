//! What stands before something fast, before any depth is known: for prices only.
//! It is neither conservative nor exact.

use std::collections::HashMap;

use decor_api::{Bounds, Camera, Sphere};

use super::{BlockSet, Wishes};
use crate::film::{FrameState, ObjectId};
use crate::motion::screen_box;
use crate::segmentation::Class;
use crate::stage::Stage;

/// With more objects in the décor nobody looks whether one of them hides
/// something: looking would cost more than it wins.
const MOST_OBJECTS: usize = 500;

/// The décor's objects that can hide something: the balls around them.
pub struct Screens(Vec<Sphere>);

impl Screens {
    /// Those of a frame. What has no end hides nothing that is before it, as a rule.
    pub fn of(stage: &Stage, state: &FrameState<'_>, classes: &HashMap<ObjectId, Class>) -> Self {
        let stays = |id: &ObjectId| classes.get(id).is_some_and(|class| class.in_decor());
        let those = state.objects.iter().filter(|o| stays(&o.id));
        let balls = those.filter_map(|object| {
            let bounds = stage.prototype(object).bounds.posed(&object.pose);
            bounds.as_sphere().copied()
        });
        let mut balls: Vec<Sphere> = balls.collect();
        if balls.len() > MOST_OBJECTS {
            balls.clear();
        }
        Self(balls)
    }

    /// The blocks of the boxes around those that begin nearer than a ball.
    pub fn before(&self, ball: &Sphere, camera: &Camera, mut blocks: BlockSet) -> BlockSet {
        let near = |ball: &Sphere| ball.centre.distance(camera.eye) - ball.radius;
        for screen in self.0.iter().filter(|screen| near(screen) < near(ball)) {
            let bounds = Bounds::Sphere(*screen);
            blocks.insert(screen_box(&bounds, camera, blocks.size()).window());
        }
        blocks
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
        let (mut seen, mut all) = (stage.no_blocks(wishes), stage.no_blocks(wishes));
        let is_fast = |id: &ObjectId| classes.get(id) == Some(&Class::Fast);
        for object in state.objects.iter().filter(|o| is_fast(&o.id)) {
            let mut own = stage.no_blocks(wishes);
            own.insert_all(stage.silhouette(object, &state.camera));
            all = all.union(&own);
            let bounds = stage.prototype(object).bounds.posed(&object.pose);
            if let Some(ball) = bounds.as_sphere() {
                own = own.without(&self.before(ball, &state.camera, stage.no_blocks(wishes)));
            }
            seen = seen.union(&own);
        }
        (seen, all)
    }
}

//! The scenes of a décor: who is seen, and in whose shadows.

use std::collections::HashSet;

use decor_api::{Instance, Scene};

use super::execution::Execution;
use crate::casters::casters;
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::plan::{Mode, Period};
use crate::segmentation::Class;

/// What a picture shows, and in whose shadows.
#[derive(PartialEq, Eq)]
pub struct Shown {
    /// The objects that are seen.
    pub drawn: HashSet<ObjectId>,
    /// Those that stand in the light: the drawn ones, and others.
    pub lit_among: HashSet<ObjectId>,
}

impl Shown {
    /// By a period's décor: with the shadows of all that rests.
    pub fn by(period: &Period) -> Self {
        let drawn = decor_objects(period);
        Self {
            lit_among: drawn.union(&period.resting).copied().collect(),
            drawn,
        }
    }

    /// Some of the objects, in the same light.
    pub fn only(&self, drawn: impl IntoIterator<Item = ObjectId>) -> Self {
        Self {
            drawn: drawn.into_iter().collect(),
            lit_among: self.lit_among.clone(),
        }
    }
}

/// The objects of a period's décor.
pub fn decor_objects(period: &Period) -> HashSet<ObjectId> {
    let kept = period.objects.iter().filter(|o| o.class.in_decor());
    kept.map(|o| o.object).collect()
}

impl Execution<'_> {
    /// Some objects of a frame, in the light that they stand in.
    pub fn decor_scene(&self, state: &FrameState<'_>, shown: &Shown) -> Scene {
        let drawn = &shown.drawn;
        let mut scene = self.stage.scene(state, |o| drawn.contains(&o.id));
        scene.hidden = self.hidden(state, drawn, |o| {
            shown.lit_among.contains(&o.id) && !drawn.contains(&o.id)
        });
        scene
    }

    /// What a period's décor has turned into in frame `until`. What stands still
    /// in the period stays where it is there.
    pub fn target_scene(&self, period: &Period, until: u32) -> Scene {
        let objects = decor_objects(period);
        let (before, after) = (
            self.stage.film.frame(period.start),
            self.stage.film.frame(until),
        );
        let still: HashSet<ObjectId> = period
            .objects
            .iter()
            .filter(|o| o.class == Class::Immobile)
            .map(|o| o.object)
            .collect();
        let mut scene = self.stage.scene(&after, |object| {
            objects.contains(&object.id) && !still.contains(&object.id)
        });
        let rest = self
            .stage
            .scene(&before, |object| still.contains(&object.id));
        scene.instances.extend(rest.instances);
        scene.hidden = self.hidden(&before, &objects, |o| period.resting.contains(&o.id));
        scene
    }

    /// Those of `unseen` that may shade what is drawn of a frame, where the mode
    /// cares.
    pub fn hidden(
        &self,
        state: &FrameState<'_>,
        drawn: &HashSet<ObjectId>,
        unseen: impl Fn(&ObjectState<'_>) -> bool,
    ) -> Vec<Instance> {
        if self.plan.wishes.mode == Mode::Preview {
            return Vec::new();
        }
        let is_drawn = |object: &ObjectState<'_>| drawn.contains(&object.id);
        let found = casters(self.stage, state, is_drawn, unseen).into_iter();
        found.map(|object| self.stage.instance(object)).collect()
    }
}

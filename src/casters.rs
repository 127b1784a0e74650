//! Who casts shadows in a layer without being seen there.

use decor_api::{Bounds, Instance};

use crate::film::{FrameState, ObjectState};
use crate::influence::may_shade;
use crate::stage::Stage;

/// Pairs of objects that are looked at: with more of them, all objects may cast.
/// Looking would take longer than the renderer needs for reading them.
const MOST_PAIRS: usize = 4_000_000;

/// Those `unseen` objects of a frame that can stand between a light and one that is
/// `drawn`. None where no shadow falls, or where the renderer has no objects that
/// only cast.
pub fn casters<'s, 'f>(
    stage: &Stage,
    state: &'s FrameState<'f>,
    drawn: impl Fn(&ObjectState<'_>) -> bool,
    unseen: impl Fn(&ObjectState<'_>) -> bool,
) -> Vec<&'s ObjectState<'f>> {
    if !stage.has_shadows(state) || !stage.adapter.abilities().hidden_casters {
        return Vec::new();
    }
    let bounds = |object: &ObjectState<'_>| stage.prototype(object).bounds.posed(&object.pose);
    let objects = state.objects.iter();
    let mut found: Vec<&ObjectState<'_>> = objects.filter(|object| unseen(object)).collect();
    let receivers = state.objects.iter().filter(|object| drawn(object));
    let receivers: Vec<Bounds> = receivers.map(bounds).collect();
    if found.len() * receivers.len() * state.lights.len() <= MOST_PAIRS {
        found.retain(|object| {
            let caster = bounds(object);
            state.lights.iter().any(|light| {
                let mut receivers = receivers.iter();
                receivers.any(|receiver| may_shade(light, &caster, receiver))
            })
        });
    }
    found
}

impl Stage {
    /// Do shadows fall in a frame?
    pub fn has_shadows(&self, state: &FrameState<'_>) -> bool {
        state.shadows && !state.lights.is_empty() && self.adapter.abilities().shadows
    }

    /// An object where it is.
    pub fn instance(&self, object: &ObjectState<'_>) -> Instance {
        Instance {
            prototype: self.prototype_id(object),
            pose: object.pose,
        }
    }
}

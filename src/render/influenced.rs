//! The blocks of a frame that what moves can influence, found when the décor's
//! depth is known.

use std::collections::HashMap;

use decor_api::{Optics, Prototype};

use super::execution::Execution;
use super::ground::PeriodGround;
use super::shown::decor_objects;
use crate::film::ObjectState;
use crate::influence::{Cause, Influence, Mask, Still, influence, is_slender};
use crate::motion::screen_box;
use crate::plan::{BlockSet, FramePlan, Mode, Period, ShadowPlan};

/// The blocks of some frames that are rendered from the full scene.
pub type Blocks = HashMap<u32, BlockSet>;

impl Execution<'_> {
    /// Do the blocks of these frames depend on the décor's depth?
    pub fn needs_ground_first(&self, period: &Period, frames: std::ops::Range<u32>) -> bool {
        frames.into_iter().any(|number| {
            matches!(
                period.frames[(number - period.start) as usize],
                FramePlan::Layered {
                    shadows: Some(_),
                    ..
                }
            )
        })
    }

    /// The blocks of a frame: those of the plan, and those that what moves can
    /// shade; or where it can, if a shadow map is made.
    pub fn blocks_of(
        &self,
        period: &Period,
        number: u32,
        ground: Option<&PeriodGround>,
    ) -> (BlockSet, Option<Mask>) {
        let size = self.stage.size();
        match &period.frames[(number - period.start) as usize] {
            FramePlan::Whole => (self.stage.no_blocks(&self.plan.wishes), None),
            FramePlan::Layered {
                blocks,
                shadows: None,
                ..
            } => (blocks.clone(), None),
            FramePlan::Layered {
                blocks,
                shadows: Some(shadows),
                ..
            } => {
                let found =
                    ground.and_then(|ground| self.influenced(period, number, *shadows, ground));
                match found {
                    Some((found, None)) if shadows.replaces_boxes => (found, None),
                    Some((found, mask)) => (found.union(blocks), mask),
                    // Not certain is everything.
                    None => {
                        let mut all = self.stage.no_blocks(&self.plan.wishes);
                        all.insert(size.window());
                        (all, None)
                    }
                }
            }
        }
    }

    fn influenced(
        &self,
        period: &Period,
        number: u32,
        shadows: ShadowPlan,
        ground: &PeriodGround,
    ) -> Option<(BlockSet, Option<Mask>)> {
        let size = self.stage.size();
        let state = self.stage.film.frame(number);
        let antialiased = state.antialias.is_some();
        let depths = ground.depths(size, antialiased)?;
        // The décor is seen as it was, by the observer of then.
        let view = &ground.view;
        let kept = decor_objects(period);
        let (mut changed, mut optical, mut slender) = (Vec::new(), Vec::new(), Vec::new());
        for object in &state.objects {
            if !kept.contains(&object.id) && !period.resting.contains(&object.id) {
                changed.push(self.stage.changed(object));
            }
        }
        for shown in &view.instances {
            let prototype = self.stage.library.table.get(shown.prototype);
            let bounds = prototype.bounds.posed(&shown.pose);
            if self.may_mirror(prototype) {
                optical.push(screen_box(&bounds, &view.camera, size).window());
            }
            if !depths.has_samples() && is_slender(prototype, &shown.pose, &view.camera, size) {
                slender.push(bounds);
            }
        }
        let side = self.stage.block_side(&self.plan.wishes);
        let still = Still {
            camera: &view.camera,
            size,
            lights: state.lights,
            shadows: state.shadows,
            antialiased,
            by_blocks: (shadows.replaces_boxes && period.still).then_some(side),
            depths,
            optical: &optical,
            slender: if antialiased { &slender } else { &[] },
        };
        match influence(&still, &changed, None) {
            Influence::Everything(_) => None,
            Influence::Confined(mask) if shadows.replaces_boxes && period.still => {
                // With antialiasing POV-Ray compares the pixels of a block's first
                // row and column with those before them.
                let around = u32::from(antialiased);
                Some((mask.blocks_around(side, around, None), None))
            }
            Influence::Confined(mask) if shadows.by_map => {
                Some((self.stage.no_blocks(&self.plan.wishes), Some(mask)))
            }
            Influence::Confined(mask) => {
                // Surfaces may have moved since their depth was measured.
                let moved_px = if period.still {
                    0.0
                } else {
                    period.threshold_px
                };
                let around = 1 + moved_px.ceil().min(1e6) as u32;
                let mut blocks = mask.blocks_around(side, around, Some(Cause::Shadowed));
                if shadows.replaces_boxes {
                    // The observer may have moved since: what is seen is where it
                    // is seen now.
                    for object in state.objects.iter().filter(|o| !kept.contains(&o.id)) {
                        blocks.insert_all(self.stage.silhouette(object, &state.camera));
                    }
                    for window in &optical {
                        blocks.insert(*window);
                    }
                    let mirrors = |o: &&ObjectState<'_>| self.may_mirror(self.stage.prototype(o));
                    for object in state.objects.iter().filter(mirrors) {
                        blocks.insert_all(self.stage.silhouette(object, &state.camera));
                    }
                }
                Some((blocks, None))
            }
        }
    }

    /// May what is seen of the object depend on others?
    fn may_mirror(&self, prototype: &Prototype) -> bool {
        self.stage.adapter.abilities().optics
            && self.plan.wishes.mode != Mode::Preview
            && prototype.optics != Optics::Opaque
    }
}

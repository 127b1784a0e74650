//! What need not be read for the blocks of a frame: a heavy object of the décor that
//! cannot be seen in them, and shades nothing that is.
//!
//! A sculpture of twenty thousand triangles takes a renderer as long to read as
//! dozens of blocks to draw, in every frame.

use std::collections::{BTreeMap, HashSet};
use std::sync::{Mutex, PoisonError};

use decor_api::Optics;

use super::execution::Execution;
use super::ground::PeriodGround;
use super::shown::decor_objects;
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::influence::{Changed, Places, Still, matters, shades, with_ring};
use crate::plan::{BlockSet, Mode, Period, description_bytes};

/// What takes fewer bytes to describe is read faster than it is thought about.
const HEAVY_BYTES: f64 = 16_384.0;

/// With more objects, looking at all of them takes longer than it saves.
const MOST_OBJECTS: usize = 2_000;

/// The heavy objects of a period's décor, and where they matter.
pub struct Spared {
    heavy: Vec<(ObjectId, Changed)>,
    decor: Vec<Changed>,
    /// Of a block, by its corner: which of the heavy ones matter, once it was asked
    /// for.
    known: Mutex<BTreeMap<(u32, u32), Vec<bool>>>,
}

impl Execution<'_> {
    /// What can be spared in a period: where nothing mirrors or lets light through,
    /// and the blocks are found by the décor's depth.
    pub fn spared(&self, period: &Period) -> Option<Spared> {
        let state = self.stage.film.frame(period.start);
        let optical = |number: u32| {
            let state = self.stage.film.frame(number);
            let mut objects = state.objects.iter();
            objects.any(|object| self.stage.prototype(object).optics != Optics::Opaque)
        };
        let is_sure = period.still
            && period.replaces_boxes()
            && self.plan.wishes.mode != Mode::Preview
            && state.objects.len() <= MOST_OBJECTS;
        if !is_sure || self.keep_colours {
            return None;
        }
        let kept = decor_objects(period);
        let is_kept = |object: &&ObjectState<'_>| kept.contains(&object.id);
        let is_heavy = |object: &&ObjectState<'_>| {
            let prototype = self.stage.prototype(object);
            description_bytes(&prototype.geometry) >= HEAVY_BYTES
        };
        let decor = state.objects.iter().filter(is_kept);
        let heavy: Vec<(ObjectId, Changed)> = decor
            .clone()
            .filter(is_heavy)
            .map(|object| (object.id, self.stage.changed(object)))
            .collect();
        if heavy.is_empty() || period.numbers().any(optical) {
            return None;
        }
        Some(Spared {
            heavy,
            decor: decor.map(|object| self.stage.changed(object)).collect(),
            known: Mutex::default(),
        })
    }

    /// The objects that need not be drawn in some blocks of a frame.
    pub fn spared_in(
        &self,
        ground: Option<&PeriodGround>,
        period: &Period,
        state: &FrameState<'_>,
        blocks: &BlockSet,
    ) -> HashSet<ObjectId> {
        let nothing = HashSet::new();
        let Some((ground, spared)) = ground.and_then(|g| Some((g, g.spared.as_ref()?))) else {
            return nothing;
        };
        let size = self.stage.size();
        let antialiased = state.antialias.is_some();
        let Some(depths) = ground.depths(size, antialiased) else {
            return nothing;
        };
        let still = Still {
            camera: &ground.view.camera,
            size,
            lights: state.lights,
            // What is kept of a block holds for all frames.
            shadows: true,
            antialiased,
            by_blocks: None,
            depths,
            optical: &[],
            slender: &[],
        };
        let places = Places::of(&still, &spared.decor);
        let mut matter = vec![false; spared.heavy.len()];
        for block in blocks.windows() {
            let of_block = spared.of_block((block.x, block.y), || {
                let window = with_ring(block, size);
                let heavy = spared.heavy.iter();
                heavy
                    .map(|(_, thing)| matters(&still, thing, &places, window))
                    .collect()
            });
            matter
                .iter_mut()
                .zip(of_block)
                .for_each(|(all, one)| *all |= one);
        }
        let kept = decor_objects(period);
        let moving = state.objects.iter().filter(|o| !kept.contains(&o.id));
        let moving: Vec<Changed> = moving.map(|object| self.stage.changed(object)).collect();
        let heavy = spared.heavy.iter().zip(matter);
        heavy
            .filter(|((_, thing), matters)| {
                let on_moving = |to: &Changed| state.shadows && shades(state.lights, thing, to);
                !matters && !moving.iter().any(on_moving)
            })
            .map(|((id, _), _)| *id)
            .collect()
    }
}

impl Spared {
    fn of_block(&self, corner: (u32, u32), find: impl FnOnce() -> Vec<bool>) -> Vec<bool> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&corner) {
            return found.clone();
        }
        let found = find();
        known().insert(corner, found.clone());
        found
    }
}

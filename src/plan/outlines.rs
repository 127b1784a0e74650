//! Where objects are seen, kept while a period is chosen: every length that is
//! tried, and both ways of drawing what is fast, look at the same frames.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use decor_api::Window;

use crate::film::{FrameState, ObjectId, ObjectState};
use crate::stage::Stage;

/// What is kept at most: it is thrown away before memory is short.
const MOST: usize = 1 << 20;

/// An object in a frame.
type Key = (u32, ObjectId);

/// The outlines that were asked for, by frame and object.
#[derive(Debug, Default)]
pub struct Outlines {
    known: Mutex<HashMap<Key, Arc<[Window]>>>,
}

impl Outlines {
    /// The rectangles that an object of a frame can be seen in.
    pub fn of(
        &self,
        stage: &Stage,
        object: &ObjectState<'_>,
        state: &FrameState<'_>,
    ) -> Arc<[Window]> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if known.len() > MOST {
            known.clear();
        }
        let outline = known
            .entry((state.number, object.id))
            .or_insert_with(|| stage.silhouette(object, &state.camera).into());
        Arc::clone(outline)
    }

    /// Frames before this one are not asked for again.
    pub fn forget_before(&self, frame: u32) {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        known.retain(|&(number, _), _| number >= frame);
    }
}

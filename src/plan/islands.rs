//! Blocks around what is fast whose borders cut through nothing: islands.
//!
//! Where the décor is up to the threshold off, a block rendered from the full
//! scene beside it would show its border: an object that lies across it jumps by
//! as much. So the blocks grow until every object of the décor that moves lies in
//! them or beside them. Then no object is split, an island's pixels are the
//! renderer's own, and neither décor nor fast objects need a depth.

use std::collections::{HashMap, HashSet};

use decor_api::{Optics, Window};

use super::{BlockSet, Mode, Wishes};
use crate::film::{FrameState, ObjectId};
use crate::motion::screen_box;
use crate::segmentation::Class;
use crate::stage::Stage;

/// Where more objects of the décor move, looking at all of them in every frame
/// costs more than it wins.
const MOST_MOVING: usize = 20_000;

/// Grows `blocks` until no object that moves in the décor lies across their
/// border. `threshold_px`: how far it can be from where the décor shows it.
/// `None` where too many do.
pub fn islands(
    stage: &Stage,
    state: &FrameState<'_>,
    classes: &HashMap<ObjectId, Class>,
    threshold_px: f64,
    mut blocks: BlockSet,
) -> Option<BlockSet> {
    let slow = classes
        .values()
        .filter(|class| matches!(class, Class::Slow | Class::Clipped));
    if slow.count() > MOST_MOVING {
        return None;
    }
    let size = stage.size();
    // What is as good as infinite takes the whole picture.
    let room = threshold_px.ceil().min(1e6) as u32;
    let moving = state.objects.iter().filter(|object| {
        let class = classes.get(&object.id);
        matches!(class, Some(Class::Slow | Class::Clipped))
    });
    let mut outside: Vec<Window> = moving
        .map(|object| {
            let bounds = stage.prototype(object).bounds.posed(&object.pose);
            let seen = screen_box(&bounds, &state.camera, size).window();
            wider(seen, room).intersection(size.window())
        })
        .filter(|window| !window.is_empty())
        .collect();
    loop {
        let before = outside.len();
        outside.retain(|&window| {
            let touched = blocks.touches(window);
            if touched {
                blocks.insert(window);
            }
            !touched
        });
        if outside.len() == before {
            return Some(blocks);
        }
    }
}

/// The objects that can be seen in some blocks, where nothing else can change
/// what is seen there; `None`: any object may.
pub fn seen_in(
    stage: &Stage,
    wishes: &Wishes,
    state: &FrameState<'_>,
    blocks: &BlockSet,
) -> Option<HashSet<ObjectId>> {
    let from_scene = matches!(wishes.mode, Mode::Exact | Mode::Equivalent);
    if !from_scene || state.antialias.is_some() || !is_flat(stage, state) {
        return None;
    }
    let objects = state.objects.iter();
    let seen = objects.filter(|object| stage.is_seen_in(object, &state.camera, blocks));
    Some(seen.map(|object| object.id).collect())
}

/// Is what is seen in a pixel one object's alone, whatever else there is: no shadow,
/// no mirror, no glass?
fn is_flat(stage: &Stage, state: &FrameState<'_>) -> bool {
    let is_opaque = |object| stage.prototype(object).optics == Optics::Opaque;
    !stage.has_shadows(state)
        && (!stage.adapter.abilities().optics || state.objects.iter().all(is_opaque))
}

fn wider(window: Window, by: u32) -> Window {
    if window.is_empty() {
        return window;
    }
    let (x, y) = (window.x.saturating_sub(by), window.y.saturating_sub(by));
    Window {
        x,
        y,
        width: window.right().saturating_add(by) - x,
        height: window.bottom().saturating_add(by) - y,
    }
}

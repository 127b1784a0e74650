//! Flicker: the pixels that change from one frame to the next, in A's own
//! sequence and in B's own.
//!
//! A pixel *changes* where red, green, blue, or alpha where all four pictures
//! have it, differs between a frame and the frame before it in the same sequence
//! by more than a level. What changes in B and not in A is what B *adds*: where A
//! is the plain film, the seams and dissolves that it does not have. What changes
//! in A and not in B is *lost*: motion that B shows late or not at all. So
//! `changed_b − changed_a = added − lost`.

use super::mask::Mask;
use super::metrics::{difference, share};
use super::picture::{Form, Picture};

/// The changed pixels of one transition, or of several together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flicker {
    /// Pixels that were looked at.
    pub pixels: u64,
    /// Changed from A's frame before to A's frame.
    pub changed_a: u64,
    /// Changed from B's frame before to B's frame.
    pub changed_b: u64,
    /// Changed in B and not in A.
    pub added: u64,
    /// Changed in A and not in B.
    pub lost: u64,
}

impl Flicker {
    /// How many more pixels change in B than in A; negative where fewer do.
    pub fn difference(&self) -> i64 {
        self.changed_b as i64 - self.changed_a as i64
    }

    /// The part of the pixels that B changes and A does not, 0..1.
    pub fn share_added(&self) -> f64 {
        share(self.added, self.pixels)
    }

    /// Adds a later transition.
    pub fn append(&mut self, later: &Self) {
        self.pixels += later.pixels;
        self.changed_a += later.changed_a;
        self.changed_b += later.changed_b;
        self.added += later.added;
        self.lost += later.lost;
    }
}

/// The flicker between the frames `before` and `now`, each a pair of A's picture
/// and B's. `level` is in units of the pictures' values. Nothing where they are
/// not all of one size, or one sequence changes its encoding between them.
pub fn flicker(
    before: (&Picture, &Picture),
    now: (&Picture, &Picture),
    level: f64,
    mask: Option<&Mask>,
) -> Option<Flicker> {
    let size = now.0.size;
    let all = [before.0, before.1, now.0, now.1];
    let pixels = now.0.values.len();
    if all
        .iter()
        .any(|picture| picture.size != size || picture.values.len() != pixels)
        || before.0.encoding != now.0.encoding
        || before.1.encoding != now.1.encoding
    {
        return None;
    }
    let channels = if all.iter().all(|picture| picture.has_alpha) {
        4
    } else {
        3
    };
    let changed = |before: &Picture, now: &Picture, k: usize| {
        let whole_steps = before.form != Form::Exr && now.form != Form::Exr;
        let (before, now) = (&before.values[k], &now.values[k]);
        (0..channels).any(|c| difference(before[c], now[c], whole_steps) > level)
    };
    let mut flicker = Flicker::default();
    for k in (0..pixels).filter(|&k| mask.is_none_or(|mask| mask.counts(k))) {
        let (a, b) = (changed(before.0, now.0, k), changed(before.1, now.1, k));
        flicker.pixels += 1;
        flicker.changed_a += u64::from(a);
        flicker.changed_b += u64::from(b);
        flicker.added += u64::from(b && !a);
        flicker.lost += u64::from(a && !b);
    }
    Some(flicker)
}

//! Which pixels of a frame can differ from the décor's picture: conservatively,
//! from geometry alone.
//!
//! The décor is what does not change, rendered without what does, by the same
//! camera under the same lights. A pixel of the whole frame can differ from it
//! - (a) where what changed can be *seen*;
//! - (b) where it can cast a *shadow*: where its bounding sphere can stand
//!   between a light and the surface that the décor shows there;
//! - (c) where the décor shows something *optical*, that mirrors or lets light
//!   through;
//! - (d) *everywhere*, where a scene uses what cannot be confined.
//!
//! What is not certain is in it: a number that is not one, a light whose rays
//! cannot be told, a pixel of unknown depth.
//!
//! ```text
//! depth ─ depths ─→ beams of a tile ─┐
//! lights ─ lamp ────────────────────┼─ trace: tile, cell, pixel ─→ Mask ─→ BlockSet
//! what changed ─ parts ─→ spheres ──┘
//! ```
//!
//! # Between the pixels' centres
//! Without antialiasing a pixel depends on the ray through its centre alone, and
//! its depth is known. With it, more rays may be sent, where colours meet.
//! [`Depths::with_samples`] is exact about them: the décor's depth in a picture
//! so many times as large, whose pixels' centres are the very places of POV-Ray's
//! `+AM1` and of the reference's antialiasing without jitter. Otherwise the
//! range of the depths of a pixel and its neighbours, extended by itself,
//! stands for the surfaces in between; to the end of the world where a neighbour
//! shows nothing. What is seen at no centre around must be named: the scene's
//! `slender` objects. A gap, or a spike of a solid object, that is narrower than a
//! pixel is not covered by that.
//!
//! POV-Ray's `+AM1` compares a pixel with neighbours that may have been refined
//! already, so that a change can travel from pixel to pixel inside a block, in
//! principle any way; it never crosses a block's border by more than the one
//! pixel of [`Mask::dilated`]. Its blocks are certain; its dilated pixels
//! almost.

mod depths;
pub mod distance;
mod estimate;
pub mod lamp;
mod mask;
mod parts;
mod trace;

use std::fmt;

use decor_api::{Bounds, Camera, Light, Pose, Prototype, Size, Sphere, Window};

pub use depths::Depths;
pub use estimate::estimated_pixels;
pub use lamp::{Beam, Lamp};
pub use mask::{Cause, Mask};
pub use parts::{is_slender, parts, thickness};

/// What is the same in the décor and in the frame.
#[derive(Clone, Copy, Debug)]
pub struct Still<'a> {
    /// From where it is seen.
    pub camera: &'a Camera,
    /// The size of the picture.
    pub size: Size,
    /// The lights.
    pub lights: &'a [Light],
    /// Are shadows cast?
    pub shadows: bool,
    /// Does the renderer look between the pixels' centres?
    pub antialiased: bool,
    /// How far the décor's surfaces are.
    pub depths: Depths<'a>,
    /// Where the décor can show something that mirrors or lets light through.
    pub optical: &'a [Window],
    /// The bounds of the décor's objects that can be thinner than a pixel
    /// ([`is_slender`]); not needed where the depth of the samples is known.
    pub slender: &'a [Bounds],
}

/// Something that is in the frame and not in the décor.
#[derive(Clone, Debug, PartialEq)]
pub struct Changed {
    /// What encloses all of it.
    pub whole: Bounds,
    /// Spheres that enclose it together, tighter than the whole; none: the
    /// whole is all that is known.
    pub parts: Vec<Sphere>,
}

impl Changed {
    /// An object of which only the bounds are known.
    pub fn within(whole: Bounds) -> Self {
        Self {
            whole,
            parts: Vec::new(),
        }
    }

    /// A placed prototype; in parts where its geometry is neutral.
    pub fn placed(prototype: &Prototype, pose: &Pose) -> Self {
        let posed = |sphere: &Sphere| {
            let bounds = Bounds::Sphere(*sphere).posed(pose);
            bounds.as_sphere().copied()
        };
        // A part that is not finite any more makes the parts useless.
        let parts: Option<Vec<Sphere>> = parts(prototype).iter().map(posed).collect();
        Self {
            whole: prototype.bounds.posed(pose),
            parts: parts.unwrap_or_default(),
        }
    }
}

impl From<Bounds> for Changed {
    fn from(bounds: Bounds) -> Self {
        Self::within(bounds)
    }
}

/// Why every pixel can change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The scene uses what reaches everywhere (radiosity, …).
    Unconfined(String),
    /// Something changed that has no end, or whose size nobody knows.
    Endless,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unconfined(what) => write!(f, "{what} can change every pixel"),
            Self::Endless => write!(f, "something without an end moves"),
        }
    }
}

/// The pixels that can differ from the décor's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Influence {
    /// All of them.
    Everything(Reason),
    /// Only these.
    Confined(Mask),
}

impl Influence {
    /// The pixels, where they are confined.
    pub fn mask(&self) -> Option<&Mask> {
        match self {
            Self::Everything(_) => None,
            Self::Confined(mask) => Some(mask),
        }
    }
}

/// The influence of what `changed` on the picture of what is `still`.
/// `unconfined`: why it cannot be confined, where the caller knows it.
pub fn influence(still: &Still<'_>, changed: &[Changed], unconfined: Option<&str>) -> Influence {
    if let Some(what) = unconfined {
        return Influence::Everything(Reason::Unconfined(what.to_owned()));
    }
    if changed.iter().any(|c| c.whole == Bounds::Unbounded) {
        return Influence::Everything(Reason::Endless);
    }
    if changed.iter().all(|c| c.whole == Bounds::Empty) {
        return Influence::Confined(Mask::none(still.size));
    }
    Influence::Confined(trace::trace(still, changed))
}

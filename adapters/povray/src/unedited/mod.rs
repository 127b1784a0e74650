//! Plain scenes by coherence: what of a scene that nobody wrote for decor
//! depends on the clock, where it is in each frame, and what it can touch.
//!
//! About the text:
//!
//! ```text
//! PlainScene → Sources (source: the scene and its includes)
//!            → Analysis (lex, outline, taint, refuse: statements that move)
//!            → Boxes (instrument, boxes: where POV-Ray says that they are)
//! ```
//!
//! The scene is never changed: copies of it are, by [`Edit`]s, and what cannot
//! be understood for certain is a [`Refusal`]: all frames are rendered whole.

mod analysis;
mod boxes;
mod source;

pub use analysis::{Analysis, Kind, Options, Refusal, Statement, analyse};
pub use boxes::{Boxes, Extent, FrameBoxes, Placed, boxes};
pub use source::{Copy, Edit, SourceFile, Sources};

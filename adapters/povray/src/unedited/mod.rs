//! Plain scenes by coherence: what of a scene that nobody wrote for decor
//! depends on the clock, where it is in each frame, and what it can touch.
//!
//! About the text:
//!
//! ```text
//! PlainScene → Sources (source: the scene and its includes)
//!            → Analysis (lex, outline, placing, taint, refuse: what moves)
//!            → Boxes (instrument, boxes: where POV-Ray says that they are)
//!            → Steps (expression, aliases: frames that show the same)
//! ```
//!
//! About the pixels:
//!
//! ```text
//! Boxes → Hulls (boxes and balls for groups of frames: solid)
//!       → Geometry, Proxy (pixels that can be touched) → Blocks (dirty, by frame)
//!       → Schedule (keys: who traces what for whom) → Finished, Traced (frames)
//! ```
//!
//! The scene is never changed: copies of it are, by [`Edit`]s, and what cannot
//! be understood for certain is a [`Refusal`]: all frames are rendered whole.

mod aliases;
mod analysis;
mod blocks;
mod boxes;
mod brackets;
#[cfg(test)]
mod cases;
mod expression;
mod frames;
mod geometry;
mod hulls;
mod instrument;
mod keys;
mod lex;
mod media;
mod mixed;
mod order;
mod outline;
mod parts;
mod placing;
mod proxy;
mod records;
mod refuse;
mod solid;
mod source;
mod steps;
mod taint;
mod values;
mod view;

pub use analysis::{Analysis, Kind, Options, Refusal, Statement, analyse};
pub use blocks::{Blocks, Grid, Pixels, Sampling};
pub use boxes::{Boxes, Extent, FrameBoxes, Placed, boxes};
pub use frames::{Finished, Timing, Traced, differing, only};
pub use geometry::Geometry;
pub use hulls::Hulls;
pub use keys::{Schedule, schedule};
pub use proxy::Proxy;
pub use source::{Copy, Edit, SourceFile, Sources};
pub use steps::Steps;
pub use view::View;

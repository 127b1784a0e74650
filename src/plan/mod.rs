//! The plan: which frames share a décor, and what is rendered where in each.
//!
//! A plan is a value. It can be printed (`decor plan`), and executed
//! (`decor render`); nothing is decided after it.

mod blocks;
mod budget;
mod cost;
mod islands;
mod lay;
mod make;
mod outlines;
mod screened;
mod ways;
mod windows;

use std::collections::{HashMap, HashSet};
use std::fmt;

use decor_api::Window;
use serde::Serialize;

pub use blocks::{BLOCK, BlockSet};
pub use budget::Budget;
pub use cost::{
    Costs, CostsFrom, Coverage, FrameWork, Parsed, Pass, PassTotal, Picture, PixelCost, Prediction,
    Price, Seen, Survey, Work, chunk_lengths, description_bytes, jobs, periods_at_once, whole_work,
};
pub(crate) use islands::seen_in;
pub(crate) use make::Maker;
pub use make::{PlanError, plan};
pub(crate) use outlines::Outlines;
pub use screened::Screens;
pub use windows::gathered;

use crate::film::ObjectId;
use crate::segmentation::{Class, Measure, Segmented};

/// What the frames promise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// Every frame is rendered whole, many at once: the renderer's own frames.
    Full,
    /// The renderer's own frames, pixel for pixel; what nothing changed is kept.
    Exact,
    /// Not to be told apart by eye.
    Equivalent,
    /// The plain merge: shadows stay inside each layer.
    Preview,
}

impl Mode {
    /// How far objects may move in the picture and stay in a décor, in pixels,
    /// where nobody says otherwise.
    pub fn default_threshold_px(self) -> f64 {
        match self {
            Self::Full | Self::Exact => 0.0,
            Self::Equivalent => 1.0,
            Self::Preview => 4.0,
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Full => "full",
            Self::Exact => "exact",
            Self::Equivalent => "equivalent",
            Self::Preview => "preview",
        })
    }
}

/// What is asked of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Wishes {
    /// The promise.
    pub mode: Mode,
    /// Objects may move so far in the picture, in pixels, and stay in a décor.
    pub threshold_px: f64,
    /// Which measure of motion decides.
    pub measure: Measure,
    /// Frames per décor at most; `None`: as decor sees fit.
    pub period: Option<u32>,
    /// Time for a frame: the threshold adapts.
    pub budget: Option<Budget>,
    /// The first and last frame to render.
    pub frames: (u32, u32),
    /// Is the depth of every frame wanted too?
    pub with_depth: bool,
    /// How shadows of what moves come onto the décor.
    pub shadow_way: ShadowWay,
    /// May frames be rendered whole because it is cheaper?
    pub fallback: bool,
}

/// Why frames are rendered whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum WholeReason {
    /// The mode says so.
    Asked,
    /// A light, the background or the sky changes in every frame.
    SurroundingsChange,
    /// The observer moves, and everything has to stay in place.
    ObserverMoves,
    /// The observer moves before a sky that would have to move with it.
    SkyMoves,
    /// No object stays where it is.
    NothingStays,
    /// Something changes every pixel: what the renderer's files say.
    Unconfined(String),
    /// Shadows fall from one layer onto the other.
    Shadows,
    /// A part of a picture is not what the whole has there.
    NoParts,
    /// What has to be rendered again is more than a whole frame.
    NoGain,
}

impl fmt::Display for WholeReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked => write!(f, "asked for"),
            Self::SurroundingsChange => {
                write!(
                    f,
                    "a light, the background or the sky changes in every frame"
                )
            }
            Self::ObserverMoves => write!(f, "the observer moves"),
            Self::SkyMoves => write!(f, "the observer moves before a sky"),
            Self::NothingStays => write!(f, "no object stays where it is"),
            Self::Unconfined(what) => write!(f, "{what} can change every pixel"),
            Self::NoParts => write!(
                f,
                "this renderer draws no part of a picture as it is in the whole"
            ),
            Self::Shadows => write!(
                f,
                "shadows fall between what moves and what does not, and this renderer draws no blocks"
            ),
            Self::NoGain => write!(f, "what moves covers so much that nothing is won"),
        }
    }
}

/// What is done for one frame.
#[derive(Clone, Debug, PartialEq)]
pub enum FramePlan {
    /// The whole frame is rendered.
    Whole,
    /// The décor, with layers merged into it.
    Layered {
        /// Where fast objects are rendered and merged. Windows may overlap:
        /// every fast object is drawn in each that it is seen in.
        fast: Vec<Window>,
        /// Blocks that are rendered from the full scene, over everything else.
        blocks: BlockSet,
        /// The sky is rendered anew, behind the objects of the décor.
        sky: bool,
        /// What moves may shade the décor: where, is found out when the décor's
        /// depth is known, and these blocks are rendered from the full scene too.
        shadows: Option<ShadowPlan>,
    },
}

impl FramePlan {
    /// Is the frame its décor, and nothing has to be rendered for it?
    pub fn is_decor(&self) -> bool {
        match self {
            Self::Whole => false,
            Self::Layered {
                fast,
                blocks,
                sky,
                shadows,
            } => fast.is_empty() && blocks.is_empty() && !sky && shadows.is_none(),
        }
    }
}

/// Where what moves may change the décor's picture, which its depth tells: by shadows,
/// and where it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowPlan {
    /// About how many pixels of blocks there will be: for the price.
    pub expected_pixels: f64,
    /// All that moves is rendered in such blocks, and nothing is merged: then
    /// they replace the frame's other blocks, which are boxes only.
    pub replaces_boxes: bool,
    /// The light that arrives at shaded pixels is asked for, and the décor's
    /// colours are mixed anew, in place of rendering their blocks.
    pub by_map: bool,
}

/// How shadows of what moves come onto the décor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ShadowWay {
    /// The cheaper way.
    #[default]
    Auto,
    /// Their blocks are rendered from the full scene.
    Blocks,
    /// The thesis's shadow map: the décor light by light, and in every frame the
    /// light that arrives.
    Map,
}

/// Why a period is not longer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum End {
    /// No more frames are asked for.
    Done,
    /// It is as long as was asked for.
    Asked,
    /// Any other length that was tried costs more per frame.
    Cheapest,
    /// A light, the background, the sky or the opening of the view changes.
    SurroundingsChange,
    /// The observer begins to move.
    ObserverStarts,
    /// The observer comes to rest.
    ObserverRests,
    /// Its frames are rendered whole; then a décor is tried again.
    TriedAgain,
    /// A frame arrived that was not as predicted.
    PredictionFailed,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Done => "no more frames",
            Self::Asked => "as long as asked for",
            Self::Cheapest => "the cheapest length",
            Self::SurroundingsChange => {
                "a light, the background, the sky or the opening of the view changes"
            }
            Self::ObserverStarts => "the observer begins to move",
            Self::ObserverRests => "the observer comes to rest",
            Self::TriedAgain => "a décor is tried again",
            Self::PredictionFailed => "a frame was not as predicted",
        })
    }
}

/// The sky of a period in which the observer moves: it is at infinity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkyMotion {
    /// `Immobile` where the observer does not turn; never `Clipped`.
    pub class: Class,
    /// How far it moves in the picture during the period, in pixels.
    pub motion_px: f64,
}

/// Frames that one décor serves.
#[derive(Clone, Debug, PartialEq)]
pub struct Period {
    /// Its first frame; the décor shows it.
    pub start: u32,
    /// What is done for each frame, from `start` on.
    pub frames: Vec<FramePlan>,
    /// Every object of the period.
    pub objects: Vec<Segmented>,
    /// Fast objects that stand still in the world while the observer moves: under
    /// lights, the décor has their shadows and does not show them.
    pub resting: HashSet<ObjectId>,
    /// Objects move so far in the picture, in pixels, and stay in the décor.
    pub threshold_px: f64,
    /// Does neither the observer move nor anything that the décor shows? Then what
    /// was rendered of it is right to the pixel in every frame.
    pub still: bool,
    /// Is all that is merged nearer than whatever of the décor it is seen over, in all
    /// frames? Then its coverage says what is seen, and neither has a depth.
    pub before: bool,
    /// The sky, where there is one and the observer moves.
    pub sky: Option<SkyMotion>,
    /// The frame whose poses the décor dissolves towards, where it does: the one
    /// after the period, as a rule.
    pub dissolve_until: Option<u32>,
    /// Why it is not longer.
    pub end: End,
    /// Why it has no décor, where it has none.
    pub whole: Option<WholeReason>,
}

impl Period {
    /// Its length in frames.
    pub fn len(&self) -> u32 {
        self.frames.len() as u32
    }

    /// Has it no frame? Never, in a plan.
    pub fn is_empty(&self) -> bool {
        self.frames.is_empty()
    }

    /// The frames' numbers.
    pub fn numbers(&self) -> std::ops::Range<u32> {
        self.start..self.start + self.len()
    }

    /// Every object's class.
    pub fn classes(&self) -> HashMap<ObjectId, Class> {
        self.objects.iter().map(|o| (o.object, o.class)).collect()
    }

    /// How many objects have this class.
    pub fn count(&self, class: Class) -> usize {
        self.objects.iter().filter(|o| o.class == class).count()
    }

    /// Is it rendered in every frame, and does it move in the world? Then nobody
    /// knows before where its shadow falls.
    pub fn is_moving(&self, object: &Segmented) -> bool {
        !object.class.in_decor() && !self.resting.contains(&object.object)
    }

    /// Is a décor rendered?
    pub fn has_decor(&self) -> bool {
        self.whole.is_none()
    }

    /// Is the décor's depth needed: for a merge, or to see the sky behind it?
    pub fn needs_depth(&self) -> bool {
        self.frames.iter().any(|frame| match frame {
            FramePlan::Layered {
                fast, sky, shadows, ..
            } => self.merges_by_depth(fast) || *sky || shadows.is_some(),
            FramePlan::Whole => false,
        })
    }

    /// Is what is drawn in these windows merged by its depth?
    pub fn merges_by_depth(&self, fast: &[Window]) -> bool {
        !fast.is_empty() && !self.before
    }

    /// Is the décor needed light by light?
    pub fn by_map(&self) -> bool {
        self.frames.iter().any(
            |frame| matches!(frame, FramePlan::Layered { shadows: Some(plan), .. } if plan.by_map),
        )
    }

    /// Is there a frame whose blocks are found by the décor's depth, and by
    /// nothing else? Then antialiasing asks for the depth between the pixels'
    /// centres, too.
    pub fn replaces_boxes(&self) -> bool {
        self.frames.iter().any(|frame| {
            matches!(frame, FramePlan::Layered { shadows: Some(plan), .. } if plan.replaces_boxes)
        })
    }

    /// The frames over which the décor dissolves, where it does.
    pub fn dissolve_steps(&self) -> Option<u32> {
        self.dissolve_until.map(|until| until - self.start)
    }
}

/// The whole plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// What was asked.
    pub wishes: Wishes,
    /// The periods, in order, without a gap.
    pub periods: Vec<Period>,
}

impl Plan {
    /// Is every frame rendered whole although something else was asked?
    pub fn is_fallback(&self) -> bool {
        self.wishes.mode != Mode::Full && self.periods.iter().all(|p| p.whole.is_some())
    }
}

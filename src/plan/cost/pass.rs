//! The passes: what a picture is for, and what all pictures of a pass come to.

use serde::{Deserialize, Serialize};

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// A décor's colour.
    Decor,
    /// A décor's depth.
    DecorDepth,
    /// What a décor is dissolved into: its objects at the period's end.
    Target,
    /// The depth of that.
    TargetDepth,
    /// The sky behind a décor.
    Sky,
    /// The fast objects alone.
    Fast,
    /// Their depth.
    FastDepth,
    /// Blocks rendered from the full scene.
    Blocks,
    /// Light that arrives at points of the décor: its pixels are those points.
    Shadow,
    /// A frame rendered whole.
    Whole,
    /// The depth of one.
    WholeDepth,
}

impl Pass {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Decor,
        Self::DecorDepth,
        Self::Target,
        Self::TargetDepth,
        Self::Sky,
        Self::Fast,
        Self::FastDepth,
        Self::Blocks,
        Self::Shadow,
        Self::Whole,
        Self::WholeDepth,
    ];

    /// Does it give depth?
    pub fn is_depth(self) -> bool {
        matches!(
            self,
            Self::DecorDepth | Self::TargetDepth | Self::FastDepth | Self::WholeDepth
        )
    }

    /// Does it show fast objects alone?
    pub fn is_fast(self) -> bool {
        matches!(self, Self::Fast | Self::FastDepth)
    }
}

/// What the renderer has to read for a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Parsed {
    /// Placed objects.
    pub instances: f64,
    /// The descriptions that they need, in bytes of text, or what text they
    /// would make.
    pub bytes: f64,
}

/// The sum over all pictures of a pass.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct PassTotal {
    /// Pictures.
    pub pictures: u64,
    /// Pixels that are asked for.
    pub pixels: f64,
    /// Of these, pixels that show an object: an estimate.
    pub covered: f64,
    /// Placed objects that are read.
    pub instances: f64,
    /// Bytes of descriptions that are read.
    pub bytes: f64,
}

impl std::ops::AddAssign for PassTotal {
    fn add_assign(&mut self, other: Self) {
        self.pictures += other.pictures;
        self.pixels += other.pixels;
        self.covered += other.covered;
        self.instances += other.instances;
        self.bytes += other.bytes;
    }
}

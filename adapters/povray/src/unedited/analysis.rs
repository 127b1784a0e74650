//! What analysing a scene's text gives.

use std::ops::Range;

use super::source::{Edit, Sources};

/// What kind of statement it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An object, by its keyword: `sphere`, `union`.
    Object(String),
    /// A light.
    Light,
    /// The camera.
    Camera,
}

/// A statement of the scene itself (not a part of another one).
#[derive(Clone, Debug)]
pub struct Statement {
    /// Which file of [`Sources::files`].
    pub file: usize,
    /// Its line, from 1.
    pub line: usize,
    /// Its bytes.
    pub range: Range<usize>,
    /// What it is.
    pub kind: Kind,
    /// Does it depend on the clock?
    pub moves: bool,
    /// Why it depends on the clock, in words; empty where it does not.
    pub why: String,
    /// May it mirror or bend rays (reflection, refraction)?
    pub bends: bool,
    /// May it be executed any number of times (loop, macro)?
    pub repeated: bool,
}

/// Something for which frames are rendered whole.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Refusal {
    /// The name of the file; empty where it is an option.
    pub file: String,
    /// The line, from 1; 0 where it has none.
    pub line: usize,
    /// Why, in words.
    pub reason: String,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.file.is_empty(), self.line) {
            (true, _) => write!(f, "{}", self.reason),
            (false, 0) => write!(f, "{}: {}", self.file, self.reason),
            (false, line) => write!(f, "{}:{line}: {}", self.file, self.reason),
        }
    }
}

/// What is known besides the text.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Names that the INI file declares (`Declare=name=value`).
    pub declared: Vec<String>,
}

/// What a scene's text says of its motion.
#[derive(Clone, Debug, Default)]
pub struct Analysis {
    /// The statements of the scene: objects, lights, cameras; those that move
    /// ([`Statement::moves`]) are objects. Empty where `whole` is not.
    pub statements: Vec<Statement>,
    /// Why all frames are rendered whole; empty: they need not be.
    pub whole: Vec<Refusal>,
    /// Why only POV-Ray's own proxies say what is touched, not geometry
    /// (lights that are no points, cameras that are not plain…).
    pub proxies_only: Vec<Refusal>,
    /// How added names begin, which the scene has nowhere: `decor0_`.
    pub prefix: String,
    hiding: Vec<Edit>,
}

impl Analysis {
    /// The statements that move, with their index in `statements`.
    pub fn moving(&self) -> impl Iterator<Item = (usize, &Statement)> {
        self.statements.iter().enumerate().filter(|(_, s)| s.moves)
    }

    /// Edits by which everything that moves goes from the scene, and all else
    /// stays as it is: what statements declare, count or draw, they still do.
    /// What stands for them is put behind the scene ([`Sources::behind`]): boxes
    /// by value, so that loops and macros need nothing special.
    pub fn hidden(&self) -> Vec<Edit> {
        self.hiding.clone()
    }
}

/// Analyses the text of a scene.
pub fn analyse(sources: &Sources, _options: &Options) -> Analysis {
    let whole = Refusal {
        file: sources
            .files
            .first()
            .map(|f| f.name.clone())
            .unwrap_or_default(),
        line: 0,
        reason: "scenes are not analysed yet".into(),
    };
    Analysis {
        whole: vec![whole],
        ..Analysis::default()
    }
}

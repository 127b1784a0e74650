//! What of a scene depends on the clock: its statements, and why frames have to
//! be rendered whole.

use std::ops::Range;

use super::instrument;
use super::outline::Outline;
use super::placing::Placing;
use super::refuse;
use super::source::{Edit, Sources};
use super::steps::Steps;
use super::taint::Taint;
use super::values::{is_global, is_object};
use crate::plain::{Order, PlainScene};

/// The words that differ from frame to frame. (`now` does too, but not only.)
const CLOCK: &[&str] = &["clock", "frame_number"];

/// Words by which a surface mirrors or bends rays.
const BENDING: &[&str] = &["reflection", "refraction", "ior", "dispersion", "irid"];

/// What kind of statement it is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An object, by its keyword: `sphere`, `union`; or by its name.
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
    /// Why frames are rendered whole whatever the text says: they read what
    /// others write…
    pub refused: Vec<String>,
}

impl Options {
    /// What a scene's options say.
    pub fn of(scene: &PlainScene) -> Self {
        let refused = match &scene.order {
            Order::Free => Vec::new(),
            Order::Chained(reason) | Order::OwnPictures(reason) => vec![reason.clone()],
        };
        Self { refused }
    }
}

/// What a scene's text says of its motion.
#[derive(Clone, Debug, Default)]
pub struct Analysis {
    /// The statements of the scene: objects, lights, cameras; those that move
    /// ([`Statement::moves`]) are objects. Where `whole` is not empty they are
    /// for people only.
    pub statements: Vec<Statement>,
    /// Why all frames are rendered whole; empty: they need not be.
    pub whole: Vec<Refusal>,
    /// What the clock says, where frames are made of nothing else that differs.
    pub steps: Option<Steps>,
    /// Why only POV-Ray's own proxies say what is touched, not geometry
    /// (lights that are no points, cameras that are not plain…).
    pub proxies_only: Vec<Refusal>,
    /// How added names begin, which the scene has nowhere: `decor0_`.
    pub prefix: String,
    /// Edits by which what moves goes.
    pub(super) hiding: Vec<Edit>,
    /// Edits by which what is there says where.
    pub(super) measuring: Vec<Edit>,
    /// Where definitions can stand before everything else.
    pub(super) start: (usize, usize),
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
pub fn analyse(sources: &Sources, options: &Options) -> Analysis {
    let outline = Outline::of(sources);
    let option = |reason: &String| Refusal {
        file: String::new(),
        line: 0,
        reason: reason.clone(),
    };
    let mut whole: Vec<Refusal> = options.refused.iter().map(option).collect();
    if !outline.faults.is_empty() {
        let faults = outline.faults.iter();
        whole.extend(faults.map(|(file, at, why)| refuse::at(sources, *file, *at, *why)));
        return Analysis {
            whole,
            prefix: sources.prefix.clone(),
            ..Analysis::default()
        };
    }
    let placing = Placing::of(&outline, sources);
    let clock = Taint::of(&outline, sources, &placing.used, CLOCK, true);
    let bending = Taint::of(&outline, sources, &placing.used, BENDING, false);
    // A default texture that bends is everybody's.
    let all_bend = outline
        .settings
        .iter()
        .any(|raw| placing.used[raw.unit] && bending.concerns(raw));

    let mut statements = Vec::new();
    let mut raws = Vec::new();
    for raw in &placing.live {
        let kind = match raw.keyword {
            "light_source" => Kind::Light,
            "camera" => Kind::Camera,
            word if is_global(word) && !is_object(word) => continue,
            word => Kind::Object(word.to_owned()),
        };
        let file = outline.units[raw.unit].file;
        let range = outline.bytes(raw);
        let why = clock.why(raw);
        statements.push(Statement {
            file,
            line: sources.line(file, range.start),
            range,
            moves: why.is_some() && matches!(kind, Kind::Object(_)),
            why: why.unwrap_or_default(),
            bends: all_bend || bending.concerns(raw),
            repeated: raw.unit != 0 || outline.governing(raw.control).any(|c| c.loops),
            kind,
        });
        raws.push(*raw);
    }

    let scene = refuse::Scene {
        outline: &outline,
        sources,
        placing: &placing,
        clock: &clock,
        raws: &raws,
        statements: &statements,
    };
    let steps = Steps::of(&outline).filter(|_| whole.is_empty() && scene.is_certain());
    whole.extend(scene.whole());
    whole.sort();
    whole.dedup();
    let mut proxies_only = scene.proxies_only();
    proxies_only.sort();
    proxies_only.dedup();
    let edits = instrument::Edits::of(&scene);
    Analysis {
        statements,
        whole,
        steps,
        proxies_only,
        prefix: sources.prefix.clone(),
        hiding: edits.hiding,
        measuring: edits.measuring,
        start: edits.start,
    }
}

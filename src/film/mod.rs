//! The film model, its formats, its validation.
//!
//! A [`Film`] is read from an `.anim` file (the thesis's form, [`anim`]) or from
//! JSON lines ([`jsonl`]), and cannot be wrong: whoever has one need not check
//! anything again. Both forms say the same, and are written back without loss.
//!
//! ```text
//! text → lines or JSON → drafts (every value allowed) → build (all of them
//! together: order, names, files, cameras) → Film → FrameState
//! ```
//!
//! Where the format leaves a choice:
//! - a film must state `*eye`, `*aim` and `*angles` in its first scene, and
//!   `*size` somewhere;
//! - nothing is stated twice in one scene, but for lights, includes and objects,
//!   and for a size or a number of frames that stays the same;
//! - includes hold for the whole film, in every pass, in the order of first
//!   mention: an object is the same in all its frames;
//! - colours are not negative; a spot's half angles reach 90°;
//! - a name is not what an unnamed object is called (`house.inc#3`);
//! - a named object may change its path between scenes: it stays the same
//!   object, with another description;
//! - errors that come with time (an eye that reaches the aim, a position that
//!   is no number any more) are found when the film is read.

use std::path::Path;

pub mod anim;
mod build;
mod draft;
mod error;
mod fields;
mod force;
mod frame;
mod intern;
pub mod jsonl;
mod keyword;
mod lines;
mod locate;
mod mark;
mod model;
mod paths;
mod predict;
mod problem;
mod ranges;
mod scene_json;
mod schema;
mod statements;
mod stream;
mod view_run;
mod write;

pub use anim::write as write_anim;
pub use error::{FilmError, FilmErrors};
pub use frame::{FrameState, ObjectState};
pub use jsonl::write as write_jsonl;
pub use model::{DescriptionId, Film, Identity, Motion, NamedFile, ObjectId};
pub use problem::Problem;
pub use stream::FilmStream;

/// The forms of a film.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// The thesis's, `.anim`.
    Anim,
    /// One JSON object a line, `.jsonl`.
    JsonLines,
}

impl Form {
    /// The form that a name's ending says.
    pub fn of(path: &Path) -> Option<Self> {
        match path.extension()?.to_str()? {
            "anim" => Some(Self::Anim),
            "jsonl" => Some(Self::JsonLines),
            _ => None,
        }
    }

    /// The film as text in this form. Reading it in the film's folder gives an
    /// equal film, every number bit for bit.
    pub fn write(self, film: &Film) -> String {
        match self {
            Self::Anim => write_anim(film),
            Self::JsonLines => write_jsonl(film),
        }
    }
}

/// Reads a film, in the form that its name's ending says. Its paths are
/// relative to its folder; `allow_outside` lets them leave it.
///
/// # Errors
/// Everything that is wrong with it.
pub fn read(path: &Path, allow_outside: bool) -> Result<Film, FilmErrors> {
    let name = path.display().to_string();
    let parse = match Form::of(path) {
        Some(Form::Anim) => anim::parse,
        Some(Form::JsonLines) => jsonl::parse,
        None => {
            let problem = Problem::UnknownForm { name: name.clone() };
            return Err(FilmErrors::of_file(&name, problem));
        }
    };
    let text = std::fs::read(path)
        .map_err(|source| FilmErrors::of_file(&name, Problem::Unreadable { source }))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parse(&name, &text, folder, allow_outside)
}

//! The film as JSON lines: one scene a line, one JSON object a scene.
//!
//! It says what an `.anim` file says, for programs and for streams. A scene,
//! here broken into several lines:
//!
//! ```json
//! {"scene": 0,
//!  "size": [320, 240],
//!  "frames": 25,
//!  "eye": {"position": [0, 2, -10], "velocity": [0, 0, 0.1]},
//!  "aim": {"position": [0, 0, 0]},
//!  "up": [0, 1, 0],
//!  "angles": [60, 45],
//!  "shadows": true,
//!  "background": [0.1, 0.1, 0.2],
//!  "antialias": {"threshold": 0.1, "depth": 3},
//!  "include": ["colours.inc"],
//!  "sky": "clouds.inc",
//!  "lights": [
//!    {"type": "point", "position": [5, 9, -5], "colour": [1, 1, 1],
//!     "fade": {"distance": 10, "power": 2}},
//!    {"type": "sun", "position": [0, 100, 0], "colour": [1, 1, 1], "towards": [0, 0, 0]},
//!    {"type": "spot", "position": [0, 5, 0], "colour": [1, 0, 0], "towards": [0, 0, 0],
//!     "radius": 20, "falloff": 30, "tightness": 1},
//!    {"type": "area", "position": [0, 9, 0], "colour": [1, 1, 1],
//!     "u": [2, 0, 0], "v": [0, 0, 2], "nu": 4, "nv": 4}],
//!  "objects": [
//!    {"path": "ball.inc", "name": "ball", "position": [0, 1, 0], "angles": [0, 30, 0],
//!     "velocity": [0.1, 0, 0], "angles_velocity": [0, 5, 0]},
//!    {"path": "floor.ron", "position": [0, 0, 0]}]}
//! ```
//!
//! - `scene` alone must be there; what else a scene leaves out carries over, as
//!   in an `.anim` file, and the first scene must have `eye`, `aim`, `angles`.
//! - `velocity`, `angles` of an object and `angles_velocity` are 0 where they
//!   are left out; angles are degrees, velocities per frame.
//! - `antialias` is `"off"` or an object.
//! - A light has the fields of its `type` and no other; `towards` of a sun is
//!   the origin where it is left out. `color` is read too.
//! - An empty list says nothing; where it would have to empty a list that
//!   carries over, it is an error, for no film can say that.
//! - `null` counts as left out. Unknown fields are refused. Blank lines, CRLF
//!   and a byte order mark are allowed; comments are not.

use std::path::Path;

use serde_json::error::Category;

use super::build::Builder;
use super::draft::Draft;
use super::error::FilmErrors;
use super::keyword::nearest;
use super::lines::{self, Place};
use super::mark::{Faults, Mark, Source};
use super::model::Film;
use super::paths::Folder;
use super::problem::Problem;
use super::scene_json;
use super::schema::{JsonScene, Object};

/// Reads the text of a `.jsonl` file. `name` is what messages call it, `folder`
/// what its paths are relative to.
///
/// # Errors
/// Everything that is wrong with it; of a line that is no scene at all, the
/// first thing.
pub fn parse(
    name: &str,
    text: &[u8],
    folder: &Path,
    allow_outside: bool,
) -> Result<Film, FilmErrors> {
    let source = Source {
        file: name,
        bytes: text,
        only_line: None,
    };
    let mut builder = Builder::new(Folder::new(folder, allow_outside));
    let mut unfinished = false;
    for (place, bytes) in lines::split(text) {
        // The rest of an object that was broken into several lines is not
        // worth an error a line.
        if unfinished && !bytes.trim_ascii().starts_with(b"{\"") {
            continue;
        }
        match scene(bytes, place, &mut builder.faults) {
            Ok(found) => {
                unfinished = false;
                if let Some(draft) = found {
                    builder.add(&draft);
                }
            }
            Err(()) => {
                unfinished |= builder.faults.ends_unfinished();
                builder.skip(place.mark(0, 0));
            }
        }
    }
    let end = Mark::span(1, 0, 0, 0);
    builder.finish(end).map_err(|faults| source.errors(faults))
}

/// The scene of one line; `Ok(None)` where the line is blank.
pub(super) fn scene(bytes: &[u8], place: Place, faults: &mut Faults) -> Result<Option<Draft>, ()> {
    let text = lines::text(bytes, place, faults).ok_or(())?;
    if text.trim_ascii().is_empty() {
        return Ok(None);
    }
    match serde_json::from_str::<Object<JsonScene>>(text) {
        Ok(Object(json)) => {
            let mark = Mark::json(place.number, place.start);
            Ok(Some(scene_json::draft(json, mark, faults)))
        }
        Err(error) => {
            // serde_json counts bytes from 1, up to the one that it cannot take.
            let mut to = error.column().min(text.len());
            while !text.is_char_boundary(to) {
                to += 1;
            }
            let from = text[..to].char_indices().next_back().map_or(0, |(i, _)| i);
            let mark = place.mark(from, to);
            let problem = problem(&error);
            faults.push(mark, problem);
            Err(())
        }
    }
}

/// serde's message, without its own place, as ours.
fn problem(error: &serde_json::Error) -> Problem {
    let text = error.to_string();
    let text = text
        .rsplit_once(" at line ")
        .map_or(&*text, |(text, _)| text);
    if error.classify() != Category::Data {
        let reason = text.to_owned();
        return Problem::NotJson { reason };
    }
    let (reason, expected) = match text.split_once(", expected ") {
        Some((reason, "u32")) => (reason, "a whole number from 0 to 4294967295"),
        Some((reason, "u64")) => (reason, "a whole number, 0 or more"),
        Some((reason, "f64")) => (reason, "a number"),
        Some(both) => both,
        None => (text, "a scene"),
    };
    // Of the words between backquotes, the first is wrong, the rest are right.
    let mut words = text.split('`').skip(1).step_by(2);
    let near = match words.next() {
        Some(word) if reason.starts_with("unknown") => nearest(word, words),
        _ => None,
    };
    Problem::NotAScene {
        reason: reason.to_owned(),
        expected: expected.to_owned(),
        near: near.map(str::to_owned),
    }
}

/// The film as the text of a `.jsonl` file. Reading it gives the same film,
/// every number bit for bit.
///
/// Paths are written as they were stated: the text belongs into the film's
/// folder.
pub fn write(film: &Film) -> String {
    let mut text = String::new();
    for scene in &film.scenes {
        let json = scene_json::json(scene, &film.tables);
        text += &serde_json::to_string(&json).expect("all keys are strings, nothing can fail");
        text.push('\n');
    }
    text
}

//! The film as the thesis writes it (Annexe A-1): reading, and in
//! [`write()`] writing.
//!
//! A blank may follow the signs `@`, `*` and `!`. The form has no escapes: a path
//! or a name with a quotation mark or a control character cannot be stated, in
//! either form.

use std::path::Path;

use super::build::Builder;
use super::draft::Draft;
use super::error::FilmErrors;
use super::fields::scene_number;
use super::lines::{self, Line};
use super::mark::{Faults, Mark, Source};
use super::model::Film;
use super::paths::Folder;
use super::problem::Problem;
use super::statements;

pub use super::write::write;

/// Reads the text of an `.anim` file. `name` is what messages call it, `folder`
/// what its paths are relative to.
///
/// # Errors
/// Everything that is wrong with it.
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
    let mut scene = Open::default();
    for (place, bytes) in lines::split(text) {
        let faults = &mut builder.faults;
        let line = match lines::text(bytes, place, faults) {
            Some(text) => lines::cut(text, place, faults),
            None => Err(()),
        };
        match line {
            Ok(None) => {}
            Ok(Some(line)) if line.sign == '@' => {
                let number = number(&line, &mut builder.faults);
                if let Some(ended) = scene.begin(number, line.mark) {
                    builder.add(&ended);
                }
            }
            Ok(Some(line)) => {
                let draft = scene.draft(line.mark);
                if line.sign == '*' {
                    statements::environment(&line, draft, &mut builder.faults);
                } else {
                    statements::object(&line, draft, &mut builder.faults);
                }
            }
            // Whatever the line was to state counts as stated.
            Err(()) => scene.draft(place.mark(0, 0)).riddled = true,
        }
    }
    if let Some(last) = scene.draft {
        builder.add(&last);
    }
    let end = Mark::span(1, 0, 0, 0);
    builder.finish(end).map_err(|faults| source.errors(faults))
}

/// The scene that lines are read into.
#[derive(Default)]
struct Open {
    draft: Option<Draft>,
    /// Its number was stated.
    numbered: bool,
}

impl Open {
    /// A scene number was read; gives the scene that ends here.
    fn begin(&mut self, number: Option<u32>, mark: Mark) -> Option<Draft> {
        let before = self.draft.take();
        let was_numbered = std::mem::replace(&mut self.numbered, true);
        match before {
            // What stands before the first number belongs to that scene.
            Some(mut headless) if !was_numbered => {
                (headless.number, headless.mark) = (number, mark);
                self.draft = Some(headless);
                None
            }
            before => {
                self.draft = Some(Draft::new(number, mark));
                before
            }
        }
    }

    /// The scene at hand; scene 0 where none was begun.
    fn draft(&mut self, mark: Mark) -> &mut Draft {
        self.draft.get_or_insert_with(|| Draft::new(Some(0), mark))
    }
}

fn number(line: &Line<'_>, faults: &mut Faults) -> Option<u32> {
    let [field] = &line.fields[..] else {
        let problem = Problem::FieldCount {
            statement: "a scene",
            expected: "1 scene number after `@`",
            found: line.fields.len(),
        };
        faults.push(line.mark, problem);
        return None;
    };
    faults.check(field.mark, scene_number(&field.text))
}

//! Places in a film's text, cheap to carry along and resolved only where
//! something is wrong.

use std::sync::Arc;

use super::error::{Excerpt, FilmError, FilmErrors};
use super::locate::{Step, locate};
use super::problem::Problem;

/// A place in one line of a film.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mark {
    /// The line's number, from 1.
    pub(super) line: usize,
    /// Where the line starts in the text, in bytes.
    start: usize,
    part: Part,
}

#[derive(Clone, Copy, Debug)]
enum Part {
    /// From byte to byte of the line.
    Span(usize, usize),
    /// A value in the line's JSON object.
    Json([Option<Step>; 4]),
}

impl Mark {
    /// Bytes `from..to` of the line that starts at byte `start`.
    pub(super) fn span(line: usize, start: usize, from: usize, to: usize) -> Self {
        let part = Part::Span(from, to);
        Self { line, start, part }
    }

    /// The whole JSON object of the line that starts at byte `start`.
    pub(super) fn json(line: usize, start: usize) -> Self {
        let part = Part::Json([None; 4]);
        Self { line, start, part }
    }

    /// A value inside the JSON value of this mark.
    pub(super) fn inside(mut self, step: Step) -> Self {
        if let Part::Json(path) = &mut self.part
            && let Some(free) = path.iter_mut().find(|step| step.is_none())
        {
            *free = Some(step);
        }
        self
    }
}

/// Something wrong, and where.
#[derive(Debug)]
pub(super) struct Fault {
    pub(super) mark: Mark,
    pub(super) problem: Problem,
}

/// What is wrong with a film, as it is found.
#[derive(Debug, Default)]
pub(super) struct Faults(Vec<Fault>);

impl Faults {
    pub(super) fn push(&mut self, mark: Mark, problem: Problem) {
        self.0.push(Fault { mark, problem });
    }

    /// The value, or its problem noted at `mark`.
    pub(super) fn check<T>(&mut self, mark: Mark, result: Result<T, Problem>) -> Option<T> {
        result.map_err(|problem| self.push(mark, problem)).ok()
    }

    /// Is the last one a JSON text that ended too early?
    pub(super) fn ends_unfinished(&self) -> bool {
        self.0
            .last()
            .is_some_and(|fault| fault.problem.is_unfinished_json())
    }

    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The text that marks point into.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    /// The film's name, as it was given.
    pub(super) file: &'a str,
    pub(super) bytes: &'a [u8],
    /// Of a stream, only the line of this number is here.
    pub(super) only_line: Option<usize>,
}

/// More errors than this help nobody.
const MOST_ERRORS: usize = 1000;

impl Source<'_> {
    /// The faults as the user reads them, in the order of the text.
    pub(super) fn errors(&self, faults: Faults) -> FilmErrors {
        let mut faults = faults.0;
        faults.sort_by_key(|fault| fault.mark.line);
        let more = faults.len().saturating_sub(MOST_ERRORS);
        if more > 0 {
            faults.truncate(MOST_ERRORS + 1);
            if let Some(last) = faults.last_mut() {
                last.problem = Problem::TooMany { more };
            }
        }
        let file: Arc<str> = self.file.into();
        let mut errors: Vec<FilmError> = faults
            .into_iter()
            .map(|fault| FilmError::new(fault.problem, self.excerpt(&file, fault.mark)))
            .collect();
        errors.sort_by_key(|error| (error.line(), error.column()));
        FilmErrors::new(self.file, errors)
    }

    fn excerpt(&self, file: &Arc<str>, mark: Mark) -> Excerpt {
        // A stream's earlier lines are gone: the line that revealed the error
        // stands in for them.
        if let Some(line) = self.only_line.filter(|line| *line != mark.line) {
            return Excerpt::new(file, line, self.bytes, 0, self.bytes.len());
        }
        let rest = self.bytes.get(mark.start..).unwrap_or_default();
        let line = rest.split(|b| *b == b'\n').next().unwrap_or_default();
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let (from, to) = match mark.part {
            Part::Span(from, to) => (from, to),
            Part::Json(path) => match std::str::from_utf8(line) {
                Ok(text) => {
                    let range = locate(text, path.iter().flatten().copied());
                    (range.start, range.end)
                }
                Err(_) => (0, line.len()),
            },
        };
        Excerpt::new(file, mark.line, line, from, to)
    }
}

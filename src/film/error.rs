//! The errors of a film, all in one go, each with its place.

use std::fmt;
use std::sync::Arc;

use miette::{Diagnostic, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan};
use thiserror::Error;

use super::problem::Problem;

/// Everything that is wrong with a film, in the order of its lines.
#[derive(Debug, Error, Diagnostic)]
#[error("{file} is not a film: {} error{}", errors.len(), if errors.len() == 1 { "" } else { "s" })]
pub struct FilmErrors {
    file: String,
    #[related]
    errors: Vec<FilmError>,
}

impl FilmErrors {
    pub(super) fn new(file: &str, errors: Vec<FilmError>) -> Self {
        Self {
            file: file.to_owned(),
            errors,
        }
    }

    /// One error that has no place in the text.
    pub(super) fn of_file(file: &str, problem: Problem) -> Self {
        let error = FilmError {
            problem,
            excerpt: None,
        };
        Self::new(file, vec![error])
    }

    /// The film's name, as it was given.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The errors, at least one.
    pub fn errors(&self) -> &[FilmError] {
        &self.errors
    }
}

/// One error of a film.
#[derive(Debug, Error)]
#[error("{problem}")]
pub struct FilmError {
    problem: Problem,
    excerpt: Option<Excerpt>,
}

impl FilmError {
    pub(super) fn new(problem: Problem, excerpt: Excerpt) -> Self {
        Self {
            problem,
            excerpt: Some(excerpt),
        }
    }

    /// What is wrong.
    pub fn problem(&self) -> &Problem {
        &self.problem
    }

    /// The line, from 1; `None` where the error is about the whole file.
    pub fn line(&self) -> Option<usize> {
        self.excerpt.as_ref().map(|e| e.line)
    }

    /// The column in characters, from 1.
    pub fn column(&self) -> Option<usize> {
        self.excerpt.as_ref().map(|e| e.column)
    }
}

impl Diagnostic for FilmError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        let hint = self.problem.hint();
        // Without a line to label, what was expected is said here.
        let text = match (&self.excerpt, hint) {
            (Some(_), hint) => hint?,
            (None, None) => self.problem.expected(),
            (None, Some(hint)) => format!("{}; {hint}", self.problem.expected()),
        };
        Some(Box::new(text))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt.as_ref().map(|e| e as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let excerpt = self.excerpt.as_ref()?;
        let label = LabeledSpan::new_with_span(Some(self.problem.expected()), excerpt.marked);
        Some(Box::new(std::iter::once(label)))
    }

    fn diagnostic_source(&self) -> Option<&dyn Diagnostic> {
        None
    }
}

/// The part of one line that an error shows. Whole files are not kept: a film
/// may be large, and its errors many.
#[derive(Debug)]
pub(super) struct Excerpt {
    file: Arc<str>,
    line: usize,
    column: usize,
    /// The line, or a window of it where it is long, without control characters.
    text: String,
    /// Characters of the line before `text`.
    skipped: usize,
    /// The place, in bytes of `text`.
    marked: SourceSpan,
}

/// How many characters of a line are shown before and after the place.
const WINDOW: usize = 48;

impl Excerpt {
    /// Shows `bytes[from..to]` of the line `bytes`, which is line number `line`.
    pub(super) fn new(file: &Arc<str>, line: usize, bytes: &[u8], from: usize, to: usize) -> Self {
        let from = from.min(bytes.len());
        let to = to.clamp(from, bytes.len());
        let lossy = |part: &[u8]| -> Vec<char> {
            let text = String::from_utf8_lossy(part);
            text.chars().map(printable).collect()
        };
        let before = lossy(&bytes[..from]);
        let inside = lossy(&bytes[from..to]);
        let after = lossy(&bytes[to..]);
        let skipped = before.len().saturating_sub(WINDOW);
        let mut text = String::new();
        // What is left out is one sign in the place of one character.
        if skipped > 0 {
            text.push('…');
        }
        text.extend(&before[skipped + usize::from(skipped > 0)..]);
        let start = text.len();
        text.extend(inside.iter().take(WINDOW));
        let length = text.len() - start;
        if inside.len() <= WINDOW {
            text.extend(after.iter().take(WINDOW));
        }
        if inside.len() > WINDOW || after.len() > WINDOW {
            text.push('…');
        }
        Self {
            file: file.clone(),
            line,
            column: before.len() + 1,
            text,
            skipped,
            marked: (start, length).into(),
        }
    }
}

/// Control characters would change the terminal, not the message.
fn printable(c: char) -> char {
    match c {
        '\t' => ' ',
        c if c.is_control() => char::REPLACEMENT_CHARACTER,
        c => c,
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn miette::SpanContents<'a> + 'a>, MietteError> {
        // Asked without context, the answer begins at the span itself.
        let bare = lines_before == 0 && lines_after == 0;
        let range = if bare {
            span.offset()..span.offset() + span.len()
        } else {
            0..self.text.len()
        };
        let (start, length) = (range.start, range.len());
        let data = self.text.get(range).ok_or(MietteError::OutOfBounds)?;
        let before = self.text[..start].chars().count();
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.to_string(),
            data.as_bytes(),
            (start, length).into(),
            self.line - 1,
            self.skipped + before,
            1,
        )))
    }
}

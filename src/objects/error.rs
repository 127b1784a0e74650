//! What is wrong with the objects of a film: everything in one go.

use std::path::{Path, PathBuf};

use decor_api::AdapterError;
use miette::{Diagnostic, NamedSource, SourceSpan};
use thiserror::Error;

use super::mesh_file::MeshError;

/// All that is wrong with the objects of a film.
#[derive(Debug, Error, Diagnostic)]
#[error("{} problem{} with the objects of the film", problems.len(), if problems.len() == 1 { "" } else { "s" })]
pub struct ObjectError {
    /// At least one, in the order of the film.
    #[related]
    pub problems: Vec<ObjectProblem>,
}

impl ObjectError {
    /// Did the user stop the run?
    pub fn is_cancelled(&self) -> bool {
        let cancelled = |p: &ObjectProblem| {
            matches!(
                p,
                ObjectProblem::Inspection {
                    source: AdapterError::Cancelled,
                    ..
                }
            )
        };
        self.problems.iter().any(cancelled)
    }

    /// Is it the renderer that failed, and not one of the user's files?
    pub fn is_renderer(&self) -> bool {
        let renderer = |p: &ObjectProblem| {
            matches!(p, ObjectProblem::Inspection { source, .. }
                if !matches!(source, AdapterError::BadInput { .. } | AdapterError::Unsupported { .. }))
        };
        self.problems.iter().all(renderer)
    }
}

/// One thing that is wrong with one object.
#[derive(Debug, Error, Diagnostic)]
pub enum ObjectProblem {
    /// The path is absolute, or leaves its folder through `..`.
    #[error("{}: leaves the folder {}", path.display(), folder.display())]
    #[diagnostic(help("--allow-outside allows it"))]
    Outside {
        /// The path as it was written.
        path: PathBuf,
        /// The folder that it should stay in.
        folder: PathBuf,
    },
    /// No such file.
    #[error("{}: there is no {}", path.display(), list(tried, " or "))]
    Missing {
        /// The path as it was written.
        path: PathBuf,
        /// The files that were looked for.
        tried: Vec<PathBuf>,
    },
    /// The ending says nothing.
    #[error("{}: objects end in {}", path.display(), super::library::ENDINGS.join(", "))]
    UnknownEnding {
        /// The path as it was written.
        path: PathBuf,
    },
    /// Reading a file failed.
    #[error("{}: cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// A text does not say what it should.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Text(#[from] Box<TextError>),
    /// A mesh file does not hold a mesh.
    #[error("{}: cannot be read as a mesh", path.display())]
    Mesh {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: MeshError,
    },
    /// The renderer does not read fragments of this kind.
    #[error("{}: {adapter} does not read .{language} fragments", path.display())]
    #[diagnostic(help("describe the object in a .ron file, or use another --renderer"))]
    Fragment {
        /// The file.
        path: PathBuf,
        /// The adapter.
        adapter: String,
        /// The fragment's ending.
        language: String,
    },
    /// The renderer could not say how large fragments are.
    #[error("{}: the renderer could not look at it", list(paths, ", "))]
    Inspection {
        /// The fragments that it was asked about.
        paths: Vec<PathBuf>,
        /// Why.
        #[source]
        source: AdapterError,
    },
}

fn list(paths: &[PathBuf], between: &str) -> String {
    let names: Vec<String> = paths.iter().map(|p| p.display().to_string()).collect();
    names.join(between)
}

/// An error and its causes, in one line.
pub(super) fn with_causes(error: &dyn std::error::Error) -> String {
    let causes = std::iter::successors(Some(error), |e| e.source());
    let causes: Vec<String> = causes.map(ToString::to_string).collect();
    causes.join(": ")
}

/// A place in one of the user's texts, and what is wrong there.
#[derive(Debug, Error, Diagnostic)]
#[error("{}:{line}:{column}: {reason}", path.display())]
pub struct TextError {
    /// The file.
    pub path: PathBuf,
    /// Counted from 1.
    pub line: usize,
    /// Counted from 1, in characters.
    pub column: usize,
    /// What is wrong, and what was expected.
    pub reason: String,
    #[source_code]
    text: NamedSource<String>,
    #[label("here")]
    at: SourceSpan,
}

impl TextError {
    /// About the bytes `start..end` of `text`.
    pub(super) fn at(
        path: &Path,
        text: &str,
        start: usize,
        end: usize,
        reason: String,
    ) -> Box<Self> {
        let start = char_start(text, start);
        let end = char_start(text, end).max(start);
        let before = &text[..start];
        let line_start = before.rfind('\n').map_or(0, |i| i + 1);
        Box::new(Self {
            path: path.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            reason,
            text: NamedSource::new(path.display().to_string(), text.to_owned()),
            at: (start, end - start).into(),
        })
    }
}

/// The start of the character that byte `at` belongs to.
fn char_start(text: &str, at: usize) -> usize {
    let mut at = at.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

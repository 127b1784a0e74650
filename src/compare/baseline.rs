//! Reference frames that are kept in a folder: comparing with them, and replacing
//! them on purpose.
//!
//! Replaced are the references that the comparison does not find within its
//! tolerance; one that is within stays, so that nothing changes without a reason.
//! Either all are replaced or, where a new frame cannot be read, none.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::folders::{self, Match, PairingError};
use super::verdict::Verdict;
use super::{Comparison, Entry};
use crate::frames::{WriteError, write_safely};

/// What was done to a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Action {
    /// There was none.
    Added,
    /// There was another.
    Replaced,
    /// There is no such frame any more.
    Removed,
}

impl Action {
    /// In a word.
    pub fn words(self) -> &'static str {
        match self {
            Self::Added => "added",
            Self::Replaced => "replaced",
            Self::Removed => "removed",
        }
    }
}

/// A reference that was changed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// What was done.
    pub action: Action,
    /// The frame's name.
    pub name: String,
}

/// Why references were not replaced.
#[derive(Debug, thiserror::Error)]
pub enum UpdateError {
    /// A new frame cannot be read, or is gone: nothing was replaced.
    #[error("nothing was replaced: the new frame {} cannot be read", path.display())]
    Frame {
        /// The frame.
        path: PathBuf,
        /// Why, where the file system says it.
        #[source]
        source: Option<std::io::Error>,
    },
    /// A reference cannot be written or removed.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Are the two folders one? Frames are always equal to themselves.
pub fn same_folder(references: &Path, frames: &Path) -> bool {
    match (references.canonicalize(), frames.canonicalize()) {
        (Ok(references), Ok(frames)) => references == frames,
        _ => false,
    }
}

/// Pairs references with frames as [`folders::pair`] does; where there is no
/// folder of references yet, or none in it, every frame is new.
///
/// # Errors
/// As of [`folders::pair`], but for that.
pub fn pair_for_update(references: &Path, frames: &Path) -> Result<Vec<Match>, PairingError> {
    let matches = folders::pair(references, frames);
    let none_yet = match &matches {
        Err(PairingError::Empty { folder }) => folder == references,
        Err(PairingError::Io { path, source }) => {
            path == references && source.kind() == ErrorKind::NotFound
        }
        _ => false,
    };
    if none_yet {
        folders::unpaired(frames, folders::Side::A)
    } else {
        matches
    }
}

/// Replaces the references that are not within the tolerance by the frames they
/// were compared with. A is the folder of references.
///
/// # Errors
/// Where a frame cannot be read (then nothing is changed) or a reference not be
/// written.
pub fn update(
    comparison: &Comparison,
    references: &Path,
    frames: &Path,
) -> Result<Vec<Change>, UpdateError> {
    // What is unreadable must be found before anything is changed.
    for entry in &comparison.entries {
        if let Entry::Pair(pair) = entry
            && pair.verdict == Verdict::Unreadable
            && pair.sizes.1.is_none()
        {
            let (path, source) = (pair.b.clone(), None);
            return Err(UpdateError::Frame { path, source });
        }
    }
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| WriteError::Io { path, source }
    };
    std::fs::create_dir_all(references).map_err(io(references))?;
    let mut changes = Vec::new();
    for entry in &comparison.entries {
        let name = entry.name().to_owned();
        let action = match entry {
            Entry::Pair(pair) if pair.verdict == Verdict::Within => continue,
            Entry::Pair(pair) => {
                let own_name = pair.b.file_name().unwrap_or(pair.b.as_os_str());
                let new = references.join(own_name);
                copy(&pair.b, &new)?;
                // A reference of another format would be a second of the name.
                if new != pair.a {
                    std::fs::remove_file(&pair.a).map_err(io(&pair.a))?;
                }
                Action::Replaced
            }
            Entry::Missing { name, from } => match from {
                folders::Side::A => {
                    copy(&frames.join(name), &references.join(name))?;
                    Action::Added
                }
                folders::Side::B => {
                    let path = references.join(name);
                    std::fs::remove_file(&path).map_err(io(&path))?;
                    Action::Removed
                }
            },
        };
        changes.push(Change { action, name });
    }
    Ok(changes)
}

fn copy(frame: &Path, reference: &Path) -> Result<(), UpdateError> {
    let bytes = std::fs::read(frame).map_err(|source| UpdateError::Frame {
        path: frame.to_owned(),
        source: Some(source),
    })?;
    Ok(write_safely(reference, &bytes)?)
}

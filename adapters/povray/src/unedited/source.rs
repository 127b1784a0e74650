//! The text of a scene: the file itself and all that it includes, and copies of
//! them with pieces replaced.

use std::ops::Range;
use std::path::{Path, PathBuf};

use decor_api::AdapterError;

use crate::PovRay;
use crate::plain::PlainScene;

/// A file of the scene.
#[derive(Clone, Debug)]
pub struct SourceFile {
    /// Where it is.
    pub path: PathBuf,
    /// What it is called in messages: its name without folder.
    pub name: String,
    /// Its text.
    pub text: Vec<u8>,
    /// Is it one of POV-Ray's own include files?
    pub library: bool,
}

/// A scene and its includes, each once. The first file is the scene.
#[derive(Clone, Debug)]
pub struct Sources {
    /// The files.
    pub files: Vec<SourceFile>,
}

/// A piece of a file, and what a copy has in its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Edit {
    /// Which file of [`Sources::files`].
    pub file: usize,
    /// Which bytes of it; an empty range inserts.
    pub range: Range<usize>,
    /// What stands there instead.
    pub text: String,
}

/// A copy of a scene in a folder.
#[derive(Clone, Debug)]
pub struct Copy {
    /// Switches that follow the scene's own: with them, POV-Ray renders the copy
    /// where it would have rendered the scene. The working folder is still the
    /// scene's own ([`PlainScene::folder`]).
    pub switches: Vec<String>,
}

impl Sources {
    /// Reads a scene's files.
    ///
    /// # Errors
    /// [`AdapterError::Io`] where the scene itself cannot be read.
    pub fn read(_povray: &PovRay, scene: &PlainScene) -> Result<Self, AdapterError> {
        let path = scene.files.first().cloned().unwrap_or_default();
        let text = std::fs::read(&path).map_err(AdapterError::io(&path))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            files: vec![SourceFile {
                name: name.into_owned(),
                path,
                text,
                library: false,
            }],
        })
    }

    /// The line of a byte, from 1.
    pub fn line(&self, file: usize, at: usize) -> usize {
        let text = self.files.get(file).map_or(&[][..], |file| &file.text);
        1 + text.iter().take(at).filter(|byte| **byte == b'\n').count()
    }

    /// Inserts `text` behind everything else in the scene.
    pub fn behind(&self, text: impl Into<String>) -> Edit {
        let end = self.files.first().map_or(0, |file| file.text.len());
        Edit {
            file: 0,
            range: end..end,
            // The last line may be a comment.
            text: format!("\n{}", text.into()),
        }
    }

    /// Writes a copy of the scene with pieces replaced into the folder `to`.
    /// Edits may not overlap; those at one place keep their order.
    ///
    /// # Errors
    /// [`AdapterError::Io`].
    pub fn rewritten(&self, edits: &[Edit], to: &Path) -> Result<Copy, AdapterError> {
        let _ = (edits, to);
        Err(AdapterError::BadInput {
            file: self
                .files
                .first()
                .map(|f| f.path.clone())
                .unwrap_or_default(),
            reason: "decor makes no copies yet".into(),
        })
    }
}

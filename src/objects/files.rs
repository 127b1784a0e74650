//! Reading the files of one description: inside its folder, once, and with a
//! hash of all that was read.

use std::fs;
use std::io;
use std::path::{Component, Path, PathBuf};

use super::error::ObjectProblem;

/// What is wrong with a file that a description names.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The path is absolute, or leaves its folder through `..`.
    #[error("{} leaves the folder {}", path.display(), folder.display())]
    Outside {
        /// The path as it was written.
        path: PathBuf,
        /// The folder that it should stay in.
        folder: PathBuf,
    },
    /// No such file.
    #[error("there is no file {}", .0.display())]
    Missing(PathBuf),
    /// Reading failed.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: io::Error,
    },
}

impl FileError {
    /// As a problem of the object that the film calls `path`, and that this
    /// file describes.
    pub(super) fn into_problem(self, path: &Path) -> ObjectProblem {
        let path = path.to_owned();
        match self {
            Self::Outside { folder, .. } => ObjectProblem::Outside { path, folder },
            Self::Missing(file) => ObjectProblem::Missing {
                path,
                tried: vec![file],
            },
            Self::Io { source, .. } => ObjectProblem::Io { path, source },
        }
    }
}

/// Does the path stay in the folder that it starts from? Links are not followed:
/// who puts a link into a folder means it.
pub(super) fn stays_inside(path: &Path) -> bool {
    let mut depth = 0_i64;
    for component in path.components() {
        match component {
            Component::Prefix(_) | Component::RootDir => return false,
            Component::ParentDir => depth -= 1,
            Component::CurDir => {}
            Component::Normal(_) => depth += 1,
        }
        if depth < 0 {
            return false;
        }
    }
    true
}

/// The files of one description.
pub(super) struct Files {
    allow_outside: bool,
    hasher: blake3::Hasher,
}

impl Files {
    pub(super) fn new(allow_outside: bool) -> Self {
        Self {
            allow_outside,
            hasher: blake3::Hasher::new(),
        }
    }

    /// The bytes of a file.
    pub(super) fn read(&mut self, path: &Path) -> Result<Vec<u8>, FileError> {
        let failed = |source: io::Error| match source.kind() {
            io::ErrorKind::NotFound => FileError::Missing(path.to_owned()),
            _ => FileError::Io {
                path: path.to_owned(),
                source,
            },
        };
        // A pipe would wait for ever, a device never end.
        if !fs::metadata(path).map_err(failed)?.is_file() {
            return Err(failed(io::Error::other("not a regular file")));
        }
        let bytes = fs::read(path).map_err(failed)?;
        // The ending says how the bytes are read: it is content too.
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        hash_part(&mut self.hasher, ending.as_encoded_bytes());
        hash_part(&mut self.hasher, &bytes);
        Ok(bytes)
    }

    /// The path of a file that the description at `from` names.
    pub(super) fn beside(&self, from: &Path, named: &str) -> Result<PathBuf, FileError> {
        let folder = from.parent().unwrap_or(Path::new(""));
        if !self.allow_outside && !stays_inside(Path::new(named)) {
            return Err(FileError::Outside {
                path: PathBuf::from(named),
                folder: folder.to_owned(),
            });
        }
        Ok(folder.join(named))
    }

    /// The hash of all that was read, in order, in hexadecimal.
    pub(super) fn hash(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

/// Adds a part with its length: parts cannot run into each other.
pub(super) fn hash_part(hasher: &mut blake3::Hasher, part: &[u8]) {
    hasher.update(&(part.len() as u64).to_le_bytes());
    hasher.update(part);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_paths_that_go_up_leave() {
        for inside in ["a", "a/b.ron", "./a", "a/../b", "a/b/../../c"] {
            assert!(stays_inside(Path::new(inside)), "{inside}");
        }
        for outside in ["/a", "..", "../a", "a/../../b"] {
            assert!(!stays_inside(Path::new(outside)), "{outside}");
        }
    }

    #[test]
    fn a_folder_is_not_a_file() {
        let folder = tempfile::tempdir().unwrap();
        let error = Files::new(false).read(folder.path()).unwrap_err();
        assert!(matches!(error, FileError::Io { .. }), "{error}");
    }
}

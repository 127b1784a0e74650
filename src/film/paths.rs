//! From a path in a film to a file in its folder.

use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use super::problem::Problem;

/// The endings of object descriptions.
const ENDINGS: [&str; 8] = ["inc", "pov", "ron", "obj", "ply", "stl", "gltf", "glb"];

/// What a path without an ending may mean, in this order: the thesis names its
/// descriptions so.
const TRIED: [&str; 3] = ["inc", "pov", "ron"];

/// Where a film's paths lead.
#[derive(Clone, Debug)]
pub(super) struct Folder {
    path: PathBuf,
    allow_outside: bool,
}

impl Folder {
    pub(super) fn new(path: &Path, allow_outside: bool) -> Self {
        let path = if path.as_os_str().is_empty() {
            Path::new(".")
        } else {
            path
        };
        Self {
            // Without a working directory, the path as it is has to do.
            path: std::path::absolute(path).unwrap_or_else(|_| path.to_owned()),
            allow_outside,
        }
    }

    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The file of an object's description.
    pub(super) fn description(&self, stated: &str) -> Result<PathBuf, Problem> {
        let path = self.inside(stated)?;
        let Some(ending) = path.extension() else {
            return self.with_ending(stated, &path);
        };
        let ending = ending.to_string_lossy();
        if !ENDINGS.contains(&&*ending) {
            return Err(Problem::UnknownEnding {
                ending: ending.into_owned(),
            });
        }
        existing(stated, path)
    }

    /// A renderer-native file: its ending is the renderer's business.
    pub(super) fn native(&self, stated: &str) -> Result<PathBuf, Problem> {
        existing(stated, self.inside(stated)?)
    }

    fn with_ending(&self, stated: &str, path: &Path) -> Result<PathBuf, Problem> {
        for ending in TRIED {
            let candidate = path.with_extension(ending);
            if candidate.is_file() {
                return Ok(candidate);
            }
        }
        Err(Problem::MissingFile {
            path: stated.to_owned(),
            tried: TRIED.iter().map(|e| format!("{stated}.{e}")).collect(),
        })
    }

    /// The path without its `.` and `..`, so that the file system cannot lead
    /// out through a link what stays inside by name.
    fn inside(&self, stated: &str) -> Result<PathBuf, Problem> {
        writable("the path", stated)?;
        if stated.is_empty() {
            return Err(Problem::EmptyPath);
        }
        let path = Path::new(stated);
        if self.allow_outside {
            return named(stated, self.path.join(path));
        }
        let mut kept = PathBuf::new();
        for component in path.components() {
            match component {
                Component::Prefix(_) | Component::RootDir => {
                    return Err(Problem::AbsolutePath {
                        path: stated.to_owned(),
                    });
                }
                Component::CurDir => {}
                Component::ParentDir => {
                    if !kept.pop() {
                        return Err(Problem::LeavesFolder {
                            path: stated.to_owned(),
                        });
                    }
                }
                Component::Normal(name) => kept.push(name),
            }
        }
        named(stated, self.path.join(kept))
    }
}

/// Can both forms of a film hold this text?
pub(super) fn writable(what: &'static str, text: &str) -> Result<(), Problem> {
    if text.chars().any(|c| c == '"' || c.is_control()) {
        return Err(Problem::Unwritable { what });
    }
    Ok(())
}

/// `.`, `..` and the like name a folder, and take no ending.
fn named(stated: &str, path: PathBuf) -> Result<PathBuf, Problem> {
    if Path::new(stated).file_name().is_none() {
        return Err(Problem::NotAFile {
            path: stated.to_owned(),
        });
    }
    Ok(path)
}

fn existing(stated: &str, path: PathBuf) -> Result<PathBuf, Problem> {
    let stated = || stated.to_owned();
    match std::fs::metadata(&path) {
        Ok(found) if found.is_file() => Ok(path),
        Ok(_) => Err(Problem::NotAFile { path: stated() }),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
            Err(Problem::MissingFile {
                path: stated(),
                tried: Vec::new(),
            })
        }
        Err(source) => Err(Problem::UnreachableFile {
            path: stated(),
            source,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, Folder) {
        let temp = tempfile::tempdir().unwrap();
        std::fs::create_dir(temp.path().join("sub")).unwrap();
        for name in ["a.inc", "a.ron", "b.ron", "sub/c.obj"] {
            std::fs::write(temp.path().join(name), "").unwrap();
        }
        let folder = Folder::new(temp.path(), false);
        (temp, folder)
    }

    #[test]
    fn a_path_without_an_ending_is_tried_in_order() {
        let (temp, folder) = folder();
        assert_eq!(folder.description("a").unwrap(), temp.path().join("a.inc"));
        assert_eq!(folder.description("b").unwrap(), temp.path().join("b.ron"));
        assert!(matches!(
            folder.description("c"),
            Err(Problem::MissingFile { tried, .. }) if tried == ["c.inc", "c.pov", "c.ron"]
        ));
    }

    #[test]
    fn a_path_may_turn_back_but_not_leave() {
        let (temp, folder) = folder();
        let file = folder.description("sub/../sub/./c.obj").unwrap();
        assert_eq!(file, temp.path().join("sub/c.obj"));
        for path in ["../a.inc", "sub/../../a.inc", ".."] {
            let result = folder.description(path);
            assert!(
                matches!(result, Err(Problem::LeavesFolder { .. })),
                "{path}"
            );
        }
        let absolute = temp.path().join("a.inc");
        let absolute = absolute.to_str().unwrap();
        assert!(matches!(
            folder.description(absolute),
            Err(Problem::AbsolutePath { .. })
        ));
        let free = Folder::new(&temp.path().join("sub"), true);
        assert!(free.description("../a.inc").is_ok());
        assert!(free.description(absolute).is_ok());
    }

    #[test]
    fn what_is_no_file_is_refused() {
        let (_temp, folder) = folder();
        assert!(matches!(
            folder.native("sub"),
            Err(Problem::NotAFile { .. })
        ));
        for path in [".", "sub/.."] {
            let result = folder.description(path);
            assert!(matches!(result, Err(Problem::NotAFile { .. })), "{path}");
        }
        assert!(matches!(
            folder.native("a.inc/b"),
            Err(Problem::MissingFile { .. })
        ));
        assert!(matches!(folder.native(""), Err(Problem::EmptyPath)));
        assert!(matches!(
            folder.native("a\0"),
            Err(Problem::Unwritable { .. })
        ));
        assert!(matches!(
            folder.description("a.mp3"),
            Err(Problem::UnknownEnding { .. })
        ));
    }
}

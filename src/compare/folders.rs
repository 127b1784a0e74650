//! Which picture is compared with which: two files, or the frames of two
//! folders, paired by name. Nothing is left out silently.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

/// The first or the second argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The first.
    A,
    /// The second.
    B,
}

impl Side {
    /// `A` or `B`.
    pub fn letter(self) -> char {
        match self {
            Self::A => 'A',
            Self::B => 'B',
        }
    }
}

/// A picture of one side and its partner, if it has one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Match {
    /// Two pictures to compare.
    Pair {
        /// The file name of the first.
        name: String,
        /// The first picture.
        a: PathBuf,
        /// The second picture.
        b: PathBuf,
    },
    /// A picture without a partner.
    Missing {
        /// Its file name.
        name: String,
        /// Where it is not.
        from: Side,
    },
}

impl Match {
    /// The file name; of a pair, the first's.
    pub fn name(&self) -> &str {
        match self {
            Self::Pair { name, .. } | Self::Missing { name, .. } => name,
        }
    }
}

/// Why there is nothing to compare.
#[derive(Debug, thiserror::Error)]
pub enum PairingError {
    /// The file system says no.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// One is a folder, the other is not.
    #[error("{} is a folder, {} is a file", folder.display(), file.display())]
    FileAndFolder {
        /// The folder.
        folder: PathBuf,
        /// The file.
        file: PathBuf,
    },
    /// A folder without pictures.
    #[error("{} has no pictures (.png, .exr)", folder.display())]
    Empty {
        /// The folder.
        folder: PathBuf,
    },
}

/// Pairs two files, or the pictures of two folders: first by the whole name,
/// then, of what is left, by the name without its ending where that is
/// unambiguous (`frame_0001.png` and `frame_0001.exr`). In the order of the
/// names. Folders are not entered further; files of other endings are ignored.
///
/// # Errors
/// Where one of them is not there, they are of different kinds, or a folder has
/// no picture.
pub fn pair(a: &Path, b: &Path) -> Result<Vec<Match>, PairingError> {
    match (is_folder(a)?, is_folder(b)?) {
        (false, false) => {
            let name = a.file_name().unwrap_or(a.as_os_str());
            Ok(vec![Match::Pair {
                name: name.to_string_lossy().into_owned(),
                a: a.to_owned(),
                b: b.to_owned(),
            }])
        }
        (true, true) => Ok(pair_names(a, b, pictures(a)?, pictures(b)?)),
        (true, false) => Err(PairingError::FileAndFolder {
            folder: a.to_owned(),
            file: b.to_owned(),
        }),
        (false, true) => Err(PairingError::FileAndFolder {
            folder: b.to_owned(),
            file: a.to_owned(),
        }),
    }
}

/// The pictures of a folder, each without a partner in `from`.
///
/// # Errors
/// Where it is no folder, cannot be read, or has no picture.
pub fn unpaired(folder: &Path, from: Side) -> Result<Vec<Match>, PairingError> {
    let missing = |name: OsString| Match::Missing {
        name: name.to_string_lossy().into_owned(),
        from,
    };
    Ok(pictures(folder)?.into_iter().map(missing).collect())
}

fn is_folder(path: &Path) -> Result<bool, PairingError> {
    let metadata = std::fs::metadata(path).map_err(|source| PairingError::Io {
        path: path.to_owned(),
        source,
    })?;
    Ok(metadata.is_dir())
}

/// The names of the pictures in a folder.
fn pictures(folder: &Path) -> Result<BTreeSet<OsString>, PairingError> {
    let io = |source| PairingError::Io {
        path: folder.to_owned(),
        source,
    };
    let mut names = BTreeSet::new();
    for entry in std::fs::read_dir(folder).map_err(io)? {
        let name = entry.map_err(io)?.file_name();
        let ending = Path::new(&name).extension().unwrap_or_default();
        let picture = ["png", "exr"]
            .iter()
            .any(|e| ending.eq_ignore_ascii_case(e));
        // A link that leads nowhere stays in: it will be unreadable, and said so.
        if picture && !folder.join(&name).is_dir() {
            names.insert(name);
        }
    }
    if names.is_empty() {
        return Err(PairingError::Empty {
            folder: folder.to_owned(),
        });
    }
    Ok(names)
}

fn pair_names(
    a: &Path,
    b: &Path,
    names_a: BTreeSet<OsString>,
    names_b: BTreeSet<OsString>,
) -> Vec<Match> {
    let mut partners: Vec<(&OsStr, &OsStr)> = names_a
        .intersection(&names_b)
        .map(|name| (name.as_os_str(), name.as_os_str()))
        .collect();
    let mut only_a: BTreeSet<&OsStr> = names_a
        .difference(&names_b)
        .map(|n| n.as_os_str())
        .collect();
    let mut only_b: BTreeSet<&OsStr> = names_b
        .difference(&names_a)
        .map(|n| n.as_os_str())
        .collect();
    let (stems_a, stems_b) = (by_stem(&only_a), by_stem(&only_b));
    for (stem, of_a) in &stems_a {
        if let ([a], Some([b])) = (of_a.as_slice(), stems_b.get(stem).map(Vec::as_slice)) {
            partners.push((a, b));
            only_a.remove(a);
            only_b.remove(b);
        }
    }
    let words = |name: &OsStr| name.to_string_lossy().into_owned();
    let mut matches: Vec<Match> = partners
        .into_iter()
        .map(|(name_a, name_b)| Match::Pair {
            name: words(name_a),
            a: a.join(name_a),
            b: b.join(name_b),
        })
        .collect();
    for (names, from) in [(&only_a, Side::B), (&only_b, Side::A)] {
        matches.extend(names.iter().map(|name| Match::Missing {
            name: words(name),
            from,
        }));
    }
    matches.sort_by(|one, other| one.name().cmp(other.name()));
    matches
}

fn by_stem<'a>(names: &BTreeSet<&'a OsStr>) -> BTreeMap<&'a OsStr, Vec<&'a OsStr>> {
    let mut stems: BTreeMap<&OsStr, Vec<&OsStr>> = BTreeMap::new();
    for &name in names {
        let stem = Path::new(name).file_stem().unwrap_or(name);
        stems.entry(stem).or_default().push(name);
    }
    stems
}

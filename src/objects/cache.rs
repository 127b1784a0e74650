//! A folder of small things that were expensive to find out, by what they
//! depend on. Not a store of pictures.
//!
//! One JSON file an entry, named by the hash of its key, written beside and
//! renamed: processes that run at the same time see a whole entry or none. The
//! cache never fails a run. An entry that cannot be read is as good as none,
//! and is written again; one that cannot be written is found out again.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use etcetera::BaseStrategy;
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The folder to use instead of the user's cache folder.
pub const FOLDER_VARIABLE: &str = "DECOR_CACHE";

/// Part of every key: entries of another layout are not looked at.
const VERSION: u32 = 1;

/// A content-addressed cache folder.
#[derive(Clone, Debug)]
pub struct Cache {
    folder: Option<PathBuf>,
}

impl Cache {
    /// The folder that `DECOR_CACHE` names, else `decor` in the user's cache
    /// folder (`$XDG_CACHE_HOME`, `~/.cache`). Nothing is created before the
    /// first entry. Without a home folder nothing is kept.
    pub fn open() -> Self {
        let stated = std::env::var_os(FOLDER_VARIABLE).filter(|f| !f.is_empty());
        let usual = || {
            let strategy = etcetera::choose_base_strategy().ok()?;
            Some(strategy.cache_dir().join("decor"))
        };
        Self {
            folder: stated.map(PathBuf::from).or_else(usual),
        }
    }

    /// A cache in that folder.
    pub fn in_folder(folder: impl Into<PathBuf>) -> Self {
        Self {
            folder: Some(folder.into()),
        }
    }

    /// A cache that keeps nothing.
    pub fn disabled() -> Self {
        Self { folder: None }
    }

    /// The folder, where there is one. It need not exist.
    pub fn folder(&self) -> Option<&Path> {
        self.folder.as_deref()
    }

    /// What was kept under `key`. `kind` says what sort of thing it is, and
    /// changes with its layout.
    pub fn get<T: DeserializeOwned>(&self, kind: &str, key: &[u8]) -> Option<T> {
        let file = self.file(kind, key)?;
        let text = match fs::read(&file) {
            Ok(text) => text,
            Err(error) => {
                if error.kind() != std::io::ErrorKind::NotFound {
                    tracing::debug!(file = %file.display(), %error, "cache entry not read");
                }
                return None;
            }
        };
        match serde_json::from_slice(&text) {
            Ok(value) => Some(value),
            Err(error) => {
                tracing::debug!(file = %file.display(), %error, "cache entry ignored");
                None
            }
        }
    }

    /// Keeps `value` under `key`, over what was there.
    pub fn put<T: Serialize>(&self, kind: &str, key: &[u8], value: &T) {
        let Some(file) = self.file(kind, key) else {
            return;
        };
        if let Err(error) = write(&file, value) {
            tracing::debug!(file = %file.display(), %error, "cache entry not written");
        }
    }

    fn file(&self, kind: &str, key: &[u8]) -> Option<PathBuf> {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&VERSION.to_le_bytes());
        hasher.update(&(kind.len() as u64).to_le_bytes());
        hasher.update(kind.as_bytes());
        hasher.update(key);
        let name = format!("{}.json", hasher.finalize().to_hex());
        self.folder.as_ref().map(|folder| folder.join(name))
    }
}

fn write<T: Serialize>(file: &Path, value: &T) -> std::io::Result<()> {
    let folder = file.parent().unwrap_or(Path::new("."));
    fs::create_dir_all(folder)?;
    let mut beside = tempfile::NamedTempFile::new_in(folder)?;
    beside.write_all(&serde_json::to_vec(value)?)?;
    beside.persist(file).map_err(|e| e.error)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_is_got() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path().join("not/there/yet"));
        assert_eq!(cache.get::<Vec<f64>>("spheres", b"a"), None);
        let value = vec![0.1 + 0.2, f64::MIN_POSITIVE, -1e300];
        cache.put("spheres", b"a", &value);
        assert_eq!(cache.get("spheres", b"a"), Some(value));
        assert_eq!(cache.get::<Vec<f64>>("spheres", b"b"), None);
        assert_eq!(cache.get::<Vec<f64>>("costs", b"a"), None);
    }

    #[test]
    fn a_corrupt_entry_is_ignored_and_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path());
        cache.put("n", b"k", &7);
        let file = cache.file("n", b"k").unwrap();
        for corrupt in [&b"{"[..], b"", b"\xff\xfe", b"\"seven\""] {
            fs::write(&file, corrupt).unwrap();
            assert_eq!(cache.get::<i32>("n", b"k"), None);
        }
        cache.put("n", b"k", &8);
        assert_eq!(cache.get("n", b"k"), Some(8));
    }

    #[test]
    fn an_impossible_folder_harms_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a file");
        fs::write(&file, "").unwrap();
        for cache in [Cache::in_folder(&file), Cache::disabled()] {
            cache.put("n", b"k", &7);
            assert_eq!(cache.get::<i32>("n", b"k"), None);
        }
    }

    #[test]
    fn many_writers_leave_one_whole_entry() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path());
        let long = |c: char| c.to_string().repeat(100_000);
        std::thread::scope(|scope| {
            for c in ['a', 'b', 'c', 'd'] {
                let (cache, value) = (&cache, long(c));
                scope.spawn(move || {
                    for _ in 0..20 {
                        cache.put("text", b"k", &value);
                        let got: String = cache.get("text", b"k").expect("a whole entry");
                        assert_eq!(got.len(), 100_000);
                    }
                });
            }
        });
        let entries = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(entries, 1, "temporary files were left behind");
    }
}

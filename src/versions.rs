//! Versions of renderers that were asked before. POV-Ray sleeps a fifth of a second
//! until it says its own: of a short film that is the tenth part.
//!
//! A program that is the same file as before has the same version. That holds for
//! binaries only: a script may call another program today than yesterday.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::objects::Cache;

/// The kind of its cache entries.
const KIND: &str = "version-1";

/// The first bytes of a binary.
const BINARY: &[u8] = b"\x7fELF";

/// The version of a program: the one that is known, or what it says now.
///
/// # Errors
/// Those of `ask`.
pub fn version_of<E>(
    program: &Path,
    cache: &Cache,
    ask: impl FnOnce(&Path) -> Result<String, E>,
) -> Result<String, E> {
    let key = binary(program);
    let known = key.as_ref().and_then(|key| cache.get(KIND, key));
    if let Some(version) = known {
        return Ok(version);
    }
    let version = ask(program)?;
    if let Some(key) = key {
        cache.put(KIND, &key, &version);
    }
    Ok(version)
}

/// What tells a binary from every other one, and from itself after a change; none
/// for what is no binary.
#[cfg(unix)]
fn binary(program: &Path) -> Option<Vec<u8>> {
    use std::os::unix::fs::MetadataExt as _;

    let mut file = File::open(program).ok()?;
    let mut first = [0; BINARY.len()];
    file.read_exact(&mut first).ok()?;
    let about = file.metadata().ok()?;
    let stamps = [
        about.mtime(),
        about.mtime_nsec(),
        about.ctime(),
        about.ctime_nsec(),
    ];
    let place = (about.dev(), about.ino(), about.len());
    let path = program.canonicalize().ok()?;
    (first == BINARY).then(|| format!("{} {place:?} {stamps:?}", path.display()).into_bytes())
}

#[cfg(not(unix))]
fn binary(_: &Path) -> Option<Vec<u8>> {
    None
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::convert::Infallible;

    use super::*;

    /// Asks a program so often; what was said each time. It says how often it was
    /// asked in all.
    fn said(program: &Path, cache: &Cache, asked: &Cell<u32>, times: usize) -> Vec<String> {
        let ask = |_: &Path| {
            asked.set(asked.get() + 1);
            Ok::<_, Infallible>(format!("3.{}", asked.get()))
        };
        let once = |_| {
            let Ok(version) = version_of(program, cache, ask);
            version
        };
        (0..times).map(once).collect()
    }

    #[test]
    fn a_binary_is_asked_once_until_it_is_another_one() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path().join("cache"));
        let (program, asked) = (folder.path().join("program"), Cell::new(0));
        let write = |text: &str| std::fs::write(&program, text).unwrap();
        write("\x7fELF one");
        assert_eq!(said(&program, &cache, &asked, 3), ["3.1"; 3]);
        write("\x7fELF another");
        assert_eq!(said(&program, &cache, &asked, 2), ["3.2"; 2]);
        let nothing = Cache::disabled();
        assert_eq!(said(&program, &nothing, &asked, 2), ["3.3", "3.4"]);
    }

    #[test]
    fn a_script_is_asked_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::in_folder(folder.path().join("cache"));
        let (program, asked) = (folder.path().join("script"), Cell::new(0));
        std::fs::write(&program, "#!/bin/sh\nexec povray \"$@\"\n").unwrap();
        assert_eq!(said(&program, &cache, &asked, 2), ["3.1", "3.2"]);
        let missing = folder.path().join("missing");
        assert_eq!(said(&missing, &cache, &asked, 2), ["3.3", "3.4"]);
    }
}

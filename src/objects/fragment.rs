//! Renderer-native fragments: what their first line says, and what they depend
//! on. Not a parser of the renderer's language.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use decor_api::{Bounds, Extent, Fragment, NativeFile, Optics, Said};
use glam::DVec3;

use super::error::TextError;
use super::files::hash_part;

/// Files above this size are hashed, but not searched for further names.
const LARGEST_TEXT: usize = 16 << 20;

/// The sphere of a first line `// bounds: x y z r`, where there is one.
///
/// # Errors
/// Where the line begins so and does not go on with four usable numbers.
pub(super) fn stated_bounds(path: &Path, text: &[u8]) -> Result<Option<Bounds>, Box<TextError>> {
    let line = text.split(|&b| b == b'\n').next().unwrap_or_default();
    let line = String::from_utf8_lossy(line);
    let comment = line.trim_start_matches('\u{feff}').trim();
    let stated = comment
        .strip_prefix("//")
        .and_then(|comment| comment.trim_start().strip_prefix("bounds:"));
    let Some(stated) = stated else {
        return Ok(None);
    };
    let numbers: Vec<f64> = stated
        .split_whitespace()
        .map_while(|word| word.parse().ok())
        .collect();
    let fields = stated.split_whitespace().count();
    let bounds = match numbers[..] {
        [x, y, z, r] if fields == 4 => Bounds::sphere(DVec3::new(x, y, z), r),
        _ => Bounds::Unbounded,
    };
    if bounds == Bounds::Unbounded {
        let start = line.find("bounds:").unwrap_or(0);
        let end = line.trim_end().len();
        let reason = "expected // bounds: x y z r, four finite numbers, r not negative".to_owned();
        // The text may not be UTF-8: its first line is all there is to show.
        return Err(TextError::at(path, &line, start, end, reason));
    }
    Ok(Some(bounds))
}

/// What one text may read.
struct Named {
    /// Its string literals, each perhaps the name of a file.
    literals: Vec<String>,
    /// It reads a file whose name is put together: no one knows which.
    computed: bool,
}

/// Looks for string literals outside of comments, and for `#include` and
/// `#fopen` that are not followed by one.
fn names_in(text: &[u8]) -> Named {
    let mut named = Named {
        literals: Vec::new(),
        computed: false,
    };
    // How many words stand between a directive and its file's name.
    let mut words_before_name: Option<usize> = None;
    let mut i = 0;
    while i < text.len() {
        let rest = &text[i..];
        if rest.starts_with(b"//") {
            i += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        } else if rest.starts_with(b"/*") {
            i += comment_length(rest);
        } else if rest[0] == b'"' {
            let length = literal_length(rest);
            let literal = rest.get(1..length - 1).unwrap_or_default();
            named
                .literals
                .push(String::from_utf8_lossy(literal).into_owned());
            words_before_name = None;
            i += length;
        } else if rest[0] == b'#' {
            let blanks = rest[1..]
                .iter()
                .take_while(|b| b.is_ascii_whitespace())
                .count();
            let word = word_at(&rest[1 + blanks..]);
            words_before_name = match word {
                b"include" => Some(0),
                b"fopen" => Some(1),
                _ => None,
            };
            i += 1 + blanks + word.len();
        } else if rest[0].is_ascii_whitespace() {
            i += 1;
        } else {
            words_before_name = match words_before_name {
                Some(0) => {
                    named.computed = true;
                    None
                }
                Some(words) => Some(words - 1),
                None => None,
            };
            i += word_at(rest).len().max(1);
        }
    }
    named
}

fn word_at(text: &[u8]) -> &[u8] {
    let is_word = |b: &u8| b.is_ascii_alphanumeric() || *b == b'_';
    &text[..text.iter().take_while(|b| is_word(b)).count()]
}

/// Comments of this kind stand in each other.
fn comment_length(text: &[u8]) -> usize {
    let (mut depth, mut i) = (0, 0);
    while i < text.len() {
        if text[i..].starts_with(b"/*") {
            depth += 1;
            i += 2;
        } else if text[i..].starts_with(b"*/") {
            depth -= 1;
            i += 2;
            if depth == 0 {
                return i;
            }
        } else {
            i += 1;
        }
    }
    text.len()
}

/// With both quotes.
fn literal_length(text: &[u8]) -> usize {
    let mut i = 1;
    while i < text.len() {
        match text[i] {
            b'\\' => i += 2,
            b'"' => return i + 1,
            _ => i += 1,
        }
    }
    text.len().max(2)
}

/// Everything that texts depend on.
pub(super) struct Dependencies {
    hasher: blake3::Hasher,
    names_files: bool,
    computed: bool,
    seen: HashSet<PathBuf>,
}

impl Dependencies {
    pub(super) fn new() -> Self {
        Self {
            hasher: blake3::Hasher::new(),
            names_files: false,
            computed: false,
            seen: HashSet::new(),
        }
    }

    /// A text, and the files that its literals name, beside it and in the
    /// film's folder, and the files that those name.
    pub(super) fn add(&mut self, file: &NativeFile) {
        hash_part(&mut self.hasher, &file.text);
        let beside = file.path.parent().unwrap_or(Path::new(""));
        let folders = [beside, &file.root];
        let mut waiting = vec![names_in(&file.text)];
        while let Some(named) = waiting.pop() {
            self.computed |= named.computed;
            self.names_files |= named.computed || !named.literals.is_empty();
            for literal in named.literals {
                for path in folders.map(|folder| folder.join(&literal)) {
                    if !path.is_file() || !self.seen.insert(path.clone()) {
                        continue;
                    }
                    // What cannot be read here is the renderer's to complain of.
                    let Ok(text) = fs::read(&path) else { continue };
                    hash_part(&mut self.hasher, literal.as_bytes());
                    hash_part(&mut self.hasher, &text);
                    if text.len() <= LARGEST_TEXT {
                        waiting.push(names_in(&text));
                    }
                }
            }
        }
    }

    /// The key of what a renderer says of all that; none where not everything
    /// is known that it depends on.
    pub(super) fn key(mut self, adapter: &str, version: &str) -> Option<Vec<u8>> {
        hash_part(&mut self.hasher, adapter.as_bytes());
        hash_part(&mut self.hasher, version.as_bytes());
        (!self.computed).then(|| self.hasher.finalize().as_bytes().to_vec())
    }
}

/// The hash of a fragment's content, in hexadecimal: two of the same are one
/// prototype. The same text in another folder may find other files beside it,
/// so the folder counts wherever a file might be named.
pub(crate) fn content_hash(fragment: &Fragment) -> String {
    let mut content = Dependencies::new();
    content.add(&fragment.file);
    hash_part(&mut content.hasher, fragment.language.as_bytes());
    if content.names_files {
        let folder = fragment.file.path.parent().unwrap_or(Path::new(""));
        hash_part(&mut content.hasher, folder.as_os_str().as_encoded_bytes());
    }
    content.hasher.finalize().to_hex().to_string()
}

/// The key under which the cache keeps what the renderer says of a fragment.
pub(super) fn inspection_key(
    fragment: &Fragment,
    includes: &[NativeFile],
    adapter: &str,
    version: &str,
) -> Option<Vec<u8>> {
    let mut depends = Dependencies::new();
    // Once each, and in order: declarations may override each other.
    depends.add(&fragment.file);
    for include in includes {
        depends.add(include);
    }
    depends.key(adapter, version)
}

/// What [`Said`] is in the cache.
#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct KeptSaid {
    bounds: KeptBounds,
    extents: Vec<[DVec3; 2]>,
    optical: Option<String>,
    unlayerable: Option<String>,
}

#[derive(Debug, PartialEq, serde::Serialize, serde::Deserialize)]
enum KeptBounds {
    Empty,
    Sphere([f64; 4]),
    Unbounded,
}

impl KeptSaid {
    pub(super) fn new(said: &Said) -> Self {
        Self {
            bounds: match said.bounds {
                Bounds::Empty => KeptBounds::Empty,
                Bounds::Sphere(s) => {
                    KeptBounds::Sphere([s.centre.x, s.centre.y, s.centre.z, s.radius])
                }
                Bounds::Unbounded => KeptBounds::Unbounded,
            },
            extents: said.extents.iter().map(|e| [e.min, e.max]).collect(),
            optical: match &said.optics {
                Optics::Opaque => None,
                Optics::Optical(why) => Some(why.clone()),
            },
            unlayerable: said.unlayerable.clone(),
        }
    }

    pub(super) fn into_said(self) -> Said {
        Said {
            bounds: match self.bounds {
                KeptBounds::Empty => Bounds::Empty,
                KeptBounds::Sphere([x, y, z, r]) => Bounds::sphere(DVec3::new(x, y, z), r),
                KeptBounds::Unbounded => Bounds::Unbounded,
            },
            extents: {
                let boxes = self.extents.into_iter();
                boxes.map(|[min, max]| Extent { min, max }).collect()
            },
            optics: self.optical.map_or(Optics::Opaque, Optics::Optical),
            unlayerable: self.unlayerable,
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn names(text: &str) -> (Vec<String>, bool) {
        let named = names_in(text.as_bytes());
        (named.literals, named.computed)
    }

    #[test]
    fn names_are_found_outside_of_comments() {
        let text = "#include \"a.inc\" // \"b\n/* \"c\" /* */ \"d\" */ #  include /* e */ \"e.inc\"\n\
                    #fopen FILE \"f.txt\" read\n text { ttf \"g\\\"h\" 1 }";
        let (literals, computed) = names(text);
        assert_eq!(literals, ["a.inc", "e.inc", "f.txt", "g\\\"h"]);
        assert!(!computed);
    }

    #[test]
    fn computed_names_are_noticed() {
        for text in [
            "#include concat(\"a\", \"b\")",
            "#include Name",
            "#fopen F Name read",
            "#fopen F concat(\"a\", \"b\") read",
        ] {
            assert!(names(text).1, "{text}");
        }
        for text in ["#declare include = 1;", "included(\"a\")", "#include"] {
            assert!(!names(text).1, "{text}");
        }
    }

    #[test]
    fn only_a_first_line_states_bounds() {
        let stated = |text: &str| stated_bounds(Path::new("a.inc"), text.as_bytes());
        let sphere = Some(Bounds::sphere(DVec3::new(1.0, -2.0, 0.5), 3.0));
        for text in [
            "// bounds: 1 -2 .5 3",
            "//bounds: 1 -2 .5 3\nsphere {}",
            "\u{feff}  // bounds:\t1 -2 5e-1 3 \r\n",
        ] {
            assert_eq!(stated(text).unwrap(), sphere, "{text:?}");
        }
        for text in [
            "",
            "\n// bounds: 1 2 3 4",
            "// sphere",
            "bounds: 1 2 3 4",
            "// bounds 1",
        ] {
            assert_eq!(stated(text).unwrap(), None, "{text:?}");
        }
        for text in [
            "// bounds:",
            "// bounds: 1 2 3",
            "// bounds: 1 2 3 4 5",
            "// bounds: 1 2 3 nan",
            "// bounds: 1 2 3 inf",
            "// bounds: 1, 2, 3, 4",
        ] {
            let error = stated(text).unwrap_err();
            assert_eq!((error.line, error.column), (1, 4), "{text:?}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_looked_at_without_a_panic(
            text in prop::collection::vec(
                prop::sample::select(b"#/*\"\\\n include fopen x".to_vec()), 0..60),
            bytes in prop::collection::vec(any::<u8>(), 0..60),
        ) {
            for text in [text, bytes] {
                names_in(&text);
                let _ = stated_bounds(Path::new("x"), &text);
            }
        }
    }
}

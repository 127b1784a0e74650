//! Do the frames of a scene depend on each other? They do where one writes what
//! another may read: then they are rendered in order, by one process, as
//! POV-Ray alone would.
//!
//! The scene is not understood, only looked at: its words, those of the files
//! that it includes, and of the macros of POV-Ray's library that it names. What
//! cannot be known counts as a dependence; that costs time, never a picture.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use crate::sources::{Library, LibraryWords};
use crate::tokens::{Kind, Token, tokens};

use super::settings::Settings;

/// How the frames hang together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Order {
    /// They do not: each can be rendered anywhere, at any time.
    Free,
    /// A frame may read what an earlier one wrote, for the reason given.
    Chained(String),
    /// A frame may read the picture of an earlier one, so that pictures must be
    /// where POV-Ray puts them; for the reason given.
    OwnPictures(String),
}

/// What looking at a scene gives.
#[derive(Clone, Debug)]
pub struct Look {
    /// How its frames hang together.
    pub order: Order,
    /// The user's own files that were read, the scene first.
    pub files: Vec<(PathBuf, Vec<u8>)>,
    /// Other files that the texts name and that are there: pictures, fonts.
    pub named: Vec<PathBuf>,
}

/// What a scene is looked at for.
pub struct Looking<'a> {
    /// The working folder.
    pub folder: &'a Path,
    /// What POV-Ray is told.
    pub settings: &'a Settings,
    /// POV-Ray's own include files.
    pub library: &'a Library,
    /// The words of their definitions.
    pub words: &'a LibraryWords,
    /// The stem and the ending of the pictures.
    pub pictures: (&'a str, &'a str),
}

/// Words behind which a scene names a file that it reads.
const READERS: &[&str] = &[
    "png",
    "jpeg",
    "tiff",
    "tga",
    "ppm",
    "pgm",
    "gif",
    "sys",
    "iff",
    "exr",
    "hdr",
    "bmp",
    "pot",
    "df3",
    "read",
    "load_file",
    "image_map",
    "bump_map",
    "material_map",
    "image_pattern",
    "height_field",
];

/// Words that make a text of something else than the strings of the scene.
const TEXT_MAKERS: &[&str] = &[
    "chr",
    "substr",
    "strlwr",
    "strupr",
    "input_file_name",
    "datetime",
];

impl Looking<'_> {
    /// Looks at the scene in `scene`.
    pub fn look(&self, scene: &Path) -> Look {
        let mut look = Look {
            order: Order::Free,
            files: Vec::new(),
            named: Vec::new(),
        };
        let mut chained = self.by_option();
        let mut open: Vec<PathBuf> = vec![scene.to_owned()];
        let header = self
            .settings
            .text("Include_Header")
            .and_then(|name| self.find(name, &[".inc"]));
        open.extend(header);
        let mut seen = HashSet::new();
        let mut library = Vec::new();
        while let Some(path) = open.pop() {
            if !seen.insert(path.clone()) {
                continue;
            }
            let Ok(text) = std::fs::read(&path) else {
                chained.get_or_insert(format!("{} cannot be read", path.display()));
                continue;
            };
            let found = tokens(&text);
            for (at, token) in found.iter().enumerate() {
                if token.kind == Kind::Directive && token.is("#include") {
                    let named = found.get(at + 1).and_then(Token::string);
                    match named.map(|name| String::from_utf8_lossy(name).into_owned()) {
                        None => {
                            chained.get_or_insert(format!(
                                "{} includes a file whose name is computed",
                                place(&path, token)
                            ));
                        }
                        Some(name) => match self.find(&name, &[".inc", ".INC", ".pov", ".POV"]) {
                            Some(file) if self.library.holds(&file) => library.push(file),
                            Some(file) => open.push(file),
                            None => {
                                chained.get_or_insert(format!(
                                    "{} includes `{name}`, which was not found",
                                    place(&path, token)
                                ));
                            }
                        },
                    }
                }
            }
            if let Some(reason) = writes(&path, &found) {
                chained.get_or_insert(reason);
            }
            look.files.push((path, text));
        }
        if chained.is_none() {
            chained = self.by_macro(&look.files, &library);
        }
        let own = self.own_pictures(&mut look);
        look.order = match (own, chained) {
            (Some(reason), _) => Order::OwnPictures(reason),
            (None, Some(reason)) => Order::Chained(reason),
            (None, None) => Order::Free,
        };
        look
    }

    fn by_option(&self) -> Option<String> {
        self.settings
            .is_on("Radiosity_To_File")
            .then(|| "Radiosity_To_File writes what later frames may read".to_owned())
    }

    /// A file as POV-Ray looks for it: in the working folder, then in the
    /// library folders; first as it is called.
    pub fn find(&self, name: &str, endings: &[&str]) -> Option<PathBuf> {
        find(self.folder, &self.settings.library, name, endings)
    }

    /// Does a macro of the library write a file, that the scene names directly
    /// or through other macros?
    fn by_macro(&self, own: &[(PathBuf, Vec<u8>)], library: &[PathBuf]) -> Option<String> {
        let mut words: HashSet<String> = HashSet::new();
        for (_, text) in own {
            let found = tokens(text);
            let names = found.iter().filter(|token| token.kind == Kind::Word);
            words.extend(names.map(|token| token.text().into_owned()));
        }
        for file in library {
            let definitions = self.words.of(file, self.library);
            let mut open: Vec<&String> = words
                .iter()
                .filter(|w| definitions.contains_key(*w))
                .collect();
            let mut seen: HashSet<&String> = open.iter().copied().collect();
            while let Some(name) = open.pop() {
                let inner = definitions.get(name).into_iter().flatten();
                for word in inner {
                    if is_writer(word) {
                        return Some(format!("`{name}` of {} writes a file", file.display()));
                    }
                    if definitions.contains_key(word) && seen.insert(word) {
                        open.push(word);
                    }
                }
            }
        }
        None
    }

    /// Might the scene read a picture that an earlier frame was written to? A
    /// name is a picture's if it says so, and may be one if it is put together
    /// and any string of the scene could be a piece of it.
    fn own_pictures(&self, look: &mut Look) -> Option<String> {
        let (stem, ending) = self.pictures;
        let mut computed = None;
        let mut piece = None;
        let mut reason = None;
        for (path, text) in &look.files {
            let found = tokens(text);
            for (at, token) in found.iter().enumerate() {
                if token.kind == Kind::Word && TEXT_MAKERS.iter().any(|word| token.is(word)) {
                    piece.get_or_insert(place(path, token));
                }
                if let Some(name) = token.string() {
                    let name = String::from_utf8_lossy(name);
                    let file = name.rsplit('/').next().unwrap_or_default();
                    if is_picture(file, stem, ending) {
                        reason.get_or_insert(format!(
                            "{} names `{name}`, which may be a frame",
                            place(path, token)
                        ));
                    } else if !file.is_empty() && stem.starts_with(file) || file.starts_with(stem) {
                        piece.get_or_insert(place(path, token));
                    }
                    if let Some(there) = self.find(&name, &[""]) {
                        look.named.push(there);
                    }
                }
                if reads_computed(&found, at) {
                    computed.get_or_insert(place(path, token));
                }
            }
        }
        look.named.sort();
        look.named.dedup();
        reason.or_else(|| {
            let (computed, _) = computed.zip(piece)?;
            Some(format!(
                "{computed} reads a file whose name is computed: it may be a frame"
            ))
        })
    }
}

/// See [`Looking::find`].
pub fn find(folder: &Path, library: &[String], name: &str, endings: &[&str]) -> Option<PathBuf> {
    let folders = std::iter::once(folder.to_owned()).chain(library.iter().map(|p| folder.join(p)));
    folders
        .flat_map(|folder| {
            let plain = folder.join(name);
            let others = endings
                .iter()
                .map(move |ending| folder.join(format!("{name}{ending}")));
            std::iter::once(plain).chain(others).collect::<Vec<_>>()
        })
        .find(|path| path.is_file())
}

fn place(path: &Path, token: &Token<'_>) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    format!("{}:{}", name.to_string_lossy(), token.line)
}

fn is_writer(word: &str) -> bool {
    matches!(word, "write" | "append" | "save_file")
}

/// Does a text itself write files? The words have no other meaning in the
/// language; as names of the user's they cost time only.
fn writes(path: &Path, found: &[Token<'_>]) -> Option<String> {
    let writer = found
        .iter()
        .find(|token| token.kind == Kind::Word && is_writer(&token.text()))?;
    Some(format!(
        "{} writes a file (`{}`)",
        place(path, writer),
        writer.text()
    ))
}

/// Is it the name of a frame: the stem, digits, the ending?
fn is_picture(file: &str, stem: &str, ending: &str) -> bool {
    let number = file
        .strip_prefix(stem)
        .and_then(|rest| rest.strip_suffix(ending))
        .and_then(|rest| rest.strip_suffix('.'));
    number.is_some_and(|number| number.bytes().all(|b| b.is_ascii_digit()))
}

/// Does the token at `at` say that a file is read, and something else than a
/// string says which?
fn reads_computed(found: &[Token<'_>], at: usize) -> bool {
    let token = &found[at];
    let next = |k: usize| found.get(at + k);
    let is_text = |token: Option<&Token<'_>>| token.is_some_and(|t| t.kind == Kind::Text);
    if token.kind == Kind::Directive && token.is("#fopen") {
        return !is_text(next(2));
    }
    if token.kind != Kind::Word || !READERS.iter().any(|word| token.is(word)) {
        return false;
    }
    match token.bytes {
        // Since 3.7 the type may be left out: the name follows the brace.
        b"image_map" | b"bump_map" | b"material_map" | b"image_pattern" | b"height_field" => {
            let name = next(2);
            !is_text(name)
                && name.is_some_and(|t| t.kind == Kind::Word && !READERS.iter().any(|w| t.is(w)))
                && name.is_some_and(|t| !t.is("function") && !t.is("pattern"))
        }
        // The mode of #fopen, seen there already.
        b"read" => false,
        _ => !is_text(next(1)),
    }
}

//! The text of a scene: the file itself and all that it includes, and copies of
//! them with pieces replaced.
//!
//! A copy lies elsewhere, but POV-Ray still works in the scene's own folder: all
//! names in the scene lead where they lead in the original. Only `#include`s of
//! copied files are changed, to names that nothing else has.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

use decor_api::AdapterError;

use super::lex::{Kind, lex};
use crate::PovRay;
use crate::plain::{PlainScene, quoted};

/// Endings that POV-Ray tries for an include.
const INCLUDE_ENDINGS: &[&str] = &[".inc", ".INC", ".pov", ".POV"];

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
    /// How `#include`s spell it.
    pub(super) called: Vec<String>,
    /// Where its lines end.
    newlines: Vec<usize>,
}

impl SourceFile {
    fn new(path: PathBuf, text: Vec<u8>, library: bool) -> Self {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let bytes = text.iter().enumerate();
        Self {
            name: name.into_owned(),
            newlines: bytes
                .filter(|(_, byte)| **byte == b'\n')
                .map(|(at, _)| at)
                .collect(),
            path,
            text,
            library,
            called: Vec::new(),
        }
    }
}

/// A scene and its includes, each once. The first file is the scene.
#[derive(Clone, Debug)]
pub struct Sources {
    /// The files.
    pub files: Vec<SourceFile>,
    /// The file that is read before the scene (`Include_Header`).
    pub header: Option<usize>,
    /// How added names may begin: nothing in the scene does.
    pub prefix: String,
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
    /// Reads a scene's files. Includes that are not found, or whose name is
    /// computed, are left out; [`super::analyse`] refuses them.
    ///
    /// # Errors
    /// [`AdapterError::Io`] where a file cannot be read.
    pub fn read(povray: &PovRay, scene: &PlainScene) -> Result<Self, AdapterError> {
        let find = |name: &str| scene.find(name, INCLUDE_ENDINGS);
        let name = scene.settings().text("Input_File_Name").unwrap_or_default();
        let path = scene.find(name, &[".pov", ".POV"]).unwrap_or_default();
        let header = scene.settings().text("Include_Header").and_then(find);
        let library = |path: &Path| povray.library.holds(path);
        let mut sources = Self::collect(path, header, find, library)?;
        // Nor may a file of the user's be called like a copy.
        while scene.find(&sources.copy_name(0), &[]).is_some() {
            sources.prefix.insert(0, 'x');
        }
        Ok(sources)
    }

    /// A scene from texts: `files` has names and contents, the scene first.
    pub fn of_texts(files: &[(&str, &str)]) -> Self {
        let mut sources = Self {
            files: Vec::new(),
            header: None,
            prefix: String::new(),
        };
        for (name, text) in files {
            let mut file = SourceFile::new(PathBuf::from(name), text.as_bytes().to_vec(), false);
            file.called.push((*name).to_owned());
            sources.files.push(file);
        }
        sources.choose_prefix();
        sources
    }

    fn collect(
        scene: PathBuf,
        header: Option<PathBuf>,
        find: impl Fn(&str) -> Option<PathBuf>,
        library: impl Fn(&Path) -> bool,
    ) -> Result<Self, AdapterError> {
        let mut sources = Self {
            files: Vec::new(),
            header: None,
            prefix: String::new(),
        };
        sources.add(scene, &library)?;
        if let Some(header) = header {
            sources.header = Some(sources.add(header, &library)?);
        }
        let mut next = 0;
        while next < sources.files.len() {
            for name in included(&sources.files[next].text) {
                if let Some(path) = find(&name) {
                    let file = sources.add(path, &library)?;
                    let called = &mut sources.files[file].called;
                    if !called.contains(&name) {
                        called.push(name);
                    }
                }
            }
            next += 1;
        }
        sources.choose_prefix();
        Ok(sources)
    }

    fn add(
        &mut self,
        path: PathBuf,
        library: impl Fn(&Path) -> bool,
    ) -> Result<usize, AdapterError> {
        if let Some(known) = self.files.iter().position(|file| file.path == path) {
            return Ok(known);
        }
        let text = std::fs::read(&path).map_err(AdapterError::io(&path))?;
        let library = library(&path);
        self.files.push(SourceFile::new(path, text, library));
        Ok(self.files.len() - 1)
    }

    fn choose_prefix(&mut self) {
        let taken = |prefix: &str| {
            let prefix = prefix.as_bytes();
            let mut texts = self.files.iter().map(|file| &file.text);
            texts.any(|text| text.windows(prefix.len()).any(|piece| piece == prefix))
        };
        let free = (0..)
            .map(|k| format!("decor{k}_"))
            .find(|prefix| !taken(prefix));
        self.prefix = free.unwrap_or_default();
    }

    /// The line of a byte, from 1.
    pub fn line(&self, file: usize, at: usize) -> usize {
        let ends = self.files.get(file).map_or(&[][..], |file| &file.newlines);
        1 + ends.partition_point(|end| *end < at)
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

    fn copy_name(&self, file: usize) -> String {
        let ending = if file == 0 { "pov" } else { "inc" };
        format!("{}{file}.{ending}", self.prefix)
    }

    /// Writes a copy of the scene with pieces replaced into the folder `to`.
    /// Edits may not overlap; insertions at one place keep their order.
    ///
    /// # Errors
    /// [`AdapterError::Io`]; [`AdapterError::BadInput`] where POV-Ray has no way
    /// to write the folder's name.
    pub fn rewritten(&self, edits: &[Edit], to: &Path) -> Result<Copy, AdapterError> {
        let copied = self.copied(edits);
        for file in &copied {
            let mut edits: Vec<&Edit> = edits.iter().filter(|e| e.file == *file).collect();
            let includes = self.changed_includes(*file, &copied);
            edits.extend(&includes);
            // Stable: insertions at one place keep their order.
            edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
            let text = apply(&self.files[*file].text, &edits);
            let path = to.join(self.copy_name(*file));
            std::fs::write(&path, text).map_err(AdapterError::io(&path))?;
        }
        let in_quotes = |path: &Path| {
            let quoted = path.to_str().and_then(quoted);
            quoted.ok_or_else(|| AdapterError::BadInput {
                file: path.to_owned(),
                reason: "POV-Ray cannot quote the name of this folder".into(),
            })
        };
        let scene = in_quotes(&to.join(self.copy_name(0)))?;
        let mut switches = vec![
            format!("Input_File_Name={scene}"),
            format!("Library_Path={}", in_quotes(to)?),
        ];
        if let Some(header) = self.header.filter(|header| copied.contains(header)) {
            switches.push(format!("Include_Header={}", self.copy_name(header)));
        }
        Ok(Copy { switches })
    }

    /// The scene, what is edited, and what includes these.
    fn copied(&self, edits: &[Edit]) -> BTreeSet<usize> {
        let mut copied: BTreeSet<usize> = edits.iter().map(|edit| edit.file).collect();
        copied.insert(0);
        loop {
            let more = (0..self.files.len()).find(|file| {
                !copied.contains(file) && !self.changed_includes(*file, &copied).is_empty()
            });
            match more {
                Some(file) => copied.insert(file),
                None => return copied,
            };
        }
    }

    /// The edits that make a file include copies.
    fn changed_includes(&self, file: usize, copied: &BTreeSet<usize>) -> Vec<Edit> {
        let mut edits = Vec::new();
        let lexed = lex(&self.files[file].text);
        for pair in lexed.tokens.windows(2) {
            if !pair[0].is_directive("include") || pair[1].kind != Kind::Text {
                continue;
            }
            let target = self
                .files
                .iter()
                .position(|f| f.called.iter().any(|c| c == pair[1].text));
            if let Some(target) = target.filter(|target| copied.contains(target)) {
                edits.push(Edit {
                    file,
                    range: pair[1].start..pair[1].end,
                    text: format!("\"{}\"", self.copy_name(target)),
                });
            }
        }
        edits
    }
}

/// The names behind a text's `#include`s.
fn included(text: &[u8]) -> Vec<String> {
    let lexed = lex(text);
    let pairs = lexed.tokens.windows(2);
    let names = pairs.filter(|pair| pair[0].is_directive("include") && pair[1].kind == Kind::Text);
    names.map(|pair| pair[1].text.to_owned()).collect()
}

fn apply(text: &[u8], edits: &[&Edit]) -> Vec<u8> {
    let mut copy = Vec::with_capacity(text.len());
    let mut at = 0;
    for edit in edits {
        let start = edit.range.start.clamp(at, text.len());
        copy.extend_from_slice(&text[at..start]);
        copy.extend_from_slice(edit.text.as_bytes());
        at = edit.range.end.clamp(start, text.len());
    }
    copy.extend_from_slice(&text[at..]);
    copy
}

/// A place for people: `scene.pov:12`.
pub(super) fn place(sources: &Sources, file: usize, at: usize) -> String {
    let mut text = sources
        .files
        .get(file)
        .map_or_else(String::new, |f| f.name.clone());
    let _ = write!(text, ":{}", sources.line(file, at));
    text
}

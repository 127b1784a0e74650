//! Which files a piece of POV-Ray text reads: the user's own, and the library's.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

use decor_api::NativeFile;

use crate::tokens::{Kind, Token, has_directives, tokens};

/// What an `#include` leads to.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Included {
    /// A file of the user's, beside the including file or in the film's folder.
    Own(PathBuf),
    /// A file of POV-Ray's library.
    Library(PathBuf),
    /// No file of that name was found.
    NotFound(String),
    /// The name is computed.
    Computed,
}

/// The folders of POV-Ray's own include files.
#[derive(Clone, Debug, Default)]
pub struct Library {
    folders: Vec<PathBuf>,
}

impl Library {
    /// The usual places, and those beside the program.
    pub fn of_program(program: &Path) -> Self {
        let prefix = program
            .canonicalize()
            .ok()
            .and_then(|p| p.parent().and_then(Path::parent).map(Path::to_owned));
        let mut folders = Vec::new();
        for base in prefix
            .into_iter()
            .chain(["/usr", "/usr/local"].map(PathBuf::from))
        {
            for version in ["3.8", "3.7"] {
                let folder = base.join(format!("share/povray-{version}/include"));
                if folder.is_dir() && !folders.contains(&folder) {
                    folders.push(folder);
                }
            }
        }
        Self { folders }
    }

    /// Is the file one of the library's?
    pub fn holds(&self, file: &Path) -> bool {
        self.folders.iter().any(|folder| file.starts_with(folder))
    }

    /// The folder that is looked in first.
    pub fn first(&self) -> Option<String> {
        self.folders
            .first()
            .map(|folder| folder.to_string_lossy().into_owned())
    }

    /// What `name` leads to from a file in `folder` of a film in `root`.
    pub fn find(&self, name: &str, folder: &Path, root: &Path) -> Included {
        for own in [folder.join(name), root.join(name)] {
            if own.is_file() {
                return Included::Own(own);
            }
        }
        for folder in &self.folders {
            let file = folder.join(name);
            if file.is_file() {
                return Included::Library(file);
            }
        }
        Included::NotFound(name.to_owned())
    }
}

/// The `#include`s of some tokens: the index of the token behind the directive,
/// and what it leads to.
pub fn includes(
    found: &[Token<'_>],
    library: &Library,
    folder: &Path,
    root: &Path,
) -> Vec<(usize, Included)> {
    let mut list = Vec::new();
    for (at, token) in found.iter().enumerate() {
        if token.kind != Kind::Directive || !token.is("#include") {
            continue;
        }
        let name = found.get(at + 1).and_then(Token::string);
        let included = match name {
            Some(name) => library.find(&String::from_utf8_lossy(name), folder, root),
            None => Included::Computed,
        };
        list.push((at + 1, included));
    }
    list
}

/// A file and all that it includes, each once: the user's own files with their
/// text, and what else is read.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// The file itself first, then its own includes.
    pub own: Vec<(PathBuf, Vec<u8>)>,
    /// Library files that are named directly.
    pub library: Vec<PathBuf>,
    /// Includes that lead nowhere, in words.
    pub lost: Vec<String>,
}

/// Walks from `file` through its includes.
pub fn tree(file: &NativeFile, library: &Library) -> Tree {
    let mut tree = Tree::default();
    let mut seen = HashSet::new();
    let mut open = vec![(file.path.clone(), file.text.clone())];
    while let Some((path, text)) = open.pop() {
        if !seen.insert(path.clone()) {
            continue;
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let found = if has_directives(&text) {
            includes(&tokens(&text), library, &folder, &file.root)
        } else {
            Vec::new()
        };
        for (_, included) in found {
            match included {
                Included::Own(own) => match std::fs::read(&own) {
                    Ok(text) => open.push((own, text)),
                    Err(_) => tree
                        .lost
                        .push(format!("`{}`, which cannot be read", own.display())),
                },
                Included::Library(path) if !tree.library.contains(&path) => tree.library.push(path),
                Included::Library(_) => {}
                Included::NotFound(name) => {
                    tree.lost.push(format!("`{name}`, which was not found"));
                }
                Included::Computed => tree.lost.push("a file whose name is computed".to_owned()),
            }
        }
        tree.own.push((path, text));
    }
    tree
}

/// Collects, for each `#declare`, `#local` and `#macro`, the words up to the
/// next one: more than belongs to it, never less, but for nested declarations,
/// whose words count for both. What a macro makes its own by `#local` is no
/// identifier of the file: its words are the macro's.
pub fn definitions(text: &[u8], into: &mut Definitions) {
    let mut current: Vec<String> = Vec::new();
    let found = tokens(text);
    let mut blocks = 0_usize;
    let mut macro_at: Option<(String, usize)> = None;
    let mut locals: HashSet<&[u8]> = HashSet::new();
    let mut at = 0;
    while at < found.len() {
        let token = &found[at];
        if token.kind == Kind::Directive {
            let name = found.get(at + 1).filter(|t| t.kind == Kind::Word);
            match (token.bytes, name) {
                (b"#declare" | b"#local", Some(name)) => {
                    current.clear();
                    if let Some((outer, _)) = &macro_at {
                        current.push(outer.clone());
                        if token.is("#local") {
                            locals.insert(name.bytes);
                        }
                    }
                    if !locals.contains(name.bytes) {
                        current.push(name.text().into_owned());
                    }
                    at += 1;
                }
                (b"#macro", Some(name)) => {
                    blocks += 1;
                    let name = name.text().into_owned();
                    current = vec![name.clone()];
                    if macro_at.is_none() {
                        macro_at = Some((name, blocks));
                        locals.clear();
                    }
                    at += 1;
                }
                (b"#if" | b"#ifdef" | b"#ifndef" | b"#while" | b"#for" | b"#switch", _) => {
                    blocks += 1;
                }
                (b"#end", _) => {
                    if macro_at.as_ref().is_some_and(|(_, depth)| *depth == blocks) {
                        macro_at = None;
                        locals.clear();
                        current.clear();
                    }
                    blocks = blocks.saturating_sub(1);
                }
                _ => {}
            }
        } else if token.kind == Kind::Word {
            for name in &current {
                into.entry(name.clone())
                    .or_default()
                    .insert(token.text().into_owned());
            }
        }
        at += 1;
    }
}

/// The words that stand in the definition of each identifier of a file.
pub type Definitions = HashMap<String, HashSet<String>>;

/// Definitions of library files, read once.
#[derive(Debug, Default)]
pub struct LibraryWords {
    known: Mutex<HashMap<PathBuf, Arc<Definitions>>>,
}

impl LibraryWords {
    /// The definitions of `path` and of the library files that it includes.
    pub fn of(&self, path: &Path, library: &Library) -> Arc<Definitions> {
        if let Some(known) = self.lock().get(path) {
            return Arc::clone(known);
        }
        let mut words = HashMap::new();
        let mut seen = HashSet::new();
        let mut open = vec![path.to_owned()];
        while let Some(path) = open.pop() {
            if !seen.insert(path.clone()) {
                continue;
            }
            let Ok(text) = std::fs::read(&path) else {
                continue;
            };
            definitions(&text, &mut words);
            let folder = path.parent().unwrap_or(Path::new(""));
            for (_, included) in includes(&tokens(&text), library, folder, folder) {
                if let Included::Own(path) | Included::Library(path) = included {
                    open.push(path);
                }
            }
        }
        let words = Arc::new(words);
        self.lock().insert(path.to_owned(), Arc::clone(&words));
        words
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, HashMap<PathBuf, Arc<Definitions>>> {
        // The map is whole at every moment: a panic elsewhere did not spoil it.
        self.known
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

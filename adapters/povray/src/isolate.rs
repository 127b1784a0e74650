//! Keeps what a fragment declares to itself: its own names, and those of the
//! files of the user's that it includes, are renamed.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::{Path, PathBuf};

use decor_api::NativeFile;

use crate::scene_text::with_newline;
use crate::sources::{Included, Library, includes, tree};
use crate::tokens::{Kind, Token, has_directives, tokens};

/// POV-Ray 3.7 reads identifiers of up to this many characters.
const LONGEST_NAME: usize = 40;

/// The fragment's text and that of its own includes, as files named
/// `decor_{stem}.inc`, `decor_{stem}_1.inc`, …; the fragment is the first.
pub fn isolate(
    fragment: &NativeFile,
    film_includes: &[NativeFile],
    library: &Library,
    stem: &str,
) -> Vec<(String, Vec<u8>)> {
    let tree = tree(fragment, library);
    let library_texts = library_texts(&tree.library, library);
    let library_names: Vec<Declared> = library_texts
        .iter()
        .flat_map(|text| declared_in(text))
        .collect();
    let defined = |name: &[u8]| library_names.iter().any(|d| d.name == name);
    let is_library_macro = |name: &[u8]| library_names.iter().any(|d| d.name == name && d.is_macro);
    let kept = words_of(&library_texts);
    // Names of the library's that the fragment declares anew: they begin with
    // the library's value, behind each include.
    let mut behind_includes = String::new();
    let film_words: HashSet<Vec<u8>> = film_includes
        .iter()
        .flat_map(|file| crate::sources::tree(file, library).own)
        .flat_map(|(_, text)| declared_in(&text))
        .map(|name| name.name)
        .collect();

    let mut renamed: BTreeMap<Vec<u8>, String> = BTreeMap::new();
    let mut inherited: Vec<Vec<u8>> = Vec::new();
    for (_, text) in &tree.own {
        for Declared { name, is_macro } in declared_in(text) {
            // What the library only reads may be a parameter of its own.
            let is_parameter = kept.contains(&name) && !defined(&name);
            if is_parameter || renamed.contains_key(&name) {
                continue;
            }
            if film_words.contains(&name) && !is_macro {
                inherited.push(name.clone());
            }
            let new = new_name(stem, renamed.len(), &name);
            if defined(&name) && !is_macro && !is_library_macro(&name) {
                let old = String::from_utf8_lossy(&name);
                behind_includes.push_str(&format!(" #ifdef ({old}) #declare {new} = {old}; #end"));
            }
            renamed.insert(name, new);
        }
    }
    let files: HashMap<&Path, String> = tree
        .own
        .iter()
        .enumerate()
        .map(|(k, (path, _))| {
            let name = if k == 0 {
                format!("decor_{stem}.inc")
            } else {
                format!("decor_{stem}_{k}.inc")
            };
            (path.as_path(), name)
        })
        .collect();

    let mut written = Vec::new();
    for (k, (path, text)) in tree.own.iter().enumerate() {
        let mut out = Vec::new();
        if k == 0 {
            // A name of the film's that the fragment declares anew begins with
            // the film's value.
            for name in &inherited {
                let old = String::from_utf8_lossy(name);
                let new = &renamed[name];
                out.extend_from_slice(
                    format!("#ifdef ({old}) #declare {new} = {old}; #end\n").as_bytes(),
                );
            }
        }
        out.extend(rewrite(
            path,
            text,
            &renamed,
            &files,
            library,
            &fragment.root,
            &behind_includes,
        ));
        if k == 0 && tree.own.iter().any(|(_, text)| states_version(text)) {
            // The language version of a fragment is its own, too.
            out.extend_from_slice(b"#version 3.7;\n");
        }
        written.push((files[path.as_path()].clone(), out));
    }
    written
}

fn rewrite(
    path: &Path,
    text: &[u8],
    renamed: &BTreeMap<Vec<u8>, String>,
    files: &HashMap<&Path, String>,
    library: &Library,
    root: &Path,
    behind_includes: &str,
) -> Vec<u8> {
    if renamed.is_empty() && !has_directives(text) {
        return with_newline(text);
    }
    let found = tokens(text);
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut replaced: HashMap<usize, String> = HashMap::new();
    for (at, included) in includes(&found, library, folder, root) {
        match included {
            Included::Own(path) => {
                if let Some(name) = files.get(path.as_path()) {
                    replaced.insert(at, format!("\"{name}\""));
                }
            }
            Included::Library(_) if !behind_includes.is_empty() => {
                replaced.insert(at, format!("{}{behind_includes}", found[at].text()));
            }
            _ => {}
        }
    }
    for (at, token) in found.iter().enumerate() {
        // Behind a point stands a component, never a name.
        let component = at > 0 && found[at - 1].is(".");
        if token.kind == Kind::Word
            && !component
            && let Some(name) = renamed.get(token.bytes)
        {
            replaced.insert(at, name.clone());
        }
    }
    let mut out = Vec::with_capacity(text.len() + 16 * replaced.len());
    let mut from = 0;
    for (at, token) in found.iter().enumerate() {
        if let Some(new) = replaced.get(&at) {
            out.extend_from_slice(&text[from..token.start]);
            out.extend_from_slice(new.as_bytes());
            from = token.start + token.bytes.len();
        }
    }
    out.extend_from_slice(&text[from..]);
    // The last line may be a comment: what follows must not be part of it.
    out.push(b'\n');
    out
}

fn states_version(text: &[u8]) -> bool {
    has_directives(text) && tokens(text).iter().any(|token| token.is("#version"))
}

struct Declared {
    name: Vec<u8>,
    is_macro: bool,
}

fn declared_in(text: &[u8]) -> Vec<Declared> {
    if has_directives(text) {
        declared(&tokens(text))
    } else {
        Vec::new()
    }
}

fn declared(found: &[Token<'_>]) -> Vec<Declared> {
    let mut names = Vec::new();
    for pair in found.windows(2) {
        let is_macro = pair[0].is("#macro");
        let declares =
            is_macro || pair[0].is("#declare") || pair[0].is("#local") || pair[0].is("#undef");
        if declares && pair[1].kind == Kind::Word {
            names.push(Declared {
                name: pair[1].bytes.to_vec(),
                is_macro,
            });
        }
    }
    names
}

/// The texts of library files and of the library files that they include.
fn library_texts(files: &[PathBuf], library: &Library) -> Vec<Vec<u8>> {
    let mut open: Vec<PathBuf> = files.to_vec();
    let mut seen: HashSet<PathBuf> = HashSet::new();
    let mut texts = Vec::new();
    while let Some(path) = open.pop() {
        if !seen.insert(path.clone()) {
            continue;
        }
        let Ok(text) = std::fs::read(&path) else {
            continue;
        };
        let folder = path.parent().unwrap_or(Path::new(""));
        for (_, included) in includes(&tokens(&text), library, folder, folder) {
            if let Included::Own(path) | Included::Library(path) = included {
                open.push(path);
            }
        }
        texts.push(text);
    }
    texts
}

/// All words of some texts.
fn words_of(texts: &[Vec<u8>]) -> HashSet<Vec<u8>> {
    let words = texts.iter().flat_map(|text| {
        let words = tokens(text).into_iter().filter(|t| t.kind == Kind::Word);
        words.map(|t| t.bytes.to_vec()).collect::<Vec<_>>()
    });
    words.collect()
}

fn new_name(stem: &str, number: usize, name: &[u8]) -> String {
    let mut new = format!("{stem}_{number}_{}", String::from_utf8_lossy(name));
    new.truncate(LONGEST_NAME);
    new
}

#[cfg(test)]
mod tests {
    use super::*;

    fn native(text: &str) -> NativeFile {
        NativeFile {
            path: "/film/part.inc".into(),
            root: "/film".into(),
            text: text.into(),
        }
    }

    fn isolated(text: &str, film: &[NativeFile]) -> String {
        let files = isolate(&native(text), film, &Library::default(), "P1");
        String::from_utf8(files[0].1.clone()).unwrap()
    }

    #[test]
    fn declared_names_are_renamed_wherever_they_stand() {
        let text =
            "#declare Size = 2; // Size\n#ifdef (Size) sphere { 0, Size*vlength(Size.x) } #end";
        insta::assert_snapshot!(isolated(text, &[]), @r"
        #declare P1_0_Size = 2; // Size
        #ifdef (P1_0_Size) sphere { 0, P1_0_Size*vlength(P1_0_Size.x) } #end
        ");
    }

    #[test]
    fn a_name_of_the_films_keeps_its_value() {
        let film = [native("#declare Size = 3;")];
        insta::assert_snapshot!(isolated("#declare Size = Size*2; sphere { 0, Size }", &film), @r"
        #ifdef (Size) #declare P1_0_Size = Size; #end
        #declare P1_0_Size = P1_0_Size*2; sphere { 0, P1_0_Size }
        ");
        assert_eq!(
            isolated("sphere { 0, Size }", &film),
            "sphere { 0, Size }\n"
        );
    }

    #[test]
    fn the_language_version_stays_inside() {
        let out = isolated("#version 3.5;\nsphere { 0, 1 }", &[]);
        assert_eq!(out, "#version 3.5;\nsphere { 0, 1 }\n#version 3.7;\n");
    }

    #[test]
    fn long_names_stay_readable_for_povray() {
        let name = "A".repeat(39);
        let out = isolated(&format!("#declare {name} = 1;"), &[]);
        assert!(out.split_whitespace().all(|word| word.len() <= 40), "{out}");
    }
}

//! What the words of a fragment say: does it mirror or let light through, and
//! may it be put into a layer at all?
//!
//! The answer errs on one side only. Looks that are pulled in by name are
//! followed into the files that define them; what cannot be followed counts as
//! a mirror.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use decor_api::{NativeFile, Optics};

use crate::colours;
use crate::sources::{Definitions, Library, LibraryWords, Tree, definitions, tree};
use crate::tokens::{Kind, Token, tokens};

/// Words that make a pixel depend on what lies behind or around; and `crand`,
/// noise that POV-Ray makes anew in every render: such pixels are no décor.
const OPTICAL: [&str; 15] = [
    "reflection",
    "refraction",
    "transmit",
    "filter",
    "rgbt",
    "rgbf",
    "rgbft",
    "interior",
    "media",
    "ior",
    "caustics",
    "image_map",
    "translucency",
    "dispersion",
    "crand",
];

/// Words whose value, or whose effect, a layer does not share with the frame.
pub const UNLAYERABLE: [&str; 19] = [
    "clock",
    "clock_on",
    "clock_delta",
    "initial_clock",
    "final_clock",
    "frame_number",
    "initial_frame",
    "final_frame",
    "image_width",
    "image_height",
    "input_file_name",
    "light_source",
    "light_group",
    "camera",
    "global_settings",
    "radiosity",
    "photons",
    "subsurface",
    "now",
];

/// Directives that reach beyond the fragment.
const REACHING: [&str; 4] = ["#default", "#fopen", "#write", "#read"];

/// What the words of one fragment say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Findings {
    /// Does it mirror or let light through?
    pub optics: Optics,
    /// Why it cannot be put into a layer, where it cannot.
    pub unlayerable: Option<String>,
}

/// Looks at a fragment with the film's declarations.
pub fn fragment(
    file: &NativeFile,
    includes: &[NativeFile],
    library: &Library,
    words: &LibraryWords,
) -> Findings {
    let tree = tree(file, library);
    let unlayerable = tree
        .own
        .iter()
        .find_map(|(path, text)| unlayerable(path, &tokens(text)))
        .or_else(|| unlayerable_by_name(&tree, includes, library));
    let optics = match optical(&tree, includes, library, words) {
        Some(reason) => Optics::Optical(reason),
        None => Optics::Opaque,
    };
    Findings {
        optics,
        unlayerable,
    }
}

/// Does it use a name of the film's declarations behind which such a word
/// stands: a macro that places a light, a value that goes by the clock?
fn unlayerable_by_name(tree: &Tree, includes: &[NativeFile], library: &Library) -> Option<String> {
    let mut known: HashMap<String, HashSet<String>> = HashMap::new();
    for include in includes {
        for (_, text) in &crate::sources::tree(include, library).own {
            definitions(text, &mut known);
        }
    }
    let found = tree.own.iter().flat_map(|(_, text)| tokens(text));
    let words = found.filter(|t| t.kind == Kind::Word);
    let mut open: Vec<String> = words.map(|t| t.text().into_owned()).collect();
    let mut seen = HashSet::new();
    while let Some(name) = open.pop() {
        let Some(words) = known.get(&name).filter(|_| seen.insert(name.clone())) else {
            continue;
        };
        if let Some(word) = words.iter().find(|w| UNLAYERABLE.contains(&w.as_str())) {
            return Some(format!("uses `{name}`, which may have `{word}`"));
        }
        open.extend(words.iter().cloned());
    }
    None
}

fn unlayerable(path: &Path, found: &[Token<'_>]) -> Option<String> {
    let token = found.iter().find(|t| match t.kind {
        Kind::Word => UNLAYERABLE.iter().any(|w| t.is(w)),
        Kind::Directive => REACHING.iter().any(|w| t.is(w)),
        _ => false,
    })?;
    Some(format!(
        "uses `{}` ({} line {})",
        token.text(),
        name_of(path),
        token.line
    ))
}

fn optical(
    tree: &Tree,
    film_includes: &[NativeFile],
    library: &Library,
    library_words: &LibraryWords,
) -> Option<String> {
    if let Some(lost) = tree.lost.first() {
        return Some(format!("it includes {lost}"));
    }
    let mut open: Vec<String> = Vec::new();
    for (path, text) in &tree.own {
        let found = tokens(text);
        let at = |t: &Token<'_>| format!("{} line {}", name_of(path), t.line);
        if let Some(t) = found.iter().find(|t| is_optical_word(t)) {
            return Some(format!("`{}` in {}", t.text(), at(t)));
        }
        if let Some(t) = colour_of_one_number(&found) {
            return Some(format!("a colour of one number in {}", at(t)));
        }
        if let Some(t) = found.iter().find(|t| t.is("Parse_String")) {
            return Some(format!("text that is read as scene in {}", at(t)));
        }
        if let Some(t) = colour_with_filter(&found) {
            return Some(format!("a colour of more than three numbers in {}", at(t)));
        }
        open.extend(
            found
                .iter()
                .filter(|t| t.kind == Kind::Word)
                .map(|t| t.text().into_owned()),
        );
    }
    // Follow the names into the film's declarations and POV-Ray's library.
    let mut known: HashMap<String, HashSet<String>> = HashMap::new();
    let mut sources: Vec<_> = tree.library.clone();
    let mut colour_names: HashSet<String> = HashSet::new();
    let mut summed: Vec<Vec<u8>> = Vec::new();
    for include in film_includes {
        let included = crate::sources::tree(include, library);
        for (_, text) in &included.own {
            definitions(text, &mut known);
            colours::declared(&tokens(text), &mut colour_names);
            summed.push(text.clone());
        }
        if let Some(lost) = included.lost.first() {
            return Some(format!("{} includes {lost}", name_of(&include.path)));
        }
        sources.extend(included.library);
    }
    let from_library: Vec<_> = sources
        .iter()
        .map(|p| library_words.of(p, library))
        .collect();
    for (_, text) in &tree.own {
        colours::declared(&tokens(text), &mut colour_names);
    }
    let is_colour = |name: &str| {
        let words = |m: &Definitions| {
            let words = m.get(name)?;
            Some(colours::is_colour(words.iter().map(String::as_str)))
        };
        colour_names.contains(name) || from_library.iter().any(|m| words(m) == Some(true))
    };
    for (path, text) in &tree.own {
        if let Some(t) = colours::sum_with_number(&tokens(text), is_colour) {
            let place = format!("{} line {}", name_of(path), t.line);
            return Some(format!("a number added to `{}` in {place}", t.text()));
        }
    }
    for text in &summed {
        // Whoever uses the name in whose declaration the sum stands.
        let found = tokens(text);
        if let Some(t) = colours::sum_with_number(&found, is_colour) {
            let before = found.windows(2).filter(|pair| pair[1].start <= t.start);
            let declares = |pair: &&[Token<'_>]| {
                ["#declare", "#local", "#macro"]
                    .iter()
                    .any(|d| pair[0].is(d))
            };
            if let Some(pair) = before.rev().find(declares) {
                let words = known.entry(pair[1].text().into_owned()).or_default();
                words.insert("transmit".to_owned());
            }
        }
    }
    let mut seen: HashSet<String> = HashSet::new();
    let mut via: HashMap<String, String> = HashMap::new();
    while let Some(name) = open.pop() {
        if !seen.insert(name.clone()) {
            continue;
        }
        let everywhere = from_library
            .iter()
            .map(|m| m.get(&name))
            .chain([known.get(&name)]);
        for word in everywhere.flatten().flatten() {
            if OPTICAL.contains(&word.as_str()) {
                let asked = via.get(&name).unwrap_or(&name);
                return Some(format!("`{asked}` may have `{word}`"));
            }
            if !seen.contains(word) {
                let asked = via.get(&name).unwrap_or(&name).clone();
                via.entry(word.clone()).or_insert(asked);
                open.push(word.clone());
            }
        }
    }
    None
}

/// Is it one of the words that make an object optical?
pub fn is_optical_word(token: &Token<'_>) -> bool {
    token.kind == Kind::Word && OPTICAL.iter().any(|w| token.is(w))
}

/// `color 0.5`: one number is all five of a colour, transparency included.
fn colour_of_one_number<'t, 'a>(found: &'t [Token<'a>]) -> Option<&'t Token<'a>> {
    let pair = found.windows(2).find(|pair| {
        let word = pair[0].is("color") || pair[0].is("colour");
        let first = pair[1].bytes.first().copied().unwrap_or(0);
        word && (first.is_ascii_digit() || matches!(first, b'.' | b'-' | b'('))
    })?;
    Some(&pair[0])
}

/// `<r,g,b,f>` or `<r,g,b,f,t>`: the fourth and fifth number let light through.
fn colour_with_filter<'t, 'a>(found: &'t [Token<'a>]) -> Option<&'t Token<'a>> {
    for (at, token) in found.iter().enumerate() {
        if !token.is("<") {
            continue;
        }
        let (mut depth, mut commas) = (0_i32, 0);
        for next in &found[at + 1..] {
            match next.bytes {
                b"(" | b"[" => depth += 1,
                b")" | b"]" => depth -= 1,
                b"," if depth == 0 => commas += 1,
                b"<" | b"{" | b"}" | b";" | b">" if depth == 0 => break,
                _ => {}
            }
        }
        if commas == 3 || commas == 4 {
            return Some(token);
        }
    }
    None
}

/// The name of a file, for messages.
pub fn name_of(path: &Path) -> String {
    path.file_name()
        .unwrap_or(path.as_os_str())
        .to_string_lossy()
        .into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(text: &str) -> NativeFile {
        NativeFile {
            path: "/film/part.inc".into(),
            root: "/film".into(),
            text: text.into(),
        }
    }

    fn optics(text: &str) -> Optics {
        fragment(
            &file(text),
            &[],
            &Library::default(),
            &LibraryWords::default(),
        )
        .optics
    }

    #[test]
    fn mirrors_and_glass_are_found_by_their_words() {
        assert_eq!(
            optics("sphere { 0, 1 pigment { rgb <1,0,0> } }"),
            Optics::Opaque
        );
        for text in [
            "sphere { 0, 1 finish { reflection 0.3 } }",
            "sphere { 0, 1 pigment { rgbt 0.5 } }",
            "sphere { 0, 1 pigment { color <1,1,1,0.5> } }",
            "sphere { 0, 1 pigment { image_map { png \"x.png\" } } }",
            "#include \"nowhere.inc\" sphere { 0, 1 }",
            "#include concat(\"a\", \"b\") sphere { 0, 1 }",
        ] {
            assert!(optics(text).is_optical(), "{text}");
        }
        // Sixteen numbers are a matrix, and a comment is not a word.
        assert_eq!(
            optics("box { 0, 1 matrix <1,0,0,0,1,0,0,0,1,0,0,0> }"),
            Optics::Opaque
        );
        assert_eq!(optics("box { 0, 1 } // no reflection"), Optics::Opaque);
    }

    #[test]
    fn looks_pulled_in_by_name_are_followed() {
        let declarations = file(
            "#declare Dull = texture { pigment { rgb 1 } }\n\
             #declare Shine = finish { reflection 0.5 }\n\
             #declare Bright = texture { pigment { rgb 1 } finish { Shine } }",
        );
        let ask = |text: &str| {
            fragment(
                &file(text),
                std::slice::from_ref(&declarations),
                &Library::default(),
                &LibraryWords::default(),
            )
            .optics
        };
        assert_eq!(ask("box { 0, 1 texture { Dull } }"), Optics::Opaque);
        assert_eq!(
            ask("box { 0, 1 texture { Bright } }"),
            Optics::Optical("`Bright` may have `reflection`".into())
        );
    }

    #[test]
    fn a_number_added_to_a_colour_lets_light_through() {
        let declarations = file(
            "#declare Own = color rgb <1,0,0>; #declare Dim = Own*0.5; #declare Size = 2;\n\
             #declare Milky = Own*0.5+0.2;",
        );
        let ask = |text: &str| {
            fragment(
                &file(text),
                std::slice::from_ref(&declarations),
                &Library::default(),
                &LibraryWords::default(),
            )
            .optics
        };
        for text in [
            "box { 0, Size+1 pigment { Dim*0.5 } }",
            "box { 0, 1 pigment { rgb <1,1,1>*0.5+0.1 } translate Size-2 }",
        ] {
            assert_eq!(ask(text), Optics::Opaque, "{text}");
        }
        for text in [
            "box { 0, 1 pigment { Own*0.5+0.2 } }",
            "box { 0, 1 pigment { color Dim-0.1 } }",
            "box { 0, 1 pigment { Milky } }",
        ] {
            assert!(ask(text).is_optical(), "{text}");
        }
    }

    #[test]
    fn what_a_layer_does_not_share_is_found() {
        let ask = |text: &str| {
            fragment(
                &file(text),
                &[],
                &Library::default(),
                &LibraryWords::default(),
            )
            .unlayerable
        };
        assert_eq!(ask("box { 0, 1 }"), None);
        assert_eq!(
            ask("box { 0,\n clock }").unwrap(),
            "uses `clock` (part.inc line 2)"
        );
        assert!(ask("#default { finish { ambient 1 } } box { 0, 1 }").is_some());
    }
}

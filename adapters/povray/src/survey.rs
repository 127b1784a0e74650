//! What the words of a fragment say: does it mirror or let light through, and
//! may it be put into a layer at all?
//!
//! The answer errs on one side only. Looks that are pulled in by name are
//! followed into the files that define them; what cannot be followed counts as
//! a mirror.

use std::collections::{HashMap, HashSet};
use std::path::Path;

use decor_api::{AdapterError, NativeFile, Optics};

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
const UNLAYERABLE: [&str; 19] = [
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

fn is_optical_word(token: &Token<'_>) -> bool {
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

/// Words at the top of a file that put something into the scene.
const OBJECTS: [&str; 34] = [
    "light_source",
    "light_group",
    "camera",
    "object",
    "union",
    "merge",
    "intersection",
    "difference",
    "sphere",
    "box",
    "cylinder",
    "cone",
    "torus",
    "plane",
    "disc",
    "polygon",
    "triangle",
    "smooth_triangle",
    "mesh",
    "mesh2",
    "blob",
    "bicubic_patch",
    "height_field",
    "isosurface",
    "julia_fractal",
    "lathe",
    "ovus",
    "parametric",
    "poly",
    "prism",
    "quadric",
    "sor",
    "sphere_sweep",
    "superellipsoid",
];

/// The same for what surrounds the scene: at home in a sky, not among
/// declarations.
const SURROUNDING: [&str; 5] = ["background", "sky_sphere", "fog", "rainbow", "media"];

/// What the files around a scene say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Around {
    /// Why no part of a picture can be kept, where that is so.
    pub unlayerable: Option<String>,
    /// The sky holds fog: it changes the colour of objects.
    pub fog: bool,
    /// The declarations change what objects look like by default.
    pub default: bool,
    /// The declarations may keep a state from one fragment to the next.
    pub stateful: bool,
}

/// Looks at a film's declarations and its sky.
///
/// # Errors
/// [`AdapterError::BadInput`] where one puts an object, a light or a camera into
/// the scene.
pub fn around(
    includes: &[NativeFile],
    sky: Option<&NativeFile>,
    library: &Library,
) -> Result<Around, AdapterError> {
    let mut around = Around::default();
    for file in includes {
        around.read(file, library, false)?;
    }
    if let Some(file) = sky {
        around.read(file, library, true)?;
    }
    Ok(around)
}

impl Around {
    fn read(
        &mut self,
        file: &NativeFile,
        library: &Library,
        sky: bool,
    ) -> Result<(), AdapterError> {
        for (path, text) in &tree(file, library).own {
            let found = tokens(text);
            if let Some(token) = placed(&found, &OBJECTS) {
                return Err(AdapterError::BadInput {
                    file: path.clone(),
                    reason: format!(
                        "`{}` in line {}: {} may hold no object, light or camera; they belong into the film",
                        token.text(),
                        token.line,
                        if sky {
                            "a sky"
                        } else {
                            "a file of declarations"
                        },
                    ),
                });
            }
            if !sky && let Some(token) = placed(&found, &SURROUNDING) {
                return Err(AdapterError::BadInput {
                    file: path.clone(),
                    reason: format!(
                        "`{}` in line {}: what surrounds the scene belongs into `*sky`",
                        token.text(),
                        token.line,
                    ),
                });
            }
            self.fog |= sky && changes_objects(&found);
            self.default |= found.iter().any(|t| t.is("#default"));
            self.stateful |= found
                .iter()
                .any(|t| t.is("#macro") || t.is("seed") || t.is("rand"));
            // Every object would mirror, those of neutral descriptions too; and
            // a sky is not there in every pass.
            let default = found.iter().find(|t| t.is("#default"));
            let optical = found.iter().any(is_optical_word);
            let global = found.iter().find(|t| sky && t.is("global_settings"));
            if let Some(t) = default.filter(|_| sky || optical).or(global)
                && self.unlayerable.is_none()
            {
                let place = format!("{} line {}", name_of(path), t.line);
                self.unlayerable = Some(format!("`{}` in {place}", t.text()));
            }
            let forbidden = |t: &&Token<'_>| {
                let allowed = ["global_settings", "light_source", "light_group", "camera"];
                let word = t.kind == Kind::Word
                    && UNLAYERABLE.iter().any(|w| t.is(w))
                    && !allowed.iter().any(|w| t.is(w));
                // Scattering is sampled at random along each ray.
                let media = sky && t.is("media");
                let files = t.kind == Kind::Directive && (t.is("#fopen") || t.is("#write"));
                word || media || files
            };
            if self.unlayerable.is_none()
                && let Some(t) = found.iter().find(forbidden)
            {
                self.unlayerable = Some(format!(
                    "`{}` in {} line {}",
                    t.text(),
                    name_of(path),
                    t.line
                ));
            }
        }
        Ok(())
    }
}

/// May a sky change the colour of objects? Not where it is made of backgrounds
/// and sky spheres alone.
fn changes_objects(found: &[Token<'_>]) -> bool {
    let mut braces = 0_i32;
    let mut harmless = true;
    for token in found {
        match token.bytes {
            b"{" => braces += 1,
            b"}" => braces -= 1,
            b"fog" | b"rainbow" => harmless = false,
            _ if token.kind == Kind::Word && braces == 0 => {
                harmless &= token.is("background") || token.is("sky_sphere");
            }
            _ => {}
        }
    }
    !harmless
}

/// The first of `words` that stands at the top of the file, outside of
/// declarations, macros and braces.
fn placed<'t, 'a>(found: &'t [Token<'a>], words: &[&str]) -> Option<&'t Token<'a>> {
    let (mut braces, mut blocks, mut macro_depth) = (0_i32, 0_i32, None);
    for (at, token) in found.iter().enumerate() {
        match token.bytes {
            b"{" => braces += 1,
            b"}" => braces -= 1,
            b"#if" | b"#ifdef" | b"#ifndef" | b"#while" | b"#for" | b"#switch" => blocks += 1,
            b"#macro" => {
                blocks += 1;
                macro_depth.get_or_insert(blocks);
            }
            b"#end" => {
                if macro_depth == Some(blocks) {
                    macro_depth = None;
                }
                blocks -= 1;
            }
            _ if token.kind == Kind::Word
                && braces == 0
                && macro_depth.is_none()
                && words.iter().any(|w| token.is(w)) =>
            {
                let before = at.checked_sub(1).map(|k| &found[k]);
                let declared = before.is_some_and(|t| t.is("=") || t.is("(") || t.is(","));
                let opens = found.get(at + 1).is_some_and(|t| t.is("{"));
                if !declared && opens {
                    return Some(token);
                }
            }
            _ => {}
        }
    }
    None
}

fn name_of(path: &Path) -> String {
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

    #[test]
    fn declarations_may_not_place_anything() {
        let ask = |text: &str| around(&[file(text)], None, &Library::default());
        assert_eq!(
            ask("#declare A = sphere { 0, 1 }").unwrap(),
            Around::default()
        );
        assert!(ask("#macro M() sphere { 0, 1 } #end").unwrap().stateful);
        for text in [
            "sphere { 0, 1 }",
            "#if (1) light_source { 0 rgb 1 } #end",
            "fog { distance 3 }",
        ] {
            assert!(ask(text).is_err(), "{text}");
        }
    }

    #[test]
    fn a_sky_may_surround_but_not_place() {
        let ask = |text: &str| around(&[], Some(&file(text)), &Library::default());
        assert!(ask("fog { distance 3 rgb 1 }").unwrap().fog);
        assert!(
            ask("media { scattering { 1, rgb 1 } }")
                .unwrap()
                .unlayerable
                .is_some()
        );
        assert!(
            ask("sky_sphere { pigment { rgb z } }")
                .unwrap()
                .unlayerable
                .is_none()
        );
        assert!(ask("plane { y, 100 }").is_err());
    }
}

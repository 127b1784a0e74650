//! What the words of the files around a scene say: declarations may not place
//! anything, and a sky may only surround.

use decor_api::{AdapterError, NativeFile};

use crate::sources::{Library, tree};
use crate::survey::{UNLAYERABLE, is_optical_word, name_of};
use crate::tokens::{Kind, Token, tokens};

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

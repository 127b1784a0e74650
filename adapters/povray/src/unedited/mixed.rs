//! CSG objects whose shadows depend on what was traced before.
//!
//! POV-Ray remembers the object that stopped the last shadow ray of a light, and
//! asks it first. A `difference`, `intersection` or `merge` with an opaque texture
//! of its own counts as opaque, also where a part of it is glass with a texture of
//! its own: then the light goes through that part once or twice, as the object was
//! remembered or not. (Unions are asked part by part.)
//!
//! Only what the text shows is found here: parts by name are not followed.

use crate::tokens::{Kind, Token};

/// What gives an object its looks.
const LOOKS: &[&str] = &["texture", "pigment", "material"];

/// Words by which light passes.
const CLEAR: &[&str] = &["rgbf", "rgbt", "rgbft", "filter", "transmit"];

/// The lines of CSG objects of that kind.
pub fn mixed(tokens: &[Token<'_>]) -> Vec<usize> {
    let is_csg = |token: &Token<'_>| {
        let known = ["difference", "intersection", "merge"];
        token.kind == Kind::Word && known.iter().any(|word| token.is(word))
    };
    let starts = tokens.windows(2).enumerate();
    starts
        .filter(|(_, pair)| is_csg(&pair[0]) && pair[1].is("{"))
        .filter(|(at, _)| is_mixed(&tokens[at + 1..]))
        .map(|(_, pair)| pair[0].line)
        .collect()
}

/// Has the block that begins here looks of its own, and a part with other ones that
/// may let light through?
fn is_mixed(tokens: &[Token<'_>]) -> bool {
    let (mut depth, mut own, mut clear) = (0_usize, false, false);
    // Since which depth the looks of a part are described.
    let mut inside: Option<usize> = None;
    for (at, token) in tokens.iter().enumerate() {
        if token.is("{") {
            depth += 1;
        } else if token.is("}") {
            depth -= 1;
            inside = inside.filter(|since| depth > *since);
            if depth == 0 {
                break;
            }
        } else if token.kind == Kind::Word {
            let opens = tokens.get(at + 1).is_some_and(|next| next.is("{"));
            if opens && LOOKS.iter().any(|word| token.is(word)) && inside.is_none() {
                inside = Some(depth);
                own |= depth == 1;
            } else if inside.is_some_and(|since| since > 1) {
                // A name may stand for anything.
                let named = token.bytes.first().is_some_and(u8::is_ascii_uppercase);
                clear |= named || CLEAR.iter().any(|word| token.is(word));
            }
        }
    }
    own && clear
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tokens::tokens;

    fn lines(text: &str) -> Vec<usize> {
        mixed(&tokens(text.as_bytes()))
    }

    #[test]
    fn opaque_objects_with_a_part_of_glass() {
        let glass = "box { -1, 1 pigment { rgbf <1, 1, 1, .7> } }";
        let red = "sphere { 0, 1 pigment { rgb x } }";
        for csg in ["difference", "intersection", "merge"] {
            let text = format!("\n{csg} {{ {glass} {red} texture {{ pigment {{ rgb 1 }} }} }}");
            assert_eq!(lines(&text), [2], "{text}");
        }
        let named =
            "difference { box { -1, 1 texture { Glass } } sphere { 0, 1 } pigment { rgb 1 } }";
        assert_eq!(lines(named), [1]);
        for other in [
            format!("union {{ {glass} {red} pigment {{ rgb 1 }} }}"),
            format!("difference {{ {glass} {red} }}"),
            format!("difference {{ {red} {red} pigment {{ rgb 1 }} }}"),
            "difference { box { -1, 1 } sphere { 0, 1 } pigment { rgbf .9 } }".to_owned(),
            "difference {".to_owned(),
            "difference { } } }".to_owned(),
        ] {
            assert_eq!(lines(&other), Vec::<usize>::new(), "{other}");
        }
    }
}

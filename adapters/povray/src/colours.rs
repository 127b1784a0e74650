//! Colours that are summed: does a number added to a colour make it let light
//! through?
//!
//! A number beside a colour stands for all five of its parts: `White*0.5 + 0.2`
//! filters and transmits two tenths. Behind `rgb` there are only three parts,
//! and a product keeps the zeros of what is opaque.

use std::collections::HashSet;

use crate::tokens::{Kind, Token};

/// Words behind which a colour stands.
const COLOUR_WORDS: [&str; 6] = ["color", "colour", "rgb", "red", "green", "blue"];

/// Do these words of a definition make it a colour?
pub fn is_colour<'w>(mut words: impl Iterator<Item = &'w str>) -> bool {
    words.any(|word| COLOUR_WORDS.contains(&word))
}

/// The names that the tokens declare as colours, added to `known`: what stands
/// behind the `=` is a colour, or one that is known already.
pub fn declared(found: &[Token<'_>], known: &mut HashSet<String>) {
    for four in found.windows(4) {
        let declares = four[0].is("#declare") || four[0].is("#local");
        if !declares || !four[2].is("=") || four[3].kind != Kind::Word {
            continue;
        }
        let first = four[3].text();
        if COLOUR_WORDS.contains(&first.as_ref()) || known.contains(first.as_ref()) {
            known.insert(four[1].text().into_owned());
        }
    }
}

/// The first colour of `known` that a number, or something that nobody knows, is
/// added to or subtracted from.
pub fn sum_with_number<'t, 'a>(
    found: &'t [Token<'a>],
    known: impl Fn(&str) -> bool,
) -> Option<&'t Token<'a>> {
    let is_colour = |at: usize| {
        let token = &found[at];
        // A component is a number.
        let component = found.get(at + 1).is_some_and(|t| t.is("."));
        let declared = at > 0 && found[at - 1].kind == Kind::Directive;
        token.kind == Kind::Word && !component && !declared && known(&token.text())
    };
    (0..found.len()).find_map(|at| {
        if !is_colour(at) {
            return None;
        }
        let right = terms(found, at, true);
        let left = terms(found, at, false);
        let plain = |term: &Vec<usize>| {
            !term.is_empty() && !term.iter().any(|&k| is_colour(k) || found[k].is("<"))
        };
        // The first term of each side is the colour's own.
        let others = right.iter().skip(1).chain(left.iter().skip(1));
        others.into_iter().any(plain).then_some(&found[at])
    })
}

/// The terms of the sum that `found[at]` is in, from there to one end.
fn terms(found: &[Token<'_>], at: usize, forwards: bool) -> Vec<Vec<usize>> {
    let mut list = vec![vec![at]];
    let mut vector = 0_i32;
    let mut k = at;
    loop {
        let next = if forwards { k + 1 } else { k.wrapping_sub(1) };
        let Some(token) = found.get(next) else { break };
        // Between < and > the commas and signs are the vector's own.
        vector += i32::from(token.is("<")) - i32::from(token.is(">"));
        let inside = vector != 0 || token.is("<") || token.is(">");
        let ends = token.kind == Kind::Directive
            || token.kind == Kind::Text
            || ["{", "}", "[", "]", ";", "="].iter().any(|s| token.is(s))
            || (token.is(",") && !inside);
        // Two operands beside each other belong to two statements.
        let (one, other) = if forwards { (k, next) } else { (next, k) };
        let apart = !inside && is_operand_end(&found[one]) && is_operand_start(&found[other]);
        if ends || apart {
            break;
        }
        if !inside && (token.is("+") || token.is("-")) {
            list.push(Vec::new());
        } else if let Some(term) = list.last_mut() {
            term.push(next);
        }
        k = next;
    }
    list
}

fn is_number(token: &Token<'_>) -> bool {
    token.kind == Kind::Other && token.bytes.first().is_some_and(u8::is_ascii_digit)
}

fn is_operand_end(token: &Token<'_>) -> bool {
    token.kind == Kind::Word || is_number(token) || token.is(")")
}

fn is_operand_start(token: &Token<'_>) -> bool {
    token.kind == Kind::Word || is_number(token)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tokens::tokens;

    fn sums(text: &str) -> bool {
        let found = tokens(text.as_bytes());
        let mut known: HashSet<String> = ["White", "Red"].map(str::to_owned).into();
        declared(&found, &mut known);
        sum_with_number(&found, |name| known.contains(name)).is_some()
    }

    #[test]
    fn a_number_added_to_a_colour_is_found() {
        for text in [
            "pigment { White*0.5+0.2 }",
            "pigment { color 0.2 + White }",
            "pigment { color White - .1 }",
            "pigment { (White+0.2)*0.5 }",
            "pigment { (White)*0.5+0.2 scale 2 }",
            "color_map { [0 Red][1 Red*0.5+Amount] }",
            "#declare Own = color rgb <1,0,0>; box { 0, 1 pigment { Own+0.1 } }",
            "#declare Own = White*0.5; #declare Other = Own; pigment { Red+Other-1 }",
        ] {
            assert!(sums(text), "{text}");
        }
    }

    #[test]
    fn opaque_sums_and_products_are_not() {
        for text in [
            "pigment { rgb <1,0.5,0>*0.5 }",
            "pigment { rgb <1,0.5,0>*0.5+0.2 }",
            "pigment { White*0.5 } translate 2+1",
            "pigment { color White } scale Size+1",
            "pigment { White*0.5+Red*0.5 }",
            "pigment { White*0.5+<0.1,0.2,0.3> }",
            "pigment { color White*(0.5) rotate -20*x }",
            "color_map { [0.5+0.1 White][1-0.2 Red] }",
            "sphere { 0, White.red+0.5 }",
            "#declare Size = 2; sphere { 0, Size+0.2 pigment { rgb 1 } }",
            "checker White, Red-<0.1,0,0>",
        ] {
            assert!(!sums(text), "{text}");
        }
    }
}

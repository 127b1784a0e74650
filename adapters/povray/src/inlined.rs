//! A fragment's text with the unions that it names written out where it places
//! them: `#local U = union { A B } object { U scale 2 }` places two objects, and only
//! so can they be told apart.
//!
//! Only what means the same in both places is written out: a union without
//! directives and parentheses (a loop, a macro, a random number), whose words are
//! declared once in the whole text, or nowhere in it; and no include between.

use std::collections::HashMap;
use std::ops::Range;

use crate::tokens::{Kind, Token, tokens};

/// Unions within unions are written out so many deep.
const MOST_ROUNDS: usize = 4;

/// A text becomes at most so many times as long.
const MOST_GROWTH: usize = 8;

/// The text with its named unions written out.
pub fn inlined(text: &[u8]) -> Vec<u8> {
    let most = MOST_GROWTH * text.len();
    let mut done = text.to_vec();
    for _ in 0..MOST_ROUNDS {
        match once(&done) {
            Some(longer) if longer.len() <= most => done = longer,
            _ => break,
        }
    }
    done
}

/// A union that has a name.
struct Named {
    /// What is between its braces, in bytes of the text.
    inside: Range<usize>,
    /// The token behind its declaration.
    end: usize,
}

/// The text with the unions that are placed written out; `None` where there is none.
fn once(text: &[u8]) -> Option<Vec<u8>> {
    let tokens = tokens(text);
    let unions = named(&tokens);
    let mut out = Vec::with_capacity(text.len());
    let mut copied = 0;
    for at in 0..tokens.len() {
        let Some([object, open, name]) = tokens.get(at..at + 3) else {
            break;
        };
        let is_placed = object.kind == Kind::Word && object.is("object") && open.is("{");
        let Some(union) = unions.get(name.bytes).filter(|_| is_placed) else {
            continue;
        };
        // In between, and behind, nothing else is read.
        let included = tokens[union.end.min(at)..at]
            .iter()
            .any(|t| t.is("#include"));
        if at < union.end || included {
            continue;
        }
        out.extend_from_slice(&text[copied..object.start]);
        out.extend_from_slice(b"union { ");
        out.extend_from_slice(&text[union.inside.clone()]);
        copied = name.start + name.bytes.len();
    }
    if copied == 0 {
        return None;
    }
    out.extend_from_slice(&text[copied..]);
    Some(out)
}

/// The unions that can be written out elsewhere, by name.
fn named<'a>(tokens: &[Token<'a>]) -> HashMap<&'a [u8], Named> {
    // How often each name is declared; a loop's more than once.
    let mut declared: HashMap<&[u8], usize> = HashMap::new();
    for pair in tokens.windows(2) {
        let declares = ["#declare", "#local", "#undef", "#macro"];
        if declares.iter().any(|word| pair[0].is(word)) {
            *declared.entry(pair[1].bytes).or_default() += 1;
        }
    }
    for three in tokens.windows(3).filter(|three| three[0].is("#for")) {
        *declared.entry(three[2].bytes).or_default() += 2;
    }
    let mut found = HashMap::new();
    let mut depth = 0_usize;
    for (at, token) in tokens.iter().enumerate() {
        // In a block a declaration may be read or not, or twice.
        let opens = [
            "#if", "#ifdef", "#ifndef", "#while", "#for", "#switch", "#macro",
        ];
        if opens.iter().any(|word| token.is(word)) {
            depth += 1;
        } else if token.is("#end") {
            depth = depth.saturating_sub(1);
        }
        let declares = token.is("#declare") || token.is("#local");
        let Some([name, equals, union, open]) = tokens.get(at + 1..at + 5) else {
            break;
        };
        let is_union = equals.is("=") && (union.is("union") || union.is("merge")) && open.is("{");
        if !(declares && is_union && depth == 0 && declared.get(name.bytes) == Some(&1)) {
            continue;
        }
        let Some(close) = closing(tokens, at + 5) else {
            continue;
        };
        let inside = &tokens[at + 5..close];
        let is_plain = |token: &Token<'_>| match token.kind {
            Kind::Directive => false,
            // Once, and before: else it is another thing where the union is placed.
            Kind::Word => match declared.get(token.bytes) {
                None => true,
                Some(1) => declared_before(tokens, at, token.bytes),
                Some(_) => false,
            },
            Kind::Text | Kind::List => true,
            Kind::Other => !(token.is("(") || token.is(")")),
        };
        if inside.iter().all(is_plain) {
            let named = Named {
                inside: open.start + 1..tokens[close].start,
                end: close + 1,
            };
            found.insert(name.bytes, named);
        }
    }
    found
}

/// Is a name declared before token `at`?
fn declared_before(tokens: &[Token<'_>], at: usize, name: &[u8]) -> bool {
    let mut pairs = tokens[..at].windows(2);
    pairs.any(|pair| (pair[0].is("#declare") || pair[0].is("#local")) && pair[1].bytes == name)
}

/// The brace that closes what is open before token `from`.
fn closing(tokens: &[Token<'_>], from: usize) -> Option<usize> {
    let mut depth = 1_usize;
    for (at, token) in tokens.iter().enumerate().skip(from) {
        if token.is("{") {
            depth += 1;
        } else if token.is("}") {
            depth -= 1;
            if depth == 0 {
                return Some(at);
            }
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unions_are_written_out_where_they_are_placed() {
        for (text, expected) in [
            (
                "#local U = union { box { 0, 1 } torus { 2, 1 } rotate x } object { U } object{U scale 2}",
                "#local U = union { box { 0, 1 } torus { 2, 1 } rotate x } \
                 union {  box { 0, 1 } torus { 2, 1 } rotate x  } union {  box { 0, 1 } torus { 2, 1 } rotate x  scale 2}",
            ),
            (
                "#local T = texture { pigment { rgb 1 } } #local U = merge { box { 0, 1 texture { T } } } object { U }",
                "#local T = texture { pigment { rgb 1 } } #local U = merge { box { 0, 1 texture { T } } } \
                 union {  box { 0, 1 texture { T } }  }",
            ),
        ] {
            assert_eq!(
                String::from_utf8(inlined(text.as_bytes())).unwrap(),
                expected
            );
        }
        let nested = "#local A = union { box { 0, 1 } } #local B = union { object { A } sphere { 0, 1 } } object { B scale 3 }";
        let out = String::from_utf8(inlined(nested.as_bytes())).unwrap();
        let placed = out.rsplit_once("sphere").unwrap().0;
        assert!(
            placed.ends_with("union {  union {  box { 0, 1 }  } "),
            "{out}"
        );
    }

    #[test]
    fn what_may_mean_something_else_stays() {
        for text in [
            // Declared twice, or only now and then.
            "#local U = union { box { 0, 1 } } #local U = union { box { 0, 2 } } object { U }",
            "#if (a) #local U = union { box { 0, 1 } } #end object { U }",
            // What it is made of changes, or is not there yet.
            "#local K = 1; #local U = union { box { 0, K } } #local K = 2; object { U }",
            "#local U = union { box { 0, K } } #local K = 2; object { U }",
            "#local U = union { box { 0, 1 } } #include \"other.inc\" object { U }",
            // Not the same twice.
            "#local U = union { box { 0, rand(S) } } object { U }",
            "#local U = union { #if (a) box { 0, 1 } #end } object { U }",
            "#local U = union { box { 0, K } } #for (K, 1, 2) object { U } #end",
            "#local U = difference { box { 0, 1 } box { 1, 2 } } object { U }",
            "#local U = union { box { 0, 1 } object { U }",
        ] {
            assert_eq!(String::from_utf8(inlined(text.as_bytes())).unwrap(), text);
        }
    }
}

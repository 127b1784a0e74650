//! Media that POV-Ray samples at fixed places along a ray, and those that it
//! samples at random ones.
//!
//! Method 3, its own since version 3.5, draws random numbers too, and multiplies
//! them by `jitter`, which is 0 unless it is stated. Methods 1 and 2 sample
//! anywhere, and draw from one row for all pixels: where blocks are left out, the
//! others come out otherwise. (Rays of light through media of one density are
//! sampled at random places by all methods: there, the place makes no difference.)
//!
//! Only the user's files are looked at, and only what is plain counts.

use super::analysis::Refusal;
use super::source::Sources;
use crate::tokens::{Kind, Token, tokens};

/// Words that follow the brace of media that are not made of others by name.
const OWN: &[&str] = &[
    "intervals",
    "samples",
    "method",
    "aa_threshold",
    "aa_level",
    "collect",
    "absorption",
    "emission",
    "scattering",
    "confidence",
    "variance",
    "ratio",
    "density",
];

/// Where media may be sampled at random, and why; empty: they are not.
pub fn random(sources: &Sources) -> Vec<Refusal> {
    let files = sources.files.iter().filter(|file| !file.library);
    let read: Vec<_> = files.map(|file| (&file.name, tokens(&file.text))).collect();
    // Media are older than method 3: without `#version`, POV-Ray 3.7 takes 3.6.
    let old = read.iter().any(|(_, list)| is_old(list));
    let mut found = Vec::new();
    for (name, list) in &read {
        for (at, token) in list.iter().enumerate() {
            let reason = if token.kind != Kind::Word {
                None
            } else if token.is("method") && !is_three(&list[at + 1..]) {
                Some("media are sampled at random, but by method 3")
            } else if token.is("media") && !is_fixed(&list[at + 1..], old) {
                Some("media may be sampled at random: their method is not plain")
            } else {
                None
            };
            found.extend(reason.map(|reason| Refusal {
                file: (*name).clone(),
                line: token.line,
                reason: reason.into(),
            }));
        }
    }
    found
}

/// `3`, and no expression that begins with it.
fn is_three(tokens: &[Token<'_>]) -> bool {
    let ends = |token: &Token<'_>| token.kind != Kind::Other || token.is("}");
    match tokens {
        [three, next, ..] => three.is("3") && ends(next),
        _ => false,
    }
}

/// Does the block that begins here state its method, or take a fixed one?
fn is_fixed(tokens: &[Token<'_>], old: bool) -> bool {
    if !tokens.first().is_some_and(|token| token.is("{")) {
        return false;
    }
    let mut depth = 0_usize;
    for token in tokens {
        if token.is("{") {
            depth += 1;
        } else if token.is("}") {
            depth -= 1;
        } else if token.is("method") {
            return true;
        }
        if depth == 0 {
            break;
        }
    }
    // Others by name say their method themselves.
    let first = tokens.get(1);
    let named = first.is_some_and(|t| t.kind == Kind::Word && !OWN.iter().any(|w| t.is(w)));
    depth == 0 && (named || !old)
}

/// Is a version stated that is, or may be, before 3.5?
fn is_old(tokens: &[Token<'_>]) -> bool {
    let mut all = tokens.iter().enumerate();
    all.any(|(at, token)| {
        token.kind == Kind::Directive
            && token.is("#version")
            && !tokens.get(at + 1).is_some_and(|number| {
                let number = std::str::from_utf8(number.bytes).ok();
                let number = number.and_then(|text| text.parse::<f64>().ok());
                number.is_some_and(|version| (3.5..4.0).contains(&version))
            })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> Vec<String> {
        let sources = Sources::of_texts(&[("a.pov", text)]);
        random(&sources).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn media_by_method_3_are_sampled_at_fixed_places() {
        for fixed in [
            "media { method 3 samples 2 absorption 1 }",
            "media { scattering { 1, rgb 1 } density { wrinkles } }",
            "#version 3.7; media { emission 1 }",
            "#version 3.1; media { emission 1 method 3 }",
            "#declare M = media { method 3 emission 1 } sphere { 0, 1 interior { media { M } } }",
        ] {
            assert_eq!(said(fixed), Vec::<String>::new(), "{fixed}");
        }
    }

    #[test]
    fn other_media_are_random_or_may_be() {
        for random in [
            "\nmedia { method 1 emission 1 }",
            "\nmedia { method 2 emission 1 }",
            "\nmedia { emission 1 method 3 - 1 }",
            "\nmedia { emission 1 method M }",
            "\nmedia { emission 1 } #version 3.1;",
            "#declare V = 3.1; #version V;\nmedia { emission 1 }",
            "\nmedia { } #version 3.1;",
            "\nmedia",
        ] {
            let found = said(random);
            assert!(
                found.len() == 1 && found[0].starts_with("a.pov:2: media"),
                "{random}: {found:?}"
            );
        }
    }
}

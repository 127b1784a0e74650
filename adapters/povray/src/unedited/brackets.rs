//! Which bracket belongs to which. Macros are looked at by themselves: one that
//! opens what another closes may stand in a library and never be called.

use std::collections::HashMap;

use super::lex::{Kind, Token};

/// The brackets of a text.
#[derive(Default)]
pub struct Brackets {
    /// The partner of each bracket; for other tokens their own.
    pub partner: Vec<usize>,
    /// A bracket without partner, outside of all macros.
    pub broken: Option<usize>,
    /// The same in macros, by the `#macro`. What nobody calls may be like that.
    pub broken_macros: HashMap<usize, usize>,
}

impl Brackets {
    /// The brackets of these tokens.
    pub fn of(tokens: &[Token<'_>]) -> Self {
        let mut found = Self {
            partner: (0..tokens.len()).collect(),
            ..Self::default()
        };
        // Open directives (is it a macro?), and the brackets open in each macro.
        let mut directives: Vec<Option<usize>> = Vec::new();
        let mut open: Vec<(Option<usize>, Vec<usize>)> = vec![(None, Vec::new())];
        for (at, token) in tokens.iter().enumerate() {
            match (token.kind, token.text) {
                (Kind::Directive, "macro") => {
                    directives.push(Some(at));
                    open.push((Some(at), Vec::new()));
                }
                (Kind::Directive, "if" | "ifdef" | "ifndef" | "while" | "for" | "switch") => {
                    directives.push(None);
                }
                (Kind::Directive, "end") => {
                    if let Some(Some(_)) = directives.pop()
                        && let Some((within, left)) = open.pop()
                        && let Some(bracket) = left.first()
                    {
                        found.without_partner(within, *bracket);
                    }
                }
                (Kind::Mark, "(" | "[" | "{") => {
                    if let Some((_, open)) = open.last_mut() {
                        open.push(at);
                    }
                }
                (Kind::Mark, mark @ (")" | "]" | "}")) => {
                    let Some((within, open)) = open.last_mut() else {
                        continue;
                    };
                    let opening = match mark {
                        ")" => "(",
                        "]" => "[",
                        _ => "{",
                    };
                    match open.pop() {
                        Some(other) if tokens[other].text == opening => {
                            found.partner[at] = other;
                            found.partner[other] = at;
                        }
                        _ => {
                            let within = *within;
                            found.without_partner(within, at);
                        }
                    }
                }
                _ => {}
            }
        }
        for (within, left) in open {
            if let Some(bracket) = left.first() {
                found.without_partner(within, *bracket);
            }
        }
        found
    }

    fn without_partner(&mut self, within: Option<usize>, bracket: usize) {
        match within {
            Some(definition) => {
                self.broken_macros.entry(definition).or_insert(bracket);
            }
            None => {
                self.broken.get_or_insert(bracket);
            }
        }
    }
}

//! A walk through the tokens of a file, word by word: what is a statement, what is
//! called, and what is neither.

mod directives;

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use super::super::lex::{Kind, Token};
use super::super::values::{arguments, is_colour, is_global, is_object};
use super::{Call, Item, Odd, Outline, Raw, Tail};

pub(super) const NO_PARTNER: &str = "this bracket has no partner";

/// An open directive.
pub(super) struct Open {
    name: &'static str,
    control: usize,
    depth: usize,
    /// The unit to go back to behind a macro.
    outer: Option<usize>,
}

/// A walk through the tokens of a file.
pub(super) struct Walk<'m, 'a> {
    macros: &'m HashSet<&'a str>,
    /// Macros with a bracket without partner.
    broken: &'m HashMap<usize, usize>,
    pub(super) file: usize,
    pub(super) unit: usize,
    pub(super) control: usize,
    pub(super) stack: Vec<Open>,
    pub(super) at: usize,
    depth: usize,
    /// Before this token a value goes on.
    value_until: usize,
    /// Before this token a statement or a call goes on.
    item_until: usize,
}

impl<'m, 'a> Walk<'m, 'a> {
    pub(super) fn new(
        file: usize,
        macros: &'m HashSet<&'a str>,
        broken: &'m HashMap<usize, usize>,
    ) -> Self {
        Self {
            macros,
            broken,
            file,
            unit: 0,
            control: 0,
            stack: Vec::new(),
            at: 0,
            depth: 0,
            value_until: 0,
            item_until: 0,
        }
    }

    pub(super) fn step(&mut self, outline: &mut Outline<'a>) {
        let token = outline.tokens[self.file].list[self.at];
        match token.kind {
            Kind::Directive => self.directive(outline, token.text),
            Kind::Word => {
                self.word(outline, token.text);
                self.at += 1;
            }
            Kind::Mark => {
                self.mark(outline, token.text);
                self.at += 1;
            }
            Kind::Text | Kind::Number => {
                self.other(outline);
                self.at += 1;
            }
        }
    }

    fn token(&self, outline: &Outline<'a>, at: usize) -> Option<Token<'a>> {
        outline.tokens[self.file].list.get(at).copied()
    }

    fn is_mark(&self, outline: &Outline<'a>, at: usize, mark: &str) -> bool {
        self.token(outline, at).is_some_and(|t| t.is_mark(mark))
    }

    fn words(&self, outline: &Outline<'a>, range: Range<usize>) -> Vec<&'a str> {
        outline.words_in(self.file, range)
    }

    pub(super) fn odd(&self, outline: &mut Outline<'a>, token: usize, reason: &'static str) {
        outline.units[self.unit].odd.push(Odd { token, reason });
    }

    /// The depth that the unit itself is at: macros may stand in braces.
    fn base(&self) -> usize {
        let unit = self.stack.iter().rev().find(|open| open.name == "macro");
        unit.map_or(0, |open| open.depth)
    }

    /// Is this a place for statements?
    fn outside(&self) -> bool {
        self.depth == self.base() && self.at >= self.value_until && self.at >= self.item_until
    }

    fn other(&self, outline: &mut Outline<'a>) {
        if self.outside() {
            let token = outline.tokens[self.file].list[self.at];
            let broken = match token.kind {
                // What a bracket opens, its partner closes.
                Kind::Mark => !matches!(token.text, "(" | "[" | "{" | ">" | ";"),
                _ => is_colour(token.text),
            };
            self.item(
                outline,
                Item::Other(self.at),
                if broken { Tail::Broken } else { Tail::Whole },
            );
        }
    }

    fn item(&self, outline: &mut Outline<'a>, item: Item<'a>, tail: Tail<'a>) {
        let unit = &mut outline.units[self.unit];
        unit.items.push(item);
        unit.last = Some(tail);
        if self.control == unit.control {
            unit.always = Some(tail);
        }
    }

    fn mark(&mut self, outline: &mut Outline<'a>, mark: &str) {
        self.other(outline);
        match mark {
            "(" | "[" | "{" => self.depth += 1,
            ")" | "]" | "}" => {
                if self.depth <= self.base() {
                    self.odd(
                        outline,
                        self.at,
                        "this bracket closes what stands elsewhere",
                    );
                }
                self.depth = self.depth.saturating_sub(1);
            }
            _ => {}
        }
    }

    fn word(&mut self, outline: &mut Outline<'a>, word: &'a str) {
        let outside = self.outside();
        let called = self.is_mark(outline, self.at + 1, "(");
        let is_macro = self.macros.contains(word);
        let mut as_statement = false;
        if outside {
            if is_macro && called {
                let end = outline.tokens[self.file].partner[self.at + 1] + 1;
                self.item(outline, Item::Call(word), Tail::Call(word));
                self.item_until = end;
                as_statement = true;
            } else {
                self.statement(outline, word);
            }
        }
        let unit = &mut outline.units[self.unit];
        unit.words.insert(word);
        if !as_statement {
            unit.nested.insert(word);
            let in_item = matches!(unit.items.last(), Some(Item::Statement(raw)) if raw.tokens.contains(&self.at));
            if !in_item && self.at >= self.value_until {
                unit.loose.insert(word);
            }
        }
        if called && (is_macro || matches!(word, "rand" | "seed" | "trace")) {
            self.call(outline, word);
        }
    }

    /// A word where statements stand: is it one?
    fn statement(&mut self, outline: &mut Outline<'a>, word: &'a str) {
        let mut end = self.at + 1;
        if self.is_mark(outline, end, "{") && (is_object(word) || is_global(word)) {
            end = outline.tokens[self.file].partner[end] + 1;
        } else if word == "default" {
            return self.default(outline, self.at);
        } else if self.macros.contains(word) || is_object(word) || is_global(word) {
            return self.other(outline);
        } else {
            // An object that has a name may stand alone, or in an array.
            while self.is_mark(outline, end, "[") {
                end = outline.tokens[self.file].partner[end] + 1;
            }
            let alone = self
                .token(outline, end)
                .is_none_or(|next| matches!(next.kind, Kind::Directive | Kind::Word));
            if !alone {
                return self.other(outline);
            }
        }
        let raw = self.raw(outline, word, self.at..end);
        self.item(outline, Item::Statement(raw), Tail::Whole);
        self.item_until = end;
    }

    fn raw(&self, outline: &Outline<'a>, keyword: &'a str, tokens: Range<usize>) -> Raw<'a> {
        Raw {
            keyword,
            words: self.words(outline, tokens.clone()),
            tokens,
            unit: self.unit,
            control: self.control,
        }
    }

    fn call(&self, outline: &mut Outline<'a>, callee: &'a str) {
        let open = self.at + 1;
        let close = outline.tokens[self.file].partner[open];
        let arguments = arguments(&outline.tokens[self.file], open);
        let arguments = arguments.map(|list| {
            let words = |range: &Range<usize>| self.words(outline, range.clone());
            list.iter().map(words).collect()
        });
        outline.calls.push(Call {
            callee,
            arguments,
            words: self.words(outline, open..close),
            control: self.control,
            unit: self.unit,
            token: self.at,
        });
    }
}

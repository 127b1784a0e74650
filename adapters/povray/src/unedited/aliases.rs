//! Names that stand for one expression of numbers and the clock: `#declare T = clock*4;`.
//!
//! A name is one where it is given a value in a single place ([`Outline::single`]). Then
//! whatever stands there is, wherever it is used, the value of that expression: a use
//! before it, or where a condition left it out, is an error, and no picture.

use std::collections::{HashMap, HashSet};
use std::ops::Range;

use super::expression::{Names, read};
use super::lex::Kind;
use super::outline::{Assignment, Outline};
use super::steps::text;

/// Names of expressions.
#[derive(Debug, Default)]
pub(super) struct Aliases<'a> {
    /// What they stand for.
    pub values: Names<'a>,
    /// The same in POV-Ray's language, in brackets.
    pub texts: HashMap<&'a str, String>,
    /// Those that differ from frame to frame.
    moving: HashSet<&'a str>,
    /// Where they are declared: the file, and the tokens.
    places: Vec<(usize, Range<usize>)>,
}

impl<'a> Aliases<'a> {
    /// Those of a scene.
    pub fn of(outline: &Outline<'a>) -> Self {
        let mut single = outline.single();
        single.retain(|assignment| !outline.called.contains_key(assignment.name));
        let mut found = Self::default();
        // A name may be made of others, whatever their order.
        while found.add(outline, &single) {}
        found
    }

    /// Adds names whose values are made of known ones; is there any?
    fn add(&mut self, outline: &Outline<'a>, single: &[&Assignment<'a>]) -> bool {
        let before = self.values.len();
        for assignment in single {
            let name = assignment.name;
            if self.values.contains_key(name) {
                continue;
            }
            let file = outline.units[assignment.unit].file;
            let list = &outline.tokens[file].list;
            let start = assignment.token + 2;
            let length = list
                .iter()
                .skip(start)
                .position(|token| token.is_mark(";") || token.kind == Kind::Directive);
            let Some(length) = length else {
                continue;
            };
            let end = start + length;
            if !list[end].is_mark(";") {
                continue;
            }
            let Some(value) = read(&list[start..end], &self.values) else {
                continue;
            };
            let words = list[start..end].iter();
            if words.clone().any(|token| self.moves(token.text)) {
                self.moving.insert(name);
            }
            let text = format!("({})", text(&list[start..end], self));
            self.texts.insert(name, text);
            self.values.insert(name, value);
            self.places.push((file, assignment.token..end));
        }
        self.values.len() > before
    }

    /// Does the word differ from frame to frame?
    pub fn moves(&self, word: &str) -> bool {
        matches!(word, "clock" | "frame_number") || self.moving.contains(word)
    }

    /// Is the token a part of a declaration of a name?
    pub fn declares(&self, file: usize, token: usize) -> bool {
        let mut places = self.places.iter();
        places.any(|(its, tokens)| *its == file && tokens.contains(&token))
    }
}

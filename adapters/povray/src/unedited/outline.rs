//! The outline of a scene: its units (files and macros), what governs what in
//! them (`#if`, `#while`…), what is assigned and called, and the statements that
//! stand in the scene itself.
//!
//! Nothing is evaluated. Where the structure of the text is not certain (braces
//! that a directive opens and another closes, values whose end is not clear), an
//! [`Odd`] says so; it counts where the unit is used.

mod walk;

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use super::brackets::Brackets;
use super::lex::{Kind, Token, lex};
use super::source::Sources;
use walk::{NO_PARTNER, Walk};

/// A file's tokens.
#[derive(Debug, Default)]
pub struct Tokens<'a> {
    /// The tokens.
    pub list: Vec<Token<'a>>,
    /// For each bracket the index of its partner; for other tokens their own.
    pub partner: Vec<usize>,
}

/// What decides whether, and how often, a part of the text is executed.
#[derive(Debug)]
pub struct Control<'a> {
    /// What it stands in.
    pub parent: Option<usize>,
    /// The unit that it belongs to.
    pub unit: usize,
    /// The words of its conditions.
    pub words: Vec<&'a str>,
    /// Is it `#while` or `#for`?
    pub loops: bool,
}

/// A file, or the body of a macro: what may be executed elsewhere.
#[derive(Debug)]
pub struct Unit<'a> {
    /// The name that it is called by: a macro's, or a file's as an `#include`
    /// spells it. The scene has none.
    pub names: Vec<&'a str>,
    /// Is it a macro?
    pub is_macro: bool,
    /// Its file.
    pub file: usize,
    /// Its first token; of a macro, its name.
    pub start: usize,
    /// A macro's parameters.
    pub params: Vec<&'a str>,
    /// Names that `#local` makes before anything else can use them.
    pub locals: HashSet<&'a str>,
    /// All words of its text, and the names of files that it includes.
    pub words: BTreeSet<&'a str>,
    /// The same without the macros and files that it calls as statements.
    pub nested: HashSet<&'a str>,
    /// Of those, the words that stand in no [`Item`] and no value.
    pub loose: HashSet<&'a str>,
    /// Its own control: all of it.
    pub control: usize,
    /// What governs a macro's definition.
    pub defined_in: Option<usize>,
    /// What stands in it outside all braces, in order.
    pub items: Vec<Item<'a>>,
    /// Regions of `#declare name = value;` outside all braces.
    pub values: Vec<Range<usize>>,
    /// What is not certain.
    pub odd: Vec<Odd>,
    /// The end of what it emits, conditions or not.
    last: Option<Tail<'a>>,
    /// The end of what it always emits.
    always: Option<Tail<'a>>,
}

/// How a macro's text ends.
#[derive(Clone, Copy, Debug)]
enum Tail<'a> {
    /// With a whole value.
    Whole,
    /// In the middle of one.
    Broken,
    /// As the text of another macro.
    Call(&'a str),
}

/// What stands outside all braces.
#[derive(Clone, Debug)]
pub enum Item<'a> {
    /// A statement: an object, a light, the camera, a setting.
    Statement(Raw<'a>),
    /// A macro is called.
    Call(&'a str),
    /// A file is included.
    Include(&'a str),
    /// Something else: no scene has it there, but a macro may.
    Other(usize),
}

/// A statement as it stands.
#[derive(Clone, Debug)]
pub struct Raw<'a> {
    /// Its keyword; an object's name where it stands alone.
    pub keyword: &'a str,
    /// Its tokens.
    pub tokens: Range<usize>,
    /// The unit that it is in.
    pub unit: usize,
    /// What governs it.
    pub control: usize,
    /// Its words, and the names of files that it includes.
    pub words: Vec<&'a str>,
}

/// Something whose structure is not certain.
#[derive(Clone, Debug)]
pub struct Odd {
    /// The token.
    pub token: usize,
    /// Why.
    pub reason: &'static str,
}

/// A name gets a value.
#[derive(Debug)]
pub struct Assignment<'a> {
    /// The name.
    pub name: &'a str,
    /// What the value is made of.
    pub words: Vec<&'a str>,
    /// What governs it.
    pub control: usize,
    /// The unit that it is in.
    pub unit: usize,
    /// The token of the name.
    pub token: usize,
}

/// A macro, a file or a function is called.
#[derive(Debug)]
pub struct Call<'a> {
    /// Its name.
    pub callee: &'a str,
    /// The words of each argument; where they cannot be told apart, `None`.
    pub arguments: Option<Vec<Vec<&'a str>>>,
    /// The words of all arguments.
    pub words: Vec<&'a str>,
    /// What governs it.
    pub control: usize,
    /// The unit that it is in.
    pub unit: usize,
    /// The token of the name.
    pub token: usize,
}

/// The outline of a scene.
#[derive(Debug, Default)]
pub struct Outline<'a> {
    /// The tokens of each of [`Sources::files`].
    pub tokens: Vec<Tokens<'a>>,
    /// All controls.
    pub controls: Vec<Control<'a>>,
    /// All units; the scene's is the first.
    pub units: Vec<Unit<'a>>,
    /// Which units a name calls.
    pub called: HashMap<&'a str, Vec<usize>>,
    /// Which names get which values.
    pub assignments: Vec<Assignment<'a>>,
    /// What is called.
    pub calls: Vec<Call<'a>>,
    /// `#default { … }` and `#version …`, wherever they stand.
    pub settings: Vec<Raw<'a>>,
    /// Directives that read or write files, wherever they stand: unit, token.
    pub file_access: Vec<(usize, usize)>,
    /// Names that `#undef` removes somewhere.
    pub undefined: HashSet<&'a str>,
    /// What cannot be split for certain: the file, the byte, and why.
    pub faults: Vec<(usize, usize, &'static str)>,
    /// Values that end for certain if a macro makes a whole value: the unit, the
    /// token, the macro.
    if_whole: Vec<(usize, usize, &'a str)>,
}

impl<'a> Outline<'a> {
    /// Reads the outline of all files.
    pub fn of(sources: &'a Sources) -> Self {
        let mut outline = Self::default();
        let mut broken_macros = Vec::new();
        for (file, source) in sources.files.iter().enumerate() {
            let lexed = lex(&source.text);
            let faults = lexed.faults.iter().map(|(at, why)| (file, *at, *why));
            outline.faults.extend(faults);
            let brackets = Brackets::of(&lexed.tokens);
            if let Some(token) = brackets.broken {
                let at = lexed.tokens[token].start;
                outline.faults.push((file, at, NO_PARTNER));
            }
            broken_macros.push(brackets.broken_macros);
            outline.tokens.push(Tokens {
                list: lexed.tokens,
                partner: brackets.partner,
            });
        }
        if !outline.faults.is_empty() {
            return outline;
        }
        // Macros must be known before their calls are: they end values.
        let mut macros = HashSet::new();
        for tokens in &outline.tokens {
            for pair in tokens.list.windows(2) {
                if pair[0].is_directive("macro") {
                    macros.insert(pair[1].text);
                }
            }
        }
        for (file, (source, broken)) in sources.files.iter().zip(&broken_macros).enumerate() {
            outline.file(Walk::new(file, &macros, broken), &source.called);
        }
        for (unit, token, name) in std::mem::take(&mut outline.if_whole) {
            if !outline.makes_whole(name, 0) {
                let reason = "where this value ends is not certain";
                outline.units[unit].odd.push(Odd { token, reason });
            }
        }
        outline
    }

    /// Does a call of the macro always make a whole value?
    fn makes_whole(&self, name: &str, depth: usize) -> bool {
        let is_whole = |tail: Option<Tail<'a>>| match tail {
            Some(Tail::Whole) => true,
            Some(Tail::Call(other)) => depth < 16 && self.makes_whole(other, depth + 1),
            Some(Tail::Broken) | None => false,
        };
        let units = self.called.get(name).into_iter().flatten();
        let mut units = units.map(|unit| &self.units[*unit]);
        units.all(|unit| is_whole(unit.last) && is_whole(unit.always))
    }

    fn file(&mut self, mut walk: Walk<'_, 'a>, names: &'a [String]) {
        let unit = self.unit(walk.file, None);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        for name in &names {
            self.called.entry(name).or_default().push(unit);
        }
        self.units[unit].names = names;
        let end = self.tokens[walk.file].list.len();
        walk.unit = unit;
        walk.control = self.units[unit].control;
        while walk.at < end {
            walk.step(self);
        }
        if !walk.stack.is_empty() {
            walk.odd(self, end.saturating_sub(1), "a directive has no #end");
        }
    }

    fn unit(&mut self, file: usize, defined_in: Option<usize>) -> usize {
        let unit = self.units.len();
        let control = self.controls.len();
        self.controls.push(Control {
            parent: None,
            unit,
            words: Vec::new(),
            loops: false,
        });
        self.units.push(Unit {
            names: Vec::new(),
            is_macro: false,
            file,
            start: 0,
            params: Vec::new(),
            locals: HashSet::new(),
            words: BTreeSet::new(),
            nested: HashSet::new(),
            loose: HashSet::new(),
            control,
            defined_in,
            items: Vec::new(),
            values: Vec::new(),
            odd: Vec::new(),
            last: None,
            always: None,
        });
        unit
    }

    /// Is the name the unit's own: a parameter, or a local of it?
    pub fn owns(&self, unit: usize, name: &str) -> bool {
        let at = &self.units[unit];
        (at.params.contains(&name) || at.locals.contains(name)) && !self.undefined.contains(name)
    }

    /// A control and what it stands in, inside out.
    pub fn governing(&self, control: usize) -> impl Iterator<Item = &Control<'a>> {
        let mut next = Some(control);
        std::iter::from_fn(move || {
            let control = &self.controls[next?];
            next = control.parent;
            Some(control)
        })
    }

    /// Names that are given a value by `#declare` or `#local` in a single place, and
    /// nowhere else mean anything. Where a macro gives one of its parameters a value there
    /// are none: it may be any name that it is called with.
    pub fn single(&self) -> Vec<&Assignment<'a>> {
        let params = self.units.iter().flat_map(|unit| &unit.params);
        let params: HashSet<&str> = params.copied().collect();
        let mut count: HashMap<&str, usize> = HashMap::new();
        for assignment in &self.assignments {
            if params.contains(assignment.name) {
                return Vec::new();
            }
            // `#undef` is one, too.
            *count.entry(assignment.name).or_default() += 1;
        }
        let is_single = |assignment: &&Assignment<'a>| {
            let list = &self.tokens[self.units[assignment.unit].file].list;
            let declared = assignment.token.checked_sub(1).is_some_and(|before| {
                list[before].is_directive("declare") || list[before].is_directive("local")
            });
            let set = list.get(assignment.token + 1);
            count[assignment.name] == 1 && declared && set.is_some_and(|t| t.is_mark("="))
        };
        self.assignments.iter().filter(is_single).collect()
    }

    /// The bytes of a statement.
    pub fn bytes(&self, raw: &Raw<'_>) -> Range<usize> {
        let tokens = &self.tokens[self.units[raw.unit].file].list;
        let start = tokens.get(raw.tokens.start).map_or(0, |token| token.start);
        let last = raw
            .tokens
            .end
            .checked_sub(1)
            .and_then(|last| tokens.get(last));
        start..last.map_or(start, |token| token.end)
    }

    /// The words of some tokens, and the names of the files that they include.
    pub fn words_in(&self, file: usize, range: Range<usize>) -> Vec<&'a str> {
        words_of(&self.tokens[file].list, range)
    }
}

fn words_of<'a>(tokens: &[Token<'a>], range: Range<usize>) -> Vec<&'a str> {
    let counts = |at: usize| match tokens[at].kind {
        Kind::Word => true,
        Kind::Text => at > 0 && tokens[at - 1].is_directive("include"),
        _ => false,
    };
    let range = range.start..range.end.min(tokens.len());
    range
        .filter(|at| counts(*at))
        .map(|at| tokens[at].text)
        .collect()
}

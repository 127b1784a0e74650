//! The outline of a scene: its units (files and macros), what governs what in
//! them (`#if`, `#while`…), what is assigned and called, and the statements that
//! stand in the scene itself.
//!
//! Nothing is evaluated. Where the structure of the text is not certain (braces
//! that a directive opens and another closes, values whose end is not clear), an
//! [`Odd`] says so; it counts where the unit is used.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use super::brackets::Brackets;
use super::lex::{Kind, Token, lex};
use super::source::Sources;
use super::values::{Shape, is_colour, is_global, is_object, value_end};

const NO_PARTNER: &str = "this bracket has no partner";

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

/// An open directive.
struct Open {
    name: &'static str,
    control: usize,
    depth: usize,
    /// The unit to go back to behind a macro.
    outer: Option<usize>,
}

/// A walk through the tokens of a file.
struct Walk<'m, 'a> {
    macros: &'m HashSet<&'a str>,
    /// Macros with a bracket without partner.
    broken: &'m HashMap<usize, usize>,
    file: usize,
    unit: usize,
    control: usize,
    stack: Vec<Open>,
    at: usize,
    depth: usize,
    /// Before this token a value goes on.
    value_until: usize,
    /// Before this token a statement or a call goes on.
    item_until: usize,
}

impl<'m, 'a> Walk<'m, 'a> {
    fn new(file: usize, macros: &'m HashSet<&'a str>, broken: &'m HashMap<usize, usize>) -> Self {
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

    fn step(&mut self, outline: &mut Outline<'a>) {
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

    fn odd(&self, outline: &mut Outline<'a>, token: usize, reason: &'static str) {
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
        let arguments = super::values::arguments(&outline.tokens[self.file], open);
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

    fn directive(&mut self, outline: &mut Outline<'a>, name: &'a str) {
        let here = self.at;
        self.at += 1;
        match name {
            "if" | "ifdef" | "ifndef" | "while" | "for" | "switch" => {
                let name = match name {
                    "while" | "for" => "loop",
                    "switch" => "switch",
                    _ => "if",
                };
                self.open(outline, here, name);
            }
            "elseif" | "case" | "range" => {
                self.check_depth(outline, here);
                let words = self.condition(outline, here);
                outline.controls[self.control].words.extend(words);
            }
            "else" => self.check_depth(outline, here),
            "end" => self.close(outline, here),
            "break" => self.break_out(outline, here),
            "macro" => self.define(outline, here),
            "declare" | "local" => self.assign(outline, here, name == "local"),
            "undef" => {
                if let Some(token) = self.token(outline, self.at) {
                    outline.undefined.insert(token.text);
                    self.assignment(outline, token.text, Vec::new(), self.at);
                    self.at += 1;
                }
            }
            "include" => self.include(outline, here),
            "default" => self.default(outline, here),
            "version" => {
                let value = value_end(&outline.tokens[self.file], self.at, self.macros);
                let raw = self.raw(outline, "version", here..value.end);
                outline.settings.push(raw);
                self.value_until = self.value_until.max(value.end);
            }
            "debug" | "warning" | "error" | "render" | "statistics" => self.message(outline),
            "fopen" | "fclose" | "read" | "write" => {
                outline.file_access.push((self.unit, here));
                // #fopen NAME "file" write, #fclose NAME, #write (NAME, …)
                let end = match name {
                    "fopen" => self.at + 3,
                    "fclose" => self.at + 1,
                    _ if self.is_mark(outline, self.at, "(") => {
                        outline.tokens[self.file].partner[self.at] + 1
                    }
                    _ => self.at,
                };
                self.item_until = self.item_until.max(end);
            }
            _ => self.odd(outline, here, "decor does not know this directive"),
        }
    }

    /// `#default { … }`; the # may be missing.
    fn default(&mut self, outline: &mut Outline<'a>, here: usize) {
        let brace = here + 1;
        if !self.is_mark(outline, brace, "{") {
            self.odd(outline, here, "#default has no braces");
            return;
        }
        let end = outline.tokens[self.file].partner[brace] + 1;
        let raw = self.raw(outline, "default", here..end);
        outline.settings.push(raw);
        self.value_until = self.value_until.max(end);
    }

    /// The words of the condition behind a directive, which is walked through too.
    fn condition(&mut self, outline: &mut Outline<'a>, here: usize) -> Vec<&'a str> {
        if !self.is_mark(outline, self.at, "(") {
            self.odd(outline, here, "no condition follows this directive");
            return Vec::new();
        }
        let end = outline.tokens[self.file].partner[self.at] + 1;
        // What it calls is no statement.
        self.item_until = self.item_until.max(end);
        self.words(outline, self.at..end)
    }

    fn open(&mut self, outline: &mut Outline<'a>, here: usize, name: &'static str) {
        let words = self.condition(outline, here);
        self.stack.push(Open {
            name,
            control: self.control,
            depth: self.depth,
            outer: None,
        });
        let counter = words.first().copied();
        let is_for = outline.tokens[self.file].list[here].is_directive("for");
        let rest = if is_for {
            words[1.min(words.len())..].to_vec()
        } else {
            Vec::new()
        };
        let outer = self.control;
        self.control = outline.controls.len();
        outline.controls.push(Control {
            parent: Some(outer),
            unit: self.unit,
            words,
            loops: name == "loop",
        });
        if let Some(counter) = counter.filter(|_| is_for) {
            self.make_local(outline, counter, outer);
            self.assignment(outline, counter, rest, here);
        }
    }

    /// A name that a unit makes at its outermost, before it uses it, is its own.
    fn make_local(&self, outline: &mut Outline<'a>, name: &'a str, control: usize) {
        let unit = &mut outline.units[self.unit];
        if unit.is_macro && control == unit.control && !unit.words.contains(name) {
            unit.locals.insert(name);
        }
        unit.words.insert(name);
    }

    fn check_depth(&self, outline: &mut Outline<'a>, here: usize) {
        match self.stack.last() {
            Some(open) if open.depth == self.depth && open.name != "macro" => {}
            Some(_) => self.odd(
                outline,
                here,
                "brackets open and close in different branches",
            ),
            None => self.odd(outline, here, "this directive continues nothing"),
        }
    }

    fn close(&mut self, outline: &mut Outline<'a>, here: usize) {
        let Some(open) = self.stack.pop() else {
            self.odd(outline, here, "this #end ends nothing");
            return;
        };
        if open.depth != self.depth {
            self.odd(
                outline,
                here,
                "brackets open and close in different branches",
            );
            self.depth = open.depth;
        }
        self.control = open.control;
        if let Some(outer) = open.outer {
            self.unit = outer;
        }
    }

    /// What governs a `#break` governs what it skips.
    fn break_out(&self, outline: &mut Outline<'a>, here: usize) {
        let mut words = Vec::new();
        let mut inner = self.control;
        for open in self.stack.iter().rev() {
            match open.name {
                "loop" | "switch" => {
                    if open.depth != self.depth {
                        self.odd(outline, here, "this #break leaves braces");
                    }
                    outline.controls[inner].words.extend(words);
                    return;
                }
                // Outside of loops, a #break leaves the macro.
                "macro" => {
                    if open.depth != self.depth {
                        self.odd(outline, here, "this #break leaves braces");
                    }
                    outline.controls[inner].words.extend(words);
                    return;
                }
                _ => {
                    words.extend_from_slice(&outline.controls[inner].words);
                    inner = open.control;
                }
            }
        }
        self.odd(outline, here, "this #break leaves the file");
    }

    fn define(&mut self, outline: &mut Outline<'a>, here: usize) {
        let name = self
            .token(outline, self.at)
            .filter(|t| t.kind == Kind::Word);
        let (Some(name), true) = (name, self.is_mark(outline, self.at + 1, "(")) else {
            self.odd(outline, here, "this macro has no name");
            return;
        };
        let open = self.at + 1;
        let close = outline.tokens[self.file].partner[open];
        let unit = outline.unit(self.file, Some(self.control));
        let params = self.words(outline, open..close);
        outline.units[unit].params = params;
        outline.units[unit].names = vec![name.text];
        outline.units[unit].is_macro = true;
        outline.units[unit].start = self.at;
        outline.called.entry(name.text).or_default().push(unit);
        self.stack.push(Open {
            name: "macro",
            control: self.control,
            depth: self.depth,
            outer: Some(self.unit),
        });
        self.unit = unit;
        self.control = outline.units[unit].control;
        self.at = close + 1;
        if let Some(bracket) = self.broken.get(&here) {
            self.odd(outline, *bracket, NO_PARTNER);
        }
    }

    fn assign(&mut self, outline: &mut Outline<'a>, here: usize, local: bool) {
        if self
            .token(outline, self.at)
            .is_some_and(|t| t.text == "deprecated")
        {
            self.at += 1;
            if self
                .token(outline, self.at)
                .is_some_and(|t| t.text == "once")
            {
                self.at += 1;
            }
            if self
                .token(outline, self.at)
                .is_some_and(|t| t.kind == Kind::Text)
            {
                self.at += 1;
            }
        }
        let name = self
            .token(outline, self.at)
            .filter(|t| t.kind == Kind::Word);
        let Some(name) = name else {
            self.odd(outline, here, "this declaration has no name");
            return;
        };
        let at = self.at;
        let mut equals = at + 1;
        while self.is_mark(outline, equals, "[") {
            equals = outline.tokens[self.file].partner[equals] + 1;
        }
        if !self.is_mark(outline, equals, "=") {
            self.odd(outline, here, "this declaration has no value");
            return;
        }
        let value = value_end(&outline.tokens[self.file], equals + 1, self.macros);
        match value.shape {
            Shape::Certain => {}
            Shape::IfWhole(name) => outline.if_whole.push((self.unit, here, name)),
            Shape::Uncertain => self.odd(outline, here, "where this value ends is not certain"),
        }
        if local && equals == at + 1 {
            self.make_local(outline, name.text, self.control);
        }
        let words = self.words(outline, at + 1..value.end);
        self.assignment(outline, name.text, words, at);
        if self.outside() {
            outline.units[self.unit].values.push(here..value.end);
        }
        self.value_until = self.value_until.max(value.end);
        self.at = at + 1;
    }

    fn assignment(
        &self,
        outline: &mut Outline<'a>,
        name: &'a str,
        words: Vec<&'a str>,
        token: usize,
    ) {
        outline.units[self.unit].words.insert(name);
        outline.assignments.push(Assignment {
            name,
            words,
            control: self.control,
            unit: self.unit,
            token,
        });
    }

    fn include(&mut self, outline: &mut Outline<'a>, here: usize) {
        let Some(name) = self
            .token(outline, self.at)
            .filter(|t| t.kind == Kind::Text)
        else {
            self.odd(outline, here, "the name of the file is computed");
            return;
        };
        let outside = self.outside();
        let unit = &mut outline.units[self.unit];
        unit.words.insert(name.text);
        if outside {
            unit.items.push(Item::Include(name.text));
        } else {
            unit.nested.insert(name.text);
        }
        outline.calls.push(Call {
            callee: name.text,
            arguments: None,
            words: Vec::new(),
            control: self.control,
            unit: self.unit,
            token: here,
        });
        self.at += 1;
    }

    /// `#debug concat(…)`: a string, which is no statement.
    fn message(&mut self, outline: &Outline<'a>) {
        let mut end = self.at + 1;
        while self.is_mark(outline, end, "(") || self.is_mark(outline, end, "[") {
            end = outline.tokens[self.file].partner[end] + 1;
        }
        self.item_until = self.item_until.max(end);
    }
}

//! What depends on what: from some words (`clock`) through values, conditions,
//! macros and their parameters to everything that they can reach.
//!
//! The order of the text does not count: a name that ever gets a value from the
//! clock depends on it everywhere. Parameters and locals of a macro are its own,
//! so that one call with the clock does not stain the others; but
//!
//! - a parameter may be a reference: what a macro writes to it, its callers'
//!   arguments get;
//! - scoping is dynamic: what a macro calls sees its parameters and locals;
//! - `rand` draws from streams that have many names: one draw more or less
//!   changes all that follow;
//! - `trace` writes to its fourth argument.

use std::collections::{BTreeMap, HashMap, HashSet};

use super::outline::{Call, Outline, Raw};
use super::source::{Sources, place};

/// Longest chain of reasons that is told.
const LONGEST: usize = 6;

/// Why something depends on the sources.
#[derive(Clone, Copy, Debug)]
struct Why<'a> {
    /// File and byte where it happens.
    at: (usize, usize),
    /// By which word, in which unit.
    by: Cause<'a>,
}

#[derive(Clone, Copy, Debug)]
enum Cause<'a> {
    Word(&'a str, usize),
    Run(usize),
}

/// All that depends on some words.
#[derive(Debug)]
pub struct Taint<'o, 'a> {
    outline: &'o Outline<'a>,
    sources: &'a Sources,
    used: &'o [bool],
    /// The words that it begins with.
    roots: HashSet<&'static str>,
    /// Do conditions count?
    controls: bool,
    names: HashMap<&'a str, Why<'a>>,
    own: BTreeMap<(usize, &'a str), Why<'a>>,
    run: HashMap<usize, Why<'a>>,
    seen: HashMap<&'a str, Why<'a>>,
    written: HashSet<(usize, &'a str)>,
    rand: Option<Why<'a>>,
    /// Names that can be written to.
    variables: HashSet<&'a str>,
    /// All units that a unit calls, and those that these call.
    calls: Vec<HashSet<usize>>,
}

impl<'o, 'a> Taint<'o, 'a> {
    /// What depends on `roots` in the units that are `used`. With `controls`,
    /// what conditions govern depends on them; without, only what is made of it.
    pub fn of(
        outline: &'o Outline<'a>,
        sources: &'a Sources,
        used: &'o [bool],
        roots: &[&'static str],
        controls: bool,
    ) -> Self {
        let mut variables: HashSet<&str> = outline.assignments.iter().map(|a| a.name).collect();
        variables.extend(outline.units.iter().flat_map(|unit| &unit.params));
        let mut taint = Self {
            outline,
            sources,
            used,
            roots: roots.iter().copied().collect(),
            controls,
            names: HashMap::new(),
            own: BTreeMap::new(),
            run: HashMap::new(),
            seen: HashMap::new(),
            written: HashSet::new(),
            rand: None,
            variables,
            calls: super::placing::reach(outline),
        };
        while taint.round() {}
        taint
    }

    /// Does a word depend on the roots, in a unit?
    fn depends(&self, word: &str, unit: usize) -> bool {
        self.roots.contains(word)
            || self.names.contains_key(word)
            || (word == "rand" && self.rand.is_some())
            || if self.outline.owns(unit, word) {
                self.own.contains_key(&(unit, word))
            } else {
                self.seen.contains_key(word)
            }
    }

    /// Does it in the text itself, whoever calls it with whatever?
    fn depends_always(&self, word: &str, unit: usize) -> bool {
        self.depends(word, unit) && !self.own.contains_key(&(unit, word))
            || self.names.contains_key(word)
    }

    fn first(&self, words: &[&'a str], unit: usize) -> Option<Cause<'a>> {
        let found = words.iter().find(|word| self.depends(word, unit));
        found.map(|word| Cause::Word(word, unit))
    }

    /// What governs something, and depends on the roots.
    fn governed(&self, control: usize) -> Option<Cause<'a>> {
        if !self.controls {
            return None;
        }
        let unit = self.outline.controls[control].unit;
        let mut governing = self.outline.governing(control);
        let by_word = governing.find_map(|control| self.first(&control.words, control.unit));
        by_word.or_else(|| self.run.contains_key(&unit).then_some(Cause::Run(unit)))
    }

    /// Why a statement depends on the roots, if it does.
    pub fn why(&self, raw: &Raw<'a>) -> Option<String> {
        let by_word = self.first(&raw.words, raw.unit);
        if let Some(cause) = by_word {
            return Some(format!("it is made with {}", self.told(cause, LONGEST)));
        }
        let cause = self.governed(raw.control)?;
        Some(format!(
            "whether it is there depends on {}",
            self.told(cause, LONGEST)
        ))
    }

    /// Does a statement depend on the roots?
    pub fn concerns(&self, raw: &Raw<'a>) -> bool {
        self.first(&raw.words, raw.unit).is_some() || self.governed(raw.control).is_some()
    }

    fn told(&self, cause: Cause<'a>, depth: usize) -> String {
        let (text, why) = match cause {
            Cause::Word(word, unit) => {
                let why = if self.roots.contains(word) {
                    None
                } else if word == "rand" && self.rand.is_some() {
                    self.rand
                } else {
                    let own = self.own.get(&(unit, word));
                    self.names
                        .get(word)
                        .or(own)
                        .or_else(|| self.seen.get(word))
                        .copied()
                };
                (format!("`{word}`"), why)
            }
            Cause::Run(unit) => {
                let name = self.outline.units[unit]
                    .names
                    .first()
                    .copied()
                    .unwrap_or("the scene");
                (
                    format!("whether `{name}` is run"),
                    self.run.get(&unit).copied(),
                )
            }
        };
        match why {
            None => text,
            Some(_) if depth == 0 => format!("{text} …"),
            Some(why) => {
                let at = place(self.sources, why.at.0, why.at.1);
                format!("{text} ({at}, with {})", self.told(why.by, depth - 1))
            }
        }
    }

    fn at(&self, unit: usize, token: usize) -> (usize, usize) {
        let file = self.outline.units[unit].file;
        let token = self.outline.tokens[file].list.get(token);
        (file, token.map_or(0, |token| token.start))
    }

    /// A name gets something that depends on the roots. Was that news?
    fn stain(&mut self, name: &'a str, unit: usize, why: Why<'a>) -> bool {
        if self.names.contains_key(name) {
            return false;
        }
        if !self.outline.owns(unit, name) {
            self.names.insert(name, why);
            return true;
        }
        let mut news = false;
        if self.outline.units[unit].params.contains(&name) {
            news = self.written.insert((unit, name));
        }
        if let std::collections::btree_map::Entry::Vacant(entry) = self.own.entry((unit, name)) {
            entry.insert(why);
            news = true;
        }
        news
    }

    fn round(&mut self) -> bool {
        let outline = self.outline;
        let mut news = false;
        for assignment in &outline.assignments {
            if !self.used[assignment.unit] {
                continue;
            }
            let cause = self.first(&assignment.words, assignment.unit);
            if let Some(by) = cause.or_else(|| self.governed(assignment.control)) {
                let at = self.at(assignment.unit, assignment.token);
                news |= self.stain(assignment.name, assignment.unit, Why { at, by });
            }
        }
        for call in &outline.calls {
            if self.used[call.unit] {
                news |= self.call(call);
            }
        }
        for (index, unit) in outline.units.iter().enumerate() {
            if !self.used[index] {
                continue;
            }
            let word = unit
                .words
                .iter()
                .find(|word| self.depends_always(word, index));
            let mut cause = word.map(|word| Cause::Word(word, index));
            if let Some(control) = unit.defined_in {
                cause = cause.or_else(|| self.governed(control));
            }
            if let Some(by) = cause {
                let at = self.at_unit(index);
                for name in &unit.names {
                    news |= self.names.insert(name, Why { at, by }).is_none();
                }
            }
        }
        news | self.callees_see()
    }

    fn at_unit(&self, unit: usize) -> (usize, usize) {
        let start = self.outline.units[unit].start;
        self.at(unit, start)
    }

    fn call(&mut self, call: &Call<'a>) -> bool {
        let governed = self.governed(call.control);
        let at = self.at(call.unit, call.token);
        let mut news = false;
        if matches!(call.callee, "rand" | "seed") {
            let cause = governed.or_else(|| match call.callee {
                // Another stream is drawn from: that one goes on, this one does not.
                "rand" => self.first(&call.words, call.unit),
                _ => None,
            });
            if let (Some(by), None) = (cause, self.rand) {
                self.rand = Some(Why { at, by });
                news = true;
            }
        }
        if call.callee == "trace" {
            let written: &[&str] = match &call.arguments {
                Some(list) if list.len() < 4 => &[],
                Some(list) if list.len() == 4 => &list[3],
                _ => &call.words,
            };
            if let Some(by) = self.first(&call.words, call.unit).or(governed) {
                news |= self.write_back(written, call.unit, Why { at, by });
            }
        }
        let callees = self
            .outline
            .called
            .get(call.callee)
            .map_or(&[][..], Vec::as_slice);
        for callee in callees {
            if let Some(by) = governed {
                news |= self.run.insert(*callee, Why { at, by }).is_none();
            }
            let params = &self.outline.units[*callee].params;
            for (k, param) in params.iter().enumerate() {
                let words: &[&str] = match &call.arguments {
                    Some(list) if list.len() == params.len() => &list[k],
                    _ => &call.words,
                };
                if let Some(by) = self.first(words, call.unit) {
                    news |= if self.outline.owns(*callee, param) {
                        self.own.insert((*callee, param), Why { at, by }).is_none()
                    } else {
                        self.names.insert(param, Why { at, by }).is_none()
                    };
                }
                // What the callee calls may write to it too: scoping is dynamic.
                let elsewhere = self.names.contains_key(param)
                    && (!self.outline.owns(*callee, param) || self.is_seen(*callee, param));
                if self.written.contains(&(*callee, *param)) || elsewhere {
                    let by = Cause::Word(param, *callee);
                    news |= self.write_back(words, call.unit, Why { at, by });
                }
            }
        }
        news
    }

    /// Something is written to whatever variable these words may be.
    fn write_back(&mut self, words: &[&'a str], unit: usize, why: Why<'a>) -> bool {
        let mut news = false;
        let mut open: Vec<&str> = words.to_vec();
        let mut seen = HashSet::new();
        while let Some(word) = open.pop() {
            if !seen.insert(word) {
                continue;
            }
            if self.variables.contains(word) {
                news |= self.stain(word, unit, why);
            }
            // A macro may stand for the name of a variable.
            for callee in self.outline.called.get(word).into_iter().flatten() {
                open.extend(&self.outline.units[*callee].words);
            }
        }
        news
    }

    /// Does anything that a unit calls use a name of the unit's own?
    fn is_seen(&self, unit: usize, name: &str) -> bool {
        self.calls[unit].iter().any(|callee| {
            self.outline.units[*callee].words.contains(name) && !self.outline.owns(*callee, name)
        })
    }

    /// What units call sees their parameters and locals.
    fn callees_see(&mut self) -> bool {
        let mut found = Vec::new();
        for ((unit, name), why) in &self.own {
            if !self.seen.contains_key(name) && self.is_seen(*unit, name) {
                found.push((*name, *why));
            }
        }
        let mut news = false;
        for (name, why) in found {
            news |= self.seen.insert(name, why).is_none();
        }
        news
    }
}

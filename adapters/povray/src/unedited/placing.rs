//! Which parts of the text are executed where: those that are used at all, those
//! that stand in the scene itself, and those that stand within something else.
//! The same macro may make an object of the scene here and a part of one there.

use std::collections::HashSet;
use std::ops::Range;

use super::outline::{Item, Outline, Raw};
use super::source::Sources;

/// Where the units of a scene are executed.
#[derive(Debug)]
pub struct Placing<'o, 'a> {
    /// Is the unit used at all?
    pub used: Vec<bool>,
    /// Is it executed in the scene itself?
    pub scene: Vec<bool>,
    /// Is it executed within something else?
    pub nested: Vec<bool>,
    /// The statements of the scene.
    pub live: Vec<&'o Raw<'a>>,
    /// Names of macros that are both, and of what calls them.
    reaching_mixed: HashSet<&'a str>,
}

impl<'o, 'a> Placing<'o, 'a> {
    /// Finds out.
    pub fn of(outline: &'o Outline<'a>, sources: &Sources) -> Self {
        let count = outline.units.len();
        let mut placing = Self {
            used: vec![false; count],
            scene: vec![false; count],
            nested: vec![false; count],
            live: Vec::new(),
            reaching_mixed: HashSet::new(),
        };
        let header = |unit: &usize| {
            Some(outline.units[*unit].file) == sources.header && !outline.units[*unit].is_macro
        };
        let calls = reach(outline);
        let roots: Vec<usize> = (0..count)
            .filter(|unit| *unit == 0 || header(unit))
            .collect();
        for root in roots {
            placing.scene[root] = true;
            placing.used[root] = true;
            for unit in &calls[root] {
                placing.used[*unit] = true;
            }
        }
        while placing.spread(outline) {}

        for (index, unit) in outline.units.iter().enumerate() {
            if placing.scene[index] && placing.used[index] {
                placing
                    .live
                    .extend(unit.items.iter().filter_map(|item| match item {
                        Item::Statement(raw) => Some(raw),
                        _ => None,
                    }));
            }
        }
        let mixed: HashSet<usize> = (0..count).filter(|unit| placing.is_mixed(*unit)).collect();
        for (name, units) in &outline.called {
            let reaches = |unit: &usize| mixed.contains(unit) || !mixed.is_disjoint(&calls[*unit]);
            if units.iter().any(reaches) {
                placing.reaching_mixed.insert(name);
            }
        }
        placing
    }

    fn spread(&mut self, outline: &Outline<'a>) -> bool {
        let mut news = false;
        let mut mark = |list: &mut Vec<bool>, name: &str| {
            for unit in outline.called.get(name).into_iter().flatten() {
                news |= !std::mem::replace(&mut list[*unit], true);
            }
        };
        for (index, unit) in outline.units.iter().enumerate() {
            if !self.used[index] {
                continue;
            }
            for name in &unit.nested {
                mark(&mut self.nested, name);
            }
            for item in &unit.items {
                let (Item::Call(name) | Item::Include(name)) = item else {
                    continue;
                };
                if self.scene[index] {
                    mark(&mut self.scene, name);
                }
                if self.nested[index] || !self.scene[index] {
                    mark(&mut self.nested, name);
                }
            }
        }
        news
    }

    /// Is the unit executed in the scene and within something else?
    pub fn is_mixed(&self, unit: usize) -> bool {
        self.scene[unit] && self.nested[unit]
    }

    /// Do these words lead to a macro that is executed in both places?
    pub fn reach_mixed<'w>(&self, words: impl IntoIterator<Item = &'w &'a str>) -> bool
    where
        'a: 'w,
    {
        words
            .into_iter()
            .any(|word| self.reaching_mixed.contains(word))
    }

    /// Values that stand in the scene and within which such macros are executed:
    /// the file, and the bytes.
    pub fn values_reaching_mixed(&self, outline: &Outline<'a>) -> Vec<(usize, Range<usize>)> {
        let mut found = Vec::new();
        for (index, unit) in outline.units.iter().enumerate() {
            if !self.used[index] || !self.scene[index] {
                continue;
            }
            let tokens = &outline.tokens[unit.file].list;
            for value in &unit.values {
                if self.reach_mixed(&outline.words_in(unit.file, value.clone())) {
                    let end = tokens[value.end - 1].end;
                    found.push((unit.file, tokens[value.start].start..end));
                }
            }
        }
        found
    }
}

/// For each unit those that it may call, directly or not.
pub fn reach(outline: &Outline<'_>) -> Vec<HashSet<usize>> {
    let direct = |unit: usize| {
        let words = outline.units[unit].words.iter();
        words
            .filter_map(|word| outline.called.get(word))
            .flatten()
            .copied()
    };
    let all = (0..outline.units.len()).map(|unit| {
        let mut open: Vec<usize> = direct(unit).collect();
        let mut seen = HashSet::new();
        while let Some(next) = open.pop() {
            if seen.insert(next) {
                open.extend(direct(next));
            }
        }
        seen
    });
    all.collect()
}

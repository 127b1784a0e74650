//! The parts of unions, each of which says where it is: a union's own box may be
//! mostly empty (a carousel, a car and its aerial).
//!
//! A union's parts stand where they stood, and are executed once: each becomes the
//! value of a name, which is an object of the union. Behind the union the names are
//! moved as the union is. That reads the union's transformations again: only what
//! may be read twice is told apart. Unions within unions are too, and those that are
//! placed by a name that is given a value in one place only.
//!
//! A macro could execute the same text again before all parts of a union have their
//! names: where one that it calls may, a union stays whole.

use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::ops::Range;

use super::instrument::is_plain;
use super::lex::Kind;
use super::outline::{Outline, Raw};
use super::placing::reach;
use super::refuse::Scene;
use super::solid::{RESHAPING, is_round};
use super::source::Edit;
use super::values::is_object;

/// A statement has so many parts at most: each costs time in every pass.
const MOST_PARTS: usize = 64;

/// And the statements of a frame, so many: beyond, they are one thing each.
pub(super) const MOST_IN_A_FRAME: usize = 4096;

/// Modifiers that move what they stand behind.
const MOVING: &[&str] = &["translate", "rotate", "scale", "matrix", "transform"];

/// Modifiers that do not, or that only take something away. (With `inverse`, media fill
/// what is outside.)
const OTHERS: &[&str] = &[
    "texture",
    "pigment",
    "normal",
    "finish",
    "material",
    "interior",
    "interior_texture",
    "uv_mapping",
    "photons",
    "hollow",
    "no_shadow",
    "no_image",
    "no_reflection",
    "no_radiosity",
    "double_illuminate",
    "split_union",
    "clipped_by",
    "bounded_by",
];

/// A part, by the name that it was given.
#[derive(Clone, Debug)]
pub(super) struct Part {
    /// Its name.
    pub name: String,
    /// Is it a sphere?
    pub round: bool,
}

/// What makes a union tell its parts.
#[derive(Default)]
struct Told {
    parts: Vec<Part>,
    /// Edits, each with whether it ends something.
    edits: Vec<(bool, Edit)>,
    /// What has to stand behind it.
    behind: String,
}

/// Tells unions apart.
pub(super) struct Parts<'p, 's, 'a> {
    scene: &'p Scene<'s, 'a>,
    /// Where a name that has one value gets it: the unit, the tokens of the value.
    values: HashMap<&'a str, (usize, Range<usize>)>,
    /// For each unit those that it may call.
    reach: Vec<HashSet<usize>>,
    /// Unions that have a name and were told apart; `None`: they cannot be.
    named: HashMap<&'a str, Option<Vec<Part>>>,
    /// Edits, each with whether it ends something.
    pub(super) edits: Vec<(bool, Edit)>,
    count: usize,
}

impl<'p, 's, 'a> Parts<'p, 's, 'a> {
    pub(super) fn of(scene: &'p Scene<'s, 'a>) -> Self {
        let reach = reach(scene.outline);
        Self {
            scene,
            values: single_values(scene.outline, &reach),
            reach,
            named: HashMap::new(),
            edits: Vec::new(),
            count: 0,
        }
    }

    /// The parts of a statement, and what has to stand behind it before they are
    /// where they are; `None` where it is one thing.
    pub(super) fn parts(&mut self, raw: &Raw<'a>) -> Option<(Vec<Part>, String)> {
        let told = self.told(raw.unit, raw.tokens.clone())?;
        self.edits.extend(told.edits);
        Some((told.parts, told.behind))
    }

    /// What makes the object of these tokens tell its parts.
    fn told(&mut self, unit: usize, range: Range<usize>) -> Option<Told> {
        let (scene, outline) = (self.scene, self.scene.outline);
        let file = outline.units[unit].file;
        let tokens = &outline.tokens[file];
        if self.calls(unit, &range) {
            return None;
        }
        let keyword = tokens.list.get(range.start)?;
        let close = range.end.checked_sub(1)?;
        let braced = tokens.partner.get(range.start + 1) == Some(&close) && range.len() > 3;
        if !braced || !tokens.list[range.start + 1].is_mark("{") {
            return None;
        }
        let mut told = Told::default();
        let mut at = range.start + 2;
        match keyword.text {
            "union" | "merge" => {
                while at < close && is_object(tokens.list[at].text) {
                    let end = tokens.partner[at + 1];
                    if !tokens.list[at + 1].is_mark("{") {
                        return None;
                    }
                    self.component(unit, at..end + 1, &mut told);
                    at = end + 1;
                }
            }
            "object" => {
                let word = tokens.list[at];
                let parts = self.of_name(word.text)?;
                let copies = parts.iter().map(|part| {
                    let copy = self.name();
                    let _ = write!(told.behind, " #declare {copy}=object{{{}}}", part.name);
                    Part {
                        name: copy,
                        round: part.round,
                    }
                });
                told.parts = copies.collect();
                at += 1;
            }
            _ => return None,
        }
        if told.parts.is_empty() || told.parts.len() > MOST_PARTS {
            return None;
        }
        let moves = transformations(scene, file, at..close)?;
        let reshapes = moves.iter().any(|word| RESHAPING.contains(&word.0));
        if !moves.is_empty() {
            let moves: Vec<String> = moves.into_iter().map(|(_, text)| text).collect();
            let moves = moves.join("\n");
            for part in &mut told.parts {
                let name = &part.name;
                let _ = write!(told.behind, " #declare {name}=object{{{name} {moves}}}");
                part.round &= !reshapes;
            }
        }
        Some(told)
    }

    /// May the unit be executed again by what these of its tokens call?
    fn calls(&self, unit: usize, range: &Range<usize>) -> bool {
        let outline = self.scene.outline;
        let words = outline.words_in(outline.units[unit].file, range.clone());
        let called = words.iter().filter_map(|word| outline.called.get(word));
        let mut called = called.flatten();
        called.any(|other| *other == unit || self.reach[*other].contains(&unit))
    }

    /// A union's component: its own parts, or it is one.
    fn component(&mut self, unit: usize, range: Range<usize>, told: &mut Told) {
        let file = self.scene.outline.units[unit].file;
        let tokens = &self.scene.outline.tokens[file].list;
        let (start, end) = (tokens[range.start].start, tokens[range.end - 1].end);
        let edit = |ends, at, text| {
            let range = at..at;
            (ends, Edit { file, range, text })
        };
        let inner = self.told(unit, range.clone());
        let fits = |inner: &Told| told.parts.len() + inner.parts.len() <= MOST_PARTS;
        if let Some(inner) = inner.filter(fits) {
            told.parts.extend(inner.parts);
            told.edits.extend(inner.edits);
            told.edits.push(edit(true, end, inner.behind + " "));
            return;
        }
        let name = self.name();
        told.edits
            .push(edit(false, start, format!(" #declare {name}=")));
        told.edits
            .push(edit(true, end, format!(" object{{{name}}} ")));
        let round = is_round(self.scene.outline, file, &range);
        told.parts.push(Part { name, round });
    }

    /// The parts of what has this name.
    fn of_name(&mut self, name: &'a str) -> Option<Vec<Part>> {
        if let Some(known) = self.named.get(name) {
            return known.clone();
        }
        // It may be made of itself.
        self.named.insert(name, None);
        let (unit, range) = self.values.get(name)?.clone();
        let told = self.told(unit, range.clone())?;
        let file = self.scene.outline.units[unit].file;
        let tokens = &self.scene.outline.tokens[file].list;
        let last = &tokens[range.end - 1];
        let next = tokens.get(range.end).filter(|next| next.is_mark(";"));
        let end = next.map_or(last.end, |next| next.end);
        let edit = Edit {
            file,
            range: end..end,
            text: told.behind + " ",
        };
        self.edits.extend(told.edits);
        self.edits.push((true, edit));
        self.named.insert(name, Some(told.parts.clone()));
        Some(told.parts)
    }

    fn name(&mut self) -> String {
        self.count += 1;
        format!("{}u{}", self.scene.sources.prefix, self.count)
    }
}

/// Names that stand for one object ([`Outline::single`]). Not those that are made in
/// macros, nor in files that include themselves: `#local` makes a name there for each
/// time that they are executed, and the parts have one name for all.
fn single_values<'a>(
    outline: &Outline<'a>,
    reach: &[HashSet<usize>],
) -> HashMap<&'a str, (usize, Range<usize>)> {
    let mut found = HashMap::new();
    for assignment in outline.single() {
        let unit = &outline.units[assignment.unit];
        let tokens = &outline.tokens[unit.file];
        let (name, start) = (assignment.name, assignment.token + 2);
        let once = !unit.is_macro && !reach[assignment.unit].contains(&assignment.unit);
        let braced = tokens.list.get(start + 1).is_some_and(|t| t.is_mark("{"));
        if once && braced && is_object(tokens.list[start].text) {
            let end = tokens.partner[start + 1] + 1;
            found.insert(name, (assignment.unit, start..end));
        }
    }
    found
}

/// The transformations among a union's modifiers, in order, each with its word; `None`
/// where there is anything that may not be read twice. A modifier's text goes on to the
/// next one that is known: what is not known is read again with it.
fn transformations<'a>(
    scene: &Scene<'_, 'a>,
    file: usize,
    range: Range<usize>,
) -> Option<Vec<(&'a str, String)>> {
    let tokens = &scene.outline.tokens[file];
    if !range.clone().all(|at| is_plain(scene, &tokens.list[at])) {
        return None;
    }
    let mut modifiers: Vec<(&'a str, Range<usize>)> = Vec::new();
    let mut at = range.start;
    while at < range.end {
        let token = tokens.list[at];
        let begins = token.kind == Kind::Word
            && (MOVING.contains(&token.text) || OTHERS.contains(&token.text));
        let end = tokens.partner[at].max(at) + 1;
        if begins {
            modifiers.push((token.text, at..end));
        } else {
            modifiers.last_mut()?.1.end = end;
        }
        at = end;
    }
    let text = &scene.sources.files[file].text;
    let moving = modifiers.into_iter().filter(|m| MOVING.contains(&m.0));
    let texts = moving.map(|(word, range)| {
        let bytes = tokens.list[range.start].start..tokens.list[range.end - 1].end;
        Some((word, String::from_utf8(text.get(bytes)?.to_vec()).ok()?))
    });
    texts.collect()
}

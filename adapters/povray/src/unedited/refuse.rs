//! Why frames are rendered whole, and why geometry does not say what is touched.
//! What is not certain is refused: that costs time, never a picture.

use super::analysis::{Kind, Refusal, Statement};
use super::lex::Kind as TokenKind;
use super::outline::{Item, Outline, Raw};
use super::placing::Placing;
use super::source::Sources;
use super::taint::Taint;

/// Words that make a scene depend on more than its text and the clock.
const UNKNOWABLE: &[(&str, &str)] = &[
    ("now", "it asks for the time"),
    ("datetime", "it asks for the time"),
    ("input_file_name", "it asks for its own name"),
];

/// Words that make pictures that POV-Ray does not make twice alike, or that are
/// made of more than rays.
const UNSTEADY: &[(&str, &str)] = &[
    ("radiosity", "radiosity"),
    ("photons", "photons"),
    ("subsurface", "light below surfaces (subsurface)"),
    ("crand", "grain (crand)"),
];

/// Words that ask where things are.
const ASKING: &[&str] = &["min_extent", "max_extent", "trace", "inside"];

/// A refusal at a place in a file.
pub fn at(sources: &Sources, file: usize, byte: usize, reason: impl Into<String>) -> Refusal {
    Refusal {
        file: sources
            .files
            .get(file)
            .map_or_else(String::new, |file| file.name.clone()),
        line: sources.line(file, byte),
        reason: reason.into(),
    }
}

/// All that is known of a scene.
pub struct Scene<'s, 'a> {
    /// Its outline.
    pub outline: &'s Outline<'a>,
    /// Its text.
    pub sources: &'a Sources,
    /// Where what is executed.
    pub placing: &'s Placing<'s, 'a>,
    /// What depends on the clock.
    pub clock: &'s Taint<'s, 'a>,
    /// Its objects, lights and cameras in the text.
    pub raws: &'s [&'s Raw<'a>],
    /// The same for people.
    pub statements: &'s [Statement],
}

impl<'a> Scene<'_, 'a> {
    /// What is made with any of these words.
    pub fn carrying(&self, words: &[&'static str]) -> Taint<'_, 'a> {
        Taint::of(self.outline, self.sources, &self.placing.used, words, false)
    }

    /// Is the word used anywhere?
    pub fn uses(&self, word: &str) -> bool {
        let mut units = self.outline.units.iter().zip(&self.placing.used);
        units.any(|(unit, used)| *used && unit.words.contains(word))
    }

    /// Does it ask where things are?
    pub fn asks(&self) -> bool {
        ASKING.iter().any(|word| self.uses(word))
    }

    /// Objects, lights and cameras with their text.
    pub fn parts(&self) -> impl Iterator<Item = (&Statement, &Raw<'a>)> {
        self.statements.iter().zip(self.raws.iter().copied())
    }

    fn here(&self, raw: &Raw<'a>, reason: impl Into<String>) -> Refusal {
        let file = self.outline.units[raw.unit].file;
        at(self.sources, file, self.outline.bytes(raw).start, reason)
    }

    fn token(&self, unit: usize, token: usize, reason: impl Into<String>) -> Refusal {
        let file = self.outline.units[unit].file;
        let found = self.outline.tokens[file].list.get(token);
        at(self.sources, file, found.map_or(0, |t| t.start), reason)
    }

    /// Why all frames are rendered whole.
    pub fn whole(&self) -> Vec<Refusal> {
        let mut found = self.structure();
        found.extend(self.words());
        found.extend(self.what_moves());
        found.extend(self.unsteady());
        found
    }

    /// Does nothing stand against it but that what moves is the camera, a light…?
    /// Then two frames of which the clock says the same are the same.
    pub fn is_certain(&self) -> bool {
        [self.structure(), self.words(), self.unsteady()]
            .iter()
            .all(Vec::is_empty)
    }

    /// The first place where a word is used.
    fn first(&self, word: &str) -> Option<(usize, usize)> {
        let mut units = self
            .outline
            .units
            .iter()
            .enumerate()
            .zip(&self.placing.used);
        units.find_map(|((index, unit), used)| {
            let tokens = &self.outline.tokens[unit.file].list;
            let is = |at: &usize| tokens[*at].kind == TokenKind::Word && tokens[*at].text == word;
            let at = (unit.start..tokens.len()).find(is);
            at.filter(|_| *used && unit.words.contains(word))
                .map(|token| (index, token))
        })
    }

    /// What is not certain in the structure of the text.
    fn structure(&self) -> Vec<Refusal> {
        let outline = self.outline;
        let mut found = Vec::new();
        for (index, unit) in outline.units.iter().enumerate() {
            if !self.placing.used[index] {
                continue;
            }
            for odd in &unit.odd {
                found.push(self.token(index, odd.token, odd.reason));
            }
            if !self.placing.scene[index] {
                continue;
            }
            for item in &unit.items {
                if let Item::Other(token) = item {
                    found.push(self.token(index, *token, "decor does not understand this"));
                }
            }
            if !unit.is_macro && self.placing.is_mixed(index) {
                let reason = "this file makes objects in one place and parts of them in another";
                found.push(self.token(index, 0, reason));
            }
            if self.placing.reach_mixed(&unit.loose) {
                let reason = "a macro that makes objects elsewhere is called for a value here";
                found.push(self.token(index, unit.start, reason));
            }
        }
        let settings = outline.settings.iter();
        let settings = settings.filter(|raw| self.placing.used[raw.unit]);
        for raw in self.placing.live.iter().copied().chain(settings) {
            let counted = matches!(raw.keyword, "light_source" | "camera")
                || !super::values::is_global(raw.keyword) && raw.keyword != "default";
            if !counted && self.placing.reach_mixed(&raw.words) {
                let reason = "a macro that makes objects elsewhere is called here";
                found.push(self.here(raw, reason));
            }
        }
        for call in &outline.calls {
            let unit = &outline.units[call.unit];
            let token = outline.tokens[unit.file].list[call.token];
            if !self.placing.used[call.unit] || token.kind != TokenKind::Directive {
                continue;
            }
            match outline.called.get(call.callee).map(Vec::as_slice) {
                None => {
                    let reason = format!("`{}` was not found", call.callee);
                    found.push(self.token(call.unit, call.token, reason));
                }
                Some([0, ..]) => {
                    found.push(self.token(call.unit, call.token, "the scene includes itself"));
                }
                Some(_) if call.callee.contains(['\\', '"']) => {
                    found.push(self.token(call.unit, call.token, "this name is not plain"));
                }
                Some(_) => {}
            }
        }
        found
    }

    /// Words and directives by which frames depend on more than the text.
    fn words(&self) -> Vec<Refusal> {
        let mut found = Vec::new();
        for (word, reason) in UNKNOWABLE {
            if let Some((unit, token)) = self.first(word) {
                found.push(self.token(unit, token, format!("{reason} (`{word}`)")));
            }
        }
        for (unit, token) in &self.outline.file_access {
            if self.placing.used[*unit] {
                found.push(self.token(*unit, *token, "it reads or writes a file"));
            }
        }
        found
    }

    /// What may not move.
    fn what_moves(&self) -> Vec<Refusal> {
        let mut found = Vec::new();
        for raw in &self.outline.settings {
            if !self.placing.used[raw.unit] {
                continue;
            }
            if let Some(why) = self.clock.why(raw) {
                found.push(self.here(raw, format!("#{} changes: {why}", raw.keyword)));
            }
        }
        let lit = self.carrying(&["light_source"]);
        let inverse = self.carrying(&["inverse"]);
        let bounded = self.carrying(&["bounded_by"]);
        // Its surface has an end, but all around is inside of it.
        let filled = ["fog", "rainbow", "media"]
            .iter()
            .any(|word| self.uses(word));
        let interior = self.carrying(&["interior", "material", "refraction", "ior"]);
        for raw in &self.placing.live {
            let Some(why) = self.clock.why(raw) else {
                continue;
            };
            let reason = match raw.keyword {
                "camera" => format!("the camera moves: {why}"),
                "light_source" => format!("a light changes: {why}"),
                "plane" => format!("an object without end moves: {why}"),
                word if super::values::is_global(word) => format!("`{word}` changes: {why}"),
                _ if lit.concerns(raw) || raw.keyword == "light_group" => {
                    format!("a light is a part of what moves: {why}")
                }
                _ if inverse.concerns(raw) && (filled || interior.concerns(raw)) => {
                    format!("what moves may be everything but an object (inverse): {why}")
                }
                // Whether POV-Ray keeps to bounds that are too small depends.
                _ if self.asks() && bounded.concerns(raw) => {
                    format!("what moves has stated bounds, and the scene asks for bounds: {why}")
                }
                _ => continue,
            };
            found.push(self.here(raw, reason));
        }
        found
    }

    /// What POV-Ray does not make twice alike.
    fn unsteady(&self) -> Vec<Refusal> {
        let mut found = Vec::new();
        for (word, what) in UNSTEADY {
            if !self.uses(word) {
                continue;
            }
            let carrying = self.carrying(&[word]);
            // Objects may say what they do with photons; there are none without
            // settings, nor is there radiosity.
            let settings_only = matches!(*word, "photons" | "radiosity");
            let settings = self.outline.settings.iter();
            let settings = settings.filter(|raw| self.placing.used[raw.unit]);
            for raw in self.placing.live.iter().copied().chain(settings) {
                let counts = !settings_only || raw.keyword == "global_settings";
                if counts && carrying.concerns(raw) {
                    found.push(self.here(raw, format!("decor does not divide {what}")));
                }
            }
        }
        if self.uses("jitter") {
            let jitter = self.carrying(&["jitter"]);
            let area = self.carrying(&["area_light"]);
            let lit = self.carrying(&["light_source"]);
            for raw in &self.placing.live {
                if lit.concerns(raw) && jitter.concerns(raw) && area.concerns(raw) {
                    found.push(self.here(raw, "a light of some size jitters"));
                }
            }
        }
        found
    }

    /// Why geometry does not say what is touched.
    pub fn proxies_only(&self) -> Vec<Refusal> {
        let mut found = Vec::new();
        let shaped = self.carrying(super::instrument::SHAPED);
        let lit = self.carrying(&["light_source", "light_group"]);
        let bounded = self.carrying(&["bounded_by"]);
        if let Some((unit, token)) = self.first("media") {
            found.push(self.token(unit, token, "shadows can be seen in media"));
        }
        for (statement, raw) in self.parts() {
            let reason = match &statement.kind {
                Kind::Light if shaped.concerns(raw) => "a light is no point",
                Kind::Light if self.placing.is_mixed(raw.unit) => {
                    "a light may be a part of an object"
                }
                Kind::Object(_) if lit.concerns(raw) => "a light is a part of an object",
                Kind::Object(_) if self.asks() && bounded.concerns(raw) => {
                    "an object has stated bounds, and the scene asks for bounds"
                }
                _ => continue,
            };
            found.push(self.here(raw, reason));
        }
        found
    }
}

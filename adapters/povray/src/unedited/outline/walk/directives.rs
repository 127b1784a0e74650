//! Directives: conditions and loops, macros, values, includes, messages.

use super::super::super::lex::Kind;
use super::super::super::values::{Shape, value_end};
use super::super::{Assignment, Call, Control, Item, Outline};
use super::{NO_PARTNER, Open, Walk};

impl<'a> Walk<'_, 'a> {
    pub(super) fn directive(&mut self, outline: &mut Outline<'a>, name: &'a str) {
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
    pub(super) fn default(&mut self, outline: &mut Outline<'a>, here: usize) {
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

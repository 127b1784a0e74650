//! A fragment's objects one by one: its text with every object that it places
//! replaced by a question about that object's box.
//!
//! Only text whose every word at the top is understood is rewritten: directives,
//! and objects with their braces. What an include places stays, and is asked
//! about as a rest; a macro's call, or a `rotate` behind all objects, leaves the
//! fragment in one piece. A union's objects are asked about one by one, each with
//! the modifiers behind them all.

use crate::tokens::{Kind, Token, tokens};

/// The words that begin an object. `plane` and its kin have no box: their
/// fragment has none either.
const OBJECTS: [&str; 35] = [
    "bicubic_patch",
    "blob",
    "box",
    "cone",
    "cubic",
    "cylinder",
    "difference",
    "disc",
    "height_field",
    "intersection",
    "isosurface",
    "julia_fractal",
    "lathe",
    "merge",
    "mesh",
    "mesh2",
    "object",
    "ovus",
    "parametric",
    "plane",
    "poly",
    "polygon",
    "polynomial",
    "prism",
    "quadric",
    "quartic",
    "smooth_triangle",
    "sor",
    "sphere",
    "sphere_sweep",
    "superellipsoid",
    "text",
    "torus",
    "triangle",
    "union",
];

/// Directives with a condition in parentheses that begin a block.
const BLOCKS: [&str; 7] = [
    "#if", "#ifdef", "#ifndef", "#while", "#for", "#switch", "#macro",
];

/// Directives with a condition in parentheses within a block.
const BRANCHES: [&str; 3] = ["#elseif", "#case", "#range"];

/// The text with `before` and `after` around each object that it places; `None`
/// where it is not understood.
pub fn rewritten(text: &[u8], before: &str, after: &str) -> Option<Vec<u8>> {
    let found = tokens(text);
    let mut walk = Walk {
        tokens: &found,
        at: 0,
    };
    let mut asked = Asked {
        text,
        out: Vec::with_capacity(text.len() + 1024),
        copied: 0,
        around: (before, after),
        modifiers: Vec::new(),
    };
    walk.objects(found.len(), &mut asked)?;
    asked.copy_to(text.len());
    Some(asked.out)
}

/// The text as it becomes.
struct Asked<'x> {
    text: &'x [u8],
    out: Vec<u8>,
    /// So much of the text is done.
    copied: usize,
    /// What stands around each object.
    around: (&'x str, &'x str),
    /// The modifiers of the unions around, from the outermost.
    modifiers: Vec<&'x [u8]>,
}

impl Asked<'_> {
    fn copy_to(&mut self, end: usize) {
        self.out.extend_from_slice(&self.text[self.copied..end]);
        self.copied = end;
    }

    /// Asks about the object in `text[start..end]`.
    fn ask(&mut self, start: usize, end: usize) {
        self.copy_to(start);
        self.out.extend_from_slice(self.around.0.as_bytes());
        for _ in &self.modifiers {
            self.out.extend_from_slice(b"union { ");
        }
        self.copy_to(end);
        for modifiers in self.modifiers.iter().rev() {
            self.out.push(b' ');
            self.out.extend_from_slice(modifiers);
            self.out.extend_from_slice(b" }");
        }
        self.out.extend_from_slice(self.around.1.as_bytes());
    }
}

/// A union that is told apart: numbers of tokens.
struct Union {
    /// The first of its objects.
    first: usize,
    /// The first of its modifiers, or its closing brace.
    modifiers: usize,
    /// Its closing brace.
    close: usize,
}

struct Walk<'t, 'a> {
    tokens: &'t [Token<'a>],
    at: usize,
}

fn is_object(token: &Token<'_>) -> bool {
    token.kind == Kind::Word && OBJECTS.iter().any(|object| token.is(object))
}

impl<'t, 'a> Walk<'t, 'a> {
    fn peek(&self) -> Option<&'t Token<'a>> {
        self.tokens.get(self.at)
    }

    fn take(&mut self) -> Option<&'t Token<'a>> {
        let token = self.peek()?;
        self.at += 1;
        Some(token)
    }

    /// Asks about the objects up to token `end`; `None` where something is not
    /// understood.
    fn objects(&mut self, end: usize, asked: &mut Asked<'a>) -> Option<()> {
        while self.at < end {
            let token = self.take()?;
            match token.kind {
                Kind::Directive => self.directive(token)?,
                Kind::Word if is_object(token) => match self.union(token) {
                    Some(union) => self.told_apart(token, &union, asked)?,
                    None => {
                        let last = self.group("{", "}")?;
                        asked.ask(token.start, last.start + last.bytes.len());
                    }
                },
                _ => return None,
            }
        }
        Some(())
    }

    /// Asks about the objects of a union that begins with `token`.
    fn told_apart(
        &mut self,
        token: &Token<'a>,
        union: &Union,
        asked: &mut Asked<'a>,
    ) -> Option<()> {
        let start = |token: usize| self.tokens[token].start;
        let (modifiers, close) = (start(union.modifiers), start(union.close));
        asked.copy_to(token.start);
        asked.copied = start(union.first);
        asked.modifiers.push(&asked.text[modifiers..close]);
        self.at = union.first;
        self.objects(union.modifiers, asked)?;
        asked.modifiers.pop();
        asked.copy_to(modifiers);
        asked.copied = close + 1;
        self.at = union.close + 1;
        Some(())
    }

    /// The parts of a union, where each of its objects can be asked about by
    /// itself: where its modifiers can be written again and mean the same. That is
    /// not so of what draws random numbers or calls macros: of parentheses.
    fn union(&self, token: &Token<'a>) -> Option<Union> {
        if !(token.is("union") || token.is("merge")) {
            return None;
        }
        let mut walk = Walk {
            tokens: self.tokens,
            at: self.at,
        };
        walk.take()?.is("{").then_some(())?;
        let first = walk.at;
        let mut modifiers = loop {
            let token = walk.peek()?;
            if token.kind == Kind::Directive {
                // What an include places would lose the modifiers.
                (!token.is("#include")).then_some(())?;
                walk.at += 1;
                walk.directive(token)?;
            } else if is_object(token) {
                walk.at += 1;
                walk.group("{", "}")?;
            } else {
                break walk.at;
            }
        };
        let start = modifiers;
        let mut depth = 0;
        loop {
            let token = self.tokens.get(modifiers)?;
            if token.is("}") && depth == 0 {
                return Some(Union {
                    first,
                    modifiers: start,
                    close: modifiers,
                });
            }
            let is_odd =
                token.is("(") || token.kind == Kind::Directive || depth == 0 && is_object(token);
            (!is_odd).then_some(())?;
            depth += i32::from(token.is("{")) - i32::from(token.is("}"));
            modifiers += 1;
        }
    }

    fn directive(&mut self, token: &Token<'a>) -> Option<()> {
        if token.is("#macro") {
            return self.macro_body();
        }
        if BLOCKS.iter().chain(&BRANCHES).any(|d| token.is(d)) {
            return self.group("(", ")").map(|_| ());
        }
        if ["#declare", "#local"].iter().any(|d| token.is(d)) {
            return self.declaration();
        }
        match token.bytes {
            b"#else" | b"#end" | b"#break" => Some(()),
            b"#version" => self.skip_to_semicolon(),
            b"#undef" => (self.take()?.kind == Kind::Word).then_some(()),
            b"#include" => {
                let name = self.take()?.string()?;
                // The fragment's own: what it places, and turns, is not known.
                (!name.starts_with(b"decor_")).then_some(())
            }
            _ => None,
        }
    }

    /// Behind the opening token that comes next, up to the closing one.
    fn group(&mut self, open: &str, close: &str) -> Option<&'t Token<'a>> {
        if !self.take()?.is(open) {
            return None;
        }
        let mut depth = 1;
        // A branch that opens what another closes cannot be counted.
        let mut blocks: Vec<i32> = Vec::new();
        loop {
            let token = self.take()?;
            if token.is(open) {
                depth += 1;
            } else if token.is(close) {
                depth -= 1;
                if depth == 0 {
                    return blocks.is_empty().then_some(token);
                }
            } else if token.kind == Kind::Directive {
                if BLOCKS.iter().any(|d| token.is(d)) {
                    blocks.push(depth);
                } else if token.is("#end") {
                    (blocks.pop()? == depth).then_some(())?;
                } else if token.is("#else") || BRANCHES.iter().any(|d| token.is(d)) {
                    (*blocks.last()? == depth).then_some(())?;
                }
            }
        }
    }

    /// `Name = texture { … }`, or `Name = …;`.
    fn declaration(&mut self) -> Option<()> {
        let is_named = self.take()?.kind == Kind::Word;
        if !(is_named && self.take()?.is("=")) {
            return None;
        }
        let is_block = self.peek()?.kind == Kind::Word
            && self.tokens.get(self.at + 1).is_some_and(|t| t.is("{"));
        if !is_block {
            return self.skip_to_semicolon();
        }
        self.at += 1;
        self.group("{", "}")?;
        if self.peek().is_some_and(|t| t.is(";")) {
            self.at += 1;
        }
        Some(())
    }

    fn skip_to_semicolon(&mut self) -> Option<()> {
        loop {
            let token = self.take()?;
            if token.is(";") {
                return Some(());
            }
            if token.kind == Kind::Directive || token.is("{") {
                return None;
            }
        }
    }

    /// A macro is read where it is called.
    fn macro_body(&mut self) -> Option<()> {
        let mut depth = 1;
        while depth > 0 {
            let token = self.take()?;
            if token.kind == Kind::Directive {
                if BLOCKS.iter().any(|d| token.is(d)) {
                    depth += 1;
                } else if token.is("#end") {
                    depth -= 1;
                }
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(text: &str) -> Option<String> {
        let out = rewritten(text.as_bytes(), "[", "]")?;
        Some(String::from_utf8(out).unwrap())
    }

    #[test]
    fn objects_at_the_top_are_found_wherever_they_stand() {
        for (text, expected) in [
            ("sphere { 0, 1 }", "[sphere { 0, 1 }]"),
            (
                "#local T = texture { pigment { rgb 1 } } box{0,1 texture{T}} // box {}",
                "#local T = texture { pigment { rgb 1 } } [box{0,1 texture{T}}] // box {}",
            ),
            (
                "#declare K = 0; #while (K < (3)) torus { 1, K } #declare K = K+1; #end",
                "#declare K = 0; #while (K < (3)) [torus { 1, K }] #declare K = K+1; #end",
            ),
            (
                "#include \"colors.inc\" union { sphere {0,1} #if(a) box{0,1} #end } mesh { }",
                "#include \"colors.inc\" [union { sphere {0,1}  }] #if(a) [union { box{0,1}  }] #end  [mesh { }]",
            ),
            (
                "#macro M() #if(1) box{0,1} #end #end #local U = union { M() } object { U }",
                "#macro M() #if(1) box{0,1} #end #end #local U = union { M() } [object { U }]",
            ),
            (
                "union { box { 0, 1 } merge { torus { 1, 2 } scale 3 } texture { T } rotate 4*y }",
                "[union { box { 0, 1 } texture { T } rotate 4*y  }] \
                 [union { union { torus { 1, 2 } scale 3  } texture { T } rotate 4*y  }]  ",
            ),
            // Modifiers that would not be the same twice, and what is not an object.
            (
                "union { box { 0, 1 } rotate rand(S) }",
                "[union { box { 0, 1 } rotate rand(S) }]",
            ),
            ("union { box { 0, 1 } M() }", "[union { box { 0, 1 } M() }]"),
            (
                "union { #include \"stones.inc\" box { 0, 1 } scale 2 }",
                "[union { #include \"stones.inc\" box { 0, 1 } scale 2 }]",
            ),
            (
                "difference { union { box { 0, 1 } box { 1, 2 } } torus { 1, 2 } }",
                "[difference { union { box { 0, 1 } box { 1, 2 } } torus { 1, 2 } }]",
            ),
            (
                "#version 3.5; cone {x,1,y,2}",
                "#version 3.5; [cone {x,1,y,2}]",
            ),
            ("", ""),
        ] {
            assert_eq!(asked(text).as_deref(), Some(expected));
        }
    }

    #[test]
    fn what_is_not_understood_stays_in_one_piece() {
        for text in [
            "sphere { 0, 1 } rotate 30*y",
            "M() sphere { 0, 1 }",
            "#declare C = rgb 1 sphere { 0, 1 } #declare D = 2;",
            "#declare C = rgb 1 #declare D = 2;",
            "union { #if (a) sphere { 0, 1 #else box { 0, 1 #end } }",
            "sphere { 0, 1",
            "#include \"decor_P0_1.inc\"",
            "#include Name",
            "#declare F = function(x) { x }",
            "#default { finish { ambient 1 } }",
            "light_source { 0, 1 }",
            "} sphere { 0, 1 }",
        ] {
            assert_eq!(asked(text), None, "{text}");
        }
    }
}

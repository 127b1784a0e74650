//! Where a value ends (`#declare name = value`), what a call's arguments are, and
//! which words begin statements.
//!
//! POV-Ray's rules: a block ends at its brace; an expression ends where an
//! operator could stand and something else does: a directive, a word, a call of a
//! macro. Only where an operand is due do directives and macros go on with it.

use std::collections::HashSet;
use std::ops::Range;

use super::lex::Kind;
use super::outline::Tokens;

/// Words that begin an object.
const OBJECTS: &[&str] = &[
    "sphere",
    "box",
    "cone",
    "cylinder",
    "torus",
    "union",
    "merge",
    "intersection",
    "difference",
    "object",
    "plane",
    "disc",
    "triangle",
    "smooth_triangle",
    "mesh",
    "mesh2",
    "blob",
    "text",
    "height_field",
    "isosurface",
    "parametric",
    "julia_fractal",
    "lathe",
    "sor",
    "prism",
    "poly",
    "polygon",
    "polynomial",
    "quadric",
    "cubic",
    "quartic",
    "superellipsoid",
    "bicubic_patch",
    "sphere_sweep",
    "light_group",
    "ovus",
    "composite",
];

/// Words that begin what concerns the whole scene.
const GLOBALS: &[&str] = &[
    "light_source",
    "camera",
    "background",
    "fog",
    "sky_sphere",
    "rainbow",
    "global_settings",
    "media",
];

/// Words of colours, which want a value behind them.
const COLOURS: &[&str] = &[
    "rgb", "rgbf", "rgbt", "rgbft", "srgb", "srgbf", "srgbt", "srgbft", "color", "colour", "red",
    "green", "blue", "filter", "transmit", "alpha",
];

/// Does the word begin an object?
pub fn is_object(word: &str) -> bool {
    OBJECTS.contains(&word)
}

/// Does the word begin something that concerns the whole scene?
pub fn is_global(word: &str) -> bool {
    GLOBALS.contains(&word)
}

/// Does a value have to follow the word?
pub fn is_colour(word: &str) -> bool {
    COLOURS.contains(&word)
}

/// What a value is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape<'a> {
    /// Its end is certain.
    Certain,
    /// It is, if a call of this macro always makes a whole value.
    IfWhole(&'a str),
    /// It is not.
    Uncertain,
}

/// A value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Value<'a> {
    /// The token behind it (and behind its `;`).
    pub end: usize,
    /// Is that certain?
    pub shape: Shape<'a>,
}

/// The value that begins with the token `at`.
pub fn value_end<'a>(tokens: &Tokens<'a>, at: usize, macros: &HashSet<&str>) -> Value<'a> {
    let list = &tokens.list;
    let is = |at: usize, mark: &str| list.get(at).is_some_and(|t| t.is_mark(mark));
    let word = |at: usize| {
        list.get(at)
            .filter(|t| t.kind == Kind::Word)
            .map(|t| t.text)
    };
    let behind = |at: usize| tokens.partner[at] + 1;
    let block = match word(at) {
        Some(first) if is(at + 1, "{") && !macros.contains(first) => {
            let mut end = behind(at + 1);
            while first == "texture" && word(end) == Some("texture") && is(end + 1, "{") {
                end = behind(end + 1);
            }
            Some(end)
        }
        Some("array") => {
            let mut end = at + 1;
            while is(end, "[") {
                end = behind(end);
            }
            if is(end, "{") {
                end = behind(end);
            }
            Some(end)
        }
        Some("function") if is(at + 1, "(") && is(behind(at + 1), "{") => {
            Some(behind(behind(at + 1)))
        }
        Some("transform") => {
            return Value {
                end: at + 1,
                shape: Shape::Uncertain,
            };
        }
        _ => None,
    };
    match block.or_else(|| either_object(tokens, at)) {
        Some(end) => Value {
            end: end + usize::from(is(end, ";")),
            shape: Shape::Certain,
        },
        None => expression_end(tokens, at, macros),
    }
}

/// The end of `#if (…) sphere {…} #else box {…} #end`: an object, whichever.
fn either_object(tokens: &Tokens<'_>, at: usize) -> Option<usize> {
    let list = &tokens.list;
    let is = |at: usize, name: &str| list.get(at).is_some_and(|t| t.is_directive(name));
    let object = |at: usize| {
        let word = list.get(at).filter(|token| token.kind == Kind::Word)?;
        let brace = list.get(at + 1).is_some_and(|next| next.is_mark("{"));
        (is_object(word.text) && brace).then(|| tokens.partner[at + 1] + 1)
    };
    let condition = list.get(at + 1).filter(|token| token.is_mark("("));
    let begins = ["if", "ifdef", "ifndef"].iter().any(|name| is(at, name));
    condition.filter(|_| begins)?;
    let first = object(tokens.partner[at + 1] + 1).filter(|end| is(*end, "else"))?;
    let second = object(first + 1).filter(|end| is(*end, "end"))?;
    Some(second + 1)
}

fn expression_end<'a>(tokens: &Tokens<'a>, at: usize, macros: &HashSet<&str>) -> Value<'a> {
    let list = &tokens.list;
    // Was a whole operand read last? Which macro made it? Open angle brackets.
    let (mut operand, mut by_macro, mut angles) = (false, None, 0_usize);
    let mut now = at;
    let ends = |end: usize, certain: bool, by: Option<&'a str>| Value {
        end,
        shape: match (certain, by) {
            (false, _) => Shape::Uncertain,
            (true, None) => Shape::Certain,
            (true, Some(name)) => Shape::IfWhole(name),
        },
    };
    while let Some(token) = list.get(now) {
        let next_is = |mark: &str| list.get(now + 1).is_some_and(|t| t.is_mark(mark));
        match (token.kind, token.text) {
            (Kind::Directive, _) => return ends(now, operand && angles == 0, by_macro),
            (Kind::Number | Kind::Text, _) => {
                if operand && angles == 0 {
                    return ends(now, false, None);
                }
                (operand, by_macro) = (true, None);
            }
            (Kind::Word, word) => {
                if operand && angles == 0 {
                    if COLOURS.contains(&word) {
                        operand = false;
                    } else {
                        // Layers of a texture go on, but not behind a name.
                        let layer = word == "texture" && by_macro.is_some();
                        return ends(now, !layer, by_macro);
                    }
                } else if next_is("{") {
                    return ends(now, false, None);
                } else {
                    operand = !COLOURS.contains(&word);
                    by_macro = macros.contains(word).then_some(word);
                }
            }
            (_, ";") => return ends(now + 1, operand && angles == 0, None),
            (_, ")" | "]" | "}") => return ends(now, operand && angles == 0, None),
            (_, "(" | "[") => {
                now = tokens.partner[now];
                if !operand {
                    by_macro = None;
                }
                operand = true;
            }
            (_, "{") => return ends(now, false, None),
            (_, "<") => {
                if !operand {
                    angles += 1;
                }
                operand = false;
            }
            (_, ">") if operand && angles > 0 => {
                angles -= 1;
                by_macro = None;
            }
            (_, ",") if angles == 0 => return ends(now, operand, None),
            _ => (operand, by_macro) = (false, None),
        }
        now += 1;
    }
    ends(now, operand && angles == 0, by_macro)
}

/// The arguments of the call whose bracket is the token `open`; `None` where it
/// is not certain which is which: commas may be left out, `<` may compare.
pub fn arguments(tokens: &Tokens<'_>, open: usize) -> Option<Vec<Range<usize>>> {
    let list = &tokens.list;
    let close = tokens.partner[open];
    if close == open + 1 {
        return Some(Vec::new());
    }
    let (mut arguments, mut start, mut now) = (Vec::new(), open + 1, open + 1);
    let (mut operand, mut angles) = (false, 0_usize);
    while now < close {
        let token = &list[now];
        match (token.kind, token.text) {
            (Kind::Directive, _) => return None,
            (Kind::Mark, "(" | "[" | "{") => {
                now = tokens.partner[now];
                operand = true;
            }
            (Kind::Mark, "<") if operand => return None,
            (Kind::Mark, "<") => angles += 1,
            (Kind::Mark, ">") if operand && angles > 0 => angles -= 1,
            (Kind::Mark, ">") => return None,
            (Kind::Mark, ",") => {
                if angles == 0 {
                    arguments.push(start..now);
                    start = now + 1;
                }
                operand = false;
            }
            (Kind::Mark, _) => operand = false,
            _ => operand = true,
        }
        now += 1;
    }
    arguments.push(start..close);
    (angles == 0).then_some(arguments)
}

#[cfg(test)]
mod tests {
    use super::super::lex::lex;
    use super::*;

    fn tokens(text: &str) -> Tokens<'_> {
        let list = lex(text.as_bytes()).tokens;
        let mut partner: Vec<usize> = (0..list.len()).collect();
        let mut open = Vec::new();
        for (at, token) in list.iter().enumerate() {
            match token.text {
                "(" | "[" | "{" => open.push(at),
                ")" | "]" | "}" => {
                    if let Some(other) = open.pop() {
                        (partner[at], partner[other]) = (other, at);
                    }
                }
                _ => {}
            }
        }
        Tokens { list, partner }
    }

    fn ended(text: &str) -> (String, bool) {
        let found = tokens(text);
        let macros = HashSet::from(["M", "N"]);
        let value = value_end(&found, 0, &macros);
        let rest: Vec<&str> = found.list[value.end..].iter().map(|t| t.text).collect();
        (rest.join(" "), value.shape == Shape::Certain)
    }

    #[test]
    fn values_end_where_povray_ends_them() {
        let certain = [
            ("1; A", "A"),
            ("1 sphere { 0 1 }", "sphere { 0 1 }"),
            ("-2*B+vlength(<1,2 3>) #declare A = 1", "declare A = 1"),
            ("<1,2,3>*M(1) ; A", "A"),
            ("texture { T } texture { U } A", "A"),
            ("sphere { 0 1 }; A", "A"),
            ("array[2][3] { 1, 2 } A", "A"),
            ("function(x, y) { x } A", "A"),
            ("rgb 1 filter .5 A", "A"),
            ("color rgb <1,0,0> transmit B; A", "A"),
            ("A[1].x }", "}"),
            ("B A", "A"),
            ("(B < 1 ? 2 : 3); A", "A"),
            ("M(1).x*2; A", "A"),
            ("#if(C) sphere { 0 1 } #else box { 0 1 } #end A", "A"),
            (
                "#ifdef (C) sphere { #if(D) #end } #else object { B } #end; A",
                "A",
            ),
            ("concat(\"a\", \"b\") #debug C", "debug C"),
        ];
        for (text, rest) in certain {
            assert_eq!(ended(text), (rest.to_owned(), true), "{text}");
        }
        for (text, name) in [
            ("M(1) N(2)", "M"),
            ("2*M(1) sphere {}", "M"),
            ("M(1) #if(C) 2 #end", "M"),
        ] {
            let found = tokens(text);
            let value = value_end(&found, 0, &HashSet::from(["M", "N"]));
            assert_eq!(value.shape, Shape::IfWhole(name), "{text}");
        }
        for text in [
            "M(1) texture { T }",
            "1 + #if(C) 2 #end",
            "#if(C) 2 #end",
            "#if(C) sphere { 0 1 } #end",
            "#if(C) sphere { 0 1 } #else B #end",
            "#if(C) sphere { 0 1 } translate x #else box { 0 1 } #end",
            "rgb #if(C) 1 #end",
            "1 2",
            "transform T;",
            "M() { 1 }",
            "1 +;",
        ] {
            assert!(!ended(text).1, "{text}");
        }
    }

    #[test]
    fn arguments_are_told_apart() {
        let count = |text| arguments(&tokens(text), 0).map(|list| list.len());
        assert_eq!(count("()"), Some(0));
        assert_eq!(count("(a)"), Some(1));
        assert_eq!(count("(<1,2>, f(a,b), array[2]{1,2}, -<a,b,c>*2)"), Some(4));
        assert_eq!(count("(a<b, c>d)"), None);
        assert_eq!(count("(a > b)"), None);
        assert_eq!(count("(#if(c) 1 #end)"), None);
    }
}

//! POV-Ray's scene language as words: enough to look at a fragment and to
//! rename what it declares, without understanding it.

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An identifier or a reserved word.
    Word,
    /// A directive, with its `#`: `#declare`.
    Directive,
    /// A string, with its quotes.
    Text,
    /// Anything else: a number, or a single brace or operator.
    Other,
    /// The middle of a long list of numbers and vectors, with its commas.
    List,
}

/// A piece of the text. Comments and blanks lie between the tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token<'a> {
    /// What it is.
    pub kind: Kind,
    /// Its bytes.
    pub bytes: &'a [u8],
    /// Where it starts in the text.
    pub start: usize,
    /// Its line, from 1.
    pub line: usize,
}

impl<'a> Token<'a> {
    /// Is it this word (or directive, or character)?
    pub fn is(&self, text: &str) -> bool {
        self.bytes == text.as_bytes()
    }

    /// Is it a number, or what stands between the numbers of a list?
    fn is_of_list(&self) -> bool {
        self.kind == Kind::Other
            && (self.bytes[0].is_ascii_digit() || b"<>,.+-".contains(&self.bytes[0]))
    }

    /// The word, directive or string as text; other bytes are lost.
    pub fn text(&self) -> std::borrow::Cow<'a, str> {
        String::from_utf8_lossy(self.bytes)
    }

    /// What a string says, without its quotes; `None` for other tokens.
    pub fn string(&self) -> Option<&'a [u8]> {
        match self.kind {
            Kind::Text => {
                let inner = self.bytes.strip_prefix(b"\"")?;
                Some(inner.strip_suffix(b"\"").unwrap_or(inner))
            }
            _ => None,
        }
    }
}

/// Tokens at either end of a list that are always told apart: what stands before or
/// behind a list may ask for them.
const LIST_ENDS: usize = 32;

/// All tokens of `text`. Never fails: what is unfinished ends with the text.
///
/// A mesh is hundreds of thousands of numbers, and nobody asks for those in its midst:
/// of a text without directives they are one token. Where there are directives, any
/// number may become part of a colour.
pub fn tokens(text: &[u8]) -> Vec<Token<'_>> {
    let mut scan = Scan {
        text,
        at: 0,
        line: 1,
    };
    let shortens = !has_directives(text);
    let mut found = Vec::new();
    let mut list = 0;
    while let Some(token) = scan.next() {
        list = if token.is_of_list() { list + 1 } else { 0 };
        found.push(token);
        // By many at once: each is moved but once.
        if shortens && list == 3 * LIST_ENDS {
            shorten(&mut found, text);
            list = 2 * LIST_ENDS;
        }
    }
    found
}

/// The list that `found` ends with has `3 * LIST_ENDS` tokens: those in its middle
/// become one, with the one before them where that is in the middle as well.
fn shorten<'a>(found: &mut Vec<Token<'a>>, text: &'a [u8]) {
    let (from, until) = (found.len() - 2 * LIST_ENDS, found.len() - LIST_ENDS);
    let first = if found[from - 1].kind == Kind::List {
        from - 1
    } else {
        from
    };
    let last = &found[until - 1];
    let end = last.start + last.bytes.len();
    let start = found[first].start;
    found[first].kind = Kind::List;
    found[first].bytes = &text[start..end];
    found.drain(first + 1..until);
}

/// Can there be a directive in `text`? A mesh is hundreds of thousands of tokens,
/// and as a rule without one.
pub fn has_directives(text: &[u8]) -> bool {
    text.contains(&b'#')
}

struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    line: usize,
}

impl<'a> Scan<'a> {
    fn peek(&self, ahead: usize) -> u8 {
        self.text.get(self.at + ahead).copied().unwrap_or(0)
    }

    fn step(&mut self) {
        if self.peek(0) == b'\n' {
            self.line += 1;
        }
        self.at += 1;
    }

    fn skip_blanks_and_comments(&mut self) {
        loop {
            match (self.peek(0), self.peek(1)) {
                _ if self.at >= self.text.len() => return,
                (b'/', b'/') => {
                    while self.at < self.text.len() && self.peek(0) != b'\n' {
                        self.step();
                    }
                }
                (b'/', b'*') => self.skip_block_comment(),
                (b, _) if b.is_ascii_whitespace() => self.step(),
                _ => return,
            }
        }
    }

    /// Comments between `/*` and `*/` nest in POV-Ray.
    fn skip_block_comment(&mut self) {
        let mut depth = 0;
        while self.at < self.text.len() {
            match (self.peek(0), self.peek(1)) {
                (b'/', b'*') => {
                    depth += 1;
                    self.at += 2;
                }
                (b'*', b'/') => {
                    depth -= 1;
                    self.at += 2;
                    if depth == 0 {
                        return;
                    }
                }
                _ => self.step(),
            }
        }
    }

    fn next(&mut self) -> Option<Token<'a>> {
        self.skip_blanks_and_comments();
        if self.at >= self.text.len() {
            return None;
        }
        let (start, line) = (self.at, self.line);
        let first = self.peek(0);
        let kind = if is_word_start(first) {
            self.skip_word();
            Kind::Word
        } else if first == b'"' {
            self.skip_string();
            Kind::Text
        } else if first == b'#' {
            self.step();
            // Blanks may stand between the # and its word.
            while matches!(self.peek(0), b' ' | b'\t') {
                self.step();
            }
            if is_word_start(self.peek(0)) {
                let word = self.at;
                self.skip_word();
                if word != start + 1 {
                    return Some(Token {
                        kind: Kind::Directive,
                        bytes: spaced_directive(&self.text[word..self.at]),
                        start,
                        line,
                    });
                }
                Kind::Directive
            } else {
                Kind::Other
            }
        } else if first.is_ascii_digit() {
            // A number is one token, so that its exponent is no word.
            while self.peek(0).is_ascii_alphanumeric() || self.peek(0) == b'.' {
                self.step();
            }
            Kind::Other
        } else {
            self.step();
            Kind::Other
        };
        Some(Token {
            kind,
            bytes: &self.text[start..self.at],
            start,
            line,
        })
    }

    fn skip_word(&mut self) {
        while self.peek(0).is_ascii_alphanumeric() || self.peek(0) == b'_' {
            self.step();
        }
    }

    fn skip_string(&mut self) {
        self.step();
        while self.at < self.text.len() {
            match self.peek(0) {
                b'\\' => {
                    self.step();
                    if self.at < self.text.len() {
                        self.step();
                    }
                }
                b'"' => {
                    self.step();
                    return;
                }
                _ => self.step(),
            }
        }
        self.at = self.at.min(self.text.len());
    }
}

fn is_word_start(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || byte == b'_'
}

/// The usual spelling of a directive that was written with blanks behind `#`.
fn spaced_directive(word: &[u8]) -> &'static [u8] {
    const KNOWN: [&[u8]; 24] = [
        b"#declare",
        b"#local",
        b"#macro",
        b"#include",
        b"#default",
        b"#if",
        b"#ifdef",
        b"#ifndef",
        b"#else",
        b"#elseif",
        b"#while",
        b"#for",
        b"#switch",
        b"#case",
        b"#range",
        b"#break",
        b"#end",
        b"#undef",
        b"#fopen",
        b"#write",
        b"#read",
        b"#fclose",
        b"#version",
        b"#error",
    ];
    KNOWN
        .iter()
        .find(|k| &k[1..] == word)
        .copied()
        .unwrap_or(b"#?")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn words(text: &str) -> Vec<String> {
        tokens(text.as_bytes())
            .iter()
            .map(|t| t.text().into_owned())
            .collect()
    }

    #[test]
    fn comments_strings_and_numbers() {
        assert_eq!(
            words("a /* b /* c */ d */ \"e // f\" // g\n#declare h=1e-5; 2.5e3.x"),
            [
                "a",
                "\"e // f\"",
                "#declare",
                "h",
                "=",
                "1e",
                "-",
                "5",
                ";",
                "2.5e3.x"
            ]
        );
        assert_eq!(words("# declare x"), ["#declare", "x"]);
        assert_eq!(words(r#""a\"b" c"#), [r#""a\"b""#, "c"]);
    }

    #[test]
    fn lines_are_counted() {
        let found = tokens(b"a\n/* \n */ b\n\"x\ny\" c");
        let lines: Vec<usize> = found.iter().map(|t| t.line).collect();
        assert_eq!(lines, [1, 3, 4, 5]);
    }

    #[test]
    fn a_long_list_is_one_token_between_its_ends() {
        let list = |vectors: usize| {
            (0..vectors)
                .map(|k| format!("<{k},-1,.5>,\n"))
                .collect::<String>()
        };
        let text = format!("mesh2 {{ vertex_vectors {{ 9, {} }} }} after", list(5000));
        let found = tokens(text.as_bytes());
        assert!(found.len() < 200, "{}", found.len());
        let lists = found.iter().filter(|t| t.kind == Kind::List).count();
        assert_eq!(lists, 1);
        let (head, tail) = (
            &found[..4 + LIST_ENDS],
            &found[found.len() - 3 - LIST_ENDS..],
        );
        assert_eq!(head[3].text(), "{");
        assert_eq!(head[4].text(), "9");
        assert!(head[4..].iter().all(|t| t.kind == Kind::Other));
        assert_eq!(tail[LIST_ENDS].text(), "}");
        assert_eq!(tail[LIST_ENDS + 2].text(), "after");
        assert!(tail[..LIST_ENDS].iter().all(|t| t.kind == Kind::Other));
        assert_eq!(tail[LIST_ENDS + 2].line, 5001);
        // Nothing is lost between them.
        let gap = found
            .windows(2)
            .map(|pair| pair[1].start - (pair[0].start + pair[0].bytes.len()));
        assert!(gap.max() <= Some(2));

        let short = text.replace(&list(5000), &list(8));
        assert!(
            tokens(short.as_bytes())
                .iter()
                .all(|t| t.kind != Kind::List)
        );
        let directed = format!("#local A = 1; {text}");
        assert!(
            tokens(directed.as_bytes())
                .iter()
                .all(|t| t.kind != Kind::List)
        );
    }

    proptest! {
        #[test]
        fn any_bytes_are_read(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let found = tokens(&bytes);
            let total: usize = found.iter().map(|t| t.bytes.len()).sum();
            prop_assert!(total <= bytes.len() + 8 * found.len());
        }
    }
}

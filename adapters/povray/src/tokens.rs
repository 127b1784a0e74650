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
    /// Anything else, a character at a time: numbers, braces, operators.
    Other,
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

/// All tokens of `text`. Never fails: what is unfinished ends with the text.
pub fn tokens(text: &[u8]) -> Vec<Token<'_>> {
    let mut scan = Scan {
        text,
        at: 0,
        line: 1,
    };
    let mut found = Vec::new();
    while let Some(token) = scan.next() {
        found.push(token);
    }
    found
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

    proptest! {
        #[test]
        fn any_bytes_are_read(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let found = tokens(&bytes);
            let total: usize = found.iter().map(|t| t.bytes.len()).sum();
            prop_assert!(total <= bytes.len() + 8 * found.len());
        }
    }
}

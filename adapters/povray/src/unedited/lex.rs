//! The words of a scene, exactly as POV-Ray 3.7 splits its text: what depends on
//! the clock is decided by them, so anything doubtful is a fault.
//!
//! (`crate::tokens` looks at fragments and may be wrong about odd texts.)

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// An identifier or a reserved word.
    Word,
    /// A directive; its text is the word behind the `#`.
    Directive,
    /// A string; its text is what is between the quotes.
    Text,
    /// A number.
    Number,
    /// A single character of any other kind.
    Mark,
}

/// A piece of the text. Comments and blanks lie between the tokens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Token<'a> {
    /// What it is.
    pub kind: Kind,
    /// Its text, see [`Kind`].
    pub text: &'a str,
    /// Its first byte.
    pub start: usize,
    /// The byte behind it.
    pub end: usize,
}

impl Token<'_> {
    /// Is it this character?
    pub fn is_mark(&self, mark: &str) -> bool {
        self.kind == Kind::Mark && self.text == mark
    }

    /// Is it this directive?
    pub fn is_directive(&self, name: &str) -> bool {
        self.kind == Kind::Directive && self.text == name
    }
}

/// A text's tokens, and what is odd about it: the byte, and why.
#[derive(Clone, Debug, Default)]
pub struct Lexed<'a> {
    /// The tokens.
    pub tokens: Vec<Token<'a>>,
    /// Why the tokens may not be POV-Ray's.
    pub faults: Vec<(usize, &'static str)>,
}

/// Splits a text. Never fails: what is unfinished is a fault.
pub fn lex(text: &[u8]) -> Lexed<'_> {
    let mut scan = Scan {
        text,
        at: 0,
        lexed: Lexed::default(),
    };
    while scan.next() {}
    scan.lexed
}

struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    lexed: Lexed<'a>,
}

impl<'a> Scan<'a> {
    fn peek(&self, ahead: usize) -> u8 {
        self.text.get(self.at + ahead).copied().unwrap_or(0)
    }

    fn fault(&mut self, at: usize, reason: &'static str) {
        self.lexed.faults.push((at, reason));
    }

    fn push(&mut self, kind: Kind, start: usize, text: std::ops::Range<usize>) {
        let token = Token {
            kind,
            text: std::str::from_utf8(&self.text[text]).unwrap_or_default(),
            start,
            end: self.at,
        };
        self.lexed.tokens.push(token);
    }

    fn skip_blanks_and_comments(&mut self) {
        while self.at < self.text.len() {
            match (self.peek(0), self.peek(1)) {
                (b'/', b'/') => {
                    while self.at < self.text.len() && self.peek(0) != b'\n' {
                        self.at += 1;
                    }
                }
                (b'/', b'*') => self.skip_block_comment(),
                // Control-Z was an end of file once; POV-Ray skips it.
                (b, _) if b.is_ascii_whitespace() || matches!(b, 0 | 0x0b | 0x1a) => self.at += 1,
                _ => return,
            }
        }
    }

    /// Comments between `/*` and `*/` nest. As in POV-Ray, `/*/` opens and
    /// neither closes nor opens another.
    fn skip_block_comment(&mut self) {
        let start = self.at;
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
                _ => self.at += 1,
            }
        }
        self.fault(start, "this comment has no end");
    }

    fn next(&mut self) -> bool {
        self.skip_blanks_and_comments();
        if self.at >= self.text.len() {
            return false;
        }
        let start = self.at;
        let first = self.peek(0);
        if is_word_start(first) {
            self.skip_word();
            self.push(Kind::Word, start, start..self.at);
        } else if first == b'"' {
            self.string(start);
        } else if first == b'#' {
            self.at += 1;
            self.skip_blanks_and_comments();
            let word = self.at;
            self.skip_word();
            if !is_word_start(self.text.get(word).copied().unwrap_or(0)) {
                self.fault(start, "this # has no word");
            }
            self.push(Kind::Directive, start, word..self.at);
        } else if first.is_ascii_digit() || (first == b'.' && self.peek(1).is_ascii_digit()) {
            self.number(start);
        } else {
            if !first.is_ascii_graphic() {
                self.fault(start, "this character is none of POV-Ray's");
            }
            self.at += 1;
            self.push(Kind::Mark, start, start..self.at);
        }
        true
    }

    fn skip_word(&mut self) {
        while self.peek(0).is_ascii_alphanumeric() || self.peek(0) == b'_' {
            self.at += 1;
        }
    }

    fn number(&mut self, start: usize) {
        let digits = |scan: &mut Self| {
            while scan.peek(0).is_ascii_digit() {
                scan.at += 1;
            }
        };
        digits(self);
        if self.peek(0) == b'.' {
            self.at += 1;
            digits(self);
        }
        let sign = usize::from(matches!(self.peek(1), b'+' | b'-'));
        if matches!(self.peek(0), b'e' | b'E') && self.peek(1 + sign).is_ascii_digit() {
            self.at += 1 + sign;
            digits(self);
        }
        if is_word_start(self.peek(0)) || self.peek(0) == b'.' {
            self.fault(start, "this number runs into what follows");
        }
        self.push(Kind::Number, start, start..self.at);
    }

    fn string(&mut self, start: usize) {
        self.at += 1;
        while self.at < self.text.len() {
            match self.peek(0) {
                b'\\' => self.at += 2,
                b'"' => {
                    self.at += 1;
                    self.push(Kind::Text, start, start + 1..self.at - 1);
                    return;
                }
                _ => self.at += 1,
            }
        }
        self.at = self.text.len();
        self.fault(start, "this string has no end");
    }
}

fn is_word_start(byte: u8) -> bool {
    byte.is_ascii_alphabetic() || byte == b'_'
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn words(text: &str) -> Vec<&str> {
        let lexed = lex(text.as_bytes());
        assert!(lexed.faults.is_empty(), "{text}: {:?}", lexed.faults);
        lexed.tokens.iter().map(|t| t.text).collect()
    }

    #[test]
    fn comments_strings_and_numbers() {
        assert_eq!(
            words("a /* b /* c */ d */ \"e // f\" // g\n#declare h=1e-5*.5; V.x"),
            [
                "a", "e // f", "declare", "h", "=", "1e-5", "*", ".5", ";", "V", ".", "x"
            ]
        );
        assert_eq!(words("#\n /* \" */ // \n declare x"), ["declare", "x"]);
        assert_eq!(words(r#""a\"b" c"#), [r#"a\"b"#, "c"]);
        assert_eq!(words("a/**/b /* /*/ */ */ c"), ["a", "b", "c"]);
    }

    #[test]
    fn odd_texts_have_faults() {
        for text in [
            "2clock", "1.5.x", "\"a", "/* a", "/*/", "# 5", "é", "#", "\"a\\\"",
        ] {
            assert!(!lex(text.as_bytes()).faults.is_empty(), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_bytes_are_split(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
            let lexed = lex(&bytes);
            for pair in lexed.tokens.windows(2) {
                prop_assert!(pair[0].end <= pair[1].start);
            }
            prop_assert!(lexed.tokens.iter().all(|t| t.end <= bytes.len()));
        }
    }
}

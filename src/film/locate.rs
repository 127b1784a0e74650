//! Where a value stands in a line of JSON. Used once something is known to be
//! wrong with the value: serde has no places to give.

use std::ops::Range;

/// One step into a JSON value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Into an object's member.
    Key(&'static str),
    /// Into an array's element.
    Index(usize),
}

/// The bytes of the value that the steps lead to, in a line of valid JSON; of
/// the last one that was found, where the path breaks off.
pub(super) fn locate(line: &str, steps: impl Iterator<Item = Step>) -> Range<usize> {
    let mut scan = Scan {
        bytes: line.as_bytes(),
        at: 0,
    };
    scan.skip_blanks();
    let mut found = scan.value();
    for step in steps {
        scan.at = found.start;
        match scan.enter(step) {
            Some(inner) => found = inner,
            None => break,
        }
    }
    found
}

struct Scan<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Scan<'_> {
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.at).copied()
    }

    fn skip_blanks(&mut self) {
        while self.peek().is_some_and(|b| b.is_ascii_whitespace()) {
            self.at += 1;
        }
    }

    /// Passes the value that starts here.
    fn value(&mut self) -> Range<usize> {
        let start = self.at;
        let mut depth = 0_usize;
        while let Some(byte) = self.peek() {
            match byte {
                b'"' => self.string(),
                b'{' | b'[' => {
                    depth += 1;
                    self.at += 1;
                }
                b'}' | b']' if depth == 0 => break,
                b'}' | b']' => {
                    depth -= 1;
                    self.at += 1;
                }
                b',' | b':' if depth == 0 => break,
                byte if depth == 0 && byte.is_ascii_whitespace() => break,
                _ => {
                    self.at += 1;
                    continue_scalar(self, depth);
                }
            }
            if depth == 0 {
                break;
            }
        }
        start..self.at
    }

    /// Passes a string, from quotation mark to quotation mark.
    fn string(&mut self) {
        self.at += 1;
        while let Some(byte) = self.peek() {
            self.at += 1;
            match byte {
                b'\\' => self.at += 1,
                b'"' => break,
                _ => {}
            }
        }
        self.at = self.at.min(self.bytes.len());
    }

    /// The value that `step` leads to in the object or array that starts here.
    fn enter(&mut self, step: Step) -> Option<Range<usize>> {
        let opening = self.peek()?;
        self.at += 1;
        let mut index = 0;
        loop {
            self.skip_blanks();
            let found = match (opening, step) {
                (b'{', Step::Key(key)) => {
                    let start = self.at;
                    self.value();
                    let name = self.bytes.get(start + 1..self.at.saturating_sub(1))?;
                    self.skip_blanks();
                    self.at += 1;
                    self.skip_blanks();
                    name == key.as_bytes()
                }
                (b'[', Step::Index(wanted)) => index == wanted,
                _ => return None,
            };
            let before = self.at;
            let value = self.value();
            if value.is_empty() {
                return None;
            }
            if found {
                return Some(value);
            }
            self.skip_blanks();
            if self.peek() != Some(b',') || self.at == before {
                return None;
            }
            self.at += 1;
            index += 1;
        }
    }
}

/// Passes the rest of a number or a word.
fn continue_scalar(scan: &mut Scan<'_>, depth: usize) {
    if depth > 0 {
        return;
    }
    while scan
        .peek()
        .is_some_and(|b| !b.is_ascii_whitespace() && !b",:]}".contains(&b))
    {
        scan.at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Step::{Index, Key};

    const LINE: &str = r#" {"scene": 0, "a]\"": "x, }", "objects" :[{"path":"b"} , {"path": "c\"d", "p":[1,-2e5]}]} "#;

    fn at(steps: &[Step]) -> &'static str {
        &LINE[locate(LINE, steps.iter().copied())]
    }

    #[test]
    fn values_are_found() {
        assert_eq!(at(&[]), LINE.trim());
        assert_eq!(at(&[Key("scene")]), "0");
        let second = [Key("objects"), Index(1)];
        assert_eq!(at(&[second[0], second[1], Key("path")]), r#""c\"d""#);
        assert_eq!(at(&[second[0], second[1], Key("p"), Index(1)]), "-2e5");
    }

    #[test]
    fn a_path_that_breaks_off_gives_what_it_reached() {
        assert_eq!(at(&[Key("none")]), LINE.trim());
        assert_eq!(at(&[Key("scene"), Index(3)]), "0");
        assert_eq!(at(&[Key("objects"), Index(0), Key("p")]), r#"{"path":"b"}"#);
    }

    #[test]
    fn no_text_makes_it_panic() {
        for text in [
            "", "{", "[", "\"", "{\"", "\"\\", "{\"a\"", "{\"a\":", "[,]", "}{",
        ] {
            for step in [Key("a"), Index(0), Index(1)] {
                let range = locate(text, [step, step].into_iter());
                assert!(text.get(range).is_some());
            }
        }
    }
}

//! Lines of an `.anim` file, cut into fields.

use std::borrow::Cow;

use super::mark::{Faults, Mark};
use super::problem::Problem;

/// One field of a line, without its quotation marks.
#[derive(Clone, Debug)]
pub(super) struct Field<'a> {
    pub(super) text: Cow<'a, str>,
    pub(super) mark: Mark,
    /// The bytes that are not in quotation marks, from the start.
    bare: usize,
}

impl Field<'_> {
    /// The text after `prefix`, which must stand outside of quotation marks.
    pub(super) fn after(&self, prefix: &str) -> Option<&str> {
        if self.bare < prefix.len() {
            return None;
        }
        self.text.strip_prefix(prefix)
    }
}

/// A line that states something.
#[derive(Debug)]
pub(super) struct Line<'a> {
    /// `@`, `*` or `!`; the first field comes without it.
    pub(super) sign: char,
    pub(super) fields: Vec<Field<'a>>,
    /// From the sign to the last field.
    pub(super) mark: Mark,
}

/// Where a line is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Its number, from 1.
    pub(super) number: usize,
    /// Its first byte in the file.
    pub(super) start: usize,
}

impl Place {
    pub(super) fn mark(self, from: usize, to: usize) -> Mark {
        Mark::span(self.number, self.start, from, to)
    }
}

/// The lines of a text with their places, without their ends; a byte order mark
/// is passed over.
pub(super) fn split(bytes: &[u8]) -> impl Iterator<Item = (Place, &[u8])> {
    const BYTE_ORDER_MARK: &[u8] = b"\xEF\xBB\xBF";
    let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    let mut start = bytes.len() - text.len();
    let lines = text.split(|b| *b == b'\n');
    lines.enumerate().map(move |(i, line)| {
        let place = Place {
            number: i + 1,
            start,
        };
        start += line.len() + 1;
        (place, line.strip_suffix(b"\r").unwrap_or(line))
    })
}

/// The line as UTF-8 text.
pub(super) fn text<'a>(bytes: &'a [u8], place: Place, faults: &mut Faults) -> Option<&'a str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Some(text),
        Err(error) => {
            let from = error.valid_up_to();
            let length = error.error_len().unwrap_or(bytes.len() - from);
            faults.push(place.mark(from, from + length), Problem::NotUtf8);
            None
        }
    }
}

/// Cuts a line into fields; `Ok(None)` where it states nothing.
///
/// # Errors
/// What is wrong with the line as a whole is noted.
pub(super) fn cut<'a>(
    text: &'a str,
    place: Place,
    faults: &mut Faults,
) -> Result<Option<Line<'a>>, ()> {
    let is_blank = |c: char| c.is_ascii_whitespace();
    let start = text.len() - text.trim_start_matches(is_blank).len();
    let Some(sign) = text[start..].chars().next().filter(|c| *c != '#') else {
        return Ok(None);
    };
    let words = start + sign.len_utf8();
    if !matches!(sign, '@' | '*' | '!') {
        let word = text[start..].split(is_blank).next().unwrap_or_default();
        let mark = place.mark(start, start + word.len());
        let word = shortened(word);
        faults.push(mark, Problem::NotAStatement { word });
        return Err(());
    }
    let mut fields = Vec::new();
    let mut at = words;
    let mut end = words;
    loop {
        let blanks = text[at..].len() - text[at..].trim_start_matches(is_blank).len();
        at += blanks;
        // A comment follows a blank; right after the sign it is a word.
        if at == text.len() || (text[at..].starts_with('#') && blanks > 0) {
            break;
        }
        let (field, next) = field(text, at, place, faults)?;
        fields.push(field);
        at = next;
        end = next;
    }
    let mark = place.mark(start, end);
    Ok(Some(Line { sign, fields, mark }))
}

/// The field that starts at byte `start`, and the byte after it.
fn field<'a>(
    text: &'a str,
    start: usize,
    place: Place,
    faults: &mut Faults,
) -> Result<(Field<'a>, usize), ()> {
    let rest = &text[start..];
    let word = rest.split(|c: char| c.is_ascii_whitespace()).next();
    let word = word.unwrap_or_default();
    let Some(quote) = word.find('"') else {
        let next = start + word.len();
        let field = Field {
            text: word.into(),
            mark: place.mark(start, next),
            bare: word.len(),
        };
        return Ok((field, next));
    };
    // A quotation mark opens a whole field, or the whole name in `name="…"`.
    let stray = start + quote;
    if quote > 0 && &word[..quote] != "name=" {
        faults.push(place.mark(stray, stray + 1), Problem::StrayQuote);
        return Err(());
    }
    let inside = quote + 1;
    let Some(length) = rest[inside..].find('"') else {
        faults.push(place.mark(stray, text.len()), Problem::OpenQuote);
        return Err(());
    };
    let next = start + inside + length + 1;
    if text[next..].starts_with(|c: char| !c.is_ascii_whitespace()) {
        faults.push(place.mark(next - 1, next), Problem::StrayQuote);
        return Err(());
    }
    let quoted = &rest[inside..inside + length];
    let field = Field {
        text: match &word[..quote] {
            "" => quoted.into(),
            key => format!("{key}{quoted}").into(),
        },
        mark: place.mark(start, next),
        bare: quote,
    };
    Ok((field, next))
}

/// At most the first characters of a word, for a message.
pub(super) fn shortened(word: &str) -> String {
    const SHOWN: usize = 40;
    let mut shown: String = word.chars().take(SHOWN).map(printable).collect();
    if word.chars().nth(SHOWN).is_some() {
        shown.push('…');
    }
    shown
}

fn printable(c: char) -> char {
    if c.is_control() {
        char::REPLACEMENT_CHARACTER
    } else {
        c
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(text: &str) -> Result<Option<Vec<String>>, ()> {
        let place = Place {
            number: 1,
            start: 0,
        };
        let line = cut(text, place, &mut Faults::default())?;
        Ok(line.map(|line| {
            line.fields
                .into_iter()
                .map(|f| f.text.into_owned())
                .collect()
        }))
    }

    #[test]
    fn a_number_sign_begins_a_comment_after_a_blank_only() {
        let words = |words: &[&str]| Ok(Some(words.iter().map(|w| w.to_string()).collect()));
        assert_eq!(fields("# all of it"), Ok(None));
        assert_eq!(fields("  \t# all of it"), Ok(None));
        assert_eq!(fields("*eye 1 # 2"), words(&["eye", "1"]));
        assert_eq!(fields("*eye 1\t#2"), words(&["eye", "1"]));
        assert_eq!(fields("!a#1.inc 2"), words(&["a#1.inc", "2"]));
        assert_eq!(fields("!#1.inc 2"), words(&["#1.inc", "2"]));
        assert_eq!(fields("!\"a #1.inc\" 2"), words(&["a #1.inc", "2"]));
        assert_eq!(fields("@ 5"), words(&["5"]));
        assert_eq!(fields(""), Ok(None));
        assert_eq!(fields(" \r \t"), Ok(None));
        assert_eq!(fields("@"), words(&[]));
    }

    #[test]
    fn quotation_marks_go_around_a_whole_field() {
        for text in ["!a\"b\"", "!\"a\"b", "!\"a", "!a name=b\"c\"", "*\""] {
            assert_eq!(fields(text), Err(()), "{text}");
        }
        let Ok(Some(found)) = fields("!\"\" 1 name=\"a b\"") else {
            panic!("refused");
        };
        assert_eq!(found, ["", "1", "name=a b"]);
    }

    #[test]
    fn lines_know_their_places() {
        let text = "\u{feff}a\r\n\nb".as_bytes();
        let found: Vec<_> = split(text).map(|(p, l)| (p.number, p.start, l)).collect();
        assert_eq!(found, [(1, 3, &b"a"[..]), (2, 6, b""), (3, 7, b"b")]);
    }
}

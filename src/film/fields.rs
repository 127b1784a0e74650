//! Fields of an `.anim` line as values. Every bad field of a line is noted, not
//! the first alone.

use glam::DVec3;

use super::lines::{Field, shortened};
use super::mark::{Faults, Mark};
use super::problem::Problem;

/// The fields of a statement after its keyword.
pub(super) struct Fields<'a> {
    /// What the statement is called in messages.
    pub(super) statement: &'static str,
    /// The whole statement.
    pub(super) mark: Mark,
    pub(super) list: &'a [Field<'a>],
    pub(super) faults: &'a mut Faults,
}

impl Fields<'_> {
    /// Is the number of fields one of `counts`? `expected` says so in words.
    pub(super) fn expect(&mut self, counts: &[usize], expected: &'static str) -> Option<()> {
        let found = self.list.len();
        if counts.contains(&found) {
            return Some(());
        }
        let statement = self.statement;
        let problem = Problem::FieldCount {
            statement,
            expected,
            found,
        };
        self.faults.push(self.mark, problem);
        None
    }

    /// The number of field `i`, which is there.
    pub(super) fn number(&mut self, i: usize) -> Option<f64> {
        let field = &self.list[i];
        self.faults.check(field.mark, number(&field.text))
    }

    /// The number of field `i`, in its range.
    pub(super) fn checked<T>(
        &mut self,
        i: usize,
        check: impl FnOnce(f64) -> Result<T, Problem>,
    ) -> Option<T> {
        let value = self.number(i)?;
        self.faults.check(self.list[i].mark, check(value))
    }

    /// The whole number of field `i`, in its range.
    pub(super) fn whole<T>(
        &mut self,
        i: usize,
        check: impl FnOnce(u64) -> Result<T, Problem>,
    ) -> Option<T> {
        let field = &self.list[i];
        let value = whole(&field.text).and_then(check);
        let value = value.map_err(|problem| match problem {
            // The number as it was written, should it be too large to be kept.
            Problem::SizeOutOfRange { .. } => Problem::SizeOutOfRange {
                value: shortened(&field.text),
            },
            other => other,
        });
        self.faults.check(field.mark, value)
    }

    /// Three numbers from field `i` on.
    pub(super) fn vector(&mut self, i: usize) -> Option<DVec3> {
        let [x, y, z] = [i, i + 1, i + 2].map(|i| self.number(i));
        Some(DVec3::new(x?, y?, z?))
    }

    /// The yes or no of field `i`.
    pub(super) fn boolean(&mut self, i: usize) -> Option<bool> {
        let field = &self.list[i];
        let value = match &*field.text {
            "0" => Ok(false),
            "1" => Ok(true),
            text => Err(Problem::NotABoolean {
                text: shortened(text),
            }),
        };
        self.faults.check(field.mark, value)
    }
}

fn number(text: &str) -> Result<f64, Problem> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        Ok(_) => Err(Problem::NotFinite {
            text: shortened(text),
        }),
        Err(_) => Err(Problem::NotANumber {
            text: shortened(text),
        }),
    }
}

/// A whole number; one too large to be kept is larger than any range allows.
fn whole(text: &str) -> Result<u64, Problem> {
    if text.is_empty() || !text.bytes().all(|b| b.is_ascii_digit()) {
        return Err(Problem::NotWhole {
            text: shortened(text),
        });
    }
    Ok(text.parse().unwrap_or(u64::MAX))
}

/// A scene's number.
pub(super) fn scene_number(text: &str) -> Result<u32, Problem> {
    let value = whole(text).ok().and_then(|value| u32::try_from(value).ok());
    value.ok_or_else(|| Problem::SceneNumber {
        text: shortened(text),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_plain_and_finite() {
        for text in ["0", "-0", "+1", ".5", "5.", "1e-400", "-2.5E+3"] {
            assert!(number(text).is_ok(), "{text}");
        }
        for text in ["nan", "inf", "-infinity", "1e400"] {
            let result = number(text);
            assert!(matches!(result, Err(Problem::NotFinite { .. })), "{text}");
        }
        for text in ["", "x", "1,5", "0x10", "1_000", "1 "] {
            let result = number(text);
            assert!(matches!(result, Err(Problem::NotANumber { .. })), "{text}");
        }
    }

    #[test]
    fn scene_numbers_are_whole() {
        assert!(matches!(scene_number("007"), Ok(7)));
        assert!(matches!(scene_number("4294967295"), Ok(u32::MAX)));
        for text in [
            "",
            "-1",
            "+1",
            "1.0",
            "4294967296",
            "99999999999999999999999",
        ] {
            assert!(scene_number(text).is_err(), "{text}");
        }
    }
}

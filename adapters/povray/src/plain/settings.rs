//! What POV-Ray has been told: the value of each option, the last one winning.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::words::{Keyword, Kind};

/// The value of an option.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A whole number.
    Whole(i32),
    /// A number; POV-Ray keeps single precision.
    Real(f32),
    /// On or off.
    Switch(bool),
    /// A text.
    Text(String),
}

/// All options that were stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    values: BTreeMap<&'static str, Value>,
    /// `Declare=`, in order.
    pub declares: Vec<String>,
    /// `Library_Path=`, in order.
    pub library: Vec<String>,
    /// The INI files that were read, with their text.
    pub files: Vec<(PathBuf, Vec<u8>)>,
}

impl Settings {
    /// Sets an option from what was written.
    ///
    /// # Errors
    /// Where POV-Ray would not take the value, in words.
    pub fn set(&mut self, (name, kind): Keyword, text: &str) -> Result<(), String> {
        let value = match kind {
            Kind::Switch => Value::Switch(is_true(text)),
            Kind::Whole => Value::Whole(
                whole(text).ok_or_else(|| format!("{name} wants a whole number, not `{text}`"))?,
            ),
            Kind::Real => Value::Real(
                real(text).ok_or_else(|| format!("{name} wants a number, not `{text}`"))?,
            ),
            Kind::Text | Kind::Command => Value::Text(text.to_owned()),
            Kind::FileType => return self.set_file_type(text.trim_start()),
            Kind::Declare => {
                self.declares.push(text.to_owned());
                return Ok(());
            }
            Kind::Library => {
                self.library.push(text.to_owned());
                return Ok(());
            }
            Kind::Return | Kind::Ini | Kind::Other => return Ok(()),
        };
        self.values.insert(name, value);
        Ok(())
    }

    /// Turns an option on or off.
    pub fn turn(&mut self, name: &'static str, on: bool) {
        self.values.insert(name, Value::Switch(on));
    }

    /// `N`, and in a switch also `N16` and `Ng`: bits of a channel, grey.
    fn set_file_type(&mut self, text: &str) -> Result<(), String> {
        let letter = text.chars().next().map(|c| c.to_ascii_uppercase());
        let known = letter.filter(|c| "TCNJPBEHS".contains(*c));
        let letter = known.ok_or_else(|| format!("`{text}` is no file type of POV-Ray"))?;
        self.values
            .insert("Output_File_Type", Value::Text(letter.to_string()));
        Ok(())
    }

    /// A whole number, however it was stated.
    pub fn whole(&self, name: &str) -> Option<i32> {
        match self.values.get(name)? {
            Value::Whole(n) => Some(*n),
            Value::Real(x) => Some(*x as i32),
            _ => None,
        }
    }

    /// A number, however it was stated.
    pub fn real(&self, name: &str) -> Option<f32> {
        match self.values.get(name)? {
            Value::Whole(n) => Some(*n as f32),
            Value::Real(x) => Some(*x),
            _ => None,
        }
    }

    /// Is it on? Where it was not stated, it is not.
    pub fn is_on(&self, name: &str) -> bool {
        self.values.get(name) == Some(&Value::Switch(true))
    }

    /// A text.
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.values.get(name)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// All single values, by name.
    pub fn values(&self) -> impl Iterator<Item = (&'static str, &Value)> {
        self.values.iter().map(|(name, value)| (*name, value))
    }
}

/// POV-Ray compares as many characters as the shorter of the two words has:
/// `O` is `on`, and so is nothing.
fn is_true(text: &str) -> bool {
    ["on", "true", "yes", "1"].iter().any(|word| {
        word.bytes()
            .zip(text.bytes())
            .all(|(a, b)| a == b.to_ascii_lowercase())
    })
}

/// As C's `%d`: what follows the digits is not looked at.
fn whole(text: &str) -> Option<i32> {
    let text = text.trim_start();
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let count = digits.bytes().take_while(u8::is_ascii_digit).count();
    let end = text.len() - digits.len() + count;
    (count > 0).then(|| {
        let number: i64 = text[..end].parse().unwrap_or(i64::MAX);
        i32::try_from(number).unwrap_or(i32::MAX)
    })
}

/// As C's `%lf`, but for hexadecimal numbers.
fn real(text: &str) -> Option<f32> {
    let text = text.trim_start();
    let ends = text.char_indices().map(|(k, c)| k + c.len_utf8()).rev();
    let number = ends
        .map(|end| &text[..end])
        .find_map(|part| part.parse::<f64>().ok());
    number.map(|x| x as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_where_c_ends_them() {
        assert_eq!(whole("12foo"), Some(12));
        assert_eq!(whole(" -3.7"), Some(-3));
        assert_eq!(whole("foo"), None);
        assert_eq!(real(".25x"), Some(0.25));
        assert_eq!(real("1e2 "), Some(100.0));
        assert_eq!(real("e"), None);
    }

    #[test]
    fn words_for_on() {
        for on in ["on", "On", "TRUE", "y", "1", "", "o"] {
            assert!(is_true(on), "{on}");
        }
        for off in ["off", "no", "0", "false", "2"] {
            assert!(!is_true(off), "{off}");
        }
    }
}

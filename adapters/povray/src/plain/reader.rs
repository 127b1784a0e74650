//! Reads INI files and switches as POV-Ray 3.7 does.
//!
//! The rules, found by reading its source and by asking it (`Create_Ini`):
//!
//! - A line is `Keyword = value`, or switches (`+W320 -A`), or the name of a
//!   `.pov` file, of another INI file, or of a library folder (it ends in `/`).
//!   Capitals do not matter. `;` and `#` begin a comment.
//! - Behind an option the rest of the line is skipped; behind a switch it is
//!   read on: `+kff20 +kc Declare=fp=0` sets three things.
//! - A value ends at a blank. But where the word behind the blank is no keyword,
//!   switch or comment, POV-Ray takes the line for a text with blanks that
//!   somebody forgot to quote: the value goes on to the end of the line. It
//!   looks at that word from its second letter on, so another option on the same
//!   line is never seen: `Input_File_Name=a.pov Width=9` names one file. Where
//!   the line ends behind the blank, the word of the next line is looked at.
//! - A value in quotes ends at the same quote. Values behind commas are further
//!   values of the same keyword.
//! - What stands before the first `[section]` always counts; a section counts
//!   where the file was called `file.ini[section]`.
//! - INI files are looked for in the working folder, then in the library folders
//!   known so far, as they are called (if the ending has up to three letters),
//!   then with `.ini` and `.INI`.
//! - First of all one `povray.ini` is read: `POVINI`, or that of the working
//!   folder, of the user, of the system. Then the words of the command line in
//!   their order. Later values win; folders and declarations add up; `POVINC` is
//!   the last folder.

use std::path::{Path, PathBuf};

use super::settings::Settings;
use super::words::{Keyword, Kind, SWITCHES, keyword};

/// INI files that read each other end somewhere.
const DEEPEST: usize = 16;

/// Why POV-Ray would not go on: the file (if it is in one), and the reason.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The file.
    pub file: Option<PathBuf>,
    /// Why.
    pub reason: String,
}

/// Reads into settings.
pub struct Reader<'a> {
    /// The working folder.
    pub folder: &'a Path,
    /// What was read so far.
    pub settings: Settings,
    depth: usize,
}

impl<'a> Reader<'a> {
    /// Nothing is read yet.
    pub fn new(folder: &'a Path) -> Self {
        Self {
            folder,
            settings: Settings::default(),
            depth: 0,
        }
    }

    /// Reads one word of the command line. POV-Ray splits it again at blanks.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn word(&mut self, word: &str) -> Result<(), Refused> {
        let mut scan = Scan::new(word.as_bytes());
        scan.commas_end = false;
        loop {
            scan.skip_blanks();
            let here = scan.at;
            let Some(first) = scan.take() else {
                return Ok(());
            };
            match first {
                b'+' | b'-' => self.switch(&mut scan, first == b'+').map_err(nowhere)?,
                b'"' | b'\'' => {
                    let name = scan.until(first);
                    self.name(&name)?;
                }
                _ => {
                    scan.at = here;
                    if !self.command_option(&mut scan)? {
                        scan.at = here;
                        let name = scan.word(Ends::LineValue, false);
                        if name.contains('=') || name.is_empty() {
                            return Err(nowhere(format!("POV-Ray does not know `{word}`")));
                        }
                        self.name(&name)?;
                    }
                }
            }
        }
    }

    /// `Keyword=value` on the command line, without blanks.
    fn command_option(&mut self, scan: &mut Scan<'_>) -> Result<bool, Refused> {
        let name = scan.word(Ends::Line, false);
        let Some(found) = keyword(name.as_bytes()) else {
            return Ok(false);
        };
        if scan.take() != Some(b'=') {
            return Ok(false);
        }
        let value = match scan.peek() {
            Some(quote @ (b'"' | b'\'')) => {
                scan.at += 1;
                scan.until(quote)
            }
            _ => scan.word(Ends::LineValue, false),
        };
        self.set(found, &value)?;
        Ok(true)
    }

    /// Reads an INI file: `name` or `name[section]`.
    ///
    /// # Errors
    /// [`Refused`].
    pub fn ini(&mut self, name: &str) -> Result<(), Refused> {
        let (file, section) = match name.split_once('[') {
            None => (name, None),
            Some((file, rest)) => match rest.split_once(']') {
                Some((section, _)) => (file, Some(section)),
                None => return Err(nowhere(format!("`{name}` names no section"))),
            },
        };
        let found = self.find_ini(file).ok_or_else(|| Refused {
            file: Some(self.folder.join(file)),
            reason: "there is no such INI file".into(),
        })?;
        if self.depth >= DEEPEST {
            return Err(Refused {
                file: Some(found),
                reason: "INI files read each other without end".into(),
            });
        }
        let text = std::fs::read(&found).map_err(|error| Refused {
            file: Some(found.clone()),
            reason: error.to_string(),
        })?;
        self.settings.files.push((found.clone(), text.clone()));
        self.depth += 1;
        let result = self.lines(&text, section, &found);
        self.depth -= 1;
        result
    }

    fn find_ini(&self, name: &str) -> Option<PathBuf> {
        let ending = name.rfind('.').map(|at| name.len() - at);
        let mut names = Vec::new();
        if ending.is_some_and(|length| length <= 4) {
            names.push(name.to_owned());
        }
        names.extend([format!("{name}.ini"), format!("{name}.INI")]);
        let folders = std::iter::once(self.folder.to_owned()).chain(
            self.settings
                .library
                .iter()
                .map(|path| self.folder.join(path)),
        );
        folders
            .flat_map(|folder| {
                names
                    .iter()
                    .map(move |name| folder.join(name))
                    .collect::<Vec<_>>()
            })
            .find(|path| path.is_file())
    }

    fn lines(&mut self, text: &[u8], wanted: Option<&str>, file: &Path) -> Result<(), Refused> {
        let mut scan = Scan::new(text);
        let mut counts = true;
        loop {
            scan.skip_white();
            let here = scan.at;
            let Some(first) = scan.take() else {
                return Ok(());
            };
            let wrong = |reason: String| Refused {
                file: Some(file.to_owned()),
                reason: format!("line {}: {reason}", line_of(text, here)),
            };
            match first {
                b'[' => {
                    let name = scan.until(b']');
                    counts = wanted.is_some_and(|wanted| wanted.eq_ignore_ascii_case(&name));
                }
                _ if !counts => scan.skip_line(),
                b';' | b'#' => scan.skip_line(),
                b'+' | b'-' => {
                    self.switch(&mut scan, first == b'+').map_err(wrong)?;
                }
                b'"' | b'\'' => {
                    let name = scan.until(first);
                    self.name(&name)?;
                }
                _ => {
                    let known = first.is_ascii_alphanumeric() || first == b'_';
                    if known {
                        scan.at = here;
                        match self.file_option(&mut scan) {
                            Ok(true) => {
                                scan.skip_line();
                                continue;
                            }
                            Ok(false) => {}
                            Err(refused) if refused.file.is_some() => return Err(refused),
                            Err(refused) => return Err(wrong(refused.reason)),
                        }
                        scan.at = here;
                    }
                    // Otherwise POV-Ray has eaten the first character.
                    let name = scan.word(Ends::LineValue, true);
                    if name.contains('=') {
                        return Err(wrong(format!("POV-Ray does not know `{}`", name.trim())));
                    }
                    self.name(&name)?;
                }
            }
        }
    }

    /// `Keyword = value, value` in a file. False: it is something else.
    fn file_option(&mut self, scan: &mut Scan<'_>) -> Result<bool, Refused> {
        let name = scan.word(Ends::Line, false);
        let Some(found) = keyword(name.as_bytes()) else {
            return Ok(false);
        };
        scan.skip_blanks();
        if scan.take() != Some(b'=') {
            return Ok(false);
        }
        scan.skip_blanks();
        if found.1 == Kind::Command {
            let value = scan.raw();
            self.set(found, &value)?;
            return Ok(true);
        }
        let mut smart = true;
        loop {
            let value = match scan.peek() {
                Some(quote @ (b'"' | b'\'')) => {
                    scan.at += 1;
                    scan.until(quote)
                }
                _ => scan.word(Ends::LineValue, smart),
            };
            self.set(found, &value)?;
            scan.skip_blanks();
            if scan.peek() != Some(b',') {
                return Ok(true);
            }
            scan.at += 1;
            scan.skip_blanks();
            smart = false;
        }
    }

    fn set(&mut self, found: Keyword, value: &str) -> Result<(), Refused> {
        if found.1 == Kind::Ini {
            return self.ini(value);
        }
        self.settings.set(found, value).map_err(nowhere)
    }

    fn switch(&mut self, scan: &mut Scan<'_>, on: bool) -> Result<(), String> {
        let letters = scan.word(Ends::Line, false);
        let quoted = match scan.peek() {
            Some(quote @ (b'"' | b'\'')) => {
                scan.at += 1;
                Some(scan.until(quote))
            }
            _ => None,
        };
        let unknown = || {
            Err(format!(
                "POV-Ray knows no switch `{}{letters}`",
                if on { '+' } else { '-' }
            ))
        };
        for rule in SWITCHES {
            let head = letters.as_bytes().get(..rule.letters.len());
            if !head.is_some_and(|head| head.eq_ignore_ascii_case(rule.letters.as_bytes())) {
                continue;
            }
            // The letters are ASCII, so this is a boundary.
            let mut parameter = &letters[rule.letters.len()..];
            if let Some(quoted) = &quoted {
                if !parameter.is_empty() {
                    return unknown();
                }
                parameter = quoted;
            }
            let follows = parameter.bytes().next().is_some_and(|byte| byte > b' ');
            if follows != rule.parameter.is_some() {
                continue;
            }
            if let Some(name) = rule.sign {
                self.settings.turn(name, on);
            }
            if let Some(found) = rule.parameter {
                self.settings.set(found, parameter)?;
                if found.1 == Kind::FileType {
                    self.picture_bits(&parameter[1..])?;
                }
            }
            return Ok(());
        }
        unknown()
    }

    /// What follows the letter in `+FN16`, `+FNg`.
    fn picture_bits(&mut self, rest: &str) -> Result<(), String> {
        if rest.is_empty() {
            return Ok(());
        }
        if rest.eq_ignore_ascii_case("g") {
            self.settings.turn("Grayscale_Output", true);
            return Ok(());
        }
        if !rest.bytes().all(|b| b.is_ascii_digit()) {
            return Err(format!("`{rest}` does not follow a file type"));
        }
        self.settings.set(("Bits_Per_Color", Kind::Whole), rest)
    }

    /// A word that is no option: a scene, a folder, or an INI file.
    fn name(&mut self, name: &str) -> Result<(), Refused> {
        let ending = name.rfind('.').map(|at| &name[at..]);
        if ending.is_some_and(|ending| ending.eq_ignore_ascii_case(".pov")) {
            return self.set(("Input_File_Name", Kind::Text), name);
        }
        if name.ends_with('/') {
            return self.set(("Library_Path", Kind::Library), name);
        }
        self.ini(name)
    }
}

fn nowhere(reason: String) -> Refused {
    Refused { file: None, reason }
}

fn line_of(text: &[u8], at: usize) -> usize {
    1 + text[..at.min(text.len())]
        .iter()
        .filter(|b| **b == b'\n')
        .count()
}

/// Where a word ends.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Ends {
    /// As a name: at a blank, a quote, `,;#[]=`.
    Line,
    /// As a value: brackets and `=` belong to it.
    LineValue,
}

struct Scan<'a> {
    text: &'a [u8],
    at: usize,
    /// In a file commas end words; on the command line they do not.
    commas_end: bool,
}

impl<'a> Scan<'a> {
    fn new(text: &'a [u8]) -> Self {
        Self {
            text,
            at: 0,
            commas_end: true,
        }
    }

    fn peek(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    fn take(&mut self) -> Option<u8> {
        let byte = self.peek()?;
        self.at += 1;
        Some(byte)
    }

    fn skip_blanks(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
    }

    fn skip_white(&mut self) {
        while matches!(self.peek(), Some(b' ' | b'\t' | b'\n' | b'\r')) {
            self.at += 1;
        }
    }

    fn skip_line(&mut self) {
        while let Some(byte) = self.take() {
            if matches!(byte, b'\n' | b'\r') {
                return;
            }
        }
    }

    /// Up to `end`, which is eaten; to the end of the text where it is missing.
    fn until(&mut self, end: u8) -> String {
        let from = self.at;
        while let Some(byte) = self.take() {
            if byte == end {
                return text_of(&self.text[from..self.at - 1]);
            }
        }
        text_of(&self.text[from..])
    }

    /// A word; `smart` guesses at texts with blanks that are not quoted.
    fn word(&mut self, ends: Ends, smart: bool) -> String {
        let from = self.at;
        let mut to_line_end = false;
        while let Some(byte) = self.peek() {
            if to_line_end {
                if matches!(byte, b';' | b'#' | b'\n' | b'\r') {
                    break;
                }
            } else if smart && matches!(byte, b' ' | b'\t') {
                if !self.blank_belongs_to_the_word() {
                    break;
                }
                to_line_end = true;
            } else if byte.is_ascii_whitespace()
                || byte == 0x0b
                || (byte == b',' && self.commas_end)
                || matches!(byte, b';' | b'#' | b'"' | b'\'')
                || (ends == Ends::Line && matches!(byte, b'[' | b']' | b'='))
            {
                break;
            }
            self.at += 1;
        }
        text_of(&self.text[from..self.at])
    }

    /// Looks ahead from a blank inside a value.
    fn blank_belongs_to_the_word(&self) -> bool {
        let mut ahead = Scan {
            text: self.text,
            at: self.at,
            commas_end: true,
        };
        ahead.skip_blanks();
        match ahead.take() {
            None | Some(b';' | b'#' | b',') => return false,
            Some(b'+' | b'-') => {
                if ahead.take().is_some_and(|b| b.is_ascii_alphabetic()) {
                    return false;
                }
                // From the blank again: an empty name, which is no keyword.
                return true;
            }
            Some(_) => {}
        }
        keyword(ahead.word(Ends::Line, false).as_bytes()).is_none()
    }

    /// A command of the shell: to the end of the line or a comment.
    fn raw(&mut self) -> String {
        let from = self.at;
        let mut quote = None;
        while let Some(byte) = self.peek() {
            match (byte, quote) {
                (b'\n' | b'\r', _) | (b';' | b'#', None) => break,
                (b'\\', _) => self.at += 1,
                (b'"' | b'\'', None) => quote = Some(byte),
                (b'"' | b'\'', Some(open)) if open == byte => quote = None,
                _ => {}
            }
            self.at += 1;
        }
        self.at = self.at.min(self.text.len());
        text_of(&self.text[from..self.at])
    }
}

fn text_of(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

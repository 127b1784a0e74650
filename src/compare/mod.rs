//! Comparing pictures and films: metrics, verdicts, difference pictures.
//!
//! Two paths → pairs ([`folders`]) → pictures ([`picture`]) → numbers
//! ([`metrics`]; how it looks, [`perceived`]; from frame to frame, [`flicker`]) →
//! a verdict by tolerances ([`verdict`]) → the film's totals ([`totals`]) → JSON,
//! words, tables ([`report`], [`words`], [`csv_table`],
//! [`junit`]).
//!
//! A is the plain film, B what is judged by it: no metric of a pair depends on
//! that, the flicker does.
//!
//! Two pictures in memory: [`pair::metrics`]. Two files: [`pair::compare_pair`].
//! Two films, read as they are needed: [`compare()`].

pub mod baseline;
pub mod csv_table;
mod filter;
pub mod flicker;
pub mod flip;
pub mod folders;
pub mod junit;
pub mod mask;
pub mod metrics;
pub mod moved;
pub mod pair;
pub mod panels;
pub mod perceived;
pub mod picture;
pub mod report;
pub mod seen;
pub mod ssim;
mod table;
pub mod totals;
pub mod verdict;
pub mod words;

#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use crate::frames::WriteError;
use folders::{Match, PairingError, Side};
use mask::Mask;
pub(crate) use pair::with_causes;
use pair::{PairReport, Pictures};
use totals::Totals;
use verdict::{Tolerances, Verdict};

/// Pairs in memory at once: more threads than these help little, and two 4K
/// pictures are a quarter of a gigabyte.
const PAIRS_AT_ONCE: usize = 8;

/// What is measured and tolerated, and what is written.
#[derive(Clone, Debug)]
pub struct Options {
    /// What is tolerated.
    pub tolerances: Tolerances,
    /// The pixels that count; all where there is none.
    pub mask: Option<Mask>,
    /// Are SSIM and FLIP measured?
    pub perception: bool,
    /// How far the eye is, for FLIP: pixels per degree of its field.
    pub pixels_per_degree: f32,
    /// The folder for difference pictures; made where it is not there.
    pub diff: Option<PathBuf>,
}

impl Default for Options {
    /// Nothing is tolerated, everything is measured, nothing is written.
    fn default() -> Self {
        Self {
            tolerances: Tolerances::default(),
            mask: None,
            perception: true,
            pixels_per_degree: flip::PIXELS_PER_DEGREE,
            diff: None,
        }
    }
}

/// A pair, or a picture without a partner.
#[derive(Debug)]
pub enum Entry {
    /// A pair, compared.
    Pair(Box<PairReport>),
    /// A picture without a partner: a failure.
    Missing {
        /// Its file name.
        name: String,
        /// Where it is not.
        from: Side,
    },
}

impl Entry {
    /// The file name.
    pub fn name(&self) -> &str {
        match self {
            Self::Pair(pair) => &pair.name,
            Self::Missing { name, .. } => name,
        }
    }

    /// How it ends.
    pub fn verdict(&self) -> Verdict {
        match self {
            Self::Pair(pair) => pair.verdict,
            Self::Missing { .. } => Verdict::Failed,
        }
    }
}

/// What came of it all.
#[derive(Debug)]
pub struct Comparison {
    /// Pairs and lone pictures, in the order of their names.
    pub entries: Vec<Entry>,
    /// What they come to.
    pub totals: Totals,
    /// The worst verdict.
    pub verdict: Verdict,
    /// Why nothing was compared at all, where that is so.
    pub reason: Option<String>,
    /// The first difference picture that could not be written; no further one
    /// was tried.
    pub diff_error: Option<WriteError>,
}

/// Why nothing was begun.
#[derive(Debug, thiserror::Error)]
pub enum CompareError {
    /// The difference pictures would lie among the pictures compared, and would
    /// be taken for frames the next time, or replace one now.
    #[error("difference pictures cannot be written among the pictures compared: {}", path.display())]
    DiffAmongFrames {
        /// The folder or file.
        path: PathBuf,
    },
    /// The folder for difference pictures cannot be made.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Compares two pictures, or two folders of frames. `each` is given every entry
/// as soon as it is there, in the order of the names.
///
/// Whatever is wrong with the pictures is in the verdicts, not an error.
///
/// # Errors
/// Where the difference pictures cannot be, or must not be, where they are
/// wanted.
pub fn compare(
    a: &Path,
    b: &Path,
    options: &Options,
    each: impl FnMut(&Entry),
) -> Result<Comparison, CompareError> {
    compare_matches(folders::pair(a, b), (a, b), options, each)
}

/// As [`compare()`], of what is already paired; the paths are where it is from.
///
/// # Errors
/// As of [`compare()`].
pub fn compare_matches(
    matches: Result<Vec<Match>, PairingError>,
    (a, b): (&Path, &Path),
    options: &Options,
    mut each: impl FnMut(&Entry),
) -> Result<Comparison, CompareError> {
    let matches = match matches {
        Ok(matches) => matches,
        Err(error) => return Ok(nothing_compared(&error)),
    };
    if let Some(folder) = &options.diff {
        prepare(folder, a, b, &matches)?;
    }
    let mut entries = Vec::with_capacity(matches.len());
    let mut diff_error = None;
    // The pictures before the first of the batch, for the flicker.
    let mut before: Option<Pictures> = None;
    let at_once = rayon::current_num_threads().clamp(1, PAIRS_AT_ONCE);
    for batch in matches.chunks(at_once) {
        // A full disk would be full for every frame.
        let diff = options.diff.as_deref().filter(|_| diff_error.is_none());
        let (reports, mut pictures): (Vec<_>, Vec<_>) = batch.par_iter().map(read).unzip();
        let done: Vec<_> = reports
            .into_par_iter()
            .enumerate()
            .map(|(k, report)| {
                let before = match k.checked_sub(1) {
                    Some(k) => pictures[k].as_ref(),
                    None => before.as_ref(),
                };
                judged(report, pictures[k].as_ref(), before, options, diff)
            })
            .collect();
        before = pictures.pop().flatten();
        for (entry, error) in done {
            each(&entry);
            entries.push(entry);
            diff_error = diff_error.or(error);
        }
    }
    let totals = Totals::of(&entries);
    Ok(Comparison {
        verdict: totals.verdict(),
        entries,
        totals,
        reason: None,
        diff_error,
    })
}

fn read(one: &Match) -> (Entry, Option<Pictures>) {
    match one {
        Match::Missing { name, from } => {
            let (name, from) = (name.clone(), *from);
            (Entry::Missing { name, from }, None)
        }
        Match::Pair { name, a, b } => {
            let (report, pictures) = pair::load(name.clone(), a.clone(), b.clone());
            (Entry::Pair(Box::new(report)), pictures)
        }
    }
}

fn judged(
    entry: Entry,
    pictures: Option<&Pictures>,
    before: Option<&Pictures>,
    options: &Options,
    diff: Option<&Path>,
) -> (Entry, Option<WriteError>) {
    match entry {
        Entry::Missing { .. } => (entry, None),
        Entry::Pair(report) => {
            let diff = diff.map(|folder| folder.join(diff_name(&report.name)));
            let (report, error) = pair::judge(*report, pictures, before, options, diff.as_deref());
            (Entry::Pair(Box::new(report)), error)
        }
    }
}

fn nothing_compared(error: &PairingError) -> Comparison {
    Comparison {
        entries: Vec::new(),
        totals: Totals::default(),
        verdict: match error {
            PairingError::Io { .. } => Verdict::Unreadable,
            PairingError::FileAndFolder { .. } | PairingError::Empty { .. } => {
                Verdict::NotComparable
            }
        },
        reason: Some(with_causes(error)),
        diff_error: None,
    }
}

/// `frame_0001.diff.png` of `frame_0001.png`, `frame_0001.exr.diff.png` of
/// `frame_0001.exr`.
fn diff_name(name: &str) -> String {
    format!("{}.diff.png", name.strip_suffix(".png").unwrap_or(name))
}

/// Makes the folder for difference pictures and sees that they harm nothing.
fn prepare(folder: &Path, a: &Path, b: &Path, matches: &[Match]) -> Result<(), CompareError> {
    let io = |source| WriteError::Io {
        path: folder.to_owned(),
        source,
    };
    std::fs::create_dir_all(folder).map_err(io)?;
    let real_folder = folder.canonicalize().map_err(io)?;
    for side in [a, b] {
        let Ok(side) = side.canonicalize() else {
            continue;
        };
        let written = |one: &Match| real_folder.join(diff_name(one.name()));
        if side == real_folder || matches.iter().any(|one| written(one) == side) {
            return Err(CompareError::DiffAmongFrames { path: side });
        }
    }
    Ok(())
}

//! One pair of pictures: read, made comparable, measured, judged.

use std::error::Error;
use std::path::{Path, PathBuf};

use decor_api::Size;
use rayon::join;

use super::Options;
use super::flicker::{Flicker, flicker};
use super::metrics::{Metrics, measure};
use super::moved::moved;
use super::panels;
use super::perceived::perceive;
use super::picture::{Encoding, Form, Picture, PictureError};
use super::verdict::Verdict;
use crate::frames::{WriteError, write_safely};

/// What came of a pair.
#[derive(Debug)]
pub struct PairReport {
    /// The file name; of two files of different names, the first's.
    pub name: String,
    /// The first picture.
    pub a: PathBuf,
    /// The second picture.
    pub b: PathBuf,
    /// How it ends.
    pub verdict: Verdict,
    /// Why, where it is not within.
    pub reasons: Vec<String>,
    /// What has to be known to read the numbers.
    pub notes: Vec<String>,
    /// The sizes, where they could be read.
    pub sizes: (Option<Size>, Option<Size>),
    /// The numbers, where the pictures are comparable.
    pub metrics: Option<Metrics>,
    /// What changes from the pair before to this one, where there is one and all
    /// four pictures are comparable.
    pub flicker: Option<Flicker>,
    /// The columns and rows by which B is A moved, where a failure is that.
    pub moved: Option<(i64, i64)>,
    /// The difference picture, where one was written.
    pub diff: Option<PathBuf>,
}

impl PairReport {
    /// Is there no difference at all?
    pub fn identical(&self) -> bool {
        self.metrics.as_ref().is_some_and(Metrics::identical)
    }
}

/// Two pictures in memory that can be compared: of one size and one encoding.
#[derive(Debug)]
pub struct Pictures {
    /// The first picture.
    pub a: Picture,
    /// The second picture.
    pub b: Picture,
}

/// All metrics of two pictures of one encoding, without files and verdicts.
/// Nothing where the sizes differ, the mask's included.
pub fn metrics(a: &Picture, b: &Picture, options: &Options) -> Option<Metrics> {
    let mask = options.mask.as_ref();
    let mut metrics = measure(a, b, &options.tolerances.levels(), mask)?;
    if options.perception {
        metrics.perceived = perceive(a, b, mask, options.pixels_per_degree);
    }
    Some(metrics)
}

/// Compares two picture files. Gives the report, and why the difference picture
/// could not be written, if it could not: the numbers are not lost with it.
pub fn compare_pair(
    name: String,
    a: PathBuf,
    b: PathBuf,
    options: &Options,
    diff: Option<&Path>,
) -> (PairReport, Option<WriteError>) {
    let (report, pictures) = load(name, a, b);
    judge(report, pictures.as_ref(), None, options, diff)
}

/// Reads a pair; the pictures, where they can be compared.
pub fn load(name: String, a: PathBuf, b: PathBuf) -> (PairReport, Option<Pictures>) {
    let mut report = PairReport {
        name,
        verdict: Verdict::Within,
        reasons: Vec::new(),
        notes: Vec::new(),
        sizes: (None, None),
        metrics: None,
        flicker: None,
        moved: None,
        diff: None,
        a,
        b,
    };
    let pictures = join(|| Picture::read(&report.a), || Picture::read(&report.b));
    let (a, b) = match pictures {
        (Ok(a), Ok(b)) => (a, b),
        (a, b) => {
            report.sizes = (size(&a), size(&b));
            report.verdict = Verdict::Unreadable;
            for (path, error) in [(&report.a, a.err()), (&report.b, b.err())] {
                if let Some(error) = error {
                    let why = with_causes(&error);
                    report.reasons.push(format!("{}: {why}", path.display()));
                }
            }
            return (report, None);
        }
    };
    report.sizes = (Some(a.size), Some(b.size));
    report.notes = notes(&a, &b);
    if a.size != b.size || a.origin != b.origin {
        report.verdict = Verdict::NotComparable;
        report.reasons.push(why_not(&a, &b));
        return (report, None);
    }
    let (a, b) = in_one_encoding(a, b);
    (report, Some(Pictures { a, b }))
}

/// Measures and judges a pair that was read; `before` is the pair before it, if
/// it can be compared.
pub fn judge(
    mut report: PairReport,
    pictures: Option<&Pictures>,
    before: Option<&Pictures>,
    options: &Options,
    diff: Option<&Path>,
) -> (PairReport, Option<WriteError>) {
    let Some(Pictures { a, b }) = pictures else {
        return (report, None);
    };
    let Some(metrics) = metrics(a, b, options).filter(|metrics| metrics.pixels > 0) else {
        report.verdict = Verdict::NotComparable;
        report.reasons.push(nothing_counts(a, options));
        return (report, None);
    };
    let tolerances = &options.tolerances;
    (report.verdict, report.reasons) = tolerances.judge(&metrics);
    if report.verdict == Verdict::Failed && metrics.differing > 0 {
        report.moved = moved(a, b, tolerances.fail.level);
    }
    report.flicker = before.and_then(|before| {
        let (before, now) = ((&before.a, &before.b), (a, b));
        flicker(before, now, tolerances.fail.level, options.mask.as_ref())
    });
    report.metrics = Some(metrics);
    let mut failed = None;
    if let Some(path) = diff {
        let written = panels::png(a, b)
            .map_err(|source| WriteError::Png {
                path: path.to_owned(),
                source,
            })
            .and_then(|bytes| write_safely(path, &bytes));
        match written {
            Ok(()) => report.diff = Some(path.to_owned()),
            Err(error) => failed = Some(error),
        }
    }
    (report, failed)
}

fn nothing_counts(picture: &Picture, options: &Options) -> String {
    match &options.mask {
        Some(mask) if mask.size != picture.size => {
            let (mask, size) = (mask.size, picture.size);
            format!(
                "the mask has {}×{} pixels, the pictures have {}×{}",
                mask.width, mask.height, size.width, size.height
            )
        }
        Some(_) => "the mask has no white pixel".to_owned(),
        None => "the pictures have no pixels".to_owned(),
    }
}

fn size(picture: &Result<Picture, PictureError>) -> Option<Size> {
    picture.as_ref().ok().map(|picture| picture.size)
}

/// An error's message and those of its causes, in one line.
pub(crate) fn with_causes(error: &dyn Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let more = error.to_string();
        if !words.ends_with(&more) {
            words = format!("{words}: {more}");
        }
        cause = error.source();
    }
    words
}

/// Where one is display-referred and the other linear, both as a display takes
/// them: that is what is seen.
fn in_one_encoding(a: Picture, b: Picture) -> (Picture, Picture) {
    match (a.form.encoding(), b.form.encoding()) {
        (Encoding::Display, Encoding::Linear) => {
            let b = b.as_display(a.has_alpha);
            (a, b)
        }
        (Encoding::Linear, Encoding::Display) => (a.as_display(b.has_alpha), b),
        _ => (a, b),
    }
}

fn why_not(a: &Picture, b: &Picture) -> String {
    if a.size != b.size {
        let (a, b) = (a.size, b.size);
        return format!(
            "A has {}×{} pixels, B has {}×{}",
            a.width, a.height, b.width, b.height
        );
    }
    let ((ax, ay), (bx, by)) = (a.origin, b.origin);
    format!("A begins at ({ax}, {ay}) of its frame, B at ({bx}, {by})")
}

fn notes(a: &Picture, b: &Picture) -> Vec<String> {
    let mut notes = Vec::new();
    match (a.form, b.form) {
        (Form::Png8, Form::Png16) | (Form::Png16, Form::Png8) => {
            notes.push(
                "8 bits against 16: compared as numbers 0..1, where rounding to 8 bits \
                 alone is up to 0.00196"
                    .to_owned(),
            );
        }
        (Form::Exr, Form::Png8 | Form::Png16) | (Form::Png8 | Form::Png16, Form::Exr) => {
            let linear = if a.form == Form::Exr { 'A' } else { 'B' };
            notes.push(format!(
                "{linear} is linear, the other is not: compared after sRGB's transfer \
                 function, cut to 0..1"
            ));
        }
        _ => {}
    }
    let mut only_one = |what: &str, in_a: bool, in_b: bool| {
        if in_a != in_b {
            let side = if in_a { 'A' } else { 'B' };
            notes.push(format!("only {side} has {what}: it is not compared"));
        }
    };
    only_one("alpha", a.has_alpha, b.has_alpha);
    only_one("depth", a.depth.is_some(), b.depth.is_some());
    notes
}

//! One pair of pictures: read, made comparable, measured, judged.

use std::error::Error;
use std::path::{Path, PathBuf};

use decor_api::Size;
use rayon::join;

use super::metrics::{Metrics, measure};
use super::panels;
use super::picture::{Encoding, Form, Picture, PictureError};
use super::verdict::{Tolerances, Verdict};
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
    /// The difference picture, where one was written.
    pub diff: Option<PathBuf>,
}

impl PairReport {
    /// Is there no difference at all?
    pub fn identical(&self) -> bool {
        self.metrics.as_ref().is_some_and(Metrics::identical)
    }
}

/// Compares two picture files. Gives the report, and why the difference picture
/// could not be written, if it could not: the numbers are not lost with it.
pub fn compare_pair(
    name: String,
    a: PathBuf,
    b: PathBuf,
    tolerances: &Tolerances,
    diff: Option<&Path>,
) -> (PairReport, Option<WriteError>) {
    let mut report = PairReport {
        name,
        verdict: Verdict::Within,
        reasons: Vec::new(),
        notes: Vec::new(),
        sizes: (None, None),
        metrics: None,
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
    let (a, b) = in_one_encoding(a, b);
    let metrics = measure(&a, &b, &tolerances.levels());
    let Some(metrics) = metrics.filter(|_| a.origin == b.origin) else {
        report.verdict = Verdict::NotComparable;
        report.reasons.push(why_not(&a, &b));
        return (report, None);
    };
    (report.verdict, report.reasons) = tolerances.judge(&metrics);
    report.metrics = Some(metrics);
    let mut failed = None;
    if let Some(path) = diff {
        let written = panels::png(&a, &b)
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

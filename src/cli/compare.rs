//! `decor compare`: two pictures, or two folders of frames.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::Status;
use crate::compare::baseline::{self, Change, UpdateError};
use crate::compare::mask::Mask;
use crate::compare::verdict::{Limit, Preset, Tolerances, Verdict};
use crate::compare::{
    CompareError, Comparison, Options, compare_matches, csv_table, flip, folders, junit, report,
    with_causes, words,
};
use crate::frames::write_safely;
use crate::report::{Machine, html};

const EXAMPLES: &str = "\
Examples:
  decor compare a.png b.png
      Any difference fails.
  decor compare full/ fast/ --fail 0.004 --fail-percent 0.1 --hard-fail 0.1
      A frame fails where more than 0.1 % of its pixels differ by more than one
      step of 8 bits, or a single one by more than a tenth.
  decor compare full/ fast/ --like blender --diff differences/ --json
  decor compare fast/ --baseline-dir references/ --junit compare.xml
      The frames against references that are kept. With --update what differs is
      shown, the references are replaced, and the run fails this once.

What is compared: red, green and blue, and alpha where both pictures have it, as
numbers: 0..1 of a PNG whether of 8 or 16 bits, linear values of an OpenEXR; the
depth where both have it. A PNG against an OpenEXR: both as sRGB. NaN is always a
difference. SSIM (Gaussian windows, sigma 1.5, mean of red, green and blue) and
FLIP (LDR-FLIP, mean) are of what is seen: linear pictures through sRGB's transfer
function, cut to 0..1; alpha and depth left out.
Flicker: a pixel changes where it differs by more than --fail from the same pixel
of the frame before. Counted in A, in B, in B only (what B adds) and in A only.
Frames of folders are paired by their names, then without the ending
(frame_0001.png, frame_0001.exr). A frame without a partner fails.

Exit status: 0 within, 1 warning, 2 failed, 3 not comparable (sizes differ, an
empty folder), 4 unreadable; the worst wins. 5 could not write, 64 wrong usage.";

/// Compare two pictures, or two folders of frames.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArgs {
    /// A picture (PNG, OpenEXR), or a folder of them: the plain film.
    a: PathBuf,
    /// What is compared with it, of the same kind.
    #[arg(required_unless_present = "baseline_dir")]
    b: Option<PathBuf>,
    /// Compare the folder A with the references in DIR, which take A's place.
    #[arg(long, value_name = "DIR", conflicts_with = "b")]
    baseline_dir: Option<PathBuf>,
    /// Show what differs, then replace the references by it and fail once.
    #[arg(long)]
    update: bool,
    /// The tolerances of somebody else's tests; options beside it win. blender:
    /// --fail 0.016 --fail-percent 1; idiff: --fail 1e-6 --warn 1e-6.
    #[arg(long, value_name = "WHOM")]
    like: Option<Preset>,
    /// A pixel differs where a channel differs by more than this [default: 0].
    #[arg(long, value_name = "T", value_parser = tolerance)]
    fail: Option<f64>,
    /// Fail where more than this many percent of a frame's pixels differ
    /// [default: 0].
    #[arg(long, value_name = "P", value_parser = percent)]
    fail_percent: Option<f64>,
    /// Fail where a single pixel differs by more than this.
    #[arg(long, value_name = "T", value_parser = tolerance)]
    hard_fail: Option<f64>,
    /// The relative difference of depth that takes the place of --fail, where
    /// both have a depth ("inf": depth is not judged) [default: as --fail].
    #[arg(long, value_name = "R", value_parser = tolerance)]
    fail_depth: Option<f64>,
    /// Warn of pixels that differ by more than this [default: no warning; 0 with
    /// --warn-percent].
    #[arg(long, value_name = "T", value_parser = tolerance)]
    warn: Option<f64>,
    /// Warn where more than this many percent of a frame's pixels differ by more
    /// than --warn [default: 0 with --warn].
    #[arg(long, value_name = "P", value_parser = percent)]
    warn_percent: Option<f64>,
    /// Warn where a single pixel differs by more than this.
    #[arg(long, value_name = "T", value_parser = tolerance)]
    hard_warn: Option<f64>,
    /// Only pixels that are white in PICTURE count.
    #[arg(long, value_name = "PICTURE")]
    mask: Option<PathBuf>,
    /// Leave out SSIM and FLIP, which take most of the time.
    #[arg(long)]
    no_perception: bool,
    /// How far the eye is, for FLIP: pixels per degree of its field.
    #[arg(long, value_name = "N", default_value_t = flip::PIXELS_PER_DEGREE, value_parser = per_degree)]
    ppd: f32,
    /// Write difference pictures into DIR: A, B and |A − B| ×16 side by side.
    #[arg(long, value_name = "DIR")]
    diff: Option<PathBuf>,
    /// Write JUnit XML, a test case for each frame.
    #[arg(long, value_name = "FILE")]
    junit: Option<PathBuf>,
    /// Write a page with the numbers and the worst frames, to look at in a browser.
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// How the table is written.
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// One JSON object a line: every pair, then the summary (--format json).
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// How the table is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// For a terminal: the worst twenty.
    Text,
    /// For an issue or a page: all pairs that differ.
    Markdown,
    /// One object a line: every pair, then the summary.
    Json,
    /// For a spreadsheet: every pair, then the film.
    Csv,
}

pub(super) fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("it must be a number of 0 or more".to_owned()),
    }
}

pub(super) fn percent(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=100.0).contains(&value) => Ok(value),
        _ => Err("it must be a number from 0 to 100".to_owned()),
    }
}

/// The filters grow with it: some hundred is a wall-sized display far away.
fn per_degree(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(value) if (1.0..=1000.0).contains(&value) => Ok(value),
        _ => Err("it must be a number from 1 to 1000".to_owned()),
    }
}

impl CompareArgs {
    /// The two sides: the references are A.
    fn sides(&self) -> (&Path, &Path) {
        match (&self.baseline_dir, &self.b) {
            (Some(references), _) => (references, &self.a),
            // clap sees to it that one of them is there.
            (None, b) => (&self.a, b.as_deref().unwrap_or(&self.a)),
        }
    }

    fn format(&self) -> Format {
        if self.json { Format::Json } else { self.format }
    }

    fn tolerances(&self) -> Tolerances {
        let like = self.like.map(Preset::tolerances).unwrap_or_default();
        let warns = self.warn.is_some() || self.warn_percent.is_some();
        let warn = like.warn.unwrap_or(Limit {
            level: 0.0,
            percent: 0.0,
        });
        let fail = self.fail.unwrap_or(like.fail.level);
        Tolerances {
            fail: Limit {
                level: fail,
                percent: self.fail_percent.unwrap_or(like.fail.percent),
            },
            hard_fail: self.hard_fail.or(like.hard_fail),
            fail_depth: self.fail_depth.unwrap_or(fail),
            warn: (warns || like.warn.is_some()).then(|| Limit {
                level: self.warn.unwrap_or(warn.level),
                percent: self.warn_percent.unwrap_or(warn.percent),
            }),
            hard_warn: self.hard_warn.or(like.hard_warn),
        }
    }
}

/// Compares and writes the report to `out`; gives the exit status.
pub fn run(args: &CompareArgs, out: &mut dyn Write) -> u8 {
    match try_run(args, out) {
        Ok(status) => status,
        Err((status, why)) => {
            eprintln!("decor compare: {why}");
            status
        }
    }
}

/// An exit status, and why.
type Ended = (u8, String);

fn ended(status: u8, error: &dyn std::error::Error) -> Ended {
    (status, with_causes(error))
}

fn try_run(args: &CompareArgs, out: &mut dyn Write) -> Result<u8, Ended> {
    let (a, b) = args.sides();
    // clap lets `requires` pass where what is required conflicts with B.
    if args.update && args.baseline_dir.is_none() {
        let why = "--update replaces references: it needs --baseline-dir".to_owned();
        return Err((Status::Usage.code(), why));
    }
    if args.baseline_dir.is_some() && baseline::same_folder(a, b) {
        let why = "the references and the frames are one folder: they are always equal".to_owned();
        return Err((Status::Usage.code(), why));
    }
    let mask = match &args.mask {
        Some(path) => Some(Mask::read(path).map_err(|error| {
            let why = with_causes(&error);
            let words = format!("the mask {}: {why}", path.display());
            (Verdict::Unreadable.status(), words)
        })?),
        None => None,
    };
    let options = Options {
        tolerances: args.tolerances(),
        mask,
        perception: !args.no_perception,
        pixels_per_degree: args.ppd,
        diff: args.diff.clone(),
    };
    let matches = if args.update {
        baseline::pair_for_update(a, b)
    } else {
        folders::pair(a, b)
    };
    // The verdict is worth having where the report cannot be written, too.
    let mut written: io::Result<()> = Ok(());
    let mut comparison = compare_matches(matches, (a, b), &options, |entry| {
        if args.format() == Format::Json && written.is_ok() {
            written = report::entry_line(entry, &options.tolerances)
                .map_err(io::Error::from)
                .and_then(|line| writeln!(out, "{line}"));
        }
    })
    .map_err(|error| {
        let status = match &error {
            CompareError::DiffAmongFrames { .. } => Status::Usage,
            CompareError::Write(_) => Status::Write,
        };
        ended(status.code(), &error)
    })?;
    if let Some(path) = &args.junit {
        write_junit(path, &comparison, b)?;
    }
    if let Some(path) = &args.html {
        write_html(path, &comparison, a, b)?;
    }
    let changes = if args.update && comparison.reason.is_none() {
        Some(update(&mut comparison, a, b))
    } else {
        None
    };
    let changed = match &changes {
        Some(Ok(changes)) => changes.as_slice(),
        _ => &[],
    };
    let written = written
        .and_then(|()| write_report(args.format(), &comparison, args, &options, changed, out));
    if let Some(Err(ended)) = changes {
        return Err(ended);
    }
    if let Some(error) = &comparison.diff_error {
        return Err(ended(Status::Write.code(), error));
    }
    match written {
        // Whoever reads may have read enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(ended(Status::Write.code(), &error))
        }
        _ => Ok(comparison.verdict.status()),
    }
}

fn write_junit(path: &Path, comparison: &Comparison, frames: &Path) -> Result<(), Ended> {
    let name = frames.to_string_lossy();
    let xml = junit::xml(comparison, &name).map_err(|error| ended(Status::Write.code(), &error))?;
    write_safely(path, xml.as_bytes()).map_err(|error| ended(Status::Write.code(), &error))
}

/// Frames in the page: two pictures each, and the worst are what is looked for.
const HTML_FRAMES: usize = 12;

fn write_html(path: &Path, comparison: &Comparison, a: &Path, b: &Path) -> Result<(), Ended> {
    let label = |side: &Path| side.to_string_lossy().into_owned();
    let (plain, other) = (html::Run::read(&label(a), a), html::Run::read(&label(b), b));
    let page = html::Page {
        title: format!("{} against {}", label(b), label(a)),
        numbers: Vec::new(),
        shown: vec![html::Shown {
            label: label(b),
            comparison,
            frames: HTML_FRAMES,
        }],
        curve: html::curve(comparison, plain.as_ref(), other.as_ref()),
        table: None,
        runs: plain.into_iter().chain(other).collect(),
        machine: Machine::here(),
    };
    let text = page
        .html()
        .map_err(|error| ended(Verdict::Unreadable.status(), &error))?;
    write_safely(path, text.as_bytes()).map_err(|error| ended(Status::Write.code(), &error))
}

/// Replaces the references; where that changes any, the run has failed, so that
/// no change passes without somebody having looked.
fn update(comparison: &mut Comparison, a: &Path, b: &Path) -> Result<Vec<Change>, Ended> {
    let changes = baseline::update(comparison, a, b).map_err(|error| {
        let status = match &error {
            UpdateError::Frame { .. } => Verdict::Unreadable.status(),
            UpdateError::Write(_) => Status::Write.code(),
        };
        ended(status, &error)
    })?;
    if !changes.is_empty() {
        comparison.verdict = Verdict::Failed;
    }
    Ok(changes)
}

fn write_report(
    format: Format,
    comparison: &Comparison,
    args: &CompareArgs,
    options: &Options,
    changes: &[Change],
    out: &mut dyn Write,
) -> io::Result<()> {
    let (a, b) = args.sides();
    match format {
        Format::Text => words::write(comparison, out)?,
        Format::Markdown => words::write_markdown(comparison, out)?,
        Format::Csv => csv_table::write(comparison, out)?,
        Format::Json => {
            for change in changes {
                writeln!(out, "{}", report::change_line(change)?)?;
            }
            let line = report::summary_line(a, b, comparison, &options.tolerances)?;
            writeln!(out, "{line}")?;
        }
    }
    if !changes.is_empty() {
        let words = changed_words(changes, a);
        match format {
            Format::Text => writeln!(out, "{words}")?,
            // What is on stdout is data.
            _ => eprintln!("{words}"),
        }
    }
    out.flush()
}

fn changed_words(changes: &[Change], references: &Path) -> String {
    let mut words = String::new();
    for Change { action, name } in changes {
        words += &format!("{name}: {}\n", action.words());
    }
    format!(
        "{words}updated: {} references in {} were changed. This run fails so that nobody misses \
         it: look at them, keep them, and run again.",
        changes.len(),
        references.display()
    )
}

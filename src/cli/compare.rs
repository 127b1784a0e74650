//! `decor compare`: two pictures, or two folders of frames.

use std::io::Write;
use std::path::PathBuf;

use super::Status;
use crate::compare::verdict::{Limit, Tolerances};
use crate::compare::{CompareError, Options, compare, report, words};

const EXAMPLES: &str = "\
Examples:
  decor compare a.png b.png
      Any difference fails.
  decor compare full/ fast/ --fail 0.004 --fail-percent 0.1 --hard-fail 0.1
      A frame fails where more than 0.1 % of its pixels differ by more than one
      step of 8 bits, or a single one by more than a tenth.
  decor compare full/ fast/ --fail 0.02 --warn 0.004 --diff differences/ --json

What is compared: red, green and blue, and alpha where both pictures have it, as
numbers: 0..1 of a PNG whether of 8 or 16 bits, linear values of an OpenEXR.
A PNG against an OpenEXR: both as sRGB. NaN is always a difference.
Frames of folders are paired by their names, then without the ending
(frame_0001.png, frame_0001.exr). A frame without a partner fails.

Exit status: 0 within, 1 warning, 2 failed, 3 not comparable (sizes differ, an
empty folder), 4 unreadable; the worst wins. 5 could not write, 64 wrong usage.";

/// Compare two pictures, or two folders of frames.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct CompareArgs {
    /// A picture (PNG, OpenEXR), or a folder of them.
    a: PathBuf,
    /// What it is compared with, of the same kind.
    b: PathBuf,
    /// A pixel differs where a channel differs by more than this.
    #[arg(long, value_name = "T", default_value = "0", value_parser = tolerance)]
    fail: f64,
    /// Fail where more than this many percent of a frame's pixels differ.
    #[arg(long, value_name = "P", default_value = "0", value_parser = percent)]
    fail_percent: f64,
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
    /// Write difference pictures into DIR: A, B and |A − B| ×16 side by side.
    #[arg(long, value_name = "DIR")]
    diff: Option<PathBuf>,
    /// One JSON object a line: every pair, then the summary.
    #[arg(long)]
    json: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 => Ok(value),
        _ => Err("it must be a number of 0 or more".to_owned()),
    }
}

fn percent(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (0.0..=100.0).contains(&value) => Ok(value),
        _ => Err("it must be a number from 0 to 100".to_owned()),
    }
}

impl CompareArgs {
    fn options(&self) -> Options {
        let warns = self.warn.is_some() || self.warn_percent.is_some();
        Options {
            tolerances: Tolerances {
                fail: Limit {
                    level: self.fail,
                    percent: self.fail_percent,
                },
                hard_fail: self.hard_fail,
                fail_depth: self.fail_depth.unwrap_or(self.fail),
                warn: warns.then(|| Limit {
                    level: self.warn.unwrap_or(0.0),
                    percent: self.warn_percent.unwrap_or(0.0),
                }),
                hard_warn: self.hard_warn,
            },
            diff: self.diff.clone(),
            ..Options::default()
        }
    }
}

/// Compares and writes the report to `out`; gives the exit status.
pub fn run(args: &CompareArgs, out: &mut dyn Write) -> u8 {
    let options = args.options();
    let tolerances = &options.tolerances;
    // The verdict is worth having where the report cannot be written, too.
    let mut written: std::io::Result<()> = Ok(());
    let result = compare(&args.a, &args.b, &options, |entry| {
        if args.json && written.is_ok() {
            written = report::entry_line(entry, tolerances)
                .map_err(std::io::Error::from)
                .and_then(|line| writeln!(out, "{line}"));
        }
    });
    let comparison = match result {
        Ok(comparison) => comparison,
        Err(error) => {
            let status = match &error {
                CompareError::DiffAmongFrames { .. } => Status::Usage,
                CompareError::Write(_) => Status::Write,
            };
            complain(&error);
            return status.code();
        }
    };
    let written = written.and_then(|()| {
        if args.json {
            let line = report::summary_line(&args.a, &args.b, &comparison, tolerances)?;
            writeln!(out, "{line}")?;
        } else {
            words::write(&comparison, out)?;
        }
        out.flush()
    });
    if let Some(error) = &comparison.diff_error {
        complain(error);
        return Status::Write.code();
    }
    match written {
        Ok(()) => comparison.verdict.status(),
        // Whoever reads has read enough.
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => comparison.verdict.status(),
        Err(error) => {
            complain(&error);
            Status::Write.code()
        }
    }
}

fn complain(error: &dyn std::error::Error) {
    eprintln!("decor compare: {}", crate::compare::with_causes(error));
}

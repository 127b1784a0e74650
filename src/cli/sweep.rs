//! `decor sweep`: the trade between speed and accuracy, measured.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{Args, ValueEnum};
use decor_api::PictureFormat;

use super::film_args::{self, FilmArgs, Period, cancelled_by_ctrl_c};
use super::{Failure, Status, compare, plain, print_json};
use crate::frames::write_safely;
use crate::job::Job;
use crate::plan::{Mode, Price};
use crate::segmentation::Measure;
use crate::sweep::{Against, Antialiasing, Errors, Follow, Grid, Sweep, SweepError, Swept, table};

/// Measure what settings win and what they cost.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor sweep plane.anim -o sweep
  decor sweep ladybirds.anim -o sweep --thresholds 1,2,4,8 --periods auto,5,25
  decor sweep scene.anim -o sweep --modes equivalent --antialias as-is,off --runs 3

Frame by frame is rendered once, then every combination of the lists that differs
from the others, one at a time; the modes full and exact have no threshold. Settings
that come to the same plan are rendered once. DIR has then report.html, to look at,
and sweep.json; with the frames and times in DIR/cache, a sweep that was interrupted
goes on, and a larger one begins with what is there. Reading the film is not counted,
planning it is. Run it on a quiet machine.")]
pub struct SweepArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// Where the report goes, and all frames.
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Thresholds in pixels.
    #[arg(long, value_name = "PX,…", value_delimiter = ',', default_values_t = [0.5, 1.0, 2.0, 4.0],
          value_parser = film_args::not_negative)]
    thresholds: Vec<f64>,
    /// Frames per décor: numbers, or auto.
    #[arg(long, value_name = "N|auto,…", value_delimiter = ',', default_value = "auto",
          value_parser = film_args::period)]
    periods: Vec<Period>,
    /// Measures of motion.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Measure::Bound])]
    measures: Vec<Measure>,
    /// Modes.
    #[arg(long, value_enum, value_delimiter = ',',
          default_values_t = [Mode::Full, Mode::Exact, Mode::Equivalent, Mode::Preview])]
    modes: Vec<Mode>,
    /// With the film's antialiasing, and without any.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Antialiasing::AsIs])]
    antialias: Vec<Antialiasing>,
    /// What all is measured against: one plain call of the stock renderer, or
    /// decor's pool.
    #[arg(long, value_enum, default_value_t = Against::Stock)]
    against: Against,
    /// Use décors also where frame by frame would be cheaper.
    #[arg(long)]
    no_fallback: bool,
    /// Runs of each setting: their medians count.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..100))]
    runs: u16,
    /// Pixels count as changed, for the flicker, where a channel differs by more
    /// than this.
    #[arg(long, value_name = "T", default_value_t = 0.016, value_parser = compare::tolerance)]
    level: f64,
    /// Calls of the renderer at once [default: chosen].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// What is printed.
    #[arg(long, value_enum, default_value_t = Format::Markdown)]
    format: Format,
    /// One JSON object a line on stdout (--format json).
    #[arg(long, conflicts_with = "format")]
    json: bool,
}

/// What is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// A table.
    Markdown,
    /// One object a line: every setting, then the summary.
    Json,
    /// A line for each setting.
    Csv,
    /// The page.
    Html,
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Job(error) => error.into(),
            SweepError::Compare(error) => Self::internal(error),
            SweepError::Page(error) => Self::internal(error),
            SweepError::Json(error) => Self::internal(error),
        }
    }
}

/// Says on stderr what is going on.
struct Told {
    quiet: bool,
}

impl Follow for Told {
    fn begins(&self, what: &str, kept: bool) {
        if !self.quiet && !kept {
            eprintln!("decor: rendering {what}");
        }
    }

    fn ends(&self, what: &str, price: Price, errors: &Errors) {
        if !self.quiet {
            let (wall, flip) = (price.wall_s, errors.flip);
            eprintln!("decor: {what}: {wall:.2} s, FLIP {flip:.5}");
        }
    }
}

/// Runs the verb.
pub fn run(args: &SweepArgs, quiet: bool) -> Result<Status, Failure> {
    if plain::names_plain(&args.film) {
        return Err(Failure::usage(
            "a plain POV-Ray scene is rendered frame by frame: there is nothing to trade",
        ));
    }
    let cancel = cancelled_by_ctrl_c();
    let film = args.film.read()?;
    let without = if args.antialias.contains(&Antialiasing::Off) {
        let film = film.clone().without_antialiasing();
        Some(args.film.stage_of(film, &cancel)?)
    } else {
        None
    };
    let stage = args.film.stage_of(film, &cancel)?;
    let sweep = Sweep {
        stage: &stage,
        plain: without.as_ref(),
        job: Job {
            film: args.film.film.display().to_string(),
            out: args.out.clone(),
            format: PictureFormat::Png,
            jobs: args.jobs.map(usize::from),
            seed: 0,
            resume: false,
            keep: None,
            timeout: args.film.timeout(),
            cancel: Arc::clone(&cancel),
        },
        grid: Grid {
            thresholds_px: args.thresholds.clone(),
            periods: args
                .periods
                .iter()
                .map(|period| match period {
                    Period::Auto => None,
                    Period::Frames(n) => Some(*n),
                })
                .collect(),
            measures: args.measures.clone(),
            modes: args.modes.clone(),
            antialias: args.antialias.clone(),
        },
        frames: args.film.wanted(&stage.film),
        against: args.against,
        runs: usize::from(args.runs),
        level: args.level,
        fallback: !args.no_fallback,
    };
    let swept = sweep.run(&Told { quiet })?;
    let page = swept.html()?;
    let json = swept.json().map_err(Failure::internal)?;
    write_safely(&args.out.join("sweep.json"), json.as_bytes())?;
    let report = args.out.join("report.html");
    write_safely(&report, page.as_bytes())?;
    print(args, &swept, &page)?;
    if !quiet {
        eprintln!("decor: look at {}", report.display());
    }
    Ok(Status::Done)
}

fn print(args: &SweepArgs, swept: &Swept<'_>, page: &str) -> Result<(), Failure> {
    use std::io::Write as _;
    let mut out = std::io::stdout().lock();
    let format = if args.json { Format::Json } else { args.format };
    let written = match format {
        Format::Markdown => table::write_markdown(swept, &mut out),
        Format::Csv => table::write_csv(swept, &mut out),
        Format::Html => out.write_all(page.as_bytes()).and_then(|()| out.flush()),
        Format::Json => {
            drop(out);
            for k in 0..swept.settings.len() {
                print_json(&swept.setting_line(k))?;
            }
            return print_json(&swept.line());
        }
    };
    match written {
        // Whoever reads may have read enough.
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::write(Path::new("stdout"), error))
        }
        _ => Ok(()),
    }
}

//! `decor tune`: the fastest setting that keeps a quality.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use decor_api::PictureFormat;
use serde::Serialize;

use super::film_args::{self, FilmArgs, Period, cancelled_by_ctrl_c};
use super::{Failure, Status, compare, plain, print_json};
use crate::frames::write_safely;
use crate::job::{Job, Unwatched};
use crate::plan::{Mode, Wishes};
use crate::report::{Clock, Summary};
use crate::segmentation::Measure;
use crate::tune::target::Target;
use crate::tune::{Probe, Sureness, Tune, Tuned};

/// Find the fastest setting that keeps a quality.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor tune plane.anim --target flip=0.02
  decor tune ladybirds.anim --target psnr=35 --render -o frames
  decor tune ladybirds.anim --target motion=0.5

Targets: flip (the film's mean), rms, flicker (the share, 0..1, of the pixels that
change from frame to frame in this film only), max (the largest difference) and motion
(pixels that anything in a décor moves at most) are not to be exceeded; psnr (dB) and
ssim are to be reached. Numbers are those of `decor compare --fail 0.016` over the whole
film.

A few frames are rendered for at most five thresholds, plainly and merged: where
periods begin, in between and where they end. motion is a matter of the plan alone.
What is found is the cheapest by predicted seconds; where nothing holds, the mode exact.")]
pub struct TuneArgs {
    #[command(flatten)]
    film: FilmArgs,
    /// The quality: flip, psnr, ssim, rms, max, flicker or motion.
    #[arg(long, value_name = "METRIC=VALUE")]
    target: Target,
    /// What the frames promise beside it: equivalent, or preview, where layers cast
    /// no shadows on each other.
    #[arg(long, value_enum, default_value_t = Mode::Equivalent)]
    mode: Mode,
    /// Which measure of motion decides.
    #[arg(long, value_enum, default_value_t = Measure::Bound)]
    measure: Measure,
    /// Frames per décor: a number, or auto.
    #[arg(long, value_name = "N|auto", default_value = "auto", value_parser = film_args::period)]
    period: Period,
    /// The smallest threshold that is tried.
    #[arg(long, value_name = "PX", default_value_t = 0.0625, value_parser = film_args::positive)]
    threshold_min: f64,
    /// The largest one.
    #[arg(long, value_name = "PX", default_value_t = 16.0, value_parser = film_args::positive)]
    threshold_max: f64,
    /// Pixels count as changed, for the flicker, where a channel differs by more
    /// than this.
    #[arg(long, value_name = "T", default_value_t = 0.016, value_parser = compare::tolerance)]
    level: f64,
    /// Calls of the renderer at once [default: chosen].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Use décors also where frame by frame would be cheaper.
    #[arg(long)]
    no_fallback: bool,
    /// Render the film with what was found.
    #[arg(long, requires = "out")]
    render: bool,
    /// Where its frames go.
    #[arg(short, long, value_name = "DIR", requires = "render")]
    out: Option<PathBuf>,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// A threshold that was tried.
#[derive(Serialize)]
#[serde(tag = "type", rename = "probe")]
struct ProbeLine<'a> {
    #[serde(flatten)]
    probe: &'a Probe,
}

/// What was found.
#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct TuneSummary<'a> {
    target: Target,
    mode: String,
    threshold_px: f64,
    /// The options of `decor render` that ask for it.
    options: String,
    /// Is every frame rendered whole?
    whole: bool,
    /// The predicted value of the film; null where it is infinite.
    value: Option<f64>,
    /// The same with its margin.
    at_worst: Option<f64>,
    /// The standard deviation of the periods looked at, as a loss.
    spread: f64,
    sure: Sureness,
    frames: u32,
    /// Frames that were rendered plainly for the probes.
    plain_frames: usize,
    probes: usize,
    predicted_wall_s: f64,
    predicted_cpu_s: f64,
    baseline_wall_s: f64,
    predicted_speedup: f64,
    /// What tuning took.
    wall_s: f64,
    cpu_s: f64,
    /// Of `--render`.
    rendered: Option<&'a Summary>,
}

/// Runs the verb.
pub fn run(args: &TuneArgs, quiet: bool) -> Result<Status, Failure> {
    if plain::names_plain(&args.film) {
        return Err(Failure::usage(
            "a plain POV-Ray scene is rendered frame by frame: there is nothing to tune",
        ));
    }
    if matches!(args.mode, Mode::Full | Mode::Exact) {
        return Err(Failure::usage(
            "the modes full and exact have no error: --mode equivalent or preview",
        ));
    }
    if args.threshold_min > args.threshold_max {
        return Err(Failure::usage("--threshold-min is above --threshold-max"));
    }
    let clock = Clock::start();
    let cancel = cancelled_by_ctrl_c();
    let stage = args.film.stage(&cancel)?;
    let frames = args.film.wanted(&stage.film);
    let job = Job {
        film: args.film.film.display().to_string(),
        out: args.out.clone().unwrap_or_default(),
        format: PictureFormat::Png,
        jobs: args.jobs.map(usize::from),
        seed: 0,
        resume: false,
        keep: None,
        timeout: args.film.timeout(),
        cancel: Arc::clone(&cancel),
    };
    let tune = Tune {
        stage: &stage,
        job: job.clone(),
        target: args.target,
        wishes: Wishes {
            mode: args.mode,
            threshold_px: args.mode.default_threshold_px(),
            measure: args.measure,
            period: match args.period {
                Period::Auto => None,
                Period::Frames(n) => Some(n),
            },
            budget: None,
            shadow_way: crate::plan::ShadowWay::Auto,
            frames,
            with_depth: false,
            fallback: !args.no_fallback,
        },
        limits_px: (args.threshold_min, args.threshold_max),
        level: args.level,
    };
    let tuned = tune.run()?;
    let took = (clock.wall_s(), clock.cpu_s());
    if !args.json {
        tell(&tuned, frames.1 - frames.0 + 1);
    }
    let rendered = match &args.out {
        Some(out) => {
            let clock = Clock::start();
            let (plan, probed) = (&tuned.plan, &tuned.probed);
            let summary = job.execute(&stage, plan, probed, &clock, &Unwatched)?;
            let text = serde_json::to_string_pretty(&summary).map_err(Failure::internal)? + "\n";
            write_safely(&out.join("decor.json"), text.as_bytes())?;
            if !quiet && !args.json {
                told_rendered(&summary, out);
            }
            Some(summary)
        }
        None => None,
    };
    if args.json {
        for probe in &tuned.probes {
            print_json(&ProbeLine { probe })?;
        }
        print_json(&summary(&tuned, frames, took, rendered.as_ref()))?;
    }
    Ok(Status::Done)
}

fn summary<'a>(
    tuned: &Tuned,
    frames: (u32, u32),
    took: (f64, f64),
    rendered: Option<&'a Summary>,
) -> TuneSummary<'a> {
    TuneSummary {
        target: tuned.target,
        mode: tuned.plan.wishes.mode.to_string(),
        threshold_px: tuned.plan.wishes.threshold_px,
        options: tuned.options(),
        whole: !tuned.plan.periods.iter().any(|p| p.has_decor()),
        value: tuned.value,
        at_worst: tuned.at_worst,
        spread: tuned.spread,
        sure: tuned.sure,
        frames: frames.1 - frames.0 + 1,
        plain_frames: tuned.plain_frames,
        probes: tuned.probes.len(),
        predicted_wall_s: tuned.prediction.predicted_wall_s,
        predicted_cpu_s: tuned.prediction.predicted_cpu_s,
        baseline_wall_s: tuned.prediction.baseline_wall_s,
        predicted_speedup: tuned.prediction.speedup(),
        wall_s: took.0,
        cpu_s: took.1,
        rendered,
    }
}

fn value(value: Option<f64>) -> String {
    value.map_or_else(|| "∞".to_owned(), |value| format!("{value:.5}"))
}

fn tell(tuned: &Tuned, frames: u32) {
    let metric = tuned.target.metric;
    for probe in &tuned.probes {
        let (seen, all) = probe.periods;
        let looked = match probe.frames {
            0 => "no frame has an error".to_owned(),
            n => format!("{n} frames of {seen} of {all} periods"),
        };
        say!(
            "{:8.3} px: {metric} {}, with its margin {}: {} ({looked}; about {:.1} s)",
            probe.threshold_px,
            value(probe.value),
            value(probe.at_worst),
            if probe.holds {
                "holds"
            } else {
                "does not hold"
            },
            probe.predicted_wall_s,
        );
    }
    let sure = match tuned.sure {
        Sureness::Certain => "certain, by the plan",
        Sureness::Likely => "likely",
        Sureness::Guess => "a guess: frames that were not looked at may be worse",
    };
    say!(
        "{}: {}; {metric} {}, with its margin {} ({sure}; {} of {frames} frames were rendered plainly)",
        tuned.target,
        tuned.options(),
        value(tuned.value),
        value(tuned.at_worst),
        tuned.plain_frames,
    );
    let prediction = &tuned.prediction;
    say!(
        "about {:.1} s, {:.1} times as fast as frame by frame ({})",
        prediction.predicted_wall_s,
        prediction.speedup(),
        prediction.costs,
    );
}

fn told_rendered(summary: &Summary, out: &Path) {
    eprintln!(
        "decor: {} frames in {}: {:.1} s, {:.1} s of CPU",
        summary.frames,
        out.display(),
        summary.wall_s,
        summary.cpu_s
    );
}

//! `decor render`: a film's frames.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use clap::{Args, ValueEnum};
use decor_api::{Baseline, PictureFormat, RunContext, Tally};
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::job_log::{JOB_FILE, JobLog, finished};
use super::plain::{self, PlainArgs};
use super::progress::Progress;
use super::{Failure, Status, print_json};
use crate::animation::write_apng;
use crate::frames::{name, write_safely};
use crate::objects::Cache;
use crate::plan::{CostsFrom, Mode, Plan, Prediction, Price, Wishes, jobs, plan, whole_work};
use crate::probe::{self, Probed};
use crate::render::{Options, TracedPixels, WorkFolder, render};
use crate::report::{Clock, Summary, period_summaries};
use crate::stage::Stage;

/// Render a film.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor render plane.anim -o frames
  decor render plane.anim -o exact --mode exact --format png16
  decor render plane.anim -o plain --baseline
  decor render plane.anim -o part --frames 10-20 --keep scenes
  decor render scene.ini -o frames                 (any POV-Ray animation)
  decor render scene.pov -o frames -- +W320 +H240 +KFF50")]
pub struct RenderArgs {
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    wishes: PlanWishes,
    /// Where the frames go: frame_0000.png …, and decor.json.
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// Frame by frame by the stock renderer: one plain call over the film.
    #[arg(long, conflicts_with_all = ["mode", "threshold", "period", "jobs", "resume"])]
    baseline: bool,
    /// The format of the frames [default: png; of a plain POV-Ray scene, its own].
    #[arg(long, value_enum)]
    format: Option<Format>,
    /// Calls of the renderer at once [default: chosen].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    jobs: Option<u16>,
    /// Write the frames as an animated PNG, too.
    #[arg(long, value_name = "FILE")]
    apng: Option<PathBuf>,
    /// Frames a second of the animated PNG.
    #[arg(long, value_name = "N", default_value_t = 12, requires = "apng",
          value_parser = clap::value_parser!(u16).range(1..))]
    fps: u16,
    /// Of the order in which a décor dissolves.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Keep the frames of an interrupted run of the same job.
    #[arg(long)]
    resume: bool,
    /// Keep the scene files and the renderer's logs here.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// A picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Format {
    /// 8 bits a channel.
    Png,
    /// 16 bits a channel.
    Png16,
    /// Linear float, with the depth in Z.
    Exr,
}

impl Format {
    fn picture(self) -> PictureFormat {
        match self {
            Self::Png => PictureFormat::Png,
            Self::Png16 => PictureFormat::Png16,
            Self::Exr => PictureFormat::Exr,
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Png16 => "png16",
            Self::Exr => "exr",
        }
    }
}

impl RenderArgs {
    fn format(&self) -> Format {
        self.format.unwrap_or(Format::Png)
    }

    /// What concerns a plain POV-Ray scene.
    fn plain(&self, quiet: bool) -> PlainArgs<'_> {
        PlainArgs {
            film: &self.film,
            wishes: &self.wishes,
            out: &self.out,
            baseline: self.baseline,
            format: self.format.map(Format::picture),
            jobs: self.jobs,
            apng: self.apng.as_deref(),
            fps: self.fps,
            resume: self.resume,
            keep: self.keep.as_deref(),
            json: self.json,
            quiet,
        }
    }
}

/// A finished frame, for `--json`.
#[derive(Serialize)]
#[serde(tag = "type", rename = "frame")]
struct FrameLine<'a> {
    frame: u32,
    file: &'a Path,
}

/// Runs the verb.
pub fn run(args: &RenderArgs, quiet: bool) -> Result<Status, Failure> {
    if plain::names_plain(&args.film) {
        return plain::run(&args.plain(quiet));
    }
    if args.apng.is_some() && args.format() == Format::Exr {
        return Err(Failure::usage(
            "--apng is made of PNG frames: leave out --format exr",
        ));
    }
    let clock = Clock::start();
    let cancel = cancelled_by_ctrl_c();
    let stage = args.film.stage(&cancel)?;
    let frames = args.film.wanted(&stage.film);
    let summary = if args.baseline {
        baseline(args, &stage, frames, &cancel, &clock)?
    } else {
        layered(args, &stage, frames, &cancel, &clock, quiet)?
    };
    let text = serde_json::to_string_pretty(&summary).map_err(Failure::internal)? + "\n";
    write_safely(&args.out.join("decor.json"), text.as_bytes())?;
    if let Some(path) = &args.apng {
        let format = args.format().picture();
        let files: Vec<PathBuf> = (frames.0..=frames.1)
            .map(|n| args.out.join(name(n, format)))
            .collect();
        write_apng(&files, path, args.fps)?;
    }
    if args.json {
        print_json(&summary)?;
    } else if !quiet {
        tell(&summary, &args.out);
    }
    Ok(Status::Done)
}

fn layered(
    args: &RenderArgs,
    stage: &Stage,
    frames: (u32, u32),
    cancel: &Arc<AtomicBool>,
    clock: &Clock,
    quiet: bool,
) -> Result<Summary, Failure> {
    let format = args.format().picture();
    let wishes = args.wishes.wishes(frames, format == PictureFormat::Exr);
    let (plan, probed) = planned(args, stage, wishes, cancel)?;
    let mut summary = describe(args, stage, frames);
    summary.mode = plan.wishes.mode.to_string();
    summary.threshold_px = plan.wishes.threshold_px;
    summary.periods = period_summaries(&plan);
    summary.fallback = plan.is_fallback();
    // Other periods have other frames.
    let starts: Vec<(u32, u32)> = plan.periods.iter().map(|p| (p.start, p.len())).collect();
    let job = blake3::hash(format!("{} {starts:?}", summary.job).as_bytes());
    summary.job = job.to_hex().to_string();
    let jobs_at_once = args.jobs.map_or_else(|| jobs(stage), usize::from);
    let works = plan.works(stage);
    let price = probed.costs.film(&works, jobs_at_once, probe::cores());
    let whole = whole_work(stage, &plan.wishes);
    let stock = probed.costs.stock(&whole, probe::cores());
    let prediction = Prediction::new(probed.from, price.into_iter().sum(), stock);
    let before = Price {
        wall_s: clock.wall_s(),
        cpu_s: clock.cpu_s(),
    };
    make_folder(&args.out)?;
    let skip = if args.resume {
        finished(&args.out, &summary.job, frames, &|n| name(n, format))
    } else {
        BTreeSet::new()
    };
    // What is there belongs to this job from now on, also if it is interrupted.
    let log = JobLog::begin(&args.out, &summary.job, &skip)?;
    let options = Options {
        out: args.out.clone(),
        format,
        jobs: args.jobs.map(usize::from),
        keep: args.keep.clone(),
        timeout: args.film.timeout(),
        seed: args.seed,
        cancel: Arc::clone(cancel),
        skip,
    };
    let left = u64::from(frames.1 - frames.0 + 1) - options.skip.len() as u64;
    let progress = Progress::new(left, quiet || args.json);
    let watch = |frame: u32, file: &Path| {
        progress.frame();
        log.finished(frame);
        if args.json {
            // A reader that went away is found out at the end, by the summary.
            let _ = print_json(&FrameLine { frame, file });
        }
    };
    let done = render(stage, &plan, &options, &watch);
    progress.finish();
    let done = done?;
    // Only an interrupted run needs it.
    log.end();
    summary.frames_kept = options.skip.len() as u64;
    summary.renderer_calls = done.calls;
    summary.renderer_frames = done.pictures;
    summary.pixels_traced = done.traced;
    (summary.wall_s, summary.cpu_s) = (clock.wall_s(), clock.cpu_s());
    summary.prediction = Some(prediction.measured(Price {
        wall_s: summary.wall_s - before.wall_s,
        cpu_s: summary.cpu_s - before.cpu_s,
    }));
    Ok(summary)
}

/// The plan, with costs that were measured where that pays.
fn planned(
    args: &RenderArgs,
    stage: &Stage,
    wishes: Wishes,
    cancel: &Arc<AtomicBool>,
) -> Result<(Plan, Probed), Failure> {
    let cache = Cache::open();
    let mut probed = probe::known(stage, &cache);
    let first = plan(stage, wishes.clone(), &probed.costs)?;
    let measures = wishes.mode != Mode::Full
        && probed.from == CostsFrom::BuiltIn
        && probe::worth_probing(stage, &wishes);
    if !measures {
        return Ok((first, probed));
    }
    let work = WorkFolder::new(None)?;
    let mut run = RunContext::new(&work.path);
    run.timeout = args.film.timeout();
    run.cancel = Arc::clone(cancel);
    probed = probe::probe(stage, &first, &cache, &run)?;
    Ok((plan(stage, wishes, &probed.costs)?, probed))
}

fn baseline(
    args: &RenderArgs,
    stage: &Stage,
    frames: (u32, u32),
    cancel: &Arc<AtomicBool>,
    clock: &Clock,
) -> Result<Summary, Failure> {
    let film = (*stage.film.frames().start(), *stage.film.frames().end());
    if frames.0 < film.0 || frames.1 > film.1 {
        return Err(crate::plan::PlanError::NoSuchFrames {
            film,
            asked: frames,
        }
        .into());
    }
    let format = args.format().picture();
    let request = Baseline {
        prototypes: &stage.library.table,
        size: stage.size(),
        antialias: stage.antialias(),
        film,
        frames: (frames.0..=frames.1)
            .map(|n| (n, Arc::new(stage.scene(&stage.film.frame(n), |_| true))))
            .collect(),
        format,
    };
    let work = WorkFolder::new(args.keep.as_deref())?;
    let tally = Arc::new(Tally::default());
    let run = RunContext {
        work: work.path.clone(),
        keep: args.keep.is_some(),
        timeout: args.film.timeout(),
        threads: None,
        cancel: Arc::clone(cancel),
        tally: Arc::clone(&tally),
    };
    let files = stage.adapter.baseline(&request, &run)?;
    make_folder(&args.out)?;
    // What an interrupted run has noted is written over now.
    let _ = std::fs::remove_file(args.out.join(JOB_FILE));
    for (number, file) in files {
        let bytes = std::fs::read(&file).map_err(|source| {
            Failure::from(decor_api::AdapterError::BadOutput {
                program: stage.adapter.name().into(),
                file: file.clone(),
                reason: source.to_string(),
            })
        })?;
        let path = args.out.join(name(number, format));
        write_safely(&path, &bytes)?;
        // The copy is in place; the original would be a second film on the disk.
        let _ = std::fs::remove_file(&file);
        if args.json {
            print_json(&FrameLine {
                frame: number,
                file: &path,
            })?;
        }
    }
    let mut summary = describe(args, stage, frames);
    summary.mode = "baseline".into();
    (summary.renderer_calls, summary.renderer_frames) = tally.read();
    summary.pixels_traced = TracedPixels {
        whole: summary.pixels_full,
        ..Default::default()
    };
    (summary.wall_s, summary.cpu_s) = (clock.wall_s(), clock.cpu_s());
    Ok(summary)
}

/// A summary of what is about to be done.
fn describe(args: &RenderArgs, stage: &Stage, frames: (u32, u32)) -> Summary {
    let size = stage.size();
    let count = u64::from(frames.1 - frames.0 + 1);
    let abilities = stage.adapter.abilities();
    let mode = args.wishes.mode.unwrap_or(Mode::Equivalent);
    let job = blake3::hash(
        format!(
            "{} {} {} {:?} {}",
            args.seed,
            args.baseline,
            stage.key(),
            args.wishes.wishes(frames, args.format() == Format::Exr),
            args.format().text()
        )
        .as_bytes(),
    );
    Summary {
        decor: env!("CARGO_PKG_VERSION").into(),
        film: args.film.film.display().to_string(),
        frames: count,
        frames_kept: 0,
        first_frame: frames.0,
        width: size.width,
        height: size.height,
        renderer: stage.adapter.name().into(),
        renderer_version: abilities.version.clone(),
        mode: mode.to_string(),
        threshold_px: 0.0,
        format: args.format().text().into(),
        periods: Vec::new(),
        wall_s: 0.0,
        cpu_s: 0.0,
        renderer_calls: 0,
        renderer_frames: 0,
        pixels_traced: TracedPixels::default(),
        pixels_full: count * size.pixels() as u64,
        prediction: None,
        fallback: false,
        job: job.to_hex().to_string(),
    }
}

fn make_folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|source| Failure::write(path, source))
}

fn tell(summary: &Summary, out: &Path) {
    let traced = summary.pixels_traced.total();
    let share = traced as f64 / summary.pixels_full.max(1) as f64 * 100.0;
    eprintln!(
        "decor: {} frames in {} ({}, {} {}): {:.1} s, {:.1} s of CPU, {} calls, {share:.0} % of the pixels traced",
        summary.frames,
        out.display(),
        summary.mode,
        summary.renderer,
        summary.renderer_version,
        summary.wall_s,
        summary.cpu_s,
        summary.renderer_calls,
    );
    let mut reasons: Vec<&String> = summary
        .periods
        .iter()
        .filter_map(|p| p.whole.as_ref())
        .collect();
    reasons.dedup();
    if summary.fallback {
        for reason in reasons.into_iter().take(3) {
            eprintln!("decor: rendered frame by frame: {reason}");
        }
    }
}

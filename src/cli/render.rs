//! `decor render`: a film's frames.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, OnceLock};

use clap::{Args, ValueEnum};
use decor_api::PictureFormat;
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::plain::{self, PlainArgs};
use super::progress::Progress;
use super::{Failure, Status, compare, print_json};
use crate::animation::write_apng;
use crate::compare::verdict::Limit;
use crate::frames::{name, write_safely};
use crate::job::{Job, Watch};
use crate::plan::{Mode, plan};
use crate::report::{Clock, Summary};
use crate::stage::Stage;
use crate::verify::{Verified, default_limit, verify};

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
    #[arg(long, conflicts_with_all = ["mode", "threshold", "period", "jobs", "resume", "verify"])]
    baseline: bool,
    #[command(flatten)]
    verify: VerifyArgs,
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

/// Which frames are rendered plainly too, and what is tolerated of them.
#[derive(Debug, Args)]
struct VerifyArgs {
    /// Render N frames plainly too, first and last ones of periods and middles,
    /// and compare: status 1 where one is outside the tolerance.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    verify: Option<u16>,
    /// A pixel differs where a channel differs by more than this [default: 0 in
    /// the modes full and exact, else 0.016].
    #[arg(long, value_name = "T", value_parser = compare::tolerance, requires = "verify")]
    verify_fail: Option<f64>,
    /// So many percent of a frame's pixels may differ [default: 0 in the modes full
    /// and exact, else 1].
    #[arg(long, value_name = "P", value_parser = compare::percent, requires = "verify")]
    verify_fail_percent: Option<f64>,
}

impl VerifyArgs {
    fn limit(&self, mode: Mode) -> Limit {
        let usual = default_limit(mode);
        Limit {
            level: self.verify_fail.unwrap_or(usual.level),
            percent: self.verify_fail_percent.unwrap_or(usual.percent),
        }
    }
}

/// A picture format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Format {
    /// 8 bits a channel.
    Png,
    /// 16 bits a channel.
    Png16,
    /// Linear float, with the depth in Z.
    Exr,
}

impl Format {
    pub(super) fn picture(self) -> PictureFormat {
        match self {
            Self::Png => PictureFormat::Png,
            Self::Png16 => PictureFormat::Png16,
            Self::Exr => PictureFormat::Exr,
        }
    }
}

impl RenderArgs {
    fn format(&self) -> Format {
        self.format.unwrap_or(Format::Png)
    }

    fn job(&self, cancel: &Arc<AtomicBool>) -> Job {
        Job {
            film: self.film.film.display().to_string(),
            out: self.out.clone(),
            format: self.format().picture(),
            jobs: self.jobs.map(usize::from),
            seed: self.seed,
            resume: self.resume,
            keep: self.keep.clone(),
            timeout: self.film.timeout(),
            cancel: Arc::clone(cancel),
        }
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
        if args.verify.verify.is_some() {
            return Err(Failure::usage(
                "--verify compares with frame by frame, which a plain POV-Ray scene is rendered by",
            ));
        }
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
    let job = args.job(&cancel);
    let watch = Shown {
        json: args.json,
        quiet,
        progress: OnceLock::new(),
    };
    let summary = if args.baseline {
        job.stock(&stage, frames, &clock, &watch)?
    } else {
        layered(args, &stage, frames, &job, &clock, &watch)?
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
    let passed = summary.verified.as_ref().is_none_or(|v| v.passed);
    Ok(if passed {
        Status::Done
    } else {
        Status::Verification
    })
}

fn layered(
    args: &RenderArgs,
    stage: &Stage,
    frames: (u32, u32),
    job: &Job,
    clock: &Clock,
    watch: &Shown,
) -> Result<Summary, Failure> {
    let wishes = args.wishes.wishes(frames, job.format == PictureFormat::Exr);
    let probed = job.costs(stage, &wishes)?;
    let plan = plan(stage, wishes, &probed.costs)?;
    let summary = job.execute(stage, &plan, &probed, clock, watch);
    watch.finish();
    let mut summary = summary?;
    if let Some(count) = args.verify.verify {
        let limit = args.verify.limit(plan.wishes.mode);
        let wanted = (usize::from(count), limit);
        summary.verified = Some(verify(stage, &plan, &probed, job, wanted)?);
    }
    Ok(summary)
}

/// Shows finished frames: as lines of JSON, or how many there are.
struct Shown {
    json: bool,
    quiet: bool,
    progress: OnceLock<Progress>,
}

impl Shown {
    fn finish(&self) {
        if let Some(progress) = self.progress.get() {
            progress.finish();
        }
    }
}

impl Watch for Shown {
    fn begins(&self, frames: u64) {
        let quiet = self.quiet || self.json;
        self.progress.get_or_init(|| Progress::new(frames, quiet));
    }

    fn frame(&self, frame: u32, file: &Path) {
        if let Some(progress) = self.progress.get() {
            progress.frame();
        }
        if self.json {
            // A reader that went away is found out at the end, by the summary.
            let _ = print_json(&FrameLine { frame, file });
        }
    }
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
    if let Some(verified) = &summary.verified {
        eprintln!("decor: {}", verdict(verified));
    }
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

/// A verification in words.
fn verdict(verified: &Verified) -> String {
    let psnr = verified.psnr.map_or_else(
        || "nothing differs".to_owned(),
        |psnr| format!("PSNR {psnr:.1} dB"),
    );
    let words = format!(
        "verified {} frames against plain ones in {:.1} s: largest difference {:.5}, {psnr}, {:.3} % of the pixels above {}",
        verified.frames.len(),
        verified.wall_s,
        verified.max,
        100.0 * verified.share_above,
        verified.tolerance,
    );
    let failed: Vec<String> = verified.failed.iter().map(ToString::to_string).collect();
    if verified.passed {
        format!("{words}: passed")
    } else {
        format!("{words}: failed in the frames {}", failed.join(", "))
    }
}

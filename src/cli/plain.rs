//! Plain POV-Ray scenes on the command line: `decor render scene.ini -o DIR`,
//! and what `plan` and `explain` say of them.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use decor_api::{Adapter as _, PictureFormat};
use decor_povray::plain::{Order, PlainScene, is_plain};
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::progress::Progress;
use super::{Failure, Status, print_json};
use crate::animation::write_apng;
use crate::frames::write_safely;
use crate::job::log::{JobLog, finished};
use crate::plain::{Done, Look, Options, Way, most_jobs, render};
use crate::plan::Mode;
use crate::render::TracedPixels;
use crate::renderers::povray;
use crate::report::Clock;

/// What `render` is told, as far as it concerns a plain scene.
pub struct PlainArgs<'a> {
    pub film: &'a FilmArgs,
    pub wishes: &'a PlanWishes,
    pub out: &'a Path,
    pub baseline: bool,
    /// The format, where one was stated.
    pub format: Option<PictureFormat>,
    pub jobs: Option<u16>,
    pub apng: Option<&'a Path>,
    pub fps: u16,
    pub resume: bool,
    pub keep: Option<&'a Path>,
    pub json: bool,
    pub quiet: bool,
}

/// `decor.json`: the fields of a film's summary, and how frames hang together.
#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct PlainSummary {
    decor: &'static str,
    film: String,
    frames: u64,
    frames_kept: u64,
    first_frame: u32,
    last_frame: u32,
    frame_step: u32,
    width: u32,
    height: u32,
    renderer: &'static str,
    renderer_version: String,
    mode: &'static str,
    threshold_px: f64,
    /// The ending of the pictures.
    format: &'static str,
    periods: Vec<PlainPeriod>,
    /// Why the frames were rendered in order, if they were.
    in_order: Option<String>,
    /// Why the frames were rendered whole, in the mode exact.
    rendered_whole: Vec<String>,
    /// Frames that show the same as others, and were not rendered.
    frames_repeated: u64,
    /// The share of blocks that may change, where it was found out.
    dirty_blocks: Option<f64>,
    wall_s: f64,
    cpu_s: f64,
    renderer_calls: u64,
    renderer_frames: u64,
    pixels_traced: TracedPixels,
    pixels_full: u64,
    fallback: bool,
    job: String,
}

/// All frames of a plain scene.
#[derive(Serialize)]
struct PlainPeriod {
    start: u32,
    length: u64,
    objects: NoObjects,
    /// Why nothing is kept from one frame to the next; null where something is.
    whole: Option<String>,
}

#[derive(Default, Serialize)]
struct NoObjects {
    immobile: usize,
    clipped: usize,
    slow: usize,
    fast: usize,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "frame")]
struct FrameLine<'a> {
    frame: u32,
    file: &'a Path,
}

const WHOLE: &str = "a plain POV-Ray scene";

/// Does the film argument name a plain scene?
pub fn names_plain(film: &FilmArgs) -> bool {
    is_plain(&film.film)
}

/// Options that a plain scene has no use for.
pub fn check(film: &FilmArgs, wishes: &PlanWishes) -> Result<(), Failure> {
    let refused = |what: &str| {
        Err(Failure::usage(format!(
            "{what}: the frames of a plain POV-Ray scene are POV-Ray's own (--mode exact or full)"
        )))
    };
    match wishes.mode {
        None | Some(Mode::Exact | Mode::Full) => {}
        Some(mode) => return refused(&format!("--mode {mode}")),
    }
    if wishes.threshold.is_some() {
        return refused("--threshold");
    }
    if wishes.period.is_some() {
        return refused("--period");
    }
    match film.renderer.as_deref() {
        None | Some("povray") => Ok(()),
        Some(other) => refused(&format!("--renderer {other}")),
    }
}

/// The frames that are asked for.
pub fn wanted(film: &FilmArgs, scene: &PlainScene) -> Result<BTreeSet<u32>, Failure> {
    let (first, last) = (scene.frames.first, scene.frames.last);
    let Some((a, b)) = film.frames else {
        return Ok(scene.frames.numbers().collect());
    };
    if a < first || b > last {
        return Err(crate::plan::PlanError::NoSuchFrames {
            film: (first, last),
            asked: (a, b),
        }
        .into());
    }
    let frames: BTreeSet<u32> = scene
        .frames
        .numbers()
        .filter(|n| (a..=b).contains(n))
        .collect();
    if frames.is_empty() {
        return Err(Failure::usage(format!("there is no frame from {a} to {b}")));
    }
    Ok(frames)
}

pub fn ends(frames: &BTreeSet<u32>) -> (u32, u32) {
    let first = frames.first().copied().unwrap_or_default();
    (first, frames.last().copied().unwrap_or(first))
}

pub fn reason(scene: &PlainScene) -> Option<&str> {
    match &scene.order {
        Order::Free => None,
        Order::Chained(reason) | Order::OwnPictures(reason) => Some(reason),
    }
}

/// `decor render` of a plain scene.
pub fn run(args: &PlainArgs<'_>) -> Result<Status, Failure> {
    check(args.film, args.wishes)?;
    let clock = Clock::start();
    let cancel = cancelled_by_ctrl_c();
    let povray = povray()?;
    let scene = povray.plain(&args.film.film, &args.film.switches, args.format)?;
    if args.apng.is_some() && scene.ending != "png" {
        return Err(Failure::usage(format!(
            "--apng is made of PNG frames, not of .{}: add --format png",
            scene.ending
        )));
    }
    let frames = wanted(args.film, &scene)?;
    let (first, last) = ends(&frames);
    let mode = if args.baseline { "baseline" } else { "full" };
    let job = format!("{mode} {}", scene.key);
    std::fs::create_dir_all(args.out).map_err(|source| Failure::write(args.out, source))?;
    let mut kept = BTreeSet::new();
    if args.resume {
        kept = finished(args.out, &job, (first, last), &|n| scene.name(n));
        kept.retain(|n| frames.contains(n));
        // Frames that need each other are made together.
        if scene.order != Order::Free && kept.len() < frames.len() {
            kept.clear();
        }
    }
    // What is there belongs to this job from now on, also if it is interrupted.
    let log = JobLog::begin(args.out, &job, &kept)?;
    let in_order = reason(&scene).filter(|_| !args.baseline);
    if let (Some(reason), false) = (in_order, args.quiet) {
        eprintln!("decor: rendered in order, by one POV-Ray: {reason}");
    }
    let way = match (args.baseline, args.wishes.mode) {
        (true, _) => Way::Stock,
        (false, Some(Mode::Full)) => Way::Whole,
        _ => Way::Coherent {
            look: Box::new(Look::at(&povray, &scene)?),
            always: args.wishes.no_fallback,
        },
    };
    let options = Options {
        out: args.out.to_owned(),
        jobs: args.jobs.map(usize::from),
        most: most_jobs(&scene, povray.abilities().jobs),
        keep: args.keep.map(Path::to_owned),
        timeout: args.film.timeout(),
        cancel,
        wanted: frames.difference(&kept).copied().collect(),
        way,
    };
    let progress = Progress::new(options.wanted.len() as u64, args.quiet || args.json);
    let watch = |frame: u32, file: &Path| {
        progress.frame();
        log.finished(frame);
        if args.json {
            // A reader that went away is found out at the end, by the summary.
            let _ = print_json(&FrameLine { frame, file });
        }
    };
    let done = render(&povray, &scene, &options, &watch);
    progress.finish();
    let done = done?;
    // Only an interrupted run needs it.
    log.end();
    let pixels = u64::from(scene.size.0) * u64::from(scene.size.1);
    let (mode, whole) = mode_of(args, &options, &done);
    let summary = PlainSummary {
        decor: env!("CARGO_PKG_VERSION"),
        film: args.film.film.display().to_string(),
        frames: frames.len() as u64,
        frames_kept: kept.len() as u64,
        first_frame: first,
        last_frame: last,
        frame_step: scene.frames.step,
        width: scene.size.0,
        height: scene.size.1,
        renderer: "povray",
        renderer_version: povray.abilities().version.clone(),
        mode,
        threshold_px: 0.0,
        format: scene.ending,
        periods: vec![PlainPeriod {
            start: first,
            length: frames.len() as u64,
            objects: NoObjects::default(),
            whole,
        }],
        in_order: in_order.map(str::to_owned),
        rendered_whole: done.whole,
        frames_repeated: done.repeated,
        dirty_blocks: done.dirty,
        wall_s: clock.wall_s(),
        cpu_s: clock.cpu_s(),
        renderer_calls: done.calls,
        renderer_frames: done.pictures,
        pixels_traced: TracedPixels {
            whole: done.whole_pixels,
            blocks: done.block_pixels,
            ..Default::default()
        },
        pixels_full: frames.len() as u64 * pixels,
        fallback: false,
        job,
    };
    let text = serde_json::to_string_pretty(&summary).map_err(Failure::internal)? + "\n";
    write_safely(&args.out.join("decor.json"), text.as_bytes())?;
    if let Some(path) = args.apng {
        let files: Vec<PathBuf> = frames
            .iter()
            .map(|n| args.out.join(scene.name(*n)))
            .collect();
        write_apng(&files, path, args.fps)?;
    }
    if args.json {
        print_json(&summary)?;
    } else if !args.quiet {
        if summary.frames_repeated > 0 {
            let repeated = summary.frames_repeated;
            eprintln!("decor: {repeated} frames show the same as others");
        }
        for reason in &summary.rendered_whole {
            eprintln!("decor: rendered whole: {reason}");
        }
        if let (Some(dirty), "exact") = (summary.dirty_blocks, mode) {
            let percent = 100.0 * dirty;
            eprintln!("decor: {percent:.1} % of the blocks may change from frame to frame");
        }
        eprintln!(
            "decor: {} frames in {} ({mode}, povray {}): {:.1} s, {:.1} s of CPU, {} calls",
            summary.frames,
            args.out.display(),
            summary.renderer_version,
            summary.wall_s,
            summary.cpu_s,
            summary.renderer_calls,
        );
    }
    Ok(Status::Done)
}

/// What was done in the end, and why nothing was kept, if so.
fn mode_of(args: &PlainArgs<'_>, options: &Options, done: &Done) -> (&'static str, Option<String>) {
    match options.way {
        Way::Stock => ("baseline", Some(WHOLE.into())),
        Way::Coherent { .. } if done.whole.is_empty() && done.dirty.is_some() => ("exact", None),
        _ => {
            let why = done.whole.first().cloned();
            let why = why.or_else(|| args.wishes.mode.map(|mode| format!("--mode {mode}")));
            ("full", Some(why.unwrap_or_else(|| WHOLE.into())))
        }
    }
}

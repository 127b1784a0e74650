//! `decor stream`: scenes from stdin as they arrive, each frame out at once.

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use clap::Args;
use decor_api::{AdapterError, PictureFormat};
use serde::Serialize;

use super::film_args::{PlanWishes, cancelled_by_ctrl_c, positive};
use super::render::Format;
use super::{Failure, Status, print_json};
use crate::frames::write_safely;
use crate::job::format_name;
use crate::job::log::JOB_FILE;
use crate::objects::Cache;
use crate::plan::{Mode, Period};
use crate::render::Options;
use crate::renderers;
use crate::report::{Clock, PeriodSummary, Summary};
use crate::segmentation::Class;
use crate::stage::Stage;
use crate::stream::{Event, Settings, Stream, StreamDone, StreamError};

/// How long to wait for a scene before looking whether the user has had enough.
const GLANCE: Duration = Duration::from_millis(50);

/// Where the summary goes.
const SUMMARY_FILE: &str = "decor.json";

/// Render scenes from stdin as they arrive.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  simulator | decor stream -o frames --folder scenes
  decor convert plane.anim plane.jsonl && decor stream -o frames < plane.jsonl
  simulator | decor stream -o frames --json --budget 0.5

A scene is a JSON object on a line, as in a .jsonl film; what it leaves out stays
as it was. The velocities that it states are the prediction: a scene that is not
as predicted costs a new décor, and is never shown with the old one. Each frame is
in its place, and its line of --json printed, before the next scene is read. The
end of stdin, or Ctrl-C, ends the stream.")]
pub struct StreamArgs {
    /// Where the frames go: frame_0000.png …, and decor.json.
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// What the paths in the scenes are relative to.
    #[arg(long, value_name = "DIR", default_value = ".")]
    folder: PathBuf,
    /// The renderer: povray, mitsuba, reference or exec:PROGRAM.
    #[arg(long, value_name = "NAME", default_value = "povray")]
    renderer: String,
    /// Object paths may leave the folder.
    #[arg(long)]
    allow_outside: bool,
    #[command(flatten)]
    wishes: PlanWishes,
    /// The format of the frames.
    #[arg(long, value_enum, default_value = "png")]
    format: Format,
    /// Seconds that one call of the renderer may take.
    #[arg(long, value_name = "SECONDS", default_value_t = 3600.0, value_parser = positive)]
    timeout: f64,
    /// Of the order in which a décor dissolves.
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,
    /// Keep the scene files and the renderer's logs here.
    #[arg(long, value_name = "DIR")]
    keep: Option<PathBuf>,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// A period that begins, for `--json`.
#[derive(Serialize)]
#[serde(tag = "type", rename = "begin")]
struct BeginLine<'a> {
    start: u32,
    threshold_px: f64,
    dissolves_until: Option<u32>,
    whole: Option<String>,
    objects: Vec<ObjectLine<'a>>,
}

#[derive(Serialize)]
struct ObjectLine<'a> {
    name: &'a str,
    class: Class,
    reason: String,
    /// Pixels, as predicted; null where the motion is unbounded.
    motion_px: Option<f64>,
}

/// A frame in its place.
#[derive(Serialize)]
#[serde(tag = "type", rename = "frame")]
struct FrameLine<'a> {
    frame: u32,
    file: &'a Path,
    /// The first frame of its period.
    period: u32,
    seconds: f64,
}

/// A period that has ended.
#[derive(Serialize)]
#[serde(tag = "type", rename = "period")]
struct PeriodLine<'a> {
    #[serde(flatten)]
    period: &'a PeriodSummary,
}

/// Runs the verb.
pub fn run(args: &StreamArgs, quiet: bool) -> Result<Status, Failure> {
    let clock = Clock::start();
    let cancel = cancelled_by_ctrl_c();
    let settings = args.settings(&cancel)?;
    let folder = || std::fs::create_dir_all(&args.out);
    folder().map_err(|source| Failure::write(&args.out, source))?;
    let adapter = std::sync::Arc::clone(&settings.adapter);
    let mut stream = Stream::new(settings, Cache::open())?;
    let mut first = None;
    let mut watch = |event: &Event<'_>| {
        match event {
            Event::Frame { number, .. } => {
                first.get_or_insert(*number);
            }
            // What is noted there of another run's frames is not true any more.
            Event::Began(..) if first.is_none() => {
                for note in [JOB_FILE, SUMMARY_FILE] {
                    let _ = std::fs::remove_file(args.out.join(note));
                }
            }
            _ => {}
        }
        if args.json {
            tell_json(event);
        } else if !quiet {
            tell(event);
        }
    };
    let lines = Lines::begin();
    let result = follow(&mut stream, &lines, &cancel, &mut watch);
    let size = stream.stage().map(Stage::size);
    let done = stream.close(&mut watch);
    let (Some(size), Some(first)) = (size, first) else {
        return result;
    };
    let count = done.frames;
    let mode = args.wishes.mode.unwrap_or(Mode::Equivalent);
    let whole = |period: &PeriodSummary| period.whole.is_some();
    let summary = Summary {
        decor: env!("CARGO_PKG_VERSION").into(),
        film: "-".into(),
        frames: count,
        frames_kept: 0,
        first_frame: first,
        width: size.width,
        height: size.height,
        renderer: adapter.name().into(),
        renderer_version: adapter.abilities().version.clone(),
        mode: mode.to_string(),
        threshold_px: args.wishes.wishes((0, 0), false).threshold_px,
        format: format_name(args.format.picture()).into(),
        fallback: mode != Mode::Full && done.periods.iter().all(whole),
        periods: done.periods.clone(),
        wall_s: clock.wall_s(),
        cpu_s: clock.cpu_s(),
        renderer_calls: done.calls,
        renderer_frames: done.pictures,
        pixels_traced: done.traced,
        pixels_full: count * size.pixels() as u64,
        prediction: None,
        verified: None,
        // Nobody can resume what is gone.
        job: String::new(),
    };
    let text = serde_json::to_string_pretty(&summary).map_err(Failure::internal)? + "\n";
    let written = write_safely(&args.out.join(SUMMARY_FILE), text.as_bytes());
    if args.json {
        let _ = print_json(&summary);
    } else if !quiet {
        tell_all(&done, args, summary.wall_s);
    }
    // What stopped the stream says more than what came of its summary.
    let status = result?;
    written?;
    Ok(status)
}

impl StreamArgs {
    fn settings(&self, cancel: &std::sync::Arc<AtomicBool>) -> Result<Settings, Failure> {
        let format = self.format.picture();
        let adapter = match renderers::find(&self.renderer) {
            Err(AdapterError::Missing { program, install })
                if !renderers::is_known(&self.renderer) =>
            {
                return Err(Failure::usage(format!("{program} is not known; {install}")));
            }
            found => found?,
        };
        Ok(Settings {
            name: "stdin".into(),
            folder: self.folder.clone(),
            allow_outside: self.allow_outside,
            adapter,
            wishes: self.wishes.wishes((0, 0), format == PictureFormat::Exr),
            options: Options {
                out: self.out.clone(),
                format,
                jobs: None,
                keep: self.keep.clone(),
                timeout: Duration::from_secs_f64(self.timeout.min(1e9)),
                seed: self.seed,
                cancel: std::sync::Arc::clone(cancel),
                skip: std::collections::BTreeSet::new(),
            },
        })
    }
}

/// Renders scene by scene, until there are no more.
fn follow(
    stream: &mut Stream,
    lines: &Lines,
    cancel: &AtomicBool,
    watch: &mut dyn FnMut(&Event<'_>),
) -> Result<Status, Failure> {
    loop {
        match lines.next(cancel) {
            Next::Line(line) => stream.line(&line, watch)?,
            Next::End => {
                stream.finish(watch)?;
                return Ok(Status::Done);
            }
            Next::Stopped => return Ok(Status::Stopped),
            Next::Broken(source) => return Err(Failure::read_stdin(source)),
        }
    }
}

/// What stdin has next.
enum Next {
    Line(Vec<u8>),
    End,
    Stopped,
    Broken(std::io::Error),
}

/// The lines of stdin, read in a thread of their own: one that waits for a line
/// does not see that the user has had enough. None is read before it is asked
/// for.
struct Lines {
    ask: Sender<()>,
    answers: Receiver<std::io::Result<Vec<u8>>>,
}

impl Lines {
    fn begin() -> Self {
        let (ask, asked) = channel::<()>();
        let (answer, answers) = channel();
        std::thread::spawn(move || {
            let mut stdin = BufReader::new(std::io::stdin());
            for () in asked {
                let mut line = Vec::new();
                let read = stdin.read_until(b'\n', &mut line);
                if answer.send(read.map(|_| line)).is_err() {
                    break;
                }
            }
        });
        Self { ask, answers }
    }

    fn next(&self, cancel: &AtomicBool) -> Next {
        if self.ask.send(()).is_err() {
            return Next::End;
        }
        loop {
            if cancel.load(Ordering::Relaxed) {
                return Next::Stopped;
            }
            match self.answers.recv_timeout(GLANCE) {
                Ok(Ok(line)) if line.is_empty() => return Next::End,
                Ok(Ok(line)) => return Next::Line(line),
                Ok(Err(error)) => return Next::Broken(error),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Next::End,
            }
        }
    }
}

fn tell_json(event: &Event<'_>) {
    // A reader that went away wants no more of it; the frames are for others.
    let _ = match event {
        Event::Began(stage, period) => print_json(&begin_line(stage, period)),
        Event::Frame {
            number,
            file,
            period,
            seconds,
        } => print_json(&FrameLine {
            frame: *number,
            file,
            period: *period,
            seconds: *seconds,
        }),
        Event::Ended(period) => print_json(&PeriodLine { period }),
    };
}

fn begin_line<'a>(stage: &'a Stage, period: &Period) -> BeginLine<'a> {
    let objects = period.objects.iter().map(|object| ObjectLine {
        name: stage.film.identity(object.object).name(),
        class: object.class,
        reason: object.reason.to_string(),
        motion_px: object.motion_px.is_finite().then_some(object.motion_px),
    });
    BeginLine {
        start: period.start,
        threshold_px: period.threshold_px,
        dissolves_until: period.dissolve_until,
        whole: period.whole.as_ref().map(ToString::to_string),
        objects: objects.collect(),
    }
}

fn tell(event: &Event<'_>) {
    let Event::Ended(period) = event else { return };
    let last = period.start + period.length.max(1) - 1;
    let why = period.failed.clone().unwrap_or(period.end.to_string());
    let how = match &period.whole {
        Some(reason) => format!("rendered whole, {reason}"),
        None => format!("{} px", period.threshold_px),
    };
    eprintln!("decor: frames {} to {last} ({how}): {why}", period.start);
}

fn tell_all(done: &StreamDone, args: &StreamArgs, wall_s: f64) {
    eprintln!(
        "decor: {} frames in {}, {} periods: {wall_s:.1} s, {} calls",
        done.frames,
        args.out.display(),
        done.periods.len(),
        done.calls,
    );
}

impl From<StreamError> for Failure {
    fn from(error: StreamError) -> Self {
        match error {
            StreamError::Film(error) => Self::input(error),
            StreamError::Stage(error) => error.into(),
            StreamError::Plan(error) => error.into(),
            StreamError::Render(error) => error.into(),
        }
    }
}

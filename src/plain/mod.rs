//! Plain POV-Ray animations: frame by frame through a pool of processes, or in
//! order by one, where frames depend on each other.
//!
//! A process sleeps for most of a short call, so several run at once ([`pace`]),
//! each with one thread, each with frames that follow each other ([`queue`]). What they
//! write lies in their working folders until they have ended well and the
//! pictures are whole; then it is renamed into place.

mod pace;
mod queue;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use decor_api::{AdapterError, RunContext, Tally};
use decor_povray::plain::{Order, Part, PlainScene};

use crate::frames::write_safely;
use crate::render::{RenderError, Watch, WorkFolder};
use crate::report::Clock;
use pace::Pace;
use queue::Queue;

/// How to render.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where frames go; it exists.
    pub out: PathBuf,
    /// Processes at once, if it was stated.
    pub jobs: Option<usize>,
    /// Processes at once, at most, where it was not.
    pub most: usize,
    /// Where logs are kept, if anywhere.
    pub keep: Option<PathBuf>,
    /// How long one call may take.
    pub timeout: Duration,
    /// Set to stop; set where something fails, so that the others end too.
    pub cancel: Arc<AtomicBool>,
    /// The frames that are wanted.
    pub wanted: BTreeSet<u32>,
    /// One call, with as many threads as the user's options and POV-Ray say.
    pub stock: bool,
}

/// What was done.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Done {
    /// Calls of POV-Ray.
    pub calls: u64,
    /// Pictures in them.
    pub pictures: u64,
}

/// Processes at once, at most, where nobody says otherwise: as many as the
/// adapter says for small pictures. A large one takes memory in each process.
pub fn most_jobs(scene: &PlainScene, small_pictures: usize) -> usize {
    let pixels = u64::from(scene.size.0) * u64::from(scene.size.1);
    let jobs = match pixels {
        0..=0x8_0000 => small_pictures,
        0x8_0001..=0x20_0000 => small_pictures / 2,
        _ => small_pictures / 4,
    };
    jobs.max(1)
}

/// Renders frames.
///
/// # Errors
/// The first thing that went wrong; frames that were finished before stay.
pub fn render(
    scene: &PlainScene,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Done, RenderError> {
    let (Some(&first), Some(&last)) = (options.wanted.first(), options.wanted.last()) else {
        return Ok(Done::default());
    };
    let work = WorkFolder::new(options.keep.as_deref())?;
    let tally = Arc::new(Tally::default());
    let run = RunContext {
        work: work.path.clone(),
        keep: options.keep.is_some(),
        timeout: options.timeout,
        threads: None,
        cancel: Arc::clone(&options.cancel),
        tally: Arc::clone(&tally),
    };
    let delivery = Delivery {
        scene,
        options,
        watch,
    };
    let chained = scene.order != Order::Free;
    if chained || options.stock {
        // What earlier frames leave is made by rendering them.
        let first = if chained { scene.frames.first } else { first };
        let part = Part {
            first,
            last,
            threads: None,
        };
        delivery.part(part, &run)?;
    } else {
        pool(&delivery, &run)?;
    }
    let (calls, pictures) = tally.read();
    Ok(Done { calls, pictures })
}

/// Renders in any order.
fn pool(delivery: &Delivery<'_>, run: &RunContext) -> Result<(), RenderError> {
    let options = delivery.options;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let frames = options.wanted.len();
    let (stated, most) = (options.jobs, options.most.min(frames));
    // Fewer frames than cores: the cores share a frame.
    let threads = if frames < cores { None } else { Some(1) };
    let clock = Clock::start();
    let state = Mutex::new(State {
        queue: Queue::new(&options.wanted, delivery.scene.frames.step),
        pace: Pace::first(stated, most, cores),
        done: 0,
        failure: None,
    });
    let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
    let work = |worker: usize| {
        while !run.is_cancelled() {
            let part = {
                let mut state = lock();
                if state.queue.is_empty() {
                    return;
                }
                if worker < state.pace.processes {
                    let pace = state.pace;
                    state.queue.take(&pace)
                } else {
                    None
                }
            };
            let Some((first, last)) = part else {
                // Not needed now; perhaps when the first frames are done.
                std::thread::sleep(IDLE);
                continue;
            };
            let part = Part {
                first,
                last,
                threads,
            };
            match delivery.part(part, run) {
                Ok(count) => {
                    let mut state = lock();
                    state.done += count;
                    let each_s = clock.cpu_s() / state.done as f64;
                    state.pace = Pace::after(each_s, stated, most, cores);
                }
                Err(error) => {
                    lock().failure.get_or_insert(error);
                    run.cancel.store(true, Ordering::Relaxed);
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for worker in 0..stated.unwrap_or(most).min(frames) {
            let work = &work;
            scope.spawn(move || work(worker));
        }
    });
    let state = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    match state.failure {
        Some(error) => Err(error),
        None if run.is_cancelled() => Err(AdapterError::Cancelled.into()),
        None => Ok(()),
    }
}

/// Between two looks of a worker that is not needed.
const IDLE: Duration = Duration::from_millis(20);

/// What the workers share.
struct State {
    queue: Queue,
    pace: Pace,
    /// Frames that are in their places.
    done: u64,
    failure: Option<RenderError>,
}

/// Puts finished frames where they belong.
struct Delivery<'a> {
    scene: &'a PlainScene,
    options: &'a Options,
    watch: Watch<'a>,
}

impl Delivery<'_> {
    /// Renders a part and delivers its frames; gives their number.
    fn part(&self, part: Part, run: &RunContext) -> Result<u64, RenderError> {
        let files = self.scene.render(part, run)?;
        let count = files.len() as u64;
        for (frame, file) in files {
            let leave = self.scene.leaves_pictures();
            if self.options.wanted.contains(&frame) {
                let place = self.options.out.join(self.scene.name(frame));
                self.deliver(&file, &place)?;
                (self.watch)(frame, &place);
            }
            if !leave {
                let _ = std::fs::remove_file(&file);
            }
        }
        Ok(count)
    }

    fn deliver(&self, file: &Path, place: &Path) -> Result<(), RenderError> {
        if !self.scene.leaves_pictures() && std::fs::rename(file, place).is_ok() {
            return Ok(());
        }
        if same_file(file, place) {
            // POV-Ray's own place is the one that was asked for.
            return Ok(());
        }
        // Another file system, or a picture that stays: a copy.
        let bytes = std::fs::read(file).map_err(|source| AdapterError::BadOutput {
            program: "povray".into(),
            file: file.to_owned(),
            reason: source.to_string(),
        })?;
        Ok(write_safely(place, &bytes)?)
    }
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

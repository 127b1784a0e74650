//! Plain POV-Ray animations: frame by frame through a pool of processes, or in
//! order by one, where frames depend on each other.
//!
//! A process sleeps for most of a short call, so many run at once, each with one
//! thread, each with a few frames that follow each other ([`queue`]). What they
//! write lies in their working folders until they have ended well and the
//! pictures are whole; then it is renamed into place.

mod queue;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use decor_api::{AdapterError, RunContext, Tally};
use decor_povray::plain::{Order, Part, PlainScene};

use crate::frames::write_safely;
use crate::render::{RenderError, Watch, WorkFolder};
use queue::Queue;

/// How to render.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where frames go; it exists.
    pub out: PathBuf,
    /// Processes at once.
    pub jobs: usize,
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

/// Processes at once, where nobody says otherwise: as many as the adapter says
/// for small pictures. A large one keeps its core busy by itself: more processes
/// would take turns, and memory.
pub fn default_jobs(scene: &PlainScene, small_pictures: usize) -> usize {
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
    let jobs = options.jobs.min(frames);
    // Fewer frames than cores: the cores share a frame.
    let threads = if frames < cores { None } else { Some(1) };
    let queue = Mutex::new(Queue::new(
        &options.wanted,
        delivery.scene.frames.step,
        jobs,
    ));
    let failure: Mutex<Option<RenderError>> = Mutex::new(None);
    // Thousandths of a second that a frame took, at the last look.
    let frame_ms = AtomicU64::new(0);
    let lock_queue = || queue.lock().unwrap_or_else(PoisonError::into_inner);
    std::thread::scope(|scope| {
        for worker in 0..jobs {
            let (lock_queue, failure, frame_ms) = (&lock_queue, &failure, &frame_ms);
            scope.spawn(move || {
                loop {
                    let ms = frame_ms.load(Ordering::Relaxed);
                    if is_surplus(worker, cores, jobs, ms) || run.is_cancelled() {
                        return;
                    }
                    let Some((first, last)) = lock_queue().take(ms) else {
                        return;
                    };
                    let started = Instant::now();
                    match delivery.part(
                        Part {
                            first,
                            last,
                            threads,
                        },
                        run,
                    ) {
                        Ok(count) => {
                            let ms = started.elapsed().as_millis() as u64 / count.max(1);
                            frame_ms.store(ms, Ordering::Relaxed);
                        }
                        Err(error) => {
                            let mut kept = failure.lock().unwrap_or_else(PoisonError::into_inner);
                            kept.get_or_insert(error);
                            run.cancel.store(true, Ordering::Relaxed);
                            return;
                        }
                    }
                }
            });
        }
    });
    match failure.into_inner().unwrap_or_else(PoisonError::into_inner) {
        Some(error) => Err(error),
        None if run.is_cancelled() => Err(AdapterError::Cancelled.into()),
        None => Ok(()),
    }
}

/// Processes help while they sleep. Where a frame keeps a core busy for seconds,
/// two a core fill the gaps, and further ones only take memory.
fn is_surplus(worker: usize, cores: usize, jobs: usize, frame_ms: u64) -> bool {
    const ASLEEP_MS: u64 = 400;
    let at_once = jobs.div_ceil(cores).max(1) as u64;
    // With so many at once a frame of no work at all would take this long.
    let busy = frame_ms / at_once > 4 * ASLEEP_MS;
    busy && worker >= 2 * cores
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

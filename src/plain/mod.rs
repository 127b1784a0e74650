//! Plain POV-Ray animations: frame by frame through a pool of processes, or in
//! order by one, where frames depend on each other.
//!
//! A process sleeps for most of a short call, so several run at once ([`ramp`],
//! [`pace`]), each with one thread, each with frames that follow each other ([`queue`]). What they
//! write lies in their working folders until they have ended well and the
//! pictures are whole; then it is renamed into place.

mod coherent;
mod delivery;
mod pace;
mod pool;
mod queue;
mod ramp;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use decor_api::{RunContext, Tally};
use decor_povray::PovRay;
use decor_povray::plain::{Order, Part, PlainScene};

use crate::render::{RenderError, Watch, WorkFolder};
use delivery::Delivery;
use pace::Pace;
use pool::{Workers, pool};

pub use coherent::{Costs, Forecast, Look, forecast};

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
    /// How.
    pub way: Way,
}

/// How frames are made; they are the same.
#[derive(Clone, Debug)]
pub enum Way {
    /// One call, with as many threads as the user's options and POV-Ray say.
    Stock,
    /// Each frame whole, or in order where they depend on each other.
    Whole,
    /// What is the same in several frames once, where that pays.
    Coherent {
        /// What the scene's text says.
        look: Box<Look>,
        /// Also where it does not pay.
        always: bool,
    },
}

/// What was done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Done {
    /// Calls of POV-Ray.
    pub calls: u64,
    /// Pictures in them.
    pub pictures: u64,
    /// Pixels of frames that were traced whole.
    pub whole_pixels: u64,
    /// Pixels of blocks that were traced in the others, and to know which.
    pub block_pixels: u64,
    /// The share of blocks that may change, where it was found out.
    pub dirty: Option<f64>,
    /// Frames that show the same as others, and were not rendered.
    pub repeated: u64,
    /// Why frames were rendered whole, if they were.
    pub whole: Vec<String>,
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
    povray: &PovRay,
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
        repeated: &BTreeMap::new(),
    };
    let chained = scene.order != Order::Free;
    let mut done = Done::default();
    match &options.way {
        Way::Coherent { look, always } if !chained => {
            done = coherent::render(povray, &delivery, look, *always, &run)?;
        }
        Way::Whole | Way::Coherent { .. } if !chained => {
            whole(&delivery, &options.wanted, None, &run)?;
        }
        _ => {
            // What earlier frames leave is made by rendering them.
            let first = if chained { scene.frames.first } else { first };
            let part = Part {
                first,
                last,
                threads: None,
            };
            delivery.part(part, &run)?;
        }
    }
    (done.calls, done.pictures) = tally.read();
    if done.whole_pixels == 0 {
        let pixels = u64::from(scene.size.0) * u64::from(scene.size.1);
        done.whole_pixels = done.pictures * pixels;
    }
    Ok(done)
}

fn workers(delivery: &Delivery<'_>, frames: usize) -> Workers {
    let options = delivery.options;
    Workers {
        stated: options.jobs,
        most: options.most.min(frames),
        cores: std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// Renders frames whole, in any order; `each_s`, where it is known, is what one
/// takes.
fn whole(
    delivery: &Delivery<'_>,
    frames: &BTreeSet<u32>,
    each_s: Option<f64>,
    run: &RunContext,
) -> Result<(), RenderError> {
    let workers = workers(delivery, frames.len());
    // Fewer frames than cores: the cores share a frame.
    let threads = if frames.len() < workers.cores && each_s.is_none() {
        None
    } else {
        Some(1)
    };
    let pace = each_s.map(|each_s| Pace::of(each_s, &workers));
    let step = delivery.scene.frames.step;
    pool(
        frames,
        &[],
        step,
        usize::MAX,
        pace,
        workers,
        run,
        None,
        |first, last| {
            let part = Part {
                first,
                last,
                threads,
            };
            delivery.part(part, run)
        },
    )
}

//! Executes a plan: calls the renderer, merges, writes frames.
//!
//! Periods are begun in order. At the joint between two of them the décor of the
//! next is rendered, and what that of the last has turned into; then the frames,
//! in chunks, each a few calls of the renderer. As many calls run at once as the
//! adapter says; a frame is merged and written as soon as its layers and its
//! décor are there, and then forgotten. Until then its layers are the renderer's
//! files: a few frames are in memory at once, whatever the film's length.

mod behind;
mod called;
mod chunk;
mod common;
mod execution;
mod ground;
mod influenced;
mod joint;
mod pace;
mod schedule;
mod shading;
mod shown;
mod slots;
mod spared;
mod surfaces;

pub(crate) use execution::{Execution, join};
pub(crate) use ground::PeriodGround;
pub(crate) use joint::{Joint, Wanted};
pub(crate) use slots::Slots;

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use decor_api::{AdapterError, PictureFormat, RunContext, Tally};
use serde::Serialize;

use crate::frames::WriteError;
use crate::plan::{Plan, jobs};
use crate::stage::Stage;

/// Why there are no frames.
#[derive(Debug, thiserror::Error)]
pub enum RenderError {
    /// The renderer, or a file that it needs.
    #[error(transparent)]
    Adapter(#[from] AdapterError),
    /// A frame could not be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A folder could not be made.
    #[error("{} cannot be made", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
}

/// How to execute a plan.
#[derive(Clone, Debug)]
pub struct Options {
    /// Where frames go; it exists.
    pub out: PathBuf,
    /// Their format.
    pub format: PictureFormat,
    /// Calls at once; `None`: what the adapter says.
    pub jobs: Option<usize>,
    /// Where scene files and logs are kept, if anywhere.
    pub keep: Option<PathBuf>,
    /// How long one call may take.
    pub timeout: Duration,
    /// Of the dissolve.
    pub seed: u64,
    /// Set to stop.
    pub cancel: Arc<AtomicBool>,
    /// Frames that are there already.
    pub skip: BTreeSet<u32>,
}

/// Pixels that the renderer was asked for, by pass; antialiasing is not counted.
#[derive(Debug, Default)]
pub struct Traced {
    decor: AtomicU64,
    fast: AtomicU64,
    depth: AtomicU64,
    shadow: AtomicU64,
    blocks: AtomicU64,
    whole: AtomicU64,
}

/// The same as numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct TracedPixels {
    /// The décors' colours.
    pub decor: u64,
    /// The fast layers' colours.
    pub fast: u64,
    /// All depths.
    pub depth: u64,
    /// Shadow maps.
    pub shadow: u64,
    /// Blocks rendered again from the full scene.
    pub blocks: u64,
    /// Frames rendered whole.
    pub whole: u64,
}

impl TracedPixels {
    /// All of them.
    pub fn total(&self) -> u64 {
        self.decor + self.fast + self.depth + self.shadow + self.blocks + self.whole
    }
}

impl Traced {
    /// What was counted so far.
    pub fn read(&self) -> TracedPixels {
        let get = |counter: &AtomicU64| counter.load(Ordering::Relaxed);
        TracedPixels {
            decor: get(&self.decor),
            fast: get(&self.fast),
            depth: get(&self.depth),
            shadow: get(&self.shadow),
            blocks: get(&self.blocks),
            whole: get(&self.whole),
        }
    }
}

/// What was done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Done {
    /// Frames that were written.
    pub frames: u64,
    /// Calls of the renderer.
    pub calls: u64,
    /// Pictures in them.
    pub pictures: u64,
    /// Pixels traced.
    pub traced: TracedPixels,
}

/// Is told of every finished frame, from any thread.
pub type Watch<'a> = &'a (dyn Fn(u32, &std::path::Path) + Sync);

/// Renders the frames of a plan.
///
/// # Errors
/// The first thing that went wrong; frames that were finished before stay.
pub fn render(
    stage: &Stage,
    plan: &Plan,
    options: &Options,
    watch: Watch<'_>,
) -> Result<Done, RenderError> {
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
    let jobs = options.jobs.unwrap_or_else(|| jobs(stage)).max(1);
    let execution = execution::Execution {
        stage,
        plan,
        options,
        run,
        slots: slots::Slots::new(jobs),
        hands: slots::Slots::new(execution::frames_in_hand(stage.size().pixels())),
        traced: Traced::default(),
        watch,
        written: AtomicU64::new(0),
        jobs,
        keep_colours: false,
        // Many calls run at once.
        threads: Some(1),
    };
    schedule::run(&execution)?;
    let (calls, pictures) = tally.read();
    Ok(Done {
        frames: execution.written.load(Ordering::Relaxed),
        calls,
        pictures,
        traced: execution.traced.read(),
    })
}

/// The folder that the renderer works in: temporary, unless it is kept.
pub struct WorkFolder {
    /// Where it is.
    pub path: PathBuf,
    _temporary: Option<tempfile::TempDir>,
}

impl WorkFolder {
    /// Makes it: at `keep`, or somewhere temporary.
    ///
    /// # Errors
    /// [`RenderError::Folder`].
    pub fn new(keep: Option<&std::path::Path>) -> Result<Self, RenderError> {
        match keep {
            Some(path) => {
                let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
                std::fs::create_dir_all(&path).map_err(|source| RenderError::Folder {
                    path: path.clone(),
                    source,
                })?;
                Ok(Self {
                    path,
                    _temporary: None,
                })
            }
            None => {
                let folder = tempfile::Builder::new().prefix("decor-").tempdir();
                let temporary = folder.map_err(|source| RenderError::Folder {
                    path: std::env::temp_dir(),
                    source,
                })?;
                Ok(Self {
                    path: temporary.path().to_owned(),
                    _temporary: Some(temporary),
                })
            }
        }
    }
}

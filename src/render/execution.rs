//! What all calls of a run share.

use std::sync::atomic::{AtomicU64, Ordering};

use decor_api::{AdapterError, Layer, LayerRequest, PictureFormat, RunContext};

use super::called::Left;
use super::slots::Slots;
use super::{Options, RenderError, Traced, Watch};
use crate::frames::Encoder;
use crate::plan::{Period, Plan};
use crate::stage::Stage;

/// Everything that the calls need.
pub struct Execution<'a> {
    pub stage: &'a Stage,
    pub plan: &'a Plan,
    pub options: &'a Options,
    pub run: RunContext,
    pub slots: Slots,
    /// Frames whose layers are in memory.
    pub hands: Slots,
    pub traced: Traced,
    pub watch: Watch<'a>,
    pub written: AtomicU64,
    pub jobs: usize,
    /// Are the décors' colours kept, where the planned frames need them no more?
    pub keep_colours: bool,
    /// Threads of a call that renders frames; `None`: all that there are.
    pub threads: Option<usize>,
}

impl Execution<'_> {
    pub fn period(&self, index: usize) -> &Period {
        &self.plan.periods[index]
    }

    pub fn encoder(&self) -> Encoder<'_> {
        Encoder {
            adapter: &*self.stage.adapter,
            format: self.options.format,
        }
    }

    /// Is the depth of every frame wanted?
    pub fn with_depth(&self) -> bool {
        self.options.format == PictureFormat::Exr
    }

    /// Makes other calls stop: the run has failed.
    pub fn give_up(&self) {
        self.run.cancel.store(true, Ordering::Relaxed);
    }

    /// One call of the renderer, when it is its turn.
    pub fn call(
        &self,
        request: &LayerRequest<'_>,
        threads: Option<usize>,
    ) -> Result<Vec<Layer>, RenderError> {
        let _slot = self.slots.take();
        Ok(self.stage.adapter.render(request, &self.run_of(threads))?)
    }

    /// The same, to be read when it is needed: as finished pictures, where those
    /// are enough (`encoded`) and the renderer has them.
    pub fn call_to_read<'r>(
        &'r self,
        request: &'r LayerRequest<'_>,
        encoded: bool,
        threads: Option<usize>,
    ) -> Result<Left<'r>, RenderError> {
        let _slot = self.slots.take();
        let (adapter, run) = (&self.stage.adapter, self.run_of(threads));
        if encoded {
            let pictures = adapter.pictures(request, self.options.format, &run)?;
            if let Some(pictures) = pictures {
                return Ok(Left::Pictures(pictures));
            }
        }
        Ok(Left::Layers(adapter.render_to_read(request, &run)?))
    }

    fn run_of(&self, threads: Option<usize>) -> RunContext {
        RunContext {
            threads,
            ..self.run.clone()
        }
    }
}

/// How many frames are put together at once, for pictures of so many pixels: a
/// large one is 30 bytes a pixel in hand, and more than two at once are of use
/// only where they are small and many.
pub fn frames_in_hand(pixels: usize) -> usize {
    const HELD_PIXELS: usize = 1 << 20;
    const MOST: usize = 64;
    (HELD_PIXELS / pixels.max(1)).clamp(2, MOST)
}

/// The only layer of a call.
pub fn only(layers: Vec<Layer>) -> Result<Layer, AdapterError> {
    layers
        .into_iter()
        .next()
        .ok_or_else(|| AdapterError::BadOutput {
            program: "the renderer".into(),
            file: "the décor".into(),
            reason: "it is missing".into(),
        })
}

/// The result of a thread; its panic goes on in this one.
pub fn join<T>(handle: std::thread::ScopedJoinHandle<'_, T>) -> T {
    match handle.join() {
        Ok(value) => value,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

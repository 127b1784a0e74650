//! The summary of a render: the last line of `--json`, and `decor.json`.

use std::time::Instant;

use nix::sys::resource::{UsageWho, getrusage};
use serde::Serialize;

use crate::plan::{End, Plan, Prediction};
use crate::render::TracedPixels;
use crate::segmentation::Class;
use crate::verify::Verified;

/// Objects of a period by class.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ObjectCounts {
    /// Part of the décor: does not move.
    pub immobile: usize,
    /// Part of the décor: out of view.
    pub clipped: usize,
    /// Part of the décor: moves by the threshold at most.
    pub slow: usize,
    /// Rendered in every frame.
    pub fast: usize,
}

/// A period.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PeriodSummary {
    /// Its first frame.
    pub start: u32,
    /// Frames that it serves.
    pub length: u32,
    /// Objects move so far in the picture, in pixels, and stay in its décor.
    pub threshold_px: f64,
    /// The frame that its décor dissolves towards, where it does.
    pub dissolves_until: Option<u32>,
    /// Why it is not longer.
    pub end: End,
    /// Of a stream: what was not as predicted, where that ended it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed: Option<String>,
    /// Its objects.
    pub objects: ObjectCounts,
    /// Why its frames are rendered whole, where they are.
    pub whole: Option<String>,
}

/// Everything about a render.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename = "summary")]
pub struct Summary {
    /// The version of decor.
    pub decor: String,
    /// The film's file.
    pub film: String,
    /// Frames of the run.
    pub frames: u64,
    /// Of those, frames that an earlier run had left.
    pub frames_kept: u64,
    /// The number of the first frame.
    pub first_frame: u32,
    /// Columns of a frame.
    pub width: u32,
    /// Rows of a frame.
    pub height: u32,
    /// The adapter.
    pub renderer: String,
    /// The renderer's version.
    pub renderer_version: String,
    /// `full`, `exact`, `equivalent`, `preview` or `baseline`.
    pub mode: String,
    /// Objects may move so far, in pixels, and stay in the décor.
    pub threshold_px: f64,
    /// `png`, `png16` or `exr`.
    pub format: String,
    /// The periods.
    pub periods: Vec<PeriodSummary>,
    /// Seconds on the clock.
    pub wall_s: f64,
    /// Seconds of all cores, the renderer's included.
    pub cpu_s: f64,
    /// Calls of the renderer.
    pub renderer_calls: u64,
    /// Pictures that it drew in them.
    pub renderer_frames: u64,
    /// Pixels that it was asked for, by pass.
    pub pixels_traced: TracedPixels,
    /// Pixels that frame by frame would have traced.
    pub pixels_full: u64,
    /// What it was to cost, and what it did.
    pub prediction: Option<Prediction>,
    /// Was frame by frame chosen in place of what was asked for?
    pub fallback: bool,
    /// What came of the frames that were rendered plainly too, where some were.
    pub verified: Option<Verified>,
    /// The same job has the same frames: for `--resume`.
    pub job: String,
}

/// The periods of a plan as the summary shows them.
pub fn period_summaries(plan: &Plan) -> Vec<PeriodSummary> {
    plan.periods
        .iter()
        .map(|period| PeriodSummary {
            start: period.start,
            length: period.len(),
            threshold_px: period.threshold_px,
            dissolves_until: period.dissolve_until,
            end: period.end,
            failed: None,
            objects: ObjectCounts {
                immobile: period.count(Class::Immobile),
                clipped: period.count(Class::Clipped),
                slow: period.count(Class::Slow),
                fast: period.count(Class::Fast),
            },
            whole: period.whole.as_ref().map(ToString::to_string),
        })
        .collect()
}

/// Measures wall and CPU time from its beginning.
pub struct Clock {
    wall: Instant,
    cpu_s: f64,
}

impl Clock {
    /// Begins to measure.
    pub fn start() -> Self {
        Self {
            wall: Instant::now(),
            cpu_s: cpu_s(),
        }
    }

    /// Seconds on the clock since then.
    pub fn wall_s(&self) -> f64 {
        self.wall.elapsed().as_secs_f64()
    }

    /// Seconds of all cores since then, those of ended child processes included.
    pub fn cpu_s(&self) -> f64 {
        cpu_s() - self.cpu_s
    }
}

fn cpu_s() -> f64 {
    let of = |who| {
        getrusage(who).map_or(0.0, |usage| {
            let seconds =
                |t: nix::sys::time::TimeVal| t.tv_sec() as f64 + t.tv_usec() as f64 * 1e-6;
            seconds(usage.user_time()) + seconds(usage.system_time())
        })
    };
    of(UsageWho::RUSAGE_SELF) + of(UsageWho::RUSAGE_CHILDREN)
}

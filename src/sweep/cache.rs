//! What a sweep keeps in its folder: frames and times by all that they depend on,
//! so that a sweep that was interrupted goes on, and a larger one begins with what
//! is there.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::SweepError;
use crate::frames::write_safely;
use crate::plan::{FramePlan, Period, Plan, Price};
use crate::probe::Probed;
use crate::report::Summary;

/// Written last: where it is, the frames beside it are complete.
const DONE: &str = "made.json";

/// Frames that were made, and what that took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Made {
    /// What every run took.
    pub runs: Vec<Price>,
    /// Calls of the renderer.
    pub calls: u64,
    /// Pictures in them.
    pub pictures: u64,
    /// Pixels that the renderer was asked for, by pass.
    pub traced: BTreeMap<String, u64>,
    /// Pixels that frame by frame traces.
    pub full: u64,
}

impl Made {
    /// Of the summaries of some runs of one job.
    pub fn of(summaries: &[Summary]) -> Option<Self> {
        let last = summaries.last()?;
        let traced = serde_json::to_value(last.pixels_traced).ok()?;
        Some(Self {
            runs: summaries
                .iter()
                .map(|summary| Price {
                    wall_s: summary.wall_s,
                    cpu_s: summary.cpu_s,
                })
                .collect(),
            calls: last.renderer_calls,
            pictures: last.renderer_frames,
            traced: serde_json::from_value(traced).ok()?,
            full: last.pixels_full,
        })
    }

    /// The medians of the runs.
    pub fn price(&self) -> Price {
        let median = |of: fn(&Price) -> f64| {
            let mut values: Vec<f64> = self.runs.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            match values.len() {
                0 => 0.0,
                n => (values[(n - 1) / 2] + values[n / 2]) / 2.0,
            }
        };
        Price {
            wall_s: median(|run| run.wall_s),
            cpu_s: median(|run| run.cpu_s),
        }
    }

    /// Pixels that the renderer was asked for.
    pub fn traced(&self) -> u64 {
        self.traced.values().sum()
    }
}

/// The folder.
pub struct SweepCache {
    root: PathBuf,
}

impl SweepCache {
    /// In the folder of a sweep.
    pub fn new(out: &Path) -> Self {
        Self {
            root: out.join("cache"),
        }
    }

    /// Where the frames of a key are.
    pub fn folder(&self, key: &str) -> PathBuf {
        self.root.join(key)
    }

    /// What was made under a key, at least so many times.
    pub fn find(&self, key: &str, runs: usize) -> Option<Made> {
        let text = std::fs::read_to_string(self.folder(key).join(DONE)).ok()?;
        let made: Made = serde_json::from_str(&text).ok()?;
        (made.runs.len() >= runs).then_some(made)
    }

    /// Frames of a key are about to be made: what is noted of them no longer holds.
    pub fn begin(&self, key: &str) {
        let _ = std::fs::remove_file(self.folder(key).join(DONE));
    }

    /// They are complete.
    pub fn keep(&self, key: &str, made: &Made) -> Result<(), SweepError> {
        self.write(&self.folder(key).join(DONE), made)
    }

    /// The costs that a sweep began with: those that others find out meanwhile
    /// would make other plans.
    pub fn costs(
        &self,
        key: &str,
        find: impl FnOnce() -> Result<Probed, SweepError>,
    ) -> Result<Probed, SweepError> {
        let path = self.root.join(format!("costs-{key}.json"));
        let kept = std::fs::read_to_string(&path).ok();
        if let Some((costs, from)) = kept.and_then(|text| serde_json::from_str(&text).ok()) {
            let price = Price::default();
            return Ok(Probed { costs, from, price });
        }
        let found = find()?;
        std::fs::create_dir_all(&self.root).map_err(|source| crate::frames::WriteError::Io {
            path: self.root.clone(),
            source,
        })?;
        self.write(&path, &(found.costs, found.from))?;
        Ok(found)
    }

    fn write(&self, path: &Path, value: &impl Serialize) -> Result<(), SweepError> {
        let text = serde_json::to_string_pretty(value)? + "\n";
        Ok(write_safely(path, text.as_bytes())?)
    }
}

/// The first digits of a hash: enough for a folder's name.
pub fn key(words: &str) -> String {
    blake3::hash(words.as_bytes()).to_hex()[..16].to_owned()
}

/// All of a plan that its frames depend on: two plans with the same have the same
/// frames, whatever the thresholds that led to them. Only where shadows fall, what
/// they may touch is found out by the threshold while rendering.
pub fn same_frames(plan: &Plan) -> String {
    let part = |period: &Period| {
        let objects: Vec<String> = period
            .objects
            .iter()
            .map(|object| format!("{:?}{}", object.object, object.class.in_decor()))
            .collect();
        let sky = period.sky.map(|sky| sky.class.in_decor());
        let (start, until) = (period.start, period.dissolve_until);
        let shades = |frame: &FramePlan| match frame {
            FramePlan::Layered { shadows, .. } => shadows.is_some(),
            FramePlan::Whole => false,
        };
        let shaded = period
            .frames
            .iter()
            .any(shades)
            .then_some(period.threshold_px);
        format!(
            "{start} {:?} {until:?} {sky:?} {shaded:?} {objects:?};",
            period.frames
        )
    };
    let layered = plan.periods.iter().any(Period::has_decor);
    // Where all frames are whole, the mode makes no difference, nor do joints.
    if layered {
        let parts: String = plan.periods.iter().map(part).collect();
        format!("{} {parts}", plan.wishes.mode)
    } else {
        "whole".to_owned()
    }
}

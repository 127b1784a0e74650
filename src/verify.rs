//! Verification: some frames of a finished film rendered plainly too, and
//! compared.

use std::collections::BTreeSet;
use std::path::Path;

use serde::Serialize;

use crate::compare::folders::Match;
use crate::compare::verdict::{Limit, Preset, Tolerances, Verdict};
use crate::compare::{CompareError, Comparison, Entry, Options, compare_matches};
use crate::frames::{WriteError, name};
use crate::job::{Job, JobError};
use crate::plan::{Mode, Period, Plan, Wishes, plan};
use crate::probe::Probed;
use crate::render::WorkFolder;
use crate::report::Clock;
use crate::stage::Stage;

/// What came of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verified {
    /// The frames that were rendered plainly too.
    pub frames: Vec<u32>,
    /// Is every one of them within the tolerance?
    pub passed: bool,
    /// Those that are not.
    pub failed: Vec<u32>,
    /// A pixel differs where a channel differs by more than this.
    pub tolerance: f64,
    /// So many percent of a frame's pixels may differ.
    pub tolerance_percent: f64,
    /// The largest difference.
    pub max: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// In decibels; null where nothing differs.
    pub psnr: Option<f64>,
    /// Pixels above the tolerance.
    pub differing: u64,
    /// Their share, 0..1.
    pub share_above: f64,
    /// The frame that differs most.
    pub worst: Option<u32>,
    /// What the verification took on the clock, in seconds.
    pub wall_s: f64,
    /// Seconds of all cores.
    pub cpu_s: f64,
}

/// What is tolerated where nobody says otherwise: nothing of a mode that promises
/// the renderer's own frames, else what Blender's render tests tolerate.
pub fn default_limit(mode: Mode) -> Limit {
    match mode {
        Mode::Full | Mode::Exact => Limit {
            level: 0.0,
            percent: 0.0,
        },
        Mode::Equivalent | Mode::Preview => Preset::Blender.tolerances().fail,
    }
}

/// So many frames of a plan, at most all of them, spread over the film: middles of
/// periods, last frames before a joint and first ones after it. Of periods with a
/// décor, where there is one.
pub fn spread(plan: &Plan, count: usize) -> BTreeSet<u32> {
    let layered: Vec<&Period> = plan.periods.iter().filter(|p| p.has_decor()).collect();
    let periods = if layered.is_empty() {
        plan.periods.iter().collect()
    } else {
        layered
    };
    let last = |p: &&Period| p.start + p.len() - 1;
    let kinds: [Vec<u32>; 3] = [
        periods.iter().map(|p| p.start + p.len() / 2).collect(),
        periods.iter().map(last).collect(),
        periods.iter().map(|p| p.start).collect(),
    ];
    let mut chosen = BTreeSet::new();
    for (kind, frames) in kinds.iter().enumerate() {
        chosen.extend(evenly(frames, (count + 2 - kind) / 3));
    }
    // Where kinds fall together, or there are more frames to look at than joints
    // and middles: any others, as far from each other as can be.
    let all: Vec<u32> = plan.periods.iter().flat_map(Period::numbers).collect();
    let mut share = count;
    while chosen.len() < count.min(all.len()) {
        let missing = count.min(all.len()) - chosen.len();
        let more = evenly(&all, share.min(all.len()));
        chosen.extend(
            more.filter(|n| !chosen.contains(n))
                .take(missing)
                .collect::<Vec<_>>(),
        );
        share = share.saturating_mul(2);
    }
    chosen
}

/// So many of a list, evenly spread, from the middles of equal parts.
fn evenly(list: &[u32], count: usize) -> impl Iterator<Item = u32> {
    let count = count.min(list.len());
    (0..count).map(move |k| list[(2 * k + 1) * list.len() / (2 * count)])
}

/// Renders `count` frames of the plan plainly, through the pool, and compares
/// them with those that `job` has written.
///
/// # Errors
/// Where they cannot be rendered. A frame that cannot be compared has failed.
pub fn verify(
    stage: &Stage,
    done: &Plan,
    probed: &Probed,
    job: &Job,
    (count, limit): (usize, Limit),
) -> Result<Verified, JobError> {
    let clock = Clock::start();
    let chosen = spread(done, count);
    let folder = WorkFolder::new(None)?;
    let plain = Job {
        out: folder.path.join("plain"),
        keep: None,
        resume: false,
        ..job.clone()
    };
    plain_frames(stage, &done.wishes, probed, &plain, &chosen)?;
    let options = Options {
        tolerances: Tolerances {
            fail: limit,
            fail_depth: limit.level,
            ..Tolerances::default()
        },
        perception: false,
        ..Options::default()
    };
    let frames: Vec<u32> = chosen.into_iter().collect();
    let comparison = compare_frames(&plain, &job.out, &frames, &options)?;
    let failed = frames.iter().zip(&comparison.entries);
    let failed = failed.filter(|(_, entry)| entry.verdict() > Verdict::Warning);
    let totals = &comparison.totals;
    let psnr = totals.psnr();
    Ok(Verified {
        passed: comparison.verdict <= Verdict::Warning,
        failed: failed.map(|(n, _)| *n).collect(),
        tolerance: limit.level,
        tolerance_percent: limit.percent,
        max: totals.max,
        rms: totals.rms(),
        psnr: psnr.is_finite().then_some(psnr),
        differing: totals.differing,
        share_above: totals.share_above(),
        worst: totals.worst.map(|k| frames[k]),
        frames,
        wall_s: clock.wall_s(),
        cpu_s: clock.cpu_s(),
    })
}

/// Renders single frames whole, through the pool.
///
/// # Errors
/// Where the film lacks them, or the renderer fails.
pub fn plain_frames(
    stage: &Stage,
    wishes: &Wishes,
    probed: &Probed,
    job: &Job,
    frames: &BTreeSet<u32>,
) -> Result<(), JobError> {
    let (Some(&first), Some(&last)) = (frames.first(), frames.last()) else {
        return Ok(());
    };
    let wishes = Wishes {
        mode: Mode::Full,
        threshold_px: 0.0,
        budget: None,
        frames: (first, last),
        ..wishes.clone()
    };
    let whole = plan(stage, wishes, &probed.costs)?;
    job.execute_only(stage, &whole, frames)?;
    Ok(())
}

/// Compares single frames of two folders, in the order given.
///
/// # Errors
/// Where difference pictures are asked for and cannot be written.
pub fn compare_frames(
    plain: &Job,
    out: &Path,
    frames: &[u32],
    options: &Options,
) -> Result<Comparison, JobError> {
    let pair = |n: &u32| {
        let name = name(*n, plain.format);
        Match::Pair {
            a: plain.out.join(&name),
            b: out.join(&name),
            name,
        }
    };
    let pairs = frames.iter().map(pair).collect();
    let nothing = |_: &Entry| {};
    compare_matches(Ok(pairs), (&plain.out, out), options, nothing).map_err(|error| {
        JobError::Write(match error {
            CompareError::Write(error) => error,
            CompareError::DiffAmongFrames { path } => WriteError::Io {
                path,
                source: std::io::ErrorKind::AlreadyExists.into(),
            },
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{End, FramePlan};
    use crate::segmentation::Measure;

    fn plan_of(lengths: &[u32]) -> Plan {
        let mut start = 10;
        let periods = lengths.iter().map(|&length| {
            let period = Period {
                start,
                frames: vec![FramePlan::Whole; length as usize],
                objects: Vec::new(),
                resting: std::collections::HashSet::new(),
                threshold_px: 1.0,
                still: false,
                before: false,
                sky: None,
                dissolve_until: None,
                end: End::Asked,
                whole: None,
            };
            start += length;
            period
        });
        let periods = periods.collect();
        Plan {
            wishes: Wishes {
                mode: Mode::Equivalent,
                threshold_px: 1.0,
                measure: Measure::Bound,
                period: None,
                budget: None,
                shadow_way: crate::plan::ShadowWay::Auto,
                frames: (10, start - 1),
                with_depth: false,
                fallback: true,
            },
            periods,
        }
    }

    #[test]
    fn frames_are_spread_over_joints_and_middles() {
        let plan = plan_of(&[8, 8, 8]);
        // The middle, the end and the beginning of the period in the middle.
        assert_eq!(spread(&plan, 3), BTreeSet::from([18, 22, 25]));
        let nine = BTreeSet::from([10, 14, 17, 18, 22, 25, 26, 30, 33]);
        assert_eq!(spread(&plan, 9), nine);
    }

    #[test]
    fn as_many_as_asked_for_and_there_are() {
        for lengths in [&[1][..], &[1, 1, 1], &[5], &[2, 9, 1, 30]] {
            let plan = plan_of(lengths);
            let all: u32 = lengths.iter().sum();
            for count in 1..60 {
                let chosen = spread(&plan, count);
                assert_eq!(chosen.len(), count.min(all as usize), "{lengths:?} {count}");
                assert!(chosen.iter().all(|n| (10..10 + all).contains(n)));
            }
        }
    }
}

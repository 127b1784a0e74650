//! Which frames of a plan are looked at, and what they say of all of them.
//!
//! The error of a layered film comes and goes with its periods: there is none in the
//! frame that a décor shows, most in the middle of one that dissolves, or at the end
//! of one that does not. A few periods, spread over the film, are looked at where
//! they begin, in between and where they end; between those frames the error is
//! taken for a straight line, and periods that are not looked at for the mean of the
//! others. Frames that are rendered whole have no error.

use std::collections::{BTreeMap, BTreeSet};

use super::target::Metric;
use crate::plan::{Period, Plan};

/// Periods that are looked at.
const PERIODS: usize = 3;
/// Steps between the frames of a long one.
const STEPS: u32 = 4;
/// Between the frames looked at an error is no straight line.
const UNEVEN: f64 = 0.1;
/// Standard errors in a margin: about one film in forty is worse.
const SURE: f64 = 2.0;
/// The margin where only one of several periods was seen, as a share.
const ONE_OF_MANY: f64 = 0.5;

/// Frames of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Sample {
    /// The frames, with neighbours where changes from frame to frame count.
    pub frames: BTreeSet<u32>,
    /// Their periods' numbers.
    pub periods: Vec<usize>,
}

/// What the frames say of the film: losses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Of the film.
    pub loss: f64,
    /// How much worse it may be.
    pub margin: f64,
    /// The standard deviation of the periods.
    pub spread: f64,
}

impl Sample {
    /// The frames to look at; none where no period has a décor.
    pub fn of(plan: &Plan, metric: Metric) -> Self {
        let layered: Vec<usize> = (0..plan.periods.len())
            .filter(|&k| plan.periods[k].has_decor())
            .collect();
        let count = PERIODS.min(layered.len());
        let periods: Vec<usize> = (0..count)
            .map(|k| layered[(2 * k + 1) * layered.len() / (2 * count)])
            .collect();
        let mut frames = BTreeSet::new();
        for &k in &periods {
            let period = &plan.periods[k];
            let (start, last) = (period.start, period.start + period.len() - 1);
            for step in 0..=STEPS {
                let at = start + (last - start) * step / STEPS;
                frames.insert(at);
                if metric == Metric::Flicker {
                    // The frame before: at the start that is before the joint.
                    frames.insert(at.saturating_sub(1).max(plan.wishes.frames.0));
                }
            }
        }
        Self { frames, periods }
    }

    /// The film's loss from those of frames.
    pub fn estimate(&self, plan: &Plan, metric: Metric, losses: &BTreeMap<u32, f64>) -> Estimate {
        let of_period = |&k: &usize| {
            let period = &plan.periods[k];
            let inside: Vec<(u32, f64)> = losses
                .range(period.start..period.start + period.len())
                .map(|(n, loss)| (*n, *loss))
                .collect();
            match metric {
                Metric::Max => inside.iter().map(|(_, loss)| *loss).fold(0.0, f64::max),
                Metric::Flicker => with_joint(period, &inside),
                _ => between(period, &inside),
            }
        };
        let seen: Vec<f64> = self.periods.iter().map(of_period).collect();
        if seen.is_empty() {
            return Estimate::default();
        }
        let n = seen.len() as f64;
        let mean = seen.iter().sum::<f64>() / n;
        let squares: f64 = seen.iter().map(|loss| (loss - mean).powi(2)).sum();
        let spread = if seen.len() > 1 {
            (squares / (n - 1.0)).sqrt()
        } else {
            0.0
        };
        let layered = plan.periods.iter().filter(|period| period.has_decor());
        let (mut count, mut frames, mut known) = (0.0, 0.0, 0.0);
        for period in layered {
            count += 1.0;
            frames += f64::from(period.len());
        }
        for (&k, loss) in self.periods.iter().zip(&seen) {
            known += f64::from(plan.periods[k].len()) * loss;
        }
        let all = plan.periods.iter().map(|p| f64::from(p.len())).sum::<f64>();
        let seen_frames = self
            .periods
            .iter()
            .map(|&k| f64::from(plan.periods[k].len()));
        let unseen = frames - seen_frames.sum::<f64>();
        let many = seen.len() == 1 && count > 1.0;
        if metric == Metric::Max {
            let worst = seen.iter().copied().fold(0.0, f64::max);
            let share = if many { ONE_OF_MANY } else { UNEVEN };
            return Estimate {
                loss: worst,
                margin: share * worst + if count > n { spread } else { 0.0 },
                spread,
            };
        }
        let loss = (known + unseen * mean) / all;
        let share = if many { ONE_OF_MANY } else { UNEVEN };
        // Less the more of the periods were seen.
        let error = spread * ((1.0 - n / count).max(0.0) / n).sqrt();
        Estimate {
            loss,
            margin: share * loss + SURE * error * frames / all,
            spread,
        }
    }
}

/// The mean of a period, by straight lines between the frames that were seen.
fn between(period: &Period, seen: &[(u32, f64)]) -> f64 {
    let (Some(first), Some(last)) = (seen.first(), seen.last()) else {
        return 0.0;
    };
    let at = |n: u32| {
        let after = seen.partition_point(|(m, _)| *m < n);
        match (after.checked_sub(1).map(|k| seen[k]), seen.get(after)) {
            (_, Some((m, loss))) if *m == n => *loss,
            (Some((a, low)), Some((b, high))) => {
                low + (high - low) * f64::from(n - a) / f64::from(b - a)
            }
            (None, _) => first.1,
            (_, None) => last.1,
        }
    };
    period.numbers().map(at).sum::<f64>() / f64::from(period.len())
}

/// The same of changes from frame to frame: the joint before the first frame is not
/// like those inside.
fn with_joint(period: &Period, seen: &[(u32, f64)]) -> f64 {
    let joint = seen.iter().find(|(n, _)| *n == period.start);
    let inside: Vec<f64> = seen
        .iter()
        .filter(|(n, _)| *n != period.start)
        .map(|(_, loss)| *loss)
        .collect();
    let mean = if inside.is_empty() {
        0.0
    } else {
        inside.iter().sum::<f64>() / inside.len() as f64
    };
    let joint = joint.map_or(0.0, |(_, loss)| *loss);
    (joint + mean * f64::from(period.len() - 1)) / f64::from(period.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{End, FramePlan, Mode, WholeReason, Wishes};
    use crate::segmentation::Measure;

    /// Periods of these lengths; a negative one is rendered whole.
    fn plan_of(lengths: &[i32]) -> Plan {
        let mut start = 0;
        let periods = lengths.iter().map(|&length| {
            let period = Period {
                start,
                frames: vec![FramePlan::Whole; length.unsigned_abs() as usize],
                objects: Vec::new(),
                resting: std::collections::HashSet::new(),
                threshold_px: 1.0,
                still: false,
                before: false,
                sky: None,
                dissolve_until: None,
                end: End::Asked,
                whole: (length < 0).then_some(WholeReason::NoGain),
            };
            start += length.unsigned_abs();
            period
        });
        let periods: Vec<Period> = periods.collect();
        Plan {
            wishes: Wishes {
                mode: Mode::Equivalent,
                threshold_px: 1.0,
                measure: Measure::Bound,
                period: None,
                budget: None,
                shadow_way: crate::plan::ShadowWay::Auto,
                frames: (0, start - 1),
                with_depth: false,
                fallback: true,
            },
            periods,
        }
    }

    fn estimate(lengths: &[i32], metric: Metric, loss: impl Fn(u32) -> f64) -> Estimate {
        let plan = plan_of(lengths);
        let sample = Sample::of(&plan, metric);
        let losses = sample.frames.iter().map(|&n| (n, loss(n))).collect();
        sample.estimate(&plan, metric, &losses)
    }

    #[test]
    fn a_straight_line_is_found_exactly() {
        let found = estimate(&[21], Metric::Flip, f64::from);
        assert!((found.loss - 10.0).abs() < 1e-9, "{found:?}");
        assert_eq!(found.spread, 0.0);
    }

    #[test]
    fn whole_frames_have_no_error() {
        let found = estimate(&[-10, 10], Metric::Flip, |_| 1.0);
        assert!((found.loss - 0.5).abs() < 1e-9, "{found:?}");
        assert_eq!(estimate(&[-7], Metric::Flip, |_| 1.0), Estimate::default());
    }

    #[test]
    fn periods_that_differ_make_a_wide_margin() {
        let even = estimate(&[5; 12], Metric::Flip, |_| 0.1);
        let uneven = estimate(&[5; 12], Metric::Flip, |n| f64::from(n) / 300.0);
        assert!(uneven.margin > 3.0 * even.margin, "{even:?} {uneven:?}");
        let film = (0..60).map(|n| f64::from(n) / 300.0).sum::<f64>() / 60.0;
        assert!(film <= uneven.loss + uneven.margin, "{uneven:?} {film}");
    }

    #[test]
    fn joints_flicker_by_themselves() {
        let found = estimate(&[10, 10], Metric::Flicker, |n| {
            if n % 10 == 0 && n > 0 { 1.0 } else { 0.0 }
        });
        assert!((found.loss - 0.05).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn the_largest_is_of_the_worst_frame() {
        let found = estimate(&[9, 9, 9], Metric::Max, f64::from);
        assert_eq!(found.loss, 26.0);
    }
}

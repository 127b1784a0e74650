//! Tuning: the fastest setting that keeps a quality, found with few probes.
//!
//! The error grows with the threshold, so that it is searched for as a root is: from
//! what a probe says, and between the largest threshold that holds and the smallest
//! that does not. A probe plans the film with a threshold and renders some of that
//! plan's frames ([`sample`]), plainly too; plain frames are rendered once. Plans
//! that come out the same are looked at once, and one without a décor has no error.
//! Then the price of the plan decides: a smaller threshold may be cheaper, and holds
//! as well.

pub mod sample;
pub mod target;

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::compare::verdict::{Limit, Tolerances};
use crate::compare::{Entry, Options};
use crate::job::{Job, JobError};
use crate::plan::{Mode, Period, Plan, Prediction, Wishes, plan};
use crate::probe::{self, Probed};
use crate::render::WorkFolder;
use crate::stage::Stage;
use crate::sweep::{Antialiasing, Setting, kept_motion_px, same_frames};
use crate::verify::{compare_frames, plain_frames};
use sample::{Estimate, Sample};
use target::{Metric, Target};

/// Probes at most.
pub const PROBES: usize = 5;
/// Thresholds nearer to each other than this are not told apart.
const NEAR: f64 = 1.12;
/// A step beyond what was seen, at most.
const STEP: f64 = 6.0;
/// And at least.
const LEAST_STEP: f64 = 1.5;
/// Smaller thresholds whose price is looked at, and by what they shrink.
const LADDER: (i32, f64) = (6, std::f64::consts::SQRT_2);
/// A plan has to be so much cheaper to be preferred to one with a larger threshold.
const CHEAPER: f64 = 0.97;

/// What is tuned.
pub struct Tune<'a> {
    /// The film.
    pub stage: &'a Stage,
    /// How frames are made; they go into temporary folders.
    pub job: Job,
    /// The quality.
    pub target: Target,
    /// All but the threshold, which is searched for.
    pub wishes: Wishes,
    /// The smallest and the largest threshold that may be chosen, in pixels.
    pub limits_px: (f64, f64),
    /// A difference above this counts as flicker.
    pub level: f64,
}

/// A threshold that was tried.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Probe {
    /// The threshold, in pixels.
    pub threshold_px: f64,
    /// The predicted value of the film; null where it is infinite.
    pub value: Option<f64>,
    /// The same with its margin: what has to hold.
    pub at_worst: Option<f64>,
    /// Does it?
    pub holds: bool,
    /// Frames that were looked at; 0 where the plan alone tells.
    pub frames: usize,
    /// Their periods, of so many with a décor.
    pub periods: (usize, usize),
    /// Predicted seconds on the clock for the film.
    pub predicted_wall_s: f64,
}

/// How sure the result is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sureness {
    /// It follows from the plan.
    Certain,
    /// Frames of several periods, or of all there are, were looked at.
    Likely,
    /// The largest difference, or one of many periods: a frame that was not looked
    /// at may be worse.
    Guess,
}

/// What was found.
pub struct Tuned {
    /// The quality that was asked for.
    pub target: Target,
    /// The plan that keeps it, with the mode and the threshold.
    pub plan: Plan,
    /// The costs that it was priced by.
    pub probed: Probed,
    /// What it costs.
    pub prediction: Prediction,
    /// The predicted value of the film; none where it is infinite.
    pub value: Option<f64>,
    /// The same with its margin.
    pub at_worst: Option<f64>,
    /// The standard deviation of the periods that were looked at, as a loss.
    pub spread: f64,
    /// How sure that is.
    pub sure: Sureness,
    /// The thresholds that were tried, in that order.
    pub probes: Vec<Probe>,
    /// Frames that were rendered plainly for it.
    pub plain_frames: usize,
}

/// What is known of a plan.
#[derive(Clone, Copy)]
struct Known {
    estimate: Estimate,
    frames: usize,
    periods: (usize, usize),
}

struct Search<'t, 'a> {
    tune: &'t Tune<'a>,
    probed: Probed,
    folder: WorkFolder,
    plain: BTreeSet<u32>,
    known: BTreeMap<String, Known>,
    probes: Vec<Probe>,
    looked: usize,
}

impl Tune<'_> {
    /// Searches.
    ///
    /// # Errors
    /// Where the film cannot be planned, or frames cannot be rendered.
    pub fn run(&self) -> Result<Tuned, JobError> {
        let usual = Wishes {
            threshold_px: Mode::Equivalent.default_threshold_px(),
            ..self.wishes.clone()
        };
        let mut search = Search {
            probed: self.job.costs(self.stage, &usual)?,
            tune: self,
            folder: WorkFolder::new(None)?,
            plain: BTreeSet::new(),
            known: BTreeMap::new(),
            probes: Vec::new(),
            looked: 0,
        };
        let found = if self.target.metric == Metric::Motion {
            Some((self.target.value, None))
        } else {
            search.largest()?.map(|(px, known)| (px, Some(known)))
        };
        search.fastest(found)
    }
}

impl Search<'_, '_> {
    fn plan(&self, mode: Mode, threshold_px: f64) -> Result<Plan, JobError> {
        let wishes = Wishes {
            mode,
            threshold_px,
            ..self.tune.wishes.clone()
        };
        Ok(plan(self.tune.stage, wishes, &self.probed.costs)?)
    }

    fn predict(&self, plan: &Plan) -> Prediction {
        self.tune
            .job
            .prediction(self.tune.stage, plan, &self.probed)
    }

    /// The largest threshold that holds, of those that are tried, and what is known
    /// of it.
    fn largest(&mut self) -> Result<Option<(f64, Known)>, JobError> {
        let (least, most) = self.tune.limits_px;
        let allowed = self.tune.target.loss();
        let mut holds: Option<(f64, Known)> = None;
        let mut fails: Option<f64> = None;
        let mut next = self
            .tune
            .wishes
            .mode
            .default_threshold_px()
            .clamp(least, most);
        loop {
            let Some(known) = self.look(next)? else {
                return Ok(holds);
            };
            let at_worst = known.estimate.loss + known.estimate.margin;
            // The error grows as the threshold does, about; the mean square as its
            // square.
            let power = match self.tune.target.metric {
                Metric::Psnr | Metric::Rms => 0.5,
                _ => 1.0,
            };
            let factor = if at_worst > 0.0 {
                (allowed / at_worst).powf(power).clamp(1.0 / STEP, STEP)
            } else {
                STEP
            };
            let guess = next * factor;
            if at_worst <= allowed {
                holds = Some((next, known));
            } else {
                fails = Some(next);
            }
            let low = holds.map_or(least, |(px, _)| px);
            let high = fails.unwrap_or(most);
            let done = match (holds, fails) {
                (Some((px, _)), None) => px >= most,
                (None, Some(px)) => px <= least,
                _ => low * NEAR >= high,
            };
            if done {
                return Ok(holds);
            }
            next = match (holds, fails) {
                // Not too near to an end, or the other never comes nearer.
                (Some(_), Some(_)) => {
                    let quarter = (high / low).powf(0.25);
                    guess.clamp(low * quarter, high / quarter)
                }
                (None, Some(px)) => guess.clamp(least, (px / LEAST_STEP).max(least)),
                (_, None) => guess.max(next * LEAST_STEP).clamp(least, most),
            };
            next = short(next).clamp(least, most);
        }
    }

    /// What is known of the film at a threshold; none where there are no more
    /// probes.
    fn look(&mut self, threshold_px: f64) -> Result<Option<Known>, JobError> {
        let metric = self.tune.target.metric;
        let planned = self.plan(self.tune.wishes.mode, threshold_px)?;
        let key = same_frames(&planned);
        let known = match self.known.get(&key) {
            Some(known) => *known,
            None if self.looked == PROBES => return Ok(None),
            None => {
                let sample = Sample::of(&planned, metric);
                let layered = planned.periods.iter().filter(|p| p.has_decor()).count();
                let estimate = if sample.frames.is_empty() {
                    Estimate::default()
                } else {
                    self.looked += 1;
                    let losses = self.losses(&planned, &sample)?;
                    sample.estimate(&planned, metric, &losses)
                };
                let known = Known {
                    estimate,
                    frames: sample.frames.len(),
                    periods: (sample.periods.len(), layered),
                };
                self.known.insert(key, known);
                known
            }
        };
        let Estimate { loss, margin, .. } = known.estimate;
        let finite = |loss: f64| Some(metric.value(loss)).filter(|value| value.is_finite());
        // A threshold that was looked at before would be looked at for ever.
        if self.probes.iter().any(|p| p.threshold_px == threshold_px) {
            return Ok(None);
        }
        self.probes.push(Probe {
            threshold_px,
            value: finite(loss),
            at_worst: finite(loss + margin),
            holds: loss + margin <= self.tune.target.loss(),
            frames: known.frames,
            periods: known.periods,
            predicted_wall_s: self.predict(&planned).predicted_wall_s,
        });
        Ok(Some(known))
    }

    /// The losses of the frames of a sample.
    fn losses(&mut self, planned: &Plan, sample: &Sample) -> Result<BTreeMap<u32, f64>, JobError> {
        let tune = self.tune;
        let metric = tune.target.metric;
        let in_folder = |name: String| Job {
            out: self.folder.path.join(name),
            keep: None,
            resume: false,
            ..tune.job.clone()
        };
        let plain = in_folder("plain".into());
        let missing: BTreeSet<u32> = sample.frames.difference(&self.plain).copied().collect();
        plain_frames(tune.stage, &tune.wishes, &self.probed, &plain, &missing)?;
        self.plain.extend(missing);
        let layered = in_folder(format!("probe-{}", self.looked));
        layered.execute_only(tune.stage, planned, &sample.frames)?;
        let frames: Vec<u32> = sample.frames.iter().copied().collect();
        let options = Options {
            tolerances: Tolerances {
                fail: Limit {
                    level: tune.level,
                    percent: 100.0,
                },
                fail_depth: f64::INFINITY,
                ..Tolerances::default()
            },
            perception: matches!(metric, Metric::Flip | Metric::Ssim),
            ..Options::default()
        };
        let comparison = compare_frames(&plain, &layered.out, &frames, &options)?;
        let mut losses = BTreeMap::new();
        for (k, entry) in comparison.entries.iter().enumerate() {
            // What changes since a frame that is not the one before says nothing.
            let follows = k > 0 && frames[k - 1] + 1 == frames[k];
            if metric == Metric::Flicker && !follows {
                continue;
            }
            if let Entry::Pair(pair) = entry
                && let Some(loss) = metric.loss_of_frame(pair)
            {
                losses.insert(frames[k], loss);
            }
        }
        Ok(losses)
    }

    /// Of the thresholds up to the largest that holds, and of what has no error at
    /// all, the one that costs least.
    fn fastest(self, found: Option<(f64, Option<Known>)>) -> Result<Tuned, JobError> {
        let cores = probe::cores();
        let weight = |prediction: &Prediction| {
            crate::plan::Price {
                wall_s: prediction.predicted_wall_s,
                cpu_s: prediction.predicted_cpu_s,
            }
            .weight(cores)
        };
        let exact = self.plan(Mode::Exact, 0.0)?;
        let mut best = (self.predict(&exact), exact);
        let mut layered = None;
        if let Some((largest, known)) = found {
            for step in 0..=LADDER.0 {
                let threshold_px = match step {
                    0 => largest,
                    _ => short(largest / LADDER.1.powi(step)),
                };
                let planned = self.plan(self.tune.wishes.mode, threshold_px)?;
                let prediction = self.predict(&planned);
                // Décors are wanted whatever they cost.
                let wanted =
                    self.tune.wishes.fallback || planned.periods.iter().any(Period::has_decor);
                if !wanted && step > 0 {
                    continue;
                }
                let limit = match step {
                    0 if !self.tune.wishes.fallback => f64::INFINITY,
                    // The largest one is as sure as any, and first.
                    0 => 1.0,
                    _ => CHEAPER,
                };
                if weight(&prediction) < limit * weight(&best.0) {
                    best = (prediction, planned);
                    layered = known;
                }
            }
        }
        let (prediction, plan) = best;
        let metric = self.tune.target.metric;
        let errorless =
            !plan.periods.iter().any(Period::has_decor) || plan.wishes.mode == Mode::Exact;
        let estimate = match (metric, layered) {
            (Metric::Motion, _) => Estimate {
                loss: kept_motion_px(&plan),
                ..Estimate::default()
            },
            (_, Some(known)) if !errorless => known.estimate,
            _ => Estimate::default(),
        };
        let sure = match layered {
            _ if errorless || metric == Metric::Motion => Sureness::Certain,
            Some(Known {
                periods: (seen, all),
                ..
            }) if metric != Metric::Max && (seen > 1 || seen == all) => Sureness::Likely,
            _ => Sureness::Guess,
        };
        let finite = |loss: f64| Some(metric.value(loss)).filter(|value| value.is_finite());
        Ok(Tuned {
            target: self.tune.target,
            plan,
            prediction,
            value: finite(estimate.loss),
            at_worst: finite(estimate.loss + estimate.margin),
            spread: estimate.spread,
            sure,
            probes: self.probes,
            plain_frames: self.plain.len(),
            probed: self.probed,
        })
    }
}

/// A threshold in three digits, rounded down: a user may have to type it.
fn short(threshold_px: f64) -> f64 {
    let digits = 2 - threshold_px.log10().floor() as i32;
    let scale = 10.0_f64.powi(digits);
    (threshold_px * scale).floor() / scale
}

impl Tuned {
    /// The options of `decor render` that ask for it.
    pub fn options(&self) -> String {
        let wishes = &self.plan.wishes;
        Setting {
            mode: wishes.mode,
            threshold_px: wishes.threshold_px,
            period: wishes.period,
            measure: wishes.measure,
            antialias: Antialiasing::AsIs,
        }
        .options()
    }
}

//! A sweep: the trade between speed and accuracy, measured.
//!
//! Frame by frame is rendered once; then every setting of a [`Grid`], each by
//! itself so that its time is its own, and compared with it. Settings that come to
//! the same plan are rendered once. What is finished is kept ([`cache`]): a sweep
//! that was interrupted goes on, but for the setting that was under way, which
//! begins anew, since its time has to be that of one run.

mod cache;
mod grid;
pub mod page;
pub mod report;
pub mod table;
mod trade;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde::Serialize;

use crate::compare::verdict::{Limit, Tolerances};
use crate::compare::{CompareError, Comparison, Options, compare};
use crate::frames::WriteError;
use crate::job::{Job, JobError, Unwatched};
use crate::plan::{Mode, Period, Plan, PlanError, Price, plan};
use crate::probe::Probed;
use crate::report::{Clock, Machine};
use crate::segmentation::Class;
use crate::stage::Stage;

pub use cache::{Made, same_frames};
use cache::{SweepCache, key};
pub use grid::{Antialiasing, Grid, Setting};
pub use trade::{Trade, trades};

/// Why there is no sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// Frames could not be made.
    #[error(transparent)]
    Job(#[from] JobError),
    /// They could not be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A picture that was just rendered cannot be put into the report.
    #[error(transparent)]
    Page(#[from] crate::report::html::PictureDataError),
    /// What was found cannot be written down.
    #[error("what was found cannot be written down")]
    Json(#[from] serde_json::Error),
}

impl From<PlanError> for SweepError {
    fn from(error: PlanError) -> Self {
        Self::Job(error.into())
    }
}

impl From<WriteError> for SweepError {
    fn from(error: WriteError) -> Self {
        Self::Job(error.into())
    }
}

/// What the errors are measured against, and the speed-ups.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Against {
    /// The stock renderer: one plain call over the film.
    Stock,
    /// Frame by frame through the pool.
    Full,
}

/// A sweep.
pub struct Sweep<'a> {
    /// The film, as it is.
    pub stage: &'a Stage,
    /// The film without antialiasing, where that is tried.
    pub plain: Option<&'a Stage>,
    /// How frames are made, and the folder of the sweep.
    pub job: Job,
    /// What is tried.
    pub grid: Grid,
    /// The first and last frame.
    pub frames: (u32, u32),
    /// What it is measured against.
    pub against: Against,
    /// Runs of each setting: their medians count.
    pub runs: usize,
    /// A difference above this counts for the share and for the flicker.
    pub level: f64,
    /// May frames be rendered whole because it is cheaper?
    pub fallback: bool,
}

/// How far a setting's film is from frame by frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// The largest difference of a channel.
    pub max: f64,
    /// The root of the mean square.
    pub rms: f64,
    /// In decibels; null where nothing differs.
    pub psnr: Option<f64>,
    /// The mean SSIM; null where no window fits.
    pub ssim: Option<f64>,
    /// The mean FLIP.
    pub flip: f64,
    /// The share of the pixels that change from frame to frame in this film only.
    pub flicker: f64,
    /// The share of the pixels above the level.
    pub share_above: f64,
    /// How far anything in a décor moves in the picture, at most, in pixels.
    pub motion_px: f64,
}

impl Errors {
    /// Of a comparison, and of the plan that made the film.
    pub fn of(comparison: &Comparison, plan: &Plan) -> Self {
        let totals = &comparison.totals;
        let seen = totals.perceived.as_ref();
        let flicker = totals.flicker.as_ref();
        Self {
            max: totals.max,
            rms: totals.rms(),
            psnr: Some(totals.psnr()).filter(|psnr| psnr.is_finite()),
            ssim: seen.and_then(|seen| seen.ssim()),
            flip: seen.map_or(0.0, |seen| seen.flip()),
            flicker: flicker.map_or(0.0, |flicker| flicker.all.share_added()),
            share_above: totals.share_above(),
            motion_px: kept_motion_px(plan),
        }
    }
}

/// How far anything that a décor keeps moves in the picture, at most, in pixels.
pub fn kept_motion_px(plan: &Plan) -> f64 {
    let layered = plan.periods.iter().filter(|period| period.has_decor());
    let of_period = |period: &Period| {
        let slow = period.objects.iter().filter(|o| o.class == Class::Slow);
        let sky = period.sky.filter(|sky| sky.class == Class::Slow);
        let all = slow
            .map(|o| o.motion_px)
            .chain(sky.map(|sky| sky.motion_px));
        all.fold(0.0, f64::max)
    };
    layered.map(of_period).fold(0.0, f64::max)
}

/// A setting, measured.
pub struct Measured {
    /// The setting.
    pub setting: Setting,
    /// Its plan.
    pub plan: Plan,
    /// Where its frames are.
    pub folder: PathBuf,
    /// The number of the setting before whose plan is the same, if there is one:
    /// frames and times are its.
    pub same_as: Option<usize>,
    /// What was made.
    pub made: Made,
    /// The medians of the runs.
    pub price: Price,
    /// The errors.
    pub errors: Errors,
    /// The comparison, frame by frame.
    pub comparison: Comparison,
}

/// Frame by frame.
pub struct Reference {
    /// Which.
    pub against: Against,
    /// Where its frames are.
    pub folder: PathBuf,
    /// What was made.
    pub made: Made,
    /// The medians of the runs.
    pub price: Price,
}

/// A finished sweep.
pub struct Swept<'a> {
    /// The film.
    pub stage: &'a Stage,
    /// What the film is called.
    pub film: String,
    /// The first and last frame.
    pub frames: (u32, u32),
    /// A difference above this counts for the share and for the flicker.
    pub level: f64,
    /// Runs of each setting.
    pub runs: usize,
    /// The machine.
    pub machine: Machine,
    /// Frame by frame.
    pub reference: Reference,
    /// The settings, in the order of the grid.
    pub settings: Vec<Measured>,
    /// For each of them, what it is worth among the others.
    pub trades: Vec<Trade>,
}

/// Is told what is going on.
pub trait Follow {
    /// A setting begins; `kept`: it was measured before.
    fn begins(&self, what: &str, kept: bool);
    /// It is measured.
    fn ends(&self, what: &str, price: Price, errors: &Errors);
}

impl<'a> Sweep<'a> {
    /// Renders and compares.
    ///
    /// # Errors
    /// The first thing that went wrong; finished settings are kept.
    pub fn run(&self, follow: &dyn Follow) -> Result<Swept<'a>, SweepError> {
        let cache = SweepCache::new(&self.job.out);
        let reference = self.reference(&cache, follow)?;
        let mut settings: Vec<Measured> = Vec::new();
        let mut first_with: BTreeMap<String, usize> = BTreeMap::new();
        for setting in self.grid.settings() {
            let Some(stage) = self.stage_for(&setting) else {
                continue;
            };
            let what = setting.to_string();
            let (planned, planning, probed) = self.planned(&cache, stage, &setting)?;
            let key = self.key(stage, &same_frames(&planned));
            let same_as = first_with.get(&key).copied();
            first_with.entry(key.clone()).or_insert(settings.len());
            let kept = cache.find(&key, self.runs);
            follow.begins(&what, kept.is_some());
            let job = Job {
                out: cache.folder(&key),
                ..self.job.clone()
            };
            let made = match kept {
                Some(made) => made,
                None => self.make(&cache, &key, || {
                    let clock = Clock::start();
                    let mut done = job.execute(stage, &planned, &probed, &clock, &Unwatched)?;
                    done.wall_s += planning.wall_s;
                    done.cpu_s += planning.cpu_s;
                    Ok(done)
                })?,
            };
            let comparison = compare(&reference.folder, &job.out, &self.options(), |_| {})?;
            let errors = Errors::of(&comparison, &planned);
            let price = made.price();
            follow.ends(&what, price, &errors);
            settings.push(Measured {
                setting,
                plan: planned,
                folder: job.out,
                same_as,
                made,
                price,
                errors,
                comparison,
            });
        }
        let trades = trades(&settings);
        Ok(Swept {
            stage: self.stage,
            film: self.job.film.clone(),
            frames: self.frames,
            level: self.level,
            runs: self.runs,
            machine: Machine::here(),
            reference,
            settings,
            trades,
        })
    }

    /// How settings are compared with frame by frame.
    fn options(&self) -> Options {
        Options {
            tolerances: Tolerances {
                fail: Limit {
                    level: self.level,
                    // Nothing fails here: everything is measured.
                    percent: 100.0,
                },
                fail_depth: f64::INFINITY,
                ..Tolerances::default()
            },
            ..Options::default()
        }
    }

    /// The film that a setting is of; none where it is the same as another's.
    fn stage_for(&self, setting: &Setting) -> Option<&'a Stage> {
        match setting.antialias {
            Antialiasing::AsIs => Some(self.stage),
            // A film that is not antialiased is already what `off` makes of it.
            Antialiasing::Off => self.plain.filter(|_| self.stage.antialias().is_some()),
        }
    }

    fn planned(
        &self,
        cache: &SweepCache,
        stage: &Stage,
        setting: &Setting,
    ) -> Result<(Plan, Price, Probed), SweepError> {
        let mut wishes = setting.wishes(self.frames);
        wishes.fallback = self.fallback;
        // A probe of layers shows what whole frames cost, too: one for all settings.
        let usual = Setting {
            mode: Mode::Equivalent,
            threshold_px: Mode::Equivalent.default_threshold_px(),
            ..Setting::FULL
        };
        let usual = usual.wishes(self.frames);
        let probed = cache.costs(&key(&stage.key()), || Ok(self.job.costs(stage, &usual)?))?;
        let clock = Clock::start();
        let planned = plan(stage, wishes, &probed.costs)?;
        let planning = Price {
            wall_s: clock.wall_s(),
            cpu_s: clock.cpu_s(),
        };
        Ok((planned, planning, probed))
    }

    fn reference(&self, cache: &SweepCache, follow: &dyn Follow) -> Result<Reference, SweepError> {
        let (what, frames, planned) = match self.against {
            Against::Stock => ("frame by frame by the stock renderer", "stock".into(), None),
            Against::Full => {
                let planned = self.planned(cache, self.stage, &Setting::FULL)?;
                let frames = same_frames(&planned.0);
                ("frame by frame through the pool", frames, Some(planned))
            }
        };
        let key = self.key(self.stage, &frames);
        let job = Job {
            out: cache.folder(&key),
            ..self.job.clone()
        };
        let kept = cache.find(&key, self.runs);
        follow.begins(what, kept.is_some());
        let made = match kept {
            Some(made) => made,
            None => self.make(cache, &key, || {
                let clock = Clock::start();
                match &planned {
                    None => job.stock(self.stage, self.frames, &clock, &Unwatched),
                    Some((planned, _, probed)) => {
                        job.execute(self.stage, planned, probed, &clock, &Unwatched)
                    }
                }
            })?,
        };
        Ok(Reference {
            against: self.against,
            folder: job.out,
            price: made.price(),
            made,
        })
    }

    fn make(
        &self,
        cache: &SweepCache,
        key: &str,
        once: impl Fn() -> Result<crate::report::Summary, JobError>,
    ) -> Result<Made, SweepError> {
        cache.begin(key);
        let runs = (0..self.runs.max(1)).map(|_| once());
        let summaries: Vec<_> = runs.collect::<Result<_, _>>()?;
        // At least one run was made.
        let made = Made::of(&summaries).unwrap_or_else(|| Made {
            runs: Vec::new(),
            calls: 0,
            pictures: 0,
            traced: BTreeMap::new(),
            full: 0,
        });
        cache.keep(key, &made)?;
        Ok(made)
    }

    /// All that frames and times depend on.
    fn key(&self, stage: &Stage, frames: &str) -> String {
        let Job {
            seed, jobs, format, ..
        } = &self.job;
        key(&format!(
            "{} {:?} {} {seed} {jobs:?} {format:?} {:?} {frames}",
            env!("CARGO_PKG_VERSION"),
            Machine::here(),
            stage.key(),
            self.frames,
        ))
    }
}

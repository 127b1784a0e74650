//! A job: from a stage and what is wished to frames and their summary. What
//! `render`, `sweep` and `tune` share; nothing is printed here.

pub mod log;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use decor_api::{AdapterError, Baseline, PictureFormat, RunContext, Tally};

use crate::frames::{WriteError, name, write_safely};
use crate::objects::Cache;
use crate::plan::{
    CostsFrom, Mode, Plan, PlanError, Prediction, Price, Wishes, jobs, plan, whole_work,
};
use crate::probe::{self, Learned, Probed};
use crate::render::{Done, Options, RenderError, TracedPixels, WorkFolder, render};
use crate::report::{Clock, Summary, period_summaries};
use crate::stage::Stage;
use log::{JOB_FILE, JobLog, finished};

/// Why a job has no frames.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The frames cannot be planned.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// They cannot be rendered.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Something cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl From<AdapterError> for JobError {
    fn from(error: AdapterError) -> Self {
        Self::Render(error.into())
    }
}

/// What a job writes, and how.
#[derive(Clone, Debug)]
pub struct Job {
    /// What the film is called.
    pub film: String,
    /// Where frames go; made where it is not there.
    pub out: PathBuf,
    /// Their format.
    pub format: PictureFormat,
    /// Calls at once; `None`: what the adapter says.
    pub jobs: Option<usize>,
    /// Of the dissolve.
    pub seed: u64,
    /// Are frames of an interrupted run of the same job kept?
    pub resume: bool,
    /// Where scene files and logs are kept, if anywhere.
    pub keep: Option<PathBuf>,
    /// How long one call may take.
    pub timeout: Duration,
    /// Set to stop.
    pub cancel: Arc<AtomicBool>,
}

/// Follows a job, from any thread.
pub trait Watch: Sync {
    /// So many frames are to be made.
    fn begins(&self, _frames: u64) {}
    /// A frame is there.
    fn frame(&self, frame: u32, file: &Path);
}

/// Nobody follows.
pub struct Unwatched;

impl Watch for Unwatched {
    fn frame(&self, _frame: u32, _file: &Path) {}
}

/// `png`, `png16` or `exr`.
pub fn format_name(format: PictureFormat) -> &'static str {
    match format {
        PictureFormat::Png => "png",
        PictureFormat::Png16 => "png16",
        PictureFormat::Exr => "exr",
    }
}

impl Job {
    /// A run of the renderer in `work`.
    fn run(&self, work: &Path, tally: &Arc<Tally>) -> RunContext {
        RunContext {
            work: work.to_owned(),
            keep: self.keep.is_some(),
            timeout: self.timeout,
            threads: None,
            cancel: Arc::clone(&self.cancel),
            tally: Arc::clone(tally),
        }
    }

    /// The costs of a film: what is known of them, or measured where the film is
    /// long enough to be worth it.
    ///
    /// # Errors
    /// Where the film cannot be planned, or the renderer fails.
    pub fn costs(&self, stage: &Stage, wishes: &Wishes) -> Result<Probed, JobError> {
        let cache = Cache::open();
        let known = probe::known(stage, &cache);
        // Frames that the film does not have are found out first.
        let first = plan(stage, wishes.clone(), &known.costs)?;
        let measures = wishes.mode != Mode::Full
            && known.from == CostsFrom::BuiltIn
            && probe::worth_probing(stage, wishes);
        if !measures {
            return Ok(known);
        }
        let work = WorkFolder::new(None)?;
        let run = self.run(&work.path, &Arc::default());
        Ok(probe::probe(stage, &first, &cache, &run)?)
    }

    /// What a plan is to cost, beside what the stock renderer would.
    pub fn prediction(&self, stage: &Stage, plan: &Plan, probed: &Probed) -> Prediction {
        let at_once = self.jobs.unwrap_or_else(|| jobs(stage));
        let works = plan.works(stage);
        let price = probed.costs.film(&works, at_once, probe::cores());
        let price: Price = price.into_iter().sum();
        let whole = whole_work(stage, &plan.wishes);
        let stock = probed.costs.stock(&whole, probe::cores());
        let learned = Learned::of(stage, probed.from, &Cache::open());
        let (corrected, stock) = (learned.correct(plan, price), learned.correct_stock(stock));
        Prediction::new(probed.from, corrected, stock).uncorrected(price, learned.renders(plan))
    }

    /// Renders the frames of a plan, and says what was done.
    ///
    /// # Errors
    /// The first thing that went wrong; frames that were finished before stay,
    /// and are kept by the next run where [`Job::resume`] says so.
    pub fn execute(
        &self,
        stage: &Stage,
        plan: &Plan,
        probed: &Probed,
        clock: &Clock,
        watch: &dyn Watch,
    ) -> Result<Summary, JobError> {
        let frames = plan.wishes.frames;
        // Other periods have other frames.
        let starts: Vec<(u32, u32)> = plan.periods.iter().map(|p| (p.start, p.len())).collect();
        let key = format!("{:?} {starts:?}", plan.wishes);
        let mut summary = self.describe(stage, frames, &key);
        summary.mode = plan.wishes.mode.to_string();
        summary.threshold_px = plan.wishes.threshold_px;
        summary.periods = period_summaries(plan);
        summary.fallback = plan.is_fallback();
        let prediction = self.prediction(stage, plan, probed);
        let before = Price {
            wall_s: clock.wall_s(),
            cpu_s: clock.cpu_s(),
        };
        make_folder(&self.out)?;
        let skip = if self.resume {
            finished(&self.out, &summary.job, frames, &|n| name(n, self.format))
        } else {
            BTreeSet::new()
        };
        // What is there belongs to this job from now on, also if it is interrupted.
        let log = JobLog::begin(&self.out, &summary.job, &skip)?;
        summary.frames_kept = skip.len() as u64;
        watch.begins(u64::from(frames.1 - frames.0 + 1) - summary.frames_kept);
        let done = self.render(stage, plan, skip, &|frame, file| {
            log.finished(frame);
            watch.frame(frame, file);
        })?;
        // Only an interrupted run needs it.
        log.end();
        summary.renderer_calls = done.calls;
        summary.renderer_frames = done.pictures;
        summary.pixels_traced = done.traced;
        (summary.wall_s, summary.cpu_s) = (clock.wall_s(), clock.cpu_s());
        let measured = Price {
            wall_s: summary.wall_s - before.wall_s,
            cpu_s: summary.cpu_s - before.cpu_s,
        };
        if summary.frames_kept == 0 {
            let told = (prediction.uncorrected, measured);
            probe::learn(stage, plan, probed.from, told, &Cache::open());
        }
        summary.prediction = Some(prediction.measured(measured));
        Ok(summary)
    }

    /// Renders only these frames of a plan, each as the whole film would have it.
    ///
    /// # Errors
    /// The first thing that went wrong.
    pub fn execute_only(
        &self,
        stage: &Stage,
        plan: &Plan,
        frames: &BTreeSet<u32>,
    ) -> Result<Done, JobError> {
        make_folder(&self.out)?;
        let (first, last) = plan.wishes.frames;
        let skip = (first..=last).filter(|n| !frames.contains(n)).collect();
        Ok(self.render(stage, plan, skip, &|_, _| {})?)
    }

    fn render(
        &self,
        stage: &Stage,
        plan: &Plan,
        skip: BTreeSet<u32>,
        watch: crate::render::Watch<'_>,
    ) -> Result<Done, RenderError> {
        let options = Options {
            out: self.out.clone(),
            format: self.format,
            jobs: self.jobs,
            keep: self.keep.clone(),
            timeout: self.timeout,
            seed: self.seed,
            cancel: Arc::clone(&self.cancel),
            skip,
        };
        render(stage, plan, &options, watch)
    }

    /// Frame by frame by the stock renderer: one plain call over the frames.
    ///
    /// # Errors
    /// Where the film lacks the frames, the renderer fails, or something cannot
    /// be written.
    pub fn stock(
        &self,
        stage: &Stage,
        frames: (u32, u32),
        clock: &Clock,
        watch: &dyn Watch,
    ) -> Result<Summary, JobError> {
        let film = (*stage.film.frames().start(), *stage.film.frames().end());
        if frames.0 < film.0 || frames.1 > film.1 {
            let asked = frames;
            return Err(PlanError::NoSuchFrames { film, asked }.into());
        }
        let request = Baseline {
            prototypes: &stage.library.table,
            size: stage.size(),
            antialias: stage.antialias(),
            film,
            frames: (frames.0..=frames.1)
                .map(|n| (n, Arc::new(stage.scene(&stage.film.frame(n), |_| true))))
                .collect(),
            format: self.format,
        };
        let work = WorkFolder::new(self.keep.as_deref())?;
        let tally = Arc::new(Tally::default());
        let files = stage
            .adapter
            .baseline(&request, &self.run(&work.path, &tally))?;
        make_folder(&self.out)?;
        // What an interrupted run has noted is written over now.
        let _ = std::fs::remove_file(self.out.join(JOB_FILE));
        for (number, file) in files {
            let bytes = std::fs::read(&file).map_err(|source| AdapterError::BadOutput {
                program: stage.adapter.name().into(),
                file: file.clone(),
                reason: source.to_string(),
            })?;
            let path = self.out.join(name(number, self.format));
            write_safely(&path, &bytes)?;
            // The copy is in place; the original would be a second film on the disk.
            let _ = std::fs::remove_file(&file);
            watch.frame(number, &path);
        }
        let mut summary = self.describe(stage, frames, "baseline");
        summary.mode = "baseline".into();
        (summary.renderer_calls, summary.renderer_frames) = tally.read();
        summary.pixels_traced = TracedPixels {
            whole: summary.pixels_full,
            ..Default::default()
        };
        (summary.wall_s, summary.cpu_s) = (clock.wall_s(), clock.cpu_s());
        Ok(summary)
    }

    /// A summary of what is about to be done; `how` is all that the frames depend
    /// on beside the stage.
    fn describe(&self, stage: &Stage, frames: (u32, u32), how: &str) -> Summary {
        let size = stage.size();
        let count = u64::from(frames.1 - frames.0 + 1);
        let format = format_name(self.format);
        let job = format!("{} {} {frames:?} {how} {format}", self.seed, stage.key());
        Summary {
            decor: env!("CARGO_PKG_VERSION").into(),
            film: self.film.clone(),
            frames: count,
            frames_kept: 0,
            first_frame: frames.0,
            width: size.width,
            height: size.height,
            renderer: stage.adapter.name().into(),
            renderer_version: stage.adapter.abilities().version.clone(),
            mode: String::new(),
            threshold_px: 0.0,
            format: format.into(),
            periods: Vec::new(),
            wall_s: 0.0,
            cpu_s: 0.0,
            renderer_calls: 0,
            renderer_frames: 0,
            pixels_traced: TracedPixels::default(),
            pixels_full: count * size.pixels() as u64,
            prediction: None,
            fallback: false,
            verified: None,
            job: blake3::hash(job.as_bytes()).to_hex().to_string(),
        }
    }
}

fn make_folder(path: &Path) -> Result<(), WriteError> {
    std::fs::create_dir_all(path).map_err(|source| WriteError::Io {
        path: path.to_owned(),
        source,
    })
}

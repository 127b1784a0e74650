//! A stream: scenes as they arrive, each frame out before the next scene is
//! read, with no knowledge of the future.
//!
//! Every arriving scene makes a small film, whose later frames are what its
//! velocities predict ([`FilmStream::predicted`]). A period is planned on it with
//! the planner of films, and verified against every real frame (`period`). How
//! far ahead is planned, and with what threshold, is learnt on the way (`pace`).
//!
//! ```text
//! line → frames that it shows → verify ─┬─ holds: lay, render, merge, write
//!                                       └─ fails: end the period, plan another
//! ```

mod draw;
mod pace;
mod period;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use decor_api::{Adapter, RunContext, Tally};

use crate::film::{FilmErrors, FilmStream};
use crate::objects::Cache;
use crate::plan::{Costs, End, Period, Plan, PlanError, Wishes};
use crate::probe;
use crate::render::{Options, RenderError, TracedPixels, WorkFolder};
use crate::report::{PeriodSummary, period_summaries};
use crate::segmentation::same_environment;
use crate::stage::{Stage, StageError};
use pace::Pace;
use period::{Open, Over, Planner};

/// Why a stream cannot go on.
#[derive(Debug, thiserror::Error)]
pub enum StreamError {
    /// A scene is wrong.
    #[error(transparent)]
    Film(#[from] FilmErrors),
    /// What a scene names is wrong.
    #[error(transparent)]
    Stage(#[from] StageError),
    /// An object cannot be put into a layer.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A frame could not be rendered or written.
    #[error(transparent)]
    Render(#[from] RenderError),
}

/// How a stream is rendered.
#[derive(Clone)]
pub struct Settings {
    /// What its messages are called by.
    pub name: String,
    /// What its paths are relative to.
    pub folder: PathBuf,
    /// May they leave it?
    pub allow_outside: bool,
    /// The renderer.
    pub adapter: Arc<dyn Adapter>,
    /// What is wished of the frames. Which of them is the stream's affair; the
    /// budget counts measured time.
    pub wishes: Wishes,
    /// How they are rendered; what is to be skipped is not looked at.
    pub options: Options,
}

/// What has happened.
pub enum Event<'a> {
    /// A period has begun; of its frames only the first is certain.
    Began(&'a Stage, &'a Period),
    /// A frame is in its place.
    Frame {
        /// Its number.
        number: u32,
        /// Where it is.
        file: &'a Path,
        /// The first frame of its period.
        period: u32,
        /// Seconds since its scene was there.
        seconds: f64,
    },
    /// A period has ended.
    Ended(&'a PeriodSummary),
}

/// Is told of what happens.
pub type Watch<'a> = &'a mut dyn FnMut(&Event<'_>);

/// What was done so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StreamDone {
    /// Frames that were written.
    pub frames: u64,
    /// Calls of the renderer.
    pub calls: u64,
    /// Pictures in them.
    pub pictures: u64,
    /// Pixels traced.
    pub traced: TracedPixels,
    /// The periods that have ended.
    pub periods: Vec<PeriodSummary>,
}

/// A stream that is being rendered.
pub struct Stream {
    settings: Settings,
    scenes: FilmStream,
    cache: Cache,
    work: WorkFolder,
    tally: Arc<Tally>,
    pace: Pace,
    /// What things cost; found with the first scene.
    costs: Option<Costs>,
    /// The frame before.
    before: Option<Arc<Stage>>,
    open: Option<Open>,
    done: StreamDone,
}

impl Stream {
    /// A stream without a scene yet.
    ///
    /// # Errors
    /// Where there is no folder to work in.
    pub fn new(settings: Settings, cache: Cache) -> Result<Self, RenderError> {
        let work = WorkFolder::new(settings.options.keep.as_deref())?;
        let Settings {
            name,
            folder,
            allow_outside,
            ..
        } = &settings;
        Ok(Self {
            scenes: FilmStream::new(name, folder, *allow_outside),
            pace: Pace::new(&settings.wishes),
            settings,
            cache,
            work,
            tally: Arc::new(Tally::default()),
            costs: None,
            before: None,
            open: None,
            done: StreamDone::default(),
        })
    }

    /// Reads the next line, and renders the frames that it shows. All of them are
    /// in their place when this returns.
    ///
    /// # Errors
    /// What is wrong with the scene, or what went wrong with a frame; the frames
    /// before it stay.
    pub fn line(&mut self, line: &[u8], watch: Watch<'_>) -> Result<(), StreamError> {
        let began = Instant::now();
        let frames = self.scenes.push_line(line)?;
        self.frames(frames.into_iter().flatten(), began, watch)
    }

    /// The stream is at its end: renders the frames that it has still promised.
    ///
    /// # Errors
    /// As [`line`](Self::line).
    pub fn finish(&mut self, watch: Watch<'_>) -> Result<(), StreamError> {
        let began = Instant::now();
        let frames = self.scenes.finish()?;
        self.frames(frames.into_iter().flatten(), began, watch)
    }

    /// No more frames: what was done. The period at hand has ended, whatever was
    /// planned.
    pub fn close(mut self, watch: Watch<'_>) -> StreamDone {
        if let Some(open) = self.open.take() {
            self.ended(open, Over::Planned(End::Done), watch);
        }
        (self.done.calls, self.done.pictures) = self.tally.read();
        self.done
    }

    /// A frame's stage, of the newest frame that was begun.
    pub fn stage(&self) -> Option<&Stage> {
        self.before.as_deref()
    }

    fn frames(
        &mut self,
        numbers: impl Iterator<Item = u32>,
        mut began: Instant,
        watch: Watch<'_>,
    ) -> Result<(), StreamError> {
        for number in numbers {
            self.frame(number, began, watch)?;
            // Where a line shows several frames, each waits for those before it.
            began = Instant::now();
        }
        Ok(())
    }

    /// Renders a frame.
    fn frame(&mut self, number: u32, began: Instant, watch: Watch<'_>) -> Result<(), StreamError> {
        let stage = Arc::new(self.arriving(number)?);
        let costs = self.costs(&stage);
        let pace = self.pace;
        let wishes = self.settings.wishes.clone();
        let planner = Planner {
            wishes: &wishes,
            costs: &costs,
            pace: &pace,
        };
        planner.check(&stage)?;
        let before = self.before.replace(Arc::clone(&stage));
        let served = self.open.as_mut().map(|open| planner.serve(open, &stage));
        let frame = match served {
            Some(Ok(frame)) => frame,
            served => {
                let over = match served {
                    Some(Err(over)) => Some(over),
                    _ => None,
                };
                self.next_period(over, &stage, before.as_deref(), watch)?
            }
        };
        let Some(mut open) = self.open.take() else {
            return Ok(());
        };
        let file = self.draw(&mut open, &stage, frame);
        let seconds = began.elapsed().as_secs_f64();
        open.served += u32::from(file.is_ok());
        open.seconds += seconds;
        let period = open.period.start;
        self.open = Some(open);
        let file = file?;
        self.done.frames += 1;
        watch(&Event::Frame {
            number,
            file: &file,
            period,
            seconds,
        });
        Ok(())
    }

    /// The stage of a frame that is there, and of what is predicted after it.
    fn arriving(&self, number: u32) -> Result<Stage, StreamError> {
        let (first, end) = self.scenes.span();
        let last = number.saturating_add(self.pace.ahead());
        let last = end.map_or(last, |end| last.min(end));
        let Some(film) = self.scenes.predicted(number, last) else {
            // A frame that a line shows has a camera: the line was checked.
            return Err(PlanError::LastNumber.into());
        };
        let run = RunContext {
            tally: Arc::clone(&self.tally),
            ..self.context(&self.work.path)
        };
        Ok(Stage::follow(
            self.before.as_deref(),
            film,
            first.zip(end),
            Arc::clone(&self.settings.adapter),
            self.settings.allow_outside,
            &self.cache,
            &run,
        )?)
    }

    /// What earlier runs found out, or what is built in: a probe would keep the
    /// first frame waiting.
    fn costs(&mut self, stage: &Stage) -> Costs {
        let cache = &self.cache;
        *self
            .costs
            .get_or_insert_with(|| probe::known(stage, cache).costs)
    }

    /// Ends the period at hand, where there is one, and begins another with the
    /// frame that `stage` begins with. Gives what is rendered in it.
    fn next_period(
        &mut self,
        over: Option<Over>,
        stage: &Arc<Stage>,
        before: Option<&Stage>,
        watch: Watch<'_>,
    ) -> Result<Period, StreamError> {
        let number = *stage.film.frames().start();
        let mut earlier = self.open.take();
        if let Some(open) = &earlier
            && (open.period.has_decor() || self.pace.adapts())
        {
            // Whole frames are right whatever was predicted.
            let failed = matches!(over, Some(Over::Failed(_))) && open.period.has_decor();
            let frame_s = open.seconds / f64::from(open.served.max(1));
            self.pace.learn(open.served, failed, frame_s);
        }
        let changes = before.is_some_and(|before| {
            let then = before.film.frame(*before.film.frames().start());
            !same_environment(&then, &stage.film.frame(number))
        });
        let pace = self.pace;
        let costs = self.costs(stage);
        let planner = Planner {
            wishes: &self.settings.wishes,
            costs: &costs,
            pace: &pace,
        };
        let mut open = planner.open(stage, self.scenes.span().1, changes)?;
        let frame = Period {
            frames: open.period.frames[..1].to_vec(),
            ..open.period.clone()
        };
        if let Some(mut whole) = earlier.take_if(|earlier| {
            open.period.whole.is_some()
                && earlier.period.whole == open.period.whole
                && earlier.period.threshold_px == open.period.threshold_px
        }) {
            // Whole frames have no décor in common: they are one period.
            whole.go_on_as(open);
            self.open = Some(whole);
            return Ok(frame);
        }
        if let Some(earlier) = earlier {
            open.take_decor_of(&earlier, self.settings.wishes.with_depth);
            self.ended(earlier, over.unwrap_or(Over::Planned(End::Done)), watch);
        }
        watch(&Event::Began(stage, &open.period));
        self.open = Some(open);
        Ok(frame)
    }

    fn ended(&mut self, open: Open, over: Over, watch: Watch<'_>) {
        let (end, failed) = match over {
            Over::Planned(end) => (end, None),
            Over::Failed(what) => (End::PredictionFailed, Some(what)),
        };
        let plan = Plan {
            wishes: self.settings.wishes.clone(),
            periods: vec![Period { end, ..open.period }],
        };
        for summary in period_summaries(&plan) {
            let summary = PeriodSummary {
                length: open.served,
                failed: failed.clone(),
                ..summary
            };
            watch(&Event::Ended(&summary));
            self.done.periods.push(summary);
        }
    }
}

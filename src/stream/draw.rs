//! One frame of a stream, rendered by the executor of plans.

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, OnceLock};

use decor_api::{Layer, RunContext};

use super::Stream;
use super::period::Open;
use crate::frames::name;
use crate::plan::{Period, Plan, jobs};
use crate::render::{
    Execution, Joint, PeriodGround, RenderError, Slots, Traced, TracedPixels, Wanted, join,
};
use crate::stage::Stage;

impl Stream {
    /// Renders, merges and writes the only frame of `frame`, which `open`
    /// serves; gives its file. The décor is rendered beside its first frame, and
    /// what it dissolves into beside the second: a period that fails at once has
    /// no use for it.
    pub(super) fn draw(
        &mut self,
        open: &mut Open,
        stage: &Arc<Stage>,
        frame: Period,
    ) -> Result<PathBuf, RenderError> {
        let number = frame.start;
        let plan = Plan {
            wishes: self.settings.wishes.clone(),
            periods: vec![frame],
        };
        let now = self.execution(stage, &plan, open.period.start);
        let then = self.execution(&open.stage, &plan, open.period.start);
        let is_first = open.ground.is_none();
        let dissolves = open.decor.is_some() && open.period.dissolve_until.is_some();
        let for_target = !is_first && dissolves && !open.has_target;
        let made: OnceLock<Made> = OnceLock::new();
        let mut error = None;
        let drawn = std::thread::scope(|scope| {
            let (open, then) = (&*open, &then);
            let making =
                (is_first || for_target).then(|| scope.spawn(|| make(then, open, for_target)));
            now.chunk(&plan.periods[0], number..number + 1, || match making {
                None => open.ground.as_ref(),
                Some(making) => match join(making) {
                    Ok(ground) => Some(&made.get_or_init(|| ground).ground),
                    Err(failed) => {
                        error = Some(failed);
                        None
                    }
                },
            })
        });
        let traced = [now.traced.read(), then.traced.read()];
        drop((now, then));
        for traced in traced {
            add(&mut self.done.traced, traced);
        }
        drawn?;
        if let Some(error) = error {
            return Err(error);
        }
        if let Some(made) = made.into_inner() {
            open.decor = made.decor;
            open.ground = Some(made.ground);
            open.has_target |= for_target;
        }
        let options = &self.settings.options;
        Ok(options.out.join(name(number, options.format)))
    }

    pub(super) fn context(&self, work: &Path) -> RunContext {
        let options = &self.settings.options;
        RunContext {
            work: work.to_owned(),
            keep: options.keep.is_some(),
            timeout: options.timeout,
            threads: None,
            cancel: Arc::clone(&options.cancel),
            tally: Arc::clone(&self.tally),
        }
    }

    fn execution<'a>(&'a self, stage: &'a Stage, plan: &'a Plan, period: u32) -> Execution<'a> {
        let options = &self.settings.options;
        let work = if options.keep.is_some() {
            // Two periods may dissolve towards one frame.
            self.work.path.join(format!("period_{period:04}"))
        } else {
            self.work.path.clone()
        };
        Execution {
            stage,
            plan,
            options,
            run: self.context(&work),
            slots: Slots::new(options.jobs.unwrap_or_else(|| jobs(stage))),
            hands: Slots::new(1),
            traced: Traced::default(),
            watch: &|_, _| {},
            written: AtomicU64::new(0),
            jobs: 1,
            // Nobody knows what the next frames need.
            keep_colours: true,
            // A frame is alone, and waited for.
            threads: None,
        }
    }
}

/// What frames begin with.
struct Made {
    decor: Option<Arc<Layer>>,
    ground: PeriodGround,
}

fn make(then: &Execution<'_>, open: &Open, for_target: bool) -> Result<Made, RenderError> {
    let period = &open.period;
    let decor = match &open.decor {
        Some(decor) => Some(Arc::clone(decor)),
        None if then.needs_decor(period) => {
            let wanted = Wanted {
                begins: Some(period),
                ends: None,
            };
            then.joint(wanted)?.decor
        }
        None => None,
    };
    let target = if for_target {
        let wanted = Wanted {
            begins: None,
            ends: Some(period),
        };
        then.joint(wanted)?.target
    } else {
        None
    };
    let begins = Joint {
        decor: decor.clone(),
        ..Joint::default()
    };
    let ends = Joint {
        target,
        ..Joint::default()
    };
    let ground = then.ground(period, Some(&begins), Some(&ends));
    Ok(Made { decor, ground })
}

fn add(sum: &mut TracedPixels, more: TracedPixels) {
    sum.decor += more.decor;
    sum.fast += more.fast;
    sum.depth += more.depth;
    sum.shadow += more.shadow;
    sum.blocks += more.blocks;
    sum.whole += more.whole;
}

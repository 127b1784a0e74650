//! Which thread does what next: joints as few ahead as possible, so that few
//! décors are in memory, and no core without work.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

use super::RenderError;
use super::execution::Execution;
use super::ground::PeriodGround;
use super::joint::{Joint, Wanted};
use super::pace;
use crate::plan::{Period, periods_at_once};

/// A joint under way or done.
struct JointSlot {
    /// The period that begins there.
    index: usize,
    /// Is a target wanted of the period before?
    for_target: bool,
    /// Is the décor of the period wanted?
    for_decor: bool,
    /// `None` inside: it failed.
    done: OnceLock<Option<Joint>>,
}

/// A period under way. Its frames' layers are rendered while its décor is: only
/// the merge needs both.
struct Open {
    period: usize,
    before: Option<Arc<JointSlot>>,
    after: Option<Arc<JointSlot>>,
    ground: OnceLock<PeriodGround>,
    chunks_left: AtomicUsize,
}

enum Task {
    /// Render a joint; chunks may be waiting for it.
    Joint(Arc<JointSlot>),
    /// Render some frames of a period.
    Chunk(Arc<Open>, Range<u32>),
}

#[derive(Default)]
struct State {
    /// Joints stand before the chunks that wait for them: whoever takes a chunk
    /// knows that its joints are being rendered, and nobody waits for ever.
    tasks: VecDeque<Task>,
    /// The joint at the end of the period that was opened last.
    newest_joint: Option<Arc<JointSlot>>,
    next_period: usize,
    open: usize,
    error: Option<RenderError>,
}

struct Queue {
    state: Mutex<State>,
    changed: Condvar,
    periods: usize,
    at_once: usize,
}

/// Executes all periods.
pub fn run(execution: &Execution<'_>) -> Result<(), RenderError> {
    let pixels = execution.stage.size().pixels() as f64;
    let queue = Queue {
        state: Mutex::default(),
        changed: Condvar::new(),
        periods: execution.plan.periods.len(),
        at_once: periods_at_once(pixels, execution.jobs),
    };
    std::thread::scope(|scope| {
        let (at_work, workers) = std::sync::mpsc::channel();
        for _ in 0..execution.jobs {
            let (at_work, queue) = (at_work.clone(), &queue);
            scope.spawn(move || {
                queue.work(execution);
                drop(at_work);
            });
        }
        // A number that the user gives is kept.
        if execution.options.jobs.is_none() {
            scope.spawn(move || pace::keep(execution, &workers));
        }
    });
    match queue.lock().error.take() {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

/// Tells those who wait for a joint when it is there or has failed, also by a
/// panic: nobody waits for ever.
struct Told<'a> {
    queue: &'a Queue,
    slot: &'a JointSlot,
}

impl Drop for Told<'_> {
    fn drop(&mut self) {
        let _ = self.slot.done.set(None);
        // Under the lock: who waits has either seen it, or is woken.
        let _state = self.queue.lock();
        self.queue.changed.notify_all();
    }
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self, execution: &Execution<'_>) {
        while let Some(task) = self.next(execution) {
            let result = match task {
                Task::Joint(slot) => self.joint(execution, &slot),
                Task::Chunk(open, frames) => {
                    let wait = || self.ground(execution, &open);
                    let result = execution.chunk(execution.period(open.period), frames, wait);
                    if open.chunks_left.fetch_sub(1, Ordering::AcqRel) == 1 {
                        self.lock().open -= 1;
                    }
                    result
                }
            };
            if let Err(error) = result {
                // The first error is the cause; what follows is its echo.
                self.lock().error.get_or_insert(error);
                // Calls of other threads are of no use any more.
                execution.give_up();
            }
            self.changed.notify_all();
        }
    }

    /// The next task; waits for one; `None` when there will be none.
    fn next(&self, execution: &Execution<'_>) -> Option<Task> {
        let mut state = self.lock();
        loop {
            if state.error.is_some() {
                return None;
            }
            if let Some(task) = state.tasks.pop_front() {
                return Some(task);
            }
            if state.next_period < self.periods && state.open < self.at_once {
                let index = state.next_period;
                state.next_period += 1;
                open(execution, &mut state, index);
                self.changed.notify_all();
                continue;
            }
            if state.next_period >= self.periods && state.open == 0 {
                return None;
            }
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn joint(&self, execution: &Execution<'_>, slot: &JointSlot) -> Result<(), RenderError> {
        let told = Told { queue: self, slot };
        let periods = &execution.plan.periods;
        let before = slot.index.checked_sub(1).map(|index| &periods[index]);
        let wanted = Wanted {
            begins: periods.get(slot.index).filter(|_| slot.for_decor),
            ends: before.filter(|_| slot.for_target),
        };
        let joint = execution.joint(wanted)?;
        let _ = slot.done.set(Some(joint));
        drop(told);
        Ok(())
    }

    /// What the frames of a period begin with, when its joints are done; `None`
    /// where one failed.
    fn ground<'o>(&self, execution: &Execution<'_>, open: &'o Open) -> Option<&'o PeriodGround> {
        let joint = |slot: &'o Option<Arc<JointSlot>>| match slot {
            Some(slot) => self.wait_for(slot).map(Some),
            None => Some(None),
        };
        let (begins, ends) = (joint(&open.before)?, joint(&open.after)?);
        let period = execution.period(open.period);
        Some(
            open.ground
                .get_or_init(|| execution.ground(period, begins, ends)),
        )
    }

    fn wait_for<'o>(&self, slot: &'o JointSlot) -> Option<&'o Joint> {
        let mut state = self.lock();
        loop {
            if let Some(joint) = slot.done.get() {
                return joint.as_ref();
            }
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Queues what a period needs: its joints first, then its frames.
fn open(execution: &Execution<'_>, state: &mut State, index: usize) {
    let period = execution.period(index);
    let chunks = execution.chunks(period);
    let needed =
        |period: &Period| execution.needs_decor(period) && !execution.chunks(period).is_empty();
    let earlier = state.newest_joint.take();
    if chunks.is_empty() {
        return;
    }
    let slot = |state: &mut State, index: usize, for_decor: bool, for_target: bool| {
        let slot = Arc::new(JointSlot {
            index,
            for_target,
            for_decor,
            done: OnceLock::new(),
        });
        state.tasks.push_back(Task::Joint(Arc::clone(&slot)));
        slot
    };
    let before = match earlier {
        Some(slot) => Some(slot),
        None if needed(period) => Some(slot(state, index, true, false)),
        None => None,
    };
    // The joint at its end serves the next period, too.
    let after = period.dissolve_until.map(|_| {
        let next = execution.plan.periods.get(index + 1);
        slot(state, index + 1, next.is_some_and(needed), true)
    });
    state.newest_joint.clone_from(&after);
    state.open += 1;
    let open = Arc::new(Open {
        period: index,
        before,
        after,
        ground: OnceLock::new(),
        chunks_left: AtomicUsize::new(chunks.len()),
    });
    for frames in chunks {
        state
            .tasks
            .push_back(Task::Chunk(Arc::clone(&open), frames));
    }
}

//! Which thread does what next: décors as few ahead as possible, so that few
//! are in memory, and no core without work.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, OnceLock, PoisonError};

use super::RenderError;
use super::chunk::{Execution, PeriodGround};

/// Periods whose décor is in memory at once, at most: the next one is rendered
/// while the last frames of the one before are.
const PERIODS_AT_ONCE: usize = 2;

/// A period under way. Its frames' layers are rendered while its décor is: only
/// the merge needs both.
struct Open {
    period: usize,
    /// `None` inside: the décor failed.
    ground: OnceLock<Option<PeriodGround>>,
    chunks_left: AtomicUsize,
}

enum Task {
    /// Render the décor of a period, with its chunks waiting or running.
    Ground(Arc<Open>),
    /// Render some frames of a period.
    Chunk(Arc<Open>, Range<u32>),
}

#[derive(Default)]
struct State {
    chunks: VecDeque<(Arc<Open>, Range<u32>)>,
    next_period: usize,
    open: usize,
    error: Option<RenderError>,
}

struct Queue {
    state: Mutex<State>,
    changed: Condvar,
    periods: usize,
}

/// Executes all periods.
pub fn run(execution: &Execution<'_>) -> Result<(), RenderError> {
    let queue = Queue {
        state: Mutex::default(),
        changed: Condvar::new(),
        periods: execution.plan.periods.len(),
    };
    std::thread::scope(|scope| {
        for _ in 0..execution.jobs {
            scope.spawn(|| queue.work(execution));
        }
    });
    match queue.lock().error.take() {
        Some(error) => Err(error),
        None => Ok(()),
    }
}

/// Tells those who wait for a décor when it is there or has failed, also by a
/// panic: nobody waits for ever.
struct Told<'a> {
    queue: &'a Queue,
    open: &'a Open,
}

impl Drop for Told<'_> {
    fn drop(&mut self) {
        let _ = self.open.ground.set(None);
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
                Task::Ground(open) => self.ground(execution, &open),
                Task::Chunk(open, frames) => {
                    let wait = || self.wait_for_ground(&open);
                    let result = execution.chunk(open.period, frames, wait);
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
            if let Some((open, frames)) = state.chunks.pop_front() {
                return Some(Task::Chunk(open, frames));
            }
            if state.next_period < self.periods && state.open < PERIODS_AT_ONCE {
                let period = state.next_period;
                state.next_period += 1;
                let chunks = execution.chunks(period);
                if chunks.is_empty() {
                    continue;
                }
                state.open += 1;
                let open = Arc::new(Open {
                    period,
                    ground: OnceLock::new(),
                    chunks_left: AtomicUsize::new(chunks.len()),
                });
                for frames in chunks {
                    state.chunks.push_back((Arc::clone(&open), frames));
                }
                self.changed.notify_all();
                return Some(Task::Ground(open));
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

    fn ground(&self, execution: &Execution<'_>, open: &Open) -> Result<(), RenderError> {
        let told = Told { queue: self, open };
        let ground = execution.ground(open.period)?;
        let _ = open.ground.set(Some(ground));
        drop(told);
        Ok(())
    }

    /// The décor of a period, when it is there; `None` where it failed.
    fn wait_for_ground<'o>(&self, open: &'o Open) -> Option<&'o PeriodGround> {
        let mut state = self.lock();
        loop {
            if let Some(ground) = open.ground.get() {
                return ground.as_ref();
            }
            state = self
                .changed
                .wait(state)
                .unwrap_or_else(PoisonError::into_inner);
        }
    }
}

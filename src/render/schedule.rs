//! Which thread does what next: décors as few ahead as possible, so that few
//! are in memory, and no core without work.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use super::RenderError;
use super::chunk::{Execution, PeriodGround};

/// Periods whose décor is in memory at once, at most: the next one is rendered
/// while the last frames of the one before are.
const PERIODS_AT_ONCE: usize = 2;

/// A period under way.
struct Open {
    ground: PeriodGround,
    chunks_left: AtomicUsize,
}

enum Task {
    /// Render the décor of a period.
    Begin(usize),
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

impl Queue {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn work(&self, execution: &Execution<'_>) {
        while let Some(task) = self.next() {
            let result = match task {
                Task::Begin(index) => self.begin(execution, index),
                Task::Chunk(open, frames) => {
                    let result = execution.chunk(&open.ground, frames);
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
    fn next(&self) -> Option<Task> {
        let mut state = self.lock();
        loop {
            if state.error.is_some() {
                return None;
            }
            if let Some((open, frames)) = state.chunks.pop_front() {
                return Some(Task::Chunk(open, frames));
            }
            if state.next_period < self.periods && state.open < PERIODS_AT_ONCE {
                let index = state.next_period;
                state.next_period += 1;
                state.open += 1;
                return Some(Task::Begin(index));
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

    fn begin(&self, execution: &Execution<'_>, index: usize) -> Result<(), RenderError> {
        let chunks = execution.chunks(index);
        if chunks.is_empty() {
            self.lock().open -= 1;
            return Ok(());
        }
        let ground = match execution.ground(index) {
            Ok(ground) => ground,
            Err(error) => {
                self.lock().open -= 1;
                return Err(error);
            }
        };
        let open = Arc::new(Open {
            ground,
            chunks_left: AtomicUsize::new(chunks.len()),
        });
        let mut state = self.lock();
        for frames in chunks {
            state.chunks.push_back((Arc::clone(&open), frames));
        }
        Ok(())
    }
}

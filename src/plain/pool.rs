//! Workers side by side.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use decor_api::{AdapterError, RunContext};

use super::pace::Pace;
use super::queue::Queue;
use crate::render::RenderError;
use crate::report::Clock;

/// Between two looks of a worker that is not needed.
const IDLE: Duration = Duration::from_millis(20);

/// How many workers.
#[derive(Clone, Copy, Debug)]
pub struct Workers {
    /// So many, if it was stated.
    pub stated: Option<usize>,
    /// At most, where it was not.
    pub most: usize,
    /// The machine's cores.
    pub cores: usize,
}

impl Workers {
    /// As many as keep the cores busy with work that does not sleep.
    pub fn busy(&self) -> usize {
        self.stated.unwrap_or(self.cores.min(self.most)).max(1)
    }

    /// As many as there may be, for work that sleeps.
    pub fn all(&self) -> usize {
        self.stated.unwrap_or(self.most).max(1)
    }
}

/// How a pool is held while it runs.
#[derive(Debug)]
pub struct Reins {
    is_short: AtomicBool,
    is_halted: AtomicBool,
    left: AtomicUsize,
}

impl Reins {
    /// Parts are as short as they can be.
    pub fn short() -> Self {
        Self {
            is_short: AtomicBool::new(true),
            is_halted: AtomicBool::new(false),
            left: AtomicUsize::new(usize::MAX),
        }
    }

    /// Parts are as long as they like.
    pub fn loosen(&self) {
        self.is_short.store(false, Ordering::Relaxed);
    }

    /// No further part begins.
    pub fn halt(&self) {
        self.is_halted.store(true, Ordering::Relaxed);
    }

    /// So many frames have not begun.
    pub fn left(&self) -> usize {
        self.left.load(Ordering::Relaxed)
    }

    fn take(&self, queue: &mut Queue, pace: &Pace, cores: usize) -> Option<(u32, u32)> {
        let most = if self.is_short.load(Ordering::Relaxed) {
            pace.short(cores)
        } else {
            usize::MAX
        };
        let part = queue.take(pace, most);
        self.left.store(queue.left(), Ordering::Relaxed);
        part
    }
}

/// What the workers of a pool share.
struct State {
    queue: Queue,
    pace: Pace,
    /// Frames that are in their places.
    done: u64,
    failure: Option<RenderError>,
}

/// Renders frames in parts, from a first to a last one, in any order, but those in
/// `before` one by one, and before all others. Parts have `longest` frames at most;
/// `work` gives how many frames are in their places.
///
/// # Errors
/// The first thing that went wrong.
#[expect(clippy::too_many_arguments, reason = "a pool has one caller a case")]
pub fn pool(
    frames: &BTreeSet<u32>,
    before: &[u32],
    step: u32,
    longest: usize,
    first: Pace,
    workers: Workers,
    run: &RunContext,
    reins: Option<&Reins>,
    work: impl Fn(u32, u32) -> Result<u64, RenderError> + Sync,
) -> Result<(), RenderError> {
    let clock = Clock::start();
    let state = Mutex::new(State {
        queue: Queue::new(frames, before, step).in_parts_of(longest),
        pace: first,
        done: 0,
        failure: None,
    });
    let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
    let worker = |number: usize| {
        let halted = || reins.is_some_and(|reins| reins.is_halted.load(Ordering::Relaxed));
        while !run.is_cancelled() && !halted() {
            let part = {
                let mut state = lock();
                if state.queue.is_empty() {
                    return;
                }
                if number < state.pace.processes {
                    let pace = state.pace;
                    match reins {
                        Some(reins) => reins.take(&mut state.queue, &pace, workers.cores),
                        None => state.queue.take(&pace, usize::MAX),
                    }
                } else {
                    None
                }
            };
            let Some((first, last)) = part else {
                // Not needed now; perhaps when the first frames are done.
                std::thread::sleep(IDLE);
                continue;
            };
            match work(first, last) {
                Ok(count) => {
                    let mut state = lock();
                    state.done += count;
                    let each_s = clock.cpu_s() / state.done as f64;
                    state.pace = Pace::after(each_s, workers.stated, workers.most, workers.cores);
                }
                Err(error) => {
                    lock().failure.get_or_insert(error);
                    run.cancel.store(true, Ordering::Relaxed);
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for number in 0..workers.all().min(frames.len()) {
            let worker = &worker;
            scope.spawn(move || worker(number));
        }
    });
    let state = state.into_inner().unwrap_or_else(PoisonError::into_inner);
    match state.failure {
        Some(error) => Err(error),
        None if run.is_cancelled() => Err(AdapterError::Cancelled.into()),
        None => Ok(()),
    }
}

/// Does something with each item, `at_once` at a time; the results are in the
/// items' order.
///
/// # Errors
/// The first thing that went wrong. What has begun is ended, nothing more begins.
pub fn side_by_side<T: Sync, R: Send, E: Send>(
    items: &[T],
    at_once: usize,
    work: impl Fn(&T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    let next = AtomicUsize::new(0);
    let results: Vec<Mutex<Option<Result<R, E>>>> =
        items.iter().map(|_| Mutex::default()).collect();
    std::thread::scope(|scope| {
        for _ in 0..at_once.clamp(1, items.len().max(1)) {
            scope.spawn(|| {
                while let Some(at) = Some(next.fetch_add(1, Ordering::Relaxed))
                    && let Some(item) = items.get(at)
                {
                    let result = work(item);
                    if result.is_err() {
                        next.store(items.len(), Ordering::Relaxed);
                    }
                    *results[at].lock().unwrap_or_else(PoisonError::into_inner) = Some(result);
                }
            });
        }
    });
    let results = results.into_iter();
    results
        .filter_map(|result| result.into_inner().unwrap_or_else(PoisonError::into_inner))
        .collect()
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    fn run() -> RunContext {
        RunContext::new(PathBuf::new())
    }

    const ALONE: Workers = Workers {
        stated: Some(1),
        most: 1,
        cores: 1,
    };

    #[test]
    fn a_halted_pool_begins_nothing_more() {
        let pace = Pace::of(Some(1.0), &ALONE);
        let frames: BTreeSet<u32> = (1..=50).collect();
        let rendered = |halted_after: usize| {
            let (reins, parts) = (Reins::short(), AtomicUsize::new(0));
            let work = |first, last| {
                if parts.fetch_add(1, Ordering::Relaxed) + 1 == halted_after {
                    reins.halt();
                }
                Ok(u64::from(last - first + 1_u32))
            };
            let reins = Some(&reins);
            pool(&frames, &[], 1, 1, pace, ALONE, &run(), reins, work).unwrap();
            parts.into_inner()
        };
        assert_eq!((rendered(3), rendered(0)), (3, 50));
    }

    #[test]
    fn parts_are_short_until_they_are_loosened() {
        // Frames that cost nothing come in eights.
        let pace = Pace::of(Some(0.0), &ALONE);
        let frames: BTreeSet<u32> = (1..=200).collect();
        let (reins, parts) = (Reins::short(), Mutex::new(Vec::new()));
        let work = |first, last| {
            let mut parts = parts.lock().unwrap();
            parts.push((first, last));
            if parts.len() == 4 {
                assert_eq!(reins.left(), 182);
                reins.loosen();
            }
            Ok(u64::from(last - first + 1_u32))
        };
        let before = [1, 101];
        pool(
            &frames,
            &before,
            1,
            99,
            pace,
            ALONE,
            &run(),
            Some(&reins),
            work,
        )
        .unwrap();
        let parts = parts.into_inner().unwrap();
        assert_eq!(parts[..4], [(1, 1), (101, 101), (2, 9), (10, 17)]);
        assert!(parts[4].1 - parts[4].0 > 8, "{parts:?}");
    }

    #[test]
    fn results_are_in_order_and_errors_end_it() {
        let items: Vec<u32> = (0..50).collect();
        let doubled = side_by_side(&items, 4, |n| Ok::<_, ()>(n * 2)).unwrap();
        assert_eq!(doubled, items.iter().map(|n| n * 2).collect::<Vec<_>>());
        let begun = AtomicUsize::new(0);
        let failed = side_by_side(&items, 1, |n| {
            begun.fetch_add(1, Ordering::Relaxed);
            if *n == 3 { Err(*n) } else { Ok(()) }
        });
        assert_eq!((failed, begun.into_inner()), (Err(3), 4));
        assert_eq!(side_by_side(&[], 4, |n: &u32| Ok::<_, ()>(*n)), Ok(vec![]));
    }
}

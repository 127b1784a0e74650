//! Workers side by side.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use decor_api::{AdapterError, RunContext};

use super::pace::Pace;
use super::queue::Queue;
use super::ramp::{Ramp, Ticks};
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
pub struct Reins<'r> {
    /// Might frames that cost so much CPU, of which so many are left, be halted?
    may_halt: Box<dyn Fn(f64, usize) -> bool + Sync + 'r>,
    is_short: AtomicBool,
    is_halted: AtomicBool,
    left: AtomicUsize,
}

impl<'r> Reins<'r> {
    /// Parts are as short as they can be, where they might be the last ones.
    pub fn short_where(may_halt: impl Fn(f64, usize) -> bool + Sync + 'r) -> Self {
        Self {
            may_halt: Box::new(may_halt),
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

    /// Frames in a part, at most, where so many are left.
    fn most(&self, pace: &Pace, left: usize) -> usize {
        let is_short = self.is_short.load(Ordering::Relaxed);
        if is_short && (self.may_halt)(pace.frame_cpu_s(), left) {
            pace.short()
        } else {
            usize::MAX
        }
    }
}

/// What the workers of a pool share.
struct State<'p> {
    queue: Queue,
    /// When a frame is done.
    pace: Option<Pace>,
    /// Until then.
    ramp: Ramp,
    reins: Option<&'p Reins<'p>>,
    running: usize,
    /// Frames that are in their places.
    done: u64,
    failure: Option<RenderError>,
}

impl State<'_> {
    /// The next part, if there is to be one now.
    fn take(&mut self) -> Option<(u32, u32)> {
        let left = self.queue.left();
        let next = match &self.pace {
            None => self.ramp.next(self.running),
            Some(pace) => {
                let most = self
                    .reins
                    .map_or(usize::MAX, |reins| reins.most(pace, left));
                pace.next(left, most)
            }
        };
        if self.running >= next.processes {
            return None;
        }
        let part = self.queue.take(next.frames)?;
        self.running += 1;
        if let Some(reins) = self.reins {
            reins.left.store(self.queue.left(), Ordering::Relaxed);
        }
        Some(part)
    }
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
    pace: Option<Pace>,
    workers: Workers,
    run: &RunContext,
    reins: Option<&Reins<'_>>,
    work: impl Fn(u32, u32) -> Result<u64, RenderError> + Sync,
) -> Result<(), RenderError> {
    let clock = Clock::start();
    let state = Mutex::new(State {
        queue: Queue::new(frames, before, step).in_parts_of(longest),
        pace,
        ramp: Ramp::new(workers),
        reins,
        running: 0,
        done: 0,
        failure: None,
    });
    let used_before = run.tally.cpu();
    let lock = || state.lock().unwrap_or_else(PoisonError::into_inner);
    let worker = || {
        let halted = || reins.is_some_and(|reins| reins.is_halted.load(Ordering::Relaxed));
        while !run.is_cancelled() && !halted() {
            let part = {
                let mut state = lock();
                if state.queue.is_empty() {
                    return;
                }
                if state.pace.is_none() {
                    let used = run.tally.cpu().saturating_sub(used_before);
                    let used_s = used.as_secs_f64();
                    state.ramp.look(clock.wall_s(), used_s, Ticks::now);
                }
                state.take()
            };
            let Some((first, last)) = part else {
                // Not needed now; perhaps when the first frames are done.
                std::thread::sleep(IDLE);
                continue;
            };
            let worked = work(first, last);
            let mut state = lock();
            state.running -= 1;
            match worked {
                Ok(count) => {
                    state.done += count;
                    if state.done > 0 {
                        let each_s = clock.cpu_s() / state.done as f64;
                        state.pace = Some(Pace::of(each_s, &workers));
                    }
                }
                Err(error) => {
                    state.failure.get_or_insert(error);
                    run.cancel.store(true, Ordering::Relaxed);
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..workers.all().min(frames.len()) {
            scope.spawn(worker);
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

    /// The parts of frames of which each costs so much, rendered by one worker that
    /// is told how many parts have begun.
    fn parts_of(
        frames: u32,
        before: &[u32],
        each_s: f64,
        reins: &Reins<'_>,
        told: impl Fn(usize) + Sync,
    ) -> Vec<(u32, u32)> {
        let (pace, frames) = (Pace::of(each_s, &ALONE), (1..=frames).collect());
        let parts = Mutex::new(Vec::new());
        let work = |first, last| {
            let mut parts = parts.lock().unwrap();
            parts.push((first, last));
            told(parts.len());
            Ok(u64::from(last - first + 1_u32))
        };
        let (run, reins) = (run(), Some(reins));
        pool(&frames, before, 1, 99, Some(pace), ALONE, &run, reins, work).unwrap();
        parts.into_inner().unwrap()
    }

    #[test]
    fn a_halted_pool_begins_nothing_more() {
        let begun = |halted_after| {
            let reins = Reins::short_where(|_, _| true);
            let told = |begun| {
                if begun == halted_after {
                    reins.halt();
                }
            };
            parts_of(50, &[], 1.0, &reins, told).len()
        };
        assert_eq!(begun(3), 3);
        assert!(begun(0) > 3);
    }

    #[test]
    fn parts_are_short_until_they_are_loosened() {
        // Frames that cost nothing come in eights.
        let reins = Reins::short_where(|_, _| true);
        let told = |begun| {
            if begun == 4 {
                assert_eq!(reins.left(), 182);
                reins.loosen();
            }
        };
        let parts = parts_of(200, &[1, 101], 0.0, &reins, told);
        assert_eq!(parts[..4], [(1, 1), (101, 101), (2, 9), (10, 17)]);
        assert!(parts[4].1 - parts[4].0 > 8, "{parts:?}");
    }

    #[test]
    fn parts_that_cannot_be_the_last_ones_are_long_at_once() {
        let free = Reins::short_where(|_, _| true);
        free.loosen();
        let as_free = parts_of(200, &[1, 101], 0.0, &free, |_| ());
        let light = Reins::short_where(|each_s, left| each_s > 0.5 && left > 9);
        assert_eq!(parts_of(200, &[1, 101], 0.0, &light, |_| ()), as_free);
    }

    #[test]
    fn before_a_frame_is_done_each_core_has_one() {
        let two = Workers {
            stated: None,
            most: 2,
            cores: 2,
        };
        let (begun, parts) = (std::sync::Barrier::new(2), Mutex::new(Vec::new()));
        let work = |first, last| {
            if first <= 2 {
                begun.wait();
            }
            parts.lock().unwrap().push((first, last));
            Ok(u64::from(last - first + 1_u32))
        };
        let frames = (1..=40).collect();
        pool(&frames, &[], 1, 99, None, two, &run(), None, work).unwrap();
        let mut parts = parts.into_inner().unwrap();
        parts.sort_unstable();
        assert_eq!(parts[..2], [(1, 1), (2, 2)]);
        assert!(parts[2].1 > parts[2].0, "{parts:?}");
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

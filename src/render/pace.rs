//! How many calls run at once: as many as keep the cores busy, found by watching.
//!
//! A renderer that draws small pictures sleeps most of the time: many calls at once
//! fill the cores. One that computes all the time fills a core by itself: more calls
//! than cores only share caches and take memory.

use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::{Duration, Instant};

use nix::time::ClockId;

use super::execution::Execution;
use crate::probe::{cores, cpu_s};

/// Between two looks. CPU time is told in pieces of some 40 ms: shorter ones would
/// see little else.
const LOOK: Duration = Duration::from_millis(500);

/// The share of the cores' time above which fewer calls would do as well. What is
/// lost here is time, and what is won memory: so it is near to all.
const FULL: f64 = 0.99;

/// The share below which there is room for more.
const ROOM: f64 = 0.97;

/// How many calls may run, where `limit` might, `taken` do, and the cores were so
/// busy; between `cores` and `most`.
fn next(limit: usize, taken: usize, busy: f64, (cores, most): (usize, usize)) -> usize {
    // A limit that nobody comes to says nothing: one call may be a décor that fills
    // all cores, before the frames' calls begin.
    let wanted = if taken < limit {
        limit
    } else if busy > FULL {
        limit - 1
    } else if busy < ROOM {
        limit + limit.div_ceil(4)
    } else {
        limit
    };
    wanted.max(cores).min(most)
}

/// Watches until nobody is left who could send.
pub fn keep(execution: &Execution<'_>, workers: &Receiver<()>) {
    let (cores, most) = (cores(), execution.jobs);
    let own_s = || cpu_s(ClockId::CLOCK_PROCESS_CPUTIME_ID);
    let used = || execution.run.tally.cpu().as_secs_f64() + own_s();
    let (mut since, mut before) = (Instant::now(), used());
    while let Err(RecvTimeoutError::Timeout) = workers.recv_timeout(LOOK) {
        let (now, after) = (Instant::now(), used());
        let busy = (after - before) / ((now - since).as_secs_f64() * cores as f64);
        (since, before) = (now, after);
        let (limit, taken) = execution.slots.counts();
        let allowed = next(limit, taken, busy, (cores, most));
        if allowed != limit {
            tracing::debug!(busy, taken, allowed, "calls at once");
            execution.slots.allow(allowed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where the limit comes to, if each call keeps a core busy for such a share of
    /// the time, and there is always another one.
    fn settles(share: f64, start: usize) -> usize {
        let room = (2, 16);
        (0..100).fold(start, |limit, _| {
            let busy = (share * limit as f64 / 2.0).min(1.0);
            next(limit, limit, busy, room)
        })
    }

    #[test]
    fn as_many_as_keep_the_cores_busy() {
        for start in [2, 7, 16] {
            assert!((2..=3).contains(&settles(1.0, start)));
            assert!(
                (4..=7).contains(&settles(0.4, start)),
                "{}",
                settles(0.4, start)
            );
            assert_eq!(settles(0.05, start), 16);
        }
    }

    #[test]
    fn a_limit_that_nobody_comes_to_stays() {
        assert_eq!(next(4, 1, 0.3, (2, 16)), 4);
        assert_eq!(next(16, 1, 1.0, (2, 16)), 16);
        assert_eq!(next(1, 1, f64::NAN, (4, 2)), 2);
    }
}

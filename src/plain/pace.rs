//! How many processes at once, and how many frames in a part: by what a frame costs.
//!
//! POV-Ray sleeps about a quarter of a second a frame, and longer where it begins
//! and ends. A frame of 20 ms of CPU needs many processes beside it until a core has
//! no pause; one of 10 s needs one more at most, and every further one would cost
//! memory and cache. A call also takes some CPU: parts should be long. But nobody
//! should wait for the last one: so each is a share of what is left.

use super::pool::Workers;
use crate::shares::share_of;

/// What a frame of an animation sleeps, in seconds: measured with 3.7.0.10.
pub const SLEEP_S: f64 = 0.25;

/// What a call sleeps besides, when it begins and when it ends: a call of one tiny
/// frame takes 0.65 s.
const CALL_SLEEP_S: f64 = 0.4;

/// What a call costs beside its frames, in seconds of CPU: 20 calls of one tiny
/// frame took 0.56 s, one call of 20 such frames 0.27 s.
pub const CALL_CPU_S: f64 = 0.015;

/// Calls shall cost no more than this share of their frames' CPU …
const CALL_SHARE: f64 = 0.04;

/// … unless frames are so cheap that parts would be longer than this: then
/// there is little CPU to lose, and much time.
const SHORTEST_AT_MOST: f64 = 8.0;

/// No part takes much more CPU, in seconds.
const LONGEST_S: f64 = 30.0;

/// A short part takes so long at least, unless it is one frame or many: shorter ones
/// sleep for most of their time.
const SHORT_S: f64 = 1.5;

/// Processes are never evenly asleep: so many times those that must be there to make
/// up for sleep.
const SPARE: f64 = 2.0;

/// How a pool goes on.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// What a frame costs, in seconds of CPU.
    frame_cpu_s: f64,
    workers: Workers,
}

/// What comes next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Next {
    /// Processes at once, it included.
    pub processes: usize,
    /// Frames in it.
    pub frames: usize,
}

impl Pace {
    /// Where a frame costs so much CPU.
    pub fn of(frame_cpu_s: f64, workers: &Workers) -> Self {
        Self {
            frame_cpu_s: frame_cpu_s.max(1e-3),
            workers: *workers,
        }
    }

    /// What a frame costs, in seconds of CPU.
    pub fn frame_cpu_s(&self) -> f64 {
        self.frame_cpu_s
    }

    /// Processes at once, in parts of so many frames.
    fn processes(&self, frames: usize) -> usize {
        let Workers {
            stated,
            most,
            cores,
        } = self.workers;
        let slept_s = SLEEP_S + CALL_SLEEP_S / frames.max(1) as f64;
        let wanted = cores as f64 * (1.0 + SPARE * slept_s / self.frame_cpu_s);
        let processes = (wanted.ceil() as usize).clamp(cores.min(most), most);
        stated.unwrap_or(processes).max(1)
    }

    /// A part should have so many frames, that calls cost little.
    fn shortest(&self) -> usize {
        (CALL_CPU_S / (CALL_SHARE * self.frame_cpu_s))
            .min(SHORTEST_AT_MOST)
            .ceil() as usize
    }

    /// A part that may be the last one should have so many frames.
    pub fn short(&self) -> usize {
        let cores = self.workers.cores.max(1) as f64;
        let at_once = self.processes(self.shortest()) as f64;
        let frame_s = self.frame_cpu_s * (at_once / cores).max(1.0);
        let frames = (SHORT_S / frame_s).round().min(SHORTEST_AT_MOST) as usize;
        frames.max(self.shortest())
    }

    /// The next part, where so many frames are left; it has `most` at most.
    pub fn next(&self, left: usize, most: usize) -> Next {
        let shortest = self.shortest().min(most);
        let processes = self.processes(shortest);
        let share = share_of(left, processes);
        let by_time = (LONGEST_S / self.frame_cpu_s) as usize;
        Next {
            processes,
            frames: share.max(shortest).min(most).min(by_time).max(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pace(frame_cpu_s: f64, stated: Option<usize>, most: usize) -> Pace {
        let workers = Workers {
            stated,
            most,
            cores: 2,
        };
        Pace::of(frame_cpu_s, &workers)
    }

    fn processes(frame_cpu_s: f64) -> usize {
        pace(frame_cpu_s, None, 16).next(100, usize::MAX).processes
    }

    #[test]
    fn cheap_frames_get_many_processes_and_long_parts() {
        assert_eq!(
            (processes(0.015), pace(0.015, None, 16).shortest()),
            (16, 8)
        );
        // Two cores, and 0.45 s of sleep to 0.3 s of work, twice.
        assert_eq!((processes(0.3), pace(0.3, None, 16).shortest()), (8, 2));
        assert_eq!((processes(10.0), pace(10.0, None, 16).shortest()), (3, 1));
    }

    #[test]
    fn parts_shrink_towards_the_end() {
        let pace = pace(1.0, None, 16);
        let mut left = 400;
        let mut lengths = Vec::new();
        while left > 0 {
            let frames = pace.next(left, usize::MAX).frames.min(left);
            lengths.push(frames);
            left -= frames;
        }
        assert!(lengths[0] >= 25, "{lengths:?}");
        assert_eq!(lengths.last(), Some(&1));
        assert!(
            lengths.windows(2).all(|pair| pair[0] >= pair[1]),
            "{lengths:?}"
        );
        assert!(lengths.len() < 60, "{lengths:?}");
    }

    #[test]
    fn slow_frames_make_short_parts() {
        let frames = |cpu_s| pace(cpu_s, None, 2).next(400, usize::MAX).frames;
        assert_eq!((frames(15.0), frames(100.0)), (2, 1));
        assert_eq!(pace(1.0, None, 2).next(400, 5).frames, 5);
    }

    #[test]
    fn short_parts_take_a_second_or_two() {
        let short = |cpu_s| pace(cpu_s, None, 16).short();
        // Two cores, 7 processes: a frame of 0.4 s takes more than three times as long.
        assert_eq!((short(0.4), short(0.05), short(2.0)), (1, 8, 1));
    }

    #[test]
    fn what_is_stated_goes_first() {
        assert_eq!(pace(0.015, Some(1), 16).next(9, 9).processes, 1);
        assert_eq!(pace(10.0, Some(7), 16).next(9, 9).processes, 7);
        assert_eq!(pace(10.0, None, 1).next(9, 9).processes, 1);
    }
}

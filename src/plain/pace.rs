//! How many processes at once: as many as keep the cores busy, found by what
//! the first frames cost.
//!
//! POV-Ray sleeps about a quarter of a second a frame. A frame of 20 ms of CPU
//! needs many processes beside it until a core has no pause; one of 2 s needs
//! one more at most, and every further one would cost memory and cache.

use super::pool::Workers;

/// What a frame of an animation sleeps, in seconds: measured with 3.7.0.10.
pub const SLEEP_S: f64 = 0.25;

/// What a call costs beside its frames, in seconds of CPU: 20 calls of one tiny
/// frame took 0.56 s, one call of 20 such frames 0.27 s.
pub const CALL_CPU_S: f64 = 0.015;

/// Calls shall cost no more than this share of their frames' CPU …
const CALL_SHARE: f64 = 0.03;

/// … unless frames are so cheap that parts would be longer than this: then
/// there is little CPU to lose, and much time.
const SHORTEST_AT_MOST: f64 = 8.0;

/// A short part takes so long at least, unless it is one frame or many: shorter ones
/// sleep for most of their time.
const SHORT_S: f64 = 1.5;

/// Processes are never quite evenly asleep.
const SPARE: f64 = 1.25;

/// How a pool goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Processes at once.
    pub processes: usize,
    /// What a frame costs, in seconds of CPU; `None` where no frame is done.
    pub frame_cpu_s: Option<f64>,
}

impl Pace {
    /// To begin with, where a frame costs so much, if that is known.
    pub fn of(frame_cpu_s: Option<f64>, workers: &Workers) -> Self {
        let Workers {
            stated,
            most,
            cores,
        } = *workers;
        match frame_cpu_s {
            None => Self::first(stated, most, cores),
            Some(each_s) => Self::after(each_s, stated, most, cores),
        }
    }

    /// Before anything is known.
    pub fn first(stated: Option<usize>, most: usize, cores: usize) -> Self {
        Self {
            processes: stated.unwrap_or(cores.min(most)).max(1),
            frame_cpu_s: None,
        }
    }

    /// After frames that cost so much each.
    pub fn after(frame_cpu_s: f64, stated: Option<usize>, most: usize, cores: usize) -> Self {
        let cpu_s = frame_cpu_s.max(1e-3);
        let busy = cores as f64 * (SLEEP_S + cpu_s) / cpu_s * SPARE;
        let processes = (busy.ceil() as usize).clamp(cores.min(most), most);
        Self {
            processes: stated.unwrap_or(processes).max(1),
            frame_cpu_s: Some(cpu_s),
        }
    }

    /// A part should have so many frames, that calls cost little.
    pub fn shortest(&self) -> usize {
        let cpu_s = self.frame_cpu_s.unwrap_or(1.0).max(1e-3);
        (CALL_CPU_S / (CALL_SHARE * cpu_s))
            .min(SHORTEST_AT_MOST)
            .ceil() as usize
    }
}

impl Pace {
    /// A part that may be the last one should have so many frames.
    pub fn short(&self, cores: usize) -> usize {
        let cpu_s = self.frame_cpu_s.unwrap_or(SHORT_S).max(1e-3);
        let frame_s = cpu_s * (self.processes as f64 / cores.max(1) as f64).max(1.0);
        let frames = (SHORT_S / frame_s).round().min(SHORTEST_AT_MOST) as usize;
        frames.max(self.shortest())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cheap_frames_get_many_processes_and_long_parts() {
        let cheap = Pace::after(0.015, None, 16, 2);
        assert_eq!((cheap.processes, cheap.shortest()), (16, 8));
        let usual = Pace::after(0.3, None, 16, 2);
        assert_eq!((usual.processes, usual.shortest()), (5, 2));
        let heavy = Pace::after(10.0, None, 16, 2);
        assert_eq!((heavy.processes, heavy.shortest()), (3, 1));
    }

    #[test]
    fn short_parts_take_a_second_or_two() {
        let short = |cpu_s| Pace::after(cpu_s, None, 16, 2).short(2);
        // Two cores, 4 processes: a frame of 0.4 s takes twice as long.
        assert_eq!((short(0.4), short(0.05), short(2.0)), (2, 8, 1));
        assert_eq!(Pace::first(None, 16, 2).short(2), 1);
    }

    #[test]
    fn what_is_stated_goes_first() {
        assert_eq!(Pace::first(Some(7), 16, 2).processes, 7);
        assert_eq!(Pace::after(0.015, Some(1), 16, 2).processes, 1);
        assert_eq!(Pace::first(None, 16, 2).processes, 2);
        assert_eq!(Pace::first(None, 1, 8).processes, 1);
    }
}

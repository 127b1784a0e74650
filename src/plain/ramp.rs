//! Before any frame is done nobody knows what one costs. The cores get a single frame
//! each; and where they turn out to be idle, because POV-Ray sleeps, more parts begin
//! before the first ones have ended. A heavy frame keeps its core busy by then.

use super::pace::Next;
use super::pool::Workers;

/// POV-Ray begins asleep: nothing is told before, in seconds.
const BEGINS_S: f64 = 0.25;

/// Between two looks. CPU time is told in pieces of 0.1 s.
const LOOK_S: f64 = 0.15;

/// The share of the cores' time below which there is room for more.
const ROOM: f64 = 0.5;

/// Frames that keep no core busy are not heavy: two in a call cost little more than
/// one.
const FRAMES: usize = 2;

/// How a pool begins.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    workers: Workers,
    allowed: usize,
    /// When it was looked at last, since the beginning, and the CPU used by then, in
    /// seconds.
    seen: Option<(f64, f64)>,
}

impl Ramp {
    /// To begin with.
    pub fn new(workers: Workers) -> Self {
        Self {
            workers,
            allowed: workers.busy(),
            seen: None,
        }
    }

    /// A look, after so many seconds in which renderers used so much CPU.
    pub fn look(&mut self, now_s: f64, cpu_s: f64) {
        match self.seen {
            _ if now_s < BEGINS_S => {}
            None => self.seen = Some((now_s, cpu_s)),
            Some((then_s, used_s)) if now_s - then_s >= LOOK_S => {
                let cores = self.workers.cores.max(1);
                let busy = (cpu_s - used_s) / ((now_s - then_s) * cores as f64);
                if busy < ROOM {
                    self.allowed = (self.allowed + cores).min(self.workers.all());
                }
                self.seen = Some((now_s, cpu_s));
            }
            Some(_) => {}
        }
    }

    /// The next part, where so many run.
    pub fn next(&self, running: usize) -> Next {
        Next {
            processes: self.allowed,
            frames: if running < self.workers.busy() {
                1
            } else {
                FRAMES
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORKERS: Workers = Workers {
        stated: None,
        most: 16,
        cores: 2,
    };

    /// How many processes there are after a second in which the cores are so busy.
    fn after_a_second(busy: f64, workers: Workers) -> usize {
        let mut ramp = Ramp::new(workers);
        for look in 0..50 {
            let now_s = 0.02 * f64::from(look);
            ramp.look(now_s, busy * 2.0 * now_s);
        }
        ramp.next(2).processes
    }

    #[test]
    fn idle_cores_get_more_processes_and_busy_ones_do_not() {
        assert_eq!(after_a_second(0.9, WORKERS), 2);
        assert!((8..=16).contains(&after_a_second(0.1, WORKERS)));
    }

    #[test]
    fn what_is_stated_goes_first() {
        let stated = |n| Workers {
            stated: Some(n),
            ..WORKERS
        };
        assert_eq!(after_a_second(0.0, stated(1)), 1);
        assert_eq!(after_a_second(0.9, stated(7)), 7);
        assert_eq!(
            Ramp::new(Workers { most: 1, ..WORKERS }).next(0).processes,
            1
        );
    }

    #[test]
    fn the_first_frames_stand_alone_and_sleep_is_no_room() {
        let mut ramp = Ramp::new(WORKERS);
        ramp.look(0.1, 0.0);
        ramp.look(0.24, 0.0);
        let frames = [0, 1, 2].map(|running| ramp.next(running).frames);
        assert_eq!(frames, [1, 1, 2]);
        // Heavy frames that have just begun.
        ramp.look(0.26, 0.05);
        ramp.look(0.42, 0.30);
        assert_eq!(ramp.next(2).processes, 2);
        ramp.look(0.58, 0.35);
        assert_eq!(ramp.next(2).processes, 4);
    }
}

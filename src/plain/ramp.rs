//! Before any frame is done nobody knows what one costs. The cores get a single frame
//! each; and where they turn out to be idle, because POV-Ray sleeps, more parts begin
//! before the first ones have ended. A heavy frame keeps its core busy by then, and a
//! machine that is busy with other things has no room.

use super::pace::Next;
use super::pool::Workers;

/// POV-Ray begins asleep: nothing is told before, in seconds.
const BEGINS_S: f64 = 0.25;

/// Between two looks. CPU time is told in pieces of 0.1 s.
const LOOK_S: f64 = 0.15;

/// There is room for more where renderers use less than this share of the cores' time …
const ROOM: f64 = 0.5;

/// … and the machine has more than this share of its own to give.
const IDLE: f64 = 0.25;

/// Frames that keep no core busy are not heavy: two in a call cost little more than
/// one.
const FRAMES: usize = 2;

/// The time of all the machine's cores so far, in any unit.
#[derive(Clone, Copy, Debug)]
pub struct Ticks {
    idle: u64,
    all: u64,
}

impl Ticks {
    /// Now; none where the system does not tell.
    pub fn now() -> Option<Self> {
        Self::of(&std::fs::read_to_string("/proc/stat").ok()?)
    }

    /// Of `/proc/stat`: user, nice, system, idle, waiting for a disk, two kinds of
    /// interrupts, given to other machines.
    fn of(text: &str) -> Option<Self> {
        let mut words = text.lines().next()?.split_ascii_whitespace();
        let numbers = (words.next()? == "cpu").then(|| words.take(8).map(str::parse));
        let ticks: Vec<u64> = numbers?.collect::<Result<_, _>>().ok()?;
        Some(Self {
            idle: ticks.get(3)? + ticks.get(4)?,
            all: ticks.iter().sum(),
        })
    }

    /// The share of the time since then in which cores had nothing to do.
    fn idle_since(self, then: Self) -> f64 {
        let all = self.all.saturating_sub(then.all).max(1);
        self.idle.saturating_sub(then.idle) as f64 / all as f64
    }
}

/// What was seen: when, since the beginning, and what CPU was used by then, in seconds.
#[derive(Clone, Copy, Debug)]
struct Seen {
    at_s: f64,
    cpu_s: f64,
    machine: Option<Ticks>,
}

/// How a pool begins.
#[derive(Clone, Copy, Debug)]
pub struct Ramp {
    workers: Workers,
    allowed: usize,
    seen: Option<Seen>,
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
    pub fn look(&mut self, at_s: f64, cpu_s: f64, machine: impl FnOnce() -> Option<Ticks>) {
        let due_s = self.seen.map_or(BEGINS_S, |seen| seen.at_s + LOOK_S);
        if at_s < due_s {
            return;
        }
        let machine = machine();
        let now = Seen {
            at_s,
            cpu_s,
            machine,
        };
        if let Some(then) = self.seen.replace(now) {
            let cores = self.workers.cores.max(1);
            let used = (cpu_s - then.cpu_s) / ((at_s - then.at_s) * cores as f64);
            let idle = machine
                .zip(then.machine)
                .map(|(now, then)| now.idle_since(then));
            if used < ROOM && idle.is_some_and(|idle| idle > IDLE) {
                self.allowed = (self.allowed + cores).min(self.workers.all());
            }
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

    /// How many processes there are after a second in which renderers use such a share
    /// of the cores, and others such a share.
    fn after_a_second(used: f64, by_others: f64, workers: Workers) -> usize {
        let mut ramp = Ramp::new(workers);
        for look in 0..50_u32 {
            let now_s = 0.02 * f64::from(look);
            let all = u64::from(look) * 1000;
            let idle = (all as f64 * (1.0 - used - by_others)) as u64;
            ramp.look(now_s, used * 2.0 * now_s, || Some(Ticks { idle, all }));
        }
        ramp.next(2).processes
    }

    #[test]
    fn idle_cores_get_more_processes_and_busy_ones_do_not() {
        assert_eq!(after_a_second(0.9, 0.0, WORKERS), 2);
        assert!((8..=16).contains(&after_a_second(0.1, 0.0, WORKERS)));
        assert!(after_a_second(0.1, 0.5, WORKERS) > 2);
        assert_eq!(after_a_second(0.1, 0.85, WORKERS), 2, "others need them");
    }

    #[test]
    fn nothing_known_of_the_machine_is_no_room() {
        let mut ramp = Ramp::new(WORKERS);
        for look in 0..50 {
            ramp.look(0.02 * f64::from(look), 0.0, || None);
        }
        assert_eq!(ramp.next(2).processes, 2);
    }

    #[test]
    fn what_is_stated_goes_first() {
        let stated = |n| Workers {
            stated: Some(n),
            ..WORKERS
        };
        assert_eq!(after_a_second(0.0, 0.0, stated(1)), 1);
        assert_eq!(after_a_second(0.9, 0.0, stated(7)), 7);
        let one = Workers { most: 1, ..WORKERS };
        assert_eq!(Ramp::new(one).next(0).processes, 1);
    }

    #[test]
    fn the_first_frames_stand_alone_and_sleep_is_no_room() {
        let mut ramp = Ramp::new(WORKERS);
        let mut look = |at_s, cpu_s| {
            let all = (at_s * 1000.0) as u64;
            let idle = all - (cpu_s * 500.0) as u64;
            ramp.look(at_s, cpu_s, || Some(Ticks { idle, all }));
            ramp.next(2).processes
        };
        assert_eq!((look(0.1, 0.0), look(0.24, 0.0)), (2, 2));
        // Heavy frames that have just begun, and light ones that are over.
        assert_eq!((look(0.26, 0.05), look(0.42, 0.30)), (2, 2));
        assert_eq!(look(0.58, 0.35), 4);
        let frames = [0, 1, 2].map(|running| ramp.next(running).frames);
        assert_eq!(frames, [1, 1, 2]);
    }

    #[test]
    fn what_the_system_tells() {
        let first = Ticks::of("cpu  10 0 5 80 5 0 0 0 7 0\ncpu0 1 2 3\n").unwrap();
        let later = Ticks::of("cpu  40 0 25 120 15 0 0 0 7 0\n").unwrap();
        assert!((later.idle_since(first) - 0.5).abs() < 1e-9);
        assert!(first.idle_since(first) < 1e-9);
        assert!(Ticks::of("").is_none() && Ticks::of("cpu 1 2 x 4 5").is_none());
        assert!(Ticks::of("intr 1 2 3 4 5 6").is_none());
    }
}

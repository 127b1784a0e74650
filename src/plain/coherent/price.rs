//! What frames cost, whole and by coherence, and which is less.

use super::super::pace::{CALL_CPU_S, SLEEP_S};
use super::super::pool::Workers;

/// A tiny frame in a long call, in seconds of CPU: measured with 3.7.0.10.
const TINY_FRAME_S: f64 = 0.016;

/// A call of one frame of which nearly nothing is traced, in seconds of CPU.
pub const SHORT_CALL_S: f64 = 0.045;

/// A sounding traces one of seven blocks twice, some of them dear ones.
const SOUNDED: f64 = 0.3;

/// A sounding may cost this share of the film.
pub const RISK: f64 = 0.02;

/// Wall time of a call before its first frame, nearly all of it sleep.
const CALL_S: f64 = 0.5;

/// Calls that wait for each other: where everything is, proxies for all frames and
/// for parts of them, frames that trace for others. Each sleeps before it works.
const PHASES: Price = Price {
    wall_s: 3.0,
    cpu_s: 0.0,
};

/// No film is expected to have fewer dirty blocks.
const BEST_SHARE: f64 = 0.1;

/// Coherence is only used where it takes less than this share of the time:
/// forecasts are not exact. In a trial with four of five blocks dirty, a gain of
/// some percent was foreseen, and it took 15 % longer.
const WORTH: f64 = 0.75;

/// What a frame takes, in seconds of CPU, as the first ones took it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Costs {
    /// To read the scene.
    pub parse_s: f64,
    /// To trace all blocks.
    pub trace_s: f64,
    /// All else: to write the picture, to begin and to end.
    pub other_s: f64,
}

impl Costs {
    /// From POV-Ray's own times of so many frames in so many calls, and the CPU
    /// of its processes.
    pub fn of(parse_s: f64, trace_s: f64, cpu_s: f64, frames: usize, calls: usize) -> Self {
        let each = |seconds: f64| seconds.max(0.0) / frames.max(1) as f64;
        Self {
            parse_s: each(parse_s),
            trace_s: each(trace_s),
            other_s: each(cpu_s - parse_s - trace_s - CALL_CPU_S * calls as f64),
        }
    }

    /// A whole frame.
    pub fn whole_s(&self) -> f64 {
        self.partial_s(1.0)
    }

    /// A frame of which this share is traced.
    pub fn partial_s(&self, share: f64) -> f64 {
        self.parse_s + self.other_s + self.trace_s * share
    }

    /// A sounding: four calls, and twice some blocks.
    pub fn sounding_s(&self) -> f64 {
        4.0 * (self.parse_s + SHORT_CALL_S) + SOUNDED * self.trace_s
    }

    /// To ask where everything is, in a frame.
    pub fn asked_s(&self) -> f64 {
        self.parse_s + TINY_FRAME_S
    }
}

/// Seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Price {
    /// On the clock.
    pub wall_s: f64,
    /// Of all cores.
    pub cpu_s: f64,
}

impl Price {
    /// Of `frames` frames that take so much CPU each.
    pub fn of(frames: usize, each_s: f64, workers: &Workers) -> Self {
        if frames == 0 {
            return Self::default();
        }
        let frames = frames as f64;
        let busy_s = frames * each_s / workers.busy().min(workers.cores) as f64;
        let slept_s = CALL_S + frames * (SLEEP_S + each_s) / workers.all() as f64;
        Self {
            wall_s: busy_s.max(slept_s),
            cpu_s: frames * each_s,
        }
    }

    /// One after the other.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            wall_s: self.wall_s + other.wall_s,
            cpu_s: self.cpu_s + other.cpu_s,
        }
    }

    /// Is it worth while, instead of the other? Neither in time nor in CPU may it
    /// be dearer.
    pub fn beats(&self, other: &Self) -> bool {
        self.wall_s < WORTH * other.wall_s && self.cpu_s < WORTH * other.cpu_s
    }
}

/// Does coherence pay that takes so much after its first calls?
pub fn pays(coherent: Price, whole: &Price) -> bool {
    coherent.and(PHASES).beats(whole)
}

/// May coherence pay for `frames` more frames, at its very best, and does it cost
/// little to know better?
pub fn may_pay(costs: &Costs, frames: usize, workers: &Workers) -> bool {
    if costs.sounding_s() > RISK * frames as f64 * costs.whole_s() {
        return false;
    }
    let asked = Price::of(frames, costs.asked_s(), workers);
    let best = Price::of(frames, costs.partial_s(BEST_SHARE), workers);
    let whole = Price::of(frames, costs.whole_s(), workers);
    pays(best.and(asked), &whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WORKERS: Workers = Workers {
        stated: None,
        most: 16,
        cores: 2,
    };

    fn costs(parse_s: f64, trace_s: f64) -> Costs {
        Costs {
            parse_s,
            trace_s,
            other_s: 0.02,
        }
    }

    #[test]
    fn heavy_frames_pay_and_light_ones_do_not() {
        assert!(may_pay(&costs(0.1, 10.0), 38, &WORKERS));
        assert!(may_pay(&costs(0.01, 1.0), 38, &WORKERS));
        assert!(!may_pay(&costs(0.01, 0.05), 38, &WORKERS));
        // A film of eight seconds is over before all is known.
        assert!(!may_pay(&costs(0.01, 0.4), 38, &WORKERS));
        // Scenes that take long to read, and little to trace.
        assert!(!may_pay(&costs(5.0, 3.0), 38, &WORKERS));
        assert!(!may_pay(&costs(0.1, 10.0), 0, &WORKERS));
        // A sounding would cost as much as a third of a frame: too much of twelve.
        assert!(may_pay(&costs(0.02, 3.0), 24, &WORKERS));
        assert!(!may_pay(&costs(0.02, 3.0), 12, &WORKERS));
    }

    #[test]
    fn costs_of_the_first_frames() {
        let costs = Costs::of(0.4, 2.0, 2.6 + 2.0 * CALL_CPU_S, 2, 2);
        assert!((costs.parse_s - 0.2).abs() < 1e-9 && (costs.trace_s - 1.0).abs() < 1e-9);
        assert!((costs.other_s - 0.1).abs() < 1e-9, "{costs:?}");
        assert!((costs.whole_s() - 1.3).abs() < 1e-9);
        assert!((costs.partial_s(0.5) - 0.8).abs() < 1e-9);
    }

    #[test]
    fn short_frames_are_slept_through() {
        let short = Price::of(32, 0.01, &WORKERS);
        assert!((short.wall_s - (0.5 + 32.0 * 0.26 / 16.0)).abs() < 1e-9);
        let long = Price::of(32, 2.0, &WORKERS);
        assert!((long.wall_s - 32.0).abs() < 1e-9 && (long.cpu_s - 64.0).abs() < 1e-9);
    }
}

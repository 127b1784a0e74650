//! Which frames a process takes next.
//!
//! A call costs half a second before its first frame, most of it asleep, and
//! some CPU: parts should be long. But nobody should wait for the last one:
//! parts should be short at the end. So the first parts are single frames, which
//! tell what a frame costs, and the others a share of what is left.

use std::collections::{BTreeSet, VecDeque};

use super::pace::Pace;

/// No part has more frames: an interrupted run loses no more than that.
const LONGEST: usize = 64;

/// No part takes much more CPU, in seconds.
const LONGEST_S: f64 = 30.0;

/// Frames that are still to be rendered.
#[derive(Debug)]
pub struct Queue {
    /// Frames that follow each other.
    runs: VecDeque<VecDeque<u32>>,
    left: usize,
    longest: usize,
}

impl Queue {
    /// These frames, from one to the next `step`; those in `before` come first, one
    /// by one.
    pub fn new(wanted: &BTreeSet<u32>, before: &[u32], step: u32) -> Self {
        let mut runs: VecDeque<VecDeque<u32>> = VecDeque::new();
        for &frame in wanted.iter().filter(|frame| !before.contains(frame)) {
            match runs.back_mut() {
                Some(run) if run.back().is_some_and(|last| frame - last == step) => {
                    run.push_back(frame);
                }
                _ => runs.push_back(VecDeque::from([frame])),
            }
        }
        for &frame in before.iter().rev().filter(|frame| wanted.contains(frame)) {
            runs.push_front(VecDeque::from([frame]));
        }
        Self {
            runs,
            left: wanted.len(),
            longest: LONGEST,
        }
    }

    /// The same, in parts of so many frames at most.
    #[must_use]
    pub fn in_parts_of(mut self, frames: usize) -> Self {
        self.longest = frames.clamp(1, LONGEST);
        self
    }

    /// Is nothing left?
    pub fn is_empty(&self) -> bool {
        self.left == 0
    }

    /// So many are left.
    pub fn left(&self) -> usize {
        self.left
    }

    /// The first and the last frame of the next part, which has `most` at most.
    pub fn take(&mut self, pace: &Pace, most: usize) -> Option<(u32, u32)> {
        let count = match pace.frame_cpu_s {
            None => 1,
            Some(cpu_s) => {
                // Two thirds of a share: about half of all in the first round.
                let share = (self.left * 2).div_ceil(pace.processes * 3);
                let by_time = LONGEST_S / cpu_s.max(1e-3);
                share
                    .max(pace.shortest())
                    .min(self.longest)
                    .min(most)
                    .min(by_time as usize)
            }
        };
        let run = self.runs.front_mut()?;
        let part: Vec<u32> = run.drain(..count.clamp(1, run.len())).collect();
        self.left -= part.len();
        if run.is_empty() {
            self.runs.pop_front();
        }
        Some((*part.first()?, *part.last()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all_parts(wanted: &BTreeSet<u32>, step: u32, pace: &Pace) -> Vec<(u32, u32)> {
        let mut queue = Queue::new(wanted, &[], step);
        let parts = std::iter::from_fn(|| queue.take(pace, usize::MAX)).collect();
        assert!(queue.is_empty());
        parts
    }

    fn pace(processes: usize, frame_cpu_s: Option<f64>) -> Pace {
        Pace {
            processes,
            frame_cpu_s,
        }
    }

    #[test]
    fn parts_shrink_towards_the_end() {
        let parts = all_parts(&(1..=400).collect(), 1, &pace(8, Some(1.0)));
        let lengths: Vec<u32> = parts.iter().map(|(a, b)| b - a + 1).collect();
        assert!(lengths[0] >= 30, "{lengths:?}");
        assert_eq!(lengths.last(), Some(&1));
        assert!(
            lengths.windows(2).all(|pair| pair[0] >= pair[1]),
            "{lengths:?}"
        );
        assert!(lengths.len() < 60, "{lengths:?}");
    }

    #[test]
    fn slow_frames_make_short_parts_and_unknown_ones_single_frames() {
        let length = |cpu_s| {
            let parts = all_parts(&(1..=400).collect(), 1, &pace(2, cpu_s));
            parts[0].1 - parts[0].0 + 1
        };
        assert_eq!(length(Some(15.0)), 2);
        assert_eq!(length(Some(100.0)), 1);
        assert_eq!(length(None), 1);
    }

    #[test]
    fn some_come_first() {
        let mut queue = Queue::new(&(1..=6).collect(), &[1, 4, 9], 1);
        let pace = pace(1, Some(0.01));
        let parts: Vec<_> = std::iter::from_fn(|| queue.take(&pace, 2)).collect();
        assert_eq!(parts, [(1, 1), (4, 4), (2, 3), (5, 6)]);
    }

    proptest! {
        #[test]
        fn every_frame_is_in_one_part(
            numbers in prop::collection::btree_set(0_u32..300, 0..200),
            step in 1_u32..4,
            processes in 1_usize..20,
            cpu_s in prop::option::of(0.0_f64..20.0),
        ) {
            let wanted: BTreeSet<u32> = numbers.into_iter().map(|n| n * step).collect();
            let mut seen = Vec::new();
            for (first, last) in all_parts(&wanted, step, &pace(processes, cpu_s)) {
                seen.extend((first..=last).step_by(step as usize));
            }
            prop_assert_eq!(seen, wanted.into_iter().collect::<Vec<_>>());
        }
    }
}

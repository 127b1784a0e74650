//! Which frames a process takes next.
//!
//! A call costs about half a second before its first frame, most of it asleep,
//! and some CPU: parts should be long. But nobody should wait for the last one:
//! parts should be short at the end. So a process takes a share of what is left,
//! less and less.

use std::collections::{BTreeSet, VecDeque};

/// No part has more frames: an interrupted run loses no more than that.
const LONGEST: usize = 64;

/// No part takes much longer, in milliseconds.
const LONGEST_MS: u64 = 60_000;

/// Frames that are still to be rendered.
#[derive(Debug)]
pub struct Queue {
    /// Frames that follow each other.
    runs: VecDeque<VecDeque<u32>>,
    left: usize,
    jobs: usize,
    /// Parts that were taken.
    taken: usize,
}

impl Queue {
    /// These frames, from one to the next `step`, for so many processes.
    pub fn new(wanted: &BTreeSet<u32>, step: u32, jobs: usize) -> Self {
        let mut runs: VecDeque<VecDeque<u32>> = VecDeque::new();
        for &frame in wanted {
            match runs.back_mut() {
                Some(run) if run.back().is_some_and(|last| frame - last == step) => {
                    run.push_back(frame);
                }
                _ => runs.push_back(VecDeque::from([frame])),
            }
        }
        Self {
            runs,
            left: wanted.len(),
            jobs: jobs.max(1),
            taken: 0,
        }
    }

    /// The first and the last frame of the next part; `frame_ms` is what a frame
    /// took lately, 0 where that is not known.
    pub fn take(&mut self, frame_ms: u64) -> Option<(u32, u32)> {
        // The first round takes two thirds of all; then half a share each time.
        let share = if self.taken < self.jobs {
            let all = self.left_before_round();
            (all * 2).div_ceil(self.jobs * 3)
        } else {
            self.left.div_ceil(self.jobs * 2)
        };
        let by_time = LONGEST_MS
            .checked_div(frame_ms)
            .map_or(LONGEST, |n| n as usize);
        let count = share.min(LONGEST).min(by_time).max(1);
        let run = self.runs.front_mut()?;
        let first = run.pop_front()?;
        let mut last = first;
        for _ in 1..count {
            match run.pop_front() {
                Some(frame) => last = frame,
                None => break,
            }
            self.left -= 1;
        }
        self.left -= 1;
        self.taken += 1;
        if run.is_empty() {
            self.runs.pop_front();
        }
        Some((first, last))
    }

    /// All frames, as far as the first round is concerned.
    fn left_before_round(&self) -> usize {
        // Each part of the round has taken two thirds of a share.
        let rest = 3 * self.jobs - 2 * self.taken;
        self.left * 3 * self.jobs / rest.max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn all_parts(wanted: &BTreeSet<u32>, step: u32, jobs: usize) -> Vec<(u32, u32)> {
        let mut queue = Queue::new(wanted, step, jobs);
        std::iter::from_fn(|| queue.take(0)).collect()
    }

    #[test]
    fn parts_shrink_towards_the_end() {
        let parts = all_parts(&(1..=400).collect(), 1, 8);
        let lengths: Vec<u32> = parts.iter().map(|(a, b)| b - a + 1).collect();
        assert!(lengths[0] >= 30, "{lengths:?}");
        assert_eq!(lengths.last(), Some(&1));
        assert!(
            lengths.windows(2).skip(8).all(|pair| pair[0] >= pair[1]),
            "{lengths:?}"
        );
        assert!(lengths.len() < 60, "{lengths:?}");
    }

    #[test]
    fn slow_frames_make_short_parts() {
        let mut queue = Queue::new(&(1..=400).collect(), 1, 2);
        let (first, last) = queue.take(30_000).unwrap();
        assert_eq!(last - first + 1, 2);
    }

    proptest! {
        #[test]
        fn every_frame_is_in_one_part(
            numbers in prop::collection::btree_set(0_u32..300, 0..200),
            step in 1_u32..4,
            jobs in 1_usize..20,
        ) {
            let wanted: BTreeSet<u32> = numbers.into_iter().map(|n| n * step).collect();
            let mut seen = Vec::new();
            for (first, last) in all_parts(&wanted, step, jobs) {
                seen.extend((first..=last).step_by(step as usize));
            }
            prop_assert_eq!(seen, wanted.into_iter().collect::<Vec<_>>());
        }
    }
}

//! Which frames a process takes next: runs of frames that follow each other.

use std::collections::{BTreeSet, VecDeque};

/// No part has more frames: an interrupted run loses no more than that.
const LONGEST: usize = 64;

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

    /// The first and the last frame of the next part, which has so many at most.
    pub fn take(&mut self, frames: usize) -> Option<(u32, u32)> {
        let run = self.runs.front_mut()?;
        let count = frames.min(self.longest).clamp(1, run.len());
        let part: Vec<u32> = run.drain(..count).collect();
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

    #[test]
    fn some_come_first() {
        let mut queue = Queue::new(&(1..=6).collect(), &[1, 4, 9], 1);
        let parts: Vec<_> = std::iter::from_fn(|| queue.take(2)).collect();
        assert_eq!(parts, [(1, 1), (4, 4), (2, 3), (5, 6)]);
    }

    #[test]
    fn no_part_is_longer_than_the_longest() {
        let mut queue = Queue::new(&(1..=200).collect(), &[], 1).in_parts_of(3);
        assert_eq!((queue.take(9), queue.take(2)), (Some((1, 3)), Some((4, 5))));
        let mut queue = Queue::new(&(1..=200).collect(), &[], 1).in_parts_of(999);
        assert_eq!(queue.take(999), Some((1, LONGEST as u32)));
    }

    proptest! {
        #[test]
        fn every_frame_is_in_one_part(
            numbers in prop::collection::btree_set(0_u32..300, 0..200),
            step in 1_u32..4,
            lengths in prop::collection::vec(0_usize..20, 1..9),
        ) {
            let wanted: BTreeSet<u32> = numbers.into_iter().map(|n| n * step).collect();
            let mut queue = Queue::new(&wanted, &[], step);
            let mut seen = Vec::new();
            for length in lengths.into_iter().cycle() {
                let Some((first, last)) = queue.take(length) else { break };
                seen.extend((first..=last).step_by(step as usize));
                prop_assert_eq!(queue.left(), wanted.len() - seen.len());
            }
            prop_assert!(queue.is_empty());
            prop_assert_eq!(seen, wanted.into_iter().collect::<Vec<_>>());
        }
    }
}

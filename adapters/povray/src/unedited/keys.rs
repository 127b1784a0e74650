//! Which frames trace blocks for others.
//!
//! A block that is clean in a frame shows the same in every frame in which it is
//! clean: one of them traces it, the others take it over. Frames that were
//! rendered whole already give what they have; for what is left, the frame that
//! gives most is taken, and again, until every block that is clean in some frame
//! has its source. Usually these are one to three frames.

use super::blocks::{Blocks, Grid};

/// Who traces what.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Schedule {
    /// Frames that trace for others, and what: all but what those that were
    /// whole already give. They do not need each other.
    pub sources: Vec<(usize, Blocks)>,
    /// The other frames, and what they trace: what nobody gives them.
    pub rest: Vec<(usize, Blocks)>,
}

impl Schedule {
    /// How many frames are rendered.
    pub fn frames(&self) -> usize {
        self.sources.len() + self.rest.len()
    }

    /// The blocks that are traced in all.
    pub fn traced(&self) -> usize {
        let all = self.sources.iter().chain(&self.rest);
        all.map(|(_, traced)| traced.len()).sum()
    }
}

/// Plans frames `0..dirty.len()`, given the dirty blocks of each; those in
/// `whole` are done; so are those for which `is_done` holds, but they give nothing.
pub fn schedule(
    grid: Grid,
    dirty: &[Blocks],
    whole: &[usize],
    is_done: impl Fn(usize) -> bool,
) -> Schedule {
    let all = Blocks::all(grid);
    let clean: Vec<Blocks> = dirty.iter().map(|dirty| all.without(dirty)).collect();
    let mut rest: Vec<usize> = (0..dirty.len())
        .filter(|frame| !whole.contains(frame) && !is_done(*frame))
        .collect();
    let given = whole
        .iter()
        .fold(Blocks::none(grid), |sum, frame| sum.or(&clean[*frame]));
    let mut covered = given.clone();
    let mut sources = Vec::new();
    loop {
        // What only one frame could use, it traces itself.
        let useful = Blocks::of(grid, |block| {
            !covered.has(block) && rest.iter().filter(|f| clean[**f].has(block)).count() > 1
        });
        let gain = |frame: usize| clean[frame].and(&useful).len();
        let best = (0..rest.len()).max_by_key(|at| (gain(rest[*at]), usize::MAX - at));
        let Some(at) = best.filter(|at| gain(rest[*at]) > 0) else {
            break;
        };
        let frame = rest.remove(at);
        covered = covered.or(&clean[frame]);
        sources.push((frame, all.without(&clean[frame].and(&given))));
    }
    let rest = rest
        .into_iter()
        .map(|frame| (frame, all.without(&clean[frame].and(&covered))))
        .collect();
    Schedule { sources, rest }
}

#[cfg(test)]
mod tests {
    use decor_api::Size;
    use proptest::prelude::*;

    use super::*;

    const GRID: Grid = Grid {
        size: Size {
            width: 128,
            height: 64,
        },
    };

    fn set(blocks: &[usize]) -> Blocks {
        Blocks::of(GRID, |block| blocks.contains(&block))
    }

    fn none(_: usize) -> bool {
        false
    }

    #[test]
    fn something_that_wanders_needs_two_whole_frames() {
        let dirty: Vec<Blocks> = (0..8).map(|block| set(&[block])).collect();
        let plan = schedule(GRID, &dirty, &[0, 4], none);
        assert_eq!(plan.sources, []);
        let rest = [1, 2, 3, 5, 6, 7].map(|frame| (frame, set(&[frame])));
        assert_eq!(plan.rest, rest);
        // From one, its own dirty block is missing.
        let plan = schedule(GRID, &dirty, &[0], none);
        assert_eq!(plan.sources, [(1, set(&[0, 1]))]);
        assert_eq!(plan.traced(), 2 + 6);
    }

    #[test]
    fn what_is_dirty_everywhere_needs_no_source() {
        let dirty = vec![set(&[2, 3]); 5];
        assert_eq!(schedule(GRID, &dirty, &[2], none).sources, []);
        let plan = schedule(GRID, &dirty, &[2], |frame| frame == 3);
        assert_eq!(plan.rest.iter().map(|r| r.0).collect::<Vec<_>>(), [0, 1, 4]);
        let nothing = schedule(GRID, &vec![Blocks::all(GRID); 3], &[], none);
        assert_eq!((nothing.sources.len(), nothing.rest.len()), (0, 3));
    }

    #[test]
    fn what_one_frame_alone_can_use_it_traces_itself() {
        let dirty = [set(&[0, 1]), set(&[0]), set(&[0, 1])];
        let plan = schedule(GRID, &dirty, &[0], none);
        assert_eq!(plan.sources, []);
        assert_eq!(plan.rest, [(1, set(&[0, 1])), (2, set(&[0, 1]))]);
    }

    proptest! {
        #[test]
        fn what_is_taken_over_was_traced_where_it_is_clean(
            marks in prop::collection::vec(prop::collection::vec(any::<bool>(), 8), 1..12),
            whole in prop::collection::vec(any::<bool>(), 12),
            done in prop::collection::vec(any::<bool>(), 12),
        ) {
            let dirty: Vec<Blocks> = marks.iter().map(|m| Blocks::of(GRID, |b| m[b])).collect();
            let whole: Vec<usize> = (0..dirty.len()).filter(|k| whole[*k]).collect();
            let plan = schedule(GRID, &dirty, &whole, |k| done[k]);
            let planned = plan.sources.iter().chain(&plan.rest);
            let mut seen: Vec<usize> = planned.map(|(frame, _)| *frame).collect();
            seen.extend(&whole);
            seen.extend((0..dirty.len()).filter(|k| done[*k] && !whole.contains(k)));
            seen.sort_unstable();
            prop_assert_eq!(seen, (0..dirty.len()).collect::<Vec<_>>());
            let from_whole = |block: usize| whole.iter().any(|k| !dirty[*k].has(block));
            let from_source = |block: usize| {
                plan.sources.iter().any(|(k, traced)| !dirty[*k].has(block) && traced.has(block))
            };
            for (frame, traced) in &plan.sources {
                for block in (0..GRID.count()).filter(|b| !traced.has(*b)) {
                    prop_assert!(!dirty[*frame].has(block) && from_whole(block));
                }
            }
            for (frame, traced) in &plan.rest {
                for block in (0..GRID.count()).filter(|b| !traced.has(*b)) {
                    prop_assert!(!dirty[*frame].has(block));
                    prop_assert!(from_whole(block) || from_source(block));
                }
            }
        }
    }
}

//! The boxes and balls that stand for what moves in a group of frames.
//!
//! What hardly moves gets one box for several frames, what moves fast one for each.
//! A group's boxes are made of those of its halves, and so on: they hold those of
//! every part of it. So what none of a group's boxes touches, none of a half's does.
//!
//! They are larger than what they stand for by more than POV-Ray's tolerance: a
//! shadow ray that begins inside one leaves it through a face that counts.

use std::collections::BTreeMap;

use super::analysis::Analysis;
use super::boxes::FrameBoxes;
use super::solid::Solid;

/// The solids of a group of frames, one after the other in time, by statement and
/// by which of its objects.
type Merged = BTreeMap<(usize, usize), Vec<Solid>>;

/// What stands for what moves in a group of frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Hulls {
    /// The first and the last of the frames.
    pub frames: (u32, u32),
    /// Boxes and balls.
    pub(super) solids: Vec<Solid>,
}

impl Hulls {
    /// Of frames that follow each other; `None` where there are none, or where
    /// something moves that has no end.
    pub fn of(analysis: &Analysis, group: &[FrameBoxes]) -> Option<Self> {
        let frames = (group.first()?.frame, group.last()?.frame);
        let solids = merged(analysis, group)?.into_values().flatten();
        Some(Self {
            frames,
            solids: solids.map(Solid::grown).collect(),
        })
    }

    /// The two parts of a group of which its solids are made.
    fn halves(group: &[FrameBoxes]) -> (&[FrameBoxes], &[FrameBoxes]) {
        group.split_at(group.len() / 2)
    }
}

fn merged(analysis: &Analysis, group: &[FrameBoxes]) -> Option<Merged> {
    let one = match group {
        [] => return Some(Merged::new()),
        [one] => one,
        _ => {
            let (first, second) = Hulls::halves(group);
            return Some(joined(merged(analysis, first)?, merged(analysis, second)?));
        }
    };
    let mut count: BTreeMap<usize, usize> = BTreeMap::new();
    let mut boxes = Merged::new();
    for object in &one.objects {
        let moves = analysis.statements.get(object.statement);
        if !moves.is_none_or(|statement| statement.moves) {
            continue;
        }
        let solid = Solid::of(object)?;
        let which = count.entry(object.statement).or_default();
        boxes.insert((object.statement, *which), vec![solid]);
        *which += 1;
    }
    Some(boxes)
}

/// Where the one list ends and the other begins, two solids become one if it is no
/// larger than both.
fn joined(mut all: Merged, later: Merged) -> Merged {
    for (key, mut solids) in later {
        let list = all.entry(key).or_default();
        if let (Some(old), Some(new)) = (list.last(), solids.first_mut())
            && let Some(both) = old.joined(new)
        {
            *new = both;
            list.pop();
        }
        list.extend(solids);
    }
    all
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::prelude::*;

    use super::*;
    use crate::unedited::boxes::{Extent, Placed};

    fn frame(frame: u32, boxes: &[(f64, f64)]) -> FrameBoxes {
        let placed = |(at, side): &(f64, f64)| Placed {
            statement: 0,
            extent: Extent::Box {
                min: DVec3::splat(*at),
                max: DVec3::splat(at + side),
            },
            round: false,
        };
        FrameBoxes {
            frame,
            objects: boxes.iter().map(placed).collect(),
            ..FrameBoxes::default()
        }
    }

    fn of(group: &[FrameBoxes]) -> Option<Vec<(DVec3, DVec3)>> {
        // A statement that is not known moves.
        let hulls = Hulls::of(&Analysis::default(), group)?;
        let boxes = hulls.solids.into_iter().map(|solid| match solid {
            Solid::Box { min, max } => (min, max),
            Solid::Ball { .. } => panic!("{solid:?}"),
        });
        Some(boxes.collect())
    }

    #[test]
    fn boxes_that_hardly_move_become_one() {
        let slow: Vec<FrameBoxes> = (0..9)
            .map(|k| frame(k, &[(0.01 * f64::from(k), 1.0)]))
            .collect();
        let one = of(&slow).unwrap();
        let (low, high) = (DVec3::ZERO, DVec3::splat(0.08 + 1.0));
        let [(min, max)] = one[..] else {
            panic!("{one:?}")
        };
        assert!((min - low).abs().max_element() < 2.1e-3 && min.max_element() < -1e-3);
        assert!((max - high).abs().max_element() < 2.1e-3 && max.min_element() > 1.081);
        let fast: Vec<FrameBoxes> = (0..9)
            .map(|k| frame(k, &[(5.0 * f64::from(k), 1.0)]))
            .collect();
        assert_eq!(of(&fast).unwrap().len(), 9);
        let two = [frame(0, &[(0.0, 1.0), (9.0, 1.0)]), frame(1, &[(0.1, 1.0)])];
        assert_eq!(of(&two).unwrap().len(), 2);
        assert_eq!(of(&[]), None);
    }

    #[test]
    fn what_has_no_end_has_no_box() {
        let mut endless = frame(0, &[(0.0, 1.0)]);
        endless.objects[0].extent = Extent::Endless;
        assert_eq!(of(&[endless]), None);
        let lost = frame(0, &[(f64::NAN, 1.0)]);
        assert_eq!(of(&[lost]), None);
    }

    proptest! {
        #[test]
        fn a_groups_boxes_hold_those_of_its_halves(
            places in prop::collection::vec(
                prop::collection::vec((-9.0..9.0, 0.01..4.0), 0..3), 2..20
            ),
        ) {
            let group: Vec<FrameBoxes> =
                (0..).zip(&places).map(|(k, boxes)| frame(k, boxes)).collect();
            let all = of(&group).unwrap();
            let (first, second) = Hulls::halves(&group);
            for (min, max) in of(first).unwrap().into_iter().chain(of(second).unwrap()) {
                let held = all.iter().any(|(low, high)| {
                    low.cmple(min).all() && high.cmpge(max).all()
                });
                prop_assert!(held, "{:?} in {:?}", (min, max), all);
            }
        }
    }
}

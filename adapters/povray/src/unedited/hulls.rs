//! The boxes that stand for what moves in a group of frames.
//!
//! What hardly moves gets one box for several frames, what moves fast one for each.
//! A group's boxes are made of those of its halves, and so on: they hold those of
//! every part of it. So what none of a group's boxes touches, none of a half's does.
//!
//! Boxes are larger than what they stand for by more than POV-Ray's tolerance: a
//! shadow ray that begins inside one leaves it through a face that counts.

use std::collections::BTreeMap;

use glam::DVec3;

use super::analysis::Analysis;
use super::boxes::{Extent, FrameBoxes, Placed};

/// POV-Ray's own tolerance is half of it.
const AROUND: f64 = 2e-3;

/// The same for large coordinates: extents are of single precision.
const AROUND_SHARE: f64 = 1e-5;

/// A box: its least and its greatest corner.
pub(super) type Aabb = (DVec3, DVec3);

/// The boxes of a group of frames, one after the other in time, by statement and
/// by which of its objects.
type Merged = BTreeMap<(usize, usize), Vec<Aabb>>;

/// What stands for what moves in a group of frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Hulls {
    /// The first and the last of the frames.
    pub frames: (u32, u32),
    /// The boxes.
    pub(super) boxes: Vec<Aabb>,
}

impl Hulls {
    /// Of frames that follow each other; `None` where there are none, or where
    /// something moves that has no end.
    pub fn of(analysis: &Analysis, group: &[FrameBoxes]) -> Option<Self> {
        let frames = (group.first()?.frame, group.last()?.frame);
        let boxes = merged(analysis, group)?.into_values().flatten();
        let larger = |(min, max): Aabb| {
            let largest = min.abs().max(max.abs()).max_element();
            let around = DVec3::splat(AROUND + largest * AROUND_SHARE);
            (min - around, max + around)
        };
        Some(Self {
            frames,
            boxes: boxes.map(larger).collect(),
        })
    }

    /// The two parts of a group whose boxes are within the group's.
    pub fn halves(group: &[FrameBoxes]) -> (&[FrameBoxes], &[FrameBoxes]) {
        group.split_at(group.len() / 2)
    }

    /// A frame in which the boxes are what moves.
    pub fn as_frame(&self, analysis: &Analysis, one: &FrameBoxes) -> FrameBoxes {
        let moves = |statement: usize| analysis.statements.get(statement).is_none_or(|s| s.moves);
        let mut frame = one.clone();
        frame.objects.retain(|object| !moves(object.statement));
        let placed = self.boxes.iter().map(|(min, max)| Placed {
            // A statement that is not known moves.
            statement: usize::MAX,
            extent: Extent::Box {
                min: *min,
                max: *max,
            },
        });
        frame.objects.extend(placed);
        frame
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
        let Extent::Box { min, max } = object.extent else {
            return None;
        };
        if !(min.is_finite() && max.is_finite()) {
            return None;
        }
        let which = count.entry(object.statement).or_default();
        boxes.insert((object.statement, *which), vec![(min, max)]);
        *which += 1;
    }
    Some(boxes)
}

/// Where the one list ends and the other begins, two boxes become one if it is no
/// larger than both.
fn joined(mut all: Merged, later: Merged) -> Merged {
    let area = |(min, max): Aabb| {
        let side = max - min;
        side.x * side.y + side.y * side.z + side.z * side.x
    };
    for (key, mut boxes) in later {
        let list = all.entry(key).or_default();
        if let (Some(old), Some(new)) = (list.last().copied(), boxes.first_mut()) {
            let both = (old.0.min(new.0), old.1.max(new.1));
            if area(both) <= area(old) + area(*new) {
                *new = both;
                list.pop();
            }
        }
        list.extend(boxes);
    }
    all
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frame(frame: u32, boxes: &[(f64, f64)]) -> FrameBoxes {
        let placed = |(at, side): &(f64, f64)| Placed {
            statement: 0,
            extent: Extent::Box {
                min: DVec3::splat(*at),
                max: DVec3::splat(at + side),
            },
        };
        FrameBoxes {
            frame,
            objects: boxes.iter().map(placed).collect(),
            ..FrameBoxes::default()
        }
    }

    fn of(group: &[FrameBoxes]) -> Option<Vec<Aabb>> {
        // A statement that is not known moves.
        Hulls::of(&Analysis::default(), group).map(|hulls| hulls.boxes)
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

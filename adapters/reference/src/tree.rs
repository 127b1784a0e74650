//! A tree of boxes over anything: parry's, with a box test that rounds towards
//! finding too much.

use glam::DVec3;
use parry3d_f64::bounding_volume::Aabb;
use parry3d_f64::math::Vector;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode, TraversalAction};

use crate::extent::Extent;
use crate::ray::Ray;

/// Numbered leaves; what is empty is left out, what is unbounded is always
/// visited.
pub(crate) struct Tree {
    bvh: Bvh,
    /// Which leaf stands at each place of parry's tree, which has no gaps.
    bounded: Vec<u32>,
    unbounded: Vec<u32>,
}

impl Tree {
    /// Leaf `i` lies in the `i`-th box.
    pub fn new(boxes: impl IntoIterator<Item = Extent>) -> Self {
        let (mut bounded, mut unbounded) = (Vec::new(), Vec::new());
        let mut leaves = Vec::new();
        for (number, extent) in (0_u32..).zip(boxes) {
            let extent = extent.widened();
            if extent.is_empty() {
                continue;
            }
            if extent.is_bounded() {
                bounded.push(number);
                leaves.push(Aabb::new(to_parry(extent.min), to_parry(extent.max)));
            } else {
                unbounded.push(number);
            }
        }
        Self {
            bvh: Bvh::from_leaves(BvhBuildStrategy::Binned, &leaves),
            bounded,
            unbounded,
        }
    }

    /// Visits the leaves whose box the ray passes through between `after` and
    /// `before`, near ones first. `visit` is told how near the best is so far
    /// and gives what it found, if that is nearer. A leaf whose box begins just
    /// where the best is gets visited as well, so that `visit` can break ties.
    pub fn nearest(
        &self,
        ray: &Ray,
        after: f64,
        before: f64,
        mut visit: impl FnMut(u32, f64) -> Option<f64>,
    ) {
        let mut best = before;
        for &leaf in &self.unbounded {
            best = visit(leaf, best).unwrap_or(best);
        }
        let slabs = Slabs::new(ray);
        let visit = std::cell::RefCell::new(visit);
        // parry keeps the best itself; what it returns is known to `visit`.
        let _ = self.bvh.find_best(
            best,
            |node: &BvhNode, best| {
                let entry = slabs.entry(node, after, best);
                entry.unwrap_or(f64::MAX)
            },
            |place, best| (visit.borrow_mut())(self.bounded[place as usize], best),
        );
    }

    /// Visits the leaves whose box the whole line passes through, in no order.
    pub fn along_line(&self, ray: &Ray, mut visit: impl FnMut(u32)) {
        for &leaf in &self.unbounded {
            visit(leaf);
        }
        let slabs = Slabs::new(ray);
        self.bvh.traverse(|node| {
            let entry = slabs.entry(node, f64::NEG_INFINITY, f64::INFINITY);
            if entry.is_none() {
                return TraversalAction::Prune;
            }
            if let Some(place) = node.leaf_data() {
                visit(self.bounded[place as usize]);
            }
            TraversalAction::Continue
        });
    }
}

fn to_parry(v: DVec3) -> Vector {
    Vector::new(v.x, v.y, v.z)
}

/// A ray as the test of a box needs it.
struct Slabs {
    origin: DVec3,
    direction: DVec3,
    inverse: DVec3,
}

impl Slabs {
    fn new(ray: &Ray) -> Self {
        Self {
            origin: ray.origin,
            direction: ray.direction,
            inverse: ray.direction.recip(),
        }
    }

    /// Where the ray comes into the box, or a little before; `None` where it
    /// passes by.
    fn entry(&self, node: &BvhNode, after: f64, before: f64) -> Option<f64> {
        const ROUNDING: f64 = 8.0 * f64::EPSILON;
        let (min, max) = (node.mins(), node.maxs());
        let min = DVec3::new(min.x, min.y, min.z) - self.origin;
        let max = DVec3::new(max.x, max.y, max.z) - self.origin;
        let (mut entry, mut exit) = (after, before);
        for axis in 0..3 {
            if self.direction[axis] == 0.0 {
                if min[axis] > 0.0 || max[axis] < 0.0 {
                    return None;
                }
                continue;
            }
            let (a, b) = (
                min[axis] * self.inverse[axis],
                max[axis] * self.inverse[axis],
            );
            let (near, far) = if self.inverse[axis] > 0.0 {
                (a, b)
            } else {
                (b, a)
            };
            // 0 · ∞ is NaN, which `max` and `min` pass over: nothing is cut.
            entry = entry.max(near - near.abs() * ROUNDING);
            exit = exit.min(far + far.abs() * ROUNDING);
        }
        (entry <= exit).then_some(entry - entry.abs() * ROUNDING)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    fn cube(centre: DVec3) -> Extent {
        Extent {
            min: centre - 0.5,
            max: centre + 0.5,
        }
    }

    #[test]
    fn the_nearest_of_a_row_and_no_more_than_needed() {
        let boxes: Vec<Extent> = (0..1000)
            .map(|i| cube(DVec3::Z * f64::from(2 * i)))
            .collect();
        let tree = Tree::new(boxes);
        let ray = Ray {
            origin: DVec3::Z * 99.0,
            direction: DVec3::Z,
        };
        let (visits, found) = (Cell::new(0), Cell::new(None));
        tree.nearest(&ray, 0.0, f64::INFINITY, |leaf, best| {
            visits.set(visits.get() + 1);
            let t = f64::from(2 * leaf) - 0.5 - 99.0;
            (t > 0.0 && t < best).then(|| {
                found.set(Some(leaf));
                t
            })
        });
        assert_eq!(found.get(), Some(50));
        assert!(visits.get() < 20, "{}", visits.get());
    }

    #[test]
    fn identical_boxes_are_all_there() {
        for count in [0, 1, 2, 3, 10_000] {
            let tree = Tree::new((0..count).map(|_| cube(DVec3::ZERO)));
            let ray = Ray {
                origin: DVec3::new(0.1, 0.2, -5.0),
                direction: DVec3::Z,
            };
            let mut seen = 0;
            tree.along_line(&ray, |_| seen += 1);
            assert_eq!(seen, count);
        }
    }

    #[test]
    fn a_ray_in_the_plane_of_a_face_touches_the_box() {
        let tree = Tree::new([cube(DVec3::ZERO)]);
        for (origin, direction) in [
            (DVec3::new(0.5, 0.0, -5.0), DVec3::Z),
            (DVec3::new(0.5, -0.5, -5.0), DVec3::new(0.0, -0.0, 1.0)),
            (DVec3::new(0.5, 0.5, -5.0), DVec3::new(1e-320, 0.0, 1.0)),
        ] {
            let mut seen = 0;
            tree.along_line(&Ray { origin, direction }, |_| seen += 1);
            assert_eq!(seen, 1, "{origin} {direction}");
        }
    }
}

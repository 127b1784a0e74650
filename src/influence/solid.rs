//! A box that stands anywhere, and what passes through it.

use decor_api::{Extent, Pose, Sphere};
use glam::{DMat3, DVec3};

/// A box in the world, turned like its object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    centre: DVec3,
    /// From the world's directions to the box's own.
    turned: DMat3,
    /// Half of each side.
    half: DVec3,
}

impl Solid {
    /// A box of an object's own coordinates, where the object is.
    pub fn placed(extent: &Extent, pose: &Pose) -> Self {
        let half = (extent.max - extent.min) * 0.5;
        let middle = extent.min + half;
        let centre = pose.transform().transform_point3(middle);
        // What placing rounds away.
        let rounded = 1e-14 * (centre.abs() + middle.abs() + pose.position.abs()).max_element();
        Self {
            centre,
            turned: DMat3::from_quat(pose.rotation()).transpose(),
            half: half + rounded,
        }
    }

    /// The same, seen from `origin`.
    #[must_use]
    pub fn from(mut self, origin: DVec3) -> Self {
        self.centre -= origin;
        self.half += 1e-14 * (self.centre.abs().max_element() + origin.length());
        self
    }

    /// The ball around it.
    pub fn ball(&self) -> Sphere {
        Sphere {
            centre: self.centre,
            radius: self.half.length() * (1.0 + 1e-12),
        }
    }

    /// Does the segment from `a` to `b` come within `margin` of it? `false` is
    /// certain.
    pub fn meets_segment(&self, a: DVec3, b: DVec3, margin: f64) -> bool {
        // Beside one pair of sides: as a rule that is answer enough, without a division.
        let (from, to) = (
            self.turned * (a - self.centre),
            self.turned * (b - self.centre),
        );
        let half = self.half + margin;
        let above = from.cmpgt(half) & to.cmpgt(half);
        let below = from.cmplt(-half) & to.cmplt(-half);
        if (above | below).any() {
            return false;
        }
        self.meets(a, b - a, 1.0, margin)
    }

    /// Does what starts at `a` in a `direction`, and does not end?
    pub fn meets_ray(&self, a: DVec3, direction: DVec3, margin: f64) -> bool {
        self.meets(a, direction, f64::INFINITY, margin)
    }

    /// The ways through the three pairs of sides, cut with each other. All points
    /// within `margin` of the box lie in one that is so much larger. What is not a
    /// number cuts nothing off.
    fn meets(&self, a: DVec3, along: DVec3, end: f64, margin: f64) -> bool {
        let (enters, leaves) = self.way(a, along, end, margin);
        !(enters > leaves)
    }

    /// Where what starts at `a` in a `direction` of length 1 comes within `margin` of
    /// the box: from which distance to which. `None`: nowhere, for certain.
    pub fn along_ray(&self, a: DVec3, direction: DVec3, margin: f64) -> Option<(f64, f64)> {
        let (enters, leaves) = self.way(a, direction, f64::INFINITY, margin);
        (!(enters > leaves)).then_some((enters, leaves))
    }

    fn way(&self, a: DVec3, along: DVec3, end: f64, margin: f64) -> (f64, f64) {
        let (from, along) = (self.turned * (a - self.centre), self.turned * along);
        let half = self.half + margin;
        let (low, high) = ((-half - from) / along, (half - from) / along);
        let (mut enters, mut leaves) = (0.0_f64, end);
        for axis in 0..3 {
            enters = enters.max(low[axis].min(high[axis]));
            leaves = leaves.min(low[axis].max(high[axis]));
        }
        (enters, leaves)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// The distance of a point of the world from a placed box.
    fn distance(extent: &Extent, pose: &Pose, point: DVec3) -> f64 {
        let own = pose.transform().inverse().transform_point3(point);
        own.distance(own.clamp(extent.min, extent.max))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4_000))]

        #[test]
        fn what_passes_through_is_found_and_what_passes_far_is_not(
            (low, sides) in (vec3(3.0), (0.0..2.0, 0.0..2.0, 0.0..2.0)),
            (position, angles_deg, origin) in (vec3(5.0), vec3(180.0), vec3(4.0)),
            (a, b, margin) in (vec3(9.0), vec3(9.0), 0.0..0.5),
        ) {
            let extent = Extent { min: low, max: low + DVec3::new(sides.0, sides.1, sides.2) };
            let pose = Pose { position, angles_deg };
            let solid = Solid::placed(&extent, &pose).from(origin);
            let nearest = (0..=400)
                .map(|k| distance(&extent, &pose, a.lerp(b, f64::from(k) / 400.0)))
                .fold(f64::INFINITY, f64::min);
            let found = solid.meets_segment(a - origin, b - origin, margin);
            prop_assert!(found || nearest > margin);
            // A box that is larger by the margin has corners farther away than it.
            let step = a.distance(b) / 400.0;
            prop_assert!(!found || nearest <= margin * 3.0_f64.sqrt() + step);
            prop_assert!(!found || solid.meets_ray(a - origin, b - a, margin));
            let way = solid.along_ray(a - origin, (b - a).normalize(), margin);
            prop_assert!(!found || way.is_some());
            if let Some((from, to)) = way {
                let length = a.distance(b);
                let near = (0..=400).map(|k| length * f64::from(k) / 400.0).filter(|&t| {
                    distance(&extent, &pose, a + (b - a) / length * t) <= margin
                });
                for t in near {
                    prop_assert!((from - 1e-9..=to + 1e-9).contains(&t), "{t}: {from} to {to}");
                }
            }
            let ball = solid.ball();
            let way = super::super::distance::segment_squared(ball.centre, a - origin, b - origin);
            prop_assert!(!found || way.sqrt() <= ball.radius + 2.0 * margin);
        }
    }

    #[test]
    fn what_lies_in_a_side_or_is_not_a_number_is_not_certain() {
        let extent = Extent {
            min: DVec3::ZERO,
            max: DVec3::ONE,
        };
        let solid = Solid::placed(&extent, &Pose::IDENTITY);
        let (a, b) = (DVec3::new(-1.0, 1.0, 0.5), DVec3::new(2.0, 1.0, 0.5));
        assert!(solid.meets_segment(a, b, 0.0), "along a side");
        assert!(!solid.meets_segment(a + DVec3::Y, b + DVec3::Y, 0.5));
        assert!(!solid.meets_segment(a, a, 0.5), "a point beside it");
        assert!(solid.meets_segment(a, a, 1.5));
        assert!(solid.meets_segment(DVec3::NAN, b, 0.0));
        assert!(solid.meets_segment(a, b + DVec3::Y * 9.0, f64::INFINITY));
        assert!(!solid.meets_ray(b, DVec3::X, 0.5) && solid.meets_ray(b, -DVec3::X, 0.0));
    }
}

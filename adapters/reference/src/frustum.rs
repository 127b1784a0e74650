//! Cylinders and cones, truncated or not: one solid with two radii.

use glam::DVec3;

use crate::extent::Extent;
use crate::primitive::Ends;
use crate::ray::{Ray, unit};
use crate::roots::below_parabola;

/// A solid of revolution between two discs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frustum {
    base: DVec3,
    cap: DVec3,
    base_radius: f64,
    cap_radius: f64,
    /// From base to cap, of length 1.
    axis: DVec3,
    height: f64,
    /// Radius gained per unit of height.
    slope: f64,
}

impl Frustum {
    /// `None` where it has no inside.
    pub fn new(base: DVec3, base_radius: f64, cap: DVec3, cap_radius: f64) -> Option<Self> {
        let axis = unit(cap - base)?;
        let height = (cap - base).dot(axis);
        let radii = [base_radius, cap_radius];
        let is_solid = radii.iter().all(|r| *r >= 0.0 && r.is_finite()) && radii != [0.0, 0.0];
        is_solid.then_some(Self {
            base,
            cap,
            base_radius,
            cap_radius,
            axis,
            height,
            slope: (cap_radius - base_radius) / height,
        })
    }

    pub fn extent(&self) -> Extent {
        // How far a disc across the axis reaches along each coordinate.
        let disc = (DVec3::ONE - self.axis * self.axis)
            .max(DVec3::ZERO)
            .map(f64::sqrt);
        let (b, c) = (disc * self.base_radius, disc * self.cap_radius);
        Extent::around([self.base - b, self.base + b, self.cap - c, self.cap + c])
    }

    /// The piece of the line that is inside; it is convex, so there is one.
    pub fn span(&self, ray: &Ray) -> Option<Ends> {
        let along = ray.direction.dot(self.axis);
        let across = ray.direction - self.axis * along;
        let from_base = ray.origin - self.base;
        let height = from_base.dot(self.axis);

        // Between the two planes first.
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        if along == 0.0 {
            if height < 0.0 || height > self.height {
                return None;
            }
        } else {
            let p = -height / along;
            // From the cap's own centre: of a long needle the far end keeps
            // its digits too.
            let q = -(ray.origin - self.cap).dot(self.axis) / along;
            (low, high) = if p < q { (p, q) } else { (q, p) };
        }

        // Solve near the solid: where the line is closest to the axis, or, if
        // that is beyond a plane, where it passes through the plane.
        let closest = -(from_base - self.axis * height).dot(across) / across.length_squared();
        let shift = if closest.is_finite() {
            closest.max(low).min(high)
        } else {
            low
        };
        if !shift.is_finite() {
            return None;
        }
        let (off, radius) = self.around(ray.at(shift));
        let distance = off.length();
        let growth = self.slope * along;
        let pieces = below_parabola(
            across.length_squared() - growth * growth,
            off.dot(across) - radius * growth,
            (distance - radius) * (distance + radius),
        );
        // The other half of the double cone is beyond the planes, but for
        // rounding at the apex.
        let (enter, leave) = pieces
            .into_iter()
            .flatten()
            .map(|(p, q)| ((shift + p).max(low), (shift + q).min(high)))
            .filter(|(p, q)| p < q)
            .max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
        let end = |t: f64, outwards: f64| {
            if t == low || t == high {
                (t, self.axis * (along * outwards).signum())
            } else {
                let (off, _) = self.around(ray.at(t));
                (t, off.normalize_or(-self.axis) - self.axis * self.slope)
            }
        };
        Some((end(enter, -1.0), end(leave, 1.0)))
    }

    /// From the axis to the point, and the radius at the point's height.
    fn around(&self, point: DVec3) -> (DVec3, f64) {
        let p = point - self.base;
        let height = p.dot(self.axis);
        let off = p - self.axis * height;
        (off, self.base_radius + self.slope * height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn z(z: f64) -> DVec3 {
        DVec3::Z * z
    }

    fn ends(frustum: &Frustum, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        frustum
            .span(&Ray { origin, direction })
            .map(|(a, b)| (a.0, b.0))
    }

    #[test]
    fn a_cylinder_from_the_side_and_from_the_end() {
        let cylinder = Frustum::new(z(0.0), 1.0, z(4.0), 1.0).unwrap();
        let side = ends(&cylinder, DVec3::new(-3.0, 0.0, 2.0), DVec3::X);
        assert_eq!(side, Some((2.0, 4.0)));
        assert_eq!(ends(&cylinder, z(-3.0), DVec3::Z), Some((3.0, 7.0)));
        assert_eq!(ends(&cylinder, DVec3::new(-3.0, 0.0, 5.0), DVec3::X), None);
        assert_eq!(ends(&cylinder, DVec3::new(1.5, 0.0, -3.0), DVec3::Z), None);
    }

    #[test]
    fn a_cone_along_its_axis_meets_base_and_apex() {
        let cone = Frustum::new(z(0.0), 1.0, z(2.0), 0.0).unwrap();
        let (enter, leave) = ends(&cone, z(-1.0), DVec3::Z).unwrap();
        assert_eq!(enter, 1.0);
        assert!((leave - 3.0).abs() < 1e-12);
        // Half-way up the radius is a half.
        let side = ends(&cone, DVec3::new(-3.0, 0.0, 1.0), DVec3::X).unwrap();
        assert!((side.0 - 2.5).abs() < 1e-15 && (side.1 - 3.5).abs() < 1e-15);
        // The other half of the double cone is not there.
        assert_eq!(ends(&cone, DVec3::new(-3.0, 0.0, 2.5), DVec3::X), None);
    }

    #[test]
    fn a_line_along_the_mantle_has_one_end_on_it() {
        // Parallel to the mantle on one side: the quadratic is linear.
        let cone = Frustum::new(z(0.0), 1.0, z(1.0), 0.0).unwrap();
        let (origin, direction) = (DVec3::new(1.5, 0.0, -1.0), DVec3::new(-1.0, 0.0, 1.0));
        let (enter, leave) = ends(&cone, origin, direction).unwrap();
        assert_eq!(enter, 1.0);
        assert!((leave - 1.75).abs() < 1e-14, "{leave}");
    }

    #[test]
    fn a_needle_of_a_million_radii() {
        let needle = Frustum::new(z(0.0), 1e-3, z(1e3), 1e-3).unwrap();
        let (enter, _) = ends(&needle, DVec3::new(-5.0, 0.0, 999.0), DVec3::X).unwrap();
        assert!((enter - (5.0 - 1e-3)).abs() < 1e-14, "{enter}");
    }

    fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn ends_lie_on_the_surface(
            base in vec3(5.0), cap in vec3(5.0), r0 in 0.0..3.0, r1 in 0.01..3.0,
            origin in vec3(20.0), target in vec3(4.0),
        ) {
            prop_assume!(base.distance(cap) > 0.01 && origin.distance(target) > 0.1);
            let solid = Frustum::new(base, r0, cap, r1).unwrap();
            let ray = Ray { origin, direction: target - origin };
            let Some((enter, leave)) = solid.span(&ray) else { return Ok(()) };
            prop_assert!(enter.0 < leave.0);
            for (t, normal) in [enter, leave] {
                let (off, radius) = solid.around(ray.at(t));
                let height = (ray.at(t) - base).dot(solid.axis);
                let on_mantle = (off.length() - radius).abs() < 1e-12;
                let on_disc = height.abs() < 1e-12 || (height - solid.height).abs() < 1e-12;
                prop_assert!(on_mantle || on_disc, "{off} {radius} {height}");
                prop_assert!(height > -1e-9 && height < solid.height + 1e-9);
                prop_assert!(normal.is_finite());
            }
            prop_assert!(enter.1.dot(ray.direction) <= 1e-9);
            prop_assert!(leave.1.dot(ray.direction) >= -1e-9);
        }
    }
}

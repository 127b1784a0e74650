//! The torus: a quartic, solved between brackets.
//!
//! The closed form of the quartic loses its digits where roots come close
//! together, which they do on every silhouette. Here the derivatives' roots cut
//! the line into pieces on which the quartic is monotone; whether a piece's
//! ends are inside is asked of the distance to the surface itself, and where
//! the answer changes there is exactly one root, found on that same distance.

use glam::DVec3;

use crate::extent::Extent;
use crate::primitive::Ends;
use crate::ray::Ray;
use crate::roots::bracketed;

/// A ring around the y axis, in the plane y = 0.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Torus {
    /// From the axis to the middle of the tube, > 0.
    pub major: f64,
    /// The radius of the tube, > 0.
    pub minor: f64,
}

impl Torus {
    pub fn extent(&self) -> Extent {
        let reach = self.major + self.minor;
        let corner = DVec3::new(reach, self.minor, reach);
        Extent {
            min: -corner,
            max: corner,
        }
    }

    /// The pieces of the line that are inside: two at most.
    pub fn spans(&self, ray: &Ray) -> Vec<Ends> {
        let speed = ray.direction.length();
        let Some(middle) = ray.closest_to(DVec3::ZERO) else {
            return Vec::new();
        };
        // Lengths in units of the torus's own, from the point of the line that
        // is closest to its centre: the cubic term of the quartic vanishes.
        let unit = self.major + self.minor;
        let line = Ray {
            origin: ray.at(middle) / unit,
            direction: ray.direction / speed,
        };
        let ring = Self {
            major: self.major / unit,
            minor: self.minor / unit,
        };
        let reach = 1.0 - line.origin.length_squared();
        if reach.is_nan() || reach <= 0.0 {
            return Vec::new();
        }
        // A little beyond, so that both ends are outside whatever the rounding.
        let cuts = ring.monotone_pieces(&line, reach.sqrt() + 1e-6);

        let mut spans = Vec::new();
        let mut enter = None;
        for pair in cuts.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            let was_inside = ring.distance(&line, a).0 < 0.0;
            let is_inside = ring.distance(&line, b).0 < 0.0;
            if was_inside == is_inside {
                continue;
            }
            let t = bracketed(a, b, |t| ring.distance(&line, t));
            let end = (middle + t * (unit / speed), ring.normal(line.at(t)));
            match enter.take() {
                Some(enter) if !is_inside => spans.push((enter, end)),
                _ => enter = Some(end),
            }
        }
        spans.retain(|(enter, leave)| enter.0 < leave.0);
        spans
    }

    /// Ascending parameters within ±`reach` between which the quartic of the
    /// line rises or falls, but does not do both.
    fn monotone_pieces(&self, line: &Ray, reach: f64) -> Vec<f64> {
        let (o, d) = (line.origin, line.direction);
        let across = self.major * self.major;
        // (|p|² + R² − r²)² − 4 R² (x² + z²) = t⁴ + square t² + linear t + …
        let k = o.length_squared() + (self.major - self.minor) * (self.major + self.minor);
        let square = 2.0 * k - 4.0 * across * (d.x * d.x + d.z * d.z);
        let linear = -8.0 * across * (o.x * d.x + o.z * d.z);
        let slope = |t: f64| {
            (
                (4.0 * t * t + 2.0 * square) * t + linear,
                12.0 * t * t + 2.0 * square,
            )
        };
        // The slope's own monotone pieces end where its slope is 0. The middle
        // is one more cut: it does no harm, and saves a thin tube there.
        let turn = (-square / 6.0).max(0.0).sqrt().min(reach);
        let steps = [-reach, -turn, turn, reach];
        let mut cuts = vec![-reach, 0.0, reach];
        for pair in steps.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            if (slope(a).0 < 0.0) != (slope(b).0 < 0.0) {
                cuts.push(bracketed(a, b, slope));
            }
        }
        cuts.sort_by(f64::total_cmp);
        cuts
    }

    /// The signed distance of the line's point to the surface, negative inside,
    /// and how fast it changes.
    fn distance(&self, line: &Ray, t: f64) -> (f64, f64) {
        let (p, d) = (line.at(t), line.direction);
        let from_axis = p.x.hypot(p.z);
        let off = from_axis - self.major;
        let from_ring = off.hypot(p.y);
        let slope = (off * (p.x * d.x + p.z * d.z) / from_axis + p.y * d.y) / from_ring;
        (from_ring - self.minor, slope)
    }

    fn normal(&self, p: DVec3) -> DVec3 {
        let from_axis = p.x.hypot(p.z);
        let off = (from_axis - self.major) / from_axis;
        let normal = DVec3::new(p.x * off, p.y, p.z * off);
        // The point of a horn torus that is on its own axis has no normal.
        if normal.is_finite() && normal != DVec3::ZERO {
            normal
        } else {
            DVec3::Y
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn ends(torus: Torus, origin: DVec3, direction: DVec3) -> Vec<f64> {
        let spans = torus.spans(&Ray { origin, direction });
        spans.iter().flat_map(|(a, b)| [a.0, b.0]).collect()
    }

    #[test]
    fn through_the_middle_there_are_four_surfaces() {
        let torus = Torus {
            major: 3.0,
            minor: 1.0,
        };
        let found = ends(torus, DVec3::X * -10.0, DVec3::X);
        for (got, want) in found.iter().zip([6.0, 8.0, 12.0, 14.0]) {
            assert!((got - want).abs() < 1e-12, "{found:?}");
        }
        assert_eq!(found.len(), 4);
        assert!(
            ends(torus, DVec3::Y * 5.0, -DVec3::Y).is_empty(),
            "the hole"
        );
        let down = ends(torus, DVec3::new(3.0, 5.0, 0.0), -DVec3::Y);
        assert!((down[0] - 4.0).abs() < 1e-12 && (down[1] - 6.0).abs() < 1e-12);
    }

    #[test]
    fn a_thin_ring_far_away() {
        let torus = Torus {
            major: 1.0,
            minor: 1e-6,
        };
        let found = ends(torus, DVec3::new(1.0, 1e4, 0.0), -DVec3::Y);
        assert_eq!(found.len(), 2);
        assert!((found[1] - found[0] - 2e-6).abs() < 1e-11, "{found:?}");
    }

    #[test]
    fn a_horn_torus_closes_on_its_axis() {
        let torus = Torus {
            major: 1.0,
            minor: 1.0,
        };
        let found = ends(torus, DVec3::X * -5.0, DVec3::X);
        assert!((found[0] - 3.0).abs() < 1e-12);
        assert!((found[found.len() - 1] - 7.0).abs() < 1e-12);
    }

    fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        #[test]
        fn ends_lie_on_the_surface_and_none_is_missed(
            major in 0.1..10.0, share in 1e-4..1.0, origin in vec3(30.0), target in vec3(8.0),
        ) {
            prop_assume!(origin.distance(target) > 0.1);
            let torus = Torus { major, minor: major * share };
            let ray = Ray { origin, direction: target - origin };
            let spans = torus.spans(&ray);
            prop_assert!(spans.len() <= 2);
            for (t, normal) in spans.iter().flat_map(|(a, b)| [*a, *b]) {
                let (off, _) = torus.distance(&ray, t);
                prop_assert!(off.abs() < 1e-9 * major, "{off}");
                prop_assert!(normal.is_finite());
            }
            for (enter, leave) in &spans {
                prop_assert!(enter.1.dot(ray.direction) <= 1e-6);
                prop_assert!(leave.1.dot(ray.direction) >= -1e-6);
            }
            for i in 0..400 {
                let t = -1.0 + f64::from(i) * 0.01;
                let off = torus.distance(&ray, t).0;
                if off.abs() > 1e-9 {
                    let inside = spans.iter().any(|(a, b)| a.0 < t && t < b.0);
                    prop_assert_eq!(inside, off < 0.0, "{}", t);
                }
            }
        }
    }
}

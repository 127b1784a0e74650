//! How far a point is from what light passes through: a segment, a triangle, a
//! half-strip.
//!
//! A result may be too small where a shape is degenerate (a triangle without
//! an area counts as its edges), never too large by more than rounding; what is
//! not a number is not certain, and left to the caller as it is.

use glam::DVec3;

/// The square of the distance of `p` from the segment from `a` to `b`.
pub fn segment_squared(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let length_squared = along.length_squared();
    if length_squared == 0.0 {
        return p.distance_squared(a);
    }
    let t = ((p - a).dot(along) / length_squared).clamp(0.0, 1.0);
    p.distance_squared(a + along * t)
}

/// The square of the distance of `p` from the triangle with these corners.
pub fn triangle_squared(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> f64 {
    // Below this sine the triangle is as thin as the rounding of its corners.
    const THIN: f64 = 1e-10;
    let (ab, bc, ca) = (b - a, c - b, a - c);
    let normal = ab.cross(-ca);
    let area_squared = normal.length_squared();
    let longest_squared = ab
        .length_squared()
        .max(bc.length_squared())
        .max(ca.length_squared());
    if area_squared > (THIN * longest_squared) * (THIN * longest_squared) {
        let inside = |from: DVec3, edge: DVec3| normal.cross(edge).dot(p - from) >= 0.0;
        if inside(a, ab) && inside(b, bc) && inside(c, ca) {
            let off = normal.dot(p - a);
            return off * off / area_squared;
        }
    }
    least([
        segment_squared(p, a, b),
        segment_squared(p, b, c),
        segment_squared(p, c, a),
    ])
}

/// The square of the distance of `p` from all that can be reached from the
/// segment from `a` to `b` by going in a `direction` (of length 1).
///
/// The distance from the strip at the place t of the segment is a convex
/// function of t. Where the nearest place of the endless strip is ahead of the
/// segment, that is the answer; otherwise the segment itself is nearest, or the
/// place where its ray stands square below `p`.
pub fn half_strip_squared(p: DVec3, a: DVec3, b: DVec3, direction: DVec3) -> f64 {
    let (along, to) = (b - a, p - a);
    let flat = |v: DVec3| v - direction * v.dot(direction);
    let (flat_along, flat_to) = (flat(along), flat(to));
    let ahead = |t: f64| (to - along * t).dot(direction);
    let nearest = |along: DVec3, to: DVec3| {
        let length_squared = along.length_squared();
        if length_squared == 0.0 {
            0.0
        } else {
            (to.dot(along) / length_squared).clamp(0.0, 1.0)
        }
    };
    let t = nearest(flat_along, flat_to);
    if ahead(t) >= 0.0 {
        return (flat_to - flat_along * t).length_squared();
    }
    let t = nearest(along, to);
    let from_segment = (to - along * t).length_squared();
    if ahead(t) <= 0.0 {
        return from_segment;
    }
    // Between the two lies the place that is square below.
    let t = to.dot(direction) / along.dot(direction);
    let square_below = (flat_to - flat_along * t.clamp(0.0, 1.0)).length_squared();
    least([from_segment, square_below, square_below])
}

/// The least, or NaN where one is.
fn least(values: [f64; 3]) -> f64 {
    if values.iter().any(|v| v.is_nan()) {
        return f64::NAN;
    }
    values.into_iter().fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// The least of a convex function over 0 to `end`, by golden sections.
    fn least_of(end: f64, f: impl Fn(f64) -> f64) -> f64 {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut low, mut high) = (0.0, end);
        for _ in 0..60 {
            let (a, b) = (high - golden * (high - low), low + golden * (high - low));
            if f(a) <= f(b) {
                high = b;
            } else {
                low = a;
            }
        }
        f(0.5 * (low + high))
    }

    /// The least distance of `p` from the points of `at(s, t)`, affine in both:
    /// a convex function. s goes to 1 and t to `end(s)`.
    fn searched(p: DVec3, end: impl Fn(f64) -> f64, at: impl Fn(f64, f64) -> DVec3) -> f64 {
        least_of(1.0, |s| least_of(end(s), |t| at(s, t).distance(p)))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn a_triangle_is_as_far_as_the_nearest_of_its_points(
            p in vec3(10.0), a in vec3(6.0), b in vec3(6.0), c in vec3(6.0), thin in 0_u32..4,
        ) {
            // Every fourth is a needle or a point.
            let b = if thin == 0 { a + (b - a) * 1e-9 } else { b };
            let c = if thin == 1 { a + (b - a) * 0.3 } else { c };
            let want = searched(p, |s| 1.0 - s, |s, t| a + (b - a) * s + (c - a) * t);
            let got = triangle_squared(p, a, b, c).sqrt();
            prop_assert!((got - want).abs() < 1e-6, "{got} {want}");
        }

        #[test]
        fn a_half_strip_is_as_far_as_the_nearest_of_its_points(
            p in vec3(10.0), a in vec3(6.0), b in vec3(6.0), d in vec3(1.0), case in 0_u32..4,
        ) {
            prop_assume!(d.length() > 0.1);
            let d = d.normalize();
            let b = match case {
                0 => a,
                1 => a + d * 3.0,
                _ => b,
            };
            let want = searched(p, |_| 60.0, |s, t| a + (b - a) * s + d * t);
            let got = half_strip_squared(p, a, b, d).sqrt();
            prop_assert!((got - want).abs() < 1e-6, "{got} {want}");
        }
    }

    #[test]
    fn what_is_not_a_number_stays_one() {
        let nan = DVec3::new(f64::NAN, 0.0, 0.0);
        let (o, x, y) = (DVec3::ZERO, DVec3::X, DVec3::Y);
        for (p, a, b, c) in [
            (nan, o, x, y),
            (o, nan, x, y),
            (o, x, nan, y),
            (o, x, y, nan),
        ] {
            // A caller asks whether it is *certainly* larger.
            assert!(triangle_squared(p, a, b, c).is_nan());
        }
        assert!(half_strip_squared(nan, o, x, y).is_nan());
        assert!(half_strip_squared(o, nan, x, y).is_nan());
    }
}

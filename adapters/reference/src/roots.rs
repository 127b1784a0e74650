//! Roots of functions of one variable, between brackets.

/// The root of a function between `a` and `b`, where it has opposite signs.
/// `function` gives the value and the derivative; the derivative may be
/// anything: Newton's step is taken only where it stays between the brackets
/// and converges, halving does the rest.
pub(crate) fn bracketed(mut a: f64, mut b: f64, function: impl Fn(f64) -> (f64, f64)) -> f64 {
    let rising = function(b).0 > 0.0;
    let mut t = a * 0.5 + b * 0.5;
    let mut step_before = b - a;
    // 200 halvings exhaust every digit; Newton needs about six steps.
    for _ in 0..200 {
        let (value, slope) = function(t);
        if value == 0.0 {
            return t;
        }
        if (value > 0.0) == rising {
            b = t;
        } else {
            a = t;
        }
        let newton = t - value / slope;
        let middle = a * 0.5 + b * 0.5;
        let is_good = newton > a && newton < b && (newton - t).abs() < 0.5 * step_before.abs();
        let next = if is_good { newton } else { middle };
        step_before = next - t;
        if next == t || next <= a || next >= b {
            return next;
        }
        t = next;
        if step_before.abs() <= f64::EPSILON * t.abs() {
            return t;
        }
    }
    t
}

/// The parameters where a t² + 2 b t + c ≤ 0, in up to two pieces.
pub(crate) fn below_parabola(a: f64, b: f64, c: f64) -> [Option<(f64, f64)>; 2] {
    const ALL: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
    if a == 0.0 {
        let piece = match -c / (2.0 * b) {
            _ if b == 0.0 => (c <= 0.0).then_some(ALL),
            t if b > 0.0 => Some((ALL.0, t)),
            t => Some((t, ALL.1)),
        };
        return [piece, None];
    }
    let discriminant = b * b - a * c;
    if discriminant.is_nan() || discriminant <= 0.0 {
        return [(a < 0.0).then_some(ALL), None];
    }
    // The form that does not subtract what is nearly equal.
    let q = -(b + discriminant.sqrt().copysign(b));
    let (p, q) = (q / a, c / q);
    let (low, high) = if p < q { (p, q) } else { (q, p) };
    if a > 0.0 {
        [Some((low, high)), None]
    } else {
        [Some((ALL.0, low)), Some((high, ALL.1))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_root_is_found_where_newton_fails() {
        // Flat at the start, and no derivative to go by.
        let root = bracketed(0.0, 10.0, |t| ((t - 3.0).powi(3), f64::NAN));
        assert!((root - 3.0).abs() < 1e-5, "{root}");
        let root = bracketed(-1.0, 2.0, |t| (t.cbrt(), t.cbrt().powi(-2) / 3.0));
        assert!(root.abs() < 1e-12, "{root}");
    }

    proptest! {
        #[test]
        fn a_parabola_is_below_zero_exactly_there(a in -3.0..3.0, b in -3.0..3.0, c in -3.0..3.0, t in -9.0..9.0) {
            let value: f64 = a * t * t + 2.0 * b * t + c;
            prop_assume!(value.abs() > 1e-9);
            let inside = below_parabola(a, b, c).into_iter().flatten().any(|(p, q)| p < t && t < q);
            prop_assert_eq!(inside, value < 0.0);
        }
    }
}

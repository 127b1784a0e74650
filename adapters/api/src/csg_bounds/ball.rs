//! The smallest ball around balls (points are balls of radius 0).
//!
//! The farthest ball is added to a support of at most four, whose smallest ball
//! is found by trying every subset (Fischer & Gärtner 2003, "The smallest
//! enclosing ball of balls": Welzl's move-to-front is wrong for balls, trying
//! all subsets of a handful is not). The radius grows with every step, so it
//! ends; usually after a dozen passes over the input. Whatever rounding does
//! on the way, the radius that is returned is measured on every ball.

use glam::{DMat3, DVec3};

use crate::bounds::{Bounds, Sphere};

/// More passes than any input of doubles was seen to need.
const PASSES: usize = 100;

/// A ball around all of `balls`, the smallest one but for rounding.
/// [`Bounds::Empty`] around nothing, [`Bounds::Unbounded`] where a number is
/// not finite.
pub fn ball_around(balls: &[Sphere]) -> Bounds {
    let Some(first) = balls.first() else {
        return Bounds::Empty;
    };
    let is_finite = |b: &Sphere| b.centre.is_finite() && b.radius.is_finite();
    if !balls.iter().all(is_finite) {
        return Bounds::Unbounded;
    }
    let (mut min, mut max) = (first.centre, first.centre);
    let mut largest = 0.0_f64;
    for ball in balls {
        min = min.min(ball.centre - ball.radius);
        max = max.max(ball.centre + ball.radius);
        largest = largest.max(ball.radius);
    }
    let middle = min * 0.5 + max * 0.5;
    let size = (max * 0.5 - min * 0.5).max_element().max(largest);
    if !middle.is_finite() || !size.is_finite() {
        return Bounds::Unbounded;
    }
    if size == 0.0 {
        return Bounds::sphere(middle, 0.0).rounded_outwards();
    }

    // Around the origin and of size 1: neither digits nor squares are lost.
    let unit = |ball: &Sphere| Sphere {
        centre: (ball.centre - middle) / size,
        radius: ball.radius / size,
    };
    let farthest = |from: DVec3| {
        let reach = |ball: &Sphere| {
            let ball = unit(ball);
            (ball.centre - from).length() + ball.radius
        };
        let all = balls.iter().map(|ball| (reach(ball), ball));
        all.max_by(|a, b| a.0.total_cmp(&b.0))
            .unwrap_or((0.0, first))
    };

    let mut best = Sphere {
        centre: DVec3::ZERO,
        radius: f64::INFINITY,
    };
    let mut current = unit(farthest(DVec3::ZERO).1);
    let mut support = vec![current];
    for _ in 0..PASSES {
        let (radius, far) = farthest(current.centre);
        if radius < best.radius {
            best = Sphere {
                centre: current.centre,
                radius,
            };
        }
        if radius <= current.radius * (1.0 + 1e-12) {
            break;
        }
        support.push(unit(far));
        match smallest_of_few(&support) {
            Some((ball, kept)) if ball.radius > current.radius => {
                current = ball;
                support = kept;
            }
            // Rounding keeps it from growing: what is known is good enough.
            _ => break,
        }
    }

    let centre = middle + best.centre * size;
    let reach = |ball: &Sphere| (ball.centre - centre).length() + ball.radius;
    let radius = balls.iter().map(reach).fold(0.0, f64::max);
    // Below the range of squares the measured length is 0, not small.
    let radius = radius.max(best.radius * size);
    Bounds::sphere(centre, radius).rounded_outwards()
}

/// The smallest ball around at most five balls, and the ones it touches.
fn smallest_of_few(balls: &[Sphere]) -> Option<(Sphere, Vec<Sphere>)> {
    let mut best: Option<(Sphere, Vec<Sphere>)> = None;
    for subset in 1_u32..1 << balls.len() {
        if subset.count_ones() > 4 {
            continue;
        }
        let chosen = |(i, _): &(usize, &Sphere)| subset & (1 << i) != 0;
        let touched: Vec<Sphere> = balls
            .iter()
            .enumerate()
            .filter(chosen)
            .map(|(_, b)| *b)
            .collect();
        let Some(ball) = touching(&touched) else {
            continue;
        };
        if best.as_ref().is_some_and(|(b, _)| b.radius <= ball.radius) {
            continue;
        }
        let contains =
            |b: &Sphere| (b.centre - ball.centre).length() + b.radius <= ball.radius + 1e-10;
        if balls.iter().all(contains) {
            best = Some((ball, touched));
        }
    }
    best
}

/// The smallest ball that all of the (at most four) balls touch from inside.
///
/// With the first centre as origin, |x − dᵢ| = R − rᵢ. The first equation taken
/// off the others leaves dᵢ·x = eᵢ + R·fᵢ, linear in x and R; x lies in the span
/// of the dᵢ, so x = p + R·q; and the first equation gives R.
fn touching(balls: &[Sphere]) -> Option<Sphere> {
    let (first, others) = balls.split_first()?;
    if others.is_empty() {
        return Some(*first);
    }
    let mut d = [DVec3::ZERO; 3];
    let (mut e, mut f) = (DVec3::ZERO, DVec3::ZERO);
    // Unused rows solve themselves.
    let mut gram = DMat3::IDENTITY;
    for (i, ball) in others.iter().enumerate() {
        d[i] = ball.centre - first.centre;
        e[i] = 0.5 * (d[i].length_squared() + first.radius.powi(2) - ball.radius.powi(2));
        f[i] = ball.radius - first.radius;
    }
    for i in 0..others.len() {
        for j in 0..others.len() {
            gram.col_mut(j)[i] = d[i].dot(d[j]);
        }
    }
    let volume: f64 = (0..others.len()).map(|i| gram.col(i)[i]).product();
    if gram.determinant() <= volume * 1e-13 {
        // Flat: a smaller subset has the same ball.
        return None;
    }
    let inverse = gram.inverse();
    let span = |weights: DVec3| d[0] * weights.x + d[1] * weights.y + d[2] * weights.z;
    let (p, q) = (span(inverse * e), span(inverse * f));
    // |p + R·q|² = (R − r₀)²
    let a = q.length_squared() - 1.0;
    let b = p.dot(q) + first.radius;
    let c = p.length_squared() - first.radius.powi(2);
    let roots = if a.abs() < 1e-14 {
        [-0.5 * c / b, f64::NAN]
    } else {
        let root = (b * b - a * c).max(0.0).sqrt();
        [(-b + root) / a, (-b - root) / a]
    };
    let largest = balls.iter().map(|b| b.radius).fold(0.0, f64::max);
    let radius = roots
        .into_iter()
        .filter(|&r| r.is_finite() && r >= largest * (1.0 - 1e-12))
        .min_by(f64::total_cmp)?;
    Some(Sphere {
        centre: first.centre + p + q * radius,
        radius,
    })
}

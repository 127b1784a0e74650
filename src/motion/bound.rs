//! A bound on the motion in the picture that holds for every point of the
//! sphere: closed form, no trigonometry, no loop.
//!
//! # Derivation
//! **The points.** In camera space a point p of the ball at c₀ (radius R) goes to
//! q, a point of the ball at c₁. With Q the relative rotation and ‖u‖ ≤ 1
//! ```text
//! p = c₀ + R·u,   q = c₁ + R·Q·u,   m = q − p = Δ + R·d,   Δ = c₁ − c₀,   d = (Q − 1)·u.
//! ```
//! Let h be sin(θ/2) along the axis of Q. d lies in the plane across h, in the
//! disc of radius 2‖h‖. Along the view d_z = (Qᵀẑ − ẑ)·u, where the bracket has
//! the length g = 2‖h_xy‖ and, across and along the view, components not larger
//! than g and g²/2:
//! ```text
//! |d_z| ≤ g·‖u_xy‖ + (g²/2)·|u_z|.                                            (1)
//! ```
//! **Their displacement.** Let F₀, F₁ be the focal lengths in pixels (diagonal:
//! a pixel may be wider than high), δF = F₁ − F₀, and x = F₀·p_xy/p_z where p
//! is seen. Then
//! ```text
//! v = F₁·q_xy/q_z − F₀·p_xy/p_z = (F₁·m_xy + δF·p_xy − m_z·x) / q_z.              (2)
//! ```
//! Only m and δF, the motion itself, are above the line: no two far positions
//! are subtracted. At p_z = c₀z + R·t, p is off the axis through the centre by
//! R·u_xy: p_xy = c₀xy + R·u_xy and x = x_t + F₀·R·u_xy/p_z with x_t =
//! F₀·c₀xy/p_z. (2) becomes
//! ```text
//! v = [ T(x_t) + R·M(x_t)·d ] / q_z                                         (a)
//!   − m_z·F₀·R·u_xy / (p_z·q_z)  +  δF·R·u_xy / q_z                           (b)
//! T(x) = F₁·Δ_xy + δF·c₀xy − Δ_z·x,     M(x)·d = F₁·d_xy − d_z·x.
//! ```
//! **(a), the motion of the centre's line.** For a fixed d the bracket is
//! affine in x, so its length is convex, and x_t runs along a segment: its
//! ends, at p_z = c₀z ∓ R, bound it. At an end, over the disc of all d,
//! ```text
//! ‖T + R·M·d‖² ≤ ‖T‖² + 2·R·max|T·Md| + R²·max‖Md‖² = ‖T‖² + 4R·‖GᵀT‖ + 4R²·λ = J²   (3)
//! ```
//! G has the rows M₁ × h and M₂ × h (M₁ = (F₁x, 0, −x₁), M₂ = (0, F₁y, −x₂)),
//! as the part of a vector across the axis, times ‖h‖, is as long as its
//! product with h; λ is the larger eigenvalue of G·Gᵀ. (3) is exact where the
//! motion is along, or across, the direction in which the rotation moves most.
//! q_z ≥ c₁z − R.
//!
//! **(b), off that line.** With w² = 1 − t² ≥ ‖u_xy‖² and (1), (b) is not
//! larger than
//! ```text
//! F₀·[ |Δ_z|·φ + g·ψ + (g²/2)·R·φ ] + |δF|·χ,
//! φ ≥ R·w/(p_z·q_z),   ψ ≥ R²·w²/(p_z·q_z),   χ ≥ R·w/q_z.
//! ```
//! As q_z = p_z + m_z, both depths are at least c + R·t with c = min(c₀z, c₀z +
//! Δ_z − R·g). Where c > R, elementary maxima over t give, with K = c² − R² and
//! S = √(1 + 8R²/c²),
//! ```text
//! φ = R·c·√((3 + S)³ / (32·(1 + S))) / K^{3/2},   ψ = R²/K,   χ = R/√K.
//! ```
//! (For φ: the maximum is at t = −4ϱ/(1 + S), ϱ = R/c, where 1 + ϱt = (3 −
//! S)/2, and 3 − S = 8(1 − ϱ²)/(3 + S) takes away the last cancellation.)
//! Always, with K₀ = c₀z² − R²,
//! ```text
//! φ = (R/√K₀)/(c₁z − R),   ψ = 2R²/((c₀z + √K₀)·(c₁z − R)),   χ = R/(c₁z − R),
//! ```
//! and the smaller of the two is taken.
//!
//! **Three bounds.** J/(c₁z − R) + (b) is the bound *forth*. The motion back
//! moves every point as far, so the same expression with both instants
//! exchanged is one as well. And the two pictures are ellipses: no point goes
//! further than ‖centre₁ − centre₀‖ + a₀ + a₁, which is what counts when an
//! object turns over or jumps. The smallest of the three is the result; it does
//! not change when the instants are swapped.
//!
//! **Parallel projection.** v = S₁·q_xy − S₀·p_xy with S in pixels per unit: (3)
//! with x = 0 and |δS|·R are all of it.
//!
//! # Rounding
//! The sphere's place is known to a length (`slack`): the radius grows by it.
//! The displacement m is known to `delta_error`, and the sums in T lose a few
//! units of the last place of their largest term: these are added, times the
//! largest derivative of (2), (F₁ + ‖x‖)/(c₁z − R). Everything else is made of
//! sums, products and roots of positive numbers and is worth a factor 1 +
//! 1e-13. All lengths are divided by the larger of c₀z and c₁z. Squares of what
//! is below 1e-150 of that vanish: so much is added where anything moves. Where
//! nothing does, the bound is 0. Anything that is not finite or not in front is
//! +∞: not certain is not slow.
//!
//! # Against a shorter form
//! A shorter bound is ‖displacement‖ ≤ f·(‖c₀×Δ‖ + R‖Δ‖ +
//! 2sR‖c₀‖ + 2sR²)/((c₀z−R)(c₁z−R)), from the components of p × q. It is 1.2
//! times too large for a sideways motion at R/D = 0.1 and 9 times at 0.8, where
//! this one is exact.

use super::relative::{Lenses, ObserverMotion, RelativeMotion};
use decor_api::{Pose, Sphere};
use rayon::prelude::*;

/// Relative rounding of the whole chain, with room.
const ROUNDED: f64 = 1.0 + 1e-13;
/// Per term of a sum that may cancel.
const TERM: f64 = 8.0 * f64::EPSILON;
/// Below this share of the distance, squares underflow.
const VANISHING: f64 = 1e-150;
/// Squares of more, at a distance of 1, are not measured.
const LARGEST: f64 = 1e100;
/// Depths outside of these are not measured: products of them are no numbers.
const DEPTHS: std::ops::Range<f64> = 1e-290..1e290;

/// How far, in pixels, any point of the sphere can move in the picture; +∞
/// where nothing certain can be said: the sphere is not wholly in front of the
/// observer at both instants, or a number is not finite. Never NaN. 0 exactly
/// where nothing moves.
pub fn bound_px(motion: &RelativeMotion, lenses: &Lenses) -> f64 {
    kernel(&Columns::of(motion), &Lens::of(lenses))
}

/// [`bound_px`] for many objects: `object` gives the poses at both instants and
/// the sphere (in the object's coordinates) of each of `out`, whose entries
/// become its bound. Parallel; nothing is allocated per object, and the results
/// are bit for bit those of [`bound_px`], for any number of threads.
pub fn bounds_px<F>(observer: &ObserverMotion, lenses: &Lenses, object: F, out: &mut [f64])
where
    F: Fn(usize) -> (Pose, Pose, Sphere) + Sync,
{
    let lens = Lens::of(lenses);
    out.par_chunks_mut(TILE)
        .enumerate()
        .for_each(|(tile, out)| {
            let mut table = Table::EMPTY;
            for i in 0..out.len() {
                let (before, after, sphere) = object(tile * TILE + i);
                table.set(i, &Columns::of(&observer.of(&before, &after, &sphere)));
            }
            let mut bounds = [0.0; TILE];
            for (i, bound) in bounds.iter_mut().enumerate() {
                *bound = kernel(&table.get(i), &lens);
            }
            out.copy_from_slice(&bounds[..out.len()]);
        });
}

/// The same bound under parallel projection; the lenses in pixels per scene
/// unit. It needs no sphere in front: depth plays no part.
pub fn bound_orthographic_px(motion: &RelativeMotion, lenses: &Lenses) -> f64 {
    let (m, lens) = (Columns::of(motion), Lens::of(lenses));
    let scale = larger(magnitude([m.c0[0], m.c0[1]]), larger(m.r0, m.r1));
    let scale = larger(scale, magnitude([m.delta[0], m.delta[1]]));
    let scale = if scale > 0.0 { scale } else { 1.0 };
    if !(DEPTHS.contains(&scale) && m.finite(&lens)) {
        return f64::INFINITY;
    }
    let m = m.scaled(1.0 / scale, &lens);
    let focal = larger(lens.after[0], lens.after[1]);
    let zoom = larger(lens.delta[0].abs(), lens.delta[1].abs());
    let j = joint(
        [0.0; 2], m.c0, m.delta, m.half, m.r0, lens.after, lens.delta,
    )
    .sqrt();
    let rounding = focal * (m.error + TERM * magnitude([m.delta[0], m.delta[1]]))
        + TERM * zoom * magnitude([m.c0[0], m.c0[1]]);
    finish((j + zoom * m.r0 + rounding) * scale)
}

/// A motion as the kernel reads it.
#[derive(Clone, Copy)]
struct Columns {
    c0: [f64; 3],
    c1: [f64; 3],
    delta: [f64; 3],
    half: [f64; 3],
    r0: f64,
    r1: f64,
    error: f64,
}

impl Columns {
    fn of(m: &RelativeMotion) -> Self {
        const GROWN: f64 = 1.0 + 4.0 * f64::EPSILON;
        // A sphere with less than no extent is no sphere.
        let radius = if m.radius >= 0.0 { m.radius } else { f64::NAN };
        Self {
            c0: m.centre_before.to_array(),
            c1: m.centre_after.to_array(),
            delta: m.delta.to_array(),
            half: m.half_turn.to_array(),
            r0: (radius + m.slack_before) * GROWN,
            r1: (radius + m.slack_after) * GROWN,
            error: m.delta_error,
        }
    }

    /// Are all numbers finite, and radii and focal lengths none below 0?
    #[inline(always)]
    fn finite(&self, lens: &Lens) -> bool {
        let all = [self.c0, self.c1, self.delta, self.half];
        let mut sum = self.error + lens.after[0] + lens.after[1] + lens.before[0] + lens.before[1];
        for v in all {
            sum += v[0].abs() + v[1].abs() + v[2].abs();
        }
        // A sum of finite numbers that is not finite is too large to measure.
        let real = (lens.before[0] >= 0.0)
            & (lens.before[1] >= 0.0)
            & (lens.after[0] >= 0.0)
            & (lens.after[1] >= 0.0);
        real & (self.r0 >= 0.0) & (self.r1 >= 0.0) & (sum + self.r0 + self.r1 < f64::INFINITY)
    }

    /// All lengths times `by`; and what could vanish, made visible.
    #[inline(always)]
    fn scaled(&self, by: f64, lens: &Lens) -> Self {
        let times = |v: [f64; 3]| [v[0] * by, v[1] * by, v[2] * by];
        let still = (self.delta[0] == 0.0)
            & (self.delta[1] == 0.0)
            & (self.delta[2] == 0.0)
            & (self.half[0] == 0.0)
            & (self.half[1] == 0.0)
            & (self.half[2] == 0.0)
            & (lens.delta[0] == 0.0)
            & (lens.delta[1] == 0.0);
        Self {
            c0: times(self.c0),
            c1: times(self.c1),
            delta: times(self.delta),
            half: self.half,
            r0: self.r0 * by,
            r1: self.r1 * by,
            error: self.error * by + if still { 0.0 } else { VANISHING },
        }
    }
}

/// The lenses as the kernel reads them.
#[derive(Clone, Copy)]
struct Lens {
    before: [f64; 2],
    after: [f64; 2],
    delta: [f64; 2],
    back: [f64; 2],
}

impl Lens {
    fn of(lenses: &Lenses) -> Self {
        Self {
            before: lenses.before.to_array(),
            after: lenses.after.to_array(),
            delta: lenses.delta.to_array(),
            back: (-lenses.delta).to_array(),
        }
    }
}

/// How many objects are measured together.
const TILE: usize = 128;

/// The motions of a tile, a column for each number: the kernel then runs on
/// as many objects at once as a register holds.
struct Table {
    rows: [[f64; TILE]; 15],
}

impl Table {
    const EMPTY: Self = Self {
        rows: [[0.0; TILE]; 15],
    };

    fn set(&mut self, i: usize, m: &Columns) {
        let columns = [m.c0, m.c1, m.delta, m.half, [m.r0, m.r1, m.error]];
        for (row, value) in self.rows.iter_mut().zip(columns.as_flattened()) {
            row[i] = *value;
        }
    }

    #[inline(always)]
    fn get(&self, i: usize) -> Columns {
        let r = &self.rows;
        let three = |k: usize| [r[k][i], r[k + 1][i], r[k + 2][i]];
        Columns {
            c0: three(0),
            c1: three(3),
            delta: three(6),
            half: three(9),
            r0: r[12][i],
            r1: r[13][i],
            error: r[14][i],
        }
    }
}

// `f64::max` and `f64::min` pass over NaN; these two do not branch, and every
// NaN ends in `finish`.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn magnitude(v: [f64; 2]) -> f64 {
    (v[0] * v[0] + v[1] * v[1]).sqrt()
}

#[inline(always)]
fn finish(bound: f64) -> f64 {
    if bound < f64::INFINITY {
        bound * ROUNDED
    } else {
        f64::INFINITY
    }
}

/// J² of (3) where the centre's line is seen at `x`.
#[inline(always)]
fn joint(
    x: [f64; 2],
    c: [f64; 3],
    delta: [f64; 3],
    h: [f64; 3],
    radius: f64,
    focal: [f64; 2],
    zoom: [f64; 2],
) -> f64 {
    let t = [
        focal[0] * delta[0] + zoom[0] * c[0] - delta[2] * x[0],
        focal[1] * delta[1] + zoom[1] * c[1] - delta[2] * x[1],
    ];
    let g1 = [x[0] * h[1], -x[0] * h[0] - focal[0] * h[2], focal[0] * h[1]];
    let g2 = [
        focal[1] * h[2] + x[1] * h[1],
        -x[1] * h[0],
        -focal[1] * h[0],
    ];
    let a = g1[0] * g1[0] + g1[1] * g1[1] + g1[2] * g1[2];
    let b = g2[0] * g2[0] + g2[1] * g2[1] + g2[2] * g2[2];
    let c = g1[0] * g2[0] + g1[1] * g2[1] + g1[2] * g2[2];
    let half_gap = 0.5 * (a - b);
    let eigenvalue = 0.5 * (a + b) + (half_gap * half_gap + c * c).sqrt();
    let gt = [
        g1[0] * t[0] + g2[0] * t[1],
        g1[1] * t[0] + g2[1] * t[1],
        g1[2] * t[0] + g2[2] * t[1],
    ];
    let along = (gt[0] * gt[0] + gt[1] * gt[1] + gt[2] * gt[2]).sqrt();
    t[0] * t[0] + t[1] * t[1] + 4.0 * radius * (along + radius * eigenvalue)
}

/// The bound forth: from the sphere at `c`, whose motion ends at the nearest
/// depth `near_after`.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "columns of one table")]
fn one_way(
    c: [f64; 3],
    r: f64,
    near: f64,
    radius: f64,
    near_after: f64,
    delta: [f64; 3],
    h: [f64; 3],
    error: f64,
    (from, to, zoom): ([f64; 2], [f64; 2], [f64; 2]),
) -> f64 {
    let far = c[2] + r;
    let k = near * far;
    let image = [from[0] * c[0], from[1] * c[1]];
    let x_near = [image[0] / near, image[1] / near];
    let x_far = [image[0] / far, image[1] / far];
    let j_near = joint(x_near, c, delta, h, radius, to, zoom);
    let j_far = joint(x_far, c, delta, h, radius, to, zoom);
    let j = larger(j_near, j_far).sqrt();

    let g2 = 4.0 * (h[0] * h[0] + h[1] * h[1]);
    let g = g2.sqrt();
    let root = k.sqrt();
    let phi_always = r / (root * near_after);
    let psi_always = 2.0 * r * r / ((c[2] + root) * near_after);
    let chi_always = r / near_after;
    // How much nearer q can be than p; from the exact `near`, not from c and r.
    let drop = larger(0.0, error + radius * g - delta[2] + TERM * delta[2].abs());
    let near_low = near - drop;
    let lowest = near_low + r;
    let k_low = near_low * (lowest + r);
    let inside = near_low > 0.0;
    let root_low = k_low.sqrt();
    let ratio = r / lowest;
    let s = (1.0 + 8.0 * ratio * ratio).sqrt();
    let three = 3.0 + s;
    let peak = (three * three * three / (32.0 * (1.0 + s))).sqrt();
    let phi_low = r * lowest * peak / (k_low * root_low);
    let psi_low = r * r / k_low;
    let chi_low = r / root_low;
    let pick = |low: f64, always: f64| if inside & (low < always) { low } else { always };
    let (phi, psi, chi) = (
        pick(phi_low, phi_always),
        pick(psi_low, psi_always),
        pick(chi_low, chi_always),
    );

    let focal_from = larger(from[0], from[1]);
    let focal_to = larger(to[0], to[1]);
    let zoomed = larger(zoom[0].abs(), zoom[1].abs());
    let off_line = focal_from
        * ((delta[2].abs() + error) * phi + g * psi + 0.5 * g2 * radius * phi)
        + zoomed * chi;
    let moved = (delta[0] * delta[0] + delta[1] * delta[1] + delta[2] * delta[2]).sqrt();
    let rounding = (focal_to + magnitude(x_near)) * (error + TERM * moved)
        + TERM * zoomed * magnitude([c[0], c[1]]);
    let bound = (j + rounding) / near_after + off_line;
    // Beyond this, squares overflow, and a comparison could hide it.
    let measurable = (magnitude(x_near) < LARGEST) & (moved < LARGEST) & (focal_to < LARGEST);
    if measurable { bound } else { f64::INFINITY }
}

/// The bound from one picture to the other, whatever the motion between.
#[inline(always)]
fn apart(m: &Columns, near: [f64; 2], lens: &Lens) -> f64 {
    let ellipse = |c: [f64; 3], r: f64, near: f64, focal: [f64; 2]| {
        let k = near * (c[2] + r);
        let across = (c[0] * c[0] + c[1] * c[1] + k).sqrt();
        let centre = [focal[0] * c[0] * c[2] / k, focal[1] * c[1] * c[2] / k];
        (centre, larger(focal[0], focal[1]) * r * across / k)
    };
    let (e0, a0) = ellipse(m.c0, m.r0, near[0], lens.before);
    let (e1, a1) = ellipse(m.c1, m.r1, near[1], lens.after);
    let focal = larger(
        larger(lens.before[0], lens.before[1]),
        larger(lens.after[0], lens.after[1]),
    );
    let rounding = TERM * (magnitude(e0) + magnitude(e1)) + m.error * focal;
    magnitude([e1[0] - e0[0], e1[1] - e0[1]]) + a0 + a1 + rounding
}

/// The bound of one object. No branch: a tile of them is vectorised.
#[inline(always)]
fn kernel(motion: &Columns, lens: &Lens) -> f64 {
    let scale = larger(motion.c0[2], motion.c1[2]);
    let certain = motion.finite(lens)
        & (motion.c0[2] - motion.r0 > DEPTHS.start)
        & (motion.c1[2] - motion.r1 > DEPTHS.start)
        & (scale < DEPTHS.end);
    let by = 1.0 / scale;
    let m = motion.scaled(by, lens);
    // Subtracted before they are scaled: this difference is exact.
    let (near0, near1) = (
        (motion.c0[2] - motion.r0) * by,
        (motion.c1[2] - motion.r1) * by,
    );
    let radius = larger(m.r0, m.r1);
    let forth = one_way(
        m.c0,
        m.r0,
        near0,
        radius,
        near1,
        m.delta,
        m.half,
        m.error,
        (lens.before, lens.after, lens.delta),
    );
    let negative = [-m.delta[0], -m.delta[1], -m.delta[2]];
    let back = one_way(
        m.c1,
        m.r1,
        near1,
        radius,
        near0,
        negative,
        m.half,
        m.error,
        (lens.after, lens.before, lens.back),
    );
    let apart = apart(&m, [near0, near1], lens);
    // A bound that is no number is no bound.
    let best = smaller(forth, smaller(back, smaller(apart, f64::INFINITY)));
    if certain { finish(best) } else { f64::INFINITY }
}

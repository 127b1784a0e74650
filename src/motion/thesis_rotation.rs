//! The thesis's measure of rotations (II-5).
//!
//! Of all points of the sphere, those seen on the *maximal segment* are
//! expected to move fastest: from the ellipse's centre to the vertex farthest
//! from the picture's centre (II-5-2-3). It is cut into one point per pixel;
//! each is the picture of a point M₁ of the sphere, which the rotation carries
//! along an arc. As it is not known where on that circle the motion is largest
//! in the picture, the arc from −γ to γ around M₁ is cut at constant angles,
//! and all pairs ("doublets") of points that are γ apart are projected
//! (II-5-3). The longest one is the measure.
//!
//! # At the singularities
//! | the thesis | here |
//! |---|---|
//! | γ from an arc cosine | 2·atan2(sin γ/2, cos γ/2) |
//! | the axis across the plane (M₁, M₂, M₃), undefined for no rotation, for half a turn, and for a point on the axis | the axis of the resulting rotation's quaternion; no rotation measures 0 |
//! | β = sin ε / sin γ (EQ 2) | α·u + β·v is cos ε·u + sin ε·(a × u), with the axis a: no quotient |
//! | M₃ by half the rotation where it is half a turn | not needed |
//! | a doublet's length by two projections | by its difference, 2·sin(γ/2) across its middle: small rotations keep their digits |

use super::ellipse::Ellipse;
use super::relative::{Lenses, RelativeMotion};
use super::thesis::larger;
use glam::{DVec2, DVec3};

/// Points of a maximal segment at most: a sphere that is wider than the picture
/// is not looked at in every pixel.
pub const SEGMENT_POINTS_MOST: u32 = 256;

/// Arcs at most; II-6: about ten.
pub const ARCS_MOST: u32 = 16;

/// II-5-2-3: from the ellipse's centre to its far vertex, in tangents.
pub fn maximal_segment(ellipse: &Ellipse) -> (DVec2, DVec2) {
    (
        ellipse.centre,
        ellipse.centre + ellipse.direction * ellipse.semi_major,
    )
}

/// The resulting rotation (II-5-3-2), about an axis through the sphere's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResultingRotation {
    /// Its axis, of length 1.
    pub axis: DVec3,
    /// γ, from 0 to π.
    pub angle_rad: f64,
    /// sin(γ/2).
    pub sin_half: f64,
    /// cos(γ/2).
    pub cos_half: f64,
}

impl ResultingRotation {
    /// The rotation of a motion; `None` where there is none.
    pub fn of(motion: &RelativeMotion) -> Option<Self> {
        let largest = motion.half_turn.abs().max_element();
        if largest == 0.0 || !largest.is_finite() {
            return None;
        }
        let scaled = motion.half_turn / largest;
        let length = scaled.length();
        let sin_half = (largest * length).min(1.0);
        let cos_half = ((1.0 - sin_half) * (1.0 + sin_half)).sqrt();
        let angle_rad = 2.0 * sin_half.atan2(cos_half);
        Some(Self {
            axis: scaled / length,
            angle_rad,
            sin_half,
            cos_half,
        })
    }
}

/// II-5-3-2 as it is printed: the centre of the arc through three successive
/// positions of a point, relative to the sphere's centre, is the foot of the
/// sphere's centre on their plane. `None` where they have no plane: no rotation,
/// half a turn, a point on the axis. Kept to compare.
pub fn arc_centre_by_three_points(m1: DVec3, m2: DVec3, m3: DVec3) -> Option<DVec3> {
    let normal = (m2 - m1).cross(m3 - m1);
    let normal = (normal.length() > 0.0).then(|| normal.normalize())?;
    Some(normal * normal.dot(m1))
}

/// The point of the sphere, on the observer's side, that is seen on the maximal
/// segment at `part` (0 to 1) of its length, as a direction from the sphere's
/// centre (II-5-3-1: the ray through the pixel meets the sphere).
///
/// With d the ray through the pixel and c the centre, −(c − d·(d·c)/d²) ± the
/// rest of the radius along d. The part of c across the ray is d × (d × c)/d²,
/// where d × c is taken from how far the pixel is from the centre's picture: a
/// small sphere keeps its digits.
pub fn surface_point(centre_camera: DVec3, radius: f64, ellipse: &Ellipse, part: f64) -> DVec3 {
    let c = centre_camera / centre_camera.z;
    let r = radius / centre_camera.z;
    let k = (1.0 - r) * (1.0 + r);
    let offset = c.truncate() * (r * r / k) + ellipse.direction * (ellipse.semi_major * part);
    let ray = c + offset.extend(0.0);
    // offset × c, by the radius.
    let across = (offset / r).extend(0.0).cross(c);
    let across = ray.cross(across) / ray.length_squared();
    let rest = (1.0 - across.length_squared()).max(0.0).sqrt();
    across - ray * (rest / ray.length())
}

/// II-5-3-4: the longest of all doublets, over the arcs of all points of the
/// maximal segment, in pixels.
pub fn rotation_px(motion: &RelativeMotion, lenses: &Lenses, ellipse: &Ellipse) -> f64 {
    let Some(rotation) = ResultingRotation::of(motion) else {
        return 0.0;
    };
    if motion.radius <= 0.0 {
        return 0.0;
    }
    let (from, to) = maximal_segment(ellipse);
    let length_px = (lenses.before * (to - from)).length();
    // `as` turns what is too large into the largest: it is cut off below.
    let points = (length_px.ceil() as u32)
        .saturating_add(1)
        .clamp(2, SEGMENT_POINTS_MOST);
    (0..points)
        .map(|i| {
            let part = f64::from(i) / f64::from(points - 1);
            let m1 = surface_point(motion.centre_before, motion.radius, ellipse, part);
            longest_doublet_px(motion, lenses, &rotation, m1)
        })
        .fold(0.0, larger)
}

/// The longest doublet of the arc around one point (II-5-3-3), in pixels; `m1`
/// as a direction from the sphere's centre.
pub fn longest_doublet_px(
    motion: &RelativeMotion,
    lenses: &Lenses,
    rotation: &ResultingRotation,
    m1: DVec3,
) -> f64 {
    let (c, r) = (motion.centre_before, motion.radius);
    let arc_centre = rotation.axis * rotation.axis.dot(m1);
    let u = m1 - arc_centre;
    let beside = rotation.axis.cross(m1);
    // As many arcs as the way is long in pixels, were it seen from the front.
    let scale = larger(lenses.before.x, lenses.before.y);
    let length_px = rotation.angle_rad * beside.length() * r * scale / (c.z + r * m1.z);
    let arcs = (length_px.ceil() as u32).clamp(1, ARCS_MOST);
    let (sin_step, cos_step) = (rotation.angle_rad / f64::from(arcs)).sin_cos();
    let (s, k) = (rotation.sin_half, rotation.cos_half);
    // From −γ: (cos, sin) of ε, by incremental rotation.
    let (mut cos, mut sin) = ((k - s) * (k + s), -2.0 * s * k);
    let mut longest = 0.0;
    for _ in 0..=arcs {
        let w = arc_centre + u * cos + beside * sin;
        // ε and ε + γ are 2·sin(γ/2) apart, across their middle ε + γ/2.
        let (cos_middle, sin_middle) = (cos * k - sin * s, sin * k + cos * s);
        let step = (beside * cos_middle - u * sin_middle) * (2.0 * s * r);
        let p = c + w * r;
        let x = p.truncate() / p.z;
        let moved = (step.truncate() - x * step.z) / (p.z + step.z);
        longest = larger(longest, (lenses.before * moved).length());
        (cos, sin) = (
            cos * cos_step - sin * sin_step,
            sin * cos_step + cos * sin_step,
        );
    }
    longest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::project_sphere;
    use glam::DQuat;

    fn motion(c: DVec3, radius: f64, axis: DVec3, angle: f64) -> RelativeMotion {
        let half = axis.normalize() * (angle * 0.5).sin();
        RelativeMotion::in_camera_space(c, DVec3::ZERO, half, radius)
    }

    #[test]
    fn points_of_the_segment_are_on_the_sphere_before_it_and_seen_where_they_should_be() {
        for (c, r) in [
            (DVec3::new(1.0, -2.0, 5.0), 1.5),
            (DVec3::new(1.0, -2.0, 5.0), 1e-9),
            (DVec3::Z * 3.0, 2.9),
        ] {
            let e = *project_sphere(c, r).ellipse().unwrap();
            let (from, to) = maximal_segment(&e);
            for i in 0..=10 {
                let part = f64::from(i) / 10.0;
                let u = surface_point(c, r, &e, part);
                assert!((u.length() - 1.0).abs() < 1e-7, "{u}");
                let p = c + u * r;
                let seen = p.truncate() / p.z;
                let expected = from.lerp(to, part);
                assert!(
                    (seen - expected).length() < 1e-7 * e.semi_major + 1e-15,
                    "{seen} {expected}"
                );
                // On the near side: its ray leaves it towards the observer.
                assert!(u.dot(p) < 1e-6, "{}", u.dot(p));
            }
        }
    }

    #[test]
    fn the_arc_is_the_one_through_three_points() {
        let axis = DVec3::new(0.2, 0.5, -0.7).normalize();
        let q = DQuat::from_axis_angle(axis, 0.3);
        let m1 = DVec3::new(0.6, 0.0, 0.8);
        let centre = arc_centre_by_three_points(m1, q * m1, q * (q * m1)).unwrap();
        assert!((centre - axis * axis.dot(m1)).length() < 1e-14);
        // No rotation and half a turn have no plane.
        assert_eq!(arc_centre_by_three_points(m1, m1, m1), None);
        assert_eq!(arc_centre_by_three_points(m1, -m1, m1), None);
    }

    #[test]
    fn facing_the_observer_a_small_rotation_moves_the_nearest_point() {
        let lenses = Lenses::fixed(DVec2::splat(1000.0));
        for angle in [1e-15, 1e-12, 1e-6, 1e-3] {
            let m = motion(DVec3::Z * 10.0, 1.0, DVec3::Y, angle);
            let e = *project_sphere(m.centre_before, 1.0).ellipse().unwrap();
            let px = rotation_px(&m, &lenses, &e);
            let expected = 1000.0 * angle / 9.0;
            assert!(
                (px / expected - 1.0).abs() < 1e-3,
                "{angle}: {px} {expected}"
            );
        }
    }

    #[test]
    fn half_a_turn_and_no_turn_have_a_measure() {
        let lenses = Lenses::fixed(DVec2::splat(1000.0));
        let c = DVec3::new(1.0, 0.0, 10.0);
        let e = *project_sphere(c, 1.0).ellipse().unwrap();
        let half = rotation_px(&motion(c, 1.0, DVec3::Z, std::f64::consts::PI), &lenses, &e);
        assert!(half > 190.0 && half < 220.0, "{half}");
        assert_eq!(
            rotation_px(&motion(c, 1.0, DVec3::Z, 0.0), &lenses, &e),
            0.0
        );
        assert_eq!(
            rotation_px(&motion(c, 0.0, DVec3::Z, 1.0), &lenses, &e),
            0.0
        );
    }
}

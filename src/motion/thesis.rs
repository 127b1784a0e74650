//! The thesis's own measure of motion (chapter II): translations by the four
//! vertices of the ellipse (II-4), rotations by the points of the maximal
//! segment and their arcs (II-5, in [`thesis_rotation`](super::thesis_rotation)).
//!
//! It follows points that are expected to move farthest, and adds nothing for
//! the others: usually tighter than [`bound_px`](super::bound_px), but no
//! bound. The default measure is therefore the bound.
//!
//! Near the view's axis the ellipse is all but a circle, and the smallest motion
//! turns its axes: there the vertices move farther than any point does.
//!
//! # Operations
//! II-6 counts triples: sums and products, divisions, roots and trigonometry.
//! For M points of the maximal segment and N arcs:
//!
//! | | thesis, II-6 | here |
//! |---|---|---|
//! | one ellipse | (170, 7, 4) | (4, 10, 3) |
//! | two ellipses and their four vertices | | (71, 20, 10) |
//! | resulting rotation, maximal segment | | (21, 6, 4) |
//! | each of the M points | (134 + 43·N, 11, 11) | (144 + 54·N, 18 + 4·N, 6 + N) |
//! | the bound, in all | | about (450, 33, 31) |
//!
//! The thesis finds the rotation anew at every point; here it is known once for
//! the object. The divisions of a projection and the root of a length are
//! counted for every arc.

use super::ellipse::{Ellipse, Projection, project_sphere};
use super::relative::{Lenses, RelativeMotion};
use super::thesis_rotation::rotation_px;
use glam::{DVec2, DVec3};

/// The motion in pixels, by its two causes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThesisMeasure {
    /// II-4-3: how far the vertices of the ellipse move.
    pub translation_px: f64,
    /// II-5-3-4: how far the rotation moves the points of the maximal segment.
    pub rotation_px: f64,
}

impl ThesisMeasure {
    /// II-7: the motion is the larger of both.
    pub fn motion_px(&self) -> f64 {
        self.translation_px.max(self.rotation_px)
    }
}

/// The measure of chapter II; `None` where the picture of the sphere is no
/// ellipse at one of the instants (II-3: nothing can be said of a hyperbola),
/// or a number is not finite.
pub fn thesis(motion: &RelativeMotion, lenses: &Lenses) -> Option<ThesisMeasure> {
    let before = project_sphere(motion.centre_before, motion.radius);
    let after = project_sphere(motion.centre_after, motion.radius);
    let (Projection::Ellipse(before), Projection::Ellipse(after)) = (before, after) else {
        return None;
    };
    if !motion.half_turn.is_finite() {
        return None;
    }
    let measure = ThesisMeasure {
        translation_px: translation_px(&before, &after, lenses),
        rotation_px: rotation_px(motion, lenses, &before),
    };
    (measure.translation_px.is_finite() && measure.rotation_px.is_finite()).then_some(measure)
}

/// II-7 as one number of pixels, +∞ where there is none.
pub fn thesis_px(motion: &RelativeMotion, lenses: &Lenses) -> f64 {
    thesis(motion, lenses).map_or(f64::INFINITY, |measure| measure.motion_px())
}

/// II-4-3: "the displacement in translation of the ellipse is the maximum of the
/// displacements of these points", the four vertices.
///
/// The ends of an axis have no names: they are paired so that the axes turn as
/// little as they can, and a circle on the axis, which has none, takes the
/// other's.
pub fn translation_px(before: &Ellipse, after: &Ellipse, lenses: &Lenses) -> f64 {
    let mut before = *before;
    let mut after = *after;
    if before.centre == DVec2::ZERO {
        before.direction = after.direction;
    } else if after.centre == DVec2::ZERO {
        after.direction = before.direction;
    }
    if before.direction.dot(after.direction) < 0.0 {
        after.direction = -after.direction;
    }
    let moved = |(a, b): (&DVec2, &DVec2)| (lenses.after * *b - lenses.before * *a).length();
    before
        .vertices()
        .iter()
        .zip(&after.vertices())
        .map(moved)
        .fold(0.0, larger)
}

/// The larger one; NaN is not passed over.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// II-4-2-1: the foci, where the two spheres of Dandelin that lie in the cone
/// touch the picture: the feet of OM₁ = OS/(A + B) and OM₂ = OS/(A − B) with A
/// = c_z, B = R and the picture at 1. In tangents.
pub fn foci(centre_camera: DVec3, radius: f64) -> [DVec2; 2] {
    let image = centre_camera.truncate();
    [
        image / (centre_camera.z + radius),
        image / (centre_camera.z - radius),
    ]
}

/// II-4-2-2 as it is printed: the semi-axes from the foci, by two second-degree
/// equations. `None` where they are 0/0: on the axis.
///
/// Kept to compare: its semi-major axis is off by 1e-10 of itself at R/D =
/// 1e-3, and by all of itself at 1e-8. [`project_sphere`] is used everywhere.
pub fn semi_axes_by_foci(centre_camera: DVec3, radius: f64) -> Option<(f64, f64)> {
    let os = centre_camera;
    let [f1, f2] = foci(centre_camera, radius);
    let oe = ((f1 + f2) * 0.5).extend(1.0);
    let k2 = os.length_squared() - radius * radius;
    let above = k2 * oe.length_squared() - oe.dot(os).powi(2);
    let semi_axis = |v: DVec3| {
        let squared = above / (v.dot(os).powi(2) - k2 * v.length_squared());
        (squared > 0.0 && squared.is_finite()).then(|| squared.sqrt() * v.length())
    };
    let f1f2 = (f2 - f1).extend(0.0);
    Some((semi_axis(f1f2)?, semi_axis(f1f2.cross(DVec3::Z))?))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ellipse(c: DVec3, r: f64) -> Ellipse {
        *project_sphere(c, r).ellipse().unwrap()
    }

    #[test]
    fn the_foci_give_the_same_ellipse_where_they_have_digits() {
        let c = DVec3::new(2.0, -1.0, 6.0);
        let e = ellipse(c, 2.0);
        let (a, b) = semi_axes_by_foci(c, 2.0).unwrap();
        assert!((a / e.semi_major - 1.0).abs() < 1e-13, "{a} {e:?}");
        assert!((b / e.semi_minor - 1.0).abs() < 1e-13, "{b} {e:?}");
        let [f1, f2] = foci(c, 2.0);
        assert!(((f1 + f2) * 0.5 - e.centre).length() < 1e-15);
        let half = (e.semi_major.powi(2) - e.semi_minor.powi(2)).sqrt();
        assert!(((f2 - f1).length() * 0.5 - half).abs() < 1e-14);
    }

    #[test]
    fn the_foci_lose_their_digits_and_break_down_on_the_axis() {
        assert_eq!(semi_axes_by_foci(DVec3::Z * 5.0, 1.0), None);
        let direction = DVec3::new(0.3, 0.2, 0.9).normalize();
        for exponent in [3, 5, 7, 8] {
            let radius = 10f64.powi(-exponent);
            // The worst of neighbours: one place may be lucky.
            let worst = (0..50).map(|i| {
                let c = direction * (1.0 + 1e-3 * f64::from(i));
                let found = semi_axes_by_foci(c, radius).map_or(0.0, |(a, _)| a);
                (found / ellipse(c, radius).semi_major - 1.0).abs()
            });
            let worst = worst.fold(0.0, f64::max);
            println!("R/D = 1e-{exponent}: semi-major axis by its foci off by {worst:.1e}");
            assert!(worst > 1e-17 * 100f64.powi(exponent));
        }
    }

    #[test]
    fn a_sideways_step_moves_all_four_vertices_alike() {
        let lenses = Lenses::fixed(DVec2::splat(100.0));
        let small = 1e-6;
        let m = RelativeMotion::in_camera_space(DVec3::Z * 4.0, DVec3::X * 0.5, DVec3::ZERO, small);
        let measure = thesis(&m, &lenses).unwrap();
        assert!((measure.translation_px - 12.5).abs() < 1e-4, "{measure:?}");
        assert_eq!(measure.rotation_px, 0.0);
    }

    #[test]
    fn across_the_axis_nothing_turns_over() {
        let lenses = Lenses::fixed(DVec2::splat(100.0));
        let m = RelativeMotion::in_camera_space(
            DVec3::new(-1e-9, 0.0, 4.0),
            DVec3::X * 2e-9,
            DVec3::ZERO,
            1.0,
        );
        assert!(thesis_px(&m, &lenses) < 1e-6);
        let onto =
            RelativeMotion::in_camera_space(DVec3::Z * 4.0, DVec3::Y * 1e-9, DVec3::ZERO, 1.0);
        assert!(thesis_px(&onto, &lenses) < 1e-6);
    }
}

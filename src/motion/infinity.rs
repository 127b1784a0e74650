//! The motion of what is at infinity: the sky moves by the observer's rotation
//! alone.
//!
//! # Derivation
//! A direction d with d_z = 1 in the first camera's coordinates is seen at F₀·t,
//! t = d_xy. In the second's it is d + e, where e = (B₁ − B₀)·B₀ᵀ·d is not longer
//! than ‖B₁ − B₀‖·‖d‖. So its displacement is
//! ```text
//! v = F₁·(t + e_xy)/(1 + e_z) − F₀·t = (δF·t + F₁·e_xy − F₀·t·e_z)/(1 + e_z),
//! ‖v‖ ≤ (|δF|·‖t‖ + (F₁ + F₀·‖t‖)·‖e‖)/(1 − ‖e‖).
//! ```
//! In view, ‖t‖ is at most the picture's half diagonal. Directions that only the
//! second camera sees have the bound of the motion back. Where ‖e‖ ≥ 1 nothing
//! certain can be said.

use decor_api::{Camera, Size};

use super::relative::Lenses;

/// How far, in pixels, anything at infinity that either camera sees can move in
/// the picture; +∞ where nothing certain can be said. Never NaN; 0 where neither
/// the view's directions nor its opening change.
pub fn infinity_px(before: &Camera, after: &Camera, size: Size) -> f64 {
    let lenses = Lenses::between(before, after, size);
    let turned = (after.right - before.right).length_squared()
        + (after.up - before.up).length_squared()
        + (after.forward - before.forward).length_squared();
    // A camera's axes are rounded once each.
    let turned = if turned == 0.0 {
        0.0
    } else {
        turned.sqrt() + 4.0 * f64::EPSILON
    };
    if turned == 0.0
        && before.half_width == after.half_width
        && before.half_height == after.half_height
    {
        return 0.0;
    }
    let one_way = |camera: &Camera, lenses: &Lenses| {
        let tangent = camera.half_width.hypot(camera.half_height);
        let off = turned * tangent.hypot(1.0);
        let zoom = lenses.delta.abs().max_element() * tangent;
        let focal = (lenses.before.max_element(), lenses.after.max_element());
        let moved = (zoom + (focal.1 + focal.0 * tangent) * off) / (1.0 - off);
        // Also where it is not a number.
        if off < 1.0 && moved.is_finite() {
            moved * (1.0 + 1e-13)
        } else {
            f64::INFINITY
        }
    };
    one_way(before, &lenses).max(one_way(after, &lenses.reversed()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    const SIZE: Size = Size {
        width: 320,
        height: 200,
    };

    fn camera(aim: DVec3, angle: f64) -> Camera {
        Camera::look_at(DVec3::ZERO, aim, DVec3::Y, (angle, angle * 0.7)).unwrap()
    }

    #[test]
    fn a_walk_moves_nothing_at_infinity() {
        let here = camera(DVec3::new(0.3, 0.1, 1.0), 50.0);
        let there = Camera {
            eye: DVec3::new(4.0, 5.0, 6.0),
            ..here
        };
        assert_eq!(infinity_px(&here, &there, SIZE), 0.0);
    }

    #[test]
    fn a_turn_around_is_unbounded() {
        let here = camera(DVec3::Z, 50.0);
        assert_eq!(
            infinity_px(&here, &camera(DVec3::NEG_Z, 50.0), SIZE),
            f64::INFINITY
        );
        let broken = Camera {
            forward: DVec3::NAN,
            ..here
        };
        assert_eq!(infinity_px(&here, &broken, SIZE), f64::INFINITY);
    }

    proptest! {
        /// Directions of both views, projected: none moves farther than the bound,
        /// which is not far above the largest.
        #[test]
        fn no_direction_moves_farther(
            turn in prop::array::uniform2(-0.02_f64..0.02),
            zoom in prop_oneof![Just(1.0), 0.98_f64..1.02],
            angle in 5.0_f64..100.0,
        ) {
            let here = camera(DVec3::Z, angle);
            let there = camera(DVec3::new(turn[0], turn[1], 1.0), angle * zoom);
            let bound = infinity_px(&here, &there, SIZE);
            let mut largest = 0.0_f64;
            for (a, b) in [(&here, &there), (&there, &here)] {
                for y in 0..=10 {
                    for x in 0..=10 {
                        let at = (f64::from(x) * 32.0, f64::from(y) * 20.0);
                        // From the origin: the eye of both cameras.
                        let far = a.direction(SIZE, at.0, at.1);
                        let to = b.project(SIZE, far).unwrap();
                        let moved = (to.0 - at.0).hypot(to.1 - at.1);
                        largest = largest.max(moved);
                        prop_assert!(moved <= bound, "{} > {}", moved, bound);
                    }
                }
            }
            prop_assert!(bound <= 4.0 * largest + 1e-6, "{} of {}", bound, largest);
        }
    }
}

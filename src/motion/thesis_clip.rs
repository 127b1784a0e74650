//! The thesis's test for clipping (III-2-3), kept to compare, and the two ways to
//! test the same cone that do not wrap.
//!
//! The frustum is replaced by the cone around it, of half angle χ; the sphere
//! by the cone that touches it, of half angle δ; φ is the angle from the view
//! to the sphere's centre. It is out of the view where φ > δ + χ, all three in
//! [0, π]. Nothing here decides in this program: that is
//! [`Frustum::excludes`](super::clip::Frustum::excludes).
//!
//! | | divisions | roots, trigonometry |
//! |---|---|---|
//! | [`excluded_by_angles`] | 1 | 3 roots, 3 inverse functions |
//! | [`thesis_clip`] | 3 | 3 roots |
//! | [`excluded_by_cone`] | 1 | 2 roots |
//! | the frustum's planes | 0 | none |

use super::clip::Frustum;
use glam::DVec3;

/// tan χ of the cone around the frustum: √(tan²α + tan²β).
fn opening(frustum: &Frustum) -> f64 {
    frustum.half_width.hypot(frustum.half_height)
}

/// III-2-3 as it is printed, "outside if the tangent of ε = φ − (δ + χ) is
/// positive", but for its misprint of tan δ, which is R/√(D² − R²) (its EQ 1).
///
/// **Wrong where the tangent wraps**: ε below −90° counts as outside, and so an
/// object that fills the view is thrown away; ε above 90° counts as inside. It
/// was applied to the two ends of a motion only.
pub fn thesis_clip(frustum: &Frustum, centre_camera: DVec3, radius: f64) -> bool {
    let c = centre_camera;
    let tangent_squared = c.length_squared() - radius * radius;
    if tangent_squared <= 0.0 {
        return false;
    }
    let tan_delta = radius / tangent_squared.sqrt();
    let tan_chi = opening(frustum);
    let tan_phi = (c.x * c.x + c.y * c.y).sqrt() / c.z;
    let (minus, plus) = (1.0 - tan_delta * tan_chi, tan_delta + tan_chi);
    (tan_phi * minus - plus) / (minus + tan_phi * plus) > 0.0
}

/// The cone's test by its angles: φ > δ + χ.
pub fn excluded_by_angles(frustum: &Frustum, centre_camera: DVec3, radius: f64) -> bool {
    let c = centre_camera;
    let distance = c.length();
    if distance <= radius {
        return false;
    }
    let phi = c.truncate().length().atan2(c.z);
    phi > (radius / distance).asin() + opening(frustum).atan()
}

/// The same without an angle: the cosine falls over [0, π], so φ > δ + χ is
/// D·cos φ < D·cos(δ + χ), that is c_z < √(D² − R²)·cos χ − R·sin χ.
pub fn excluded_by_cone(frustum: &Frustum, centre_camera: DVec3, radius: f64) -> bool {
    let tangent_squared = centre_camera.length_squared() - radius * radius;
    if tangent_squared <= 0.0 {
        return false;
    }
    let tan_chi = opening(frustum);
    let cos_chi = 1.0 / 1f64.hypot(tan_chi);
    centre_camera.z < (tangent_squared.sqrt() - radius * tan_chi) * cos_chi
}

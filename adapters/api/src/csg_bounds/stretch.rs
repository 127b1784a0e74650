//! How a linear map stretches balls.

use glam::{DMat3, DVec3};

/// How far the image of the unit ball reaches along each axis.
pub(super) fn row_lengths(m: DMat3) -> DVec3 {
    let t = m.transpose();
    DVec3::new(t.x_axis.length(), t.y_axis.length(), t.z_axis.length())
}

/// By how much the map lengthens a vector at most, rounded outwards.
pub(super) fn largest_stretch(m: DMat3) -> f64 {
    let scale = row_lengths(m).max_element();
    if scale == 0.0 || !scale.is_finite() {
        return scale;
    }
    // The largest eigenvalue of the symmetric matrix MᵀM, by the cosine formula
    // (Smith 1961, "Eigenvalues of a symmetric 3 × 3 matrix").
    let m = m * scale.recip();
    let a = m.transpose() * m;
    let off = a.y_axis.x.powi(2) + a.z_axis.x.powi(2) + a.z_axis.y.powi(2);
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let diagonal = DVec3::new(a.x_axis.x, a.y_axis.y, a.z_axis.z) - mean;
    let spread = ((diagonal.length_squared() + 2.0 * off) / 6.0).sqrt();
    let largest = if spread == 0.0 {
        mean
    } else {
        let half_det = (a - DMat3::from_diagonal(DVec3::splat(mean))).determinant() / 2.0;
        let angle = (half_det / spread.powi(3)).clamp(-1.0, 1.0).acos() / 3.0;
        mean + 2.0 * spread * angle.cos()
    };
    // Near a double eigenvalue the cosine loses half of the digits.
    let frobenius = a.x_axis.x + a.y_axis.y + a.z_axis.z;
    scale
        * (largest * (1.0 + 1e-7))
            .min(frobenius * (1.0 + 1e-14))
            .sqrt()
}

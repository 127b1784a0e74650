//! The perspective camera, with nothing left to a renderer's defaults.

use glam::DVec3;

use crate::layer::Size;

/// Why a camera cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CameraError {
    /// Eye and aim are one point.
    #[error("the eye and the aim are the same point")]
    EyeIsAim,
    /// The up direction is parallel to the view, or has no length.
    #[error("the up direction is parallel to the view")]
    UpAlongView,
    /// An opening angle is outside (0°, 180°).
    #[error("an opening angle must be between 0 and 180 degrees, both excluded")]
    Angle,
    /// A number is not finite.
    #[error("a number of the camera is not finite")]
    NotFinite,
}

/// A perspective camera. `right`, `up` and `forward` are orthonormal and
/// left-handed: `right = up × forward`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The observer's position.
    pub eye: DVec3,
    /// The direction of the view, of length 1.
    pub forward: DVec3,
    /// To the right in the picture, of length 1.
    pub right: DVec3,
    /// Upwards in the picture, of length 1.
    pub up: DVec3,
    /// tan(A/2), A the full horizontal opening angle.
    pub half_width: f64,
    /// tan(B/2), B the full vertical opening angle.
    pub half_height: f64,
}

impl Camera {
    /// A camera at `eye` that looks at `aim`. The angles are the full opening
    /// angles, horizontal and vertical, in degrees.
    ///
    /// # Errors
    /// Where no such camera exists; see [`CameraError`].
    pub fn look_at(
        eye: DVec3,
        aim: DVec3,
        up: DVec3,
        angles_deg: (f64, f64),
    ) -> Result<Self, CameraError> {
        let finite = eye.is_finite() && aim.is_finite() && up.is_finite();
        if !finite || !angles_deg.0.is_finite() || !angles_deg.1.is_finite() {
            return Err(CameraError::NotFinite);
        }
        let open = |angle: f64| angle > 0.0 && angle < 180.0;
        if !open(angles_deg.0) || !open(angles_deg.1) {
            return Err(CameraError::Angle);
        }
        let forward = unit(aim - eye).ok_or(CameraError::EyeIsAim)?;
        let up_unit = unit(up).ok_or(CameraError::UpAlongView)?;
        let side = up_unit.cross(forward);
        // Below this sine the sideways direction is rounding noise.
        if side.length() < 1e-12 {
            return Err(CameraError::UpAlongView);
        }
        let right = side.normalize();
        Ok(Self {
            eye,
            forward,
            right,
            up: forward.cross(right),
            half_width: (angles_deg.0.to_radians() * 0.5).tan(),
            half_height: (angles_deg.1.to_radians() * 0.5).tan(),
        })
    }

    /// The direction of the ray through the picture's point (x, y), in pixels
    /// from the upper left; (i + ½, j + ½) is the centre of pixel (i, j). Its
    /// component along `forward` is 1.
    pub fn direction(&self, size: Size, x: f64, y: f64) -> DVec3 {
        let right = 2.0 * self.half_width * (x / f64::from(size.width) - 0.5);
        let up = 2.0 * self.half_height * (0.5 - y / f64::from(size.height));
        self.forward + self.right * right + self.up * up
    }

    /// Focal lengths in pixels, horizontal and vertical.
    pub fn focal(&self, size: Size) -> (f64, f64) {
        (
            f64::from(size.width) / (2.0 * self.half_width),
            f64::from(size.height) / (2.0 * self.half_height),
        )
    }

    /// `point` in camera space: right, up, forward.
    pub fn to_camera(&self, point: DVec3) -> DVec3 {
        let p = point - self.eye;
        DVec3::new(self.right.dot(p), self.up.dot(p), self.forward.dot(p))
    }

    /// Where `point` is seen, in pixels from the upper left; `None` where it is
    /// not in front of the observer.
    pub fn project(&self, size: Size, point: DVec3) -> Option<(f64, f64)> {
        let p = self.to_camera(point);
        if p.z <= 0.0 {
            return None;
        }
        let (fx, fy) = self.focal(size);
        Some((
            f64::from(size.width) * 0.5 + fx * p.x / p.z,
            f64::from(size.height) * 0.5 - fy * p.y / p.z,
        ))
    }
}

/// `v` at length 1, also where its square over- or underflows.
fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    if largest == 0.0 || !largest.is_finite() {
        return None;
    }
    Some((v / largest).normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 320,
        height: 240,
    };

    #[test]
    fn the_default_view_is_left_handed() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (90.0, 90.0)).unwrap();
        assert!((camera.right - DVec3::X).length() < 1e-15);
        assert!((camera.up - DVec3::Y).length() < 1e-15);
    }

    #[test]
    fn a_projected_point_lies_on_its_ray() {
        let camera = Camera::look_at(
            DVec3::new(1.0, 2.0, -3.0),
            DVec3::ZERO,
            DVec3::Y,
            (60.0, 45.0),
        )
        .unwrap();
        let point = DVec3::new(0.3, -0.2, 0.7);
        let (x, y) = camera.project(SIZE, point).unwrap();
        let ray = camera.direction(SIZE, x, y);
        let off = ray.cross(point - camera.eye).length();
        assert!(off < 1e-12, "{off}");
    }

    #[test]
    fn tiny_and_huge_distances_still_aim() {
        for scale in [1e-300, 1e-12, 1e150, 1e300] {
            let camera =
                Camera::look_at(DVec3::ZERO, DVec3::Z * scale, DVec3::Y, (90.0, 90.0)).unwrap();
            assert!((camera.forward - DVec3::Z).length() < 1e-15);
        }
    }

    #[test]
    fn what_cannot_be_is_an_error() {
        let view = |eye, aim, up, angles| Camera::look_at(eye, aim, up, angles).unwrap_err();
        let (o, y, z) = (DVec3::ZERO, DVec3::Y, DVec3::Z);
        assert_eq!(view(o, o, y, (90.0, 90.0)), CameraError::EyeIsAim);
        assert_eq!(view(o, y, y, (90.0, 90.0)), CameraError::UpAlongView);
        assert_eq!(view(o, z, o, (90.0, 90.0)), CameraError::UpAlongView);
        assert_eq!(view(o, z, y, (180.0, 90.0)), CameraError::Angle);
        assert_eq!(view(o, z, y, (90.0, 0.0)), CameraError::Angle);
        assert_eq!(view(o, DVec3::NAN, y, (90.0, 90.0)), CameraError::NotFinite);
    }
}

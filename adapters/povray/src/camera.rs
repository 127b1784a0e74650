//! The camera in POV-Ray's words, and the crop camera: a window of the picture
//! seen by a camera of its own, ray for ray the same.
//!
//! Identity comes from arithmetic. The direction of the view and the step from
//! pixel to pixel are rounded to multiples of one small power of two, small
//! enough to be invisible (below 1e-7 pixel for usual openings), large enough
//! that every sum `direction + i·right + j·up` over the picture is exact in
//! double precision. Then the ray of a pixel does not depend on where a picture
//! begins, provided that POV-Ray's own `x / width` is exact: a crop is padded
//! to a power of two in width and height, and cut by `+EC` and `+ER`.

use decor_api::{Camera, Size, Window};
use glam::DVec3;

use crate::number::vector;

/// Bits that the rounded vectors may use, below the largest sum.
const BITS: i32 = 50;

/// A picture's rays: through the centre of pixel (i, j) goes
/// `forward + (i + ½ − W/2)·step_right + (H/2 − ½ − j)·step_up`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    eye: DVec3,
    forward: DVec3,
    step_right: DVec3,
    step_up: DVec3,
    size: Size,
}

impl Raster {
    /// The rays of `camera` over a picture of `size`.
    pub fn new(camera: &Camera, size: Size) -> Self {
        let largest = 1.0 + camera.half_width + camera.half_height;
        let grain = 2.0_f64.powi(largest.log2().ceil() as i32 - BITS);
        let snap = |v: DVec3| (v / grain).round() * grain;
        let step = |v: DVec3, half: f64, pixels: u32| v * (2.0 * half / f64::from(pixels));
        Self {
            eye: camera.eye,
            forward: snap(camera.forward),
            step_right: snap(step(camera.right, camera.half_width, size.width)),
            step_up: snap(step(camera.up, camera.half_height, size.height)),
            size,
        }
    }

    /// The camera of the whole picture.
    pub fn full(&self) -> String {
        self.camera(
            self.forward,
            self.step_right * f64::from(self.size.width),
            self.step_up * f64::from(self.size.height),
        )
    }

    /// The camera of a picture of `padded` pixels whose upper left pixel is the
    /// upper left pixel of `window`.
    pub fn crop(&self, window: Window, padded: Size) -> String {
        let half = |pixels: u32| f64::from(pixels) * 0.5;
        let x = f64::from(window.x) + half(padded.width) - half(self.size.width);
        let y = half(self.size.height) - f64::from(window.y) - half(padded.height);
        self.camera(
            self.forward + self.step_right * x + self.step_up * y,
            self.step_right * f64::from(padded.width),
            self.step_up * f64::from(padded.height),
        )
    }

    fn camera(&self, direction: DVec3, right: DVec3, up: DVec3) -> String {
        format!(
            "camera {{ perspective location {} direction {} right {} up {} }}\n",
            vector(self.eye),
            vector(direction),
            vector(right),
            vector(up)
        )
    }
}

/// The size of the crop picture for windows of up to so many pixels.
pub fn padded(width: u32, height: u32) -> Size {
    // A block is 32 pixels wide: smaller pictures win nothing.
    let pad = |pixels: u32| pixels.max(32).next_power_of_two();
    Size {
        width: pad(width),
        height: pad(height),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Exactly: is every partial sum of a ray the rounded one?
    fn exact_sum(terms: &[f64]) -> bool {
        // Knuth's two-sum leaves the rounding error; exact sums leave none.
        let mut sum = 0.0;
        for &t in terms {
            let next: f64 = sum + t;
            let tail = next - sum;
            let error = (sum - (next - tail)) + (t - tail);
            if error != 0.0 {
                return false;
            }
            sum = next;
        }
        true
    }

    proptest! {
        #[test]
        fn rays_of_power_of_two_pictures_are_sums_without_rounding(
            eye in (-10.0..10.0, -10.0..10.0, -10.0..10.0),
            aim in (-10.0..10.0, 20.0..30.0, -10.0..10.0),
            angle in 1.0..170.0_f64,
            bits in (5_u32..12, 5_u32..12),
            at in (0.0..1.0_f64, 0.0..1.0_f64),
        ) {
            let size = Size { width: 1 << bits.0, height: 1 << bits.1 };
            let camera = Camera::look_at(eye.into(), aim.into(), DVec3::Z, (angle, angle)).unwrap();
            let raster = Raster::new(&camera, size);
            let i = (at.0 * f64::from(size.width)).floor();
            let j = (at.1 * f64::from(size.height)).floor();
            for axis in 0..3 {
                let right = raster.step_right[axis] * f64::from(size.width);
                let up = raster.step_up[axis] * f64::from(size.height);
                let x0 = (i + 0.5) / f64::from(size.width) - 0.5;
                let y0 = 0.5 - (j + 0.5) / f64::from(size.height);
                // The products are exact when fused and plain agree.
                prop_assert_eq!(x0.mul_add(right, -(x0 * right)), 0.0);
                prop_assert_eq!(y0.mul_add(up, -(y0 * up)), 0.0);
                prop_assert!(exact_sum(&[raster.forward[axis], x0 * right, y0 * up]));
            }
        }
    }

    #[test]
    fn rounding_moves_no_pixel() {
        let size = Size {
            width: 4096,
            height: 4096,
        };
        for angle in [0.001, 1.0, 60.0, 179.9] {
            let camera = Camera::look_at(
                DVec3::ZERO,
                DVec3::new(1.0, 2.0, 3.0),
                DVec3::Y,
                (angle, angle),
            )
            .unwrap();
            let raster = Raster::new(&camera, size);
            let corner = raster.forward + raster.step_right * 2048.0 + raster.step_up * 2048.0;
            let off = (corner - camera.direction(size, 4096.0, 0.0)).length();
            let pixels = off / raster.step_right.length();
            assert!(
                pixels < if angle < 60.0 { 0.01 } else { 1e-7 },
                "{angle}: {pixels}"
            );
        }
    }
}

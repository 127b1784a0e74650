//! How many pixels of a picture show an object: an estimate, from the ellipses
//! of the bounding spheres.
//!
//! A pixel of an object costs more than one of the background, and a fast
//! layer's windows are fuller than a sky. What counts is only that twice the
//! estimate is twice the pixels: the cost of a covered pixel is measured by the
//! same estimate. It is kept by block of 32 × 32 pixels, the grid of all windows.

use decor_api::{Bounds, Camera, Size, Window};

use crate::motion::{Projection, Screen, project_sphere, screen_box};
use crate::plan::blocks::BLOCK;

/// Per block, the areas of all objects in it, as a share of its own.
#[derive(Clone, Debug)]
pub struct Coverage {
    size: Size,
    columns: u32,
    shares: Vec<f64>,
}

impl Coverage {
    /// Nothing is seen.
    pub fn none(size: Size) -> Self {
        let columns = size.width.div_ceil(BLOCK);
        let rows = size.height.div_ceil(BLOCK);
        Self {
            size,
            columns,
            shares: vec![0.0; columns as usize * rows as usize],
        }
    }

    /// Adds an object with these bounds (in the world). Is it in view?
    pub fn add(&mut self, bounds: &Bounds, camera: &Camera) -> bool {
        let window = screen_box(bounds, camera, self.size).window();
        if window.is_empty() {
            return false;
        }
        let filled = filled(bounds, camera, self.size);
        for row in window.y / BLOCK..window.bottom().div_ceil(BLOCK) {
            for column in window.x / BLOCK..window.right().div_ceil(BLOCK) {
                let block = self.block(column, row);
                let share = window.intersection(block).pixels() as f64 / block.pixels() as f64;
                self.shares[(row * self.columns + column) as usize] += filled * share;
            }
        }
        true
    }

    /// Pixels of a window that show something. Objects lie before each other by
    /// chance: of a block with a share s of areas, 1 − e^(−s) is covered.
    pub fn of(&self, window: Window) -> f64 {
        if window.is_empty() {
            return 0.0;
        }
        let mut covered = 0.0;
        for row in window.y / BLOCK..window.bottom().div_ceil(BLOCK) {
            for column in window.x / BLOCK..window.right().div_ceil(BLOCK) {
                let pixels = window.intersection(self.block(column, row)).pixels();
                covered += pixels as f64 * self.share(row * self.columns + column);
            }
        }
        covered
    }

    /// The share of a block that shows something, by its number.
    pub fn share(&self, block: u32) -> f64 {
        let areas = self.shares.get(block as usize).copied().unwrap_or(0.0);
        1.0 - (-areas).exp()
    }

    /// The rectangle of a block, cut at the picture.
    fn block(&self, column: u32, row: u32) -> Window {
        let block = Window {
            x: column * BLOCK,
            y: row * BLOCK,
            width: BLOCK,
            height: BLOCK,
        };
        block.intersection(self.size.window())
    }
}

/// How much of an object's window its ellipse fills. The window is wider than
/// the box around the ellipse by the pixels that it is rounded to.
fn filled(bounds: &Bounds, camera: &Camera, size: Size) -> f64 {
    let Bounds::Sphere(sphere) = bounds else {
        // Without an end: a ground, a sky of its own. Surely most of it is seen.
        return 3.0;
    };
    match project_sphere(camera.to_camera(sphere.centre), sphere.radius) {
        Projection::Ellipse(ellipse) => {
            let screen = Screen::of(camera, size);
            let (low, high) = screen.box_px(&ellipse);
            let window = (high.x - low.x + 3.0) * (high.y - low.y + 3.0);
            let filled = screen.area_px(&ellipse) / window;
            if filled.is_finite() {
                filled.clamp(0.0, 1.0)
            } else {
                1.0
            }
        }
        Projection::Unbounded => 1.0,
        Projection::Behind => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    const SIZE: Size = Size {
        width: 200,
        height: 100,
    };

    fn camera() -> Camera {
        Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 32.2)).unwrap()
    }

    fn ball(x: f64, z: f64, radius: f64) -> Bounds {
        Bounds::sphere(DVec3::new(x, 0.0, z), radius)
    }

    #[test]
    fn a_small_disc_covers_its_area() {
        let mut coverage = Coverage::none(SIZE);
        assert!(coverage.add(&ball(0.0, 100.0, 3.0), &camera()));
        // Focal length 173 pixels: a disc of radius 5.2.
        let pixels = coverage.of(SIZE.window());
        assert!((pixels - 85.0).abs() < 12.0, "{pixels}");
        assert!(!coverage.add(&ball(0.0, -100.0, 3.0), &camera()));
        assert!(coverage.of(SIZE.window()) == pixels);
    }

    #[test]
    fn many_discs_never_cover_more_than_there_is() {
        let mut coverage = Coverage::none(SIZE);
        let mut before = 0.0;
        for k in 0..50 {
            coverage.add(&ball(f64::from(k % 7) - 3.0, 12.0, 3.0), &camera());
            let now = coverage.of(SIZE.window());
            assert!(now > before && now <= SIZE.pixels() as f64, "{now}");
            before = now;
        }
        let left = Window {
            width: 96,
            ..SIZE.window()
        };
        let right = Window {
            x: 96,
            width: 104,
            ..SIZE.window()
        };
        let both = coverage.of(left) + coverage.of(right);
        assert!((both - before).abs() < 1e-6);
    }

    #[test]
    fn what_has_no_end_is_nearly_everywhere() {
        let mut coverage = Coverage::none(SIZE);
        coverage.add(&Bounds::Unbounded, &camera());
        assert!(coverage.of(SIZE.window()) > 0.9 * SIZE.pixels() as f64);
        assert!(coverage.of(Window::EMPTY) == 0.0);
    }
}

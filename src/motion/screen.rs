//! The pixels that a sphere can be seen in.
//!
//! In the plane of one picture axis and the view's axis, a sphere is a disc at
//! (c, z) of radius R. It spans the directions atan2(c, z) ± asin(R / √(c²+z²)),
//! whose tangents are the ends of its interval in the picture. The intervals of
//! the two axes make a box that contains the ellipse, and needs neither its
//! axes nor a case for the conic that it really is.

use decor_api::{Bounds, Camera, Size, Window};

/// Where something can be seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScreenBox {
    /// Nowhere in the picture.
    Outside,
    /// Only in these pixels.
    Inside(Window),
}

impl ScreenBox {
    /// The pixels, none where it is outside.
    pub fn window(self) -> Window {
        match self {
            Self::Outside => Window::EMPTY,
            Self::Inside(window) => window,
        }
    }
}

/// The pixels of a picture of `size` in which an object with these bounds (in
/// the world) can be seen: conservative, and a pixel wider on each side than
/// the box, for what rounding and an antialiased neighbour may add.
pub fn screen_box(bounds: &Bounds, camera: &Camera, size: Size) -> ScreenBox {
    let sphere = match bounds {
        Bounds::Empty => return ScreenBox::Outside,
        Bounds::Unbounded => return ScreenBox::Inside(size.window()),
        Bounds::Sphere(sphere) => sphere,
    };
    let centre = camera.to_camera(sphere.centre);
    // Rounding of the coordinates above is a share of what was subtracted.
    let scale = sphere.centre.abs().max_element() + camera.eye.abs().max_element();
    let radius = sphere.radius * (1.0 + 1e-12) + scale * 1e-14;
    if !centre.is_finite() || !radius.is_finite() {
        return ScreenBox::Inside(size.window());
    }
    let (fx, fy) = camera.focal(size);
    let (half_w, half_h) = (f64::from(size.width) * 0.5, f64::from(size.height) * 0.5);
    let Some((left, right)) = tangents(centre.x, centre.z, radius) else {
        return ScreenBox::Outside;
    };
    let Some((down, up)) = tangents(centre.y, centre.z, radius) else {
        return ScreenBox::Outside;
    };
    let x = pixels(half_w + fx * left, half_w + fx * right, size.width);
    let y = pixels(half_h - fy * up, half_h - fy * down, size.height);
    match (x, y) {
        (Some((x0, x1)), Some((y0, y1))) => ScreenBox::Inside(Window {
            x: x0,
            y: y0,
            width: x1 - x0,
            height: y1 - y0,
        }),
        _ => ScreenBox::Outside,
    }
}

/// The interval of c/z over the part of the disc before the observer; `None`
/// where no part is. An end that no direction bounds is infinite.
fn tangents(c: f64, z: f64, radius: f64) -> Option<(f64, f64)> {
    use std::f64::consts::FRAC_PI_2;
    let distance = c.hypot(z);
    if distance <= radius {
        // The observer's axis is inside the disc: every direction.
        return Some((f64::NEG_INFINITY, f64::INFINITY));
    }
    let middle = c.atan2(z);
    let spread = (radius / distance).asin();
    let (low, high) = (middle - spread, middle + spread);
    if low >= FRAC_PI_2 || high <= -FRAC_PI_2 {
        return None;
    }
    let low = if low <= -FRAC_PI_2 {
        f64::NEG_INFINITY
    } else {
        low.tan()
    };
    let high = if high >= FRAC_PI_2 {
        f64::INFINITY
    } else {
        high.tan()
    };
    Some((low, high))
}

/// The pixels between two edges, and one more on each side, cut at the picture.
fn pixels(from: f64, to: f64, length: u32) -> Option<(u32, u32)> {
    let limit = f64::from(length);
    let (from, to) = (from.floor() - 1.0, to.ceil() + 1.0);
    if to <= 0.0 || from >= limit {
        return None;
    }
    // NaN cannot come here: the ends are numbers or infinite.
    Some((from.clamp(0.0, limit) as u32, to.clamp(0.0, limit) as u32))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    const SIZE: Size = Size {
        width: 200,
        height: 100,
    };

    fn camera(angle: f64) -> Camera {
        Camera::look_at(
            DVec3::new(1.0, 2.0, -3.0),
            DVec3::new(0.5, 0.0, 4.0),
            DVec3::Y,
            (angle, angle / 2.0),
        )
        .unwrap()
    }

    fn unit() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0)
            .prop_map(|(x, y, z)| DVec3::new(x, y, z))
            .prop_filter("a direction", |v| v.length() > 0.1)
            .prop_map(DVec3::normalize)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn no_point_of_the_sphere_is_seen_outside_of_the_box(
            centre in (-20.0..20.0, -20.0..20.0, -20.0..20.0),
            radius in 1e-6..15.0_f64,
            direction in unit(),
            angle in 1.0..170.0_f64,
        ) {
            let centre: DVec3 = centre.into();
            let camera = camera(angle);
            let window = screen_box(&Bounds::sphere(centre, radius), &camera, SIZE).window();
            if let Some((x, y)) = camera.project(SIZE, centre + direction * radius) {
                let seen = (0.0..200.0).contains(&x) && (0.0..100.0).contains(&y);
                if seen {
                    prop_assert!(window.contains(x as u32, y as u32), "({x}, {y}) of {window:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_behind_is_outside_and_what_surrounds_is_everywhere() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 30.0)).unwrap();
        let at = |z: f64, r: f64| screen_box(&Bounds::sphere(DVec3::Z * z, r), &camera, SIZE);
        assert_eq!(at(-5.0, 1.0), ScreenBox::Outside);
        assert_eq!(at(0.5, 1.0), ScreenBox::Inside(SIZE.window()));
        assert_eq!(
            screen_box(&Bounds::Unbounded, &camera, SIZE),
            ScreenBox::Inside(SIZE.window())
        );
        assert_eq!(
            screen_box(&Bounds::Empty, &camera, SIZE),
            ScreenBox::Outside
        );
    }

    #[test]
    fn a_small_sphere_has_a_small_box() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (90.0, 90.0)).unwrap();
        let size = Size {
            width: 100,
            height: 100,
        };
        let window = screen_box(&Bounds::sphere(DVec3::Z * 10.0, 1.0), &camera, size).window();
        // 10 pixels wide, half a pixel of perspective, a pixel on each side.
        assert!((12..=14).contains(&window.width), "{window:?}");
    }
}

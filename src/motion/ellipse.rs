//! The ellipse that a bounding sphere is in the picture.
//!
//! Thesis, II-3 and II-4-2: the picture of a sphere is where the picture's plane
//! cuts the cone that touches the sphere. The thesis builds it from its foci
//! (the "exposé belge"), which are 0/0 on the axis and lose their digits for
//! small spheres. Here the same ellipse in a form that keeps them.
//!
//! # Derivation
//! Camera space: x right, y up, z along the view; centre c, radius R, D = ‖c‖,
//! picture at z = 1. In the plane through the view's axis and c, the tangents
//! from the eye leave at the angles φ ± δ, with tan φ = ρ/c_z, ρ = ‖(c_x, c_y)‖
//! and sin δ = R/D. They meet the picture at tan(φ ± δ), the ends of the major
//! axis:
//! ```text
//! tan(φ ± δ) = (ρ·√(D²−R²) ± R·c_z) / (c_z·√(D²−R²) ∓ R·ρ)
//! ```
//! Multiplied above and below by c_z·√(D²−R²) ± R·ρ, the lower side becomes
//! D²·k with k = c_z² − R² and the upper one D²·(ρ·c_z ± R·√(D²−R²)). Half the
//! sum and half the difference are the centre and the semi-major axis; the
//! semi-minor axis follows from the foci of the thesis (F₁, F₂ = (c_x,
//! c_y)/(c_z ± R), half of whose distance is ρ·R/k):
//! ```text
//! centre = c_z·(c_x, c_y)/k     a = R·√(ρ² + k)/k     b = √(a² − (ρ·R/k)²) = R/√k
//! ```
//! D² − R² is written ρ² + k and k is (c_z − R)(c_z + R), so nothing cancels
//! but the one subtraction c_z − R, which is exact to the last place for the
//! numbers given. All is divided by c_z first: it neither over- nor underflows
//! with the unit of length.

use decor_api::{Camera, Size};
use glam::{DVec2, DVec3};

/// What a sphere is in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// No point of it lies before the observer (c_z ≤ −R).
    Behind,
    /// The picture reaches infinity, or is not certain: a parabola, a hyperbola,
    /// the observer inside, a number that is not finite.
    Unbounded,
    /// All of it lies before the observer (c_z > R).
    Ellipse(Ellipse),
}

impl Projection {
    /// The ellipse, where there is one.
    pub fn ellipse(&self) -> Option<&Ellipse> {
        match self {
            Self::Ellipse(ellipse) => Some(ellipse),
            _ => None,
        }
    }
}

/// An ellipse in the plane of the picture. Perspective: in units of the focal
/// length (tangents). Orthographic: in scene units. x right, y up, the origin
/// where the view's axis is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipse {
    /// Its centre; *not* the picture of the sphere's centre.
    pub centre: DVec2,
    /// Along the major axis, away from the picture's centre; of length 1. For
    /// a circle on the axis, where any will do, x.
    pub direction: DVec2,
    /// Half of the long axis.
    pub semi_major: f64,
    /// Half of the short axis.
    pub semi_minor: f64,
}

/// The picture of the sphere around `centre_camera` (camera space) under
/// perspective.
pub fn project_sphere(centre_camera: DVec3, radius: f64) -> Projection {
    let c = centre_camera;
    if !c.is_finite() || !radius.is_finite() || radius < 0.0 {
        return Projection::Unbounded;
    }
    if c.z <= -radius && (c.z, radius) != (0.0, 0.0) {
        return Projection::Behind;
    }
    if c.z <= radius {
        return Projection::Unbounded;
    }
    let image = c.truncate() / c.z;
    let (near, far) = ((c.z - radius) / c.z, radius / c.z + 1.0);
    let (r, k) = (radius / c.z, near * far);
    let rho = image.x.hypot(image.y);
    let ellipse = Ellipse {
        centre: image / k,
        direction: if rho > 0.0 { image / rho } else { DVec2::X },
        semi_major: r * rho.hypot(k.sqrt()) / k,
        semi_minor: r / k.sqrt(),
    };
    if ellipse.is_measurable() {
        Projection::Ellipse(ellipse)
    } else {
        Projection::Unbounded
    }
}

/// The picture of a sphere under parallel projection: a circle, wherever it is.
/// `None` where a number is not finite or the radius negative.
pub fn project_sphere_orthographic(centre_camera: DVec3, radius: f64) -> Option<Ellipse> {
    let circle = Ellipse {
        centre: centre_camera.truncate(),
        direction: DVec2::X,
        semi_major: radius,
        semi_minor: radius,
    };
    (circle.is_measurable() && radius >= 0.0).then_some(circle)
}

impl Ellipse {
    /// Finite, and its area and its place on a screen as well.
    fn is_measurable(&self) -> bool {
        const LARGEST: f64 = 1e140;
        let largest = self
            .centre
            .abs()
            .max_element()
            .max(self.semi_major)
            .max(self.semi_minor);
        let sum = self.centre.x + self.centre.y + self.semi_major + self.semi_minor;
        largest < LARGEST && sum.is_finite() && self.direction.is_finite()
    }

    /// The ends of its axes: the far and the near one of the major axis, then
    /// those of the minor axis.
    pub fn vertices(&self) -> [DVec2; 4] {
        let major = self.direction * self.semi_major;
        let minor = self.direction.perp() * self.semi_minor;
        [
            self.centre + major,
            self.centre - major,
            self.centre + minor,
            self.centre - minor,
        ]
    }

    /// Half the width and half the height of the box around it.
    pub fn half_extent(&self) -> DVec2 {
        let (major, minor) = (
            self.direction * self.semi_major,
            self.direction.perp() * self.semi_minor,
        );
        DVec2::new(major.x.hypot(minor.x), major.y.hypot(minor.y))
    }

    /// Its point at `angle_rad` from the far vertex, counted in the circle that
    /// it is a stretched picture of.
    pub fn point(&self, angle_rad: f64) -> DVec2 {
        let (sin, cos) = angle_rad.sin_cos();
        self.centre
            + self.direction * (self.semi_major * cos)
            + self.direction.perp() * (self.semi_minor * sin)
    }

    /// Its area, in its own units squared.
    pub fn area(&self) -> f64 {
        std::f64::consts::PI * self.semi_major * self.semi_minor
    }
}

/// From the plane of the picture to pixels, counted from the upper left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Screen {
    /// Pixels per unit, horizontally and vertically: the focal lengths, or under
    /// parallel projection pixels per scene unit.
    pub scale: DVec2,
    /// Where the view's axis is, in pixels.
    pub centre_px: DVec2,
}

impl Screen {
    /// The screen of a perspective camera.
    pub fn of(camera: &Camera, size: Size) -> Self {
        let half = DVec2::new(f64::from(size.width), f64::from(size.height)) * 0.5;
        Self {
            scale: camera.focal(size).into(),
            centre_px: half,
        }
    }

    /// The screen of a parallel projection that shows `width` scene units
    /// across and `height` downwards.
    pub fn orthographic(width: f64, height: f64, size: Size) -> Self {
        let pixels = DVec2::new(f64::from(size.width), f64::from(size.height));
        Self {
            scale: pixels / DVec2::new(width, height),
            centre_px: pixels * 0.5,
        }
    }

    /// A point of the picture's plane in pixels.
    pub fn to_px(&self, point: DVec2) -> DVec2 {
        self.centre_px + self.scale * DVec2::new(point.x, -point.y)
    }

    /// The vertices in pixels. Where pixels are not square, these are the ends
    /// of two conjugate diameters of the ellipse on the screen.
    pub fn vertices_px(&self, ellipse: &Ellipse) -> [DVec2; 4] {
        ellipse.vertices().map(|vertex| self.to_px(vertex))
    }

    /// The box around the ellipse, in pixels: its upper left and lower right.
    /// Not cut at the picture.
    pub fn box_px(&self, ellipse: &Ellipse) -> (DVec2, DVec2) {
        let (centre, half) = (
            self.to_px(ellipse.centre),
            self.scale * ellipse.half_extent(),
        );
        (centre - half, centre + half)
    }

    /// The ellipse's area on the screen, in pixels; not cut at the picture.
    pub fn area_px(&self, ellipse: &Ellipse) -> f64 {
        ellipse.area() * self.scale.x * self.scale.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn on_the_axis_it_is_a_circle() {
        let Projection::Ellipse(e) = project_sphere(DVec3::Z * 5.0, 3.0) else {
            panic!()
        };
        assert_eq!(e.centre, DVec2::ZERO);
        assert!((e.semi_major - 0.75).abs() < 1e-15 && (e.semi_minor - 0.75).abs() < 1e-15);
    }

    #[test]
    fn behind_around_and_tangent_have_values_of_their_own() {
        let at = |x: f64, z: f64, r: f64| project_sphere(DVec3::new(x, 0.0, z), r);
        assert_eq!(at(0.0, -2.0, 1.0), Projection::Behind);
        assert_eq!(at(9.0, -1.0, 1.0), Projection::Behind);
        assert_eq!(at(0.0, 0.5, 1.0), Projection::Unbounded);
        assert_eq!(at(9.0, 1.0, 1.0), Projection::Unbounded);
        assert_eq!(at(9.0, -0.9, 1.0), Projection::Unbounded);
        assert_eq!(at(0.0, 0.0, 0.0), Projection::Unbounded);
        assert_eq!(at(f64::NAN, 5.0, 1.0), Projection::Unbounded);
        assert_eq!(at(0.0, 5.0, f64::INFINITY), Projection::Unbounded);
        assert_eq!(at(0.0, 5.0, -1.0), Projection::Unbounded);
        assert!(at(3.0, 5.0, 0.0).ellipse().is_some());
    }

    #[test]
    fn pixels_need_not_be_square() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (90.0, 90.0)).unwrap();
        let size = Size {
            width: 200,
            height: 100,
        };
        let Projection::Ellipse(e) = project_sphere(DVec3::Z * 5.0, 3.0) else {
            panic!()
        };
        let screen = Screen::of(&camera, size);
        let (low, high) = screen.box_px(&e);
        assert!((low - DVec2::new(25.0, 12.5)).length() < 1e-10, "{low}");
        assert!((high - DVec2::new(175.0, 87.5)).length() < 1e-10, "{high}");
        let right = screen.vertices_px(&e)[0];
        assert!(
            (right - DVec2::new(175.0, 50.0)).length() < 1e-10,
            "{right}"
        );
    }

    #[test]
    fn a_parallel_projection_shows_a_circle_anywhere() {
        let e = project_sphere_orthographic(DVec3::new(2.0, -1.0, -50.0), 3.0).unwrap();
        assert_eq!(
            (e.centre, e.semi_major, e.semi_minor),
            (DVec2::new(2.0, -1.0), 3.0, 3.0)
        );
        let screen = Screen::orthographic(
            20.0,
            10.0,
            Size {
                width: 200,
                height: 200,
            },
        );
        assert_eq!(screen.to_px(e.centre), DVec2::new(120.0, 120.0));
    }

    proptest! {
        #[test]
        fn its_rays_touch_the_sphere(
            c in (-30.0..30.0, -30.0..30.0, 1.0..30.0_f64),
            part in 1e-6..0.99_f64,
            angle in 0.0..6.3_f64,
        ) {
            let c: DVec3 = c.into();
            let radius = c.z * part;
            let Projection::Ellipse(e) = project_sphere(c, radius) else {
                return Err(TestCaseError::fail("a sphere in front is an ellipse"));
            };
            let ray = e.point(angle).extend(1.0).normalize();
            let off = ray.cross(c).length();
            prop_assert!((off - radius).abs() < 1e-9 * c.length(), "{off} {radius}");
        }
    }
}

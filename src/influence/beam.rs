//! Rays from the eye to surface points: what can be seen along them.
//!
//! All positions here are relative to the eye. A *beam* is what one asks about:
//! the surface points that lie along a ray from the eye, at distances from
//! `near` to `far` (which may be infinite), and along all rays whose directions
//! (of length 1) are at most `spread` away from its own. A pixel is a narrow
//! beam, a tile of the picture a wide one; the same test serves both.

use decor_api::Sphere;
use glam::DVec3;

use super::Solid;

/// Rounding, relative to the lengths involved: far more than a few operations
/// lose, far less than a pixel.
pub const ROUNDING: f64 = 1e-9;

/// Surface points along rays from the eye.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// The middle ray, of length 1.
    pub direction: DVec3,
    /// How far the directions of the other rays are off.
    pub spread: f64,
    /// The least distance from the eye; finite, ≥ 0.
    pub near: f64,
    /// The largest; may be infinite.
    pub far: f64,
    /// The points may be wrong along their rays: by this much, and by this
    /// share of their distance.
    pub quantum: (f64, f64),
}

impl Beam {
    /// To everything in a ball: all of it is where its centre may be. `forward`:
    /// any direction, for a ball around the eye.
    pub fn to_ball(ball: &Sphere, forward: DVec3) -> Self {
        let distance = ball.centre.length();
        Self {
            direction: ball.centre.normalize_or(forward),
            spread: 0.0,
            near: distance,
            far: distance,
            quantum: (ball.radius * (1.0 + 1e-9), 1e-9),
        }
    }

    /// How far a point at the distance `t` may be off the middle ray's, and off
    /// its own place.
    pub fn slack(&self, t: f64) -> f64 {
        (self.spread + self.quantum.1) * t + self.quantum.0
    }

    /// Is every point certainly outside the cone from `apex`?
    pub fn is_outside(&self, apex: DVec3, (axis, half_angle): (DVec3, f64)) -> bool {
        let (a, b) = (self.direction * self.near, self.direction * self.far);
        let middle = (a + b) * 0.5 - apex;
        let radius = 0.5 * (self.far - self.near)
            + self.slack(self.far)
            + ROUNDING * (self.far + apex.length());
        let distance = middle.length();
        if !(radius < distance) {
            return false;
        }
        let angle = middle.cross(axis).length().atan2(middle.dot(axis));
        angle - (radius / distance).asin() > half_angle + 1e-6
    }

    /// Can `ball` be seen along the beam? With `is_hidden_beyond`, only what is
    /// not behind its far end. `false` is certain.
    pub fn may_show(&self, ball: &Sphere, is_hidden_beyond: bool) -> bool {
        let (c, r) = (ball.centre, ball.radius);
        let distance = c.length();
        let r = r + (self.spread + ROUNDING) * (distance + r);
        if !(distance > r) {
            return true;
        }
        let along = c.dot(self.direction);
        let off_squared = (c - self.direction * along).length_squared();
        if along < 0.0 || is_clear(off_squared, r) {
            return false;
        }
        let entry = along - (r * r - off_squared).max(0.0).sqrt();
        let end = self.far + self.slack(self.far) + ROUNDING * distance;
        !(is_hidden_beyond && entry > end)
    }

    /// The same of a box; asked where the ball around it can be seen.
    pub fn may_show_box(&self, solid: &Solid, is_hidden_beyond: bool) -> bool {
        let ball = solid.ball();
        let reach = ball.centre.length() + ball.radius;
        let margin = (self.spread + ROUNDING) * reach;
        let end = if is_hidden_beyond {
            let end = self.far + self.slack(self.far) + ROUNDING * reach;
            end.min(reach + margin)
        } else {
            reach + margin
        };
        solid.meets_segment(DVec3::ZERO, self.direction * end, margin)
    }
}

/// Certainly larger than the radius?
pub fn is_clear(distance_squared: f64, radius: f64) -> bool {
    distance_squared > radius * radius
}

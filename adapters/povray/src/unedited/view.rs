//! A perspective camera as POV-Ray 3.7 understands its words, and the outlines
//! of things in its picture.

use decor_api::Size;
use glam::{DMat3, DVec2, DVec3};

use crate::number::vector;

/// Nearer than this to the camera nothing is projected, in units of the scene:
/// POV-Ray sees nothing that is nearer than 1e-4.
const NEAREST: f64 = 1e-5;

/// A camera.
#[derive(Clone, Copy, Debug)]
pub struct View {
    eye: DVec3,
    /// Right, up and direction.
    to_picture: DMat3,
    /// To parts of right, up and direction.
    to_camera: DMat3,
    /// [`NEAREST`], in lengths of the direction.
    nearest: f64,
    width: f64,
    height: f64,
}

/// A rectangle of the picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Rectangle {
    /// Its upper left corner.
    pub least: DVec2,
    /// Its lower right corner.
    pub greatest: DVec2,
}

impl View {
    /// The camera of these words: whatever their order, POV-Ray (since 3.5) takes
    /// `angle` first, then `look_at`, then what moves the camera, in order.
    /// `None` where another word is among them, or where it makes no picture.
    pub fn of(words: &[(String, DVec3)], size: Size) -> Option<Self> {
        let mut camera = Vectors::default();
        let mut placing = Vec::new();
        let (mut look_at, mut angle) = (None, None);
        for (word, value) in words {
            match word.as_str() {
                "location" => camera.location = *value,
                "direction" => camera.direction = *value,
                "right" => camera.right = *value,
                "up" => camera.up = *value,
                "sky" => camera.sky = *value,
                "look_at" => look_at = Some(*value),
                "angle" => angle = Some(value.x),
                "perspective" => {}
                "translate" | "rotate" | "scale" => placing.push((word.as_str(), *value)),
                _ => return None,
            }
        }
        if let Some(degrees) = angle.filter(|degrees| *degrees > 0.0) {
            let length = camera.right.length() / (degrees.to_radians() / 2.0).tan() / 2.0;
            camera.direction = camera.direction.normalize() * length;
        }
        if let Some(point) = look_at {
            camera.look_at(point);
        }
        for (word, value) in placing {
            camera.place(word, value);
        }
        let to_picture = DMat3::from_cols(camera.right, camera.up, camera.direction);
        let view = Self {
            eye: camera.location,
            to_picture,
            to_camera: to_picture.inverse(),
            nearest: NEAREST / camera.direction.length(),
            width: f64::from(size.width),
            height: f64::from(size.height),
        };
        let usable = view.to_camera.is_finite() && view.eye.is_finite() && view.nearest.is_finite();
        usable.then_some(view)
    }

    /// The text of a camera whose picture shows one column more to the left and one
    /// row more above, and none of the last ones.
    pub fn one_pixel_further(&self) -> String {
        let [right, up, direction] = [0, 1, 2].map(|axis| self.to_picture.col(axis));
        let shifted = direction - right / self.width + up / self.height;
        format!(
            "camera {{ perspective location {} direction {} right {} up {} }}",
            vector(self.eye),
            vector(shifted),
            vector(right),
            vector(up)
        )
    }

    /// The convex outline of what is seen of the hull of these points, in
    /// pixels: empty where all are behind the camera.
    ///
    /// # Errors
    /// Where something is not a number.
    pub(super) fn outline(&self, points: &[DVec3]) -> Result<Vec<DVec2>, ()> {
        let seen: Vec<DVec3> = points
            .iter()
            .map(|p| self.to_camera * (*p - self.eye))
            .collect();
        if seen.iter().any(|p| !p.is_finite()) {
            return Err(());
        }
        let (front, behind): (Vec<DVec3>, Vec<DVec3>) =
            seen.into_iter().partition(|p| p.z >= self.nearest);
        let mut kept = front.clone();
        for p in &front {
            for q in &behind {
                kept.push(*p + (*q - *p) * ((p.z - self.nearest) / (p.z - q.z)));
            }
        }
        let pixels = kept.iter().map(|p| {
            // Rounding may bring a point that was cut off behind the camera.
            let z = p.z.max(self.nearest / 2.0);
            DVec2::new((p.x / z + 0.5) * self.width, (0.5 - p.y / z) * self.height)
        });
        Ok(hull(pixels.collect()))
    }
}

/// The vectors of a camera, with their defaults.
struct Vectors {
    location: DVec3,
    direction: DVec3,
    right: DVec3,
    up: DVec3,
    sky: DVec3,
}

impl Default for Vectors {
    fn default() -> Self {
        Self {
            location: DVec3::ZERO,
            direction: DVec3::Z,
            right: DVec3::X * 1.33,
            up: DVec3::Y,
            sky: DVec3::Y,
        }
    }
}

impl Vectors {
    fn look_at(&mut self, point: DVec3) {
        let lengths = (
            self.right.length(),
            self.up.length(),
            self.direction.length(),
        );
        let handed = self.up.cross(self.direction).dot(self.right) > 0.0;
        let direction = (point - self.location).normalize();
        let mut right = self.sky.cross(direction);
        if right.abs().max_element() < 1e-10 {
            right = self.right;
        }
        let right = right.normalize();
        self.up = direction.cross(right) * lengths.1;
        self.right = right * if handed { lengths.0 } else { -lengths.0 };
        self.direction = direction * lengths.2;
    }

    fn place(&mut self, word: &str, value: DVec3) {
        if word == "translate" {
            self.location += value;
            return;
        }
        let by = if word == "scale" {
            // POV-Ray takes 1 for 0.
            DMat3::from_diagonal(DVec3::select(value.cmpeq(DVec3::ZERO), DVec3::ONE, value))
        } else {
            // About x first. Left-handed coordinates and turns: the usual matrices.
            let turn = value * std::f64::consts::PI / 180.0;
            DMat3::from_rotation_z(turn.z)
                * DMat3::from_rotation_y(turn.y)
                * DMat3::from_rotation_x(turn.x)
        };
        self.location = by * self.location;
        self.direction = by * self.direction;
        self.right = by * self.right;
        self.up = by * self.up;
    }
}

/// The convex hull, in order (Andrew's monotone chain).
fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for p in points {
            while let [.., a, b] = chain[..] {
                if (b - a).perp_dot(p - a) > 0.0 {
                    break;
                }
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut lower = half(&mut points.iter().copied());
    lower.extend(half(&mut points.iter().rev().copied()));
    lower
}

/// Can a convex outline and a rectangle have a point in common? Sure only where
/// a line lies between them: one along the rectangle, or along the outline.
pub fn touches(outline: &[DVec2], rectangle: &Rectangle) -> bool {
    let (least, greatest) = (rectangle.least, rectangle.greatest);
    let Some(first) = outline.first() else {
        return false;
    };
    let (mut low, mut high) = (*first, *first);
    for p in outline {
        (low, high) = (low.min(*p), high.max(*p));
    }
    if low.x > greatest.x || high.x < least.x || low.y > greatest.y || high.y < least.y {
        return false;
    }
    let corners = [
        least,
        DVec2::new(greatest.x, least.y),
        greatest,
        DVec2::new(least.x, greatest.y),
    ];
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    let between = |(a, b): (&DVec2, &DVec2)| {
        let normal = (*b - *a).perp().normalize_or_zero();
        if normal == DVec2::ZERO {
            return false;
        }
        // From the rectangle: ends of the outline can be very far away.
        let range = |points: &[DVec2]| {
            let along = points.iter().map(|p| (*p - least).dot(normal));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| {
                (low.min(t), high.max(t))
            })
        };
        let (ours, its) = (range(outline), range(&corners));
        // A hundredth of a pixel for rounding.
        ours.0 > its.1 + 0.01 || ours.1 < its.0 - 0.01
    };
    !edges.into_iter().any(between)
}

//! The motion of a sphere relative to the observer, between two instants.
//!
//! An object moves, the observer moves, turns and zooms: seen from the observer
//! it is one rigid motion of the sphere in camera space. Everything small is
//! made of differences of what was given (positions, eyes, angles, the camera's
//! axes), each correct to its last place, and never of two far positions: at
//! coordinates of 1e8 a motion of 1e-6 keeps its digits. What rounding is left
//! is carried along, as a length.

use decor_api::{Camera, Pose, Size, Sphere};
use glam::{DMat3, DQuat, DVec2, DVec3};

const EPS: f64 = f64::EPSILON;

/// A motion of a sphere in camera space (x right, y up, z along the view), in
/// scene units. A point c₀ + R·u of the ball goes to c₁ + R·Q·u.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeMotion {
    /// c₀, the centre at the first instant.
    pub centre_before: DVec3,
    /// c₁, the centre at the second instant.
    pub centre_after: DVec3,
    /// Δ = c₁ − c₀, with more digits than that subtraction would have.
    pub delta: DVec3,
    /// The vector part of the quaternion of Q whose scalar part is not negative:
    /// sin(θ/2) along the axis, θ from 0 to π.
    pub half_turn: DVec3,
    /// R.
    pub radius: f64,
    /// How far off `centre_before` can be for rounding.
    pub slack_before: f64,
    /// How far off `centre_after` can be for rounding.
    pub slack_after: f64,
    /// How far off the displacement of any point, Δ + R·(Q − 1)·u, can be for
    /// rounding.
    pub delta_error: f64,
}

impl RelativeMotion {
    /// The motion of an object's sphere (its centre in the object's
    /// coordinates: it turns with the object) from one camera and pose to
    /// another. For many objects, make one [`ObserverMotion`].
    pub fn between(
        camera_before: &Camera,
        pose_before: &Pose,
        camera_after: &Camera,
        pose_after: &Pose,
        sphere: &Sphere,
    ) -> Self {
        ObserverMotion::between(camera_before, camera_after).of(pose_before, pose_after, sphere)
    }

    /// A motion given in camera space, exactly. `half_turn` is sin(θ/2) along
    /// the axis of the rotation; its length must not exceed 1.
    pub fn in_camera_space(
        centre_before: DVec3,
        delta: DVec3,
        half_turn: DVec3,
        radius: f64,
    ) -> Self {
        let centre_after = centre_before + delta;
        Self {
            centre_before,
            centre_after,
            delta,
            half_turn,
            radius,
            slack_before: 0.0,
            slack_after: 2.0 * EPS * centre_after.length(),
            delta_error: 4.0 * EPS * half_turn.length() * centre_after.length(),
        }
    }

    /// The same motion without its rotation.
    pub fn translation_only(&self) -> Self {
        Self {
            half_turn: DVec3::ZERO,
            ..*self
        }
    }

    /// The rotation alone, where the sphere was.
    pub fn rotation_only(&self) -> Self {
        Self {
            centre_after: self.centre_before,
            delta: DVec3::ZERO,
            slack_after: self.slack_before,
            ..*self
        }
    }

    /// The motion back.
    pub fn reversed(&self) -> Self {
        Self {
            centre_before: self.centre_after,
            centre_after: self.centre_before,
            delta: -self.delta,
            half_turn: -self.half_turn,
            slack_before: self.slack_after,
            slack_after: self.slack_before,
            ..*self
        }
    }
}

/// The focal lengths at both instants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lenses {
    /// Pixels per tangent, horizontally and vertically, at the first instant.
    /// Under parallel projection: pixels per scene unit.
    pub before: DVec2,
    /// The same at the second instant.
    pub after: DVec2,
    /// after − before.
    pub delta: DVec2,
}

impl Lenses {
    /// The lenses of two cameras that make pictures of one size.
    pub fn between(before: &Camera, after: &Camera, size: Size) -> Self {
        let pixels = DVec2::new(f64::from(size.width), f64::from(size.height));
        let a = DVec2::new(before.half_width, before.half_height);
        let b = DVec2::new(after.half_width, after.half_height);
        Self {
            before: before.focal(size).into(),
            after: after.focal(size).into(),
            delta: pixels * 0.5 * ((a - b) / a / b),
        }
    }

    /// One lens at both instants.
    pub fn fixed(focal_px: DVec2) -> Self {
        Self {
            before: focal_px,
            after: focal_px,
            delta: DVec2::ZERO,
        }
    }

    /// A zoom.
    pub fn zoom(before: DVec2, after: DVec2) -> Self {
        Self {
            before,
            after,
            delta: after - before,
        }
    }

    /// The lenses of the motion back.
    pub fn reversed(&self) -> Self {
        Self {
            before: self.after,
            after: self.before,
            delta: -self.delta,
        }
    }
}

/// A rotation as a quaternion whose vector part keeps its digits when it is
/// small, with how far off that part can be.
#[derive(Clone, Copy, Debug)]
struct Turn {
    half: DVec3,
    cos_half: f64,
    error: f64,
}

impl Turn {
    const NONE: Self = Self {
        half: DVec3::ZERO,
        cos_half: 1.0,
        error: 0.0,
    };

    fn about(axis: DVec3, angle_deg: f64) -> Self {
        let (sin, cos) = (angle_deg.to_radians() * 0.5).sin_cos();
        Self {
            half: axis * sin,
            cos_half: cos,
            error: 8.0 * EPS * sin.abs(),
        }
    }

    /// First `first`, then this.
    fn after(self, first: Self) -> Self {
        Self {
            half: self.half * first.cos_half
                + first.half * self.cos_half
                + self.half.cross(first.half),
            cos_half: self.cos_half * first.cos_half - self.half.dot(first.half),
            error: (self.error + first.error) * 1.5
                + 4.0 * EPS * (self.half.length() + first.half.length()),
        }
    }

    /// How far it moves `v`: (Q − 1)·v.
    fn displacement(&self, v: DVec3) -> DVec3 {
        let w = self.half.cross(v);
        2.0 * (self.cos_half * w + self.half.cross(w))
    }
}

/// How the observer moves between two instants: what all objects share.
#[derive(Clone, Copy, Debug)]
pub struct ObserverMotion {
    eye_before: DVec3,
    eye_after: DVec3,
    eye_delta: DVec3,
    axes_before: [DVec3; 3],
    axes_after: [DVec3; 3],
    axes_delta: [DVec3; 3],
    turn: Turn,
    /// The length of the largest change of an axis, 0 where none changes.
    turned: f64,
    /// By how much rounding may have turned a camera's axes.
    axes_error: f64,
}

fn times(rows: &[DVec3; 3], v: DVec3) -> DVec3 {
    DVec3::new(rows[0].dot(v), rows[1].dot(v), rows[2].dot(v))
}

impl ObserverMotion {
    /// The observer's motion from one camera to another.
    pub fn between(before: &Camera, after: &Camera) -> Self {
        let axes_before = [before.right, before.up, before.forward];
        let axes_after = [after.right, after.up, after.forward];
        let axes_delta = [0, 1, 2].map(|i| axes_after[i] - axes_before[i]);
        let turned = axes_delta[0].length() + axes_delta[1].length() + axes_delta[2].length();
        // The axes of a camera are rounded once each: only where they change
        // does that look like a motion.
        let axes_error = if turned == 0.0 { 0.0 } else { 4.0 * EPS };
        Self {
            eye_before: before.eye,
            eye_after: after.eye,
            eye_delta: after.eye - before.eye,
            axes_before,
            axes_after,
            axes_delta,
            turn: camera_turn(&axes_before, &axes_after, &axes_delta, turned, axes_error),
            turned,
            axes_error,
        }
    }

    /// The relative motion of an object from one pose to another; the sphere's
    /// centre in the object's coordinates. Numbers that are not finite make a
    /// motion that no measure calls bounded.
    pub fn of(&self, before: &Pose, after: &Pose, sphere: &Sphere) -> RelativeMotion {
        let turn_world = pose_turn(before.angles_deg, after.angles_deg);
        let (arm, arm_delta, arm_length) = if sphere.centre == DVec3::ZERO {
            (DVec3::ZERO, DVec3::ZERO, 0.0)
        } else {
            let arm = before.rotation() * sphere.centre;
            (arm, turn_world.displacement(arm), sphere.centre.length())
        };
        let (from_eye, to_eye) = (
            before.position - self.eye_before,
            after.position - self.eye_after,
        );
        let place = from_eye + arm;
        let position_delta = after.position - before.position;
        let moved = (position_delta - self.eye_delta) + arm_delta;
        let delta = times(&self.axes_after, moved) + times(&self.axes_delta, place);

        let turn_camera = Turn {
            half: times(&self.axes_before, turn_world.half),
            ..turn_world
        };
        let turn = self.turn.after(turn_camera);

        let place_length = place.length();
        let slack_before = 16.0 * EPS * (from_eye.length() + 2.0 * arm_length);
        let slack_after = 16.0 * EPS * (to_eye.length() + 2.0 * arm_length);
        let centre_error = 8.0 * EPS * (position_delta.length() + self.eye_delta.length())
            + 16.0 * EPS * (moved.length() + arm_delta.length())
            + 2.0 * turn_world.error * arm_length
            + (8.0 * EPS * self.turned + self.axes_error) * place_length
            + self.turned * slack_before;
        RelativeMotion {
            centre_before: times(&self.axes_before, place),
            centre_after: times(&self.axes_after, to_eye + (arm + arm_delta)),
            delta,
            half_turn: if turn.cos_half < 0.0 {
                -turn.half
            } else {
                turn.half
            },
            radius: sphere.radius,
            slack_before,
            slack_after,
            delta_error: centre_error
                + 2.0 * turn.error * sphere.radius
                + 2.0 * turn.half.length() * slack_before.max(slack_after),
        }
    }
}

/// The camera's own turn, from the first camera's coordinates to the second's:
/// C = B₁·B₀ᵀ, where C − 1 = (B₁ − B₀)·B₀ᵀ keeps the digits of a small turn.
fn camera_turn(
    before: &[DVec3; 3],
    after: &[DVec3; 3],
    delta: &[DVec3; 3],
    turned: f64,
    axes_error: f64,
) -> Turn {
    if turned == 0.0 {
        return Turn::NONE;
    }
    let off = |i: usize, j: usize| delta[i].dot(before[j]);
    let trace = 3.0 + off(0, 0) + off(1, 1) + off(2, 2);
    let error = axes_error + 8.0 * EPS * turned;
    if trace > 0.5 {
        let cos_half = (trace + 1.0).sqrt() * 0.5;
        let twice_sin = DVec3::new(
            off(2, 1) - off(1, 2),
            off(0, 2) - off(2, 0),
            off(1, 0) - off(0, 1),
        );
        return Turn {
            half: twice_sin / (4.0 * cos_half),
            cos_half,
            error,
        };
    }
    let row = |i: usize| {
        DVec3::new(
            after[i].dot(before[0]),
            after[i].dot(before[1]),
            after[i].dot(before[2]),
        )
    };
    let q = DQuat::from_mat3(&DMat3::from_cols(row(0), row(1), row(2)).transpose());
    Turn {
        half: q.xyz(),
        cos_half: q.w,
        error: error + 16.0 * EPS,
    }
}

/// The rotation, in the world, that takes an object from one orientation to the
/// other: Z₁Y₁X₁·(Z₀Y₀X₀)⁻¹ = R(Z₁Y₁x, δx)·R(Z₁y, δy)·R(z, δz), where only the
/// differences of the angles appear.
fn pose_turn(before_deg: DVec3, after_deg: DVec3) -> Turn {
    if before_deg == after_deg {
        return Turn::NONE;
    }
    let radians = |degrees: f64| (degrees % 360.0).to_radians();
    let (sin_y, cos_y) = radians(after_deg.y).sin_cos();
    let (sin_z, cos_z) = radians(after_deg.z).sin_cos();
    let x = DVec3::new(cos_z * cos_y, sin_z * cos_y, -sin_y);
    let y = DVec3::new(-sin_z, cos_z, 0.0);
    let by = |before: f64, after: f64| {
        let straight = after - before;
        if straight.abs() <= 180.0 {
            return straight;
        }
        let wrapped = after % 360.0 - before % 360.0;
        wrapped - 360.0 * (wrapped / 360.0).round()
    };
    let turn = |axis: DVec3, before: f64, after: f64| {
        if before == after {
            return Turn::NONE;
        }
        let mut turn = Turn::about(axis, by(before, after));
        if (after - before).abs() > 180.0 {
            // Wrapped: the rounding is that of a whole turn.
            turn.error += 8.0 * EPS;
        }
        turn
    };
    turn(x, before_deg.x, after_deg.x)
        .after(turn(y, before_deg.y, after_deg.y))
        .after(turn(DVec3::Z, before_deg.z, after_deg.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vec3(size: f64) -> impl Strategy<Value = DVec3> {
        (-size..size, -size..size, -size..size).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// Where u of the ball goes.
    fn carried(m: &RelativeMotion, u: DVec3) -> DVec3 {
        let cos = (1.0 - m.half_turn.length_squared()).max(0.0).sqrt();
        let w = m.half_turn.cross(u);
        m.centre_after + (u + 2.0 * (cos * w + m.half_turn.cross(w))) * m.radius
    }

    proptest! {
        #[test]
        fn points_go_where_the_cameras_and_poses_take_them(
            eyes in (vec3(10.0), vec3(10.0)),
            aims in (vec3(10.0), vec3(10.0)),
            at in (vec3(10.0), vec3(10.0)),
            angles in (vec3(400.0), vec3(400.0)),
            local in vec3(5.0),
            u in vec3(1.0),
            small in any::<bool>(),
        ) {
            // Small: the second instant is close to the first one.
            let near = |a: DVec3, b: DVec3| if small { a + b * 1e-6 } else { b };
            let Ok(c0) = Camera::look_at(eyes.0, aims.0, DVec3::Y, (60.0, 60.0)) else { return Ok(()) };
            let Ok(c1) = Camera::look_at(near(eyes.0, eyes.1), near(aims.0, aims.1), DVec3::Y, (60.0, 60.0)) else { return Ok(()) };
            let p0 = Pose { position: at.0, angles_deg: angles.0 };
            let p1 = Pose { position: near(at.0, at.1), angles_deg: near(angles.0, angles.1) };
            let sphere = Sphere { centre: local, radius: 2.0 };
            let m = RelativeMotion::between(&c0, &p0, &c1, &p1, &sphere);
            // u is in the first camera's axes: back into the object's.
            let world = c0.right * u.x + c0.up * u.y + c0.forward * u.z;
            let own = p0.rotation().inverse() * world;
            let truth = c1.to_camera(p1.transform().transform_point3(local + own * 2.0));
            // cos(θ/2) comes from a root here: half the digits near half a turn.
            let off = (carried(&m, u) - truth).length();
            prop_assert!(off < if small { 1e-11 } else { 1e-6 }, "{off} {m:?}");
            prop_assert!((m.centre_after - m.centre_before - m.delta).length() < 1e-12);
        }
    }

    #[test]
    fn far_from_the_origin_small_motions_keep_their_digits() {
        let far = DVec3::new(1e8, -1e8, 1e8);
        let camera =
            |eye: DVec3| Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, (60.0, 60.0)).unwrap();
        let pose = |x: f64| Pose {
            position: far + DVec3::new(x, 0.0, 10.0),
            angles_deg: DVec3::ZERO,
        };
        let sphere = Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        };
        let (a, b) = (pose(0.0), pose(1e-6));
        let m = RelativeMotion::between(&camera(far), &a, &camera(far), &b, &sphere);
        assert_eq!(m.delta, DVec3::new(b.position.x - a.position.x, 0.0, 0.0));
        assert!(m.delta.x > 9.9e-7);
        assert!(m.delta_error < 1e-20, "{}", m.delta_error);
    }

    #[test]
    fn what_does_not_move_does_not_move_at_all() {
        let camera = Camera::look_at(
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::ZERO,
            DVec3::Y,
            (60.0, 60.0),
        )
        .unwrap();
        let pose = Pose {
            position: DVec3::new(0.1, 0.2, 0.3),
            angles_deg: DVec3::new(10.0, 20.0, 30.0),
        };
        let sphere = Sphere {
            centre: DVec3::new(1.0, 0.3, 0.2),
            radius: 1.0,
        };
        let m = RelativeMotion::between(&camera, &pose, &camera, &pose, &sphere);
        assert_eq!(
            (m.delta, m.half_turn, m.delta_error),
            (DVec3::ZERO, DVec3::ZERO, 0.0)
        );
    }

    #[test]
    fn tiny_turns_and_whole_turns() {
        let turn = |degrees: f64| {
            pose_turn(
                DVec3::new(5.0, 50.0, 70.0),
                DVec3::new(5.0, 50.0, 70.0 + degrees),
            )
            .half
        };
        assert!(turn(360.0 * 7.0).length() < 1e-13);
        assert!((turn(180.0).length() - 1.0).abs() < 1e-15);
        let tiny = pose_turn(DVec3::ZERO, DVec3::new(0.0, 1e-12f64.to_degrees(), 0.0));
        assert!((tiny.half.y / 0.5e-12 - 1.0).abs() < 1e-14);
    }
}

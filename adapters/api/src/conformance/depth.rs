//! Depth is the distance along the ray at the pixel's centre, to within what the
//! layer says of its own precision.

use glam::DVec3;

use super::Subject;
use super::stage::{Stage, at, cuboid, dull, plane, sphere};
use crate::adapter::Output;
use crate::scene::{Instance, Pose};

fn check(subject: &Subject, stage: &Stage) {
    let layer = stage.draw(&*subject.adapter(), Output::Depth);
    assert_eq!(layer.window, stage.size.window());
    stage.oracle().assert_depth(&layer);
}

/// Spheres before and beside each other, from aslant.
pub fn the_depth_of_spheres(subject: &Subject) {
    let solids = [
        sphere(0.0, 0.0, 0.0, 2.0),
        sphere(2.5, 1.0, 1.5, 1.0),
        dull(sphere(-2.0, -1.0, -3.0, 0.7)),
    ];
    let stage = Stage::of(solids).seen_from(DVec3::new(2.0, 3.0, -9.0), DVec3::new(0.2, 0.1, 0.0));
    check(subject, &stage);
}

/// Boxes along the axes, from aslant, one inside of another.
pub fn the_depth_of_boxes(subject: &Subject) {
    let solids = [
        cuboid([-3.0, -2.0, 0.0], [-0.5, 1.5, 2.0]),
        cuboid([0.0, -1.0, -1.0], [2.5, 0.5, 0.5]),
        dull(cuboid([0.5, -0.5, -0.8], [1.0, 1.5, 0.0])),
    ];
    let stage = Stage::of(solids).seen_from(DVec3::new(-3.0, 4.0, -8.0), DVec3::ZERO);
    check(subject, &stage);
}

/// A floor to the horizon, and a leaning wall of another prototype.
pub fn the_depth_of_planes(subject: &Subject) {
    let solids = [
        plane([0.0, 1.0, 0.0], -1.5),
        dull(plane([2.0, 0.4, -1.0], -4.0)),
    ];
    let stage = Stage::of(solids).seen_from(DVec3::new(1.0, 1.0, -9.0), DVec3::new(1.0, 0.5, 0.0));
    check(subject, &stage);
}

/// Copies of two prototypes, turned about every axis and moved.
pub fn the_depth_of_instances(subject: &Subject) {
    let mut stage = Stage::empty();
    let brick = stage.prototype("brick.ron", cuboid([-0.9, -0.3, -0.5], [0.9, 0.6, 0.2]));
    let ball = stage.prototype("ball.ron", sphere(0.4, 0.0, 0.0, 0.5));
    for (k, prototype) in (0_u32..10).zip([brick, ball].into_iter().cycle()) {
        let k = f64::from(k);
        let pose = Pose {
            position: DVec3::new(
                1.9 * (k % 4.0) - 3.0,
                1.5 * (k / 4.0).floor() - 1.5,
                0.3 * k,
            ),
            angles_deg: DVec3::new(37.0 * k, -64.0 * k, 500.0 + 11.0 * k),
        };
        stage.scene.instances.push(Instance { prototype, pose });
    }
    check(subject, &stage);
}

/// From a hundredth of a unit to a hundred thousand, in one picture.
pub fn the_depth_of_what_is_near_and_far(subject: &Subject) {
    let solids = [
        sphere(-0.02, 0.0, 0.06, 0.01),
        sphere(0.5, 0.3, 3.0, 0.5),
        cuboid([-300.0, -100.0, 900.0], [100.0, 50.0, 1100.0]),
        sphere(20_000.0, -20_000.0, 90_000.0, 15_000.0),
    ];
    let stage = Stage::of(solids).seen_from(DVec3::ZERO, DVec3::Z);
    check(subject, &stage);
}

/// The scene is a thousand units away from where coordinates begin.
pub fn the_depth_far_from_the_origin(subject: &Subject) {
    let mut stage = Stage::empty();
    stage.add(sphere(0.0, 0.0, 0.0, 1.0), at(1000.0, -500.0, 2000.0));
    stage.add(
        cuboid([-1.0, -1.0, 0.0], [0.5, 0.5, 1.0]),
        at(1002.0, -500.0, 2001.0),
    );
    let eye = DVec3::new(1001.0, -499.0, 1994.0);
    check(
        subject,
        &stage.seen_from(eye, DVec3::new(1001.0, -500.0, 2000.0)),
    );
}

/// The observer is inside of a solid and sees its other side.
pub fn the_depth_from_inside(subject: &Subject) {
    let solids = [
        cuboid([-4.0, -3.0, -5.0], [4.0, 3.0, 6.0]),
        sphere(1.0, 0.0, 3.0, 1.0),
    ];
    let stage = Stage::of(solids).seen_from(DVec3::new(0.5, 0.2, -2.0), DVec3::Z * 3.0);
    check(subject, &stage);
}

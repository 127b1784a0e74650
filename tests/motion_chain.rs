//! From cameras and poses to pixels: the bound holds for what was given, to its
//! last digit, far from the origin and for the smallest motions; and it does not
//! depend on where the world is, how large, or how it is turned.

mod motion_truth;

use decor::motion::{Lenses, ObserverMotion, RelativeMotion, bound_px, bounds_px, thesis_px};
use decor_api::{Camera, Pose, Size, Sphere};
use glam::{DQuat, DVec3};
use motion_truth::Random;
use motion_truth::dd::{Dd, V};
use motion_truth::{farthest, quantile};
use rayon::prelude::*;

const SIZE: Size = Size {
    width: 640,
    height: 480,
};

/// A vector of the object's coordinates in the world, by angles in 106 bits.
fn turned(angles_deg: DVec3, v: V) -> V {
    let angle = |degrees: f64| (Dd::from(degrees % 360.0) * Dd::PI / Dd::from(180.0)).sin_cos();
    let [x, y, z] = v.0;
    let (s, c) = angle(angles_deg.x);
    let (y, z) = (y * c - z * s, y * s + z * c);
    let (s, c) = angle(angles_deg.y);
    let (x, z) = (x * c + z * s, z * c - x * s);
    let (s, c) = angle(angles_deg.z);
    V([x * c - y * s, x * s + y * c, z])
}

/// Where a point of the object is seen, in pixels from the view's axis.
fn seen(camera: &Camera, pose: &Pose, own: V) -> [Dd; 2] {
    let p = (V::from(pose.position) - V::from(camera.eye)) + turned(pose.angles_deg, own);
    let along = |axis: DVec3| V::from(axis).dot(p);
    let z = along(camera.forward);
    let focal = |pixels: u32, half: f64| Dd::from(f64::from(pixels) * 0.5) / Dd::from(half);
    [
        focal(SIZE.width, camera.half_width) * along(camera.right) / z,
        focal(SIZE.height, camera.half_height) * along(camera.up) / z,
    ]
}

struct World {
    cameras: [Camera; 2],
    poses: [Pose; 2],
    sphere: Sphere,
}

fn world(random: &mut Random) -> Option<World> {
    let far = if random.chance(0.5) {
        random.direction() * random.log(1.0, 1e8)
    } else {
        DVec3::ZERO
    };
    let radius = random.log(1e-3, 5.0);
    let centre = if random.chance(0.5) {
        DVec3::ZERO
    } else {
        random.direction() * random.log(1e-3, 10.0)
    };
    let step = random.log(1e-12, 1.0);
    let part = |random: &mut Random| {
        if random.chance(0.5) {
            random.direction() * step
        } else {
            DVec3::ZERO
        }
    };
    let eye = far + random.direction() * 3.0;
    let aim = far + random.direction() * 3.0;
    let angles = (random.range(1.0, 120.0), random.range(1.0, 120.0));
    let zoomed = if random.chance(0.2) {
        (angles.0 * (1.0 + step * 0.1), angles.1)
    } else {
        angles
    };
    // Sometimes the view only shifts, so that its axes stay the same.
    let eye_step = part(random);
    let aim_step = if random.chance(0.5) {
        eye_step
    } else {
        part(random)
    };
    let camera = Camera::look_at(eye, aim, DVec3::Y, angles).ok()?;
    let mut after = Camera::look_at(eye + eye_step, aim + aim_step, DVec3::Y, zoomed).ok()?;
    if eye_step == aim_step {
        (after.right, after.up, after.forward) = (camera.right, camera.up, camera.forward);
    }
    let angles_deg = DVec3::new(
        random.range(-720.0, 720.0),
        random.range(-720.0, 720.0),
        random.range(-720.0, 720.0),
    );
    let ahead = camera.forward * random.log(1.0, 50.0) + random.direction() * 2.0;
    let place = eye + ahead;
    // Sometimes the object flies with its observer.
    let place_step = if random.chance(0.2) {
        after.eye - camera.eye
    } else {
        part(random)
    };
    let spin = part(random) * if random.chance(0.1) { 1e3 } else { 10.0 };
    Some(World {
        cameras: [camera, after],
        poses: [
            Pose {
                position: place,
                angles_deg,
            },
            Pose {
                position: place + place_step,
                angles_deg: angles_deg + spin,
            },
        ],
        sphere: Sphere { centre, radius },
    })
}

impl World {
    fn motion(&self) -> (RelativeMotion, Lenses) {
        let [a, b] = &self.cameras;
        let motion = RelativeMotion::between(a, &self.poses[0], b, &self.poses[1], &self.sphere);
        (motion, Lenses::between(a, b, SIZE))
    }

    /// How far the point u (in the first camera's axes) moves, in 106 bits.
    fn moved(&self, u: DVec3) -> f64 {
        let [a, b] = &self.cameras;
        let world = a.right * u.x + a.up * u.y + a.forward * u.z;
        let own = V::from(self.poses[0].rotation().inverse() * world).unit();
        let own = V::from(self.sphere.centre) + own * Dd::from(self.sphere.radius);
        let (p, q) = (seen(a, &self.poses[0], own), seen(b, &self.poses[1], own));
        let (x, y) = (q[0] - p[0], q[1] - p[1]);
        (x * x + y * y).sqrt().value()
    }
}

#[test]
fn the_bound_holds_from_cameras_and_poses_in_106_bits() {
    let found: Vec<f64> = (0..400u64)
        .into_par_iter()
        .flat_map_iter(|batch| {
            let mut random = Random(batch * 31 + 11);
            let mut ratios = Vec::new();
            while ratios.len() < 250 {
                let Some(world) = world(&mut random) else {
                    continue;
                };
                let (motion, lenses) = world.motion();
                let bound = bound_px(&motion, &lenses);
                if !bound.is_finite() {
                    continue;
                }
                let (_, best) = farthest(&motion, &lenses, 0, 40, &mut random);
                let mut most = 0.0_f64;
                for u in [best, random.direction(), -DVec3::Z] {
                    let moved = world.moved(u);
                    assert!(
                        moved <= bound,
                        "{moved:e} > {bound:e}: {:?} {:?} {:?} {motion:?}",
                        world.cameras,
                        world.poses,
                        world.sphere
                    );
                    most = most.max(moved);
                }
                ratios.push(if most > 0.0 { bound / most } else { 1.0 });
            }
            ratios
        })
        .collect();
    let mut sorted = found;
    sorted.sort_by(f64::total_cmp);
    println!(
        "{} motions of cameras and poses, 0 under-estimates; over-estimate {:.4} (median) {:.4} (90 %) {:.4} (99 %)",
        sorted.len(),
        quantile(&sorted, 0.5),
        quantile(&sorted, 0.9),
        quantile(&sorted, 0.99)
    );
    assert!(quantile(&sorted, 0.5) < 1.5);
}

/// Both worlds, whose second is the first one transformed, measure the same.
fn same(a: &World, b: &World, what: &str, tolerance: f64) {
    let measure = |w: &World| {
        let (motion, lenses) = w.motion();
        (bound_px(&motion, &lenses), thesis_px(&motion, &lenses))
    };
    let ((bound, thesis), (other_bound, other_thesis)) = (measure(a), measure(b));
    let close = |a: f64, b: f64, of: f64| a == b || (a - b).abs() <= of * a.max(b) + 1e-9;
    assert!(
        close(bound, other_bound, tolerance),
        "{what}: {bound} {other_bound}"
    );
    // A count of points may differ by one where a length rounds otherwise.
    assert!(
        close(thesis, other_thesis, 0.02),
        "{what}, thesis: {thesis} {other_thesis}"
    );
}

fn worlds(seeds: std::ops::Range<u64>) -> impl Iterator<Item = (World, Random)> {
    seeds.filter_map(|seed| {
        let mut random = Random(seed);
        let world = world(&mut random)?;
        let near = world.cameras[0].eye.length() < 100.0;
        (near && bound_px(&world.motion().0, &world.motion().1).is_finite())
            .then_some((world, random))
    })
}

#[test]
fn turning_the_world_changes_nothing() {
    for (a, mut random) in worlds(0..3000) {
        let q = DQuat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
        let camera = |c: &Camera| Camera {
            eye: q * c.eye,
            right: q * c.right,
            up: q * c.up,
            forward: q * c.forward,
            ..*c
        };
        // The angles of the turned orientation, about x, then y, then z.
        let pose = |p: &Pose| {
            let (z, y, x) = (q * p.rotation()).to_euler(glam::EulerRot::ZYX);
            let angles_deg = DVec3::new(x.to_degrees(), y.to_degrees(), z.to_degrees());
            Pose {
                position: q * p.position,
                angles_deg,
            }
        };
        let b = World {
            cameras: [camera(&a.cameras[0]), camera(&a.cameras[1])],
            poses: [pose(&a.poses[0]), pose(&a.poses[1])],
            sphere: a.sphere,
        };
        same(&a, &b, "turned", 1e-6);
    }
}

#[test]
fn scaling_the_world_changes_nothing() {
    for (a, mut random) in worlds(0..3000) {
        let scale = random.log(1e-6, 1e6);
        let camera = |c: &Camera| Camera {
            eye: c.eye * scale,
            ..*c
        };
        let pose = |p: &Pose| Pose {
            position: p.position * scale,
            ..*p
        };
        let b = World {
            cameras: [camera(&a.cameras[0]), camera(&a.cameras[1])],
            poses: [pose(&a.poses[0]), pose(&a.poses[1])],
            sphere: Sphere {
                centre: a.sphere.centre * scale,
                radius: a.sphere.radius * scale,
            },
        };
        same(&a, &b, "scaled", 1e-6);
    }
}

#[test]
fn the_way_back_is_as_long() {
    for (a, _) in worlds(0..3000) {
        let (motion, lenses) = a.motion();
        let forth = bound_px(&motion, &lenses);
        assert_eq!(forth, bound_px(&motion.reversed(), &lenses.reversed()));
        let back = World {
            cameras: [a.cameras[1], a.cameras[0]],
            poses: [a.poses[1], a.poses[0]],
            sphere: a.sphere,
        };
        let (motion, lenses) = back.motion();
        let back = bound_px(&motion, &lenses);
        assert!(
            (forth - back).abs() <= 1e-6 * forth + 1e-9,
            "{forth} {back}"
        );
    }
}

#[test]
fn the_parts_of_a_motion_bound_the_whole() {
    let mut excess: Vec<f64> = Vec::new();
    for (a, _) in worlds(0..3000) {
        // Straight on half the way, then the rest.
        let half = Pose {
            position: a.poses[0].position.lerp(a.poses[1].position, 0.5),
            angles_deg: a.poses[0].angles_deg.lerp(a.poses[1].angles_deg, 0.5),
        };
        let still = a.cameras[0];
        let px = |from: &Pose, to: &Pose| {
            let m = RelativeMotion::between(&still, from, &still, to, &a.sphere);
            bound_px(&m, &Lenses::between(&still, &still, SIZE))
        };
        let parts = px(&a.poses[0], &half) + px(&half, &a.poses[1]);
        // The truth of the whole is not above the bounds of its parts.
        let whole = World {
            cameras: [still, still],
            ..a
        };
        let (motion, lenses) = whole.motion();
        let mut random = Random(3);
        let (_, u) = farthest(&motion, &lenses, 50, 50, &mut random);
        assert!(whole.moved(u) <= parts, "{} {parts}", whole.moved(u));
        let bound = bound_px(&motion, &lenses);
        if parts > 1e-9 && parts.is_finite() && bound.is_finite() {
            excess.push(bound / parts);
        }
    }
    excess.sort_by(f64::total_cmp);
    println!(
        "bound of the whole / of its parts: {:.4} (median) {:.4} (most)",
        quantile(&excess, 0.5),
        quantile(&excess, 1.0)
    );
    assert!((quantile(&excess, 0.5) - 1.0).abs() < 0.05);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let mut random = Random(77);
    let view = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 45.0)).unwrap();
    let next = Camera::look_at(
        DVec3::X * 0.01,
        DVec3::new(0.1, 0.0, 9.0),
        DVec3::Y,
        (59.0, 45.0),
    )
    .unwrap();
    let objects: Vec<(Pose, Pose, Sphere)> = (0..100_003)
        .map(|_| {
            let position = DVec3::Z * 10.0 + random.direction() * random.range(0.0, 12.0);
            let a = Pose {
                position,
                angles_deg: random.direction() * 90.0,
            };
            let b = Pose {
                position: position + random.direction() * 0.1,
                angles_deg: a.angles_deg + 1.0,
            };
            (
                a,
                b,
                Sphere {
                    centre: random.direction(),
                    radius: random.range(0.0, 2.0),
                },
            )
        })
        .collect();
    let observer = ObserverMotion::between(&view, &next);
    let lenses = Lenses::between(&view, &next, SIZE);
    let measure = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut out = vec![0.0; objects.len()];
        pool.install(|| bounds_px(&observer, &lenses, |i| objects[i], &mut out));
        out.iter().map(|px| px.to_bits()).collect::<Vec<_>>()
    };
    let one = measure(1);
    assert_eq!(one, measure(2));
    assert_eq!(one, measure(7));
    let alone = |i: usize| {
        bound_px(
            &observer.of(&objects[i].0, &objects[i].1, &objects[i].2),
            &lenses,
        )
    };
    assert!((0..objects.len()).all(|i| alone(i).to_bits() == one[i]));
}

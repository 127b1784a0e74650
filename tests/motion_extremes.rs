//! The extremes that every release survives: nothing panics, nothing is NaN,
//! and what is not certain is unbounded.

use decor::motion::{
    Lenses, ObserverMotion, Projection, RelativeMotion, Screen, Sighting, bound_orthographic_px,
    bound_px, bounds_px, first_in_view, project_sphere, project_sphere_orthographic, screen_box,
    thesis, thesis_px,
};
use decor_api::{Bounds, Camera, Pose, Size, Sphere};
use glam::{DVec2, DVec3};

const TINY: f64 = f64::MIN_POSITIVE / 1024.0;

/// All numbers that a place, a size or an angle can be spoilt by.
const ODD: [f64; 14] = [
    0.0,
    -0.0,
    TINY,
    -TINY,
    1e-200,
    1e-12,
    1.0,
    -1.0,
    1e8,
    1e200,
    f64::MAX,
    f64::INFINITY,
    f64::NEG_INFINITY,
    f64::NAN,
];

fn camera(eye: DVec3, aim: DVec3, angle_deg: f64) -> Camera {
    Camera::look_at(eye, aim, DVec3::Y, (angle_deg, angle_deg)).unwrap()
}

fn pose(position: DVec3, angles_deg: DVec3) -> Pose {
    Pose {
        position,
        angles_deg,
    }
}

/// Everything that this room says of a motion, with the promise that none of it is NaN.
fn measured(a: &Sighting, b: &Sighting, sphere: &Sphere, size: Size) -> f64 {
    let motion = RelativeMotion::between(&a.camera, &a.pose, &b.camera, &b.pose, sphere);
    let lenses = Lenses::between(&a.camera, &b.camera, size);
    let bound = bound_px(&motion, &lenses);
    let others = [
        thesis_px(&motion, &lenses),
        bound_orthographic_px(&motion, &lenses),
        bound_px(&motion.translation_only(), &lenses),
        bound_px(&motion.rotation_only(), &lenses),
        bound_px(&motion.reversed(), &lenses.reversed()),
    ];
    for px in others {
        assert!(px >= 0.0, "{px}: {motion:?}");
    }
    assert!(bound >= 0.0, "{bound}: {motion:?}");
    if let Some(t) = thesis(&motion, &lenses) {
        assert!(t.translation_px.is_finite() && t.rotation_px.is_finite());
    }
    let mut many = [f64::NAN];
    let observer = ObserverMotion::between(&a.camera, &b.camera);
    bounds_px(&observer, &lenses, |_| (a.pose, b.pose, *sphere), &mut many);
    assert_eq!(many[0].to_bits(), bound.to_bits());
    for (sighting, centre) in [(a, motion.centre_before), (b, motion.centre_after)] {
        match project_sphere(centre, sphere.radius) {
            Projection::Ellipse(e) => {
                let screen = Screen::of(&sighting.camera, size);
                assert!(!e.half_extent().is_nan() && !e.area().is_nan());
                assert!(screen.vertices_px(&e).iter().all(|v| !v.is_nan()));
                let (low, high) = screen.box_px(&e);
                assert!(!low.is_nan() && !high.is_nan() && !screen.area_px(&e).is_nan());
            }
            Projection::Behind | Projection::Unbounded => {
                assert_eq!(bound, f64::INFINITY, "{motion:?}");
            }
        }
        let _ = project_sphere_orthographic(centre, sphere.radius);
        let bounds = Bounds::sphere(sphere.centre, sphere.radius).posed(&sighting.pose);
        let _ = screen_box(&bounds, &sighting.camera, size);
    }
    let _ = first_in_view([*a, *b], sphere, size);
    bound
}

/// What a case must come out as.
enum Px {
    Still,
    Within(f64, f64),
    Unbounded,
    Anything,
}

#[test]
fn the_table_of_extremes() {
    use Px::*;
    let size = Size {
        width: 640,
        height: 480,
    };
    let ahead = |z: f64| pose(DVec3::Z * z, DVec3::ZERO);
    let view = camera(DVec3::ZERO, DVec3::Z, 60.0);
    let focal = view.focal(size).0;
    let moved = |a: Pose, b: Pose, radius: f64, px: Px, name: &str| {
        (name.to_owned(), view, a, view, b, radius, size, px)
    };
    let turned = |angle: f64, px: Px, name: &str| {
        moved(
            ahead(10.0),
            pose(DVec3::Z * 10.0, DVec3::Y * angle),
            1.0,
            px,
            name,
        )
    };
    let mut table = vec![
        moved(ahead(10.0), ahead(10.0), 1.0, Still, "nothing moves"),
        moved(
            ahead(10.0),
            pose(DVec3::new(1.0, 0.0, 10.0), DVec3::ZERO),
            0.0,
            Within(focal * 0.1, focal * 0.1001),
            "no extent",
        ),
        moved(ahead(10.0), ahead(10.0), 0.0, Still, "no extent, no motion"),
        moved(
            ahead(1.0),
            ahead(1.0 + 1e-9),
            1.0,
            Unbounded,
            "tangent to the plane of the eye",
        ),
        moved(
            ahead(1.0 + 1e-12),
            ahead(1.0 + 2e-12),
            1.0,
            Anything,
            "all but tangent",
        ),
        moved(ahead(-10.0), ahead(-9.0), 1.0, Unbounded, "behind"),
        moved(
            ahead(0.3),
            ahead(0.4),
            1.0,
            Unbounded,
            "around the observer",
        ),
        moved(
            ahead(10.0),
            ahead(0.3),
            1.0,
            Unbounded,
            "comes to be around the observer",
        ),
        moved(ahead(0.0), ahead(0.0), 0.0, Unbounded, "a point in the eye"),
        moved(
            ahead(TINY),
            ahead(2.0 * TINY),
            0.0,
            Unbounded,
            "denormal places",
        ),
        moved(
            ahead(1.0),
            pose(DVec3::new(TINY, 0.0, 1.0), DVec3::ZERO),
            0.5,
            Within(0.0, 1e-100),
            "a denormal motion",
        ),
        moved(
            ahead(1.0),
            pose(DVec3::Z, DVec3::Y * TINY),
            0.5,
            Within(0.0, 1e-100),
            "a denormal rotation",
        ),
        moved(
            ahead(1e300),
            ahead(1e300 + 1e290),
            1.0,
            Unbounded,
            "too far to measure",
        ),
        moved(
            ahead(1e9),
            ahead(1e9 + 1.0),
            0.01,
            Within(0.0, 1e-6),
            "far, near/far ratio of 1e9",
        ),
        turned(0.0, Still, "no rotation"),
        turned(
            1e-12f64.to_degrees(),
            Within(focal * 1e-12 / 9.0, focal * 1e-12 / 4.0),
            "1e-12 rad",
        ),
        turned(180.0, Within(focal * 0.2, focal * 0.3), "half a turn"),
        turned(360.0, Within(0.0, 1e-9), "a whole turn"),
        turned(
            360.0 * 1e6 + 1.0,
            Within(0.0, 10.0),
            "many turns and a degree",
        ),
        turned(
            1e300,
            Within(0.0, focal),
            "more turns than there are digits",
        ),
    ];
    for angle in [0.001, 1.0, 90.0, 179.0, 179.9] {
        let narrow = camera(DVec3::ZERO, DVec3::Z, angle);
        let after = pose(DVec3::new(1e-6, 0.0, 10.0), DVec3::ZERO);
        let px = narrow.focal(size).0 * 1e-7;
        table.push((
            format!("an opening of {angle} degrees"),
            narrow,
            ahead(10.0),
            narrow,
            after,
            1e-4,
            size,
            Within(px, px * 1.01),
        ));
        // A zoom from and to it.
        table.push((
            format!("a zoom from {angle} degrees"),
            narrow,
            ahead(10.0),
            view,
            ahead(10.0),
            1.0,
            size,
            Anything,
        ));
    }
    for (width, height) in [(1, 1), (1, 65535), (65535, 1)] {
        let after = pose(DVec3::new(1.0, 1.0, 10.0), DVec3::ZERO);
        table.push((
            format!("a picture of {width} x {height}"),
            view,
            ahead(10.0),
            view,
            after,
            1.0,
            Size { width, height },
            Within(0.05, 1e5),
        ));
    }
    for exponent in 0..=12 {
        let radius = 10f64.powi(-exponent) * 0.999 * 10.0;
        let after = pose(DVec3::new(1e-3, 0.0, 10.0), DVec3::ZERO);
        let px = focal * 1e-3 / (10.0 - radius);
        table.push((
            format!("R/D = {:e}", radius / 10.0),
            view,
            ahead(10.0),
            view,
            after,
            radius,
            size,
            Within(px, px * 1.001),
        ));
    }
    let far = DVec3::new(1e8, -1e8, 1e8);
    let there = camera(far, far + DVec3::Z, 60.0);
    let (a, b) = (far + DVec3::Z * 10.0, far + DVec3::new(1e-6, 0.0, 10.0));
    let step = focal * (b - a).x / 9.0;
    table.push((
        "1e8 away, a motion of 1e-6".into(),
        there,
        pose(a, DVec3::ZERO),
        there,
        pose(b, DVec3::ZERO),
        1.0,
        size,
        Within(step, step * 1.001),
    ));
    let beside = camera(
        far + DVec3::X * 1e-6,
        far + DVec3::new(1e-6, 0.0, 1.0),
        60.0,
    );
    let carried = beside.eye - there.eye;
    table.push((
        "1e8 away, a cockpit that flies with its pilot".into(),
        there,
        pose(a, DVec3::ZERO),
        beside,
        pose(a + carried, DVec3::ZERO),
        1.0,
        size,
        Within(0.0, 1e-10),
    ));

    for (name, camera_a, pose_a, camera_b, pose_b, radius, size, expected) in table {
        let sphere = Sphere {
            centre: DVec3::ZERO,
            radius,
        };
        let (a, b) = (
            Sighting {
                camera: camera_a,
                pose: pose_a,
            },
            Sighting {
                camera: camera_b,
                pose: pose_b,
            },
        );
        let px = measured(&a, &b, &sphere, size);
        println!("{name:>45}: {px:.6e} px");
        match expected {
            Still => assert_eq!(px, 0.0, "{name}"),
            Within(low, high) => {
                assert!(
                    px >= low * (1.0 - 1e-9) && px <= high,
                    "{name}: {px} in {low}..{high}"
                );
            }
            Unbounded => assert_eq!(px, f64::INFINITY, "{name}"),
            Anything => {}
        }
    }
}

#[test]
fn every_number_that_is_odd_in_every_place() {
    let size = Size {
        width: 100,
        height: 100,
    };
    let view = camera(DVec3::ZERO, DVec3::Z, 60.0);
    let other = camera(DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.0, 1.0, 9.0), 50.0);
    let good = [0.5, 0.25, 10.0, 10.0, 20.0, 30.0, 0.1, 0.2, 0.3, 1.0];
    let mut count = 0;
    for slot in 0..good.len() {
        for second in 0..good.len() {
            for odd in ODD {
                for odder in ODD {
                    let mut v = good;
                    (v[slot], v[second]) = (odd, odder);
                    let sphere = Sphere {
                        centre: DVec3::new(v[6], v[7], v[8]),
                        radius: v[9],
                    };
                    let bad = pose(DVec3::new(v[0], v[1], v[2]), DVec3::new(v[3], v[4], v[5]));
                    let fine = pose(DVec3::new(0.5, 0.25, 10.0), DVec3::ZERO);
                    let bad = Sighting {
                        camera: view,
                        pose: bad,
                    };
                    let fine = Sighting {
                        camera: other,
                        pose: fine,
                    };
                    for (a, b) in [(&bad, &fine), (&fine, &bad), (&bad, &bad)] {
                        let px = measured(a, b, &sphere, size);
                        if v.iter().any(|n| !n.is_finite()) || v[9] < 0.0 {
                            assert_eq!(px, f64::INFINITY, "{v:?}");
                            // Not certain is not out of the picture.
                            assert!(first_in_view([*a, *b], &sphere, size).is_some(), "{v:?}");
                        }
                        count += 1;
                    }
                }
            }
        }
    }
    println!("{count} motions with odd numbers: none NaN, all of what is not finite unbounded");
}

#[test]
fn motions_given_in_camera_space_are_not_trusted_either() {
    let lenses = Lenses::fixed(DVec2::splat(100.0));
    for odd in ODD {
        for slot in 0..10 {
            let mut v = [0.5, 0.25, 10.0, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 1.0];
            v[slot] = odd;
            let three = |i: usize| DVec3::new(v[i], v[i + 1], v[i + 2]);
            let motion = RelativeMotion::in_camera_space(three(0), three(3), three(6), v[9]);
            let (bound, thesis) = (bound_px(&motion, &lenses), thesis_px(&motion, &lenses));
            assert!(bound >= 0.0 && thesis >= 0.0, "{v:?}");
            if !odd.is_finite() {
                assert_eq!((bound, thesis), (f64::INFINITY, f64::INFINITY), "{v:?}");
            }
        }
        for wrong in [
            Lenses::fixed(DVec2::splat(odd)),
            Lenses::zoom(DVec2::ONE, DVec2::splat(odd)),
        ] {
            let motion = RelativeMotion::in_camera_space(DVec3::Z, DVec3::X, DVec3::ZERO, 0.5);
            assert!(bound_px(&motion, &wrong) >= 0.0);
            assert!(thesis_px(&motion, &wrong) >= 0.0);
        }
    }
}

#[test]
fn ten_thousand_identical_objects_and_none_at_all() {
    let size = Size {
        width: 100,
        height: 100,
    };
    let view = camera(DVec3::ZERO, DVec3::Z, 60.0);
    let observer = ObserverMotion::between(&view, &view);
    let lenses = Lenses::between(&view, &view, size);
    let object = |_| {
        let sphere = Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        };
        (
            pose(DVec3::Z * 9.0, DVec3::ZERO),
            pose(DVec3::new(0.1, 0.0, 9.0), DVec3::X),
            sphere,
        )
    };
    let mut out = vec![f64::NAN; 10_000];
    bounds_px(&observer, &lenses, object, &mut out);
    assert!(out.iter().all(|px| px.to_bits() == out[0].to_bits()));
    bounds_px(&observer, &lenses, object, &mut []);
    assert_eq!(
        first_in_view(
            [],
            &Sphere {
                centre: DVec3::ZERO,
                radius: 1.0
            },
            size
        ),
        None
    );
}

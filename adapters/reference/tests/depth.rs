//! Depth against the formulas, near and far, and where nothing is.

mod common;

use common::{Stage, camera, cube, plane, size, sphere, vec3};
use decor_api::{Camera, Csg, Output, Pose};
use glam::DVec3;
use proptest::prelude::*;

/// The depth picture against `expected(direction of length 1)`, +∞ for nothing.
fn assert_depth(stage: &Stage, expected: impl Fn(DVec3) -> f64) {
    let size = size(48, 40);
    let layer = stage.drawn(size, Output::Depth, None);
    assert!(layer.colour.is_none());
    let depth = layer.depth.as_ref().unwrap();
    let mut hits = 0;
    for y in 0..size.height {
        for x in 0..size.width {
            let (px, py) = (f64::from(x) + 0.5, f64::from(y) + 0.5);
            let direction = stage.scene.camera.direction(size, px, py).normalize();
            let want = expected(direction);
            let got = depth[layer.index(x, y)];
            let (absolute, relative) = layer.depth_quantum;
            let quantum = absolute + relative * want;
            if want.is_finite() {
                hits += 1;
                assert!(
                    (got - want).abs() <= quantum,
                    "({x}, {y}): {got}, not {want}"
                );
            } else {
                assert_eq!(got, f64::INFINITY, "({x}, {y})");
            }
        }
    }
    assert!(hits > 50, "hardly anything was seen: {hits}");
}

#[test]
fn a_sphere() {
    let (centre, radius) = (vec3(0.5, -0.25, 1.0), 2.0);
    let stage = Stage::of([sphere(centre.x, centre.y, centre.z, radius)]);
    assert_depth(&stage, |d| {
        let to = centre - stage.scene.camera.eye;
        let beside = radius * radius - to.cross(d).length_squared();
        if beside > 0.0 {
            to.dot(d) - beside.sqrt()
        } else {
            f64::INFINITY
        }
    });
}

#[test]
fn a_box_seen_straight_on() {
    let stage = Stage::of([cube(1.5)]);
    assert_depth(&stage, |d| {
        // Its front face hides the rest of it.
        let t = 8.5 / d.z;
        let p = d * t;
        if p.x.abs() < 1.5 && p.y.abs() < 1.5 {
            t
        } else {
            f64::INFINITY
        }
    });
}

#[test]
fn a_ground_plane_up_to_its_horizon() {
    let stage = Stage::of([plane(vec3(0.0, 2.0, 0.0), -1.0)]);
    assert_depth(
        &stage,
        |d| {
            if d.y < 0.0 { -1.0 / d.y } else { f64::INFINITY }
        },
    );
}

#[test]
fn a_cylinder_across_the_view() {
    let stage = Stage::of([Csg::Cylinder {
        base: vec3(-50.0, 0.0, 0.0),
        cap: vec3(50.0, 0.0, 0.0),
        radius: 2.0,
    }]);
    assert_depth(&stage, |d| {
        // In the plane across its axis it is a circle.
        let across = d.y.hypot(d.z);
        let (cosine, sine) = (d.z / across, d.y / across);
        let beside = 4.0 - 100.0 * sine * sine;
        if beside > 0.0 {
            (10.0 * cosine - beside.sqrt()) / across
        } else {
            f64::INFINITY
        }
    });
}

#[test]
fn a_cone_satisfies_its_equation_and_so_does_a_torus() {
    let cone = Csg::Cone {
        base: vec3(0.0, -2.0, 0.0),
        base_radius: 2.0,
        cap: vec3(0.0, 2.0, 0.0),
        cap_radius: 0.5,
    };
    let ring = Csg::Torus {
        major: 2.0,
        minor: 0.7,
    };
    let turned = Csg::Rotate(vec3(-60.0, 0.0, 20.0), Box::new(ring));
    let rotation = decor_api::scene::rotation(vec3(-60.0, 0.0, 20.0)).inverse();
    let on_cone = |p: DVec3| {
        let on_mantle = p.x.hypot(p.z) - (2.0 - 0.375 * (p.y + 2.0));
        on_mantle.abs().min((p.y.abs() - 2.0).abs())
    };
    let on_torus = |p: DVec3| {
        let p = rotation * p;
        ((p.x.hypot(p.z) - 2.0).hypot(p.y) - 0.7).abs()
    };
    let (cone, torus) = (Stage::of([cone]).world(), Stage::of([turned]).world());
    let eye = DVec3::Z * -10.0;
    let mut hits = 0;
    for i in 0..10_000 {
        let (x, y) = (f64::from(i % 100) - 49.5, f64::from(i / 100) - 49.5);
        let direction = vec3(x / 100.0, y / 100.0, 1.0);
        if let Some(hit) = cone.cast(eye, direction) {
            assert!(on_cone(hit.point) < 1e-9 && hit.normal.dot(direction) < 0.0);
            hits += 1;
        }
        if let Some(hit) = torus.cast(eye, direction) {
            assert!(on_torus(hit.point) < 1e-9 && hit.normal.dot(direction) < 0.0);
            hits += 1;
        }
    }
    assert!(hits > 1000, "{hits}");
}

#[test]
fn near_and_far_a_billion_apart() {
    let stage = Stage::of([
        Csg::Translate(vec3(1e-3, 0.0, 0.0), Box::new(sphere(0.0, 0.0, 1.0, 1e-4))),
        sphere(0.0, 0.0, 1e9, 1e7),
    ]);
    let near = stage.distance(DVec3::ZERO, vec3(1e-3, 0.0, 1.0));
    let want = 1e-3_f64.hypot(1.0) - 1e-4;
    assert!((near - want).abs() < 1e-15, "{near}");
    let far = stage.distance(DVec3::ZERO, DVec3::Z);
    assert!((far - 0.99e9).abs() < 1e-6, "{far}");
}

#[test]
fn coordinates_of_a_hundred_million() {
    let away = vec3(1e8, -1e8, 1e8);
    for (tree, want) in [
        (sphere(0.0, 0.0, 0.0, 1.0), 4.0),
        (cube(1.0), 4.0),
        (
            Csg::Torus {
                major: 0.75,
                minor: 0.25,
            },
            4.0,
        ),
        (
            Csg::Cylinder {
                base: DVec3::Z * -1.0,
                cap: DVec3::Z,
                radius: 1.0,
            },
            4.0,
        ),
    ] {
        let mut stage = Stage::of([]);
        let pose = Pose {
            position: away,
            angles_deg: vec3(0.0, 0.0, 720.0),
        };
        stage.add(tree, pose);
        let got = stage.distance(away - DVec3::Z * 5.0, DVec3::Z);
        assert!((got - want).abs() < 1e-12, "{got}");
        // A point on its own surface is seen from the eye: no false shadows.
        let world = stage.world();
        let eye = away - DVec3::Z * 5.0;
        let hit = world.cast(eye, DVec3::Z).unwrap();
        assert!(world.is_clear(eye, hit.point));
        assert!(!world.is_clear(eye, away + DVec3::Z * 5.0));
    }
}

#[test]
fn nothing_is_infinitely_far() {
    let layer = Stage::of([]).drawn(size(5, 3), Output::ColourAlone { with_sky: false }, None);
    assert_eq!(layer.depth, Some(vec![f64::INFINITY; 15]));
    assert_eq!(layer.colour, Some(vec![[0.0; 4]; 15]));
    let layer = Stage::of([]).drawn(size(1, 1), Output::ColourOverBackground, None);
    assert_eq!(layer.colour, Some(vec![[0.25, 0.5, 0.75, 1.0]]));
}

#[test]
fn an_observer_inside_sees_the_far_side() {
    for (tree, want) in [
        (sphere(0.0, 0.0, -10.0, 3.0), 3.0),
        (Csg::Translate(DVec3::Z * -10.0, Box::new(cube(2.0))), 2.0),
        (
            // Inside what was cut out.
            Csg::Difference(
                Box::new(sphere(0.0, 0.0, -10.0, 5.0)),
                vec![sphere(0.0, 0.0, -10.0, 4.0)],
            ),
            4.0,
        ),
    ] {
        assert_eq!(Stage::of([tree]).distance(DVec3::Z * -10.0, DVec3::Z), want);
    }
    let below = Stage::of([plane(DVec3::Y, 1.0)]);
    assert_eq!(below.distance(DVec3::ZERO, DVec3::Y), 1.0);
    assert_eq!(below.distance(DVec3::ZERO, DVec3::X), f64::INFINITY);
}

#[test]
fn of_two_at_one_place_the_first_listed_is_seen() {
    let stage = Stage::of([cube(1.0), cube(1.0), sphere(0.0, 0.0, 0.0, 0.5)]);
    let hit = stage.world().cast(DVec3::Z * -5.0, DVec3::Z).unwrap();
    assert_eq!((hit.instance, hit.distance), (0, 4.0));
    assert_eq!(hit.normal, -DVec3::Z);

    // Whatever the order in which a tree comes upon them.
    let slab = |i: i32| Csg::Box {
        min: vec3(-1.0 - f64::from(i % 7), -1.0, -1.0),
        max: vec3(1.0, 1.0 + f64::from(i % 5), f64::from(i)),
    };
    for slabs in [
        (0..30).map(slab).collect::<Vec<_>>(),
        (0..30).rev().map(slab).collect(),
    ] {
        let world = Stage::of(slabs).world();
        let hit = world.cast(DVec3::Z * -5.0, DVec3::Z).unwrap();
        assert_eq!((hit.instance, hit.distance), (0, 4.0));
    }
}

#[test]
fn wide_and_narrow_views() {
    let ball = || Stage::of([sphere(0.0, 0.0, 0.0, 1.0)]);
    for angle in [0.001, 179.9] {
        let eye = DVec3::Z * -10.0;
        let view = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, (angle, angle)).unwrap();
        let stage = ball().seen_from(view);
        let layer = stage.drawn(size(3, 3), Output::Depth, None);
        assert_eq!(layer.depth.unwrap()[4], 9.0);
    }
    let line = ball().drawn(size(1, 65_535), Output::Depth, None);
    assert_eq!(line.depth.unwrap()[32_767], 9.0);
    assert_eq!(camera().eye, DVec3::Z * -10.0);
}

/// From the smallest to the largest numbers, with 0, and some that are none.
fn wild() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -5.0..5.0,
        1 => Just(0.0),
        1 => prop::sample::select(vec![
            1e-320, 1e-200, 1e-12, 1e-6, 1e6, 1e8, 1e12, 1e155, 1e300, f64::MAX,
            -1e-320, -1e8, -1e200, f64::NAN, f64::INFINITY, f64::NEG_INFINITY,
        ]),
    ]
}

fn wild3() -> impl Strategy<Value = DVec3> {
    (wild(), wild(), wild()).prop_map(|(x, y, z)| vec3(x, y, z))
}

fn wild_tree() -> impl Strategy<Value = Csg> {
    let leaf = prop_oneof![
        (wild3(), wild()).prop_map(|(centre, radius)| Csg::Sphere { centre, radius }),
        (wild3(), wild3()).prop_map(|(min, max)| Csg::Box { min, max }),
        (wild3(), wild3(), wild(), wild()).prop_map(|(base, cap, base_radius, cap_radius)| {
            Csg::Cone {
                base,
                base_radius,
                cap,
                cap_radius,
            }
        }),
        (wild(), wild()).prop_map(|(major, minor)| Csg::Torus { major, minor }),
        (wild3(), wild()).prop_map(|(normal, distance)| plane(normal, distance)),
        prop::collection::vec(wild3(), 3..6).prop_map(|vertices| {
            let triangles = vec![[0, 1, 2], [2, 1, 0], [0, 0, 1], [0, 2, 7]];
            Csg::Mesh(std::sync::Arc::new(decor_api::TriangleMesh {
                vertices,
                triangles,
            }))
        }),
    ];
    leaf.prop_recursive(3, 8, 3, |inner| {
        let some = || prop::collection::vec(inner.clone(), 0..3);
        let boxed = || inner.clone().prop_map(Box::new);
        prop_oneof![
            some().prop_map(Csg::Union),
            some().prop_map(Csg::Intersection),
            (boxed(), some()).prop_map(|(first, rest)| Csg::Difference(first, rest)),
            (wild3(), boxed()).prop_map(|(by, tree)| Csg::Translate(by, tree)),
            (wild3(), boxed()).prop_map(|(angles, tree)| Csg::Rotate(angles, tree)),
            (wild3(), boxed()).prop_map(|(factors, tree)| Csg::Scale(factors, tree)),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(5000))]

    #[test]
    fn no_input_panics_or_gives_what_is_no_number(
        trees in prop::collection::vec((wild_tree(), wild3(), wild3()), 1..4),
        origin in wild3(),
        direction in wild3(),
    ) {
        let mut stage = Stage::of([]);
        for (tree, position, angles_deg) in trees {
            stage.add(tree, Pose { position, angles_deg });
        }
        if let Some(hit) = stage.world().cast(origin, direction) {
            prop_assert!(hit.distance > 0.0 && hit.distance.is_finite());
            prop_assert!(hit.normal.is_finite());
            prop_assert!((hit.normal.length() - 1.0).abs() < 1e-9);
        }
    }
}

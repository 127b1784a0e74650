use std::sync::Arc;

use glam::dvec3;
use proptest::prelude::*;

use super::*;
use crate::material::Material;
use crate::mesh::TriangleMesh;

fn sphere_of(csg: &Csg) -> Sphere {
    match csg.bounds() {
        Bounds::Sphere(sphere) => sphere,
        other => panic!("{other:?} around {csg:?}"),
    }
}

fn assert_sphere(csg: &Csg, centre: DVec3, radius: f64) {
    let sphere = sphere_of(csg);
    let size = radius + centre.length();
    assert!(
        (sphere.centre - centre).length() < 1e-9 * size,
        "{sphere:?}"
    );
    assert!((sphere.radius - radius).abs() < 1e-9 * size, "{sphere:?}");
}

fn ball(centre: DVec3, radius: f64) -> Csg {
    Csg::Sphere { centre, radius }
}

fn cuboid(min: DVec3, max: DVec3) -> Csg {
    Csg::Box { min, max }
}

fn mesh(vertices: Vec<DVec3>) -> Csg {
    let count = vertices.len() as u32;
    let triangles = (2..count).map(|i| [0, i - 1, i]).collect();
    Csg::Mesh(Arc::new(TriangleMesh {
        vertices,
        triangles,
    }))
}

fn plane(normal: DVec3, distance: f64) -> Csg {
    Csg::Plane { normal, distance }
}

#[test]
fn primitives_are_exact() {
    assert_sphere(&ball(dvec3(1.0, 2.0, 3.0), 4.0), dvec3(1.0, 2.0, 3.0), 4.0);
    let cube = cuboid(DVec3::ZERO, dvec3(2.0, 4.0, 4.0));
    assert_sphere(&cube, dvec3(1.0, 2.0, 2.0), 3.0);
    let cylinder = Csg::Cylinder {
        base: DVec3::ZERO,
        cap: dvec3(0.0, 8.0, 0.0),
        radius: 3.0,
    };
    assert_sphere(&cylinder, dvec3(0.0, 4.0, 0.0), 5.0);
    let cone = |base_radius, cap_radius, height| Csg::Cone {
        base: DVec3::ZERO,
        base_radius,
        cap: DVec3::Z * height,
        cap_radius,
    };
    // A flat cone's sphere is that of its base, a steep one's goes through the tip.
    assert_sphere(&cone(4.0, 0.0, 1.0), DVec3::ZERO, 4.0);
    assert_sphere(&cone(0.0, 4.0, 1.0), DVec3::Z, 4.0);
    assert_sphere(&cone(4.0, 0.0, 8.0), DVec3::Z * 3.0, 5.0);
    assert_sphere(&cone(3.0, 3.0, 8.0), DVec3::Z * 4.0, 5.0);
    let torus = Csg::Torus {
        major: 3.0,
        minor: 1.0,
    };
    assert_sphere(&torus, DVec3::ZERO, 4.0);
}

#[test]
fn turning_and_moving_keep_exactness() {
    let moved = |node| {
        let turned = Csg::Rotate(dvec3(10.0, 20.0, 30.0), Box::new(node));
        let scaled = Csg::Scale(dvec3(-2.0, 2.0, 2.0), Box::new(turned));
        Csg::Translate(dvec3(1.0, 1.0, 1.0), Box::new(scaled))
    };
    let centre = DVec3::ONE;
    let shapes = [
        (ball(DVec3::ZERO, 3.0), 3.0),
        (cuboid(-dvec3(1.0, 2.0, 2.0), dvec3(1.0, 2.0, 2.0)), 3.0),
        (
            Csg::Cylinder {
                base: -DVec3::X * 4.0,
                cap: DVec3::X * 4.0,
                radius: 3.0,
            },
            5.0,
        ),
        (
            Csg::Torus {
                major: 2.0,
                minor: 1.0,
            },
            3.0,
        ),
        (
            mesh(corners(-DVec3::ONE, DVec3::ONE).to_vec()),
            3.0_f64.sqrt(),
        ),
    ];
    for (shape, radius) in shapes {
        assert_sphere(&moved(shape), centre, 2.0 * radius);
    }
}

#[test]
fn an_ellipsoid_is_as_long_as_its_longest_axis() {
    let egg = Csg::Scale(dvec3(1.0, 3.0, 2.0), Box::new(ball(DVec3::ZERO, 1.0)));
    let turned = Csg::Rotate(dvec3(0.0, 0.0, 45.0), Box::new(egg));
    let sphere = sphere_of(&turned);
    assert!((3.0..3.0 * 1.0001).contains(&sphere.radius), "{sphere:?}");
}

#[test]
fn a_turned_union_is_as_tight_as_it_was() {
    let dumbbell = Csg::Union(vec![
        ball(dvec3(-5.0, 0.0, 0.0), 1.0),
        ball(dvec3(5.0, 0.0, 0.0), 2.0),
        ball(DVec3::ZERO, 1.0),
    ]);
    assert_sphere(&dumbbell, dvec3(0.5, 0.0, 0.0), 6.5);
    let turned = Csg::Rotate(dvec3(0.0, 0.0, 90.0), Box::new(dumbbell));
    assert_sphere(&turned, dvec3(0.0, 0.5, 0.0), 6.5);
    // Not the sphere around two spheres, which is larger.
    let halves = Csg::Union(vec![
        cuboid(dvec3(-1.0, -1.0, -1.0), dvec3(0.0, 1.0, 1.0)),
        cuboid(dvec3(0.0, -1.0, -1.0), dvec3(1.0, 1.0, 1.0)),
    ]);
    assert_sphere(&halves, DVec3::ZERO, 3.0_f64.sqrt());
}

#[test]
fn planes_have_no_end_but_cut() {
    assert_eq!(plane(DVec3::Y, 0.0).bounds(), Bounds::Unbounded);
    let with_a_ball = Csg::Union(vec![ball(DVec3::ZERO, 1.0), plane(DVec3::Y, 0.0)]);
    assert_eq!(with_a_ball.bounds(), Bounds::Unbounded);
    let outside = Csg::Difference(Box::new(plane(DVec3::Y, 0.0)), vec![ball(DVec3::ZERO, 1.0)]);
    assert_eq!(outside.bounds(), Bounds::Unbounded);

    let half = Csg::Intersection(vec![ball(DVec3::ZERO, 1.0), plane(DVec3::ONE, 0.0)]);
    assert_sphere(&half, DVec3::ZERO, 1.0);
    // A thin slice of a large ball: the box of the planes is the smaller one.
    let cube = [DVec3::X, DVec3::Y, DVec3::Z].into_iter();
    let cube = cube.flat_map(|n| [plane(n, 1.0), plane(-n, 1.0)]).collect();
    let cube = Csg::Intersection(cube);
    assert_sphere(&cube, DVec3::ZERO, 3.0_f64.sqrt());
    let moved = Csg::Translate(dvec3(0.0, 7.0, 0.0), Box::new(cube.clone()));
    assert_sphere(&moved, dvec3(0.0, 7.0, 0.0), 3.0_f64.sqrt());
    let in_a_ball = Csg::Intersection(vec![ball(DVec3::ZERO, 100.0), cube]);
    assert_sphere(&in_a_ball, DVec3::ZERO, 3.0_f64.sqrt());
}

#[test]
fn what_is_nowhere_is_empty() {
    let apart = vec![ball(DVec3::ZERO, 1.0), ball(DVec3::X * 3.0, 1.0)];
    assert_eq!(Csg::Intersection(apart).bounds(), Bounds::Empty);
    assert_eq!(Csg::Union(Vec::new()).bounds(), Bounds::Empty);
    assert_eq!(mesh(Vec::new()).bounds(), Bounds::Empty);
    let one = Csg::Union(vec![mesh(Vec::new()), ball(DVec3::ZERO, 1.0)]);
    assert_sphere(&one, DVec3::ZERO, 1.0);
}

#[test]
fn what_overflows_has_no_end() {
    let huge = |factor: f64, node| Csg::Scale(DVec3::splat(factor), Box::new(node));
    let too_large = [
        huge(1e300, ball(DVec3::ZERO, 1e300)),
        huge(1e300, cuboid(DVec3::ZERO, DVec3::splat(1e300))),
        huge(1e300, mesh(vec![DVec3::ZERO, DVec3::X, DVec3::Y * 1e300])),
        ball(DVec3::splat(1e308), 1e308),
    ];
    for node in too_large {
        let union = Csg::Union(vec![ball(DVec3::ZERO, 1.0), node]);
        assert_eq!(union.bounds(), Bounds::Unbounded, "{union:?}");
    }
    // Squares of these are 0; they are still contained.
    let tiny = mesh(vec![DVec3::ZERO, DVec3::X * 1e-200, DVec3::Y * 1e-200]);
    let sphere = sphere_of(&tiny);
    assert!(sphere.radius >= 0.5e-200 * 2.0_f64.sqrt(), "{sphere:?}");
    assert!(sphere.radius <= 1e-200, "{sphere:?}");
}

#[test]
fn a_long_way_there_and_back_keeps_what_it_loses() {
    let there = |by: f64, node| Csg::Translate(DVec3::splat(by), Box::new(node));
    let turned = Csg::Rotate(
        dvec3(0.0, 33.0, 0.0),
        Box::new(there(1e9, ball(DVec3::ZERO, 1.0))),
    );
    let back = Csg::Rotate(dvec3(0.0, -33.0, 0.0), Box::new(turned));
    let sphere = sphere_of(&there(-1e9, back));
    assert!(sphere.centre.length() + 1.0 <= sphere.radius, "{sphere:?}");
    assert!(sphere.radius < 1.001, "{sphere:?}");
}

/// The radius of the smallest ball around points, by trying every ball that up
/// to four of them span. For a dozen points, and no more.
fn smallest_radius(points: &[DVec3]) -> f64 {
    fn circumball(support: &[DVec3]) -> Option<(DVec3, f64)> {
        let origin = support[0];
        let d: Vec<DVec3> = support[1..].iter().map(|p| *p - origin).collect();
        let centre = match d[..] {
            [] => DVec3::ZERO,
            [a] => a / 2.0,
            [a, b] => {
                let n = a.cross(b);
                let up = (a.length_squared() * b - b.length_squared() * a).cross(n);
                up / (2.0 * n.length_squared())
            }
            [a, b, c] => {
                let (aa, bb, cc) = (a.length_squared(), b.length_squared(), c.length_squared());
                let up = aa * b.cross(c) + bb * c.cross(a) + cc * a.cross(b);
                up / (2.0 * a.dot(b.cross(c)))
            }
            _ => return None,
        };
        centre
            .is_finite()
            .then(|| (origin + centre, centre.length()))
    }
    let mut least = f64::INFINITY;
    for subset in 1_u32..1 << points.len() {
        if subset.count_ones() > 4 {
            continue;
        }
        let chosen = (0..points.len()).filter(|i| subset & (1 << i) != 0);
        let support: Vec<DVec3> = chosen.map(|i| points[i]).collect();
        let Some((centre, radius)) = circumball(&support) else {
            continue;
        };
        let around = |p: &DVec3| (*p - centre).length() <= radius * (1.0 + 1e-9) + 1e-12;
        if radius < least && points.iter().all(around) {
            least = radius;
        }
    }
    least
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![-10.0..10.0_f64, (-3_i32..=3).prop_map(f64::from)]
}

fn vector() -> impl Strategy<Value = DVec3> {
    [coordinate(), coordinate(), coordinate()].prop_map(DVec3::from_array)
}

fn length() -> impl Strategy<Value = f64> {
    prop_oneof![0.01..5.0_f64, Just(1.0)]
}

/// Factors that are not 0, some of them negative, some equal.
fn factors() -> impl Strategy<Value = DVec3> {
    let factor = || (0.1..4.0_f64, any::<bool>()).prop_map(|(f, neg)| if neg { -f } else { f });
    prop_oneof![
        [factor(), factor(), factor()].prop_map(DVec3::from_array),
        factor().prop_map(DVec3::splat),
    ]
}

fn primitive() -> impl Strategy<Value = Csg> {
    prop_oneof![
        (vector(), length()).prop_map(|(centre, radius)| ball(centre, radius)),
        (vector(), length(), length(), length())
            .prop_map(|(min, x, y, z)| cuboid(min, min + dvec3(x, y, z))),
        (vector(), vector(), length()).prop_map(|(base, way, radius)| Csg::Cylinder {
            base,
            cap: base + way + DVec3::X * 0.1,
            radius,
        }),
        (vector(), vector(), length(), 0.0..3.0_f64).prop_map(|(base, way, a, b)| Csg::Cone {
            base,
            base_radius: a,
            cap: base + way + DVec3::X * 0.1,
            cap_radius: b,
        }),
        (length(), 0.01..1.0_f64).prop_map(|(major, share)| Csg::Torus {
            major,
            minor: major * share,
        }),
        (vector(), -2.0..2.0_f64).prop_map(|(n, distance)| plane(n + DVec3::X * 0.01, distance)),
        prop::collection::vec(vector(), 3..9).prop_map(mesh),
    ]
}

fn tree() -> impl Strategy<Value = Csg> {
    primitive().prop_recursive(4, 12, 3, |node| {
        let some = || prop::collection::vec(node.clone(), 1..4);
        prop_oneof![
            some().prop_map(Csg::Union),
            some().prop_map(Csg::Intersection),
            (node.clone(), some()).prop_map(|(a, b)| Csg::Difference(Box::new(a), b)),
            (vector(), node.clone()).prop_map(|(v, n)| Csg::Translate(v, Box::new(n))),
            (vector(), node.clone()).prop_map(|(v, n)| Csg::Rotate(v * 36.0, Box::new(n))),
            (factors(), node.clone()).prop_map(|(v, n)| Csg::Scale(v, Box::new(n))),
            node.clone()
                .prop_map(|n| Csg::Look(Material::default(), Box::new(n))),
        ]
    })
}

/// Points of a node: on its surface where `shares` are at their ends, inside of
/// it otherwise. `None` for what has no end.
fn point_of(node: &Csg, shares: &mut dyn FnMut() -> f64) -> Option<DVec3> {
    Some(match node {
        Csg::Sphere { centre, radius } => *centre + *radius * direction(shares),
        Csg::Box { min, max } => {
            let share = dvec3(shares(), shares(), shares());
            *min + (*max - *min) * share
        }
        Csg::Cylinder { base, cap, radius } => {
            cone_point((*base, *radius), (*cap, *radius), shares)
        }
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => cone_point((*base, *base_radius), (*cap, *cap_radius), shares),
        Csg::Torus { major, minor } => {
            let (sin, cos) = (TAU * shares()).sin_cos();
            let (up, out) = (TAU * shares()).sin_cos();
            let from_axis = major + minor * out;
            dvec3(cos * from_axis, minor * up, sin * from_axis)
        }
        Csg::Mesh(mesh) => {
            let all = mesh.triangles.len();
            let chosen = mesh.corners().nth((shares() * (all - 1) as f64) as usize)?;
            let (u, v) = (shares(), shares());
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            chosen[0] + (chosen[1] - chosen[0]) * u + (chosen[2] - chosen[0]) * v
        }
        Csg::Plane { .. } => return None,
        Csg::Union(nodes) | Csg::Intersection(nodes) => {
            let which = (shares() * nodes.len() as f64) as usize;
            return point_of(&nodes[which.min(nodes.len() - 1)], shares);
        }
        Csg::Difference(first, _) => return point_of(first, shares),
        Csg::Translate(by, node) => point_of(node, shares)? + *by,
        Csg::Rotate(angles, node) => rotation(*angles) * point_of(node, shares)?,
        Csg::Scale(factors, node) => point_of(node, shares)? * *factors,
        Csg::Look(_, node) => return point_of(node, shares),
    })
}

fn direction(shares: &mut dyn FnMut() -> f64) -> DVec3 {
    let height = 2.0 * shares() - 1.0;
    let (sin, cos) = (TAU * shares()).sin_cos();
    let around = (1.0 - height * height).sqrt();
    dvec3(cos * around, sin * around, height)
}

fn cone_point(base: (DVec3, f64), cap: (DVec3, f64), shares: &mut dyn FnMut() -> f64) -> DVec3 {
    let along = shares();
    let (u, v) = (cap.0 - base.0).normalize().any_orthonormal_pair();
    let (sin, cos) = (TAU * shares()).sin_cos();
    let radius = (base.1 + (cap.1 - base.1) * along) * shares().sqrt();
    base.0 + (cap.0 - base.0) * along + (u * cos + v * sin) * radius
}

/// Is the point in the solid, or within rounding of it? Cut surfaces count as
/// inside on both sides: what is tested may contain too much, never too little.
fn contains(node: &Csg, p: DVec3) -> bool {
    const NEAR: f64 = 1e-9;
    match node {
        Csg::Sphere { centre, radius } => (p - *centre).length() <= radius + NEAR,
        Csg::Box { min, max } => p.cmpge(*min - NEAR).all() && p.cmple(*max + NEAR).all(),
        Csg::Cylinder { base, cap, radius } => in_cone((*base, *radius), (*cap, *radius), p, NEAR),
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => in_cone((*base, *base_radius), (*cap, *cap_radius), p, NEAR),
        Csg::Torus { major, minor } => (p.x.hypot(p.z) - major).hypot(p.y) <= minor + NEAR,
        Csg::Plane { normal, distance } => p.dot(normal.normalize()) <= distance + NEAR,
        Csg::Mesh(mesh) => mesh
            .corners()
            .any(|[a, b, c]| distance_to_triangle(p, a, b, c) <= NEAR),
        Csg::Union(nodes) => nodes.iter().any(|n| contains(n, p)),
        Csg::Intersection(nodes) => nodes.iter().all(|n| contains(n, p)),
        // Points on what cuts stay: only those well inside go. Counting all of
        // them as there is the harder test.
        Csg::Difference(first, _) => contains(first, p),
        Csg::Translate(by, node) => contains(node, p - *by),
        Csg::Rotate(angles, node) => contains(node, rotation(*angles).inverse() * p),
        Csg::Scale(factors, node) => contains(node, p / *factors),
        Csg::Look(_, node) => contains(node, p),
    }
}

fn in_cone(base: (DVec3, f64), cap: (DVec3, f64), p: DVec3, near: f64) -> bool {
    let axis = cap.0 - base.0;
    let along = (p - base.0).dot(axis) / axis.length_squared();
    let radius = base.1 + (cap.1 - base.1) * along.clamp(0.0, 1.0);
    let from_axis = (p - base.0 - axis * along).length();
    (-near..=1.0 + near).contains(&along) && from_axis <= radius + near
}

fn distance_to_triangle(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> f64 {
    let normal = (b - a).cross(c - a);
    let from_edge = |a: DVec3, b: DVec3| {
        let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
        if along.is_nan() {
            (p - a).length()
        } else {
            (p - a - (b - a) * along).length()
        }
    };
    let edges = from_edge(a, b).min(from_edge(b, c)).min(from_edge(c, a));
    let inside = [(a, b), (b, c), (c, a)]
        .iter()
        .all(|(from, to)| normal.dot((*to - *from).cross(p - *from)) >= 0.0);
    let above = (p - a).dot(normal).abs() / normal.length();
    if inside && above < edges {
        above
    } else {
        edges
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1024))]

    #[test]
    fn what_is_in_the_tree_is_in_its_sphere(
        node in tree(),
        shares in prop::collection::vec(
            prop_oneof![3 => 0.0..1.0_f64, 1 => Just(0.0), 1 => Just(1.0)], 400),
    ) {
        let bounds = node.bounds();
        let mut shares = shares.into_iter().cycle();
        for _ in 0..60 {
            let Some(p) = point_of(&node, &mut || shares.next().unwrap_or(0.5)) else {
                continue;
            };
            if !contains(&node, p) {
                continue;
            }
            match bounds {
                Bounds::Unbounded => {}
                Bounds::Sphere(s) => {
                    let distance = (p - s.centre).length();
                    prop_assert!(distance <= s.radius * (1.0 + 1e-9) + 1e-7, "{p} in {s:?}");
                }
                // Where two surfaces only touch, rounding may part them.
                Bounds::Empty => prop_assert!(nearly_apart(&node), "{p} in nothing"),
            }
        }
    }

    #[test]
    fn a_tree_without_planes_has_an_end(node in tree()) {
        fn has_plane(node: &Csg) -> bool {
            matches!(node, Csg::Plane { .. }) || node.children().into_iter().any(has_plane)
        }
        if !has_plane(&node) {
            prop_assert_ne!(node.bounds(), Bounds::Unbounded);
        }
    }

    #[test]
    fn a_mesh_has_the_smallest_sphere(points in prop::collection::vec(vector(), 1..11)) {
        let sphere = sphere_of(&mesh(points.clone()));
        for p in &points {
            prop_assert!((*p - sphere.centre).length() <= sphere.radius);
        }
        let least = smallest_radius(&points);
        prop_assert!(sphere.radius <= least * (1.0 + 1e-6) + 1e-12,
            "{} for {least}: {:.4}", sphere.radius, sphere.radius / least);
    }

    #[test]
    fn a_ball_around_balls_contains_them_and_is_tight(
        balls in prop::collection::vec((vector(), prop_oneof![Just(0.0), 0.0..8.0_f64]), 1..9),
    ) {
        let balls: Vec<Sphere> =
            balls.into_iter().map(|(centre, radius)| Sphere { centre, radius }).collect();
        let Bounds::Sphere(around) = ball_around(&balls) else {
            return Err(TestCaseError::fail("no sphere"));
        };
        let reach = |from: DVec3| {
            let each = balls.iter().map(|b| (b.centre - from).length() + b.radius);
            each.fold(0.0, f64::max)
        };
        prop_assert!(reach(around.centre) <= around.radius);
        // The reach is convex: where no step leads down, it is the smallest.
        let step = around.radius * 1e-3;
        for k in 0..200 {
            let mut share = [0.5 + 0.5 * (k as f64 * 0.618).sin(), k as f64 * 0.382 % 1.0].into_iter();
            let to = around.centre + step * direction(&mut || share.next().unwrap_or(0.0));
            prop_assert!(reach(to) >= around.radius * (1.0 - 1e-5) - 1e-9, "{} < {}", reach(to), around.radius);
        }
    }

    #[test]
    fn the_largest_stretch_is_not_exceeded(
        angles in vector(), factors in factors(), again in vector(), way in vector(),
    ) {
        let m = DMat3::from_quat(rotation(angles * 36.0))
            * DMat3::from_diagonal(factors)
            * DMat3::from_quat(rotation(again * 36.0));
        let most = largest_stretch(m);
        prop_assert!((m * way).length() <= most * way.length() * (1.0 + 1e-12));
        let exact = factors.abs().max_element();
        prop_assert!(most <= exact * (1.0 + 1e-6), "{most} for {exact}");
    }
}

/// Do parts of an intersection barely touch? Grown a little, they overlap.
fn nearly_apart(node: &Csg) -> bool {
    let extent = Extent::of(
        node,
        &Placed {
            map: DAffine3::IDENTITY,
            slack: 1e-6,
        },
    );
    !extent.is_empty()
}

#[test]
fn many_points_on_a_sphere_are_no_trouble() {
    // Every point is as far as every other: the worst for a support of four.
    let mut state = 1_u64;
    let mut share = || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let points: Vec<DVec3> = (0..20_000)
        .map(|_| dvec3(1e6, 0.0, 0.0) + direction(&mut share))
        .collect();
    let sphere = sphere_of(&mesh(points.clone()));
    assert!(
        points
            .iter()
            .all(|p| (*p - sphere.centre).length() <= sphere.radius)
    );
    assert!(sphere.radius < 1.0001, "{sphere:?}");
    let flat: Vec<DVec3> = points.iter().map(|p| dvec3(p.x, p.y, 0.0)).collect();
    let sphere = sphere_of(&mesh(flat));
    assert!(sphere.radius < 1.0001, "{sphere:?}");
}

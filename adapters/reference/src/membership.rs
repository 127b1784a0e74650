//! For the tests: is a point inside a solid, by the definition of every solid,
//! and random solids to ask it of.

use decor_api::Csg;
use decor_api::scene::rotation;
use glam::DVec3;
use proptest::prelude::*;

/// By definition, not by rays. Meshes have no inside here.
pub(crate) fn contains(tree: &Csg, p: DVec3) -> bool {
    match tree {
        Csg::Sphere { centre, radius } => p.distance(*centre) < *radius,
        Csg::Box { min, max } => p.cmpgt(*min).all() && p.cmplt(*max).all(),
        Csg::Cylinder { base, cap, radius } => in_cone(p, *base, *radius, *cap, *radius),
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => in_cone(p, *base, *base_radius, *cap, *cap_radius),
        Csg::Torus { major, minor } => (p.x.hypot(p.z) - major).hypot(p.y) < *minor,
        Csg::Plane { normal, distance } => p.dot(*normal) < distance * normal.length(),
        Csg::Mesh(_) => false,
        Csg::Union(all) => all.iter().any(|t| contains(t, p)),
        Csg::Intersection(all) => !all.is_empty() && all.iter().all(|t| contains(t, p)),
        Csg::Difference(first, rest) => contains(first, p) && !rest.iter().any(|t| contains(t, p)),
        Csg::Translate(by, tree) => contains(tree, p - *by),
        Csg::Rotate(angles, tree) => contains(tree, rotation(*angles).inverse() * p),
        Csg::Scale(factors, tree) => contains(tree, p / *factors),
        Csg::Look(_, tree) => contains(tree, p),
    }
}

fn in_cone(p: DVec3, base: DVec3, base_radius: f64, cap: DVec3, cap_radius: f64) -> bool {
    let axis = cap - base;
    let share = (p - base).dot(axis) / axis.length_squared();
    let radius = base_radius + (cap_radius - base_radius) * share;
    share > 0.0 && share < 1.0 && (p - (base + axis * share)).length() < radius
}

pub(crate) fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
    (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn leaf() -> impl Strategy<Value = Csg> {
    let radius = || 0.1..2.0;
    prop_oneof![
        (vec3(1.0), radius()).prop_map(|(centre, radius)| Csg::Sphere { centre, radius }),
        (vec3(1.5), vec3(1.5)).prop_map(|(a, b)| Csg::Box {
            min: a.min(b),
            max: a.max(b),
        }),
        (vec3(1.5), vec3(1.5), radius()).prop_map(|(base, cap, radius)| Csg::Cylinder {
            base,
            cap,
            radius,
        }),
        (
            vec3(1.5),
            vec3(1.5),
            radius(),
            prop_oneof![Just(0.0), radius()]
        )
            .prop_map(|(base, cap, base_radius, cap_radius)| Csg::Cone {
                base,
                base_radius,
                cap,
                cap_radius,
            }),
        (0.3..1.5, 0.05..1.0).prop_map(|(major, share): (f64, f64)| Csg::Torus {
            major,
            minor: major * share,
        }),
        (vec3(1.0), -1.0..1.0).prop_map(|(normal, distance)| Csg::Plane { normal, distance }),
    ]
}

/// Random trees of a few leaves around the origin.
pub(crate) fn trees() -> impl Strategy<Value = Csg> {
    let factor = || prop_oneof![0.3..2.5, -2.5..-0.3];
    leaf().prop_recursive(4, 16, 3, move |inner| {
        let some = || prop::collection::vec(inner.clone(), 1..4);
        let boxed = || inner.clone().prop_map(Box::new);
        prop_oneof![
            some().prop_map(Csg::Union),
            some().prop_map(Csg::Intersection),
            (boxed(), some()).prop_map(|(first, rest)| Csg::Difference(first, rest)),
            (vec3(1.0), boxed()).prop_map(|(by, tree)| Csg::Translate(by, tree)),
            (vec3(180.0), boxed()).prop_map(|(angles, tree)| Csg::Rotate(angles, tree)),
            ((factor(), factor(), factor()), boxed())
                .prop_map(|((x, y, z), tree)| Csg::Scale(DVec3::new(x, y, z), tree)),
        ]
    })
}

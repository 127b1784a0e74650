//! A neutral solid in spheres that fit better than one, and how thin it is.

use decor_api::csg_bounds::ball_around;
use decor_api::{Bounds, Camera, Csg, Extent, Geometry, Pose, Prototype, Size, Sphere};
use glam::DVec3;

/// More spheres cost more than they save.
const MOST_PARTS: usize = 64;

/// A fragment's are only asked where shadows fall: what is seen of it is known by
/// its boxes.
const MOST_OF_FRAGMENT: usize = 256;

/// Pieces that one side of a box, or the height of a cylinder, is cut into, so
/// that as many boxes as usual stay under the limit.
const MOST_PIECES: f64 = 5.0;
const PIECES_OF_FRAGMENT: f64 = 9.0;

/// Pieces of a ring.
const RING: u32 = 12;

/// Spheres that together enclose a prototype, in its own coordinates, where
/// they are tighter than the one around all of it: of a fragment, those of its
/// boxes. None where nobody knows.
pub fn parts(prototype: &Prototype) -> Vec<Sphere> {
    let boxed;
    let (csg, most, pieces) = match &prototype.geometry {
        Geometry::Neutral(csg) => (csg, MOST_PARTS, MOST_PIECES),
        Geometry::Fragment(_) => {
            let boxes = prototype.extents.iter();
            let boxes = boxes.map(|&Extent { min, max }| Csg::Box { min, max });
            boxed = Csg::Union(boxes.collect());
            (&boxed, MOST_OF_FRAGMENT, PIECES_OF_FRAGMENT)
        }
    };
    let mut balls = Vec::new();
    if collect(csg, pieces, &mut Vec::new(), &mut balls).is_none() {
        return Vec::new();
    }
    let balls = clustered(balls, most);
    if balls.len() < 2 { Vec::new() } else { balls }
}

/// A transform above a node.
#[derive(Clone, Copy)]
enum Place {
    Translate(DVec3),
    Rotate(DVec3),
    Scale(DVec3),
}

/// The solid, placed as the nodes above it say.
fn placed(solid: Csg, places: &[Place]) -> Csg {
    places.iter().rev().fold(solid, |inner, place| {
        let inner = Box::new(inner);
        match *place {
            Place::Translate(by) => Csg::Translate(by, inner),
            Place::Rotate(by) => Csg::Rotate(by, inner),
            Place::Scale(by) => Csg::Scale(by, inner),
        }
    })
}

/// Adds the balls of the pieces of `node`; `None` where one has no end.
fn collect(node: &Csg, most: f64, places: &mut Vec<Place>, balls: &mut Vec<Sphere>) -> Option<()> {
    let within = |place: Place, inner: &Csg, places: &mut Vec<Place>, balls: &mut _| {
        places.push(place);
        let done = collect(inner, most, places, balls);
        places.pop();
        done
    };
    match node {
        Csg::Union(nodes) => nodes
            .iter()
            .try_for_each(|node| collect(node, most, places, balls)),
        // What is taken away only makes it smaller.
        Csg::Difference(first, _) => collect(first, most, places, balls),
        Csg::Translate(by, inner) => within(Place::Translate(*by), inner, places, balls),
        Csg::Rotate(by, inner) => within(Place::Rotate(*by), inner, places, balls),
        Csg::Scale(by, inner) => within(Place::Scale(*by), inner, places, balls),
        Csg::Look(_, inner) => collect(inner, most, places, balls),
        _ => pieces(node, most).into_iter().try_for_each(|piece| {
            match placed(piece, places).bounds() {
                Bounds::Empty => Some(()),
                Bounds::Unbounded => None,
                Bounds::Sphere(ball) => {
                    balls.push(ball);
                    Some(())
                }
            }
        }),
    }
}

/// A primitive cut where it is long.
fn pieces(solid: &Csg, most: f64) -> Vec<Csg> {
    match solid {
        Csg::Box { min, max } => {
            let sides = *max - *min;
            let edge = sides.min_element().max(sides.max_element() / (most - 1.0));
            let counts = sides.to_array().map(|side| cuts(side / edge, most));
            let mut all = Vec::new();
            for i in 0..counts[0] {
                for j in 0..counts[1] {
                    for k in 0..counts[2] {
                        let at = |i: u32, j: u32, k: u32| {
                            let share = [i, j, k].map(f64::from);
                            let share =
                                DVec3::from_array(share) / DVec3::from_array(counts.map(f64::from));
                            *min + sides * share
                        };
                        all.push(Csg::Box {
                            min: at(i, j, k),
                            max: at(i + 1, j + 1, k + 1),
                        });
                    }
                }
            }
            all
        }
        Csg::Cylinder { base, cap, radius } => along(*base, *cap, *radius)
            .map(|[(_, base), (_, cap)]| Csg::Cylinder {
                base,
                cap,
                radius: *radius,
            })
            .collect(),
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => {
            let radius = |share: f64| base_radius + (cap_radius - base_radius) * share;
            along(*base, *cap, base_radius.max(*cap_radius))
                .map(|[(from, base), (to, cap)]| Csg::Cone {
                    base,
                    base_radius: radius(from),
                    cap,
                    cap_radius: radius(to),
                })
                .collect()
        }
        Csg::Torus { major, minor } if minor / major < 0.5 => {
            let angle = std::f64::consts::TAU / f64::from(RING);
            // From the middle of an arc to its end, and the tube around it.
            let radius = 2.0 * major * (angle / 4.0).sin() + minor;
            (0..RING)
                .map(|k| {
                    let (sin, cos) = (f64::from(k) * angle).sin_cos();
                    Csg::Sphere {
                        centre: DVec3::new(cos, 0.0, sin) * *major,
                        radius,
                    }
                })
                .collect()
        }
        Csg::Mesh(mesh) => {
            let vertex = |index: u32| mesh.vertices.get(index as usize).copied();
            let triangles = mesh.triangles.iter().map(|corners| {
                let corners = corners.map(vertex);
                let [Some(a), Some(b), Some(c)] = corners else {
                    return None;
                };
                let points = [a, b, c].map(|centre| Sphere {
                    centre,
                    radius: 0.0,
                });
                let ball = ball_around(&points).as_sphere().copied()?;
                Some(Csg::Sphere {
                    centre: ball.centre,
                    radius: ball.radius,
                })
            });
            // A mesh that is not sound is not cut.
            let all: Option<Vec<Csg>> = triangles.collect();
            all.unwrap_or_else(|| vec![solid.clone()])
        }
        other => vec![other.clone()],
    }
}

/// How many pieces for so many cubes in a row. NaN is one.
fn cuts(ratio: f64, most: f64) -> u32 {
    (ratio - 1e-9).ceil().clamp(1.0, most) as u32
}

/// The ends of the pieces between two discs: the share of the way, and where.
fn along(base: DVec3, cap: DVec3, radius: f64) -> impl Iterator<Item = [(f64, DVec3); 2]> {
    let count = cuts(base.distance(cap) / (2.0 * radius), MOST_PIECES);
    (0..count).map(move |k| {
        [k, k + 1].map(|k| {
            let share = f64::from(k) / f64::from(count);
            (share, base + (cap - base) * share)
        })
    })
}

/// At most `limit` balls around all of `balls`: halved at the median of the
/// longest side until few enough are left.
fn clustered(mut balls: Vec<Sphere>, limit: usize) -> Vec<Sphere> {
    if balls.len() <= limit {
        return balls;
    }
    if limit <= 1 {
        return match ball_around(&balls) {
            Bounds::Sphere(ball) => vec![ball],
            // Not a number: the caller knows the whole.
            _ => Vec::new(),
        };
    }
    let first = balls[0].centre;
    let (min, max) = balls.iter().fold((first, first), |(min, max), ball| {
        (min.min(ball.centre), max.max(ball.centre))
    });
    let axis = (max - min).max_position();
    let half = balls.len() / 2;
    balls.select_nth_unstable_by(half, |a, b| a.centre[axis].total_cmp(&b.centre[axis]));
    let upper = balls.split_off(half);
    let mut all = clustered(balls, limit / 2);
    all.extend(clustered(upper, limit - limit / 2));
    all
}

/// How thin the thinnest part of a solid may be, in its own units; 0 where
/// nobody knows.
pub fn thickness(solid: &Csg) -> f64 {
    match solid {
        Csg::Sphere { radius, .. } => 2.0 * radius,
        Csg::Box { min, max } => (*max - *min).min_element(),
        Csg::Cylinder { base, cap, radius } => (2.0 * radius).min(base.distance(*cap)),
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => (2.0 * base_radius.min(*cap_radius)).min(base.distance(*cap)),
        Csg::Torus { minor, .. } => 2.0 * minor,
        Csg::Plane { .. } => f64::INFINITY,
        Csg::Union(nodes) => nodes.iter().map(thickness).fold(f64::INFINITY, f64::min),
        Csg::Translate(_, inner) | Csg::Rotate(_, inner) | Csg::Look(_, inner) => thickness(inner),
        Csg::Scale(by, inner) => thickness(inner) * by.abs().min_element(),
        // Cutting may leave any sliver; a mesh has no inside.
        Csg::Intersection(_) | Csg::Difference(..) | Csg::Mesh(_) => 0.0,
    }
}

/// Can a placed prototype be seen between the pixels' centres and at none? Where
/// its thinnest part is narrower than two pixels, or nobody knows.
pub fn is_slender(prototype: &Prototype, pose: &Pose, camera: &Camera, size: Size) -> bool {
    const WIDE_PX: f64 = 2.0;
    let thin = match &prototype.geometry {
        Geometry::Neutral(csg) => thickness(csg),
        Geometry::Fragment(_) => 0.0,
    };
    if thin == f64::INFINITY {
        return false;
    }
    let Bounds::Sphere(ball) = prototype.bounds.posed(pose) else {
        return prototype.bounds != Bounds::Empty;
    };
    let farthest = ball.centre.distance(camera.eye) + ball.radius;
    let (fx, fy) = camera.focal(size);
    // Not certain means slender.
    !(thin * fx.min(fy) > WIDE_PX * farthest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::{Optics, TriangleMesh};
    use std::sync::Arc;

    fn prototype(csg: Csg) -> Prototype {
        Prototype {
            extents: Vec::new(),
            path: "test".into(),
            hash: String::new(),
            bounds: csg.bounds(),
            geometry: Geometry::Neutral(csg),
            optics: Optics::Opaque,
            unlayerable: None,
        }
    }

    fn ball(x: f64, radius: f64) -> Csg {
        Csg::Sphere {
            centre: DVec3::X * x,
            radius,
        }
    }

    fn holds(balls: &[Sphere], point: DVec3) -> bool {
        balls
            .iter()
            .any(|b| point.distance(b.centre) <= b.radius * (1.0 + 1e-12))
    }

    #[test]
    fn parts_hold_every_point_of_a_plate_a_rod_and_a_ring() {
        let turn = |csg| {
            let scaled = Csg::Scale(DVec3::new(2.0, 1.0, 0.5), Box::new(csg));
            Csg::Translate(
                DVec3::X * 3.0,
                Box::new(Csg::Rotate(DVec3::new(20.0, 30.0, 40.0), Box::new(scaled))),
            )
        };
        let pose = |p: DVec3| {
            let turned = decor_api::scene::rotation(DVec3::new(20.0, 30.0, 40.0));
            turned * (p * DVec3::new(2.0, 1.0, 0.5)) + DVec3::X * 3.0
        };
        let plate = turn(Csg::Box {
            min: DVec3::new(-1.0, -0.1, -2.0),
            max: DVec3::new(1.0, 0.1, 2.0),
        });
        let rod = turn(Csg::Cone {
            base: DVec3::ZERO,
            base_radius: 0.2,
            cap: DVec3::Y * 3.0,
            cap_radius: 0.0,
        });
        let ring = turn(Csg::Torus {
            major: 2.0,
            minor: 0.3,
        });
        let [plate, rod, ring] = [plate, rod, ring].map(|csg| parts(&prototype(csg)));
        assert!(plate.len() > 4 && rod.len() > 3 && ring.len() == 12);
        for i in 0..=40 {
            for j in 0..=40 {
                let (s, t) = (f64::from(i) / 40.0, f64::from(j) / 40.0);
                let p = DVec3::new(2.0 * s - 1.0, 0.1, 4.0 * t - 2.0);
                assert!(holds(&plate, pose(p)), "{p}");
                let (sin, cos) = (s * std::f64::consts::TAU).sin_cos();
                let p = DVec3::new(cos, 0.0, sin) * (0.2 * (1.0 - t)) + DVec3::Y * (3.0 * t);
                assert!(holds(&rod, pose(p)), "{p}");
                let (up, out) = (t * std::f64::consts::TAU).sin_cos();
                let p = DVec3::new(cos, 0.0, sin) * (2.0 + 0.3 * out) + DVec3::Y * (0.3 * up);
                assert!(holds(&ring, pose(p)), "{p}");
            }
        }
    }

    #[test]
    fn many_balls_are_few_and_none_is_lost() {
        let many: Vec<Csg> = (0..1000).map(|i| ball(f64::from(i), 0.5)).collect();
        let balls = parts(&prototype(Csg::Union(many)));
        assert_eq!(balls.len(), MOST_PARTS);
        assert!((0..1000).all(|i| holds(&balls, DVec3::X * f64::from(i) + DVec3::Y * 0.5)));
        let vertices = (0..300).map(|i| DVec3::new(f64::from(i), f64::from(i % 2), 0.0));
        let mesh = TriangleMesh {
            vertices: vertices.clone().collect(),
            triangles: (0..298).map(|i| [i, i + 1, i + 2]).collect(),
        };
        let balls = parts(&prototype(Csg::Mesh(Arc::new(mesh))));
        assert_eq!(balls.len(), MOST_PARTS);
        assert!(vertices.into_iter().all(|v| holds(&balls, v)));
    }

    #[test]
    fn one_ball_or_no_end_has_no_parts() {
        assert!(parts(&prototype(ball(0.0, 1.0))).is_empty());
        let plane = Csg::Plane {
            normal: DVec3::Y,
            distance: 0.0,
        };
        assert!(parts(&prototype(Csg::Union(vec![ball(0.0, 1.0), plane]))).is_empty());
    }

    #[test]
    fn thin_is_measured_in_pixels() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (90.0, 90.0)).unwrap();
        let size = Size {
            width: 100,
            height: 100,
        };
        // 50 pixels a unit at the distance 1, 5 at 10.
        let slender = |csg, z: f64| {
            let pose = Pose {
                position: DVec3::Z * z,
                ..Pose::IDENTITY
            };
            is_slender(&prototype(csg), &pose, &camera, size)
        };
        let wire = Csg::Cylinder {
            base: DVec3::ZERO,
            cap: DVec3::X,
            radius: 0.1,
        };
        assert!(slender(wire.clone(), 10.0));
        assert!(!slender(wire, 3.0));
        assert!(slender(ball(0.0, 1.0), 100.0));
        let cut = Csg::Difference(Box::new(ball(0.0, 1.0)), vec![ball(0.1, 1.0)]);
        assert!(slender(cut, 3.0));
        let floor = Csg::Plane {
            normal: DVec3::Y,
            distance: -1.0,
        };
        assert!(!slender(floor, 0.0));
    }
}

//! Bounding spheres of neutral solids.
//!
//! Every node is described by three things that all contain it: a box along
//! the axes, a set of *generators* (balls such that any ball around all of
//! them contains the node: corners, vertices, the vertices of a polygon around
//! a circle), and where there is one the sphere known in closed form. The
//! smallest sphere that any of them gives is the answer. Transforms are carried
//! down to the primitives, so that a turned union is as tight as an unturned
//! one.
//!
//! What contains is promised, what is tight is not: exact for spheres, boxes,
//! cylinders, cones, tori and meshes that are moved, turned and scaled
//! uniformly; conservative for the rest.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DVec3};

use crate::bounds::{Bounds, Sphere};
use crate::csg::Csg;
use crate::scene::rotation;

mod aabb;
mod ball;
mod stretch;

pub use ball::ball_around;

use aabb::Aabb;
use stretch::{largest_stretch, row_lengths};

/// Vertices of the polygon drawn around a circle: 0.9 % larger than the circle.
const POLYGON: usize = 24;

/// What each transform may add in rounding, relative to the lengths in it.
const ROUNDING: f64 = 4e-15;

impl Csg {
    /// A sphere that contains the solid, in the tree's own coordinates.
    ///
    /// [`Bounds::Empty`] for a tree without a surface, [`Bounds::Unbounded`]
    /// for one without an end (a plane that nothing cuts).
    pub fn bounds(&self) -> Bounds {
        Extent::of(self, &Placed::IDENTITY).ball()
    }
}

/// Where a node stands: its transform, and the rounding gathered on the way.
struct Placed {
    map: DAffine3,
    slack: f64,
}

impl Placed {
    const IDENTITY: Self = Self {
        map: DAffine3::IDENTITY,
        slack: 0.0,
    };

    fn then(&self, inner: DAffine3) -> Self {
        let map = self.map * inner;
        // A large way there and back again leaves the rounding of the large way.
        let lengths = self.map.translation.length()
            + largest_stretch(self.map.matrix3) * inner.translation.length()
            + map.translation.length();
        Self {
            map,
            slack: self.slack + ROUNDING * lengths,
        }
    }

    /// The factor of a transform that keeps angles.
    fn similarity(&self) -> Option<f64> {
        let m = self.map.matrix3;
        let factor = m.x_axis.length();
        let gram = m.transpose() * m;
        let wanted = DMat3::from_diagonal(DVec3::splat(factor * factor));
        gram.abs_diff_eq(wanted, 1e-13 * factor * factor)
            .then_some(factor * (1.0 + 1e-13))
    }
}

/// What is known of the size of a node, in the coordinates of the root.
struct Extent {
    aabb: Aabb,
    /// `None` where the node has no end.
    generators: Option<Vec<Sphere>>,
    /// A sphere that contains it, in closed form.
    known: Option<Sphere>,
}

impl Extent {
    fn of(node: &Csg, placed: &Placed) -> Self {
        let map = &placed.map;
        match node {
            Csg::Sphere { centre, radius } => Self::ball_of(placed, *centre, *radius),
            Csg::Box { min, max } => {
                let corners = corners(*min, *max).map(|c| point(map.transform_point3(c)));
                Self::from_generators(placed, corners.to_vec())
            }
            Csg::Cylinder { base, cap, radius } => {
                Self::cone(placed, (*base, *radius), (*cap, *radius))
            }
            Csg::Cone {
                base,
                base_radius,
                cap,
                cap_radius,
            } => Self::cone(placed, (*base, *base_radius), (*cap, *cap_radius)),
            Csg::Torus { major, minor } => Self::torus(placed, *major, *minor),
            Csg::Plane { normal, distance } => Self::plane(placed, *normal, *distance),
            Csg::Mesh(mesh) => {
                let vertices = mesh.vertices.iter();
                let moved = vertices.map(|&v| point(map.transform_point3(v)));
                Self::from_generators(placed, moved.collect())
            }
            Csg::Union(nodes) => {
                let all = nodes.iter().map(|node| Self::of(node, placed));
                all.reduce(Self::union).unwrap_or_else(Self::empty)
            }
            Csg::Intersection(nodes) => {
                let all = nodes.iter().map(|node| Self::of(node, placed));
                Self::intersection(all.collect())
            }
            // What is taken away only makes it smaller.
            Csg::Difference(first, _) => Self::of(first, placed),
            Csg::Translate(by, node) => {
                Self::of(node, &placed.then(DAffine3::from_translation(*by)))
            }
            Csg::Rotate(angles_deg, node) => {
                let turn = DAffine3::from_quat(rotation(*angles_deg));
                Self::of(node, &placed.then(turn))
            }
            Csg::Scale(factors, node) => {
                Self::of(node, &placed.then(DAffine3::from_scale(*factors)))
            }
            Csg::Look(_, node) => Self::of(node, placed),
        }
    }

    fn empty() -> Self {
        Self {
            aabb: Aabb::EMPTY,
            generators: Some(Vec::new()),
            known: None,
        }
    }

    fn from_generators(placed: &Placed, generators: Vec<Sphere>) -> Self {
        let aabb = Aabb::around_balls(&generators);
        Self {
            aabb,
            generators: Some(generators),
            known: None,
        }
        .grown(placed)
    }

    /// Adds the rounding of the transforms. What overflowed has no end.
    fn grown(mut self, placed: &Placed) -> Self {
        let more = placed.slack;
        let is_finite = |b: &Sphere| b.centre.is_finite() && b.radius.is_finite();
        let overflowed = match &self.generators {
            Some(balls) if !balls.is_empty() => {
                !(balls.iter().all(is_finite) && self.aabb.is_finite() && more.is_finite())
            }
            _ => false,
        };
        if overflowed {
            return Self {
                aabb: Aabb::ALL,
                generators: None,
                known: None,
            };
        }
        self.aabb = self.aabb.grown(more);
        for ball in self.generators.iter_mut().flatten() {
            ball.radius += more;
        }
        if let Some(ball) = &mut self.known {
            ball.radius += more;
        }
        self
    }

    fn ball_of(placed: &Placed, centre: DVec3, radius: f64) -> Self {
        let linear = placed.map.matrix3;
        let factor = placed
            .similarity()
            .unwrap_or_else(|| largest_stretch(linear));
        let centre = placed.map.transform_point3(centre);
        let ball = Sphere {
            centre,
            radius: radius * factor,
        };
        Self {
            aabb: Aabb::around(centre, radius * row_lengths(linear)),
            generators: Some(vec![ball]),
            known: Some(ball),
        }
        .grown(placed)
    }

    /// Two discs across the line between their centres, and what is between.
    fn cone(placed: &Placed, base: (DVec3, f64), cap: (DVec3, f64)) -> Self {
        let axis = cap.0 - base.0;
        let height = axis.length();
        let (u, v) = axis
            .try_normalize()
            .unwrap_or(DVec3::Y)
            .any_orthonormal_pair();
        let linear = placed.map.matrix3;
        let (mu, mv) = (linear * u, linear * v);
        let mut generators = Vec::new();
        let mut aabb = Aabb::EMPTY;
        for (centre, radius) in [base, cap] {
            let centre = placed.map.transform_point3(centre);
            let half = DVec3::from_array([0, 1, 2].map(|i| mu[i].hypot(mv[i])));
            aabb = aabb.union(Aabb::around(centre, radius * half));
            generators.extend(ring(centre, mu * radius, mv * radius, 0.0));
        }
        let known = placed.similarity().map(|factor| {
            // The centre on the axis from which both rims are equally far.
            let along = if height > 0.0 {
                let t = (height * height + cap.1 * cap.1 - base.1 * base.1) / (2.0 * height);
                t.clamp(0.0, height) / height
            } else {
                0.0
            };
            let (below, above) = (along * height, (1.0 - along) * height);
            Sphere {
                centre: placed.map.transform_point3(base.0 + axis * along),
                radius: base.1.hypot(below).max(cap.1.hypot(above)) * factor,
            }
        });
        Self {
            aabb,
            generators: Some(generators),
            known,
        }
        .grown(placed)
    }

    fn torus(placed: &Placed, major: f64, minor: f64) -> Self {
        let linear = placed.map.matrix3;
        let centre = placed.map.translation;
        let factor = placed
            .similarity()
            .unwrap_or_else(|| largest_stretch(linear));
        let (x, z) = (linear.x_axis * major, linear.z_axis * major);
        let half = DVec3::from_array([0, 1, 2].map(|i| x[i].hypot(z[i])));
        Self {
            aabb: Aabb::around(centre, half + minor * row_lengths(linear)),
            generators: Some(ring(centre, x, z, minor * factor)),
            known: placed.similarity().map(|factor| Sphere {
                centre,
                radius: (major + minor) * factor,
            }),
        }
        .grown(placed)
    }

    /// No end; but a plane along the axes still cuts the box of what it is
    /// intersected with.
    fn plane(placed: &Placed, normal: DVec3, distance: f64) -> Self {
        let mut aabb = Aabb::ALL;
        let linear = placed.map.matrix3;
        let world = linear.inverse().transpose() * normal;
        if let (Some(unit), Some(own)) = (world.try_normalize(), normal.try_normalize()) {
            let on_plane = placed.map.transform_point3(own * distance);
            for i in 0..3 {
                let mut others = unit;
                others[i] = 0.0;
                if others == DVec3::ZERO {
                    let slack = ROUNDING * on_plane[i].abs();
                    if unit[i] > 0.0 {
                        aabb.max[i] = on_plane[i] + slack;
                    } else {
                        aabb.min[i] = on_plane[i] - slack;
                    }
                }
            }
        }
        Self {
            aabb,
            generators: None,
            known: None,
        }
        .grown(placed)
    }

    fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        let generators = match (self.generators, other.generators) {
            (Some(mut a), Some(b)) => {
                a.extend(b);
                Some(a)
            }
            _ => None,
        };
        Self {
            aabb: self.aabb.union(other.aabb),
            generators,
            known: None,
        }
    }

    /// The smaller of: the smallest part, the box that all boxes share.
    fn intersection(parts: Vec<Self>) -> Self {
        let aabb = parts
            .iter()
            .map(|p| p.aabb)
            .fold(Aabb::ALL, Aabb::intersection);
        if aabb.is_empty() {
            return Self::empty();
        }
        let radius = |bounds: Bounds| bounds.as_sphere().map_or(f64::INFINITY, |s| s.radius);
        let mut best = Self {
            aabb,
            generators: aabb.is_finite().then(|| aabb.corners()),
            known: None,
        };
        let mut least = radius(aabb.bounds());
        for part in parts {
            let ball = part.ball();
            if radius(ball) < least {
                least = radius(ball);
                best.generators = part.generators.or_else(|| Some(part.aabb.corners()));
                best.known = ball.as_sphere().copied();
            }
        }
        best
    }

    fn is_empty(&self) -> bool {
        self.aabb.is_empty()
    }

    fn ball(&self) -> Bounds {
        if self.is_empty() {
            return Bounds::Empty;
        }
        let known = self
            .known
            .map_or(Bounds::Unbounded, |s| Bounds::sphere(s.centre, s.radius));
        let generated = match &self.generators {
            // One ball is its own ball: nothing to search for.
            Some(_) if self.known.is_some() => Bounds::Unbounded,
            Some(balls) => ball_around(balls),
            None => Bounds::Unbounded,
        };
        let candidates = [known.rounded_outwards(), generated, self.aabb.bounds()];
        let radius = |b: &Bounds| b.as_sphere().map_or(f64::INFINITY, |s| s.radius);
        candidates
            .into_iter()
            .min_by(|a, b| radius(a).total_cmp(&radius(b)))
            .unwrap_or(Bounds::Unbounded)
    }
}

fn point(centre: DVec3) -> Sphere {
    Sphere {
        centre,
        radius: 0.0,
    }
}

fn corners(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, axis: usize| {
            if i & bit == 0 { min[axis] } else { max[axis] }
        };
        DVec3::new(pick(1, 0), pick(2, 1), pick(4, 2))
    })
}

/// Balls on a polygon around the ellipse `centre + u·cos + v·sin`: the affine
/// image of a polygon around a circle is around the image of the circle.
fn ring(centre: DVec3, u: DVec3, v: DVec3, radius: f64) -> Vec<Sphere> {
    let out = 1.0 / (0.5 * TAU / POLYGON as f64).cos();
    (0..POLYGON)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / POLYGON as f64).sin_cos();
            Sphere {
                centre: centre + (u * cos + v * sin) * out,
                radius,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests;

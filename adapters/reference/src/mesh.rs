//! Triangle meshes: watertight crossings.
//!
//! Woop, Benthin, Wald, "Watertight Ray/Triangle Intersection" (JCGT 2013): the
//! vertices are sheared so that the ray is the third axis, and a triangle is
//! hit where the origin lies in its projection. Two triangles that share an edge
//! compute the very same number for it with opposite signs. Where that number is
//! 0 the origin counts as moved by (ε, ε²): a ray through an edge or a vertex
//! crosses a closed mesh an even number of times, like any other.

use decor_api::TriangleMesh;
use glam::DVec3;

use crate::extent::Extent;
use crate::ray::Ray;
use crate::span::{Crossing, Span};
use crate::tree::Tree;

/// A mesh with a tree over its triangles.
pub(crate) struct Mesh {
    triangles: Vec<[DVec3; 3]>,
    extent: Extent,
    tree: Tree,
}

impl std::fmt::Debug for Mesh {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Mesh of {} triangles", self.triangles.len())
    }
}

impl Mesh {
    /// `None` where there is no triangle. What is not finite or names a vertex
    /// that does not exist is left out.
    pub fn new(mesh: &TriangleMesh) -> Option<Self> {
        let vertex = |i: u32| mesh.vertices.get(i as usize).filter(|v| v.is_finite());
        let triangles: Vec<[DVec3; 3]> = mesh
            .triangles
            .iter()
            .filter_map(|t| Some([*vertex(t[0])?, *vertex(t[1])?, *vertex(t[2])?]))
            .collect();
        if triangles.is_empty() {
            return None;
        }
        Some(Self {
            extent: Extent::around(triangles.iter().flatten().copied()),
            tree: Tree::new(triangles.iter().map(|t| Extent::around(*t))),
            triangles,
        })
    }

    pub fn extent(&self) -> Extent {
        self.extent
    }

    /// The first triangle between `after` and `before`. It is entered where
    /// its normal, by the order of its corners, faces the ray.
    pub fn nearest(&self, ray: &Ray, after: f64, before: f64, look: u32) -> Option<Crossing> {
        let shear = Shear::new(ray)?;
        let mut found: Option<(f64, u32)> = None;
        self.tree.nearest(ray, after, before, |leaf, _| {
            let t = shear.crosses(&self.triangles[leaf as usize])?;
            let is_nearer = found.is_none_or(|best| (t, leaf) < best);
            if t > after && t < before && is_nearer {
                found = Some((t, leaf));
                return Some(t);
            }
            None
        });
        found.map(|(t, leaf)| {
            let normal = self.normal(leaf, ray);
            Crossing {
                t,
                normal,
                look,
                enters: normal.dot(ray.direction) < 0.0,
            }
        })
    }

    /// Between the odd and the even crossings of the whole line.
    pub fn spans(&self, ray: &Ray, look: u32) -> Vec<Span> {
        let Some(shear) = Shear::new(ray) else {
            return Vec::new();
        };
        let mut crossings = Vec::new();
        self.tree.along_line(ray, |leaf| {
            if let Some(t) = shear.crosses(&self.triangles[leaf as usize]) {
                crossings.push((t, leaf));
            }
        });
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let facing = |(t, leaf): (f64, u32), outwards: f64| {
            let normal = self.normal(leaf, ray);
            let side = normal.dot(ray.direction) * outwards;
            (t, if side < 0.0 { -normal } else { normal })
        };
        crossings
            .chunks_exact(2)
            .filter(|pair| pair[0].0 < pair[1].0)
            .map(|pair| Span::new(facing(pair[0], -1.0), facing(pair[1], 1.0), look))
            .collect()
    }

    fn normal(&self, leaf: u32, ray: &Ray) -> DVec3 {
        let [a, b, c] = self.triangles[leaf as usize];
        let (p, q) = (b - a, c - a);
        // Scaled, so that a tiny triangle's product does not underflow.
        let size = p.abs().max(q.abs()).max_element();
        (p / size).cross(q / size).normalize_or(-ray.direction)
    }
}

/// A ray as the test of a triangle needs it.
struct Shear {
    origin: DVec3,
    /// The axis along which the ray goes most, and the two others.
    along: usize,
    across: [usize; 2],
    slope: [f64; 2],
    speed: f64,
}

impl Shear {
    fn new(ray: &Ray) -> Option<Self> {
        let along = ray.direction.abs().max_position();
        let speed = ray.direction[along];
        let across = [(along + 1) % 3, (along + 2) % 3];
        let slope = across.map(|axis| ray.direction[axis] / speed);
        slope.iter().all(|s| s.is_finite()).then_some(Self {
            origin: ray.origin,
            along,
            across,
            slope,
            speed,
        })
    }

    /// The ray's parameter where it crosses the triangle.
    fn crosses(&self, triangle: &[DVec3; 3]) -> Option<f64> {
        let [a, b, c] = triangle.map(|vertex| {
            let p = vertex - self.origin;
            let z = p[self.along];
            let [x, y] = [0, 1].map(|i| p[self.across[i]] - self.slope[i] * z);
            (x, y, z / self.speed)
        });
        let weights = [edge(b, c), edge(c, a), edge(a, b)];
        let sides = [side(b, c), side(c, a), side(a, b)];
        if sides[0] == 0 || sides[1] != sides[0] || sides[2] != sides[0] {
            return None;
        }
        let sum = weights[0] + weights[1] + weights[2];
        let t = (weights[0] * a.2 + weights[1] * b.2 + weights[2] * c.2) / sum;
        t.is_finite().then_some(t)
    }
}

/// Twice the area between the origin and the edge; exactly the opposite for
/// the edge taken the other way.
fn edge(p: (f64, f64, f64), q: (f64, f64, f64)) -> f64 {
    q.0 * p.1 - q.1 * p.0
}

/// On which side of the edge the origin is, never on it, but for an edge of no
/// length.
fn side(p: (f64, f64, f64), q: (f64, f64, f64)) -> i8 {
    let sign = |v: f64| i8::from(v > 0.0) - i8::from(v < 0.0);
    match sign(edge(p, q)) {
        0 => match sign(q.1 - p.1) {
            0 => sign(p.0 - q.0),
            up => up,
        },
        side => side,
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::span::first_after;
    use proptest::prelude::*;

    /// A cube of half size 1 as twelve triangles.
    pub fn cube() -> TriangleMesh {
        let corner = |i: u32| {
            let sign = |bit: u32| if i & bit == 0 { -1.0 } else { 1.0 };
            DVec3::new(sign(1), sign(2), sign(4))
        };
        let faces = [
            [0, 1, 3, 2],
            [4, 6, 7, 5],
            [0, 4, 5, 1],
            [2, 3, 7, 6],
            [0, 2, 6, 4],
            [1, 5, 7, 3],
        ];
        TriangleMesh {
            vertices: (0..8).map(corner).collect(),
            triangles: faces
                .iter()
                .flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]])
                .collect(),
        }
    }

    fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// Edges, diagonals, vertices and face centres, exactly.
    fn on_the_grid() -> impl Strategy<Value = DVec3> {
        let coordinate = || (-2..=2_i32).prop_map(f64::from);
        (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn a_mesh_of_a_box_is_a_box(origin in vec3(5.0), target in vec3(1.5)) {
            prop_assume!(origin.distance(target) > 0.1);
            let ray = Ray { origin, direction: target - origin };
            let mesh = Mesh::new(&cube()).unwrap();
            let solid = crate::primitive::Primitive::Block {
                min: DVec3::splat(-1.0),
                max: DVec3::splat(1.0),
            };
            let (got, want) = (mesh.spans(&ray, 0), solid.spans(&ray, 0));
            // At an edge the one may see what the other has just missed.
            let length = want.first().map_or(0.0, |s| s.leave.t - s.enter.t);
            prop_assume!(want.is_empty() || length > 1e-9);
            prop_assert_eq!(got.len(), want.len());
            for (g, w) in got.iter().zip(&want) {
                prop_assert!((g.enter.t - w.enter.t).abs() < 1e-12);
                prop_assert!((g.leave.t - w.leave.t).abs() < 1e-12);
                prop_assert!(g.enter.normal.distance(w.enter.normal) < 1e-12);
            }
            let first = mesh.nearest(&ray, 0.0, f64::INFINITY, 0).map(|c| c.t);
            prop_assert_eq!(first, first_after(&got, 0.0).map(|c| c.t));
        }

        #[test]
        fn through_edges_and_vertices_crossings_stay_even(
            through in on_the_grid(), from in on_the_grid(), scale in prop::sample::select(vec![1.0, 1.0 / 3.0, 1e5]),
        ) {
            prop_assume!(from != DVec3::ZERO);
            let mut mesh = cube();
            mesh.vertices.iter_mut().for_each(|v| *v *= scale);
            let mesh = Mesh::new(&mesh).unwrap();
            let ray = Ray { origin: (through + from * 7.0) * scale, direction: -from };
            let shear = Shear::new(&ray).unwrap();
            let count = mesh.triangles.iter().filter(|t| shear.crosses(t).is_some()).count();
            prop_assert_eq!(count % 2, 0);
        }
    }

    #[test]
    fn a_single_triangle_is_a_surface_without_an_inside() {
        let mesh = Mesh::new(&TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2], [0, 1, 9]],
        })
        .unwrap();
        let ray = Ray {
            origin: DVec3::new(0.2, 0.2, -3.0),
            direction: DVec3::Z,
        };
        let hit = mesh.nearest(&ray, 0.0, f64::INFINITY, 4).unwrap();
        assert_eq!((hit.t, hit.look), (3.0, 4));
        assert!(mesh.spans(&ray, 0).is_empty());
        assert!(mesh.nearest(&ray, 3.0, f64::INFINITY, 0).is_none());
    }
}

//! Solids as closed triangle meshes: for what Mitsuba has no shape for, and for
//! what is cut. Vertices lie on the solid; triangles turn anticlockwise as seen
//! from outside, in coordinates that know no hands.

use std::collections::HashMap;
use std::f64::consts::TAU;

use decor_api::TriangleMesh;
use glam::{DAffine3, DVec3};

/// A point of a circle of radius 1 around z, at step `k` of `n`.
fn on_circle(k: u32, n: u32) -> (f64, f64) {
    (TAU * f64::from(k) / f64::from(n)).sin_cos()
}

/// A box between two corners.
pub(crate) fn cuboid(min: DVec3, max: DVec3) -> TriangleMesh {
    let corner = |k: u32| {
        let pick = |bit: u32, low: f64, high: f64| if k & bit == 0 { low } else { high };
        DVec3::new(
            pick(1, min.x, max.x),
            pick(2, min.y, max.y),
            pick(4, min.z, max.z),
        )
    };
    let quads = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 2, 3, 1],
        [4, 5, 7, 6],
    ];
    TriangleMesh {
        vertices: (0..8).map(corner).collect(),
        triangles: quads
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
    }
}

/// A surface of revolution around z: a profile of (radius, height) from the
/// bottom to the top, in `around` steps. Radius 0 at an end closes it in a
/// point; another radius there is closed by a disc.
fn revolved(profile: &[(f64, f64)], around: u32) -> TriangleMesh {
    let mut mesh = TriangleMesh::default();
    // The vertices of each ring; a single one where the radius is 0.
    let mut rings: Vec<Vec<u32>> = Vec::with_capacity(profile.len() + 2);
    let mut ring = |mesh: &mut TriangleMesh, radius: f64, height: f64| {
        let count = if radius == 0.0 { 1 } else { around };
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend((0..count).map(|k| {
            let (sin, cos) = on_circle(k, around);
            DVec3::new(radius * cos, radius * sin, height)
        }));
        rings.push((first..first + count).collect());
    };
    let ends = (profile.first(), profile.last());
    if let (Some(&(radius, height)), _) = ends
        && radius > 0.0
    {
        ring(&mut mesh, 0.0, height);
    }
    for &(radius, height) in profile {
        ring(&mut mesh, radius, height);
    }
    if let (_, Some(&(radius, height))) = ends
        && radius > 0.0
    {
        ring(&mut mesh, 0.0, height);
    }
    for pair in rings.windows(2) {
        let (low, high) = (&pair[0], &pair[1]);
        for k in 0..around as usize {
            let at = |ring: &Vec<u32>, k: usize| ring[k % ring.len()];
            let (a, b) = (at(low, k), at(low, k + 1));
            let (c, d) = (at(high, k), at(high, k + 1));
            if a != b {
                mesh.triangles.push([a, b, d]);
            }
            if c != d {
                mesh.triangles.push([a, d, c]);
            }
        }
    }
    mesh
}

/// How far the mesh of a [`sphere`] of radius 1 is from it, at most.
pub(crate) fn deviation_of_sphere(steps: u32) -> f64 {
    // Where the faces of the icosahedron are nearest to the centre (0.795), its
    // edges of 1.051 are projected the longest. An equilateral triangle of edge
    // e lies e²/6 below its sphere; half of that is above (see `sphere`).
    let edge = 1.051 / 0.795 / f64::from(steps);
    edge * edge / 12.0
}

/// A sphere, as an icosahedron whose edges are cut into so many steps. Vertices
/// lie outside by as much as the middles of triangles lie inside.
pub(crate) fn sphere(centre: DVec3, radius: f64, steps: u32) -> TriangleMesh {
    let steps = steps.max(1);
    let radius = radius * (1.0 + deviation_of_sphere(steps));
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let ring = |k: usize, a: f64, b: f64| {
        let mut v = [0.0; 3];
        v[(k + 1) % 3] = a;
        v[(k + 2) % 3] = b * golden;
        DVec3::from_array(v)
    };
    let corners: Vec<DVec3> = (0..3)
        .flat_map(|k| {
            [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)].map(|(a, b)| ring(k, a, b))
        })
        .collect();
    let near = |a: usize, b: usize| corners[a].distance_squared(corners[b]) < 4.1;
    let mut mesh = TriangleMesh::default();
    // A vertex by its weights: edges are shared by two faces.
    let mut known: HashMap<[(usize, u32); 3], u32> = HashMap::new();
    for a in 0..12 {
        for b in a + 1..12 {
            for c in b + 1..12 {
                if !(near(a, b) && near(b, c) && near(a, c)) {
                    continue;
                }
                let outwards = corners[a].dot(corners[b].cross(corners[c])) > 0.0;
                let (b, c) = if outwards { (b, c) } else { (c, b) };
                let mut vertex = |j: u32, k: u32| {
                    let mut weights = [(a, steps - j - k), (b, j), (c, k)];
                    let point: DVec3 = weights
                        .iter()
                        .map(|&(p, w)| corners[p] * f64::from(w))
                        .sum();
                    for (p, w) in &mut weights {
                        if *w == 0 {
                            *p = usize::MAX;
                        }
                    }
                    weights.sort_unstable();
                    *known.entry(weights).or_insert_with(|| {
                        mesh.vertices.push(centre + point.normalize() * radius);
                        (mesh.vertices.len() - 1) as u32
                    })
                };
                let mut triangles = Vec::new();
                for j in 0..steps {
                    for k in 0..steps - j {
                        let (p, q, r) = (vertex(j, k), vertex(j + 1, k), vertex(j, k + 1));
                        triangles.push([p, q, r]);
                        if j + k + 1 < steps {
                            triangles.push([q, vertex(j + 1, k + 1), r]);
                        }
                    }
                }
                mesh.triangles.extend(triangles);
            }
        }
    }
    mesh
}

/// A cone, a truncated cone or a cylinder, with its ends.
pub(crate) fn frustum(
    base: DVec3,
    base_radius: f64,
    cap: DVec3,
    cap_radius: f64,
    around: u32,
) -> TriangleMesh {
    let axis = cap - base;
    let Some(up) = axis.try_normalize() else {
        return TriangleMesh::default();
    };
    let (u, v) = up.any_orthonormal_pair();
    // u, v and up in this order turn as x, y and z do, or in the other way.
    let v = if u.cross(v).dot(up) > 0.0 { v } else { -v };
    let placed = DAffine3::from_cols(u, v, up, base);
    let profile = [(base_radius, 0.0), (cap_radius, axis.length())];
    moved(revolved(&profile, around), placed)
}

/// A ring around y, in `around` steps, and half as many around its tube.
pub(crate) fn torus(major: f64, minor: f64, around: u32) -> TriangleMesh {
    let across = around / 2;
    let mut mesh = TriangleMesh::default();
    for k in 0..around {
        let (sin, cos) = on_circle(k, around);
        for j in 0..across {
            let (up, out) = on_circle(j, across);
            let reach = major + minor * out;
            mesh.vertices
                .push(DVec3::new(reach * cos, minor * up, -reach * sin));
            let (k1, j1) = ((k + 1) % around, (j + 1) % across);
            let [a, b, c, d] = [(k, j), (k1, j), (k1, j1), (k, j1)].map(|(k, j)| k * across + j);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// The mesh where `by` puts it, still turning anticlockwise.
pub(crate) fn moved(mut mesh: TriangleMesh, by: DAffine3) -> TriangleMesh {
    for vertex in &mut mesh.vertices {
        *vertex = by.transform_point3(*vertex);
    }
    if by.matrix3.determinant() < 0.0 {
        turn_over(&mut mesh);
    }
    mesh
}

/// Turns every triangle the other way round.
pub(crate) fn turn_over(mesh: &mut TriangleMesh) {
    for triangle in &mut mesh.triangles {
        triangle.swap(1, 2);
    }
}

/// The volume inside; negative where the triangles turn the other way.
pub(crate) fn volume(mesh: &TriangleMesh) -> f64 {
    let parts = mesh.corners().map(|[a, b, c]| a.dot(b.cross(c)));
    parts.sum::<f64>() / 6.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Does every edge belong to two triangles, once in each direction?
    fn is_closed(mesh: &TriangleMesh) -> bool {
        let mut edges: HashMap<(u32, u32), u32> = HashMap::new();
        for t in &mesh.triangles {
            for k in 0..3 {
                *edges.entry((t[k], t[(k + 1) % 3])).or_default() += 1;
            }
        }
        edges
            .iter()
            .all(|(&(a, b), &n)| n == 1 && edges.get(&(b, a)) == Some(&1))
    }

    #[track_caller]
    fn holds(mesh: &TriangleMesh, expected: f64) {
        assert!(is_closed(mesh));
        let off = volume(mesh) / expected - 1.0;
        assert!(off.abs() < 1e-3, "{} for {expected}", volume(mesh));
    }

    #[test]
    fn meshes_are_closed_and_hold_the_volume_of_their_solids() {
        let centre = DVec3::new(1.0, -2.0, 3.0);
        holds(&cuboid(centre, centre + DVec3::new(1.0, 2.0, 3.0)), 6.0);
        holds(&sphere(centre, 2.0, 40), 4.0 / 3.0 * PI * 8.0);
        let cap = centre + DVec3::new(0.0, 3.0, 4.0);
        holds(&frustum(centre, 2.0, cap, 2.0, 200), PI * 4.0 * 5.0);
        holds(&frustum(centre, 2.0, cap, 0.0, 200), PI * 4.0 * 5.0 / 3.0);
        holds(&frustum(centre, 0.0, cap, 2.0, 200), PI * 4.0 * 5.0 / 3.0);
        holds(&torus(3.0, 1.0, 200), 2.0 * PI * PI * 3.0);
    }

    #[test]
    fn the_mesh_of_a_sphere_is_as_near_as_it_says() {
        for steps in [10, 21] {
            let mesh = sphere(DVec3::ZERO, 1.0, steps);
            assert_eq!(mesh.triangles.len() as u32, 20 * steps * steps);
            let most = deviation_of_sphere(steps);
            let mut farthest = 0.0_f64;
            for corners in mesh.corners() {
                let middle = corners.into_iter().sum::<DVec3>() / 3.0;
                for point in [middle, corners[0]] {
                    farthest = farthest.max((point.length() - 1.0).abs());
                }
            }
            assert!(
                farthest < 1.05 * most && farthest > 0.8 * most,
                "{farthest}"
            );
        }
    }

    #[test]
    fn a_mirrored_mesh_is_not_inside_out() {
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 2.0, 1.0));
        let mesh = moved(cuboid(DVec3::ZERO, DVec3::ONE), mirror);
        assert!((volume(&mesh) - 2.0).abs() < 1e-12);
    }
}

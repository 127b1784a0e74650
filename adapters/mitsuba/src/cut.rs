//! Intersections and differences as meshes. Mitsuba has none: what is cut is
//! made of triangles, round parts in steps.

use std::panic::{AssertUnwindSafe, catch_unwind};

use boolmesh::compute_boolean;
use boolmesh::prelude::{Manifold, OpType};
use decor_api::{AdapterError, Bounds, Csg, Material, Sphere, TriangleMesh};
use glam::{DAffine3, DVec3};

use crate::solid::{descend, largest, sagitta};
use crate::tessellate::{
    cuboid, deviation_of_sphere, frustum, moved, sphere, torus, turn_over, volume,
};
use crate::unsupported;

/// Steps around cylinders and cones: of a radius of 1, no point of the mesh is
/// more than 2e-5 off.
const AROUND: u32 = 512;

/// Steps around rings: of a radius of 1, 3e-4 off. Twice as many make four times
/// the triangles, and a cut takes seconds.
const AROUND_RING: u32 = 192;

/// Steps along the edges of the icosahedron that a ball is made of, where it is
/// as large as half of all that is cut: 1.5e-5 off. The tests of this file count volumes,
/// which need no such precision.
const STEPS: f64 = if cfg!(test) { 24.0 } else { 100.0 };

/// The steps of a ball that is smaller than half of it all: as far off.
fn steps(radius: f64, within: f64) -> u32 {
    let share = (2.0 * radius / within).clamp(0.0, 1.0);
    (STEPS * share.sqrt()).ceil().clamp(8.0, STEPS) as u32
}

/// A closed mesh; every corner carries the number of its look.
type Body = Manifold<f64>;

/// The meshes of a cut solid, each with the look that it has.
pub(crate) fn meshes(
    node: &Csg,
    look: usize,
    looks: &mut Vec<Material>,
) -> Result<Vec<(TriangleMesh, usize)>, AdapterError> {
    let within = match node.bounds() {
        Bounds::Empty => return Ok(Vec::new()),
        Bounds::Sphere(sphere) => sphere,
        Bounds::Unbounded => {
            return Err(unsupported("a cut solid without an end"));
        }
    };
    let cutter = Cutter { within };
    let body = cutter.body(node, DAffine3::IDENTITY, look, looks)?;
    Ok(body.map(|body| by_look(&body)).unwrap_or_default())
}

/// How far the mesh of a cut solid is from its surface, at most.
pub(crate) fn deviation(node: &Csg) -> f64 {
    match node.bounds() {
        Bounds::Sphere(within) => deviation_within(node, 1.0, within.radius),
        _ => 0.0,
    }
}

fn deviation_within(node: &Csg, scale: f64, within: f64) -> f64 {
    match node {
        Csg::Sphere { radius, .. } => {
            let radius = radius * scale;
            radius * deviation_of_sphere(steps(radius, within))
        }
        Csg::Cylinder { radius, .. } => sagitta(radius * scale, AROUND),
        Csg::Cone {
            base_radius,
            cap_radius,
            ..
        } => sagitta(base_radius.max(*cap_radius) * scale, AROUND),
        // Half as many steps around the tube are four times as far off.
        Csg::Torus { major, minor } => 2.0 * sagitta((major + 5.0 * minor) * scale, AROUND_RING),
        Csg::Scale(by, node) => deviation_within(node, scale * by.abs().max_element(), within),
        other => {
            let inside = other.children().into_iter();
            inside
                .map(|node| deviation_within(node, scale, within))
                .fold(0.0, f64::max)
        }
    }
}

struct Cutter {
    /// Around all that is left in the end.
    within: Sphere,
}

impl Cutter {
    /// `None` where nothing is inside.
    fn body(
        &self,
        node: &Csg,
        placement: DAffine3,
        look: usize,
        looks: &mut Vec<Material>,
    ) -> Result<Option<Body>, AdapterError> {
        let mesh = match node {
            Csg::Sphere { centre, radius } => {
                let steps = steps(radius * largest(&placement), self.within.radius);
                sphere(*centre, *radius, steps)
            }
            Csg::Box { min, max } => cuboid(*min, *max),
            Csg::Cylinder { base, cap, radius } => frustum(*base, *radius, *cap, *radius, AROUND),
            Csg::Cone {
                base,
                base_radius,
                cap,
                cap_radius,
            } => frustum(*base, *base_radius, *cap, *cap_radius, AROUND),
            Csg::Torus { major, minor } => torus(*major, *minor, AROUND_RING),
            Csg::Plane { normal, distance } => {
                let block = self.block_below(*normal, *distance, placement);
                return block.map(|mesh| body_of(&mesh, look)).transpose();
            }
            Csg::Mesh(mesh) => {
                let mut mesh = TriangleMesh::clone(mesh);
                if volume(&mesh) < 0.0 {
                    turn_over(&mut mesh);
                }
                mesh
            }
            Csg::Union(nodes) => {
                return self.joined(nodes, placement, look, looks);
            }
            Csg::Intersection(nodes) => {
                let mut common: Option<Body> = None;
                for node in nodes {
                    let Some(body) = self.body(node, placement, look, looks)? else {
                        return Ok(None);
                    };
                    common = match common {
                        None => Some(body),
                        Some(so_far) => boolean(&so_far, &body, OpType::Intersect)?,
                    };
                    if common.is_none() {
                        return Ok(None);
                    }
                }
                return Ok(common);
            }
            Csg::Difference(first, rest) => {
                let mut left = self.body(first, placement, look, looks)?;
                for node in rest {
                    let cut = self.body(node, placement, look, looks)?;
                    if let (Some(body), Some(cut)) = (&left, cut) {
                        left = boolean(body, &cut, OpType::Subtract)?;
                    }
                }
                return Ok(left);
            }
            Csg::Translate(..) | Csg::Rotate(..) | Csg::Scale(..) | Csg::Look(..) => {
                let (node, placement, look) = descend(node, placement, look, looks);
                return self.body(node, placement, look, looks);
            }
        };
        if mesh.triangles.is_empty() {
            return Ok(None);
        }
        body_of(&moved(mesh, placement), look).map(Some)
    }

    fn joined(
        &self,
        nodes: &[Csg],
        placement: DAffine3,
        look: usize,
        looks: &mut Vec<Material>,
    ) -> Result<Option<Body>, AdapterError> {
        let mut all: Option<Body> = None;
        for node in nodes {
            let Some(body) = self.body(node, placement, look, looks)? else {
                continue;
            };
            all = match all {
                None => Some(body),
                Some(so_far) => boolean(&so_far, &body, OpType::Add)?,
            };
        }
        Ok(all)
    }

    /// The part of a half-space that matters: a block that sticks out of the
    /// sphere `within` on all sides but the plane's.
    fn block_below(
        &self,
        normal: DVec3,
        distance: f64,
        placement: DAffine3,
    ) -> Option<TriangleMesh> {
        let (normal, point) = placed_plane(normal, distance, placement)?;
        let Sphere { centre, radius } = self.within;
        let above = (centre - point).dot(normal);
        if radius <= 0.0 || above >= radius {
            return None;
        }
        let (u, v) = normal.any_orthonormal_pair();
        let foot = centre - normal * above;
        let block = cuboid(
            DVec3::new(-2.0 * radius, -2.0 * radius, above - 2.0 * radius),
            DVec3::new(2.0 * radius, 2.0 * radius, 0.0),
        );
        Some(moved(block, DAffine3::from_cols(u, v, normal, foot)))
    }
}

/// The unit normal and a point of a plane that `placement` puts somewhere.
pub(crate) fn placed_plane(
    normal: DVec3,
    distance: f64,
    placement: DAffine3,
) -> Option<(DVec3, DVec3)> {
    let unit = normal.try_normalize()?;
    let point = placement.transform_point3(unit * distance);
    let turned = placement.matrix3.inverse().transpose() * unit;
    Some((turned.try_normalize()?, point))
}

fn body_of(mesh: &TriangleMesh, look: usize) -> Result<Body, AdapterError> {
    let positions: Vec<f64> = mesh.vertices.iter().flat_map(DVec3::to_array).collect();
    let corners: Vec<usize> = mesh
        .triangles
        .iter()
        .flatten()
        .map(|&i| i as usize)
        .collect();
    let looks = vec![look as f64; corners.len()];
    unharmed(|| Manifold::new_with_values(&positions, &corners, &looks))
}

/// `None` where nothing is left.
fn boolean(a: &Body, b: &Body, operation: OpType) -> Result<Option<Body>, AdapterError> {
    let result = unharmed(|| compute_boolean(a, b, operation))?;
    Ok((result.nf > 0).then_some(result))
}

/// What the crate that cuts meshes cannot do is an error, also where it panics.
fn unharmed<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, AdapterError> {
    let reason = match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(done)) => return Ok(done),
        Ok(Err(reason)) => reason,
        Err(_) => "its triangles are too entangled".to_owned(),
    };
    Err(unsupported(&format!(
        "a cut of meshes that are not closed, or degenerate: {reason}"
    )))
}

fn by_look(body: &Body) -> Vec<(TriangleMesh, usize)> {
    let vertices: Vec<DVec3> = body.ps.iter().map(|p| DVec3::new(p.x, p.y, p.z)).collect();
    let mut meshes: Vec<(TriangleMesh, usize)> = Vec::new();
    for (k, triangle) in body.hs.chunks_exact(3).enumerate() {
        let look = body.vals.get(3 * k).map_or(0, |v| v.round() as usize);
        let place = meshes.iter().position(|(_, l)| *l == look);
        let place = place.unwrap_or_else(|| {
            meshes.push((TriangleMesh::default(), look));
            meshes.len() - 1
        });
        let corners = [0, 1, 2].map(|i| triangle[i].tail as u32);
        meshes[place].0.triangles.push(corners);
    }
    for (mesh, _) in &mut meshes {
        keep_used(mesh, &vertices);
    }
    meshes
}

/// Gives the mesh those of the vertices that its triangles name.
fn keep_used(mesh: &mut TriangleMesh, vertices: &[DVec3]) {
    let mut places: Vec<Option<u32>> = vec![None; vertices.len()];
    for corner in mesh.triangles.iter_mut().flatten() {
        let old = *corner as usize;
        *corner = *places[old].get_or_insert_with(|| {
            mesh.vertices.push(vertices[old]);
            (mesh.vertices.len() - 1) as u32
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn ball(x: f64, radius: f64) -> Csg {
        Csg::Sphere {
            centre: DVec3::X * x,
            radius,
        }
    }

    fn total(node: &Csg) -> f64 {
        let meshes = meshes(node, 0, &mut vec![Material::default()]).unwrap();
        let mut all = TriangleMesh::default();
        for (mesh, _) in &meshes {
            let first = all.vertices.len() as u32;
            all.vertices.extend(&mesh.vertices);
            let triangles = mesh.triangles.iter().map(|t| t.map(|i| i + first));
            all.triangles.extend(triangles);
        }
        volume(&all)
    }

    #[track_caller]
    fn near(found: f64, expected: f64) {
        assert!((found / expected - 1.0).abs() < 2e-3, "{found}, {expected}");
    }

    #[test]
    fn cuts_hold_the_volume_that_is_left() {
        let whole = 4.0 / 3.0 * PI;
        // Two unit balls at a distance of 1 share 5/12 of π.
        let lens = 5.0 / 12.0 * PI;
        let two = || vec![ball(0.0, 1.0), ball(1.0, 1.0)];
        near(total(&Csg::Intersection(two())), lens);
        let less = Csg::Difference(Box::new(ball(0.0, 1.0)), vec![ball(1.0, 1.0)]);
        near(total(&less), whole - lens);
        let both = Csg::Intersection(vec![Csg::Union(two()), ball(0.0, 3.0)]);
        near(total(&both), 2.0 * whole - lens);
    }

    #[test]
    fn a_half_space_cuts() {
        let below = |distance: f64| Csg::Plane {
            normal: DVec3::new(0.0, 2.0, 0.0),
            distance,
        };
        let cut = |distance| Csg::Intersection(vec![ball(5.0, 1.0), below(distance)]);
        near(total(&cut(0.0)), 2.0 / 3.0 * PI);
        near(total(&cut(7.0)), 4.0 / 3.0 * PI);
        assert_eq!(total(&cut(-7.0)), 0.0);
    }

    #[test]
    fn cut_faces_have_the_look_of_what_cut() {
        let red = Material {
            ambient: 0.5,
            ..Material::default()
        };
        let node = Csg::Difference(
            Box::new(ball(0.0, 1.0)),
            vec![Csg::Look(red, Box::new(ball(1.0, 1.0)))],
        );
        let mut looks = vec![Material::default()];
        let meshes = meshes(&node, 0, &mut looks).unwrap();
        assert_eq!(looks.len(), 2);
        for (mesh, look) in &meshes {
            let centre = if *look == 1 { DVec3::X } else { DVec3::ZERO };
            for corners in mesh.corners() {
                let middle = corners.into_iter().sum::<DVec3>() / 3.0;
                let off = middle.distance(centre) - 1.0;
                assert!(off.abs() < 1e-3, "{off} with look {look}");
            }
        }
        assert_eq!(meshes.len(), 2);
    }

    #[test]
    fn an_open_mesh_cannot_cut() {
        let open = TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2]],
        };
        let node = Csg::Difference(
            Box::new(ball(0.0, 1.0)),
            vec![Csg::Mesh(std::sync::Arc::new(open))],
        );
        let error = meshes(&node, 0, &mut vec![Material::default()]).unwrap_err();
        assert!(matches!(error, AdapterError::Unsupported { .. }), "{error}");
    }
}

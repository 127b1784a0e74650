//! Neutral solids, taken apart into what Mitsuba has shapes for.
//!
//! A tree of unions becomes a list of placed shapes; what is cut becomes meshes
//! ([`cut`](crate::cut)); half-spaces stay apart, for they have no end and are
//! drawn as far as the eye sees.

use std::f64::consts::PI;
use std::sync::Arc;

use decor_api::scene::rotation;
use decor_api::{AdapterError, Csg, Material, TriangleMesh};
use glam::{DAffine3, DVec3};

use crate::cut::{self, placed_plane};
use crate::geometry;

/// A shape in coordinates of its own.
#[derive(Clone, Debug)]
pub(crate) enum Shape {
    Sphere {
        centre: DVec3,
        radius: f64,
    },
    Box {
        min: DVec3,
        max: DVec3,
    },
    Cylinder {
        base: DVec3,
        cap: DVec3,
        radius: f64,
    },
    Cone {
        base: DVec3,
        base_radius: f64,
        cap: DVec3,
        cap_radius: f64,
    },
    Torus {
        major: f64,
        minor: f64,
    },
    Mesh(Arc<TriangleMesh>),
}

/// A shape, where it is, and the number of its look in the model.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub shape: Shape,
    pub placement: DAffine3,
    pub look: usize,
}

/// All below a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSpace {
    /// Of length 1, out of the solid half.
    pub normal: DVec3,
    /// A point of the plane.
    pub point: DVec3,
    pub look: usize,
}

impl HalfSpace {
    /// The unit normal from the eye, and the height of the plane along it.
    pub fn seen_by(&self, from_eye: &DAffine3) -> (DVec3, f64) {
        let turned = from_eye.matrix3.inverse().transpose() * self.normal;
        let normal = turned.normalize_or(DVec3::Y);
        (normal, from_eye.transform_point3(self.point).dot(normal))
    }
}

/// A prototype, taken apart.
#[derive(Clone, Debug, Default)]
pub(crate) struct Model {
    pub parts: Vec<Part>,
    pub half_spaces: Vec<HalfSpace>,
    pub looks: Vec<Material>,
    /// How far meshes are from the round surfaces that they stand for.
    pub deviation: f64,
}

impl Model {
    /// Takes a solid apart. What has no look of its own has the default one.
    pub fn new(solid: &Csg) -> Result<Self, AdapterError> {
        let mut model = Self {
            looks: vec![Material::default()],
            ..Self::default()
        };
        model.add(solid, DAffine3::IDENTITY, 0)?;
        Ok(model)
    }

    fn add(&mut self, node: &Csg, placement: DAffine3, look: usize) -> Result<(), AdapterError> {
        let shape = match node {
            Csg::Sphere { centre, radius } => Shape::Sphere {
                centre: *centre,
                radius: *radius,
            },
            Csg::Box { min, max } => Shape::Box {
                min: *min,
                max: *max,
            },
            Csg::Cylinder { base, cap, radius } => Shape::Cylinder {
                base: *base,
                cap: *cap,
                radius: *radius,
            },
            Csg::Cone {
                base,
                base_radius,
                cap,
                cap_radius,
            } => {
                let radius = base_radius.max(*cap_radius) * largest(&placement);
                let deviation = sagitta(radius, geometry::AROUND);
                self.deviation = self.deviation.max(deviation);
                Shape::Cone {
                    base: *base,
                    base_radius: *base_radius,
                    cap: *cap,
                    cap_radius: *cap_radius,
                }
            }
            Csg::Torus { major, minor } => Shape::Torus {
                major: *major,
                minor: *minor,
            },
            Csg::Mesh(mesh) if mesh.triangles.is_empty() => return Ok(()),
            Csg::Mesh(mesh) => Shape::Mesh(Arc::clone(mesh)),
            Csg::Plane { normal, distance } => {
                if let Some((normal, point)) = placed_plane(*normal, *distance, placement) {
                    self.half_spaces.push(HalfSpace {
                        normal,
                        point,
                        look,
                    });
                }
                return Ok(());
            }
            Csg::Union(nodes) => {
                return nodes
                    .iter()
                    .try_for_each(|node| self.add(node, placement, look));
            }
            Csg::Intersection(nodes) if nodes.is_empty() => return Ok(()),
            // One alone is not cut: it keeps its own shape.
            Csg::Intersection(nodes) if nodes.len() == 1 => {
                return self.add(&nodes[0], placement, look);
            }
            Csg::Difference(first, rest) if rest.is_empty() => {
                return self.add(first, placement, look);
            }
            Csg::Intersection(_) | Csg::Difference(..) => {
                let deviation = cut::deviation(node) * largest(&placement);
                self.deviation = self.deviation.max(deviation);
                for (mesh, look) in cut::meshes(node, look, &mut self.looks)? {
                    self.parts.push(Part {
                        shape: Shape::Mesh(Arc::new(mesh)),
                        placement,
                        look,
                    });
                }
                return Ok(());
            }
            Csg::Translate(..) | Csg::Rotate(..) | Csg::Scale(..) | Csg::Look(..) => {
                let (node, placement, look) = descend(node, placement, look, &mut self.looks);
                return self.add(node, placement, look);
            }
        };
        self.parts.push(Part {
            shape,
            placement,
            look,
        });
        Ok(())
    }
}

/// Through one node that only places or paints what is below.
pub(crate) fn descend<'a>(
    node: &'a Csg,
    placement: DAffine3,
    look: usize,
    looks: &mut Vec<Material>,
) -> (&'a Csg, DAffine3, usize) {
    match node {
        Csg::Translate(by, node) => (node, placement * DAffine3::from_translation(*by), look),
        Csg::Rotate(by, node) => (node, placement * DAffine3::from_quat(rotation(*by)), look),
        Csg::Scale(by, node) => (node, placement * DAffine3::from_scale(*by), look),
        Csg::Look(material, node) => {
            looks.push(*material);
            (node, placement, looks.len() - 1)
        }
        other => (other, placement, look),
    }
}

/// By how much `placement` enlarges along the model's axes, at most.
pub(crate) fn largest(placement: &DAffine3) -> f64 {
    let m = placement.matrix3;
    [m.x_axis, m.y_axis, m.z_axis]
        .map(DVec3::length)
        .into_iter()
        .fold(0.0, f64::max)
}

/// How far the sides of a polygon of so many corners are from its circle.
pub(crate) fn sagitta(radius: f64, around: u32) -> f64 {
    radius * (1.0 - (PI / f64::from(around)).cos())
}

/// By how much `placement` enlarges, where it keeps angles.
pub(crate) fn similarity(placement: &DAffine3) -> Option<f64> {
    let m = placement.matrix3;
    let scale = m.x_axis.length();
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-9 * scale * scale;
    let square = scale * scale;
    let lengths = [m.x_axis, m.y_axis, m.z_axis].map(DVec3::length_squared);
    let right = [
        m.x_axis.dot(m.y_axis),
        m.y_axis.dot(m.z_axis),
        m.z_axis.dot(m.x_axis),
    ];
    let keeps = lengths.into_iter().all(|l| close(l, square))
        && right.into_iter().all(|r| close(r, 0.0))
        && scale > 0.0;
    keeps.then_some(scale)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_keeps_angles_is_a_similarity() {
        let turned = DAffine3::from_quat(rotation(DVec3::new(10.0, 20.0, 30.0)));
        let all = |by: f64| DAffine3::from_scale(DVec3::splat(by));
        let found = similarity(&(turned * all(-3.0) * turned)).unwrap();
        assert!((found - 3.0).abs() < 1e-12);
        let uneven = DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.001));
        assert_eq!(similarity(&(turned * uneven)), None);
    }
}

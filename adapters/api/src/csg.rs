//! The neutral description of a solid: a tree that every adapter can walk.

use std::sync::Arc;

use glam::DVec3;

use crate::material::Material;
use crate::mesh::TriangleMesh;

/// A node of a CSG tree. Lengths in the object's own units.
#[derive(Clone, Debug, PartialEq)]
pub enum Csg {
    /// A ball.
    Sphere {
        /// Its centre.
        centre: DVec3,
        /// Its radius, > 0.
        radius: f64,
    },
    /// A box along the axes; `min` is below `max` in every coordinate.
    Box {
        /// The corner with the least coordinates.
        min: DVec3,
        /// The opposite corner.
        max: DVec3,
    },
    /// A solid cylinder.
    Cylinder {
        /// The centre of one end.
        base: DVec3,
        /// The centre of the other.
        cap: DVec3,
        /// Its radius, > 0.
        radius: f64,
    },
    /// A solid, possibly truncated, cone.
    Cone {
        /// The centre of one end.
        base: DVec3,
        /// The radius there, ≥ 0.
        base_radius: f64,
        /// The centre of the other end.
        cap: DVec3,
        /// The radius there, ≥ 0; not both are 0.
        cap_radius: f64,
    },
    /// A ring around the y axis, in the plane y = 0.
    Torus {
        /// From the axis to the middle of the tube.
        major: f64,
        /// The radius of the tube, in (0, major].
        minor: f64,
    },
    /// The half-space below the plane of the points p with
    /// p · normal = distance · |normal|.
    Plane {
        /// Points out of the solid half.
        normal: DVec3,
        /// From the origin along the normal.
        distance: f64,
    },
    /// A triangle mesh: a surface, without an inside.
    Mesh(Arc<TriangleMesh>),
    /// All of them.
    Union(Vec<Csg>),
    /// What they have in common.
    Intersection(Vec<Csg>),
    /// The first without the others. The cut faces have the look of what cut.
    Difference(Box<Csg>, Vec<Csg>),
    /// Moved by a vector.
    Translate(DVec3, Box<Csg>),
    /// Turned about x, then y, then z, in degrees, left-handed (as POV-Ray does).
    Rotate(DVec3, Box<Csg>),
    /// Scaled along the axes; no factor is 0.
    Scale(DVec3, Box<Csg>),
    /// A look for everything below that has none of its own.
    Look(Material, Box<Csg>),
}

impl Csg {
    /// The children of this node, in order.
    pub fn children(&self) -> Vec<&Csg> {
        match self {
            Self::Union(nodes) | Self::Intersection(nodes) => nodes.iter().collect(),
            Self::Difference(first, rest) => std::iter::once(&**first).chain(rest.iter()).collect(),
            Self::Translate(_, node) | Self::Rotate(_, node) | Self::Scale(_, node) => {
                vec![node]
            }
            Self::Look(_, node) => vec![node],
            _ => Vec::new(),
        }
    }

    /// Does anything in the tree mirror or let light through?
    pub fn is_optical(&self) -> bool {
        let own = matches!(self, Self::Look(material, _) if material.is_optical());
        own || self.children().into_iter().any(Self::is_optical)
    }
}

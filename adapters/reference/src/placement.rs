//! Affine placements, with their inverses kept beside them.

use decor_api::scene::rotation;
use glam::{DMat3, DVec3};

use crate::extent::Extent;
use crate::ray::Ray;

/// Where a primitive lies in its object. The inverse is built along with it,
/// factor by factor: inverting the product would lose what a large scale next
/// to a small one has left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    linear: DMat3,
    inverse: DMat3,
    offset: DVec3,
}

impl Placement {
    pub const IDENTITY: Self = Self {
        linear: DMat3::IDENTITY,
        inverse: DMat3::IDENTITY,
        offset: DVec3::ZERO,
    };

    /// What stands inside is moved first.
    pub fn translated(&self, by: DVec3) -> Self {
        Self {
            offset: self.offset + self.linear * by,
            ..*self
        }
    }

    /// What stands inside is turned first: about x, then y, then z, in degrees.
    pub fn rotated(&self, angles_deg: DVec3) -> Self {
        let turn = DMat3::from_quat(rotation(angles_deg));
        Self {
            linear: self.linear * turn,
            inverse: turn.transpose() * self.inverse,
            offset: self.offset,
        }
    }

    /// What stands inside is scaled first.
    pub fn scaled(&self, factors: DVec3) -> Self {
        Self {
            linear: self.linear * DMat3::from_diagonal(factors),
            inverse: DMat3::from_diagonal(factors.recip()) * self.inverse,
            offset: self.offset,
        }
    }

    /// Is every number of it finite? A factor of 0 has no inverse.
    pub fn is_usable(&self) -> bool {
        self.linear.is_finite() && self.inverse.is_finite() && self.offset.is_finite()
    }

    /// The ray in the primitive's coordinates; its parameter keeps its meaning.
    pub fn inwards(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.inverse * (ray.origin - self.offset),
            direction: self.inverse * ray.direction,
        }
    }

    /// A normal of the primitive in the object's coordinates, also where it is
    /// mirrored or scaled unevenly; its length changes.
    pub fn normal_outwards(&self, normal: DVec3) -> DVec3 {
        self.inverse.transpose() * normal
    }

    /// The box around the placed box.
    pub fn extent_outwards(&self, extent: &Extent) -> Extent {
        extent.transformed(&self.linear, self.offset)
    }
}

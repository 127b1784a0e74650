//! Boxes along the axes, for the bounds of CSG trees.

use glam::DVec3;

use crate::bounds::{Bounds, Sphere};

/// A box along the axes that may be infinite. Empty where `min` > `max`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aabb {
    pub min: DVec3,
    pub max: DVec3,
}

impl Aabb {
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };
    pub const ALL: Self = Self {
        min: DVec3::NEG_INFINITY,
        max: DVec3::INFINITY,
    };

    pub fn around(centre: DVec3, half: DVec3) -> Self {
        Self {
            min: centre - half,
            max: centre + half,
        }
    }

    pub fn around_balls(balls: &[Sphere]) -> Self {
        let each = balls
            .iter()
            .map(|b| Self::around(b.centre, DVec3::splat(b.radius)));
        each.fold(Self::EMPTY, Self::union)
    }

    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    pub fn grown(self, by: f64) -> Self {
        Self {
            min: self.min - by,
            max: self.max + by,
        }
    }

    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    pub fn is_finite(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    pub fn corners(&self) -> Vec<Sphere> {
        super::corners(self.min, self.max)
            .map(super::point)
            .to_vec()
    }

    pub fn bounds(&self) -> Bounds {
        if self.is_empty() {
            return Bounds::Empty;
        }
        let centre = self.min * 0.5 + self.max * 0.5;
        let half = (self.max - centre).max(centre - self.min);
        let size = half.max_element();
        // In units of its own size: the squares of tiny lengths are 0.
        let radius = if size > 0.0 {
            size * (half / size).length()
        } else {
            0.0
        };
        Bounds::sphere(centre, radius).rounded_outwards()
    }
}

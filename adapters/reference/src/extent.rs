//! Boxes along the axes: what the trees sort by.

use glam::{DMat3, DVec3};

/// A box along the axes. Empty where `min` is above `max`; unbounded where a
/// coordinate is infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Extent {
    pub min: DVec3,
    pub max: DVec3,
}

impl Extent {
    pub const EMPTY: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    pub const EVERYTHING: Self = Self {
        min: DVec3::NEG_INFINITY,
        max: DVec3::INFINITY,
    };

    /// The box around some points.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |e, p| Self {
            min: e.min.min(p),
            max: e.max.max(p),
        })
    }

    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    pub fn is_bounded(&self) -> bool {
        self.min.is_finite() && self.max.is_finite()
    }

    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    pub fn intersection(&self, other: &Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// The largest absolute coordinate; 0 where it is empty or unbounded.
    pub fn reach(&self) -> f64 {
        if self.is_bounded() && !self.is_empty() {
            self.min.abs().max(self.max.abs()).max_element()
        } else {
            0.0
        }
    }

    /// The box around the box where `linear` and then `offset` take it.
    pub fn transformed(&self, linear: &DMat3, offset: DVec3) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        if !self.is_bounded() {
            return Self::EVERYTHING;
        }
        let centre = self.min * 0.5 + self.max * 0.5;
        let half = self.max * 0.5 - self.min * 0.5;
        let centre = *linear * centre + offset;
        let half = linear.abs() * half;
        Self {
            min: centre - half,
            max: centre + half,
        }
    }

    /// A little larger: rounding on the way here must not cut anything off.
    pub fn widened(&self) -> Self {
        if self.is_empty() || !self.is_bounded() {
            return *self;
        }
        let by = DVec3::splat(1e-12 * self.reach() + f64::MIN_POSITIVE);
        Self {
            min: self.min - by,
            max: self.max + by,
        }
    }
}

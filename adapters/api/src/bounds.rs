//! Bounding spheres: what the motion of an object is measured on.

use glam::DVec3;

use crate::scene::Pose;

/// A sphere, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius, ≥ 0.
    pub radius: f64,
}

/// What encloses an object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bounds {
    /// Nothing is there: no surface at all.
    Empty,
    /// Everything lies in this sphere.
    Sphere(Sphere),
    /// The object has no end (a plane), or nobody knows.
    Unbounded,
}

impl Bounds {
    /// The sphere around `centre`; unbounded where a number is not finite.
    pub fn sphere(centre: DVec3, radius: f64) -> Self {
        if centre.is_finite() && radius.is_finite() && radius >= 0.0 {
            Self::Sphere(Sphere { centre, radius })
        } else {
            Self::Unbounded
        }
    }

    /// The sphere around the box from `min` to `max`, rounded outwards.
    pub fn around_box(min: DVec3, max: DVec3) -> Self {
        if min.cmpgt(max).any() {
            return Self::Empty;
        }
        let centre = min * 0.5 + max * 0.5;
        let radius = (max - centre).length().max((min - centre).length());
        Self::sphere(centre, radius).rounded_outwards()
    }

    /// A sphere around both.
    pub fn union(self, other: Self) -> Self {
        match (self, other) {
            (Self::Empty, b) => b,
            (a, Self::Empty) => a,
            (Self::Unbounded, _) | (_, Self::Unbounded) => Self::Unbounded,
            (Self::Sphere(a), Self::Sphere(b)) => {
                let apart = b.centre - a.centre;
                let distance = apart.length();
                if distance + b.radius <= a.radius {
                    return Self::Sphere(a);
                }
                if distance + a.radius <= b.radius {
                    return Self::Sphere(b);
                }
                let radius = 0.5 * (distance + a.radius + b.radius);
                let centre = a.centre + apart * ((radius - a.radius) / distance);
                Self::sphere(centre, radius).rounded_outwards()
            }
        }
    }

    /// The same, a few units in the last place larger: what was computed with
    /// rounding must still contain the object.
    pub fn rounded_outwards(self) -> Self {
        match self {
            Self::Sphere(s) => Self::sphere(
                s.centre,
                s.radius * (1.0 + 1e-14) + s.centre.abs().max_element() * 1e-14,
            ),
            other => other,
        }
    }

    /// The bounds of the object where `pose` puts it.
    pub fn posed(self, pose: &Pose) -> Self {
        match self {
            Self::Sphere(s) => Self::sphere(pose.transform().transform_point3(s.centre), s.radius)
                .rounded_outwards(),
            other => other,
        }
    }

    /// The sphere, where there is one.
    pub fn as_sphere(&self) -> Option<&Sphere> {
        match self {
            Self::Sphere(s) => Some(s),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vec3() -> impl Strategy<Value = DVec3> {
        (-1e3..1e3, -1e3..1e3, -1e3..1e3).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn a_union_contains_both(a in vec3(), b in vec3(), r in 0.0..100.0, q in 0.0..100.0) {
            let Bounds::Sphere(u) = Bounds::sphere(a, r).union(Bounds::sphere(b, q)) else {
                panic!("two spheres have a sphere around them");
            };
            prop_assert!((a - u.centre).length() + r <= u.radius * (1.0 + 1e-12));
            prop_assert!((b - u.centre).length() + q <= u.radius * (1.0 + 1e-12));
        }

        #[test]
        fn a_sphere_around_a_box_contains_its_corners(a in vec3(), b in vec3()) {
            let (min, max) = (a.min(b), a.max(b));
            let Bounds::Sphere(s) = Bounds::around_box(min, max) else {
                panic!("a finite box has a sphere around it");
            };
            for corner in [min, max, DVec3::new(min.x, max.y, min.z)] {
                prop_assert!((corner - s.centre).length() <= s.radius);
            }
        }
    }

    #[test]
    fn what_is_not_finite_is_unbounded() {
        assert_eq!(Bounds::sphere(DVec3::NAN, 1.0), Bounds::Unbounded);
        assert_eq!(
            Bounds::sphere(DVec3::ZERO, f64::INFINITY),
            Bounds::Unbounded
        );
    }
}

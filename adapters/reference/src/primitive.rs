//! Ball, box and half-space, and what every primitive answers.

use std::sync::Arc;

use decor_api::Csg;
use glam::DVec3;

use crate::extent::Extent;
use crate::frustum::Frustum;
use crate::mesh::Mesh;
use crate::ray::{Ray, unit};
use crate::span::Span;
use crate::torus::Torus;

/// A solid without parts, in its own coordinates.
#[derive(Clone, Debug)]
pub(crate) enum Primitive {
    Ball { centre: DVec3, radius: f64 },
    Block { min: DVec3, max: DVec3 },
    HalfSpace { normal: DVec3, distance: f64 },
    Frustum(Frustum),
    Torus(Torus),
    Mesh(Arc<Mesh>),
}

impl Primitive {
    /// The primitive of a leaf of a tree. `None` where it has no inside (a
    /// radius of 0, a normal of no length) or where the node is no leaf.
    pub fn of(node: &Csg) -> Option<Self> {
        let positive = |v: f64| v > 0.0 && v.is_finite();
        match *node {
            Csg::Sphere { centre, radius } => {
                (positive(radius) && centre.is_finite()).then_some(Self::Ball { centre, radius })
            }
            Csg::Box { min, max } => min.cmplt(max).all().then_some(Self::Block { min, max }),
            Csg::Cylinder { base, cap, radius } => {
                Frustum::new(base, radius, cap, radius).map(Self::Frustum)
            }
            Csg::Cone {
                base,
                base_radius,
                cap,
                cap_radius,
            } => Frustum::new(base, base_radius, cap, cap_radius).map(Self::Frustum),
            Csg::Torus { major, minor } => {
                (positive(major) && positive(minor)).then_some(Self::Torus(Torus { major, minor }))
            }
            Csg::Plane { normal, distance } => unit(normal)
                .filter(|_| distance.is_finite())
                .map(|normal| Self::HalfSpace { normal, distance }),
            Csg::Mesh(ref mesh) => Mesh::new(mesh).map(|mesh| Self::Mesh(Arc::new(mesh))),
            _ => None,
        }
    }

    /// The box around it.
    pub fn extent(&self) -> Extent {
        match self {
            Self::Ball { centre, radius } => Extent {
                min: *centre - *radius,
                max: *centre + *radius,
            },
            Self::Block { min, max } => Extent {
                min: *min,
                max: *max,
            },
            Self::HalfSpace { .. } => Extent::EVERYTHING,
            Self::Frustum(frustum) => frustum.extent(),
            Self::Torus(torus) => torus.extent(),
            Self::Mesh(mesh) => mesh.extent(),
        }
    }

    /// The pieces of the whole line that are inside. A mesh's inside is what
    /// lies between its odd and its even crossings; one that is not closed has
    /// none behind its last.
    pub fn spans(&self, ray: &Ray, look: u32) -> Vec<Span> {
        let span = |(enter, leave)| Span::new(enter, leave, look);
        match self {
            Self::Ball { centre, radius } => one(ball(ray, *centre, *radius).map(span)),
            Self::Block { min, max } => one(block(ray, *min, *max).map(span)),
            Self::HalfSpace { normal, distance } => {
                one(half_space(ray, *normal, *distance).map(span))
            }
            Self::Frustum(frustum) => one(frustum.span(ray).map(span)),
            Self::Torus(torus) => torus.spans(ray).into_iter().map(span).collect(),
            Self::Mesh(mesh) => mesh.spans(ray, look),
        }
    }
}

/// Two ends, each a parameter and a normal.
pub(crate) type Ends = ((f64, DVec3), (f64, DVec3));

/// A span with an inside; not one of length 0, and not NaN.
fn one(span: Option<Span>) -> Vec<Span> {
    span.filter(|s| s.enter.t < s.leave.t).into_iter().collect()
}

fn ball(ray: &Ray, centre: DVec3, radius: f64) -> Option<Ends> {
    // From the point of the line that is closest to the centre both ends are
    // equally far: nothing is subtracted that is nearly equal, however far
    // away the eye is.
    let middle = ray.closest_to(centre)?;
    let off = ray.at(middle) - centre;
    let distance = off.length();
    let gap = (radius - distance) * (radius + distance);
    if gap.is_nan() || gap <= 0.0 {
        return None;
    }
    let half = (gap / ray.direction.length_squared()).sqrt();
    let end = |t: f64| (middle + t, (off + ray.direction * t) / radius);
    Some((end(-half), end(half)))
}

fn block(ray: &Ray, min: DVec3, max: DVec3) -> Option<Ends> {
    let mut enter = (f64::NEG_INFINITY, DVec3::X);
    let mut leave = (f64::INFINITY, DVec3::X);
    for axis in 0..3 {
        let (o, d) = (ray.origin[axis], ray.direction[axis]);
        if d == 0.0 {
            if o < min[axis] || o > max[axis] {
                return None;
            }
            continue;
        }
        let (near, far) = if d > 0.0 {
            (min[axis], max[axis])
        } else {
            (max[axis], min[axis])
        };
        let along = DVec3::AXES[axis] * d.signum();
        let (near, far) = ((near - o) / d, (far - o) / d);
        if near > enter.0 {
            enter = (near, -along);
        }
        if far < leave.0 {
            leave = (far, along);
        }
    }
    Some((enter, leave))
}

fn half_space(ray: &Ray, normal: DVec3, distance: f64) -> Option<Ends> {
    let above = ray.origin.dot(normal) - distance;
    let slope = ray.direction.dot(normal);
    let (from, to) = ((f64::NEG_INFINITY, normal), (f64::INFINITY, normal));
    if slope == 0.0 {
        return (above <= 0.0).then_some((from, to));
    }
    let t = -above / slope;
    Some(if slope < 0.0 {
        ((t, normal), to)
    } else {
        (from, (t, normal))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::span::first_after;

    fn ends(primitive: &Primitive, origin: DVec3, direction: DVec3) -> Vec<(f64, f64)> {
        primitive
            .spans(&Ray { origin, direction }, 0)
            .iter()
            .map(|s| (s.enter.t, s.leave.t))
            .collect()
    }

    #[test]
    fn a_far_small_ball_keeps_its_digits() {
        let ball = Primitive::Ball {
            centre: DVec3::Z * 1e6,
            radius: 1e-3,
        };
        let found = ends(&ball, DVec3::new(6e-4, 0.0, 0.0), DVec3::Z);
        // A 3-4-5 triangle: half the chord is 8e-4. One digit of 1e6 is 1e-10.
        assert!((found[0].0 - (1e6 - 8e-4)).abs() < 2e-10, "{found:?}");
        assert!((found[0].1 - (1e6 + 8e-4)).abs() < 2e-10, "{found:?}");
    }

    #[test]
    fn the_parameter_is_the_ray_s_own_not_a_length() {
        let ball = Primitive::Ball {
            centre: DVec3::Z * 8.0,
            radius: 2.0,
        };
        assert_eq!(ends(&ball, DVec3::ZERO, DVec3::Z * 2.0), [(3.0, 5.0)]);
    }

    #[test]
    fn a_box_from_outside_inside_and_along_its_face() {
        let cube = Primitive::Block {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        };
        assert_eq!(ends(&cube, DVec3::Z * -5.0, DVec3::Z), [(4.0, 6.0)]);
        assert_eq!(ends(&cube, DVec3::ZERO, DVec3::X), [(-1.0, 1.0)]);
        assert_eq!(ends(&cube, DVec3::X * 1.5, DVec3::Z), []);
        assert_eq!(
            ends(&cube, DVec3::new(1.0, 0.0, 0.0), DVec3::Y),
            [(-1.0, 1.0)]
        );
        let diagonal = cube.spans(
            &Ray {
                origin: DVec3::new(-5.0, 0.5, 0.0),
                direction: DVec3::X,
            },
            7,
        );
        assert_eq!(diagonal[0].enter.normal, -DVec3::X);
        assert_eq!(diagonal[0].leave.normal, DVec3::X);
        assert_eq!(diagonal[0].leave.look, 7);
    }

    #[test]
    fn a_plane_has_an_inside_below() {
        let ground = Primitive::of(&Csg::Plane {
            normal: DVec3::Y * 3.0,
            distance: 1.0,
        })
        .unwrap();
        let down = ground.spans(
            &Ray {
                origin: DVec3::Y * 4.0,
                direction: -DVec3::Y,
            },
            0,
        );
        assert_eq!(first_after(&down, 0.0).map(|c| c.t), Some(3.0));
        let along = |y: f64| ends(&ground, DVec3::Y * y, DVec3::X);
        assert_eq!(along(2.0), []);
        assert_eq!(along(0.0), [(f64::NEG_INFINITY, f64::INFINITY)]);
    }

    #[test]
    fn what_has_no_inside_is_nothing() {
        for nothing in [
            Csg::Sphere {
                centre: DVec3::ZERO,
                radius: 0.0,
            },
            Csg::Sphere {
                centre: DVec3::ZERO,
                radius: f64::NAN,
            },
            Csg::Box {
                min: DVec3::ONE,
                max: DVec3::ONE,
            },
            Csg::Plane {
                normal: DVec3::ZERO,
                distance: 0.0,
            },
            Csg::Cylinder {
                base: DVec3::ONE,
                cap: DVec3::ONE,
                radius: 1.0,
            },
            Csg::Mesh(Arc::default()),
        ] {
            assert!(Primitive::of(&nothing).is_none(), "{nothing:?}");
        }
    }
}

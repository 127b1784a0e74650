//! What is really seen: solids of spheres, boxes and planes, cut by intervals
//! along a ray, in closed form. No code of any adapter is in it.

use glam::{DAffine3, DVec3};

use crate::bounds::{Bounds, Sphere};
use crate::camera::Camera;
use crate::csg::Csg;
use crate::layer::{Layer, Size};
use crate::prototype::{Geometry, PrototypeTable};
use crate::scene::{Instance, Scene, rotation};

/// How far from a pixel's centre, in pixels, a renderer may sample: edges are
/// not compared where that decides what is seen, and depth may differ by as much
/// as the surface recedes.
const SLACK_PX: f64 = 1e-3;

/// The largest relative uncertainty of depth that is still of use.
const WORST_QUANTUM: f64 = 1e-5;

/// Along a ray, where a solid is: ascending, apart.
type Spans = Vec<(f64, f64)>;

/// One placed solid.
struct Placed<'a> {
    solid: &'a Csg,
    to_object: DAffine3,
    bounds: Option<Sphere>,
}

/// The objects of a scene that the camera sees.
pub struct Oracle<'a> {
    placed: Vec<Placed<'a>>,
    camera: Camera,
    size: Size,
}

impl<'a> Oracle<'a> {
    /// Of a scene whose geometry is neutral.
    pub fn new(prototypes: &'a PrototypeTable, scene: &Scene, size: Size) -> Self {
        let place = |instance: &Instance| {
            let prototype = prototypes.get(instance.prototype);
            let Geometry::Neutral(solid) = &prototype.geometry else {
                panic!("the oracle knows neutral solids alone");
            };
            Placed {
                solid,
                to_object: instance.pose.transform().inverse(),
                bounds: match prototype.bounds.posed(&instance.pose) {
                    Bounds::Sphere(sphere) => Some(sphere),
                    _ => None,
                },
            }
        };
        Self {
            placed: scene.instances.iter().map(place).collect(),
            camera: scene.camera,
            size,
        }
    }

    /// The distance along the ray through a point of the picture; +∞ where
    /// nothing is.
    pub fn depth(&self, x: f64, y: f64) -> f64 {
        let direction = self.camera.direction(self.size, x, y).normalize();
        let eye = self.camera.eye;
        let mut nearest = f64::INFINITY;
        for placed in &self.placed {
            if placed.bounds.is_some_and(|s| misses(&s, eye, direction)) {
                continue;
            }
            let origin = placed.to_object.transform_point3(eye);
            let along = placed.to_object.transform_vector3(direction);
            for (enters, leaves) in spans(placed.solid, origin, along) {
                let seen = if enters > 0.0 { enters } else { leaves };
                if seen > 0.0 {
                    nearest = nearest.min(seen);
                }
            }
        }
        nearest
    }

    /// Is it certain what a ray near the centre of pixel (x, y) meets? Then its
    /// depth, and by how much that may differ.
    pub fn certain(&self, x: u32, y: u32, at: (f64, f64)) -> Option<(f64, f64)> {
        let (x, y) = (f64::from(x) + at.0, f64::from(y) + at.1);
        let depth = self.depth(x, y);
        let mut spread = 0.0_f64;
        for (right, down) in [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)] {
            let beside = self.depth(x + right * SLACK_PX, y + down * SLACK_PX);
            if beside.is_finite() != depth.is_finite() {
                return None;
            }
            if depth.is_finite() {
                spread = spread.max((beside - depth).abs());
            }
        }
        // More than a slope: another surface begins here.
        (depth.is_infinite() || spread < 1e-2 * depth).then_some((depth, spread))
    }

    /// Every depth of the layer is the right one, to within what the layer
    /// itself says of its precision.
    pub fn assert_depth(&self, layer: &Layer) {
        let depths = layer.depth.as_deref().expect("depth was asked for");
        assert_eq!(depths.len(), layer.window.pixels(), "one depth a pixel");
        let (absolute, relative) = layer.depth_quantum;
        assert!(
            absolute >= 0.0 && relative >= 0.0,
            "the quantum {:?} is no precision",
            layer.depth_quantum
        );
        let (mut compared, mut met) = (0, 0);
        for y in layer.window.y..layer.window.bottom() {
            for x in layer.window.x..layer.window.right() {
                let Some((expected, spread)) = self.certain(x, y, (0.5, 0.5)) else {
                    continue;
                };
                compared += 1;
                let found = depths[layer.index(x, y)];
                if expected.is_infinite() {
                    assert!(
                        found == f64::INFINITY,
                        "pixel ({x}, {y}): nothing is there, and its depth is {found}"
                    );
                    continue;
                }
                met += 1;
                let quantum = absolute + relative * expected;
                assert!(
                    quantum <= WORST_QUANTUM * expected,
                    "pixel ({x}, {y}): a depth of {expected} known to {quantum} is of no use"
                );
                let off = (found - expected).abs();
                assert!(
                    off <= quantum + spread + 1e-12 * expected,
                    "pixel ({x}, {y}): the depth is {found}, should be {expected} \
                     (off by {off:.2e}; precise to {quantum:.2e}, it claims)"
                );
            }
        }
        let pixels = layer.window.pixels();
        assert!(compared * 10 >= pixels * 8, "too many edges to judge by");
        assert!(met > 0, "the scene of this test shows nothing");
    }
}

/// Does the ray pass by the sphere? Only where that is certain.
fn misses(sphere: &Sphere, eye: DVec3, direction: DVec3) -> bool {
    let to = sphere.centre - eye;
    let beside = to - direction * to.dot(direction);
    beside.length() > sphere.radius * (1.0 + 1e-9) + 1e-9 * to.length()
}

/// Where the line `origin + t·along` is inside of the solid.
fn spans(solid: &Csg, origin: DVec3, along: DVec3) -> Spans {
    match solid {
        Csg::Sphere { centre, radius } => {
            // From the point of the line that is nearest to the centre: no
            // digits are lost far away.
            let to = *centre - origin;
            let middle = to.dot(along) / along.length_squared();
            let beside = (to - along * middle).length_squared();
            let half = (radius * radius - beside) / along.length_squared();
            if half <= 0.0 {
                return Vec::new();
            }
            vec![(middle - half.sqrt(), middle + half.sqrt())]
        }
        Csg::Box { min, max } => {
            let (mut enters, mut leaves) = (f64::NEG_INFINITY, f64::INFINITY);
            for axis in 0..3 {
                if along[axis] == 0.0 {
                    if origin[axis] < min[axis] || origin[axis] > max[axis] {
                        return Vec::new();
                    }
                    continue;
                }
                let a = (min[axis] - origin[axis]) / along[axis];
                let b = (max[axis] - origin[axis]) / along[axis];
                enters = enters.max(a.min(b));
                leaves = leaves.min(a.max(b));
            }
            if enters < leaves {
                vec![(enters, leaves)]
            } else {
                Vec::new()
            }
        }
        Csg::Plane { normal, distance } => {
            let normal = normal.normalize();
            let (above, rises) = (normal.dot(origin) - distance, normal.dot(along));
            if rises == 0.0 {
                let everywhere = (f64::NEG_INFINITY, f64::INFINITY);
                return if above < 0.0 {
                    vec![everywhere]
                } else {
                    Vec::new()
                };
            }
            let crosses = -above / rises;
            vec![if rises < 0.0 {
                (crosses, f64::INFINITY)
            } else {
                (f64::NEG_INFINITY, crosses)
            }]
        }
        Csg::Union(nodes) => {
            let mut all: Spans = nodes.iter().flat_map(|n| spans(n, origin, along)).collect();
            all.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut merged: Spans = Vec::new();
            for span in all {
                match merged.last_mut() {
                    Some(last) if span.0 <= last.1 => last.1 = last.1.max(span.1),
                    _ => merged.push(span),
                }
            }
            merged
        }
        Csg::Intersection(nodes) => {
            let mut all = nodes.iter().map(|n| spans(n, origin, along));
            let first = all.next().unwrap_or_default();
            all.fold(first, |a, b| common(&a, &b))
        }
        Csg::Difference(first, rest) => {
            rest.iter().fold(spans(first, origin, along), |left, node| {
                common(&left, &outside(&spans(node, origin, along)))
            })
        }
        Csg::Translate(by, node) => spans(node, origin - *by, along),
        Csg::Rotate(by, node) => {
            let back = rotation(*by).inverse();
            spans(node, back * origin, back * along)
        }
        Csg::Scale(by, node) => spans(node, origin / *by, along / *by),
        Csg::Look(_, node) => spans(node, origin, along),
        other => panic!("the oracle does not know {other:?}"),
    }
}

fn common(a: &[(f64, f64)], b: &[(f64, f64)]) -> Spans {
    let pairs = a.iter().flat_map(|a| b.iter().map(move |b| (a, b)));
    pairs
        .map(|(a, b)| (a.0.max(b.0), a.1.min(b.1)))
        .filter(|(enters, leaves)| enters < leaves)
        .collect()
}

fn outside(spans: &[(f64, f64)]) -> Spans {
    let mut gaps = Vec::new();
    let mut from = f64::NEG_INFINITY;
    for &(enters, leaves) in spans {
        gaps.push((from, enters));
        from = leaves;
    }
    gaps.push((from, f64::INFINITY));
    gaps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(solid: &Csg) -> Spans {
        spans(solid, DVec3::Z * -10.0, DVec3::Z)
    }

    #[test]
    fn solids_are_cut_where_they_are() {
        let ball = Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 2.0,
        };
        let cube = Csg::Box {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        };
        let below = Csg::Plane {
            normal: DVec3::Z * 3.0,
            distance: 0.5,
        };
        assert_eq!(cut(&ball), [(8.0, 12.0)]);
        assert_eq!(cut(&cube), [(9.0, 11.0)]);
        assert_eq!(cut(&below), [(f64::NEG_INFINITY, 10.5)]);
        let hollow = Csg::Difference(Box::new(ball.clone()), vec![cube.clone()]);
        assert_eq!(cut(&hollow), [(8.0, 9.0), (11.0, 12.0)]);
        let both = Csg::Intersection(vec![ball.clone(), below]);
        assert_eq!(cut(&both), [(8.0, 10.5)]);
        let apart = Csg::Translate(DVec3::Z * 3.0, Box::new(cube));
        assert_eq!(cut(&Csg::Union(vec![apart, ball.clone()])), [(8.0, 14.0)]);
        let flat = Csg::Scale(DVec3::new(1.0, 1.0, 0.5), Box::new(ball));
        assert_eq!(cut(&flat), [(9.0, 11.0)]);
    }
}

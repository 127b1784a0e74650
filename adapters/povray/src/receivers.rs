//! Lit receivers: tiny white triangles at surface points, each facing a light,
//! and a camera that looks at each from just above.
//!
//! The camera is a `mesh_camera` over the very meshes that are drawn: its rays
//! start above the centroids, along the normals, and go back down. So a point
//! is written once. POV-Ray stores the vertices of a mesh in single precision:
//! points are gathered in cells of about 256 footprints, each a mesh with its
//! own coordinates, in units of the footprint, that is scaled and moved to its
//! place in double precision. A point keeps its digits wherever it lies.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fmt::Write as _;

use decor_api::{Light, LightKind, SurfacePoint};
use glam::DVec3;

use crate::number::{number, push_single, vector};

/// From a receiver's centre to its corners, in units of the footprint: none
/// reaches a neighbour's.
const RADIUS: f64 = 0.15;

/// How far above a receiver its ray starts, in units of the footprint.
const ABOVE: f64 = 0.2;

/// The smallest unit is 2 to this: POV-Ray meets nothing that is nearer than
/// 1e-4 to the start of a ray.
const FINEST: i32 = -10;

/// The largest unit is 2 to this.
const COARSEST: i32 = 60;

/// The side of a cell, in units. Single precision leaves 4e-6 of a unit: with
/// 1e-4, one of 3000 pixels was on the wrong side of one sample's shadow.
const CELL: f64 = 256.0;

/// The longest side of a cell, where single precision leaves 1e-4 of a scene
/// unit: a point under an area light lies on a caster of its own, and POV-Ray
/// takes a surface nearer than 1e-3 for the point's own.
const LONGEST: f64 = 4096.0;

/// The receivers of one frame and one light.
#[derive(Clone, Debug, PartialEq)]
pub struct Receivers {
    /// The meshes, the camera, and the objects.
    pub text: String,
    /// For each ray, in order: the number of its point, and the cosine of the
    /// light to its receiver, which is 1 but for rounding.
    pub rays: Vec<(usize, f64)>,
}

/// Where a point is gathered: the exponent of its unit, and its cell.
type Cell = (i32, [i64; 3]);

impl Receivers {
    /// The receivers at those of `points` that the light may reach. The first
    /// ray of all is none of theirs: it starts at `outside`.
    pub fn of(light: &Light, points: &[SurfacePoint], outside: DVec3) -> Self {
        let mut cells: BTreeMap<Cell, Vec<usize>> = BTreeMap::new();
        for (k, point) in points.iter().enumerate() {
            if light.may_reach(point.position) && towards(light, point.position).is_some() {
                cells.entry(cell_of(point)).or_default().push(k);
            }
        }
        let mut text = format!(
            "#declare Decor_First = mesh2 {{ vertex_vectors {{ 3,<1,0,0>,<0,1,0>,<0,0,1> }} \
             face_indices {{ 1,<0,1,2> }} translate {} }}\n",
            vector(outside)
        );
        let mut camera = String::from("camera { mesh_camera { 1 1 mesh { Decor_First }");
        let mut objects = String::new();
        let mut rays = Vec::with_capacity(points.len());
        for (number_of_cell, (cell, members)) in cells.iter().enumerate() {
            let name = format!("Decor_Points_{number_of_cell}");
            let _ = write!(text, "#declare {name} = ");
            push_mesh(&mut text, light, points, cell, members, &mut rays);
            let _ = write!(camera, " mesh {{ {name} }}");
            push_object(&mut objects, &name, points, cell, members);
        }
        let _ = writeln!(
            camera,
            " }} location <0,0,{}> direction <0,0,-1> }}",
            number(ABOVE)
        );
        text.push_str(&camera);
        text.push_str(&objects);
        Self { text, rays }
    }
}

/// The look of the receivers, whatever the film's declarations make the default.
pub const WHITE: &str = "#declare Decor_White = texture { pigment { rgb 1 } \
     finish { ambient 0 emission 0 diffuse 1 brilliance 1 phong 0 specular 0 \
     reflection 0 crand 0 } }\nbackground { rgb 0 transmit 1 }\n";

/// The direction from a point to the light.
fn towards(light: &Light, point: DVec3) -> Option<DVec3> {
    match light.kind {
        LightKind::Sun { towards } => (light.position - towards).try_normalize(),
        _ => (light.position - point).try_normalize(),
    }
}

fn cell_of(point: &SurfacePoint) -> Cell {
    let footprint = if point.footprint > 0.0 {
        point.footprint
    } else {
        0.0
    };
    // The logarithm of 0 is −∞, which `as` makes the smallest number.
    let level = (footprint.log2().floor() as i32).clamp(FINEST, COARSEST);
    let at = (point.position / side(level)).floor();
    (level, at.to_array().map(|c| c as i64))
}

/// The side of a cell, in scene units.
fn side(level: i32) -> f64 {
    let unit = 2.0_f64.powi(level);
    (unit * CELL).min(LONGEST.max(unit))
}

/// Appends the mesh of a cell, and its rays.
fn push_mesh(
    text: &mut String,
    light: &Light,
    points: &[SurfacePoint],
    cell: &Cell,
    members: &[usize],
    rays: &mut Vec<(usize, f64)>,
) {
    let (level, at) = *cell;
    let unit = 2.0_f64.powi(level);
    let centre = (DVec3::from_array(at.map(|c| c as f64)) + 0.5) * side(level);
    // Writing to a string cannot fail.
    let _ = write!(text, "mesh2 {{ vertex_vectors {{ {}", 3 * members.len());
    for &k in members {
        let local = (points[k].position - centre) / unit;
        let to_light = towards(light, points[k].position).unwrap_or(DVec3::Y);
        let corners = corners(local, to_light);
        for corner in corners {
            text.push(',');
            push_single(text, corner);
        }
        rays.push((
            k,
            cosine(light, corners.map(|c| centre + c * unit), corners),
        ));
    }
    let _ = write!(text, " }} face_indices {{ {}", members.len());
    for k in 0..members.len() {
        let _ = write!(text, ",<{},{},{}>", 3 * k, 3 * k + 1, 3 * k + 2);
    }
    let _ = writeln!(
        text,
        " }} scale {} translate {} }}",
        number(unit),
        vector(centre)
    );
}

/// Appends the object of a cell. POV-Ray keeps bounding boxes in single
/// precision, and far from the origin a mesh can stick out of its own: two small
/// spheres that nothing sees make the box of a union large enough. Inside of a
/// union there are no boxes.
fn push_object(
    text: &mut String,
    name: &str,
    points: &[SurfacePoint],
    cell: &Cell,
    members: &[usize],
) {
    let unit = 2.0_f64.powi(cell.0);
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for &k in members {
        low = low.min(points[k].position);
        high = high.max(points[k].position);
    }
    let farthest = low.abs().max(high.abs()).max_element();
    let margin = unit + 4.0 * f64::from(f32::EPSILON) * farthest;
    let _ = writeln!(
        text,
        "union {{ object {{ {name} }} sphere {{ {}, {unit} no_image }} sphere {{ {}, {unit} no_image }} \
         texture {{ Decor_White }} no_shadow no_reflection }}",
        vector(low - margin),
        vector(high + margin),
        unit = number(unit * 0.01)
    );
}

/// The corners of a triangle around `centre` whose normal is `normal`, as
/// single precision leaves them.
fn corners(centre: DVec3, normal: DVec3) -> [DVec3; 3] {
    let u = normal.any_orthonormal_vector();
    let v = normal.cross(u);
    [0.0, 1.0, 2.0].map(|k: f64| {
        let (sine, cosine) = (k * TAU / 3.0).sin_cos();
        // Clockwise about the normal: left-handed, as POV-Ray's world.
        let corner = centre + (u * cosine - v * sine) * RADIUS;
        corner.as_vec3().as_dvec3()
    })
}

/// The cosine of the light to the normal of a triangle, that is small and has
/// its digits in its own coordinates.
fn cosine(light: &Light, placed: [DVec3; 3], own: [DVec3; 3]) -> f64 {
    let middle = placed.iter().sum::<DVec3>() / 3.0;
    let normal = (own[2] - own[0]).cross(own[1] - own[0]).normalize_or_zero();
    let cosine = towards(light, middle).map_or(1.0, |way| way.dot(normal));
    // A triangle that is none would not have been lit: nothing to divide by.
    if cosine > 0.5 { cosine } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Rgb;
    use proptest::prelude::*;

    fn lamp(position: DVec3) -> Light {
        Light {
            position,
            colour: Rgb([0.5; 3]),
            kind: LightKind::Point,
            fade: None,
        }
    }

    proptest! {
        #[test]
        fn receivers_face_the_light_and_stand_at_their_points(
            at in (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64),
            lamp_at in (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64),
            scale in -6.0..8.0_f64,
            footprint in -3.0..0.0_f64,
        ) {
            let scale = 10.0_f64.powf(scale);
            let position = DVec3::from(at) * scale;
            let light = lamp(DVec3::from(lamp_at) * scale + DVec3::Y * 2.0 * scale);
            let point = SurfacePoint { position, footprint: scale * 10.0_f64.powf(footprint) };
            let (level, cell) = cell_of(&point);
            let unit = 2.0_f64.powi(level);
            let centre = (DVec3::from_array(cell.map(|c| c as f64)) + 0.5) * side(level);
            let local = (position - centre) / unit;
            prop_assert!(local.abs().max_element() <= 0.5 * CELL);
            let own = corners(local, towards(&light, position).unwrap());
            let middle = own.iter().sum::<DVec3>() / 3.0;
            let off = (middle - local).length();
            prop_assert!(off < 2e-5, "{off}");
            if point.footprint >= 2.0_f64.powi(FINEST) {
                prop_assert!(unit <= point.footprint && point.footprint < 2.0 * unit);
            }
            let cosine = cosine(&light, own.map(|c| centre + c * unit), own);
            prop_assert!((0.999_99..=1.0 + 1e-12).contains(&cosine), "{cosine}");
        }
    }

    #[test]
    fn points_that_the_light_does_not_reach_have_no_ray() {
        let light = Light {
            kind: LightKind::Spot {
                towards: DVec3::ZERO,
                radius_deg: 10.0,
                falloff_deg: 20.0,
                tightness: 0.0,
            },
            ..lamp(DVec3::Y)
        };
        let points = [DVec3::X * 9.0, DVec3::ZERO, light.position, DVec3::NAN].map(|position| {
            SurfacePoint {
                position,
                footprint: 0.1,
            }
        });
        let receivers = Receivers::of(&light, &points, DVec3::ZERO);
        assert_eq!(receivers.rays.iter().map(|r| r.0).collect::<Vec<_>>(), [1]);
    }

    #[test]
    fn footprints_of_any_size_have_a_unit() {
        for footprint in [0.0, -1.0, f64::NAN, 1e-300, 1e300, f64::INFINITY] {
            let point = SurfacePoint {
                position: DVec3::ONE,
                footprint,
            };
            assert!((FINEST..=COARSEST).contains(&cell_of(&point).0));
        }
    }
}

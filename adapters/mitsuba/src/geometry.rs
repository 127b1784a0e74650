//! A model as a file of shape groups, and its instances.
//!
//! A group is written at the model's own size, and its instances scale it: small
//! triangles keep their normals however small the scene is written. Spheres
//! stand for themselves, outside of groups: Mitsuba's are exact for rays of
//! length 1 alone, which a scaled instance does not shoot.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use decor_api::TriangleMesh;
use glam::{DAffine3, DVec3};

use crate::look::Looks;
use crate::solid::{Model, Part, Shape, similarity};
use crate::tessellate::{frustum, moved};
use crate::units::{Placed, Units, drawn_to, farthest};
use crate::xml::{matrix, number, point};

/// Steps around a cone that is not cut: of a radius of 1, no point is more than
/// 5e-6 off.
pub(crate) const AROUND: u32 = 1024;

/// Control points of the curve in a torus. Where a cubic spline is nearest to
/// a circle, at so many points it is as good as single precision.
const CURVE: u32 = 64;

/// Is it part of the model's group? If not, every instance writes it anew.
fn is_grouped(part: &Part) -> bool {
    match part.shape {
        Shape::Sphere { .. } => false,
        Shape::Cylinder { .. } | Shape::Torus { .. } => similarity(&part.placement).is_some(),
        Shape::Box { .. } | Shape::Cone { .. } | Shape::Mesh(_) => true,
    }
}

/// The file of a model, by `number`, and those that it reads.
pub(crate) fn files(model: &Model, number: u32, looks: &mut Looks) -> Vec<(String, Vec<u8>)> {
    let mut read = Vec::new();
    let mut group = String::new();
    let mut alone = String::new();
    for (k, part) in model.parts.iter().enumerate() {
        let look = looks.number(&model.looks[part.look]);
        let name = format!("solid_{number}_{k}");
        if is_grouped(part) {
            group.push_str(&shape(part, look, &name, &mut read));
        } else if !matches!(part.shape, Shape::Sphere { .. }) {
            let at_home = Part {
                placement: DAffine3::IDENTITY,
                ..part.clone()
            };
            let inner = shape(&at_home, look, &name, &mut read);
            let _ = writeln!(
                alone,
                "<shape type=\"shapegroup\" id=\"{name}\">\n{inner}</shape>"
            );
        }
    }
    for half in &model.half_spaces {
        looks.number(&model.looks[half.look]);
    }
    let mut text = String::from("<scene version=\"3.0.0\">\n");
    if !group.is_empty() {
        let _ = writeln!(
            text,
            "<shape type=\"shapegroup\" id=\"solid_{number}\">\n{group}</shape>"
        );
    }
    text.push_str(&alone);
    text.push_str("</scene>\n");
    let mut files = vec![(file_name(number), text.into_bytes())];
    files.append(&mut read);
    files
}

/// How the file of a model is called.
pub(crate) fn file_name(number: u32) -> String {
    format!("solid_{number}.xml")
}

/// One shape of a group; what it reads is added to `read`, called after `name`.
fn shape(part: &Part, look: usize, name: &str, read: &mut Vec<(String, Vec<u8>)>) -> String {
    let placement = &part.placement;
    let reference = format!("<ref id=\"look{look}\"/>");
    let mut mesh = |mesh: TriangleMesh| {
        let file = format!("{name}.ply");
        let text = format!(
            "<shape type=\"ply\"><string name=\"filename\" value=\"{file}\"/>\
             <boolean name=\"face_normals\" value=\"true\"/>{reference}</shape>\n"
        );
        read.push((file, ply(&mesh)));
        text
    };
    match &part.shape {
        Shape::Sphere { centre, radius } => {
            format!(
                "<shape type=\"sphere\">{}<float name=\"radius\" value=\"{}\"/>{reference}</shape>\n",
                point("center", *centre),
                number(*radius)
            )
        }
        Shape::Box { min, max } => {
            // Mitsuba's cube reaches from −1 to 1.
            let half = (*max - *min) * 0.5;
            let placed =
                *placement * DAffine3::from_translation(*min + half) * DAffine3::from_scale(half);
            format!(
                "<shape type=\"cube\"><transform name=\"to_world\">{}</transform>{reference}</shape>\n",
                placed_by(&placed)
            )
        }
        Shape::Cylinder { base, cap, radius } => {
            let at = |p: DVec3| placement.transform_point3(p);
            let radius = radius * similarity(placement).unwrap_or(1.0);
            let (base, cap) = (at(*base), at(*cap));
            let mut text = format!(
                "<shape type=\"cylinder\">{}{}<float name=\"radius\" value=\"{}\"/>{reference}</shape>\n",
                point("p0", base),
                point("p1", cap),
                number(radius)
            );
            if let Some(axis) = (cap - base).try_normalize() {
                for (end, out) in [(base, -axis), (cap, axis)] {
                    let (u, v) = out.any_orthonormal_pair();
                    let _ = writeln!(
                        text,
                        "<shape type=\"disk\"><transform name=\"to_world\">{}</transform>{reference}</shape>",
                        matrix([u * radius, v * radius, out], end)
                    );
                }
            }
            text
        }
        Shape::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => mesh(moved(
            frustum(*base, *base_radius, *cap, *cap_radius, AROUND),
            *placement,
        )),
        Shape::Torus { major, minor } => {
            let file = format!("{name}.txt");
            read.push((file.clone(), ring(*major, *minor, placement)));
            format!(
                "<shape type=\"bsplinecurve\"><string name=\"filename\" value=\"{file}\"/>{reference}</shape>\n"
            )
        }
        Shape::Mesh(triangles) => mesh(moved(TriangleMesh::clone(triangles), *placement)),
    }
}

/// The control points of a closed curve: position and radius, line by line.
fn ring(major: f64, minor: f64, placement: &DAffine3) -> Vec<u8> {
    let step = TAU / f64::from(CURVE);
    // A spline's knot is a sixth of the points beside it and two thirds of its
    // own: so the knots lie on the circle.
    let out = major * 3.0 / (2.0 + step.cos());
    let radius = minor * similarity(placement).unwrap_or(1.0);
    let mut text = String::new();
    // The first three points again close it.
    for k in 0..CURVE + 3 {
        let (sin, cos) = (step * f64::from(k % CURVE)).sin_cos();
        let p = placement.transform_point3(DVec3::new(out * cos, 0.0, out * sin));
        let [x, y, z] = p.to_array().map(number);
        let _ = writeln!(text, "{x} {y} {z} {}", number(radius));
    }
    text.into_bytes()
}

fn ply(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for vertex in &mesh.vertices {
        for coordinate in vertex.to_array() {
            bytes.extend((coordinate as f32).to_le_bytes());
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        for corner in triangle {
            bytes.extend(corner.to_le_bytes());
        }
    }
    bytes
}

fn placed_by(by: &DAffine3) -> String {
    let m = by.matrix3;
    matrix([m.x_axis, m.y_axis, m.z_axis], by.translation)
}

/// All instances of a scene: its file of shapes.
pub(crate) fn shapes(placed: &[Placed<'_>], units: Units, looks: &mut Looks) -> String {
    let mut text = String::from("<scene version=\"3.0.0\">\n");
    let mut numbers: Vec<u32> = placed.iter().map(|p| p.number).collect();
    numbers.sort_unstable();
    numbers.dedup();
    for &number in &numbers {
        let _ = writeln!(text, "<include filename=\"{}\"/>", file_name(number));
    }
    let reach = farthest(placed);
    let mut uneven: Vec<String> = Vec::new();
    for object in placed {
        instance(&mut text, object, units, reach, looks, &mut uneven);
    }
    text.push_str("</scene>\n");
    text
}

fn instance(
    text: &mut String,
    object: &Placed<'_>,
    units: Units,
    reach: f64,
    looks: &mut Looks,
    uneven: &mut Vec<String>,
) {
    let Placed {
        model,
        number: solid,
        from_eye,
        ..
    } = object;
    if model.parts.iter().any(is_grouped) {
        let _ = writeln!(
            text,
            "{}",
            placed_group(&format!("solid_{solid}"), from_eye, units.scale)
        );
    }
    for (k, part) in model.parts.iter().enumerate() {
        if is_grouped(part) {
            continue;
        }
        let whole = *from_eye * part.placement;
        let Shape::Sphere { centre, radius } = part.shape else {
            let group = format!("solid_{solid}_{k}");
            let _ = writeln!(text, "{}", placed_group(&group, &whole, units.scale));
            continue;
        };
        let look = looks.number(&model.looks[part.look]);
        let centre = whole.transform_point3(centre) * units.scale;
        let sphere = |centre, radius: f64| Part {
            shape: Shape::Sphere { centre, radius },
            placement: DAffine3::IDENTITY,
            look,
        };
        let mut none = Vec::new();
        if let Some(scale) = similarity(&whole) {
            let part = sphere(centre, radius * scale * units.scale);
            text.push_str(&shape(&part, look, "", &mut none));
        } else {
            // The instance only stretches; the size is the sphere's own.
            let size = whole.matrix3.determinant().abs().cbrt();
            let group = format!("ball_{solid}_{k}");
            if !uneven.contains(&group) {
                let part = sphere(DVec3::ZERO, radius * size * units.scale);
                let inner = shape(&part, look, "", &mut none);
                let _ = writeln!(
                    text,
                    "<shape type=\"shapegroup\" id=\"{group}\">{inner}</shape>"
                );
                uneven.push(group.clone());
            }
            let stretched = DAffine3 {
                matrix3: whole.matrix3 * size.recip(),
                translation: centre,
            };
            let _ = writeln!(text, "{}", placed_group(&group, &stretched, 1.0));
        }
    }
    for half in &model.half_spaces {
        let look = looks.number(&model.looks[half.look]);
        let (normal, height) = half.seen_by(from_eye);
        let (u, v) = normal.any_orthonormal_pair();
        let far = drawn_to(height.abs(), reach) * units.scale;
        let _ = writeln!(
            text,
            "<shape type=\"disk\"><transform name=\"to_world\">{}</transform><ref id=\"look{look}\"/></shape>",
            matrix([u * far, v * far, normal], normal * (height * units.scale))
        );
    }
}

fn placed_group(group: &str, by: &DAffine3, scale: f64) -> String {
    format!(
        "<shape type=\"instance\"><ref id=\"{group}\"/><transform name=\"to_world\">{}\
         <scale value=\"{}\"/></transform></shape>",
        placed_by(by),
        number(scale)
    )
}

//! Neutral solids and materials in POV-Ray's words.

use std::fmt::Write as _;

use decor_api::{Csg, Highlight, Material, TriangleMesh};
use glam::DVec3;

use crate::number::{number, push_single, vector};

/// Are the materials written, or left to whoever places the object?
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Looks {
    /// Every look is written.
    Written,
    /// None is: the object takes the texture of where it is placed.
    LeftOut,
}

/// An object statement for `solid`. What has no look of its own gets the
/// default one, where looks are written.
pub fn solid(solid: &Csg, looks: Looks) -> String {
    let mut text = String::new();
    let look = match looks {
        Looks::Written => texture(&Material::default()),
        Looks::LeftOut => String::new(),
    };
    push(&mut text, solid, looks, &look);
    text
}

/// Appends the statement of `node`, with `modifiers` before its closing brace.
/// A texture there is taken by every part that has none of its own.
fn push(text: &mut String, node: &Csg, looks: Looks, modifiers: &str) {
    // Writing to a string cannot fail.
    let _ = match node {
        Csg::Sphere { centre, radius } => {
            write!(text, "sphere {{ {}, {}", vector(*centre), number(*radius))
        }
        Csg::Box { min, max } => write!(text, "box {{ {}, {}", vector(*min), vector(*max)),
        Csg::Cylinder { base, cap, radius } => write!(
            text,
            "cylinder {{ {}, {}, {}",
            vector(*base),
            vector(*cap),
            number(*radius)
        ),
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => write!(
            text,
            "cone {{ {}, {}, {}, {}",
            vector(*base),
            number(*base_radius),
            vector(*cap),
            number(*cap_radius)
        ),
        Csg::Torus { major, minor } => {
            write!(text, "torus {{ {}, {}", number(*major), number(*minor))
        }
        Csg::Plane { normal, distance } => {
            write!(text, "plane {{ {}, {}", vector(*normal), number(*distance))
        }
        Csg::Mesh(mesh) => {
            push_mesh(text, mesh);
            Ok(())
        }
        Csg::Union(nodes) => {
            push_all(text, "union", nodes.iter(), looks);
            Ok(())
        }
        Csg::Intersection(nodes) => {
            push_all(text, "intersection", nodes.iter(), looks);
            Ok(())
        }
        Csg::Difference(first, rest) => {
            push_all(
                text,
                "difference",
                std::iter::once(&**first).chain(rest),
                looks,
            );
            Ok(())
        }
        Csg::Translate(by, inner) => {
            push_placed(text, inner, looks);
            write!(text, " translate {}", vector(*by))
        }
        Csg::Rotate(by, inner) => {
            push_placed(text, inner, looks);
            write!(text, " rotate {}", vector(*by))
        }
        Csg::Scale(by, inner) => {
            push_placed(text, inner, looks);
            write!(text, " scale {}", vector(*by))
        }
        Csg::Look(material, inner) => {
            let own = match looks {
                Looks::Written => texture(material),
                Looks::LeftOut => modifiers.to_owned(),
            };
            return push(text, inner, looks, &own);
        }
    };
    if !modifiers.is_empty() {
        text.push(' ');
        text.push_str(modifiers);
    }
    text.push_str(" }");
}

fn push_placed(text: &mut String, inner: &Csg, looks: Looks) {
    text.push_str("object { ");
    push(text, inner, looks, "");
}

fn push_all<'a>(text: &mut String, word: &str, nodes: impl Iterator<Item = &'a Csg>, looks: Looks) {
    text.push_str(word);
    text.push_str(" {");
    for node in nodes {
        text.push_str("\n  ");
        push(text, node, looks, "");
    }
}

fn push_mesh(text: &mut String, mesh: &TriangleMesh) {
    let _ = write!(text, "mesh2 {{ vertex_vectors {{ {}", mesh.vertices.len());
    for &vertex in &mesh.vertices {
        text.push_str(",\n");
        push_single(text, vertex);
    }
    let _ = write!(text, " }} face_indices {{ {}", mesh.triangles.len());
    for [a, b, c] in &mesh.triangles {
        let _ = write!(text, ",\n<{a},{b},{c}>");
    }
    text.push_str(" }");
}

/// A texture, and the interior that goes with it.
fn texture(material: &Material) -> String {
    let Material {
        colour: c,
        ambient,
        diffuse,
        highlight,
        reflection,
        transmission,
        ior,
    } = material;
    let [red, green, blue] = c.0.map(number);
    let mut text = format!(
        "texture {{ pigment {{ rgbf <{red},{green},{blue},{}> }} finish {{ ambient {} diffuse {}",
        number(*transmission),
        number(*ambient),
        number(*diffuse),
    );
    let _ = match highlight {
        Highlight::None => Ok(()),
        Highlight::Phong { amount, size } => {
            write!(
                text,
                " phong {} phong_size {}",
                number(*amount),
                number(*size)
            )
        }
        Highlight::Specular { amount, roughness } => {
            write!(
                text,
                " specular {} roughness {}",
                number(*amount),
                number(*roughness)
            )
        }
    };
    if *reflection > 0.0 {
        let _ = write!(text, " reflection {{ {} }}", number(*reflection));
    }
    text.push_str(" } }");
    if *ior != 1.0 {
        let _ = write!(text, " interior {{ ior {} }}", number(*ior));
    }
    text
}

/// The statement that places a declared object. A rotation by nothing is not
/// written.
pub fn placed(name: &str, pose: &decor_api::Pose, modifiers: &str) -> String {
    let mut text = format!("object {{ {name}");
    if pose.angles_deg != DVec3::ZERO {
        let _ = write!(text, " rotate {}", vector(pose.angles_deg));
    }
    if pose.position != DVec3::ZERO {
        let _ = write!(text, " translate {}", vector(pose.position));
    }
    if !modifiers.is_empty() {
        text.push(' ');
        text.push_str(modifiers);
    }
    text.push_str(" }\n");
    text
}

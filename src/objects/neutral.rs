//! The neutral description of an object: a CSG tree in a `.ron` file, that
//! every adapter draws.
//!
//! ```ron
//! // A snowman: comments are welcome.
//! union([
//!     material(
//!         (colour: (0.9, 0.9, 1.0), phong: (amount: 0.3, size: 60)),
//!         union([
//!             sphere(radius: 1),
//!             translate((0, 1.5, 0), scale(0.7, sphere(radius: 1))),
//!         ]),
//!     ),
//!     material(
//!         (colour: (1, 0.4, 0)),
//!         cone(base: (0, 1.5, -0.6), base_radius: 0.1, cap: (0, 1.5, -1.2)),
//!     ),
//!     difference(
//!         box(min: (-0.5, 2.1, -0.5), max: (0.5, 2.6, 0.5)),
//!         [cylinder(base: (0, 2, 0), cap: (0, 2.4, 0), radius: 0.4)],
//!     ),
//! ])
//! ```
//!
//! | node | means |
//! |---|---|
//! | `sphere(centre: (x, y, z), radius: r)` | a ball; `centre` may be left out |
//! | `box(min: (x, y, z), max: (x, y, z))` | along the axes; `min` below `max` |
//! | `cylinder(base: (x, y, z), cap: (x, y, z), radius: r)` | solid, with both ends closed; `base` may be left out |
//! | `cone(base: …, base_radius: r, cap: …, cap_radius: r)` | solid; a radius that is left out is 0 |
//! | `torus(major: R, minor: r)` | around the y axis, in y = 0; r ≤ R |
//! | `plane(normal: (x, y, z), distance: d)` | the half-space below; `distance` may be left out |
//! | `mesh("file.ply")` | a mesh file beside the description ([`mesh_file`]) |
//! | `union([…])`, `intersection([…])` | of at least one node |
//! | `difference(node, […])` | the first without the others |
//! | `translate((x, y, z), node)` | moved |
//! | `rotate((a, b, c), node)` | turned about x, then y, then z, in degrees, left-handed |
//! | `scale((x, y, z), node)`, `scale(s, node)` | no factor is 0 |
//! | `material((…), node)` | the look of everything below that has none of its own |
//!
//! A material has `colour: (r, g, b)` (linear), `ambient`, `diffuse`,
//! `phong: (amount: a, size: s)` or `specular: (amount: a, roughness: r)`,
//! `reflection`, `transmission` and `ior`; what is left out is
//! [`Material::default`](decor_api::Material). Coordinates are a film's:
//! left-handed, y up, z into the picture.
//!
//! Unknown names are refused. Every number is finite, radii are above 0, and
//! nodes stand in each other about 100 deep at most.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use decor_api::{Csg, TriangleMesh};
use ron::Options;
use ron::extensions::Extensions;
use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer};

use super::error::{ObjectProblem, TextError, with_causes};
use super::files::Files;
use super::mesh_file;
use super::neutral_values::{Direction, Factors, Finite, Look, NotNegative, Point, Positive};

/// How deep the reader may call itself: what keeps a hostile nesting from
/// overflowing the stack, here and wherever the tree is walked. A node takes up
/// to four calls.
const RECURSION: usize = 400;

/// Reads the description `bytes` of the file `path`, and the meshes that it
/// names.
///
/// # Errors
/// The first error of the text, or one for every mesh that cannot be used.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    files: &mut Files,
) -> Result<Csg, Vec<ObjectProblem>> {
    let node = parse(path, bytes).map_err(|e| vec![e.into()])?;
    let text = String::from_utf8_lossy(bytes);
    let mut problems = Vec::new();
    let mut meshes: HashMap<String, Arc<TriangleMesh>> = HashMap::new();
    let csg = node.into_csg(&mut |named| {
        if let Some(mesh) = meshes.get(named) {
            return mesh.clone();
        }
        let read = mesh_file::read_beside(path, named, files);
        let mesh = Arc::new(read.unwrap_or_else(|error| {
            // The mesh has no place of its own in the tree, but its name has.
            let start = text.find(&format!("\"{named}\"")).unwrap_or(0);
            let reason = with_causes(&error);
            let at = TextError::at(path, &text, start, start + named.len() + 2, reason);
            problems.push(at.into());
            TriangleMesh::default()
        }));
        meshes.insert(named.to_owned(), mesh.clone());
        mesh
    });
    if problems.is_empty() {
        Ok(csg)
    } else {
        Err(problems)
    }
}

/// Reads a description without its meshes: only whether it is well-formed.
///
/// # Errors
/// The place of the first error, and what was expected.
pub fn check(path: &Path, bytes: &[u8]) -> Result<(), Box<TextError>> {
    parse(path, bytes).map(|_| ())
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Node, Box<TextError>> {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.strip_prefix('\u{feff}').unwrap_or(text),
        Err(error) => {
            let at = error.valid_up_to();
            let text = String::from_utf8_lossy(bytes);
            let reason = "expected UTF-8".to_owned();
            return Err(TextError::at(path, &text, at, at + 1, reason));
        }
    };
    let options = Options::default()
        .with_recursion_limit(RECURSION)
        .with_default_extension(Extensions::IMPLICIT_SOME)
        .with_default_extension(Extensions::UNWRAP_NEWTYPES)
        .with_default_extension(Extensions::UNWRAP_VARIANT_NEWTYPES);
    options.from_str(text).map_err(|error| {
        let start = offset(text, error.span.start.line, error.span.start.col);
        let end = offset(text, error.span.end.line, error.span.end.col);
        let reason = match error.code {
            ron::Error::ExceededRecursionLimit => "nodes stand in each other too deeply".to_owned(),
            other => other.to_string(),
        };
        TextError::at(path, text, start, end, reason)
    })
}

/// The byte at a line and a column, both counted from 1.
fn offset(text: &str, line: usize, column: usize) -> usize {
    let mut starts = std::iter::once(0).chain(text.match_indices('\n').map(|(i, _)| i + 1));
    let start = starts.nth(line.saturating_sub(1)).unwrap_or(text.len());
    let rest = &text[start..];
    let within = rest.char_indices().nth(column.saturating_sub(1));
    start + within.map_or(rest.len(), |(i, _)| i)
}

/// A node as it is written.
#[derive(Debug, Deserialize)]
#[serde(rename = "node", rename_all = "snake_case", deny_unknown_fields)]
enum Node {
    Sphere {
        #[serde(default, alias = "center")]
        centre: Point,
        radius: Positive,
    },
    Box(Sound<Cuboid>),
    Cylinder(Sound<Cylinder>),
    Cone(Sound<Cone>),
    Torus(Sound<Torus>),
    Plane {
        normal: Direction,
        #[serde(default)]
        distance: Finite,
    },
    Mesh(String),
    Union(Nodes),
    Intersection(Nodes),
    Difference(Box<Node>, Nodes),
    Translate(Point, Box<Node>),
    Rotate(Point, Box<Node>),
    Scale(Factors, Box<Node>),
    Material(Look, Box<Node>),
}

/// At least one node.
#[derive(Debug, Deserialize)]
#[serde(try_from = "Vec<Node>")]
struct Nodes(Vec<Node>);

impl TryFrom<Vec<Node>> for Nodes {
    type Error = &'static str;

    fn try_from(nodes: Vec<Node>) -> Result<Self, Self::Error> {
        if nodes.is_empty() {
            return Err("expected at least one node");
        }
        Ok(Self(nodes))
    }
}

/// A shape whose fields depend on each other.
trait Shape: DeserializeOwned {
    const EXPECTED: &'static str;

    fn is_sound(&self) -> bool;
}

/// A shape that was looked at.
#[derive(Debug)]
struct Sound<T>(T);

impl<'de, T: Shape> Deserialize<'de> for Sound<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let shape = T::deserialize(deserializer)?;
        if shape.is_sound() {
            Ok(Self(shape))
        } else {
            Err(D::Error::custom(format_args!("expected {}", T::EXPECTED)))
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cuboid {
    min: Point,
    max: Point,
}

impl Shape for Cuboid {
    const EXPECTED: &'static str = "a box whose min is below its max in x, y and z";

    fn is_sound(&self) -> bool {
        self.min.0.cmplt(self.max.0).all()
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cylinder {
    #[serde(default)]
    base: Point,
    cap: Point,
    radius: Positive,
}

impl Shape for Cylinder {
    const EXPECTED: &'static str = "a cylinder whose base and cap are apart";

    fn is_sound(&self) -> bool {
        self.base != self.cap
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cone {
    #[serde(default)]
    base: Point,
    #[serde(default)]
    base_radius: NotNegative,
    cap: Point,
    #[serde(default)]
    cap_radius: NotNegative,
}

impl Shape for Cone {
    const EXPECTED: &'static str =
        "a cone whose base and cap are apart, and one of whose radii is above 0";

    fn is_sound(&self) -> bool {
        self.base != self.cap && self.base_radius.0.max(self.cap_radius.0) > 0.0
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Torus {
    major: Positive,
    minor: Positive,
}

impl Shape for Torus {
    const EXPECTED: &'static str = "a torus whose minor radius is not above its major radius";

    fn is_sound(&self) -> bool {
        self.minor.0 <= self.major.0
    }
}

impl Node {
    fn into_csg(self, mesh: &mut impl FnMut(&str) -> Arc<TriangleMesh>) -> Csg {
        let all = |Nodes(nodes): Nodes, mesh: &mut _| {
            nodes.into_iter().map(|n| n.into_csg(mesh)).collect()
        };
        match self {
            Self::Sphere { centre, radius } => Csg::Sphere {
                centre: centre.0,
                radius: radius.0,
            },
            Self::Box(Sound(shape)) => Csg::Box {
                min: shape.min.0,
                max: shape.max.0,
            },
            Self::Cylinder(Sound(shape)) => Csg::Cylinder {
                base: shape.base.0,
                cap: shape.cap.0,
                radius: shape.radius.0,
            },
            Self::Cone(Sound(shape)) => Csg::Cone {
                base: shape.base.0,
                base_radius: shape.base_radius.0,
                cap: shape.cap.0,
                cap_radius: shape.cap_radius.0,
            },
            Self::Torus(Sound(shape)) => Csg::Torus {
                major: shape.major.0,
                minor: shape.minor.0,
            },
            Self::Plane { normal, distance } => Csg::Plane {
                normal: normal.0,
                distance: distance.0,
            },
            Self::Mesh(path) => Csg::Mesh(mesh(&path)),
            Self::Union(nodes) => Csg::Union(all(nodes, mesh)),
            Self::Intersection(nodes) => Csg::Intersection(all(nodes, mesh)),
            Self::Difference(first, rest) => {
                let first = Box::new(first.into_csg(mesh));
                Csg::Difference(first, all(rest, mesh))
            }
            Self::Translate(by, node) => Csg::Translate(by.0, Box::new(node.into_csg(mesh))),
            Self::Rotate(angles, node) => Csg::Rotate(angles.0, Box::new(node.into_csg(mesh))),
            Self::Scale(factors, node) => Csg::Scale(factors.0, Box::new(node.into_csg(mesh))),
            Self::Material(look, node) => Csg::Look(look.0, Box::new(node.into_csg(mesh))),
        }
    }
}

#[cfg(test)]
mod tests;

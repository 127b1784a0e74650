//! Triangle meshes from files.
//!
//! | ending | coordinates |
//! |---|---|
//! | `.obj`, `.ply`, `.stl` | taken as they stand: x, y, z are a film's x, y, z |
//! | `.gltf`, `.glb` | glTF is right-handed with z towards the viewer: z is mirrored (and the triangles' order with it). Node transforms are applied |
//!
//! Only the geometry is read. Materials, colours, normals and textures of the
//! file are left: the object has one uniform
//! [`Material::default`](decor_api::Material), unless a `.ron` description
//! gives it another. Polygons become fans of triangles around their first
//! vertex; triangles without an area are dropped; lines and points alone are
//! an error, as is a file without any triangle.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use decor_api::TriangleMesh;
use glam::DVec3;

use super::files::{FileError, Files};

mod gltf;
mod obj;
mod ply;
mod stl;

/// The endings of mesh files.
pub const ENDINGS: [&str; 5] = ["obj", "ply", "stl", "gltf", "glb"];

/// Why a file does not hold a mesh.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file, or one that it names, cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is not of its format.
    #[error("{}{reason}", line.map_or(String::new(), |l| format!("line {l}: ")))]
    Format {
        /// The line, counted from 1, where there are lines.
        line: Option<usize>,
        /// What is wrong.
        reason: String,
    },
    /// A triangle names a vertex that is not there.
    #[error("a face names vertex {index} of {vertices} (counted from 0)")]
    NoSuchVertex {
        /// The vertex that it names.
        index: u64,
        /// How many there are.
        vertices: usize,
    },
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} (counted from 0) is not finite")]
    NotFinite {
        /// Which vertex.
        vertex: usize,
    },
    /// There is no triangle with an area.
    #[error("there is no triangle with an area (lines and points are not drawn)")]
    Empty,
    /// The file asks for something that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// The ending is not one of a mesh file.
    #[error("meshes end in {}", ENDINGS.join(", "))]
    Ending,
}

impl MeshError {
    fn format(reason: impl std::fmt::Display) -> Self {
        Self::Format {
            line: None,
            reason: reason.to_string(),
        }
    }
}

/// Reads the mesh in `bytes`, that were read from `path`.
///
/// # Errors
/// Any [`MeshError`]; hostile bytes are one too, never a panic.
pub(super) fn read(
    path: &Path,
    bytes: &[u8],
    files: &mut Files,
) -> Result<TriangleMesh, MeshError> {
    parse(&ending(path), bytes, |named| {
        let path = files.beside(path, named)?;
        files.read(&path)
    })
}

/// Reads a mesh that the description at `from` names.
///
/// # Errors
/// Any [`MeshError`].
pub(super) fn read_beside(
    from: &Path,
    named: &str,
    files: &mut Files,
) -> Result<TriangleMesh, MeshError> {
    let path = files.beside(from, named)?;
    if !ENDINGS.contains(&&*ending(&path)) {
        return Err(MeshError::Ending);
    }
    let bytes = files.read(&path)?;
    read(&path, &bytes, files)
}

fn ending(path: &Path) -> String {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    ending.to_string_lossy().into_owned()
}

/// Reads a mesh out of the bytes of a file with this ending. `other` gives the
/// bytes of a file that it names (the buffers of a `.gltf`).
///
/// # Errors
/// Any [`MeshError`]; hostile bytes are one too, never a panic.
pub fn parse(
    ending: &str,
    bytes: &[u8],
    mut other: impl FnMut(&str) -> Result<Vec<u8>, FileError>,
) -> Result<TriangleMesh, MeshError> {
    let soup = match ending {
        "obj" => guarded(|| obj::parse(bytes)),
        "ply" => guarded(|| ply::parse(bytes)),
        "stl" => guarded(|| stl::parse(bytes)),
        "gltf" | "glb" => guarded(|| gltf::parse(bytes, &mut other)),
        _ => Err(MeshError::Ending),
    }?;
    soup.finish()
}

/// The readers are other people's: what was found to make them panic is
/// refused before they see it, and this is for what was not found.
fn guarded<T>(read: impl FnOnce() -> Result<T, MeshError>) -> Result<T, MeshError> {
    catch_unwind(AssertUnwindSafe(read)).unwrap_or_else(|panic| {
        let why = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("unknown");
        Err(MeshError::format(format_args!(
            "the file is damaged ({why})"
        )))
    })
}

/// Vertices and faces as a file gives them, not yet checked.
#[derive(Debug, Default)]
struct Soup {
    vertices: Vec<DVec3>,
    triangles: Vec<[u64; 3]>,
}

impl Soup {
    /// A fan around the polygon's first vertex. Two vertices and fewer are no
    /// polygon.
    fn push_polygon(&mut self, mut indices: impl Iterator<Item = u64>) {
        let (Some(first), Some(mut previous)) = (indices.next(), indices.next()) else {
            return;
        };
        for next in indices {
            self.triangles.push([first, previous, next]);
            previous = next;
        }
    }

    /// Checks everything, and keeps what has an area and the vertices that it
    /// needs, in their order.
    fn finish(self) -> Result<TriangleMesh, MeshError> {
        if let Some(vertex) = self.vertices.iter().position(|v| !v.is_finite()) {
            return Err(MeshError::NotFinite { vertex });
        }
        let count = self.vertices.len();
        if u32::try_from(count).is_err() {
            let reason = "more vertices than 32 bits can number".to_owned();
            return Err(MeshError::Unsupported(reason));
        }
        let mut triangles = Vec::with_capacity(self.triangles.len());
        for triangle in self.triangles {
            if let Some(&index) = triangle.iter().find(|&&i| i >= count as u64) {
                return Err(MeshError::NoSuchVertex {
                    index,
                    vertices: count,
                });
            }
            let corners = triangle.map(|i| self.vertices[i as usize]);
            if has_area(corners) {
                triangles.push(triangle.map(|i| i as u32));
            }
        }
        if triangles.is_empty() {
            return Err(MeshError::Empty);
        }

        let mut number = vec![u32::MAX; count];
        for &i in triangles.iter().flatten() {
            number[i as usize] = 0;
        }
        let mut vertices = Vec::new();
        for (vertex, number) in self.vertices.iter().zip(&mut number) {
            if *number == 0 {
                *number = vertices.len() as u32;
                vertices.push(*vertex);
            }
        }
        for i in triangles.iter_mut().flatten() {
            *i = number[*i as usize];
        }
        Ok(TriangleMesh {
            vertices,
            triangles,
        })
    }
}

fn has_area([a, b, c]: [DVec3; 3]) -> bool {
    let (u, v) = (b - a, c - a);
    let size = u.abs().max(v.abs()).max_element();
    // In units of its own size: squares of tiny lengths would be 0.
    size > 0.0 && (u / size).cross(v / size) != DVec3::ZERO
}

#[cfg(test)]
mod tests;

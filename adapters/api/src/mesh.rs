//! Triangle meshes, as they come out of a file.

use glam::DVec3;

/// Triangles over shared vertices. Every index is below `vertices.len()`; every
/// coordinate is finite.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// Positions, in the object's units.
    pub vertices: Vec<DVec3>,
    /// Three vertices each, by number.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// The corners of every triangle.
    pub fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        self.triangles
            .iter()
            .map(|t| t.map(|i| self.vertices[i as usize]))
    }
}

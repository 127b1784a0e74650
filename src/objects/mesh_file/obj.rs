//! Wavefront OBJ. Positions, faces, relative indices; groups and objects are
//! put together.
//!
//! The reader is given positions and faces only. What it makes of texture
//! coordinates, normals and colours would be thrown away, and where they are
//! wrong it refuses the file, or overflows.

use std::fmt::Write;

use std::io::{self, BufRead, Read};

use glam::DVec3;
use tobj::{LoadError, LoadOptions};

use super::{MeshError, Soup};

pub(super) fn parse(bytes: &[u8]) -> Result<Soup, MeshError> {
    // Old files have comments and names in other encodings.
    let text = geometry_alone(&String::from_utf8_lossy(bytes));
    let mut lines = Lines {
        rest: text.as_bytes(),
        read: 0,
    };
    let options = LoadOptions {
        triangulate: true,
        ignore_points: true,
        ignore_lines: true,
        ..LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| Err(LoadError::OpenFileFailed);
    let loaded = tobj::load_obj_buf(&mut lines, &options, no_materials);
    let (models, _) = loaded.map_err(|error| MeshError::Format {
        // Indices are looked at when all lines are read: too late for a line.
        line: (error != LoadError::FaceVertexOutOfBounds).then_some(lines.read),
        reason: error.to_string(),
    })?;

    let mut soup = Soup::default();
    for model in models {
        let first = soup.vertices.len() as u64;
        let (positions, _) = model.mesh.positions.as_chunks::<3>();
        soup.vertices
            .extend(positions.iter().copied().map(DVec3::from_array));
        let (triangles, _) = model.mesh.indices.as_chunks::<3>();
        soup.triangles
            .extend(triangles.iter().map(|t| t.map(|i| first + u64::from(i))));
    }
    Ok(soup)
}

/// Positions and faces, each in its own line; the other lines are empty.
fn geometry_alone(text: &str) -> String {
    let mut alone = String::with_capacity(text.len());
    // A line that ends in a backslash goes on in the next one.
    let mut begun = String::new();
    for line in text.lines() {
        if let Some(part) = line.trim_end().strip_suffix('\\') {
            begun.push_str(part);
            begun.push(' ');
            alone.push('\n');
            continue;
        }
        begun.push_str(line);
        push_geometry(&mut alone, &begun);
        alone.push('\n');
        begun.clear();
    }
    push_geometry(&mut alone, &begun);
    alone
}

fn push_geometry(alone: &mut String, line: &str) {
    let line = line.split('#').next().unwrap_or_default();
    let mut words = line.split_whitespace();
    match words.next() {
        Some("v") => {
            let numbers: Vec<&str> = words.collect();
            // Three coordinates and a weight; but three and more are a colour.
            let used = if numbers.len() == 4 {
                4
            } else {
                3.min(numbers.len())
            };
            let _ = write!(alone, "v {}", numbers[..used].join(" "));
        }
        Some("f") => {
            alone.push('f');
            for corner in words {
                let position = corner.split('/').next().unwrap_or_default();
                let _ = write!(alone, " {position}");
            }
        }
        _ => {}
    }
}

/// Counts the lines that were read, for the messages.
struct Lines<'a> {
    rest: &'a [u8],
    read: usize,
}

impl Read for Lines<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let n = self.rest.len().min(buffer.len());
        buffer[..n].copy_from_slice(&self.rest[..n]);
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(self.rest)
    }

    fn consume(&mut self, n: usize) {
        let (taken, rest) = self.rest.split_at(n);
        self.read += taken.iter().filter(|&&b| b == b'\n').count();
        // The last line may have no end.
        if rest.is_empty() && taken.last().is_some_and(|&b| b != b'\n') {
            self.read += 1;
        }
        self.rest = rest;
    }
}

//! STL, as text and as binary.
//!
//! A binary file may begin with `solid` too: it is told from text by its length.
//! Equal corners become one vertex.

use std::io::Cursor;

use glam::DVec3;

use super::{MeshError, Soup};

/// Title and number of triangles; then 50 bytes a triangle.
const HEADER: usize = 84;
const TITLE: usize = 80;

pub(super) fn parse(bytes: &[u8]) -> Result<Soup, MeshError> {
    let triangles = bytes.get(TITLE..HEADER).map(|count| {
        let count = count.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b));
        HEADER as u64 + 50 * count
    });
    let is_binary = triangles == Some(bytes.len() as u64);
    let begins_as_text = bytes.trim_ascii_start().get(..5);
    let is_text = begins_as_text.is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    let plain = if is_text && !is_binary {
        plain_text(bytes)?
    } else {
        // The reader would take a title of `solid` for text.
        let mut plain = bytes.to_vec();
        let title = plain.len().min(TITLE);
        plain[..title].fill(b' ');
        plain
    };
    let mesh = stl_io::read_stl(&mut Cursor::new(plain)).map_err(MeshError::format)?;
    Ok(Soup {
        vertices: mesh
            .vertices
            .iter()
            .map(|v| DVec3::from_array(v.0.map(f64::from)))
            .collect(),
        triangles: mesh
            .faces
            .iter()
            .map(|face| face.vertices.map(|i| i as u64))
            .collect(),
    })
}

/// All solids of a text as one, in the spelling that the reader knows: in lower
/// case, and with a title.
fn plain_text(bytes: &[u8]) -> Result<Vec<u8>, MeshError> {
    let text = String::from_utf8_lossy(bytes).to_ascii_lowercase();
    let first_word = |line: &str| line.split_whitespace().next().map(str::to_owned);
    let is_frame = |line: &str| {
        let word = first_word(line);
        matches!(word.as_deref(), Some("solid" | "endsolid"))
    };
    if !text
        .lines()
        .any(|l| first_word(l).as_deref() == Some("endsolid"))
    {
        return Err(MeshError::format("the text ends before endsolid"));
    }
    let mut plain = "solid decor\n".to_owned();
    for line in text.lines().filter(|line| !is_frame(line)) {
        plain.push_str(line);
        plain.push('\n');
    }
    plain.push_str("endsolid\n");
    Ok(plain.into_bytes())
}

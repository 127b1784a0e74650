//! PLY, as text and as binary of both orders. `vertex` with x, y, z and `face`
//! with `vertex_indices` (or `vertex_index`); everything else is skipped.

use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{Property, PropertyAccess, PropertyAccessResult};

use super::{MeshError, Soup};

pub(super) fn parse(bytes: &[u8]) -> Result<Soup, MeshError> {
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new()
        .read_header(&mut reader)
        .map_err(wrong)?;
    let mut soup = Soup::default();
    let mut polygons = Vec::new();
    for (name, element) in &header.elements {
        // Each takes a byte at least. Elements without properties would take
        // none, and a header could claim 2⁶⁴ of them.
        if element.count > bytes.len() {
            return Err(MeshError::format(format_args!(
                "{} {name} elements do not fit into the file",
                element.count
            )));
        }
        match name.as_str() {
            "vertex" => {
                let has = |axis| element.properties.iter().any(|(name, _)| name == axis);
                if !["x", "y", "z"].into_iter().all(has) {
                    return Err(MeshError::format(
                        "expected x, y and z in the vertex element",
                    ));
                }
                let vertices = Parser::<Vertex>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(wrong)?;
                soup.vertices.extend(vertices.iter().map(|v| v.position));
            }
            "face" => {
                polygons = Parser::<Face>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(wrong)?;
            }
            _ => {
                Parser::<Skipped>::new()
                    .read_payload_for_element(&mut reader, element, &header)
                    .map_err(wrong)?;
            }
        }
    }
    for face in polygons {
        if let Some(&index) = face.indices.iter().find(|i| **i < 0) {
            return Err(MeshError::format(format_args!(
                "a face names vertex {index}"
            )));
        }
        soup.push_polygon(face.indices.iter().map(|&i| i as u64));
    }
    Ok(soup)
}

fn wrong(error: ParseError) -> MeshError {
    let line = error.line();
    // Several lines, with the same one told at every level.
    let text = error.to_string();
    let words: Vec<&str> = text.split_whitespace().collect();
    let text = words.join(" ");
    let reason = match line {
        Some(line) => text
            .trim_start_matches(&format!("Line {line}: "))
            .to_owned(),
        None => text,
    };
    MeshError::Format { line, reason }
}

struct Vertex {
    position: DVec3,
}

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self {
            position: DVec3::NAN,
        }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        let axis = match name {
            "x" => 0,
            "y" => 1,
            "z" => 2,
            _ => return PropertyAccessResult::Ignored,
        };
        self.position[axis] = match value {
            Property::Char(v) => v.into(),
            Property::UChar(v) => v.into(),
            Property::Short(v) => v.into(),
            Property::UShort(v) => v.into(),
            Property::Int(v) => v.into(),
            Property::UInt(v) => v.into(),
            Property::Float(v) => v.into(),
            Property::Double(v) => v,
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

struct Face {
    indices: Vec<i64>,
}

impl PropertyAccess for Face {
    fn new() -> Self {
        Self {
            indices: Vec::new(),
        }
    }

    fn set_property(&mut self, name: &str, value: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        fn wide<T: Into<i64>>(list: Vec<T>) -> Vec<i64> {
            list.into_iter().map(Into::into).collect()
        }
        self.indices = match value {
            Property::ListChar(list) => wide(list),
            Property::ListUChar(list) => wide(list),
            Property::ListShort(list) => wide(list),
            Property::ListUShort(list) => wide(list),
            Property::ListInt(list) => wide(list),
            Property::ListUInt(list) => wide(list),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}

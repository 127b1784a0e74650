//! glTF 2.0, as JSON with buffers beside it or in `data:` URIs, and as GLB.
//!
//! The default scene is read (the first one where none is the default, every
//! root node where there is no scene). Skins and morph targets that are at work
//! are refused: drawn without them, the object would be another one.

use base64::Engine;
use base64::engine::general_purpose::{STANDARD, STANDARD_NO_PAD};
use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use gltf::accessor::{Accessor, DataType, Dimensions};
use gltf::buffer::{Source, View};
use gltf::mesh::Mode;
use gltf::scene::Transform;
use gltf::{Document, Gltf, Node, Primitive};

use super::super::files::FileError;
use super::{MeshError, Soup};

/// Zeros that a sparse accessor may stand for.
const MOST_ZEROS: usize = 1 << 24;

pub(super) fn parse(
    bytes: &[u8],
    other: &mut dyn FnMut(&str) -> Result<Vec<u8>, FileError>,
) -> Result<Soup, MeshError> {
    check_glb_header(bytes)?;
    let unchecked = Gltf::from_slice_without_validation(bytes).map_err(MeshError::format)?;
    let Gltf { document, blob } = unchecked;
    let document = validated(document)?;
    let file = File {
        buffers: buffers(&document, blob, other)?,
    };
    let mut soup = Soup::default();
    let mut was_seen = vec![false; document.nodes().len()];
    let mut waiting: Vec<(Node<'_>, DAffine3)> = roots(&document)
        .into_iter()
        .map(|node| (node, DAffine3::IDENTITY))
        .collect();
    waiting.reverse();
    while let Some((node, world_from_parent)) = waiting.pop() {
        // A node has one parent: the graph is a tree, without circles.
        if std::mem::replace(&mut was_seen[node.index()], true) {
            let reason = format_args!("node {} has two parents", node.index()).to_string();
            return Err(MeshError::format(reason));
        }
        let world_from_node = world_from_parent * transform(&node)?;
        if let Some(mesh) = node.mesh() {
            refuse_deformation(&node, &mesh)?;
            for primitive in mesh.primitives() {
                file.push_primitive(&primitive, world_from_node, &mut soup)?;
            }
        }
        waiting.extend(node.children().map(|child| (child, world_from_node)));
    }
    Ok(soup)
}

/// The reader subtracts the header's size from the stated length unseen.
fn check_glb_header(bytes: &[u8]) -> Result<(), MeshError> {
    let Some(header) = bytes.strip_prefix(b"glTF") else {
        return Ok(());
    };
    let length = header.get(4..8).and_then(|l| l.try_into().ok());
    match length.map(u32::from_le_bytes) {
        Some(length) if length >= 12 && length as usize <= bytes.len() => Ok(()),
        _ => Err(MeshError::format("the file is cut off")),
    }
}

/// The crate's own validation, without which its accessors panic. It looks up
/// the positions of every primitive itself, before it has checked their number.
fn validated(document: Document) -> Result<Document, MeshError> {
    let json = document.into_json();
    let primitives = json.meshes.iter().flat_map(|mesh| &mesh.primitives);
    for index in primitives.flat_map(|primitive| primitive.attributes.values()) {
        if index.value() >= json.accessors.len() {
            return Err(MeshError::format(format_args!(
                "there is no accessor {}",
                index.value()
            )));
        }
    }
    Document::from_json(json).map_err(|error| match error {
        gltf::Error::Validation(errors) => {
            let each = errors
                .iter()
                .map(|(path, error)| format!("{path}: {error}"));
            MeshError::format(each.collect::<Vec<_>>().join(", "))
        }
        other => MeshError::format(other),
    })
}

fn roots(document: &Document) -> Vec<Node<'_>> {
    let scene = document.default_scene();
    if let Some(scene) = scene.or_else(|| document.scenes().next()) {
        return scene.nodes().collect();
    }
    let mut is_child = vec![false; document.nodes().len()];
    for child in document.nodes().flat_map(|node| node.children()) {
        is_child[child.index()] = true;
    }
    let nodes = document.nodes();
    nodes.filter(|node| !is_child[node.index()]).collect()
}

fn refuse_deformation(node: &Node<'_>, mesh: &gltf::Mesh<'_>) -> Result<(), MeshError> {
    let name = node.index();
    if node.skin().is_some() {
        return Err(MeshError::Unsupported(format!(
            "node {name} is bent by a skin: export it without"
        )));
    }
    let weights = node.weights().or(mesh.weights()).unwrap_or_default();
    if weights.iter().any(|&w| w != 0.0) {
        return Err(MeshError::Unsupported(format!(
            "node {name} is bent by morph targets: export it without"
        )));
    }
    Ok(())
}

fn transform(node: &Node<'_>) -> Result<DAffine3, MeshError> {
    match node.transform() {
        Transform::Matrix { matrix } => {
            let columns = matrix.map(|c| DVec4::from_array(c.map(f64::from)));
            let matrix = DMat4::from_cols(columns[0], columns[1], columns[2], columns[3]);
            if matrix.row(3) != DVec4::W {
                return Err(MeshError::format(format_args!(
                    "the matrix of node {} is not affine",
                    node.index()
                )));
            }
            Ok(DAffine3::from_mat4(matrix))
        }
        Transform::Decomposed {
            translation,
            rotation,
            scale,
        } => {
            let turn = DVec4::from_array(rotation.map(f64::from));
            let turn = turn.try_normalize().unwrap_or(DVec4::W);
            Ok(DAffine3::from_scale_rotation_translation(
                DVec3::from_array(scale.map(f64::from)),
                DQuat::from_vec4(turn),
                DVec3::from_array(translation.map(f64::from)),
            ))
        }
    }
}

/// The bytes of all buffers.
fn buffers(
    document: &Document,
    blob: Option<Vec<u8>>,
    other: &mut dyn FnMut(&str) -> Result<Vec<u8>, FileError>,
) -> Result<Vec<Vec<u8>>, MeshError> {
    let mut blob = blob;
    document
        .buffers()
        .map(|buffer| match buffer.source() {
            Source::Bin => blob
                .take()
                .ok_or_else(|| MeshError::format("there is no binary chunk")),
            Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => inline(data),
                None if uri.contains(':') => Err(MeshError::Unsupported(format!(
                    "buffers are read from files only, not from {uri}"
                ))),
                None => {
                    let path = percent_encoding::percent_decode_str(uri);
                    let path = path.decode_utf8().map_err(MeshError::format)?;
                    Ok(other(&path)?)
                }
            },
        })
        .collect()
}

fn inline(data: &str) -> Result<Vec<u8>, MeshError> {
    let Some((_, text)) = data.split_once(";base64,") else {
        let reason = "data: URIs are read in base64 only".to_owned();
        return Err(MeshError::Unsupported(reason));
    };
    STANDARD
        .decode(text)
        .or_else(|_| STANDARD_NO_PAD.decode(text))
        .map_err(MeshError::format)
}

struct File {
    buffers: Vec<Vec<u8>>,
}

impl File {
    fn push_primitive(
        &self,
        primitive: &Primitive<'_>,
        world_from_node: DAffine3,
        soup: &mut Soup,
    ) -> Result<(), MeshError> {
        let mode = primitive.mode();
        if !matches!(
            mode,
            Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan
        ) {
            return Ok(());
        }
        let Some(positions) = primitive.get(&gltf::Semantic::Positions) else {
            return Ok(());
        };
        let first = soup.vertices.len() as u64;
        let vertices = self.positions(&positions)?;
        let count = vertices.len();
        // Right-handed, z towards the viewer → left-handed, z into the picture.
        let mirror = DVec3::new(1.0, 1.0, -1.0);
        soup.vertices.extend(
            vertices
                .into_iter()
                .map(|v| world_from_node.transform_point3(v) * mirror),
        );
        let indices = match primitive.indices() {
            Some(accessor) => self.indices(&accessor)?,
            None => (0..count as u64).collect(),
        };
        if let Some(&index) = indices.iter().find(|&&i| i >= count as u64) {
            return Err(MeshError::NoSuchVertex {
                index,
                vertices: count,
            });
        }
        let linear = world_from_node.matrix3;
        let keeps_order = linear.determinant() < 0.0;
        let mut push = |[a, b, c]: [u64; 3]| {
            let [b, c] = if keeps_order { [b, c] } else { [c, b] };
            soup.triangles.push([first + a, first + b, first + c]);
        };
        match mode {
            Mode::Triangles => indices.as_chunks::<3>().0.iter().copied().for_each(push),
            Mode::TriangleStrip => {
                for (k, t) in indices.windows(3).enumerate() {
                    // Every second triangle of a strip runs the other way round.
                    push(if k % 2 == 0 {
                        [t[0], t[1], t[2]]
                    } else {
                        [t[1], t[0], t[2]]
                    });
                }
            }
            _ => {
                for pair in indices.get(1..).unwrap_or_default().windows(2) {
                    push([indices[0], pair[0], pair[1]]);
                }
            }
        }
        Ok(())
    }

    fn positions(&self, accessor: &Accessor<'_>) -> Result<Vec<DVec3>, MeshError> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            let reason = "positions are read as three floats only".to_owned();
            return Err(MeshError::Unsupported(reason));
        }
        let items = self.items::<12>(accessor)?;
        let float = |b: &[u8; 4]| f64::from(f32::from_le_bytes(*b));
        Ok(items
            .iter()
            .map(|item| {
                let (xyz, _) = item.as_chunks::<4>();
                DVec3::new(float(&xyz[0]), float(&xyz[1]), float(&xyz[2]))
            })
            .collect())
    }

    fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u64>, MeshError> {
        if accessor.dimensions() != Dimensions::Scalar {
            return Err(MeshError::format("indices are not single numbers"));
        }
        fn wide<const N: usize>(items: Vec<[u8; N]>) -> Vec<u64> {
            let number = |b: &[u8; N]| b.iter().rev().fold(0, |n, &b| n << 8 | u64::from(b));
            items.iter().map(number).collect()
        }
        match accessor.data_type() {
            DataType::U8 => self.items::<1>(accessor).map(wide),
            DataType::U16 => self.items::<2>(accessor).map(wide),
            DataType::U32 => self.items::<4>(accessor).map(wide),
            _ => Err(MeshError::format("indices are not unsigned numbers")),
        }
    }

    /// The elements of an accessor, of N bytes each. The crate's own iterator
    /// trusts offsets and counts; this one does not.
    fn items<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[u8; N]>, MeshError> {
        let count = accessor.count();
        let mut items = match accessor.view() {
            Some(view) => self.slices(&view, accessor.offset(), count)?,
            None if count <= MOST_ZEROS => vec![[0; N]; count],
            None => return Err(MeshError::format("an accessor without data")),
        };
        let Some(sparse) = accessor.sparse() else {
            return Ok(items);
        };
        let (indices, values) = (sparse.indices(), sparse.values());
        let values: Vec<[u8; N]> = self.slices(&values.view(), values.offset(), sparse.count())?;
        let (view, offset) = (indices.view(), indices.offset());
        let size = indices.index_type().size();
        let stride = view.stride().unwrap_or(size);
        for (k, value) in values.into_iter().enumerate() {
            let bytes = self.slice(&view, offset, stride, k, size)?;
            let index = bytes.iter().rev().fold(0, |n, &b| n << 8 | usize::from(b));
            *items
                .get_mut(index)
                .ok_or_else(|| MeshError::format("a sparse accessor beyond its end"))? = value;
        }
        Ok(items)
    }

    fn slices<const N: usize>(
        &self,
        view: &View<'_>,
        offset: usize,
        count: usize,
    ) -> Result<Vec<[u8; N]>, MeshError> {
        let stride = view.stride().unwrap_or(N);
        // The last first: a count that is too large is found before anything is
        // allocated for it.
        if let Some(last) = count.checked_sub(1) {
            self.slice(view, offset, stride, last, N)?;
        }
        (0..count)
            .map(|k| {
                let bytes = self.slice(view, offset, stride, k, N)?;
                bytes
                    .try_into()
                    .map_err(|_| MeshError::format("a buffer is too short"))
            })
            .collect()
    }

    /// Element `k` of a view.
    fn slice(
        &self,
        view: &View<'_>,
        offset: usize,
        stride: usize,
        k: usize,
        size: usize,
    ) -> Result<&[u8], MeshError> {
        let within = || {
            let start = k.checked_mul(stride)?.checked_add(offset)?;
            let end = start.checked_add(size)?;
            if end > view.length() || stride == 0 {
                return None;
            }
            let buffer = self.buffers.get(view.buffer().index())?;
            let first = view.offset();
            buffer.get(first.checked_add(start)?..first.checked_add(end)?)
        };
        within().ok_or_else(|| MeshError::format("a buffer is too short"))
    }
}

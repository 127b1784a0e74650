use std::io::Write;

use glam::dvec3;
use proptest::prelude::*;
use serde_json::json;

use super::*;

fn fixture(name: &str) -> Vec<u8> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/objects");
    std::fs::read(folder.join(name)).unwrap()
}

fn alone(ending: &str, bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    parse(ending, bytes, |named| {
        Err(FileError::Missing(named.to_owned().into()))
    })
}

fn with_buffer(ending: &str, bytes: &[u8]) -> Result<TriangleMesh, MeshError> {
    parse(ending, bytes, |named| match named {
        "tetrahedron data.bin" => Ok(fixture(named)),
        _ => Err(FileError::Missing(named.to_owned().into())),
    })
}

/// Six times the volume, by the triangles' order: positive where they run the
/// same way round everywhere, seen from one side.
fn volume_six(mesh: &TriangleMesh) -> f64 {
    mesh.corners().map(|[a, b, c]| a.dot(b.cross(c))).sum()
}

fn area(mesh: &TriangleMesh) -> f64 {
    let areas = mesh
        .corners()
        .map(|[a, b, c]| (b - a).cross(c - a).length());
    areas.sum::<f64>() / 2.0
}

fn binary_stl(mesh: &TriangleMesh) -> Vec<u8> {
    let triangles: Vec<stl_io::Triangle> = mesh
        .corners()
        .map(|corners| stl_io::Triangle {
            normal: stl_io::Normal::new([0.0; 3]),
            vertices: corners.map(|c| stl_io::Vertex::new(c.as_vec3().to_array())),
        })
        .collect();
    let mut bytes = Vec::new();
    stl_io::write_stl(&mut bytes, triangles.iter()).unwrap();
    bytes
}

fn binary_ply(mesh: &TriangleMesh, big: bool) -> Vec<u8> {
    let order = if big { "big" } else { "little" };
    let mut bytes = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex {}\n\
         property double x\nproperty double y\nproperty double z\n\
         element face {}\nproperty list uchar uint vertex_index\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for number in mesh.vertices.iter().flat_map(|v| v.to_array()) {
        bytes.extend(if big {
            number.to_be_bytes()
        } else {
            number.to_le_bytes()
        });
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        for i in triangle {
            bytes.extend(if big {
                i.to_be_bytes()
            } else {
                i.to_le_bytes()
            });
        }
    }
    bytes
}

fn glb() -> Vec<u8> {
    let mut json: serde_json::Value = serde_json::from_slice(&fixture("tetrahedron.gltf")).unwrap();
    json["buffers"][0].as_object_mut().unwrap().remove("uri");
    let glb = ::gltf::Glb {
        header: ::gltf::binary::Header {
            magic: *b"glTF",
            version: 2,
            length: 0,
        },
        json: serde_json::to_vec(&json).unwrap().into(),
        bin: Some(fixture("tetrahedron data.bin").into()),
    };
    glb.to_vec().unwrap()
}

fn inline_gltf(change: impl FnOnce(&mut serde_json::Value)) -> Vec<u8> {
    use base64::Engine;
    let mut json: serde_json::Value = serde_json::from_slice(&fixture("tetrahedron.gltf")).unwrap();
    let data = base64::engine::general_purpose::STANDARD.encode(fixture("tetrahedron data.bin"));
    json["buffers"][0]["uri"] = format!("data:application/octet-stream;base64,{data}").into();
    change(&mut json);
    serde_json::to_vec(&json).unwrap()
}

#[test]
fn a_cube_is_a_cube_in_every_format() {
    let cube = alone("obj", &fixture("cube.obj")).unwrap();
    assert_eq!(cube.vertices.len(), 8);
    let cubes = [
        ("ply", fixture("cube.ply")),
        ("ply", binary_ply(&cube, false)),
        ("ply", binary_ply(&cube, true)),
        ("stl", binary_stl(&cube)),
    ];
    assert_eq!(cube.triangles.len(), 12);
    assert_eq!(area(&cube), 24.0);
    for (ending, bytes) in cubes {
        let same = alone(ending, &bytes).unwrap();
        assert_eq!(same.triangles.len(), 12, "{ending}");
        assert_eq!(same.vertices.len(), 8, "{ending}");
        assert_eq!(area(&same), 24.0, "{ending}");
        for vertex in &same.vertices {
            assert_eq!(vertex.abs(), DVec3::ONE, "{ending}");
        }
    }
}

#[test]
fn a_text_of_several_solids_is_one_mesh() {
    let mesh = alone("stl", &fixture("tetrahedron.stl")).unwrap();
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 4));
    assert_eq!(volume_six(&mesh), 1.0);
}

#[test]
fn a_binary_stl_may_begin_with_solid() {
    let mesh = alone("stl", &fixture("tetrahedron.stl")).unwrap();
    let mut bytes = binary_stl(&mesh);
    bytes[..12].copy_from_slice(b"solid binary");
    assert_eq!(alone("stl", &bytes).unwrap(), mesh);
}

#[test]
fn a_gltf_is_placed_by_its_nodes_and_mirrored() {
    let mesh = with_buffer("gltf", &fixture("tetrahedron.gltf")).unwrap();
    // Scaled by 2, turned by 90° about y (x → −z, z → x), moved by 10 in x; then z mirrored.
    let expected = [
        dvec3(10.0, 0.0, 0.0),
        dvec3(10.0, 0.0, 2.0),
        dvec3(10.0, 4.0, 0.0),
        dvec3(16.0, 0.0, 0.0),
    ];
    for (vertex, expected) in mesh.vertices.iter().zip(expected) {
        assert!((vertex - expected).length() < 1e-6, "{vertex}");
    }
    // Counter-clockwise seen from outside, in right-handed coordinates: a
    // positive volume; and one in the mirrored ones too, since the order was
    // turned round.
    let centred = TriangleMesh {
        vertices: mesh.vertices.iter().map(|v| v - mesh.vertices[0]).collect(),
        ..mesh.clone()
    };
    assert!((volume_six(&centred) - 48.0).abs() < 1e-4);

    assert_eq!(alone("glb", &glb()).unwrap(), mesh);
    assert_eq!(alone("gltf", &inline_gltf(|_| {})).unwrap(), mesh);
}

#[test]
fn a_gltf_matrix_is_in_columns() {
    let bytes = inline_gltf(|json| {
        json["nodes"] = json!([{
            "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 5, 6, 7, 1],
            "mesh": 0
        }]);
        json.as_object_mut().unwrap().remove("scene");
    });
    let mesh = alone("gltf", &bytes).unwrap();
    assert_eq!(mesh.vertices[0], dvec3(5.0, 6.0, -7.0));
    assert_eq!(mesh.vertices[3], dvec3(5.0, 6.0, -4.0));
    let centred = mesh.vertices.iter().map(|v| v - mesh.vertices[0]);
    let centred = TriangleMesh {
        vertices: centred.collect(),
        ..mesh.clone()
    };
    // A mirroring node keeps the front in front, as glTF says.
    assert!((volume_six(&centred) - 6.0).abs() < 1e-9);
}

#[test]
fn strips_and_fans_become_triangles() {
    for mode in [5, 6] {
        let bytes = inline_gltf(|json| {
            let primitive = &mut json["meshes"][0]["primitives"][0];
            primitive.as_object_mut().unwrap().remove("indices");
            primitive["mode"] = mode.into();
        });
        assert_eq!(alone("gltf", &bytes).unwrap().triangles.len(), 2);
    }
    let lines = inline_gltf(|json| json["meshes"][0]["primitives"][0]["mode"] = 1.into());
    assert!(matches!(alone("gltf", &lines), Err(MeshError::Empty)));
}

#[test]
fn sparse_positions_are_put_in() {
    let bytes = inline_gltf(|json| {
        // Vertex 1 gets the place of vertex 2: its index is the first short of
        // the index list's second entry (2).
        json["accessors"][0]["sparse"] = json!({
            "count": 1,
            "indices": { "bufferView": 1, "byteOffset": 4, "componentType": 5123 },
            "values": { "bufferView": 0, "byteOffset": 36 }
        });
    });
    let mesh = alone("gltf", &bytes).unwrap();
    let apart = (mesh.vertices[0] - mesh.vertices[1]).length();
    assert!(
        (apart - 6.0).abs() < 1e-5 || mesh.vertices.len() < 4,
        "{mesh:?}"
    );
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    type Change = fn(&mut serde_json::Value);
    let refused: [(&str, Change); 12] = [
        ("two parents", |j| j["nodes"][1]["children"] = json!([0])),
        ("two parents", |j| j["scenes"][0]["nodes"] = json!([0, 1])),
        ("skin", |j| {
            j["skins"] = json!([{ "joints": [0] }]);
            j["nodes"][1]["skin"] = 0.into();
        }),
        ("morph", |j| j["meshes"][0]["weights"] = json!([0.5])),
        ("too short", |j| j["accessors"][0]["count"] = 5.into()),
        ("too short", |j| {
            j["bufferViews"][1]["byteOffset"] = 60.into()
        }),
        ("too short", |j| {
            j["accessors"][0]["byteOffset"] = u64::MAX.into();
        }),
        ("three floats", |j| {
            j["accessors"][0]["componentType"] = 5123.into()
        }),
        ("single numbers", |j| {
            j["accessors"][1]["type"] = "VEC2".into()
        }),
        ("names vertex", |j| {
            j["bufferViews"][1]["byteOffset"] = 0.into();
            j["bufferViews"][1]["byteLength"] = 72.into();
        }),
        ("files only", |j| {
            j["buffers"][0]["uri"] = "https://a/b.bin".into()
        }),
        ("not affine", |j| {
            j["nodes"][0] = json!({
                "matrix": [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1],
                "children": [1]
            });
        }),
    ];
    for (expected, change) in refused {
        let error = alone("gltf", &inline_gltf(change)).unwrap_err().to_string();
        assert!(error.contains(expected), "{error} is not about {expected}");
    }
}

#[test]
fn what_is_not_a_mesh_is_refused() {
    let ply = |vertices: &str, faces: &str| {
        let (v, f) = (vertices.lines().count(), faces.lines().count());
        format!(
            "ply\nformat ascii 1.0\nelement vertex {v}\nproperty float x\nproperty float y\n\
             property float z\nelement face {f}\nproperty list uchar int vertex_indices\n\
             end_header\n{vertices}\n{faces}\n"
        )
    };
    let huge =
        "ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\nend_header\n";
    let refused = [
        ("obj", String::new(), "no triangle"),
        (
            "obj",
            "v 0 0 0\nv 1 0 0\nl 1 2\np 1\n".into(),
            "no triangle",
        ),
        (
            "obj",
            "v 0 0 0\nv 1 0 0\nv 0 x 0\nf 1 2 3\n".into(),
            "line 3",
        ),
        (
            "obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n".into(),
            "out of bounds",
        ),
        (
            "obj",
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n".into(),
            "out of bounds",
        ),
        (
            "obj",
            "v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n".into(),
            "not finite",
        ),
        (
            "obj",
            "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\nf 1 1 2\n".into(),
            "no triangle",
        ),
        (
            "ply",
            ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 3"),
            "vertex 3 of 3",
        ),
        ("ply", ply("0 0 0\n1 0 0\n0 1 0", "3 0 1 -1"), "vertex -1"),
        ("ply", ply("0 0 0\n1 0 0\n0 1 0", "2 0 1"), "no triangle"),
        ("ply", ply("0 0 0\n1 0 x", "3 0 1 1"), "line 11"),
        ("ply", huge.into(), "do not fit"),
        ("ply", "plx".into(), "ply"),
        ("stl", "solid a\nfacet normal 0 0 1\n".into(), "endsolid"),
        (
            "stl",
            "solid a\nfacet normal 0 0 1\nendsolid\n".into(),
            "expected",
        ),
        ("stl", "solid a\nendsolid\n".into(), "no triangle"),
        ("stl", "too short".into(), "fill"),
        ("gltf", "{}".into(), "asset"),
        ("gltf", "[".repeat(100_000), "invalid"),
        ("glb", "glTF\u{2}\0\0\0\0\0\0\0".into(), "cut off"),
        ("glb", "glTF".into(), "cut off"),
        ("xyz", String::new(), "end in"),
    ];
    for (ending, text, expected) in refused {
        let error = alone(ending, text.as_bytes()).unwrap_err().to_string();
        assert!(
            error.contains(expected),
            "{ending}: {error:?} is not about {expected:?}"
        );
        assert!(
            !error.contains("damaged"),
            "{ending}: the reader panicked: {error}"
        );
    }
}

#[test]
fn what_is_not_needed_is_dropped() {
    let obj = b"v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1e-170 0\nv 0 1 0\nf 2 3 4\nf 2 2 3\nf 2 3 5\n";
    let mesh = alone("obj", obj).unwrap();
    // The thin one has an area, small as it is; the one with two equal corners
    // has none. Nobody uses the first vertex.
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 1, 3]]);
    assert_eq!(mesh.vertices[0], DVec3::ZERO);
}

#[test]
fn old_texts_in_other_encodings_are_read() {
    let obj = b"# caf\xe9\no caf\xe9\nv 0 0 0\nv 1 0 0\nv 0 1 0\r\nf 1 2 3";
    assert_eq!(alone("obj", obj).unwrap().triangles.len(), 1);
}

#[test]
fn obj_lines_may_go_on_and_carry_what_is_not_read() {
    let obj = "v 0 0 0 1 0 0\nv 2 0 0 2\nv 0 1 \\\n 0 # here\nvt 0\nvn x\nf 1/9/9 2//9 \\\n-1\n";
    let mesh = alone("obj", obj.as_bytes()).unwrap();
    assert_eq!(mesh.vertices, [DVec3::ZERO, DVec3::X, DVec3::Y]);
    let late = format!("{obj}v 1 2\n");
    let error = alone("obj", late.as_bytes()).unwrap_err().to_string();
    assert!(error.starts_with("line 9: "), "{error}");
}

#[test]
fn the_fan_starts_at_the_first_vertex() {
    let mut obj = String::new();
    for k in 0..5 {
        let angle = f64::from(k) * std::f64::consts::TAU / 5.0;
        obj += &format!("v {} {} 0\n", angle.cos(), angle.sin());
    }
    let mesh = alone("obj", format!("{obj}f 1 2 3 4 5\n").as_bytes()).unwrap();
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn a_panic_of_a_reader_is_an_error() {
    let error = guarded::<()>(|| panic!("on purpose")).unwrap_err();
    assert!(
        error.to_string().contains("damaged (on purpose)"),
        "{error}"
    );
}

/// One valid file of each kind.
fn valid_files() -> Vec<(&'static str, Vec<u8>)> {
    let cube = alone("obj", &fixture("cube.obj")).unwrap();
    vec![
        ("obj", fixture("cube.obj")),
        ("ply", fixture("cube.ply")),
        ("ply", binary_ply(&cube, false)),
        ("ply", binary_ply(&cube, true)),
        ("stl", fixture("tetrahedron.stl")),
        ("stl", binary_stl(&cube)),
        ("gltf", inline_gltf(|_| {})),
        ("glb", glb()),
    ]
}

/// A mesh that was read is sound, whatever it was read from; and no reader
/// panics, not even inside of its guard.
fn look_at(ending: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    match alone(ending, bytes) {
        Ok(mesh) => {
            let count = mesh.vertices.len() as u32;
            prop_assert!(mesh.vertices.iter().all(|v| v.is_finite()));
            prop_assert!(mesh.triangles.iter().flatten().all(|&i| i < count));
            prop_assert!(!mesh.triangles.is_empty());
        }
        Err(error) => {
            let said = error.to_string();
            let known = KNOWN_PANICS.iter().any(|known| said.contains(known));
            prop_assert!(known || !said.contains("damaged"), "{ending}: {said}");
        }
    }
    Ok(())
}

/// Panics of the readers that only the guard stops.
const KNOWN_PANICS: [&str; 0] = [];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_bytes_are_read_without_a_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..400),
        kind in 0_usize..5,
    ) {
        look_at(ENDINGS[kind], &bytes)?;
    }

    #[test]
    fn any_mutation_is_read_without_a_panic(
        kind in 0_usize..8,
        changes in prop::collection::vec((0.0..1.0_f64, 0_usize..6, prop::collection::vec(any::<u8>(), 0..6)), 1..4),
    ) {
        let (ending, mut bytes) = valid_files().swap_remove(kind);
        for (at, cut, with) in changes {
            let start = (at * bytes.len() as f64) as usize;
            let end = (start + cut).min(bytes.len());
            bytes.splice(start..end, with);
        }
        look_at(ending, &bytes)?;
    }

    #[test]
    fn any_changed_number_is_read_without_a_panic(
        kind in 0_usize..8,
        at in 0.0..1.0_f64,
        number in prop::sample::select(vec![
            "0", "-1", "1", "3", "255", "65536", "4294967295", "4294967296",
            "9223372036854775807", "-9223372036854775808", "18446744073709551615",
            "6148914691236517206", "1e308", "-1e999", "nan", "",
        ]),
    ) {
        let (ending, bytes) = valid_files().swap_remove(kind);
        // The number after a place in the text gives way to an extreme one.
        let from = (at * bytes.len() as f64) as usize;
        let is_digit = |b: &u8| b.is_ascii_digit();
        let Some(start) = bytes[from..].iter().position(is_digit).map(|i| from + i) else {
            return Ok(());
        };
        let length = bytes[start..].iter().take_while(|b| is_digit(b)).count();
        let mut changed = Vec::new();
        changed.write_all(&bytes[..start]).unwrap();
        changed.write_all(number.as_bytes()).unwrap();
        changed.write_all(&bytes[start + length..]).unwrap();
        look_at(ending, &changed)?;
    }
}

//! Every kind of emitted scene text is a reviewed snapshot, and POV-Ray parses
//! and renders each of them.

mod common;

use std::sync::Arc;

use common::{AA1, at, context, fragment, neutral, povray, scene};
use decor_api::{
    Adapter, Antialias, Blocks, Bounds, Camera, Csg, Fade, Highlight, Instance, LayerRequest,
    LayerShot, Light, LightKind, Material, NativeFile, Output, Pose, PrototypeTable, Region, Rgb,
    Scene, Size, TriangleMesh, Window,
};
use decor_povray::LayerSource;
use glam::DVec3;

const SIZE: Size = Size {
    width: 96,
    height: 64,
};

fn view() -> Camera {
    Camera::look_at(
        DVec3::new(0.0, 2.0, -10.0),
        DVec3::ZERO,
        DVec3::Y,
        (60.0, 42.0),
    )
    .unwrap()
}

fn check(
    name: &str,
    table: &PrototypeTable,
    scenes: &[Arc<Scene>],
    output: Output,
    region: Region,
    antialias: Option<Antialias>,
    film: Option<(u32, u32)>,
) {
    for source in [LayerSource::StateFile, LayerSource::Pictures] {
        let povray = povray(source);
        let request = LayerRequest {
            prototypes: table,
            size: SIZE,
            output,
            antialias,
            shots: (3..)
                .zip(scenes)
                .map(|(frame, scene)| LayerShot {
                    frame,
                    scene: Arc::clone(scene),
                    region: region.clone(),
                })
                .collect(),
            film,
            label: "text".into(),
        };
        let text = povray.scene_text(&request).unwrap();
        let mut shown = String::new();
        for (file, bytes) in &text.files {
            shown.push_str(&format!("==> {file}\n{}", String::from_utf8_lossy(bytes)));
        }
        // Only depth is written differently for the two ways of reading.
        if source == LayerSource::StateFile || output == Output::Depth {
            let ending = if source == LayerSource::Pictures {
                "_16"
            } else {
                ""
            };
            insta::assert_snapshot!(format!("{name}{ending}"), shown);
        }
        let (_folder, run) = context();
        let layers = povray.render(&request, &run).unwrap();
        assert_eq!(layers.len(), scenes.len());
        // Something is to be seen, or the test would show nothing.
        match output {
            Output::Depth => {
                let depth = layers[0].depth.as_ref().unwrap();
                assert!(
                    depth.iter().any(|d| d.is_finite()),
                    "{name}: nothing is there"
                );
            }
            _ => {
                let colour = layers[0].colour.as_ref().unwrap();
                assert!(
                    colour.iter().any(|c| *c != colour[0]),
                    "{name}: all is one colour"
                );
            }
        }
    }
}

fn window() -> Region {
    Region::Window(SIZE.window())
}

fn mesh() -> Csg {
    Csg::Mesh(Arc::new(TriangleMesh {
        vertices: vec![
            DVec3::ZERO,
            DVec3::new(1.0, 0.1, 0.0),
            DVec3::new(0.0, 1.0 / 3.0, 1e-7),
            DVec3::new(0.0, 0.0, -1.0),
        ],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }))
}

fn everything() -> Csg {
    let shiny = Material {
        colour: Rgb([0.9, 0.8, 0.1]),
        ambient: 0.2,
        diffuse: 0.6,
        highlight: Highlight::Specular {
            amount: 0.7,
            roughness: 0.02,
        },
        reflection: 0.3,
        transmission: 0.0,
        ior: 1.0,
    };
    let glass = Material {
        transmission: 0.8,
        ior: 1.5,
        highlight: Highlight::Phong {
            amount: 1.0,
            size: 60.0,
        },
        ..Material::default()
    };
    let bored = Csg::Difference(
        Box::new(Csg::Box {
            min: DVec3::splat(-1.0),
            max: DVec3::ONE,
        }),
        vec![
            Csg::Cylinder {
                base: DVec3::X * -2.0,
                cap: DVec3::X * 2.0,
                radius: 0.5,
            },
            Csg::Look(
                shiny,
                Box::new(Csg::Sphere {
                    centre: DVec3::ONE,
                    radius: 0.8,
                }),
            ),
        ],
    );
    let turned = Csg::Translate(
        DVec3::new(0.0, 2.0, 0.0),
        Box::new(Csg::Rotate(
            DVec3::new(10.0, 20.0, 30.0),
            Box::new(Csg::Scale(
                DVec3::new(1.0, 2.0, 0.5),
                Box::new(Csg::Torus {
                    major: 1.0,
                    minor: 0.25,
                }),
            )),
        )),
    );
    let lens = Csg::Look(
        glass,
        Box::new(Csg::Intersection(vec![
            Csg::Sphere {
                centre: DVec3::new(-2.0, 0.0, 0.5),
                radius: 1.0,
            },
            Csg::Sphere {
                centre: DVec3::new(-2.0, 0.0, -0.5),
                radius: 1.0,
            },
        ])),
    );
    let cone = Csg::Cone {
        base: DVec3::new(2.0, 0.0, 0.0),
        base_radius: 0.7,
        cap: DVec3::new(2.0, 1.5, 0.0),
        cap_radius: 0.0,
    };
    Csg::Union(vec![bored, turned, lens, cone, mesh()])
}

#[test]
fn neutral_solids_and_materials() {
    let mut table = PrototypeTable::default();
    let id = neutral(&mut table, "everything", [0.2, 0.4, 0.6], everything());
    let turned = Instance {
        prototype: id,
        pose: Pose {
            position: DVec3::new(0.5, 0.0, 2.0),
            angles_deg: DVec3::new(0.0, -30.0, 1e-7),
        },
    };
    let scene = scene(view(), vec![at(id, 0.0, 0.0, 0.0), turned]);
    check(
        "neutral",
        &table,
        &[scene],
        Output::ColourOverBackground,
        window(),
        None,
        None,
    );
}

#[test]
fn all_lights_and_no_shadows() {
    let mut table = PrototypeTable::default();
    let id = neutral(
        &mut table,
        "ball",
        [1.0; 3],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 2.0,
        },
    );
    let mut lit = (*scene(view(), vec![at(id, 0.0, 0.0, 0.0)])).clone();
    let light = |kind, fade| Light {
        position: DVec3::new(-5.0, 8.0, -10.0),
        colour: Rgb([0.3, 0.2, 0.1]),
        kind,
        fade,
    };
    let towards = DVec3::new(0.0, 1.0, 0.0);
    lit.lights = vec![
        light(
            LightKind::Point,
            Some(Fade {
                distance: 12.0,
                power: 2.0,
            }),
        ),
        light(LightKind::Sun { towards }, None),
        light(
            LightKind::Spot {
                towards,
                radius_deg: 10.0,
                falloff_deg: 20.0,
                tightness: 3.0,
            },
            None,
        ),
        light(
            LightKind::Area {
                u: DVec3::X * 2.0,
                v: DVec3::Y,
                nu: 3,
                nv: 2,
            },
            None,
        ),
    ];
    lit.shadows = false;
    check(
        "lights",
        &table,
        &[Arc::new(lit)],
        Output::ColourOverBackground,
        window(),
        Some(AA1),
        None,
    );
}

#[test]
fn a_film_of_fragments_with_declarations_and_a_sky() {
    let mut table = PrototypeTable::default();
    let bounds = Bounds::sphere(DVec3::ZERO, 2.0);
    let a = fragment(
        &mut table,
        "a",
        bounds,
        "#declare R = 1;\nsphere { 0, R texture { Skin } } // the end",
    );
    let b = fragment(
        &mut table,
        "b",
        bounds,
        "#declare R = 2;\n#macro M(S) box { -S, S } #end\nobject { M(R/3) pigment { rgb y } }\n",
    );
    let native = |name: &str, text: &str| NativeFile {
        path: format!("/nowhere/{name}").into(),
        root: "/nowhere".into(),
        text: text.into(),
    };
    let with = |x: f64| {
        let mut scene = (*scene(view(), vec![at(a, x, 0.0, 0.0), at(b, -2.0, 0.0, 0.0)])).clone();
        scene.includes = vec![native(
            "names.inc",
            "#declare Skin = texture { pigment { rgb x } }",
        )];
        scene.sky = Some(native(
            "sky.inc",
            "sky_sphere { pigment { gradient y color_map { [0 rgb 1][1 rgb z] } } }",
        ));
        Arc::new(scene)
    };
    let scenes = [with(1.0), with(2.0)];
    check(
        "film",
        &table,
        &scenes,
        Output::ColourOverBackground,
        window(),
        None,
        Some((0, 9)),
    );
    check(
        "alone",
        &table,
        &scenes,
        Output::ColourAlone { with_sky: false },
        window(),
        Some(AA1),
        None,
    );
    check("veil", &table, &scenes, Output::Depth, window(), None, None);
}

#[test]
fn depth_by_pigment_in_a_window() {
    let mut table = PrototypeTable::default();
    let id = neutral(&mut table, "everything", [0.2, 0.4, 0.6], everything());
    let scene = scene(view(), vec![at(id, 0.0, 0.0, 0.0)]);
    let part = Region::Window(Window {
        x: 32,
        y: 0,
        width: 64,
        height: 64,
    });
    check("pigment", &table, &[scene], Output::Depth, part, None, None);
}

#[test]
fn blocks() {
    let mut table = PrototypeTable::default();
    let id = neutral(
        &mut table,
        "ball",
        [1.0, 0.0, 0.0],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 2.0,
        },
    );
    let scenes = [
        scene(view(), vec![at(id, 0.0, 0.0, 0.0)]),
        scene(view(), vec![at(id, 1.0, 0.0, 0.0)]),
    ];
    let some = Region::Blocks(Blocks::usual(vec![1, 4]));
    check(
        "blocks",
        &table,
        &scenes,
        Output::ColourOverBackground,
        some,
        Some(AA1),
        None,
    );
}

/// What only some frames place is read in these alone, and they are the same.
#[test]
fn what_a_frame_does_not_place_is_not_read_for_it() {
    let mut table = PrototypeTable::default();
    let solid = Csg::Sphere {
        centre: DVec3::ZERO,
        radius: 1.0,
    };
    let ball = neutral(&mut table, "ball", [1.0, 0.0, 0.0], solid);
    let bounds = Bounds::sphere(DVec3::ZERO, 2.0);
    let text = "#local Side = 1; box { -Side, Side pigment { rgb y } }";
    let cube = fragment(&mut table, "cube", bounds, text);
    let both = vec![at(ball, -2.0, 0.0, 0.0), at(cube, 2.0, 0.0, 0.0)];
    let one = vec![at(ball, -2.0, 0.0, 0.0)];
    let scenes = [&both, &one, &both, &both].map(|placed| scene(view(), placed.clone()));
    let povray = povray(LayerSource::StateFile);
    let request = |scenes: &[Arc<Scene>]| LayerRequest {
        prototypes: &table,
        size: SIZE,
        output: Output::ColourOverBackground,
        antialias: None,
        shots: (3..)
            .zip(scenes)
            .map(|(frame, scene)| LayerShot {
                frame,
                scene: Arc::clone(scene),
                region: window(),
            })
            .collect(),
        film: None,
        label: "some".into(),
    };
    let main = povray.scene_text(&request(&scenes)).unwrap().files[0]
        .1
        .clone();
    let main = String::from_utf8(main).unwrap();
    let condition = "#if (((frame_number >= 1) & (frame_number <= 1)) \
                     | ((frame_number >= 3) & (frame_number <= 4)))\n#declare Decor_P1";
    assert!(main.contains(condition), "{main}");
    assert_eq!(main.matches("#if").count(), 1, "{main}");
    let (_folder, run) = context();
    let together = povray.render(&request(&scenes), &run).unwrap();
    for (layer, scene) in together.iter().zip(&scenes) {
        let alone = povray.render(&request(std::slice::from_ref(scene)), &run);
        assert_eq!(alone.unwrap()[0].colour, layer.colour);
    }
    assert_ne!(together[0].colour, together[1].colour);
}

#[test]
fn numbers_read_back_the_same() {
    // POV-Ray itself is asked: a difference of one unit in the last place of a
    // coordinate would show in the text that it writes back.
    use decor_povray::number;
    let values = [
        0.1,
        1.0 / 3.0,
        1e-7,
        123_456_789.123_456_79,
        -2.5e-300,
        1.797e308,
        5e-324,
        1e15,
    ];
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::from("#version 3.7;\n#fopen F \"out.txt\" write\n");
    for value in values {
        // Equal to itself read from a literal with many more digits?
        let long = format!("{value:.40e}");
        text.push_str(&format!(
            "#write (F, #if ({} = {long}) \"same\\n\" #else \"differs {}\\n\" #end)\n",
            number(value),
            number(value)
        ));
    }
    text.push_str("#fclose F\n#error \"written\"\n");
    std::fs::write(folder.path().join("n.pov"), text).unwrap();
    let _ = std::process::Command::new(povray(LayerSource::StateFile).program())
        .args(["+In.pov", "+W8", "+H8", "-D", "-F"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let out = std::fs::read_to_string(folder.path().join("out.txt")).unwrap();
    assert_eq!(
        out.lines().filter(|line| *line == "same").count(),
        values.len(),
        "{out}"
    );
}

//! Objects that the camera does not see: they cast shadows and show in mirrors.

mod common;

use std::sync::Arc;

use common::{at, context, fragment, neutral, povray, scene};
use decor_api::{
    Adapter, Bounds, Camera, Csg, Layer, LayerRequest, LayerShot, Output, PrototypeId,
    PrototypeTable, Region, Scene, Size,
};
use decor_povray::LayerSource;
use glam::DVec3;

const SIZE: Size = Size {
    width: 96,
    height: 64,
};

/// A floor, a mirror behind it, and three things to hide: a neutral union, a
/// fragment of several objects, and a fragment that is a union of unions.
struct Stage {
    table: PrototypeTable,
    seen: Vec<PrototypeId>,
    others: Vec<PrototypeId>,
}

fn stage() -> Stage {
    let mut table = PrototypeTable::default();
    let bounds = Bounds::sphere(DVec3::ZERO, 2.0);
    let floor = fragment(
        &mut table,
        "floor",
        Bounds::sphere(DVec3::ZERO, 18.0),
        "box { <-12,-1.1,-9>, <12,-1,5> pigment { checker rgb 1, rgb 0.6 } }",
    );
    let mirror = fragment(
        &mut table,
        "mirror",
        Bounds::sphere(DVec3::ZERO, 18.0),
        "box { <-12,-1,4>, <12,9,4.1> pigment { rgb 0.1 } finish { reflection 0.8 } }",
    );
    let ball = |x, radius| Csg::Sphere {
        centre: DVec3::X * x,
        radius,
    };
    let pair = Csg::Union(vec![ball(0.0, 0.8), ball(0.9, 0.4)]);
    let pair = neutral(&mut table, "pair", [1.0, 0.2, 0.2], pair);
    let several = "sphere { 0, 0.7 pigment { rgb y } } box { <0.4,-0.3,-0.3>, <1.2,0.3,0.3> pigment { rgb z } }";
    let several = fragment(&mut table, "several", bounds, several);
    let nested = "union { union { sphere { -x, 0.5 } cylinder { -x, x, 0.2 } } object { sphere { x, 0.5 } scale <1,1.2,1> } pigment { rgb <1,1,0> } }";
    let nested = fragment(&mut table, "nested", bounds, nested);
    Stage {
        table,
        seen: vec![floor, mirror],
        others: vec![pair, several, nested],
    }
}

impl Stage {
    fn scene(&self, seen: bool, shown: &[usize], hidden: &[usize]) -> Arc<Scene> {
        let eye = DVec3::new(0.0, 2.0, -10.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, (60.0, 42.0)).unwrap();
        let place = |&k: &usize| at(self.others[k], 2.5 * k as f64 - 2.5, 0.2, 0.0);
        let mut instances = Vec::new();
        if seen {
            instances.extend(self.seen.iter().map(|&id| at(id, 0.0, 0.0, 0.0)));
        }
        instances.extend(shown.iter().map(place));
        let mut scene = (*scene(camera, instances)).clone();
        scene.hidden = hidden.iter().map(place).collect();
        Arc::new(scene)
    }

    fn draw(&self, scenes: Vec<Arc<Scene>>, output: Output, source: LayerSource) -> Vec<Layer> {
        let (_folder, run) = context();
        let shot = |scene| LayerShot {
            frame: 0,
            scene,
            region: Region::Window(SIZE.window()),
        };
        let request = LayerRequest {
            prototypes: &self.table,
            size: SIZE,
            output,
            antialias: None,
            shots: scenes.into_iter().map(shot).collect(),
            film: None,
            label: "hidden".into(),
        };
        povray(source).render(&request, &run).unwrap()
    }
}

const ALL: [usize; 3] = [0, 1, 2];

#[test]
fn the_hidden_shade_and_are_mirrored_but_are_not_seen() {
    let stage = stage();
    let alone = Output::ColourAlone { with_sky: false };
    for source in [LayerSource::StateFile, LayerSource::Pictures] {
        let depths = stage.draw(
            vec![stage.scene(true, &ALL, &[]), stage.scene(true, &[], &ALL)],
            Output::Depth,
            LayerSource::StateFile,
        );
        let depths: Vec<&Vec<f64>> = depths.iter().map(|l| l.depth.as_ref().unwrap()).collect();
        for output in [Output::ColourOverBackground, alone] {
            let layers = stage.draw(
                vec![
                    stage.scene(true, &ALL, &[]),
                    stage.scene(true, &[], &ALL),
                    stage.scene(true, &[], &[]),
                ],
                output,
                source,
            );
            let [whole, hidden, without] = [0, 1, 2].map(|k| layers[k].colour.as_ref().unwrap());
            let (mut shown, mut changed) = (0, 0);
            for k in 0..SIZE.pixels() {
                // Where one of them is in front, it is not seen.
                if (depths[0][k] - depths[1][k]).abs() > 0.05 {
                    shown += 1;
                    assert_ne!(hidden[k], whole[k], "{output:?} {source:?} pixel {k}");
                } else {
                    assert_eq!(hidden[k], whole[k], "{output:?} {source:?} pixel {k}");
                    changed += usize::from(hidden[k] != without[k]);
                }
            }
            assert!(shown > 200, "{shown} pixels show them");
            assert!(changed > 200, "{changed} pixels in shadow or mirror");
        }
    }
}

#[test]
fn depth_takes_no_notice_of_them() {
    let stage = stage();
    for shown in [&[][..], &[0]] {
        // Neutral objects alone have another depth pass than fragments.
        let scenes = vec![
            stage.scene(shown.is_empty(), shown, &[1, 2]),
            stage.scene(shown.is_empty(), shown, &[]),
        ];
        let layers = stage.draw(scenes, Output::Depth, LayerSource::StateFile);
        assert_eq!(layers[0].depth, layers[1].depth);
        assert!(
            layers[0]
                .depth
                .as_ref()
                .unwrap()
                .iter()
                .any(|d| d.is_finite())
        );
    }
}

#[test]
fn the_text_says_no_image() {
    let stage = stage();
    let mut unshaded = (*stage.scene(true, &[0], &[1, 2])).clone();
    unshaded.shadows = false;
    let text = |scene: Arc<Scene>, output| {
        let request = LayerRequest {
            prototypes: &stage.table,
            size: SIZE,
            output,
            antialias: None,
            shots: vec![LayerShot {
                frame: 0,
                scene,
                region: Region::Window(SIZE.window()),
            }],
            film: None,
            label: "hidden".into(),
        };
        let text = povray(LayerSource::StateFile).scene_text(&request).unwrap();
        let mut shown = String::new();
        for (file, bytes) in &text.files {
            shown.push_str(&format!("==> {file}\n{}", String::from_utf8_lossy(bytes)));
        }
        shown
    };
    let shaded = stage.scene(true, &[0], &[1, 2]);
    let alone = Output::ColourAlone { with_sky: false };
    insta::assert_snapshot!(
        "hidden",
        text(Arc::clone(&shaded), Output::ColourOverBackground)
    );
    insta::assert_snapshot!("hidden_alone", text(Arc::clone(&shaded), alone));
    insta::assert_snapshot!("hidden_unshaded", text(Arc::new(unshaded), alone));
    assert!(!text(shaded, Output::Depth).contains("no_image"));
}

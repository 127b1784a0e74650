//! A window rendered by a crop camera has the full frame's very values.

mod common;

use std::sync::Arc;

use common::{AA1, at, context, fragment, neutral, povray, scene};
use decor_api::{
    Adapter, Antialias, Blocks, Bounds, Camera, Csg, Layer, LayerRequest, LayerShot, Output,
    PrototypeTable, Region, Scene, Size, Window,
};
use decor_povray::LayerSource;
use glam::DVec3;

/// A box whose edge lies on the view's axis, a checkered floor up to the
/// horizon, stripes, and a small ball one pixel above a block's border.
fn stage(size: Size) -> (PrototypeTable, Arc<Scene>) {
    let mut table = PrototypeTable::default();
    let cube = neutral(
        &mut table,
        "cube",
        [1.0, 0.1, 0.1],
        Csg::Box {
            min: DVec3::new(0.0, -1.0, 0.0),
            max: DVec3::new(3.0, 1.0, 2.0),
        },
    );
    let floor = fragment(
        &mut table,
        "floor",
        Bounds::Unbounded,
        "plane { y, -2 pigment { checker rgb 0.9, rgb <0.2,0.5,0.2> scale 0.5 } }",
    );
    let stripes = fragment(
        &mut table,
        "stripes",
        Bounds::sphere(DVec3::ZERO, 1.0),
        "sphere { 0, 1 pigment { gradient x color_map { [0.5 rgb 1][0.5 rgb 0] } scale 0.2 } }",
    );
    let speck = neutral(
        &mut table,
        "speck",
        [1.0, 1.0, 0.0],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 0.4,
        },
    );
    let aspect = f64::from(size.height) / f64::from(size.width);
    let (half_width, half_height) = (2.0 / 3.0_f64, 2.0 / 3.0 * aspect);
    let degrees = |half: f64| 2.0 * half.atan().to_degrees();
    let eye = DVec3::new(0.0, 0.0, -6.0);
    let camera = Camera::look_at(
        eye,
        DVec3::ZERO,
        DVec3::Y,
        (degrees(half_width), degrees(half_height)),
    )
    .unwrap();
    // The speck covers the row below the first blocks alone: antialiasing that
    // looks up must still see it.
    let ray = camera.direction(size, 40.0, 32.6);
    let place = eye + ray * 5.9;
    let instances = vec![
        at(cube, 0.0, 0.0, 0.0),
        at(floor, 0.0, 0.0, 0.0),
        at(stripes, -2.0, 0.0, 0.0),
        at(speck, place.x, place.y, place.z),
    ];
    (table, scene(camera, instances))
}

fn render(
    table: &PrototypeTable,
    scene: &Arc<Scene>,
    size: Size,
    antialias: Option<Antialias>,
    source: LayerSource,
    windows: &[Window],
) -> Vec<Layer> {
    let (_folder, run) = context();
    let shot = |&window: &Window| LayerShot {
        frame: 0,
        scene: Arc::clone(scene),
        region: Region::Window(window),
    };
    let request = LayerRequest {
        prototypes: table,
        size,
        output: Output::ColourOverBackground,
        antialias,
        shots: windows.iter().map(shot).collect(),
        film: None,
        label: "crop".into(),
    };
    povray(source).render(&request, &run).unwrap()
}

fn differing(full: &Layer, crop: &Layer) -> Vec<(u32, u32)> {
    let (full_colour, crop_colour) = (full.colour.as_ref().unwrap(), crop.colour.as_ref().unwrap());
    let mut wrong = Vec::new();
    for y in crop.window.y..crop.window.bottom() {
        for x in crop.window.x..crop.window.right() {
            if full_colour[full.index(x, y)] != crop_colour[crop.index(x, y)] {
                wrong.push((x, y));
            }
        }
    }
    wrong
}

fn check(size: Size, source: LayerSource) {
    let (table, scene) = stage(size);
    let cut = |x, y, width, height| {
        Window {
            x,
            y,
            width,
            height,
        }
        .intersection(size.window())
    };
    let windows = [
        cut(96, 32, 64, 64),
        cut(64, 32, 96, 64),
        cut(32, 64, 96, 32),
        cut(0, 0, 32, 32),
        cut(160, 96, 64, 64),
        cut(32, 32, 32, 32),
    ];
    let modes = [
        None,
        Some(AA1),
        Some(Antialias {
            threshold: 0.3,
            depth: 2,
        }),
    ];
    for antialias in modes {
        let full = render(&table, &scene, size, antialias, source, &[size.window()]);
        let crops = render(&table, &scene, size, antialias, source, &windows);
        for crop in &crops {
            let wrong = differing(&full[0], crop);
            assert!(
                wrong.is_empty(),
                "{size:?} {antialias:?} {:?}: {wrong:?}",
                crop.window
            );
        }
    }
}

#[test]
fn odd_sizes() {
    check(
        Size {
            width: 205,
            height: 157,
        },
        LayerSource::StateFile,
    );
}

#[test]
fn usual_sizes() {
    check(
        Size {
            width: 320,
            height: 240,
        },
        LayerSource::StateFile,
    );
}

#[test]
fn powers_of_two() {
    check(
        Size {
            width: 1024,
            height: 1024,
        },
        LayerSource::StateFile,
    );
}

#[test]
fn pictures_of_16_bits() {
    check(
        Size {
            width: 205,
            height: 157,
        },
        LayerSource::Pictures,
    );
}

#[test]
fn blocks_of_the_full_picture() {
    let size = Size {
        width: 205,
        height: 157,
    };
    let (table, scene) = stage(size);
    for source in [LayerSource::StateFile, LayerSource::Pictures] {
        let (_folder, run) = context();
        let request = |region: Region| LayerRequest {
            prototypes: &table,
            size,
            output: Output::ColourOverBackground,
            antialias: Some(AA1),
            shots: vec![LayerShot {
                frame: 0,
                scene: Arc::clone(&scene),
                region,
            }],
            film: None,
            label: "blocks".into(),
        };
        let povray = povray(source);
        let full = povray
            .render(&request(Region::Window(size.window())), &run)
            .unwrap();
        // The last ones are alone with the picture's right and lower border, which
        // cuts them: where a crop is rendered, its border is another.
        let sets: [&[u32]; 7] = [
            &[2, 8, 9, 34],
            &[6],
            &[13, 20],
            &[26, 27],
            &[28],
            &[31, 32],
            &[34],
        ];
        for ids in sets {
            let region = Region::Blocks(Blocks::usual(ids.to_vec()));
            let part = &povray.render(&request(region), &run).unwrap()[0];
            for &id in ids {
                let window = decor_api::block_window(id, decor_api::BLOCK, size);
                let block = Layer {
                    window,
                    colour: Some(
                        (window.y..window.bottom())
                            .flat_map(|y| (window.x..window.right()).map(move |x| (x, y)))
                            .map(|(x, y)| part.colour.as_ref().unwrap()[part.index(x, y)])
                            .collect(),
                    ),
                    depth: None,
                    depth_quantum: (0.0, 0.0),
                };
                assert_eq!(differing(&full[0], &block), [], "{source:?} block {id}");
            }
        }
    }
}

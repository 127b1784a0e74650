//! POV-Ray's depth, made by pigment and by veil, against the reference ray
//! caster's.

mod common;

use std::sync::Arc;

use common::{at, context, fragment, neutral, povray, scene};
use decor_api::{
    Adapter, Bounds, Camera, Csg, Layer, LayerRequest, LayerShot, Output, PrototypeTable, Region,
    Scene, Size,
};
use decor_povray::LayerSource;
use decor_reference::World;
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

fn depth(table: &PrototypeTable, scene: &Arc<Scene>, source: LayerSource) -> Layer {
    let (_folder, run) = context();
    let request = LayerRequest {
        prototypes: table,
        size: SIZE,
        output: Output::Depth,
        antialias: None,
        shots: vec![LayerShot {
            frame: 0,
            scene: Arc::clone(scene),
            region: Region::Window(SIZE.window()),
        }],
        film: None,
        label: "depth".into(),
    };
    povray(source)
        .render(&request, &run)
        .unwrap()
        .pop()
        .unwrap()
}

/// The largest error as a share of the layer's largest distance, and how many
/// pixels only one of the two calls empty.
fn compare(layer: &Layer, table: &PrototypeTable, truth: &Scene) -> (f64, f64, usize) {
    let world = World::of(truth, table).unwrap();
    let found = layer.depth.as_ref().unwrap();
    let (mut error, mut beyond, mut far, mut silhouette) = (0.0_f64, 0.0_f64, 0.0_f64, 0);
    for y in 0..SIZE.height {
        for x in 0..SIZE.width {
            let direction = truth
                .camera
                .direction(SIZE, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let hit = world.cast(truth.camera.eye, direction);
            // POV-Ray does not see farther than this.
            let expected = hit.map(|hit| hit.distance).filter(|d| *d < 1e7);
            let depth = found[layer.index(x, y)];
            match expected {
                None if depth == f64::INFINITY => {}
                Some(d) if depth != f64::INFINITY => {
                    far = far.max(d);
                    error = error.max((depth - d).abs());
                    let (absolute, relative) = layer.depth_quantum;
                    let quantum = absolute + relative * d;
                    beyond = beyond.max((depth - d).abs() / quantum);
                }
                _ => silhouette += 1,
            }
        }
    }
    (error / far, beyond, silhouette)
}

fn solids(table: &mut PrototypeTable, ratio: f64) -> Arc<Scene> {
    let ball = neutral(
        table,
        "ball",
        [1.0, 0.2, 0.2],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        },
    );
    let cube = neutral(
        table,
        "cube",
        [0.2, 1.0, 0.2],
        Csg::Box {
            min: DVec3::splat(-1.0),
            max: DVec3::splat(1.0),
        },
    );
    let wall = neutral(
        table,
        "wall",
        [0.5; 3],
        Csg::Box {
            min: DVec3::splat(-0.4 * ratio),
            max: DVec3::splat(0.4 * ratio),
        },
    );
    let near = neutral(
        table,
        "near",
        [0.5; 3],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 0.1,
        },
    );
    scene(
        view(),
        vec![
            at(ball, -2.0, 0.0, 0.0),
            at(cube, 2.0, 0.0, 1.0),
            at(wall, 0.0, -0.3 * ratio, ratio),
            at(near, 0.4, 1.7, -9.0),
        ],
    )
}

fn floor(table: &mut PrototypeTable) -> Arc<Scene> {
    let plane = neutral(
        table,
        "plane",
        [0.5; 3],
        Csg::Plane {
            normal: DVec3::Y,
            distance: -1.0,
        },
    );
    let ball = neutral(
        table,
        "ball",
        [1.0, 0.2, 0.2],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        },
    );
    scene(
        view(),
        vec![at(plane, 0.0, 0.0, 0.0), at(ball, 0.0, 0.0, 0.0)],
    )
}

#[test]
fn by_pigment() {
    for ratio in [10.0, 1e3, 1e6] {
        let mut table = PrototypeTable::default();
        let scene = solids(&mut table, ratio);
        for source in [LayerSource::StateFile, LayerSource::Pictures] {
            let layer = depth(&table, &scene, source);
            let (error, beyond, silhouette) = compare(&layer, &table, &scene);
            println!(
                "pigment, {source:?}, far {ratio:e}: {error:.1e} of the range, {beyond:.2} quanta"
            );
            assert!(error <= 1e-8, "{source:?} {ratio}: {error:e}");
            assert!(beyond <= 1.5, "{source:?} {ratio}: {beyond} quanta");
            assert_eq!(silhouette, 0);
        }
    }
}

#[test]
fn of_a_plane_up_to_its_horizon() {
    let mut table = PrototypeTable::default();
    let scene = floor(&mut table);
    let layer = depth(&table, &scene, LayerSource::StateFile);
    let (error, beyond, silhouette) = compare(&layer, &table, &scene);
    assert!(error <= 1e-8 && beyond <= 1.5, "{error:e}, {beyond} quanta");
    assert_eq!(silhouette, 0);
}

/// Fragments of every kind that a pigment could not see, each the size of a
/// neutral solid that stands for it.
fn veiled() -> Vec<(&'static str, &'static str, Csg)> {
    let ball = || Csg::Sphere {
        centre: DVec3::ZERO,
        radius: 1.5,
    };
    let bitten = || {
        Csg::Difference(
            Box::new(ball()),
            vec![Csg::Box {
                min: DVec3::new(-1.0, -1.0, -2.0),
                max: DVec3::new(1.0, 1.0, 0.0),
            }],
        )
    };
    vec![
        ("plain", "sphere { 0, 1.5 pigment { rgb 1 } }", ball()),
        (
            "mirror",
            "sphere { 0, 1.5 pigment { rgb 1 } finish { reflection 0.9 ambient 1 } }",
            ball(),
        ),
        (
            "glass",
            "sphere { 0, 1.5 pigment { rgbt 0.9 } interior { ior 1.5 } }",
            ball(),
        ),
        (
            "glowing",
            "sphere { 0, 1.5 pigment { rgb 9 } finish { emission 3 ambient 5 } }",
            ball(),
        ),
        (
            "media",
            "sphere { 0, 1.5 pigment { rgbt 0.5 } hollow interior { media { emission 3 scattering { 1, 2 } } } }",
            ball(),
        ),
        (
            "negative",
            "difference { sphere { 0, 1.5 pigment { rgb 1 } } box { <-1,-1,-2>, <1,1,0> pigment { rgb -5 } } }",
            bitten(),
        ),
        (
            "unlike parts",
            "union { sphere { 0, 1.5 texture { pigment { rgb 1 } } } sphere { 0, 0.5 pigment { rgb 2 } no_shadow } }",
            ball(),
        ),
    ]
}

#[test]
fn by_veil() {
    for ratio in [1e2, 1e6] {
        for (name, text, stand_in) in veiled() {
            let mut table = PrototypeTable::default();
            let wall = Csg::Box {
                min: DVec3::splat(-0.4 * ratio),
                max: DVec3::splat(0.4 * ratio),
            };
            let wall = neutral(&mut table, "wall", [0.5; 3], wall);
            let real = fragment(&mut table, name, stand_in.bounds(), text);
            let truth = neutral(&mut table, "stand-in", [1.0; 3], stand_in);
            let with = |id| {
                scene(
                    view(),
                    vec![at(id, 0.3, 0.2, 0.0), at(wall, 0.0, -0.3 * ratio, ratio)],
                )
            };
            for source in [LayerSource::StateFile, LayerSource::Pictures] {
                let layer = depth(&table, &with(real), source);
                let (error, beyond, silhouette) = compare(&layer, &table, &with(truth));
                println!(
                    "veil, {name}, {source:?}, far {ratio:e}: {error:.1e}, {beyond:.2} quanta"
                );
                assert!(error <= 2e-5, "{name} {source:?}: {error:e} of the range");
                assert!(beyond <= 1.5, "{name} {source:?}: {beyond} quanta");
                assert_eq!(silhouette, 0, "{name}");
            }
        }
    }
}

#[test]
fn by_veil_inside_of_something_that_is_not_hollow() {
    // A sky sphere around the observer turns fog off unless it is hollow.
    let mut table = PrototypeTable::default();
    let dome = fragment(
        &mut table,
        "dome",
        Bounds::sphere(DVec3::ZERO, 100.0),
        "sphere { 0, 100 pigment { rgb <0.3,0.5,1> } }",
    );
    let ball = fragment(
        &mut table,
        "ball",
        Bounds::sphere(DVec3::ZERO, 1.0),
        "sphere { 0, 1 pigment { rgb 1 } }",
    );
    let dome_truth = neutral(
        &mut table,
        "t0",
        [1.0; 3],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 100.0,
        },
    );
    let ball_truth = neutral(
        &mut table,
        "t1",
        [1.0; 3],
        Csg::Sphere {
            centre: DVec3::ZERO,
            radius: 1.0,
        },
    );
    let with = |a, b| scene(view(), vec![at(a, 0.0, 0.0, 0.0), at(b, 0.5, 0.5, 0.0)]);
    let layer = depth(&table, &with(dome, ball), LayerSource::StateFile);
    let (error, beyond, silhouette) = compare(&layer, &table, &with(dome_truth, ball_truth));
    assert!(error <= 1e-6 && beyond <= 1.5, "{error:e}, {beyond} quanta");
    assert_eq!(silhouette, 0);
}

//! The adapter as the core sees it: errors, files, health.

mod common;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use common::{Stage, glowing, lamp, painted, run, size, sphere};
use decor_api::{
    Adapter, AdapterError, Baseline, Blocks, Bounds, Fragment, Geometry, Instance, NativeFile,
    Optics, Output, PictureFormat, Pose, Prototype, PrototypeId, Region, RunContext, Window,
};
use decor_reference::Reference;
use glam::DVec3;

fn native(name: &str) -> NativeFile {
    NativeFile {
        path: PathBuf::from("film").join(name),
        root: PathBuf::from("film"),
        text: b"union { }".to_vec(),
    }
}

fn whole(stage: &Stage) -> Result<(), AdapterError> {
    let size = size(8, 8);
    let request = stage.request(
        size,
        Output::ColourOverBackground,
        None,
        Region::Window(size.window()),
    );
    let text = Reference::new().scene_text(&request);
    let drawn = Reference::new().render(&request, &run());
    assert_eq!(text.is_ok(), drawn.is_ok(), "both halves agree");
    if let Ok(text) = text {
        assert!(text.files.is_empty());
    }
    drawn.map(|_| ())
}

fn assert_names(result: Result<impl std::fmt::Debug, AdapterError>, name: &str) {
    let error = result.unwrap_err();
    assert!(matches!(error, AdapterError::Unsupported { .. }), "{error}");
    assert!(error.to_string().contains(name), "{error}");
}

#[test]
fn what_it_cannot_draw_is_named() {
    let mut stage = Stage::of([]);
    assert!(whole(&stage).is_ok());
    let file = native("ship.inc");
    let fragment = Fragment {
        file: file.clone(),
        language: "inc".to_owned(),
    };
    let prototype = stage.prototypes.insert(Prototype {
        extents: Vec::new(),
        path: PathBuf::from("ship.inc"),
        hash: "a fragment".to_owned(),
        geometry: Geometry::Fragment(fragment.clone()),
        bounds: Bounds::Unbounded,
        optics: Optics::Opaque,
        unlayerable: None,
    });
    assert!(whole(&stage).is_ok(), "nobody uses it");
    let pose = Pose::IDENTITY;
    stage.scene.instances.push(Instance { prototype, pose });
    assert_names(whole(&stage), "ship.inc");

    stage.scene.instances[0].prototype = PrototypeId(99);
    assert_names(whole(&stage), "99");

    let mut stage = Stage::of([]);
    stage.scene.sky = Some(native("fog.inc"));
    assert_names(whole(&stage), "fog.inc");
    stage.scene.includes.push(native("colours.inc"));
    assert_names(whole(&stage), "colours.inc");

    let adapter = Reference::new();
    assert_names(adapter.inspect(&[&fragment], &[], &run()), "ship.inc");
    assert_eq!(adapter.inspect(&[], &[], &run()).unwrap(), []);
    assert_names(adapter.surroundings(&[], Some(&file)), "ship.inc");
    assert!(adapter.surroundings(&[], None).is_ok());
}

#[test]
fn what_is_outside_of_the_picture_is_an_error() {
    let stage = Stage::of([]);
    let draw = |region| {
        let request = stage.request(size(40, 40), Output::Depth, None, region);
        Reference::new().render(&request, &run())
    };
    let window = |x, width| {
        Region::Window(Window {
            x,
            y: 0,
            width,
            height: 1,
        })
    };
    assert!(draw(window(39, 1)).is_ok());
    assert!(draw(window(39, 2)).is_err());
    assert!(draw(Region::Window(Window::EMPTY)).is_ok());
    assert!(draw(Region::Blocks(Blocks::usual(vec![3]))).is_ok());
    assert_names(draw(Region::Blocks(Blocks::usual(vec![4]))), "block 4");
}

#[test]
fn it_stops_when_asked_and_when_late() {
    let stage = Stage::of([sphere(0.0, 0.0, 0.0, 1.0)]);
    let size = size(64, 64);
    let request = stage.request(size, Output::Depth, None, Region::Window(size.window()));
    let stopped = run();
    stopped.cancel.store(true, Ordering::Relaxed);
    let error = Reference::new().render(&request, &stopped).unwrap_err();
    assert!(matches!(error, AdapterError::Cancelled));
    let mut late = run();
    late.timeout = Duration::ZERO;
    let error = Reference::new().render(&request, &late).unwrap_err();
    assert!(matches!(error, AdapterError::TimedOut { .. }), "{error}");
}

#[test]
fn it_is_healthy_and_says_what_it_is() {
    let adapter = Reference::new();
    let health = adapter.health(&run());
    assert!(health.is_good(), "{health:?}");
    assert!(!health.checks.is_empty());
    assert_eq!(adapter.name(), "reference");
    let abilities = adapter.abilities();
    assert!(abilities.csg && abilities.depth_with_colour && abilities.block_mask);
    assert_eq!(abilities.crop_grid, Some(decor_reference::BLOCK));
}

#[test]
fn whole_frames_are_written_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let stage = Stage::of([painted(
        glowing([1.0, 0.214_041_14, 0.0]),
        sphere(0.0, 0.0, 0.0, 1.0),
    )])
    .lit(lamp(DVec3::Y * 9.0));
    let run = RunContext::new(folder.path());
    let size = size(9, 7);
    let scene = Arc::new(stage.scene.clone());
    let written = |format| {
        let request = Baseline {
            prototypes: &stage.prototypes,
            size,
            antialias: None,
            film: (4, 6),
            frames: vec![(4, scene.clone()), (5, scene.clone())],
            format,
        };
        let files = Reference::new().baseline(&request, &run).unwrap();
        assert_eq!(files.iter().map(|f| f.0).collect::<Vec<_>>(), [4, 5]);
        assert!(files.iter().all(|f| f.1.starts_with(folder.path())));
        files[1].1.clone()
    };
    let middle = 3 * 9 + 4;
    let decoded = |path: PathBuf| {
        let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut bytes).unwrap();
        bytes
    };
    let eight = decoded(written(PictureFormat::Png));
    assert_eq!(eight.len(), 9 * 7 * 3);
    assert_eq!(eight[middle * 3..][..3], [255, 128, 0]);
    let sixteen = decoded(written(PictureFormat::Png16));
    let encoded = Reference::new().encode(0.214_041_14, 65_535) as u16;
    assert_eq!(sixteen[middle * 6 + 2..][..2], encoded.to_be_bytes());

    let linear = exr::prelude::read_first_rgba_layer_from_file(
        written(PictureFormat::Exr),
        |size, _| vec![[0.0_f32; 3]; size.area()],
        |pixels: &mut Vec<[f32; 3]>, at, (r, g, b, _): (f32, f32, f32, f32)| {
            pixels[at.y() * 9 + at.x()] = [r, g, b];
        },
    )
    .unwrap();
    let pixels = linear.layer_data.channel_data.pixels;
    assert_eq!(pixels[middle], [1.0, 0.214_041_14, 0.0]);
    assert_eq!(pixels[0], [0.25, 0.5, 0.75]);
    assert_eq!(run.tally.read(), (3, 6));
}

#[test]
fn ten_thousand_instances() {
    let mut stage = Stage::of([sphere(0.0, 0.0, 0.0, 0.02)]);
    let one = stage.scene.instances[0];
    stage.scene.instances = (0..10_000)
        .map(|i| Instance {
            pose: Pose {
                position: DVec3::new(
                    f64::from(i % 100) * 0.05 - 2.475,
                    f64::from(i / 100) * 0.05 - 2.475,
                    f64::from(i % 7),
                ),
                ..Pose::IDENTITY
            },
            ..one
        })
        .collect();
    let stage = stage.lit(lamp(DVec3::new(5.0, 5.0, -20.0)));
    let started = Instant::now();
    let layer = stage.drawn(size(320, 240), Output::ColourOverBackground, None);
    // It takes 0.1 s; without a tree it would take minutes.
    assert!(started.elapsed() < Duration::from_secs(20));
    let seen = layer
        .depth
        .unwrap()
        .iter()
        .filter(|d| d.is_finite())
        .count();
    assert!(seen > 5_000, "{seen}");

    // All of them at one place: no box tells them apart.
    let mut stage = stage;
    for instance in &mut stage.scene.instances {
        instance.pose = Pose::IDENTITY;
    }
    let hit = stage.world().cast(DVec3::Z * -10.0, DVec3::Z).unwrap();
    assert_eq!(hit.instance, 0);
}

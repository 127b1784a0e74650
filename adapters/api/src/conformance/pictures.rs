//! Colour: what can be said of it without knowing how a renderer shades.

use std::path::Path;
use std::sync::Arc;

use glam::DVec3;

use super::Subject;
use super::stage::{
    BACKGROUND, Room, Stage, assert_part_of, colours, cuboid, drawn, dull, glowing, lamp, plane,
    sphere, whole,
};
use crate::adapter::{Adapter, Baseline, Output};
use crate::layer::Layer;
use crate::scene::PictureFormat;

const RED: [f64; 3] = [0.9, 0.25, 0.1];

fn glowing_ball() -> Stage {
    Stage::of([glowing(RED, sphere(0.5, 0.2, 0.0, 2.0))])
}

fn lit() -> Stage {
    Stage::of([
        dull(plane([0.0, 1.0, 0.0], -2.0)),
        dull(sphere(-1.0, 0.0, 0.0, 1.5)),
        glowing(RED, cuboid([1.5, -1.0, -1.0], [3.0, 1.0, 1.0])),
    ])
    .lit(lamp(4.0, 9.0, -8.0))
}

/// Every pixel whose ray certainly meets something, or certainly nothing.
fn certain(
    adapter: &dyn Adapter,
    stage: &Stage,
    layer: &Layer,
    mut look: impl FnMut([f32; 4], bool),
) {
    let oracle = stage.oracle();
    let position = adapter.abilities().sample_position;
    let mut seen = 0;
    for y in 0..stage.size.height {
        for x in 0..stage.size.width {
            if let Some((depth, _)) = oracle.certain(x, y, position) {
                look(colours(layer)[layer.index(x, y)], depth.is_finite());
                seen += 1;
            }
        }
    }
    assert!(seen > stage.size.pixels() * 9 / 10);
}

fn assert_close(found: [f32; 4], expected: [f64; 3], allowed: f64) {
    let near = |(found, expected): (&f32, f64)| (f64::from(*found) - expected).abs() <= allowed;
    let all = found.iter().zip(expected).all(near);
    assert!(all, "{found:?} is not {expected:?}");
}

/// What glows has its own colour, where it is and nowhere else.
pub fn colours_and_outlines_are_right(subject: &Subject) {
    let (adapter, stage) = (subject.adapter(), glowing_ball());
    let layer = stage.draw(&*adapter, Output::ColourOverBackground);
    certain(&*adapter, &stage, &layer, |pixel, there| {
        assert_close(pixel, if there { RED } else { BACKGROUND }, 1e-3);
        assert_eq!(pixel[3], 1.0, "the background covers");
    });
}

/// Without background: premultiplied colour, and nothing where nothing is.
pub fn objects_alone_leave_the_rest_empty(subject: &Subject) {
    let (adapter, stage) = (subject.adapter(), glowing_ball());
    let layer = stage.draw(&*adapter, Output::ColourAlone { with_sky: false });
    certain(&*adapter, &stage, &layer, |pixel, there| {
        assert_close(pixel, if there { RED } else { [0.0; 3] }, 1e-3);
        // Coverage may be left at 1 where nothing is: depth says so then.
        assert!(!there || pixel[3] == 1.0, "an object covers");
    });
}

/// One thread or four: the same bits.
pub fn threads_change_nothing(subject: &Subject) {
    let (adapter, stage) = (subject.adapter(), lit());
    for output in [Output::ColourOverBackground, Output::Depth] {
        let shots = vec![stage.shot(0, whole(stage.size))];
        let request = stage.request(output, shots);
        let with = |threads| {
            let mut room = Room::plain();
            room.run.threads = Some(threads);
            drawn(adapter.render(&request, &room.run)).remove(0)
        };
        assert_part_of(&with(1), &with(4), |_, _| true);
    }
}

/// Calls of one label, in one folder, at the same time.
pub fn calls_side_by_side_do_not_disturb_each_other(subject: &Subject) {
    let adapter = subject.adapter();
    let stages =
        [0.0, 1.0, 2.0, 3.0].map(|k| Stage::of([sphere(k - 1.5, 0.2 * k, 0.0, 1.0 + 0.2 * k)]));
    let room = Room::plain();
    std::thread::scope(|scope| {
        for stage in &stages {
            scope.spawn(|| {
                let shots = vec![stage.shot(0, whole(stage.size))];
                let request = stage.request(Output::Depth, shots);
                let layers = drawn(adapter.render(&request, &room.run));
                stage.oracle().assert_depth(&layers[0]);
            });
        }
    });
    room.assert_empty();
}

/// The renderer's own pictures are those that decor would write: the same
/// pixels, by the same encoding.
pub fn the_baseline_is_what_is_merged(subject: &Subject) {
    let adapter = subject.adapter();
    let stages: Vec<Stage> = (0..3)
        .map(|k| lit().seen_from(DVec3::new(f64::from(k), 1.0, -10.0), DVec3::ZERO))
        .collect();
    let first = &stages[0];
    let frames = (9_u32..).zip(&stages);
    let shots = frames.clone().map(|(n, s)| s.shot(n, whole(s.size)));
    let request = first.request(Output::ColourOverBackground, shots.collect());
    let layers = drawn(adapter.render(&request, &Room::plain().run));
    for format in [PictureFormat::Png, PictureFormat::Png16, PictureFormat::Exr] {
        let request = Baseline {
            prototypes: &first.prototypes,
            size: first.size,
            antialias: None,
            film: (0, 20),
            frames: frames
                .clone()
                .map(|(n, stage)| (n, Arc::new(stage.scene.clone())))
                .collect(),
            format,
        };
        let room = Room::plain();
        let files = drawn(adapter.baseline(&request, &room.run));
        let numbers: Vec<u32> = files.iter().map(|(n, _)| *n).collect();
        assert_eq!(numbers, [9, 10, 11]);
        for (layer, (_, file)) in layers.iter().zip(&files) {
            assert!(file.starts_with(&room.run.work), "{}", file.display());
            if format == PictureFormat::Exr {
                let bytes = std::fs::read(file).expect("the picture");
                assert!(bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]), "no OpenEXR");
                continue;
            }
            let (max, samples) = read_png(file, first.size.pixels());
            for (k, pixel) in colours(layer).iter().enumerate() {
                let expected = [0, 1, 2].map(|c| adapter.encode(pixel[c], max));
                let found = &samples[3 * k..][..3];
                assert_eq!(found, expected, "pixel {k} of frame {}", file.display());
            }
        }
    }
}

/// The largest value, and the colour channels of all pixels.
fn read_png(path: &Path, pixels: usize) -> (u32, Vec<u32>) {
    let file = std::io::BufReader::new(std::fs::File::open(path).expect("the picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut bytes = vec![0; reader.output_buffer_size().expect("its size")];
    let info = reader.next_frame(&mut bytes).expect("its pixels");
    let channels = info.color_type.samples();
    assert!(channels >= 3, "colour, not {:?}", info.color_type);
    assert_eq!(info.width as usize * info.height as usize, pixels);
    let (max, samples): (u32, Vec<u32>) = match info.bit_depth {
        png::BitDepth::Eight => (255, bytes.iter().map(|&b| u32::from(b)).collect()),
        png::BitDepth::Sixteen => {
            let pairs = bytes.as_chunks::<2>().0.iter();
            (
                65535,
                pairs.map(|&p| u32::from(u16::from_be_bytes(p))).collect(),
            )
        }
        other => panic!("{other:?} bits a channel"),
    };
    let colour = samples.chunks(channels).flat_map(|p| &p[..3]).copied();
    (max, colour.collect())
}

/// Black is 0, white is all there is, and brighter is never less.
pub fn the_encoding_rises_from_end_to_end(subject: &Subject) {
    let adapter = subject.adapter();
    for max in [255, 65535] {
        assert_eq!(adapter.encode(0.0, max), 0);
        assert_eq!(adapter.encode(1.0, max), max);
        assert_eq!(adapter.encode(-3.0, max), 0);
        assert_eq!(adapter.encode(f32::INFINITY, max), max);
        assert!(adapter.encode(f32::NAN, max) <= max);
        let mut before = 0;
        for k in 0..=4000_u16 {
            let step = adapter.encode(f32::from(k) / 4000.0, max);
            assert!(before <= step && step <= max, "at {k} of 4000");
            before = step;
        }
    }
}

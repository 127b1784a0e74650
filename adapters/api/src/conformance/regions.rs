//! Parts of a picture are parts of that picture.

use glam::DVec3;

use super::Subject;
use super::stage::{
    BACKGROUND, Room, Stage, assert_part_of, colours, cuboid, drawn, dull, glowing, lamp, plane,
    sphere, whole,
};
use crate::adapter::{AdapterError, Output, Region};
use crate::blocks::{BLOCK, Blocks};
use crate::csg::Csg;
use crate::layer::{Layer, Size, Window};
use crate::scene::{Antialias, Pose};

const ANTIALIAS: Antialias = Antialias {
    threshold: 0.1,
    depth: 2,
};

/// What is drawn, and with which antialiasing.
type Way = (Output, Option<Antialias>);

/// The passes that are compared.
const PASSES: [Way; 4] = [
    (Output::ColourOverBackground, None),
    (Output::ColourOverBackground, Some(ANTIALIAS)),
    (Output::ColourAlone { with_sky: false }, Some(ANTIALIAS)),
    (Output::Depth, None),
];

/// Some of everything, with edges in every part of the picture.
fn busy() -> Stage {
    let solids = [
        dull(plane([0.0, 1.0, 0.0], -2.0)),
        dull(sphere(-2.0, 0.0, 0.0, 1.5)),
        glowing([0.9, 0.3, 0.1], cuboid([1.0, -2.0, -1.0], [3.0, 1.0, 1.0])),
        dull(sphere(3.5, 2.5, 4.0, 1.0)),
    ];
    let mut stage = Stage::of(solids).lit(lamp(4.0, 9.0, -8.0));
    // Some blocks of 32 pixels, the last ones cut.
    stage.size = Size {
        width: 101,
        height: 75,
    };
    stage
}

fn window(x: u32, y: u32, width: u32, height: u32) -> Window {
    Window {
        x,
        y,
        width,
        height,
    }
}

/// Where nothing is, nothing comes back: no objects, a solid without parts, all
/// of them out of the picture.
pub fn what_is_empty_is_empty(subject: &Subject) {
    let adapter = subject.adapter();
    let mut stage = Stage::empty();
    let mut shots = vec![stage.shot(0, whole(stage.size))];
    let nowhere = [
        Csg::Union(Vec::new()),
        glowing([1.0; 3], sphere(0.0, 0.0, -20.0, 2.0)),
        sphere(80.0, 0.0, 0.0, 1.0),
    ];
    for solid in nowhere {
        stage.add(solid, Pose::IDENTITY);
        shots.push(stage.shot(1, whole(stage.size)));
    }
    let draw = |output| {
        let request = stage.request(output, shots.clone());
        drawn(adapter.render(&request, &Room::plain().run))
    };
    for layer in draw(Output::Depth) {
        let depths = layer.depth.expect("depth was asked for");
        assert_eq!(depths.len(), stage.size.pixels());
        let nothing = depths.iter().all(|&d| d == f64::INFINITY);
        assert!(nothing, "nothing is there");
    }
    for layer in draw(Output::ColourOverBackground) {
        for pixel in colours(&layer) {
            for (channel, expected) in pixel.iter().zip(BACKGROUND) {
                let off = (f64::from(*channel) - expected).abs();
                assert!(off < 1e-4, "{pixel:?} is not the background");
            }
            assert_eq!(pixel[3], 1.0, "the background covers");
        }
    }
    for layer in draw(Output::ColourAlone { with_sky: false }) {
        let dark = |p: &[f32; 4]| p[..3].iter().all(|&c| c == 0.0);
        assert!(colours(&layer).iter().all(dark), "there is no background");
    }
    let room = Room::plain();
    let none = stage.request(Output::Depth, Vec::new());
    let layers = drawn(adapter.render(&none, &room.run));
    assert!(layers.is_empty(), "no shots are no layers");
    room.assert_empty();
}

/// A window without a pixel is a layer without a pixel, among others.
pub fn an_empty_window_is_a_layer(subject: &Subject) {
    let stage = busy();
    let windows = [window(3, 20, 60, 40), Window::EMPTY, window(60, 25, 9, 30)];
    for output in [Output::Depth, Output::ColourOverBackground] {
        let shots = windows.map(|w| stage.shot(0, Region::Window(w))).to_vec();
        let request = stage.request(output, shots);
        let layers = drawn(subject.adapter().render(&request, &Room::plain().run));
        assert_eq!(layers.len(), windows.len());
        for (layer, window) in layers.iter().zip(windows) {
            assert_eq!(layer.window, window);
            if output == Output::Depth && !window.is_empty() {
                stage.oracle().assert_depth(layer);
            }
            let lengths = [
                layer.colour.as_ref().map(Vec::len),
                layer.depth.as_ref().map(Vec::len),
            ];
            for length in lengths.into_iter().flatten() {
                assert_eq!(length, window.pixels());
            }
        }
    }
}

/// A window at any place shows what is there, also one of a single pixel.
pub fn windows_are_where_they_say(subject: &Subject) {
    let stage = busy();
    let windows = [
        window(13, 7, 50, 41),
        window(0, 30, 101, 9),
        window(100, 74, 1, 1),
        window(39, 21, 62, 54),
    ];
    let shots = windows.map(|w| stage.shot(0, Region::Window(w))).to_vec();
    let room = Room::plain();
    let request = stage.request(Output::Depth, shots);
    let layers = drawn(subject.adapter().render(&request, &room.run));
    for (layer, window) in layers.iter().zip(windows) {
        assert_eq!(layer.window, window);
        stage.oracle().assert_depth(layer);
    }
    assert_eq!(layers.len(), windows.len());
}

/// On the declared grid a window has the full frame's very values.
pub fn crops_on_the_grid_are_identical(subject: &Subject) {
    let adapter = subject.adapter();
    let Some(grid) = adapter.abilities().crop_grid else {
        return;
    };
    assert!(grid > 0, "a grid of no pixels");
    let stage = busy();
    // One that touches no edge of the picture where the grid allows it, a tall
    // one and a wide one.
    let windows = [
        window(37, 35, 17, 9),
        window(70, 3, 1, 44),
        window(2, 66, 67, 2),
    ]
    .map(|window| window.on_grid(grid, stage.size));
    let windows = windows.map(Region::Window).to_vec();
    compare(subject, &stage, &PASSES, windows, |_, _| true);
}

/// A set of blocks alone has the full frame's very values in these blocks.
pub fn blocks_are_identical(subject: &Subject) {
    let adapter = subject.adapter();
    let abilities = adapter.abilities();
    let stage = busy();
    if !abilities.block_mask {
        // The window around them, slower, is right too.
        let region = Region::Blocks(Blocks::usual(vec![1, 4]));
        match stage.draw_with(&*adapter, Output::Depth, region, None) {
            Err(AdapterError::Unsupported { .. }) => return,
            Err(error) => panic!("blocks are refused, but not as unsupported: {error}"),
            Ok(_) => {}
        }
    }
    assert!(abilities.crop_grid.is_some(), "blocks are those of a grid");
    same_in_blocks(subject, &stage, &PASSES, BLOCK);
    let plain = PASSES.map(|pass| pass.1.is_none().then_some(pass));
    let plain: Vec<Way> = plain.into_iter().flatten().collect();
    let sides = [1, 2, 4, 8, 16].into_iter();
    for side in sides.filter(|side| *side >= abilities.finest_block) {
        same_in_blocks(subject, &stage, &plain, side);
    }
}

fn same_in_blocks(subject: &Subject, stage: &Stage, passes: &[Way], side: u32) {
    let columns = stage.size.width.div_ceil(side);
    let count = columns * stage.size.height.div_ceil(side);
    let numbers = (0..count).filter(|k| k % 5 == 1 || k % 7 == 4).collect();
    let blocks = Blocks { side, numbers };
    let wanted = &blocks.numbers;
    let inside = |x: u32, y: u32| wanted.contains(&(y / side * columns + x / side));
    let regions = vec![Region::Blocks(blocks.clone())];
    for part in compare(subject, stage, passes, regions, inside) {
        for k in wanted {
            let (x, y) = (k % columns * side, k / columns * side);
            assert!(
                part.window.contains(x, y),
                "block {k} is outside of the layer"
            );
        }
    }
}

/// Draws the whole and the regions, and compares what is `wanted`.
fn compare(
    subject: &Subject,
    stage: &Stage,
    passes: &[Way],
    regions: Vec<Region>,
    wanted: impl Fn(u32, u32) -> bool,
) -> Vec<Layer> {
    let adapter = subject.adapter();
    let mut all = Vec::new();
    for &(output, antialias) in passes {
        let full = drawn(stage.draw_with(&*adapter, output, whole(stage.size), antialias));
        let shots = regions.iter().map(|r| stage.shot(1, r.clone())).collect();
        let mut request = stage.request(output, shots);
        request.antialias = antialias;
        let parts = drawn(adapter.render(&request, &Room::plain().run));
        assert_eq!(parts.len(), regions.len());
        for part in parts {
            assert_part_of(&part, &full, &wanted);
            all.push(part);
        }
    }
    all
}

/// Many frames in one call, each another scene and window: in the request's
/// order, whatever their numbers.
pub fn a_batch_comes_back_in_order(subject: &Subject) {
    let stages: Vec<Stage> = (0..7)
        .map(|k| {
            let mut stage = busy();
            stage.scene.camera = super::stage::camera(
                DVec3::new(f64::from(k) - 3.0, 1.0, -10.0),
                DVec3::new(0.0, 0.3 * f64::from(k), 0.0),
            );
            stage
        })
        .collect();
    let frames = [12, 3, 4, 100_000, 0, 5, 6];
    let mut shots = Vec::new();
    for (k, (stage, frame)) in (0_u32..).zip(stages.iter().zip(frames)) {
        shots.push(stage.shot(frame, Region::Window(window(4 * k, 3 * k, 60 + k, 50 - k))));
    }
    let request = stages[0].request(Output::Depth, shots);
    let room = Room::plain();
    let layers = drawn(subject.adapter().render(&request, &room.run));
    assert_eq!(layers.len(), stages.len());
    for ((stage, layer), k) in stages.iter().zip(&layers).zip(0_u32..) {
        assert_eq!(layer.window, window(4 * k, 3 * k, 60 + k, 50 - k));
        stage.oracle().assert_depth(layer);
    }
    room.assert_empty();
}

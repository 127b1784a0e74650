//! A pixel is the same whatever is rendered with it.

mod common;

use common::{Stage, glowing, lamp, painted, plane, run, size, sphere, vec3, white};
use decor_api::{
    Adapter, Antialias, Blocks, Highlight, Layer, Light, LightKind, Material, Output, Region, Rgb,
    Size, Window,
};
use decor_reference::{BLOCK, Reference};
use glam::DVec3;

const SIZE: Size = Size {
    width: 75,
    height: 70,
};

const FINE: Option<Antialias> = Some(Antialias {
    threshold: 0.05,
    depth: 3,
});

/// Shadows, a penumbra, a mirror, glass and many edges.
fn busy() -> Stage {
    let mirror = Material {
        reflection: 0.5,
        highlight: Highlight::Phong {
            amount: 0.8,
            size: 40.0,
        },
        ..Material::default()
    };
    let glass = Material {
        transmission: 0.8,
        ior: 1.5,
        ..Material::default()
    };
    let mut trees = vec![
        painted(white(), plane(DVec3::Y, -2.0)),
        painted(mirror, sphere(-1.5, 0.0, 1.0, 1.4)),
        painted(glass, sphere(1.6, 0.0, -1.0, 1.2)),
    ];
    for i in 0..12 {
        let x = f64::from(i) * 0.6 - 3.3;
        trees.push(painted(
            glowing([0.1 * f64::from(i), 0.4, 0.2]),
            sphere(x, 2.5, 3.0, 0.2),
        ));
    }
    Stage::of(trees).lit(lamp(vec3(5.0, 8.0, -8.0))).lit(Light {
        position: vec3(-6.0, 6.0, -6.0),
        colour: Rgb([0.4, 0.3, 0.2]),
        kind: LightKind::Area {
            u: DVec3::X * 2.0,
            v: DVec3::Z * 2.0,
            nu: 3,
            nv: 3,
        },
        fade: None,
    })
}

fn draw(stage: &Stage, output: Output, antialias: Option<Antialias>, region: Region) -> Layer {
    let request = stage.request(SIZE, output, antialias, region);
    Reference::new().render(&request, &run()).unwrap().remove(0)
}

/// The bits: NaN and −0 would not hide.
fn bits(layer: &Layer, x: u32, y: u32) -> ([u32; 4], u64) {
    let i = layer.index(x, y);
    let colour = layer.colour.as_ref().map_or([0.0; 4], |c| c[i]);
    let depth = layer.depth.as_ref().map_or(0.0, |d| d[i]);
    (colour.map(f32::to_bits), depth.to_bits())
}

const PASSES: [(Output, Option<Antialias>); 5] = [
    (Output::ColourOverBackground, FINE),
    (Output::ColourOverBackground, None),
    (Output::ColourAlone { with_sky: false }, FINE),
    (Output::ColourAlone { with_sky: true }, None),
    (Output::Depth, FINE),
];

#[test]
fn a_window_is_the_full_frame_s() {
    let stage = busy();
    for (output, antialias) in PASSES {
        let whole = draw(&stage, output, antialias, Region::Window(SIZE.window()));
        for (x, y, width, height) in [
            (0, 0, 32, 32),
            (32, 32, 43, 38),
            (17, 29, 3, 1),
            (74, 69, 1, 1),
            (20, 0, 1, 70),
        ] {
            let window = Window {
                x,
                y,
                width,
                height,
            };
            let part = draw(&stage, output, antialias, Region::Window(window));
            assert_eq!(part.window, window);
            for y in window.y..window.bottom() {
                for x in window.x..window.right() {
                    assert_eq!(
                        bits(&part, x, y),
                        bits(&whole, x, y),
                        "({x}, {y}) {output:?}"
                    );
                }
            }
        }
    }
}

#[test]
fn blocks_are_the_full_frame_s() {
    let stage = busy();
    let blocks = vec![1, 3, 4, 8];
    for (output, antialias) in PASSES {
        let whole = draw(&stage, output, antialias, Region::Window(SIZE.window()));
        let some = draw(
            &stage,
            output,
            antialias,
            Region::Blocks(Blocks::usual(blocks.clone())),
        );
        assert_eq!(some.window, SIZE.window());
        let mut seen = 0;
        for y in 0..SIZE.height {
            for x in 0..SIZE.width {
                if blocks.contains(&(y / BLOCK * 3 + x / BLOCK)) {
                    seen += 1;
                    assert_eq!(bits(&some, x, y), bits(&whole, x, y), "({x}, {y})");
                }
            }
        }
        assert_eq!(seen, 32 * 32 * 3 + 11 * 6);
    }
    let last = draw(
        &stage,
        Output::Depth,
        None,
        Region::Blocks(Blocks::usual(vec![8])),
    );
    assert_eq!(last.window.pixels(), 11 * 6);
    let none = draw(
        &stage,
        Output::Depth,
        None,
        Region::Blocks(Blocks::usual(Vec::new())),
    );
    assert_eq!(none.depth, Some(Vec::new()));
}

#[test]
fn any_number_of_threads_gives_the_same() {
    let stage = busy();
    let region = Region::Window(SIZE.window());
    let request = stage.request(SIZE, Output::ColourOverBackground, FINE, region);
    let drawn = |threads| {
        let mut run = run();
        run.threads = threads;
        Reference::new().render(&request, &run).unwrap()
    };
    let one = drawn(Some(1));
    for threads in [Some(0), Some(2), Some(7), None] {
        assert_eq!(drawn(threads), one, "{threads:?}");
    }
}

#[test]
fn depth_does_not_change_with_what_else_is_asked() {
    let stage = busy();
    let depth = draw(&stage, Output::Depth, None, Region::Window(SIZE.window())).depth;
    for (output, antialias) in PASSES {
        let layer = draw(&stage, output, antialias, Region::Window(SIZE.window()));
        assert_eq!(layer.depth, depth);
    }
}

#[test]
fn a_hidden_object_changes_nothing() {
    let mut stage = Stage::of([painted(white(), plane(-DVec3::Z, 0.0))]).lit(lamp(DVec3::Z * -9.0));
    let before = stage.drawn(size(40, 40), Output::ColourOverBackground, FINE);
    stage.add(sphere(0.0, 0.0, 5.0, 2.0), decor_api::Pose::IDENTITY);
    let after = stage.drawn(size(40, 40), Output::ColourOverBackground, FINE);
    assert_eq!(before.colour, after.colour);
}

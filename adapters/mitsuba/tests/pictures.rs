//! Mitsuba's pictures against the ray caster's: where things are, how far, and
//! where parallel light falls, which both know in the same unit.

mod common;

use common::{Stage, apart, colours, depths, lamp, mitsuba};
use decor_api::{Blocks, Output, Region, Window};
use decor_reference::Reference;

/// How many pixels see something in one picture and nothing in the other.
fn silhouette(a: &[f64], b: &[f64]) -> usize {
    let pair = a.iter().zip(b);
    pair.filter(|(a, b)| a.is_finite() != b.is_finite()).count()
}

/// Relative differences where both see something, sorted.
fn off(a: &[f64], b: &[f64]) -> Vec<f64> {
    let pair = a.iter().zip(b);
    let both = pair.filter(|(a, b)| a.is_finite() && b.is_finite());
    let mut off: Vec<f64> = both.map(|(a, b)| (a / b - 1.0).abs()).collect();
    off.sort_by(f64::total_cmp);
    off
}

#[test]
fn depth_is_that_of_the_ray_caster() {
    let mut stage = Stage::empty();
    stage.exact_shapes();
    let (a, b) = (
        stage.draw(&mitsuba(), Output::Depth),
        stage.draw(&Reference::new(), Output::Depth),
    );
    assert_eq!(silhouette(depths(&a), depths(&b)), 0);
    let off = off(depths(&a), depths(&b));
    println!(
        "depth: median {:e}, worst {:?}",
        off[off.len() / 2],
        &off[off.len() - 12..]
    );
    assert!(off[off.len() / 2] < 5e-7);
    let beyond = off.iter().filter(|o| **o > 1e-5).count();
    // A ray's direction is single precision: what it meets at a flat angle, far
    // out on the floor, is not better than that.
    assert!(beyond * 400 <= off.len(), "{beyond} of {}", off.len());
    assert!(off[off.len() - 1] < 1e-4);
}

#[test]
fn meshes_stand_where_their_solids_do() {
    let mut stage = Stage::empty();
    stage.meshed_shapes();
    let (a, b) = (
        stage.draw(&mitsuba(), Output::Depth),
        stage.draw(&Reference::new(), Output::Depth),
    );
    let (a, b) = (depths(&a), depths(&b));
    println!("silhouette: {} of {}", silhouette(a, b), a.len());
    assert!(silhouette(a, b) * 2000 <= a.len());
    let off = off(a, b);
    println!(
        "depth: median {:e}, worst {:?}",
        off[off.len() / 2],
        &off[off.len() - 12..]
    );
    let beyond = off.iter().filter(|o| **o > 1e-4).count();
    println!("{beyond} of {}", off.len());
    assert!(beyond * 40 <= off.len());
}

#[test]
fn parallel_light_falls_as_in_the_ray_caster() {
    for shadows in [true, false] {
        let mut stage = Stage::empty();
        stage.exact_shapes();
        stage.scene.shadows = shadows;
        for output in [
            Output::ColourOverBackground,
            Output::ColourAlone { with_sky: false },
        ] {
            let (a, b) = (
                stage.draw(&mitsuba(), output),
                stage.draw(&Reference::new(), output),
            );
            let apart = apart(&a, &b);
            let beyond = apart.iter().filter(|d| **d > 1e-3).count();
            println!(
                "shadows {shadows}: {beyond} of {} pixels are apart",
                apart.len()
            );
            // Where a shadow's edge, or the day's, goes through a pixel's centre.
            assert!(beyond * 200 <= apart.len(), "{beyond} of {}", apart.len());
        }
    }
}

#[test]
fn without_shadows_nothing_is_dark_that_faces_the_light() {
    let mut stage = Stage::empty();
    stage.exact_shapes();
    stage.scene.shadows = false;
    stage.scene.lights = vec![lamp()];
    let (a, b) = (
        stage.draw(&mitsuba(), Output::ColourOverBackground),
        stage.draw(&Reference::new(), Output::ColourOverBackground),
    );
    // The fall-off is not the same: only what is lit at all is compared.
    stage.scene.lights.clear();
    let dark = stage.draw(&Reference::new(), Output::ColourOverBackground);
    let lit =
        |layer: &decor_api::Layer, k: usize| colours(layer)[k][0] > colours(&dark)[k][0] + 1e-6;
    // Far out on the floor there is nothing left of it.
    let near = 12 * stage.size.width as usize;
    let wrong = (near..colours(&a).len()).filter(|&k| lit(&a, k) != lit(&b, k));
    let wrong = wrong.count();
    println!("{wrong} pixels");
    assert_eq!(wrong, 0);
}

#[test]
fn blocks_are_the_whole_pictures_own() {
    for (shadows, depth) in [(true, None), (false, Some(2))] {
        let mut stage = Stage::empty();
        stage.exact_shapes();
        stage.scene.shadows = shadows;
        stage.scene.lights.push(lamp());
        stage.antialias = depth.map(|depth| decor_api::Antialias {
            threshold: 0.1,
            depth,
        });
        let mitsuba = mitsuba();
        for output in [Output::ColourOverBackground, Output::Depth] {
            let whole = stage.draw(&mitsuba, output);
            let blocks = vec![0, 8, 9, 16, 34];
            let part = stage
                .try_draw(
                    &mitsuba,
                    output,
                    Region::Blocks(Blocks::usual(blocks.clone())),
                )
                .unwrap();
            assert_eq!(part.window, stage.size.window());
            for y in 0..stage.size.height {
                for x in 0..stage.size.width {
                    if blocks.contains(&(y / 32 * 7 + x / 32)) {
                        let k = whole.index(x, y);
                        assert_eq!(
                            whole.colour.as_ref().map(|c| c[k]),
                            part.colour.as_ref().map(|c| c[k]),
                            "({x}, {y})"
                        );
                        assert_eq!(
                            whole.depth.as_ref().map(|d| d[k]),
                            part.depth.as_ref().map(|d| d[k]),
                            "({x}, {y})"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn a_window_is_nearly_the_whole_pictures_own() {
    let mut stage = Stage::empty();
    stage.exact_shapes();
    let mitsuba = mitsuba();
    let window = Window {
        x: 37,
        y: 41,
        width: 90,
        height: 61,
    };
    let alone = Output::ColourAlone { with_sky: false };
    let whole = (
        stage.draw(&mitsuba, alone),
        stage.draw(&mitsuba, Output::Depth),
    );
    let part = |output| {
        let layer = stage.try_draw(&mitsuba, output, Region::Window(window));
        layer.unwrap()
    };
    let part = (part(alone), part(Output::Depth));
    let (mut apart, mut seen) = (0, 0);
    for y in window.y..window.bottom() {
        for x in window.x..window.right() {
            let (k, i) = (whole.0.index(x, y), part.0.index(x, y));
            let (a, b) = (colours(&whole.0)[k], colours(&part.0)[i]);
            let far = a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-5);
            let (a, b) = (depths(&whole.1)[k], depths(&part.1)[i]);
            let moved = a != b && (a / b - 1.0).abs() > 1e-5;
            apart += usize::from(far || moved);
            seen += usize::from(a.is_finite());
        }
    }
    println!("{apart} of {}", window.pixels());
    assert!(seen > window.pixels() / 2);
    assert!(apart * 200 <= window.pixels(), "{apart}");
}

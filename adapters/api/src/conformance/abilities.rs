//! What an adapter says of itself is true.

use std::sync::Arc;

use glam::DVec3;

use super::Subject;
use super::stage::{
    Room, Stage, colours, cuboid, drawn, dull, glowing, lamp, plane, sphere, whole,
};
use crate::adapter::{AdapterError, Output};
use crate::arrival::{ArrivalRequest, ArrivalShot, SurfacePoint};
use crate::csg::Csg;
use crate::layer::Layer;
use crate::material::Material;
use crate::scene::{Antialias, Instance, Rgb};

const COLOUR: Output = Output::ColourOverBackground;
const RED: [f64; 3] = [0.9, 0.1, 0.1];

/// A ball over a floor, a light above, seen from aslant.
fn ball_and_floor() -> Stage {
    Stage::of([
        dull(plane([0.0, 1.0, 0.0], -1.0)),
        dull(sphere(0.0, 1.5, 0.0, 1.0)),
    ])
    .lit(lamp(0.0, 30.0, 0.0))
    .seen_from(DVec3::new(0.0, 4.0, -9.0), DVec3::ZERO)
}

/// A point of the floor in the ball's shadow that the camera sees, and one in
/// the light.
const IN_SHADOW: DVec3 = DVec3::new(0.0, -1.0, -0.4);
const IN_LIGHT: DVec3 = DVec3::new(3.0, -1.0, -0.4);

fn brightness(stage: &Stage, layer: &Layer, point: DVec3) -> f64 {
    let pixel = stage.colour_at(layer, point);
    pixel[..3].iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0
}

fn assert_refused<T>(result: Result<T, AdapterError>, what: &str) {
    match result {
        Err(AdapterError::Unsupported { .. }) => {}
        Err(other) => panic!("{what}: not declared, and the refusal is not typed: {other}"),
        Ok(_) => panic!("{what}: not declared, and yet something was drawn"),
    }
}

/// Two layers whose colours agree to a hair.
fn assert_alike(a: &Layer, b: &Layer) {
    for (a, b) in colours(a).iter().zip(colours(b)) {
        let near = a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4);
        assert!(near, "{a:?} and {b:?}");
    }
}

/// Nothing is left empty, and no number is out of its range.
pub fn abilities_are_plausible(subject: &Subject) {
    let adapter = subject.adapter();
    let name = adapter.name();
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
    assert!(!name.is_empty() && name.chars().all(plain), "name `{name}`");
    let abilities = adapter.abilities();
    assert!(!abilities.version.trim().is_empty(), "no version");
    assert!(!abilities.units.trim().is_empty(), "no units");
    assert!(abilities.jobs >= 1, "no job at all");
    let (right, down) = abilities.sample_position;
    assert!((0.0..=1.0).contains(&right) && (0.0..=1.0).contains(&down));
    for overhead in [abilities.call_overhead_s, abilities.picture_cpu_s] {
        assert!((0.0..600.0).contains(&overhead), "{overhead} s");
    }
    assert_ne!(abilities.crop_grid, Some(0));
    let blocks_have_a_grid = !abilities.block_mask || abilities.crop_grid.is_some();
    assert!(blocks_have_a_grid, "blocks, of which grid?");
    let finest = abilities.finest_block;
    assert!(
        finest > 0 && crate::BLOCK.is_multiple_of(finest),
        "blocks of {finest}"
    );
    for ending in abilities.fragments {
        assert!(!ending.is_empty() && !ending.starts_with('.'), "`{ending}`");
    }
}

/// What `decor doctor` shows.
pub fn the_renderer_is_healthy(subject: &Subject) {
    let (adapter, room) = (subject.adapter(), Room::plain());
    let health = adapter.health(&room.run);
    assert!(!health.checks.is_empty(), "nothing was tried");
    assert!(health.is_good(), "{:?}", health.checks);
    assert_eq!(
        health.version.as_deref(),
        Some(&*adapter.abilities().version)
    );
    assert!(
        !health.install.trim().is_empty(),
        "no word on installing it"
    );
    room.assert_empty();
}

/// Trees with curved surfaces where CSG is declared; else right or refused.
pub fn csg_is_drawn_or_refused(subject: &Subject) {
    let adapter = subject.adapter();
    let block = cuboid([-2.0, -1.5, -1.0], [2.0, 1.5, 1.0]);
    let bitten = Csg::Difference(
        Box::new(block.clone()),
        vec![sphere(-1.5, 1.2, -1.0, 1.0), sphere(1.0, 0.0, -1.4, 0.9)],
    );
    let lens = Csg::Intersection(vec![
        sphere(0.0, 0.0, -2.5, 1.5),
        Csg::Rotate(
            DVec3::new(20.0, 30.0, 0.0),
            Box::new(plane([0.0, 1.0, 0.3], 0.2)),
        ),
    ]);
    let scaled = Csg::Scale(
        DVec3::new(1.5, 0.5, 1.0),
        Box::new(Csg::Union(vec![block, sphere(2.5, 3.0, 0.0, 0.8)])),
    );
    for solid in [bitten, lens, scaled] {
        let stage =
            Stage::of([solid]).seen_from(DVec3::new(-2.0, 3.0, -8.0), DVec3::new(0.3, 0.0, 0.0));
        match stage.try_draw(&*adapter, Output::Depth) {
            Ok(layer) => stage.oracle().assert_depth(&layer),
            refused if !adapter.abilities().csg => assert_refused(refused, "CSG"),
            Err(error) => panic!("CSG is declared: {error}"),
        }
    }
}

/// A shadow is there, or the picture is the one without.
pub fn shadows_are_cast_as_declared(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = ball_and_floor();
    let mut plain = stage.clone();
    plain.scene.shadows = false;
    let (with, without) = (stage.draw(&*adapter, COLOUR), plain.draw(&*adapter, COLOUR));
    if !adapter.abilities().shadows {
        assert_alike(&with, &without);
        return;
    }
    let at = |layer: &Layer, point| brightness(&stage, layer, point);
    let lit = at(&without, IN_LIGHT);
    assert!(lit > 0.01, "the floor is dark in the light: {lit}");
    let off = (at(&with, IN_LIGHT) - lit).abs();
    assert!(
        off < 1e-3 * lit,
        "shadows change the light elsewhere by {off}"
    );
    let (dark, open) = (at(&with, IN_SHADOW), at(&without, IN_SHADOW));
    assert!(
        dark < 0.1 * open,
        "in the shadow {dark}, without one {open}"
    );
}

/// What is hidden casts its shadow, and is not seen; or is refused.
pub fn hidden_casters_are_hidden_or_refused(subject: &Subject) {
    let adapter = subject.adapter();
    let shown = ball_and_floor();
    let mut stage = shown.clone();
    let ball = stage.scene.instances.pop().expect("the ball");
    let floor = stage.clone();
    stage.scene.hidden.push(ball);
    // Depth takes no notice of what is hidden, whatever is declared.
    if adapter.abilities().hidden_casters {
        floor
            .oracle()
            .assert_depth(&stage.draw(&*adapter, Output::Depth));
    } else {
        assert_refused(stage.try_draw(&*adapter, COLOUR), "hidden casters");
        return;
    }
    let hidden = stage.draw(&*adapter, COLOUR);
    let alone = floor.draw(&*adapter, COLOUR);
    let shadowed = shown.draw(&*adapter, COLOUR);
    let in_shadow = brightness(&stage, &hidden, IN_SHADOW);
    let expected = brightness(&shown, &shadowed, IN_SHADOW);
    assert!(
        (in_shadow - expected).abs() < 1e-3,
        "{in_shadow}, not {expected}"
    );
    // Through the ball's place the floor behind it is seen as if it were alone.
    let through = DVec3::new(0.0, 1.5, 0.0);
    let (seen, floor) = (
        brightness(&stage, &hidden, through),
        brightness(&floor, &alone, through),
    );
    assert!((seen - floor).abs() < 1e-3, "{seen}, not {floor}");
}

/// A mirror shows what is behind the observer, or is dull.
pub fn mirrors_are_drawn_as_declared(subject: &Subject) {
    let adapter = subject.adapter();
    let wall = |reflection| {
        let look = Material {
            colour: Rgb([1.0; 3]),
            ambient: 0.0,
            diffuse: 0.0,
            reflection,
            ..Material::default()
        };
        let wall = Csg::Look(look, Box::new(cuboid([-9.0, -9.0, 5.0], [9.0, 9.0, 6.0])));
        Stage::of([wall, glowing(RED, sphere(0.0, 3.0, -5.0, 1.0))])
            .seen_from(DVec3::ZERO, DVec3::Z)
    };
    let (mirror, dull) = (wall(1.0), wall(0.0));
    let drawn = mirror.draw(&*adapter, COLOUR);
    if !adapter.abilities().optics {
        assert_alike(&drawn, &dull.draw(&*adapter, COLOUR));
        return;
    }
    // The ball's image is as far behind the mirror as it is before it.
    let [r, g, b, _] = mirror.colour_at(&drawn, DVec3::new(0.0, 3.0, 15.0));
    assert!(r > 0.5 && g < 0.3 && b < 0.3, "no image: {:?}", [r, g, b]);
}

/// Antialiased edges cover their pixels in part, by as much as is true.
pub fn coverage_is_stated_as_declared(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = Stage::of([glowing(RED, sphere(0.0, 0.0, 0.0, 2.0))]);
    let antialias = Antialias {
        threshold: 0.05,
        depth: 4,
    };
    let alone = Output::ColourAlone { with_sky: false };
    let region = whole(stage.size);
    let layer = drawn(stage.draw_with(&*adapter, alone, region, Some(antialias)));
    let (mut sum, mut partly) = (0.0, 0);
    for pixel in colours(&layer) {
        let coverage = f64::from(pixel[3]);
        assert!((0.0..=1.0).contains(&coverage), "a coverage of {coverage}");
        sum += coverage;
        partly += usize::from(coverage > 0.01 && coverage < 0.99);
        for (channel, glow) in pixel.iter().zip(RED) {
            let expected = coverage * glow;
            let near = (f64::from(*channel) - expected).abs() < 0.01;
            assert!(
                near || !adapter.abilities().coverage,
                "{pixel:?} is not premultiplied"
            );
        }
    }
    if !adapter.abilities().coverage {
        return;
    }
    assert!(partly > 20, "only {partly} pixels are covered in part");
    // The ball's outline: a circle of tan δ = R/√(D² − R²), each way in pixels.
    let (fx, fy) = stage.scene.camera.focal(stage.size);
    let area = std::f64::consts::PI * fx * fy * (4.0 / (100.0 - 4.0));
    assert!(
        (sum / area - 1.0).abs() < 0.02,
        "{sum} pixels, not {area:.1}"
    );
    // Without antialiasing something is there, or nothing is.
    let plain = stage.draw(&*adapter, alone);
    let depth = stage.draw(&*adapter, Output::Depth);
    let depths = depth.depth.as_deref().unwrap_or_default();
    assert_eq!(colours(&plain).len(), depths.len());
    for (pixel, depth) in colours(&plain).iter().zip(depths) {
        let there = if depth.is_finite() { 1.0 } else { 0.0 };
        assert_eq!(pixel[3], there, "{pixel:?} at {depth}");
    }
}

/// Depth comes out of the pass that draws colour.
pub fn depth_comes_with_colour_as_declared(subject: &Subject) {
    let adapter = subject.adapter();
    let stage = ball_and_floor();
    let layer = stage.draw(&*adapter, COLOUR);
    if adapter.abilities().depth_with_colour {
        stage.oracle().assert_depth(&layer);
    }
    assert!(stage.draw(&*adapter, Output::Depth).colour.is_none());
}

/// Points in the shadow get nothing of a light, others all of it.
pub fn light_arrives_or_is_refused(subject: &Subject) {
    let adapter = subject.adapter();
    let mut stage = ball_and_floor();
    let floor = stage.scene.instances.remove(0);
    let far = Instance {
        pose: super::stage::at(100.0, 0.0, 0.0),
        ..stage.scene.instances[0]
    };
    let point = |position| SurfacePoint {
        position,
        footprint: 0.01,
    };
    let points: Arc<[SurfacePoint]> = Arc::new([point(IN_LIGHT), point(IN_SHADOW)]);
    let shot = |frame, casters: Vec<Instance>| ArrivalShot {
        frame,
        light: stage.scene.lights[0],
        casters: casters.into(),
        points: Arc::clone(&points),
    };
    let request = ArrivalRequest {
        prototypes: &stage.prototypes,
        includes: &[],
        shots: vec![
            shot(0, vec![stage.scene.instances[0]]),
            shot(1, vec![far]),
            shot(2, vec![floor]),
        ],
        label: "arrival".into(),
    };
    let room = Room::plain();
    let result = adapter.arriving_light(&request, &room.run);
    room.assert_empty();
    if !adapter.abilities().ray_list {
        assert_refused(result, "a list of rays");
        return;
    }
    let fractions = drawn(result);
    let expected = [[1.0, 0.0], [1.0, 1.0], [1.0, 1.0]];
    assert_eq!(fractions.len(), expected.len());
    for (k, (found, expected)) in fractions.iter().zip(expected).enumerate() {
        assert_eq!(found, &expected.map(|e: f32| [e; 3]), "shot {k}");
    }
}

//! Light, shadow, highlights, mirrors, glass and coverage against the formulas.

mod common;

use common::{Stage, assert_near, glowing, lamp, painted, plane, size, sphere, vec3, white};
use decor_api::{Antialias, Csg, Highlight, Light, LightKind, Material, Output, Rgb, TriangleMesh};
use glam::DVec3;

/// A wall across the view, at z = 0.
fn wall(material: Material) -> Csg {
    painted(material, plane(-DVec3::Z, 0.0))
}

#[test]
fn ambient_and_lambert() {
    let paint = Material {
        colour: Rgb([0.5, 0.25, 1.0]),
        ambient: 0.2,
        diffuse: 0.6,
        ..Material::default()
    };
    // From 45° in front of the wall.
    let mut light = lamp(vec3(0.0, 10.0, -10.0));
    light.colour = Rgb([1.0, 2.0, 0.5]);
    let [r, g, b, a] = Stage::of([wall(paint)]).lit(light).middle();
    let cosine = 0.5_f64.sqrt();
    assert_near(r, 0.5 * (0.2 + 0.6 * cosine));
    assert_near(g, 0.25 * (0.2 + 0.6 * cosine * 2.0));
    assert_near(b, 0.2 + 0.6 * cosine * 0.5);
    assert_eq!(a, 1.0);
    // Behind the wall it lights nothing.
    let dark = Stage::of([wall(white())])
        .lit(lamp(DVec3::Z * 5.0))
        .middle();
    assert_eq!(dark, [0.0, 0.0, 0.0, 1.0]);
}

#[test]
fn a_shadow_falls_and_can_be_switched_off() {
    let light = lamp(vec3(0.0, 4.0, -4.0));
    let blocker = |x: f64| sphere(x, 2.0, -2.0, 0.5);
    let lit = |x: f64, shadows: bool| {
        let mut stage = Stage::of([wall(white()), blocker(x)]).lit(light);
        stage.scene.shadows = shadows;
        stage.middle()[0]
    };
    assert_eq!(lit(0.0, true), 0.0);
    assert_near(lit(0.0, false), 0.5_f64.sqrt());
    assert_near(lit(0.6, true), 0.5_f64.sqrt());
    // Behind the lamp nothing is in the way.
    let beyond = Stage::of([wall(white()), sphere(0.0, 6.0, -6.0, 1.0)]).lit(light);
    assert_near(beyond.middle()[0], 0.5_f64.sqrt());
}

#[test]
fn coloured_glass_tints_the_shadow_at_each_surface() {
    let glass = Material {
        colour: Rgb([1.0, 0.5, 0.0]),
        transmission: 0.8,
        ..white()
    };
    let pane = painted(glass, sphere(0.0, 2.0, -2.0, 0.5));
    let [r, g, b, _] = Stage::of([wall(white()), pane])
        .lit(lamp(vec3(0.0, 4.0, -4.0)))
        .middle();
    let cosine = 0.5_f64.sqrt();
    assert_near(r, cosine * 0.64);
    assert_near(g, cosine * 0.16);
    assert_near(b, 0.0);
}

#[test]
fn half_an_area_light_is_half_a_shadow() {
    let light = Light {
        position: DVec3::Z * -8.0 + DVec3::Y * 0.5,
        colour: Rgb([1.0; 3]),
        kind: LightKind::Area {
            u: DVec3::X * 4.0,
            v: DVec3::Y,
            nu: 4,
            nv: 2,
        },
        fade: None,
    };
    // Hides all samples with x < 0 from the middle of the wall.
    let half = Csg::Box {
        min: vec3(-9.0, -9.0, -1.1),
        max: vec3(-1e-3, 9.0, -1.0),
    };
    let lit = |trees: Vec<Csg>| Stage::of(trees).lit(light).middle()[0];
    let (all, part) = (lit(vec![wall(white())]), lit(vec![wall(white()), half]));
    assert_near(part, f64::from(all) / 2.0);
}

#[test]
fn highlights_where_the_mirror_image_is() {
    let shiny = |highlight| Material {
        ambient: 0.0,
        diffuse: 0.0,
        highlight,
        ..Material::default()
    };
    let at_degrees = |degrees: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        lamp(vec3(0.0, 5.0 * sine, -5.0 * cosine))
    };
    let phong = shiny(Highlight::Phong {
        amount: 0.7,
        size: 20.0,
    });
    let seen =
        |look: Material, degrees: f64| Stage::of([wall(look)]).lit(at_degrees(degrees)).middle()[1];
    assert_near(seen(phong, 0.0), 0.7);
    assert_near(seen(phong, 10.0), 0.7 * 10_f64.to_radians().cos().powi(20));
    let blinn = shiny(Highlight::Specular {
        amount: 0.5,
        roughness: 0.05,
    });
    assert_near(seen(blinn, 20.0), 0.5 * 10_f64.to_radians().cos().powi(20));
}

#[test]
fn a_mirror_shows_what_is_behind_the_eye() {
    let mirror = Material {
        ambient: 0.0,
        diffuse: 0.0,
        reflection: 0.5,
        ..Material::default()
    };
    let behind = painted(glowing([1.0, 0.0, 0.5]), sphere(0.0, 0.0, -20.0, 1.0));
    let [r, g, b, _] = Stage::of([wall(mirror), behind]).middle();
    assert_near(r, 0.5);
    assert_near(g, 0.0);
    assert_near(b, 0.25);
    // Nothing there: the background is mirrored.
    assert_near(Stage::of([wall(mirror)]).middle()[2], 0.375);
    // Two mirrors that face each other come to an end.
    let other = painted(mirror, plane(DVec3::Z, -20.0));
    assert!(Stage::of([wall(mirror), other]).middle()[0].is_finite());
}

#[test]
fn glass_tints_and_bends() {
    let glass = |ior: f64| Material {
        colour: Rgb([1.0, 0.5, 1.0]),
        ambient: 0.0,
        diffuse: 0.0,
        transmission: 1.0,
        ior,
        ..Material::default()
    };
    let behind = || painted(glowing([1.0; 3]), plane(-DVec3::Z, -5.0));
    let [r, g, ..] =
        Stage::of([painted(glass(1.5), sphere(0.0, 0.0, 0.0, 1.0)), behind()]).middle();
    assert_near(r, 1.0);
    assert_near(g, 0.25);

    // A thick plate, looked through at 45°: the ray comes out displaced by
    // d · (tan 45° − tan β), sin β = sin 45° / 1.5, and meets a small target.
    let plate = Csg::Box {
        min: vec3(-50.0, -50.0, 0.0),
        max: vec3(50.0, 50.0, 2.0),
    };
    let sine = 0.5_f64.sqrt() / 1.5;
    let inside = 2.0 * sine / (1.0 - sine * sine).sqrt();
    let target = painted(
        glowing([1.0; 3]),
        sphere(10.0 + inside + 3.0, 0.0, 5.0, 1e-3),
    );
    let view = decor_api::Camera::look_at(
        DVec3::Z * -10.0,
        DVec3::ZERO + DVec3::X * 10.0,
        DVec3::Y,
        (1.0, 1.0),
    );
    let mut stage = Stage::of([painted(glass(1.5), plate), target]).seen_from(view.unwrap());
    stage.scene.background = Rgb([0.0; 3]);
    assert_near(stage.middle()[0], 1.0);
}

#[test]
fn glass_bends_the_same_as_a_mesh_whatever_the_order_of_its_corners() {
    let corners: Vec<DVec3> = (0..8)
        .map(|i| {
            let at = |bit: i32| if i & bit == 0 { -1.0 } else { 1.0 };
            vec3(at(1), at(2), at(4))
        })
        .collect();
    let faces = [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [7, 5, 4],
        [0, 4, 5],
        [5, 1, 0],
        [2, 7, 3],
        [2, 6, 7],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 3, 7],
    ];
    let glass = Material {
        transmission: 0.9,
        ior: 1.3,
        ..Material::default()
    };
    let turned = |tree: Csg| {
        let tree = Csg::Rotate(vec3(30.0, 40.0, 0.0), Box::new(tree));
        let ground = painted(glowing([0.9, 0.3, 0.1]), plane(DVec3::Y, -2.0));
        let stage = Stage::of([painted(glass, tree), ground]);
        stage.drawn(size(40, 40), Output::ColourOverBackground, None)
    };
    let mesh = turned(Csg::Mesh(std::sync::Arc::new(TriangleMesh {
        vertices: corners,
        triangles: faces.to_vec(),
    })));
    let solid = turned(common::cube(1.0));
    let pairs = mesh
        .colour
        .iter()
        .flatten()
        .zip(solid.colour.iter().flatten());
    let different = pairs
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > 1e-4))
        .count();
    // A ray through an edge may bend either way.
    assert!(different <= 4, "{different} of 1600 pixels");
}

#[test]
fn coverage_on_an_edge_is_the_covered_share() {
    let fine = Some(Antialias {
        threshold: 0.1,
        depth: 4,
    });
    // Its left face lies a quarter into the middle pixel of nine.
    let half_width = (22.5_f64).to_radians().tan();
    let pixel = 2.0 * half_width * 9.0 / 9.0;
    let block = Csg::Box {
        min: vec3(-0.25 * pixel, -50.0, -1.0),
        max: vec3(50.0, 50.0, 1.0),
    };
    let stage = Stage::of([painted(glowing([1.0, 0.5, 0.25]), block)]);
    let alone = stage.drawn(size(9, 9), Output::ColourAlone { with_sky: false }, fine);
    assert_eq!(alone.colour.unwrap()[40], [0.75, 0.375, 0.1875, 0.75]);
    let over = stage.drawn(size(9, 9), Output::ColourOverBackground, fine);
    let [r, _, _, a] = over.colour.unwrap()[40];
    assert_eq!((r, a), (0.75 + 0.25 * 0.25, 1.0));
    // The depth is the centre's, not a mean.
    assert_eq!(alone.depth.unwrap()[40], 9.0);
    // Above the threshold only.
    let coarse = Some(Antialias {
        threshold: 100.0,
        depth: 4,
    });
    let plain = stage.drawn(size(9, 9), Output::ColourAlone { with_sky: false }, coarse);
    assert_eq!(plain.colour.unwrap()[40][3], 1.0);
}

#[test]
fn a_curved_surface_does_not_shadow_itself() {
    for scale in [1e-6, 1.0, 1e6] {
        let ball = painted(white(), sphere(0.0, 0.0, 0.0, 3.0 * scale));
        let view = decor_api::Camera::look_at(
            DVec3::Z * -10.0 * scale,
            DVec3::ZERO,
            DVec3::Y,
            (45.0, 45.0),
        );
        let lit = |shadows: bool| {
            let mut stage = Stage::of([ball.clone()])
                .lit(lamp(vec3(8.0, 8.0, -10.0) * scale))
                .seen_from(view.unwrap());
            stage.scene.shadows = shadows;
            stage
                .drawn(size(64, 64), Output::ColourOverBackground, None)
                .colour
        };
        assert_eq!(lit(true), lit(false), "{scale}");
    }
}

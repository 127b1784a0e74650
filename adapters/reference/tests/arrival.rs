//! Hidden casters, and the light that arrives at points.

mod common;

use std::sync::Arc;

use common::{Stage, cube, lamp, painted, plane, run, size, sphere, vec3, white};
use decor_api::{
    Adapter, ArrivalRequest, ArrivalShot, Instance, Light, LightKind, Material, Output, Pose, Rgb,
    SurfacePoint,
};
use decor_reference::Reference;
use glam::DVec3;

fn fractions(stage: &Stage, light: Light, points: &[DVec3]) -> Vec<[f32; 3]> {
    let point = |&position: &DVec3| SurfacePoint {
        position,
        footprint: 0.1,
    };
    let request = ArrivalRequest {
        prototypes: &stage.prototypes,
        includes: &[],
        shots: vec![ArrivalShot {
            frame: 1,
            light,
            casters: stage.scene.instances.clone().into(),
            points: points.iter().map(point).collect::<Vec<_>>().into(),
        }],
        label: "arrival".to_owned(),
    };
    let mut found = Reference::new().arriving_light(&request, &run()).unwrap();
    assert_eq!(found.len(), 1);
    found.remove(0)
}

#[test]
fn what_stands_in_the_way_takes_its_share() {
    let green = Material {
        colour: Rgb([0.2, 1.0, 0.5]),
        transmission: 0.5,
        ..Material::default()
    };
    let stage = Stage::of([
        painted(white(), sphere(0.0, 5.0, 0.0, 1.0)),
        painted(green, sphere(8.0, 5.0, 0.0, 1.0)),
        painted(white(), plane(DVec3::Y, 0.0)),
    ]);
    let mut light = lamp(vec3(0.0, 100.0, 0.0));
    // Neither its colour nor its fading matter.
    light.colour = Rgb([0.0, 3.0, 0.1]);
    light.kind = LightKind::Sun {
        towards: DVec3::ZERO,
    };
    // The points lie on a caster, the floor.
    let found = fractions(
        &stage,
        light,
        &[DVec3::ZERO, DVec3::X * 8.0, DVec3::X * 4.0],
    );
    assert_eq!(found[0], [0.0; 3]);
    for (got, want) in found[1].into_iter().zip([0.01, 0.25, 0.0625]) {
        assert!((got - want).abs() < 1e-6, "{:?}", found[1]);
    }
    assert_eq!(found[2], [1.0; 3]);
}

#[test]
fn outside_of_the_cone_all_of_nothing_arrives() {
    let stage = Stage::of([painted(white(), cube(50.0))]);
    let mut spot = lamp(vec3(0.0, 100.0, 0.0));
    spot.kind = LightKind::Spot {
        towards: DVec3::ZERO,
        radius_deg: 5.0,
        falloff_deg: 10.0,
        tightness: 0.0,
    };
    let below = |x| vec3(x, -60.0, 0.0);
    let found = fractions(&stage, spot, &[below(0.0), below(500.0), DVec3::NAN]);
    assert_eq!(found, [[0.0; 3], [1.0; 3], [1.0; 3]]);
}

#[test]
fn the_hidden_shade_and_are_mirrored_but_are_not_seen() {
    let mirror = Material {
        reflection: 0.9,
        ..white()
    };
    let floor = || {
        Stage::of([
            painted(white(), plane(DVec3::Y, -1.0)),
            painted(mirror, plane(-DVec3::Z, -4.0)),
        ])
        .lit(lamp(vec3(-6.0, 5.0, -4.0)))
    };
    let mut whole = floor();
    whole.add(painted(white(), sphere(0.0, 0.5, 0.0, 1.0)), Pose::IDENTITY);
    let ball = *whole.scene.instances.last().unwrap();
    let mut hidden = floor();
    hidden.prototypes = whole.prototypes.clone();
    hidden.scene.hidden = vec![Instance { ..ball }];
    let size = size(65, 65);
    let draw = |stage: &Stage| stage.drawn(size, Output::ColourOverBackground, None);
    let (whole, hidden, without) = (draw(&whole), draw(&hidden), draw(&floor()));
    assert_eq!(hidden.depth, without.depth);
    let colours = [&whole, &hidden, &without].map(|l| l.colour.as_ref().unwrap());
    let depths = [&whole, &hidden].map(|l| l.depth.as_ref().unwrap());
    let (mut shown, mut changed) = (0, 0);
    for k in 0..size.pixels() {
        if depths[0][k] == depths[1][k] {
            assert_eq!(colours[0][k], colours[1][k], "pixel {k}");
            changed += usize::from(colours[1][k] != colours[2][k]);
        } else {
            shown += 1;
        }
    }
    assert!(shown > 100 && changed > 50, "{shown} {changed}");
}

#[test]
fn native_casters_are_refused() {
    let stage = Stage::of([]);
    let file = decor_api::NativeFile {
        path: "a.inc".into(),
        root: ".".into(),
        text: Vec::new(),
    };
    let request = ArrivalRequest {
        prototypes: &stage.prototypes,
        includes: &[file],
        shots: vec![ArrivalShot {
            frame: 1,
            light: lamp(DVec3::Y),
            casters: Arc::new([]),
            points: Arc::new([]),
        }],
        label: String::new(),
    };
    assert!(Reference::new().arriving_light(&request, &run()).is_err());
}

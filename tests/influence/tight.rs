//! Tight, on a scene like the bundled film `shadows`: three lights of three
//! kinds, a flock over a terrain of boxes and spheres, shadows on shadows.

use decor::influence::{Cause, Mask};
use decor_api::{
    Antialias, Camera, Csg, Light, LightKind, Material, Output, Pose, PrototypeTable, Rgb,
    RunContext, Scene, Size,
};
use decor_reference::Reference;
use glam::DVec3;

use crate::scenes::{Case, Dice, differing, instance, render};

const SIZE: Size = Size {
    width: 320,
    height: 240,
};

fn at(position: DVec3, angles_deg: DVec3) -> Pose {
    Pose {
        position,
        angles_deg,
    }
}

fn painted(red: f64, csg: Csg) -> Csg {
    let look = Material {
        colour: Rgb([red, 0.6, 0.4]),
        ..Material::default()
    };
    Csg::Look(look, Box::new(csg))
}

/// A body, two wings and a tail.
fn bird() -> Csg {
    let wing = |side: f64| {
        let plate = Csg::Box {
            min: DVec3::new(0.0, -0.02, -0.18),
            max: DVec3::new(1.0, 0.02, 0.18),
        };
        let turned = Csg::Rotate(DVec3::new(0.0, 0.0, 20.0), Box::new(plate));
        Csg::Scale(DVec3::new(side, 1.0, 1.0), Box::new(turned))
    };
    let body = Csg::Sphere {
        centre: DVec3::ZERO,
        radius: 0.25,
    };
    let tail = Csg::Cone {
        base: DVec3::ZERO,
        base_radius: 0.15,
        cap: DVec3::Z * -0.8,
        cap_radius: 0.02,
    };
    let body = Csg::Scale(DVec3::new(0.8, 0.8, 1.6), Box::new(body));
    painted(0.9, Csg::Union(vec![body, wing(1.0), wing(-1.0), tail]))
}

fn flock(table: &mut PrototypeTable) -> Case {
    let mut dice = Dice(7);
    let mut instances = Vec::new();
    let ground = Csg::Box {
        min: DVec3::new(-20.0, -1.0, -20.0),
        max: DVec3::new(20.0, 0.0, 20.0),
    };
    instances.push(instance(table, painted(0.5, ground), Pose::IDENTITY));
    for i in 0..8 {
        for j in 0..8 {
            let place = DVec3::new(f64::from(i) - 3.5, 0.0, f64::from(j) - 3.5) * 3.0;
            let height = dice.within(0.2, 2.0);
            let solid = if dice.chance(50) {
                Csg::Box {
                    min: DVec3::new(-0.9, 0.0, -0.9),
                    max: DVec3::new(0.9, height, 0.9),
                }
            } else {
                Csg::Sphere {
                    centre: DVec3::ZERO,
                    radius: 0.5 + 0.4 * height,
                }
            };
            let turn = DVec3::Y * dice.within(0.0, 90.0);
            let solid = painted(dice.within(0.2, 0.8), solid);
            instances.push(instance(table, solid, at(place, turn)));
        }
    }
    let decor_count = instances.len();
    for _ in 0..12 {
        let place = dice.vec3(8.0) * DVec3::new(1.0, 0.15, 1.0) + DVec3::Y * 5.0;
        let turn = DVec3::new(dice.within(-15.0, 15.0), dice.within(0.0, 360.0), 0.0);
        instances.push(instance(table, bird(), at(place, turn)));
    }
    let light = |position: DVec3, bright: f64, kind| Light {
        position,
        colour: Rgb([bright; 3]),
        kind,
        fade: None,
    };
    let towards = DVec3::ZERO;
    let eye = DVec3::new(3.0, 13.0, -22.0);
    Case {
        scene: Scene {
            camera: Camera::look_at(eye, DVec3::Y * 1.5, DVec3::Y, (50.0, 39.0)).unwrap(),
            lights: vec![
                light(DVec3::new(-15.0, 22.0, -6.0), 0.5, LightKind::Point),
                light(
                    DVec3::new(30.0, 50.0, -20.0),
                    0.5,
                    LightKind::Sun { towards },
                ),
                light(
                    DVec3::new(2.0, 25.0, 12.0),
                    0.6,
                    LightKind::Spot {
                        towards,
                        radius_deg: 25.0,
                        falloff_deg: 35.0,
                        tightness: 0.0,
                    },
                ),
            ],
            shadows: true,
            background: Rgb([0.2, 0.3, 0.6]),
            includes: Vec::new(),
            sky: None,
            instances,
            hidden: Vec::new(),
        },
        decor_count,
        size: SIZE,
        antialias: None,
    }
}

/// The masks as one sees them: what differs is white, what is influenced grey.
fn picture(name: &str, mask: &Mask, changed: &[(u32, u32)]) {
    let Some(folder) = std::env::var_os("DECOR_INFLUENCE_PICTURES") else {
        return;
    };
    let mut picture = image::RgbImage::from_fn(SIZE.width, SIZE.height, |x, y| {
        let is = |cause| u8::from(mask.has(x, y, cause)) * 120;
        image::Rgb([is(Cause::Seen), is(Cause::Optical), is(Cause::Shadowed)])
    });
    for &(x, y) in changed {
        let image::Rgb(under) = *picture.get_pixel(x, y);
        picture.put_pixel(x, y, image::Rgb(under.map(|v| v.saturating_add(130))));
    }
    let path = std::path::Path::new(&folder).join(format!("{name}.png"));
    picture.save(path).expect("the picture is written");
}

#[test]
fn a_flock_influences_at_most_three_times_what_differs() {
    let mut table = PrototypeTable::default();
    let mut case = flock(&mut table);
    let (adapter, run) = (Reference::new(), RunContext::new(std::env::temp_dir()));
    for antialias in [
        None,
        Some(Antialias {
            threshold: 0.1,
            depth: 3,
        }),
    ] {
        case.antialias = antialias;
        let drawn = |scene: Scene, size: Size, output: Output| {
            let layers = render(&adapter, &run, &table, vec![scene], size, output, antialias);
            layers.into_iter().next().unwrap()
        };
        let full = drawn(case.scene.clone(), SIZE, Output::ColourOverBackground);
        let decor = drawn(case.decor(), SIZE, Output::ColourOverBackground);
        let changed = differing(&full, &decor, SIZE);
        let fine = Size {
            width: SIZE.width * 3,
            height: SIZE.height * 3,
        };
        let samples = antialias.map(|_| drawn(case.decor(), fine, Output::Depth));
        let mut masks = vec![("neighbourhoods", case.mask(&table, &decor, None))];
        if let Some(samples) = &samples {
            masks.push(("samples", case.mask(&table, &decor, Some((samples, 3)))));
        }
        for (name, mask) in masks {
            let name = if antialias.is_none() { "centres" } else { name };
            let ratio = mask.count() as f64 / changed.len() as f64;
            println!(
                "{name}: {} differ, {} influenced ({} seen, {} shadowed), {ratio:.2} times",
                changed.len(),
                mask.count(),
                mask.count_of(Cause::Seen),
                mask.count_of(Cause::Shadowed)
            );
            picture(name, &mask, &changed);
            let wide = mask.dilated();
            assert!(changed.iter().all(|(x, y)| wide.contains(*x, *y)), "{name}");
            assert!(changed.len() > 3_000, "{name}: too little changes");
            assert!(ratio <= 3.0, "{name}: {ratio}");
        }
    }
}

//! Geometry against rays: what a point shows, or shades, is dirty.

use decor_api::Size;
use proptest::prelude::*;

use super::*;
use crate::unedited::Statement;
use crate::unedited::boxes::Placed;

const SIZE: Size = Size {
    width: 320,
    height: 240,
};
const GRID: Grid = Grid { size: SIZE };

fn statement(kind: &str, moves: bool, bends: bool) -> Statement {
    Statement {
        file: 0,
        line: 1,
        range: 0..1,
        kind: Kind::Object(kind.into()),
        moves,
        why: String::new(),
        bends,
        repeated: false,
    }
}

/// What moves is statement 0, a still thing 1, a mirror 2.
fn analysis() -> Analysis {
    Analysis {
        statements: vec![
            statement("sphere", true, false),
            statement("box", false, false),
            statement("sphere", false, true),
        ],
        ..Analysis::default()
    }
}

fn words(list: &[(&str, DVec3)]) -> Option<Vec<(String, DVec3)>> {
    let own = list
        .iter()
        .map(|(word, value)| ((*word).to_owned(), *value));
    Some(own.collect())
}

fn placed(statement: usize, min: DVec3, max: DVec3) -> Placed {
    let extent = Extent::Box { min, max };
    Placed {
        statement,
        extent,
        round: false,
    }
}

/// A floor, a light, a camera that looks down on them; a small box moves.
fn scene(at: DVec3) -> FrameBoxes {
    let floor = Extent::Plane {
        point: DVec3::ZERO,
        normal: DVec3::Y,
    };
    FrameBoxes {
        frame: 1,
        objects: vec![
            placed(0, at - 0.1, at + 0.1),
            Placed {
                statement: 1,
                extent: floor,
                round: false,
            },
        ],
        lights: vec![DVec3::new(3.0, 6.0, -2.0)],
        camera: words(&[
            ("location", DVec3::new(0.0, 3.0, -8.0)),
            ("look_at", DVec3::new(0.0, 1.0, 0.0)),
            ("right", DVec3::X * 4.0 / 3.0),
            ("angle", DVec3::splat(50.0)),
        ]),
        lost_light: false,
    }
}

fn dirty(frame: &FrameBoxes) -> Blocks {
    Geometry::new(GRID, &analysis(), frame)
        .unwrap()
        .dirty(frame)
}

fn pixel(frame: &FrameBoxes, point: DVec3) -> Option<(f64, f64)> {
    let view = View::of(frame.camera.as_ref().unwrap(), SIZE).unwrap();
    let outline = view.outline(&[point]).unwrap();
    outline.first().map(|p| (p.x, p.y))
}

/// Is the block at these pixels dirty? What lies outside needs not be.
fn is_covered(dirty: &Blocks, (x, y): (f64, f64)) -> bool {
    let outside = x < 0.0 || y < 0.0 || x >= 320.0 || y >= 240.0;
    outside || dirty.has((y as usize / 32) * 10 + x as usize / 32)
}

#[test]
fn a_small_box_and_its_shadow_dirty_a_few_blocks() {
    let frame = scene(DVec3::new(0.0, 1.0, 0.0));
    let dirty = dirty(&frame);
    assert!(is_covered(&dirty, (160.0, 120.0)));
    assert!((2..=12).contains(&dirty.len()), "{dirty:?}");
    // Without a light, only where it is seen.
    let dark = FrameBoxes {
        lights: Vec::new(),
        ..frame
    };
    assert!((1..=4).contains(&self::dirty(&dark).len()));
}

#[test]
fn the_cameras_words_mean_what_povray_says() {
    let at = |list: &[(&str, DVec3)], point: DVec3| {
        let view = View::of(&words(list).unwrap(), SIZE).unwrap();
        let p = view.outline(&[point]).unwrap()[0];
        (p.x.round(), p.y.round())
    };
    let ahead = DVec3::Z * 5.0;
    assert_eq!(at(&[], ahead), (160.0, 120.0));
    // Half of 1.33 to the right is the border.
    assert_eq!(at(&[], DVec3::new(0.665, 0.0, 1.0)), (320.0, 120.0));
    assert_eq!(
        at(&[("right", -DVec3::X)], DVec3::new(0.5, 0.5, 1.0)),
        (0.0, 0.0)
    );
    let angle = [("angle", DVec3::splat(90.0)), ("right", DVec3::X * 2.0)];
    assert_eq!(at(&angle, DVec3::new(1.0, 0.0, 1.0)), (320.0, 120.0));
    // A turn of 90 degrees about y takes z to x.
    let turned = [("rotate", DVec3::Y * 90.0), ("translate", DVec3::Y)];
    assert_eq!(at(&turned, DVec3::new(5.0, 1.0, 0.0)), (160.0, 120.0));
    let look = [
        ("location", DVec3::X),
        ("look_at", DVec3::new(1.0, 9.0, 9.0)),
    ];
    assert_eq!(at(&look, DVec3::new(1.0, 5.0, 5.0)), (160.0, 120.0));
    for other in ["orthographic", "normal", "matrix"] {
        assert!(View::of(&words(&[(other, DVec3::ONE)]).unwrap(), SIZE).is_none());
    }
    assert!(View::of(&words(&[("right", DVec3::ZERO)]).unwrap(), SIZE).is_none());
}

#[test]
fn mirrors_are_dirty_and_endless_ones_refused() {
    let mut frame = scene(DVec3::new(0.0, -5.0, 0.0));
    assert_eq!(
        dirty(&frame).len(),
        dirty(&scene(DVec3::new(0.0, -5.0, 0.0))).len()
    );
    let mirror = DVec3::new(-2.0, 2.0, 0.0);
    frame.objects.push(placed(2, mirror - 0.3, mirror + 0.3));
    let block = pixel(&frame, mirror).unwrap();
    assert!(is_covered(&dirty(&frame), block));
    frame.objects.push(Placed {
        statement: 2,
        extent: Extent::Endless,
        round: false,
    });
    let refused = Geometry::new(GRID, &analysis(), &frame).unwrap_err();
    assert!(refused.contains("without end"), "{refused}");
}

#[test]
fn what_is_not_certain_is_dirty() {
    let still = scene(DVec3::Y);
    let geometry = Geometry::new(GRID, &analysis(), &still).unwrap();
    let all = Blocks::all(GRID);
    let mut other = scene(DVec3::Y);
    other.lights[0].x += 1.0;
    assert_eq!(geometry.dirty(&other), all);
    let mut endless = scene(DVec3::Y);
    endless.objects[0].extent = Extent::Endless;
    assert_eq!(geometry.dirty(&endless), all);
    let mut number = scene(DVec3::Y);
    number.objects[0] = placed(0, DVec3::NAN, DVec3::ONE);
    assert_eq!(geometry.dirty(&number), all);
    // The camera is inside.
    let around = scene(DVec3::new(0.0, 3.0, -8.0));
    assert_eq!(geometry.dirty(&around), all);
}

proptest! {
    #[test]
    fn what_is_seen_or_shaded_is_dirty(
        centre in prop::array::uniform3(-6.0_f64..6.0),
        inside in prop::array::uniform3(-0.1_f64..0.1),
        light in prop::array::uniform3(-9.0_f64..9.0),
        tilt in prop::array::uniform3(-1.0_f64..1.0),
    ) {
        let centre = DVec3::from(centre);
        let mut frame = scene(centre);
        frame.lights = vec![DVec3::from(light)];
        let normal = (DVec3::Y + DVec3::from(tilt) * 0.7).normalize();
        frame.objects[1].extent = Extent::Plane { point: DVec3::ZERO, normal };
        let blocks = dirty(&frame);
        let point = centre + DVec3::from(inside);
        if let Some(seen) = pixel(&frame, point) {
            prop_assert!(is_covered(&blocks, seen), "seen at {seen:?}");
        }
        // The shadow of the point on the plane.
        let ray = point - frame.lights[0];
        let along = -frame.lights[0].dot(normal) / ray.dot(normal);
        if along > 1.0 && let Some(shade) = pixel(&frame, frame.lights[0] + ray * along) {
            prop_assert!(is_covered(&blocks, shade), "shaded at {shade:?}");
        }
    }

    #[test]
    fn shadows_fall_on_boxes_and_on_what_has_no_end(
        centre in prop::array::uniform3(-6.0_f64..6.0),
        light in prop::array::uniform3(-9.0_f64..9.0),
        far in 1.0_f64..20.0,
        endless: bool,
    ) {
        let centre = DVec3::from(centre);
        let mut frame = scene(centre);
        frame.lights = vec![DVec3::from(light)];
        let shade = centre + (centre - frame.lights[0]) * far;
        frame.objects[1] = if endless {
            Placed { statement: 1, extent: Extent::Endless, round: false }
        } else {
            placed(1, shade - 0.01, shade + 0.01)
        };
        if let Some(seen) = pixel(&frame, shade) {
            prop_assert!(is_covered(&dirty(&frame), seen), "shaded at {seen:?}");
        }
    }
}

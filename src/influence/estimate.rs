//! Where a frame may be shaded, before any depth is known: for prices only. It
//! is neither conservative nor exact.

use decor_api::{Bounds, Camera, Light, Size, Sphere};
use glam::DVec3;

use super::Changed;
use super::lamp::Lamp;
use crate::motion::screen_box;
use crate::plan::BlockSet;

/// About which blocks what changed shades: those of the discs that its shadows are
/// on the décor's spheres. A décor without an end is shaded as far as the object
/// is seen. Nothing is taken off where shadows are hidden. They are added to
/// `blocks`.
pub fn estimated_shadows(
    camera: &Camera,
    size: Size,
    lights: &[Light],
    changed: &[Changed],
    decor: &[Bounds],
    mut blocks: BlockSet,
) -> BlockSet {
    let lamps = lights.iter();
    let lamps: Vec<Lamp> = lamps.filter_map(|l| Lamp::of(l, DVec3::ZERO)).collect();
    // An estimate may not take longer than what it estimates.
    const MOST_PAIRS: usize = 10_000;
    let by_parts = changed.len() * decor.len() <= MOST_PAIRS;
    let has_no_end = decor.contains(&Bounds::Unbounded);
    let mut insert = |ball: &Sphere| {
        let bounds = Bounds::sphere(ball.centre, ball.radius);
        blocks.insert(screen_box(&bounds, camera, size).window());
    };
    for object in changed {
        let Some(whole) = object.whole.as_sphere() else {
            continue;
        };
        let parts = match object.parts.as_slice() {
            parts if by_parts && !parts.is_empty() => parts,
            _ => std::slice::from_ref(whole),
        };
        if has_no_end && !lamps.is_empty() {
            parts.iter().for_each(&mut insert);
        }
        for lamp in &lamps {
            for receiver in decor.iter().filter_map(Bounds::as_sphere) {
                if shadow(lamp, whole, receiver).is_some() {
                    let discs = parts.iter().filter_map(|part| shadow(lamp, part, receiver));
                    discs.for_each(|disc| insert(&disc));
                }
            }
        }
    }
    blocks
}

/// The ball around the shadow of `caster` on `receiver`, where there is one.
fn shadow(lamp: &Lamp, caster: &Sphere, receiver: &Sphere) -> Option<Sphere> {
    let (away, grows) = match *lamp {
        Lamp::Anywhere => return Some(*receiver),
        Lamp::Sun { back, .. } => (-back, 0.0),
        Lamp::At { centre, radius, .. } => {
            let way = caster.centre - centre;
            let distance = way.length();
            (way / distance, (caster.radius + radius) / distance)
        }
    };
    let beyond = (receiver.centre - caster.centre).dot(away);
    if beyond + receiver.radius < 0.0 {
        return None;
    }
    let on_axis = caster.centre + away * beyond;
    let radius = caster.radius + grows * beyond.max(0.0);
    let off = on_axis.distance(receiver.centre);
    if off >= radius + receiver.radius {
        return None;
    }
    Some(if radius < receiver.radius {
        Sphere {
            centre: on_axis,
            radius,
        }
    } else {
        *receiver
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::{LightKind, Rgb};

    const SIZE: Size = Size {
        width: 200,
        height: 200,
    };

    fn estimate(lights: &[Light], decor: &[Bounds]) -> usize {
        let eye = DVec3::new(0.0, 0.0, -20.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, (60.0, 60.0)).unwrap();
        let ball = Bounds::sphere(DVec3::Y * 3.0, 1.0);
        let none = BlockSet::none(SIZE, crate::plan::BLOCK);
        estimated_shadows(&camera, SIZE, lights, &[ball.into()], decor, none).pixels()
    }

    #[test]
    fn shadows_are_where_something_is_behind() {
        let lamp = Light {
            position: DVec3::Y * 13.0,
            colour: Rgb([1.0; 3]),
            kind: LightKind::Point,
            fade: None,
        };
        let below = Bounds::sphere(DVec3::Y * -5.0, 4.0);
        let above = Bounds::sphere(DVec3::Y * 9.0, 2.0);
        assert_eq!(estimate(&[], &[below]), 0);
        assert_eq!(estimate(&[lamp], &[above]), 0);
        // A disc of radius 1.8 in 20, 173 pixels to a unit at 1: 31 pixels in
        // blocks of 32.
        let shadowed = estimate(&[lamp], &[below]);
        assert!((1024..=6 * 1024).contains(&shadowed), "{shadowed}");
        assert!(estimate(&[lamp], &[Bounds::Unbounded]) > 0);
        // What lies in the same place is shaded once.
        assert_eq!(estimate(&[lamp; 3], &[below; 4]), shadowed);
    }

    #[test]
    fn it_is_never_more_than_the_picture() {
        let lamp = Light {
            position: DVec3::NAN,
            colour: Rgb([1.0; 3]),
            kind: LightKind::Point,
            fade: None,
        };
        let many = vec![Bounds::sphere(DVec3::ZERO, 50.0); 9];
        assert_eq!(estimate(&[lamp], &many), 40_000);
    }
}

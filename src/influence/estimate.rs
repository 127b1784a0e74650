//! How much a frame may be influenced, before any depth is known: for prices
//! only. It is neither conservative nor exact.

use decor_api::{Bounds, Camera, Light, Size, Sphere};
use glam::DVec3;

use super::lamp::Lamp;
use crate::motion::screen_box;

/// About how many pixels a frame's changed spheres influence, at most all: those
/// that they are seen in, and those of the discs that their shadows are on the
/// décor's spheres. A décor without an end gets a shadow as large as the object
/// is seen. Nothing is taken off where shadows overlap or are hidden.
pub fn estimated_pixels(
    camera: &Camera,
    size: Size,
    lights: &[Light],
    changed: &[Sphere],
    decor: &[Bounds],
) -> f64 {
    let seen_px = |ball: &Sphere| {
        let bounds = Bounds::sphere(ball.centre, ball.radius);
        // A circle in its box.
        let window = screen_box(&bounds, camera, size).window();
        window.pixels() as f64 * std::f64::consts::FRAC_PI_4
    };
    let lamps = lights.iter();
    let lamps: Vec<Lamp> = lamps.filter_map(|l| Lamp::of(l, DVec3::ZERO)).collect();
    let has_no_end = decor.contains(&Bounds::Unbounded);
    let mut sum = 0.0;
    for ball in changed {
        let own = seen_px(ball);
        sum += own;
        for lamp in &lamps {
            if has_no_end {
                sum += own;
            }
            let shadows = decor.iter().filter_map(Bounds::as_sphere);
            let shadows = shadows.filter_map(|receiver| shadow(lamp, ball, receiver));
            sum += shadows.map(|disc| seen_px(&disc)).sum::<f64>();
        }
    }
    let all = size.pixels() as f64;
    // NaN is no price.
    if sum < all { sum } else { all }
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

    fn estimate(lights: &[Light], decor: &[Bounds]) -> f64 {
        let eye = DVec3::new(0.0, 0.0, -20.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, (60.0, 60.0)).unwrap();
        let ball = Sphere {
            centre: DVec3::Y * 3.0,
            radius: 1.0,
        };
        estimated_pixels(&camera, SIZE, lights, &[ball], decor)
    }

    #[test]
    fn shadows_are_added_where_something_is_behind() {
        let lamp = Light {
            position: DVec3::Y * 13.0,
            colour: Rgb([1.0; 3]),
            kind: LightKind::Point,
            fade: None,
        };
        let below = Bounds::sphere(DVec3::Y * -5.0, 4.0);
        let above = Bounds::sphere(DVec3::Y * 9.0, 2.0);
        let alone = estimate(&[], &[below]);
        // A ball of 1 in 20, 173 pixels to a unit at 1: a disc of 17 pixels.
        assert!((200.0..420.0).contains(&alone), "{alone}");
        assert_eq!(estimate(&[lamp], &[above]), alone);
        let shadowed = estimate(&[lamp], &[below]);
        assert!(
            shadowed > 2.0 * alone && shadowed < 6.0 * alone,
            "{shadowed}"
        );
        let endless = estimate(&[lamp], &[Bounds::Unbounded]);
        assert_eq!(endless, 2.0 * alone);
    }

    #[test]
    fn it_is_never_more_than_the_picture_nor_nan() {
        let lamp = Light {
            position: DVec3::NAN,
            colour: Rgb([1.0; 3]),
            kind: LightKind::Point,
            fade: None,
        };
        let many = vec![Bounds::sphere(DVec3::ZERO, 50.0); 9];
        assert_eq!(estimate(&[lamp], &many), 40_000.0);
    }
}

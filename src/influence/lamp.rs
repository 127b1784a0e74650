//! Where the light of a lamp can be blocked by a ball.
//!
//! All positions here are relative to the eye; what is asked about is a
//! [beam](super::beam).
//!
//! # Why a widened triangle is enough
//! Let X′ be a point of the beam, at distance t, L′ a point of the lamp, and P
//! on the segment between them, P = L′ + σ(X′ − L′), in the ball (c, r). On the
//! beam's own ray lies X with ‖X − X′‖ ≤ t·spread, in the lamp's centre L with
//! ‖L − L′‖ ≤ ρ. So the triangle of near, far and L has a point within
//! σ·t·spread + (1−σ)·ρ of P:
//! - σ·t ≤ t. And for t > 2(‖L‖ + ρ), σ = ‖P − L′‖/‖X′ − L′‖ is at most
//!   (‖c−L‖ + r + ρ)/(t/2), so that σ·t ≤ 2(‖c−L‖ + r + ρ), however far X is.
//! - 1 − σ = 1 − ‖P − L′‖/‖X′ − L′‖ ≤ 1 − (‖c−L‖ − r − ρ)/(‖X−L‖ + ρ + t·spread):
//!   the penumbra of what is close to the ground is narrow.

use decor_api::{Bounds, Light, LightKind, Sphere, area_samples};
use glam::DVec3;

use super::Solid;
use super::beam::{Beam, ROUNDING, is_clear};
use super::distance::{half_strip_squared, segment_squared, triangle_squared};

/// A light, as far as shadows are concerned.
#[derive(Clone, Copy, Debug)]
pub enum Lamp {
    /// From a point, or from somewhere in a ball around it.
    At {
        /// The middle.
        centre: DVec3,
        /// How far from it light may start.
        radius: f64,
        /// The axis and half the angle of the only directions with light.
        cone: Option<(DVec3, f64)>,
    },
    /// From a plane, square to it.
    Sun {
        /// From a point of the scene to the light, of length 1.
        back: DVec3,
        /// How far the plane is from the eye along `back`.
        plane: f64,
    },
    /// Not certain: it may come from anywhere.
    Anywhere,
}

impl Lamp {
    /// `None` for a light without any.
    pub fn of(light: &Light, eye: DVec3) -> Option<Self> {
        if light.colour.0.iter().all(|channel| *channel == 0.0) {
            return None;
        }
        let centre = light.position - eye;
        let at = |radius: f64, cone| Self::At {
            centre,
            radius,
            cone,
        };
        let lamp = match light.kind {
            LightKind::Point => at(0.0, None),
            LightKind::Sun { towards } => match (light.position - towards).try_normalize() {
                Some(back) => Self::Sun {
                    back,
                    plane: centre.dot(back),
                },
                None => Self::Anywhere,
            },
            LightKind::Spot {
                towards,
                radius_deg,
                falloff_deg,
                ..
            } => at(0.0, cone(towards - light.position, radius_deg, falloff_deg)),
            LightKind::Area { u, v, nu, nv } => {
                // A single sample is in the middle.
                let half = |side: DVec3, n: u32| if n > 1 { side * 0.5 } else { DVec3::ZERO };
                let (u, v) = (half(u, nu), half(v, nv));
                at((u + v).length().max((u - v).length()), None)
            }
        };
        Some(if lamp.is_finite() {
            lamp
        } else {
            Self::Anywhere
        })
    }

    /// Where its light starts, as exactly as it is known: at each sample of an area
    /// light, where they are not too many.
    pub fn sources(light: &Light, eye: DVec3) -> Vec<Self> {
        const MOST_SAMPLES: u32 = 64;
        let whole = Self::of(light, eye);
        let (LightKind::Area { u, v, nu, nv }, Some(Self::At { centre, .. })) = (light.kind, whole)
        else {
            return whole.into_iter().collect();
        };
        if nu.saturating_mul(nv) > MOST_SAMPLES {
            return whole.into_iter().collect();
        }
        let rows = area_samples(nv).into_iter();
        rows.flat_map(|(q, _)| {
            let row = area_samples(nu).into_iter();
            row.map(move |(p, _)| Self::At {
                centre: centre + u * p + v * q,
                radius: 0.0,
                cone: None,
            })
        })
        .collect()
    }

    fn is_finite(&self) -> bool {
        match self {
            Self::At { centre, radius, .. } => centre.is_finite() && radius.is_finite(),
            Self::Sun { back, plane } => back.is_finite() && plane.is_finite(),
            Self::Anywhere => true,
        }
    }

    /// Can `ball` stand between the lamp and a point of `beam`? `false` is
    /// certain.
    pub fn may_be_blocked(&self, ball: &Sphere, beam: &Beam) -> bool {
        match *self {
            Self::Anywhere => true,
            Self::At {
                centre,
                radius,
                cone,
            } => {
                // A cone's angles take longer than all of the other.
                let is_dark = || cone.is_some_and(|cone| beam.is_outside(centre, cone));
                blocks_lamp(ball, beam, centre, radius) && !is_dark()
            }
            Self::Sun { back, plane } => blocks_sun(ball, beam, back, plane),
        }
    }
}

impl Lamp {
    /// Can a box stand between the lamp and a point of `beam`? Light and dark are not
    /// looked at: the ball around it is asked as well. `false` is certain: all points of the beam are within `off` of
    /// the middle one, and so is what lies between them and a light from that.
    pub fn may_be_blocked_by(&self, solid: &Solid, beam: &Beam) -> bool {
        if !beam.far.is_finite() {
            return true;
        }
        let middle = beam.direction * (0.5 * (beam.near + beam.far));
        let off = 0.5 * (beam.far - beam.near) + beam.slack(beam.far);
        match *self {
            Self::Anywhere => true,
            Self::At { centre, radius, .. } => {
                let margin = off + radius + ROUNDING * (beam.far + centre.length() + radius);
                solid.meets_segment(middle, centre, margin)
            }
            Self::Sun { back, .. } => {
                let margin = off + ROUNDING * (beam.far + solid.ball().centre.length());
                solid.meets_ray(middle, back, margin)
            }
        }
    }
}

/// POV-Ray's cone, and the reference's: full up to `radius_deg` and nothing
/// beyond `falloff_deg`; to the side and behind there is never any. From 90
/// degrees on POV-Ray's full light has no limit but that.
fn cone(axis: DVec3, radius_deg: f64, falloff_deg: f64) -> Option<(DVec3, f64)> {
    let axis = axis.try_normalize()?;
    let half = if radius_deg < 89.99 {
        radius_deg.max(falloff_deg)
    } else {
        90.0
    };
    half.is_finite()
        .then(|| (axis, half.clamp(0.0, 90.0).to_radians()))
}

fn blocks_lamp(ball: &Sphere, beam: &Beam, lamp: DVec3, lamp_radius: f64) -> bool {
    let (c, r) = (ball.centre, ball.radius);
    let to_ball = c.distance(lamp);
    let lamp_far = lamp.length() + lamp_radius;
    // No further counts; see the derivation above.
    let reach = beam
        .far
        .min((2.0 * lamp_far).max(2.0 * (to_ball + r + lamp_radius)));
    let mut slack = beam.slack(reach) + ROUNDING * (reach + lamp_far + to_ball);
    let near = beam.direction * beam.near;
    let is_endless = !beam.far.is_finite();
    let far = if is_endless {
        near
    } else {
        beam.direction * beam.far
    };
    if lamp_radius > 0.0 {
        let longest = near.distance(lamp).max(far.distance(lamp)) + lamp_radius;
        let longest = longest + beam.slack(beam.far);
        let past = (to_ball - r - lamp_radius).max(0.0) / longest;
        let share = if is_endless || past.is_nan() {
            1.0
        } else {
            (1.0 - past).clamp(0.0, 1.0)
        };
        slack += lamp_radius * share;
    }
    let squared = if is_endless {
        half_strip_squared(c, near, lamp, beam.direction)
    } else if beam.near == beam.far {
        segment_squared(c, near, lamp)
    } else {
        // All of the triangle is near the segment from the middle of its far side: as
        // a rule that is answer enough, and takes a third of the time.
        let half = 0.5 * (beam.far - beam.near);
        let middle = segment_squared(c, (near + far) * 0.5, lamp);
        if is_clear(middle, (r + slack + half) * (1.0 + ROUNDING)) {
            return false;
        }
        triangle_squared(c, near, far, lamp)
    };
    !is_clear(squared, r + slack)
}

fn blocks_sun(ball: &Sphere, beam: &Beam, back: DVec3, plane: f64) -> bool {
    let (c, r) = (ball.centre, ball.radius);
    let rounding = ROUNDING * (c.length() + plane.abs());
    // The light starts at the plane: what is behind it blocks nothing.
    if c.dot(back) - plane > r + rounding {
        return false;
    }
    // With P in the ball on the way from X to the sun, the law of sines in the
    // triangle eye, X, P: ‖X‖ ≤ ‖P‖/sin at X.
    let sine = beam.direction.cross(back).length() - beam.spread - 1e-12;
    let limit = if sine > 0.0 {
        (c.length() + r) * (1.0 + ROUNDING) / sine + beam.quantum.0
    } else {
        f64::INFINITY
    };
    if beam.near > limit + beam.slack(beam.near) {
        return false;
    }
    let far = beam.far.min(limit.max(beam.near));
    if !far.is_finite() {
        return true;
    }
    let (a, b) = (beam.direction * beam.near, beam.direction * far);
    let radius = r + beam.slack(far) + rounding + ROUNDING * far;
    // All of the strip is near the ray from its middle: as a rule that is answer enough.
    let from_middle = c - (a + b) * 0.5;
    let aside = from_middle - back * from_middle.dot(back).max(0.0);
    let half = 0.5 * (far - beam.near);
    if is_clear(aside.length_squared(), (radius + half) * (1.0 + ROUNDING)) {
        return false;
    }
    !is_clear(half_strip_squared(c, a, b, back), radius)
}

/// Can what is within `caster` shade anything of what is within `receiver`? All
/// in the world. `false` is certain.
pub fn may_shade(light: &Light, caster: &Bounds, receiver: &Bounds) -> bool {
    let (caster, receiver) = match (caster, receiver) {
        (Bounds::Empty, _) | (_, Bounds::Empty) => return false,
        (Bounds::Sphere(caster), Bounds::Sphere(receiver)) => (caster, receiver),
        _ => return Lamp::of(light, DVec3::ZERO).is_some(),
    };
    let ball = |ball: &Sphere| Sphere {
        centre: ball.centre - receiver.centre,
        // What the subtraction rounds away.
        radius: ball.radius * (1.0 + 1e-12) + 1e-14 * ball.centre.abs().max_element(),
    };
    let beam = Beam::to_ball(&ball(receiver), DVec3::Z);
    Lamp::of(light, receiver.centre).is_some_and(|lamp| lamp.may_be_blocked(&ball(caster), &beam))
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Rgb;
    use proptest::prelude::*;

    fn light(position: DVec3, kind: LightKind) -> Light {
        Light {
            position,
            colour: Rgb([1.0; 3]),
            kind,
            fade: None,
        }
    }

    fn vec3(range: f64) -> impl Strategy<Value = DVec3> {
        (-range..range, -range..range, -range..range).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    fn unit() -> impl Strategy<Value = DVec3> {
        vec3(1.0)
            .prop_filter("a direction", |v| v.length() > 0.1)
            .prop_map(DVec3::normalize)
    }

    fn beam(direction: DVec3, spread: f64, near: f64, far: f64) -> Beam {
        Beam {
            direction,
            spread,
            near,
            far,
            quantum: (0.0, 0.0),
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            max_global_rejects: 20_000,
            ..ProptestConfig::with_cases(20_000)
        })]

        /// Backwards: a blocked way is built, and must be found.
        #[test]
        fn a_ball_on_the_way_to_the_light_is_found(
            direction in unit(), off in unit(), spread in 0.0..0.4_f64, at in 0.0..1.0_f64,
            near in 0.0..10.0_f64, depth in 0.0..10.0_f64, endless in 0_u32..3,
            place in vec3(20.0), sides in (vec3(4.0), vec3(4.0)), corner in (-0.5..0.5_f64, -0.5..0.5_f64),
            (kind, way) in (0_u32..3, 0.0..1.0_f64), radius in 0.0..3.0_f64, out in unit(), share in 0.0..1.0_f64,
        ) {
            let mut near_and_far = (near, near + depth);
            let mut t = near + depth * at;
            if endless == 0 {
                near_and_far.1 = f64::INFINITY;
                t = near + depth * 1e4_f64.powf(at);
            } else if endless == 1 {
                near_and_far.1 = near;
                t = near;
            }
            let beam = beam(direction, spread, near_and_far.0, near_and_far.1);
            // A direction on the sphere that is at most `spread` off.
            let aside = (off - direction * off.dot(direction)).normalize_or_zero();
            let angle = 2.0 * (0.5 * spread).asin() * share;
            let x = (direction * angle.cos() + aside * angle.sin()) * t;
            let (place, kind, end) = match kind {
                0 => (place, LightKind::Point, place),
                1 => (
                    place,
                    LightKind::Area { u: sides.0, v: sides.1, nu: 3, nv: 4 },
                    place + sides.0 * corner.0 + sides.1 * corner.1,
                ),
                _ => {
                    // Where the ray of the sun through x comes from its plane; behind
                    // that there is no shadow: then the sun is moved back.
                    let towards = place + sides.0;
                    let back = (place - towards).normalize_or_zero();
                    let ahead = (place - x).dot(back);
                    let (place, ahead) = if ahead < 0.0 {
                        (place + back * (1.0 - ahead), 1.0)
                    } else {
                        (place, ahead)
                    };
                    (place, LightKind::Sun { towards }, x + back * ahead)
                }
            };
            let p = x + (end - x) * way;
            let ball = Sphere { centre: p + out * (radius * share), radius };
            let lamp = Lamp::of(&light(place, kind), DVec3::ZERO).unwrap();
            prop_assert!(lamp.may_be_blocked(&ball, &beam), "{lamp:?} {ball:?} {beam:?} {x}");
        }

        #[test]
        fn what_stands_between_two_balls_and_a_light_may_shade(
            receiver in vec3(20.0), radii in (0.0..3.0_f64, 0.0..3.0_f64),
            from in unit(), out in unit(), way in 0.0..1.0_f64, place in vec3(20.0),
        ) {
            let x = receiver + from * radii.0;
            let p = x + (place - x) * way;
            let receiver = Bounds::sphere(receiver, radii.0);
            let light = light(place, LightKind::Point);
            prop_assert!(may_shade(&light, &Bounds::sphere(p + out * radii.1, radii.1), &receiver));
        }

        #[test]
        fn a_lit_point_is_not_outside_of_the_cone(
            direction in unit(), near in 0.0..10.0_f64, depth in 0.0..10.0_f64, at in 0.0..1.0_f64,
            apex in vec3(10.0), aim in unit(), half in 1.0..90.0_f64,
        ) {
            let beam = beam(direction, 0.0, near, near + depth);
            let x = direction * (near + depth * at) - apex;
            let cosine = x.normalize_or_zero().dot(aim);
            if cosine > half.to_radians().cos() {
                prop_assert!(!beam.is_outside(apex, (aim, half.to_radians())));
            }
        }

        #[test]
        fn a_ball_on_a_ray_is_seen(
            direction in unit(), off in unit(), spread in 0.0..0.4_f64, share in 0.0..1.0_f64,
            t in 0.0..20.0_f64, radius in 0.0..3.0_f64, out in unit(),
        ) {
            let aside = (off - direction * off.dot(direction)).normalize_or_zero();
            let angle = 2.0 * (0.5 * spread).asin() * share;
            let point = (direction * angle.cos() + aside * angle.sin()) * t;
            let ball = Sphere { centre: point + out * (radius * share), radius };
            prop_assert!(beam(direction, spread, 0.0, t).may_show(&ball, true));
        }
    }

    #[test]
    fn what_is_beside_or_beyond_blocks_nothing() {
        let point = Lamp::of(
            &light(DVec3::new(0.0, 10.0, 10.0), LightKind::Point),
            DVec3::ZERO,
        );
        let point = point.unwrap();
        let surface = beam(DVec3::Z, 1e-4, 10.0, 10.0);
        let ball = |x: f64, y: f64, radius: f64| Sphere {
            centre: DVec3::new(x, y, 10.0),
            radius,
        };
        assert!(point.may_be_blocked(&ball(0.5, 5.0, 1.0), &surface));
        assert!(!point.may_be_blocked(&ball(1.5, 5.0, 1.0), &surface));
        assert!(
            !point.may_be_blocked(&ball(0.0, 12.0, 1.0), &surface),
            "above the lamp"
        );
        assert!(
            !point.may_be_blocked(&ball(0.0, -3.0, 1.0), &surface),
            "below the ground"
        );
        assert!(
            point.may_be_blocked(&ball(3.0, 10.0, 4.0), &surface),
            "around the lamp"
        );
        let sun = LightKind::Sun {
            towards: DVec3::new(0.0, 0.0, 10.0),
        };
        let sun = Lamp::of(&light(DVec3::new(0.0, 10.0, 10.0), sun), DVec3::ZERO).unwrap();
        assert!(sun.may_be_blocked(&ball(0.5, 5.0, 1.0), &surface));
        assert!(
            !sun.may_be_blocked(&ball(0.5, 15.0, 1.0), &surface),
            "behind the sun"
        );
    }

    #[test]
    fn a_caster_beside_or_below_a_receiver_does_not_shade_it() {
        let lamp = light(DVec3::Y * 10.0, LightKind::Point);
        let ball = |x: f64, y: f64| Bounds::sphere(DVec3::new(x, y, 0.0), 1.0);
        assert!(may_shade(&lamp, &ball(1.0, 5.0), &ball(0.0, 0.0)));
        assert!(!may_shade(&lamp, &ball(2.5, 5.0), &ball(0.0, 0.0)));
        assert!(!may_shade(&lamp, &ball(0.0, -3.0), &ball(0.0, 0.0)));
        assert!(!may_shade(&lamp, &Bounds::Empty, &Bounds::Unbounded));
        assert!(may_shade(&lamp, &ball(9.0, 0.0), &Bounds::Unbounded));
        let dark = Light {
            colour: Rgb([0.0; 3]),
            ..lamp
        };
        assert!(!may_shade(&dark, &ball(1.0, 5.0), &ball(0.0, 0.0)));
    }

    #[test]
    fn black_lights_are_none_and_odd_ones_are_anywhere() {
        let mut lamp = light(DVec3::Y, LightKind::Point);
        lamp.colour = Rgb([0.0; 3]);
        assert!(Lamp::of(&lamp, DVec3::ZERO).is_none());
        lamp.colour = Rgb([0.0, f64::NAN, 0.0]);
        assert!(Lamp::of(&lamp, DVec3::ZERO).is_some());
        lamp.position = DVec3::NAN;
        assert!(matches!(Lamp::of(&lamp, DVec3::ZERO), Some(Lamp::Anywhere)));
        let sun = light(DVec3::Y, LightKind::Sun { towards: DVec3::Y });
        assert!(matches!(Lamp::of(&sun, DVec3::ZERO), Some(Lamp::Anywhere)));
    }
}

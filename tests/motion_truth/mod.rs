//! The truth that measures of motion are held against: points of the sphere,
//! moved and projected, in `f64` where many are needed and in 106 bits where it
//! is decided.
#![allow(dead_code, reason = "each test uses its part")]

pub mod dd;

use dd::{Dd, V};
use decor::motion::{Lenses, RelativeMotion};
use glam::{DVec2, DVec3};

/// Random numbers (SplitMix64): the same on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    pub fn range(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.unit()
    }

    /// Evenly in its logarithm.
    pub fn log(&mut self, from: f64, to: f64) -> f64 {
        self.range(from.ln(), to.ln()).exp()
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    pub fn chance(&mut self, part: f64) -> bool {
        self.unit() < part
    }

    pub fn direction(&mut self) -> DVec3 {
        let z = self.range(-1.0, 1.0);
        let (sin, cos) = self.range(0.0, std::f64::consts::TAU).sin_cos();
        let w = (1.0 - z * z).sqrt();
        DVec3::new(w * cos, w * sin, z)
    }
}

/// How far the point u (‖u‖ ≤ 1) of the ball moves in the picture, in pixels.
/// Nothing but the motion itself is subtracted.
pub fn displacement_px(m: &RelativeMotion, lenses: &Lenses, u: DVec3) -> f64 {
    let cos = (1.0 - m.half_turn.length_squared()).max(0.0).sqrt();
    let w = m.half_turn.cross(u);
    let d = 2.0 * (cos * w + m.half_turn.cross(w));
    let step = m.delta + m.radius * d;
    let p = m.centre_before + m.radius * u;
    let q = p.z + step.z;
    let x = lenses.before * p.truncate() / p.z;
    ((lenses.after * step.truncate() + lenses.delta * p.truncate() - step.z * x) / q).length()
}

/// The same in 106 bits, of the direction of u.
pub fn exact_px(m: &RelativeMotion, lenses: &Lenses, u: DVec3) -> f64 {
    let (u, h, radius) = (V::from(u).unit(), V::from(m.half_turn), Dd::from(m.radius));
    let cos = (Dd::ONE - h.dot(h)).sqrt();
    let w = h.cross(u);
    let d = (w * cos + h.cross(w)) * Dd::from(2.0);
    let (p, delta) = (V::from(m.centre_before) + u * radius, V::from(m.delta));
    let step = delta + d * radius;
    let q = p + step;
    let axis = |i: usize, before: f64, after: f64| {
        (Dd::from(after) * step.0[i] + (Dd::from(after) - Dd::from(before)) * p.0[i]
            - step.0[2] * Dd::from(before) * p.0[i] / p.0[2])
            / q.0[2]
    };
    let (x, y) = (
        axis(0, lenses.before.x, lenses.after.x),
        axis(1, lenses.before.y, lenses.after.y),
    );
    (x * x + y * y).sqrt().value()
}

/// The point that moves farthest, of `many` spread over the sphere and of those
/// where theory puts a maximum, climbed up from the best for `steps`.
pub fn farthest(
    m: &RelativeMotion,
    lenses: &Lenses,
    many: u32,
    steps: u32,
    random: &mut Random,
) -> (f64, DVec3) {
    let mut best = (-1.0, DVec3::Z);
    let mut look = |u: DVec3| {
        let moved = displacement_px(m, lenses, u);
        if moved > best.0 {
            best = (moved, u);
        }
    };
    for u in [
        DVec3::Z,
        -DVec3::Z,
        DVec3::X,
        -DVec3::X,
        DVec3::Y,
        -DVec3::Y,
    ] {
        look(u);
    }
    let ray = m.centre_before.normalize();
    look(-ray);
    let outwards = (m.centre_before * DVec3::new(1.0, 1.0, 0.0)).normalize_or(DVec3::X);
    let along = (m.delta * DVec3::new(1.0, 1.0, 0.0)).normalize_or(DVec3::Y);
    let axis = m.half_turn.normalize_or(DVec3::Z);
    let r = m.radius / m.centre_before.z;
    for side in [
        outwards,
        along,
        axis.cross(along),
        axis.cross(-ray),
        axis.cross(outwards),
    ] {
        for t in [0.0, -r, -(r * r), -0.5 - 0.5 * r] {
            let w = (1.0 - t * t).max(0.0).sqrt();
            for sign in [1.0, -1.0] {
                let u = side * (sign * w) + DVec3::Z * t;
                look(u.normalize_or(DVec3::X));
            }
        }
    }
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    for i in 0..many {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(many);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let w = (1.0 - z * z).sqrt();
        look(DVec3::new(w * cos, w * sin, z));
    }
    let mut reach = 0.5;
    let mut failures = 0;
    for _ in 0..steps {
        let u = (best.1 + random.direction() * reach).normalize();
        let moved = displacement_px(m, lenses, u);
        if moved > best.0 {
            best = (moved, u);
            failures = 0;
        } else {
            failures += 1;
            if failures > 3 {
                reach *= 0.6;
                failures = 0;
            }
        }
    }
    best
}

/// A motion to measure, and what kind it is.
pub struct Case {
    pub kind: &'static str,
    pub motion: RelativeMotion,
    pub lenses: Lenses,
    /// R/D, the larger of both instants.
    pub ratio: f64,
}

/// A random or adversarial motion of a sphere that is in front at both
/// instants.
pub fn case(random: &mut Random) -> Case {
    loop {
        if let Some(case) = attempt(random) {
            return case;
        }
    }
}

fn attempt(random: &mut Random) -> Option<Case> {
    let distance = if random.chance(0.9) {
        random.log(0.1, 100.0)
    } else {
        random.log(1e-9, 1e9)
    };
    let ratio = match random.below(10) {
        0 => random.log(1e-12, 1e-3),
        1..=3 => random.log(1e-3, 1.0),
        4..=8 => random.range(0.0, 0.8),
        _ => 1.0 - random.log(1e-3, 0.2),
    };
    let radius = ratio * distance;
    // The view is up to 60° to the side, sometimes 89.9°; sometimes on the axis.
    let side = match random.below(20) {
        0 => 0.0,
        1 => random.range(0.0, 89.9),
        2 => random.log(1e-9, 1.0),
        _ => random.range(0.0, 60.0),
    };
    let (sin, cos) = side.to_radians().sin_cos();
    let (s, c) = random.range(0.0, std::f64::consts::TAU).sin_cos();
    let mut centre = DVec3::new(sin * c, sin * s, cos) * distance;
    if random.chance(0.02) {
        // All but tangent to the plane of the eye.
        centre.z = radius * (1.0 + random.log(1e-12, 1e-2));
    }
    let small = random.log(1e-12, 1.0);
    let angle = if random.chance(0.05) {
        std::f64::consts::PI
    } else {
        random.log(1e-12, 3.2)
    };
    let turn = |axis: DVec3, angle: f64| axis * (angle * 0.5).sin();
    let axis = random.direction();
    let gap = centre.z - radius;
    let focal = DVec2::splat(random.log(10.0, 10_000.0));
    let mut lenses = Lenses::fixed(focal);
    let (kind, delta, half) = match random.below(12) {
        0 | 1 => (
            "translation",
            random.direction() * distance * small,
            DVec3::ZERO,
        ),
        2 => (
            "near translation",
            random.direction() * gap * small,
            DVec3::ZERO,
        ),
        3 | 4 => ("rotation", DVec3::ZERO, turn(axis, angle)),
        5 | 6 => {
            let length = radius * 2.0 * (angle * 0.5).sin() * random.range(0.2, 5.0);
            ("both alike", random.direction() * length, turn(axis, angle))
        }
        7 => (
            "both",
            random.direction() * distance * small,
            turn(axis, angle),
        ),
        8 => (
            "along the ray",
            centre * (random.range(-1.0, 1.0) * small),
            turn(axis, angle * small),
        ),
        9 => {
            // The observer pans: the sphere turns about the eye.
            let h = turn(axis, angle * random.range(0.0, 0.3));
            let w = h.cross(centre);
            let delta = 2.0 * ((1.0 - h.length_squared()).sqrt() * w + h.cross(w));
            ("pan", delta, h)
        }
        10 => {
            // The observer goes round, and looks at the object: it only turns.
            let h = turn(DVec3::new(axis.x, axis.y, 0.0).normalize(), angle);
            (
                "orbit",
                random.direction() * radius * angle * 1e-3 * random.unit(),
                h,
            )
        }
        _ => {
            // Nearer, and a wider lens: the centre stays as large.
            let step = centre.z * small * random.range(-0.8, 0.8);
            lenses = Lenses::zoom(focal, focal * ((centre.z + step) / centre.z));
            let tilt = random.direction() * step * random.unit() * 0.2;
            (
                "dolly zoom",
                DVec3::Z * step + tilt,
                turn(axis, angle * small),
            )
        }
    };
    match random.below(10) {
        0 => {
            lenses = Lenses::zoom(
                focal,
                focal * (1.0 + random.range(-0.5, 0.5) * random.log(1e-9, 1.0)),
            )
        }
        1 => {
            let wide = DVec2::new(1.0, random.log(0.1, 10.0));
            lenses = Lenses::zoom(lenses.before * wide, lenses.after * wide);
        }
        _ => {}
    }
    let motion = RelativeMotion::in_camera_space(centre, delta, half, radius);
    let after = motion.centre_after;
    let in_front = after.z - radius > 1e-12 * after.length() && centre.z > radius;
    let larger = (radius / centre.length()).max(radius / after.length());
    in_front.then_some(Case {
        kind,
        motion,
        lenses,
        ratio: larger,
    })
}

/// The value that `part` of the sorted values do not exceed.
pub fn quantile(sorted: &[f64], part: f64) -> f64 {
    if sorted.is_empty() {
        return f64::NAN;
    }
    sorted[((sorted.len() - 1) as f64 * part).round() as usize]
}

//! A small world that turns suddenly, and what it looks like.

use std::collections::BTreeSet;

use serde_json::{Value, json};

pub type V = [f64; 3];

pub const SIZE: [u32; 2] = [96, 72];

/// SplitMix64: the same on every machine.
pub struct Random(pub u64);

impl Random {
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
    pub fn range(&mut self, a: f64, b: f64) -> f64 {
        a + (b - a) * (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn below(&mut self, n: u64) -> usize {
        (self.bits() % n) as usize
    }
    pub fn vector(&mut self, far: f64) -> V {
        [0; 3].map(|_| self.range(-far, far))
    }
}

#[derive(Clone)]
pub struct Thing {
    pub name: String,
    pub path: &'static str,
    pub position: V,
    pub angles: V,
    pub velocity: V,
    pub spin: V,
    pub there: bool,
}

#[derive(Clone)]
pub struct World {
    pub eye: V,
    pub eye_velocity: V,
    pub aim: V,
    pub aim_velocity: V,
    pub angles: [f64; 2],
    pub light: f64,
    pub things: Vec<Thing>,
}

pub fn plus(a: V, b: V, times: f64) -> V {
    std::array::from_fn(|i| a[i] + b[i] * times)
}

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V, b: V) -> V {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub fn unit(a: V) -> V {
    a.map(|x| x / dot(a, a).sqrt())
}

impl World {
    pub fn new(random: &mut Random) -> Self {
        let things = (0..14).map(|k| Thing {
            name: format!("thing_{k}"),
            path: if k % 5 == 0 { "brick" } else { "ball" },
            position: plus([0.0, 0.0, 14.0], random.vector(11.0), 1.0),
            angles: random.vector(180.0),
            velocity: [0.0; 3],
            spin: [0.0; 3],
            there: k < 11,
        });
        Self {
            eye: [0.0, 0.0, -30.0],
            eye_velocity: [0.0; 3],
            aim: [0.0, 0.0, 10.0],
            aim_velocity: [0.0; 3],
            angles: [50.0, 38.55],
            light: 0.9,
            things: things.collect(),
        }
    }

    /// As velocities have it, so many frames later.
    pub fn after(&self, steps: f64) -> Self {
        let mut world = self.clone();
        world.eye = plus(self.eye, self.eye_velocity, steps);
        world.aim = plus(self.aim, self.aim_velocity, steps);
        for thing in &mut world.things {
            thing.position = plus(thing.position, thing.velocity, steps);
            thing.angles = plus(thing.angles, thing.spin, steps);
        }
        world
    }

    /// Something happens that nobody could know of.
    pub fn surprise(&mut self, random: &mut Random) {
        let speed = [0.0, 0.03, 0.08, 0.7][random.below(4)];
        let k = random.below(self.things.len() as u64);
        let thing = &mut self.things[k];
        match random.below(10) {
            0 | 1 => {
                // The observer turns.
                self.eye_velocity = random.vector(speed);
                self.aim_velocity = self.eye_velocity;
            }
            2 => {
                self.eye_velocity = [0.0; 3];
                self.aim_velocity = random.vector(speed);
            }
            3 => {
                self.eye = [random.range(-5.0, 5.0), random.range(-4.0, 4.0), -30.0];
                self.eye_velocity = random.vector(0.06);
            }
            4 => thing.there = !thing.there,
            5 => {
                let position = plus([0.0, 0.0, 14.0], random.vector(11.0), 1.0);
                thing.position = position;
                thing.velocity = random.vector(0.04);
            }
            6 => {
                let speed = [0.0, 0.1, 9.0][random.below(3)];
                thing.spin = random.vector(speed);
            }
            7 if random.below(3) == 0 => self.light = random.range(0.4, 1.0),
            7 if random.below(3) == 0 => self.angles[0] = random.range(45.0, 55.0),
            _ => thing.velocity = random.vector(speed),
        }
    }

    pub fn scene(&self, number: u32) -> Value {
        let objects: Vec<Value> = self
            .things
            .iter()
            .filter(|thing| thing.there)
            .map(|thing| {
                json!({"path": thing.path, "name": thing.name, "position": thing.position,
                       "angles": thing.angles, "velocity": thing.velocity,
                       "angles_velocity": thing.spin})
            })
            .collect();
        let light = [self.light; 3];
        json!({"scene": number, "size": SIZE, "angles": self.angles,
               "eye": {"position": self.eye, "velocity": self.eye_velocity},
               "aim": {"position": self.aim, "velocity": self.aim_velocity},
               "lights": [{"type": "sun", "position": [-20, 30, -40], "colour": light}],
               "background": [0.3, 0.4, 0.6], "objects": objects})
    }

    pub fn thing(&self, name: &str) -> Option<&Thing> {
        self.things
            .iter()
            .find(|thing| thing.there && thing.name == name)
    }

    /// Where a point is in the picture, in pixels; `None` behind the observer.
    pub fn see(&self, point: V) -> Option<[f64; 2]> {
        let z = unit(plus(self.aim, self.eye, -1.0));
        let x = unit(cross([0.0, 1.0, 0.0], z));
        let y = cross(z, x);
        let seen = plus(point, self.eye, -1.0);
        let depth = dot(seen, z);
        let focal =
            |side: u32, angle: f64| f64::from(side) / (2.0 * (angle / 2.0).to_radians().tan());
        (depth > 0.0).then(|| {
            [
                f64::from(SIZE[0]) / 2.0 + focal(SIZE[0], self.angles[0]) * dot(seen, x) / depth,
                f64::from(SIZE[1]) / 2.0 - focal(SIZE[1], self.angles[1]) * dot(seen, y) / depth,
            ]
        })
    }
}

pub fn in_picture(point: [f64; 2]) -> bool {
    (0..2).all(|i| (0.0..f64::from(SIZE[i])).contains(&point[i]))
}

impl Thing {
    /// A point of it in the world: turned about x, y, z, then moved.
    pub fn place(&self, [x, y, z]: V) -> V {
        let [a, b, c] = self.angles.map(f64::to_radians);
        let [x, y, z] = [x, y * a.cos() - z * a.sin(), y * a.sin() + z * a.cos()];
        let [x, y, z] = [x * b.cos() + z * b.sin(), y, -x * b.sin() + z * b.cos()];
        let turned = [x * c.cos() - y * c.sin(), x * c.sin() + y * c.cos(), z];
        plus(self.position, turned, 1.0)
    }

    /// Points of its surface, in its own coordinates.
    pub fn points(&self) -> Vec<V> {
        const COUNT: usize = 200;
        let sphere = (0..COUNT).map(|k| {
            let y = 1.0 - 2.0 * (k as f64 + 0.5) / COUNT as f64;
            let (angle, r) = (k as f64 * 2.399_963, (1.0 - y * y).sqrt());
            [r * angle.cos(), y, r * angle.sin()]
        });
        match self.path {
            "ball" => sphere.collect(),
            // Out to the sides of the brick.
            _ => sphere
                .map(|p| {
                    let most = p.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
                    let on_cube = p.map(|x| x / most);
                    [on_cube[0] * 1.5, on_cube[1] * 0.6, on_cube[2] * 0.8]
                })
                .collect(),
        }
    }
}

pub fn objects_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let colour = |rgb: &str| format!("(colour: {rgb}, ambient: 0.2, diffuse: 0.7)");
    let ball = colour("(0.9, 0.5, 0.1)");
    let brick = colour("(0.2, 0.7, 0.3)");
    write("ball.ron", &format!("material({ball}, sphere(radius: 1))"));
    write(
        "brick.ron",
        &format!("material({brick}, box(min: (-1.5, -0.6, -0.8), max: (1.5, 0.6, 0.8)))"),
    );
    folder
}

/// The largest motion of an object from one world to another, of its points that
/// either shows in the picture.
pub fn motion(name: &str, from: &World, to: &World) -> f64 {
    let (a, b) = (from.thing(name).unwrap(), to.thing(name).unwrap());
    let mut most = 0.0_f64;
    for point in a.points() {
        let (before, after) = (from.see(a.place(point)), to.see(b.place(point)));
        let shows = |p: Option<[f64; 2]>| p.is_some_and(in_picture);
        if !shows(before) && !shows(after) {
            continue;
        }
        let (Some(p), Some(q)) = (before, after) else {
            return f64::INFINITY;
        };
        most = most.max((p[0] - q[0]).hypot(p[1] - q[1]));
    }
    most
}

/// What a validity check has seen.
#[derive(Default, Debug)]
pub struct Seen {
    pub slow: usize,
    pub immobile: usize,
    pub clipped: usize,
    pub fast: usize,
    pub dissolved: usize,
    pub largest_px: f64,
}

/// Is every object of the décor of a frame where its class says?
pub fn check_frame(number: usize, start: usize, begin: &Value, worlds: &[World], seen: &mut Seen) {
    let threshold = begin["threshold_px"].as_f64().unwrap();
    let (made, now) = (&worlds[start], &worlds[number]);
    if !begin["whole"].is_null() {
        return;
    }
    assert_eq!(made.light, now.light, "frame {number}");
    assert_eq!(made.angles, now.angles, "frame {number}");
    for object in begin["objects"].as_array().unwrap() {
        let name = object["name"].as_str().unwrap();
        let class = object["class"].as_str().unwrap();
        let what = format!("{name}, {class}, in frame {number} of the period from {start}");
        if class == "fast" {
            seen.fast += 1;
            continue;
        }
        assert!(made.thing(name).is_some(), "{what}");
        let thing = now.thing(name).unwrap_or_else(|| panic!("{what}"));
        let moved = motion(name, made, now);
        match class {
            "immobile" => {
                seen.immobile += 1;
                assert_eq!(moved, 0.0, "{what}");
            }
            "slow" => {
                seen.slow += 1;
                seen.largest_px = seen.largest_px.max(moved);
                assert!(moved <= threshold, "{what}: {moved} px");
                if let Some(until) = begin["dissolves_until"].as_u64() {
                    seen.dissolved += 1;
                    let target = made.after((until as usize - start) as f64);
                    let onward = motion(name, now, &target);
                    assert!(onward <= threshold, "{what}: {onward} px onward");
                }
            }
            "clipped" => {
                seen.clipped += 1;
                let shows = |p: &V| now.see(thing.place(*p)).is_some_and(in_picture);
                assert!(!thing.points().iter().any(shows), "{what}");
            }
            other => panic!("{other}"),
        }
    }
}

/// Worlds of 200 scenes, and the frames in which something happened.
pub fn turning_worlds(seed: u64) -> (Vec<World>, BTreeSet<u64>) {
    let mut random = Random(seed);
    let mut worlds = vec![World::new(&mut random)];
    let mut surprises = BTreeSet::new();
    let mut next = 3;
    for number in 1..200 {
        let mut world = worlds.last().unwrap().after(1.0);
        if number == next {
            for _ in 0..=random.below(3) {
                world.surprise(&mut random);
            }
            surprises.insert(number as u64);
            next += 1 + random.below(10);
        }
        worlds.push(world);
    }
    (worlds, surprises)
}

//! Random scenes: solids, mirrors and glass under all kinds of lights, with
//! something that changed among them. The same on every machine.

use std::sync::Arc;

use decor::influence::{
    Changed, Depths, Influence, Mask, Solid, Still, influence, is_slender, parts,
};
use decor::motion::screen_box;
use decor_api::{
    Adapter, Antialias, Bounds, Camera, Csg, Extent, Fade, Geometry, Highlight, Instance, Layer,
    LayerRequest, LayerShot, Light, LightKind, Material, Optics, Output, Pose, Prototype,
    PrototypeTable, Region, Rgb, RunContext, Scene, Size, Window,
};
use glam::DVec3;

/// Random numbers (SplitMix64).
pub struct Dice(pub u64);

impl Dice {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n
    }

    pub fn chance(&mut self, percent: u64) -> bool {
        self.below(100) < percent
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (self.next() >> 11) as f64 / (1_u64 << 53) as f64 * (high - low)
    }

    pub fn vec3(&mut self, range: f64) -> DVec3 {
        DVec3::new(
            self.within(-range, range),
            self.within(-range, range),
            self.within(-range, range),
        )
    }
}

/// A scene whose first instances are the décor, and the rest what changed.
#[derive(Clone)]
pub struct Case {
    pub scene: Scene,
    pub decor_count: usize,
    pub size: Size,
    pub antialias: Option<Antialias>,
}

/// Adds a neutral solid to the table; gives its instance.
pub fn instance(table: &mut PrototypeTable, csg: Csg, pose: Pose) -> Instance {
    insert(table, csg, pose, false)
}

/// The same; `by_boxes`: every other solid is known by boxes, as a renderer's own
/// objects are.
fn insert(table: &mut PrototypeTable, csg: Csg, pose: Pose, by_boxes: bool) -> Instance {
    let hash = format!("{csg:?}");
    let optics = if csg.is_optical() {
        Optics::Optical("its material".to_owned())
    } else {
        Optics::Opaque
    };
    let mut prototype = Prototype {
        extents: Vec::new(),
        path: hash.clone().into(),
        hash,
        bounds: csg.bounds(),
        geometry: Geometry::Neutral(csg),
        optics,
        unlayerable: None,
    };
    if by_boxes && prototype.hash.len().is_multiple_of(2) {
        prototype.extents = boxes(&prototype);
    }
    let prototype = table.insert(prototype);
    Instance { prototype, pose }
}

/// Boxes that enclose a prototype together.
fn boxes(prototype: &Prototype) -> Vec<Extent> {
    if let Geometry::Neutral(Csg::Box { min, max }) = prototype.geometry {
        return vec![Extent { min, max }];
    }
    let balls = match (parts(prototype), prototype.bounds) {
        (balls, Bounds::Sphere(whole)) if balls.is_empty() => vec![whole],
        (balls, _) => balls,
    };
    let around = balls.iter().map(|ball| Extent {
        min: ball.centre - ball.radius,
        max: ball.centre + ball.radius,
    });
    around.collect()
}

/// A box so many times as large.
pub fn smaller(extent: &Extent, share: f64) -> Extent {
    let (middle, half) = (
        (extent.min + extent.max) * 0.5,
        (extent.max - extent.min) * 0.5,
    );
    Extent {
        min: middle - half * share,
        max: middle + half * share,
    }
}

impl Case {
    /// The décor alone.
    pub fn decor(&self) -> Scene {
        let mut decor = self.scene.clone();
        decor.instances.truncate(self.decor_count);
        decor
    }

    /// What can differ. `samples`: the depth of all samples, where it is given.
    pub fn mask(
        &self,
        table: &PrototypeTable,
        depth: &Layer,
        samples: Option<(&Layer, u32)>,
    ) -> Mask {
        self.mask_of_smaller(1.0, table, depth, samples, None)
    }

    /// As [`Self::mask`], where what changed had spheres so many times as large:
    /// a mask that is wrong.
    pub fn mask_of_smaller(
        &self,
        share: f64,
        table: &PrototypeTable,
        depth: &Layer,
        samples: Option<(&Layer, u32)>,
        by_blocks: Option<u32>,
    ) -> Mask {
        let (decor, changed) = self.scene.instances.split_at(self.decor_count);
        let (camera, size) = (&self.scene.camera, self.size);
        let optical: Vec<Window> = decor
            .iter()
            .filter(|i| table.get(i.prototype).optics.is_optical())
            .map(|i| {
                let bounds = table.get(i.prototype).bounds.posed(&i.pose);
                screen_box(&bounds, camera, size).window()
            })
            .collect();
        let slender: Vec<Bounds> = decor
            .iter()
            .filter(|i| is_slender(table.get(i.prototype), &i.pose, camera, size))
            .map(|i| table.get(i.prototype).bounds.posed(&i.pose))
            .collect();
        let changed: Vec<Changed> = changed
            .iter()
            .map(|i| {
                let mut object = Changed::placed(
                    table.get(i.prototype),
                    &parts(table.get(i.prototype)),
                    &i.pose,
                );
                object.parts.iter_mut().for_each(|p| p.radius *= share);
                let extents = table.get(i.prototype).extents.iter();
                let extents = extents.map(|extent| smaller(extent, share));
                object.boxes = extents.map(|e| Solid::placed(&e, &i.pose)).collect();
                if let Bounds::Sphere(whole) = &mut object.whole {
                    whole.radius *= share;
                }
                object
            })
            .collect();
        let still = Still {
            camera,
            size,
            lights: &self.scene.lights,
            shadows: self.scene.shadows,
            antialiased: self.antialias.is_some(),
            by_blocks,
            depths: match samples {
                Some((samples, n)) => Depths::with_samples(depth, samples, n),
                None => Depths::at_centres(depth),
            },
            optical: &optical,
            slender: &slender,
        };
        match influence(&still, &changed, None) {
            Influence::Confined(mask) => mask,
            Influence::Everything(reason) => panic!("{reason}"),
        }
    }
}

/// Renders whole pictures, all of one kind, in one call.
pub fn render(
    adapter: &dyn Adapter,
    run: &RunContext,
    table: &PrototypeTable,
    scenes: Vec<Scene>,
    size: Size,
    output: Output,
    antialias: Option<Antialias>,
) -> Vec<Layer> {
    let shots = (1..).zip(scenes).map(|(frame, scene)| LayerShot {
        frame,
        scene: Arc::new(scene),
        region: Region::Window(size.window()),
    });
    let request = LayerRequest {
        prototypes: table,
        size,
        output,
        antialias,
        shots: shots.collect(),
        film: None,
        label: "influence".to_owned(),
    };
    adapter.render(&request, run).expect("it renders")
}

/// The pixels whose colours are not the same bits.
pub fn differing(a: &Layer, b: &Layer, size: Size) -> Vec<(u32, u32)> {
    let (a, b) = (a.colour.as_ref().unwrap(), b.colour.as_ref().unwrap());
    let is_same = |i: usize| a[i].map(f32::to_bits) == b[i].map(f32::to_bits);
    (0..size.pixels())
        .filter(|&i| !is_same(i))
        .map(|i| (i as u32 % size.width, i as u32 / size.width))
        .collect()
}

fn material(dice: &mut Dice) -> Material {
    let kind = dice.below(100);
    Material {
        colour: Rgb([
            dice.within(0.1, 1.0),
            dice.within(0.1, 1.0),
            dice.within(0.1, 1.0),
        ]),
        ambient: 0.1,
        diffuse: 0.7,
        highlight: match dice.below(3) {
            0 => Highlight::Phong {
                amount: 0.5,
                size: 20.0,
            },
            1 => Highlight::Specular {
                amount: 0.6,
                roughness: 0.05,
            },
            _ => Highlight::None,
        },
        reflection: if kind < 9 { dice.within(0.1, 0.9) } else { 0.0 },
        transmission: if (9..18).contains(&kind) { 0.6 } else { 0.0 },
        ior: if kind < 12 { 1.3 } else { 1.0 },
    }
}

fn solid(dice: &mut Dice, depth: u32) -> Csg {
    let r = if dice.chance(15) {
        dice.within(0.02, 0.2)
    } else {
        dice.within(0.3, 1.5)
    };
    let sphere = |centre: DVec3, radius: f64| Csg::Sphere { centre, radius };
    match dice.below(if depth == 0 { 9 } else { 5 }) {
        0 => sphere(dice.vec3(0.5), r),
        1 => {
            let half = DVec3::new(r, dice.within(0.05, 1.5), dice.within(0.05, 1.5));
            Csg::Box {
                min: -half,
                max: half,
            }
        }
        2 => Csg::Cylinder {
            base: DVec3::Y * -dice.within(0.1, 2.0),
            cap: dice.vec3(0.6) + DVec3::Y,
            radius: 0.6 * r,
        },
        3 => Csg::Cone {
            base: DVec3::Y * -dice.within(0.1, 1.0),
            base_radius: r,
            cap: DVec3::Y * dice.within(0.2, 1.5),
            cap_radius: if dice.chance(50) { 0.0 } else { 0.4 * r },
        },
        4 => Csg::Torus {
            major: 1.0,
            minor: (0.4 * r).min(0.9),
        },
        5 => Csg::Union((0..2 + dice.below(4)).map(|_| moved(dice)).collect()),
        6 => Csg::Difference(
            Box::new(sphere(DVec3::ZERO, 1.2)),
            vec![solid(dice, 1), sphere(dice.vec3(1.0), 0.6)],
        ),
        7 => Csg::Intersection(vec![solid(dice, 1), sphere(dice.vec3(0.5), 1.1)]),
        _ => Csg::Scale(
            DVec3::new(dice.within(0.3, 2.0), 1.0, dice.within(0.3, 1.5)),
            Box::new(solid(dice, 1)),
        ),
    }
}

fn moved(dice: &mut Dice) -> Csg {
    let (by, angles) = (dice.vec3(1.5), dice.vec3(180.0));
    Csg::Translate(by, Box::new(Csg::Rotate(angles, Box::new(solid(dice, 1)))))
}

fn pose(dice: &mut Dice) -> Pose {
    let place = dice.vec3(5.0);
    Pose {
        position: DVec3::new(place.x, 0.5 * place.y + 1.5, place.z),
        angles_deg: dice.vec3(180.0),
    }
}

fn light(dice: &mut Dice) -> Light {
    let mut position = dice.vec3(12.0);
    if dice.chance(85) {
        position.y = position.y.abs() + 2.0;
    }
    let towards = dice.vec3(3.0);
    let bright = if dice.chance(4) {
        0.0
    } else {
        dice.within(0.3, 1.0)
    };
    Light {
        position,
        colour: Rgb([bright, bright * 0.9, bright * 0.8]),
        kind: match dice.below(4) {
            0 => LightKind::Point,
            1 => LightKind::Sun { towards },
            2 => LightKind::Spot {
                towards,
                radius_deg: dice.within(5.0, 30.0),
                falloff_deg: dice.within(10.0, 60.0),
                tightness: if dice.chance(50) { 0.0 } else { 5.0 },
            },
            _ => LightKind::Area {
                u: dice.vec3(2.0),
                v: dice.vec3(2.0),
                nu: 1 + dice.below(3) as u32,
                nv: 1 + dice.below(4) as u32,
            },
        },
        fade: dice.chance(20).then_some(Fade {
            distance: 8.0,
            power: 2.0,
        }),
    }
}

/// A random case; its prototypes are added to `table`.
pub fn random(dice: &mut Dice, table: &mut PrototypeTable, size: Size) -> Case {
    let eye = DVec3::new(
        dice.within(-8.0, 8.0),
        dice.within(0.2, 8.0),
        dice.within(-14.0, -6.0),
    );
    let angle = dice.within(25.0, 100.0);
    let aspect = f64::from(size.height) / f64::from(size.width);
    let camera = Camera::look_at(eye, dice.vec3(2.0), DVec3::Y, (angle, angle * aspect));
    let mut instances = Vec::new();
    if dice.chance(70) {
        let tilt = if dice.chance(70) { 0.0 } else { 0.3 };
        let floor = Csg::Plane {
            normal: DVec3::Y + dice.vec3(1.0) * tilt,
            distance: -dice.within(0.5, 2.5),
        };
        // A mirror without an end would leave nothing to show.
        let look = Material {
            reflection: 0.0,
            transmission: 0.0,
            ..material(dice)
        };
        let floor = Csg::Look(look, Box::new(floor));
        instances.push(insert(table, floor, Pose::IDENTITY, true));
    }
    for _ in 0..2 + dice.below(6) {
        let solid = Csg::Look(material(dice), Box::new(solid(dice, 0)));
        instances.push(insert(table, solid, pose(dice), true));
    }
    let decor_count = instances.len();
    for _ in 0..1 + dice.below(2) * dice.below(3) {
        let solid = Csg::Look(material(dice), Box::new(solid(dice, 0)));
        instances.push(insert(table, solid, pose(dice), true));
    }
    Case {
        scene: Scene {
            camera: camera.expect("a camera"),
            lights: (0..1 + dice.below(3)).map(|_| light(dice)).collect(),
            shadows: dice.chance(95),
            background: Rgb([0.1, 0.2, 0.4]),
            includes: Vec::new(),
            sky: None,
            instances,
            hidden: Vec::new(),
        },
        decor_count,
        size,
        antialias: None,
    }
}

//! The shadow map against POV-Ray's own shadows, caster by caster and light by
//! light: a picture of a floor without its caster, mixed by what arrives at its
//! points, against the picture that POV-Ray draws with the caster in it.

mod common;

use std::sync::Arc;

use common::{at, context, fragment, neutral, povray, scene};
use decor_api::{
    Adapter, ArrivalRequest, ArrivalShot, Bounds, Camera, Csg, Fade, Instance, LayerRequest,
    LayerShot, Light, LightKind, Output, Pose, PrototypeId, PrototypeTable, Region, Rgb, Scene,
    Size, SurfacePoint,
};
use decor_povray::LayerSource;
use glam::DVec3;

const SIZE: Size = Size {
    width: 64,
    height: 48,
};

/// A floor through `point`, and where it is seen from.
struct Ground {
    point: DVec3,
    normal: DVec3,
    text: String,
    camera: Camera,
}

impl Ground {
    /// A white floor one unit below `origin`.
    fn white(origin: DVec3) -> Self {
        Self::new(
            origin,
            DVec3::Y,
            "pigment { rgb 1 } finish { ambient 0 diffuse 1 }",
        )
    }

    /// A coloured one with a highlight, that glows a little and is tilted.
    fn coloured(origin: DVec3) -> Self {
        Self::new(
            origin,
            DVec3::new(0.2, 1.0, -0.3).normalize(),
            "pigment { checker rgb <0.9,0.5,0.3>, rgb <0.3,0.6,0.8> scale 0.7 } \
             finish { ambient 0.1 diffuse 0.7 phong 0.8 phong_size 12 }",
        )
    }

    fn new(origin: DVec3, normal: DVec3, look: &str) -> Self {
        let point = origin - DVec3::Y;
        let n = decor_povray::number;
        let text = format!(
            "plane {{ <{},{},{}>, 0 {look} translate <{},{},{}> }}",
            n(normal.x),
            n(normal.y),
            n(normal.z),
            n(point.x),
            n(point.y),
            n(point.z)
        );
        let eye = origin + DVec3::new(0.0, 6.0, -9.0);
        Self {
            point,
            normal,
            text,
            camera: Camera::look_at(eye, origin - DVec3::Y, DVec3::Y, (50.0, 38.0)).unwrap(),
        }
    }

    /// Where the rays through the pixels' centres meet it.
    fn points(&self) -> Arc<[SurfacePoint]> {
        let pixels = (0..SIZE.height).flat_map(|y| (0..SIZE.width).map(move |x| (x, y)));
        let point = |(x, y)| {
            let way = self
                .camera
                .direction(SIZE, f64::from(x) + 0.5, f64::from(y) + 0.5);
            let t = (self.point - self.camera.eye).dot(self.normal) / way.dot(self.normal);
            assert!(t > 0.0, "the floor fills the picture");
            SurfacePoint {
                position: self.camera.eye + way * t,
                footprint: way.length() * t * 2.0 * self.camera.half_width / f64::from(SIZE.width),
            }
        };
        pixels.map(point).collect()
    }
}

/// What is drawn: a floor, groups of casters that stand on it one after the
/// other, and lights.
struct Stage {
    table: PrototypeTable,
    ground: Ground,
    floor: PrototypeId,
    groups: Vec<Vec<Instance>>,
    lights: Vec<Light>,
}

impl Stage {
    fn new(ground: Ground, lights: &[Light]) -> Self {
        let mut table = PrototypeTable::default();
        let floor = fragment(&mut table, "floor", Bounds::Unbounded, &ground.text);
        Self {
            table,
            ground,
            floor,
            groups: Vec::new(),
            lights: lights.to_vec(),
        }
    }

    /// Casters of text, posed, that stand there together.
    fn group(&mut self, casters: &[(&str, Pose)]) {
        let bounds = Bounds::sphere(DVec3::ZERO, 3.0);
        let mut group = Vec::new();
        for &(text, pose) in casters {
            let name = format!("caster {}", self.table.len());
            let prototype = fragment(&mut self.table, &name, bounds, text);
            group.push(Instance { prototype, pose });
        }
        self.groups.push(group);
    }

    fn scene(&self, lights: &[Light], hidden: &[Instance]) -> Arc<Scene> {
        let mut scene = (*scene(self.ground.camera, vec![at(self.floor, 0.0, 0.0, 0.0)])).clone();
        scene.lights = lights.to_vec();
        scene.hidden = hidden.to_vec();
        Arc::new(scene)
    }

    /// Pictures of some scenes.
    fn draw(&self, scenes: Vec<Arc<Scene>>) -> Vec<Vec<[f32; 4]>> {
        let (_folder, run) = context();
        let shot = |scene| LayerShot {
            frame: 0,
            scene,
            region: Region::Window(SIZE.window()),
        };
        let request = LayerRequest {
            prototypes: &self.table,
            size: SIZE,
            output: Output::ColourOverBackground,
            antialias: None,
            shots: scenes.into_iter().map(shot).collect(),
            film: None,
            label: "floor".into(),
        };
        let povray = povray(LayerSource::StateFile);
        let layers = povray.render(&request, &run).unwrap();
        layers.into_iter().map(|l| l.colour.unwrap()).collect()
    }

    /// What arrives of each light, for each group: one call.
    fn arriving(&self, source: LayerSource) -> Vec<Vec<[f32; 3]>> {
        let (_folder, run) = context();
        let points = self.ground.points();
        let mut shots = Vec::new();
        for group in &self.groups {
            shots.extend(self.lights.iter().map(|light| ArrivalShot {
                frame: 7,
                light: *light,
                casters: group.clone().into(),
                points: Arc::clone(&points),
            }));
        }
        let request = ArrivalRequest {
            prototypes: &self.table,
            includes: &[],
            shots,
            label: "arrival".into(),
        };
        let found = povray(source).arriving_light(&request, &run).unwrap();
        let left = std::fs::read_dir(&run.work).unwrap().count();
        assert_eq!(left, 0, "files are left behind");
        found
    }

    /// Mixes, and compares with POV-Ray's own pictures, group by group.
    fn compare(&self, source: LayerSource) -> Vec<Outcome> {
        let mut scenes = vec![self.scene(&self.lights, &[]), self.scene(&[], &[])];
        scenes.extend(self.lights.iter().map(|l| self.scene(&[*l], &[])));
        let first_truth = scenes.len();
        let groups = self.groups.iter();
        scenes.extend(groups.map(|group| self.scene(&self.lights, group)));
        let pictures = self.draw(scenes);
        let (bare, dark) = (&pictures[0], &pictures[1]);
        let lit = &pictures[2..first_truth];
        let fractions = self.arriving(source);
        let povray = povray(source);
        let shown = |linear| povray.encode(linear, 255);
        let of_group = |(truth, fractions): (&Vec<[f32; 4]>, &[Vec<[f32; 3]>])| {
            let mut outcome = Outcome::default();
            for k in 0..SIZE.pixels() {
                let (mut worst, mut shadow) = (0, 0);
                for channel in 0..3 {
                    let mut mixed = dark[k][channel];
                    for (lit, fractions) in lit.iter().zip(fractions) {
                        mixed += (lit[k][channel] - dark[k][channel]) * fractions[k][channel];
                    }
                    let right = shown(truth[k][channel]);
                    worst = worst.max(shown(mixed).abs_diff(right));
                    shadow = shadow.max(shown(bare[k][channel]).abs_diff(right));
                }
                outcome.largest = outcome.largest.max(worst);
                outcome.wrong += usize::from(worst > 2);
                outcome.shadowed += usize::from(shadow > 2);
            }
            outcome
        };
        let by_group = fractions.chunks(self.lights.len());
        pictures[first_truth..]
            .iter()
            .zip(by_group)
            .map(of_group)
            .collect()
    }
}

/// Pixels, and steps of 255.
#[derive(Clone, Copy, Debug, Default)]
struct Outcome {
    wrong: usize,
    largest: u32,
    /// Pixels that the caster changes at all.
    shadowed: usize,
}

impl Outcome {
    /// No pixel is wrong, and something was to be seen.
    fn check(self, name: &str, casts: bool) {
        println!("{name}: {self:?}");
        assert_eq!(self.wrong, 0, "{name}: {self:?}");
        assert!(self.shadowed > 20 || !casts, "{name}: {self:?}");
    }
}

/// The casters: name, text, and does it cast a shadow?
const CASTERS: [(&str, &str, bool); 16] = [
    ("opaque", "sphere { 0, 1.2 pigment { rgb 1 } }", true),
    (
        "union",
        "union { sphere { 0, 1 } union { box { <-2,-0.2,-0.2>, <2,0.2,0.2> } cone { <0,0,1>, 0.5, <0,0,2>, 0 } } pigment { rgb x } }",
        true,
    ),
    (
        "difference",
        "difference { box { -1, 1 } cylinder { -2*y, 2*y, 0.7 } pigment { rgb x } }",
        true,
    ),
    (
        "filter",
        "sphere { 0, 1.2 pigment { rgbf <1,0.3,0.2,0.8> } }",
        true,
    ),
    (
        "transmit",
        "box { -1, <1,2,1> pigment { rgbft <0.2,0.9,0.3,0.5,0.3> } }",
        true,
    ),
    (
        "layered",
        "sphere { 0, 1.2 texture { pigment { rgbf <1,0.5,0.5,0.9> } } texture { pigment { checker rgbt <1,1,1,0.8>, rgbf <0.3,1,0.3,0.8> scale 0.4 } } }",
        true,
    ),
    (
        "nested",
        "sphere { 0, 1.2 pigment { rgbf <1,0.5,0.5,0.9> } } sphere { 0, 0.7 pigment { rgbf <0.5,1,0.5,0.9> } }",
        true,
    ),
    (
        "refracting",
        "sphere { 0, 1.2 pigment { rgbf <0.95,1,0.9,0.9> } finish { reflection 0.2 } interior { ior 1.5 } }",
        true,
    ),
    (
        "fading",
        "sphere { 0, 1.2 pigment { rgbf <0.95,1,0.9,0.9> } interior { ior 1.5 fade_distance 1 fade_power 2 fade_color rgb <0.8,0.3,0.3> } }",
        true,
    ),
    (
        "caustics",
        "sphere { 0, 1.2 pigment { rgbf <0.95,1,0.9,0.9> } interior { ior 1.5 caustics 0.8 } }",
        true,
    ),
    (
        "chrome",
        "sphere { 0, 1.2 pigment { rgb 0.1 } finish { reflection 0.8 } }",
        true,
    ),
    (
        "emissive",
        "sphere { 0, 1.2 pigment { rgb 1 } finish { emission 0.7 } }",
        true,
    ),
    (
        "no_shadow",
        "sphere { 0, 1.2 pigment { rgb 1 } no_shadow }",
        false,
    ),
    (
        "no_shadow part",
        "union { sphere { -x, 0.8 pigment { rgb 1 } no_shadow } sphere { x, 0.8 pigment { rgb 1 } } }",
        true,
    ),
    (
        "media",
        "sphere { 0, 1.2 hollow pigment { rgbt 1 } interior { media { absorption 0.5 } } }",
        true,
    ),
    (
        "mesh",
        "mesh { triangle { <-1,0,-1>, <1,0,-1>, <0,0.5,1> } triangle { <-1,0,-1>, <1,1,-1>, <0,0.5,1> } pigment { rgb 1 } }",
        true,
    ),
];

fn lamp(origin: DVec3, kind: LightKind) -> Light {
    Light {
        position: origin + DVec3::new(-5.0, 12.0, -3.0),
        colour: Rgb([0.9, 0.8, 0.6]),
        kind,
        fade: None,
    }
}

fn lights(origin: DVec3) -> [(&'static str, Light); 4] {
    let spot = LightKind::Spot {
        towards: origin - DVec3::Y,
        radius_deg: 8.0,
        falloff_deg: 16.0,
        tightness: 2.0,
    };
    let area = LightKind::Area {
        u: DVec3::X * 2.0,
        v: DVec3::Z * 2.0,
        nu: 5,
        nv: 5,
    };
    let mut fading = lamp(origin, LightKind::Point);
    fading.fade = Some(Fade {
        distance: 12.0,
        power: 2.0,
    });
    [
        ("point", fading),
        ("sun", lamp(origin, LightKind::Sun { towards: origin })),
        ("spot", lamp(origin, spot)),
        ("area", lamp(origin, area)),
    ]
}

fn posed(origin: DVec3) -> Pose {
    Pose {
        position: origin + DVec3::Y,
        angles_deg: DVec3::new(10.0, 20.0, 0.0),
    }
}

/// Every caster on one kind of ground, under the light at `index`.
fn every_caster(index: usize, ground: Ground) {
    let (kind, light) = lights(DVec3::ZERO)[index];
    let mut stage = Stage::new(ground, &[light]);
    for (_, text, _) in CASTERS {
        stage.group(&[(text, posed(DVec3::ZERO))]);
    }
    let outcomes = stage.compare(LayerSource::StateFile);
    assert_eq!(outcomes.len(), CASTERS.len());
    for (outcome, (name, _, casts)) in outcomes.into_iter().zip(CASTERS) {
        outcome.check(&format!("{name}, {kind}"), casts);
    }
}

#[test]
fn every_caster_under_a_point_light() {
    every_caster(0, Ground::white(DVec3::ZERO));
}

#[test]
fn every_caster_under_a_sun() {
    every_caster(1, Ground::white(DVec3::ZERO));
}

#[test]
fn every_caster_under_a_spot() {
    every_caster(2, Ground::white(DVec3::ZERO));
}

#[test]
fn every_caster_under_an_area_light() {
    every_caster(3, Ground::white(DVec3::ZERO));
}

#[test]
fn every_caster_on_a_coloured_tilted_floor() {
    for index in 0..4 {
        every_caster(index, Ground::coloured(DVec3::ZERO));
    }
}

/// Two lights, two casters that both shade some points.
fn two_and_two(origin: DVec3, source: LayerSource) -> Outcome {
    let [_, (_, sun), _, (_, area)] = lights(origin);
    let mut second = area;
    second.position = origin + DVec3::new(6.0, 9.0, -2.0);
    second.colour = Rgb([0.2, 0.4, 0.5]);
    let low = Pose {
        position: origin + DVec3::new(-0.7, -0.4, 0.4),
        angles_deg: DVec3::ZERO,
    };
    let glassy = "box { -0.5, 0.5 pigment { rgbf <0.9,0.4,0.3,0.7> } }";
    let mut stage = Stage::new(Ground::coloured(origin), &[sun, second]);
    stage.group(&[(CASTERS[0].1, posed(origin)), (glassy, low)]);
    stage.compare(source)[0]
}

#[test]
fn two_lights_and_two_casters() {
    for source in [LayerSource::StateFile, LayerSource::Pictures] {
        two_and_two(DVec3::ZERO, source).check(&format!("two and two, {source:?}"), true);
    }
}

#[test]
fn far_from_the_origin() {
    for origin in [DVec3::new(1e5, -2e5, 1.5e5), DVec3::splat(1e6)] {
        let outcome = two_and_two(origin, LayerSource::StateFile);
        outcome.check(&format!("at {origin}"), true);
    }
}

/// No light, and what each light adds, is the picture with all of them.
#[test]
fn lights_add_up() {
    let all = lights(DVec3::ZERO).map(|(_, light)| light);
    let stage = Stage::new(Ground::coloured(DVec3::ZERO), &all);
    let mut table = stage.table.clone();
    let ball = Csg::Sphere {
        centre: DVec3::ZERO,
        radius: 1.0,
    };
    let ball = neutral(&mut table, "ball", [0.9, 0.7, 0.2], ball);
    let stage = Stage { table, ..stage };
    let with = |lights: &[Light]| {
        let mut scene = (*stage.scene(lights, &[])).clone();
        scene.instances.push(at(ball, 0.3, 0.6, 0.0));
        Arc::new(scene)
    };
    let mut scenes = vec![with(&all), with(&[])];
    scenes.extend(all.iter().map(|l| with(&[*l])));
    let pictures = stage.draw(scenes);
    let (whole, dark) = (&pictures[0], &pictures[1]);
    let mut largest = 0.0_f32;
    for k in 0..SIZE.pixels() {
        for channel in 0..3 {
            let added = pictures[2..]
                .iter()
                .map(|p| p[k][channel] - dark[k][channel]);
            let sum = dark[k][channel] + added.sum::<f32>();
            largest = largest.max((sum - whole[k][channel]).abs());
        }
    }
    println!("lights add up to within {largest:e}");
    assert!(largest <= 5e-4, "{largest:e}");
    assert!(whole.iter().any(|p| p[0] > 0.5), "it is dark");
}

/// What is not asked of POV-Ray: frames without casters, points outside of a
/// spot's cone, no points at all.
#[test]
fn nothing_in_the_way_is_all_the_light() {
    let (_, spot) = lights(DVec3::ZERO)[2];
    let mut stage = Stage::new(Ground::white(DVec3::ZERO), &[spot]);
    stage.group(&[(CASTERS[0].1, posed(DVec3::ZERO))]);
    let point = |x| SurfacePoint {
        position: DVec3::new(x, -1.0, 0.0),
        footprint: 0.1,
    };
    let shot = |casters: &[Instance], points: &[SurfacePoint]| ArrivalShot {
        frame: 1,
        light: spot,
        casters: casters.into(),
        points: points.into(),
    };
    let casters = &stage.groups[0];
    let request = ArrivalRequest {
        prototypes: &stage.table,
        includes: &[],
        shots: vec![
            shot(&[], &[point(0.0)]),
            shot(casters, &[point(900.0), point(f64::NAN)]),
            shot(casters, &[]),
        ],
        label: "nothing".into(),
    };
    let (_folder, run) = context();
    let found = povray(LayerSource::StateFile)
        .arriving_light(&request, &run)
        .unwrap();
    assert_eq!(found, [vec![[1.0; 3]], vec![[1.0; 3]; 2], vec![]]);
    assert_eq!(run.tally.read().0, 0, "POV-Ray was called");
}

/// The emitted text, with two cells and two frames.
#[test]
fn the_text_of_a_request() {
    let (_, area) = lights(DVec3::ZERO)[3];
    let mut stage = Stage::new(Ground::white(DVec3::ZERO), &[area]);
    stage.group(&[(CASTERS[0].1, posed(DVec3::ZERO))]);
    let point = |x, footprint| SurfacePoint {
        position: DVec3::new(x, -1.0, 0.0),
        footprint,
    };
    let shot = |x| ArrivalShot {
        frame: 1,
        light: area,
        casters: stage.groups[0].clone().into(),
        points: Arc::new([point(x, 0.1), point(x + 1.0, 1.0)]),
    };
    let request = ArrivalRequest {
        prototypes: &stage.table,
        includes: &[],
        shots: vec![shot(0.0), shot(1e5)],
        label: "text".into(),
    };
    let text = povray(LayerSource::StateFile)
        .arrival_text(&request)
        .unwrap();
    let mut shown = String::new();
    for (file, bytes) in &text.files {
        shown.push_str(&format!("==> {file}\n{}", String::from_utf8_lossy(bytes)));
    }
    insta::assert_snapshot!("arrival", shown);
}

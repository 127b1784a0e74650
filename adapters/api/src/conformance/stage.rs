//! Scenes for the tests, in few words.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use glam::DVec3;

use crate::adapter::{Adapter, AdapterError, LayerRequest, LayerShot, Output, Region, RunContext};
use crate::camera::Camera;
use crate::conformance::oracle::Oracle;
use crate::csg::Csg;
use crate::layer::{Layer, Size, Window};
use crate::material::Material;
use crate::prototype::{Geometry, Optics, Prototype, PrototypeId, PrototypeTable};
use crate::scene::{Antialias, Instance, Light, LightKind, Pose, Rgb, Scene};

/// The pictures' size where no test needs another. Odd, and no power of two.
pub const SIZE: Size = Size {
    width: 61,
    height: 45,
};

/// The colour where nothing is.
pub const BACKGROUND: [f64; 3] = [0.1, 0.2, 0.4];

/// A scene with its geometry.
#[derive(Clone)]
pub struct Stage {
    /// The geometry.
    pub prototypes: PrototypeTable,
    /// The frame.
    pub scene: Scene,
    /// The size of the picture.
    pub size: Size,
}

/// A camera of 60° by 47°: pixels are not quite square.
pub fn camera(eye: DVec3, aim: DVec3) -> Camera {
    Camera::look_at(eye, aim, DVec3::Y, (60.0, 47.0)).expect("a camera")
}

/// A sphere around a point.
pub fn sphere(x: f64, y: f64, z: f64, radius: f64) -> Csg {
    Csg::Sphere {
        centre: DVec3::new(x, y, z),
        radius,
    }
}

/// A box along the axes.
pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Csg {
    Csg::Box {
        min: DVec3::from_array(min),
        max: DVec3::from_array(max),
    }
}

/// The half-space below `distance` along `normal`.
pub fn plane(normal: [f64; 3], distance: f64) -> Csg {
    Csg::Plane {
        normal: DVec3::from_array(normal),
        distance,
    }
}

/// A solid that shines by itself alone: its colour is the pixel's.
pub fn glowing(colour: [f64; 3], solid: Csg) -> Csg {
    let look = Material {
        colour: Rgb(colour),
        ambient: 1.0,
        diffuse: 0.0,
        ..Material::default()
    };
    Csg::Look(look, Box::new(solid))
}

/// A solid that scatters the light that arrives, and does not shine.
pub fn dull(solid: Csg) -> Csg {
    let look = Material {
        colour: Rgb([0.8; 3]),
        ambient: 0.0,
        diffuse: 0.9,
        ..Material::default()
    };
    Csg::Look(look, Box::new(solid))
}

/// A light of one point.
pub fn lamp(x: f64, y: f64, z: f64) -> Light {
    Light {
        position: DVec3::new(x, y, z),
        colour: Rgb([1.0; 3]),
        kind: LightKind::Point,
        fade: None,
    }
}

/// At a point, not turned.
pub fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose {
        position: DVec3::new(x, y, z),
        angles_deg: DVec3::ZERO,
    }
}

/// The whole of a picture.
pub fn whole(size: Size) -> Region {
    Region::Window(size.window())
}

impl Stage {
    /// Nothing, seen from z = −10 along z.
    pub fn empty() -> Self {
        Self {
            prototypes: PrototypeTable::default(),
            scene: Scene {
                camera: camera(DVec3::Z * -10.0, DVec3::ZERO),
                lights: Vec::new(),
                shadows: false,
                background: Rgb(BACKGROUND),
                includes: Vec::new(),
                sky: None,
                instances: Vec::new(),
                hidden: Vec::new(),
            },
            size: SIZE,
        }
    }

    /// Solids as they are, one instance each.
    pub fn of(solids: impl IntoIterator<Item = Csg>) -> Self {
        let mut stage = Self::empty();
        for solid in solids {
            stage.add(solid, Pose::IDENTITY);
        }
        stage
    }

    /// The same from elsewhere.
    #[must_use]
    pub fn seen_from(mut self, eye: DVec3, aim: DVec3) -> Self {
        self.scene.camera = camera(eye, aim);
        self
    }

    /// The same with a light, and with shadows.
    #[must_use]
    pub fn lit(mut self, light: Light) -> Self {
        self.scene.lights.push(light);
        self.scene.shadows = true;
        self
    }

    /// A solid as a prototype called `name`.
    pub fn prototype(&mut self, name: &str, solid: Csg) -> PrototypeId {
        let content = format!("{name} {solid:?}");
        self.prototypes.insert(Prototype {
            path: name.into(),
            hash: blake3::hash(content.as_bytes()).to_hex().to_string(),
            bounds: solid.bounds(),
            optics: if solid.is_optical() {
                Optics::Optical("a test".into())
            } else {
                Optics::Opaque
            },
            geometry: Geometry::Neutral(solid),
            extents: Vec::new(),
            unlayerable: None,
        })
    }

    /// Adds a solid with one instance.
    pub fn add(&mut self, solid: Csg, pose: Pose) {
        let name = format!("solid {}.ron", self.prototypes.len());
        let prototype = self.prototype(&name, solid);
        self.scene.instances.push(Instance { prototype, pose });
    }

    /// One shot of it.
    pub fn shot(&self, frame: u32, region: Region) -> LayerShot {
        LayerShot {
            frame,
            scene: Arc::new(self.scene.clone()),
            region,
        }
    }

    /// A request of some shots.
    pub fn request(&self, output: Output, shots: Vec<LayerShot>) -> LayerRequest<'_> {
        LayerRequest {
            prototypes: &self.prototypes,
            size: self.size,
            output,
            antialias: None,
            shots,
            film: None,
            label: "conformance".into(),
        }
    }

    /// Draws the whole picture.
    ///
    /// # Errors
    /// What the adapter says.
    pub fn try_draw(&self, adapter: &dyn Adapter, output: Output) -> Result<Layer, AdapterError> {
        self.draw_with(adapter, output, whole(self.size), None)
    }

    /// Draws the whole picture.
    pub fn draw(&self, adapter: &dyn Adapter, output: Output) -> Layer {
        drawn(self.try_draw(adapter, output))
    }

    /// Draws a part, with antialiasing or without.
    ///
    /// # Errors
    /// What the adapter says.
    pub fn draw_with(
        &self,
        adapter: &dyn Adapter,
        output: Output,
        region: Region,
        antialias: Option<Antialias>,
    ) -> Result<Layer, AdapterError> {
        let room = Room::plain();
        let mut request = self.request(output, vec![self.shot(7, region)]);
        request.antialias = antialias;
        let mut layers = adapter.render(&request, &room.run)?;
        assert_eq!(layers.len(), 1, "one shot is one layer");
        Ok(layers.remove(0))
    }

    /// What is really seen.
    pub fn oracle(&self) -> Oracle<'_> {
        Oracle::new(&self.prototypes, &self.scene, self.size)
    }

    /// The colour of the pixel where a point of the world is seen.
    pub fn colour_at(&self, layer: &Layer, point: DVec3) -> [f32; 4] {
        let seen = self.scene.camera.project(self.size, point);
        let (x, y) = seen.expect("the point is in front of the camera");
        colours(layer)[layer.index(x as u32, y as u32)]
    }
}

/// The colours of a layer that was asked for them.
pub fn colours(layer: &Layer) -> &[[f32; 4]] {
    let colours = layer.colour.as_deref().expect("colour was asked for");
    assert_eq!(colours.len(), layer.window.pixels(), "one colour a pixel");
    colours
}

/// What came out, or the whole story of why not.
pub fn drawn<T>(result: Result<T, AdapterError>) -> T {
    result.unwrap_or_else(|error| panic!("it was to be drawn: {error}"))
}

/// The entries of `part` are those of `whole` at the same pixels, bit for bit.
pub fn assert_part_of(part: &Layer, whole: &Layer, wanted: impl Fn(u32, u32) -> bool) {
    let Window { x, y, .. } = part.window;
    let mut compared = 0;
    for y in y..part.window.bottom() {
        for x in (x..part.window.right()).filter(|&x| wanted(x, y)) {
            let (i, j) = (part.index(x, y), whole.index(x, y));
            compared += 1;
            if let (Some(a), Some(b)) = (&part.colour, &whole.colour) {
                let same = a[i].map(f32::to_bits) == b[j].map(f32::to_bits);
                assert!(same, "pixel ({x}, {y}): {:?} is not {:?}", a[i], b[j]);
            }
            if let (Some(a), Some(b)) = (&part.depth, &whole.depth) {
                let same = a[i].to_bits() == b[j].to_bits();
                assert!(same, "depth at ({x}, {y}): {} is not {}", a[i], b[j]);
            }
        }
    }
    assert!(compared > 0, "there was nothing to compare");
    assert_eq!(part.colour.is_some(), whole.colour.is_some());
    assert_eq!(part.depth.is_some(), whole.depth.is_some());
}

/// A folder to work in. Its name is one that users have.
pub struct Room {
    folder: tempfile::TempDir,
    /// The context that works in it.
    pub run: RunContext,
}

impl Room {
    /// A new one.
    pub fn plain() -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let run = RunContext::new(folder.path());
        Self { folder, run }
    }

    /// A new one with blanks, quotes and letters of several scripts in its name.
    pub fn odd() -> Self {
        let folder = tempfile::Builder::new()
            .prefix("décor of 'tests' \u{65e5}\u{672c} & $HOME -")
            .tempdir()
            .expect("a temporary folder");
        let run = RunContext::new(folder.path());
        Self { folder, run }
    }

    /// What lies in the folder.
    pub fn contents(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.folder.path()).expect("the folder is there");
        entries
            .map(|entry| {
                entry
                    .expect("an entry")
                    .file_name()
                    .to_string_lossy()
                    .into_owned()
            })
            .collect()
    }

    /// Nothing is left: no file, and no process that works here.
    pub fn assert_empty(&self) {
        assert_eq!(self.contents(), Vec::<String>::new(), "left in the folder");
        assert_no_process_in(self.folder.path());
    }
}

/// No process works in a folder, or in one below it. One that was just killed
/// may need a moment to go. Only Linux tells.
pub fn assert_no_process_in(folder: &Path) {
    let here = folder.canonicalize().expect("the folder");
    let inside = |process: &Path| {
        let folder = std::fs::read_link(process.join("cwd"));
        folder.is_ok_and(|folder| folder.starts_with(&here))
    };
    let mut left = Vec::new();
    for _ in 0..100 {
        let Ok(processes) = std::fs::read_dir("/proc") else {
            return;
        };
        left = processes
            .flatten()
            .filter(|entry| inside(&entry.path()))
            .map(|entry| entry.file_name().to_string_lossy().into_owned())
            .collect();
        if left.is_empty() {
            break;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    assert_eq!(left, Vec::<String>::new(), "left running");
}

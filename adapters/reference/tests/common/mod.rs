//! Scenes for the tests, in few words.
#![allow(dead_code)]

use std::path::PathBuf;
use std::sync::Arc;

use decor_api::{
    Adapter, Antialias, Bounds, Camera, Csg, Geometry, Instance, Layer, LayerRequest, LayerShot,
    Light, LightKind, Material, Optics, Output, Pose, Prototype, PrototypeTable, Region, Rgb,
    RunContext, Scene, Size,
};
use decor_reference::{Reference, World};
use glam::DVec3;

/// A scene and the prototypes that its instances name.
pub struct Stage {
    pub scene: Scene,
    pub prototypes: PrototypeTable,
}

pub fn vec3(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

/// Looks along z from z = −10, with half a right angle across.
pub fn camera() -> Camera {
    Camera::look_at(DVec3::Z * -10.0, DVec3::ZERO, DVec3::Y, (45.0, 45.0)).unwrap()
}

pub fn sphere(x: f64, y: f64, z: f64, radius: f64) -> Csg {
    Csg::Sphere {
        centre: vec3(x, y, z),
        radius,
    }
}

pub fn cube(half: f64) -> Csg {
    Csg::Box {
        min: DVec3::splat(-half),
        max: DVec3::splat(half),
    }
}

pub fn plane(normal: DVec3, distance: f64) -> Csg {
    Csg::Plane { normal, distance }
}

pub fn painted(material: Material, tree: Csg) -> Csg {
    Csg::Look(material, Box::new(tree))
}

/// A look that shines by itself alone: its colour is the pixel's.
pub fn glowing(colour: [f64; 3]) -> Material {
    Material {
        colour: Rgb(colour),
        ambient: 1.0,
        diffuse: 0.0,
        ..Material::default()
    }
}

/// A look that only scatters, all of it.
pub fn white() -> Material {
    Material {
        colour: Rgb([1.0; 3]),
        ambient: 0.0,
        diffuse: 1.0,
        ..Material::default()
    }
}

pub fn lamp(position: DVec3) -> Light {
    Light {
        position,
        colour: Rgb([1.0; 3]),
        kind: LightKind::Point,
        fade: None,
    }
}

impl Stage {
    /// Trees at the origin, one instance each.
    pub fn of(trees: impl IntoIterator<Item = Csg>) -> Self {
        let mut stage = Self {
            scene: Scene {
                camera: camera(),
                lights: Vec::new(),
                shadows: true,
                background: Rgb([0.25, 0.5, 0.75]),
                includes: Vec::new(),
                sky: None,
                instances: Vec::new(),
                hidden: Vec::new(),
            },
            prototypes: PrototypeTable::default(),
        };
        for tree in trees {
            stage.add(tree, Pose::IDENTITY);
        }
        stage
    }

    pub fn add(&mut self, tree: Csg, pose: Pose) {
        let name = format!("{}", self.prototypes.len());
        let prototype = self.prototypes.insert(Prototype {
            extents: Vec::new(),
            path: PathBuf::from(&name),
            hash: name,
            geometry: Geometry::Neutral(tree),
            bounds: Bounds::Unbounded,
            optics: Optics::Opaque,
            unlayerable: None,
        });
        self.scene.instances.push(Instance { prototype, pose });
    }

    pub fn lit(mut self, light: Light) -> Self {
        self.scene.lights.push(light);
        self
    }

    pub fn seen_from(mut self, camera: Camera) -> Self {
        self.scene.camera = camera;
        self
    }

    pub fn world(&self) -> World {
        World::of(&self.scene, &self.prototypes).unwrap()
    }

    /// The distance along a ray; +∞ where nothing is.
    pub fn distance(&self, origin: DVec3, direction: DVec3) -> f64 {
        let hit = self.world().cast(origin, direction);
        hit.map_or(f64::INFINITY, |hit| hit.distance)
    }

    pub fn request(
        &self,
        size: Size,
        output: Output,
        antialias: Option<Antialias>,
        region: Region,
    ) -> LayerRequest<'_> {
        LayerRequest {
            prototypes: &self.prototypes,
            size,
            output,
            antialias,
            shots: vec![LayerShot {
                frame: 3,
                scene: Arc::new(self.scene.clone()),
                region,
            }],
            film: None,
            label: "test".to_owned(),
        }
    }

    /// The whole picture.
    pub fn drawn(&self, size: Size, output: Output, antialias: Option<Antialias>) -> Layer {
        let request = self.request(size, output, antialias, Region::Window(size.window()));
        let mut layers = Reference::new().render(&request, &run()).unwrap();
        assert_eq!(layers.len(), 1);
        layers.remove(0)
    }

    /// The colour and coverage of the middle pixel of a picture of odd size.
    pub fn middle(&self) -> [f32; 4] {
        let layer = self.drawn(size(9, 9), Output::ColourOverBackground, None);
        layer.colour.unwrap()[9 * 4 + 4]
    }
}

pub fn size(width: u32, height: u32) -> Size {
    Size { width, height }
}

/// A run that writes nothing.
pub fn run() -> RunContext {
    RunContext::new(std::env::temp_dir())
}

pub fn assert_near(got: f32, want: f64) {
    assert!((f64::from(got) - want).abs() < 1e-6, "{got} is not {want}");
}

//! A scene of every shape, and renders of it.

#![allow(dead_code)] // not every test file uses everything

use std::path::PathBuf;
use std::sync::Arc;

use decor_api::{
    Adapter, AdapterError, Antialias, Camera, Csg, Geometry, Instance, Layer, LayerRequest,
    LayerShot, Light, LightKind, Material, Optics, Output, Pose, Prototype, PrototypeTable, Region,
    Rgb, RunContext, Scene, Size, TriangleMesh,
};
use decor_mitsuba::Mitsuba;
use glam::DVec3;

pub const SIZE: Size = Size {
    width: 200,
    height: 150,
};

/// Mitsuba; a test without it fails.
pub fn mitsuba() -> Mitsuba {
    Mitsuba::find().expect("Mitsuba must be installed for this test")
}

/// A scene and its geometry.
#[derive(Clone)]
pub struct Stage {
    pub prototypes: PrototypeTable,
    pub scene: Scene,
    pub size: Size,
    pub antialias: Option<Antialias>,
}

pub fn look(colour: [f64; 3], ambient: f64, node: Csg) -> Csg {
    let material = Material {
        colour: Rgb(colour),
        ambient,
        ..Material::default()
    };
    Csg::Look(material, Box::new(node))
}

pub fn sun() -> Light {
    Light {
        position: DVec3::new(-6.0, 10.0, -7.0),
        colour: Rgb([0.9, 0.8, 0.7]),
        kind: LightKind::Sun {
            towards: DVec3::ZERO,
        },
        fade: None,
    }
}

pub fn lamp() -> Light {
    Light {
        position: DVec3::new(4.0, 7.0, -3.0),
        colour: Rgb([0.4, 0.5, 0.6]),
        kind: LightKind::Point,
        fade: None,
    }
}

impl Stage {
    pub fn empty() -> Self {
        let camera = Camera::look_at(
            DVec3::new(0.5, 3.5, -9.0),
            DVec3::new(0.0, 0.6, 0.0),
            DVec3::Y,
            // Rounded as in a film: pixels are squares but for 1e-6.
            (50.0, 38.5526),
        );
        Self {
            prototypes: PrototypeTable::default(),
            scene: Scene {
                camera: camera.unwrap(),
                lights: vec![sun()],
                shadows: true,
                background: Rgb([0.1, 0.2, 0.4]),
                includes: Vec::new(),
                sky: None,
                instances: Vec::new(),
                hidden: Vec::new(),
            },
            size: SIZE,
            antialias: None,
        }
    }

    pub fn put(&mut self, name: &str, solid: Csg, position: [f64; 3], angles_deg: [f64; 3]) {
        let prototype = self.prototypes.insert(Prototype {
            path: PathBuf::from(name),
            hash: name.to_owned(),
            bounds: solid.bounds(),
            geometry: Geometry::Neutral(solid),
            extents: Vec::new(),
            optics: Optics::Opaque,
            unlayerable: None,
        });
        self.scene.instances.push(Instance {
            prototype,
            pose: Pose {
                position: position.into(),
                angles_deg: angles_deg.into(),
            },
        });
    }

    /// Every shape that is drawn as what it is: no mesh stands for it.
    pub fn exact_shapes(&mut self) {
        self.put(
            "floor",
            look([0.6, 0.5, 0.4], 0.15, floor()),
            [0.0; 3],
            [0.0; 3],
        );
        self.put(
            "ball",
            look([0.8, 0.2, 0.2], 0.1, ball(0.6)),
            [-3.0, 0.6, 0.0],
            [0.0; 3],
        );
        // The table knows it by its name.
        self.put("ball", ball(0.6), [-1.5, 0.6, -2.0], [0.0; 3]);
        let crate_ = look(
            [0.2, 0.7, 0.3],
            0.2,
            Csg::Box {
                min: DVec3::new(-0.5, 0.0, -0.5),
                max: DVec3::new(0.5, 1.2, 0.5),
            },
        );
        self.put("crate", crate_, [2.5, 0.0, 0.4], [0.0, 30.0, 0.0]);
        let drum = look(
            [0.3, 0.3, 0.8],
            0.1,
            Csg::Cylinder {
                base: DVec3::ZERO,
                cap: DVec3::Y * 1.5,
                radius: 0.7,
            },
        );
        self.put("drum", drum, [0.0, 0.0, 1.5], [15.0, 0.0, 10.0]);
        let ring = look(
            [0.8, 0.7, 0.1],
            0.1,
            Csg::Torus {
                major: 0.8,
                minor: 0.2,
            },
        );
        self.put("ring", ring, [0.6, 1.0, -1.5], [60.0, 20.0, 0.0]);
        let egg = look(
            [0.7, 0.3, 0.7],
            0.3,
            Csg::Scale(DVec3::new(0.5, 1.5, 0.8), Box::new(ball(0.6))),
        );
        self.put("egg", egg, [-1.6, 1.4, 2.0], [20.0, 10.0, 30.0]);
        let flat = look(
            [0.5, 0.6, 0.6],
            0.3,
            Csg::Scale(
                DVec3::new(1.0, 0.3, 0.5),
                Box::new(Csg::Torus {
                    major: 0.6,
                    minor: 0.25,
                }),
            ),
        );
        self.put("flat", flat, [-2.2, 2.2, -0.5], [70.0, 0.0, 0.0]);
        let tetrahedron = TriangleMesh {
            vertices: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        };
        let tetrahedron = look([0.9; 3], 0.0, Csg::Mesh(Arc::new(tetrahedron)));
        self.put(
            "tetrahedron",
            tetrahedron,
            [3.4, 0.8, -2.0],
            [10.0, 40.0, 0.0],
        );
    }

    /// Shapes that meshes stand for.
    pub fn meshed_shapes(&mut self) {
        let cone = look(
            [0.9, 0.4, 0.1],
            0.1,
            Csg::Cone {
                base: DVec3::ZERO,
                base_radius: 0.7,
                cap: DVec3::Y * 1.6,
                cap_radius: 0.0,
            },
        );
        self.put("cone", cone, [1.6, 0.0, -2.4], [0.0; 3]);
        let lens = Csg::Intersection(vec![
            ball(0.8),
            Csg::Translate(DVec3::X * 0.5, Box::new(ball(0.8))),
        ]);
        self.put(
            "lens",
            look([0.3, 0.6, 0.9], 0.1, lens),
            [-0.8, 2.5, 0.0],
            [0.0, 0.0, 20.0],
        );
        let gate = Csg::Difference(
            Box::new(Csg::Box {
                min: DVec3::new(-1.0, 0.0, -0.4),
                max: DVec3::new(1.0, 1.6, 0.4),
            }),
            vec![look(
                [0.9, 0.2, 0.2],
                0.2,
                Csg::Cylinder {
                    base: DVec3::new(0.0, 0.3, -1.0),
                    cap: DVec3::new(0.0, 0.3, 1.0),
                    radius: 0.7,
                },
            )],
        );
        self.put(
            "gate",
            look([0.6; 3], 0.1, gate),
            [-2.6, 0.0, 3.0],
            [0.0, 25.0, 0.0],
        );
    }

    pub fn request(&self, output: Output, region: Region) -> LayerRequest<'_> {
        LayerRequest {
            prototypes: &self.prototypes,
            size: self.size,
            output,
            antialias: self.antialias,
            shots: vec![LayerShot {
                frame: 0,
                scene: Arc::new(self.scene.clone()),
                region,
            }],
            film: None,
            label: "test".to_owned(),
        }
    }

    pub fn try_draw(
        &self,
        adapter: &dyn Adapter,
        output: Output,
        region: Region,
    ) -> Result<Layer, AdapterError> {
        let work = tempfile::tempdir().unwrap();
        let request = self.request(output, region);
        let mut layers = adapter.render(&request, &RunContext::new(work.path()))?;
        assert_eq!(layers.len(), 1);
        let left = std::fs::read_dir(work.path()).unwrap().count();
        assert_eq!(left, 0, "files are left behind");
        Ok(layers.remove(0))
    }

    pub fn draw(&self, adapter: &dyn Adapter, output: Output) -> Layer {
        let whole = Region::Window(self.size.window());
        self.try_draw(adapter, output, whole).unwrap()
    }
}

pub fn ball(radius: f64) -> Csg {
    Csg::Sphere {
        centre: DVec3::ZERO,
        radius,
    }
}

pub fn floor() -> Csg {
    Csg::Plane {
        normal: DVec3::Y,
        distance: 0.0,
    }
}

pub fn colours(layer: &Layer) -> &[[f32; 4]] {
    layer.colour.as_deref().unwrap()
}

pub fn depths(layer: &Layer) -> &[f64] {
    layer.depth.as_deref().unwrap()
}

/// The largest difference of any channel, pixel by pixel.
pub fn apart(a: &Layer, b: &Layer) -> Vec<f32> {
    let pair = colours(a).iter().zip(colours(b));
    pair.map(|(a, b)| {
        let channels = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        channels.fold(0.0, f32::max)
    })
    .collect()
}

//! Scenes for the tests that call POV-Ray.
#![allow(dead_code)]

pub mod unedited;

use std::sync::Arc;

use decor_api::csg::Csg;
use decor_api::{
    Antialias, Bounds, Camera, Fragment, Geometry, Instance, Light, LightKind, Material,
    NativeFile, Optics, Pose, Prototype, PrototypeId, PrototypeTable, Rgb, RunContext, Scene,
};
use decor_povray::{LayerSource, PovRay};
use glam::DVec3;

/// POV-Ray, as the tests find it: they fail where it is missing.
pub fn povray(source: LayerSource) -> PovRay {
    PovRay::find()
        .expect("POV-Ray is installed")
        .with_source(source)
}

/// A folder and a context that works in it.
pub fn context() -> (tempfile::TempDir, RunContext) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = RunContext::new(folder.path());
    (folder, run)
}

pub fn neutral(table: &mut PrototypeTable, name: &str, colour: [f64; 3], csg: Csg) -> PrototypeId {
    let look = Material {
        colour: Rgb(colour),
        ..Material::default()
    };
    let csg = Csg::Look(look, Box::new(csg));
    table.insert(Prototype {
        extents: Vec::new(),
        path: name.into(),
        hash: name.into(),
        bounds: csg.bounds(),
        optics: Optics::Opaque,
        geometry: Geometry::Neutral(csg),
        unlayerable: None,
    })
}

pub fn fragment(table: &mut PrototypeTable, name: &str, bounds: Bounds, text: &str) -> PrototypeId {
    let file = NativeFile {
        path: format!("/nowhere/{name}.inc").into(),
        root: "/nowhere".into(),
        text: text.into(),
    };
    table.insert(Prototype {
        extents: Vec::new(),
        path: name.into(),
        hash: name.into(),
        bounds,
        optics: Optics::Opaque,
        geometry: Geometry::Fragment(Fragment {
            file,
            language: "inc".into(),
        }),
        unlayerable: None,
    })
}

pub fn at(prototype: PrototypeId, x: f64, y: f64, z: f64) -> Instance {
    let pose = Pose {
        position: DVec3::new(x, y, z),
        angles_deg: DVec3::ZERO,
    };
    Instance { prototype, pose }
}

pub fn scene(camera: Camera, instances: Vec<Instance>) -> Arc<Scene> {
    Arc::new(Scene {
        camera,
        lights: vec![Light {
            position: DVec3::new(-30.0, 60.0, -40.0),
            colour: Rgb([1.0, 1.0, 1.0]),
            kind: LightKind::Point,
            fade: None,
        }],
        shadows: true,
        background: Rgb([0.2, 0.3, 0.5]),
        includes: Vec::new(),
        sky: None,
        instances,
        hidden: Vec::new(),
    })
}

pub const AA1: Antialias = Antialias {
    threshold: 0.1,
    depth: 3,
};

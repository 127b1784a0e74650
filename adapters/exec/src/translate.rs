//! A request in the protocol's words. Pure: it runs where the program is not.

use std::collections::BTreeSet;
use std::path::PathBuf;

use decor_api::{
    Csg, Geometry, Highlight, Instance, LayerRequest, LayerShot, LightKind, Material, NativeFile,
    Output, Region, Scene, Window,
};
use glam::{DAffine3, DVec3};

use crate::protocol::{self, Matrix, Solid};

/// The side of the blocks of a picture, in pixels.
pub use decor_api::BLOCK;

/// What of a request the program cannot draw, by what it said of itself; `None`
/// where it may be asked.
pub fn obstacle(request: &LayerRequest<'_>, can: &protocol::Abilities) -> Option<String> {
    let native = |file: &NativeFile| format!("{}: it is text of a renderer", file.path.display());
    for shot in &request.shots {
        let scene = &shot.scene;
        if let Some(file) = scene.includes.iter().chain(&scene.sky).next() {
            return Some(native(file));
        }
        let is_colour = request.output != Output::Depth;
        if is_colour && !scene.hidden.is_empty() && !can.hidden_casters {
            return Some("objects that only cast shadows".into());
        }
        if !draws_blocks(can) && matches!(shot.region, Region::Blocks(_)) {
            return Some("blocks of a picture".into());
        }
        let inside = window(request, &shot.region);
        if inside.intersection(request.size.window()) != inside && !inside.is_empty() {
            return Some(format!("{inside:?}: the picture is smaller"));
        }
    }
    used(request).into_iter().find_map(|number| {
        let prototype = request.prototypes.get(decor_api::PrototypeId(number));
        match &prototype.geometry {
            Geometry::Fragment(fragment) => Some(native(&fragment.file)),
            Geometry::Neutral(csg) if !can.csg && cuts(csg) => {
                let name = prototype.path.display();
                Some(format!("{name}: intersections and differences"))
            }
            Geometry::Neutral(_) => None,
        }
    })
}

/// Can blocks be had? A program that does not mask draws the window around them:
/// slower, and the same where windows are the full picture's own.
fn draws_blocks(can: &protocol::Abilities) -> bool {
    can.block_mask || can.crop_grid.is_some_and(|g| BLOCK.is_multiple_of(g))
}

/// Does the tree cut solids with each other? A union merely puts them together.
fn cuts(csg: &Csg) -> bool {
    let own = matches!(csg, Csg::Intersection(_) | Csg::Difference(..));
    own || csg.children().into_iter().any(cuts)
}

/// The prototypes that are placed.
fn used(request: &LayerRequest<'_>) -> BTreeSet<u32> {
    let scenes = request.shots.iter().map(|shot| &shot.scene);
    scenes
        .flat_map(|scene| scene.instances.iter().chain(&scene.hidden))
        .map(|instance| instance.prototype.0)
        .collect()
}

/// The window of a shot's layer.
pub fn window(request: &LayerRequest<'_>, region: &Region) -> Window {
    match region {
        Region::Window(window) => *window,
        Region::Blocks(blocks) => blocks.window(request.size),
    }
}

/// The name of a layer's file.
pub fn file(index: usize) -> String {
    format!("layer_{index:04}.exr")
}

/// The request, for layers in `folder`. Shots without a pixel are left out.
pub fn render(
    request: &LayerRequest<'_>,
    can: &protocol::Abilities,
    folder: PathBuf,
    threads: Option<usize>,
) -> protocol::Render {
    let used = used(request);
    let prototypes = request.prototypes.iter().map(|(id, prototype)| {
        let solid = match &prototype.geometry {
            Geometry::Neutral(csg) if used.contains(&id.0) => Some(solid(csg)),
            _ => None,
        };
        protocol::Prototype {
            name: prototype.path.to_string_lossy().into_owned(),
            solid,
        }
    });
    let depth = request.output == Output::Depth;
    let shots = request.shots.iter().enumerate();
    protocol::Render {
        protocol: protocol::VERSION,
        folder,
        threads,
        size: [request.size.width, request.size.height],
        output: match request.output {
            Output::ColourOverBackground => protocol::Output::Colour,
            Output::ColourAlone { .. } => protocol::Output::Objects,
            Output::Depth => protocol::Output::Depth,
        },
        antialias: request
            .antialias
            .filter(|_| !depth)
            .map(|a| protocol::Antialias {
                threshold: a.threshold,
                depth: a.depth,
            }),
        prototypes: prototypes.collect(),
        shots: shots
            .filter(|(_, shot)| !window(request, &shot.region).is_empty())
            .map(|(k, shot)| self::shot(request, can, k, shot))
            .collect(),
    }
}

fn shot(
    request: &LayerRequest<'_>,
    can: &protocol::Abilities,
    index: usize,
    shot: &LayerShot,
) -> protocol::Shot {
    let Scene {
        camera,
        lights,
        shadows,
        background,
        instances,
        hidden,
        ..
    } = &*shot.scene;
    let window = window(request, &shot.region);
    // Depth takes no notice of what is hidden.
    let seen_by_light = request.output != Output::Depth;
    protocol::Shot {
        frame: shot.frame,
        file: file(index),
        window: [window.x, window.y, window.width, window.height],
        blocks: match &shot.region {
            Region::Blocks(blocks) if can.block_mask => Some(blocks.numbers.clone()),
            _ => None,
        },
        camera: protocol::Camera {
            eye: camera.eye.to_array(),
            forward: camera.forward.to_array(),
            right: camera.right.to_array(),
            up: camera.up.to_array(),
            half_width: camera.half_width,
            half_height: camera.half_height,
        },
        lights: lights.iter().map(light).collect(),
        shadows: *shadows,
        background: background.0,
        instances: instances.iter().map(instance).collect(),
        hidden: hidden
            .iter()
            .filter(|_| seen_by_light)
            .map(instance)
            .collect(),
    }
}

fn light(light: &decor_api::Light) -> protocol::Light {
    protocol::Light {
        position: light.position.to_array(),
        colour: light.colour.0,
        fade: light.fade.map(|fade| protocol::Fade {
            distance: fade.distance,
            power: fade.power,
        }),
        kind: match light.kind {
            LightKind::Point => protocol::LightKind::Point,
            LightKind::Sun { towards } => protocol::LightKind::Sun {
                towards: towards.to_array(),
            },
            LightKind::Spot {
                towards,
                radius_deg,
                falloff_deg,
                tightness,
            } => protocol::LightKind::Spot {
                towards: towards.to_array(),
                radius_deg,
                falloff_deg,
                tightness,
            },
            LightKind::Area { u, v, nu, nv } => protocol::LightKind::Area {
                u: u.to_array(),
                v: v.to_array(),
                nu,
                nv,
            },
        },
    }
}

fn instance(instance: &Instance) -> protocol::Instance {
    protocol::Instance {
        prototype: instance.prototype.0,
        matrix: matrix(&instance.pose.transform()),
    }
}

fn matrix(transform: &DAffine3) -> Matrix {
    let columns = transform.matrix3.to_cols_array_2d();
    let moved = transform.translation.to_array();
    [0, 1, 2].map(|row| {
        [
            columns[0][row],
            columns[1][row],
            columns[2][row],
            moved[row],
        ]
    })
}

fn solid(csg: &Csg) -> Solid {
    let all = |nodes: &[Csg]| nodes.iter().map(solid).collect();
    let moved = |transform: DAffine3, node: &Csg| Solid::Transform {
        matrix: matrix(&transform),
        of: Box::new(solid(node)),
    };
    match csg {
        Csg::Sphere { centre, radius } => Solid::Sphere {
            centre: centre.to_array(),
            radius: *radius,
        },
        Csg::Box { min, max } => Solid::Box {
            min: min.to_array(),
            max: max.to_array(),
        },
        Csg::Cylinder { base, cap, radius } => Solid::Cylinder {
            base: base.to_array(),
            cap: cap.to_array(),
            radius: *radius,
        },
        Csg::Cone {
            base,
            base_radius,
            cap,
            cap_radius,
        } => Solid::Cone {
            base: base.to_array(),
            base_radius: *base_radius,
            cap: cap.to_array(),
            cap_radius: *cap_radius,
        },
        Csg::Torus { major, minor } => Solid::Torus {
            major: *major,
            minor: *minor,
        },
        Csg::Plane { normal, distance } => Solid::Plane {
            normal: normal.to_array(),
            distance: *distance,
        },
        Csg::Mesh(mesh) => Solid::Mesh {
            vertices: mesh.vertices.iter().map(DVec3::to_array).collect(),
            triangles: mesh.triangles.clone(),
        },
        Csg::Union(nodes) => Solid::Union { of: all(nodes) },
        Csg::Intersection(nodes) => Solid::Intersection { of: all(nodes) },
        Csg::Difference(first, rest) => Solid::Difference {
            from: Box::new(solid(first)),
            without: all(rest),
        },
        Csg::Translate(by, node) => moved(DAffine3::from_translation(*by), node),
        Csg::Rotate(by, node) => moved(DAffine3::from_quat(decor_api::scene::rotation(*by)), node),
        Csg::Scale(by, node) => moved(DAffine3::from_scale(*by), node),
        Csg::Look(look, node) => Solid::Look {
            material: material(look),
            of: Box::new(solid(node)),
        },
    }
}

fn material(look: &Material) -> protocol::Material {
    protocol::Material {
        colour: look.colour.0,
        ambient: look.ambient,
        diffuse: look.diffuse,
        highlight: match look.highlight {
            Highlight::None => protocol::Highlight::None,
            Highlight::Phong { amount, size } => protocol::Highlight::Phong { amount, size },
            Highlight::Specular { amount, roughness } => {
                protocol::Highlight::Specular { amount, roughness }
            }
        },
        reflection: look.reflection,
        transmission: look.transmission,
        ior: look.ior,
    }
}

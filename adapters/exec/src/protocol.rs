//! The protocol, as JSON has it: what decor asks on the program's stdin, and what
//! the program answers on its stdout. One object a call, each way.
//!
//! These types are the protocol: `docs/adapters.md` says in words what they say
//! here. They change with [`VERSION`] alone, whatever becomes of the neutral
//! scene inside decor.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};

/// The version of the protocol: both sides state it in everything they say.
pub const VERSION: u32 = 1;

/// Three coordinates, or red, green, blue.
pub type Triple = [f64; 3];

/// Three rows of four: `[x y z 1]` as a column behind it gives the point moved.
pub type Matrix = [[f64; 4]; 3];

/// What decor asks.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum Ask {
    /// Who are you, and what can you do?
    Hello {
        /// [`VERSION`].
        protocol: u32,
    },
    /// Draw some layers.
    Render(Box<Render>),
}

/// Some layers to draw.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Render {
    /// [`VERSION`].
    pub protocol: u32,
    /// The folder that the layers are written into: it exists.
    pub folder: PathBuf,
    /// How many threads to use; null: as many as you like.
    pub threads: Option<usize>,
    /// Columns and rows of the whole picture.
    pub size: [u32; 2],
    /// What to write.
    pub output: Output,
    /// For colour; null: one ray a pixel.
    pub antialias: Option<Antialias>,
    /// The geometry that instances name by its place in this list.
    pub prototypes: Vec<Prototype>,
    /// One layer each.
    pub shots: Vec<Shot>,
}

/// What the layers hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Output {
    /// R, G, B over the background; A is 1.
    Colour,
    /// R, G, B of the objects alone, multiplied by the coverage A.
    Objects,
    /// Z.
    Depth,
}

/// Antialiasing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Antialias {
    /// The difference between neighbours that asks for more rays.
    pub threshold: f64,
    /// Up to depth² rays a pixel.
    pub depth: u32,
}

/// A geometry stored once.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prototype {
    /// What the film calls it: for messages. Neither unique nor tame.
    pub name: String,
    /// What it is; null where no shot places it.
    pub solid: Option<Solid>,
}

/// A layer to draw.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shot {
    /// The frame's number, for messages.
    pub frame: u32,
    /// The name of the file to write, in the folder.
    pub file: String,
    /// Left, top, columns, rows: the part of the picture that is the layer.
    pub window: [u32; 4],
    /// Numbers of the blocks that are wanted of it; null: all of it.
    pub blocks: Option<Vec<u32>>,
    /// From where it is seen.
    pub camera: Camera,
    /// What shines.
    pub lights: Vec<Light>,
    /// Are shadows cast?
    pub shadows: bool,
    /// The colour where nothing is.
    pub background: Triple,
    /// What is placed.
    pub instances: Vec<Instance>,
    /// What casts shadows and shows in mirrors, and is not seen.
    pub hidden: Vec<Instance>,
}

/// The camera. The ray through the point (x, y) of the picture, in pixels from
/// the upper left, goes along `forward + right·half_width·(2x/columns − 1) +
/// up·half_height·(1 − 2y/rows)`; a pixel's centre is at a half.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Camera {
    /// Where it stands.
    pub eye: Triple,
    /// Where it looks, of length 1.
    pub forward: Triple,
    /// To the right in the picture, of length 1.
    pub right: Triple,
    /// Upwards in the picture, of length 1.
    pub up: Triple,
    /// tan of half the horizontal opening angle.
    pub half_width: f64,
    /// tan of half the vertical opening angle.
    pub half_height: f64,
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Light {
    /// Where it stands.
    pub position: Triple,
    /// Its linear colour.
    pub colour: Triple,
    /// Null: as bright far away as near.
    pub fade: Option<Fade>,
    /// Its shape.
    #[serde(flatten)]
    pub kind: LightKind,
}

/// `2 / (1 + (way / distance)^power)` is left of a light after its way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fade {
    /// Where it has its full colour.
    pub distance: f64,
    /// The power of the fall-off.
    pub power: f64,
}

/// The shape of a light.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum LightKind {
    /// From one point into every direction.
    Point,
    /// Parallel rays.
    Sun {
        /// From the position to here.
        towards: Triple,
    },
    /// A cone.
    Spot {
        /// Where its axis goes.
        towards: Triple,
        /// Half the angle of the full light, in degrees.
        radius_deg: f64,
        /// Half the angle where there is none any more, in degrees.
        falloff_deg: f64,
        /// The exponent of the cosine to the axis.
        tightness: f64,
    },
    /// A rectangle around the position, sampled as a grid.
    Area {
        /// One whole side.
        u: Triple,
        /// The other.
        v: Triple,
        /// Samples along `u`.
        nu: u32,
        /// Samples along `v`.
        nv: u32,
    },
}

/// A placed copy of a prototype.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Instance {
    /// Its number in the list of prototypes.
    pub prototype: u32,
    /// From the prototype's coordinates to the world's.
    pub matrix: Matrix,
}

/// A solid.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
#[expect(missing_docs, reason = "as in decor_api::Csg")]
pub enum Solid {
    Sphere {
        centre: Triple,
        radius: f64,
    },
    Box {
        min: Triple,
        max: Triple,
    },
    Cylinder {
        base: Triple,
        cap: Triple,
        radius: f64,
    },
    Cone {
        base: Triple,
        base_radius: f64,
        cap: Triple,
        cap_radius: f64,
    },
    Torus {
        major: f64,
        minor: f64,
    },
    Plane {
        normal: Triple,
        distance: f64,
    },
    Mesh {
        vertices: Vec<Triple>,
        triangles: Vec<[u32; 3]>,
    },
    Union {
        of: Vec<Solid>,
    },
    Intersection {
        of: Vec<Solid>,
    },
    Difference {
        from: Box<Solid>,
        without: Vec<Solid>,
    },
    Transform {
        matrix: Matrix,
        of: Box<Solid>,
    },
    Look {
        material: Material,
        of: Box<Solid>,
    },
}

/// A uniform look.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "as in decor_api::Material")]
pub struct Material {
    pub colour: Triple,
    pub ambient: f64,
    pub diffuse: f64,
    pub highlight: Highlight,
    pub reflection: f64,
    pub transmission: f64,
    pub ior: f64,
}

/// A bright spot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "type", rename_all = "snake_case")]
#[expect(missing_docs, reason = "as in decor_api::Highlight")]
pub enum Highlight {
    None,
    Phong { amount: f64, size: f64 },
    Specular { amount: f64, roughness: f64 },
}

/// What the program answers.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "reply", rename_all = "snake_case", deny_unknown_fields)]
pub enum Reply {
    /// To `hello`.
    Hello {
        /// [`VERSION`].
        protocol: u32,
        /// Its name, for people.
        name: String,
        /// Its version: another one where it draws another picture.
        version: String,
        /// What it can do.
        abilities: Abilities,
    },
    /// To `render`: every file is written.
    Done {
        /// [`VERSION`].
        protocol: u32,
        /// How many layers.
        layers: usize,
    },
    /// To `render`: there is something that it cannot draw.
    Unsupported {
        /// [`VERSION`].
        protocol: u32,
        /// What, for people: "a torus".
        what: String,
    },
    /// It did not work.
    Failed {
        /// [`VERSION`].
        protocol: u32,
        /// Why, for people.
        why: String,
    },
}

impl Reply {
    /// The version that it was written for.
    pub fn protocol(&self) -> u32 {
        match *self {
            Self::Hello { protocol, .. }
            | Self::Done { protocol, .. }
            | Self::Unsupported { protocol, .. }
            | Self::Failed { protocol, .. } => protocol,
        }
    }
}

/// What a program can do. What it leaves out it cannot.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Abilities {
    /// Intersections and differences of solids.
    pub csg: bool,
    /// Shadows.
    pub shadows: bool,
    /// Mirrors and glass.
    pub optics: bool,
    /// Objects that are not seen and cast shadows.
    pub hidden_casters: bool,
    /// Coverage between 0 and 1 with antialiasing.
    pub coverage: bool,
    /// A window whose origin is a multiple of this has the full picture's bits.
    pub crop_grid: Option<u32>,
    /// It draws blocks of 32 pixels alone.
    pub block_mask: bool,
    /// Where in a pixel its only ray goes.
    pub sample_position: [f64; 2],
    /// How exact its depth is: absolutely, and as a share of the depth.
    pub depth_quantum: [f64; 2],
    /// How many of its calls run side by side with profit.
    pub jobs: usize,
    /// Seconds that a call takes before and after any picture.
    pub call_overhead_s: f64,
    /// Seconds of CPU that a picture takes beside its pixels.
    pub picture_cpu_s: f64,
    /// The unit of length and the fall-off of lights, in words.
    pub units: String,
}

impl Default for Abilities {
    fn default() -> Self {
        Self {
            csg: false,
            shadows: false,
            optics: false,
            hidden_casters: false,
            coverage: false,
            crop_grid: None,
            block_mask: false,
            sample_position: [0.5, 0.5],
            depth_quantum: [0.0, 1e-6],
            jobs: 1,
            call_overhead_s: 0.1,
            picture_cpu_s: 0.006,
            units: "scene units; lights fade only where the film says so".into(),
        }
    }
}

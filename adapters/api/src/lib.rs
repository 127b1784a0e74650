//! What an adapter of decor is.
//!
//! An adapter puts one renderer behind decor. The core hands it *neutral*
//! values (a [`Scene`] of placed [`Prototype`]s, a [`Camera`], [`Light`]s) and
//! gets [`Layer`]s back: colour, coverage and depth of a window of the picture.
//! What the renderer can do is said beforehand in its [`Abilities`]; the core
//! plans by them, and never asks for more.
//!
//! ```text
//! api ← each adapter ← decor
//! ```
//!
//! The compiler keeps an adapter out of the core, and the core out of a
//! renderer's language. Text and process are apart: [`Adapter::scene_text`] is
//! a pure function that can be tested where the renderer is not installed.
//!
//! Conventions, everywhere: left-handed world, y up, z into the picture;
//! lengths in scene units, angles in degrees where a name ends in `_deg` and in
//! radians otherwise; colours linear; pixels counted from the upper left.

pub mod abilities;
pub mod adapter;
pub mod arrival;
pub mod blocks;
pub mod bounds;
pub mod camera;
#[cfg(feature = "conformance")]
pub mod conformance;
pub mod csg;
pub mod csg_bounds;
#[cfg(feature = "encode")]
pub mod encode;
pub mod extent;
pub mod health;
pub mod layer;
pub mod material;
pub mod mesh;
pub mod process;
pub mod prototype;
pub mod rendered;
pub mod scene;
pub mod tally;
pub mod transfer;

pub use abilities::{Abilities, DepthKind};
pub use adapter::{
    Adapter, AdapterError, Baseline, Health, LayerRequest, LayerShot, Output, Region, RunContext,
    Said, SceneText, Surroundings,
};
pub use arrival::{ArrivalRequest, ArrivalShot, SurfacePoint};
pub use blocks::{BLOCK, BlockMask, Blocks, block_window};
pub use bounds::{Bounds, Sphere};
pub use camera::{Camera, CameraError};
pub use csg::Csg;
pub use extent::Extent;
pub use layer::{Layer, Size, Window};
pub use material::{Highlight, Material};
pub use mesh::TriangleMesh;
pub use prototype::{Fragment, Geometry, Optics, Prototype, PrototypeId, PrototypeTable};
pub use rendered::{Picture, Rendered};
pub use scene::{
    Antialias, Fade, Instance, Light, LightKind, NativeFile, PictureFormat, Pose, Rgb, Scene,
    area_samples,
};
pub use tally::Tally;
pub use transfer::Transfer;

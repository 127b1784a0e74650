//! Object descriptions: from a path in a film to a prototype.
//!
//! | ending | what it is |
//! |---|---|
//! | `.inc`, `.pov` | a renderer-native fragment, kept as it was written |
//! | `.ron` | the neutral description: a CSG tree ([`neutral`]) |
//! | `.obj` `.ply` `.stl` `.gltf` `.glb` | a triangle mesh ([`mesh_file`]) |
//!
//! [`Library::load`] reads all descriptions of a film once, finds the sphere
//! around each, and stores each content once, whatever the number of its paths
//! (the thesis's hash table of descriptions). What a renderer says of a fragment
//! is kept between runs in the [`Cache`].

pub mod cache;
pub mod error;
mod files;
mod fragment;
pub mod library;
pub mod mesh_file;
pub mod neutral;
mod neutral_values;

pub(crate) use fragment::content_hash;

pub use cache::Cache;
pub use error::{ObjectError, ObjectProblem, TextError};
pub use files::FileError;
pub use library::Library;

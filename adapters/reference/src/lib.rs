//! decor's in-process ray caster: no installation, and the oracle of the tests.
//!
//! It previews a film, draws one where no renderer is installed, and says in
//! tests what is really seen, how far away, and what is in whose shadow. It is
//! no production renderer: uniform materials, point-like lights, flat facets.
//!
//! ```text
//! Csg ─ model ─→ Model (parts in object space) ─ world ─→ World (posed, in trees)
//!                                                           │ rays: picture
//!                                     Layer ←─ picture ←─ shade ←─ light
//! ```
//!
//! Rays, not triangles: a sphere is a sphere, at f64. Solids are cut by
//! intervals along the ray (`span`). Every value of a pixel depends on the
//! scene and on that pixel's place alone, so a window, a set of blocks and any
//! number of threads give the full frame's very bits.
//!
//! What it cannot draw is an error that names it: renderer-native fragments,
//! declarations and skies.

mod adapter;
mod arrival;
mod extent;
mod frustum;
mod light;
mod mesh;
mod model;
mod picture;
mod placement;
mod primitive;
mod ray;
mod roots;
mod shade;
mod shadow;
mod solid;
mod span;
mod torus;
mod tree;
mod world;

#[cfg(test)]
mod membership;

pub use adapter::{BLOCK, Reference};
pub use model::Models;
pub use world::{Hit, World};

//! decor renders animations faster, with the renderer people already have.

pub mod film;
pub mod objects;

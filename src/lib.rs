//! decor renders animations faster, with the renderer people already have.

pub mod compare;
pub mod film;
pub mod frames;
pub mod layer;
pub mod merge;
pub mod motion;
pub mod objects;
pub mod plan;
pub mod render;
pub mod segmentation;
pub mod stage;
pub mod cli;
pub mod renderers;
pub mod report;

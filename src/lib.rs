//! decor renders animations faster, with the renderer people already have.

pub mod cli;
pub mod compare;
pub mod film;
pub mod frames;
pub mod layer;
pub mod merge;
pub mod motion;
pub mod objects;
pub mod plan;
pub mod render;
pub mod renderers;
pub mod report;
pub mod segmentation;
pub mod stage;

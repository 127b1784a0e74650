//! What an object's bounding sphere is in the picture.

mod screen;

pub use screen::{ScreenBox, screen_box};

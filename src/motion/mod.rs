//! What an object's bounding sphere is in the picture, and how far it moves
//! there.
//!
//! Thesis, chapter II and III-2-3. [`ellipse`] is the sphere's picture;
//! [`RelativeMotion`] what happens between two instants, as the observer sees
//! it; [`bound`] the distance in pixels that no point of the sphere exceeds;
//! [`thesis`](mod@thesis) the measure of chapter II; [`clip`] what stays out of
//! the picture. No decision is made here: that is the segmentation's.

pub mod bound;
pub mod clip;
pub mod ellipse;
pub mod infinity;
mod relative;
mod screen;
pub mod thesis;
pub mod thesis_clip;
pub mod thesis_rotation;

pub use bound::{bound_orthographic_px, bound_px, bounds_px};
pub use clip::{Frustum, Sighting, first_in_view};
pub use ellipse::{Ellipse, Projection, Screen, project_sphere, project_sphere_orthographic};
pub use infinity::infinity_px;
pub use relative::{Lenses, ObserverMotion, RelativeMotion};
pub use screen::{ScreenBox, screen_box};
pub use thesis::{ThesisMeasure, thesis, thesis_px};

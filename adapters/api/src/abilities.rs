//! What an adapter says of itself. The core asks, and plans by the answer.

/// Along what a renderer measures depth. Layers always hold the distance along
/// the ray; this says what the adapter had to convert from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthKind {
    /// The distance from the eye to the surface.
    AlongRay,
    /// The distance from the plane through the eye, along the view's axis.
    AlongAxis,
}

/// The abilities of one adapter, with the renderer that it found.
#[derive(Clone, Debug, PartialEq)]
pub struct Abilities {
    /// The renderer's version as it prints it, for example `3.7.0.10`.
    pub version: String,
    /// Does it draw CSG trees, or only meshes?
    pub csg: bool,
    /// The endings of the renderer-native fragments that it reads (`inc`, `pov`).
    pub fragments: &'static [&'static str],
    /// Do colour and depth come out of one pass?
    pub depth_with_colour: bool,
    /// What its depth is measured along before the adapter converts it.
    pub depth: DepthKind,
    /// Where in the pixel a ray without antialiasing goes: (½, ½) is the centre.
    pub sample_position: (f64, f64),
    /// A window whose edges are at multiples of this number of pixels, or the
    /// picture's own, has the full frame's very values
    /// ([`Window::on_grid`](crate::Window::on_grid) makes such windows). `None`:
    /// windows are never identical.
    pub crop_grid: Option<u32>,
    /// Can it render any set of blocks of the full picture in one call?
    pub block_mask: bool,
    /// The side of the smallest blocks that it draws, in pixels: a divisor of
    /// [`BLOCK`](crate::BLOCK). Not with antialiasing, where what is refined in a
    /// block may depend on the whole of it: then blocks are of [`BLOCK`](crate::BLOCK).
    pub finest_block: u32,
    /// Does it hold blocks in a picture no larger than they need, and not in one of
    /// the whole frame's size, whose other pixels cost something too?
    pub masks_in_crops: bool,
    /// Can objects be hidden from the camera and still cast shadows?
    pub hidden_casters: bool,
    /// Can it shoot a list of rays, and so say how much light arrives at points?
    pub ray_list: bool,
    /// Does it state coverage (alpha): with antialiasing the share of a pixel, without
    /// it whether anything is there?
    pub coverage: bool,
    /// Does it render shadows?
    pub shadows: bool,
    /// Are mirrors and glass drawn? If not, every object is opaque and dull.
    pub optics: bool,
    /// How many of its calls run side by side with profit, on this machine, where
    /// pictures are small.
    pub jobs: usize,
    /// Seconds that one call takes before and after any picture.
    pub call_overhead_s: f64,
    /// Seconds of CPU that a picture of a plain scene takes beside its pixels: reading
    /// the scene, writing the file.
    pub picture_cpu_s: f64,
    /// The unit of length and the fall-off of lights, in words.
    pub units: &'static str,
}

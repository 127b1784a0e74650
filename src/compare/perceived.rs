//! How different two pictures look: SSIM and FLIP.

use super::flip::{Flip, flip};
use super::mask::Mask;
use super::picture::Picture;
use super::seen::Seen;
use super::ssim::{Ssim, ssim};

/// How different two pictures look.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Perceived {
    /// The structural similarity; none where a picture is smaller than a window.
    pub ssim: Option<Ssim>,
    /// The difference that is seen when the pictures alternate.
    pub flip: Flip,
}

/// SSIM and FLIP of two pictures of one size and one encoding, of the mask's
/// white pixels where there is a mask. Nothing where the sizes differ.
pub fn perceive(
    a: &Picture,
    b: &Picture,
    mask: Option<&Mask>,
    pixels_per_degree: f32,
) -> Option<Perceived> {
    let seen = Seen::new(a, b, mask)?;
    Some(Perceived {
        ssim: ssim(&seen, mask),
        flip: flip(&seen, mask, pixels_per_degree),
    })
}

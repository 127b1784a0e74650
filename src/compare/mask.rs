//! A mask: the pixels that count.

use std::path::Path;

use decor_api::Size;

use super::picture::{Picture, PictureError};

/// The pixels that count. One mask serves all frames.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    /// Its size: that of the pictures.
    pub size: Size,
    white: Vec<bool>,
}

impl Mask {
    /// White pixels count: those whose red, green and blue are all above a half
    /// of the range. Alpha is left out.
    pub fn of(picture: &Picture) -> Self {
        let white = |[r, g, b, _]: &[f32; 4]| [r, g, b].into_iter().all(|&value| value > 0.5);
        Self {
            size: picture.size,
            white: picture.values.iter().map(white).collect(),
        }
    }

    /// Reads the mask from a picture file.
    ///
    /// # Errors
    /// As of [`Picture::read`].
    pub fn read(path: &Path) -> Result<Self, PictureError> {
        Ok(Self::of(&Picture::read(path)?))
    }

    /// Does this pixel count, by its number row by row?
    pub fn counts(&self, pixel: usize) -> bool {
        self.white.get(pixel).copied().unwrap_or(false)
    }

    /// Which pixels of a row count.
    pub(super) fn row(&self, y: usize) -> &[bool] {
        let width = self.size.width as usize;
        self.white.get(y * width..(y + 1) * width).unwrap_or(&[])
    }

    /// How many pixels count.
    pub fn pixels(&self) -> u64 {
        self.white.iter().filter(|&&white| white).count() as u64
    }
}

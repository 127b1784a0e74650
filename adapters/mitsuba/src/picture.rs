//! Mitsuba's pictures: OpenEXR, single precision.

use std::path::Path;

use decor_api::{AdapterError, Size, Window};
use exr::prelude::{FlatSamples, read_first_flat_layer_from_file};

/// Red, green, blue and coverage, row by row.
pub(crate) struct Picture {
    size: Size,
    channels: [Vec<f32>; 4],
}

impl Picture {
    /// Reads a file of `size`.
    pub fn read(path: &Path, size: Size) -> Result<Self, AdapterError> {
        let image = read_first_flat_layer_from_file(path).map_err(|e| bad(path, &e.to_string()))?;
        let layer = image.layer_data;
        let found = (layer.size.0, layer.size.1);
        if found != (size.width as usize, size.height as usize) {
            return Err(bad(
                path,
                &format!("a picture of {found:?} instead of {size:?}"),
            ));
        }
        let mut channels: [Vec<f32>; 4] = Default::default();
        for channel in layer.channel_data.list {
            let place = match channel.name.to_string().as_str() {
                "R" => 0,
                "G" => 1,
                "B" => 2,
                "A" => 3,
                _ => continue,
            };
            channels[place] = match channel.sample_data {
                FlatSamples::F32(samples) => samples,
                _ => return Err(bad(path, "its channels are not single precision")),
            };
        }
        if channels.iter().any(|c| c.len() != size.pixels()) {
            return Err(bad(path, "not all of R, G, B and A are there"));
        }
        Ok(Self { size, channels })
    }

    /// Pixel (x, y). What is not a number is black.
    pub fn pixel(&self, x: u32, y: u32) -> [f32; 4] {
        let at = y as usize * self.size.width as usize + x as usize;
        let value = |channel: &Vec<f32>| {
            let v = channel.get(at).copied().unwrap_or(0.0);
            if v.is_nan() { 0.0 } else { v }
        };
        [0, 1, 2, 3].map(|c| value(&self.channels[c]))
    }
}

/// The size of the picture of a window.
pub(crate) fn size_of(window: Window, enlarged: u32) -> Size {
    Size {
        width: window.width * enlarged,
        height: window.height * enlarged,
    }
}

fn bad(path: &Path, reason: &str) -> AdapterError {
    AdapterError::BadOutput {
        program: "mitsuba".to_owned(),
        file: path.to_owned(),
        reason: reason.to_owned(),
    }
}

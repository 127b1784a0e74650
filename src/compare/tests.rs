//! The room's tests: numbers computed by hand, and the files that come wrong.

mod measuring;
mod perceiving;
mod reading;
mod whole;

use std::path::Path;

use decor_api::Size;

use super::metrics::Levels;
use super::picture::{Form, Picture};
use crate::layer::write_exr;

/// Any difference counts; nothing is a warning.
const STRICT: Levels = Levels {
    fail: 0.0,
    warn: f64::INFINITY,
    fail_depth: 0.0,
    warn_depth: f64::INFINITY,
};

/// A picture without alpha and depth.
fn picture(width: u32, form: Form, values: &[[f32; 3]]) -> Picture {
    Picture {
        size: Size {
            width,
            height: values.len() as u32 / width,
        },
        origin: (0, 0),
        form,
        encoding: form.encoding(),
        values: values.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect(),
        has_alpha: false,
        depth: None,
    }
}

/// Writes a PNG; `bytes` as the format has them.
fn write_png(
    path: &Path,
    (width, height): (u32, u32),
    (color, depth): (png::ColorType, png::BitDepth),
    bytes: &[u8],
) {
    let file = std::fs::File::create(path).unwrap();
    let mut encoder = png::Encoder::new(std::io::BufWriter::new(file), width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(bytes).unwrap();
    writer.finish().unwrap();
}

/// An RGB PNG of 8 bits.
fn write_rgb(path: &Path, size: (u32, u32), bytes: &[u8]) {
    write_png(
        path,
        size,
        (png::ColorType::Rgb, png::BitDepth::Eight),
        bytes,
    );
}

/// An EXR of opaque pixels.
fn write_float(path: &Path, (width, height): (u32, u32), grey: &[f32], depth: Option<&[f32]>) {
    let colour: Vec<[f32; 4]> = grey.iter().map(|&v| [v, v, v, 1.0]).collect();
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    write_exr(file, Size { width, height }, &colour, depth).unwrap();
}

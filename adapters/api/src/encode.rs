//! Finished pictures, for renderers without an encoder of their own: the sRGB
//! curve, and PNG and OpenEXR files. Behind the feature `encode`.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use crate::adapter::{Adapter, AdapterError, Baseline, RunContext};
use crate::layer::{Layer, Size};
use crate::scene::PictureFormat;

/// The sRGB curve, of a linear channel from 0 to 1.
pub fn srgb(linear: f32) -> f32 {
    let linear = if linear.is_nan() {
        0.0
    } else {
        linear.clamp(0.0, 1.0)
    };
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// The nearest of `max` + 1 steps of the sRGB curve.
pub fn step(linear: f32, max: u32) -> u32 {
    // In range by the clamp in `srgb`.
    (srgb(linear) * max as f32).round() as u32
}

/// [`Adapter::baseline`] of a renderer that writes layers alone: all frames in
/// one call of [`Adapter::render`], stored here, in `folder`.
///
/// # Errors
/// As [`Adapter::render`] and [`write()`].
pub fn baseline(
    adapter: &dyn Adapter,
    request: &Baseline<'_>,
    run: &RunContext,
) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
    let name = adapter.name();
    let folder = run.work.join(name);
    std::fs::create_dir_all(&folder).map_err(AdapterError::io(&folder))?;
    let layers = adapter.render(&request.layers(), run)?;
    let frames = request.frames.iter().zip(&layers);
    frames
        .map(|((frame, _), layer)| {
            let ending = request.format.extension();
            let file = folder.join(format!("baseline_{frame:04}.{ending}"));
            write(layer, request.size, request.format, &file, name)?;
            Ok((*frame, file))
        })
        .collect()
}

/// Writes the colour of a whole picture, without coverage. `program` is who is
/// named where that fails.
///
/// # Errors
/// [`AdapterError::Io`] where the file cannot be written;
/// [`AdapterError::BadOutput`] where the pixels are not those of such a picture.
pub fn write(
    layer: &Layer,
    size: Size,
    format: PictureFormat,
    path: &Path,
    program: &str,
) -> Result<(), AdapterError> {
    let pixels = layer.colour.as_deref().unwrap_or_default();
    if pixels.len() != size.pixels() {
        let reason = format!("{} pixels of {}", pixels.len(), size.pixels());
        return Err(bad(path, &reason, program));
    }
    let channels = || pixels.iter().flat_map(|p| p.iter().take(3).copied());
    match format {
        PictureFormat::Png => {
            let bytes: Vec<u8> = channels().map(|c| step(c, 255) as u8).collect();
            png(path, size, png::BitDepth::Eight, &bytes, program)
        }
        PictureFormat::Png16 => {
            let bytes: Vec<u8> = channels()
                .flat_map(|c| (step(c, 65535) as u16).to_be_bytes())
                .collect();
            png(path, size, png::BitDepth::Sixteen, &bytes, program)
        }
        PictureFormat::Exr => {
            let (width, height) = (size.width as usize, size.height as usize);
            let pixel = |x: usize, y: usize| match pixels.get(y * width + x) {
                Some(&[r, g, b, _]) => (r, g, b),
                None => (0.0, 0.0, 0.0),
            };
            exr::prelude::write_rgb_file(path, width, height, pixel).map_err(|error| match error {
                exr::error::Error::Io(source) => AdapterError::io(path)(source),
                other => bad(path, &other, program),
            })
        }
    }
}

fn png(
    path: &Path,
    size: Size,
    depth: png::BitDepth,
    bytes: &[u8],
    program: &str,
) -> Result<(), AdapterError> {
    let file = File::create(path).map_err(AdapterError::io(path))?;
    let mut encoder = png::Encoder::new(BufWriter::new(file), size.width, size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(depth);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let written = encoder.write_header().and_then(|mut writer| {
        writer.write_image_data(bytes)?;
        writer.finish()
    });
    written.map_err(|error| match error {
        png::EncodingError::IoError(source) => AdapterError::io(path)(source),
        other => bad(path, &other, program),
    })
}

fn bad(path: &Path, error: &dyn std::fmt::Display, program: &str) -> AdapterError {
    AdapterError::BadOutput {
        program: program.to_owned(),
        file: path.to_owned(),
        reason: error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_and_the_middle_of_the_curve() {
        assert_eq!(
            [step(0.0, 255), step(1.0, 255), step(7.0, 255)],
            [0, 255, 255]
        );
        assert_eq!([step(-1.0, 255), step(f32::NAN, 255)], [0, 0]);
        assert_eq!(step(0.214_041_14, 255), 128);
        assert_eq!(step(0.5, 65535), 48_192);
    }

    #[test]
    fn every_byte_comes_back() {
        for byte in 0..=255_u32 {
            let v = byte as f32 / 255.0;
            let linear = if v <= 0.040_45 {
                v / 12.92
            } else {
                ((v + 0.055) / 1.055).powf(2.4)
            };
            assert_eq!(step(linear, 255), byte);
        }
    }
}

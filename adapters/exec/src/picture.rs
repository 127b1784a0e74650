//! Layers out of OpenEXR files. What is not what was asked for is an error,
//! never a picture.

use std::path::Path;

use decor_api::{Output, Window};
use exr::prelude::{FlatSamples, ReadChannels as _, ReadLayers as _};

/// The pixels of a layer.
pub enum Pixels {
    /// Premultiplied colour and coverage.
    Colour(Vec<[f32; 4]>),
    /// Distances.
    Depth(Vec<f64>),
}

/// Coverage may be off by this from what is possible: sums of f32 are.
const ROUNDING: f32 = 1e-4;

/// Reads a layer's file.
///
/// # Errors
/// What is wrong with it, in words.
pub fn read(path: &Path, window: Window, output: Output) -> Result<Pixels, String> {
    let bytes = std::fs::read(path).map_err(|error| format!("it cannot be read: {error}"))?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(std::io::Cursor::new(bytes))
        .map_err(|error| format!("it is no OpenEXR file that can be read: {error}"))?;
    let layer = &image.layer_data;
    let (width, height) = (window.width as usize, window.height as usize);
    if (layer.size.x(), layer.size.y()) != (width, height) {
        return Err(format!(
            "it has {} × {} pixels, not {width} × {height}",
            layer.size.x(),
            layer.size.y()
        ));
    }
    let channel = |name: &str| {
        let mut all = layer.channel_data.list.iter();
        let found = all.find(|channel| channel.name.eq(name));
        match found.map(|channel| &channel.sample_data) {
            Some(FlatSamples::F32(values)) if values.len() == width * height => Ok(&values[..]),
            Some(_) => Err(format!("its channel {name} is not of 32-bit floats")),
            None => Err(format!("it has no channel {name}")),
        }
    };
    if output == Output::Depth {
        return depth(channel("Z")?).map(Pixels::Depth);
    }
    let channels = [channel("R")?, channel("G")?, channel("B")?, channel("A")?];
    let pixels = colour(channels)?;
    let open = |pixel: &&[f32; 4]| pixel[3] < 1.0 - ROUNDING;
    if output == Output::ColourOverBackground
        && let Some(pixel) = pixels.iter().find(open)
    {
        return Err(format!("the background covers, and A is {}", pixel[3]));
    }
    Ok(Pixels::Colour(pixels))
}

fn depth(values: &[f32]) -> Result<Vec<f64>, String> {
    let distance = |(k, &z): (usize, &f32)| {
        // Not a number fails this too.
        if z > 0.0 {
            Ok(f64::from(z))
        } else {
            Err(format!("the depth of pixel {k} is {z}"))
        }
    };
    values.iter().enumerate().map(distance).collect()
}

fn colour([r, g, b, a]: [&[f32]; 4]) -> Result<Vec<[f32; 4]>, String> {
    let pixel = |k: usize| {
        let (colour, coverage) = ([r[k], g[k], b[k]], a[k]);
        if !colour.iter().all(|c| c.is_finite()) {
            return Err(format!("the colour of pixel {k} is {colour:?}"));
        }
        if !(-ROUNDING..=1.0 + ROUNDING).contains(&coverage) {
            return Err(format!("the coverage of pixel {k} is {coverage}"));
        }
        Ok([r[k], g[k], b[k], coverage.clamp(0.0, 1.0)])
    };
    (0..r.len()).map(pixel).collect()
}

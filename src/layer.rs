//! Layers as files: OpenEXR, linear, premultiplied, with the depth in `Z`.

use std::io::{Seek, Write};
use std::path::Path;

use decor_api::{Size, Window};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer as ExrLayer, LayerAttributes,
    SmallVec, WritableImage,
};

/// Why a layer's file cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum LayerFileError {
    /// The library's word.
    #[error(transparent)]
    Exr(#[from] exr::error::Error),
    /// It has no colour channels.
    #[error("it has no channels R, G and B")]
    NoColour,
}

/// What a file holds of a layer.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredLayer {
    /// The whole picture.
    pub window: Window,
    /// Linear red, green, blue, premultiplied by coverage, and coverage.
    pub colour: Option<Vec<[f32; 4]>>,
    /// The distance along the ray; +∞ where nothing is.
    pub depth: Option<Vec<f32>>,
}

/// Writes a whole frame: red, green, blue and coverage as `R G B A`, the
/// distance along the ray at the pixel's centre as `Z` (+∞ where nothing is),
/// all 32 bits.
///
/// # Errors
/// Where the target cannot be written.
pub fn write_exr(
    target: impl Write + Seek,
    size: Size,
    colour: &[[f32; 4]],
    depth: Option<&[f32]>,
) -> Result<(), LayerFileError> {
    let plane = |k: usize| FlatSamples::F32(colour.iter().map(|pixel| pixel[k]).collect());
    let mut channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = SmallVec::new();
    for (k, name) in ["R", "G", "B", "A"].into_iter().enumerate() {
        channels.push(AnyChannel::new(name, plane(k)));
    }
    if let Some(depth) = depth {
        channels.push(AnyChannel::new("Z", FlatSamples::F32(depth.to_vec())));
    }
    let layer = ExrLayer::new(
        (size.width as usize, size.height as usize),
        LayerAttributes::named(""),
        Encoding::FAST_LOSSLESS,
        AnyChannels::sort(channels),
    );
    Image::from_layer(layer).write().to_buffered(target)?;
    Ok(())
}

/// Reads the first layer of an OpenEXR file. Coverage is 1 where the file has
/// no `A`; the depth is there where it has a `Z`.
///
/// # Errors
/// Where it is no such file, or has no colour.
pub fn read_exr(path: &Path) -> Result<StoredLayer, LayerFileError> {
    let image = exr::prelude::read_first_flat_layer_from_file(path)?;
    let layer = image.layer_data;
    let (width, height) = (layer.size.0, layer.size.1);
    let channel = |name: &str| {
        layer
            .channel_data
            .list
            .iter()
            .find(|c| c.name.eq_case_insensitive(name))
            .map(|c| c.sample_data.values_as_f32().collect::<Vec<f32>>())
    };
    let grey = channel("Y");
    let plane = |name: &str| {
        channel(name)
            .or_else(|| grey.clone())
            .ok_or(LayerFileError::NoColour)
    };
    let (r, g, b) = (plane("R")?, plane("G")?, plane("B")?);
    let a = channel("A").unwrap_or_else(|| vec![1.0; r.len()]);
    let colour = (0..r.len()).map(|k| [r[k], g[k], b[k], a[k]]).collect();
    Ok(StoredLayer {
        window: Window {
            x: 0,
            y: 0,
            width: width as u32,
            height: height as u32,
        },
        colour: Some(colour),
        depth: channel("Z"),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back_bit_for_bit() {
        let size = Size {
            width: 3,
            height: 2,
        };
        let colour: Vec<[f32; 4]> = (0..6)
            .map(|k| [k as f32 * 0.1, 1e-20, 7.5, 1.0 / (k + 1) as f32])
            .collect();
        let depth = [1.0, f32::INFINITY, 1e-3, 1e7, 2.5, 0.1];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("layer.exr");
        let file = std::fs::File::create(&path).unwrap();
        write_exr(std::io::BufWriter::new(file), size, &colour, Some(&depth)).unwrap();
        let layer = read_exr(&path).unwrap();
        assert_eq!(layer.colour.unwrap(), colour);
        assert_eq!(layer.depth.unwrap(), depth);
    }
}

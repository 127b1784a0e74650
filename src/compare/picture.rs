//! Reading the pictures that are compared: PNG without losing 16 bits, OpenEXR
//! with its depth. What the numbers mean is kept beside them; nothing is
//! colour-managed, a PNG's gamma or profile is not applied.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use decor_api::Size;

use crate::layer::{LayerFileError, read_exr};

/// More pixels than a film has (16384 × 16384): a header that says so is broken,
/// and must not be believed before memory is asked for.
const MAX_PIXELS: u64 = 1 << 28;

/// Why a picture cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The file system says no.
    #[error("it cannot be opened")]
    Open(#[source] std::io::Error),
    /// Told by its first bytes, not by its name.
    #[error("it is neither PNG nor OpenEXR")]
    UnknownFormat,
    /// The PNG decoder's word.
    #[error("it is no whole PNG")]
    Png(#[source] png::DecodingError),
    /// The EXR decoder's word.
    #[error("it is no whole OpenEXR picture")]
    Exr(#[source] LayerFileError),
    /// Its header asks for more than any picture needs.
    #[error("its header says {width}×{height}, which is not believed")]
    TooLarge {
        /// Columns.
        width: u64,
        /// Rows.
        height: u64,
    },
    /// A channel has fewer samples than the picture has pixels.
    #[error("its channel {channel} is subsampled, which is not supported")]
    Subsampled {
        /// The channel's name.
        channel: String,
    },
}

/// What a picture was stored as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// 8 bits a channel or fewer, display-referred.
    Png8,
    /// 16 bits a channel, display-referred.
    Png16,
    /// Floating point, linear, premultiplied by coverage.
    Exr,
}

/// What the values of a picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// As a display takes them: 0 is black, 1 is full, a transfer function is
    /// applied. Colour is not multiplied by alpha.
    Display,
    /// Proportional to light, unbounded, premultiplied by coverage.
    Linear,
}

impl Form {
    /// What the values mean.
    pub fn encoding(self) -> Encoding {
        match self {
            Self::Png8 | Self::Png16 => Encoding::Display,
            Self::Exr => Encoding::Linear,
        }
    }
}

/// A picture in memory, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Its size.
    pub size: Size,
    /// Where its first pixel is in the whole frame: the data window of an EXR,
    /// relative to its display window. (0, 0) for every other picture.
    pub origin: (i64, i64),
    /// What it was stored as.
    pub form: Form,
    /// What the values mean: [`Form::encoding`]'s word, until they are made to
    /// mean something else.
    pub encoding: Encoding,
    /// Red, green, blue, alpha, one entry a pixel; grey is all three. Alpha is 1
    /// where the file has none.
    pub values: Vec<[f32; 4]>,
    /// Has the file an alpha of its own?
    pub has_alpha: bool,
    /// The channel `Z`, one entry a pixel, +∞ where nothing is.
    pub depth: Option<Vec<f32>>,
}

impl Picture {
    /// Reads a picture. The format is told by the first bytes.
    ///
    /// # Errors
    /// Where the file cannot be opened, is cut off, damaged, or of another kind.
    pub fn read(path: &Path) -> Result<Self, PictureError> {
        let mut magic = [0; 4];
        let mut file = File::open(path).map_err(PictureError::Open)?;
        match file.read_exact(&mut magic) {
            Err(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => {
                return Err(PictureError::Open(error));
            }
            _ => {}
        }
        match &magic {
            b"\x89PNG" => read_png(path),
            b"\x76\x2f\x31\x01" => read_linear(path),
            _ => Err(PictureError::UnknownFormat),
        }
    }

    /// This picture as a display would take it: a linear one through sRGB's
    /// transfer function (IEC 61966-2-1), cut to 0..1; any other unchanged.
    ///
    /// `straight`: divide the colour by alpha first, because what it is compared
    /// with is not premultiplied. Otherwise the colour stays as it lies on black.
    pub fn as_display(&self, straight: bool) -> Self {
        let mut picture = self.clone();
        if self.encoding == Encoding::Display {
            return picture;
        }
        picture.encoding = Encoding::Display;
        for [r, g, b, a] in &mut picture.values {
            for channel in [r, g, b] {
                if straight && *a > 0.0 {
                    *channel /= *a;
                }
                *channel = srgb(*channel);
            }
        }
        picture
    }
}

/// The transfer function of sRGB, cut to 0..1. NaN stays NaN: it has to be found.
pub(super) fn srgb(linear: f32) -> f32 {
    let linear = f64::from(linear).clamp(0.0, 1.0);
    let value = if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    };
    value as f32
}

fn believed(width: u64, height: u64) -> Result<Size, PictureError> {
    let too_large = || PictureError::TooLarge { width, height };
    if width.saturating_mul(height) > MAX_PIXELS {
        return Err(too_large());
    }
    Ok(Size {
        width: u32::try_from(width).map_err(|_| too_large())?,
        height: u32::try_from(height).map_err(|_| too_large())?,
    })
}

fn read_png(path: &Path) -> Result<Picture, PictureError> {
    let file = File::open(path).map_err(PictureError::Open)?;
    let mut decoder = png::Decoder::new(BufReader::new(file));
    // Palettes and 1, 2, 4 bits become 8 bits, a transparent colour becomes
    // alpha; 16 bits stay 16.
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(PictureError::Png)?;
    let (width, height) = reader.info().size();
    let size = believed(u64::from(width), u64::from(height))?;
    let too_large = PictureError::TooLarge {
        width: width.into(),
        height: height.into(),
    };
    let mut bytes = vec![0; reader.output_buffer_size().ok_or(too_large)?];
    let info = reader.next_frame(&mut bytes).map_err(PictureError::Png)?;
    // A file that ends before its end mark was not written to its end.
    reader.finish().map_err(PictureError::Png)?;
    let (form, max, sample_bytes) = match info.bit_depth {
        png::BitDepth::Sixteen => (Form::Png16, 65535.0, 2),
        _ => (Form::Png8, 255.0, 1),
    };
    // A division of whole numbers is rounded once: 8 bits and the same value in
    // 16 (257 times as much) become the same float.
    let value = |sample: &[u8]| match *sample {
        [high, low] => f32::from(u16::from_be_bytes([high, low])) / max,
        [byte] => f32::from(byte) / max,
        _ => 0.0,
    };
    let channels = info.color_type.samples();
    let values = bytes
        .chunks_exact(channels * sample_bytes)
        .map(|pixel| {
            let mut samples = [0.0; 4];
            for (sample, bytes) in samples.iter_mut().zip(pixel.chunks_exact(sample_bytes)) {
                *sample = value(bytes);
            }
            let [first, second, third, fourth] = samples;
            match channels {
                1 => [first, first, first, 1.0],
                2 => [first, first, first, second],
                3 => [first, second, third, 1.0],
                _ => [first, second, third, fourth],
            }
        })
        .collect();
    Ok(Picture {
        size,
        origin: (0, 0),
        form,
        encoding: form.encoding(),
        values,
        has_alpha: matches!(channels, 2 | 4),
        depth: None,
    })
}

fn read_linear(path: &Path) -> Result<Picture, PictureError> {
    let exr = |error: exr::error::Error| PictureError::Exr(error.into());
    let meta = exr::meta::MetaData::read_from_file(path, false).map_err(exr)?;
    let mut origin = (0, 0);
    let mut has_alpha = false;
    // `read_exr` takes the first layer that is not deep.
    if let Some(header) = meta.headers.iter().find(|header| !header.deep) {
        believed(header.layer_size.0 as u64, header.layer_size.1 as u64)?;
        let data = header.own_attributes.layer_position;
        let display = header.shared_attributes.display_window.position;
        let offset = |data: i32, display: i32| i64::from(data) - i64::from(display);
        origin = (offset(data.0, display.0), offset(data.1, display.1));
        for channel in &header.channels.list {
            has_alpha |= channel.name.eq_case_insensitive("A");
            if (channel.sampling.0, channel.sampling.1) != (1, 1) {
                let channel = channel.name.to_string();
                return Err(PictureError::Subsampled { channel });
            }
        }
    }
    let layer = read_exr(path).map_err(PictureError::Exr)?;
    Ok(Picture {
        size: Size {
            width: layer.window.width,
            height: layer.window.height,
        },
        origin,
        form: Form::Exr,
        encoding: Encoding::Linear,
        values: layer.colour.unwrap_or_default(),
        has_alpha,
        depth: layer.depth,
    })
}

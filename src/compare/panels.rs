//! The difference picture: A, B and |A − B| ×16 side by side.
//!
//! A and B are shown as a display takes them, alpha and depth left out. The
//! third panel has, per channel, the difference of the compared values or of
//! alpha, whichever is larger; what is not finite is magenta.

use super::picture::{Encoding, Picture, srgb};

/// What differences are multiplied by: one step of 8 bits is just visible.
const AMPLIFIED: f32 = 16.0;
/// Pixels between two panels.
const SEPARATOR: usize = 2;
const SEPARATOR_COLOUR: [u8; 3] = [200; 3];
const NOT_FINITE: [u8; 3] = [255, 0, 255];

/// The bytes of the PNG, of two pictures of one size and encoding.
///
/// # Errors
/// Where the picture would be too wide for the format.
pub fn png(a: &Picture, b: &Picture) -> Result<Vec<u8>, png::EncodingError> {
    let width = a.size.width as usize;
    let wide = u32::try_from(3 * width + 2 * SEPARATOR).map_err(|_| {
        png::EncodingError::from(std::io::Error::from(std::io::ErrorKind::FileTooLarge))
    })?;
    let mut bytes = Vec::with_capacity(wide as usize * a.size.height as usize * 3);
    if width > 0 {
        let rows = a
            .values
            .chunks_exact(width)
            .zip(b.values.chunks_exact(width));
        let separator = SEPARATOR_COLOUR.repeat(SEPARATOR);
        for (row_a, row_b) in rows {
            bytes.extend(row_a.iter().flat_map(|&pixel| shown(a, pixel)));
            bytes.extend(&separator);
            bytes.extend(row_b.iter().flat_map(|&pixel| shown(b, pixel)));
            bytes.extend(&separator);
            let alpha = a.has_alpha && b.has_alpha;
            let pixels = row_a.iter().zip(row_b);
            bytes.extend(pixels.flat_map(|(&a, &b)| amplified(a, b, alpha)));
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, wide, a.size.height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&bytes)?;
    writer.finish()?;
    Ok(file)
}

fn shown(picture: &Picture, [r, g, b, _]: [f32; 4]) -> [u8; 3] {
    if [r, g, b].iter().any(|value| value.is_nan()) {
        return NOT_FINITE;
    }
    [r, g, b].map(|value| match picture.encoding {
        Encoding::Display => byte(value),
        Encoding::Linear => byte(srgb(value)),
    })
}

fn amplified(a: [f32; 4], b: [f32; 4], alpha: bool) -> [u8; 3] {
    let difference = |k: usize| {
        if a[k] == b[k] {
            0.0
        } else {
            (a[k] - b[k]).abs()
        }
    };
    let of_alpha = if alpha { difference(3) } else { 0.0 };
    let differences = [0, 1, 2].map(difference);
    if !differences
        .iter()
        .chain([&of_alpha])
        .all(|value| value.is_finite())
    {
        return NOT_FINITE;
    }
    differences.map(|value| byte(AMPLIFIED * value.max(of_alpha)))
}

fn byte(value: f32) -> u8 {
    // The conversion saturates.
    (value * 255.0 + 0.5) as u8
}

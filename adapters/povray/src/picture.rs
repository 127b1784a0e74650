//! POV-Ray's 16-bit pictures as layers: binary PPM, and PNG where coverage is
//! wanted. The way that every version has.

use std::io::{BufRead, Read};
use std::sync::LazyLock;

use decor_api::Window;

use crate::encode;

/// How the integers stand for light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// By the sRGB transfer function.
    Srgb,
    /// As they are.
    Linear,
}

/// Why a picture cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Neither a binary PPM nor a PNG of 16 bits.
    #[error("it is no 16-bit PPM or PNG picture")]
    Format,
    /// It is smaller than what was asked for, or cut off.
    #[error("it is {width}×{height} pixels or cut off; {window:?} was wanted")]
    Short {
        /// Its width.
        width: u32,
        /// Its height.
        height: u32,
        /// What was wanted of it.
        window: Window,
    },
    /// It cannot be read.
    #[error("it cannot be read")]
    Unreadable(#[from] std::io::Error),
    /// The PNG is damaged.
    #[error("it is a damaged PNG")]
    Png(#[from] png::DecodingError),
}

/// The pixels of `window`: linear, premultiplied, with coverage.
///
/// # Errors
/// Where the picture is of another format, damaged or too small.
pub fn pixels(file: &[u8], window: Window, coding: Coding) -> Result<Vec<[f32; 4]>, PictureError> {
    if file.starts_with(b"P6") {
        ppm(file, window, coding)
    } else {
        png(file, window, coding)
    }
}

fn ppm(file: &[u8], window: Window, coding: Coding) -> Result<Vec<[f32; 4]>, PictureError> {
    let (numbers, data) = ppm_header(file).ok_or(PictureError::Format)?;
    let [width, height, max] = numbers;
    if max != 65535 {
        return Err(PictureError::Format);
    }
    let short = shortage(width, height, window)?;
    let mut out = Vec::with_capacity(window.pixels());
    for y in window.y..window.bottom() {
        let from = 6 * (y as usize * width as usize + window.x as usize);
        let row = data
            .get(from..from + 6 * window.width as usize)
            .ok_or_else(short)?;
        out.extend(row.chunks_exact(6).map(|pixel| {
            let channel = |k: usize| decode(be_u16(pixel, k), coding);
            [channel(0), channel(1), channel(2), 1.0]
        }));
    }
    Ok(out)
}

/// The error of a picture that ends early; that error itself, where a picture of
/// this size cannot hold `window`.
fn shortage(
    width: u32,
    height: u32,
    window: Window,
) -> Result<impl Fn() -> PictureError + Copy, PictureError> {
    let short = move || PictureError::Short {
        width,
        height,
        window,
    };
    if window.right() > width || window.bottom() > height {
        return Err(short());
    }
    Ok(short)
}

/// The numbers of a binary PPM's `window` as they are: red, green and blue of
/// each pixel, of 8 or of 16 bits. Only the window is kept.
///
/// # Errors
/// As [`pixels`].
pub fn encoded(mut file: impl BufRead, window: Window, bits: u8) -> Result<Vec<u8>, PictureError> {
    /// POV-Ray's own is shorter; a comment may stand in it.
    const HEADER: usize = 1 << 10;
    let mut header = Vec::new();
    // Three lines that are no comments: P6, the size, the largest value.
    let mut lines = 0;
    while lines < 3 && header.len() < HEADER {
        let before = header.len();
        let read = file.by_ref().take((HEADER - before) as u64);
        if { read }.read_until(b'\n', &mut header)? == 0 {
            break;
        }
        lines += usize::from(header[before] != b'#');
    }
    let (numbers, _) = ppm_header(&header).ok_or(PictureError::Format)?;
    let [width, height, max] = numbers;
    if !header.starts_with(b"P6") || max != (1 << bits) - 1 {
        return Err(PictureError::Format);
    }
    let short = shortage(width, height, window)?;
    let pixel = 3 * usize::from(bits / 8);
    let mut row = vec![0; pixel * width as usize];
    let mut bytes = Vec::with_capacity(pixel * window.pixels());
    let (from, length) = (pixel * window.x as usize, pixel * window.width as usize);
    for y in 0..window.bottom() {
        file.read_exact(&mut row).map_err(|_| short())?;
        if y >= window.y {
            bytes.extend_from_slice(&row[from..from + length]);
        }
    }
    Ok(bytes)
}

/// Width, height and largest value, and what follows.
fn ppm_header(file: &[u8]) -> Option<([u32; 3], &[u8])> {
    let mut at = 2;
    let mut numbers = [0_u32; 3];
    for number in &mut numbers {
        loop {
            match file.get(at)? {
                b'#' => at += file[at..].iter().position(|&b| b == b'\n')?,
                b if b.is_ascii_whitespace() => at += 1,
                _ => break,
            }
        }
        let digits = file[at..].iter().take_while(|b| b.is_ascii_digit()).count();
        *number = std::str::from_utf8(&file[at..at + digits])
            .ok()?
            .parse()
            .ok()?;
        at += digits;
    }
    Some((numbers, file.get(at + 1..)?))
}

fn png(file: &[u8], window: Window, coding: Coding) -> Result<Vec<[f32; 4]>, PictureError> {
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info()?;
    let info = reader.info();
    let (width, height) = (info.width, info.height);
    if info.bit_depth != png::BitDepth::Sixteen || info.color_type != png::ColorType::Rgba {
        return Err(PictureError::Format);
    }
    let short = shortage(width, height, window)?;
    let mut data = vec![0; reader.output_buffer_size().ok_or_else(short)?];
    reader.next_frame(&mut data)?;
    let mut out = Vec::with_capacity(window.pixels());
    for y in window.y..window.bottom() {
        let from = 8 * (y as usize * width as usize + window.x as usize);
        let row = data
            .get(from..from + 8 * window.width as usize)
            .ok_or_else(short)?;
        out.extend(row.chunks_exact(8).map(|pixel| {
            let alpha = f32::from(be_u16(pixel, 3)) / 65535.0;
            // PNG's colour is straight.
            let channel = |k: usize| decode(be_u16(pixel, k), coding) * alpha;
            [channel(0), channel(1), channel(2), alpha]
        }));
    }
    Ok(out)
}

fn be_u16(pixel: &[u8], channel: usize) -> u16 {
    u16::from_be_bytes([pixel[2 * channel], pixel[2 * channel + 1]])
}

fn decode(value: u16, coding: Coding) -> f32 {
    match coding {
        Coding::Srgb => linear_of()[usize::from(value)],
        Coding::Linear => f32::from(value) / 65535.0,
    }
}

/// The linear value of every integer: a power for each channel of each pixel
/// would take ten times as long as reading it.
fn linear_of() -> &'static [f32; 1 << 16] {
    static TABLE: LazyLock<Box<[f32; 1 << 16]>> = LazyLock::new(|| {
        let mut table = Box::new([0.0; 1 << 16]);
        for (value, linear) in (0..).zip(table.iter_mut()) {
            *linear = encode::linear(value, 65535);
        }
        table
    });
    &TABLE
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_ppm_with_a_comment_is_read() {
        let mut file = b"P6\n# by POV-Ray\n2 1\n65535\n".to_vec();
        file.extend([0, 0, 0xff, 0xff, 0x80, 0x00, 1, 1, 2, 2, 3, 3]);
        let window = Window {
            x: 1,
            y: 0,
            width: 1,
            height: 1,
        };
        let pixels = pixels(&file, window, Coding::Linear).unwrap();
        assert_eq!(
            pixels,
            [[257.0 / 65535.0, 514.0 / 65535.0, 771.0 / 65535.0, 1.0]]
        );
    }

    #[test]
    fn a_window_of_an_encoded_picture_is_its_own_bytes() {
        let mut file = b"P6\n# by POV-Ray\n3 2\n255\n".to_vec();
        file.extend(0..18);
        let window = Window {
            x: 1,
            y: 1,
            width: 2,
            height: 1,
        };
        let bytes = encoded(&file[..], window, 8).unwrap();
        assert_eq!(bytes, [12, 13, 14, 15, 16, 17]);
        assert!(matches!(
            encoded(&file[..], window, 16),
            Err(PictureError::Format)
        ));
        file.pop();
        assert!(matches!(
            encoded(&file[..], window, 8),
            Err(PictureError::Short { .. })
        ));
        let mut wide = b"P6\n1 1\n65535\n".to_vec();
        wide.extend([1, 2, 3, 4, 5, 6]);
        let window = Window {
            x: 0,
            y: 0,
            width: 1,
            height: 1,
        };
        assert_eq!(
            encoded(&wide[..], window, 16).unwrap(),
            wide[wide.len() - 6..]
        );
    }

    #[test]
    fn a_short_picture_is_noticed() {
        let file = b"P6\n2 2\n65535\n0123456789";
        let window = Window {
            x: 0,
            y: 0,
            width: 2,
            height: 2,
        };
        assert!(matches!(
            pixels(file, window, Coding::Linear),
            Err(PictureError::Short { .. })
        ));
    }

    proptest! {
        #[test]
        fn any_bytes_are_refused_or_read(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
            let window = Window { x: 0, y: 0, width: 2, height: 2 };
            let mut ppm = b"P6".to_vec();
            ppm.extend(&bytes);
            let _ = pixels(&ppm, window, Coding::Srgb);
            let _ = pixels(&bytes, window, Coding::Srgb);
            let _ = encoded(&ppm[..], window, 8);
        }
    }
}

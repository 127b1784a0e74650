//! Finished frames as one animated PNG: something to look at, everywhere.

use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Why there is no animation.
#[derive(Debug, thiserror::Error)]
pub enum AnimationError {
    /// A frame cannot be read.
    #[error("{} cannot be read as a PNG", path.display())]
    Frame {
        /// The frame.
        path: PathBuf,
        /// Why.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The animation cannot be written.
    #[error("{} cannot be written", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// One picture, 8 bits a channel.
struct Picture {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

/// Writes `frames`, PNG files of one size, as an animation that plays for ever.
///
/// # Errors
/// Where a frame cannot be read, or the file cannot be written; then no file is
/// left at `path`.
pub fn write_apng(
    frames: &[PathBuf],
    path: &Path,
    frames_per_second: u16,
) -> Result<(), AnimationError> {
    let Some(first) = frames.first() else {
        return Ok(());
    };
    let failed = |source: Box<dyn std::error::Error + Send + Sync>| AnimationError::Write {
        path: path.to_owned(),
        source,
    };
    let start = read(first)?;
    let mut bytes = Vec::new();
    {
        let mut encoder = png::Encoder::new(BufWriter::new(&mut bytes), start.width, start.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let prepare = |encoder: &mut png::Encoder<'_, _>| {
            encoder.set_animated(frames.len() as u32, 0)?;
            encoder.set_frame_delay(1, frames_per_second.max(1))
        };
        prepare(&mut encoder).map_err(|e| failed(e.into()))?;
        let mut writer = encoder.write_header().map_err(|e| failed(e.into()))?;
        writer
            .write_image_data(&start.rgb)
            .map_err(|e| failed(e.into()))?;
        for frame in &frames[1..] {
            let picture = read(frame)?;
            writer
                .write_image_data(&picture.rgb)
                .map_err(|e| failed(e.into()))?;
        }
        writer.finish().map_err(|e| failed(e.into()))?;
    }
    crate::frames::write_safely(path, &bytes).map_err(|e| failed(e.into()))
}

fn read(path: &Path) -> Result<Picture, AnimationError> {
    let failed = |source: Box<dyn std::error::Error + Send + Sync>| AnimationError::Frame {
        path: path.to_owned(),
        source,
    };
    let picture = image::open(path).map_err(|e| failed(e.into()))?.into_rgb8();
    Ok(Picture {
        width: picture.width(),
        height: picture.height(),
        rgb: picture.into_raw(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_frames_are_in_it() {
        let folder = tempfile::tempdir().unwrap();
        let frames: Vec<PathBuf> = (0..3_u8)
            .map(|k| {
                let path = folder.path().join(format!("{k}.png"));
                image::RgbImage::from_pixel(4, 3, image::Rgb([k * 100, 0, 0]))
                    .save(&path)
                    .unwrap();
                path
            })
            .collect();
        let out = folder.path().join("film.png");
        write_apng(&frames, &out, 12).unwrap();
        let file = std::io::BufReader::new(std::fs::File::open(&out).unwrap());
        let mut reader = png::Decoder::new(file).read_info().unwrap();
        assert_eq!(reader.info().animation_control().unwrap().num_frames, 3);
        let mut reds = Vec::new();
        for _ in 0..3 {
            let mut data = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut data).unwrap();
            reds.push(data[0]);
        }
        assert_eq!(reds, [0, 100, 200]);
    }
}

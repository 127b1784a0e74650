//! Finished frames: their names, their encoding, and writing them so that no
//! file is ever half there.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use decor_api::{Adapter, Layer, PictureFormat, Size};
use rayon::prelude::*;

use crate::layer::{LayerFileError, write_exr};
use crate::merge::Patch;

/// Why a frame cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The file system says no.
    #[error("{} cannot be written", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// The encoder says no.
    #[error("{} cannot be encoded", path.display())]
    Png {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: png::EncodingError,
    },
    /// The encoder says no.
    #[error("{} cannot be encoded", path.display())]
    Exr {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: LayerFileError,
    },
}

/// The file name of a frame: `frame_0007.png`.
pub fn name(number: u32, format: PictureFormat) -> String {
    format!("frame_{number:04}.{}", format.extension())
}

/// Writes a file beside its place and renames it: whoever looks sees the whole
/// of it or nothing.
///
/// # Errors
/// [`WriteError::Io`].
pub fn write_safely(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let io = |source| WriteError::Io {
        path: path.to_owned(),
        source,
    };
    let folder = path
        .parent()
        .filter(|p| !p.as_os_str().is_empty())
        .unwrap_or(Path::new("."));
    let mut file = tempfile::Builder::new()
        .prefix(".decor-")
        .suffix(".part")
        .tempfile_in(folder)
        .map_err(io)?;
    file.write_all(bytes).map_err(io)?;
    // A temporary file is its owner's alone; a picture is as any other file.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        let permissions = std::fs::Permissions::from_mode(0o666 & !umask());
        file.as_file().set_permissions(permissions).map_err(io)?;
    }
    file.persist(path).map_err(|error| io(error.error))?;
    Ok(())
}

/// The process's file mode mask, read from a file that it makes: the system
/// call would have to change it to tell it.
#[cfg(unix)]
fn umask() -> u32 {
    use std::os::unix::fs::PermissionsExt as _;
    use std::sync::OnceLock;
    static MASK: OnceLock<u32> = OnceLock::new();
    *MASK.get_or_init(|| {
        let read = || -> std::io::Result<u32> {
            let folder = tempfile::tempdir()?;
            let probe = folder.path().join("mask");
            std::fs::File::create(&probe)?;
            Ok(0o666 & !std::fs::metadata(&probe)?.permissions().mode())
        };
        read().unwrap_or(0o022)
    })
}

/// A picture that frames begin with: the décor, or nothing. It is encoded once;
/// a frame encodes only what it changes.
pub struct Ground {
    size: Size,
    colour: Arc<Vec<[f32; 4]>>,
    depth: Option<Arc<Vec<f32>>>,
    encoded: Option<Vec<u8>>,
}

/// How frames are encoded.
pub struct Encoder<'a> {
    /// Whose transfer function.
    pub adapter: &'a dyn Adapter,
    /// Into what.
    pub format: PictureFormat,
}

impl Ground {
    /// Nothing but the size: every pixel is to be replaced.
    pub fn empty(size: Size, encoder: &Encoder<'_>) -> Self {
        let exr = encoder.format == PictureFormat::Exr;
        let pixels = if exr { size.pixels() } else { 0 };
        Self {
            size,
            colour: Arc::new(vec![[0.0; 4]; pixels]),
            depth: exr.then(|| Arc::new(vec![f32::INFINITY; pixels])),
            encoded: (!exr).then(|| vec![0; size.pixels() * encoder.pixel_bytes()]),
        }
    }

    /// The décor.
    pub fn decor(layer: &Layer, size: Size, encoder: &Encoder<'_>) -> Self {
        let colour = layer.colour.clone().unwrap_or_default();
        let exr = encoder.format == PictureFormat::Exr;
        let encoded = (!exr).then(|| encoder.encode(&colour));
        Self {
            size,
            colour: Arc::new(if exr { colour } else { Vec::new() }),
            depth: exr.then(|| Arc::new(single(layer.depth.as_deref().unwrap_or_default()))),
            encoded,
        }
    }
}

/// Depths as OpenEXR keeps them.
fn single(depth: &[f64]) -> Vec<f32> {
    depth.iter().map(|&d| d as f32).collect()
}

impl Encoder<'_> {
    /// The bytes of a frame's file: the ground with patches laid onto it, the
    /// later over the earlier.
    ///
    /// # Errors
    /// Where the format's encoder refuses.
    pub fn file(
        &self,
        ground: &Ground,
        patches: &[Patch],
        path: &Path,
    ) -> Result<Vec<u8>, WriteError> {
        if self.format == PictureFormat::Exr {
            return self.exr(ground, patches, path);
        }
        let pixel = self.pixel_bytes();
        let row = ground.size.width as usize * pixel;
        let mut bytes = ground.encoded.clone().unwrap_or_default();
        for patch in patches.iter().filter(|p| !p.window.is_empty()) {
            let encoded = self.encode(&patch.colour);
            let width = patch.window.width as usize * pixel;
            for (y, line) in (patch.window.y as usize..).zip(encoded.chunks_exact(width)) {
                let from = y * row + patch.window.x as usize * pixel;
                bytes[from..from + width].copy_from_slice(line);
            }
        }
        let png = |source| WriteError::Png {
            path: path.to_owned(),
            source,
        };
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, ground.size.width, ground.size.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(match self.format {
            PictureFormat::Png16 => png::BitDepth::Sixteen,
            _ => png::BitDepth::Eight,
        });
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header().map_err(png)?;
        writer.write_image_data(&bytes).map_err(png)?;
        writer.finish().map_err(png)?;
        Ok(file)
    }

    fn exr(&self, ground: &Ground, patches: &[Patch], path: &Path) -> Result<Vec<u8>, WriteError> {
        let mut colour = (*ground.colour).clone();
        let mut depth = ground.depth.as_ref().map(|d| (**d).clone());
        let row = ground.size.width as usize;
        for patch in patches.iter().filter(|p| !p.window.is_empty()) {
            let width = patch.window.width as usize;
            for (k, y) in (patch.window.y as usize..patch.window.bottom() as usize).enumerate() {
                let (from, into) = (k * width, y * row + patch.window.x as usize);
                colour[into..into + width].copy_from_slice(&patch.colour[from..from + width]);
                if let (Some(depth), Some(new)) = (&mut depth, &patch.depth) {
                    depth[into..into + width].copy_from_slice(&single(&new[from..from + width]));
                }
            }
        }
        let mut file = std::io::Cursor::new(Vec::new());
        write_exr(&mut file, ground.size, &colour, depth.as_deref()).map_err(|source| {
            WriteError::Exr {
                path: path.to_owned(),
                source,
            }
        })?;
        Ok(file.into_inner())
    }

    fn pixel_bytes(&self) -> usize {
        match self.format {
            PictureFormat::Png16 => 6,
            _ => 3,
        }
    }

    /// Linear pixels as the picture's bytes.
    fn encode(&self, colour: &[[f32; 4]]) -> Vec<u8> {
        let pixel = self.pixel_bytes();
        let mut bytes = vec![0; colour.len() * pixel];
        bytes
            .par_chunks_mut(pixel * 4096)
            .zip(colour.par_chunks(4096))
            .for_each(|(bytes, colour)| {
                for (bytes, colour) in bytes.chunks_exact_mut(pixel).zip(colour) {
                    if pixel == 6 {
                        for k in 0..3 {
                            let value = self.adapter.encode(colour[k], 65535) as u16;
                            bytes[2 * k..2 * k + 2].copy_from_slice(&value.to_be_bytes());
                        }
                    } else {
                        for k in 0..3 {
                            bytes[k] = self.adapter.encode(colour[k], 255) as u8;
                        }
                    }
                }
            });
        bytes
    }
}

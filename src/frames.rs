//! Finished frames: their names, their encoding, and writing them so that no
//! file is ever half there.

mod canvas;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use decor_api::{Adapter, Layer, Picture, PictureFormat, Size, Transfer, Window};

use crate::dissolve::Dissolve;
use crate::layer::{LayerFileError, write_exr};
use crate::merge::Patch;
pub use canvas::Canvas;

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

/// A picture that frames begin with: the décor, or nothing, and what it
/// dissolves into. It is encoded once; a frame encodes only what it changes.
pub struct Ground {
    size: Size,
    picture: Still,
    target: Option<Still>,
    /// How colour becomes 8 bits.
    transfer: Option<Transfer>,
    /// The last frame that was encoded: one that is the same is not encoded again.
    last: Mutex<Option<Arc<Last>>>,
    /// Memory of frames that are done, for the next ones: what many threads free
    /// in turn, each keeps for itself.
    spare: Mutex<Vec<Vec<u8>>>,
}

/// An encoded frame: its pixels, and its file.
struct Last {
    pixels: Vec<u8>,
    file: Vec<u8>,
}

/// A picture in a file's own numbers.
#[derive(Clone)]
enum Content {
    /// Bytes of pixels, row by row.
    Encoded(Vec<u8>),
    /// For OpenEXR: linear colour, and the distance along the ray.
    Linear {
        colour: Vec<[f32; 4]>,
        depth: Vec<f32>,
    },
}

/// A whole picture in the numbers of a frame's file: a décor, or what one turns
/// into. What it was encoded from is not held.
#[derive(Clone)]
pub struct Still(Arc<Content>);

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
        let picture = if encoder.has_depth() {
            Content::Linear {
                colour: vec![[0.0; 4]; size.pixels()],
                depth: vec![f32::INFINITY; size.pixels()],
            }
        } else {
            Content::Encoded(vec![0; size.pixels() * encoder.pixel_bytes()])
        };
        Self::of(Still(Arc::new(picture)), None, size, encoder)
    }

    /// A picture, and what it dissolves into.
    pub fn of(picture: Still, target: Option<Still>, size: Size, encoder: &Encoder<'_>) -> Self {
        Self {
            size,
            picture,
            target,
            transfer: encoder.transfer(),
            last: Mutex::default(),
            spare: Mutex::default(),
        }
    }

    /// Memory of a frame that is done, if there is any.
    fn spared(&self) -> Vec<u8> {
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        spare.pop().unwrap_or_default()
    }

    /// Keeps the memory of a frame that is done.
    fn spare(&self, pixels: Vec<u8>) {
        const KEPT: usize = 2;
        let mut spare = self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        if spare.len() < KEPT {
            spare.push(pixels);
        }
    }

    /// The décor, and what it dissolves into.
    pub fn decor(
        layer: &Layer,
        dissolve: Option<&Dissolve>,
        size: Size,
        encoder: &Encoder<'_>,
    ) -> Self {
        let target = dissolve.map(|dissolve| encoder.still(dissolve.target()));
        Self::of(encoder.still(layer), target, size, encoder)
    }
}

/// Depths as OpenEXR keeps them.
fn single(depth: &[f64]) -> Vec<f32> {
    depth.iter().map(|&d| d as f32).collect()
}

impl Encoder<'_> {
    /// The bytes of a frame's file: the ground, dissolved so far, with patches
    /// laid onto it, the later over the earlier.
    ///
    /// # Errors
    /// Where the format's encoder refuses.
    pub fn file(
        &self,
        ground: &Ground,
        dissolve: Option<(&Dissolve, u32)>,
        patches: &[Patch],
        path: &Path,
    ) -> Result<Vec<u8>, WriteError> {
        let mut canvas = self.canvas(ground, dissolve);
        for patch in patches {
            canvas.lay(patch);
        }
        self.finish(canvas, path)
    }

    /// The bytes of a frame's file.
    ///
    /// # Errors
    /// Where the format's encoder refuses.
    pub fn finish(&self, canvas: Canvas<'_>, path: &Path) -> Result<Vec<u8>, WriteError> {
        let ground = canvas.ground;
        match canvas.content {
            Content::Encoded(bytes) => self.png_once(ground, bytes, path),
            Content::Linear { colour, depth } => self.exr(ground.size, &colour, &depth, path),
        }
    }

    /// The file of a picture; that of the last one where it is the same picture.
    fn png_once(
        &self,
        ground: &Ground,
        pixels: Vec<u8>,
        path: &Path,
    ) -> Result<Vec<u8>, WriteError> {
        let kept = || ground.last.lock().unwrap_or_else(PoisonError::into_inner);
        let last = kept().clone();
        if let Some(last) = last.filter(|last| last.pixels == pixels) {
            ground.spare(pixels);
            return Ok(last.file.clone());
        }
        let file = self.png(ground.size, &pixels, path)?;
        let before = kept().replace(Arc::new(Last {
            pixels,
            file: file.clone(),
        }));
        if let Some(before) = before.and_then(Arc::into_inner) {
            ground.spare(before.pixels);
        }
        Ok(file)
    }

    fn png(&self, size: Size, bytes: &[u8], path: &Path) -> Result<Vec<u8>, WriteError> {
        let png = |source| WriteError::Png {
            path: path.to_owned(),
            source,
        };
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, size.width, size.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(match self.format {
            PictureFormat::Png16 => png::BitDepth::Sixteen,
            _ => png::BitDepth::Eight,
        });
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        // Measured on rendered frames of 8 bits: Paeth's filter 1.5 to 2.8 ms a
        // megapixel and the smallest files, the choice of a filter by row 2.8 to
        // 3.5 ms and 0 to 2 % less, deflate's first level 8 to 15 ms and 20 % more.
        encoder.set_deflate_compression(png::DeflateCompression::FdeflateUltraFast);
        encoder.set_filter(png::Filter::Paeth);
        let mut writer = encoder.write_header().map_err(png)?;
        writer.write_image_data(bytes).map_err(png)?;
        writer.finish().map_err(png)?;
        Ok(file)
    }

    fn exr(
        &self,
        size: Size,
        colour: &[[f32; 4]],
        depth: &[f32],
        path: &Path,
    ) -> Result<Vec<u8>, WriteError> {
        let mut file = std::io::Cursor::new(Vec::new());
        write_exr(&mut file, size, colour, Some(depth)).map_err(|source| WriteError::Exr {
            path: path.to_owned(),
            source,
        })?;
        Ok(file.into_inner())
    }

    /// A layer of the whole picture as a frame's file has it.
    pub fn still(&self, layer: &Layer) -> Still {
        let transfer = self.transfer();
        Still(Arc::new(Content::of(layer, self, transfer.as_ref())))
    }

    /// The whole picture as the renderer has encoded it for files of this format.
    pub fn still_of(&self, whole: Picture) -> Still {
        Still(Arc::new(Content::Encoded(whole.bytes)))
    }

    /// The same with windows of another picture laid onto it.
    pub fn laid(
        &self,
        picture: Still,
        size: Size,
        over: &Picture,
        windows: impl Iterator<Item = Window>,
    ) -> Still {
        let ground = Ground::of(picture, None, size, self);
        let mut canvas = self.canvas(&ground, None);
        for window in windows {
            canvas.lay_picture(over, window);
        }
        Still(Arc::new(canvas.content))
    }

    /// Does a pixel look different in two pictures of the same size?
    pub fn differs(&self, one: &Still, other: &Still, pixel: usize) -> bool {
        match (&*one.0, &*other.0) {
            (Content::Encoded(one), Content::Encoded(other)) => {
                let width = self.pixel_bytes();
                let bytes = pixel * width..(pixel + 1) * width;
                one.get(bytes.clone()) != other.get(bytes)
            }
            (Content::Linear { colour: one, .. }, Content::Linear { colour: other, .. }) => {
                one.get(pixel) != other.get(pixel)
            }
            _ => true,
        }
    }

    /// Does a file hold depths, and colours as they are?
    fn has_depth(&self) -> bool {
        self.format == PictureFormat::Exr
    }

    fn pixel_bytes(&self) -> usize {
        match self.format {
            PictureFormat::Png16 => 6,
            _ => 3,
        }
    }

    /// The table of 8-bit pictures.
    fn transfer(&self) -> Option<Transfer> {
        let encode = |linear: f32| self.adapter.encode(linear, 255);
        (self.format == PictureFormat::Png).then(|| Transfer::of(encode))
    }

    /// Linear pixels as the picture's bytes. One core does it: frames are many,
    /// and several are encoded at once.
    fn encode(&self, colour: &[[f32; 4]], transfer: Option<&Transfer>, bytes: &mut [u8]) {
        if self.format == PictureFormat::Png16 {
            for (bytes, colour) in bytes.chunks_exact_mut(6).zip(colour) {
                for (bytes, &linear) in bytes.chunks_exact_mut(2).zip(colour) {
                    let value = self.adapter.encode(linear, 65535) as u16;
                    bytes.copy_from_slice(&value.to_be_bytes());
                }
            }
        } else if let Some(transfer) = transfer {
            let renderer = |linear: f32| self.adapter.encode(linear, 255);
            for (bytes, colour) in bytes.chunks_exact_mut(3).zip(colour) {
                for (byte, &linear) in bytes.iter_mut().zip(colour) {
                    *byte = transfer.encode(linear, renderer);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 7,
        height: 5,
    };

    fn patch(red: f32) -> Patch {
        Patch {
            window: SIZE.window(),
            colour: vec![[red, 0.5, 0.1, 1.0]; SIZE.pixels()],
            depth: None,
        }
    }

    #[test]
    fn frames_of_8_bits_are_encoded_as_the_renderer_says() {
        let adapter = crate::renderers::find("reference").unwrap();
        let encoder = Encoder {
            adapter: &*adapter,
            format: PictureFormat::Png,
        };
        let linear = (0..1 << 18).map(|k: u32| f32::from_bits(k << 12 | k & 0xfff));
        let colour: Vec<[f32; 4]> = linear.map(|value| [value; 4]).collect();
        let mut bytes = vec![0; 3 * colour.len()];
        encoder.encode(&colour, encoder.transfer().as_ref(), &mut bytes);
        for (bytes, colour) in bytes.chunks_exact(3).zip(colour) {
            let want = adapter.encode(colour[0], 255) as u8;
            assert_eq!(bytes, [want; 3], "{:e}", colour[0]);
        }
    }

    #[test]
    fn the_same_picture_is_not_encoded_again_and_another_one_is() {
        let adapter = crate::renderers::find("reference").unwrap();
        for format in [PictureFormat::Png, PictureFormat::Png16] {
            let encoder = Encoder {
                adapter: &*adapter,
                format,
            };
            let ground = Ground::empty(SIZE, &encoder);
            let at = Path::new("frame.png");
            let file = |red| encoder.file(&ground, None, &[patch(red)], at).unwrap();
            let last = || ground.last.lock().unwrap().clone().unwrap();
            let (first, kept) = (file(0.2), last());
            assert_eq!(file(0.2), first);
            assert!(Arc::ptr_eq(&kept, &last()), "it was encoded twice");
            let other = file(0.9);
            assert_ne!(other, first);
            assert_eq!(file(0.2), first);
            // What is written is what was encoded.
            let mut reader = png::Decoder::new(std::io::Cursor::new(other))
                .read_info()
                .unwrap();
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            let max = if format == PictureFormat::Png {
                255
            } else {
                65535
            };
            let red = if max == 255 {
                u32::from(pixels[0])
            } else {
                u32::from(u16::from_be_bytes([pixels[0], pixels[1]]))
            };
            assert_eq!(red, adapter.encode(0.9, max));
        }
    }
}

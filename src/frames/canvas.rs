//! A frame while it is put together, in the numbers of its file: it begins as its
//! ground, what changes is laid onto it, and nothing else is held of it.

use decor_api::{Layer, Picture, Transfer, Window};

use super::{Content, Encoder, Ground, single};
use crate::dissolve::Dissolve;
use crate::merge::Patch;

/// A frame of a ground.
pub struct Canvas<'a> {
    pub(super) ground: &'a Ground,
    pub(super) content: Content,
    encoder: &'a Encoder<'a>,
}

impl Encoder<'_> {
    /// The ground of a frame, dissolved so far.
    pub fn canvas<'a>(
        &'a self,
        ground: &'a Ground,
        dissolve: Option<(&Dissolve, u32)>,
    ) -> Canvas<'a> {
        let mut content = match &*ground.picture.0 {
            Content::Encoded(bytes) => {
                let mut copy = ground.spared();
                copy.clone_from(bytes);
                Content::Encoded(copy)
            }
            linear @ Content::Linear { .. } => linear.clone(),
        };
        if let (Some(target), Some((dissolve, in_place))) = (&ground.target, dissolve) {
            let shows = |i| dissolve.shows_target(i, in_place);
            match (&mut content, &*target.0) {
                (Content::Encoded(bytes), Content::Encoded(target)) => {
                    let pixel = self.pixel_bytes();
                    let pixels = bytes.chunks_exact_mut(pixel);
                    for (i, (bytes, target)) in pixels.zip(target.chunks_exact(pixel)).enumerate() {
                        if shows(i) {
                            bytes.copy_from_slice(target);
                        }
                    }
                }
                (
                    Content::Linear { colour, depth },
                    Content::Linear {
                        colour: to_colour,
                        depth: to_depth,
                    },
                ) => {
                    for i in (0..colour.len()).filter(|&i| shows(i)) {
                        colour[i] = to_colour[i];
                        depth[i] = to_depth[i];
                    }
                }
                _ => {}
            }
        }
        Canvas {
            ground,
            content,
            encoder: self,
        }
    }

    /// A frame that the renderer has encoded; `None` where it is not the whole
    /// frame, of this format.
    pub fn canvas_of<'a>(&'a self, ground: &'a Ground, whole: Picture) -> Option<Canvas<'a>> {
        let is_whole = whole.window == ground.size.window()
            && matches!(&*ground.picture.0, Content::Encoded(bytes) if bytes.len() == whole.bytes.len());
        is_whole.then_some(Canvas {
            ground,
            content: Content::Encoded(whole.bytes),
            encoder: self,
        })
    }
}

impl Canvas<'_> {
    /// Replaces pixels from column `x` of row `y` on; their depths where they are
    /// wanted and known.
    pub fn lay_row(&mut self, x: u32, y: u32, colour: &[[f32; 4]], depth: &[f64]) {
        let width = self.ground.size.width as usize;
        let from = y as usize * width + x as usize;
        match &mut self.content {
            Content::Encoded(bytes) => {
                let pixel = self.encoder.pixel_bytes();
                let line = &mut bytes[from * pixel..(from + colour.len()) * pixel];
                let transfer = self.ground.transfer.as_ref();
                self.encoder.encode(colour, transfer, line);
            }
            Content::Linear {
                colour: colours,
                depth: depths,
            } => {
                colours[from..from + colour.len()].copy_from_slice(colour);
                for (into, depth) in depths[from..].iter_mut().zip(depth) {
                    *into = *depth as f32;
                }
            }
        }
    }

    /// Replaces a rectangle.
    pub fn lay(&mut self, patch: &Patch) {
        let width = (patch.window.width as usize).max(1);
        let rows = (patch.window.y..).zip(patch.colour.chunks_exact(width));
        for (k, (y, colour)) in rows.enumerate() {
            let depth = patch.depth.as_deref().unwrap_or_default();
            let depth = depth.get(k * width..(k + 1) * width).unwrap_or_default();
            self.lay_row(patch.window.x, y, colour, depth);
        }
    }

    /// Replaces a window by that of a layer; its depth by that of another one.
    pub fn lay_layer(&mut self, layer: &Layer, depth: Option<&Layer>, window: Window) {
        let colour = layer.colour.as_deref().unwrap_or_default();
        for y in window.y..window.bottom() {
            let part = |layer: &Layer| {
                let from = layer.index(window.x, y);
                from..from + window.width as usize
            };
            let depth = depth.and_then(|of| of.depth.as_deref()?.get(part(of)));
            let colour = &colour[part(layer)];
            self.lay_row(window.x, y, colour, depth.unwrap_or_default());
        }
    }

    /// Replaces a window by what the renderer has encoded of it.
    pub fn lay_picture(&mut self, picture: &Picture, window: Window) {
        let Content::Encoded(bytes) = &mut self.content else {
            return;
        };
        let pixel = self.encoder.pixel_bytes();
        let length = window.width as usize * pixel;
        let at = |x: u32, y: u32, of: Window| {
            ((y - of.y) as usize * of.width as usize + (x - of.x) as usize) * pixel
        };
        for y in window.y..window.bottom() {
            let from = at(window.x, y, picture.window);
            let into = at(window.x, y, self.ground.size.window());
            bytes[into..into + length].copy_from_slice(&picture.bytes[from..from + length]);
        }
    }
}

impl Content {
    /// A layer's pixels as a file has them.
    pub(super) fn of(layer: &Layer, encoder: &Encoder<'_>, transfer: Option<&Transfer>) -> Self {
        let colour = layer.colour.as_deref().unwrap_or_default();
        if encoder.has_depth() {
            return Self::Linear {
                colour: colour.to_vec(),
                depth: single(layer.depth.as_deref().unwrap_or_default()),
            };
        }
        let mut bytes = vec![0; colour.len() * encoder.pixel_bytes()];
        encoder.encode(colour, transfer, &mut bytes);
        Self::Encoded(bytes)
    }
}

//! The depth of a period's décor as the influence of what moves needs it: between the
//! pixels' centres too, and only where anything can change at all.

use std::sync::atomic::Ordering;

use decor_api::{Layer, LayerRequest, Output, Region, Scene, Size, Window};

use super::RenderError;
use super::execution::{Execution, join, only};
use super::shown::decor_objects;
use crate::influence::{Changed, Depths, Still, reach, with_ring};
use crate::plan::{BLOCK, BlockSet, FramePlan, Period};

/// Places between pixels whose depth is kept, at most: each is worth 28 bytes
/// while it is read.
const MOST_SAMPLES: f64 = (12 << 20) as f64;

/// The depth of a décor.
pub struct Surfaces {
    /// At the pixels' centres; `None`: the décor's own layer has it.
    pub centres: Option<Layer>,
    /// Between them, in a picture so many times as large.
    pub samples: Option<(Layer, u32)>,
    /// Where it is of use; `None`: everywhere.
    pub within: Option<Within>,
}

/// Where the depth of a décor is of use.
pub struct Within {
    /// Anything can change in these blocks, and in no other.
    pub reached: BlockSet,
    /// Depth is rendered in these: with those around them, where it tells what need
    /// not be drawn, by the pixels that antialiasing compares with.
    pub known: BlockSet,
}

impl Execution<'_> {
    /// Where anything can change in the frames of a period, where the décor's depth
    /// is of use for nothing but to know more exactly.
    pub fn reached(&self, period: &Period) -> Option<Within> {
        let only_shadows = period.frames.iter().all(|frame| match frame {
            FramePlan::Whole => true,
            FramePlan::Layered {
                fast, sky, shadows, ..
            } => fast.is_empty() && !sky && shadows.is_some_and(|s| s.replaces_boxes),
        });
        // In a stream nobody knows the frames that come.
        let knows_frames = !self.keep_colours;
        let can = self.stage.adapter.abilities();
        let of_use = only_shadows && period.replaces_boxes() && period.still && can.block_mask;
        if !of_use || !knows_frames || self.with_depth() {
            return None;
        }
        let first = self.stage.film.frame(period.start);
        let kept = decor_objects(period);
        let receivers: Vec<Changed> = first
            .objects
            .iter()
            .filter(|object| kept.contains(&object.id))
            .map(|object| self.stage.changed(object))
            .collect();
        let mut changed = Vec::new();
        for number in period.numbers() {
            let state = self.stage.film.frame(number);
            let moving = state.objects.iter().filter(|object| {
                !kept.contains(&object.id) && !period.resting.contains(&object.id)
            });
            changed.extend(moving.map(|object| self.stage.changed(object)));
        }
        let still = Still {
            camera: &first.camera,
            size: self.stage.size(),
            lights: first.lights,
            shadows: period.numbers().any(|n| self.stage.film.frame(n).shadows),
            antialiased: first.antialias.is_some(),
            by_blocks: None,
            depths: Depths::unknown(),
            optical: &[],
            slender: &[],
        };
        let reached = reach(&still, &changed, &receivers)?;
        let known = if self.spared(period).is_some() {
            with_neighbours(&reached, still.size)
        } else {
            reached.clone()
        };
        Some(Within { reached, known })
    }

    /// The depth of a period's décor, where the blocks of its frames depend on
    /// nothing else; only where it is of use, if that is known.
    pub fn surfaces(
        &self,
        period: &Period,
        within: Option<Within>,
    ) -> Result<Option<Surfaces>, RenderError> {
        let (samples, centres) = std::thread::scope(|scope| {
            let known = within.as_ref().map(|within| &within.known);
            let samples = scope.spawn(move || self.samples(period, known));
            let centres = known.map(|known| {
                let label = format!("decor_depth_{:04}", period.start);
                self.depth_in(period, 1, Some(known), label)
            });
            (join(samples), centres)
        });
        let (samples, centres) = (samples?, centres.transpose()?);
        let is_some = samples.is_some() || centres.is_some();
        Ok(is_some.then_some(Surfaces {
            centres,
            samples,
            within,
        }))
    }

    /// The depth at the places where antialiasing looks.
    fn samples(
        &self,
        period: &Period,
        within: Option<&BlockSet>,
    ) -> Result<Option<(Layer, u32)>, RenderError> {
        let Some(antialias) = self.stage.antialias() else {
            return Ok(None);
        };
        let size = self.stage.size();
        let per_side = antialias.depth;
        let pixels = within.map_or(size.pixels(), BlockSet::pixels) as f64;
        let samples = pixels * f64::from(per_side) * f64::from(per_side);
        let fits = |pixels: u32| pixels.checked_mul(per_side).is_some_and(|p| p <= 65_535);
        let is_small = fits(size.width) && fits(size.height) && samples <= MOST_SAMPLES;
        if !period.replaces_boxes() || !period.still || !is_small {
            return Ok(None);
        }
        let label = format!("samples_{:04}", period.start);
        let layer = self.depth_in(period, per_side, within, label)?;
        Ok(Some((layer, per_side)))
    }

    /// The depth of a period's décor in a picture so many times as large, whole or
    /// in some blocks of the frame's.
    fn depth_in(
        &self,
        period: &Period,
        times: u32,
        within: Option<&BlockSet>,
        label: String,
    ) -> Result<Layer, RenderError> {
        let size = self.stage.size();
        let large = Size {
            width: size.width * times,
            height: size.height * times,
        };
        let (region, pixels) = match within {
            None => (Region::Window(large.window()), large.pixels()),
            Some(within) if within.is_empty() => return Ok(nowhere()),
            Some(within) => {
                let mut blocks = BlockSet::none(large, BLOCK);
                blocks.insert_all(within.runs().map(|w| Window {
                    x: w.x * times,
                    y: w.y * times,
                    width: w.width * times,
                    height: w.height * times,
                }));
                (Region::Blocks(blocks.wanted()), blocks.pixels())
            }
        };
        let state = self.stage.film.frame(period.start);
        let kept = decor_objects(period);
        let scene: Scene = self.stage.scene(&state, |object| kept.contains(&object.id));
        let scene = std::sync::Arc::new(scene);
        let request = LayerRequest {
            size: large,
            antialias: None,
            ..self.request_of(period.start, &scene, &region, Output::Depth, label)
        };
        self.traced
            .depth
            .fetch_add(pixels as u64, Ordering::Relaxed);
        Ok(only(self.call(&request, None)?)?)
    }
}

/// Blocks, and those that touch them.
fn with_neighbours(blocks: &BlockSet, size: Size) -> BlockSet {
    let mut wider = BlockSet::none(size, BLOCK);
    wider.insert_all(blocks.runs().map(|run| with_ring(run, size)));
    wider
}

/// No depth is known, and none is asked for.
fn nowhere() -> Layer {
    Layer {
        window: Window::EMPTY,
        colour: None,
        depth: Some(Vec::new()),
        depth_quantum: (0.0, 0.0),
    }
}

//! What the frames of a period begin with, and how a frame is put together.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, OnceLock};

use decor_api::{Layer, Window};

use super::RenderError;
use super::chunk::{Layers, Pass};
use super::execution::Execution;
use super::influenced::{Blocks, Samples};
use super::joint::Joint;
use crate::dissolve::{Backdrop, Dissolve};
use crate::frames::{Ground, WriteError, name, write_safely};
use crate::merge::{Patch, merge};
use crate::plan::{BlockSet, Period};

/// What the frames of a period begin with.
pub struct PeriodGround {
    /// The frame that the décor shows.
    start: u32,
    /// `None` without a décor.
    decor: Option<Arc<Layer>>,
    /// The décor's depth between the pixels' centres, where that is asked for.
    samples: Option<Arc<Samples>>,
    dissolve: Option<Dissolve>,
    ground: Ground,
    /// The file of a frame that is the décor, and nothing else.
    unchanged: OnceLock<Vec<u8>>,
}

impl PeriodGround {
    /// The décor as frame `number` shows it, and nothing before it.
    fn backdrop<'a>(&'a self, number: u32, sky: Option<&'a Layer>) -> Option<Backdrop<'a>> {
        Some(Backdrop {
            decor: self.decor.as_deref()?,
            dissolve: self.dissolve_at(number),
            sky,
        })
    }

    /// The décor's depth, where it has one.
    pub fn depths(&self) -> Option<(&Layer, Option<&Samples>)> {
        let decor = self.decor.as_deref().filter(|d| d.depth.is_some())?;
        Some((decor, self.samples.as_deref()))
    }

    fn dissolve_at(&self, number: u32) -> Option<(&Dissolve, u32)> {
        let dissolve = self.dissolve.as_ref()?;
        let in_place = dissolve.in_place(number - self.start);
        (in_place > 0).then_some((dissolve, in_place))
    }
}

impl Execution<'_> {
    /// What the frames of a period begin with, made of the joints at its ends.
    pub fn ground(
        &self,
        period: &Period,
        begins: Option<&Joint>,
        ends: Option<&Joint>,
    ) -> PeriodGround {
        let decor = begins.and_then(|joint| joint.decor.clone());
        let samples = begins.and_then(|joint| joint.samples.clone());
        let target = ends.and_then(|joint| joint.target.clone());
        let (size, encoder) = (self.stage.size(), self.encoder());
        let dissolve = match (&decor, target, period.dissolve_steps()) {
            (Some(decor), Some(target), Some(steps)) => {
                // Each period has an order of its own.
                let seed = self.options.seed ^ u64::from(period.start) << 32;
                Some(Dissolve::between(decor, target, steps, seed))
            }
            _ => None,
        };
        let ground = match &decor {
            None => Ground::empty(size, &encoder),
            Some(decor) => Ground::decor(decor, dissolve.as_ref(), size, &encoder),
        };
        PeriodGround {
            start: period.start,
            decor,
            samples,
            dissolve,
            ground,
            unchanged: OnceLock::new(),
        }
    }

    /// What a frame changes of its ground, in the order in which it is laid.
    pub fn patches(&self, ground: &PeriodGround, number: u32, layers: &mut Layers, blocks: &Blocks) -> Vec<Patch> {
        let mut patches = Vec::new();
        let mut take = |pass| {
            layers
                .remove(&(pass, number))
                .unwrap_or_default()
                .into_iter()
        };
        if let Some(layer) = take(Pass::Whole).next() {
            let depth = take(Pass::WholeDepth).next().and_then(|l| l.depth);
            patches.push(Patch {
                window: layer.window,
                colour: layer.colour.unwrap_or_default(),
                depth,
            });
        }
        let sky = take(Pass::Sky).next();
        if let Some(backdrop) = ground.backdrop(number, sky.as_ref()) {
            if sky.is_some() {
                patches.push(all_of(backdrop));
            }
            let antialiased = self.stage.antialias().is_some() && self.has_coverage(number);
            let depths: HashMap<Window, Layer> = take(Pass::FastDepth)
                .map(|layer| (layer.window, layer))
                .collect();
            for fast in take(Pass::Fast) {
                if let Some(depth) = depths.get(&fast.window) {
                    patches.push(merge(backdrop, &fast, depth, antialiased));
                }
            }
        }
        if let Some(layer) = take(Pass::Blocks).next() {
            let colour = layer.colour.as_deref().unwrap_or_default();
            for window in blocks.get(&number).into_iter().flat_map(BlockSet::windows) {
                let rows = window.y..window.bottom();
                let part = rows.flat_map(|y| {
                    let from = layer.index(window.x, y);
                    colour[from..from + window.width as usize].iter().copied()
                });
                patches.push(Patch {
                    window,
                    colour: part.collect(),
                    depth: None,
                });
            }
        }
        patches
    }

    fn has_coverage(&self, number: u32) -> bool {
        let state = self.stage.film.frame(number);
        self.stage.adapter.abilities().coverage && !self.stage.surroundings(&state).sky_on_objects
    }

    /// Writes a frame.
    pub fn write(
        &self,
        ground: &PeriodGround,
        number: u32,
        patches: &[Patch],
    ) -> Result<(), RenderError> {
        let path = self.options.out.join(name(number, self.options.format));
        let encoder = self.encoder();
        let dissolve = ground.dissolve_at(number);
        let file = || encoder.file(&ground.ground, dissolve, patches, &path);
        if patches.is_empty() && dissolve.is_none() {
            write_safely(&path, unchanged(ground, file)?)?;
        } else {
            write_safely(&path, &file()?)?;
        }
        self.written.fetch_add(1, Ordering::Relaxed);
        (self.watch)(number, &path);
        Ok(())
    }
}

/// The file of a frame that is the décor, made once.
fn unchanged(
    ground: &PeriodGround,
    file: impl FnOnce() -> Result<Vec<u8>, WriteError>,
) -> Result<&[u8], WriteError> {
    if let Some(file) = ground.unchanged.get() {
        return Ok(file);
    }
    let file = file()?;
    Ok(ground.unchanged.get_or_init(|| file))
}

/// The whole backdrop as a patch.
fn all_of(backdrop: Backdrop<'_>) -> Patch {
    let window: Window = backdrop.decor.window;
    let mut colour = vec![[0.0; 4]; window.pixels()];
    let mut depth = vec![f64::INFINITY; window.pixels()];
    let width = window.width.max(1) as usize;
    let rows = colour.chunks_mut(width).zip(depth.chunks_mut(width));
    for (y, (colour, depth)) in (0..).zip(rows) {
        backdrop.row(0, y, colour, depth);
    }
    Patch {
        window,
        colour,
        depth: Some(depth),
    }
}

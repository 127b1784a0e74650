//! What the frames of a period begin with, and how a frame is put together.

use std::collections::HashMap;
use std::sync::atomic::Ordering;
use std::sync::{Arc, OnceLock};

use decor_api::{Camera, Instance, Layer, Window};

use super::RenderError;
use super::chunk::{Layers, Pass};
use super::execution::Execution;
use super::influenced::{Blocks, Samples};
use super::joint::{Joint, decor_objects};
use super::shading::Lighting;
use crate::dissolve::{Backdrop, Dissolve};
use crate::frames::{Ground, WriteError, name, write_safely};
use crate::merge::{Patch, merge, merge_colour};
use crate::plan::{BlockSet, Period};
use crate::shadow::Shade;

/// One pixel of a décor.
pub struct DecorPixel<'a> {
    /// Its colour.
    pub colour: [f32; 4],
    /// The distance of its surface.
    pub depth: f64,
    /// Is it the dissolve's target's?
    pub is_target: bool,
    /// The picture that it is of, light by light.
    pub lighting: &'a Lighting,
}

/// From where a décor is seen, and what it shows.
pub struct DecorView {
    /// The observer of the décor.
    pub camera: Camera,
    /// The observer of what it dissolves into.
    pub target_camera: Option<Camera>,
    /// Its objects.
    pub instances: Vec<Instance>,
}

/// What the frames of a period begin with.
pub struct PeriodGround {
    /// The frame that the décor shows.
    start: u32,
    /// How it is seen.
    pub view: DecorView,
    /// `None` without a décor.
    decor: Option<Arc<Layer>>,
    /// The décor's depth between the pixels' centres, where that is asked for.
    samples: Option<Arc<Samples>>,
    dissolve: Option<Dissolve>,
    /// The décor light by light, where a shadow map is made; and its target.
    lighting: Option<Arc<Lighting>>,
    target_lighting: Option<Arc<Lighting>>,
    ground: Ground,
    /// The file of a frame that is the décor, and nothing else.
    unchanged: OnceLock<Vec<u8>>,
}

impl PeriodGround {
    /// The décor as frame `number` shows it, and nothing before it.
    fn backdrop<'a>(
        &'a self,
        number: u32,
        sky: Option<&'a Layer>,
        shade: Option<&'a Shade>,
    ) -> Option<Backdrop<'a>> {
        Some(Backdrop {
            decor: self.decor.as_deref()?,
            dissolve: self.dissolve_at(number),
            sky,
            shade,
        })
    }

    /// What frame `number` shows of the décor in a pixel, where a shadow map is
    /// made.
    pub fn pixel(&self, number: u32, x: u32, y: u32) -> Option<DecorPixel<'_>> {
        let decor = self.decor.as_deref()?;
        let index = decor.index(x, y);
        let target = self.dissolve_at(number).and_then(|(dissolve, in_place)| {
            let shown = dissolve.shows_target(index, in_place);
            shown.then(|| dissolve.target())
        });
        let layer = target.unwrap_or(decor);
        Some(DecorPixel {
            colour: *layer.colour.as_ref()?.get(index)?,
            depth: *layer.depth.as_ref()?.get(index)?,
            is_target: target.is_some(),
            lighting: if target.is_some() {
                self.target_lighting.as_deref()?
            } else {
                self.lighting.as_deref()?
            },
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
        let state = self.stage.film.frame(period.start);
        let kept = decor_objects(period);
        let shown = self.stage.scene(&state, |object| kept.contains(&object.id));
        let until = period.dissolve_until;
        let view = DecorView {
            camera: state.camera,
            target_camera: until.map(|until| self.stage.film.frame(until).camera),
            instances: shown.instances,
        };
        PeriodGround {
            start: period.start,
            view,
            decor,
            samples,
            dissolve,
            lighting: begins.and_then(|joint| joint.lighting.clone()),
            target_lighting: ends.and_then(|joint| joint.target_lighting.clone()),
            ground,
            unchanged: OnceLock::new(),
        }
    }

    /// What a frame changes of its ground, in the order in which it is laid.
    pub fn patches(
        &self,
        ground: &PeriodGround,
        number: u32,
        layers: &mut Layers,
        blocks: &Blocks,
        shade: Option<&Shade>,
    ) -> Vec<Patch> {
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
        if let Some(backdrop) = ground.backdrop(number, sky.as_ref(), shade) {
            if sky.is_some() {
                patches.push(part_of(backdrop, backdrop.decor.window));
            } else if let Some(shade) = shade {
                patches.extend(shaded_rows(shade, backdrop));
            }
            let antialiased = self.stage.antialias().is_some() && self.has_coverage(number);
            let depths: HashMap<Window, Layer> = take(Pass::FastDepth)
                .map(|layer| (layer.window, layer))
                .collect();
            for fast in take(Pass::Fast) {
                if let Some(depth) = depths.get(&fast.window) {
                    let merge = if self.with_depth() {
                        merge
                    } else {
                        merge_colour
                    };
                    patches.push(merge(backdrop, &fast, depth, antialiased));
                }
            }
        }
        let layers: Vec<Layer> = take(Pass::Blocks).collect();
        for window in blocks.get(&number).into_iter().flat_map(BlockSet::windows) {
            let holds = |layer: &&Layer| layer.window.intersection(window) == window;
            if let Some(layer) = layers.iter().find(holds) {
                patches.push(block_of(layer, window));
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

/// A window of a layer as a patch.
pub fn block_of(layer: &Layer, window: Window) -> Patch {
    let colour = layer.colour.as_deref().unwrap_or_default();
    let rows = window.y..window.bottom();
    let part = rows.flat_map(|y| {
        let from = layer.index(window.x, y);
        colour[from..from + window.width as usize].iter().copied()
    });
    Patch {
        window,
        colour: part.collect(),
        depth: None,
    }
}

/// A window of the backdrop as a patch.
fn part_of(backdrop: Backdrop<'_>, window: Window) -> Patch {
    let mut colour = vec![[0.0; 4]; window.pixels()];
    let mut depth = vec![f64::INFINITY; window.pixels()];
    let width = window.width.max(1) as usize;
    let rows = colour.chunks_mut(width).zip(depth.chunks_mut(width));
    for (y, (colour, depth)) in (window.y..).zip(rows) {
        backdrop.row(window.x, y, colour, depth);
    }
    Patch {
        window,
        colour,
        depth: Some(depth),
    }
}

/// The backdrop where it is shaded: in each row from the first such pixel to the
/// last.
fn shaded_rows(shade: &Shade, backdrop: Backdrop<'_>) -> Vec<Patch> {
    let width = backdrop.decor.window.width;
    let mut spans: Vec<(u32, u32, u32)> = Vec::new();
    for (index, _) in shade.pixels() {
        let (x, y) = (index % width, index / width);
        match spans.last_mut() {
            Some((row, _, last)) if *row == y => *last = x,
            _ => spans.push((y, x, x)),
        }
    }
    let patch = |(y, first, last): (u32, u32, u32)| {
        let window = Window {
            x: first,
            y,
            width: last - first + 1,
            height: 1,
        };
        part_of(backdrop, window)
    };
    spans.into_iter().map(patch).collect()
}

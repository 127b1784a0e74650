//! What the frames of a period begin with, and how a frame is put together.

use std::sync::atomic::Ordering;
use std::sync::{Arc, OnceLock};

use decor_api::{AdapterError, Camera, Instance, Layer, Size, Window};

use super::RenderError;
use super::called::{Calls, Drawn};
use super::chunk::Pass;
use super::execution::Execution;
use super::influenced::Blocks;
use super::joint::Joint;
use super::shading::Lighting;
use super::shown::decor_objects;
use super::spared::Spared;
use super::surfaces::Surfaces;
use crate::dissolve::{Backdrop, Dissolve};
use crate::frames::{Canvas, Encoder, Ground, Still, WriteError, name, write_safely};
use crate::influence::{Depths, Ranges};
use crate::merge::{Patch, Run, lay_over, merge_onto};
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
    /// The décor's depth, where its own layer does not have all of it.
    surfaces: Option<Arc<Surfaces>>,
    /// The ranges of these depths, once they are asked for.
    ranges: OnceLock<Ranges>,
    /// What need not be drawn in every block.
    pub spared: Option<Spared>,
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

    /// Is what frame `number` shows of the décor nearer than `distance` in all of a
    /// window, by more than depths are certain? Not where it is unknown.
    pub fn is_nearer(&self, number: u32, window: Window, distance: f64) -> bool {
        let Some(backdrop) = self.backdrop(number, None, None) else {
            return false;
        };
        let window = window.intersection(backdrop.decor.window);
        let (near, far) = backdrop.depth_quantum();
        // The depths of two layers are compared.
        let is_nearer = |depth: &f64| depth + 2.0 * (near + far * distance) < distance;
        let mut space = vec![f64::INFINITY; window.width as usize];
        (window.y..window.bottom()).all(|y| {
            let depths = backdrop.depths_of(window.x, y, &mut space);
            depths.iter().all(is_nearer)
        })
    }

    /// The décor's depth, where it has one.
    pub fn depths(&self, size: Size, antialiased: bool) -> Option<Depths<'_>> {
        let surfaces = self.surfaces.as_deref();
        let centres = match surfaces.and_then(|s| s.centres.as_ref()) {
            Some(centres) => centres,
            None => self.decor.as_deref().filter(|d| d.depth.is_some())?,
        };
        let samples = surfaces.and_then(|s| s.samples.as_ref());
        let mut depths = match samples.filter(|_| antialiased) {
            Some((samples, per_side)) => Depths::with_samples(centres, samples, *per_side),
            None => Depths::at_centres(centres),
        };
        if let Some(within) = surfaces.and_then(|s| s.within.as_ref()) {
            depths = depths.within(&within.reached, &within.known);
        }
        let found = || Ranges::of(&depths, size, antialiased);
        Some(depths.with_ranges(self.ranges.get_or_init(found)))
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
        let surfaces = begins.and_then(|joint| joint.surfaces.clone());
        let target = ends.and_then(|joint| joint.target.clone());
        let (size, encoder) = (self.stage.size(), self.encoder());
        let picture = |known: Option<&Still>, layer: &Layer| {
            let known = known.cloned();
            known.unwrap_or_else(|| encoder.still(layer))
        };
        let (mut dissolve, mut target_picture) = (None, None);
        let decor_picture = decor.as_ref().map(|decor| {
            let known = begins.and_then(|joint| joint.decor_picture.as_ref());
            picture(known, decor)
        });
        if let (Some(decor), Some(shown), Some(target), Some(steps)) =
            (&decor, &decor_picture, target, period.dissolve_steps())
        {
            // Each period has an order of its own.
            let seed = self.options.seed ^ u64::from(period.start) << 32;
            let known = ends.and_then(|joint| joint.target_picture.as_ref());
            let becomes = picture(known, &target);
            let differs = |i: usize| encoder.differs(shown, &becomes, i);
            dissolve = Some(Dissolve::between(decor, target, differs, steps, seed));
            target_picture = Some(becomes);
        }
        let ground = match decor_picture {
            None => Ground::empty(size, &encoder),
            Some(picture) => Ground::of(picture, target_picture, size, &encoder),
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
            surfaces,
            ranges: OnceLock::new(),
            spared: self.spared(period),
            dissolve,
            lighting: begins.and_then(|joint| joint.lighting.clone()),
            target_lighting: ends.and_then(|joint| joint.target_lighting.clone()),
            ground,
            unchanged: OnceLock::new(),
        }
    }

    /// Puts a frame together, and writes it.
    pub fn frame(
        &self,
        ground: &PeriodGround,
        number: u32,
        calls: &mut Calls<'_>,
        blocks: &Blocks,
        shade: Option<&Shade>,
    ) -> Result<(), RenderError> {
        let path = self.options.out.join(name(number, self.options.format));
        let encoder = self.encoder();
        let shaded = shade.is_some_and(|shade| !shade.pixels().is_empty());
        if calls.has(number) || shaded || ground.dissolve_at(number).is_some() {
            let mut canvas = self.begun(&encoder, ground, number, calls)?;
            self.draw(&mut canvas, ground, number, calls, blocks, shade)?;
            write_safely(&path, &encoder.finish(canvas, &path)?)?;
        } else {
            let file = || encoder.file(&ground.ground, None, &[], &path);
            write_safely(&path, unchanged(ground, file)?)?;
        }
        self.written.fetch_add(1, Ordering::Relaxed);
        (self.watch)(number, &path);
        Ok(())
    }

    /// What a frame begins with: itself where it was rendered whole, else its
    /// ground.
    fn begun<'a>(
        &self,
        encoder: &'a Encoder<'a>,
        ground: &'a PeriodGround,
        number: u32,
        calls: &mut Calls<'_>,
    ) -> Result<Canvas<'a>, RenderError> {
        let canvas = || encoder.canvas(&ground.ground, ground.dissolve_at(number));
        Ok(match calls.read(Pass::Whole, number)? {
            None => canvas(),
            Some(Drawn::Layer(layer)) => {
                let depth = calls.layer(Pass::WholeDepth, number)?;
                let mut canvas = canvas();
                canvas.lay_layer(&layer, depth.as_ref(), layer.window);
                canvas
            }
            Some(Drawn::Picture(picture)) => encoder
                .canvas_of(&ground.ground, picture)
                .ok_or_else(|| AdapterError::BadOutput {
                    program: self.stage.adapter.name().into(),
                    file: format!("frame {number}").into(),
                    reason: "it has another size".into(),
                })?,
        })
    }

    /// What a frame changes of its ground, in the passes' order. A layer is read,
    /// laid and forgotten.
    fn draw(
        &self,
        canvas: &mut Canvas<'_>,
        ground: &PeriodGround,
        number: u32,
        calls: &mut Calls<'_>,
        blocks: &Blocks,
        shade: Option<&Shade>,
    ) -> Result<(), RenderError> {
        let sky = calls.layer(Pass::Sky, number)?;
        if let Some(backdrop) = ground.backdrop(number, sky.as_ref(), shade) {
            if sky.is_some() {
                lay_part(canvas, backdrop, backdrop.decor.window);
            } else if let Some(shade) = shade {
                for window in shaded_rows(shade, backdrop.decor.window.width) {
                    lay_part(canvas, backdrop, window);
                }
            }
            let antialiased = self.stage.antialias().is_some() && self.has_coverage(number);
            for region in calls.regions(Pass::Fast, number) {
                let colour = calls.layer_in(Pass::Fast, number, &region)?;
                let depth = calls.layer_in(Pass::FastDepth, number, &region)?;
                let mut lay = |run: Run<'_>| canvas.lay_row(run.x, run.y, run.colour, run.depth);
                match (colour, depth) {
                    (Some(colour), Some(depth)) => {
                        let with_depth = self.with_depth();
                        merge_onto(backdrop, &colour, &depth, antialiased, with_depth, lay);
                    }
                    // It is before all of the décor.
                    (Some(colour), None) => lay_over(backdrop, &colour, antialiased, &mut lay),
                    _ => {}
                }
            }
        }
        for region in calls.regions(Pass::Blocks, number) {
            let Some(drawn) = calls.read_in(Pass::Blocks, number, &region)? else {
                continue;
            };
            let windows = blocks.get(&number).into_iter().flat_map(BlockSet::runs);
            for window in windows.filter(|w| drawn.window().intersection(*w) == *w) {
                match &drawn {
                    Drawn::Layer(layer) => canvas.lay_layer(layer, None, window),
                    Drawn::Picture(picture) => canvas.lay_picture(picture, window),
                }
            }
        }
        Ok(())
    }

    fn has_coverage(&self, number: u32) -> bool {
        let state = self.stage.film.frame(number);
        self.stage.adapter.abilities().coverage && !self.stage.surroundings(&state).sky_on_objects
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

/// Lays a window of the backdrop onto a frame.
fn lay_part(canvas: &mut Canvas<'_>, backdrop: Backdrop<'_>, window: Window) {
    let width = window.width as usize;
    let mut colour = vec![[0.0; 4]; width];
    let mut depth = vec![f64::INFINITY; width];
    for y in window.y..window.bottom() {
        backdrop.row(window.x, y, &mut colour, &mut depth);
        canvas.lay_row(window.x, y, &colour, &depth);
    }
}

/// Where the backdrop is shaded: in each row from the first such pixel to the
/// last.
fn shaded_rows(shade: &Shade, width: u32) -> impl Iterator<Item = Window> {
    let mut spans: Vec<(u32, u32, u32)> = Vec::new();
    for (index, _) in shade.pixels() {
        let (x, y) = (index % width, index / width);
        match spans.last_mut() {
            Some((row, _, last)) if *row == y => *last = x,
            _ => spans.push((y, x, x)),
        }
    }
    spans.into_iter().map(|(y, first, last)| Window {
        x: first,
        y,
        width: last - first + 1,
        height: 1,
    })
}

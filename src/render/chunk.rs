//! The calls behind a period: its décor, and its frames a chunk at a time.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};

use decor_api::{
    AdapterError, Antialias, Layer, LayerRequest, LayerShot, Optics, Output, PictureFormat, Region,
    RunContext, Window,
};

use super::slots::Slots;
use super::{Options, RenderError, Traced, Watch};
use crate::film::{ObjectId, ObjectState};
use crate::frames::{Encoder, Ground, name, write_safely};
use crate::merge::{Patch, merge};
use crate::motion::screen_box;
use crate::plan::{FramePlan, Mode, Period, Plan};
use crate::stage::Stage;

/// Pixels of layers that one chunk holds at once, at most.
const CHUNK_PIXELS: usize = 12 << 20;

/// Frames in one call, at most: an error should not cost an hour.
const CHUNK_FRAMES: usize = 50;

/// Everything that the calls need.
pub struct Execution<'a> {
    pub stage: &'a Stage,
    pub plan: &'a Plan,
    pub options: &'a Options,
    pub run: RunContext,
    pub slots: Slots,
    pub traced: Traced,
    pub watch: Watch<'a>,
    pub written: AtomicU64,
    pub jobs: usize,
}

/// What the frames of a period begin with.
pub struct PeriodGround {
    /// Colour, and depth where a merge needs it; `None` without a décor.
    decor: Option<Layer>,
    ground: Ground,
    /// The file of a frame that is the décor, and nothing else.
    unchanged: OnceLock<Vec<u8>>,
}

/// Layers by pass and frame; a frame may have several windows of a pass.
type Layers = HashMap<(Pass, u32), Vec<Layer>>;

/// Passes of a chunk, in the order in which their patches are laid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Pass {
    Whole,
    WholeDepth,
    Fast,
    FastDepth,
    Blocks,
}

impl Execution<'_> {
    fn period(&self, index: usize) -> &Period {
        &self.plan.periods[index]
    }

    fn encoder(&self) -> Encoder<'_> {
        Encoder {
            adapter: &*self.stage.adapter,
            format: self.options.format,
        }
    }

    fn with_depth(&self) -> bool {
        self.options.format == PictureFormat::Exr
    }

    /// Makes other calls stop: the run has failed.
    pub fn give_up(&self) {
        self.run.cancel.store(true, Ordering::Relaxed);
    }

    /// The chunks of a period: few enough frames that all jobs have one, and
    /// that their layers fit into memory.
    pub fn chunks(&self, index: usize) -> Vec<Range<u32>> {
        let period = self.period(index);
        let left: Vec<u32> = period
            .numbers()
            .filter(|n| !self.options.skip.contains(n))
            .collect();
        let heaviest = period
            .frames
            .iter()
            .map(|f| self.held_pixels(f))
            .max()
            .unwrap_or(1)
            .max(1);
        let longest = (CHUNK_PIXELS / heaviest).clamp(1, CHUNK_FRAMES);
        let length = left.len().div_ceil(self.jobs).clamp(1, longest);
        let mut chunks: Vec<Range<u32>> = Vec::new();
        for number in left {
            match chunks.last_mut() {
                Some(chunk) if chunk.end == number && chunk.len() < length => chunk.end += 1,
                _ => chunks.push(number..number + 1),
            }
        }
        chunks
    }

    fn held_pixels(&self, frame: &FramePlan) -> usize {
        match frame {
            FramePlan::Whole => self.stage.size().pixels(),
            FramePlan::Layered { fast, blocks } => {
                let around = blocks.windows().fold(Window::EMPTY, Window::union);
                2 * fast.iter().map(|window| window.pixels()).sum::<usize>() + around.pixels()
            }
        }
    }

    /// Renders what the frames of a period begin with.
    pub fn ground(&self, index: usize) -> Result<PeriodGround, RenderError> {
        let period = self.period(index);
        let size = self.stage.size();
        let fast = fast_objects(period);
        let layered = period.frames.iter().any(|f| *f != FramePlan::Whole);
        if !period.has_decor() || !layered {
            return Ok(PeriodGround {
                decor: None,
                ground: Ground::empty(size, &self.encoder()),
                unchanged: OnceLock::new(),
            });
        }
        let state = self.stage.film.frame(period.start);
        let scene = Arc::new(
            self.stage
                .scene(&state, |object| !fast.contains(&object.id)),
        );
        let call = |output: Output, label: &str| {
            let request = LayerRequest {
                prototypes: &self.stage.library.table,
                size,
                output,
                antialias: self.stage.antialias(),
                shots: vec![LayerShot {
                    frame: period.start,
                    scene: Arc::clone(&scene),
                    region: Region::Window(size.window()),
                }],
                film: None,
                label: format!("{label}_{:04}", period.start),
            };
            self.call(&request, None)
        };
        let needs_depth = period.merges() || self.with_depth();
        let (colour, depth) = std::thread::scope(|scope| {
            let depth = needs_depth.then(|| scope.spawn(|| call(Output::Depth, "decor_depth")));
            let colour = call(Output::ColourOverBackground, "decor");
            (colour, depth.map(join))
        });
        let pixels = size.pixels() as u64;
        self.traced.decor.fetch_add(pixels, Ordering::Relaxed);
        let mut decor = only(colour?)?;
        if let Some(depth) = depth {
            self.traced.depth.fetch_add(pixels, Ordering::Relaxed);
            let depth = only(depth?)?;
            decor.depth = depth.depth;
            decor.depth_quantum = depth.depth_quantum;
        }
        let ground = Ground::decor(&decor, size, &self.encoder());
        Ok(PeriodGround {
            decor: Some(decor),
            ground,
            unchanged: OnceLock::new(),
        })
    }

    /// Renders, merges and writes some frames of a period. `ground` waits for its
    /// décor: it is called when the frames' own layers are there. Where the
    /// décor failed, nothing is written; that error is told elsewhere.
    pub fn chunk<'g>(
        &self,
        period: usize,
        frames: Range<u32>,
        ground: impl FnOnce() -> Option<&'g PeriodGround>,
    ) -> Result<(), RenderError> {
        if self.run.is_cancelled() {
            return Err(AdapterError::Cancelled.into());
        }
        let shots = self.shots(period, frames.clone());
        let mut layers = self.layers(shots, frames.start)?;
        let Some(ground) = ground() else {
            return Ok(());
        };
        for number in frames {
            let patches = self.patches(ground, number, &mut layers);
            self.write(ground, number, &patches)?;
        }
        Ok(())
    }

    /// What the renderer is to draw, by pass.
    fn shots(&self, period: usize, frames: Range<u32>) -> BTreeMap<Pass, Vec<LayerShot>> {
        let period = self.period(period);
        let fast_objects = fast_objects(period);
        let mut shots: BTreeMap<Pass, Vec<LayerShot>> = BTreeMap::new();
        for number in frames {
            let state = self.stage.film.frame(number);
            let mut add = |pass: Pass, scene: &Arc<decor_api::Scene>, region: Region| {
                let shot = LayerShot {
                    frame: number,
                    scene: Arc::clone(scene),
                    region,
                };
                shots.entry(pass).or_default().push(shot);
            };
            match &period.frames[(number - period.start) as usize] {
                FramePlan::Whole => {
                    let scene = Arc::new(self.stage.scene(&state, |_| true));
                    let all = Region::Window(self.stage.size().window());
                    add(Pass::Whole, &scene, all.clone());
                    if self.with_depth() {
                        add(Pass::WholeDepth, &scene, all);
                    }
                }
                FramePlan::Layered { fast, blocks } => {
                    if !fast.is_empty() {
                        let scene = Arc::new(self.stage.scene(&state, |object| {
                            fast_objects.contains(&object.id)
                                && self.belongs_to_layer(object, &state)
                        }));
                        for window in fast {
                            add(Pass::Fast, &scene, Region::Window(*window));
                            add(Pass::FastDepth, &scene, Region::Window(*window));
                        }
                    }
                    if !blocks.is_empty() {
                        let scene = Arc::new(self.stage.scene(&state, |_| true));
                        add(Pass::Blocks, &scene, Region::Blocks(blocks.numbers()));
                    }
                }
            }
        }
        shots
    }

    /// Is a fast object drawn in the fast layer? Not where it is out of view
    /// and casts nothing, nor where its blocks are drawn from the full scene.
    fn belongs_to_layer(
        &self,
        object: &ObjectState<'_>,
        state: &crate::film::FrameState<'_>,
    ) -> bool {
        let prototype = self.stage.prototype(object);
        let drawn_in_blocks = prototype.optics != Optics::Opaque
            && self.stage.adapter.abilities().optics
            && self.plan.wishes.mode != Mode::Preview
            && !self.with_depth();
        if drawn_in_blocks {
            return false;
        }
        let bounds = prototype.bounds.posed(&object.pose);
        let window = screen_box(&bounds, &state.camera, self.stage.size()).window();
        state.shadows || !window.is_empty()
    }

    /// All layers of a chunk, by pass and frame. The calls run side by side.
    fn layers(
        &self,
        shots: BTreeMap<Pass, Vec<LayerShot>>,
        first: u32,
    ) -> Result<Layers, RenderError> {
        let mut calls: Vec<(Pass, LayerRequest<'_>)> = Vec::new();
        for (pass, shots) in shots {
            for (group, shots) in grouped(shots).into_iter().enumerate() {
                calls.push((pass, self.request(pass, shots, first, group)));
            }
        }
        let results: Vec<_> = std::thread::scope(|scope| {
            let running: Vec<_> = calls
                .iter()
                .map(|(pass, request)| (*pass, scope.spawn(|| self.call(request, Some(1)))))
                .collect();
            running
                .into_iter()
                .map(|(pass, handle)| (pass, join(handle)))
                .collect()
        });
        let mut layers = Layers::new();
        for ((pass, result), (_, request)) in results.into_iter().zip(&calls) {
            for (layer, shot) in result?.into_iter().zip(&request.shots) {
                let counter = match pass {
                    Pass::Whole => &self.traced.whole,
                    Pass::Fast => &self.traced.fast,
                    Pass::Blocks => &self.traced.blocks,
                    Pass::WholeDepth | Pass::FastDepth => &self.traced.depth,
                };
                let pixels = match &shot.region {
                    Region::Window(window) => window.pixels() as u64,
                    Region::Blocks(_) => self.blocks_of(shot.frame).pixels() as u64,
                };
                counter.fetch_add(pixels, Ordering::Relaxed);
                layers.entry((pass, shot.frame)).or_default().push(layer);
            }
        }
        Ok(layers)
    }

    fn request(
        &self,
        pass: Pass,
        shots: Vec<LayerShot>,
        first: u32,
        group: usize,
    ) -> LayerRequest<'_> {
        let frame = shots.first().map_or(first, |shot| shot.frame);
        let sky = self
            .stage
            .surroundings(&self.stage.film.frame(frame))
            .sky_on_objects;
        let (output, label) = match pass {
            Pass::Whole => (Output::ColourOverBackground, "frames"),
            Pass::WholeDepth => (Output::Depth, "frames_depth"),
            Pass::Fast => (Output::ColourAlone { with_sky: sky }, "fast"),
            Pass::FastDepth => (Output::Depth, "fast_depth"),
            Pass::Blocks => (Output::ColourOverBackground, "blocks"),
        };
        // Whole frames may go by a clock, in an object or a declaration.
        let consecutive = shots
            .windows(2)
            .all(|pair| pair[1].frame == pair[0].frame + 1);
        let film = (pass == Pass::Whole && consecutive).then(|| {
            let frames = self.stage.film.frames();
            (*frames.start(), *frames.end())
        });
        LayerRequest {
            prototypes: &self.stage.library.table,
            size: self.stage.size(),
            output,
            antialias: self.antialias(),
            shots,
            film,
            label: format!("{label}_{frame:04}_{group}"),
        }
    }

    fn antialias(&self) -> Option<Antialias> {
        self.stage.antialias()
    }

    fn blocks_of(&self, number: u32) -> crate::plan::BlockSet {
        let period = self
            .plan
            .periods
            .iter()
            .find(|p| p.numbers().contains(&number));
        match period.map(|p| &p.frames[(number - p.start) as usize]) {
            Some(FramePlan::Layered { blocks, .. }) => blocks.clone(),
            _ => crate::plan::BlockSet::none(self.stage.size()),
        }
    }

    fn call(
        &self,
        request: &LayerRequest<'_>,
        threads: Option<usize>,
    ) -> Result<Vec<Layer>, RenderError> {
        let _slot = self.slots.take();
        let run = RunContext {
            threads,
            ..self.run.clone()
        };
        Ok(self.stage.adapter.render(request, &run)?)
    }

    /// What a frame changes of its ground, in the order in which it is laid.
    fn patches(&self, ground: &PeriodGround, number: u32, layers: &mut Layers) -> Vec<Patch> {
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
        if let Some(decor) = &ground.decor {
            let antialiased = self.antialias().is_some() && self.has_coverage(number);
            let depths: HashMap<Window, Layer> = take(Pass::FastDepth)
                .map(|layer| (layer.window, layer))
                .collect();
            for fast in take(Pass::Fast) {
                if let Some(depth) = depths.get(&fast.window) {
                    patches.push(merge(decor, &fast, depth, antialiased));
                }
            }
        }
        if let Some(layer) = take(Pass::Blocks).next() {
            let colour = layer.colour.as_deref().unwrap_or_default();
            for window in self.blocks_of(number).windows() {
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

    fn write(
        &self,
        ground: &PeriodGround,
        number: u32,
        patches: &[Patch],
    ) -> Result<(), RenderError> {
        let path = self.options.out.join(name(number, self.options.format));
        let encoder = self.encoder();
        if patches.is_empty() {
            let file = match ground.unchanged.get() {
                Some(file) => file,
                None => {
                    let file = encoder.file(&ground.ground, &[], &path)?;
                    ground.unchanged.get_or_init(|| file)
                }
            };
            write_safely(&path, file)?;
        } else {
            write_safely(&path, &encoder.file(&ground.ground, patches, &path)?)?;
        }
        self.written.fetch_add(1, Ordering::Relaxed);
        (self.watch)(number, &path);
        Ok(())
    }
}

/// The objects of a period that are rendered in every frame.
fn fast_objects(period: &Period) -> HashSet<ObjectId> {
    let fast = period.objects.iter().filter(|o| !o.class.in_decor());
    fast.map(|o| o.object).collect()
}

/// Shots that one call can render well: a call has one picture size, and a
/// small window in a large picture is a waste.
fn grouped(shots: Vec<LayerShot>) -> Vec<Vec<LayerShot>> {
    let mut groups: BTreeMap<(u32, u32), Vec<LayerShot>> = BTreeMap::new();
    for shot in shots {
        let key = match &shot.region {
            Region::Window(w) => (w.width.next_power_of_two(), w.height.next_power_of_two()),
            Region::Blocks(_) => (0, 0),
        };
        groups.entry(key).or_default().push(shot);
    }
    groups.into_values().collect()
}

fn only(layers: Vec<Layer>) -> Result<Layer, AdapterError> {
    layers
        .into_iter()
        .next()
        .ok_or_else(|| AdapterError::BadOutput {
            program: "the renderer".into(),
            file: "the décor".into(),
            reason: "it is missing".into(),
        })
}

/// The result of a thread; its panic goes on in this one.
fn join<T>(handle: std::thread::ScopedJoinHandle<'_, T>) -> T {
    match handle.join() {
        Ok(value) => value,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

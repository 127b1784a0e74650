//! A joint between two periods: the décor of the one that begins, and what the
//! décor of the one that ends has turned into.
//!
//! Thesis, III-3-2-2: the objects of both décors are rendered once, and merged
//! with what is particular to each.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use decor_api::{Layer, LayerRequest, LayerShot, Optics, Output, Region, Scene, Window};

use super::RenderError;
use super::called::{Drawn, Left};
use super::execution::{Execution, join, only};
use super::ground::block_of;
use super::shading::Lighting;
use super::shown::Shown;
use super::surfaces::Surfaces;
use crate::dissolve::Backdrop;
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::frames::Still;
use crate::merge::{Patch, merge};
use crate::plan::{FramePlan, Period, gathered};
use crate::segmentation::Class;

/// Particular objects are rendered by themselves where their windows are not
/// more than this share of the picture: their depth has a price too.
const PARTICULAR_SHARE: f64 = 0.5;

/// What was rendered at a joint.
#[derive(Default)]
pub struct Joint {
    /// The décor of the period that begins.
    pub decor: Option<Arc<Layer>>,
    /// The depth of that décor, where its own layer does not have all of it.
    pub surfaces: Option<Arc<Surfaces>>,
    /// What the décor of the period that ends has turned into.
    pub target: Option<Arc<Layer>>,
    /// The décor as the frames' files have it, where its colours were let go.
    pub decor_picture: Option<Still>,
    /// The same of the target.
    pub target_picture: Option<Still>,
    /// The décor light by light, where a shadow map is made.
    pub lighting: Option<Arc<Lighting>>,
    /// The same of the target.
    pub target_lighting: Option<Arc<Lighting>>,
}

/// What a joint is to give.
#[derive(Clone, Copy, Default)]
pub struct Wanted<'p> {
    /// The period that begins, where its décor is needed.
    pub begins: Option<&'p Period>,
    /// The period that ends, where what it turns into is needed.
    pub ends: Option<&'p Period>,
}

impl Execution<'_> {
    /// Is a décor of use to the frames of this period?
    pub fn needs_decor(&self, period: &Period) -> bool {
        period.has_decor() && period.frames.iter().any(|f| *f != FramePlan::Whole)
    }

    /// Renders a joint.
    pub fn joint(&self, wanted: Wanted<'_>) -> Result<Joint, RenderError> {
        let mut periods = wanted.begins.into_iter().chain(wanted.ends);
        let colours = self.keep_colours || periods.any(|period| self.needs_colours(period));
        let mut joint = self.pictures(wanted, colours)?;
        if let Some(begins) = wanted.begins.filter(|period| period.by_map()) {
            let state = self.stage.film.frame(begins.start);
            let scene = self.decor_scene(&state, &Shown::by(begins));
            let lighting = self.lighting(begins, &scene, begins.start)?;
            joint.lighting = Some(Arc::new(lighting));
        }
        if let Some(ends) = wanted.ends.filter(|period| period.by_map())
            && let Some(until) = ends.dissolve_until
        {
            let scene = self.target_scene(ends, until);
            let lighting = self.lighting(ends, &scene, until)?;
            joint.target_lighting = Some(Arc::new(lighting));
        }
        if !colours {
            self.let_go_of_colours(&mut joint);
        }
        Ok(joint)
    }

    /// Do the frames of a period need the colours of their décor, and not only
    /// what their files show of it: to see it through the edge of something, to
    /// shade it, to put a sky behind it?
    fn needs_colours(&self, period: &Period) -> bool {
        let antialiased = self.stage.antialias().is_some();
        period.by_map()
            || period.frames.iter().any(|frame| match frame {
                FramePlan::Layered { fast, sky, .. } => *sky || antialiased && !fast.is_empty(),
                FramePlan::Whole => false,
            })
    }

    /// Encodes what frames begin with, where the renderer has not, and keeps no more
    /// than its depth: 16 bytes a pixel become 3.
    fn let_go_of_colours(&self, joint: &mut Joint) {
        let encoder = self.encoder();
        let one = matches!((&joint.decor, &joint.target), (Some(a), Some(b)) if Arc::ptr_eq(a, b));
        if one {
            joint.target = None;
        }
        let let_go = |layer: &mut Option<Arc<Layer>>, picture: &mut Option<Still>| {
            if picture.is_some() {
                return;
            }
            *picture = layer.take().map(|known| {
                let picture = encoder.still(&known);
                let mut known = Arc::unwrap_or_clone(known);
                known.colour = None;
                *layer = Some(Arc::new(known));
                picture
            });
        };
        let_go(&mut joint.decor, &mut joint.decor_picture);
        let_go(&mut joint.target, &mut joint.target_picture);
        if one {
            joint.target.clone_from(&joint.decor);
            joint.target_picture.clone_from(&joint.decor_picture);
        }
    }

    /// The pictures of a joint; with their colours, or as the files have them.
    fn pictures(&self, wanted: Wanted<'_>, colours: bool) -> Result<Joint, RenderError> {
        let until = wanted.ends.and_then(|period| period.dissolve_until);
        if let (Some(ends), Some(begins)) = (wanted.ends, wanted.begins)
            && until == Some(begins.start)
        {
            let (old, new) = (Shown::by(ends), Shown::by(begins));
            let depth = self.depth_of(ends) || self.depth_of(begins);
            let same = self.same_scene(ends, begins);
            if same && old == new {
                let scene = self.decor_scene(&self.stage.film.frame(begins.start), &new);
                let begun = self.picture(begins.start, scene, depth, colours, "decor")?;
                let layer = Arc::new(begun.layer);
                return Ok(Joint {
                    surfaces: self.surfaces(begins, None)?.map(Arc::new),
                    decor: Some(Arc::clone(&layer)),
                    decor_picture: begun.picture,
                    target: Some(layer),
                    ..Joint::default()
                });
            }
            if same {
                let state = self.stage.film.frame(begins.start);
                let blocks = self.stage.adapter.abilities().block_mask;
                let joint = if !self.is_apart(&state, &old, &new) {
                    None
                } else if depth || !blocks {
                    self.in_common(&state, &old, &new)?
                } else {
                    self.in_common_by_blocks(&state, &old, &new, colours)?
                };
                if let Some(joint) = joint {
                    return Ok(joint);
                }
            }
        }
        let reached = wanted.begins.and_then(|period| self.reached(period));
        let is_apart = reached.is_some();
        let (decor, target, surfaces) = std::thread::scope(|scope| {
            let target = wanted.ends.and_then(|period| {
                let until = period.dissolve_until?;
                Some(scope.spawn(move || {
                    let scene = self.target_scene(period, until);
                    self.picture(until, scene, self.depth_of(period), colours, "target")
                }))
            });
            let surfaces = wanted
                .begins
                .map(|period| scope.spawn(move || self.surfaces(period, reached)));
            let decor = wanted.begins.map(|period| {
                let depth = !is_apart && self.depth_of(period);
                let state = self.stage.film.frame(period.start);
                let scene = self.decor_scene(&state, &Shown::by(period));
                self.picture(period.start, scene, depth, colours, "decor")
            });
            (decor, target.map(join), surfaces.map(join))
        });
        let apart = |begun: Option<Begun>| match begun {
            Some(Begun { layer, picture }) => (Some(Arc::new(layer)), picture),
            None => (None, None),
        };
        let (decor, decor_picture) = apart(decor.transpose()?);
        let (target, target_picture) = apart(target.transpose()?);
        Ok(Joint {
            surfaces: surfaces.transpose()?.flatten().map(Arc::new),
            decor,
            target,
            decor_picture,
            target_picture,
            ..Joint::default()
        })
    }

    fn depth_of(&self, period: &Period) -> bool {
        period.needs_depth() || self.with_depth()
    }

    /// Are the still objects of the period that ends where the one that begins
    /// has them? What stands still in a period may move on after it.
    fn same_scene(&self, ends: &Period, begins: &Period) -> bool {
        let before = self.stage.film.frame(ends.start);
        let after = self.stage.film.frame(begins.start);
        let pose = |state: &FrameState<'_>, id: ObjectId| {
            let object = state.objects.iter().find(|object| object.id == id)?;
            Some(object.pose)
        };
        ends.objects
            .iter()
            .filter(|o| o.class == Class::Immobile)
            .all(|o| pose(&before, o.object) == pose(&after, o.object))
    }

    /// Is what is seen of an object the same in both décors, whatever else they
    /// show, and each pixel one object's alone?
    fn is_apart(&self, state: &FrameState<'_>, old: &Shown, new: &Shown) -> bool {
        let abilities = self.stage.adapter.abilities();
        let opaque = |object: &ObjectState<'_>| {
            self.stage.prototype(object).optics == Optics::Opaque || !abilities.optics
        };
        let same_light = !self.stage.has_shadows(state)
            || abilities.hidden_casters && old.lit_among == new.lit_among;
        same_light && self.stage.antialias().is_none() && state.objects.iter().all(opaque)
    }

    /// Where no depth is needed: the new décor rendered whole, and the old one's
    /// objects in the blocks where the two differ.
    fn in_common_by_blocks(
        &self,
        state: &FrameState<'_>,
        old: &Shown,
        new: &Shown,
        colours: bool,
    ) -> Result<Option<Joint>, RenderError> {
        let (size, frame) = (self.stage.size(), state.number);
        let mut blocks = self.stage.no_blocks(&self.plan.wishes);
        for object in &state.objects {
            if old.drawn.contains(&object.id) != new.drawn.contains(&object.id) {
                blocks.insert_all(self.stage.silhouette(object, &state.camera));
            }
        }
        let pixels = blocks.pixels();
        if pixels as f64 > PARTICULAR_SHARE * size.pixels() as f64 {
            return Ok(None);
        }
        let particular = || {
            if blocks.is_empty() {
                return Ok(None);
            }
            let seen = |object: &&ObjectState<'_>| {
                old.drawn.contains(&object.id)
                    && self.stage.is_seen_in(object, &state.camera, &blocks)
            };
            let seen = old.only(state.objects.iter().filter(seen).map(|object| object.id));
            let scene = self.decor_scene(state, &seen);
            let region = Region::Blocks(blocks.wanted());
            let colour = Output::ColourOverBackground;
            let label = format!("target_{frame:04}");
            let request = self.request_of(frame, &Arc::new(scene), &region, colour, label);
            self.traced
                .decor
                .fetch_add(pixels as u64, Ordering::Relaxed);
            Ok::<_, RenderError>(Some(self.drawn(&request, colours)?))
        };
        let scene = self.decor_scene(state, new);
        let (decor, particular) = std::thread::scope(|scope| {
            let particular = scope.spawn(particular);
            let decor = self.picture(frame, scene, false, colours, "decor");
            (decor, join(particular))
        });
        let Begun { layer, picture } = decor?;
        let (mut target, mut target_picture) = (layer.clone(), picture.clone());
        match particular? {
            None => {}
            Some(Drawn::Layer(particular)) => {
                for window in blocks.runs() {
                    lay(&mut target, &block_of(&particular, window));
                }
            }
            Some(Drawn::Picture(particular)) => {
                let laid = |on: Still| self.encoder().laid(on, size, &particular, blocks.runs());
                target_picture = target_picture.map(laid);
            }
        }
        Ok(Some(Joint {
            decor: Some(Arc::new(layer)),
            decor_picture: picture,
            target: Some(Arc::new(target)),
            target_picture,
            ..Joint::default()
        }))
    }

    /// The objects that both décors have, rendered once, and what is particular
    /// to each merged into it. `None` where that would not be cheaper.
    fn in_common(
        &self,
        state: &FrameState<'_>,
        old: &Shown,
        new: &Shown,
    ) -> Result<Option<Joint>, RenderError> {
        let (size, frame) = (self.stage.size(), state.number);
        let common = old.only(old.drawn.intersection(&new.drawn).copied());
        let old = old.only(old.drawn.difference(&common.drawn).copied());
        let new = new.only(new.drawn.difference(&common.drawn).copied());
        let windows = |particular: &Shown| {
            let objects = state.objects.iter();
            let particular = objects.filter(|object| particular.drawn.contains(&object.id));
            let windows: Vec<Window> = particular
                .map(|object| self.stage.window(object, &state.camera))
                .collect();
            gathered(&windows, size, false)
        };
        let (old_windows, new_windows) = (windows(&old), windows(&new));
        let pixels: usize = old_windows
            .iter()
            .chain(&new_windows)
            .map(|window| window.pixels())
            .sum();
        if common.drawn.is_empty() || pixels as f64 > PARTICULAR_SHARE * size.pixels() as f64 {
            return Ok(None);
        }
        let (ground, olds, news) = std::thread::scope(|scope| {
            let olds = scope.spawn(|| self.particular(state, &old_windows, "target", &old));
            let news = scope.spawn(|| self.particular(state, &new_windows, "decor", &new));
            let ground = self.decor(frame, &common, "common");
            (ground, join(olds), join(news))
        });
        let (ground, olds, news) = (ground?, olds?, news?);
        Ok(Some(Joint {
            target: Some(Arc::new(merged(&ground, &olds))),
            decor: Some(Arc::new(merged(&ground, &news))),
            ..Joint::default()
        }))
    }

    /// Layers of some objects by themselves: colour and depth, a pair a window.
    fn particular(
        &self,
        state: &FrameState<'_>,
        windows: &[Window],
        label: &str,
        shown: &Shown,
    ) -> Result<Vec<(Layer, Layer)>, RenderError> {
        if windows.is_empty() {
            return Ok(Vec::new());
        }
        let scene = Arc::new(self.decor_scene(state, shown));
        let with_sky = self.stage.surroundings(state).sky_on_objects;
        let mut layers = Vec::new();
        for (k, &window) in windows.iter().enumerate() {
            let regions = Region::Window(window);
            let colour = Output::ColourAlone { with_sky };
            let name = format!("{label}_{k}");
            layers.push(self.colour_and_depth(state.number, &scene, &regions, colour, &name)?);
            let pixels = window.pixels() as u64;
            self.traced.decor.fetch_add(pixels, Ordering::Relaxed);
            self.traced.depth.fetch_add(pixels, Ordering::Relaxed);
        }
        Ok(layers)
    }

    fn colour_and_depth(
        &self,
        frame: u32,
        scene: &Arc<Scene>,
        region: &Region,
        colour: Output,
        label: &str,
    ) -> Result<(Layer, Layer), RenderError> {
        let call = |output: Output, label: String| {
            let request = self.request_of(frame, scene, region, output, label);
            Ok::<Layer, RenderError>(only(self.call(&request, None)?)?)
        };
        std::thread::scope(|scope| {
            let depth = scope.spawn(|| call(Output::Depth, format!("{label}_depth_{frame:04}")));
            let colour = call(colour, format!("{label}_{frame:04}"));
            Ok((colour?, join(depth)?))
        })
    }

    pub fn request_of(
        &self,
        frame: u32,
        scene: &Arc<Scene>,
        region: &Region,
        output: Output,
        label: String,
    ) -> LayerRequest<'_> {
        LayerRequest {
            prototypes: &self.stage.library.table,
            size: self.stage.size(),
            output,
            antialias: self.stage.antialias(),
            shots: vec![LayerShot {
                frame,
                scene: Arc::clone(scene),
                region: region.clone(),
            }],
            film: None,
            label,
        }
    }

    /// What frames begin with: the whole picture of a scene, with its depth where that
    /// is wanted; its colours too, or what the frames' files show of them.
    fn picture(
        &self,
        frame: u32,
        scene: Scene,
        with_depth: bool,
        colours: bool,
        label: &str,
    ) -> Result<Begun, RenderError> {
        let size = self.stage.size();
        let scene = Arc::new(scene);
        let region = Region::Window(size.window());
        let pixels = size.pixels() as u64;
        let request =
            |output: Output, label: String| self.request_of(frame, &scene, &region, output, label);
        let (drawn, depth) = std::thread::scope(|scope| {
            let depth = with_depth.then(|| {
                scope.spawn(|| {
                    self.traced.depth.fetch_add(pixels, Ordering::Relaxed);
                    let label = format!("{label}_depth_{frame:04}");
                    self.call(&request(Output::Depth, label), None)
                })
            });
            self.traced.decor.fetch_add(pixels, Ordering::Relaxed);
            let colour = request(Output::ColourOverBackground, format!("{label}_{frame:04}"));
            (self.drawn(&colour, colours), depth.map(join))
        });
        let (mut layer, picture) = match drawn? {
            Drawn::Layer(layer) => (layer, None),
            Drawn::Picture(picture) => {
                let layer = Layer {
                    window: picture.window,
                    colour: None,
                    depth: None,
                    depth_quantum: (0.0, 0.0),
                };
                (layer, Some(self.encoder().still_of(picture)))
            }
        };
        if let Some(depth) = depth.transpose()? {
            let depth = only(depth)?;
            layer.depth = depth.depth;
            layer.depth_quantum = depth.depth_quantum;
        }
        Ok(Begun { layer, picture })
    }

    /// The only picture of a call that may use every core: its colours, or where those
    /// are not needed, and the renderer has it, what a frame's file shows of them.
    fn drawn(&self, request: &LayerRequest<'_>, colours: bool) -> Result<Drawn, RenderError> {
        let mut left = self.call_to_read(request, !colours, None)?;
        Ok(match &mut left {
            Left::Layers(layers) => Drawn::Layer(layers.read(0)?),
            Left::Pictures(pictures) => Drawn::Picture(pictures.read(0)?),
        })
    }

    /// Some objects of a frame with all that surrounds them, in the whole picture,
    /// with their depth.
    fn decor(&self, frame: u32, shown: &Shown, label: &str) -> Result<Layer, RenderError> {
        let scene = self.decor_scene(&self.stage.film.frame(frame), shown);
        Ok(self.picture(frame, scene, true, true, label)?.layer)
    }
}

/// What frames begin with.
struct Begun {
    /// Its depth, and its colours where they are needed.
    layer: Layer,
    /// What the frames' files show of it, where the renderer has encoded it.
    picture: Option<Still>,
}

/// A picture with some layers merged into it.
fn merged(ground: &Layer, layers: &[(Layer, Layer)]) -> Layer {
    let mut all = ground.clone();
    for (colour, depth) in layers {
        let patch = merge(Backdrop::plain(&all), colour, depth, false);
        lay(&mut all, &patch);
        let (a, b) = (all.depth_quantum, depth.depth_quantum);
        all.depth_quantum = (a.0.max(b.0), a.1.max(b.1));
    }
    all
}

/// Replaces a rectangle of a picture.
fn lay(layer: &mut Layer, patch: &Patch) {
    let width = patch.window.width as usize;
    for (k, y) in (patch.window.y..patch.window.bottom()).enumerate() {
        let (from, into) = (k * width, layer.index(patch.window.x, y));
        if let Some(colour) = &mut layer.colour {
            colour[into..into + width].copy_from_slice(&patch.colour[from..from + width]);
        }
        if let (Some(depth), Some(new)) = (&mut layer.depth, &patch.depth) {
            depth[into..into + width].copy_from_slice(&new[from..from + width]);
        }
    }
}

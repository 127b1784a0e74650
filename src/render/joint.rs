//! A joint between two periods: the décor of the one that begins, and what the
//! décor of the one that ends has turned into.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use decor_api::{Layer, LayerRequest, LayerShot, Output, Region, Scene};

use super::RenderError;
use super::called::{Drawn, Left};
use super::execution::{Execution, join, only};
use super::shading::Lighting;
use super::shown::Shown;
use super::surfaces::Surfaces;
use crate::film::{FrameState, ObjectId};
use crate::frames::Still;
use crate::plan::{FramePlan, Period};
use crate::segmentation::Class;

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
    pub fn picture(
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
    pub fn drawn(&self, request: &LayerRequest<'_>, colours: bool) -> Result<Drawn, RenderError> {
        let mut left = self.call_to_read(request, !colours, None)?;
        Ok(match &mut left {
            Left::Layers(layers) => Drawn::Layer(layers.read(0)?),
            Left::Pictures(pictures) => Drawn::Picture(pictures.read(0)?),
        })
    }

    /// Some objects of a frame with all that surrounds them, in the whole picture,
    /// with their depth.
    pub fn decor(&self, frame: u32, shown: &Shown, label: &str) -> Result<Layer, RenderError> {
        let scene = self.decor_scene(&self.stage.film.frame(frame), shown);
        Ok(self.picture(frame, scene, true, true, label)?.layer)
    }
}

/// What frames begin with.
pub struct Begun {
    /// Its depth, and its colours where they are needed.
    pub layer: Layer,
    /// What the frames' files show of it, where the renderer has encoded it.
    pub picture: Option<Still>,
}

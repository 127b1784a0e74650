//! What two décors have in common is rendered once.
//!
//! Thesis, III-3-2-2: at the joint of two periods the objects of both décors are
//! rendered once, and merged with what is particular to each. Where no depth is
//! needed, the new décor is rendered whole, and the old one's objects in the blocks
//! where the two differ.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use decor_api::{Layer, Optics, Output, Region, Scene, Window};

use super::RenderError;
use super::called::Drawn;
use super::execution::{Execution, join, only};
use super::ground::block_of;
use super::joint::{Begun, Joint};
use super::shown::Shown;
use crate::dissolve::Backdrop;
use crate::film::{FrameState, ObjectState};
use crate::frames::Still;
use crate::merge::{Patch, merge};
use crate::plan::gathered;

/// Particular objects are rendered by themselves where their windows are not
/// more than this share of the picture: their depth has a price too.
const PARTICULAR_SHARE: f64 = 0.5;

impl Execution<'_> {
    /// Is what is seen of an object the same in both décors, whatever else they
    /// show, and each pixel one object's alone?
    pub fn is_apart(&self, state: &FrameState<'_>, old: &Shown, new: &Shown) -> bool {
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
    pub fn in_common_by_blocks(
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
    pub fn in_common(
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

//! A request in Mitsuba's language: files that are rendered one after the other
//! in one call, and files that these read.

use std::collections::BTreeMap;
use std::sync::Arc;

use decor_api::{
    AdapterError, BLOCK, BlockMask, Geometry, Instance, LayerRequest, LayerShot, Output,
    PrototypeTable, Region, Scene, Window,
};
use glam::DAffine3;

use crate::camera::{Sensor, squeeze};
use crate::geometry;
use crate::light::emitters;
use crate::look::{Ambient, Looks};
use crate::solid::Model;
use crate::units::{Placed, Units};
use crate::unsupported;

/// What a file renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Pass {
    /// How far rays go.
    Depth,
    /// Which look is where, with every sample a pixel of its own.
    Looks,
    /// The light of one emitter.
    Light,
}

/// A file to render.
#[derive(Clone, Debug)]
pub(crate) struct Rendered {
    pub pass: Pass,
    /// Without its ending: `.xml` is the scene, `.exr` the picture.
    pub name: String,
}

/// How a shot becomes a layer.
#[derive(Clone, Debug)]
pub(crate) struct Take {
    pub frame: u32,
    /// What the layer covers.
    pub window: Window,
    /// What the pictures cover.
    pub drawn: Window,
    pub sensor: Sensor,
    /// How far meshes are from what they stand for.
    pub deviation: f64,
    /// None where there is nothing to see.
    pub passes: Vec<Rendered>,
}

/// A translated request.
#[derive(Clone, Debug)]
pub(crate) struct Script {
    pub files: Vec<(String, Vec<u8>)>,
    pub takes: Vec<Take>,
    /// What shines by itself, by look.
    pub ambient: Ambient,
    /// Samples in a row and in a column of a pixel, for colour.
    pub per_side: u32,
}

/// Gives the model of a prototype.
pub(crate) type ModelOf<'a> = dyn Fn(&Instance) -> Result<Arc<Model>, AdapterError> + 'a;

impl Script {
    pub fn new(request: &LayerRequest<'_>, model_of: &ModelOf<'_>) -> Result<Self, AdapterError> {
        let per_side = match (request.output, request.antialias) {
            (Output::Depth, _) | (_, None) => 1,
            (_, Some(antialias)) => antialias.depth.clamp(1, 9),
        };
        let mut models: BTreeMap<u32, Arc<Model>> = BTreeMap::new();
        for shot in &request.shots {
            refuse_what_cannot_be_drawn(&shot.scene, request.output)?;
            for instance in &shot.scene.instances {
                if let std::collections::btree_map::Entry::Vacant(place) =
                    models.entry(instance.prototype.0)
                {
                    place.insert(model_of(instance)?);
                }
            }
        }
        let mut looks = Looks::default();
        let mut read = Vec::new();
        for (&number, model) in &models {
            read.extend(geometry::files(model, number, &mut looks));
        }
        let writer = Writer {
            request,
            models: &models,
            per_side,
            ambient: looks.ambient(),
            share: looks.share(),
        };
        let mut files = Vec::new();
        let mut takes = Vec::new();
        for (k, shot) in request.shots.iter().enumerate() {
            takes.push(writer.take(k, shot, &mut looks, &mut files, &mut read)?);
        }
        if files.is_empty() {
            read.clear();
        } else {
            read.push((LIT.to_owned(), looks.lit().into_bytes()));
            read.push((TOLD_APART.to_owned(), looks.told_apart().into_bytes()));
        }
        let ambient = writer.ambient;
        files.extend(read);
        Ok(Self {
            files,
            takes,
            ambient,
            per_side,
        })
    }
}

const LIT: &str = "looks.xml";
const TOLD_APART: &str = "looks_told_apart.xml";

struct Writer<'a> {
    request: &'a LayerRequest<'a>,
    models: &'a BTreeMap<u32, Arc<Model>>,
    per_side: u32,
    ambient: Ambient,
    share: f64,
}

impl Writer<'_> {
    fn take(
        &self,
        k: usize,
        shot: &LayerShot,
        looks: &mut Looks,
        files: &mut Vec<(String, Vec<u8>)>,
        read: &mut Vec<(String, Vec<u8>)>,
    ) -> Result<Take, AdapterError> {
        let (size, scene) = (self.request.size, &*shot.scene);
        let placed = self.placed(scene);
        let units = Units::of(scene, &placed)?;
        let sensor = Sensor::new(&scene.camera, size, units);
        let (window, mask) = match &shot.region {
            Region::Window(window) => {
                if window.intersection(size.window()) != *window && !window.is_empty() {
                    return Err(unsupported(&format!("{window:?}: the picture is smaller")));
                }
                // On the grid it has the picture's very values: a crop has not.
                let on_grid = window.on_grid(BLOCK, size) == *window;
                let mask =
                    (on_grid && *window != size.window()).then(|| BlockMask::of(*window, size));
                (*window, mask)
            }
            Region::Blocks(blocks) => {
                let mask = BlockMask::new(blocks, size).map_err(|what| unsupported(&what))?;
                (mask.window(), Some(mask))
            }
        };
        let mut take = Take {
            frame: shot.frame,
            window,
            drawn: if mask.is_some() {
                size.window()
            } else {
                window
            },
            sensor,
            deviation: placed.iter().map(|p| p.model.deviation).fold(0.0, f64::max),
            passes: Vec::new(),
        };
        if window.is_empty() || placed.is_empty() {
            return Ok(take);
        }
        let crop = (take.drawn != size.window()).then_some(take.drawn);
        let cover = mask
            .map(|mask| sensor.mask(&|x, y| mask.contains(x, y), mask.side()))
            .unwrap_or_default();
        let shapes = format!("s{k:04}_shapes.xml");
        let mut add = |pass: Pass, name: &str, per_side: u32, enlarged: u32, emitter: &str| {
            let integrator = match pass {
                Pass::Depth => "<integrator type=\"depth\"/>",
                _ => {
                    "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"1\"/>\
                     <integer name=\"bsdf_samples\" value=\"0\"/></integrator>"
                }
            };
            let looks = if pass == Pass::Light { LIT } else { TOLD_APART };
            let name = format!("s{k:04}_{name}");
            let text = format!(
                "<scene version=\"3.0.0\">\n{integrator}\n{}{emitter}\n\
                 <include filename=\"{looks}\"/>\n<include filename=\"{shapes}\"/>\n{cover}</scene>\n",
                sensor.text(crop, per_side, enlarged)
            );
            files.push((format!("{name}.xml"), text.into_bytes()));
            take.passes.push(Rendered { pass, name });
        };
        if self.request.output == Output::Depth {
            add(Pass::Depth, "depth", 1, 1, "");
        } else {
            let emitters = emitters(scene, squeeze(&scene.camera, size))?;
            if !emitters.is_empty() {
                sensor.refuse_light()?;
            }
            if emitters.is_empty() || self.ambient.uniform().is_none() {
                let eye = format!(
                    "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"0\"/>{}</emitter>",
                    crate::xml::rgb("intensity", [units.scale * units.scale; 3])
                );
                add(Pass::Looks, "looks", 1, self.per_side, &eye);
            }
            for (n, emitter) in emitters.iter().enumerate() {
                let text = emitter.text(units, self.share);
                add(
                    Pass::Light,
                    &format!("light_{n:03}"),
                    self.per_side,
                    1,
                    &text,
                );
            }
        }
        let text = geometry::shapes(&placed, units, looks);
        read.push((shapes, text.into_bytes()));
        Ok(take)
    }

    /// What is to be seen of a scene, from the eye.
    fn placed(&self, scene: &Scene) -> Vec<Placed<'_>> {
        let eye = scene.camera.eye;
        let squeezed = DAffine3::from_mat3(squeeze(&scene.camera, self.request.size));
        let placed = scene.instances.iter().filter_map(|instance| {
            let model = self.models.get(&instance.prototype.0)?;
            if model.parts.is_empty() && model.half_spaces.is_empty() {
                return None;
            }
            let pose = &instance.pose;
            let from_eye = squeezed
                * DAffine3::from_rotation_translation(pose.rotation(), pose.position - eye);
            let bounds = self.request.prototypes.get(instance.prototype).bounds;
            let bounds = bounds.posed(pose);
            Some(Placed::new(
                model,
                instance.prototype.0,
                bounds,
                from_eye,
                eye,
            ))
        });
        placed.collect()
    }
}

fn refuse_what_cannot_be_drawn(scene: &Scene, output: Output) -> Result<(), AdapterError> {
    if let Some(file) = scene.includes.iter().chain(&scene.sky).next() {
        return Err(AdapterError::native(crate::NAME, file));
    }
    if !scene.hidden.is_empty() && output != Output::Depth {
        return Err(unsupported("what casts shadows and is not seen"));
    }
    Ok(())
}

/// The model of a prototype, or why there is none.
pub(crate) fn model(table: &PrototypeTable, instance: &Instance) -> Result<Model, AdapterError> {
    match &table.get(instance.prototype).geometry {
        Geometry::Neutral(solid) => Model::new(solid),
        Geometry::Fragment(fragment) => Err(AdapterError::native(crate::NAME, &fragment.file)),
    }
}

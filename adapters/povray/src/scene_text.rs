//! A request as POV-Ray text: one main file with every prototype declared once,
//! and a small file for each frame.

use std::collections::BTreeSet;
use std::sync::Arc;

use decor_api::{
    Antialias, Bounds, Camera, Geometry, Instance, LayerRequest, LayerShot, NativeFile, Output,
    PrototypeId, PrototypeTable, Region, Scene, SceneText, Size, Window,
};

use crate::camera::{Raster, padded};
use crate::depth::{DepthCode, Precision};
use crate::isolate::isolate;
use crate::light;
use crate::number::colour;
use crate::solid::{Looks, placed, solid};
use crate::sources::Library;

/// The name of the main file.
pub const MAIN: &str = "scene.pov";

/// The texture of the depth pass.
const DEPTH_TEXTURE: &str = "Decor_Depth";

/// How the frames of one call are numbered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbering {
    /// POV-Ray's first and last frame: the clock runs between them. `None`: a
    /// still, without a clock.
    pub film: Option<(u32, u32)>,
    /// The first frame to render.
    pub first: u32,
    /// How many.
    pub count: usize,
}

impl Numbering {
    /// Frames without a clock of their own, from 1.
    pub fn local(count: usize) -> Self {
        // With a last frame of 1 POV-Ray would render a still, under another name.
        Self {
            film: Some((1, (count as u32).max(2))),
            first: 1,
            count,
        }
    }

    /// Frames of a film, by their own numbers.
    pub fn of_film(film: (u32, u32), first: u32, count: usize) -> Self {
        let film = if film.0 == film.1 { None } else { Some(film) };
        Self { film, first, count }
    }

    /// The numbering of a request.
    pub fn of(request: &LayerRequest<'_>) -> Self {
        let count = request.shots.len();
        match (request.film, request.shots.first()) {
            (Some(film), Some(shot)) => Self::of_film(film, shot.frame, count),
            _ => Self::local(count),
        }
    }

    /// The number of the frame at `index`.
    pub fn frame(&self, index: usize) -> u32 {
        self.first + index as u32
    }

    /// The switches for POV-Ray.
    pub fn args(&self) -> Vec<String> {
        let Some((a, b)) = self.film else {
            return Vec::new();
        };
        let last = self.first + (self.count as u32).saturating_sub(1);
        vec![
            format!("+KFI{a}"),
            format!("+KFF{b}"),
            format!("+SF{}", self.first),
            format!("+EF{last}"),
        ]
    }

    /// What POV-Ray appends to a name for the frame at `index`.
    pub fn suffix(&self, index: usize) -> String {
        match self.film {
            None => String::new(),
            Some((_, last)) => {
                let digits = last.to_string().len();
                format!("{:0digits$}", self.frame(index))
            }
        }
    }
}

/// Which camera the frames of a request are seen by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Framing {
    /// The whole picture's.
    Full,
    /// Crop cameras: pictures of `padded` pixels, of which `cut` are rendered.
    Crop {
        /// The picture's size for POV-Ray.
        padded: Size,
        /// The rendered part, from the upper left.
        cut: Size,
    },
}

impl Framing {
    /// The framing for the regions of some shots. A window that begins at the
    /// upper left and covers the picture needs no crop. Blocks are masked in the
    /// whole picture, or in a crop around them where that is smaller by half:
    /// POV-Ray holds and writes every pixel of a picture, traced or not. Not where
    /// the picture's border cuts a block and antialiasing is on: in the crop that
    /// block would be whole, and what is refined inside of a block may change any
    /// of its pixels.
    pub fn of(request: &LayerRequest<'_>) -> Self {
        let (shots, size) = (&request.shots, request.size);
        let mut cut = Size {
            width: 1,
            height: 1,
        };
        let (mut masked, mut is_cut) = (false, false);
        for shot in shots {
            if let Region::Blocks(blocks) = &shot.region {
                masked = true;
                is_cut |= blocks
                    .windows(size)
                    .any(|block| block.width < blocks.side || block.height < blocks.side);
            }
            let window = window_of(&shot.region, size);
            cut.width = cut.width.max(window.width);
            cut.height = cut.height.max(window.height);
        }
        let padded = padded(cut.width, cut.height);
        let same_blocks = request.antialias.is_none() || !is_cut;
        if masked && same_blocks && 2 * padded.pixels() <= size.pixels() {
            Self::Crop { padded, cut }
        } else if masked || cut == size {
            Self::Full
        } else {
            Self::Crop { padded, cut }
        }
    }
}

/// The window of the picture that a region's layer covers.
pub fn window_of(region: &Region, size: Size) -> Window {
    match region {
        Region::Window(window) => *window,
        Region::Blocks(blocks) => blocks.window(size),
    }
}

/// Everything that the text of a request depends on, besides the request.
#[derive(Clone, Copy, Debug)]
pub struct Writer<'a> {
    /// Where fragments find what they include.
    pub library: &'a Library,
    /// What the pixels will be read from.
    pub precision: Precision,
    /// Do declarations change what objects look like by default?
    pub default_changed: bool,
    /// Do declarations keep a state (random numbers, macros that count)? Then
    /// every call reads every fragment, so that it is the same in all of them.
    pub stateful: bool,
    /// May lights stand in a group around everything? Outside of one, POV-Ray
    /// tries the object first that cast the last shadow, and then overlooks
    /// less: whether a point lies in a shadow depends on what its thread traced
    /// before, in single pixels near edges. The lights of a group have no such
    /// memory, and the picture depends on the scene alone.
    pub light_group: bool,
}

/// What the frames of one call share.
pub struct Shared<'a> {
    /// The geometry.
    pub prototypes: &'a PrototypeTable,
    /// Which of it is placed in any frame.
    pub used: BTreeSet<PrototypeId>,
    /// The same of each frame, where they differ.
    pub by_frame: Vec<BTreeSet<PrototypeId>>,
    /// Declarations.
    pub includes: &'a [NativeFile],
    /// What surrounds the scene, where that is drawn.
    pub sky: Option<&'a NativeFile>,
    /// Are the neutral materials written?
    pub looks: Looks,
    /// Statements behind the declarations.
    pub settings: &'a str,
}

impl<'a> Shared<'a> {
    /// What frames share that place some instances, and nothing else.
    pub fn placing(
        prototypes: &'a PrototypeTable,
        placed: impl Iterator<Item = &'a Instance>,
    ) -> Self {
        Self {
            prototypes,
            used: placed.map(|i| i.prototype).collect(),
            by_frame: Vec::new(),
            includes: &[],
            sky: None,
            looks: Looks::Written,
            settings: "",
        }
    }

    /// What some scenes share: all of a request have the same surroundings.
    fn of(prototypes: &'a PrototypeTable, scenes: impl Iterator<Item = &'a Scene>) -> Self {
        let mut shared = Self::placing(prototypes, std::iter::empty());
        for (k, scene) in scenes.enumerate() {
            if k == 0 {
                shared.includes = &scene.includes;
                shared.sky = scene.sky.as_ref();
            }
            let placed = scene.instances.iter().chain(&scene.hidden);
            let used: BTreeSet<PrototypeId> = placed.map(|i| i.prototype).collect();
            shared.used.extend(&used);
            shared.by_frame.push(used);
        }
        shared
    }

    /// The frames that place a prototype, as POV-Ray's condition; `None`: all do. A
    /// file that stands under a condition that fails is not even opened.
    fn only_in(&self, id: PrototypeId, numbering: Numbering) -> Option<String> {
        let places = |used: &BTreeSet<PrototypeId>| used.contains(&id);
        if self.by_frame.iter().all(places) {
            return None;
        }
        let placed = (0..).zip(&self.by_frame).filter(|(_, used)| places(used));
        let mut runs: Vec<(u32, u32)> = Vec::new();
        for (k, _) in placed {
            let number = numbering.frame(k);
            match runs.last_mut() {
                Some((_, last)) if *last + 1 == number => *last = number,
                _ => runs.push((number, number)),
            }
        }
        let runs = runs
            .iter()
            .map(|(first, last)| format!("((frame_number >= {first}) & (frame_number <= {last}))"));
        Some(runs.collect::<Vec<_>>().join(" | "))
    }
}

/// What a pass adds to the placed objects.
struct Pass {
    /// What an instance gets besides its place.
    modifiers: String,
    /// Are there lights, and objects that are there only for what they do to
    /// the light?
    lit: bool,
}

impl Writer<'_> {
    /// The files of a request.
    pub fn layers(&self, request: &LayerRequest<'_>) -> SceneText {
        let framing = Framing::of(request);
        let numbering = Numbering::of(request);
        let code = self.depth_code(request);
        let mut frames = Vec::new();
        for shot in &request.shots {
            let mut text = camera(&shot.scene.camera, request.size, framing, &shot.region);
            text.push_str(&self.frame(request, shot, code));
            frames.push(text);
        }
        let looks = match code {
            Some(code) if code.is_pigment() => Looks::LeftOut,
            _ => Looks::Written,
        };
        let sky = matches!(
            request.output,
            Output::ColourOverBackground | Output::ColourAlone { with_sky: true }
        );
        let mut shared = Shared::of(request.prototypes, request.shots.iter().map(|s| &*s.scene));
        shared.looks = looks;
        shared.sky = shared.sky.filter(|_| sky);
        if code.is_some_and(|code| !code.is_pigment()) {
            shared.settings = "global_settings { ambient_light 0 max_trace_level 1 }\n";
        }
        self.files(&shared, frames, numbering)
    }

    /// The files of whole frames as the stock renderer gets them: the same text
    /// as the layers', with everything in it.
    pub fn whole(
        &self,
        prototypes: &PrototypeTable,
        size: Size,
        frames: &[(u32, Arc<Scene>)],
        numbering: Numbering,
    ) -> SceneText {
        let pass = colour_pass(frames.first().is_none_or(|(_, scene)| scene.shadows));
        let texts = frames
            .iter()
            .map(|(_, scene)| {
                let mut text = Raster::new(&scene.camera, size).full();
                text.push_str(&background(scene, false));
                text.push_str(&self.contents(prototypes, scene, &pass));
                text
            })
            .collect();
        let shared = Shared::of(prototypes, frames.iter().map(|(_, scene)| &**scene));
        self.files(&shared, texts, numbering)
    }

    /// How depth is written in this request; `None` in a colour pass.
    pub fn depth_code(&self, request: &LayerRequest<'_>) -> Option<DepthCode> {
        if request.output != Output::Depth {
            return None;
        }
        let (mut near, mut far) = (f64::INFINITY, 0.0_f64);
        let mut neutral = !self.default_changed;
        for shot in &request.shots {
            for instance in &shot.scene.instances {
                let prototype = request.prototypes.get(instance.prototype);
                neutral &= matches!(prototype.geometry, Geometry::Neutral(_));
                match prototype.bounds.posed(&instance.pose) {
                    Bounds::Empty => {}
                    Bounds::Unbounded => {
                        (near, far) = (0.0, f64::INFINITY);
                    }
                    Bounds::Sphere(s) => {
                        let distance = (s.centre - shot.scene.camera.eye).length();
                        near = near.min((distance - s.radius).max(0.0));
                        far = far.max(distance + s.radius);
                    }
                }
            }
        }
        let near = if near.is_finite() { near } else { 0.0 };
        let far = if far > 0.0 { far } else { 1.0 };
        Some(if neutral {
            DepthCode::pigment(near, far, self.precision)
        } else {
            DepthCode::veil(far, self.precision)
        })
    }

    fn frame(
        &self,
        request: &LayerRequest<'_>,
        shot: &LayerShot,
        code: Option<DepthCode>,
    ) -> String {
        let scene = &shot.scene;
        match (request.output, code) {
            (Output::Depth, Some(code)) => {
                let mut text = code.declaration(scene.camera.eye, DEPTH_TEXTURE);
                let modifiers = if code.is_pigment() {
                    format!("texture {{ {DEPTH_TEXTURE} }}")
                } else {
                    // What is not hollow and holds the observer turns fog off.
                    "hollow".to_owned()
                };
                let pass = Pass {
                    modifiers,
                    lit: false,
                };
                text.push_str(&self.contents(request.prototypes, scene, &pass));
                text
            }
            (output, _) => {
                let alone = matches!(output, Output::ColourAlone { .. });
                let pass = colour_pass(scene.shadows);
                background(scene, alone) + &self.contents(request.prototypes, scene, &pass)
            }
        }
    }

    /// Lights and placed objects.
    fn contents(&self, prototypes: &PrototypeTable, scene: &Scene, pass: &Pass) -> String {
        let mut objects = placed_all(prototypes, &scene.instances, &pass.modifiers);
        if !pass.lit {
            return objects;
        }
        let modifiers = format!("{} no_image", pass.modifiers);
        objects.push_str(&placed_all(
            prototypes,
            &scene.hidden,
            modifiers.trim_start(),
        ));
        let lights: String = scene.lights.iter().map(light::light).collect();
        let grouped = self.light_group && scene.shadows && !lights.is_empty();
        if grouped && !objects.is_empty() {
            format!("light_group {{\n{lights}{objects}global_lights off }}\n")
        } else {
            lights + &objects
        }
    }

    /// The main file with what `shared` holds, and the text of each frame.
    pub fn files(
        &self,
        shared: &Shared<'_>,
        frames: Vec<String>,
        numbering: Numbering,
    ) -> SceneText {
        let mut main = String::from("#version 3.7;\nglobal_settings { assumed_gamma 1 }\n");
        let mut parts: Vec<(String, Vec<u8>)> = Vec::new();
        let includes = shared.includes;
        for (k, include) in includes.iter().enumerate() {
            let name = format!("decor_include_{k}.inc");
            main.push_str(&format!("#include \"{name}\"\n"));
            parts.push((name, with_newline(&include.text)));
        }
        main.push_str(shared.settings);
        if let Some(sky) = shared.sky {
            main.push_str("#include \"decor_sky.inc\"\n");
            // What a sky declares is its own, as a fragment's is.
            parts.extend(isolate(sky, includes, self.library, "sky"));
        }
        let used: BTreeSet<PrototypeId> = if self.stateful {
            shared.prototypes.iter().map(|(id, _)| id).collect()
        } else {
            shared.used.clone()
        };
        for id in used {
            let prototype = shared.prototypes.get(id);
            if prototype.bounds == Bounds::Empty {
                continue;
            }
            let only_in = match numbering.film {
                Some(_) if !self.stateful => shared.only_in(id, numbering),
                _ => None,
            };
            if let Some(frames) = &only_in {
                main.push_str(&format!("#if ({frames})\n"));
            }
            match &prototype.geometry {
                Geometry::Neutral(csg) => {
                    main.push_str(&format!(
                        "#declare {} = {}\n",
                        name(id),
                        solid(csg, shared.looks)
                    ));
                }
                Geometry::Fragment(fragment) => {
                    let stem = format!("P{}", id.0);
                    main.push_str(&format!(
                        "#declare {} = union {{\n#include \"decor_{stem}.inc\"\n}}\n",
                        name(id)
                    ));
                    parts.extend(isolate(&fragment.file, includes, self.library, &stem));
                }
            }
            if only_in.is_some() {
                main.push_str("#end\n");
            }
        }
        match numbering.film {
            None => main.push_str("#include \"decor_frame_0.inc\"\n"),
            Some(_) => main
                .push_str("#include concat(\"decor_frame_\", str(frame_number, 0, 0), \".inc\")\n"),
        }
        let mut files = vec![(MAIN.to_owned(), main.into_bytes())];
        files.extend(parts);
        for (k, text) in frames.into_iter().enumerate() {
            let number = if numbering.film.is_some() {
                numbering.frame(k)
            } else {
                0
            };
            files.push((format!("decor_frame_{number}.inc"), text.into_bytes()));
        }
        SceneText { files }
    }
}

/// The statements that place instances, each with `modifiers`.
pub fn placed_all(table: &PrototypeTable, instances: &[Instance], modifiers: &str) -> String {
    let there = |i: &&Instance| table.get(i.prototype).bounds != Bounds::Empty;
    instances
        .iter()
        .filter(there)
        .map(|i| placed(&name(i.prototype), &i.pose, modifiers))
        .collect()
}

/// How a prototype is called in the text.
fn name(id: PrototypeId) -> String {
    format!("Decor_P{}", id.0)
}

fn colour_pass(shadows: bool) -> Pass {
    let modifiers = if shadows {
        String::new()
    } else {
        "no_shadow".to_owned()
    };
    Pass {
        modifiers,
        lit: true,
    }
}

fn camera(camera: &Camera, size: Size, framing: Framing, region: &Region) -> String {
    let raster = Raster::new(camera, size);
    match framing {
        Framing::Crop { padded, .. } => raster.crop(window_of(region, size), padded),
        Framing::Full => raster.full(),
    }
}

/// The background; `alone`: it gives way to the alpha channel.
fn background(scene: &Scene, alone: bool) -> String {
    let text = colour(scene.background);
    if alone {
        format!("background {{ rgb {text} transmit 1 }}\n")
    } else {
        format!("background {{ rgb {text} }}\n")
    }
}

pub(crate) fn with_newline(text: &[u8]) -> Vec<u8> {
    let mut text = text.to_vec();
    text.push(b'\n');
    text
}

/// The switches of a call, but for the output.
pub fn switches(framing: Framing, size: Size, antialias: Option<Antialias>) -> Vec<String> {
    let mut args = Vec::new();
    match framing {
        Framing::Full => args.extend([format!("+W{}", size.width), format!("+H{}", size.height)]),
        Framing::Crop { padded, cut } => {
            args.extend([
                format!("+W{}", padded.width),
                format!("+H{}", padded.height),
            ]);
            // An end that is the picture's own is left out: 1 would be read as
            // a share of the whole.
            if cut != padded {
                args.extend([format!("+EC{}", cut.width), format!("+ER{}", cut.height)]);
            }
        }
    }
    match antialias {
        None => args.push("-A".into()),
        Some(a) => args.extend([
            format!("+A{}", crate::number::number(a.threshold)),
            "+AM1".into(),
            format!("+R{}", a.depth),
            "-J".into(),
        ]),
    }
    args
}

/// The part of a crop picture that belongs to a window.
pub fn in_crop(window: Window) -> Window {
    Window {
        x: 0,
        y: 0,
        ..window
    }
}

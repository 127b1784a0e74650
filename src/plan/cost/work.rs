//! What a period makes the renderer and decor do: plain counts, no seconds.
//!
//! All that is ever asked of the renderer is listed in one function,
//! [`Work::of`]: a new pass is a line there.

use std::collections::{HashMap, HashSet};

use super::coverage::Coverage;
use super::pass::{Parsed, Pass, PassTotal};
use crate::casters::casters;
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::plan::{FramePlan, Mode, Period, Wishes, seen_in};
use crate::segmentation::Class;
use crate::stage::Stage;
use decor_api::{Csg, Geometry, Optics, PrototypeId, Size, Window};

/// One picture that the renderer is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// What it is for.
    pub pass: Pass,
    /// Pixels that are asked for.
    pub pixels: f64,
    /// Of these, pixels that show an object: an estimate.
    pub covered: f64,
    /// The window around them. Windows of one call are rendered as large as the
    /// largest of them.
    pub window: (u32, u32),
    /// Are the pixels blocks in a picture of full size?
    pub masked: bool,
    /// Pixels of the picture as the renderer holds it.
    pub canvas: f64,
    /// What is read first.
    pub parsed: Parsed,
}

impl Picture {
    /// It will have so many pixels, wherever they lie.
    fn spread(&mut self, pixels: f64, whole: Window) {
        let share = if self.pixels > 0.0 {
            self.covered / self.pixels
        } else {
            1.0
        };
        self.covered = share * pixels;
        self.pixels = pixels;
        self.window = (whole.width, whole.height);
    }
}

/// What is done for one frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameWork {
    /// What the renderer is asked for.
    pub pictures: Vec<Picture>,
    /// Pixels that decor merges by depth.
    pub merged: f64,
    /// Pixels that it encodes as colours of the file.
    pub encoded: f64,
    /// Pixels of the file that it compresses and writes.
    pub written: f64,
}

/// What a period makes the renderer and decor do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Work {
    /// The pictures that its frames wait for, each a call of its own that may
    /// use every core: the décor, what it is dissolved into.
    pub ground: Vec<Picture>,
    /// Pixels of the ground that decor encodes.
    pub ground_encoded: f64,
    /// Its frames.
    pub frames: Vec<FrameWork>,
    /// Pixels of a frame.
    pub size_pixels: f64,
}

/// Frames of a period whose coverage is worked out; the others are like the one
/// before them.
const SAMPLED: usize = 12;

impl Work {
    /// The work of a period.
    pub fn of(stage: &Stage, period: &Period, wishes: &Wishes) -> Self {
        let survey = Survey::of(stage, period, wishes);
        let size = stage.size();
        let whole = size.window();
        let mut work = Self {
            size_pixels: size.pixels() as f64,
            ..Self::default()
        };
        let first = stage.film.frame(period.start);
        let layered = period.frames.iter().any(|f| *f != FramePlan::Whole);
        if period.has_decor() && layered {
            let mut seen = survey.seen(&first, |object| !survey.is_fast(object));
            let drawn = |object: &ObjectState<'_>| !survey.is_fast(object);
            let resting = |object: &ObjectState<'_>| period.resting.contains(&object.id);
            survey.read_casters(&mut seen, &first, drawn, resting);
            work.ground.push(seen.picture(Pass::Decor, whole));
            let with_depth = period.needs_depth() || wishes.with_depth;
            if with_depth {
                work.ground.push(seen.picture(Pass::DecorDepth, whole));
            }
            work.ground_encoded = size.pixels() as f64;
            if let Some(antialias) = stage.antialias()
                && period.replaces_boxes()
                && period.still
            {
                // The depth of the samples.
                let times = f64::from(antialias.depth * antialias.depth);
                let mut picture = seen.picture(Pass::DecorDepth, whole);
                picture.pixels *= times;
                picture.covered *= times;
                picture.canvas *= times;
                work.ground.push(picture);
            }
            if period.by_map() {
                // Without light, and with each.
                for _ in 0..=first.lights.len() {
                    work.ground.push(seen.picture(Pass::Decor, whole));
                }
            }
            if period.dissolve_until.is_some() {
                // What the next décor shows as well is rendered once for both.
                let share = target_share(period);
                let mut target = vec![seen.picture(Pass::Target, whole)];
                target.extend(with_depth.then(|| seen.picture(Pass::TargetDepth, whole)));
                for picture in &mut target {
                    picture.pixels *= share;
                    picture.covered *= share;
                    picture.canvas *= share;
                }
                if share > 0.0 {
                    work.ground.extend(target);
                }
                work.ground_encoded *= 2.0;
            }
        }
        let stride = period.frames.len().div_ceil(SAMPLED).max(1);
        let mut scene = Seen::nothing(stage);
        let mut fast = Seen::nothing(stage);
        for (k, (number, plan)) in (period.start..).zip(&period.frames).enumerate() {
            if k % stride == 0 {
                let state = stage.film.frame(number);
                // Which of the two is of use may change on the way.
                let rest = &period.frames[k..period.frames.len().min(k + stride)];
                if rest.iter().any(needs_scene) {
                    let seen = rest.iter().find_map(|plan| match plan {
                        FramePlan::Layered {
                            blocks,
                            shadows: None,
                            ..
                        } if !blocks.is_empty() => seen_in(stage, wishes, &state, blocks),
                        _ => None,
                    });
                    scene = survey.seen(&state, |object| {
                        seen.as_ref().is_none_or(|seen| seen.contains(&object.id))
                    });
                }
                if rest.iter().any(needs_fast) {
                    let drawn = |object: &ObjectState<'_>| survey.in_fast_layer(object, &state);
                    fast = survey.seen(&state, drawn);
                    survey.read_casters(&mut fast, &state, drawn, |o| !drawn(o));
                }
            }
            let mut frame = FrameWork {
                written: size.pixels() as f64,
                ..FrameWork::default()
            };
            match plan {
                FramePlan::Whole => {
                    frame.pictures.push(scene.picture(Pass::Whole, whole));
                    if wishes.with_depth {
                        frame.pictures.push(scene.picture(Pass::WholeDepth, whole));
                    }
                    frame.encoded = size.pixels() as f64;
                }
                FramePlan::Layered {
                    fast: windows,
                    blocks,
                    sky,
                    shadows,
                } => {
                    if *sky {
                        frame
                            .pictures
                            .push(Seen::nothing(stage).picture(Pass::Sky, whole));
                        frame.merged += size.pixels() as f64;
                    }
                    for &window in windows {
                        frame.pictures.push(fast.picture(Pass::Fast, window));
                        if !period.before {
                            frame.pictures.push(fast.picture(Pass::FastDepth, window));
                        }
                        frame.merged += window.pixels() as f64;
                    }
                    let by_map = shadows.is_some_and(|shadows| shadows.by_map);
                    if !blocks.is_empty() || shadows.is_some() && !by_map {
                        let windows: Vec<Window> = blocks.runs().collect();
                        let mut picture = scene.blocks(&windows);
                        if let Some(shadows) = shadows.filter(|_| !by_map) {
                            picture.spread(shadows.expected_pixels, whole);
                        }
                        frame.pictures.push(picture);
                    }
                    if let Some(shadows) = shadows.filter(|_| by_map) {
                        let mut picture = fast.picture(Pass::Shadow, whole);
                        let points = shadows.expected_pixels - blocks.pixels() as f64;
                        picture.pixels = points.max(0.0) * first.lights.len() as f64;
                        picture.covered = 0.0;
                        picture.canvas = picture.pixels;
                        frame.pictures.push(picture);
                    }
                    let patched: f64 = frame
                        .pictures
                        .iter()
                        .filter(|picture| !picture.pass.is_depth())
                        .map(|picture| picture.pixels)
                        .sum();
                    frame.encoded = patched;
                    if patched == 0.0 && period.dissolve_until.is_none() {
                        // The décor's own file, again.
                        frame.written = 0.0;
                    }
                }
            }
            work.frames.push(frame);
        }
        work
    }

    /// The sums by pass, of the passes that there are.
    pub fn totals(&self) -> Vec<(Pass, PassTotal)> {
        let mut sums: HashMap<Pass, PassTotal> = HashMap::new();
        let pictures = self.frames.iter().flat_map(|frame| &frame.pictures);
        for picture in self.ground.iter().chain(pictures) {
            let sum = sums.entry(picture.pass).or_default();
            sum.pictures += 1;
            sum.pixels += picture.pixels;
            sum.covered += picture.covered;
            sum.instances += picture.parsed.instances;
            sum.bytes += picture.parsed.bytes;
        }
        let sums = Pass::ALL
            .into_iter()
            .filter_map(|pass| Some((pass, *sums.get(&pass)?)));
        sums.collect()
    }
}

/// How much of a décor a target costs: what the next décor shows as well is
/// rendered once, and nobody knows yet what that is. As a rule, the next period
/// keeps about what this one keeps.
fn target_share(period: &Period) -> f64 {
    let fast = period.count(Class::Fast) as f64;
    (2.0 * fast / period.objects.len().max(1) as f64).min(1.0)
}

fn needs_scene(plan: &FramePlan) -> bool {
    match plan {
        FramePlan::Whole => true,
        FramePlan::Layered {
            blocks, shadows, ..
        } => !blocks.is_empty() || shadows.is_some(),
    }
}

fn needs_fast(plan: &FramePlan) -> bool {
    matches!(plan, FramePlan::Layered { fast, .. } if !fast.is_empty())
}

/// Some objects of a frame: where they are seen, and what it takes to read them.
pub struct Seen {
    size: Size,
    masks_in_crops: bool,
    coverage: Coverage,
    parsed: Parsed,
    /// The descriptions that are read.
    read: HashSet<PrototypeId>,
}

impl Seen {
    /// No object.
    pub fn nothing(stage: &Stage) -> Self {
        let size = stage.size();
        Self {
            size,
            masks_in_crops: stage.adapter.abilities().masks_in_crops,
            coverage: Coverage::none(size),
            parsed: Parsed::default(),
            read: HashSet::new(),
        }
    }

    /// Where they are seen.
    pub fn coverage(&self) -> &Coverage {
        &self.coverage
    }

    /// A window of them.
    pub fn picture(&self, pass: Pass, window: Window) -> Picture {
        debug_assert!(window.right() <= self.size.width);
        Picture {
            pass,
            pixels: window.pixels() as f64,
            covered: self.coverage.of(window),
            window: (window.width, window.height),
            masked: false,
            canvas: self.canvas(window),
            parsed: self.parsed,
        }
    }

    /// A window's picture has powers of two as its sides, the whole one its own.
    fn canvas(&self, window: Window) -> f64 {
        if window == self.size.window() {
            return self.size.pixels() as f64;
        }
        let side = |pixels: u32| f64::from(pixels.next_power_of_two());
        side(window.width) * side(window.height)
    }

    /// Blocks of them.
    pub fn blocks(&self, windows: &[Window]) -> Picture {
        let around = windows.iter().copied().fold(Window::EMPTY, Window::union);
        // A crop around them, where that is smaller by half.
        let (crop, whole) = (self.canvas(around), self.size.pixels() as f64);
        Picture {
            pass: Pass::Blocks,
            pixels: windows.iter().map(|w| w.pixels() as f64).sum(),
            covered: windows.iter().map(|&w| self.coverage.of(w)).sum(),
            window: (around.width, around.height),
            masked: true,
            canvas: if self.masks_in_crops && 2.0 * crop <= whole {
                crop
            } else {
                whole
            },
            parsed: self.parsed,
        }
    }
}

/// A period's classes, with what is needed to count objects.
pub struct Survey<'a> {
    stage: &'a Stage,
    classes: HashMap<ObjectId, Class>,
    /// Are optical objects drawn with the full scene, and not in a layer?
    optical_in_blocks: bool,
    /// Do shadows matter to the mode?
    casts: bool,
    bytes: HashMap<PrototypeId, f64>,
}

impl<'a> Survey<'a> {
    /// The survey of a period.
    pub fn of(stage: &'a Stage, period: &Period, wishes: &Wishes) -> Self {
        let table = &stage.library.table;
        Self {
            stage,
            classes: period.objects.iter().map(|o| (o.object, o.class)).collect(),
            optical_in_blocks: stage.adapter.abilities().optics
                && wishes.mode != Mode::Preview
                && !wishes.with_depth,
            casts: wishes.mode != Mode::Preview,
            bytes: table
                .iter()
                .map(|(id, prototype)| (id, description_bytes(&prototype.geometry)))
                .collect(),
        }
    }

    /// What its description takes to read.
    pub fn bytes_of(&self, object: &ObjectState<'_>) -> f64 {
        let id = self.stage.prototype_id(object);
        self.bytes.get(&id).copied().unwrap_or(0.0)
    }

    /// Is it rendered in every frame?
    pub fn is_fast(&self, object: &ObjectState<'_>) -> bool {
        self.classes
            .get(&object.id)
            .is_some_and(|class| !class.in_decor())
    }

    /// Is it drawn in a fast layer?
    pub fn in_fast_layer(&self, object: &ObjectState<'_>, state: &FrameState<'_>) -> bool {
        if !self.is_fast(object) {
            return false;
        }
        let prototype = self.stage.prototype(object);
        if self.optical_in_blocks && prototype.optics != Optics::Opaque {
            return false;
        }
        state.shadows || self.stage.is_in_view(object, &state.camera)
    }

    /// Adds what only casts shadows on what is `drawn` to what is read with it.
    pub fn read_casters(
        &self,
        seen: &mut Seen,
        state: &FrameState<'_>,
        drawn: impl Fn(&ObjectState<'_>) -> bool,
        unseen: impl Fn(&ObjectState<'_>) -> bool,
    ) {
        if self.casts {
            for object in casters(self.stage, state, drawn, unseen) {
                self.read(seen, object);
            }
        }
    }

    /// Those objects of a frame that `select` takes.
    pub fn seen(
        &self,
        state: &FrameState<'_>,
        mut select: impl FnMut(&ObjectState<'_>) -> bool,
    ) -> Seen {
        let mut seen = Seen::nothing(self.stage);
        for object in state.objects.iter().filter(|object| select(object)) {
            let id = self.stage.prototype_id(object);
            let bounds = self.stage.library.table.get(id).bounds;
            seen.coverage
                .add(&bounds.posed(&object.pose), &state.camera);
            self.read(&mut seen, object);
        }
        seen
    }

    /// An object is read, and its description where no other has it.
    fn read(&self, seen: &mut Seen, object: &ObjectState<'_>) {
        seen.parsed.instances += 1.0;
        if seen.read.insert(self.stage.prototype_id(object)) {
            seen.parsed.bytes += self.bytes_of(object);
        }
    }
}

/// What a description takes to read: the bytes of its text, or of the text that
/// an adapter would write, roughly. What a byte costs is measured.
pub fn description_bytes(geometry: &Geometry) -> f64 {
    const NODE_BYTES: f64 = 60.0;
    const TRIANGLE_BYTES: f64 = 40.0;
    fn tree(csg: &Csg) -> f64 {
        let own = match csg {
            Csg::Mesh(mesh) => TRIANGLE_BYTES * mesh.triangles.len() as f64,
            _ => NODE_BYTES,
        };
        own + csg.children().into_iter().map(tree).sum::<f64>()
    }
    match geometry {
        Geometry::Neutral(csg) => tree(csg),
        Geometry::Fragment(fragment) => fragment.file.text.len() as f64,
    }
}

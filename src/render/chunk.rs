//! The frames of a period, a chunk at a time: the calls behind them.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use decor_api::{AdapterError, LayerRequest, LayerShot, Optics, Output, Region, Scene, Window};

use super::RenderError;
use super::called::{Called, Calls};
use super::execution::{Execution, join};
use super::ground::PeriodGround;
use super::influenced::Blocks;
use super::shading::Shades;
use crate::film::{FrameState, ObjectId, ObjectState};
use crate::plan::{BlockSet, FramePlan, Mode, Period, chunk_lengths, gathered, seen_in};
use crate::probe::cores;

/// Passes of a chunk, in the order in which they are laid onto a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Pass {
    Whole,
    WholeDepth,
    Sky,
    Fast,
    FastDepth,
    Blocks,
}

impl Execution<'_> {
    /// The chunks of a period: few enough frames that all jobs have one, and
    /// that their layers fit into memory.
    pub fn chunks(&self, period: &Period) -> Vec<Range<u32>> {
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
        let calls = period.frames.iter().any(|frame| !frame.is_decor());
        let parts = if calls { self.jobs } else { cores() };
        let pixels = self.stage.size().pixels() as f64;
        let whole = period.whole.as_ref().map(|_| pixels);
        let mut lengths = chunk_lengths(left.len(), heaviest as f64, parts, whole).into_iter();
        let mut length = 1;
        let mut chunks: Vec<Range<u32>> = Vec::new();
        for number in left {
            match chunks.last_mut() {
                Some(chunk) if chunk.end == number && chunk.len() < length => chunk.end += 1,
                _ => {
                    // Where frames are skipped, there may be more chunks than lengths.
                    length = lengths.next().unwrap_or(length);
                    chunks.push(number..number + 1);
                }
            }
        }
        chunks
    }

    fn held_pixels(&self, frame: &FramePlan) -> usize {
        match frame {
            FramePlan::Whole => self.stage.size().pixels(),
            FramePlan::Layered {
                fast,
                blocks,
                sky,
                shadows,
            } => {
                let blocks = match shadows {
                    // They are not known yet, and read one frame at a time.
                    Some(shadows) => shadows.expected_pixels as usize,
                    None => blocks.runs().fold(Window::EMPTY, Window::union).pixels(),
                };
                let fast: usize = fast.iter().map(|window| window.pixels()).sum();
                let sky = if *sky { self.stage.size().pixels() } else { 0 };
                2 * fast + blocks + sky
            }
        }
    }

    /// Renders, merges and writes some frames of a period. `ground` waits for its
    /// décor: it is called when the frames' own layers are there. Where the
    /// décor failed, nothing is written; that error is told elsewhere.
    pub fn chunk<'g>(
        &self,
        period: &Period,
        frames: Range<u32>,
        ground: impl FnOnce() -> Option<&'g PeriodGround>,
    ) -> Result<(), RenderError> {
        if self.run.is_cancelled() {
            return Err(AdapterError::Cancelled.into());
        }
        let mut ground = Some(ground);
        // Where shadows fall is known when the décor is; what it hides, too.
        let early = if self.needs_ground_first(period, frames.clone())
            || self.may_hide(period, frames.clone())
        {
            match ground.take().and_then(|wait| wait()) {
                Some(ground) => Some(ground),
                None => return Ok(()),
            }
        } else {
            None
        };
        let (mut blocks, mut masks) = (Blocks::new(), HashMap::new());
        for number in frames.clone() {
            let (set, mask) = self.blocks_of(period, number, early);
            blocks.insert(number, set);
            masks.extend(mask.map(|mask| (number, mask)));
        }
        tracing::debug!(
            ?frames,
            blocks = ?blocks.values().map(|b| b.numbers().len()).collect::<Vec<_>>(),
            "influenced"
        );
        let shades = match early {
            Some(ground) => self.shades(period, frames.clone(), ground, &masks, &blocks)?,
            None => Shades::new(),
        };
        let shots = self.shots(period, frames.clone(), &blocks, early);
        let requests = self.requests(shots, frames.start);
        let mut calls = self.called(&requests, &blocks)?;
        let Some(ground) = early.or_else(|| ground.take().and_then(|wait| wait())) else {
            return Ok(());
        };
        for number in frames {
            let _hand = self.hands.take();
            self.frame(ground, number, &mut calls, &blocks, shades.get(&number))?;
        }
        Ok(())
    }

    /// What the renderer is to draw, by pass.
    fn shots(
        &self,
        period: &Period,
        frames: Range<u32>,
        blocks: &Blocks,
        ground: Option<&PeriodGround>,
    ) -> BTreeMap<Pass, Vec<LayerShot>> {
        let fast_objects = fast_objects(period);
        let mut shots: BTreeMap<Pass, Vec<LayerShot>> = BTreeMap::new();
        for number in frames {
            let state = self.stage.film.frame(number);
            let mut add = |pass: Pass, scene: &Arc<Scene>, region: Region| {
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
                FramePlan::Layered { fast, sky, .. } => {
                    if *sky {
                        let scene = Arc::new(self.stage.scene(&state, |_| false));
                        let all = Region::Window(self.stage.size().window());
                        add(Pass::Sky, &scene, all);
                    }
                    if !fast.is_empty() {
                        let (seen, windows) = self.seen(&state, &fast_objects, fast, ground);
                        let scene = Arc::new(self.fast_scene(&state, &seen));
                        for window in windows {
                            add(Pass::Fast, &scene, Region::Window(window));
                            if !period.before {
                                add(Pass::FastDepth, &scene, Region::Window(window));
                            }
                        }
                    }
                    if let Some(blocks) = blocks.get(&number).filter(|b| !b.is_empty()) {
                        let seen = seen_in(self.stage, &self.plan.wishes, &state, blocks);
                        let spared = self.spared_in(ground, period, &state, blocks);
                        tracing::debug!(number, spared = spared.len(), "spared");
                        let scene = self.stage.scene(&state, |object| {
                            let is_seen = seen.as_ref().is_none_or(|s| s.contains(&object.id));
                            is_seen && !spared.contains(&object.id)
                        });
                        let scene = Arc::new(scene);
                        for region in self.stage.regions(blocks) {
                            add(Pass::Blocks, &scene, region);
                        }
                    }
                }
            }
        }
        shots
    }

    /// The fast objects that the décor does not hide, and the windows in which they
    /// are rendered: of those that are planned, or where some are hidden, fewer.
    fn seen(
        &self,
        state: &FrameState<'_>,
        fast: &HashSet<ObjectId>,
        planned: &[Window],
        ground: Option<&PeriodGround>,
    ) -> (HashSet<ObjectId>, Vec<Window>) {
        let hidden = ground.map(|ground| self.behind(state, fast, ground));
        let hidden = hidden.unwrap_or_default();
        if hidden.is_empty() {
            return (fast.clone(), planned.to_vec());
        }
        let seen: HashSet<ObjectId> = fast.difference(&hidden).copied().collect();
        let objects = state.objects.iter().filter(|o| seen.contains(&o.id));
        let objects = objects.filter(|object| self.belongs_to_layer(object, state));
        let needed = objects.map(|object| self.stage.window(object, &state.camera));
        // Nothing but what was planned: who is drawn in blocks has no window.
        let needed = needed.flat_map(|needed| {
            let parts = planned
                .iter()
                .map(move |&window| window.intersection(needed));
            parts.filter(|part| !part.is_empty())
        });
        let needed: Vec<Window> = needed.collect();
        let antialiased = state.antialias.is_some();
        (seen, gathered(&needed, self.stage.size(), antialiased))
    }

    /// The fast objects of a frame by themselves, and with them, unseen, all that
    /// may shade them.
    fn fast_scene(&self, state: &FrameState<'_>, fast: &HashSet<ObjectId>) -> Scene {
        let mut drawn: HashSet<ObjectId> = HashSet::new();
        let mut scene = self.stage.scene(state, |object| {
            let belongs = fast.contains(&object.id) && self.belongs_to_layer(object, state);
            if belongs {
                drawn.insert(object.id);
            }
            belongs
        });
        scene.hidden = self.hidden(state, &drawn, |object| !drawn.contains(&object.id));
        scene
    }

    /// Is a fast object drawn in the fast layer? Not where it is out of view
    /// and casts nothing, nor where its blocks are drawn from the full scene.
    fn belongs_to_layer(&self, object: &ObjectState<'_>, state: &FrameState<'_>) -> bool {
        let prototype = self.stage.prototype(object);
        let drawn_in_blocks = prototype.optics != Optics::Opaque
            && self.stage.adapter.abilities().optics
            && self.plan.wishes.mode != Mode::Preview
            && !self.with_depth();
        if drawn_in_blocks {
            return false;
        }
        state.shadows || self.stage.is_in_view(object, &state.camera)
    }

    /// The calls that some shots make, with their passes.
    fn requests(
        &self,
        shots: BTreeMap<Pass, Vec<LayerShot>>,
        first: u32,
    ) -> Vec<(Pass, LayerRequest<'_>)> {
        let mut requests = Vec::new();
        for (pass, shots) in shots {
            for (group, shots) in grouped(shots).into_iter().enumerate() {
                requests.push((pass, self.request(pass, shots, first, group)));
            }
        }
        requests
    }

    /// The calls of a chunk, side by side.
    fn called<'r>(
        &'r self,
        requests: &'r [(Pass, LayerRequest<'r>)],
        blocks: &Blocks,
    ) -> Result<Calls<'r>, RenderError> {
        let results: Vec<_> = std::thread::scope(|scope| {
            let running: Vec<_> = requests
                .iter()
                .map(|(pass, request)| {
                    // The others are merged.
                    let encoded = matches!(pass, Pass::Whole | Pass::Blocks);
                    scope.spawn(move || self.call_to_read(request, encoded, self.threads))
                })
                .collect();
            running.into_iter().map(join).collect()
        });
        let mut called = Vec::new();
        for (result, (pass, request)) in results.into_iter().zip(requests) {
            let counter = match pass {
                Pass::Whole => &self.traced.whole,
                Pass::Sky | Pass::Fast => &self.traced.fast,
                Pass::Blocks => &self.traced.blocks,
                Pass::WholeDepth | Pass::FastDepth => &self.traced.depth,
            };
            let pixels = request.shots.iter().map(|shot| match &shot.region {
                Region::Window(window) => window.pixels(),
                Region::Blocks(_) => blocks.get(&shot.frame).map_or(0, BlockSet::pixels),
            });
            counter.fetch_add(pixels.sum::<usize>() as u64, Ordering::Relaxed);
            called.push(Called {
                pass: *pass,
                request,
                left: result?,
            });
        }
        Ok(Calls(called))
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
            Pass::Sky => (Output::ColourOverBackground, "sky"),
            Pass::Fast => (Output::ColourAlone { with_sky: sky }, "fast"),
            Pass::FastDepth => (Output::Depth, "fast_depth"),
            Pass::Blocks => (Output::ColourOverBackground, "blocks"),
        };
        // Whole frames may go by a clock, in an object or a declaration.
        let consecutive = shots
            .windows(2)
            .all(|pair| pair[1].frame == pair[0].frame + 1);
        let film = self.stage.span();
        let film = film.filter(|_| pass == Pass::Whole && consecutive);
        LayerRequest {
            prototypes: &self.stage.library.table,
            size: self.stage.size(),
            output,
            antialias: self.stage.antialias(),
            shots,
            film,
            label: format!("{label}_{frame:04}_{group}"),
        }
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

//! Plain animations by coherence: what is the same in several frames is traced
//! once, and every frame is the one that POV-Ray alone would have given.
//!
//! ```text
//! text → Look (what moves; why not)
//! two frames whole → Costs: may it pay?
//! the middle frame: boxes, a sample of its blocks: does it promise to?
//! boxes → geometry, proxies (masks) → the dirty blocks of each frame
//! a frame both ways: the same? → what all frames would cost (price)
//! sources (frames that trace for others) → the rest
//! ```
//!
//! At every step frames may turn out to be better rendered whole; then what is
//! left is. The two frames are finished ones in any case.

mod masks;
mod price;

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use decor_api::{AdapterError, RunContext};
use decor_povray::PovRay;
use decor_povray::plain::{Part, PlainScene};
use decor_povray::unedited::{
    self, Analysis, Blocks, Finished, FrameBoxes, Placed, Refusal, Schedule, Sources, Traced,
    schedule,
};

use super::delivery::Delivery;
use super::pace::Pace;
use super::pool::{Workers, pool, side_by_side};
use super::{Done, workers};
use crate::render::RenderError;
use masks::{Finding, Masks};

pub use price::{Costs, Price};

/// A scene's text, looked at.
#[derive(Clone, Debug)]
pub struct Look {
    /// The files.
    pub sources: Sources,
    /// What they say of motion.
    pub analysis: Analysis,
    /// Why all frames are rendered whole; empty: they need not be.
    pub whole: Vec<Refusal>,
}

impl Look {
    /// Looks at a scene.
    ///
    /// # Errors
    /// [`AdapterError::Io`] where the scene cannot be read.
    pub fn at(povray: &PovRay, scene: &PlainScene) -> Result<Self, AdapterError> {
        let sources = Sources::read(povray, scene)?;
        let options = unedited::Options::of(scene);
        let analysis = unedited::analyse(&sources, &options);
        let mut whole = scene.refusals(povray, &sources);
        for refusal in &analysis.whole {
            if !whole.contains(refusal) {
                whole.push(refusal.clone());
            }
        }
        Ok(Self {
            sources,
            analysis,
            whole,
        })
    }
}

/// What a plan says of coherence.
#[derive(Clone, Debug, Default)]
pub struct Forecast {
    /// Why all frames are rendered whole; empty: they need not be.
    pub whole: Vec<String>,
    /// The share of blocks that may change from frame to frame.
    pub dirty: Option<f64>,
    /// Why geometry does not tell that.
    pub proxies_only: Option<String>,
    /// What frames cost, where some were rendered to know.
    pub costs: Option<Costs>,
    /// All frames whole, and by coherence.
    pub prices: Option<(Price, Price)>,
}

/// No state files of a part may be larger than this, in bytes.
const PART_BYTES: u64 = 256 << 20;

/// A number of a state file takes four bytes, a pixel five numbers.
const PIXEL_BYTES: u64 = 20;

/// A film that is rendered by coherence.
struct Film<'a> {
    povray: &'a PovRay,
    scene: &'a PlainScene,
    look: &'a Look,
    frames: Vec<u32>,
    workers: Workers,
    run: &'a RunContext,
}

/// Two frames, rendered whole.
struct Trial {
    /// Which ones, of the film's.
    frames: [usize; 2],
    /// What they gave.
    traced: Vec<Traced>,
    costs: Costs,
}

impl Trial {
    /// The state file of the k-th.
    fn blocks(&self, k: usize) -> Option<&PathBuf> {
        self.traced.get(k)?.blocks.first().map(|(_, file)| file)
    }
}

/// What is said instead of a result: why the rest is rendered whole.
enum Found<T> {
    This(T),
    Whole(Vec<String>),
}

impl Film<'_> {
    /// Renders the first and the middle frame whole.
    fn trial(&self) -> Result<Trial, RenderError> {
        let frames = [0, self.frames.len() / 2];
        let own = measured(self.run);
        let traced = side_by_side(&frames, self.workers.busy(), |at| {
            self.trace_one(self.frames[*at], &Finished::default(), None, &own)
        });
        add(&own, self.run);
        let traced = traced?;
        let sum = |of: fn(&Traced) -> f64| traced.iter().map(of).sum::<f64>();
        let costs = Costs::of(
            sum(|t| t.timing.parse_s),
            sum(|t| t.timing.trace_s),
            own.tally.cpu().as_secs_f64(),
            frames.len(),
            frames.len(),
        );
        Ok(Trial {
            frames,
            traced,
            costs,
        })
    }

    /// A frame in a call of its own; these blocks of it, or all.
    fn trace_one(
        &self,
        frame: u32,
        finished: &Finished,
        blocks: Option<&Blocks>,
        run: &RunContext,
    ) -> Result<Traced, RenderError> {
        let all = Blocks::all(self.scene.grid());
        let state = |_| finished.state(blocks.unwrap_or(&all));
        Ok(self.scene.trace(one(frame), &state, run)?)
    }

    /// Where everything is, in each of these frames.
    fn boxes(&self, frames: &[u32]) -> Result<Found<Vec<FrameBoxes>>, RenderError> {
        let step = self.scene.frames.step;
        let parts = runs(frames, step, frames.len().div_ceil(self.workers.all()));
        let asked = side_by_side(&parts, self.workers.all(), |part| {
            let (scene, look) = (self.scene, self.look);
            let (sources, analysis) = (&look.sources, &look.analysis);
            unedited::boxes(self.povray, scene, sources, analysis, *part, self.run)
        })?;
        let whole: BTreeSet<String> = asked
            .iter()
            .flat_map(|boxes| boxes.whole.iter().map(ToString::to_string))
            .collect();
        if !whole.is_empty() {
            return Ok(Found::Whole(whole.into_iter().collect()));
        }
        let mut found: BTreeMap<u32, FrameBoxes> = BTreeMap::new();
        for boxes in asked {
            found.extend(boxes.frames.into_iter().map(|frame| (frame.frame, frame)));
        }
        let boxes = frames.iter().map(|frame| found.remove(frame));
        let Some(boxes) = boxes.collect::<Option<Vec<FrameBoxes>>>() else {
            let reason = "POV-Ray did not say where things are";
            return Ok(Found::Whole(vec![reason.into()]));
        };
        // Each part was looked at by itself.
        let still = |frame: &FrameBoxes| -> Vec<Placed> {
            let statements = &self.look.analysis.statements;
            let all = frame.objects.iter();
            all.filter(|o| statements.get(o.statement).is_some_and(|s| !s.moves))
                .copied()
                .collect()
        };
        let first = boxes.first().map(still).unwrap_or_default();
        if boxes.iter().any(|frame| still(frame) != first) {
            let reason = "what does not move is not always in one place";
            return Ok(Found::Whole(vec![reason.into()]));
        }
        Ok(Found::This(boxes))
    }

    /// The share of blocks that is dirty in the middle frame, by some of them: it
    /// costs little, and often says that all the rest is not worth while. Also the
    /// pixels that were traced to know.
    fn sounding(&self) -> Result<Found<(f64, u64)>, RenderError> {
        let middle = [self.frames[self.frames.len() / 2]];
        let boxes = match self.boxes(&middle)? {
            Found::This(boxes) => boxes,
            Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
        };
        let (finding, masks) =
            Finding::by_geometry(self.scene, self.look, &boxes, self.workers, self.run);
        let (share, pixels) = finding.sample(&masks)?;
        tracing::debug!(share, "sounding");
        Ok(Found::This((share, pixels)))
    }

    /// Does coherence pay for so many frames of which this share is dirty?
    fn promises(&self, costs: &Costs, share: f64, frames: usize) -> bool {
        let asked = Price::of(frames, costs.asked_s(), &self.workers);
        let proxies = Price::of(1, costs.whole_s(), &self.workers);
        let rest = Price::of(frames, costs.partial_s(share), &self.workers);
        let stock = Price::of(frames, costs.whole_s(), &self.workers);
        asked.and(proxies).and(rest).beats(&stock)
    }

    /// The dirty blocks of each frame.
    fn masks(
        &self,
        boxes: &[FrameBoxes],
        costs: Option<(&Costs, bool)>,
    ) -> Result<Found<Masks>, RenderError> {
        let (finding, mut masks) =
            Finding::by_geometry(self.scene, self.look, boxes, self.workers, self.run);
        if let Some((costs, at_least_once)) = costs {
            match finding.by_proxies(&mut masks, costs, at_least_once) {
                Err(RenderError::Adapter(
                    error @ (AdapterError::Failed { .. } | AdapterError::BadOutput { .. }),
                )) => {
                    // The scene itself was rendered: the copy is at fault.
                    let reason = format!("proxies could not be rendered: {error}");
                    return Ok(Found::Whole(vec![reason]));
                }
                other => other?,
            }
        }
        Ok(Found::This(masks))
    }

    /// What the frames that are not in `trial` cost by coherence; `dirtier` is what
    /// a dirty block costs, in average blocks.
    fn price(&self, costs: &Costs, plan: &Schedule, dirtier: f64) -> Price {
        let blocks = self.scene.grid().count() as f64;
        let of = |list: &[(usize, Blocks)]| {
            let traced: usize = list.iter().map(|(_, blocks)| blocks.len()).sum();
            let share = traced as f64 / (list.len().max(1) as f64 * blocks);
            let each_s = costs.partial_s((share * dirtier).min(1.0));
            Price::of(list.len(), each_s, &self.workers)
        };
        of(&plan.sources).and(of(&plan.rest))
    }
}

/// Renders frames that do not need each other.
pub fn render(
    povray: &PovRay,
    delivery: &Delivery<'_>,
    look: &Look,
    always: bool,
    run: &RunContext,
) -> Result<Done, RenderError> {
    let wanted = &delivery.options.wanted;
    let pixels = u64::from(delivery.scene.size.0) * u64::from(delivery.scene.size.1);
    let mut done = Done::default();
    let film = Film {
        povray,
        scene: delivery.scene,
        look,
        frames: wanted.iter().copied().collect(),
        workers: workers(delivery, wanted.len()),
        run,
    };
    let mut reasons: Vec<String> = look.whole.iter().map(ToString::to_string).collect();
    if reasons.is_empty() && wanted.len() < 3 {
        reasons.push("there are too few frames".into());
    }
    if !reasons.is_empty() {
        super::whole(delivery, wanted, None, run)?;
        done.whole = reasons;
        done.whole_pixels = wanted.len() as u64 * pixels;
        return Ok(done);
    }
    let trial = film.trial()?;
    let mut left = wanted.clone();
    for (frame, file) in trial.traced.iter().flat_map(|traced| &traced.pictures) {
        left.remove(frame);
        delivery.hand_over(*frame, file)?;
    }
    done.whole_pixels = (wanted.len() - left.len()) as u64 * pixels;
    let whole = film.coherent(delivery, &trial, always, &mut done)?;
    if let Found::Whole(reasons) = whole {
        super::whole(delivery, &left, Some(trial.costs.whole_s()), run)?;
        done.whole = reasons;
        done.whole_pixels += left.len() as u64 * pixels;
    }
    Ok(done)
}

impl Film<'_> {
    /// Renders what the trial did not, or says why it is better rendered whole.
    fn coherent(
        &self,
        delivery: &Delivery<'_>,
        trial: &Trial,
        always: bool,
        done: &mut Done,
    ) -> Result<Found<()>, RenderError> {
        let left = self.frames.len() - trial.frames.len();
        tracing::debug!(costs = ?trial.costs, "trial");
        if !always && !price::may_pay(&trial.costs, left, &self.workers) {
            return Ok(Found::Whole(vec![DEAR.into()]));
        }
        if !always {
            let (share, pixels) = match self.sounding()? {
                Found::This(found) => found,
                Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
            };
            done.block_pixels += pixels;
            done.dirty = Some(share);
            if !self.promises(&trial.costs, share, left) {
                return Ok(Found::Whole(vec![DEAR.into()]));
            }
        }
        let boxes = match self.boxes(&self.frames)? {
            Found::This(boxes) => boxes,
            Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
        };
        let masks = match self.masks(&boxes, Some((&trial.costs, always)))? {
            Found::This(masks) => masks,
            Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
        };
        done.block_pixels += masks.pixels;
        done.dirty = Some(masks.share());
        let grid = self.scene.grid();
        let plan = schedule(grid, &masks.dirty, &trial.frames);
        let stock = Price::of(left, trial.costs.whole_s(), &self.workers);
        tracing::debug!(
            dirty = masks.share(),
            traced = plan.traced(),
            sources = plan.sources.len(),
            ?stock,
            price = ?self.price(&trial.costs, &plan, 1.0),
            "masks"
        );
        if !always && !self.price(&trial.costs, &plan, 1.0).beats(&stock) {
            return Ok(Found::Whole(vec![DEAR.into()]));
        }
        let mut finished = Finished::default();
        let clean = |frame: usize| Blocks::all(grid).without(&masks.dirty[frame]);
        for (k, frame) in trial.frames.into_iter().enumerate() {
            if let Some(file) = trial.blocks(k) {
                finished.add(file, &clean(frame))?;
            }
        }
        let dirtier = match self.both_ways(trial, &masks, &finished, done)? {
            Found::This(dirtier) => dirtier,
            Found::Whole(reasons) => return Ok(Found::Whole(reasons)),
        };
        tracing::debug!(dirtier, "a frame both ways");
        if !always && !self.price(&trial.costs, &plan, dirtier).beats(&stock) {
            return Ok(Found::Whole(vec![DEAR.into()]));
        }
        for file in (0..trial.frames.len()).filter_map(|k| trial.blocks(k)) {
            let _ = std::fs::remove_file(file);
        }
        done.block_pixels += self.pixels(plan.sources.iter().chain(&plan.rest));
        let sources = side_by_side(&plan.sources, self.workers.busy(), |(frame, blocks)| {
            let number = self.frames[*frame];
            let traced = self.trace_one(number, &finished, Some(blocks), self.run)?;
            for (frame, file) in &traced.pictures {
                delivery.hand_over(*frame, file)?;
            }
            Ok::<_, RenderError>((*frame, traced))
        })?;
        for (frame, traced) in sources {
            for (_, file) in &traced.blocks {
                finished.add(file, &clean(frame))?;
                let _ = std::fs::remove_file(file);
            }
        }
        self.rest(delivery, &plan, &finished, trial)?;
        Ok(Found::This(()))
    }

    /// Traces what is dirty of a frame that is known whole, and compares: in the
    /// end what a dirty block costs, in average blocks.
    fn both_ways(
        &self,
        trial: &Trial,
        masks: &Masks,
        finished: &Finished,
        done: &mut Done,
    ) -> Result<Found<f64>, RenderError> {
        let grid = self.scene.grid();
        let (Some(first), Some(second)) = (trial.blocks(0), trial.blocks(1)) else {
            return Ok(Found::Whole(vec!["POV-Ray kept no blocks".into()]));
        };
        let [a, b] = trial.frames.map(|frame| &masks.dirty[frame]);
        let clean = Blocks::all(grid).without(&a.or(b));
        let unlike = unedited::differing(first, second, &clean)?;
        if let Some(block) = unlike.iter().next() {
            return Ok(Found::Whole(vec![format!(
                "what does not move is not the same in two frames (block {block})"
            )]));
        }
        let ([_, at], dirty) = (trial.frames, b);
        if dirty.is_empty() {
            return Ok(Found::This(1.0));
        }
        let traced = self.trace_one(self.frames[at], finished, Some(dirty), self.run)?;
        done.block_pixels += self.pixels([&(at, dirty.clone())]);
        for (_, file) in &traced.blocks {
            let unlike = unedited::differing(second, file, dirty)?;
            let _ = std::fs::remove_file(file);
            if let Some(block) = unlike.iter().next() {
                return Ok(Found::Whole(vec![format!(
                    "pixels depend on those that were traced before them (block {block})"
                )]));
            }
        }
        let usual_s = trial.costs.trace_s * dirty.share();
        let took_s = traced.timing.trace_s;
        Ok(Found::This(if usual_s > 0.0 && took_s > 0.0 {
            took_s / usual_s
        } else {
            1.0
        }))
    }

    /// Renders the frames that trace for nobody else.
    fn rest(
        &self,
        delivery: &Delivery<'_>,
        plan: &Schedule,
        finished: &Finished,
        trial: &Trial,
    ) -> Result<(), RenderError> {
        let traced: BTreeMap<u32, &Blocks> = plan
            .rest
            .iter()
            .map(|(frame, blocks)| (self.frames[*frame], blocks))
            .collect();
        let frames: BTreeSet<u32> = traced.keys().copied().collect();
        if frames.is_empty() {
            return Ok(());
        }
        let blocks: usize = traced.values().map(|blocks| blocks.len()).sum();
        let share = blocks as f64 / (frames.len() * self.scene.grid().count()) as f64;
        let pace = Pace::of(Some(trial.costs.partial_s(share)), &self.workers);
        let step = self.scene.frames.step;
        let all = Blocks::all(self.scene.grid());
        pool(
            &frames,
            step,
            self.longest(),
            pace,
            self.workers,
            self.run,
            |first, last| {
                let part = Part {
                    first,
                    last,
                    threads: None,
                };
                let state = |frame| finished.state(traced.get(&frame).copied().unwrap_or(&all));
                let called = self.scene.trace(part, &state, self.run)?;
                for (frame, file) in &called.pictures {
                    delivery.hand_over(*frame, file)?;
                }
                for (_, file) in &called.blocks {
                    let _ = std::fs::remove_file(file);
                }
                Ok(called.pictures.len() as u64)
            },
        )
    }

    /// A part's state files shall fit on the disk.
    fn longest(&self) -> usize {
        let (width, height) = self.scene.size;
        let bytes = u64::from(width) * u64::from(height) * PIXEL_BYTES;
        usize::try_from(PART_BYTES / bytes.max(1))
            .unwrap_or(1)
            .max(1)
    }

    fn pixels<'b>(&self, traced: impl IntoIterator<Item = &'b (usize, Blocks)>) -> u64 {
        let grid = self.scene.grid();
        let blocks = traced.into_iter().flat_map(|(_, blocks)| blocks.iter());
        blocks.map(|block| grid.window(block).pixels() as u64).sum()
    }
}

/// Why frames are rendered whole that need not be.
const DEAR: &str = "whole frames take no longer";

/// What a plan can say: where everything is, what that touches; and with `probe`,
/// which renders two frames, what it costs.
///
/// # Errors
/// What goes wrong with POV-Ray.
pub fn forecast(
    povray: &PovRay,
    scene: &PlainScene,
    look: &Look,
    frames: Vec<u32>,
    most: usize,
    probe: bool,
    run: &RunContext,
) -> Result<Forecast, RenderError> {
    let mut said = Forecast {
        whole: look.whole.iter().map(ToString::to_string).collect(),
        ..Forecast::default()
    };
    if !said.whole.is_empty() || frames.len() < 3 {
        return Ok(said);
    }
    let film = Film {
        povray,
        scene,
        look,
        workers: Workers {
            stated: None,
            most: most.min(frames.len()),
            cores: crate::probe::cores(),
        },
        frames,
        run,
    };
    let trial = if probe { Some(film.trial()?) } else { None };
    said.costs = trial.as_ref().map(|trial| trial.costs);
    if let Some(trial) = &trial {
        let (costs, left) = (&trial.costs, film.frames.len() - trial.frames.len());
        let (share, _) = match film.sounding()? {
            Found::This(found) => found,
            Found::Whole(reasons) => {
                said.whole = reasons;
                return Ok(said);
            }
        };
        said.dirty = Some(share);
        if !price::may_pay(costs, left, &film.workers) || !film.promises(costs, share, left) {
            let whole = Price::of(film.frames.len(), costs.whole_s(), &film.workers);
            said.whole = vec![DEAR.into()];
            said.prices = Some((whole, whole));
            return Ok(said);
        }
    }
    let boxes = match film.boxes(&film.frames)? {
        Found::This(boxes) => boxes,
        Found::Whole(reasons) => {
            said.whole = reasons;
            return Ok(said);
        }
    };
    let masks = match film.masks(&boxes, said.costs.as_ref().map(|costs| (costs, false)))? {
        Found::This(masks) => masks,
        Found::Whole(reasons) => {
            said.whole = reasons;
            return Ok(said);
        }
    };
    said.proxies_only.clone_from(&masks.proxies_only);
    let known = masks.proxies_only.is_none() || masks.pixels > 0;
    said.dirty = known.then(|| masks.share());
    if let Some(trial) = trial {
        let costs = trial.costs;
        let plan = schedule(scene.grid(), &masks.dirty, &trial.frames);
        let all = film.frames.len();
        let stock = Price::of(all, costs.whole_s(), &film.workers);
        let first = Price::of(trial.frames.len(), costs.whole_s(), &film.workers);
        let coherent = first.and(film.price(&costs, &plan, 1.0));
        if !coherent.beats(&stock) {
            said.whole = vec![DEAR.into()];
        }
        said.prices = Some((stock, coherent));
    }
    Ok(said)
}

fn one(frame: u32) -> Part {
    Part {
        first: frame,
        last: frame,
        threads: None,
    }
}

/// The same run, counted apart.
fn measured(run: &RunContext) -> RunContext {
    RunContext {
        tally: std::sync::Arc::default(),
        ..run.clone()
    }
}

/// Adds what was counted apart.
fn add(own: &RunContext, run: &RunContext) {
    let (calls, frames) = own.tally.read();
    for k in 0..calls {
        let frames = if k == 0 { frames } else { 0 };
        run.tally.add_call(usize::try_from(frames).unwrap_or(0));
    }
    run.tally.add_cpu(own.tally.cpu());
}

/// Frames that follow each other, at most so many: their first and last ones.
fn runs(frames: &[u32], step: u32, longest: usize) -> Vec<(u32, u32)> {
    let mut list: Vec<(u32, u32)> = Vec::new();
    let mut length = 0;
    for &frame in frames {
        match list.last_mut() {
            Some((_, last)) if *last + step == frame && length < longest => {
                *last = frame;
                length += 1;
            }
            _ => {
                list.push((frame, frame));
                length = 1;
            }
        }
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_of_frames() {
        assert_eq!(runs(&[1, 2, 3, 4, 5], 1, 2), [(1, 2), (3, 4), (5, 5)]);
        assert_eq!(runs(&[1, 3, 5, 9], 2, 9), [(1, 5), (9, 9)]);
        assert_eq!(runs(&[], 1, 3), []);
    }
}

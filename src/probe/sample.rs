//! The calls of a probe: which pictures, and rendering them.

use std::sync::Arc;
use std::time::Instant;

use decor_api::{
    AdapterError, Layer, LayerRequest, LayerShot, Light, LightKind, Output, Region, Rendered,
    RunContext, Scene, Tally, Window,
};
use nix::time::{ClockId, clock_gettime};

use crate::film::{FrameState, ObjectState};
use crate::plan::{BlockSet, Coverage, FramePlan, Parsed, Pass, Period, Plan, Seen, Survey};
use crate::stage::Stage;

/// The side of a block.
pub const BLOCK: u32 = 32;

/// Pixels of a sample, at least, where the picture has them.
pub const PIXELS: f64 = 32_768.0;

/// At most: more would not be more exact than the rest is.
const MOST_PIXELS: f64 = 65_536.0;

/// Of a film whose pixels take many rays, fewer are enough: it is the rays that take
/// the time that is measured.
const FEWEST_PIXELS: f64 = 8_192.0;

/// Rays that a pixel of a plain scene may take: one seen, one to each of two lights.
const PLAIN_RAYS: f64 = 3.0;

/// The share of the film's pixels that a sample may have.
const SHARE: f64 = 0.004;

/// Blocks are picked out of a picture of full size where that is not much
/// larger than what is picked; windows elsewhere: what the rest of the picture
/// costs is known too roughly to be taken off.
const CANVAS_RATIO: f64 = 3.0;

/// What a call is there to tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// What a call costs, and its pictures: of a scene with next to nothing.
    Empty,
    /// What a picture of full size costs of which next to nothing is traced.
    Canvas,
    /// What reading the full scene costs.
    Read,
    /// What pixels of a pass cost.
    Pixels(Pass),
}

/// A call.
pub struct Sample {
    pub question: Question,
    output: Output,
    shots: Vec<LayerShot>,
    /// The blocks of its only picture, where it is made of blocks.
    blocks: Vec<Window>,
    /// Pixels traced in all pictures.
    pub pixels: f64,
    /// Of these, the ones that show an object.
    pub covered: f64,
    /// Pixels of the pictures as the renderer holds them.
    pub canvas: f64,
    /// What is read, in all pictures.
    pub parsed: Parsed,
}

/// What a call told.
pub struct Measured {
    pub sample: Sample,
    /// Seconds on the clock; other calls ran beside it.
    pub wall_s: f64,
    /// Seconds of CPU of the renderer, for this call alone.
    pub cpu_s: f64,
    /// Seconds of CPU of decor for it: writing the scene, reading the pixels.
    /// A renderer in-process has both in one.
    pub own_s: f64,
    /// What its first shot shows, where that is a part of a whole frame.
    pub picture: Option<Layer>,
}

impl Sample {
    /// Pictures in the call.
    pub fn pictures(&self) -> f64 {
        self.shots.len() as f64
    }

    /// The blocks of its only picture; none where it has windows.
    pub fn blocks(&self) -> Vec<Window> {
        self.blocks.clone()
    }
}

/// The calls of a probe.
pub fn samples(stage: &Stage, plan: &Plan) -> Vec<Sample> {
    let Some(period) = representative(plan) else {
        return Vec::new();
    };
    let size = stage.size();
    let frames = plan.wishes.frames;
    let film = size.pixels() as f64 * (f64::from(frames.1 - frames.0) + 1.0);
    let number = period.start + period.len() / 2;
    let state = stage.film.frame(number);
    let wanted = (SHARE * film).clamp(PIXELS, MOST_PIXELS);
    let wanted = (wanted * PLAIN_RAYS / rays(stage, &state)).clamp(FEWEST_PIXELS, wanted);
    let survey = Survey::of(stage, period, &plan.wishes);
    let asker = Asker {
        stage,
        state: &state,
        number,
        wanted,
        by_blocks: stage.adapter.abilities().block_mask
            && size.pixels() as f64 <= CANVAS_RATIO * wanted,
    };

    let everything = survey.seen(&state, |_| true);
    let scene = Arc::new(stage.scene(&state, |_| true));
    // Without any object a renderer may not even be called.
    let by_bytes = |a: &&ObjectState<'_>, b: &&ObjectState<'_>| {
        survey.bytes_of(a).total_cmp(&survey.bytes_of(b))
    };
    let least = state.objects.iter().min_by(by_bytes).map(|o| o.id);
    let empty = Arc::new(stage.scene(&state, |object| Some(object.id) == least));
    let nothing = Seen::nothing(stage);
    let corner = asker.emptiest_block(everything.coverage());
    let mut samples = vec![
        asker.windows(Question::Empty, &nothing, &empty, &[corner]),
        asker.windows(Question::Empty, &nothing, &empty, &[corner; 3]),
        asker.windows(Question::Read, &everything, &scene, &[corner; 2]),
    ];
    // Where every picture is as large as the frame, all of them tell.
    let can = stage.adapter.abilities();
    if can.block_mask && can.masks_in_crops {
        samples.push(asker.canvas(&everything, &scene));
    }
    let all = asker.all_blocks();
    let depth_scene = survey.seen(&state, |object| !survey.is_fast(object));
    let still = Arc::new(stage.scene(&state, |object| !survey.is_fast(object)));
    samples.extend(asker.pixels(Pass::Whole, &everything, &scene, &all));
    if period.whole.is_none() || plan.wishes.with_depth {
        samples.extend(asker.pixels(Pass::DecorDepth, &depth_scene, &still, &all));
    }
    if let FramePlan::Layered { fast, .. } = &period.frames[(number - period.start) as usize]
        && !fast.is_empty()
    {
        let mut blocks = BlockSet::none(size, BLOCK);
        fast.iter().for_each(|&window| blocks.insert(window));
        let blocks = blocks.numbers();
        let select = |object: &ObjectState<'_>| survey.in_fast_layer(object, &state);
        let seen = survey.seen(&state, select);
        let scene = Arc::new(stage.scene(&state, select));
        samples.extend(asker.pixels(Pass::Fast, &seen, &scene, &blocks));
        samples.extend(asker.pixels(Pass::FastDepth, &seen, &scene, &blocks));
    }
    samples
}

/// About how many rays a pixel may take: the seen one, and one to each sample of each
/// light, as often as antialiasing looks.
fn rays(stage: &Stage, state: &FrameState<'_>) -> f64 {
    let samples = |light: &Light| match light.kind {
        LightKind::Area { nu, nv, .. } => f64::from(nu.max(1)) * f64::from(nv.max(1)),
        _ => 1.0,
    };
    let shadows = if stage.has_shadows(state) {
        state.lights.iter().map(samples).sum()
    } else {
        0.0
    };
    // Most pixels have no edge.
    let looks = if state.antialias.is_some() { 2.0 } else { 1.0 };
    (looks * (1.0 + shadows)).max(PLAIN_RAYS)
}

/// Does a plan have a fast layer to look at?
pub fn shows_layers(plan: &Plan) -> bool {
    representative(plan).is_some_and(|period| says(period).0)
}

/// Has a period a fast layer in its middle, and a décor?
fn says(period: &Period) -> (bool, bool) {
    let middle = &period.frames[period.frames.len() / 2];
    let layered = matches!(middle, FramePlan::Layered { fast, .. } if !fast.is_empty());
    (layered, period.whole.is_none())
}

/// The period that says most: with a décor and a fast layer in its middle,
/// where there is one; of these, the one in the middle of the film.
fn representative(plan: &Plan) -> Option<&Period> {
    let most = plan.periods.iter().map(says).max()?;
    let those: Vec<&Period> = plan.periods.iter().filter(|p| says(p) == most).collect();
    those.get(those.len() / 2).copied()
}

struct Asker<'a> {
    stage: &'a Stage,
    state: &'a FrameState<'a>,
    number: u32,
    wanted: f64,
    by_blocks: bool,
}

impl Asker<'_> {
    fn all_blocks(&self) -> Vec<u32> {
        let mut blocks = BlockSet::none(self.stage.size(), BLOCK);
        blocks.insert(self.stage.size().window());
        blocks.numbers()
    }

    fn columns(&self) -> u32 {
        self.stage.size().width.div_ceil(BLOCK)
    }

    fn block(&self, number: u32) -> Window {
        let block = Window {
            x: number % self.columns() * BLOCK,
            y: number / self.columns() * BLOCK,
            width: BLOCK,
            height: BLOCK,
        };
        block.intersection(self.stage.size().window())
    }

    fn emptiest_block(&self, coverage: &Coverage) -> Window {
        let share = |number: &u32| coverage.share(*number);
        let least = |a: &u32, b: &u32| share(a).total_cmp(&share(b));
        let number = self.all_blocks().into_iter().min_by(least);
        self.block(number.unwrap_or(0))
    }

    /// A call with a picture for each window, of the frame's own camera.
    fn windows(
        &self,
        question: Question,
        seen: &Seen,
        scene: &Arc<Scene>,
        windows: &[Window],
    ) -> Sample {
        let pass = match question {
            Question::Pixels(pass) => pass,
            _ => Pass::Fast,
        };
        let pictures: Vec<_> = windows.iter().map(|&w| seen.picture(pass, w)).collect();
        let sum = |of: fn(&crate::plan::Picture) -> f64| pictures.iter().map(of).sum();
        Sample {
            question,
            output: self.output(question),
            shots: windows
                .iter()
                .map(|&window| self.shot(scene, Region::Window(window)))
                .collect(),
            blocks: Vec::new(),
            pixels: sum(|p| p.pixels),
            covered: sum(|p| p.covered),
            canvas: sum(|p| p.canvas),
            parsed: Parsed {
                instances: sum(|p| p.parsed.instances),
                bytes: sum(|p| p.parsed.bytes),
            },
        }
    }

    /// A call with one picture of some blocks.
    fn blocks(
        &self,
        question: Question,
        seen: &Seen,
        scene: &Arc<Scene>,
        numbers: Vec<u32>,
    ) -> Sample {
        let windows: Vec<Window> = numbers.iter().map(|&n| self.block(n)).collect();
        let picture = seen.blocks(&windows);
        Sample {
            question,
            output: self.output(question),
            shots: vec![self.shot(scene, Region::Blocks(decor_api::Blocks::usual(numbers)))],
            blocks: windows,
            pixels: picture.pixels,
            covered: picture.covered,
            canvas: picture.canvas,
            parsed: picture.parsed,
        }
    }

    /// Two opposite corners of the picture: no crop around them is smaller. Of the
    /// full scene, as blocks are.
    fn canvas(&self, everything: &Seen, scene: &Arc<Scene>) -> Sample {
        let all = self.all_blocks();
        let ends = [all.first(), all.last()].into_iter().flatten().copied();
        let mut numbers: Vec<u32> = ends.collect();
        numbers.dedup();
        let mut sample = self.blocks(Question::Canvas, everything, scene, numbers);
        // Twice: less depends on chance.
        sample.shots.push(sample.shots[0].clone());
        sample.pixels *= 2.0;
        sample.covered *= 2.0;
        sample.canvas *= 2.0;
        sample
    }

    /// Some of the pixels of a pass: from the fuller half of its blocks, and
    /// from the emptier one. Fast layers are windows in a plan, too.
    fn pixels(&self, pass: Pass, seen: &Seen, scene: &Arc<Scene>, blocks: &[u32]) -> Vec<Sample> {
        let question = Question::Pixels(pass);
        let coverage = seen.coverage();
        let mut by_share = blocks.to_vec();
        by_share.sort_by(|a, b| coverage.share(*b).total_cmp(&coverage.share(*a)));
        // The quarter that is fullest, but enough of it; and the emptier half.
        let enough = (self.wanted / f64::from(BLOCK * BLOCK)).ceil() as usize;
        let half = by_share.len().div_ceil(2);
        let full = &by_share[..half.min(enough.max(by_share.len() / 4))];
        let empty = &by_share[half..];
        [full, empty]
            .into_iter()
            .filter(|half| !half.is_empty())
            .map(|half| {
                if self.by_blocks && !pass.is_fast() {
                    self.blocks(question, seen, scene, self.spread(half))
                } else {
                    let windows = self.squares(half, coverage);
                    self.windows(question, seen, scene, &windows)
                }
            })
            .collect()
    }

    /// As many of the blocks as are wanted, evenly from all of them, ascending.
    fn spread(&self, blocks: &[u32]) -> Vec<u32> {
        let block = f64::from(BLOCK * BLOCK);
        let count = (self.wanted / block).ceil() as usize;
        let count = count.clamp(1, blocks.len());
        let mut some: Vec<u32> = (0..count)
            .map(|k| blocks[k * blocks.len() / count])
            .collect();
        some.sort_unstable();
        some
    }

    /// Two squares of the same size around two of the blocks, which are sorted
    /// from full to empty: where the picture is as they are.
    fn squares(&self, blocks: &[u32], coverage: &Coverage) -> Vec<Window> {
        let size = self.stage.size();
        let side = (self.wanted / 2.0).sqrt() as u32 / BLOCK * BLOCK;
        let fit = |at: u32, whole: u32| {
            // On the grid, and not over the end.
            let last = whole.saturating_sub(side) / BLOCK * BLOCK;
            at.saturating_sub(side / 2 / BLOCK * BLOCK).min(last)
        };
        let around = |number: u32| {
            let block = self.block(number);
            Window {
                x: fit(block.x, size.width),
                y: fit(block.y, size.height),
                width: side,
                height: side,
            }
            .intersection(size.window())
        };
        let mean: f64 =
            blocks.iter().map(|&b| coverage.share(b)).sum::<f64>() / blocks.len().max(1) as f64;
        // The squares that are most like the half of the picture that they
        // stand for, at two places.
        let mut squares: Vec<Window> = blocks.iter().map(|&b| around(b)).collect();
        squares.sort_by_key(|w| (w.y, w.x));
        squares.dedup();
        let unlike = |w: &Window| (coverage.of(*w) / w.pixels().max(1) as f64 - mean).abs();
        squares.sort_by(|a, b| unlike(a).total_cmp(&unlike(b)));
        let Some(&first) = squares.first() else {
            return Vec::new();
        };
        let second = squares
            .iter()
            .find(|w| w.intersection(first).is_empty() && w.pixels() == first.pixels());
        std::iter::once(first).chain(second.copied()).collect()
    }

    fn shot(&self, scene: &Arc<Scene>, region: Region) -> LayerShot {
        LayerShot {
            frame: self.number,
            scene: Arc::clone(scene),
            region,
        }
    }

    fn output(&self, question: Question) -> Output {
        match question {
            Question::Pixels(pass) if pass.is_depth() => Output::Depth,
            Question::Pixels(pass) if pass.is_fast() => Output::ColourAlone {
                with_sky: self.stage.surroundings(self.state).sky_on_objects,
            },
            _ => Output::ColourOverBackground,
        }
    }
}

/// Renders the samples: all at once where each is a process of its own, one
/// after the other where they are not.
pub fn render(
    stage: &Stage,
    samples: Vec<Sample>,
    run: &RunContext,
) -> Result<Vec<Measured>, AdapterError> {
    if super::is_in_process(stage) {
        let samples = samples.into_iter().zip(0..);
        return samples.map(|(s, k)| call(stage, s, k, run)).collect();
    }
    std::thread::scope(|scope| {
        let running: Vec<_> = samples
            .into_iter()
            .zip(0..)
            .map(|(sample, k)| scope.spawn(move || call(stage, sample, k, run)))
            .collect();
        running
            .into_iter()
            .map(|handle| match handle.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    })
}

fn call(
    stage: &Stage,
    sample: Sample,
    number: u32,
    run: &RunContext,
) -> Result<Measured, AdapterError> {
    let request = LayerRequest {
        prototypes: &stage.library.table,
        size: stage.size(),
        output: sample.output,
        antialias: stage.antialias(),
        shots: sample.shots.clone(),
        film: None,
        label: format!("probe_{number:02}"),
    };
    let tally = Arc::new(Tally::default());
    let run = RunContext {
        threads: Some(1),
        tally: Arc::clone(&tally),
        ..run.clone()
    };
    // What the adapter does itself (text, reading pixels) is done by this
    // thread; a renderer in-process has threads of its own.
    let clock = if super::is_in_process(stage) {
        ClockId::CLOCK_PROCESS_CPUTIME_ID
    } else {
        ClockId::CLOCK_THREAD_CPUTIME_ID
    };
    let started = Instant::now();
    let before = cpu_s(clock);
    let picture = drawn(
        sample.question,
        stage.adapter.render_to_read(&request, &run)?,
    )?;
    let here_s = cpu_s(clock) - before;
    let (cpu_s, own_s) = if super::is_in_process(stage) {
        (here_s, 0.0)
    } else {
        (tally.cpu().as_secs_f64(), here_s)
    };
    Ok(Measured {
        cpu_s,
        own_s,
        wall_s: started.elapsed().as_secs_f64(),
        sample,
        picture,
    })
}

/// Reads the pictures of a call, one after the other, and keeps what is of use later.
/// A canvas is as large as a frame, and nothing is asked of its pixels.
fn drawn(
    question: Question,
    mut rendered: Rendered<'_, Layer>,
) -> Result<Option<Layer>, AdapterError> {
    let mut kept = None;
    if question != Question::Canvas {
        for shot in 0..rendered.shots() {
            let layer = rendered.read(shot)?;
            if shot == 0 && question == Question::Pixels(Pass::Whole) {
                kept = Some(layer);
            }
        }
    }
    Ok(kept)
}

/// What a clock of CPU time shows, in seconds.
pub fn cpu_s(clock: ClockId) -> f64 {
    clock_gettime(clock).map_or(0.0, |time| {
        time.tv_sec() as f64 + time.tv_nsec() as f64 * 1e-9
    })
}

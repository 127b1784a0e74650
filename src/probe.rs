//! A probe: what a film costs on this machine, from a few small pictures of its
//! own frames.
//!
//! A handful of calls run side by side, so that the renderer's sleep is waited
//! for once: a call of an empty scene with one picture and with three, the full
//! scene in the tiniest window (what reading it costs) and in two far corners of a
//! picture in full size (what its other pixels cost), and for each pass some of its pixels, from where the picture is full and from
//! where it is empty. The CPU time of every call is its own, whatever else runs.
//! The result is kept in the cache, by all that it depends on.

mod core;
mod fit;
mod learned;
mod sample;

pub(crate) use sample::cpu_s;

use std::ops::Not;
use std::sync::Arc;
use std::time::Instant;

use decor_api::{AdapterError, RunContext};
use serde::{Deserialize, Serialize};

use crate::objects::Cache;
use crate::plan::{Costs, CostsFrom, Mode, Parsed, Plan, Price, Wishes, jobs, whole_work};
use crate::stage::Stage;

pub use learned::{Learned, learn};

/// What a probe found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probed {
    /// What things cost.
    pub costs: Costs,
    /// Was something rendered for it?
    pub from: CostsFrom,
    /// What the probe itself cost.
    pub price: Price,
}

/// The kind of its cache entries; changes with [`Costs`] and with what is
/// rendered.
const KIND: &str = "probe-4";

/// What is kept.
#[derive(Serialize, Deserialize)]
struct Entry {
    costs: Costs,
}

/// The costs of a film: kept ones, or those of plain scenes.
pub fn known(stage: &Stage, cache: &Cache) -> Probed {
    let kept: Option<Entry> = cache.get(KIND, &key(stage));
    let (costs, from) = match kept {
        Some(entry) => (entry.costs, CostsFrom::Cached),
        None => (built_in(stage), CostsFrom::BuiltIn),
    };
    Probed {
        costs,
        from,
        price: Price::default(),
    }
}

/// The costs of a film: kept ones, or measured now on the pictures of `plan`.
/// Any plan of the film will do; one that has fast layers shows what they cost.
///
/// # Errors
/// Where the renderer fails.
pub fn probe(
    stage: &Stage,
    plan: &Plan,
    cache: &Cache,
    run: &RunContext,
) -> Result<Probed, AdapterError> {
    let known = known(stage, cache);
    if known.from == CostsFrom::Cached {
        return Ok(known);
    }
    let probed = measure(stage, plan, run)?;
    let entry = Entry {
        costs: probed.costs,
    };
    cache.put(KIND, &key(stage), &entry);
    Ok(probed)
}

/// Measures the costs of a film, whatever is known of it.
///
/// # Errors
/// Where the renderer fails.
pub fn measure(stage: &Stage, plan: &Plan, run: &RunContext) -> Result<Probed, AdapterError> {
    let started = Instant::now();
    let other = sample::shows_layers(plan)
        .not()
        .then(|| layered(stage, plan));
    let plan = other.as_ref().and_then(Option::as_ref).unwrap_or(plan);
    let samples = sample::samples(stage, plan);
    let measured = sample::render(stage, samples, run)?;
    for one in &measured {
        let sample = &one.sample;
        tracing::debug!(
            question = ?sample.question,
            pictures = sample.pictures(),
            pixels = sample.pixels,
            covered = sample.covered,
            instances = sample.parsed.instances,
            bytes = sample.parsed.bytes,
            wall_s = one.wall_s,
            cpu_s = one.cpu_s,
            own_s = one.own_s,
            "probed"
        );
    }
    let mut costs = fit::costs(&measured, &built_in(stage));
    let (core, core_cpu_s) = core::measure(stage, &measured);
    core.put_into(&mut costs);
    tracing::debug!(?costs, "probe");
    let calls_cpu_s: f64 = measured.iter().map(|one| one.cpu_s + one.own_s).sum();
    Ok(Probed {
        costs,
        from: CostsFrom::Probe,
        price: Price {
            wall_s: started.elapsed().as_secs_f64(),
            cpu_s: calls_cpu_s + core_cpu_s,
        },
    })
}

/// A plan that has layers, where there can be one: what they cost is of interest
/// also where, by what is known so far, they are too dear.
fn layered(stage: &Stage, plan: &Plan) -> Option<Plan> {
    const PERIOD: u32 = 8;
    if plan.wishes.mode == Mode::Full {
        return None;
    }
    let wishes = Wishes {
        period: plan.wishes.period.or(Some(PERIOD)),
        fallback: false,
        ..plan.wishes.clone()
    };
    let other = crate::plan::plan(stage, wishes, &built_in(stage)).ok()?;
    sample::shows_layers(&other).then_some(other)
}

/// Is a film worth probing: would rendering its frames one by one take many
/// times as long as the probe? By built-in costs, which are those of plain
/// scenes: a film that is dearer than it seems is worth it all the more.
pub fn worth_probing(stage: &Stage, wishes: &Wishes) -> bool {
    const TIMES: f64 = 10.0;
    let cores = cores();
    let costs = built_in(stage);
    let work = whole_work(stage, wishes);
    let frames = costs.price(&work, jobs(stage), cores);
    let mut pictures = work.frames.iter().flat_map(|frame| &frame.pictures);
    let parsed = pictures.next().map(|picture| picture.parsed);
    frames.wall_s > TIMES * own_wall_s(&costs, &parsed.unwrap_or_default())
}

/// How long a probe takes, about, of a scene with so much to read.
fn own_wall_s(costs: &Costs, parsed: &Parsed) -> f64 {
    /// Pictures of the scene; those of the fast objects alone read little.
    const SCENES: f64 = 8.0;
    let pixels = 12.0 * sample::PIXELS;
    let work = 12.0 * (costs.call_cpu_s + 2.0 * costs.picture_cpu_s)
        + SCENES * costs.read(parsed)
        + costs.colour.of(pixels, 0.0);
    costs.call_sleep_s + 3.0 * costs.picture_sleep_s + work / cores() as f64
}

/// The cores of this machine.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// What plain scenes cost with this renderer. One that runs in-process neither
/// starts nor sleeps.
fn built_in(stage: &Stage) -> Costs {
    // The adapter tells what a call with one picture takes, most of it sleep.
    let overhead_s = stage.adapter.abilities().call_overhead_s.max(0.0);
    let mut costs = Costs {
        call_sleep_s: 0.6 * overhead_s,
        picture_sleep_s: 0.33 * overhead_s,
        picture_cpu_s: stage.adapter.abilities().picture_cpu_s,
        ..Costs::default()
    };
    if is_in_process(stage) {
        costs.call_cpu_s = 0.0;
        costs.canvas_pixel_s = 0.0;
        costs.own_call_s = 0.0;
        costs.own_pixel_s = 0.0;
    }
    costs
}

/// Does the renderer run in this process? Then its calls are measured one by
/// one: there is no child whose time is its own.
fn is_in_process(stage: &Stage) -> bool {
    stage.adapter.abilities().call_overhead_s <= 0.0
}

/// All that the costs depend on: the film, the renderer and its version, the
/// machine, and how this program was built.
fn key(stage: &Stage) -> Vec<u8> {
    format!(
        "{} {} {} {}",
        stage.key(),
        cores(),
        processor(),
        if cfg!(debug_assertions) {
            "debug"
        } else {
            "release"
        },
    )
    .into_bytes()
}

/// The name of the machine's processor, where the system tells it.
pub(crate) fn processor() -> Arc<str> {
    let text = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = text
        .lines()
        .find_map(|line| line.strip_prefix("model name"))
        .map(|rest| rest.trim_start_matches([' ', '\t', ':']).trim());
    name.unwrap_or(std::env::consts::ARCH).into()
}

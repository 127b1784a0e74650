//! `decor plan`: everything but the rendering.

use std::collections::BTreeMap;

use clap::Args;
use decor_api::RunContext;
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::{Failure, Status, print_json};
use crate::objects::Cache;
use crate::plan::{
    CostsFrom, End, Pass, PassTotal, Period, Plan, Prediction, Price, Work, jobs, plan, whole_work,
};
use crate::probe::{self, Learned};
use crate::render::WorkFolder;
use crate::segmentation::Class;
use crate::stage::Stage;

/// Show what would be rendered, and what it would cost.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor plan plane.anim
  decor plan plane.anim --mode exact --json | head -n 1
  decor plan ladybirds.anim --probe

The predicted seconds come from a probe of the film where there was one (a probe
is kept), else from built-in costs of plain scenes; heavier scenes take longer in
every mode alike.")]
pub struct PlanArgs {
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    wishes: PlanWishes,
    /// Render a few small pictures to learn what this film costs.
    #[arg(long)]
    probe: bool,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "period")]
struct PeriodLine<'a> {
    start: u32,
    length: u32,
    threshold_px: f64,
    predicted_wall_s: f64,
    predicted_cpu_s: f64,
    /// The frame that its décor dissolves towards, where it does.
    dissolves_until: Option<u32>,
    /// Why it is not longer.
    end: End,
    whole: Option<String>,
    objects: Vec<ObjectLine<'a>>,
}

#[derive(Serialize)]
struct ObjectLine<'a> {
    name: &'a str,
    class: Class,
    reason: String,
    /// Pixels; null where the motion is unbounded.
    motion_px: Option<f64>,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct PlanSummary {
    frames: u32,
    width: u32,
    height: u32,
    renderer: String,
    mode: String,
    periods: usize,
    predicted_wall_s: f64,
    predicted_cpu_s: f64,
    baseline_wall_s: f64,
    baseline_cpu_s: f64,
    predicted_speedup: f64,
    costs: CostsFrom,
    renders_learned_from: u32,
    /// What the probe itself cost; 0 without one.
    probe_wall_s: f64,
    probe_cpu_s: f64,
    /// What the renderer would be asked for, by pass.
    passes: BTreeMap<Pass, PassTotal>,
    fallback: bool,
}

/// Runs the verb.
pub fn run(args: &PlanArgs) -> Result<Status, Failure> {
    if super::plain::names_plain(&args.film) {
        return super::plain_plan::plan(&args.film, &args.wishes, args.probe, args.json);
    }
    let cancel = cancelled_by_ctrl_c();
    let stage = args.film.stage(&cancel)?;
    let frames = args.film.wanted(&stage.film);
    let wishes = args.wishes.wishes(frames, false);
    let cache = Cache::open();
    let mut probed = probe::known(&stage, &cache);
    let mut planned = plan(&stage, wishes.clone(), &probed.costs)?;
    if args.probe {
        let work = WorkFolder::new(None)?;
        let mut run = RunContext::new(&work.path);
        run.timeout = args.film.timeout();
        run.cancel = cancel;
        probed = probe::probe(&stage, &planned, &cache, &run)?;
        planned = plan(&stage, wishes, &probed.costs)?;
    }
    let plan = planned;
    let (costs, cores, jobs) = (probed.costs, probe::cores(), jobs(&stage));
    let works = plan.works(&stage);
    let learned = Learned::of(&stage, probed.from, &cache);
    let prices = costs.film(&works, jobs, cores).into_iter();
    let prices: Vec<Price> = prices.map(|price| learned.correct(&plan, price)).collect();
    let total: Price = prices.iter().copied().sum();
    let stock = costs.stock(&whole_work(&stage, &plan.wishes), cores);
    let stock = learned.correct_stock(stock);
    let prediction = Prediction::new(probed.from, total, stock);
    let summary = PlanSummary {
        frames: frames.1 - frames.0 + 1,
        width: stage.size().width,
        height: stage.size().height,
        renderer: stage.adapter.name().into(),
        mode: plan.wishes.mode.to_string(),
        periods: plan.periods.len(),
        predicted_wall_s: total.wall_s,
        predicted_cpu_s: total.cpu_s,
        baseline_wall_s: stock.wall_s,
        baseline_cpu_s: stock.cpu_s,
        predicted_speedup: prediction.speedup(),
        costs: probed.from,
        renders_learned_from: learned.renders(&plan),
        probe_wall_s: probed.price.wall_s,
        probe_cpu_s: probed.price.cpu_s,
        passes: passes(&works),
        fallback: plan.is_fallback(),
    };
    if args.json {
        for (period, price) in plan.periods.iter().zip(&prices) {
            print_json(&line(&stage, period, *price))?;
        }
        print_json(&summary)?;
    } else {
        tell(&stage, &plan, &prices, &summary);
    }
    Ok(Status::Done)
}

fn passes(works: &[Work]) -> BTreeMap<Pass, PassTotal> {
    let mut sums: BTreeMap<Pass, PassTotal> = BTreeMap::new();
    for (pass, total) in works.iter().flat_map(Work::totals) {
        *sums.entry(pass).or_default() += total;
    }
    sums
}

fn line<'s>(stage: &'s Stage, period: &Period, price: Price) -> PeriodLine<'s> {
    PeriodLine {
        start: period.start,
        length: period.len(),
        threshold_px: period.threshold_px,
        predicted_wall_s: price.wall_s,
        predicted_cpu_s: price.cpu_s,
        dissolves_until: period.dissolve_until,
        end: period.end,
        whole: period.whole.as_ref().map(ToString::to_string),
        objects: period
            .objects
            .iter()
            .map(|object| ObjectLine {
                name: stage.film.identity(object.object).name(),
                class: object.class,
                reason: object.reason.to_string(),
                motion_px: object.motion_px.is_finite().then_some(object.motion_px),
            })
            .collect(),
    }
}

fn tell(stage: &Stage, plan: &Plan, prices: &[Price], summary: &PlanSummary) {
    for (period, price) in plan.periods.iter().zip(prices) {
        let last = period.start + period.len() - 1;
        say!(
            "frames {} to {last}: about {:.1} s, {:.1} s of CPU",
            period.start,
            price.wall_s,
            price.cpu_s
        );
        say!("  ends: {}", period.end);
        if let Some(reason) = &period.whole {
            say!("  rendered frame by frame: {reason}");
        }
        if let Some(until) = period.dissolve_until {
            say!("  its décor dissolves towards frame {until}");
        }
        if let Some(sky) = period.sky {
            let moved_px = sky.motion_px;
            say!("  {:9} the sky: moved {moved_px:.3} px", sky.class);
        }
        if period.by_map() {
            say!("  shadows by the light that arrives");
        }
        for object in &period.objects {
            let name = stage.film.identity(object.object).name();
            say!("  {:9} {name}: {}", object.class, object.reason);
        }
    }
    say!(
        "about {:.1} s in all ({:.1} s of CPU), {:.1} s frame by frame by {} ({:.1} s of CPU): {:.1} times faster ({}{})",
        summary.predicted_wall_s,
        summary.predicted_cpu_s,
        summary.baseline_wall_s,
        summary.renderer,
        summary.baseline_cpu_s,
        summary.predicted_speedup,
        summary.costs,
        match summary.renders_learned_from {
            0 => String::new(),
            1 => ", corrected by a render".to_owned(),
            n => format!(", corrected by {n} renders"),
        },
    );
}

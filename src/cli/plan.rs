//! `decor plan`: everything but the rendering.

use clap::Args;
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::{Failure, Status, print_json};
use crate::plan::{Costs, Period, Plan, Price, jobs, plan, whole_work};
use crate::segmentation::Class;
use crate::stage::Stage;

/// Show what would be rendered, and what it would cost.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor plan plane.anim
  decor plan plane.anim --mode exact --json | head -n 1

The predicted seconds come from built-in costs of plain scenes; heavier scenes
take longer in every mode alike.")]
pub struct PlanArgs {
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    wishes: PlanWishes,
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
    costs: &'static str,
    fallback: bool,
}

/// Runs the verb.
pub fn run(args: &PlanArgs) -> Result<Status, Failure> {
    let cancel = cancelled_by_ctrl_c();
    let stage = args.film.stage(&cancel)?;
    let frames = args.film.wanted(&stage.film);
    let plan = plan(&stage, args.wishes.wishes(frames, false))?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (costs, jobs) = (Costs::default(), jobs(&stage));
    let prices = costs.film(&plan.works(&stage), jobs, cores);
    let count = frames.1 - frames.0 + 1;
    let total = prices
        .iter()
        .fold(Price::default(), |sum, price| sum + *price);
    let stock = costs.stock(&whole_work(&stage, &plan.wishes), cores);
    let summary = PlanSummary {
        frames: count,
        width: stage.size().width,
        height: stage.size().height,
        renderer: stage.adapter.name().into(),
        mode: plan.wishes.mode.to_string(),
        periods: plan.periods.len(),
        predicted_wall_s: total.wall_s,
        predicted_cpu_s: total.cpu_s,
        baseline_wall_s: stock.wall_s,
        baseline_cpu_s: stock.cpu_s,
        predicted_speedup: stock.wall_s / total.wall_s.max(1e-9),
        costs: "built-in",
        fallback: plan.is_fallback(),
    };
    if args.json {
        for (period, price) in plan.periods.iter().zip(&prices) {
            print_json(&line(&stage, period, *price, plan.wishes.threshold_px))?;
        }
        print_json(&summary)?;
    } else {
        tell(&stage, &plan, &prices, &summary);
    }
    Ok(Status::Done)
}

fn line<'s>(stage: &'s Stage, period: &Period, price: Price, threshold_px: f64) -> PeriodLine<'s> {
    PeriodLine {
        start: period.start,
        length: period.len(),
        threshold_px,
        predicted_wall_s: price.wall_s,
        predicted_cpu_s: price.cpu_s,
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
            "frames {} to {last}: about {:.1} s",
            period.start,
            price.wall_s
        );
        if let Some(reason) = &period.whole {
            say!("  rendered frame by frame: {reason}");
        }
        for object in &period.objects {
            let name = stage.film.identity(object.object).name();
            say!("  {:9} {name}: {}", object.class, object.reason);
        }
    }
    say!(
        "about {:.1} s in all, {:.1} s frame by frame by {}: {:.1} times faster (built-in costs)",
        summary.predicted_wall_s,
        summary.baseline_wall_s,
        summary.renderer,
        summary.predicted_speedup
    );
}

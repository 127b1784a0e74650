//! `decor plan` of a plain POV-Ray scene: its frames, files and options; what
//! moves in it, or why frames are rendered whole; what that touches and costs.

use std::path::PathBuf;

use decor_api::{Adapter as _, RunContext};
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::plain::{check, ends, reason, wanted};
use super::plain_explain::{MovingLine, moving};
use super::{Failure, Status, print_json};
use crate::plain::{Forecast, Look, forecast, most_jobs};
use crate::plan::Mode;
use crate::render::WorkFolder;
use crate::renderers::povray;

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct PlainPlan<'a> {
    film: String,
    /// `exact` where coherence is used.
    mode: &'static str,
    frames: u64,
    first_frame: u32,
    last_frame: u32,
    frame_step: u32,
    width: u32,
    height: u32,
    renderer: &'static str,
    first_file: String,
    last_file: String,
    jobs: usize,
    in_order: Option<&'a str>,
    /// Why frames are rendered whole; empty: they need not be.
    rendered_whole: Vec<String>,
    /// Frames that show the same as others, and are not rendered.
    frames_repeated: usize,
    moving: Vec<MovingLine>,
    /// The share of blocks that may change, where it is known.
    dirty_blocks: Option<f64>,
    /// Why only a probe tells that.
    proxies_only: Option<String>,
    /// What a whole frame takes, with a probe.
    frame_cpu_s: Option<f64>,
    full_wall_s: Option<f64>,
    full_cpu_s: Option<f64>,
    predicted_wall_s: Option<f64>,
    predicted_cpu_s: Option<f64>,
    files: &'a [PathBuf],
    options: Vec<String>,
}

/// `decor plan` of a plain scene; with `probe`, two frames are rendered.
pub fn plan(
    film: &FilmArgs,
    wishes: &PlanWishes,
    probe: bool,
    json: bool,
) -> Result<Status, Failure> {
    check(film, wishes)?;
    let povray = povray()?;
    let scene = povray.plain(&film.film, &film.switches, None)?;
    let frames = wanted(film, &scene)?;
    let (first, last) = ends(&frames);
    let in_order = reason(&scene);
    let most = most_jobs(&scene, povray.abilities().jobs);
    let look = Look::at(&povray, &scene)?;
    let mut rendered = frames.clone();
    let said = if wishes.mode == Some(Mode::Full) {
        Forecast {
            whole: vec!["--mode full".into()],
            ..Forecast::default()
        }
    } else {
        let work = WorkFolder::new(None)?;
        let mut run = RunContext::new(&work.path);
        run.timeout = film.timeout();
        run.cancel = cancelled_by_ctrl_c();
        let repeated = look.repeated(&povray, &scene, &frames, &run)?;
        for frame in repeated.values().flatten() {
            rendered.remove(frame);
        }
        let list = rendered.iter().copied().collect();
        forecast(&povray, &scene, &look, list, most, probe, &run)?
    };
    let (stock, coherent) = said.prices.unzip();
    let plan = PlainPlan {
        film: film.film.display().to_string(),
        mode: if said.whole.is_empty() {
            "exact"
        } else {
            "full"
        },
        frames: frames.len() as u64,
        first_frame: first,
        last_frame: last,
        frame_step: scene.frames.step,
        width: scene.size.0,
        height: scene.size.1,
        renderer: "povray",
        first_file: scene.name(first),
        last_file: scene.name(last),
        // At most; fewer where frames turn out to keep the cores busy.
        jobs: in_order.map_or(most.min(rendered.len()), |_| 1),
        in_order,
        rendered_whole: said.whole,
        frames_repeated: frames.len() - rendered.len(),
        moving: moving(&look),
        dirty_blocks: said.dirty,
        proxies_only: said.proxies_only,
        frame_cpu_s: said.costs.map(|costs| costs.whole_s()),
        full_wall_s: stock.map(|price| price.wall_s),
        full_cpu_s: stock.map(|price| price.cpu_s),
        predicted_wall_s: coherent.map(|price| price.wall_s),
        predicted_cpu_s: coherent.map(|price| price.cpu_s),
        files: &scene.files,
        options: scene.found(),
    };
    if json {
        print_json(&plan)?;
    } else {
        tell(&plan);
    }
    Ok(Status::Done)
}

fn tell(plan: &PlainPlan<'_>) {
    say!(
        "{} frames of {} by {} pixels, {} to {}: mode {}",
        plan.frames,
        plan.width,
        plan.height,
        plan.first_file,
        plan.last_file,
        plan.mode
    );
    match plan.in_order {
        Some(reason) => say!("in order, by one POV-Ray: {reason}"),
        None => say!(
            "by up to {} POV-Rays at once: no frame needs another one",
            plan.jobs
        ),
    }
    for reason in &plan.rendered_whole {
        say!("rendered whole: {reason}");
    }
    if plan.frames_repeated > 0 {
        say!("{} frames show the same as others", plan.frames_repeated);
    }
    for line in &plan.moving {
        say!("  moves {line}");
    }
    match (plan.dirty_blocks, &plan.proxies_only) {
        (Some(share), _) => say!(
            "{:.1} % of the blocks may change from frame to frame",
            100.0 * share
        ),
        (None, Some(reason)) => say!("what changes, --probe tells: {reason}"),
        (None, None) => {}
    }
    if let (Some(full), Some(cpu), Some(wall), Some(own)) = (
        plan.full_wall_s,
        plan.full_cpu_s,
        plan.predicted_wall_s,
        plan.predicted_cpu_s,
    ) {
        say!(
            "about {full:.1} s whole ({cpu:.1} s of CPU), {wall:.1} s by coherence ({own:.1} s of CPU)"
        );
    }
    for file in plan.files {
        say!("  reads {}", file.display());
    }
    for option in &plan.options {
        say!("  {option}");
    }
}

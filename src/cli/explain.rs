//! `decor explain`: why each object of a frame has its class.

use std::path::PathBuf;
use std::sync::Arc;

use clap::Args;
use decor_api::{LayerRequest, LayerShot, Output, Region, RunContext};
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::{Failure, Status, print_json};
use crate::explain::{Explained, Explanation, explain};
use crate::frames::write_safely;
use crate::plan::plan;
use crate::render::WorkFolder;
use crate::report::diagram;
use crate::segmentation::Class;
use crate::stage::Stage;

/// Explain why each object of a frame has its class, in words and as a picture.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor explain plane.anim --frame 12
  decor explain plane.anim --frame 12 -o why.png
  decor explain ladybirds.anim --frame 3 --object ladybird_007 --threshold 4
  decor explain scene.ini                          (any POV-Ray animation)

The motions are upper bounds, from the first frame of the period to this one.")]
pub struct ExplainArgs {
    #[command(flatten)]
    film: FilmArgs,
    #[command(flatten)]
    wishes: PlanWishes,
    /// Which frame; of a plain POV-Ray scene, all if it is left out.
    #[arg(long, value_name = "N")]
    frame: Option<u32>,
    /// Only this object.
    #[arg(long, value_name = "NAME")]
    object: Option<String>,
    /// Draws the frame with ellipses coloured by class, motions and a legend.
    #[arg(short, long, value_name = "PICTURE.png")]
    out: Option<PathBuf>,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "object")]
struct ObjectLine<'a> {
    name: &'a str,
    class: Class,
    reason: String,
    motion_px: Option<f64>,
    translation_px: Option<f64>,
    rotation_px: Option<f64>,
    area_px: Option<f64>,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct ExplainSummary {
    frame: u32,
    period_start: u32,
    whole: Option<String>,
    objects: usize,
    windows: usize,
    blocks: usize,
}

/// Runs the verb.
pub fn run(args: &ExplainArgs) -> Result<Status, Failure> {
    if super::plain::names_plain(&args.film) {
        return super::plain_explain::explain(&args.film, &args.wishes, args.frame, args.json);
    }
    let frame = args
        .frame
        .ok_or_else(|| Failure::usage("which frame? (--frame N)"))?;
    let cancel = cancelled_by_ctrl_c();
    let stage = args.film.stage(&cancel)?;
    let frames = args.film.wanted(&stage.film);
    let plan = plan(
        &stage,
        args.wishes.wishes(frames, false),
        &crate::probe::known(&stage, &crate::objects::Cache::open()).costs,
    )?;
    let Some(mut explanation) = explain(&stage, &plan, frame) else {
        let asked = (frame, frame);
        return Err(crate::plan::PlanError::NoSuchFrames {
            film: frames,
            asked,
        }
        .into());
    };
    if let Some(name) = &args.object {
        explanation.objects.retain(|object| object.name == *name);
        if explanation.objects.is_empty() {
            return Err(Failure::usage(format!(
                "frame {frame} has no object `{name}`"
            )));
        }
    }
    if let Some(path) = &args.out {
        let frame = picture(&stage, &explanation, args, &cancel)?;
        let drawn = diagram::draw(&frame, &explanation);
        let mut bytes = std::io::Cursor::new(Vec::new());
        drawn
            .write_to(&mut bytes, image::ImageFormat::Png)
            .map_err(Failure::internal)?;
        write_safely(path, bytes.get_ref())?;
    }
    if args.json {
        for object in &explanation.objects {
            print_json(&line(object))?;
        }
        print_json(&ExplainSummary {
            frame: explanation.frame,
            period_start: explanation.start,
            whole: explanation.whole.clone(),
            objects: explanation.objects.len(),
            windows: explanation.windows.len(),
            blocks: explanation.blocks.len(),
        })?;
    } else {
        tell(&explanation);
    }
    Ok(Status::Done)
}

/// The frame itself, rendered whole, with 8 bits.
fn picture(
    stage: &Stage,
    explanation: &Explanation,
    args: &ExplainArgs,
    cancel: &Arc<std::sync::atomic::AtomicBool>,
) -> Result<image::RgbImage, Failure> {
    let work = WorkFolder::new(None)?;
    let mut run = RunContext::new(&work.path);
    run.timeout = args.film.timeout();
    run.cancel = Arc::clone(cancel);
    let size = stage.size();
    let state = stage.film.frame(explanation.frame);
    let request = LayerRequest {
        prototypes: &stage.library.table,
        size,
        output: Output::ColourOverBackground,
        antialias: stage.antialias(),
        shots: vec![LayerShot {
            frame: explanation.frame,
            scene: Arc::new(stage.scene(&state, |_| true)),
            region: Region::Window(size.window()),
        }],
        film: None,
        label: "explain".into(),
    };
    let layers = stage.adapter.render(&request, &run)?;
    let Some(colour) = layers.into_iter().next().and_then(|layer| layer.colour) else {
        return Ok(diagram::blank(size));
    };
    Ok(image::RgbImage::from_fn(size.width, size.height, |x, y| {
        let pixel = colour[(y * size.width + x) as usize];
        image::Rgb([0, 1, 2].map(|k| stage.adapter.encode(pixel[k], 255) as u8))
    }))
}

fn line(object: &Explained) -> ObjectLine<'_> {
    ObjectLine {
        name: &object.name,
        class: object.class,
        reason: object.reason.to_string(),
        motion_px: object.motion_px,
        translation_px: object.translation_px,
        rotation_px: object.rotation_px,
        area_px: object.area_px,
    }
}

fn tell(explanation: &Explanation) {
    say!(
        "frame {} of the period from {}",
        explanation.frame,
        explanation.start
    );
    if let Some(reason) = &explanation.whole {
        say!("rendered whole: {reason}");
    }
    let width = explanation
        .objects
        .iter()
        .map(|o| o.name.len())
        .max()
        .unwrap_or(0)
        .max(6);
    say!(
        "{:width$}  {:9} {:>10} {:>11} {:>10} {:>12}  reason",
        "object",
        "class",
        "motion px",
        "translation",
        "rotation",
        "area px"
    );
    let number = |value: Option<f64>| match value {
        Some(value) => format!("{value:.2}"),
        None => "unbounded".into(),
    };
    for object in &explanation.objects {
        say!(
            "{:width$}  {:9} {:>10} {:>11} {:>10} {:>12}  {}",
            object.name,
            object.class,
            number(object.motion_px),
            number(object.translation_px),
            number(object.rotation_px),
            number(object.area_px),
            object.reason
        );
    }
}

//! `decor explain` of a plain POV-Ray scene: which statements move, by file and
//! line, and why; or why frames are rendered whole. With a frame: where they are.

use std::fmt;

use decor_api::RunContext;
use decor_povray::unedited::{self, Extent, Kind, Statement};
use serde::Serialize;

use super::film_args::{FilmArgs, PlanWishes, cancelled_by_ctrl_c};
use super::plain::check;
use super::{Failure, Status, print_json};
use crate::plain::Look;
use crate::render::WorkFolder;
use crate::renderers::povray;

/// A statement that moves.
#[derive(Clone, Debug, Serialize)]
#[serde(tag = "type", rename = "moves")]
pub struct MovingLine {
    file: String,
    line: usize,
    /// Its keyword: `sphere`, `union`.
    statement: String,
    why: String,
}

impl fmt::Display for MovingLine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file,
            line,
            statement,
            why,
        } = self;
        write!(f, "{file}:{line}: {statement}: {why}")
    }
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "refusal")]
struct RefusalLine {
    file: String,
    /// 0: it has none.
    line: usize,
    reason: String,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "object")]
struct PlaceLine {
    file: String,
    line: usize,
    /// Its least and its greatest corner; null: it has no end.
    r#box: Option<[[f64; 3]; 2]>,
}

#[derive(Serialize)]
#[serde(tag = "type", rename = "summary")]
struct ExplainPlain {
    frame: Option<u32>,
    /// Are all frames rendered whole?
    rendered_whole: bool,
    moving: usize,
    still: usize,
    /// Frames that show the same as earlier ones, and are not rendered.
    frames_repeated: usize,
    /// Why geometry alone does not tell what is touched.
    proxies_only: Vec<String>,
}

/// The statements that move.
pub fn moving(look: &Look) -> Vec<MovingLine> {
    let all = look.analysis.moving();
    all.map(|(_, statement)| line(look, statement)).collect()
}

fn line(look: &Look, statement: &Statement) -> MovingLine {
    let file = look.sources.files.get(statement.file);
    MovingLine {
        file: file.map_or_else(String::new, |file| file.name.clone()),
        line: statement.line,
        statement: match &statement.kind {
            Kind::Object(word) => word.clone(),
            Kind::Light => "light_source".into(),
            Kind::Camera => "camera".into(),
        },
        why: statement.why.clone(),
    }
}

/// `decor explain` of a plain scene.
pub fn explain(
    film: &FilmArgs,
    wishes: &PlanWishes,
    frame: Option<u32>,
    json: bool,
) -> Result<Status, Failure> {
    check(film, wishes)?;
    let povray = povray()?;
    let scene = povray.plain(&film.film, &film.switches, None)?;
    if let Some(n) = frame.filter(|n| !scene.frames.numbers().any(|own| own == *n)) {
        return Err(crate::plan::PlanError::NoSuchFrames {
            film: (scene.frames.first, scene.frames.last),
            asked: (n, n),
        }
        .into());
    }
    let look = Look::at(&povray, &scene)?;
    let moves = moving(&look);
    let mut refusals = look.whole.clone();
    let mut places = Vec::new();
    let work = WorkFolder::new(None)?;
    let mut run = RunContext::new(&work.path);
    run.timeout = film.timeout();
    run.cancel = cancelled_by_ctrl_c();
    let all = scene.frames.numbers().collect();
    let repeated = look.repeated(&povray, &scene, &all, &run)?;
    let repeated: usize = repeated.values().map(Vec::len).sum();
    if let (Some(n), true) = (frame, refusals.is_empty()) {
        let (sources, analysis) = (&look.sources, &look.analysis);
        let boxes = unedited::boxes(&povray, &scene, sources, analysis, (n, n), &run)?;
        refusals.extend(boxes.whole);
        for object in boxes.frames.iter().flat_map(|frame| &frame.objects) {
            let statement = look.analysis.statements.get(object.statement);
            if let Some(statement) = statement.filter(|s| s.moves) {
                let MovingLine { file, line, .. } = line(&look, statement);
                let corners = match object.extent {
                    Extent::Box { min, max } => Some([min.to_array(), max.to_array()]),
                    _ => None,
                };
                places.push(PlaceLine {
                    file,
                    line,
                    r#box: corners,
                });
            }
        }
    }
    let proxies_only: Vec<String> = look
        .analysis
        .proxies_only
        .iter()
        .map(ToString::to_string)
        .collect();
    if json {
        for refusal in &refusals {
            print_json(&RefusalLine {
                file: refusal.file.clone(),
                line: refusal.line,
                reason: refusal.reason.clone(),
            })?;
        }
        for line in &moves {
            print_json(line)?;
        }
        for place in &places {
            print_json(place)?;
        }
        print_json(&ExplainPlain {
            frame,
            rendered_whole: !refusals.is_empty(),
            moving: moves.len(),
            still: look.analysis.statements.len() - moves.len(),
            frames_repeated: repeated,
            proxies_only,
        })?;
        return Ok(Status::Done);
    }
    for refusal in &refusals {
        say!("rendered whole: {refusal}");
    }
    for line in &moves {
        say!("moves: {line}");
    }
    for reason in &proxies_only {
        say!("what is touched, only proxies tell: {reason}");
    }
    for PlaceLine { file, line, r#box } in &places {
        match r#box {
            Some([min, max]) => say!("  {file}:{line} is within {min:.3?} and {max:.3?}"),
            None => say!("  {file}:{line} has no end"),
        }
    }
    let still = look.analysis.statements.len() - moves.len();
    say!("{} statements move, {still} do not", moves.len());
    if repeated > 0 {
        let count = scene.frames.numbers().count();
        say!("{repeated} of {count} frames show the same as earlier ones");
    }
    Ok(Status::Done)
}

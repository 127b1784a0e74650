//! Where the statements of a scene are in each frame, by POV-Ray itself: an
//! instrumented copy is parsed for all frames in one process, of whose pictures
//! one pixel is rendered.

use std::time::Duration;

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, RunContext};
use glam::DVec3;

use super::analysis::{Analysis, Refusal};
use super::instrument;
use super::records::{Frame, frames};
use super::source::{Edit, Sources};
use crate::plain::{PlainScene, quoted};
use crate::{PovRay, patiently};

/// What a copy may take that parses for ever: so much, and so much a frame.
const PARSE_LIMIT: (Duration, Duration) = (Duration::from_secs(120), Duration::from_secs(5));

/// What an object is within.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// A box, rounded outwards.
    Box {
        /// Its least corner.
        min: DVec3,
        /// Its greatest corner.
        max: DVec3,
    },
    /// A plane, or one side of it.
    Plane {
        /// A point of the surface.
        point: DVec3,
        /// Of length 1; to either side.
        normal: DVec3,
    },
    /// It has no end, or none is known.
    Endless,
}

/// An object of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// Which of [`Analysis::statements`] made it.
    pub statement: usize,
    /// Where it is.
    pub extent: Extent,
    /// Is it a ball? Then the extent is its box.
    pub round: bool,
}

/// What is where in a frame. A statement in a loop or a macro makes any number
/// of objects, none included; a union may be several, its parts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameBoxes {
    /// The frame's number.
    pub frame: u32,
    /// Objects, those that do not move included.
    pub objects: Vec<Placed>,
    /// Centres of the lights that cast shadows.
    pub lights: Vec<DVec3>,
    /// The camera's words in order, with their values: `location`, `look_at`,
    /// `angle` (thrice the same), `translate`… `None` where it has others.
    pub camera: Option<Vec<(String, DVec3)>>,
    /// Is there a light whose centre is not known?
    pub lost_light: bool,
}

/// What is where in all frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boxes {
    /// The frames, in order.
    pub frames: Vec<FrameBoxes>,
    /// Why all frames are rendered whole after all: an endless object moves,
    /// POV-Ray does not take the copy… Not empty: nothing else here counts.
    pub whole: Vec<Refusal>,
}

/// Asks POV-Ray where everything is in the frames `first` to `last`. It takes
/// about a quarter of a second a frame, nearly all of it sleep: parts of a long
/// film can be asked for at the same time.
///
/// # Errors
/// [`AdapterError::Cancelled`], [`AdapterError::Io`], [`AdapterError::Start`];
/// what else goes wrong is in [`Boxes::whole`].
pub fn boxes(
    povray: &PovRay,
    scene: &PlainScene,
    sources: &Sources,
    analysis: &Analysis,
    (first, last): (u32, u32),
    run: &RunContext,
) -> Result<Boxes, AdapterError> {
    let refused = |reason: String| Boxes {
        frames: Vec::new(),
        whole: vec![Refusal {
            file: sources
                .files
                .first()
                .map_or_else(String::new, |f| f.name.clone()),
            line: 0,
            reason,
        }],
    };
    if !analysis.whole.is_empty() {
        return Ok(Boxes {
            frames: Vec::new(),
            whole: analysis.whole.clone(),
        });
    }
    let call = Call {
        povray,
        scene,
        sources,
        analysis,
        part: (first, last),
    };
    let said = match call.run(run) {
        Ok(said) => said,
        Err(AdapterError::TimedOut { limit, .. }) => {
            let seconds = limit.as_secs();
            return Ok(refused(format!(
                "POV-Ray did not read it within {seconds} s"
            )));
        }
        Err(AdapterError::Failed { stderr, .. }) => {
            return Ok(refused(format!(
                "POV-Ray does not take decor's copy of it: {}",
                error(&stderr)
            )));
        }
        Err(AdapterError::BadInput { reason, .. }) => return Ok(refused(reason)),
        Err(other) => return Err(other),
    };
    let expected: Vec<u32> = (first..=last).step_by(scene.frames.step as usize).collect();
    let frames = frames(&said);
    let numbers: Vec<u32> = frames.iter().map(|frame| frame.boxes.frame).collect();
    if numbers != expected || frames.iter().any(|frame| !frame.whole) {
        return Ok(refused(
            "POV-Ray's answer about decor's copy is not complete".into(),
        ));
    }
    let mut found = Boxes {
        whole: endless(analysis, sources, &frames),
        frames: frames.into_iter().map(|frame| frame.boxes).collect(),
    };
    found
        .whole
        .extend(unsteady(analysis, sources, &found.frames));
    Ok(found)
}

struct Call<'a> {
    povray: &'a PovRay,
    scene: &'a PlainScene,
    sources: &'a Sources,
    analysis: &'a Analysis,
    part: (u32, u32),
}

impl Call<'_> {
    /// What the copy writes.
    fn run(&self, run: &RunContext) -> Result<String, AdapterError> {
        let folder = tempfile::Builder::new()
            .prefix("boxes-")
            .tempdir_in(&run.work)
            .map_err(AdapterError::io(&run.work))?;
        let out = folder.path().join("boxes.txt");
        let bad = || AdapterError::BadInput {
            file: folder.path().to_owned(),
            reason: "a scene cannot write to a working folder of this name".into(),
        };
        let plain = |c: char| c.is_ascii_graphic() && !matches!(c, '"' | '\\') || c == ' ';
        let name = out
            .to_str()
            .filter(|name| name.chars().all(plain))
            .ok_or_else(bad)?;
        let ini = folder.path().join("options.ini");
        let ini = ini.to_str().and_then(quoted).ok_or_else(bad)?;

        let prefix = &self.analysis.prefix;
        let (file, at) = self.analysis.start;
        let mut edits = vec![Edit {
            file,
            range: at..at,
            text: instrument::definitions(prefix, name),
        }];
        edits.extend_from_slice(&self.analysis.measuring);
        edits.push(self.sources.behind(instrument::ending(prefix)));
        let copy = self.sources.rewritten(&edits, folder.path())?;

        let mut args = self.scene.command().to_vec();
        if self.scene.frames.digits.is_some() {
            args.extend([format!("+SF{}", self.part.0), format!("+EF{}", self.part.1)]);
        }
        args.extend(copy.switches);
        args.extend(one_pixel(self.scene.size));
        args.extend(["-A", "+Q0", "+WT1"].map(str::to_owned));
        args.push(format!("Create_Ini={ini}"));
        args.extend(["-F", "-C", "-D", "-P", "-V"].map(str::to_owned));

        let frames = (self.part.1 - self.part.0) / self.scene.frames.step + 1;
        let mut run = run.clone();
        run.timeout = run.timeout.min(PARSE_LIMIT.0 + PARSE_LIMIT.1 * frames);
        run.tally.add_call(0);
        let call = ProcessCall {
            program: self.povray.program(),
            args,
            folder: &self.scene.folder,
            doing: "where things are".into(),
            log: run.keep.then(|| run.work.join("boxes.log")),
        };
        patiently(|| {
            // An earlier try may have written something.
            let _ = std::fs::remove_file(&out);
            call.run_well(&run)
        })?;
        std::fs::read_to_string(&out).map_err(AdapterError::io(&out))
    }
}

/// Switches for one pixel of the picture: the second one of a row and of a column,
/// as `+EC1` does not end with the first one, but is all of the width.
fn one_pixel((width, height): (u32, u32)) -> [String; 4] {
    let (column, row) = (width.min(2), height.min(2));
    [
        format!("+SC{column}"),
        format!("+EC{column}"),
        format!("+SR{row}"),
        format!("+ER{row}"),
    ]
}

/// What POV-Ray says about the error; it breaks its lines.
fn error(stderr: &str) -> String {
    let is_error = |line: &&str| line.contains("Error:") && !line.contains("Possible");
    let mut lines = stderr
        .lines()
        .map(str::trim)
        .skip_while(|line| !is_error(line));
    let Some(first) = lines.next() else {
        return "it does not say why".into();
    };
    let first = first
        .find("Error:")
        .map_or(first, |at| &first[at + 6..])
        .trim();
    let more = lines
        .take_while(|line| !line.is_empty() && !line.starts_with("Fatal"))
        .take(3);
    std::iter::once(first)
        .chain(more)
        .collect::<Vec<_>>()
        .join(" ")
}

fn refusal(analysis: &Analysis, sources: &Sources, statement: usize, reason: &str) -> Refusal {
    let statement = analysis.statements.get(statement);
    let file = statement.and_then(|s| sources.files.get(s.file));
    Refusal {
        file: file.map_or_else(String::new, |file| file.name.clone()),
        line: statement.map_or(0, |s| s.line),
        reason: reason.to_owned(),
    }
}

/// What moves and has no end.
fn endless(analysis: &Analysis, sources: &Sources, frames: &[Frame]) -> Vec<Refusal> {
    let mut found = Vec::new();
    for placed in frames.iter().flat_map(|frame| &frame.boxes.objects) {
        let moves = analysis
            .statements
            .get(placed.statement)
            .is_none_or(|s| s.moves);
        if moves && !matches!(placed.extent, Extent::Box { .. }) {
            let reason = "what moves here has no end, or POV-Ray knows none";
            found.push(refusal(analysis, sources, placed.statement, reason));
        }
    }
    found.sort();
    found.dedup();
    found
}

/// What does not move must be where it was: if it is not, the analysis is wrong,
/// and no frame may depend on it.
fn unsteady(analysis: &Analysis, sources: &Sources, frames: &[FrameBoxes]) -> Vec<Refusal> {
    let still = |frame: &FrameBoxes| -> Vec<Placed> {
        let objects = frame.objects.iter().copied();
        objects
            .filter(|p| {
                analysis
                    .statements
                    .get(p.statement)
                    .is_some_and(|s| !s.moves)
            })
            .collect()
    };
    let Some(first) = frames.first() else {
        return Vec::new();
    };
    let objects = still(first);
    for frame in &frames[1..] {
        let others = still(frame);
        let pairs = objects.iter().zip(&others);
        let differing = pairs
            .into_iter()
            .find(|(a, b)| a != b)
            .map(|(a, _)| a.statement);
        let reason = "decor took this for still, and it is not: please report this";
        if let Some(statement) = differing {
            return vec![refusal(analysis, sources, statement, reason)];
        }
        if objects.len() != others.len()
            || (&frame.lights, &frame.camera) != (&first.lights, &first.camera)
        {
            return vec![refusal(analysis, sources, usize::MAX, reason)];
        }
    }
    Vec::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pixel_is_one_pixel() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("s.pov"), "sphere { 0, 1 }").unwrap();
        let pixels = |size: (u32, u32)| -> String {
            let ended = std::process::Command::new("povray")
                .args(["s.pov", "-F", "-D", "-V", "Statistic_Console=on"])
                .args([format!("+W{}", size.0), format!("+H{}", size.1)])
                .args(one_pixel(size))
                .current_dir(folder.path())
                .output()
                .expect("POV-Ray is installed");
            let said = String::from_utf8_lossy(&ended.stderr).into_owned();
            let (_, behind) = said.split_once("Pixels:").expect("it counts pixels");
            behind.split_whitespace().next().unwrap_or_default().into()
        };
        assert_eq!(pixels((80, 60)), "1");
        assert_eq!(pixels((80, 1)), "1");
    }
}

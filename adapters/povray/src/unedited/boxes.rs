//! Where the statements of a scene are in each frame, by POV-Ray itself: an
//! instrumented copy is parsed for all frames in one process, of whose pictures
//! one pixel is rendered.

use std::time::Duration;

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, RunContext};
use glam::DVec3;

use super::analysis::{Analysis, Refusal};
use super::instrument;
use super::source::{Edit, Sources};
use crate::plain::{PlainScene, quoted};
use crate::{PovRay, patiently};

/// POV-Ray calls an extent without end ±1e10.
const ENDLESS: f64 = 9e9;

/// Extents are kept in single precision, a corner and a length each, and are
/// moved and turned as such: this share of the largest coordinate covers it.
const ROUNDING: f64 = 2e-6;

/// And this, what is written with twelve digits behind the point.
const LEAST: f64 = 1e-9;

/// Lights' centres are known to this share of their coordinates.
const LIGHT_TOLERANCE: f64 = 1e-6;

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
}

/// What is where in a frame. A statement in a loop or a macro makes any number
/// of objects, none included.
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
    let frames = said.lines().collect::<Reading>().frames;
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

/// A frame as it is read.
#[derive(Default)]
struct Frame {
    boxes: FrameBoxes,
    cameras: usize,
    whole: bool,
}

/// All frames as they are read; what cannot be read leaves its frame not whole.
#[derive(Default)]
struct Reading {
    frames: Vec<Frame>,
}

impl<'l> FromIterator<&'l str> for Reading {
    fn from_iter<I: IntoIterator<Item = &'l str>>(lines: I) -> Self {
        let mut reading = Self::default();
        let mut broken = false;
        for line in lines {
            let mut words = line.split_whitespace();
            let kind = words.next().unwrap_or_default();
            let words: Vec<&str> = words.collect();
            if kind == "F" {
                broken = false;
                let frame = words.first().and_then(|n| n.parse().ok());
                reading.frames.push(Frame::default());
                if let (Some(frame), Some(last)) = (frame, reading.frames.last_mut()) {
                    last.boxes.frame = frame;
                    // No camera is POV-Ray's own.
                    last.boxes.camera = Some(Vec::new());
                }
                continue;
            }
            let Some(frame) = reading.frames.last_mut() else {
                continue;
            };
            broken |= frame.read(kind, &words).is_none();
            frame.whole = kind == "E" && !broken;
        }
        reading
    }
}

impl Frame {
    fn read(&mut self, kind: &str, words: &[&str]) -> Option<()> {
        match kind {
            "O" | "P" => {
                let statement = words.first()?.parse().ok()?;
                let points = vectors(&words[1..])?;
                let extent = match *points.as_slice() {
                    [min, max] => extent(min, max),
                    [min, max, ..] => plane(&points[2..])
                        .filter(|_| is_endless(min, max))
                        .unwrap_or_else(|| extent(min, max)),
                    _ => return None,
                };
                self.boxes.objects.push(Placed { statement, extent });
            }
            "L" => {
                let points = vectors(words.get(1..)?)?;
                let [a, b] = points[..] else { return None };
                if a.is_finite()
                    && (a - b).abs().max_element() <= LIGHT_TOLERANCE * (1.0 + b.length())
                {
                    self.boxes.lights.push(b);
                } else {
                    // Too far away, or out of shape.
                    self.boxes.lost_light = true;
                }
            }
            "C" => {
                self.cameras += 1;
                if self.cameras > 1 || words.contains(&"?") {
                    self.boxes.camera = None;
                }
                if let Some(camera) = &mut self.boxes.camera {
                    for word in words.chunks(4) {
                        let value = *vectors(word.get(1..)?)?.first()?;
                        camera.push((word[0].to_owned(), value));
                    }
                }
            }
            "E" => {}
            _ => return None,
        }
        Some(())
    }
}

fn vectors(words: &[&str]) -> Option<Vec<DVec3>> {
    let numbers: Vec<f64> = words
        .iter()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let whole = numbers.len().is_multiple_of(3);
    whole.then(|| numbers.chunks(3).map(DVec3::from_slice).collect())
}

fn is_endless(min: DVec3, max: DVec3) -> bool {
    let largest = min.abs().max_element().max(max.abs().max_element());
    // What is not a number has no end either.
    !(largest < ENDLESS && min.is_finite() && max.is_finite())
}

fn extent(min: DVec3, max: DVec3) -> Extent {
    if is_endless(min, max) {
        return Extent::Endless;
    }
    let largest = min.abs().max_element().max(max.abs().max_element());
    let room = DVec3::splat(largest * ROUNDING + LEAST);
    Extent::Box {
        min: min - room,
        max: max + room,
    }
}

/// Three rays along the axes: where they hit, and the normal there (none: 0).
fn plane(rays: &[DVec3]) -> Option<Extent> {
    let mut hits = rays
        .chunks(2)
        .filter(|hit| hit.len() == 2 && hit[1].length() > 0.5);
    let hit = hits.next()?;
    Some(Extent::Plane {
        point: hit[0],
        normal: hit[1].normalize(),
    })
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

    fn read(text: &str) -> Vec<Frame> {
        text.lines().collect::<Reading>().frames
    }

    #[test]
    fn records_are_read() {
        let frames = read(
            "F 3\nO 0 -1 -1 -1 1 1 2\nL 2 1 2 3 1 2 3\nC location 0 1 2 angle 40 40 40\n\
             P 1 -1e10 -1e10 -1e10 1e10 1e10 1e10 0 0 0 0 0 0 1 5 1 0 1 0 0 0 0 0 0 0\nE\nF 4\nE\n",
        );
        assert!(frames.iter().all(|frame| frame.whole));
        let frame = &frames[0].boxes;
        assert_eq!(
            (frame.frame, frame.lights.as_slice()),
            (3, &[DVec3::new(1.0, 2.0, 3.0)][..])
        );
        let camera = frame.camera.as_ref().expect("it is plain");
        assert_eq!(camera[1], ("angle".into(), DVec3::splat(40.0)));
        let Extent::Box { min, max } = frame.objects[0].extent else {
            panic!("it has an end")
        };
        assert!(min.z < -1.0 && max.z > 2.0 && max.z < 2.0001);
        let plane = Extent::Plane {
            point: DVec3::new(1.0, 5.0, 1.0),
            normal: DVec3::Y,
        };
        assert_eq!(frame.objects[1].extent, plane);
        assert_eq!(frames[1].boxes.camera, Some(Vec::new()));
    }

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

    #[test]
    fn what_cannot_be_read_is_not_whole() {
        for text in [
            "F 1\nO 0 1 2\nE\n",
            "F 1\nO 0 nan x 0 0 0 0\nE\n",
            "F 1\n",
            "F 1\nQ\nE\n",
        ] {
            assert!(!read(text)[0].whole, "{text}");
        }
        assert_eq!(
            read("F 1\nO 0 nan 0 0 0 0 0\nE\n")[0].boxes.objects[0].extent,
            Extent::Endless
        );
        assert_eq!(read("F 1\nC ?\nE\n")[0].boxes.camera, None);
        assert_eq!(
            read("F 1\nC up 0 1 0\nC up 0 1 0\nE\n")[0].boxes.camera,
            None
        );
        assert!(read("F 1\nL 0 1 2 3 1 2 4\nE\n")[0].boxes.lost_light);
        assert!(!read("F 1\nL 0 1 2 3 1 2 3\nE\n")[0].boxes.lost_light);
    }
}

//! Asks POV-Ray how large fragments are, and their words what they are.

use std::path::Path;

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, Bounds, Extent, Fragment, NativeFile, RunContext, Said};
use glam::DVec3;

use crate::call::fixed_switches;
use crate::extents::{Question, extents};
use crate::folder::Folder;
use crate::sources::{Library, LibraryWords};
use crate::survey;

/// POV-Ray calls an extent without end ±1e10.
const ENDLESS: f64 = 9e9;

/// Extents are kept in single precision, a corner and a length each: this share
/// of the largest coordinate covers both roundings.
const ROUNDING: f64 = 3e-7;

/// Parsing renders nothing: what takes longer hangs (a malformed picture can make
/// POV-Ray wait for ever).
const PARSE_LIMIT: std::time::Duration = std::time::Duration::from_secs(120);

/// Boxes that a fragment has at most: each is looked at for every frame.
const MOST_BOXES: usize = 24;

/// The file that the extents are written to.
const EXTENTS: &str = "extents.txt";

/// What is needed to look at fragments.
pub struct Inspection<'a> {
    /// The program.
    pub program: &'a Path,
    /// POV-Ray's own include files.
    pub library: &'a Library,
    /// What they define.
    pub words: &'a LibraryWords,
}

impl Inspection<'_> {
    /// Looks at all fragments, in two calls that parse them and render nothing.
    pub fn run(
        &self,
        fragments: &[&Fragment],
        includes: &[NativeFile],
        run: &RunContext,
    ) -> Result<Vec<Said>, AdapterError> {
        if fragments.is_empty() {
            return Ok(Vec::new());
        }
        let files: Vec<&NativeFile> = fragments.iter().map(|f| &f.file).collect();
        let wholes = self.wholes(&files, includes, run)?;
        let objects = self.ask(&files, includes, Question::Objects, run)?;
        // Text that cannot be told apart in spite of all is one object.
        let mut objects = objects.unwrap_or_default().into_iter();
        let said = files.iter().zip(wholes).map(|(file, whole)| {
            let findings = survey::fragment(file, includes, self.library, self.words);
            Said {
                bounds: whole.bounds(),
                extents: boxes(whole, objects.next()),
                optics: findings.optics,
                unlayerable: findings.unlayerable,
            }
        });
        Ok(said.collect())
    }

    /// The extents of fragments.
    fn wholes(
        &self,
        files: &[&NativeFile],
        includes: &[NativeFile],
        run: &RunContext,
    ) -> Result<Vec<Asked>, AdapterError> {
        match self.ask(files, includes, Question::Whole, run)? {
            Ok(answers) => Ok(answers.into_iter().map(|answer| answer.rest).collect()),
            // One of them is broken: ask each alone to find out which.
            Err(_) if files.len() > 1 => {
                let mut all = Vec::new();
                for file in files {
                    all.extend(self.wholes(&[file], includes, run)?);
                }
                Ok(all)
            }
            Err(said) => Err(AdapterError::BadInput {
                file: files[0].path.clone(),
                reason: format!("POV-Ray cannot read it\n{}", message(&said)),
            }),
        }
    }

    /// The answers, one a file, or what POV-Ray said instead.
    fn ask(
        &self,
        files: &[&NativeFile],
        includes: &[NativeFile],
        question: Question,
        run: &RunContext,
    ) -> Result<Result<Vec<Answer>, String>, AdapterError> {
        let text = extents(files, includes, self.library, question, EXTENTS);
        let folder = Folder::new(run, "inspect", &text)?;
        let out = folder.file(EXTENTS);
        let _ = std::fs::remove_file(&out);
        let mut args = fixed_switches();
        args.extend(["+W8", "+H8", "-F", "-A", "-UA"].map(str::to_owned));
        args.extend(folder.library_switches(files.iter().copied().chain(includes))?);
        let call = ProcessCall {
            program: self.program,
            args,
            folder: folder.path(),
            doing: "the size of fragments".into(),
            log: run.keep.then(|| folder.file("povray.log")),
        };
        run.tally.add_call(0);
        // The scene stops itself with #error: the file tells good from bad.
        let mut run = run.clone();
        run.timeout = run.timeout.min(PARSE_LIMIT);
        let ended = call.run(&run)?;
        let written = std::fs::read_to_string(&out).unwrap_or_default();
        Ok(answers(&written, files.len()).ok_or(ended.stderr))
    }
}

/// What POV-Ray says of a fragment.
#[derive(Clone, Debug, PartialEq)]
struct Answer {
    /// The objects that could be told apart.
    objects: Vec<Asked>,
    /// What encloses the others.
    rest: Asked,
}

/// One answer a fragment; `None` where one is missing.
fn answers(written: &str, count: usize) -> Option<Vec<Answer>> {
    let mut objects: Vec<Vec<Asked>> = vec![Vec::new(); count];
    let mut rests = Vec::new();
    for line in written.lines() {
        let rest = line.strip_prefix("all ");
        let (number, corners) = rest.unwrap_or(line).split_once(' ')?;
        let asked = parse(corners)?;
        let own = objects.get_mut(number.parse::<usize>().ok()?)?;
        if rest.is_some() {
            rests.push(asked);
        } else {
            own.push(asked);
        }
    }
    let answers = objects.into_iter().zip(&rests);
    let answers = answers.map(|(objects, &rest)| Answer { objects, rest });
    (rests.len() == count).then(|| answers.collect())
}

/// The boxes around a fragment, few and close.
fn boxes(whole: Asked, answer: Option<Answer>) -> Vec<Extent> {
    let Some(whole) = whole.bounded() else {
        return Vec::new();
    };
    let objects = answer.and_then(|answer| {
        let objects = answer.objects.into_iter().map(Asked::bounded);
        let mut objects: Vec<Extent> = objects.collect::<Option<_>>()?;
        // Without an end where the whole has one: there is no rest.
        objects.extend(answer.rest.bounded());
        Some(objects)
    });
    match objects.map(|objects| Extent::few(objects, MOST_BOXES)) {
        Some(boxes) if boxes.len() > 1 => boxes,
        _ => vec![whole],
    }
}

/// What POV-Ray says of the size of something.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Asked {
    Endless,
    Within(Extent),
}

impl Asked {
    fn bounds(self) -> Bounds {
        match self {
            Self::Endless => Bounds::Unbounded,
            Self::Within(extent) => Bounds::around_box(extent.min, extent.max),
        }
    }

    /// The box, where it is one.
    fn bounded(self) -> Option<Extent> {
        match self {
            Self::Within(extent) if extent.min.cmple(extent.max).all() => Some(extent),
            _ => None,
        }
    }
}

fn parse(line: &str) -> Option<Asked> {
    let numbers: Vec<f64> = line
        .split_whitespace()
        .map(|n| n.parse().ok())
        .collect::<Option<_>>()?;
    let [a, b, c, d, e, f] = numbers[..] else {
        return None;
    };
    let (min, max) = (DVec3::new(a, b, c), DVec3::new(d, e, f));
    let largest = min.abs().max_element().max(max.abs().max_element());
    if largest >= ENDLESS || !largest.is_finite() {
        return Some(Asked::Endless);
    }
    let room = DVec3::splat(largest * ROUNDING);
    Some(Asked::Within(Extent {
        min: min - room,
        max: max + room,
    }))
}

/// The lines of POV-Ray's output that are about the error.
fn message(said: &str) -> String {
    let lines: Vec<&str> = said.lines().collect();
    let first = lines.iter().position(|line| line.contains("Error"));
    match first {
        Some(first) => lines[first..].join("\n"),
        None => said.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn extents_are_rounded_outwards() {
        let asked = parse("-1 -1 -1 1 1 1").unwrap();
        let Bounds::Sphere(s) = asked.bounds() else {
            panic!("a box is bounded")
        };
        let extent = asked.bounded().unwrap();
        assert!(extent.min.cmplt(DVec3::splat(-1.0)).all() && extent.max.x < 1.000_001);
        assert!(s.radius > 3.0_f64.sqrt() && s.radius < 1.733);
        assert_eq!(parse("-10000000000 0 0 1 1 1"), Some(Asked::Endless));
        assert_eq!(parse("1 2 3"), None);
    }

    #[test]
    fn a_missing_answer_is_noticed() {
        let both = "0 0 0 0 1 1 1\nall 0 0 0 0 1 1 1\nall 1 0 0 0 2 2 2\n";
        let read = answers(both, 2).unwrap();
        assert_eq!((read[0].objects.len(), read[1].objects.len()), (1, 0));
        assert_eq!(read[1].rest, parse("0 0 0 2 2 2").unwrap());
        assert_eq!(answers(both, 3), None);
        assert_eq!(answers("0 0 0 0 1 1", 1), None);
        assert_eq!(answers("7 0 0 0 1 1 1\nall 0 0 0 0 1 1 1", 1), None);
    }

    #[test]
    fn objects_count_only_where_all_of_them_have_an_end() {
        let (whole, endless) = (parse("0 0 0 9 9 9").unwrap(), Asked::Endless);
        let (low, high) = (parse("0 0 0 1 1 1").unwrap(), parse("8 8 8 9 9 9").unwrap());
        let asked = |objects: &[Asked], rest| {
            let objects = objects.to_vec();
            boxes(whole, Some(Answer { objects, rest })).len()
        };
        assert_eq!(asked(&[low, high], endless), 2);
        assert_eq!(asked(&[low], high), 2);
        assert_eq!(asked(&[low, endless], high), 1);
        assert_eq!(boxes(whole, None), [whole.bounded().unwrap()]);
        assert!(boxes(endless, None).is_empty());
    }
}

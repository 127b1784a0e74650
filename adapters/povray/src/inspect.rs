//! Asks POV-Ray how large fragments are, and their words what they are.

use std::path::Path;

use decor_api::process::ProcessCall;
use decor_api::{AdapterError, Bounds, Extent, Fragment, NativeFile, RunContext, Said};
use glam::DVec3;

use crate::call::{Folder, fixed_switches};
use crate::scene_text::extents;
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
    /// Looks at all fragments in one call that parses them and renders nothing.
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
        let extents = self.extents(&files, includes, run)?;
        let said = files.iter().zip(extents).map(|(file, extent)| {
            let findings = survey::fragment(file, includes, self.library, self.words);
            Said {
                bounds: extent.bounds(),
                extent: extent.bounded(),
                optics: findings.optics,
                unlayerable: findings.unlayerable,
            }
        });
        Ok(said.collect())
    }

    fn extents(
        &self,
        files: &[&NativeFile],
        includes: &[NativeFile],
        run: &RunContext,
    ) -> Result<Vec<Asked>, AdapterError> {
        match self.ask(files, includes, run)? {
            Ok(extents) => Ok(extents),
            // One of them is broken: ask each alone to find out which.
            Err(_) if files.len() > 1 => {
                let mut all = Vec::new();
                for file in files {
                    all.extend(self.extents(&[file], includes, run)?);
                }
                Ok(all)
            }
            Err(said) => Err(AdapterError::BadInput {
                file: files[0].path.clone(),
                reason: format!("POV-Ray cannot read it\n{}", message(&said)),
            }),
        }
    }

    /// The extents, or what POV-Ray said instead.
    fn ask(
        &self,
        files: &[&NativeFile],
        includes: &[NativeFile],
        run: &RunContext,
    ) -> Result<Result<Vec<Asked>, String>, AdapterError> {
        let text = extents(files, includes, self.library, EXTENTS);
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
        let extents: Option<Vec<Asked>> = written.lines().map(parse).collect();
        Ok(match extents {
            Some(extents) if extents.len() == files.len() => Ok(extents),
            _ => Err(ended.stderr),
        })
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
}

//! Frames from blocks that are known and blocks that are traced.
//!
//! Blocks go from frame to frame as POV-Ray's own records, in its state file: it
//! takes them over, traces the others, and writes the finished picture itself, in
//! the user's own type, with its gamma, dithering and alpha. One thread: POV-Ray
//! with several does not always agree with itself.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use decor_api::{AdapterError, RunContext};

use super::blocks::{Blocks, Grid};
use crate::plain::{More, Part, PlainScene};
use crate::state::{self, Block};

/// Finished blocks, by number.
#[derive(Clone, Debug, Default)]
pub struct Finished {
    records: BTreeMap<usize, Vec<u8>>,
}

impl Finished {
    /// Adds blocks of a state file, those that are `wanted` and not known yet.
    ///
    /// # Errors
    /// [`AdapterError::BadOutput`] where the file is damaged, or where a wanted
    /// block is missing.
    pub fn add(&mut self, file: &Path, wanted: &Blocks) -> Result<(), AdapterError> {
        let bad = |reason: String| AdapterError::BadOutput {
            program: "povray".into(),
            file: file.to_owned(),
            reason,
        };
        let bytes = std::fs::read(file).map_err(AdapterError::io(file))?;
        let blocks = blocks_of(file, &bytes)?;
        let mut missing = wanted.clone();
        for block in blocks {
            let id = block.id as usize;
            if wanted.has(id) {
                missing.remove(id);
                let record = || block.record().to_vec();
                self.records.entry(id).or_insert_with(record);
            }
        }
        match missing.iter().next() {
            Some(block) => Err(bad(format!("block {block} is missing"))),
            None => Ok(()),
        }
    }

    /// The state file of a frame in which these blocks are to be traced.
    pub fn state(&self, traced: &Blocks) -> Vec<u8> {
        let known = self.records.iter().filter(|(id, _)| !traced.has(**id));
        state::with_records(known.map(|(_, record)| record.as_slice()))
    }
}

/// The state file of a frame of which only these blocks are traced, and all others
/// are left black.
pub fn only(grid: Grid, blocks: &Blocks) -> Vec<u8> {
    let ids = blocks.iter().map(|id| id as u32).collect();
    state::masked(grid.size, &decor_api::Blocks::usual(ids))
}

/// The blocks, of these, that two state files do not hold alike.
///
/// # Errors
/// [`AdapterError::BadOutput`], [`AdapterError::Io`].
pub fn differing(a: &Path, b: &Path, among: &Blocks) -> Result<Blocks, AdapterError> {
    let read = |file: &Path| std::fs::read(file).map_err(AdapterError::io(file));
    let (left, right) = (read(a)?, read(b)?);
    let mut unlike = among.clone();
    let theirs: BTreeMap<u32, Block<'_>> = blocks_of(b, &right)?
        .into_iter()
        .map(|block| (block.id, block))
        .collect();
    for block in blocks_of(a, &left)? {
        let same = theirs.get(&block.id).is_some_and(|its| its.is_same(&block));
        if same && among.has(block.id as usize) {
            unlike.remove(block.id as usize);
        }
    }
    Ok(unlike)
}

/// The blocks of a state file that was read.
pub(super) fn blocks_of<'b>(file: &Path, bytes: &'b [u8]) -> Result<Vec<Block<'b>>, AdapterError> {
    state::blocks(bytes).map_err(|error| AdapterError::BadOutput {
        program: "povray".into(),
        file: file.to_owned(),
        reason: error.to_string(),
    })
}

/// What a call took, in seconds of CPU, as POV-Ray says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// To read scenes.
    pub parse_s: f64,
    /// To trace pixels.
    pub trace_s: f64,
}

/// What a call gave.
#[derive(Debug)]
pub struct Traced {
    /// The frames' pictures, in order.
    pub pictures: Vec<(u32, PathBuf)>,
    /// Their blocks: state files.
    pub blocks: Vec<(u32, PathBuf)>,
    /// What it took.
    pub timing: Timing,
}

impl PlainScene {
    /// Renders a part in one call with one thread; `state` gives each frame's
    /// state file ([`Finished::state`]).
    ///
    /// # Errors
    /// Any [`AdapterError`].
    pub fn trace(
        &self,
        part: Part,
        state: &(dyn Fn(u32) -> Vec<u8> + Sync),
        run: &RunContext,
    ) -> Result<Traced, AdapterError> {
        let more = More {
            switches: vec!["Statistic_Console=on".into(), "+WT1".into()],
            state: Some(state),
        };
        let called = self.call(part, "traced", &more, run)?;
        Ok(Traced {
            pictures: called.pictures,
            blocks: called.states,
            timing: timing(&called.said),
        })
    }
}

/// The sums of the times in POV-Ray's statistics.
pub(super) fn timing(said: &str) -> Timing {
    let mut sum = Timing::default();
    let mut reading = true;
    for line in said.lines() {
        if let Some((name, _)) = line.split_once(" Time:") {
            reading = matches!(name.trim(), "Parse" | "Bounding");
        }
        let seconds = line
            .strip_suffix(" CPU-seconds total")
            .and_then(|rest| rest.rsplit_once(' '))
            .and_then(|(_, number)| number.parse::<f64>().ok());
        let into = if reading {
            &mut sum.parse_s
        } else {
            &mut sum.trace_s
        };
        *into += seconds.unwrap_or(0.0);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_several_frames() {
        let said = "\
  Parse Time:       0 hours  0 minutes  0 seconds (0.251 seconds)
              using 1 thread(s) with 0.250 CPU-seconds total
  Bounding Time:    0 hours  0 minutes  0 seconds (0.000 seconds)
              using 1 thread(s) with 0.125 CPU-seconds total
==== [Rendering...] ====
  Photon Time:      No photons
  Trace Time:       0 hours  0 minutes  2 seconds (2.024 seconds)
              using 1 thread(s) with 2.000 CPU-seconds total
  Parse Time:       0 hours  0 minutes  0 seconds (0.251 seconds)
              using 1 thread(s) with 0.500 CPU-seconds total
";
        let sum = timing(said);
        assert_eq!((sum.parse_s, sum.trace_s), (0.875, 2.0));
        assert_eq!(timing("nothing"), Timing::default());
    }
}

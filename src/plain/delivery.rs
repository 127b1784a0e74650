//! Puts finished frames where they belong.

use std::collections::BTreeMap;
use std::path::Path;

use decor_api::{AdapterError, RunContext};
use decor_povray::plain::{Part, PlainScene};

use super::Options;
use crate::frames::write_safely;
use crate::render::{RenderError, Watch};

/// Where finished frames go, and who is told.
#[derive(Clone, Copy)]
pub struct Delivery<'a> {
    pub scene: &'a PlainScene,
    pub options: &'a Options,
    pub watch: Watch<'a>,
    /// Frames that others show too, and these.
    pub repeated: &'a BTreeMap<u32, Vec<u32>>,
}

impl Delivery<'_> {
    /// Renders a part whole and delivers its frames; gives their number.
    pub fn part(&self, part: Part, run: &RunContext) -> Result<u64, RenderError> {
        let files = self.scene.render(part, run)?;
        let count = files.len() as u64;
        for (frame, file) in files {
            self.hand_over(frame, &file)?;
        }
        Ok(count)
    }

    /// Delivers a frame, if it is wanted.
    pub fn hand_over(&self, frame: u32, file: &Path) -> Result<(), RenderError> {
        if self.options.wanted.contains(&frame) {
            let place = self.options.out.join(self.scene.name(frame));
            for &later in self.repeated.get(&frame).into_iter().flatten() {
                let place = self.options.out.join(self.scene.name(later));
                write_safely(&place, &read(file)?)?;
                (self.watch)(later, &place);
            }
            self.deliver(file, &place)?;
            (self.watch)(frame, &place);
        }
        if !self.scene.leaves_pictures() {
            let _ = std::fs::remove_file(file);
        }
        Ok(())
    }

    fn deliver(&self, file: &Path, place: &Path) -> Result<(), RenderError> {
        if !self.scene.leaves_pictures() && std::fs::rename(file, place).is_ok() {
            return Ok(());
        }
        if same_file(file, place) {
            // POV-Ray's own place is the one that was asked for.
            return Ok(());
        }
        // Another file system, or a picture that stays: a copy.
        Ok(write_safely(place, &read(file)?)?)
    }
}

fn read(file: &Path) -> Result<Vec<u8>, AdapterError> {
    std::fs::read(file).map_err(|source| AdapterError::BadOutput {
        program: "povray".into(),
        file: file.to_owned(),
        reason: source.to_string(),
    })
}

fn same_file(a: &Path, b: &Path) -> bool {
    match (a.canonicalize(), b.canonicalize()) {
        (Ok(a), Ok(b)) => a == b,
        _ => false,
    }
}

//! A film that arrives scene by scene, with no knowledge of the future.

use std::ops::RangeInclusive;
use std::path::Path;

use decor_api::Size;

use super::build::Builder;
use super::error::FilmErrors;
use super::frame::FrameState;
use super::jsonl;
use super::lines::Place;
use super::mark::{Mark, Source};
use super::model::{Film, Identity, NamedFile, Scene};
use super::paths::Folder;

/// Scenes as JSON lines, read one at a time. Only the scene at hand and the one
/// before it are kept, however long the stream is.
///
/// A line shows frames: its own, and before it those since the last scene,
/// which is advanced to them. The first line must state the size as well.
#[derive(Debug)]
pub struct FilmStream {
    name: String,
    builder: Builder,
    /// Lines read so far.
    lines: usize,
    /// The last frame that was given out.
    shown: Option<u32>,
    /// The first frame of all.
    first: Option<u32>,
    /// The last one, where it is stated.
    last: Option<u32>,
    /// An error was given out: what follows has nothing to rest on.
    broken: bool,
}

impl FilmStream {
    /// A stream without a scene yet. `name` is what messages call it, `folder`
    /// what its paths are relative to.
    pub fn new(name: &str, folder: &Path, allow_outside: bool) -> Self {
        Self {
            name: name.to_owned(),
            builder: Builder::new(Folder::new(folder, allow_outside)),
            lines: 0,
            shown: None,
            first: None,
            last: None,
            broken: false,
        }
    }

    /// Reads the next line, with or without its end. Gives the frames that it
    /// shows; `None` where the line is blank.
    ///
    /// # Errors
    /// Everything that is wrong with the line. The stream cannot go on then:
    /// all further lines are blank to it.
    pub fn push_line(&mut self, line: &[u8]) -> Result<Option<RangeInclusive<u32>>, FilmErrors> {
        self.lines += 1;
        if self.broken {
            return Ok(None);
        }
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let line = match self.lines {
            1 => line.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(line),
            _ => line,
        };
        let place = Place {
            number: self.lines,
            start: 0,
        };
        match jsonl::scene(line, place, &mut self.builder.faults) {
            Ok(None) => return Ok(None),
            Ok(Some(draft)) => {
                self.builder.add(&draft);
                self.builder.check_stream(draft.mark);
            }
            Err(()) => {}
        }
        self.failed(line)?;
        let Some(number) = self.builder.newest() else {
            return Ok(None);
        };
        let from = self.shown.map_or(number, |shown| shown.saturating_add(1));
        self.shown = Some(number);
        self.first.get_or_insert(number);
        if self.builder.images.is_some() {
            self.last = self.builder.last();
        }
        Ok(Some(from..=number))
    }

    /// The stream is at its end: gives the frames up to the number of frames
    /// that it stated, where there are any.
    ///
    /// # Errors
    /// Where one of them cannot be, or the stream had no scene.
    pub fn finish(&mut self) -> Result<Option<RangeInclusive<u32>>, FilmErrors> {
        if self.broken {
            return Ok(None);
        }
        self.lines += 1;
        self.builder.check_end(Mark::span(self.lines, 0, 0, 0));
        self.failed(b"")?;
        let (Some(shown), Some(last)) = (self.shown, self.builder.last()) else {
            return Ok(None);
        };
        if last <= shown {
            return Ok(None);
        }
        self.shown = Some(last);
        Ok(Some(shown + 1..=last))
    }

    /// Frame `number`, where the last line or the end of the stream shows it;
    /// after it, what velocities predict. `None` before the first line, for
    /// earlier frames, and where a prediction has no camera.
    pub fn frame(&self, number: u32) -> Option<FrameState<'_>> {
        let scenes = self.builder.scenes();
        let scene = scenes.iter().rev().find(|scene| scene.number <= number)?;
        scene.now.state(&self.builder.interner.tables, number).ok()
    }

    /// The film from frame `number` on as far as it can be known now: its one
    /// scene is that frame, and what follows is what velocities predict, up to
    /// `last` or to where a prediction ends. `None` where
    /// [`frame`](Self::frame) gives nothing.
    ///
    /// A velocity that was wrong about the step to the newest scene, and is
    /// stated again, is not believed: the step itself counts in its place. So a
    /// stream that states no velocities is predicted, too.
    pub fn predicted(&self, number: u32, last: u32) -> Option<Film> {
        self.frame(number)?;
        let scenes = self.builder.scenes();
        let at = scenes.iter().rposition(|scene| scene.number <= number)?;
        let scene = &scenes[at];
        let mut now = scene.now.since(number);
        let before = at.checked_sub(1).map(|before| &scenes[before]);
        if let Some(before) = before.filter(|_| scene.number == number) {
            now.believe(&before.now, before.number, number);
        }
        let last = now.lasts(number, last.max(number));
        Some(Film {
            folder: self.builder.interner.folder(),
            size: self.size()?,
            last,
            tables: self.builder.interner.tables.clone(),
            scenes: vec![Scene {
                number,
                stated: scene.stated.clone(),
                now,
            }],
        })
    }

    /// The first frame and, where the stream states how long it is, the last.
    pub fn span(&self) -> (Option<u32>, Option<u32>) {
        (self.first, self.last)
    }

    /// The size of the pictures, from the first scene on.
    pub fn size(&self) -> Option<Size> {
        self.builder.size.as_ref().map(|size| size.value)
    }

    /// The objects so far; see [`Film::identities`](super::Film::identities).
    pub fn identities(&self) -> &[Identity] {
        &self.builder.interner.tables.identities
    }

    /// The descriptions so far; see
    /// [`Film::descriptions`](super::Film::descriptions).
    pub fn descriptions(&self) -> &[NamedFile] {
        &self.builder.interner.tables.descriptions
    }

    /// The declarations so far; see [`Film::includes`](super::Film::includes).
    pub fn includes(&self) -> impl Iterator<Item = &NamedFile> {
        self.builder.interner.tables.includes()
    }

    fn failed(&mut self, line: &[u8]) -> Result<(), FilmErrors> {
        if self.builder.faults.is_empty() {
            return Ok(());
        }
        self.broken = true;
        let source = Source {
            file: &self.name,
            bytes: line,
            only_line: Some(self.lines),
        };
        Err(source.errors(std::mem::take(&mut self.builder.faults)))
    }
}

//! From drafts to a film: everything that compares statements with each other,
//! with the whole film and with the file system.

use decor_api::Size;

use super::draft::{At, Draft, restate_images, restate_size};
use super::force::Force;
use super::intern::Interner;
use super::keyword::Keyword;
use super::mark::{Faults, Mark};
use super::model::{Film, Scene, Stated};
use super::paths::Folder;
use super::problem::Problem;

/// Takes drafts in the order of the text and gives a film, or what is wrong.
#[derive(Debug)]
pub(super) struct Builder {
    pub(super) faults: Faults,
    pub(super) interner: Interner,
    pub(super) size: Option<At<Size>>,
    pub(super) images: Option<At<u32>>,
    /// A size is stated, rightly or not, or something that may be one.
    size_attempted: bool,
    /// The first scene's number, where it could be read, and its place.
    first: Option<(Option<u32>, Mark)>,
    /// The largest scene number so far.
    newest: Option<u32>,
    /// Numbers and places of the scenes, to compare with the number of frames.
    numbers: Vec<(u32, Mark)>,
    force: Force,
    scenes: Vec<Scene>,
}

impl Builder {
    pub(super) fn new(folder: Folder) -> Self {
        Self {
            faults: Faults::default(),
            interner: Interner::new(folder),
            size: None,
            images: None,
            size_attempted: false,
            first: None,
            newest: None,
            numbers: Vec::new(),
            force: Force::default(),
            scenes: Vec::new(),
        }
    }

    /// Adds the next scene.
    pub(super) fn add(&mut self, draft: &Draft) {
        let is_first = self.first.is_none();
        let number = self.number(draft);
        self.whole_film(draft);
        if is_first {
            self.required(draft);
        }
        self.check_empty_lists(draft);
        self.interner.begin_scene();
        let stated = self.state(draft);
        self.force.update(number, draft, &stated);
        if let Some(now) = self.force.now() {
            self.scenes.push(Scene {
                number,
                stated,
                now,
            });
        }
    }

    /// A scene stands at `mark` that could not be read at all.
    pub(super) fn skip(&mut self, mark: Mark) {
        self.first.get_or_insert((None, mark));
        self.size_attempted = true;
    }

    /// The scene's number; the frames that the scene before it holds end here.
    fn number(&mut self, draft: &Draft) -> u32 {
        self.first.get_or_insert((draft.number, draft.mark));
        let Some(number) = draft.number else {
            return self.newest.map_or(0, |n| n.saturating_add(1));
        };
        match self.newest {
            Some(before) if number <= before => {
                let problem = Problem::SceneNotGrowing { number, before };
                self.faults.push(draft.mark, problem);
                return number;
            }
            Some(before) => {
                let ends_objects = draft.lists_objects();
                self.hold(before, number - 1, ends_objects);
            }
            None => {}
        }
        self.newest = Some(number);
        self.numbers.push((number, draft.mark));
        number
    }

    /// What holds for the whole film, wherever it is stated.
    fn whole_film(&mut self, draft: &Draft) {
        self.size_attempted |= draft.riddled || draft.attempted(Keyword::Size);
        let faults = &mut self.faults;
        if let Some(size) = draft.size {
            restate_size(&mut self.size, size, faults);
        }
        if let Some(images) = draft.images {
            restate_images(&mut self.images, images, faults);
        }
    }

    /// What the first scene must state.
    fn required(&mut self, draft: &Draft) {
        for keyword in [Keyword::Eye, Keyword::Aim, Keyword::Angles] {
            if !draft.riddled && !draft.attempted(keyword) {
                let what = keyword.name();
                self.faults.push(draft.mark, Problem::MissingFirst { what });
            }
        }
    }

    /// An empty list would be kept, not emptied, where there is one to keep.
    fn check_empty_lists(&mut self, draft: &Draft) {
        let objects = self.force.objects.as_ref();
        for list in &draft.empty_lists {
            let kept = match list.value {
                "objects" => objects.is_some_and(|(_, marks)| !marks.is_empty()),
                _ => !self.force.lights.is_empty(),
            };
            if kept {
                let what = list.value;
                self.faults.push(list.mark, Problem::EmptyList { what });
            }
        }
    }

    /// The draft with what it names resolved.
    fn state(&mut self, draft: &Draft) -> Stated {
        let Self {
            interner, faults, ..
        } = self;
        let includes = draft.includes.iter();
        let includes = includes.filter_map(|path| interner.include(path, faults));
        let includes = includes.collect();
        let sky = draft.sky.as_ref();
        let sky = sky.and_then(|path| interner.native(path, faults));
        let objects = draft.objects.iter();
        let objects = objects.filter_map(|object| interner.object(object, faults));
        let objects = objects.collect();
        Stated {
            eye: draft.eye.as_ref().map(|at| at.value),
            aim: draft.aim.as_ref().map(|at| at.value),
            up: draft.up.as_ref().map(|at| at.value),
            angles_deg: draft.angles_deg,
            shadows: draft.shadows,
            size: draft.size.as_ref().map(|at| at.value),
            background: draft.background,
            antialias: draft.antialias,
            images: draft.images.as_ref().map(|at| at.value),
            lights: draft.lights.clone().into(),
            includes,
            sky,
            objects,
        }
    }

    /// The frames `first..=last` show what is in force: is there a camera in
    /// all of them, and do the objects stay finite? Objects are looked at where
    /// their list ends.
    pub(super) fn hold(&mut self, first: u32, last: u32, ends_objects: bool) {
        let Self { force, faults, .. } = self;
        force.try_camera(first, last, faults);
        if !ends_objects {
            return;
        }
        let Some((objects, marks)) = &force.objects else {
            return;
        };
        // A list with an error in it has fewer objects than places.
        if objects.value.len() != marks.len() {
            return;
        }
        for (placed, mark) in objects.value.iter().zip(marks) {
            let pose = placed.pose_after(last.saturating_sub(objects.frame));
            if !pose.position.is_finite() || !pose.angles_deg.is_finite() {
                let name = self.interner.tables.identities[placed.object.0 as usize].name();
                let what = format!("the object `{name}`");
                faults.push(*mark, Problem::NotFiniteLater { what, frame: last });
            }
        }
    }

    /// The film's last frame, from what was stated so far.
    pub(super) fn last(&mut self) -> Option<u32> {
        let first = self.first?.0?;
        let Some(At {
            value: images,
            mark,
        }) = self.images
        else {
            return self.newest;
        };
        // Readers refuse a film of 0 frames.
        let last = first.checked_add(images.saturating_sub(1));
        if last.is_none() {
            let problem = Problem::TooManyFrames { first, images };
            self.faults.push(mark, problem);
        }
        last
    }

    /// The largest scene number so far.
    pub(super) fn newest(&self) -> Option<u32> {
        self.newest
    }

    /// The scenes so far; of a stream, the last two.
    pub(super) fn scenes(&self) -> &[Scene] {
        &self.scenes
    }

    /// After every scene of a stream, stated at `mark`: is all there that its
    /// frame needs? What no later frame needs is forgotten.
    pub(super) fn check_stream(&mut self, mark: Mark) {
        self.check_size(mark);
        let last = self.last();
        self.check_beyond(last);
        if let Some(newest) = self.newest {
            self.hold(newest, newest, true);
        }
        let old = self.scenes.len().saturating_sub(2);
        self.scenes.drain(..old);
    }

    /// At the end of a stream: was there anything, and are its remaining frames
    /// as they should be?
    pub(super) fn check_end(&mut self, end: Mark) {
        if self.first.is_none() {
            self.faults.push(end, Problem::NoFrame);
        }
        if let (Some(last), Some(newest)) = (self.last(), self.newest) {
            self.hold(newest, last.max(newest), true);
        }
    }

    fn check_size(&mut self, mark: Mark) {
        if self.size.is_none() && !self.size_attempted {
            let what = Keyword::Size.name();
            self.faults.push(mark, Problem::Missing { what });
        }
    }

    /// Does every scene lie in the film?
    fn check_beyond(&mut self, last: Option<u32>) {
        let Some(last) = last else { return };
        for (number, mark) in std::mem::take(&mut self.numbers) {
            if number > last {
                let problem = Problem::SceneBeyond { number, last };
                self.faults.push(mark, problem);
            }
        }
    }

    /// The text is at its end; `end` is a place for what it lacks.
    pub(super) fn finish(mut self, end: Mark) -> Result<Film, Faults> {
        let Some((_, first_mark)) = self.first else {
            if self.faults.is_empty() {
                self.faults.push(end, Problem::NoFrame);
            }
            return Err(self.faults);
        };
        self.check_size(first_mark);
        let last = self.last();
        self.check_beyond(last);
        if let (Some(last), Some(newest)) = (last, self.newest) {
            self.hold(newest, last.max(newest), true);
        }
        match (self.size, last) {
            (Some(size), Some(last)) if self.faults.is_empty() && !self.scenes.is_empty() => {
                Ok(Film {
                    folder: self.interner.folder(),
                    size: size.value,
                    last,
                    tables: self.interner.tables,
                    scenes: self.scenes,
                })
            }
            _ => Err(self.faults),
        }
    }
}

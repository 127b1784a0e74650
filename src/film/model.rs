//! The film: what was stated, checked, and what it means for every frame.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use decor_api::{Antialias, Light, Pose, Rgb, Size};
use glam::DVec3;

use super::frame::{FrameState, Now};

/// An identity's number in [`Film::identities`]: dense, from 0, in the order in
/// which the film first mentions the objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ObjectId(pub u32);

/// A description's number in [`Film::descriptions`]: dense, from 0, in the
/// order in which the film first mentions the paths.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct DescriptionId(pub u32);

/// One object throughout the film, whatever scenes it is in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Identity {
    pub(super) name: String,
    pub(super) named: bool,
    pub(super) description: DescriptionId,
}

impl Identity {
    /// What users call it: its `name=`, or else its path and its number among
    /// the unnamed objects of that path: `house.inc#3`, from 0. No two
    /// identities of a film have the same.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Was the name given by the film?
    pub fn is_named(&self) -> bool {
        self.named
    }

    /// Its description where it is first mentioned. A named object may have
    /// another one in a later scene: a frame's [`ObjectState`] says which.
    ///
    /// [`ObjectState`]: super::ObjectState
    pub fn description(&self) -> DescriptionId {
        self.description
    }
}

/// A file that a film names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NamedFile {
    pub(super) path: String,
    pub(super) file: PathBuf,
}

impl NamedFile {
    /// The path as the film states it, without the ending where it leaves it out.
    pub fn path(&self) -> &Path {
        Path::new(&self.path)
    }

    /// The file itself, absolute. It was there when the film was read.
    pub fn file(&self) -> &Path {
        &self.file
    }
}

/// A point that moves evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moving {
    pub(crate) position: DVec3,
    /// Per frame.
    pub(crate) velocity: DVec3,
}

/// How an object's pose changes, per frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Of the position, in scene units.
    pub velocity: DVec3,
    /// Of the three angles, in degrees.
    pub angles_velocity_deg: DVec3,
}

/// An object of a stated scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placed {
    pub(super) object: ObjectId,
    pub(super) description: DescriptionId,
    pub(super) pose: Pose,
    pub(super) motion: Motion,
}

/// What one scene states: `None` and empty where it says nothing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stated {
    pub(super) eye: Option<Moving>,
    pub(super) aim: Option<Moving>,
    pub(super) up: Option<DVec3>,
    pub(super) angles_deg: Option<(f64, f64)>,
    pub(super) shadows: Option<bool>,
    pub(super) size: Option<Size>,
    pub(super) background: Option<Rgb>,
    pub(super) antialias: Option<Option<Antialias>>,
    pub(super) images: Option<u32>,
    pub(super) lights: Arc<[Light]>,
    /// Numbers in the table of native files.
    pub(super) includes: Vec<u32>,
    pub(super) sky: Option<u32>,
    pub(super) objects: Arc<[Placed]>,
}

/// A stated scene, and what is in force in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Scene {
    pub(super) number: u32,
    pub(super) stated: Stated,
    pub(super) now: Now,
}

/// What a film's scenes name, stored once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Tables {
    pub(super) descriptions: Vec<NamedFile>,
    pub(super) identities: Vec<Identity>,
    /// Renderer-native files, of `*include` and `*sky`.
    pub(super) natives: Vec<NamedFile>,
    /// Which of them are included, in the order of first mention.
    pub(super) includes: Vec<u32>,
}

impl Tables {
    pub(super) fn includes(&self) -> impl Iterator<Item = &NamedFile> {
        self.includes.iter().map(|&i| &self.natives[i as usize])
    }
}

/// A film that cannot be wrong: it comes from a reader, which checked it.
///
/// It keeps what was stated, so that it can be written again without loss, and
/// gives for every frame what is in force there, advanced.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    pub(super) folder: PathBuf,
    pub(super) size: Size,
    pub(super) last: u32,
    pub(super) tables: Tables,
    /// At least one; numbers grow; none beyond `last`.
    pub(super) scenes: Vec<Scene>,
}

impl Film {
    /// The folder that its paths are relative to, absolute.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The size of its pictures.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The same film without antialiasing in any scene.
    #[must_use]
    pub fn without_antialiasing(mut self) -> Self {
        for scene in &mut self.scenes {
            scene.stated.antialias = scene.stated.antialias.map(|_| None);
            scene.now.antialias = None;
        }
        self
    }

    /// The numbers of its frames, at least one.
    pub fn frames(&self) -> RangeInclusive<u32> {
        let first = self.scenes.first().map_or(self.last, |scene| scene.number);
        first..=self.last
    }

    /// Every object of the film; an [`ObjectId`] is an index into it.
    pub fn identities(&self) -> &[Identity] {
        &self.tables.identities
    }

    /// One object of the film.
    ///
    /// # Panics
    /// Where the number is from another film.
    pub fn identity(&self, id: ObjectId) -> &Identity {
        &self.tables.identities[id.0 as usize]
    }

    /// Every object description that the film names, by path; a
    /// [`DescriptionId`] is an index into it. Two paths may lead to one file.
    pub fn descriptions(&self) -> &[NamedFile] {
        &self.tables.descriptions
    }

    /// The renderer-native declarations for every pass of every frame, in the
    /// order of first mention.
    pub fn includes(&self) -> impl Iterator<Item = &NamedFile> {
        self.tables.includes()
    }

    /// The numbers of the stated scenes, ascending. The frames between are
    /// their scenes advanced.
    pub fn scene_numbers(&self) -> impl ExactSizeIterator<Item = u32> {
        self.scenes.iter().map(|scene| scene.number)
    }

    /// Everything that frame `number` shows. Positions are those of the stated
    /// scene plus so many times the velocity, never summed up; what has no
    /// velocity has the same pose in all frames, bit for bit.
    ///
    /// # Panics
    /// Where `number` is not in [`frames`](Self::frames).
    pub fn frame(&self, number: u32) -> FrameState<'_> {
        assert!(
            self.frames().contains(&number),
            "frame {number} is not in the film"
        );
        self.scene_of(number)
            .now
            .state(&self.tables, number)
            .expect("validation tried the camera of every frame")
    }

    /// Frame `number` as it would be if nothing were stated after frame `from`:
    /// what velocities predict. `None` where the observer would run into the
    /// aim, where `from` is not in the film, or where `number` is before it.
    pub fn predicted(&self, from: u32, number: u32) -> Option<FrameState<'_>> {
        if !self.frames().contains(&from) || number < from {
            return None;
        }
        self.scene_of(from).now.state(&self.tables, number).ok()
    }

    /// The last scene stated at or before a frame of the film.
    fn scene_of(&self, number: u32) -> &Scene {
        let after = self.scenes.partition_point(|scene| scene.number <= number);
        &self.scenes[after.saturating_sub(1)]
    }
}

//! One frame of a film: what is in force there, advanced to it.

use std::path::Path;
use std::sync::Arc;

use decor_api::{Antialias, Camera, CameraError, Light, Pose, Rgb};
use glam::DVec3;

use super::model::{DescriptionId, Motion, Moving, NamedFile, ObjectId, Placed, Tables};

/// Everything that one frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameState<'f> {
    /// The frame's number.
    pub number: u32,
    /// From where it is seen.
    pub camera: Camera,
    /// The velocity of the observer, in scene units per frame.
    pub eye_velocity: DVec3,
    /// The point looked at.
    pub aim: DVec3,
    /// The velocity of the point looked at, in scene units per frame.
    pub aim_velocity: DVec3,
    /// The lights.
    pub lights: &'f [Light],
    /// Are shadows cast?
    pub shadows: bool,
    /// The colour where nothing is.
    pub background: Rgb,
    /// The renderer's own antialiasing; `None` is off.
    pub antialias: Option<Antialias>,
    /// What surrounds the scene, renderer-native.
    pub sky: Option<&'f NamedFile>,
    /// The objects, in the order of the film's lines.
    pub objects: Vec<ObjectState<'f>>,
}

/// One object in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ObjectState<'f> {
    /// Which object of the film it is. At most once in a frame.
    pub id: ObjectId,
    /// What users call it; see [`Identity::name`](super::Identity::name).
    pub name: &'f str,
    /// Which description it has.
    pub description: DescriptionId,
    /// The description's path as the film states it.
    pub path: &'f Path,
    /// Where it is.
    pub pose: Pose,
    /// Its velocities: what a prediction goes by where the future is not known.
    pub motion: Motion,
}

/// A value and the frame that it was stated in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Since<T> {
    pub(super) frame: u32,
    pub(super) value: T,
}

impl Since<Moving> {
    /// The position in frame `number`.
    pub(super) fn at(&self, number: u32) -> DVec3 {
        let steps = number.saturating_sub(self.frame);
        advanced(self.value.position, self.value.velocity, steps)
    }
}

/// What is in force from a stated scene on.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Now {
    pub(super) view: View,
    pub(super) shadows: bool,
    pub(super) background: Rgb,
    pub(super) antialias: Option<Antialias>,
    pub(super) lights: Arc<[Light]>,
    pub(super) sky: Option<u32>,
    pub(super) objects: Since<Arc<[Placed]>>,
}

/// What makes the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct View {
    pub(super) eye: Since<Moving>,
    pub(super) aim: Since<Moving>,
    pub(super) up: DVec3,
    pub(super) angles_deg: (f64, f64),
}

impl View {
    /// The camera of frame `number`.
    pub(super) fn camera(&self, number: u32) -> Result<Camera, CameraError> {
        let (eye, aim) = (self.eye.at(number), self.aim.at(number));
        Camera::look_at(eye, aim, self.up, self.angles_deg)
    }
}

impl Now {
    /// The frame `number`, at or after the scene.
    pub(super) fn state<'f>(
        &'f self,
        tables: &'f Tables,
        number: u32,
    ) -> Result<FrameState<'f>, CameraError> {
        let steps = number.saturating_sub(self.objects.frame);
        let objects = self.objects.value.iter().map(|placed| ObjectState {
            id: placed.object,
            name: &tables.identities[placed.object.0 as usize].name,
            description: placed.description,
            path: tables.descriptions[placed.description.0 as usize].path(),
            pose: placed.pose_after(steps),
            motion: placed.motion,
        });
        Ok(FrameState {
            number,
            camera: self.view.camera(number)?,
            eye_velocity: self.view.eye.value.velocity,
            aim: self.view.aim.at(number),
            aim_velocity: self.view.aim.value.velocity,
            lights: &self.lights,
            shadows: self.shadows,
            background: self.background,
            antialias: self.antialias,
            sky: self.sky.map(|i| &tables.natives[i as usize]),
            objects: objects.collect(),
        })
    }
}

impl Placed {
    /// The pose so many frames after it was stated.
    pub(super) fn pose_after(&self, steps: u32) -> Pose {
        Pose {
            position: advanced(self.pose.position, self.motion.velocity, steps),
            angles_deg: advanced(self.pose.angles_deg, self.motion.angles_velocity_deg, steps),
        }
    }
}

/// p + n·v. A component that does not move keeps its bits: −0 + 0 would not.
fn advanced(p: DVec3, v: DVec3, steps: u32) -> DVec3 {
    let n = f64::from(steps);
    let one = |p: f64, v: f64| {
        if steps == 0 || v == 0.0 { p } else { p + n * v }
    };
    DVec3::new(one(p.x, v.x), one(p.y, v.y), one(p.z, v.z))
}

//! What is in force after a scene, with the places where it was stated.

use std::sync::Arc;

use decor_api::{Antialias, CameraError, Light, Rgb};
use glam::DVec3;

use super::draft::{At, Draft};
use super::frame::{Now, Since, View};
use super::mark::{Faults, Mark};
use super::model::{Moving, Placed, Stated};
use super::problem::Problem;
use super::view_run::first_without_camera;

/// What is in force after the last scene, with its places; the parts that a
/// film must state may still be missing.
#[derive(Debug, Default)]
pub(super) struct Force {
    eye: Option<(Since<Moving>, Mark)>,
    aim: Option<(Since<Moving>, Mark)>,
    up: Option<(Since<DVec3>, Mark)>,
    angles_deg: Option<(f64, f64)>,
    shadows: bool,
    background: Rgb,
    antialias: Option<Antialias>,
    pub(super) lights: Arc<[Light]>,
    sky: Option<u32>,
    pub(super) objects: Option<(ObjectList, Vec<Mark>)>,
    trial: Trial,
}

/// The last list of objects.
type ObjectList = Since<Arc<[Placed]>>;

/// Does what is in force make a camera?
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Trial {
    #[default]
    Open,
    Good,
    /// No, and that was said.
    Bad,
}

impl Force {
    /// A scene states something new.
    pub(super) fn update(&mut self, number: u32, draft: &Draft, stated: &Stated) {
        let since = |at: &At<Moving>| {
            let value = at.value;
            (
                Since {
                    frame: number,
                    value,
                },
                at.mark,
            )
        };
        if let Some(eye) = &draft.eye {
            self.eye = Some(since(eye));
            self.trial = Trial::Open;
        }
        if let Some(aim) = &draft.aim {
            self.aim = Some(since(aim));
            self.trial = Trial::Open;
        }
        if let Some(up) = &draft.up {
            let value = up.value;
            self.up = Some((
                Since {
                    frame: number,
                    value,
                },
                up.mark,
            ));
            self.trial = Trial::Open;
        }
        self.angles_deg = stated.angles_deg.or(self.angles_deg);
        self.shadows = stated.shadows.unwrap_or(self.shadows);
        self.background = stated.background.unwrap_or(self.background);
        self.antialias = stated.antialias.unwrap_or(self.antialias);
        self.sky = stated.sky.or(self.sky);
        if !stated.lights.is_empty() {
            self.lights = stated.lights.clone();
        }
        if draft.lists_objects() || self.objects.is_none() {
            let value = stated.objects.clone();
            let marks = draft.objects.iter().map(|object| object.mark).collect();
            self.objects = Some((
                Since {
                    frame: number,
                    value,
                },
                marks,
            ));
        }
    }

    fn view(&self) -> Option<View> {
        Some(View {
            eye: self.eye.as_ref()?.0,
            aim: self.aim.as_ref()?.0,
            up: self.up.as_ref().map_or(DVec3::Y, |(up, _)| up.value),
            angles_deg: self.angles_deg?,
        })
    }

    /// All of it, where nothing is missing.
    pub(super) fn now(&self) -> Option<Now> {
        Some(Now {
            view: self.view()?,
            shadows: self.shadows,
            background: self.background,
            antialias: self.antialias,
            lights: self.lights.clone(),
            sky: self.sky,
            objects: self.objects.as_ref()?.0.clone(),
        })
    }

    /// Is there a camera in the frames `first..=last`? What is wrong is said
    /// once.
    pub(super) fn try_camera(&mut self, first: u32, last: u32, faults: &mut Faults) {
        let (Some((eye, eye_mark)), Some((aim, aim_mark))) = (self.eye, self.aim) else {
            return;
        };
        let still = eye.value.velocity == DVec3::ZERO && aim.value.velocity == DVec3::ZERO;
        if self.trial == Trial::Bad || (self.trial == Trial::Good && still) {
            return;
        }
        let view = View {
            eye,
            aim,
            up: self.up.map_or(DVec3::Y, |(up, _)| up.value),
            // Angles are checked by themselves, and may be missing here.
            angles_deg: self.angles_deg.unwrap_or((60.0, 60.0)),
        };
        let Some((frame, error)) = first_without_camera(&view, first..=last) else {
            self.trial = Trial::Good;
            return;
        };
        self.trial = Trial::Bad;
        let mut causes = vec![
            Cause::of_point(&eye, eye_mark),
            Cause::of_point(&aim, aim_mark),
        ];
        if let (CameraError::UpAlongView, Some((up, mark))) = (error, self.up) {
            causes.push(Cause {
                frame: up.frame,
                mark,
                moves: false,
            });
        }
        let (eye_there, aim_there) = (eye.at(frame), aim.at(frame));
        if error == CameraError::NotFinite {
            causes.swap_remove(if eye_there.is_finite() { 0 } else { 1 });
        }
        // What is stated in the frame is to blame before what moves there, and
        // that before what stands; of equals, the newer.
        let blame = |cause: &&Cause| (cause.frame == frame, cause.moves, cause.mark.line);
        let Some(cause) = causes.iter().max_by_key(blame) else {
            return;
        };
        let later = (cause.frame != frame).then_some(frame);
        let problem = match error {
            CameraError::NotFinite => {
                let what = if eye_there.is_finite() { "aim" } else { "eye" };
                let what = format!("the {what}");
                Problem::NotFiniteLater { what, frame }
            }
            CameraError::EyeIsAim if eye_there != aim_there => Problem::TooFarApart { frame },
            CameraError::EyeIsAim => Problem::EyeIsAim { frame: later },
            CameraError::UpAlongView | CameraError::Angle => Problem::UpAlongView { frame: later },
        };
        faults.push(cause.mark, problem);
    }
}

/// A statement that a camera fails by.
struct Cause {
    frame: u32,
    mark: Mark,
    moves: bool,
}

impl Cause {
    fn of_point(point: &Since<Moving>, mark: Mark) -> Self {
        Self {
            frame: point.frame,
            mark,
            moves: point.value.velocity != DVec3::ZERO,
        }
    }
}

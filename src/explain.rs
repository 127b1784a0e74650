//! Why each object of a frame has its class, in numbers.

use decor_api::{Bounds, Size, Window};
use glam::DVec2;

use crate::film::{FrameState, ObjectState};
use crate::motion::{Lenses, ObserverMotion, Projection, Screen, bound_px, project_sphere};
use crate::plan::{FramePlan, Plan};
use crate::segmentation::{Class, Reason};
use crate::stage::Stage;

/// An ellipse in the picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outline {
    centre: DVec2,
    major: DVec2,
    minor: DVec2,
}

impl Outline {
    /// The point at an angle, in radians.
    pub fn point(&self, angle_rad: f64) -> DVec2 {
        let (sin, cos) = angle_rad.sin_cos();
        self.centre + self.major * cos + self.minor * sin
    }

    /// Its area, in pixels.
    pub fn area_px(&self) -> f64 {
        std::f64::consts::PI * (self.major.x * self.minor.y - self.major.y * self.minor.x).abs()
    }
}

/// One object of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Explained {
    /// What users call it.
    pub name: String,
    /// Its class in the period.
    pub class: Class,
    /// Why.
    pub reason: Reason,
    /// How far it moves in the picture from the period's first frame to this
    /// one, in pixels, never below the truth; `None` where that is unbounded.
    pub motion_px: Option<f64>,
    /// The part of it that is translation, of the object and the observer.
    pub translation_px: Option<f64>,
    /// The part of it that is rotation.
    pub rotation_px: Option<f64>,
    /// The area of its ellipse, in pixels, also where it is outside of the
    /// picture; `None` where it has none.
    pub area_px: Option<f64>,
    /// Its ellipse.
    pub outline_px: Option<Outline>,
    /// The way of its sphere's centre since the period's first frame.
    pub path_px: Option<(DVec2, DVec2)>,
}

/// A frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Explanation {
    /// Its number.
    pub frame: u32,
    /// The first frame of its period.
    pub start: u32,
    /// Why the whole frame is rendered, where it is.
    pub whole: Option<String>,
    /// Its objects, in the film's order.
    pub objects: Vec<Explained>,
    /// Where fast objects are rendered.
    pub windows: Vec<Window>,
    /// Where the full scene is rendered again.
    pub blocks: Vec<Window>,
}

/// Explains a frame of a plan; `None` where the plan does not have it.
pub fn explain(stage: &Stage, plan: &Plan, frame: u32) -> Option<Explanation> {
    let period = plan.periods.iter().find(|p| p.numbers().contains(&frame))?;
    let (first, now) = (stage.film.frame(period.start), stage.film.frame(frame));
    let size = stage.size();
    let view = View {
        observer: ObserverMotion::between(&first.camera, &now.camera),
        lenses: Lenses::between(&first.camera, &now.camera, size),
        first: &first,
        now: &now,
        size,
    };
    let objects = now
        .objects
        .iter()
        .filter_map(|object| {
            let segmented = period.objects.iter().find(|s| s.object == object.id)?;
            let before = first.objects.iter().find(|other| other.id == object.id);
            let bounds = stage.prototype(object).bounds;
            let mut explained = view.explain(before, object, &bounds);
            explained.class = segmented.class;
            explained.reason = segmented.reason.clone();
            Some(explained)
        })
        .collect();
    let (windows, blocks) = match &period.frames[(frame - period.start) as usize] {
        FramePlan::Whole => (Vec::new(), Vec::new()),
        FramePlan::Layered { fast, blocks, .. } => (fast.clone(), blocks.runs().collect()),
    };
    Some(Explanation {
        frame,
        start: period.start,
        whole: period.whole.as_ref().map(ToString::to_string),
        objects,
        windows,
        blocks,
    })
}

struct View<'a> {
    observer: ObserverMotion,
    lenses: Lenses,
    first: &'a FrameState<'a>,
    now: &'a FrameState<'a>,
    size: Size,
}

impl View<'_> {
    fn explain(
        &self,
        before: Option<&ObjectState<'_>>,
        object: &ObjectState<'_>,
        bounds: &Bounds,
    ) -> Explained {
        let mut explained = Explained {
            name: object.name.to_owned(),
            class: Class::Fast,
            reason: Reason::Still,
            motion_px: None,
            translation_px: None,
            rotation_px: None,
            area_px: None,
            outline_px: None,
            path_px: None,
        };
        let Bounds::Sphere(sphere) = bounds else {
            let still = before.is_some_and(|b| b.pose == object.pose)
                && self.first.camera == self.now.camera;
            explained.motion_px = still.then_some(0.0);
            return explained;
        };
        let centre = self
            .now
            .camera
            .to_camera(object.pose.transform().transform_point3(sphere.centre));
        if let Projection::Ellipse(ellipse) = project_sphere(centre, sphere.radius) {
            let screen = Screen::of(&self.now.camera, self.size);
            let middle = screen.to_px(ellipse.centre);
            let arm = |direction: DVec2, length: f64| {
                screen.to_px(ellipse.centre + direction * length) - middle
            };
            let outline = Outline {
                centre: middle,
                major: arm(ellipse.direction, ellipse.semi_major),
                minor: arm(ellipse.direction.perp(), ellipse.semi_minor),
            };
            explained.area_px = Some(outline.area_px());
            explained.outline_px = Some(outline);
        }
        if let Some(before) = before {
            let motion = self.observer.of(&before.pose, &object.pose, sphere);
            let finite = |px: f64| px.is_finite().then_some(px);
            let still = before.pose == object.pose && self.first.camera == self.now.camera;
            if still {
                explained.motion_px = Some(0.0);
                explained.translation_px = Some(0.0);
                explained.rotation_px = Some(0.0);
            } else {
                explained.motion_px = finite(bound_px(&motion, &self.lenses));
                explained.translation_px =
                    finite(bound_px(&motion.translation_only(), &self.lenses));
                explained.rotation_px = finite(bound_px(&motion.rotation_only(), &self.lenses));
            }
            let place = |state: &FrameState<'_>, object: &ObjectState<'_>| {
                let point = object.pose.transform().transform_point3(sphere.centre);
                state.camera.project(self.size, point).map(DVec2::from)
            };
            if let (Some(a), Some(b)) = (place(self.first, before), place(self.now, object))
                && a != b
            {
                explained.path_px = Some((a, b));
            }
        }
        explained
    }
}

//! One scene as a reader found it: every value allowed by itself, nothing yet
//! compared with anything else.

use decor_api::{Antialias, Light, Pose, Rgb, Size};
use glam::DVec3;

use super::keyword::Keyword;
use super::mark::{Faults, Mark};
use super::model::{Motion, Moving};
use super::problem::Problem;

/// A value and where it was stated.
#[derive(Clone, Copy, Debug)]
pub(super) struct At<T> {
    pub(super) value: T,
    pub(super) mark: Mark,
}

/// An object as it was stated.
#[derive(Clone, Debug)]
pub(super) struct DraftObject {
    pub(super) path: At<String>,
    pub(super) name: Option<At<String>>,
    pub(super) pose: Pose,
    pub(super) motion: Motion,
}

/// A scene as it was stated.
#[derive(Clone, Debug)]
pub(super) struct Draft {
    /// `None` where the number could not be read.
    pub(super) number: Option<u32>,
    /// The scene's number, or the whole scene.
    pub(super) mark: Mark,
    pub(super) eye: Option<At<Moving>>,
    pub(super) aim: Option<At<Moving>>,
    pub(super) up: Option<At<DVec3>>,
    pub(super) angles_deg: Option<(f64, f64)>,
    pub(super) shadows: Option<bool>,
    pub(super) size: Option<At<Size>>,
    pub(super) background: Option<Rgb>,
    pub(super) antialias: Option<Option<Antialias>>,
    pub(super) images: Option<At<u32>>,
    pub(super) lights: Vec<Light>,
    pub(super) includes: Vec<At<String>>,
    pub(super) sky: Option<At<String>>,
    pub(super) objects: Vec<At<DraftObject>>,
    /// The scene lists an object that could not be used.
    pub(super) riddled_objects: bool,
    /// Lists that were stated with nothing in them: `objects`, `lights`.
    pub(super) empty_lists: Vec<At<&'static str>>,
    /// What was stated, also where its values could not be used, and the line.
    attempts: Vec<(Keyword, usize)>,
    /// Something could not be told: what seems missing may be meant by it.
    pub(super) riddled: bool,
}

impl Draft {
    /// A scene that states nothing yet.
    pub(super) fn new(number: Option<u32>, mark: Mark) -> Self {
        Self {
            number,
            mark,
            eye: None,
            aim: None,
            up: None,
            angles_deg: None,
            shadows: None,
            size: None,
            background: None,
            antialias: None,
            images: None,
            lights: Vec::new(),
            includes: Vec::new(),
            sky: None,
            objects: Vec::new(),
            riddled_objects: false,
            empty_lists: Vec::new(),
            attempts: Vec::new(),
            riddled: false,
        }
    }

    /// Notes that a scene states `keyword` at `mark`, rightly or not. Twice is
    /// an error but for what comes in lists, or may be repeated if it is the same.
    pub(super) fn attempt(&mut self, keyword: Keyword, mark: Mark, faults: &mut Faults) {
        use Keyword::{Images, Include, Light, Size};
        let repeatable = matches!(keyword, Light | Include | Size | Images);
        match self.attempts.iter().find(|(k, _)| *k == keyword) {
            Some(_) if repeatable => {}
            Some((_, line)) => {
                let (what, line) = (keyword.name(), *line);
                faults.push(mark, Problem::StatedTwice { what, line });
            }
            None => self.attempts.push((keyword, mark.line)),
        }
    }

    /// Does the scene list objects, whether they can be used or not?
    pub(super) fn lists_objects(&self) -> bool {
        self.riddled_objects || !self.objects.is_empty()
    }

    /// Was it stated, rightly or not?
    pub(super) fn attempted(&self, keyword: Keyword) -> bool {
        self.attempts.iter().any(|(k, _)| *k == keyword)
    }
}

/// The size holds for the whole film.
pub(super) fn restate_size(kept: &mut Option<At<Size>>, stated: At<Size>, faults: &mut Faults) {
    let show = |size: &Size| format!("{} × {}", size.width, size.height);
    restate(Keyword::Size, kept, stated, show, faults);
}

/// The number of frames holds for the whole film.
pub(super) fn restate_images(kept: &mut Option<At<u32>>, stated: At<u32>, faults: &mut Faults) {
    restate(Keyword::Images, kept, stated, u32::to_string, faults);
}

/// Keeps the first statement; another one must say the same.
fn restate<T: PartialEq>(
    keyword: Keyword,
    kept: &mut Option<At<T>>,
    stated: At<T>,
    show: impl Fn(&T) -> String,
    faults: &mut Faults,
) {
    match kept {
        None => *kept = Some(stated),
        Some(kept) if kept.value == stated.value => {}
        Some(kept) => {
            let problem = Problem::Restated {
                what: keyword.name(),
                before: show(&kept.value),
                line: kept.mark.line,
            };
            faults.push(stated.mark, problem);
        }
    }
}

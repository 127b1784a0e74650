//! The segmentation: for every object of a period, its class and why.
//!
//! Thesis, III-2. An object that cannot be judged with certainty is `Fast`: to
//! render it in vain is better than to keep an error.

use std::collections::HashMap;
use std::fmt;

use decor_api::{Bounds, Size, Sphere};
use rayon::prelude::*;
use serde::Serialize;

use crate::film::{FrameState, ObjectId, ObjectState};
use crate::motion::{self, Lenses, ObserverMotion, Projection, Sighting};

/// The answers of the segmentation (thesis: IMMOBILE, CLIPPE, LENT, RAPIDE).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Does not move relative to the observer, the lights and the environment.
    Immobile,
    /// Never in view during the period.
    Clipped,
    /// Moves in the picture by the threshold at most.
    Slow,
    /// Moves farther, or nobody knows how far: rendered in every frame.
    Fast,
}

impl Class {
    /// All of them, in order.
    pub const ALL: [Self; 4] = [Self::Immobile, Self::Clipped, Self::Slow, Self::Fast];

    /// Is the object part of the décor?
    pub fn in_decor(self) -> bool {
        self != Self::Fast
    }
}

impl fmt::Display for Class {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Immobile => "immobile",
            Self::Clipped => "clipped",
            Self::Slow => "slow",
            Self::Fast => "fast",
        })
    }
}

/// Which measure of motion decides.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, clap::ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Measure {
    /// The closed bound: never below the true motion.
    #[default]
    Bound,
    /// The thesis's own (chapter II): usually tighter, not always above.
    Thesis,
}

/// Why an object has its class.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// Same pose in every frame of the period, and so is all around it.
    Still,
    /// It has no surface.
    Empty,
    /// Its sphere stays out of view.
    OutOfView,
    /// Moves by so many pixels, not more than the threshold.
    MovesLittle {
        /// Pixels.
        moved_px: f64,
        /// Pixels.
        threshold_px: f64,
    },
    /// Moves by so many pixels, more than the threshold.
    MovesFar {
        /// Pixels.
        moved_px: f64,
        /// Pixels.
        threshold_px: f64,
        /// The frame that it was measured to.
        frame: u32,
    },
    /// The observer is inside of its sphere.
    ObserverInside {
        /// The frame.
        frame: u32,
    },
    /// The picture of its sphere has no end.
    UnboundedEllipse {
        /// The frame.
        frame: u32,
    },
    /// It has no end, and it or the observer moves.
    Endless,
    /// It is out of view at first, and enters it.
    EntersView {
        /// The frame.
        frame: u32,
    },
    /// Its description changes in this frame.
    Changes {
        /// The frame.
        frame: u32,
    },
    /// It is not there in this frame of the period.
    Absent {
        /// The frame.
        frame: u32,
    },
    /// A light, the background, the sky or the opening of the view changes.
    SurroundingsChange,
    /// It moves under lights, and its shadow may go anywhere.
    ShadowMoves,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Still => write!(f, "does not move"),
            Self::Empty => write!(f, "has no surface"),
            Self::OutOfView => write!(f, "stays out of view"),
            Self::MovesLittle {
                moved_px,
                threshold_px,
            } => {
                write!(
                    f,
                    "moved {} px ≤ {} px",
                    short(*moved_px),
                    short(*threshold_px)
                )
            }
            Self::MovesFar {
                moved_px,
                threshold_px,
                frame,
            } => write!(
                f,
                "moved {} px > {} px until frame {frame}",
                short(*moved_px),
                short(*threshold_px)
            ),
            Self::ObserverInside { frame } => write!(f, "observer inside in frame {frame}"),
            Self::UnboundedEllipse { frame } => write!(f, "unbounded ellipse in frame {frame}"),
            Self::Endless => write!(f, "has no end, and does not stay in place"),
            Self::EntersView { frame } => write!(f, "enters the view in frame {frame}"),
            Self::Changes { frame } => write!(f, "has another description in frame {frame}"),
            Self::Absent { frame } => write!(f, "is not there in frame {frame}"),
            Self::ShadowMoves => write!(f, "its shadow may move farther than itself"),
            Self::SurroundingsChange => {
                write!(
                    f,
                    "a light, the background or the opening of the view changes"
                )
            }
        }
    }
}

/// A number of pixels for people: three digits.
fn short(px: f64) -> String {
    if px == 0.0 {
        "0".into()
    } else if px.abs() < 1e-3 || px.abs() >= 1e5 {
        format!("{px:.1e}")
    } else {
        let digits = (2 - px.abs().log10().floor() as i32).clamp(0, 5) as usize;
        let text = format!("{px:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').to_owned()
        } else {
            text
        }
    }
}

/// An object's class in a period.
#[derive(Clone, Debug, PartialEq)]
pub struct Segmented {
    /// Which object.
    pub object: ObjectId,
    /// Its class.
    pub class: Class,
    /// Why.
    pub reason: Reason,
    /// How far it moves in the picture during the period, in pixels; +∞ where
    /// that is unbounded. Of a fast object it is one of its motions, not the
    /// largest.
    pub motion_px: f64,
}

/// By what objects are judged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// An object may move so far, in pixels, and stay in the décor.
    pub threshold_px: f64,
    /// Which measure decides.
    pub measure: Measure,
    /// The size of the picture.
    pub size: Size,
}

/// Is everything around the objects the same in both frames, the observer's
/// place and view aside?
pub fn same_environment(a: &FrameState<'_>, b: &FrameState<'_>) -> bool {
    a.lights == b.lights
        && a.shadows == b.shadows
        && a.background == b.background
        && a.sky == b.sky
        && a.antialias == b.antialias
}

/// The segmentation of a period: the classes of all objects that any of its
/// frames has, in the order of their numbers. Every frame is looked at.
/// `bounds` gives what encloses an object, in its own coordinates. The result
/// does not depend on the number of threads.
pub fn segment<B>(frames: &[FrameState<'_>], bounds: B, rule: &Rule) -> Vec<Segmented>
where
    B: Fn(&ObjectState<'_>) -> Bounds + Sync,
{
    segment_towards(frames, None, bounds, rule)
}

/// The segmentation of a period whose décor dissolves towards `target`, a later
/// frame. Meanwhile a pixel may show an object as it was in the first frame or
/// as it will be in the target: it is slow only if its motion from the first
/// frame to each, *and* from each to the target, is within the threshold.
pub fn segment_towards<B>(
    frames: &[FrameState<'_>],
    target: Option<&FrameState<'_>>,
    bounds: B,
    rule: &Rule,
) -> Vec<Segmented>
where
    B: Fn(&ObjectState<'_>) -> Bounds + Sync,
{
    let Some(first) = frames.first() else {
        return Vec::new();
    };
    let seen: Vec<&FrameState<'_>> = frames.iter().chain(target).collect();
    let judge = Judge::new(&seen, frames.len(), rule);
    let present: Vec<Segmented> = first
        .objects
        .par_iter()
        .enumerate()
        .map(|(index, object)| judge.judge(index, object, bounds(object)))
        .collect();
    let mut all = present;
    // What comes later is not in the décor.
    let mut known: std::collections::HashSet<ObjectId> =
        first.objects.iter().map(|object| object.id).collect();
    for state in &frames[1..] {
        for object in &state.objects {
            if known.insert(object.id) {
                all.push(Segmented {
                    object: object.id,
                    class: Class::Fast,
                    reason: Reason::Absent {
                        frame: first.number,
                    },
                    motion_px: f64::INFINITY,
                });
            }
        }
    }
    all.sort_by_key(|segmented| segmented.object);
    all
}

/// What all objects of a period are judged with.
struct Judge<'a, 'f> {
    /// The period's frames, and behind them the target, where there is one.
    frames: &'a [&'a FrameState<'f>],
    /// How many of them are shown: all but the target.
    shown: usize,
    rule: &'a Rule,
    /// The observer's motion from the first frame to each.
    observer: Vec<(ObserverMotion, Lenses)>,
    /// The observer's motion from each frame to the target.
    onward: Vec<(ObserverMotion, Lenses)>,
    /// Does the observer stay, all the time?
    observer_stays: bool,
    /// Does the environment stay?
    environment_stays: bool,
    /// Where frames list their objects in another order than the first.
    places: Vec<Option<HashMap<ObjectId, usize>>>,
}

impl<'a, 'f> Judge<'a, 'f> {
    fn new(frames: &'a [&'a FrameState<'f>], shown: usize, rule: &'a Rule) -> Self {
        let first = frames[0];
        let between = |a: &FrameState<'_>, b: &FrameState<'_>| {
            (
                ObserverMotion::between(&a.camera, &b.camera),
                Lenses::between(&a.camera, &b.camera, rule.size),
            )
        };
        let observer = frames.iter().map(|state| between(first, state)).collect();
        let onward = match frames.get(shown) {
            Some(target) => frames.iter().map(|state| between(state, target)).collect(),
            None => Vec::new(),
        };
        let same_order = |state: &FrameState<'_>| {
            state.objects.len() == first.objects.len()
                && state
                    .objects
                    .iter()
                    .zip(&first.objects)
                    .all(|(a, b)| a.id == b.id)
        };
        let places = frames
            .iter()
            .map(|state| {
                (!same_order(state)).then(|| {
                    state
                        .objects
                        .iter()
                        .enumerate()
                        .map(|(k, object)| (object.id, k))
                        .collect()
                })
            })
            .collect();
        Self {
            frames,
            shown,
            rule,
            observer,
            onward,
            observer_stays: frames[..shown]
                .iter()
                .all(|state| state.camera == first.camera),
            environment_stays: frames[..shown]
                .iter()
                .all(|state| same_environment(first, state)),
            places,
        }
    }

    /// The object in frame `k` of the period.
    fn find(&self, k: usize, index: usize, id: ObjectId) -> Option<&'a ObjectState<'f>> {
        let place = match &self.places[k] {
            None => index,
            Some(places) => *places.get(&id)?,
        };
        self.frames[k].objects.get(place)
    }

    fn judge(&self, index: usize, object: &ObjectState<'f>, bounds: Bounds) -> Segmented {
        let of = |class: Class, reason: Reason, motion_px: f64| Segmented {
            object: object.id,
            class,
            reason,
            motion_px,
        };
        if !self.environment_stays {
            return of(Class::Fast, Reason::SurroundingsChange, f64::INFINITY);
        }
        let mut still = true;
        for (k, state) in self.frames.iter().enumerate().skip(1) {
            // What stays as long as it is shown may go on afterwards.
            if k == self.shown && still && self.observer_stays {
                break;
            }
            let Some(now) = self.find(k, index, object.id) else {
                return of(
                    Class::Fast,
                    Reason::Absent {
                        frame: state.number,
                    },
                    f64::INFINITY,
                );
            };
            if now.description != object.description {
                return of(
                    Class::Fast,
                    Reason::Changes {
                        frame: state.number,
                    },
                    f64::INFINITY,
                );
            }
            still &= now.pose == object.pose;
        }
        if still && self.observer_stays {
            return of(Class::Immobile, Reason::Still, 0.0);
        }
        match bounds {
            Bounds::Empty => of(Class::Clipped, Reason::Empty, 0.0),
            Bounds::Unbounded => of(Class::Fast, Reason::Endless, f64::INFINITY),
            Bounds::Sphere(sphere) => {
                let (class, reason, motion_px) = self.judge_sphere(index, object, &sphere);
                of(class, reason, motion_px)
            }
        }
    }

    fn judge_sphere(
        &self,
        index: usize,
        object: &ObjectState<'f>,
        sphere: &Sphere,
    ) -> (Class, Reason, f64) {
        let poses = || {
            (0..self.frames.len()).filter_map(|k| {
                let pose = self.find(k, index, object.id)?.pose;
                Some(Sighting {
                    camera: self.frames[k].camera,
                    pose,
                })
            })
        };
        let seen = motion::first_in_view(poses(), sphere, self.rule.size);
        let Some(seen) = seen else {
            return (Class::Clipped, Reason::OutOfView, 0.0);
        };
        // The end is where a motion is largest, as a rule: what is fast is found
        // out there, and only what seems slow is measured frame by frame.
        let last = self.frames.len() - 1;
        let mut largest = 0.0_f64;
        let from_first = std::iter::once(last).chain(1..last).map(|k| (0, k));
        let to_target = (1..self.shown)
            .filter(|_| !self.onward.is_empty())
            .map(|k| (k, self.shown));
        for (from, to) in from_first.chain(to_target) {
            let (Some(before), Some(after)) = (
                self.find(from, index, object.id),
                self.find(to, index, object.id),
            ) else {
                continue;
            };
            let (observer, lenses) = match from {
                0 => &self.observer[to],
                _ => &self.onward[from],
            };
            let relative = observer.of(&before.pose, &after.pose, sphere);
            let moved_px = match self.rule.measure {
                Measure::Bound => motion::bound_px(&relative, lenses),
                Measure::Thesis => motion::thesis_px(&relative, lenses),
            };
            // Not certain means fast: a comparison with NaN is never true.
            let is_slow = moved_px <= self.rule.threshold_px;
            if !is_slow {
                let reason = self.why_fast((from, to), &relative, seen, moved_px);
                let moved_px = if moved_px.is_nan() {
                    f64::INFINITY
                } else {
                    moved_px
                };
                return (Class::Fast, reason, moved_px);
            }
            largest = largest.max(moved_px);
        }
        let reason = Reason::MovesLittle {
            moved_px: largest,
            threshold_px: self.rule.threshold_px,
        };
        (Class::Slow, reason, largest)
    }

    fn why_fast(
        &self,
        (from, k): (usize, usize),
        relative: &motion::RelativeMotion,
        seen: usize,
        moved_px: f64,
    ) -> Reason {
        let number = |k: usize| self.frames[k].number;
        if moved_px.is_finite() {
            if seen > 0 {
                return Reason::EntersView {
                    frame: number(seen),
                };
            }
            return Reason::MovesFar {
                moved_px,
                threshold_px: self.rule.threshold_px,
                frame: number(k),
            };
        }
        for (centre, frame) in [
            (relative.centre_before, number(from)),
            (relative.centre_after, number(k)),
        ] {
            let radius = relative.radius;
            if centre.length() <= radius {
                return Reason::ObserverInside { frame };
            }
            if motion::project_sphere(centre, radius) == Projection::Unbounded {
                return Reason::UnboundedEllipse { frame };
            }
        }
        if seen > 0 {
            return Reason::EntersView {
                frame: number(seen),
            };
        }
        Reason::UnboundedEllipse { frame: number(k) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_pixels_have_three_digits() {
        for (px, text) in [
            (0.0, "0"),
            (1.0, "1"),
            (3.2, "3.2"),
            (0.25, "0.25"),
            (12.345, "12.3"),
            (1234.5, "1234"),
            (1e-9, "1.0e-9"),
        ] {
            assert_eq!(short(px), text);
        }
    }
}

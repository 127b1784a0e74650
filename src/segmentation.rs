//! The segmentation: for every object of a period, its class and why.
//!
//! Thesis, III-2. This is its first cut: what does not move at all, and the
//! rest.

use std::fmt;

use crate::film::{FrameState, ObjectId, ObjectState};

/// The answers of the segmentation (thesis: IMMOBILE, CLIPPE, LENT, RAPIDE).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// Does not move relative to the observer, the lights and the environment.
    Immobile,
    /// Moves, and has to be rendered in every frame.
    Fast,
}

/// Why an object has its class.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// Same pose in every frame of the period, and so is all around it.
    Still,
    /// Its pose changes for the first time in this frame.
    Moves {
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
    /// The observer, a light, the background or the sky changes.
    SurroundingsChange,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Still => write!(f, "does not move"),
            Self::Moves { frame } => write!(f, "moves in frame {frame}"),
            Self::Changes { frame } => write!(f, "has another description in frame {frame}"),
            Self::Absent { frame } => write!(f, "is not there in frame {frame}"),
            Self::SurroundingsChange => {
                write!(f, "the observer, a light or the background changes")
            }
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
}

/// Is everything around the objects the same in both frames?
pub fn same_surroundings(a: &FrameState<'_>, b: &FrameState<'_>) -> bool {
    a.camera == b.camera
        && a.lights == b.lights
        && a.shadows == b.shadows
        && a.background == b.background
        && a.sky == b.sky
        && a.antialias == b.antialias
}

/// The segmentation of a period whose surroundings do not change: the classes
/// of all objects that any of its frames has, in the order of their numbers.
/// `frames` gives the period's frames in order; every one of them is looked at.
pub fn segment<'f>(frames: impl Iterator<Item = FrameState<'f>>) -> Vec<Segmented> {
    let mut known: std::collections::BTreeMap<ObjectId, Track> = std::collections::BTreeMap::new();
    let mut first = None;
    let mut previous = None;
    for (count, state) in frames.enumerate() {
        let start = *first.get_or_insert(state.number);
        for object in &state.objects {
            let track = known.entry(object.id).or_insert_with(|| Track {
                reference: Reference::of(object),
                seen: 0,
                reason: (count > 0).then_some(Reason::Absent { frame: start }),
            });
            if track.reason.is_none() && track.seen < count {
                // It was away in between: the frame before this one at the latest.
                track.reason = Some(Reason::Absent {
                    frame: previous.unwrap_or(start),
                });
            }
            if track.reason.is_none() {
                track.reason = track.reference.change(object, state.number);
            }
            track.seen = count + 1;
        }
        for track in known.values_mut() {
            if track.seen == count && track.reason.is_none() && count > 0 {
                track.reason = Some(Reason::Absent {
                    frame: state.number,
                });
            }
        }
        previous = Some(state.number);
    }
    known
        .into_iter()
        .map(|(object, track)| match track.reason {
            None => Segmented {
                object,
                class: Class::Immobile,
                reason: Reason::Still,
            },
            Some(reason) => Segmented {
                object,
                class: Class::Fast,
                reason,
            },
        })
        .collect()
}

struct Track {
    reference: Reference,
    /// Frames up to and with the last one that had it.
    seen: usize,
    reason: Option<Reason>,
}

#[derive(Clone, Copy)]
struct Reference {
    pose: decor_api::Pose,
    description: crate::film::DescriptionId,
}

impl Reference {
    fn of(object: &ObjectState<'_>) -> Self {
        Self {
            pose: object.pose,
            description: object.description,
        }
    }

    fn change(&self, object: &ObjectState<'_>, frame: u32) -> Option<Reason> {
        if self.description != object.description {
            Some(Reason::Changes { frame })
        } else if self.pose != object.pose {
            Some(Reason::Moves { frame })
        } else {
            None
        }
    }
}

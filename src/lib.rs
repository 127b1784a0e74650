//! decor renders an animation faster than frame by frame, with the renderer that
//! you already have.
//!
//! It looks at what moves *in the picture*, keeps what does not as a **décor**
//! (an image with its depth), renders only the rest, and merges the two with a
//! depth buffer. It is the system of Nicolas Ponsi's thesis (*Accélération du
//! calcul d'animations de synthèse*, Saint-Étienne, 1997), taken further.
//!
//! # The flow, in order
//!
//! ```text
//! film ─┐
//!       ├─ stage ── segmentation ── plan ── render ─┬─ merge ── frames
//! objects                                           └─ adapter (decor-api)
//! ```
//!
//! 1. [`film`] reads a film, in either of its forms, into a model that cannot be
//!    wrong; [`objects`] reads what the film names, each geometry once, with the
//!    sphere around it. [`stage`] holds both, and the renderer.
//! 2. [`motion`] says where an object is in the picture, and how far it moves
//!    there, in pixels.
//! 3. [`segmentation`] gives each object its class for a period, and why;
//!    [`explain`] shows it.
//! 4. [`plan`] decides which frames share a décor and what is rendered where. A
//!    plan is a value: it can be printed, priced and executed.
//! 5. [`render`] executes it: calls of the adapter side by side, each a pass over
//!    many frames; [`merge`] puts layers together; [`frames`] encodes and writes.
//! 6. [`compare`] says how far two sets of frames are apart; [`report`] what was
//!    done.
//!
//! Every stage is a pure function between named types. Only reading, rendering
//! and writing touch the disk.
//!
//! # Where to add what
//!
//! A renderer is a crate of its own behind [`decor_api::Adapter`], and one line
//! in [`renderers`]. The compiler keeps it out of everything else. A verb of the
//! program is one file in `cli`.
//!
//! # Words
//!
//! | word | meaning |
//! |---|---|
//! | film, scene, object | what is read: for each frame an environment and rigid objects |
//! | prototype, instance | a geometry stored once, and its placed copies |
//! | décor | image and depth of what need not be rendered again during a period |
//! | period | the frames that one décor serves |
//! | layer | colour, coverage and depth of some of the objects |
//! | block | a square of 32 by 32 pixels on the renderer's own grid; without antialiasing smaller, where the renderer has smaller ones |

pub mod animation;
mod casters;
pub mod cli;
pub mod compare;
pub mod dissolve;
pub mod explain;
pub mod film;
pub mod frames;
pub mod influence;
pub mod job;
pub mod layer;
pub mod merge;
pub mod motion;
pub mod objects;
pub mod plain;
pub mod plan;
pub mod probe;
pub mod render;
pub mod renderers;
pub mod report;
pub mod segmentation;
pub mod shadow;
mod shares;
pub mod silhouette;
pub mod stage;
pub mod stream;
pub mod sweep;
pub mod tune;
pub mod verify;
mod versions;

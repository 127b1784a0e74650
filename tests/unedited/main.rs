//! Anybody's POV-Ray animations by coherence: every frame is the one that POV-Ray
//! alone gives, pixel by pixel, in the film's own type.
//!
//! Frames are small here, and coherence would not pay: `--no-fallback` uses it all
//! the same. `DECOR_UNEDITED_SCENES` says how many random scenes are tried,
//! `DECOR_RANDOM_SEED` which; `scripts/fuzz-unedited` tries many.

#[path = "../common/mod.rs"]
mod common;
#[path = "../support/dice.rs"]
mod dice;
mod examples;
mod hostile;
mod random;
mod random_scene;
mod refusals;
mod steps;
#[path = "../common/stock.rs"]
mod stock;
mod trial;

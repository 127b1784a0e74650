//! What a plan will cost, before it is executed.
//!
//! [`Work`] counts what a period makes the renderer do; [`Costs`] says what one
//! of each thing costs, as measured on this film, renderer and machine (see
//! [`probe`](crate::probe)), or built in; [`Costs::price`] sends the work
//! through a model of the pool of calls and gives seconds. A call sleeps for
//! most of its time where pictures are small, and computes where they are large:
//! only such a model knows which of the two a plan waits for.

mod coverage;
mod memory;
mod pass;
mod pool;
mod prediction;
mod work;

use serde::{Deserialize, Serialize};

pub use coverage::Coverage;
pub use pass::{Parsed, Pass, PassTotal};
pub use pool::{chunk_lengths, jobs, periods_at_once};
pub use prediction::{CostsFrom, Prediction};
pub use work::{FrameWork, Picture, Seen, Survey, Work, description_bytes};

use super::{Plan, Wishes};
use crate::stage::Stage;

/// What tracing a pixel costs, in seconds of CPU.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelCost {
    /// Any pixel.
    pub any_s: f64,
    /// What one that shows an object costs more.
    pub covered_s: f64,
}

impl PixelCost {
    /// So many pixels, of which so many show an object.
    pub fn of(&self, pixels: f64, covered: f64) -> f64 {
        self.any_s * pixels + self.covered_s * covered
    }

    /// Both times a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        Self {
            any_s: self.any_s * factor,
            covered_s: self.covered_s * factor,
        }
    }
}

/// What things cost, in seconds: of CPU, but for the sleep. The defaults are
/// what probes of the bundled `plane` and `ladybirds` found, with POV-Ray 3.7;
/// heavier scenes cost more per pixel in all modes alike, so that speed-ups are
/// nearer to the truth than seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Costs {
    /// A call that renders nothing sleeps so long.
    pub call_sleep_s: f64,
    /// What it computes.
    pub call_cpu_s: f64,
    /// One more picture in a call sleeps so long.
    pub picture_sleep_s: f64,
    /// What it computes, where it is small and of an empty scene.
    pub picture_cpu_s: f64,
    /// A pixel of the picture as the renderer holds and writes it, traced or
    /// not: blocks lie in a picture of full size.
    pub canvas_pixel_s: f64,
    /// A placed object is read.
    pub instance_s: f64,
    /// A byte of a description is read.
    pub byte_s: f64,
    /// Colour from the full scene, or from a décor's.
    pub colour: PixelCost,
    /// Depth of a décor.
    pub depth: PixelCost,
    /// Colour of the fast objects alone.
    pub fast: PixelCost,
    /// Their depth.
    pub fast_depth: PixelCost,
    /// decor: a call is prepared, its process started.
    pub own_call_s: f64,
    /// decor: a pixel is read back from the renderer.
    pub own_pixel_s: f64,
    /// The light that arrives at a point from one light, asked for.
    #[serde(default = "arrival_s")]
    pub arrival_s: f64,
    /// decor: a pixel of a merge.
    pub merge_pixel_s: f64,
    /// decor: a pixel encoded as the file's colour.
    pub encode_pixel_s: f64,
    /// decor: a pixel of a file, compressed and written.
    pub write_pixel_s: f64,
}

impl Default for Costs {
    fn default() -> Self {
        Self {
            call_sleep_s: 0.42,
            call_cpu_s: 0.013,
            picture_sleep_s: 0.23,
            picture_cpu_s: 0.006,
            canvas_pixel_s: 6e-8,
            instance_s: 5e-5,
            byte_s: 4e-7,
            colour: PixelCost {
                any_s: 4.5e-7,
                covered_s: 1.2e-6,
            },
            depth: PixelCost {
                any_s: 3.3e-7,
                covered_s: 2.6e-7,
            },
            fast: PixelCost {
                any_s: 3.4e-7,
                covered_s: 8e-7,
            },
            fast_depth: PixelCost {
                any_s: 3e-7,
                covered_s: 2e-7,
            },
            own_call_s: 4e-3,
            own_pixel_s: 3e-8,
            arrival_s: arrival_s(),
            merge_pixel_s: 4e-9,
            encode_pixel_s: 3e-8,
            write_pixel_s: 1e-8,
        }
    }
}

/// Measured with POV-Ray 3.7: a point is text that has to be read.
fn arrival_s() -> f64 {
    4.8e-6
}

/// A predicted cost.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Price {
    /// Seconds on the clock.
    pub wall_s: f64,
    /// Seconds of all cores.
    pub cpu_s: f64,
}

impl Price {
    /// One number to choose by: less is better.
    ///
    /// The time on the clock counts first. Where calls mostly sleep, plans of
    /// very different work take the same time: then the one that leaves the
    /// cores to others is better, and a plan whose wall time was predicted too
    /// well is not preferred for that alone. Where the cores are busy, both
    /// parts say the same.
    pub fn weight(&self, cores: usize) -> f64 {
        0.7 * self.wall_s + 0.3 * self.cpu_s / cores.max(1) as f64
    }
}

impl std::ops::Add for Price {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            wall_s: self.wall_s + other.wall_s,
            cpu_s: self.cpu_s + other.cpu_s,
        }
    }
}

impl std::iter::Sum for Price {
    fn sum<I: Iterator<Item = Self>>(prices: I) -> Self {
        prices.fold(Self::default(), |sum, price| sum + price)
    }
}

impl Costs {
    /// What a pixel of a pass costs.
    pub fn pixel(&self, pass: Pass) -> PixelCost {
        if pass == Pass::Shadow {
            return PixelCost {
                any_s: self.arrival_s,
                covered_s: 0.0,
            };
        }
        match (pass.is_fast(), pass.is_depth()) {
            (true, true) => self.fast_depth,
            (true, false) => self.fast,
            (false, true) => self.depth,
            (false, false) => self.colour,
        }
    }

    /// What it costs to read a scene, and to begin a picture of it.
    pub fn read(&self, parsed: &Parsed) -> f64 {
        self.picture_cpu_s + self.instance_s * parsed.instances + self.byte_s * parsed.bytes
    }

    /// A period by itself: from an idle pool to its last frame, with so many
    /// calls at once.
    pub fn price(&self, work: &Work, jobs: usize, cores: usize) -> Price {
        self.film([work], jobs, cores).into_iter().sum()
    }

    /// What one more period like this costs in the midst of others: its first
    /// calls run beside the last ones of the period before. Periods of different
    /// lengths are compared by this, per frame.
    pub fn in_a_row(&self, work: &Work, jobs: usize, cores: usize) -> Price {
        let alone = self.price(work, jobs, cores);
        // The cores, the calls that may run at once, and the periods that may be
        // open at once: the narrowest of the three is what a long row waits for.
        let by_cores = alone.cpu_s / cores.max(1) as f64;
        let by_calls = pool::slot_seconds(self, work, jobs, cores) / jobs.max(1) as f64;
        let at_once = periods_at_once(work.size_pixels, jobs);
        let by_periods = alone.wall_s / at_once as f64;
        Price {
            wall_s: by_cores.max(by_calls).max(by_periods),
            cpu_s: alone.cpu_s,
        }
    }

    /// A period whose frames arrive one at a time, each out before the next is
    /// known. The décor is rendered beside the first, what it dissolves into
    /// beside the second; every call has all cores.
    pub fn one_by_one(&self, work: &Work, jobs: usize, cores: usize) -> Price {
        let is_target = |picture: &&Picture| {
            let pass = picture.pass;
            matches!(pass, Pass::Target | Pass::TargetDepth)
        };
        let frames = (0..).zip(&work.frames).map(|(k, frame): (u32, _)| {
            let beside = work.ground.iter().filter(|picture| match k {
                0 => !is_target(picture),
                1 => is_target(picture),
                _ => false,
            });
            let frame = Work {
                ground: frame.pictures.iter().chain(beside).copied().collect(),
                ground_encoded: if k == 0 { work.ground_encoded } else { 0.0 },
                frames: vec![FrameWork {
                    pictures: Vec::new(),
                    ..frame.clone()
                }],
                size_pixels: work.size_pixels,
            };
            self.price(&frame, jobs, cores)
        });
        frames.sum()
    }

    /// The periods of a film in their order. The wall time of each is what it
    /// adds: they overlap, and their sum is the film's.
    pub fn film<'w>(
        &self,
        works: impl IntoIterator<Item = &'w Work>,
        jobs: usize,
        cores: usize,
    ) -> Vec<Price> {
        pool::run(self, works, jobs, cores)
    }

    /// One plain call of the stock renderer over whole frames (`whole` is the
    /// work of rendering each whole), with threads for all cores.
    pub fn stock(&self, whole: &Work, cores: usize) -> Price {
        let pictures = || whole.frames.iter().flat_map(|frame| &frame.pictures);
        // One thread reads the scene and writes the file; all of them trace.
        let mut alone = self.call_cpu_s;
        let mut shared = 0.0;
        let mut sleep = self.call_sleep_s;
        for picture in pictures().filter(|picture| picture.pass == Pass::Whole) {
            alone += self.read(&picture.parsed) + self.canvas_pixel_s * picture.pixels;
            shared += self.colour.of(picture.pixels, picture.covered);
            sleep += self.picture_sleep_s;
        }
        Price {
            wall_s: sleep + alone + shared / cores.max(1) as f64,
            cpu_s: alone + shared,
        }
    }
}

impl Plan {
    /// What each period makes the renderer do, in order.
    pub fn works(&self, stage: &Stage) -> Vec<Work> {
        let work = |period| Work::of(stage, period, &self.wishes);
        self.periods.iter().map(work).collect()
    }
}

/// The work of rendering some frames whole.
pub fn whole_work(stage: &Stage, wishes: &Wishes) -> Work {
    let period = super::Period {
        start: wishes.frames.0,
        frames: vec![super::FramePlan::Whole; (wishes.frames.1 - wishes.frames.0) as usize + 1],
        objects: Vec::new(),
        resting: std::collections::HashSet::new(),
        threshold_px: 0.0,
        still: false,
        before: false,
        sky: None,
        dissolve_until: None,
        end: super::End::Done,
        whole: Some(super::WholeReason::Asked),
    };
    let wishes = Wishes {
        with_depth: false,
        ..wishes.clone()
    };
    Work::of(stage, &period, &wishes)
}

#[cfg(test)]
mod tests;

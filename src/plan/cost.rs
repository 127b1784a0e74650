//! What a plan will cost, before it is executed.
//!
//! A model of few terms: every call of the renderer costs time in which it
//! mostly sleeps, every picture in it a little more, every pixel its work. Calls
//! overlap; work is shared by the cores.

use decor_api::Size;

use super::{FramePlan, Period, Plan};

/// What things cost. The defaults were measured with POV-Ray 3.7 on plain scenes
/// of a few dozen objects; heavier scenes cost more per pixel, in all modes
/// alike, so that speed-ups are nearer to the truth than seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Costs {
    /// Wall time of a call that renders nothing, in seconds.
    pub call_wall_s: f64,
    /// Its CPU time.
    pub call_cpu_s: f64,
    /// Wall time that one more picture in a call adds.
    pub picture_wall_s: f64,
    /// Its CPU time.
    pub picture_cpu_s: f64,
    /// CPU time of a pixel of colour.
    pub pixel_cpu_s: f64,
    /// CPU time of a pixel of depth.
    pub depth_pixel_cpu_s: f64,
}

impl Default for Costs {
    fn default() -> Self {
        Self {
            call_wall_s: 0.45,
            call_cpu_s: 0.02,
            picture_wall_s: 0.25,
            picture_cpu_s: 0.016,
            pixel_cpu_s: 6e-7,
            depth_pixel_cpu_s: 2.5e-7,
        }
    }
}

/// A predicted cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Price {
    /// Seconds on the clock.
    pub wall_s: f64,
    /// Seconds of all cores.
    pub cpu_s: f64,
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

impl Costs {
    /// One plain call of the stock renderer over `frames` whole frames.
    pub fn stock(&self, frames: usize, size: Size, cores: usize) -> Price {
        let work = self.pixel_cpu_s * size.pixels() as f64 * frames as f64;
        let cpu_s = self.call_cpu_s + self.picture_cpu_s * frames as f64 + work;
        let sleep = self.call_wall_s + self.picture_wall_s * frames as f64;
        Price {
            wall_s: sleep + work / cores as f64,
            cpu_s,
        }
    }

    /// A period of a plan, its calls spread over `jobs` at once.
    pub fn period(&self, period: &Period, size: Size, jobs: usize, cores: usize) -> Price {
        let pixels = size.pixels() as f64;
        let (mut work, mut pictures) = (0.0_f64, 0.0_f64);
        for frame in &period.frames {
            match frame {
                FramePlan::Whole => {
                    work += self.pixel_cpu_s * pixels;
                    pictures += 1.0;
                }
                FramePlan::Layered { fast, blocks, sky } => {
                    if *sky {
                        work += self.pixel_cpu_s * pixels;
                        pictures += 1.0;
                    }
                    if !fast.is_empty() {
                        let pixels: usize = fast.iter().map(|window| window.pixels()).sum();
                        work += (self.pixel_cpu_s + self.depth_pixel_cpu_s) * pixels as f64;
                        pictures += 2.0 * fast.len() as f64;
                    }
                    if !blocks.is_empty() {
                        work += self.pixel_cpu_s * blocks.pixels() as f64;
                        pictures += 1.0;
                    }
                }
            }
        }
        let calls = pictures.min(jobs as f64);
        let mut price = Price {
            cpu_s: calls * self.call_cpu_s + pictures * self.picture_cpu_s + work,
            wall_s: 0.0,
        };
        let sleep = if pictures > 0.0 {
            self.call_wall_s + self.picture_wall_s * (pictures / jobs as f64).ceil()
        } else {
            0.0
        };
        price.wall_s = sleep.max(price.cpu_s / cores as f64);
        if period.has_decor() {
            let work = (self.pixel_cpu_s + self.depth_pixel_cpu_s) * pixels;
            let decor = Price {
                cpu_s: 2.0 * (self.call_cpu_s + self.picture_cpu_s) + work,
                wall_s: self.call_wall_s + self.picture_wall_s + work / cores as f64,
            };
            price = price + decor;
        }
        price
    }
}

impl Plan {
    /// The predicted cost of each period, in order.
    pub fn prices(&self, costs: &Costs, size: Size, jobs: usize, cores: usize) -> Vec<Price> {
        self.periods
            .iter()
            .map(|period| costs.period(period, size, jobs, cores))
            .collect()
    }
}

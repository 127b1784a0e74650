//! The metrics of a pair of pictures. A value that is no number is a difference,
//! always; it never disappears in a mean.

use rayon::prelude::*;

use super::mask::Mask;
use super::perceived::Perceived;
use super::picture::{Form, Picture};

/// Red, green, blue or alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Red.
    R,
    /// Green.
    G,
    /// Blue.
    B,
    /// Alpha.
    A,
}

impl Channel {
    const ALL: [Self; 4] = [Self::R, Self::G, Self::B, Self::A];

    /// `R`, `G`, `B` or `A`.
    pub fn name(self) -> &'static str {
        match self {
            Self::R => "R",
            Self::G => "G",
            Self::B => "B",
            Self::A => "A",
        }
    }
}

/// The differences above which pixels are counted. In units of the pictures'
/// values; for depth, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Levels {
    /// Of colour, for failing.
    pub fail: f64,
    /// Of colour, for a warning.
    pub warn: f64,
    /// Of depth, for failing.
    pub fail_depth: f64,
    /// Of depth, for a warning.
    pub warn_depth: f64,
}

/// Where the largest difference is, and what is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The column, from 0 at the left.
    pub x: u32,
    /// The row, from 0 at the top.
    pub y: u32,
    /// The channel.
    pub channel: Channel,
    /// The first picture's value.
    pub a: f32,
    /// The second picture's value.
    pub b: f32,
}

/// How two pictures of one size differ.
///
/// Red, green and blue are compared, alpha where both files have it. Differences
/// are absolute, in units of the pictures' values: 1 is the whole range of a PNG.
#[derive(Clone, Debug, PartialEq)]
pub struct Metrics {
    /// Pixels that were compared: all, or those that the mask has white.
    pub pixels: u64,
    /// The largest difference; +∞ where one is not finite.
    pub max: f64,
    /// Where it is: the first in reading order; none where there is none.
    pub largest: Option<Place>,
    /// The mean over pixels and over red, green and blue of the squared
    /// difference. Not over alpha: one that is opaque everywhere would make the
    /// picture look better by a quarter. A difference that is not finite counts
    /// as 1, the whole range.
    pub mean_square: f64,
    /// Pixels with any difference.
    pub unequal: u64,
    /// Pixels with a difference above [`Levels::fail`].
    pub differing: u64,
    /// Pixels with a difference above [`Levels::warn`].
    pub above_warn: u64,
    /// Pixels with a difference that is not finite: NaN in one or both, or
    /// infinity in one.
    pub not_finite: u64,
    /// The depth, where both have it.
    pub depth: Option<DepthMetrics>,
    /// SSIM and FLIP, where they are wanted; [`measure`] leaves them out.
    pub perceived: Option<Perceived>,
}

impl Metrics {
    /// The root of the mean square.
    pub fn rms(&self) -> f64 {
        self.mean_square.sqrt()
    }

    /// The peak signal-to-noise ratio in decibels, for a peak of 1:
    /// −10 · log₁₀(mean square). +∞ where red, green and blue are equal.
    pub fn psnr(&self) -> f64 {
        psnr(self.mean_square)
    }

    /// The share of pixels above the tolerance, 0..1.
    pub fn share_above(&self) -> f64 {
        share(self.differing, self.pixels)
    }

    /// Is there no difference at all, not in depth either?
    pub fn identical(&self) -> bool {
        self.unequal == 0 && self.depth.as_ref().is_none_or(|depth| depth.unequal == 0)
    }
}

/// [`Metrics::psnr`] of a mean square.
pub(super) fn psnr(mean_square: f64) -> f64 {
    if mean_square == 0.0 {
        f64::INFINITY
    } else {
        -10.0 * mean_square.log10()
    }
}

/// A part of a whole, 0 where there is no whole.
pub(super) fn share(part: u64, whole: u64) -> f64 {
    if whole == 0 {
        0.0
    } else {
        part as f64 / whole as f64
    }
}

/// Where depths differ most, and what is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthPlace {
    /// The column, from 0 at the left.
    pub x: u32,
    /// The row, from 0 at the top.
    pub y: u32,
    /// The first picture's depth.
    pub a: f32,
    /// The second picture's depth.
    pub b: f32,
}

/// How two depth maps differ. Nothing (+∞) in both is equal.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthMetrics {
    /// The largest difference where both have a surface, in scene units.
    pub max_absolute: f64,
    /// The largest difference where both have a surface, divided by the greater
    /// of the two.
    pub max_relative: f64,
    /// Pixels where one has a surface and the other has none.
    pub surface_in_one: u64,
    /// Pixels where one or both are NaN.
    pub not_a_number: u64,
    /// Where the relative difference is largest, a missing surface and NaN
    /// being larger than any: the first in reading order.
    pub largest: Option<DepthPlace>,
    /// Pixels with any difference.
    pub unequal: u64,
    /// Pixels above [`Levels::fail_depth`]; a missing surface and NaN are.
    pub differing: u64,
    /// Pixels above [`Levels::warn_depth`]; a missing surface and NaN are.
    pub above_warn: u64,
    /// The relative difference at `largest`, +∞ for a missing surface and NaN.
    worst: f64,
}

/// Compares two pictures, which must have one size and mean the same by their
/// values. Rows are done in parallel and joined in their order: the result does
/// not depend on the number of threads.
///
/// Where there is a mask, only its white pixels are compared. Gives nothing where
/// the sizes differ, the mask's included.
pub fn measure(a: &Picture, b: &Picture, levels: &Levels, mask: Option<&Mask>) -> Option<Metrics> {
    if a.size != b.size
        || a.values.len() != b.values.len()
        || mask.is_some_and(|mask| mask.size != a.size)
    {
        return None;
    }
    let width = a.size.width as usize;
    let channels = if a.has_alpha && b.has_alpha { 4 } else { 3 };
    // PNG values are whole 65535ths, which floats are not.
    let whole_steps = a.form != Form::Exr && b.form != Form::Exr;
    let rows: Vec<Row> = (0..a.size.height)
        .into_par_iter()
        .map(|y| {
            let range = y as usize * width..(y as usize + 1) * width;
            let (a, b) = (&a.values[range.clone()], &b.values[range]);
            let pixels = (0..).zip(a.iter().zip(b));
            match mask.map(|mask| mask.row(y as usize)) {
                None => Row::measure(y, pixels, channels, whole_steps, levels),
                Some(mask) => {
                    let white = pixels.zip(mask).filter(|(_, white)| **white);
                    let pixels = white.map(|(pixel, _)| pixel);
                    Row::measure(y, pixels, channels, whole_steps, levels)
                }
            }
        })
        .collect();
    let mut all = Row::default();
    for row in &rows {
        all.append(row);
    }
    let pixels = mask.map_or(a.values.len() as u64, Mask::pixels);
    Some(Metrics {
        pixels,
        max: all.max,
        largest: all.largest,
        mean_square: if pixels == 0 {
            0.0
        } else {
            all.squares / (3 * pixels) as f64
        },
        unequal: all.unequal,
        differing: all.differing,
        above_warn: all.above_warn,
        not_finite: all.not_finite,
        depth: match (&a.depth, &b.depth) {
            (Some(a), Some(b)) if a.len() == b.len() => {
                Some(measure_depth(a, b, width, levels, mask))
            }
            _ => None,
        },
        perceived: None,
    })
}

/// The absolute difference of two values; +∞ where it is no finite number.
/// `whole_steps`: both come from PNGs, and are whole steps of 16 bits.
pub(super) fn difference(a: f32, b: f32, whole_steps: bool) -> f64 {
    if a == b {
        return 0.0;
    }
    let difference = (f64::from(a) - f64::from(b)).abs();
    if !difference.is_finite() {
        return f64::INFINITY;
    }
    if whole_steps {
        // One step of 8 bits is then exactly 1/255, and a tolerance of 1/255
        // lets it pass.
        (difference * 65535.0).round() / 65535.0
    } else {
        difference
    }
}

/// The sums of a row, or of several.
#[derive(Default)]
struct Row {
    max: f64,
    largest: Option<Place>,
    squares: f64,
    unequal: u64,
    differing: u64,
    above_warn: u64,
    not_finite: u64,
}

impl Row {
    fn measure<'a>(
        y: u32,
        pixels: impl Iterator<Item = (u32, (&'a [f32; 4], &'a [f32; 4]))>,
        channels: usize,
        whole_steps: bool,
        levels: &Levels,
    ) -> Self {
        let mut row = Self::default();
        for (x, (a, b)) in pixels {
            let mut pixel_max = 0.0_f64;
            for (k, channel) in Channel::ALL.into_iter().enumerate().take(channels) {
                let difference = difference(a[k], b[k], whole_steps);
                pixel_max = pixel_max.max(difference);
                if k < 3 {
                    let counted = if difference.is_finite() {
                        difference
                    } else {
                        1.0
                    };
                    row.squares += counted * counted;
                }
                if difference > row.max {
                    row.max = difference;
                    let (a, b) = (a[k], b[k]);
                    row.largest = Some(Place {
                        x,
                        y,
                        channel,
                        a,
                        b,
                    });
                }
            }
            let not_finite = pixel_max == f64::INFINITY;
            row.unequal += u64::from(pixel_max > 0.0);
            row.differing += u64::from(pixel_max > levels.fail || not_finite);
            row.above_warn += u64::from(pixel_max > levels.warn || not_finite);
            row.not_finite += u64::from(not_finite);
        }
        row
    }

    fn append(&mut self, below: &Self) {
        if below.max > self.max {
            self.max = below.max;
            self.largest = below.largest;
        }
        self.squares += below.squares;
        self.unequal += below.unequal;
        self.differing += below.differing;
        self.above_warn += below.above_warn;
        self.not_finite += below.not_finite;
    }
}

fn measure_depth(
    a: &[f32],
    b: &[f32],
    width: usize,
    levels: &Levels,
    mask: Option<&Mask>,
) -> DepthMetrics {
    let mut all = DepthMetrics::default();
    if width == 0 {
        return all;
    }
    let rows: Vec<DepthMetrics> = a
        .par_chunks(width)
        .zip(b.par_chunks(width))
        .enumerate()
        .map(|(y, (a, b))| {
            let mut row = DepthMetrics::default();
            for (x, (&a, &b)) in (0..).zip(a.iter().zip(b)) {
                if mask.is_some_and(|mask| !mask.counts(y * width + x as usize)) {
                    continue;
                }
                let y = y as u32;
                row.add(DepthPlace { x, y, a, b }, levels);
            }
            row
        })
        .collect();
    for row in &rows {
        all.append(row);
    }
    all
}

impl DepthMetrics {
    fn add(&mut self, place: DepthPlace, levels: &Levels) {
        let (a, b) = (f64::from(place.a), f64::from(place.b));
        if a == b {
            return;
        }
        let relative = if a.is_finite() && b.is_finite() {
            let absolute = (a - b).abs();
            let relative = absolute / a.abs().max(b.abs());
            self.max_absolute = self.max_absolute.max(absolute);
            self.max_relative = self.max_relative.max(relative);
            relative
        } else {
            let nan = a.is_nan() || b.is_nan();
            self.not_a_number += u64::from(nan);
            self.surface_in_one += u64::from(!nan);
            f64::INFINITY
        };
        if relative > self.worst {
            self.worst = relative;
            self.largest = Some(place);
        }
        self.unequal += 1;
        self.differing += u64::from(relative > levels.fail_depth);
        self.above_warn += u64::from(relative > levels.warn_depth);
    }

    /// Adds what comes later: further rows, or a later frame.
    pub(super) fn append(&mut self, later: &Self) {
        self.max_absolute = self.max_absolute.max(later.max_absolute);
        self.max_relative = self.max_relative.max(later.max_relative);
        self.surface_in_one += later.surface_in_one;
        self.not_a_number += later.not_a_number;
        if later.worst > self.worst {
            self.worst = later.worst;
            self.largest = later.largest;
        }
        self.unequal += later.unequal;
        self.differing += later.differing;
        self.above_warn += later.above_warn;
    }
}

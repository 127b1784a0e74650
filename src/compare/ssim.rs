//! SSIM, the structural similarity of Wang, Bovik, Sheikh and Simoncelli (*Image
//! Quality Assessment: From Error Visibility to Structural Similarity*, IEEE
//! Transactions on Image Processing 13(4), 2004).
//!
//! As the paper has it: windows of 11 by 11 with Gaussian weights, σ = 1.5
//! pixels, K₁ = 0.01, K₂ = 0.03, a range of 1, the plain (not the sample's)
//! covariance; only windows that lie in the picture. Of red, green and blue
//! each, then their mean. That is scikit-image's `structural_similarity(a, b,
//! gaussian_weights=True, sigma=1.5, use_sample_covariance=False,
//! data_range=1.0, channel_axis=2)`.

use std::ops::Range;

use rayon::prelude::*;

use super::filter::{Plane, TILE, parts, widened};
use super::mask::Mask;
use super::seen::Seen;

/// Pixels from a window's centre to its edge: 3.5 σ.
const RADIUS: usize = 5;
const SIGMA: f64 = 1.5;
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// The similarities of all windows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ssim {
    /// Their mean: 1 where the pictures are seen as equal.
    pub mean: f64,
    /// How many windows there are: pixels that are 5 or more from every edge,
    /// and that the mask has white.
    pub windows: u64,
}

/// The structural similarity. Nothing where no window fits: in pictures of fewer
/// than 11 columns or rows, or where the mask leaves none.
pub fn ssim(seen: &Seen, mask: Option<&Mask>) -> Option<Ssim> {
    let side = 2 * RADIUS + 1;
    if seen.width < side || seen.height < side {
        return None;
    }
    let kernel = kernel();
    let rows: Vec<_> = parts(RADIUS..seen.height - RADIUS).collect();
    // In their order, whatever the number of threads.
    let bands: Vec<(f64, u64)> = rows
        .par_iter()
        .map(|rows| {
            let mut band = (0.0, 0);
            for columns in parts(RADIUS..seen.width - RADIUS) {
                let (sum, windows) = tile(seen, mask, columns, rows, &kernel);
                band = (band.0 + sum, band.1 + windows);
            }
            band
        })
        .collect();
    let (lost, windows) = bands.into_iter().fold((0.0, 0), |(sum, count), band| {
        (sum + band.0, count + band.1)
    });
    (windows > 0).then(|| Ssim {
        mean: 1.0 - lost / windows as f64,
        windows,
    })
}

fn kernel() -> Vec<f64> {
    let weight = |k: usize| {
        let x = k as f64 - RADIUS as f64;
        (-0.5 * (x / SIGMA) * (x / SIGMA)).exp()
    };
    let weights: Vec<f64> = (0..=2 * RADIUS).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    weights.into_iter().map(|weight| weight / sum).collect()
}

/// What the tile's windows lack to 1, summed, and their number. Summing what is
/// lacking keeps the digits of pictures that are nearly equal.
fn tile(
    seen: &Seen,
    mask: Option<&Mask>,
    columns: Range<usize>,
    rows: &Range<usize>,
    kernel: &[f64],
) -> (f64, u64) {
    let counts = |x: usize, y: usize| mask.is_none_or(|mask| mask.counts(y * seen.width + x));
    let windows = rows
        .clone()
        .map(|y| columns.clone().filter(|&x| counts(x, y)).count() as u64)
        .sum();
    let (wide, high) = (
        widened(&columns, RADIUS, seen.width),
        widened(rows, RADIUS, seen.height),
    );
    if windows == 0 || !seen.differs(wide.clone(), high.clone()) {
        return (0.0, windows);
    }
    let mut lost = vec![0.0; TILE * TILE];
    for channel in 0..3 {
        let plane = |of: &[[f32; 3]]| {
            Plane::of(wide.clone(), high.clone(), |x, y| {
                f64::from(of[y * seen.width + x][channel])
            })
        };
        let (a, b) = (plane(&seen.a), plane(&seen.b));
        let mean = |plane: &Plane<f64>| plane.filtered(kernel, kernel).values;
        let (mean_a, mean_b) = (mean(&a), mean(&b));
        let (aa, bb, ab) = (mean(&a.times(&a)), mean(&b.times(&b)), mean(&a.times(&b)));
        for (k, lost) in lost.iter_mut().enumerate().take(mean_a.len()) {
            let (ma, mb) = (mean_a[k], mean_b[k]);
            let (va, vb, cov) = (aa[k] - ma * ma, bb[k] - mb * mb, ab[k] - ma * mb);
            let similar = (2.0 * ma * mb + C1) * (2.0 * cov + C2)
                / ((ma * ma + mb * mb + C1) * (va + vb + C2));
            *lost += (1.0 - similar) / 3.0;
        }
    }
    let places = rows
        .clone()
        .flat_map(|y| columns.clone().map(move |x| (x, y)));
    let sum = places
        .zip(&lost)
        .filter(|((x, y), _)| counts(*x, *y))
        .map(|(_, lost)| lost)
        .sum();
    (sum, windows)
}

//! Separable filters over tiles of a picture: what SSIM and FLIP share.
//!
//! A tile is cut out with a margin, filtered, and forgotten: the intermediate
//! planes stay in the processor's cache, and a tile without any difference in
//! reach is not filtered at all. Both metrics are exact there: no error.

use std::ops::{AddAssign, Mul, Range};

/// Pixels of a tile's side: with FLIP's margin at 67 pixels per degree, a plane
/// of 32-bit numbers has 28 KB.
pub(super) const TILE: usize = 64;

/// Numbers row by row.
pub(super) struct Plane<T> {
    pub width: usize,
    pub values: Vec<T>,
}

/// A number that can be filtered.
pub(super) trait Sample: Copy + Default + Mul<Output = Self> + AddAssign {}
impl Sample for f32 {}
impl Sample for f64 {}

impl<T: Sample> Plane<T> {
    /// `value` of every pixel of a rectangle.
    pub fn of(
        columns: Range<usize>,
        rows: Range<usize>,
        value: impl Fn(usize, usize) -> T,
    ) -> Self {
        let width = columns.len();
        let values = rows
            .flat_map(|y| columns.clone().map(move |x| (x, y)))
            .map(|(x, y)| value(x, y))
            .collect();
        Self { width, values }
    }

    /// Pixel by pixel, the product of two planes of one size.
    pub fn times(&self, other: &Self) -> Self {
        let pairs = self.values.iter().zip(&other.values);
        Self {
            width: self.width,
            values: pairs.map(|(&a, &b)| a * b).collect(),
        }
    }

    /// Filters rows, then columns. Smaller by the kernels' length − 1: there is
    /// no edge, the margin is what the caller put there. Kernels of one length.
    pub fn filtered(&self, across: &[T], down: &[T]) -> Self {
        self.across(across).down(down)
    }

    /// Filters rows.
    pub fn across(&self, kernel: &[T]) -> Self {
        let width = (self.width + 1).saturating_sub(kernel.len());
        let height = self.values.len() / self.width.max(1);
        let mut values = vec![T::default(); width * height];
        if width > 0 {
            let rows = self.values.chunks_exact(self.width);
            for (out, row) in values.chunks_exact_mut(width).zip(rows) {
                // Weight by weight over a whole row: that is what processors do
                // many at a time.
                for (k, &weight) in kernel.iter().enumerate() {
                    add(out, weight, &row[k..k + width]);
                }
            }
        }
        Self { width, values }
    }

    /// Filters columns.
    pub fn down(&self, kernel: &[T]) -> Self {
        let width = self.width;
        let height = self.values.len() / width.max(1);
        let height = (height + 1).saturating_sub(kernel.len());
        let mut values = vec![T::default(); width * height];
        if width > 0 {
            for (y, out) in values.chunks_exact_mut(width).enumerate() {
                for (k, &weight) in kernel.iter().enumerate() {
                    let from = (y + k) * width;
                    add(out, weight, &self.values[from..from + width]);
                }
            }
        }
        Self { width, values }
    }
}

fn add<T: Sample>(sums: &mut [T], weight: T, row: &[T]) {
    for (sum, &value) in sums.iter_mut().zip(row) {
        *sum += weight * value;
    }
}

/// A range in parts of [`TILE`], the last one shorter.
pub(super) fn parts(range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let end = range.end;
    range
        .step_by(TILE)
        .map(move |start| start..(start + TILE).min(end))
}

/// A range with a margin, as far as there are pixels.
pub(super) fn widened(range: &Range<usize>, margin: usize, end: usize) -> Range<usize> {
    range.start.saturating_sub(margin)..(range.end + margin).min(end)
}

//! Two pictures as they are seen: what SSIM and FLIP are taken of.

use super::mask::Mask;
use super::picture::{Encoding, Picture, srgb};

/// Two pictures of one size as a display takes them: red, green and blue, 0..1,
/// in sRGB's transfer function, without NaN.
pub struct Seen {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The first picture.
    pub a: Vec<[f32; 3]>,
    /// The second picture; the first where the mask is black, so that what is
    /// not to count is in no neighbour's filter either.
    pub b: Vec<[f32; 3]>,
}

impl Seen {
    /// Takes two pictures of one size and one encoding. A linear one goes
    /// through sRGB's transfer function, cut to 0..1, on black. Alpha is left out.
    ///
    /// NaN must not look like anything: it is taken for the end of the range
    /// that is farther from the other picture's value.
    ///
    /// Gives nothing where the sizes differ.
    pub fn new(a: &Picture, b: &Picture, mask: Option<&Mask>) -> Option<Self> {
        if a.size != b.size || a.values.len() != b.values.len() {
            return None;
        }
        let linear = a.encoding == Encoding::Linear;
        let shown = |[r, g, b, _]: [f32; 4]| {
            [r, g, b].map(|value| {
                if linear {
                    srgb(value)
                } else {
                    value.clamp(0.0, 1.0)
                }
            })
        };
        let mut seen = Self {
            width: a.size.width as usize,
            height: a.size.height as usize,
            a: a.values.iter().copied().map(shown).collect(),
            b: b.values.iter().copied().map(shown).collect(),
        };
        let both = seen.a.iter_mut().zip(&mut seen.b).enumerate();
        for (k, (a, b)) in both {
            for (a, b) in a.iter_mut().zip(b.iter_mut()) {
                if a.is_nan() && b.is_nan() {
                    (*a, *b) = (0.0, 1.0);
                } else if a.is_nan() {
                    *a = far_end(*b);
                } else if b.is_nan() {
                    *b = far_end(*a);
                }
            }
            if mask.is_some_and(|mask| !mask.counts(k)) {
                *b = *a;
            }
        }
        Some(seen)
    }

    /// Is there a difference in these columns and rows?
    pub(super) fn differs(
        &self,
        columns: std::ops::Range<usize>,
        rows: std::ops::Range<usize>,
    ) -> bool {
        rows.into_iter().any(|y| {
            let row = y * self.width + columns.start..y * self.width + columns.end;
            self.a[row.clone()] != self.b[row]
        })
    }
}

fn far_end(value: f32) -> f32 {
    if value < 0.5 { 1.0 } else { 0.0 }
}

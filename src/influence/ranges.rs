//! The ranges of the décor's depth in small squares, found once for all frames of a
//! period: a tile's range is asked for in every frame, and is every pixel's.

use decor_api::{Size, Window};
use rayon::prelude::*;

use super::Depths;
use super::depths::Range;

/// The side of a square, in pixels.
const CELL: u32 = 8;

/// The ranges of all squares of a picture.
#[derive(Clone, Debug)]
pub struct Ranges {
    size: Size,
    ring: u32,
    cells: Vec<Range>,
}

impl Ranges {
    /// Of `depths`, where the renderer looks between the pixels' centres or does not.
    pub fn of(depths: &Depths<'_>, size: Size, antialiased: bool) -> Self {
        let ring = u32::from(antialiased && !depths.has_samples());
        let columns = size.width.div_ceil(CELL);
        let count = columns * size.height.div_ceil(CELL);
        let cell = |number: u32| {
            let window = Window {
                x: number % columns * CELL,
                y: number / columns * CELL,
                width: CELL,
                height: CELL,
            }
            .intersection(size.window());
            if depths.may_change(window) {
                depths.search(window, ring, size)
            } else {
                Range::NONE
            }
        };
        let cells = (0..count).into_par_iter().with_min_len(64).map(cell);
        Self {
            size,
            ring,
            cells: cells.collect(),
        }
    }

    /// The range of a window with a ring around it, where it is made of squares.
    pub(super) fn of_window(&self, window: Window, ring: u32) -> Option<Range> {
        let is_end = |at: u32, end: u32| at.is_multiple_of(CELL) || at == end;
        let fits = ring == self.ring
            && window.x.is_multiple_of(CELL)
            && window.y.is_multiple_of(CELL)
            && is_end(window.right(), self.size.width)
            && is_end(window.bottom(), self.size.height)
            && !window.is_empty();
        if !fits {
            return None;
        }
        let columns = self.size.width.div_ceil(CELL);
        let rows = window.y / CELL..window.bottom().div_ceil(CELL);
        let mut range = Range::NONE;
        for row in rows {
            let at = |x: u32| (row * columns + x) as usize;
            let (first, end) = (window.x / CELL, window.right().div_ceil(CELL));
            let cells = self.cells.get(at(first)..at(end))?;
            range = cells.iter().fold(range, |all, cell| all.union(*cell));
        }
        Some(range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Layer;

    #[test]
    fn what_is_kept_is_what_is_found() {
        let size = Size {
            width: 37,
            height: 21,
        };
        let depth = |k: usize| match k % 97 {
            0 => f64::INFINITY,
            1 if k > 400 => f64::NAN,
            _ => ((k * 7919) % 1000) as f64,
        };
        let layer = Layer {
            window: size.window(),
            colour: None,
            depth: Some((0..size.pixels()).map(depth).collect()),
            depth_quantum: (0.0, 0.0),
        };
        let plain = Depths::at_centres(&layer);
        for antialiased in [false, true] {
            let ranges = Ranges::of(&plain, size, antialiased);
            let kept = plain.with_ranges(&ranges);
            let ring = u32::from(antialiased);
            let mut found = 0;
            for (x, y, side) in (0..5).flat_map(|x| (0..3).map(move |y| (x, y, x + y))) {
                let window = Window {
                    x: 8 * x,
                    y: 8 * y,
                    width: 8 << (side % 3),
                    height: 8 << (side % 3),
                }
                .intersection(size.window());
                found += usize::from(ranges.of_window(window, ring).is_some());
                let want = plain.range(window, ring, size);
                assert_eq!(kept.range(window, ring, size), want, "{window:?}");
            }
            assert_eq!(found, 15);
            let odd = Window {
                x: 3,
                ..size.window()
            };
            assert_eq!(ranges.of_window(odd, ring), None);
            assert_eq!(ranges.of_window(size.window(), 1 - ring), None);
        }
    }
}

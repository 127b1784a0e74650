//! Sets of blocks of the picture: what is rendered again from the full scene.

use decor_api::{Blocks, Size, Window, block_window};

/// The side of a block of an antialiased picture, in pixels: the renderers' grid.
pub use decor_api::BLOCK;

/// Some blocks of a picture of one size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockSet {
    size: Size,
    side: u32,
    bits: Vec<bool>,
}

impl BlockSet {
    /// No block; the side of each is that many pixels.
    pub fn none(size: Size, side: u32) -> Self {
        let side = side.max(1);
        let count = size.width.div_ceil(side) as usize * size.height.div_ceil(side) as usize;
        Self {
            size,
            side,
            bits: vec![false; count],
        }
    }

    /// The size of the picture.
    pub fn size(&self) -> Size {
        self.size
    }

    /// The side of each, in pixels.
    pub fn side(&self) -> u32 {
        self.side
    }

    fn columns(&self) -> u32 {
        self.size.width.div_ceil(self.side)
    }

    fn row(&self, row: u32, columns: std::ops::Range<u32>) -> std::ops::Range<usize> {
        let start = row as usize * self.columns() as usize;
        start + columns.start as usize..start + columns.end as usize
    }

    /// The columns and the rows of blocks that have a pixel of a window which has
    /// one.
    fn span(&self, window: Window) -> (std::ops::Range<u32>, std::ops::Range<u32>) {
        let window = window.on_grid(self.side, self.size);
        let span = |start: u32, end: u32| start / self.side..end.div_ceil(self.side);
        (
            span(window.x, window.right()),
            span(window.y, window.bottom()),
        )
    }

    /// Adds every block that has a pixel of `window`.
    pub fn insert(&mut self, window: Window) {
        if window.is_empty() {
            return;
        }
        let (columns, rows) = self.span(window);
        for row in rows {
            let row = self.row(row, columns.clone());
            self.bits[row].fill(true);
        }
    }

    /// Adds every block that has a pixel of any of `windows`.
    pub fn insert_all(&mut self, windows: impl IntoIterator<Item = Window>) {
        for window in windows {
            self.insert(window);
        }
    }

    /// The blocks of both sets, which are of one size, of pictures of one size.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        debug_assert!(self.side == other.side && self.size == other.size);
        let bits = self.bits.iter().zip(&other.bits);
        Self {
            size: self.size,
            side: self.side,
            bits: bits.map(|(a, b)| *a || *b).collect(),
        }
    }

    /// The blocks of this set that the other one, of the same kind, has not.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        debug_assert!(self.side == other.side && self.size == other.size);
        let bits = self.bits.iter().zip(&other.bits);
        Self {
            bits: bits.map(|(a, b)| *a && !b).collect(),
            ..*self
        }
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        !self.bits.contains(&true)
    }

    /// Their numbers, row by row, ascending.
    pub fn numbers(&self) -> Vec<u32> {
        (0..)
            .zip(&self.bits)
            .filter(|(_, bit)| **bit)
            .map(|(n, _)| n)
            .collect()
    }

    /// Themselves, to ask a renderer for.
    pub fn wanted(&self) -> Blocks {
        Blocks {
            side: self.side,
            numbers: self.numbers(),
        }
    }

    /// Their rectangles, cut at the picture.
    pub fn windows(&self) -> impl Iterator<Item = Window> + '_ {
        let numbers = self.numbers().into_iter();
        numbers.map(|number| block_window(number, self.side, self.size))
    }

    /// Rectangles that have the same pixels, each several blocks of a row: fewer
    /// than the blocks.
    pub fn runs(&self) -> impl Iterator<Item = Window> + '_ {
        let columns = self.columns().max(1) as usize;
        let rows = (0..).zip(self.bits.chunks(columns));
        rows.flat_map(move |(row, bits)| {
            let mut at = 0;
            std::iter::from_fn(move || {
                let start = at + bits[at..].iter().position(|bit| *bit)?;
                let length = bits[start..].iter().take_while(|bit| **bit).count();
                at = start + length;
                let run = Window {
                    x: start as u32 * self.side,
                    y: row * self.side,
                    width: length as u32 * self.side,
                    height: self.side,
                };
                Some(run.intersection(self.size.window()))
            })
        })
    }

    /// Pixels in them.
    pub fn pixels(&self) -> usize {
        self.runs().map(Window::pixels).sum()
    }

    /// Is pixel (x, y) in one of them?
    pub fn has_pixel(&self, x: u32, y: u32) -> bool {
        let number = (y / self.side * self.columns() + x / self.side) as usize;
        x < self.size.width && self.bits.get(number) == Some(&true)
    }

    /// Is any pixel of `window` in them?
    pub fn touches(&self, window: Window) -> bool {
        self.asked(window).any(|row| self.bits[row].contains(&true))
    }

    /// Is every pixel of `window` in them?
    pub fn contains(&self, window: Window) -> bool {
        !self
            .asked(window)
            .any(|row| self.bits[row].contains(&false))
    }

    /// The places of the blocks that have a pixel of `window`, by row.
    fn asked(&self, window: Window) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        let window = window.intersection(self.size.window());
        let (columns, rows) = if window.is_empty() {
            (0..0, 0..0)
        } else {
            self.span(window)
        };
        rows.map(move |row| self.row(row, columns.clone()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 70,
        height: 40,
    };

    #[test]
    fn blocks_of_a_window() {
        let mut set = BlockSet::none(SIZE, BLOCK);
        assert!(set.is_empty());
        set.insert(Window {
            x: 31,
            y: 0,
            width: 2,
            height: 1,
        });
        assert_eq!(set.numbers(), [0, 1]);
        set.insert(Window {
            x: 69,
            y: 39,
            width: 1,
            height: 1,
        });
        assert_eq!(set.numbers(), [0, 1, 5]);
        assert_eq!(set.pixels(), 2 * 32 * 32 + 6 * 8);
        assert!(set.contains(Window {
            x: 10,
            y: 10,
            width: 40,
            height: 10
        }));
        assert!(!set.contains(Window {
            x: 10,
            y: 10,
            width: 40,
            height: 30
        }));
    }
}

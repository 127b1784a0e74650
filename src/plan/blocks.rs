//! Sets of blocks of the picture: what is rendered again from the full scene.

use decor_api::{Size, Window};

/// The side of a block, in pixels: the renderers' grid.
pub use decor_api::BLOCK;

/// Some blocks of a picture of one size.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockSet {
    size: Size,
    bits: Vec<bool>,
}

impl BlockSet {
    /// No block.
    pub fn none(size: Size) -> Self {
        let count = columns(size) as usize * size.height.div_ceil(BLOCK) as usize;
        Self {
            size,
            bits: vec![false; count],
        }
    }

    /// Adds every block that has a pixel of `window`.
    pub fn insert(&mut self, window: Window) {
        if window.is_empty() {
            return;
        }
        let window = window.on_grid(BLOCK, self.size);
        for row in window.y / BLOCK..window.bottom().div_ceil(BLOCK) {
            for column in window.x / BLOCK..window.right().div_ceil(BLOCK) {
                self.bits[(row * columns(self.size) + column) as usize] = true;
            }
        }
    }

    /// Adds every block that has a pixel of any of `windows`.
    pub fn insert_all(&mut self, windows: impl IntoIterator<Item = Window>) {
        for window in windows {
            self.insert(window);
        }
    }

    /// The blocks of both sets, which are of pictures of one size.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        let bits = self.bits.iter().zip(&other.bits);
        Self {
            size: self.size,
            bits: bits.map(|(a, b)| *a || *b).collect(),
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

    /// Their rectangles, cut at the picture.
    pub fn windows(&self) -> impl Iterator<Item = Window> + '_ {
        self.numbers().into_iter().map(|n| {
            let (x, y) = (
                n % columns(self.size) * BLOCK,
                n / columns(self.size) * BLOCK,
            );
            Window {
                x,
                y,
                width: BLOCK,
                height: BLOCK,
            }
            .intersection(self.size.window())
        })
    }

    /// Pixels in them.
    pub fn pixels(&self) -> usize {
        self.windows().map(Window::pixels).sum()
    }

    /// Is pixel (x, y) in one of them?
    pub fn has_pixel(&self, x: u32, y: u32) -> bool {
        let number = (y / BLOCK * columns(self.size) + x / BLOCK) as usize;
        x < self.size.width && self.bits.get(number) == Some(&true)
    }

    /// Is any pixel of `window` in them?
    pub fn touches(&self, window: Window) -> bool {
        if window.is_empty() {
            return false;
        }
        let (first, end) = (window.x / BLOCK, window.right().div_ceil(BLOCK));
        let rows = window.y / BLOCK..window.bottom().div_ceil(BLOCK);
        rows.into_iter().any(|row| {
            let at = |column: u32| (row * columns(self.size) + column) as usize;
            (first..end.min(columns(self.size))).any(|c| self.bits.get(at(c)) == Some(&true))
        })
    }

    /// Is every pixel of `window` in them?
    pub fn contains(&self, window: Window) -> bool {
        let mut all = Self::none(self.size);
        all.insert(window);
        all.bits
            .iter()
            .zip(&self.bits)
            .all(|(wanted, have)| *have || !wanted)
    }
}

fn columns(size: Size) -> u32 {
    size.width.div_ceil(BLOCK)
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
        let mut set = BlockSet::none(SIZE);
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

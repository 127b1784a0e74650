//! Blocks of 32 by 32 pixels: sets of them, and which of them are dirty, given
//! the pixels that something touches.
//!
//! POV-Ray looks beyond a block where it antialiases by method 1: it traces the
//! row above and the column to the left too, and what they show decides whether
//! pixels inside are sampled again. So a block is dirty if anything in it, in the
//! row above or in the column to its left is touched. At the upper and the left
//! border of the picture these lie outside: no picture shows whether they are
//! touched, and the blocks there are dirty. Method 2 and no antialiasing look at
//! the block's own pixels alone.

use decor_api::{Size, Window};

use crate::state::{BLOCK, Block, block_window};

/// The blocks of a picture, row by row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// The size of the picture.
    pub size: Size,
}

impl Grid {
    /// How many blocks there are.
    pub fn count(&self) -> usize {
        (self.columns() * self.size.height.div_ceil(BLOCK)) as usize
    }

    fn columns(&self) -> u32 {
        self.size.width.div_ceil(BLOCK)
    }

    /// The blocks directly above, and directly to the left of these.
    pub fn above_and_left_of(&self, blocks: &Blocks) -> Blocks {
        let columns = self.columns() as usize;
        let mut found = Blocks::none(*self);
        for block in blocks.iter() {
            if block >= columns {
                found.insert(block - columns);
            }
            if !block.is_multiple_of(columns) {
                found.insert(block - 1);
            }
        }
        found
    }

    /// The rectangle of a block.
    pub fn window(&self, block: usize) -> Window {
        block_window(self.size, block as u32)
    }
}

/// A set of blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Blocks(Vec<bool>);

impl Blocks {
    /// No block of a picture.
    pub fn none(grid: Grid) -> Self {
        Self(vec![false; grid.count()])
    }

    /// All blocks of a picture.
    pub fn all(grid: Grid) -> Self {
        Self(vec![true; grid.count()])
    }

    /// Those for which `is_in` holds.
    pub fn of(grid: Grid, is_in: impl FnMut(usize) -> bool) -> Self {
        Self((0..grid.count()).map(is_in).collect())
    }

    /// Is it in?
    pub fn has(&self, block: usize) -> bool {
        self.0.get(block).is_some_and(|is_in| *is_in)
    }

    /// Puts a block in.
    pub fn insert(&mut self, block: usize) {
        self.0[block] = true;
    }

    /// Takes a block out.
    pub fn remove(&mut self, block: usize) {
        self.0[block] = false;
    }

    /// How many are in.
    pub fn len(&self) -> usize {
        self.0.iter().filter(|is_in| **is_in).count()
    }

    /// Is none in?
    pub fn is_empty(&self) -> bool {
        !self.0.contains(&true)
    }

    /// The share of the picture's blocks that are in.
    pub fn share(&self) -> f64 {
        self.len() as f64 / self.0.len().max(1) as f64
    }

    /// Their numbers, ascending.
    pub fn iter(&self) -> impl Iterator<Item = usize> {
        let all = self.0.iter().enumerate();
        all.filter_map(|(block, is_in)| is_in.then_some(block))
    }

    /// Those that are in this one, or in the other.
    #[must_use]
    pub fn or(&self, other: &Self) -> Self {
        self.with(other, |a, b| a || b)
    }

    /// Those that are in both.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        self.with(other, |a, b| a && b)
    }

    /// Those that are in this one and not in the other.
    #[must_use]
    pub fn without(&self, other: &Self) -> Self {
        self.with(other, |a, b| a && !b)
    }

    fn with(&self, other: &Self, both: impl Fn(bool, bool) -> bool) -> Self {
        let pairs = self.0.iter().zip(&other.0);
        Self(pairs.map(|(a, b)| both(*a, *b)).collect())
    }
}

/// Where POV-Ray looks for a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampling {
    /// Through its centre: no antialiasing.
    Once,
    /// Method 1: its upper and its left neighbour decide whether it is sampled
    /// again.
    Neighbours,
    /// Method 2: its corners do.
    Corners,
}

/// Pixels of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pixels {
    size: Size,
    bits: Vec<bool>,
}

impl Pixels {
    /// None.
    pub fn none(size: Size) -> Self {
        let bits = vec![false; size.width as usize * size.height as usize];
        Self { size, bits }
    }

    /// Adds those of a block of a state file for which `is_in` holds of their
    /// five numbers.
    pub fn add(&mut self, block: &Block<'_>, is_in: impl Fn([f32; 5]) -> bool) {
        let window = block.window.intersection(self.size.window());
        let width = block.window.width;
        for (k, numbers) in (0_u32..).zip(block.numbers()) {
            let (x, y) = (window.x + k % width, window.y + k / width);
            if x < window.right() && y < window.bottom() && is_in(numbers) {
                self.bits[(y * self.size.width + x) as usize] = true;
            }
        }
    }

    /// Adds those of another picture of that size.
    pub fn merge(&mut self, other: &Self) {
        for (own, others) in self.bits.iter_mut().zip(&other.bits) {
            *own |= *others;
        }
    }

    /// The blocks that are dirty where these pixels are touched.
    pub fn dirty(&self, sampling: Sampling) -> Blocks {
        let grid = Grid { size: self.size };
        Blocks::of(grid, |block| {
            let own = grid.window(block);
            if sampling != Sampling::Neighbours {
                return self.any(own);
            }
            if own.x == 0 || own.y == 0 {
                return true;
            }
            self.any(Window {
                x: own.x - 1,
                y: own.y - 1,
                width: own.width + 1,
                height: own.height + 1,
            })
        })
    }

    fn any(&self, window: Window) -> bool {
        (window.y..window.bottom()).any(|y| {
            let row = (y * self.size.width) as usize;
            self.bits[row + window.x as usize..row + window.right() as usize].contains(&true)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 100,
        height: 70,
    };

    fn touched(x: u32, y: u32) -> Pixels {
        let mut pixels = Pixels::none(SIZE);
        pixels.bits[(y * SIZE.width + x) as usize] = true;
        pixels
    }

    fn dirty(x: u32, y: u32, sampling: Sampling) -> Vec<usize> {
        touched(x, y).dirty(sampling).iter().collect()
    }

    #[test]
    fn a_touched_pixel_dirties_its_block() {
        for sampling in [Sampling::Once, Sampling::Corners] {
            assert_eq!(dirty(0, 0, sampling), [0]);
            assert_eq!(dirty(31, 31, sampling), [0]);
            assert_eq!(dirty(99, 69, sampling), [11]);
        }
    }

    #[test]
    fn method_1_looks_at_the_row_above_and_the_column_to_the_left() {
        let border = [0, 1, 2, 3, 4, 8];
        let more = |x, y| -> Vec<usize> {
            let all = dirty(x, y, Sampling::Neighbours);
            assert!(border.iter().all(|block| all.contains(block)));
            all.into_iter().filter(|b| !border.contains(b)).collect()
        };
        assert_eq!(more(40, 40), [5]);
        assert_eq!(more(63, 40), [5, 6]);
        assert_eq!(more(40, 63), [5, 9]);
        assert_eq!(more(63, 63), [5, 6, 9, 10]);
        // Below and to the right, nothing is looked at.
        assert_eq!(more(64, 64), [10]);
        assert_eq!(more(31, 31), [5]);
    }

    #[test]
    fn sets() {
        let grid = Grid { size: SIZE };
        let even = Blocks::of(grid, |block| block % 2 == 0);
        let low = Blocks::of(grid, |block| block < 4);
        assert_eq!(even.and(&low).iter().collect::<Vec<_>>(), [0, 2]);
        assert_eq!(low.without(&even).iter().collect::<Vec<_>>(), [1, 3]);
        assert_eq!(even.or(&low).len(), 8);
        assert_eq!((grid.count(), even.share()), (12, 0.5));
        assert!(Blocks::none(grid).is_empty() && !Blocks::all(grid).is_empty());
    }
}

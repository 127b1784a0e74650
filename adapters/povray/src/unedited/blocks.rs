//! Blocks of 32 by 32 pixels: sets of them, and which of them are dirty, given
//! the pixels that something touches.
//!
//! POV-Ray looks beyond a block where it antialiases by method 1: it traces the
//! row above and the column to the left too, and what they show decides whether
//! pixels inside are sampled again. So a block is dirty if anything in it, in the
//! row above or in the column to its left is touched. At the upper and the left
//! border of the picture these lie outside: the picture does not show whether they
//! are touched. Method 2 and no antialiasing look at the block's own pixels alone.

use decor_api::{Size, Window, block_window};

use crate::state::{BLOCK, Block};

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

    /// The blocks at the upper and the left border of the picture.
    pub fn border(&self) -> Blocks {
        Blocks::of(*self, |block| {
            let own = self.window(block);
            own.x == 0 || own.y == 0
        })
    }

    /// In a picture that shows one column more to the left and one row more above:
    /// the blocks that show what lies above and to the left of these.
    pub fn showing_beyond(&self, border: &Blocks) -> Blocks {
        let columns = self.columns() as usize;
        let mut found = border.clone();
        for block in border.iter() {
            let own = self.window(block);
            if own.x == 0 && block + columns < self.count() {
                found.insert(block + columns);
            }
            if own.y == 0 && block + 1 < columns {
                found.insert(block + 1);
            }
        }
        found
    }

    /// The rectangle of a block.
    pub fn window(&self, block: usize) -> Window {
        block_window(block as u32, BLOCK, self.size)
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
        match sampling {
            Sampling::Neighbours => self.dirty_within(sampling).or(&grid.border()),
            Sampling::Once | Sampling::Corners => self.dirty_within(sampling),
        }
    }

    /// The same if nothing beyond the upper and the left border is touched.
    pub fn dirty_within(&self, sampling: Sampling) -> Blocks {
        let grid = Grid { size: self.size };
        let further = u32::from(sampling == Sampling::Neighbours);
        Blocks::of(grid, |block| {
            let own = grid.window(block);
            let (x, y) = (own.x.saturating_sub(further), own.y.saturating_sub(further));
            self.any(Window {
                x,
                y,
                width: own.right() - x,
                height: own.bottom() - y,
            })
        })
    }

    /// The blocks of the border beyond which nothing is touched, where these are
    /// the pixels of a picture that shows one column more to the left and one row
    /// more above. (It does not show what the last row and the last column of the
    /// picture have beside them: for their blocks, nothing is known.)
    pub fn untouched_beyond(&self) -> Blocks {
        let grid = Grid { size: self.size };
        let border = grid.border();
        Blocks::of(grid, |block| {
            let own = grid.window(block);
            let row = Window {
                x: own.x + 1,
                y: 0,
                width: own.width,
                height: 1,
            };
            let column = Window {
                x: 0,
                y: own.y + 1,
                width: 1,
                height: own.height,
            };
            let clear = |is_there: bool, shown: Window| {
                !is_there
                    || shown.right() <= self.size.width
                        && shown.bottom() <= self.size.height
                        && !self.any(shown)
            };
            border.has(block) && clear(own.y == 0, row) && clear(own.x == 0, column)
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
    fn what_a_picture_shows_beyond_the_border() {
        let grid = Grid { size: SIZE };
        let untouched = |x, y| -> Vec<usize> { touched(x, y).untouched_beyond().iter().collect() };
        // Blocks 3 and 8 have neighbours that are not shown.
        assert_eq!(untouched(50, 50), [0, 1, 2, 4]);
        // The pixel above column 31, and the one to the left of row 32.
        assert_eq!(untouched(32, 0), [1, 2, 4]);
        assert_eq!(untouched(0, 33), [0, 1, 2]);
        assert_eq!(untouched(33, 0), [0, 2, 4]);
        let border = grid.border();
        assert_eq!(border.iter().collect::<Vec<_>>(), [0, 1, 2, 3, 4, 8]);
        let one = |block: usize| Blocks::of(grid, |b| b == block);
        let shown = |block| grid.showing_beyond(&one(block)).iter().collect::<Vec<_>>();
        assert_eq!(shown(0), [0, 1, 4]);
        assert_eq!((shown(3), shown(8)), (vec![3], vec![8]));
        assert_eq!(
            grid.above_and_left_of(&one(5)).iter().collect::<Vec<_>>(),
            [1, 4]
        );
        assert!(grid.above_and_left_of(&one(0)).is_empty());
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

//! Blocks of a picture: squares on a grid, counted row by row.

use crate::layer::{Size, Window};

/// The side of a block of an antialiased picture, in pixels: the renderers' own
/// grid.
pub const BLOCK: u32 = 32;

/// Some blocks of a picture. The last ones of a row or a column are cut at its
/// border.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Blocks {
    /// The side of each, in pixels, ≥ 1.
    pub side: u32,
    /// Their numbers, row by row, ascending.
    pub numbers: Vec<u32>,
}

impl Blocks {
    /// Blocks of [`BLOCK`] pixels.
    pub fn usual(numbers: Vec<u32>) -> Self {
        Self {
            side: BLOCK,
            numbers,
        }
    }

    /// The rectangle of each of them, in a picture of `size`; empty where the
    /// picture has no such block.
    pub fn windows(&self, size: Size) -> impl Iterator<Item = Window> + '_ {
        let numbers = self.numbers.iter();
        numbers.map(move |&number| block_window(number, self.side, size))
    }

    /// What encloses them.
    pub fn window(&self, size: Size) -> Window {
        self.windows(size).fold(Window::EMPTY, Window::union)
    }
}

/// The rectangle of a block; empty where the picture has no such block.
pub fn block_window(number: u32, side: u32, size: Size) -> Window {
    let columns = size.width.div_ceil(side);
    let block = Window {
        x: (number % columns).saturating_mul(side),
        y: (number / columns).saturating_mul(side),
        width: 1,
        height: 1,
    };
    if block.y >= size.height {
        return Window::EMPTY;
    }
    block.on_grid(side, size)
}

/// The blocks that are wanted, and the window around them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockMask {
    side: u32,
    window: Window,
    columns: u32,
    wanted: Vec<bool>,
}

impl BlockMask {
    /// Blocks of a picture, by number.
    ///
    /// # Errors
    /// The first number that the picture does not have, in words.
    pub fn new(blocks: &Blocks, size: Size) -> Result<Self, String> {
        let side = blocks.side;
        let columns = size.width.div_ceil(side);
        let count = columns as usize * size.height.div_ceil(side) as usize;
        let mut mask = Self {
            side,
            window: blocks.window(size),
            columns,
            wanted: vec![false; count],
        };
        for &block in &blocks.numbers {
            let Some(wanted) = mask.wanted.get_mut(block as usize) else {
                return Err(format!("block {block}: there are {count}"));
            };
            *wanted = true;
        }
        Ok(mask)
    }

    /// The blocks, of [`BLOCK`] pixels, of a window whose edges are on their grid.
    pub fn of(window: Window, size: Size) -> Self {
        let columns = size.width.div_ceil(BLOCK);
        let blocks = (0..size.height.div_ceil(BLOCK))
            .flat_map(|row| (0..columns).map(move |column| (column * BLOCK, row * BLOCK)));
        Self {
            side: BLOCK,
            window,
            columns,
            wanted: blocks.map(|(x, y)| window.contains(x, y)).collect(),
        }
    }

    /// What encloses them.
    pub fn window(&self) -> Window {
        self.window
    }

    /// The side of each, in pixels.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Is pixel (x, y) in one of them?
    pub fn contains(&self, x: u32, y: u32) -> bool {
        let block = y / self.side * self.columns + x / self.side;
        self.wanted.get(block as usize).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 100,
        height: 70,
    };

    #[test]
    fn a_window_is_its_blocks() {
        let mask = BlockMask::new(&Blocks::usual(vec![5, 6, 9, 10]), SIZE).unwrap();
        assert_eq!(mask, BlockMask::of(mask.window(), SIZE));
        assert!(mask.contains(32, 32) && mask.contains(95, 69));
        assert!(!mask.contains(31, 32) && !mask.contains(96, 69) && !mask.contains(32, 31));
    }

    #[test]
    fn the_last_block_is_cut_and_there_are_no_more() {
        let last = BlockMask::new(&Blocks::usual(vec![11]), SIZE)
            .unwrap()
            .window();
        assert_eq!((last.x, last.y, last.width, last.height), (96, 64, 4, 6));
        assert_eq!(
            BlockMask::new(&Blocks::usual(vec![12]), SIZE),
            Err("block 12: there are 12".into())
        );
        let none = BlockMask::new(&Blocks::usual(Vec::new()), SIZE).unwrap();
        assert!(none.window().is_empty());
        assert!(Blocks::usual(vec![12]).window(SIZE).is_empty());
    }

    #[test]
    fn smaller_blocks_are_counted_by_their_own_columns() {
        let blocks = Blocks {
            side: 8,
            numbers: vec![12, 13 * 8 + 1],
        };
        // 13 columns, the last one 4 pixels wide.
        let windows: Vec<Window> = blocks.windows(SIZE).collect();
        assert_eq!((windows[0].x, windows[0].y, windows[0].width), (96, 0, 4));
        assert_eq!((windows[1].x, windows[1].y, windows[1].height), (8, 64, 6));
        let mask = BlockMask::new(&blocks, SIZE).unwrap();
        assert!(mask.contains(99, 7) && mask.contains(8, 69));
        assert!(!mask.contains(95, 0) && !mask.contains(99, 8) && !mask.contains(16, 69));
    }
}

//! Blocks of a picture: squares on a grid, counted row by row.

use crate::layer::{Size, Window};

/// The side of a block, in pixels.
pub const BLOCK: u32 = 32;

/// The blocks that are wanted, and the window around them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BlockMask {
    window: Window,
    columns: u32,
    wanted: Vec<bool>,
}

impl BlockMask {
    /// Blocks of a picture, by number.
    ///
    /// # Errors
    /// The first number that the picture does not have, in words.
    pub fn new(blocks: &[u32], size: Size) -> Result<Self, String> {
        let columns = size.width.div_ceil(BLOCK);
        let count = columns as usize * size.height.div_ceil(BLOCK) as usize;
        let mut mask = Self {
            window: Window::EMPTY,
            columns,
            wanted: vec![false; count],
        };
        for &block in blocks {
            let Some(wanted) = mask.wanted.get_mut(block as usize) else {
                return Err(format!("block {block}: there are {count}"));
            };
            *wanted = true;
            let pixel = Window {
                x: block % columns * BLOCK,
                y: block / columns * BLOCK,
                width: 1,
                height: 1,
            };
            mask.window = mask.window.union(pixel.on_grid(BLOCK, size));
        }
        Ok(mask)
    }

    /// The blocks of a window whose edges are on the grid.
    pub fn of(window: Window, size: Size) -> Self {
        let columns = size.width.div_ceil(BLOCK);
        let blocks = (0..size.height.div_ceil(BLOCK))
            .flat_map(|row| (0..columns).map(move |column| (column * BLOCK, row * BLOCK)));
        Self {
            window,
            columns,
            wanted: blocks.map(|(x, y)| window.contains(x, y)).collect(),
        }
    }

    /// What encloses them.
    pub fn window(&self) -> Window {
        self.window
    }

    /// Is pixel (x, y) in one of them?
    pub fn contains(&self, x: u32, y: u32) -> bool {
        let block = y / BLOCK * self.columns + x / BLOCK;
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
        let mask = BlockMask::new(&[5, 6, 9, 10], SIZE).unwrap();
        assert_eq!(mask, BlockMask::of(mask.window(), SIZE));
        assert!(mask.contains(32, 32) && mask.contains(95, 69));
        assert!(!mask.contains(31, 32) && !mask.contains(96, 69) && !mask.contains(32, 31));
    }

    #[test]
    fn the_last_block_is_cut_and_there_are_no_more() {
        let last = BlockMask::new(&[11], SIZE).unwrap().window();
        assert_eq!((last.x, last.y, last.width, last.height), (96, 64, 4, 6));
        assert_eq!(
            BlockMask::new(&[12], SIZE),
            Err("block 12: there are 12".into())
        );
        assert!(BlockMask::new(&[], SIZE).unwrap().window().is_empty());
    }
}

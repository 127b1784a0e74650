//! Blocks of which one pixel is as good as all of them, and what of their borders
//! matters all the same.
//!
//! With antialiasing a pixel that can change makes the blocks of its neighbours change.
//! So a marked block is done, but for the pixels that have a neighbour in a block that
//! is not.

use decor_api::{Size, Window, block_window};
use rayon::prelude::*;

use super::Mask;
use super::trace::Tracer;
use crate::plan::BlockSet;

/// The places of a block's neighbours, each a bit.
mod place {
    pub const LEFT: u8 = 1;
    pub const RIGHT: u8 = 2;
    pub const ABOVE: u8 = 4;
    pub const BELOW: u8 = 8;
    pub const LEFT_ABOVE: u8 = 16;
    pub const RIGHT_ABOVE: u8 = 32;
    pub const LEFT_BELOW: u8 = 64;
    pub const RIGHT_BELOW: u8 = 128;
}

/// A block on the way: is something of it marked, and what is still to be found out?
pub(super) struct Tile {
    window: Window,
    is_marked: bool,
    /// The neighbours that a marked pixel at the border would make change.
    open: u8,
}

impl Tile {
    /// Of which nothing is known, and no neighbour is asked about.
    pub fn new(window: Window) -> Self {
        Self {
            window,
            is_marked: false,
            open: 0,
        }
    }

    /// Does a square of it need no look?
    pub fn is_done(&self, cell: Window) -> bool {
        self.is_marked && self.open & self.beside(cell) == 0
    }

    /// A square of it is marked.
    pub fn mark(&mut self, cell: Window) {
        self.is_marked = true;
        self.open &= !self.beside(cell);
    }

    /// The neighbours that a square of it has pixels beside.
    fn beside(&self, cell: Window) -> u8 {
        let Self { window, .. } = self;
        let bit = |holds: bool, place: u8| if holds { place } else { 0 };
        let (left, right) = (cell.x <= window.x, cell.right() >= window.right());
        let (above, below) = (cell.y <= window.y, cell.bottom() >= window.bottom());
        bit(left, place::LEFT)
            | bit(right, place::RIGHT)
            | bit(above, place::ABOVE)
            | bit(below, place::BELOW)
            | bit(left && above, place::LEFT_ABOVE)
            | bit(right && above, place::RIGHT_ABOVE)
            | bit(left && below, place::LEFT_BELOW)
            | bit(right && below, place::RIGHT_BELOW)
    }
}

/// Marks, in blocks that have a marked pixel, those at the border that make another
/// block change: at least one for each that does. `causes` are the mask's, row by row.
pub(super) fn borders(tracer: &Tracer<'_>, size: Size, side: u32, causes: Vec<u8>) -> Vec<u8> {
    let mask = Mask::from_causes(size, causes);
    let marked = mask.blocks(side);
    let done = mask.blocks_around(side, 1, None);
    let mut causes = mask.into_causes();
    let rows = (side * size.width) as usize;
    let bands = causes.par_chunks_mut(rows.max(1)).enumerate();
    bands.for_each(|(band, rows)| {
        let columns = size.width.div_ceil(side);
        for number in (0..columns).map(|column| band as u32 * columns + column) {
            let window = block_window(number, side, size);
            if !marked.has_pixel(window.x, window.y) {
                continue;
            }
            let open = open(window, &done, size);
            if open != 0 {
                let mut tile = Tile {
                    window,
                    is_marked: true,
                    open,
                };
                tracer.within(window, rows, &mut tile);
            }
        }
    });
    causes
}

/// The neighbours of a block that are not among the blocks.
fn open(window: Window, blocks: &BlockSet, size: Size) -> u8 {
    let (left, right) = (window.x.checked_sub(1), window.right());
    let (above, below) = (window.y.checked_sub(1), window.bottom());
    let right = (right < size.width).then_some(right);
    let below = (below < size.height).then_some(below);
    let (x, y) = (Some(window.x), Some(window.y));
    let places = [
        (left, y, place::LEFT),
        (right, y, place::RIGHT),
        (x, above, place::ABOVE),
        (x, below, place::BELOW),
        (left, above, place::LEFT_ABOVE),
        (right, above, place::RIGHT_ABOVE),
        (left, below, place::LEFT_BELOW),
        (right, below, place::RIGHT_BELOW),
    ];
    let open = places.into_iter().filter_map(|(x, y, place)| {
        let is_there = !blocks.has_pixel(x?, y?);
        is_there.then_some(place)
    });
    open.fold(0, |all, place| all | place)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 70,
        height: 64,
    };

    #[test]
    fn a_neighbour_is_open_where_it_is_in_the_picture_and_not_done() {
        let mut done = BlockSet::none(SIZE, 32);
        assert_eq!(open(block_window(4, 32, SIZE), &done, SIZE), 0b0011_0111);
        done.insert(block_window(1, 32, SIZE));
        done.insert(block_window(3, 32, SIZE));
        let expected = place::RIGHT | place::LEFT_ABOVE | place::RIGHT_ABOVE;
        assert_eq!(open(block_window(4, 32, SIZE), &done, SIZE), expected);
        let expected = place::LEFT | place::LEFT_BELOW | place::BELOW;
        assert_eq!(
            open(block_window(2, 32, SIZE), &BlockSet::none(SIZE, 32), SIZE),
            expected
        );
    }

    #[test]
    fn what_is_marked_needs_a_look_only_beside_open_neighbours() {
        let window = block_window(4, 32, SIZE);
        let mut tile = Tile::new(window);
        let (first, middle) = (Window::pixel(32, 32), Window::pixel(40, 40));
        assert!(!tile.is_done(middle));
        tile.mark(middle);
        assert!(tile.is_done(middle) && tile.is_done(first));
        tile.open = place::LEFT | place::LEFT_ABOVE | place::RIGHT;
        assert!(tile.is_done(middle) && !tile.is_done(first));
        assert!(!tile.is_done(Window::pixel(32, 63)));
        assert!(tile.is_done(Window::pixel(40, 32)), "nothing is open above");
        tile.mark(first);
        assert!(tile.is_done(Window::pixel(32, 63)));
        assert!(!tile.is_done(Window::pixel(63, 50)));
    }
}

//! Marked pixels, and why each is.

use decor_api::{Size, Window};

use crate::plan::BlockSet;

/// Why a pixel can change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Cause {
    /// What changed can be seen there.
    Seen = 1,
    /// What changed can cast a shadow on what is seen there.
    Shadowed = 2,
    /// What is seen there mirrors or lets light through.
    Optical = 4,
    /// Only a neighbour can change: antialiasing looks at it.
    Neighbour = 8,
}

/// Pixels of a picture that can change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mask {
    size: Size,
    /// Of every pixel, all [`Cause`]s added up.
    causes: Vec<u8>,
}

impl Mask {
    /// No pixel.
    pub fn none(size: Size) -> Self {
        Self::from_causes(size, vec![0; size.pixels()])
    }

    pub(super) fn from_causes(size: Size, causes: Vec<u8>) -> Self {
        Self { size, causes }
    }

    pub(super) fn into_causes(self) -> Vec<u8> {
        self.causes
    }

    /// The picture's size.
    pub fn size(&self) -> Size {
        self.size
    }

    fn code(&self, x: u32, y: u32) -> u8 {
        if x >= self.size.width || y >= self.size.height {
            return 0;
        }
        self.causes[y as usize * self.size.width as usize + x as usize]
    }

    /// Can pixel (x, y) change? Outside of the picture none can.
    pub fn contains(&self, x: u32, y: u32) -> bool {
        self.code(x, y) != 0
    }

    /// Can pixel (x, y) change for this cause? Several may hold.
    pub fn has(&self, x: u32, y: u32, cause: Cause) -> bool {
        self.code(x, y) & cause as u8 != 0
    }

    /// How many pixels can change.
    pub fn count(&self) -> usize {
        self.causes.iter().filter(|code| **code != 0).count()
    }

    /// How many pixels can change for this cause, and perhaps for others.
    pub fn count_of(&self, cause: Cause) -> usize {
        let codes = self.causes.iter();
        codes.filter(|code| **code & cause as u8 != 0).count()
    }

    /// With the eight neighbours of every pixel: antialiasing compares a pixel
    /// with those around it, in POV-Ray also over a block's border.
    pub fn dilated(&self) -> Self {
        let width = self.size.width as usize;
        let mut causes = self.causes.clone();
        for (y, row) in self.causes.chunks(width.max(1)).enumerate() {
            for x in (0..row.len()).filter(|&x| row[x] != 0) {
                let columns = x.saturating_sub(1)..(x + 2).min(width);
                for near in y.saturating_sub(1)..(y + 2).min(self.size.height as usize) {
                    for code in &mut causes[near * width..][columns.clone()] {
                        if *code == 0 {
                            *code = Cause::Neighbour as u8;
                        }
                    }
                }
            }
        }
        Self::from_causes(self.size, causes)
    }

    /// The blocks of that side that have one of the pixels.
    pub fn blocks(&self, side: u32) -> BlockSet {
        self.blocks_around(side, 0, None)
    }

    /// The blocks of that side that have a pixel at most `around` away, to the side
    /// and up and down, from one that can change for `cause`; `None`: for any.
    pub fn blocks_around(&self, side: u32, around: u32, cause: Option<Cause>) -> BlockSet {
        let causes = cause.map_or(u8::MAX, |cause| cause as u8);
        let mut blocks = BlockSet::none(self.size, side);
        let width = self.size.width as usize;
        for (y, row) in (0_u32..).zip(self.causes.chunks(width.max(1))) {
            // Most rows have none; all of one are looked at sooner than one by one.
            if row.iter().fold(0, |all, code| all | code) & causes == 0 {
                continue;
            }
            let is_one = |code: &u8| code & causes != 0;
            let mut x = 0;
            while let Some(first) = row[x..].iter().position(is_one) {
                let start = x + first;
                let length = row[start..].iter().take_while(|code| is_one(code)).count();
                x = start + length;
                let (left, top) = (
                    (start as u32).saturating_sub(around),
                    y.saturating_sub(around),
                );
                let right = (x as u32).saturating_add(around).min(self.size.width);
                let bottom = (y + 1).saturating_add(around).min(self.size.height);
                blocks.insert(Window {
                    x: left,
                    y: top,
                    width: right - left,
                    height: bottom - top,
                });
            }
        }
        blocks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::BLOCK;

    const SIZE: Size = Size {
        width: 70,
        height: 40,
    };

    fn one(x: usize, y: usize) -> Mask {
        let mut causes = vec![0; SIZE.pixels()];
        causes[y * 70 + x] = Cause::Shadowed as u8;
        Mask::from_causes(SIZE, causes)
    }

    #[test]
    fn dilation_goes_over_the_borders_of_blocks_but_not_of_the_picture() {
        let wide = one(31, 31).dilated();
        assert_eq!(wide.count(), 9);
        assert_eq!(wide.count_of(Cause::Shadowed), 1);
        assert!(wide.has(32, 32, Cause::Neighbour));
        assert!(!wide.has(31, 31, Cause::Neighbour) && wide.has(31, 31, Cause::Shadowed));
        assert_eq!(wide.blocks(BLOCK).numbers(), [0, 1, 3, 4]);
        assert_eq!(one(31, 31).blocks(BLOCK).numbers(), [0]);
        assert_eq!(
            one(31, 31).blocks_around(BLOCK, 1, None),
            wide.blocks(BLOCK)
        );
        let shadowed = one(31, 31).blocks_around(BLOCK, 1, Some(Cause::Shadowed));
        assert_eq!(shadowed, wide.blocks(BLOCK));
        let seen = one(31, 31).blocks_around(BLOCK, 1, Some(Cause::Seen));
        assert!(seen.is_empty());
        assert_eq!(
            one(0, 0)
                .blocks_around(BLOCK, u32::MAX, None)
                .numbers()
                .len(),
            6
        );
        let corner = one(69, 39).dilated();
        assert_eq!(corner.count(), 4);
        assert_eq!(corner.blocks(BLOCK).numbers(), [5]);
    }

    #[test]
    fn runs_of_pixels_are_all_in_the_blocks() {
        let mut causes = vec![0; SIZE.pixels()];
        causes[20..60].fill(Cause::Seen as u8);
        causes[63] = Cause::Seen as u8;
        causes[69] = Cause::Optical as u8;
        assert_eq!(
            Mask::from_causes(SIZE, causes).blocks(BLOCK).numbers(),
            [0, 1, 2]
        );
        assert!(Mask::none(SIZE).blocks(BLOCK).is_empty());
    }
}

//! Blocks that two whole frames do not show alike. None of them may be clean in both:
//! where one is, what does not move depends on what does, in a way that no ray tells
//! (where surfaces coincide, POV-Ray's bounding tree decides which is seen), and
//! every frame is rendered whole. Masks only shrink while they are found, so the
//! question is put after each step, and the first answer ends it.

use decor_povray::unedited::{Blocks, Grid, differing};

use super::film::Trial;
use crate::render::RenderError;

/// Why frames are rendered whole whose blocks are nowhere.
pub const NO_BLOCKS: &str = "POV-Ray kept no blocks";

/// Two frames of a film, and where they differ.
pub struct Unlike {
    frames: [usize; 2],
    blocks: Blocks,
}

impl Unlike {
    /// Of the trial's frames, where their blocks were kept.
    pub fn of(trial: &Trial, grid: Grid) -> Result<Option<Self>, RenderError> {
        let (Some(first), Some(second)) = (trial.blocks(0), trial.blocks(1)) else {
            return Ok(None);
        };
        Ok(Some(Self {
            frames: trial.frames,
            blocks: differing(first, second, &Blocks::all(grid))?,
        }))
    }

    /// One that is clean in both frames, by the dirty blocks of all.
    pub fn clean_in(&self, dirty: &[Blocks]) -> Option<usize> {
        let [a, b] = self.frames.map(|frame| &dirty[frame]);
        self.blocks.without(&a.or(b)).iter().next()
    }
}

/// Why a scene with such a block is rendered whole.
pub fn reason(block: usize) -> String {
    format!("what does not move is not the same in two frames (block {block})")
}

#[cfg(test)]
mod tests {
    use decor_api::Size;

    use super::*;

    #[test]
    fn what_is_dirty_in_one_of_the_frames_may_differ() {
        let size = Size {
            width: 320,
            height: 32,
        };
        let grid = Grid { size };
        let only = |wanted: &[usize]| Blocks::of(grid, |block| wanted.contains(&block));
        let unlike = Unlike {
            frames: [0, 2],
            blocks: only(&[3, 7]),
        };
        let dirty = |first: &[usize], last: &[usize]| [only(first), only(&[]), only(last)];
        assert_eq!(unlike.clean_in(&dirty(&[3, 4], &[7])), None);
        assert_eq!(unlike.clean_in(&dirty(&[3, 4], &[8])), Some(7));
        assert_eq!(unlike.clean_in(&dirty(&[], &[])), Some(3));
        // What is between the two says nothing.
        let between = [only(&[]), only(&[3, 7]), only(&[7])];
        assert_eq!(unlike.clean_in(&between), Some(3));
    }
}

//! What moving objects can touch, by POV-Ray itself.
//!
//! In a copy of the scene boxes stand for all that moves, for a group of frames
//! at once, two for each place: one that glows, and throws no shadow; and one
//! that nobody sees, and that multiplies the light that passes by a huge number.
//! A pixel of this picture that is not below [`TOUCHED`] has a ray, of whatever
//! kind and after however many mirrors, that meets a box. Every other pixel is
//! the same in all frames of the group, and in the scene without what moves.
//! Where there is antialiasing, every pixel is sampled again, as much as any
//! frame could.
//!
//! Boxes are larger than what they stand for by more than POV-Ray's tolerance: a
//! shadow ray that begins inside one leaves it through a face that counts.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use decor_api::{AdapterError, RunContext};
use glam::DVec3;

use super::analysis::Analysis;
use super::blocks::{Blocks, Grid, Pixels, Sampling};
use super::boxes::{Extent, FrameBoxes};
use super::frames::{Timing, blocks_of, timing};
use super::source::{Copy, Sources};
use crate::number::vector;
use crate::plain::{More, Part, PlainScene};
use crate::state;

/// No picture is as bright.
const TOUCHED: f32 = 1e6;

/// POV-Ray's own tolerance is half of it.
const AROUND: f64 = 2e-3;

/// A box: its least and its greatest corner.
type Aabb = (DVec3, DVec3);

/// A copy of a scene with boxes for what moves.
#[derive(Debug)]
pub struct Proxy<'a> {
    scene: &'a PlainScene,
    grid: Grid,
    copy: Copy,
    frame: u32,
}

impl<'a> Proxy<'a> {
    /// Writes the copy for a group of frames; `None` where something moves that
    /// has no end.
    ///
    /// # Errors
    /// [`AdapterError::Io`].
    pub fn new(
        scene: &'a PlainScene,
        sources: &Sources,
        analysis: &Analysis,
        group: &[FrameBoxes],
        run: &RunContext,
    ) -> Result<Option<Self>, AdapterError> {
        let Some((boxes, first)) = merged(analysis, group).zip(group.first()) else {
            return Ok(None);
        };
        let mut edits = analysis.hidden();
        edits.push(sources.behind(text(&analysis.prefix, &boxes)));
        let last = group.last().map_or(first.frame, |last| last.frame);
        let name = format!("proxy-{:05}-{last:05}", first.frame);
        let folder = run.work.join(name);
        std::fs::create_dir_all(&folder).map_err(AdapterError::io(&folder))?;
        Ok(Some(Self {
            scene,
            grid: scene.grid(),
            copy: sources.rewritten(&edits, &folder)?,
            frame: first.frame,
        }))
    }

    /// The pixels of some blocks that are touched in any frame of the group, and
    /// what that took.
    ///
    /// # Errors
    /// Any [`AdapterError`].
    pub fn touched(
        &self,
        asked: &Blocks,
        run: &RunContext,
    ) -> Result<(Pixels, Timing), AdapterError> {
        let mut switches = self.copy.switches.clone();
        switches.extend(["Statistic_Console=on", "+WT1"].map(str::to_owned));
        if self.scene.sampling() != Sampling::Once {
            // All pixels are sampled again.
            switches.push("+A0.0".into());
        }
        let ids: Vec<u32> = asked.iter().map(|id| id as u32).collect();
        let size = self.grid.size;
        let part = Part {
            first: self.frame,
            last: self.frame,
            threads: None,
        };
        let more = More {
            switches,
            state: Some(&|_| state::masked(size, &ids)),
        };
        let called = self.scene.call(part, "touched", &more, run)?;
        let mut pixels = Pixels::none(size);
        let mut missing = asked.clone();
        for (_, file) in &called.states {
            let bytes = std::fs::read(file).map_err(AdapterError::io(file))?;
            for block in blocks_of(file, &bytes)? {
                let id = block.id as usize;
                if asked.has(id) {
                    missing.remove(id);
                    pixels.add(&block, is_touched);
                }
            }
            if let Some(block) = missing.iter().next() {
                return Err(AdapterError::BadOutput {
                    program: "povray".into(),
                    file: file.clone(),
                    reason: format!("block {block} is missing"),
                });
            }
        }
        Ok((pixels, timing(&called.said)))
    }
}

/// Not a number is touched, too.
fn is_touched(numbers: [f32; 5]) -> bool {
    !numbers.iter().all(|n| n.abs() < TOUCHED)
}

/// The boxes of what moves, over all frames: boxes that follow each other become
/// one where that is no larger than both.
fn merged(analysis: &Analysis, group: &[FrameBoxes]) -> Option<Vec<Aabb>> {
    let area = |(min, max): Aabb| {
        let side = max - min;
        side.x * side.y + side.y * side.z + side.z * side.x
    };
    let mut last: BTreeMap<(usize, usize), Aabb> = BTreeMap::new();
    let mut done = Vec::new();
    for frame in group {
        let mut count: BTreeMap<usize, usize> = BTreeMap::new();
        for object in &frame.objects {
            let moves = analysis.statements.get(object.statement);
            if !moves.is_none_or(|statement| statement.moves) {
                continue;
            }
            let Extent::Box { min, max } = object.extent else {
                return None;
            };
            if !(min.is_finite() && max.is_finite()) {
                return None;
            }
            let which = count.entry(object.statement).or_default();
            let key = (object.statement, *which);
            *which += 1;
            let new = (min, max);
            match last.get_mut(&key) {
                Some(old) => {
                    let both = (old.0.min(min), old.1.max(max));
                    if area(both) <= area(*old) + area(new) {
                        *old = both;
                    } else {
                        done.push(std::mem::replace(old, new));
                    }
                }
                None => {
                    last.insert(key, new);
                }
            }
        }
    }
    done.extend(last.into_values());
    Some(done)
}

/// The boxes as they stand behind the scene.
fn text(prefix: &str, boxes: &[Aabb]) -> String {
    let mut text = format!(
        "\
#declare {prefix}language = version;
#version 3.7;
#macro {prefix}proxy(A_, B_)
  box {{ A_, B_
    pigment {{ rgb 1 }} finish {{ ambient 0 diffuse 0 emission 1e20 }}
    no_shadow hollow
  }}
  box {{ A_, B_
    pigment {{ rgbf <1e20, 1e20, 1e20, 1> }} finish {{ ambient 0 diffuse 0 }}
    no_image no_reflection hollow
  }}
#end
"
    );
    for (min, max) in boxes {
        let largest = min.abs().max(max.abs()).max_element();
        // Extents are of single precision.
        let around = DVec3::splat(AROUND + largest * 1e-5);
        let (min, max) = (vector(*min - around), vector(*max + around));
        let _ = writeln!(text, "{prefix}proxy({min}, {max})");
    }
    let _ = writeln!(text, "#version {prefix}language;");
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::unedited::boxes::Placed;

    fn frame(frame: u32, boxes: &[(f64, f64)]) -> FrameBoxes {
        let placed = |(at, side): &(f64, f64)| Placed {
            statement: 0,
            extent: Extent::Box {
                min: DVec3::splat(*at),
                max: DVec3::splat(at + side),
            },
        };
        FrameBoxes {
            frame,
            objects: boxes.iter().map(placed).collect(),
            ..FrameBoxes::default()
        }
    }

    #[test]
    fn boxes_that_hardly_move_become_one() {
        // A statement that is not known moves.
        let slow: Vec<FrameBoxes> = (0..9)
            .map(|k| frame(k, &[(0.01 * f64::from(k), 1.0)]))
            .collect();
        let one = merged(&Analysis::default(), &slow).unwrap();
        assert_eq!(one, [(DVec3::ZERO, DVec3::splat(0.08 + 1.0))]);
        let fast: Vec<FrameBoxes> = (0..9)
            .map(|k| frame(k, &[(5.0 * f64::from(k), 1.0)]))
            .collect();
        assert_eq!(merged(&Analysis::default(), &fast).unwrap().len(), 9);
        let two = [frame(0, &[(0.0, 1.0), (9.0, 1.0)]), frame(1, &[(0.1, 1.0)])];
        assert_eq!(merged(&Analysis::default(), &two).unwrap().len(), 2);
    }

    #[test]
    fn what_has_no_end_has_no_box() {
        let mut endless = frame(0, &[(0.0, 1.0)]);
        endless.objects[0].extent = Extent::Endless;
        assert_eq!(merged(&Analysis::default(), &[endless]), None);
        let lost = frame(0, &[(f64::NAN, 1.0)]);
        assert_eq!(merged(&Analysis::default(), &[lost]), None);
    }

    #[test]
    fn what_is_touched() {
        assert!(!is_touched([0.5, 1.0, -3.0, 0.0, 1.0]));
        assert!(is_touched([0.5, 1e7, 0.0, 0.0, 0.0]));
        assert!(is_touched([f32::INFINITY, 0.0, 0.0, 0.0, 0.0]));
        assert!(is_touched([f32::NAN, 0.0, 0.0, 0.0, 0.0]));
        assert!(is_touched([-1e7, 0.0, 0.0, 0.0, 0.0]));
    }

    #[test]
    fn text_of_the_boxes() {
        insta::assert_snapshot!(text("decor0_", &[(DVec3::ZERO, DVec3::ONE)]));
    }
}

//! What moving objects can touch, by POV-Ray itself.
//!
//! In a copy of the scene boxes and balls stand for all that moves, for a group of frames
//! at once, two for each place: one that glows, and throws no shadow; and one
//! that nobody sees, and that multiplies the light that passes by a huge number.
//! A pixel of this picture that is not below [`TOUCHED`] has a ray, of whatever
//! kind and after however many mirrors, that meets a box.
//!
//! The numbers overflow: a touched pixel is infinite or not a number, and between two
//! of these POV-Ray sees no difference, and does not sample them again. Nothing is
//! lost by that: a block in whose samples one is touched is dirty anyway.
//!
//! Antialiasing is the user's own. POV-Ray decides by what the rays of a block
//! bring which further ones to trace, from the first to the last: if none of those
//! that it traces for a block of this picture meets a box, none of them brings
//! anything else in a frame of the group, so the decisions are the same, and so are
//! the further rays. All rays of a block show in its own pixels, but for those of
//! method 1 above and to the left of it ([`super::blocks`]): they are the first rays
//! of other blocks' pixels, which show them.
//!
//! Blocks above and to the left that are not asked for must be known to show no
//! box: by geometry, or by a pass for more frames ([`Hulls`] says why that is
//! enough).

use std::fmt::Write as _;

use decor_api::{AdapterError, RunContext};

use super::analysis::Analysis;
use super::blocks::{Blocks, Grid, Pixels};
use super::frames::{Timing, blocks_of, only, timing};
use super::hulls::Hulls;
use super::solid::Solid;
use super::source::{Copy, Sources};
use super::view::View;
use crate::number::{number, vector};
use crate::plain::{More, Part, PlainScene};

/// No picture is as bright.
const TOUCHED: f32 = 1e6;

/// A copy of a scene with boxes for what moves.
#[derive(Debug)]
pub struct Proxy<'a> {
    scene: &'a PlainScene,
    grid: Grid,
    copy: Copy,
    frame: u32,
    /// Without antialiasing.
    once: bool,
}

impl<'a> Proxy<'a> {
    /// Writes the copy for a group of frames.
    ///
    /// # Errors
    /// [`AdapterError::Io`].
    pub fn new(
        scene: &'a PlainScene,
        sources: &Sources,
        analysis: &Analysis,
        hulls: &Hulls,
        run: &RunContext,
    ) -> Result<Self, AdapterError> {
        Self::with(scene, sources, analysis, hulls, None, run)
    }

    /// The same, but its picture shows one column more to the left, and one row more
    /// above ([`Pixels::untouched_beyond`]): rays of method 1 that no block of the
    /// picture shows. They are these rays but for the last digits; boxes are larger
    /// than what they stand for by more than that.
    ///
    /// # Errors
    /// [`AdapterError::Io`].
    pub fn beyond(
        scene: &'a PlainScene,
        sources: &Sources,
        analysis: &Analysis,
        hulls: &Hulls,
        view: &View,
        run: &RunContext,
    ) -> Result<Self, AdapterError> {
        Self::with(scene, sources, analysis, hulls, Some(view), run)
    }

    fn with(
        scene: &'a PlainScene,
        sources: &Sources,
        analysis: &Analysis,
        hulls: &Hulls,
        beyond: Option<&View>,
        run: &RunContext,
    ) -> Result<Self, AdapterError> {
        let mut edits = analysis.hidden();
        let mut behind = text(&analysis.prefix, &hulls.solids);
        if let Some(view) = beyond {
            // The last camera counts.
            behind.push_str(&view.one_pixel_further());
        }
        edits.push(sources.behind(behind));
        let (first, last) = hulls.frames;
        let what = if beyond.is_some() { "beyond" } else { "proxy" };
        let folder = run.work.join(format!("{what}-{first:05}-{last:05}"));
        std::fs::create_dir_all(&folder).map_err(AdapterError::io(&folder))?;
        Ok(Self {
            scene,
            grid: scene.grid(),
            copy: sources.rewritten(&edits, &folder)?,
            frame: first,
            once: beyond.is_some(),
        })
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
        if self.once {
            switches.push("-A".into());
        }
        let size = self.grid.size;
        let part = Part {
            first: self.frame,
            last: self.frame,
            threads: None,
        };
        let more = More {
            switches,
            state: Some(&|_| only(self.grid, asked)),
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

/// The boxes and balls as they stand behind the scene.
fn text(prefix: &str, solids: &[Solid]) -> String {
    let mut text = format!(
        "\
#declare {prefix}language = version;
#version 3.7;
#macro {prefix}proxy(O_)
  object {{ O_
    pigment {{ rgb 1e38 }} finish {{ ambient 0 diffuse 0 emission 1e38 }}
    no_shadow hollow
  }}
  object {{ O_
    pigment {{ rgbf <1e38, 1e38, 1e38, 1> }} finish {{ ambient 0 diffuse 0 }}
    no_image no_reflection hollow
  }}
#end
"
    );
    for solid in solids {
        let shape = match *solid {
            Solid::Box { min, max } => format!("box {{ {}, {} }}", vector(min), vector(max)),
            Solid::Ball { centre, radius } => {
                format!("sphere {{ {}, {} }}", vector(centre), number(radius))
            }
        };
        let _ = writeln!(
            text,
            "#declare {prefix}solid = {shape} {prefix}proxy({prefix}solid)"
        );
    }
    let _ = writeln!(text, "#version {prefix}language;");
    text
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

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
        insta::assert_snapshot!(text(
            "decor0_",
            &[
                Solid::Box {
                    min: DVec3::ZERO,
                    max: DVec3::ONE
                },
                Solid::Ball {
                    centre: DVec3::X,
                    radius: 0.5
                }
            ]
        ));
    }
}

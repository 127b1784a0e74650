//! What stands for an object that moves: its box, or its ball where the text says
//! that it is one. A ball's box shows, shades and is mirrored nearly twice as much.

use std::ops::Range;

use glam::DVec3;

use super::boxes::{Extent, Placed};
use super::lex::{Kind, Token};
use super::outline::{Outline, Tokens};

/// Twice POV-Ray's own tolerance.
const AROUND: f64 = 2e-3;

/// The same for large coordinates: extents are of single precision.
const AROUND_SHARE: f64 = 1e-5;

/// The sides of a ball's box may differ by this share of its largest coordinate.
const UNEVEN: f64 = 1e-5;

/// Two balls become one that is larger by no more than this.
const GROWTH: f64 = 1.05;

/// Words behind which a sphere may be none, or its box not that of a sphere.
pub(super) const RESHAPING: &[&str] = &["scale", "matrix", "transform", "clipped_by", "bounded_by"];

/// A box, or a ball.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Solid {
    /// From its least corner to its greatest one.
    Box { min: DVec3, max: DVec3 },
    /// All that is nearer to its centre.
    Ball { centre: DVec3, radius: f64 },
}

/// Are these tokens a sphere that is only moved and turned? Then its box tells which.
pub(super) fn is_round(outline: &Outline<'_>, file: usize, range: &Range<usize>) -> bool {
    let tokens = &outline.tokens[file];
    let list = &tokens.list[range.clone()];
    if list.first().is_none_or(|first| first.text != "sphere") {
        return false;
    }
    let is_macro = |text: &str| outline.called.contains_key(text);
    let plain = |kind: Kind, text: &str| kind != Kind::Directive && !is_macro(text);
    if list.iter().any(|token| !plain(token.kind, token.text)) {
        return false;
    }
    if is_named(tokens, range) {
        return false;
    }
    // Within its own braces: what a texture's do is nothing to it.
    let mut at = range.start + 2;
    while at + 1 < range.end {
        let token = tokens.list[at];
        if token.kind == Kind::Word && RESHAPING.contains(&token.text) {
            return false;
        }
        at = tokens.partner[at].max(at) + 1;
    }
    true
}

/// `sphere { S … }` with an object's name, or an element of an array of them: it is that
/// object, whatever it is. A centre has a number, an operator or a comma behind it.
fn is_named(tokens: &Tokens<'_>, range: &Range<usize>) -> bool {
    let first = range.start + 2;
    let mut behind = first + 1;
    while behind < range.end && tokens.list[behind].is_mark("[") {
        behind = tokens.partner[behind] + 1;
    }
    let ends = |token: &Token<'_>| token.kind == Kind::Word || token.is_mark("}");
    let is_word = tokens.list.get(first).is_some_and(|t| t.kind == Kind::Word);
    is_word && tokens.list.get(behind).is_none_or(ends)
}

impl Solid {
    /// What is placed there; `None` where it has no end.
    pub(super) fn of(placed: &Placed) -> Option<Self> {
        let Extent::Box { min, max } = placed.extent else {
            return None;
        };
        if !(min.is_finite() && max.is_finite()) {
            return None;
        }
        let sides = max - min;
        let uneven = sides.max_element() - sides.min_element();
        let largest = min.abs().max(max.abs()).max_element();
        if placed.round && sides.min_element() > 0.0 && uneven <= UNEVEN * largest {
            return Some(Self::Ball {
                centre: (min + max) / 2.0,
                radius: sides.max_element() / 2.0 + uneven,
            });
        }
        Some(Self::Box { min, max })
    }

    /// Points whose hull holds it.
    pub(super) fn points(&self) -> Vec<DVec3> {
        match *self {
            Self::Box { min, max } => corners(min, max).to_vec(),
            Self::Ball { centre, radius } => {
                let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
                // A dodecahedron: the cube of side 2, and three rectangles. A ball
                // within it has a radius of golden² / √(golden² + 1).
                let inner = golden * golden / (golden * golden + 1.0).sqrt();
                let mut points = corners(-DVec3::ONE, DVec3::ONE).to_vec();
                for (a, b) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let (short, long) = (a / golden, b * golden);
                    points.push(DVec3::new(0.0, short, long));
                    points.push(DVec3::new(short, long, 0.0));
                    points.push(DVec3::new(long, 0.0, short));
                }
                let scale = radius / inner;
                points.iter().map(|p| centre + *p * scale).collect()
            }
        }
    }

    /// The same, larger by more than POV-Ray's tolerance.
    #[must_use]
    pub(super) fn grown(self) -> Self {
        match self {
            Self::Box { min, max } => {
                let largest = min.abs().max(max.abs()).max_element();
                let around = DVec3::splat(AROUND + largest * AROUND_SHARE);
                Self::Box {
                    min: min - around,
                    max: max + around,
                }
            }
            Self::Ball { centre, radius } => {
                let largest = centre.abs().max_element() + radius;
                Self::Ball {
                    centre,
                    radius: radius + AROUND + largest * AROUND_SHARE,
                }
            }
        }
    }

    /// One that holds both, where it is hardly larger than they are.
    pub(super) fn joined(&self, other: &Self) -> Option<Self> {
        let area = |min: DVec3, max: DVec3| {
            let side = max - min;
            side.x * side.y + side.y * side.z + side.z * side.x
        };
        match (*self, *other) {
            (Self::Box { min, max }, Self::Box { min: a, max: b }) => {
                let (low, high) = (min.min(a), max.max(b));
                let both = area(min, max) + area(a, b);
                (area(low, high) <= both).then_some(Self::Box {
                    min: low,
                    max: high,
                })
            }
            (
                Self::Ball { centre, radius },
                Self::Ball {
                    centre: other,
                    radius: its,
                },
            ) => {
                let apart = other - centre;
                let (far, most) = (apart.length(), radius.max(its));
                if far + radius.min(its) <= most {
                    return Some(if its > radius {
                        Self::Ball {
                            centre: other,
                            radius: its,
                        }
                    } else {
                        *self
                    });
                }
                let around = f64::midpoint(radius + its, far);
                (around <= GROWTH * most).then(|| Self::Ball {
                    centre: centre + apart * ((around - radius) / far),
                    // What rounding may take away.
                    radius: around * (1.0 + 1e-12),
                })
            }
            _ => None,
        }
    }
}

/// The corners of a box.
pub(super) fn corners(min: DVec3, max: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|k| {
        let pick = |bit: usize, a: f64, b: f64| if k & bit == 0 { a } else { b };
        DVec3::new(
            pick(1, min.x, max.x),
            pick(2, min.y, max.y),
            pick(4, min.z, max.z),
        )
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::plain::PlainScene;
    use crate::unedited::outline::Item;
    use crate::unedited::{Options, Sources, analyse};
    use crate::{PovRay, unedited};

    fn look(text: &str) -> (PovRay, PlainScene, Sources, unedited::Analysis) {
        let povray = PovRay::find().expect("POV-Ray is installed");
        let folder = tempfile::tempdir().unwrap().keep();
        let file = folder.join("s.pov");
        std::fs::write(&file, text).unwrap();
        let scene = povray.plain(&file, &["+KFF3".to_owned()], None).unwrap();
        let sources = Sources::read(&povray, &scene).unwrap();
        let analysis = analyse(&sources, &Options::of(&scene));
        (povray, scene, sources, analysis)
    }

    #[test]
    fn spheres_that_are_only_moved_are_round() {
        let before = "#declare V = <clock, 1, 2>; #macro M(A) scale A #end\n\
                      #declare B = box { 0, 1 } #declare Many = array[3];\n";
        for (text, round) in [
            ("sphere { V, .5 }", true),
            (
                "sphere { 0, 1 + .1 * clock translate V rotate y * 20 }",
                true,
            ),
            (
                "sphere { V, 1 texture { pigment { checker rgb 1, rgb 0 scale .3 } } no_shadow }",
                true,
            ),
            ("sphere { V, 1 scale <1, 2, 1> }", false),
            ("sphere { V, 1 pigment { rgb 1 } scale 2 }", false),
            ("sphere { V, 1 matrix <1,0,0, 0,1,0, 0,0,1, 0,0,0> }", false),
            ("sphere { V, 1 transform { scale 2 * x } }", false),
            ("sphere { V, 1 M(<1, 2, 3>) }", false),
            ("sphere { V, 1 #if (clock > .5) rotate x #end }", false),
            ("sphere { V, 1 clipped_by { plane { y, 1 } } }", false),
            ("sphere { V, 1 bounded_by { box { -9, 9 } } }", false),
            ("sphere { B translate V }", false),
            ("sphere { B }", false),
            ("sphere { Many[1] rotate V }", false),
            ("sphere { Many[2], 1 rotate V }", true),
            ("sphere { V * 2 1 }", true),
            ("box { V, 9 }", false),
            ("union { sphere { V, 1 } }", false),
        ] {
            let (.., sources, _) = look(&format!("{before}{text}"));
            let outline = Outline::of(&sources);
            let Some(Item::Statement(raw)) = outline.units[0].items.last() else {
                panic!("{text}")
            };
            assert_eq!(is_round(&outline, 0, &raw.tokens), round, "{text}");
        }
    }

    #[test]
    fn a_ball_is_where_povray_says_that_the_sphere_is() {
        let text = "sphere { <1, 2, 3 * clock>, .5 rotate <20, 30, 40> translate <-300, 7, 0> }";
        let (povray, scene, sources, analysis) = look(text);
        let work = tempfile::tempdir().unwrap();
        let run = decor_api::RunContext::new(work.path());
        let boxes = unedited::boxes(&povray, &scene, &sources, &analysis, (1, 3), &run).unwrap();
        assert!(boxes.whole.is_empty(), "{:?}", boxes.whole);
        for frame in &boxes.frames {
            let z = 3.0 * f64::from(frame.frame - 1) / 2.0;
            let turned = [(DVec3::X, 20.0_f64), (DVec3::Y, 30.0), (DVec3::Z, 40.0)]
                .iter()
                .fold(DVec3::new(1.0, 2.0, z), |p, (axis, degrees)| {
                    glam::DQuat::from_axis_angle(*axis, degrees.to_radians()) * p
                });
            let at = turned + DVec3::new(-300.0, 7.0, 0.0);
            let solid = Solid::of(&frame.objects[0]);
            let Some(Solid::Ball { centre, radius }) = solid else {
                panic!("{solid:?}")
            };
            assert!(
                centre.distance(at) + 0.5 <= radius + 1e-9,
                "{solid:?}, {at}"
            );
            assert!(radius < 0.505);
        }
    }

    #[test]
    fn what_is_not_even_is_a_box() {
        let solid = |extent, round| {
            Solid::of(&Placed {
                statement: 0,
                extent,
                round,
            })
        };
        let extent = |max| Extent::Box {
            min: DVec3::ZERO,
            max,
        };
        let ball = solid(extent(DVec3::ONE), true);
        assert!(matches!(ball, Some(Solid::Ball { .. })));
        let tall = extent(DVec3::new(1.0, 1.1, 1.0));
        for (extent, round) in [(extent(DVec3::ONE), false), (tall, true)] {
            let solid = solid(extent, round);
            assert!(matches!(solid, Some(Solid::Box { .. })), "{extent:?}");
        }
        assert_eq!(solid(Extent::Endless, true), None);
        assert_eq!(solid(extent(DVec3::NAN), true), None);
    }

    fn holds(solid: &Solid, point: DVec3) -> bool {
        match *solid {
            Solid::Box { min, max } => point.cmpge(min).all() && point.cmple(max).all(),
            Solid::Ball { centre, radius } => point.distance(centre) <= radius,
        }
    }

    proptest! {
        #[test]
        fn the_hull_of_its_points_holds_a_ball(
            centre in prop::array::uniform3(-9.0_f64..9.0),
            radius in 0.01_f64..9.0,
            towards in prop::array::uniform3(-1.0_f64..1.0),
        ) {
            let centre = DVec3::from(centre);
            let Some(towards) = DVec3::from(towards).try_normalize() else { return Ok(()) };
            let points = Solid::Ball { centre, radius }.points();
            let furthest = points.iter().map(|p| (*p - centre).dot(towards));
            let furthest = furthest.fold(f64::MIN, f64::max);
            prop_assert!(furthest >= radius * (1.0 - 1e-12), "{furthest} < {radius}");
            prop_assert!(furthest <= 1.3 * radius, "{furthest} of {radius}");
        }

        #[test]
        fn what_is_joined_holds_both(
            a in prop::array::uniform3(-1.0_f64..1.0),
            b in prop::array::uniform3(-1.0_f64..1.0),
            (r, s) in (0.5_f64..9.0, 0.5_f64..9.0),
            towards in prop::array::uniform3(-1.0_f64..1.0),
        ) {
            let (a, b) = (DVec3::from(a), DVec3::from(b));
            let balls = [
                Solid::Ball { centre: a, radius: r },
                Solid::Ball { centre: b, radius: s },
            ];
            let Some(towards) = DVec3::from(towards).try_normalize() else { return Ok(()) };
            if let Some(both) = balls[0].joined(&balls[1]) {
                for (centre, radius) in [(a, r), (b, s)] {
                    let point = centre + towards * (radius * (1.0 - 1e-9));
                    prop_assert!(holds(&both.grown(), point), "{balls:?} in {both:?}");
                }
            }
        }
    }
}

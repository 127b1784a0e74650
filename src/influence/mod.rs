//! Which pixels of a frame can differ from the décor's picture: conservatively,
//! from geometry alone.
//!
//! The décor is what does not change, rendered without what does, by the same
//! camera under the same lights. A pixel of the whole frame can differ from it
//! - (a) where what changed can be *seen*;
//! - (b) where it can cast a *shadow*: where its bounding sphere can stand
//!   between a light and the surface that the décor shows there;
//! - (c) where the décor shows something *optical*, that mirrors or lets light
//!   through;
//! - (d) *everywhere*, where a scene uses what cannot be confined.
//!
//! What is not certain is in it: a number that is not one, a light whose rays
//! cannot be told, a pixel of unknown depth.
//!
//! ```text
//! depth ─ depths ─→ beams of a tile ─┐
//! lights ─ lamp ────────────────────┼─ trace: tile, cell, pixel ─→ Mask ─→ BlockSet
//! what changed ─ parts ─→ spheres ──┘
//! ```
//!
//! Before any depth is known, [`reach`] says in which blocks anything can change in a
//! whole period, by the boxes in which the décor's surfaces lie: depth is rendered and
//! looked at there only. By the same test [`matters`] says which of the décor's own
//! objects a block can do without.
//!
//! # Between the pixels' centres
//! Without antialiasing a pixel depends on the ray through its centre alone, and
//! its depth is known. With it, more rays may be sent, where colours meet.
//! [`Depths::with_samples`] is exact about them: the décor's depth in a picture
//! so many times as large, whose pixels' centres are the very places of POV-Ray's
//! `+AM1` and of the reference's antialiasing without jitter. Otherwise the
//! range of the depths of a pixel and its neighbours, extended by itself,
//! stands for the surfaces in between; to the end of the world where a neighbour
//! shows nothing. What is seen at no centre around must be named: the scene's
//! `slender` objects. A gap, or a spike of a solid object, that is narrower than a
//! pixel is not covered by that.
//!
//! POV-Ray's `+AM1` compares a pixel with neighbours that may have been refined
//! already, so that a change can travel from pixel to pixel inside a block, in
//! principle any way; it never crosses a block's border by more than the one
//! pixel of [`Mask::dilated`]. Its blocks are certain; its dilated pixels
//! almost.

#![expect(
    clippy::neg_cmp_op_on_partial_ord,
    reason = "what is not a number is not certain: `!(a < b)` is not `a >= b`"
)]

mod beam;
mod border;
mod depths;
mod distance;
mod estimate;
mod lamp;
mod mask;
mod order;
mod parts;
mod ranges;
mod reach;
mod solid;
mod trace;

use std::fmt;

use decor_api::{Bounds, Camera, Light, Pose, Prototype, Size, Sphere, Window};

pub use beam::Beam;
pub use depths::Depths;
pub use estimate::estimated_shadows;
pub use lamp::{Lamp, may_shade};
pub use mask::{Cause, Mask};
pub use order::Order;
pub use parts::{is_slender, parts, thickness};
pub use ranges::Ranges;
pub use reach::{Places, matters, reach, shades, with_ring};
pub use solid::Solid;

/// What is the same in the décor and in the frame.
#[derive(Clone, Copy, Debug)]
pub struct Still<'a> {
    /// From where it is seen.
    pub camera: &'a Camera,
    /// The size of the picture.
    pub size: Size,
    /// The lights.
    pub lights: &'a [Light],
    /// Are shadows cast?
    pub shadows: bool,
    /// Does the renderer look between the pixels' centres?
    pub antialiased: bool,
    /// Where only the [blocks](Mask::blocks) of the mask are asked for, their side:
    /// then one pixel in a block is as good as all of them, which is quicker. With
    /// antialiasing those of the dilated mask, without it those of the mask.
    pub by_blocks: Option<u32>,
    /// How far the décor's surfaces are.
    pub depths: Depths<'a>,
    /// Where the décor can show something that mirrors or lets light through.
    pub optical: &'a [Window],
    /// The bounds of the décor's objects that can be thinner than a pixel
    /// ([`is_slender`]); not needed where the depth of the samples is known.
    pub slender: &'a [Bounds],
}

/// Something that is in the frame and not in the décor.
#[derive(Clone, Debug, PartialEq)]
pub struct Changed {
    /// What encloses all of it.
    pub whole: Bounds,
    /// Spheres that enclose it together, tighter than the whole; none: the
    /// whole is all that is known.
    pub parts: Vec<Sphere>,
    /// Boxes that enclose it together, too, where there are some: these are taken
    /// where depth is known.
    pub boxes: Vec<Solid>,
}

impl Changed {
    /// An object of which only the bounds are known.
    pub fn within(whole: Bounds) -> Self {
        Self {
            whole,
            parts: Vec::new(),
            boxes: Vec::new(),
        }
    }

    /// A placed prototype, with the spheres that enclose it together
    /// ([`parts`]).
    pub fn placed(prototype: &Prototype, parts: &[Sphere], pose: &Pose) -> Self {
        let posed = |sphere: &Sphere| {
            let bounds = Bounds::Sphere(*sphere).posed(pose);
            bounds.as_sphere().copied()
        };
        // A part that is not finite any more makes the parts useless.
        let parts: Option<Vec<Sphere>> = parts.iter().map(posed).collect();
        Self {
            whole: prototype.bounds.posed(pose),
            parts: parts.unwrap_or_default(),
            boxes: prototype
                .extents
                .iter()
                .map(|extent| Solid::placed(extent, pose))
                .collect(),
        }
    }
}

impl From<Bounds> for Changed {
    fn from(bounds: Bounds) -> Self {
        Self::within(bounds)
    }
}

/// Why every pixel can change.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reason {
    /// The scene uses what reaches everywhere (radiosity, …).
    Unconfined(String),
    /// Something changed that has no end, or whose size nobody knows.
    Endless,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unconfined(what) => write!(f, "{what} can change every pixel"),
            Self::Endless => write!(f, "something without an end moves"),
        }
    }
}

/// The pixels that can differ from the décor's.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Influence {
    /// All of them.
    Everything(Reason),
    /// Only these.
    Confined(Mask),
}

impl Influence {
    /// The pixels, where they are confined.
    pub fn mask(&self) -> Option<&Mask> {
        match self {
            Self::Everything(_) => None,
            Self::Confined(mask) => Some(mask),
        }
    }
}

/// The influence of what `changed` on the picture of what is `still`.
/// `unconfined`: why it cannot be confined, where the caller knows it.
pub fn influence(still: &Still<'_>, changed: &[Changed], unconfined: Option<&str>) -> Influence {
    if let Some(what) = unconfined {
        return Influence::Everything(Reason::Unconfined(what.to_owned()));
    }
    if changed.iter().any(|c| c.whole == Bounds::Unbounded) {
        return Influence::Everything(Reason::Endless);
    }
    if changed.iter().all(|c| c.whole == Bounds::Empty) {
        return Influence::Confined(Mask::none(still.size));
    }
    Influence::Confined(trace::trace(still, changed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::{Layer, LightKind, Rgb};
    use glam::DVec3;

    fn layer(size: Size, depth: f64) -> Layer {
        Layer {
            window: size.window(),
            colour: None,
            depth: Some(vec![depth; size.pixels()]),
            depth_quantum: (0.0, 0.0),
        }
    }

    fn lamp(position: DVec3) -> Light {
        Light {
            position,
            colour: Rgb([1.0; 3]),
            kind: LightKind::Point,
            fade: None,
        }
    }

    /// What a small ball on the axis influences, 20 away from the eye, before a
    /// wall at `depth`.
    fn mask(size: Size, eye: DVec3, depth: f64, lights: &[Light], shadows: bool) -> Mask {
        let camera = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, (60.0, 60.0)).unwrap();
        let wall = layer(size, depth);
        let still = Still {
            camera: &camera,
            size,
            lights,
            shadows,
            antialiased: false,
            by_blocks: None,
            depths: Depths::at_centres(&wall),
            optical: &[],
            slender: &[],
        };
        let ball = Bounds::sphere(eye + DVec3::Z * 20.0, 0.5);
        let found = influence(&still, &[ball.into()], None);
        found.mask().expect("a ball has an end").clone()
    }

    const SIZE: Size = Size {
        width: 100,
        height: 100,
    };

    #[test]
    fn a_shadow_is_where_the_light_is_not_and_only_where_there_is_a_surface() {
        let lights = [lamp(DVec3::new(10.0, 0.0, 10.0))];
        let at = |depth| mask(SIZE, DVec3::ZERO, depth, &lights, true);
        let wall = at(30.0);
        assert!(wall.has(50, 50, Cause::Seen) && !wall.has(50, 50, Cause::Shadowed));
        // Through the ball the light reaches the wall at about (-10, 0, 30 · cos).
        let shadowed = (0..100).filter(|&x| wall.has(x, 50, Cause::Shadowed));
        let shadowed: Vec<u32> = shadowed.collect();
        let expected = 50.0 - 86.6 * 0.33;
        assert!(
            shadowed
                .iter()
                .any(|&x| (f64::from(x) - expected).abs() < 4.0)
        );
        assert!(shadowed.len() < 12, "{shadowed:?}");
        assert_eq!(at(f64::INFINITY).count_of(Cause::Shadowed), 0);
        assert_eq!(at(5.0).count(), 0, "a wall before the ball hides it");
        let off = mask(SIZE, DVec3::ZERO, 30.0, &lights, false);
        assert_eq!(off.count(), off.count_of(Cause::Seen));
        let dark = [Light {
            colour: Rgb([0.0; 3]),
            ..lights[0]
        }];
        assert_eq!(mask(SIZE, DVec3::ZERO, 30.0, &dark, true), off);
    }

    #[test]
    fn what_is_not_a_number_is_influenced() {
        for light in [
            lamp(DVec3::NAN),
            lamp(DVec3::X * f64::INFINITY),
            lamp(DVec3::X * 1e300),
        ] {
            let all = mask(SIZE, DVec3::ZERO, 30.0, &[light], true);
            assert_eq!(all.count_of(Cause::Shadowed), SIZE.pixels(), "{light:?}");
        }
        // A depth that nobody knows is one along the whole ray.
        let lights = [lamp(DVec3::new(10.0, 0.0, 10.0))];
        let unknown = mask(SIZE, DVec3::ZERO, f64::NAN, &lights, true);
        for depth in [20.0, 25.0, 30.0, 60.0, 1e6] {
            let known = mask(SIZE, DVec3::ZERO, depth, &lights, true);
            for (x, y) in (0..100).flat_map(|x| (0..100).map(move |y| (x, y))) {
                let is = |mask: &Mask| mask.has(x, y, Cause::Shadowed);
                assert!(is(&unknown) || !is(&known), "({x}, {y}) at {depth}");
            }
        }
    }

    #[test]
    fn far_from_the_origin_and_in_odd_pictures_it_is_the_same() {
        let near = mask(SIZE, DVec3::ZERO, 30.0, &[lamp(DVec3::X * 10.0)], true);
        let eye = DVec3::splat(1e8);
        let far = mask(SIZE, eye, 30.0, &[lamp(eye + DVec3::X * 10.0)], true);
        let both = (near.count(), far.count());
        assert!(both.1 >= both.0 && both.1 <= both.0 + 40, "{both:?}");
        for (width, height) in [(1, 1), (1, 65_535), (33, 31)] {
            let size = Size { width, height };
            let mask = mask(size, DVec3::ZERO, 30.0, &[lamp(DVec3::Y)], true);
            assert!(mask.contains(width / 2, height / 2));
        }
    }

    #[test]
    fn reasons_come_first() {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 60.0)).unwrap();
        let wall = layer(SIZE, 1.0);
        let still = Still {
            camera: &camera,
            size: SIZE,
            lights: &[],
            shadows: true,
            antialiased: true,
            by_blocks: None,
            depths: Depths::at_centres(&wall),
            optical: &[Window {
                x: 90,
                y: 5,
                width: 50,
                height: 2,
            }],
            slender: &[],
        };
        let of = |bounds: Bounds, why| influence(&still, &[bounds.into()], why);
        assert_eq!(
            of(Bounds::Unbounded, None),
            Influence::Everything(Reason::Endless)
        );
        let radiosity = of(Bounds::Empty, Some("radiosity"));
        let Influence::Everything(reason) = radiosity else {
            panic!()
        };
        assert_eq!(reason.to_string(), "radiosity can change every pixel");
        let none = of(Bounds::Empty, None);
        assert_eq!(none.mask().unwrap().count(), 0, "nothing changed");
        // A mirror shows what is beside the picture.
        let outside = of(Bounds::sphere(DVec3::X * 50.0, 1.0), None);
        assert_eq!(outside.mask().unwrap().count(), 20);
        assert_eq!(outside.mask().unwrap().count_of(Cause::Optical), 20);
    }
}

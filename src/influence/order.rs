//! What lies before what: where everything fast is nearer than everything of the décor
//! that it is seen over, no depth is needed to merge it.

use std::collections::HashMap;

use decor_api::Window;
use glam::DVec3;

use super::beam::Beam;
use super::depths::Range;
use super::distance::segment_squared;
use super::reach::Places;
use super::trace::Tracer;
use super::{Changed, Still};
use crate::plan::BLOCK;

/// Parts of objects that are looked at, each for a tile of the picture: what is known
/// then costs less than the depth that it saves.
const MOST_LOOKS: usize = 8_000_000;

/// Rounding of distances, as a share.
const ROUNDING: f64 = 1e-9;

/// How near the décor of a period can be, tile by tile, for an observer who rests.
pub struct Order<'a> {
    tracer: Tracer<'a>,
    decor: Places,
    /// Of a tile, by its corner: up to which distance there is none of the décor, for
    /// certain, and from which on there may be, as far as it was asked for.
    known: HashMap<(u32, u32), (f64, f64)>,
    looks: usize,
}

impl<'a> Order<'a> {
    /// Of the objects of a décor. `still` needs neither lights nor depth.
    pub fn of(still: &'a Still<'a>, decor: &[Changed]) -> Self {
        Self {
            tracer: Tracer::new(still, &[]),
            decor: Places::of(still, decor),
            known: HashMap::new(),
            looks: 0,
        }
    }

    /// Is all of `front` that can be seen in a window nearer than anything of the décor
    /// there? `true` is certain.
    pub fn is_before(&mut self, still: &Still<'_>, front: &[Changed], window: Window) -> bool {
        let front = Places::of(still, front);
        let starts = |from: u32, to: u32| (from / BLOCK * BLOCK..to).step_by(BLOCK as usize);
        starts(window.y, window.bottom()).all(|y| {
            starts(window.x, window.right()).all(|x| {
                let tile = Window {
                    x,
                    y,
                    width: BLOCK,
                    height: BLOCK,
                };
                let tile = tile.intersection(still.size.window());
                let seen = front.along(&self.tracer, tile);
                seen.last().is_none_or(|(_, far)| self.is_free(tile, *far))
            })
        })
    }

    /// Is there nothing of the décor in a tile up to this distance?
    fn is_free(&mut self, tile: Window, far: f64) -> bool {
        let (free, taken) = self
            .known
            .entry((tile.x, tile.y))
            .or_insert((0.0, f64::INFINITY));
        if far <= *free {
            return true;
        }
        self.looks += self.decor.count();
        if !(far < *taken) || self.looks > MOST_LOOKS {
            return false;
        }
        let beam = self.tracer.beam(tile, Range::of(far));
        let is_free = !self.decor.meet(&beam, far);
        *(if is_free { free } else { taken }) = far;
        is_free
    }
}

impl Places {
    /// Can any of it lie on a ray of the beam, not farther than `far`? All such points
    /// are near the middle ray, by the spread times that distance. `false` is certain.
    fn meet(&self, beam: &Beam, far: f64) -> bool {
        let margin = (beam.spread + ROUNDING) * far;
        let end = beam.direction * (far * (1.0 + ROUNDING));
        self.endless
            || !far.is_finite()
            || self.parts.iter().any(|part| {
                let reach = part.ball.radius + margin;
                let squared = segment_squared(part.ball.centre, DVec3::ZERO, end);
                let solid = part.solid.as_ref();
                !(squared > reach * reach)
                    && solid.is_none_or(|solid| solid.meets_segment(DVec3::ZERO, end, margin))
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::influence::Depths;
    use decor_api::{Bounds, Camera, Extent, Pose, Size};

    const SIZE: Size = Size {
        width: 960,
        height: 640,
    };

    fn ball(x: f64, z: f64, radius: f64) -> Changed {
        Changed::within(Bounds::sphere(DVec3::new(x, 0.0, z), radius))
    }

    fn is_before(front: &[Changed], decor: &[Changed]) -> bool {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 42.0)).unwrap();
        let still = Still {
            camera: &camera,
            size: SIZE,
            lights: &[],
            shadows: false,
            antialiased: false,
            by_blocks: None,
            depths: Depths::unknown(),
            optical: &[],
            slender: &[],
        };
        Order::of(&still, decor).is_before(&still, front, SIZE.window())
    }

    #[test]
    fn what_is_nearer_is_before() {
        assert!(is_before(&[ball(0.0, 5.0, 1.0)], &[ball(0.0, 9.0, 1.0)]));
        assert!(!is_before(&[ball(0.0, 9.0, 1.0)], &[ball(0.0, 5.0, 1.0)]));
        assert!(!is_before(&[ball(0.0, 7.5, 1.0)], &[ball(0.0, 9.0, 1.0)]));
    }

    #[test]
    fn what_is_beside_does_not_matter() {
        assert!(is_before(&[ball(-4.0, 12.0, 0.5)], &[ball(4.0, 9.0, 0.5)]));
        // One of two is behind.
        let front = [ball(-4.0, 12.0, 0.5), ball(4.0, 12.0, 0.5)];
        assert!(!is_before(&front, &[ball(4.0, 9.0, 0.5)]));
        assert!(is_before(&[ball(0.0, 5.0, 1.0)], &[]));
        assert!(is_before(&[], &[ball(0.0, 5.0, 1.0)]));
    }

    #[test]
    fn a_floor_that_begins_below_the_observer_is_behind_what_flies_over_it() {
        let extent = Extent {
            min: DVec3::new(-50.0, -3.0, -50.0),
            max: DVec3::new(50.0, -2.0, 50.0),
        };
        let pose = Pose {
            position: DVec3::ZERO,
            angles_deg: DVec3::ZERO,
        };
        let floor = Changed {
            boxes: vec![crate::influence::Solid::placed(&extent, &pose)],
            ..Changed::within(Bounds::sphere(DVec3::ZERO, 80.0))
        };
        assert!(is_before(
            &[ball(0.0, 8.0, 1.0)],
            std::slice::from_ref(&floor)
        ));
        // Its lower half is behind the floor's surface.
        assert!(!is_before(&[ball(0.0, 8.0, 2.5)], &[floor]));
    }

    #[test]
    fn what_has_no_end_is_not_certain() {
        let endless = Changed::within(Bounds::Unbounded);
        assert!(!is_before(
            std::slice::from_ref(&endless),
            &[ball(0.0, 9.0, 1.0)]
        ));
        assert!(!is_before(&[ball(0.0, 5.0, 1.0)], &[endless]));
        assert!(!is_before(
            &[ball(0.0, 5.0, f64::NAN)],
            &[ball(0.0, 9.0, 1.0)]
        ));
    }
}

//! From tiles to pixels: a tile is a wide beam, and what does not reach it is
//! not asked again inside of it.

use decor_api::{Bounds, Sphere, Window};
use rayon::prelude::*;

use super::depths::Range;
use super::lamp::{Beam, Lamp};
use super::{Cause, Changed, Mask, Still};
use crate::motion::screen_box;

/// Sides of the squares that are asked as a whole, in pixels.
const SIDES: [u32; 2] = [32, 8];

/// A renderer's rays are rounded: never by more than this part of a pixel.
const RAY_ERROR_PX: f64 = 0.02;

/// What may be seen, or may block a lamp, in some part of the picture: numbers
/// of balls.
#[derive(Clone, Debug, Default)]
struct Suspects {
    seen: Vec<u32>,
    casting: Vec<(u32, u32)>,
}

impl Suspects {
    fn is_empty(&self) -> bool {
        self.seen.is_empty() && self.casting.is_empty()
    }
}

struct Tracer<'a> {
    still: &'a Still<'a>,
    lamps: Vec<Lamp>,
    /// Relative to the eye: what encloses each object, and for each the range of
    /// its parts.
    wholes: Vec<(Sphere, std::ops::Range<u32>)>,
    parts: Vec<Sphere>,
}

/// The mask of everything that has an end.
pub(super) fn trace(still: &Still<'_>, changed: &[Changed]) -> Mask {
    let tracer = Tracer::new(still, changed);
    let size = still.size;
    let mut causes = vec![0_u8; size.pixels()];
    let mark = |causes: &mut [u8], window: Window, cause: Cause| {
        let window = window.intersection(size.window());
        for y in window.y..window.bottom() {
            let start = y as usize * size.width as usize + window.x as usize;
            let row = &mut causes[start..start + window.width as usize];
            row.iter_mut().for_each(|code| *code |= cause as u8);
        }
    };
    for &window in still.optical {
        mark(&mut causes, window, Cause::Optical);
    }
    for window in tracer.slender_windows() {
        mark(&mut causes, window, Cause::Shadowed);
    }
    let band = SIDES[0] as usize * size.width as usize;
    causes
        .par_chunks_mut(band.max(1))
        .enumerate()
        .for_each(|(number, rows)| {
            let y = number as u32 * SIDES[0];
            let window = Window {
                x: 0,
                y,
                width: size.width,
                height: SIDES[0].min(size.height - y),
            };
            tracer.square(window, SIDES[0], &tracer.everything(), y, rows);
        });
    Mask::from_causes(size, causes)
}

impl<'a> Tracer<'a> {
    fn new(still: &'a Still<'a>, changed: &[Changed]) -> Self {
        let eye = still.camera.eye;
        let relative = |ball: &Sphere| Sphere {
            centre: ball.centre - eye,
            // What the subtraction rounds away.
            radius: ball.radius + 1e-14 * (ball.centre.abs().max_element() + eye.length()),
        };
        let lamps = if still.shadows {
            let lamps = still.lights.iter();
            lamps.filter_map(|light| Lamp::of(light, eye)).collect()
        } else {
            Vec::new()
        };
        let (mut wholes, mut parts) = (Vec::new(), Vec::new());
        for object in changed {
            let Bounds::Sphere(whole) = &object.whole else {
                continue;
            };
            let first = parts.len() as u32;
            if object.parts.is_empty() {
                parts.push(relative(whole));
            } else {
                parts.extend(object.parts.iter().map(relative));
            }
            wholes.push((relative(whole), first..parts.len() as u32));
        }
        Self {
            still,
            lamps,
            wholes,
            parts,
        }
    }

    /// Every object in every light, as wholes.
    fn everything(&self) -> Suspects {
        let objects = 0..self.wholes.len() as u32;
        let lamps = 0..self.lamps.len() as u32;
        Suspects {
            seen: objects.clone().collect(),
            casting: lamps
                .flat_map(|lamp| objects.clone().map(move |object| (lamp, object)))
                .collect(),
        }
    }

    /// Slender objects of the décor that a shadow can touch, where they are
    /// drawn between the pixels' centres: all of their boxes.
    fn slender_windows(&self) -> Vec<Window> {
        let still = self.still;
        if !still.antialiased || still.depths.has_samples() {
            return Vec::new();
        }
        let is_touched = |bounds: &Bounds| match bounds {
            Bounds::Empty => false,
            Bounds::Unbounded => !self.lamps.is_empty(),
            Bounds::Sphere(ball) => {
                let ball = Sphere {
                    centre: ball.centre - still.camera.eye,
                    radius: ball.radius,
                };
                let beam = Beam::to_ball(&ball, still.camera.forward);
                self.lamps.iter().any(|lamp| {
                    let mut parts = self.parts.iter();
                    parts.any(|part| lamp.may_be_blocked(part, &beam))
                })
            }
        };
        let touched = still.slender.iter().filter(|bounds| is_touched(bounds));
        touched
            .map(|bounds| screen_box(bounds, still.camera, still.size).window())
            .collect()
    }

    /// Does the picture depend on more than the rays whose depth is known?
    fn guesses(&self) -> bool {
        self.still.antialiased && !self.still.depths.has_samples()
    }

    fn range(&self, window: Window) -> Range {
        let guesses = self.guesses();
        let depths = &self.still.depths;
        let range = depths.range(window, u32::from(guesses), self.still.size);
        if guesses { range.extended() } else { range }
    }

    /// All rays of a window.
    fn beam(&self, window: Window, range: Range) -> Beam {
        let half = |start: u32, length: u32| f64::from(start) + 0.5 * f64::from(length);
        let (x, y) = (half(window.x, window.width), half(window.y, window.height));
        // From the middle to the outermost rays: the pixels' corners, or their
        // centres where nothing else is looked at.
        let inset = if self.still.antialiased { 0.0 } else { 1.0 };
        let across = 0.5 * (f64::from(window.width) - inset);
        let down = 0.5 * (f64::from(window.height) - inset);
        self.ray(x, y, (across, down), range)
    }

    fn ray(&self, x: f64, y: f64, (across, down): (f64, f64), range: Range) -> Beam {
        let Still { camera, size, .. } = self.still;
        let step = |half: f64, pixels: u32| 2.0 * half / f64::from(pixels);
        let spread = f64::hypot(
            step(camera.half_width, size.width) * (across + RAY_ERROR_PX),
            step(camera.half_height, size.height) * (down + RAY_ERROR_PX),
        );
        Beam {
            direction: camera.direction(*size, x, y).normalize_or(camera.forward),
            spread,
            near: range.near,
            far: range.far,
            quantum: self.still.depths.quantum(),
        }
    }

    /// Who of `suspects` remains in a window. `whole`: they are numbers of
    /// wholes, and the parts of those that remain are looked at.
    fn remaining(&self, window: Window, suspects: &Suspects, whole: bool) -> Suspects {
        if suspects.is_empty() {
            return Suspects::default();
        }
        let range = self.range(window);
        let beam = self.beam(window, range);
        let left = self.reached(&beam, range, suspects, whole);
        if !whole || left.is_empty() {
            return left;
        }
        let parts = |object: u32| self.wholes[object as usize].1.clone();
        let parts = Suspects {
            seen: left.seen.iter().flat_map(|&o| parts(o)).collect(),
            casting: left
                .casting
                .iter()
                .flat_map(|&(lamp, o)| parts(o).map(move |part| (lamp, part)))
                .collect(),
        };
        self.reached(&beam, range, &parts, false)
    }

    /// Who of `suspects` matters to a beam.
    fn reached(&self, beam: &Beam, range: Range, suspects: &Suspects, whole: bool) -> Suspects {
        let mut left = Suspects::default();
        for &ball in &suspects.seen {
            if self.shows(beam, range, self.ball(ball, whole)) {
                left.seen.push(ball);
            }
        }
        if range.any {
            for &(lamp, ball) in &suspects.casting {
                if self.lamps[lamp as usize].may_be_blocked(self.ball(ball, whole), beam) {
                    left.casting.push((lamp, ball));
                }
            }
        }
        left
    }

    fn ball(&self, number: u32, whole: bool) -> &Sphere {
        if whole {
            &self.wholes[number as usize].0
        } else {
            &self.parts[number as usize]
        }
    }

    /// Surfaces hide what is behind them where all of them are known.
    fn shows(&self, beam: &Beam, range: Range, ball: &Sphere) -> bool {
        beam.may_show(ball, range.any && !range.gap && !self.guesses())
    }

    /// Marks the pixels of a window, which is cut into squares of `side`. At the
    /// largest side, suspects are wholes; at smaller ones, parts. `rows`
    /// begin with the picture's row `top`.
    fn square(&self, window: Window, side: u32, suspects: &Suspects, top: u32, rows: &mut [u8]) {
        if suspects.is_empty() {
            return;
        }
        let starts = |from: u32, to: u32| (from..to).step_by(side as usize);
        for y in starts(window.y, window.bottom()) {
            for x in starts(window.x, window.right()) {
                let cell = Window {
                    x,
                    y,
                    width: side,
                    height: side,
                };
                let cell = cell.intersection(window);
                let left = self.remaining(cell, suspects, side == SIDES[0]);
                match SIDES.iter().find(|smaller| **smaller < side) {
                    Some(&smaller) => self.square(cell, smaller, &left, top, rows),
                    None => self.pixels(cell, &left, top, rows),
                }
            }
        }
    }

    fn pixels(&self, cell: Window, suspects: &Suspects, top: u32, rows: &mut [u8]) {
        if suspects.is_empty() {
            return;
        }
        for y in cell.y..cell.bottom() {
            for x in cell.x..cell.right() {
                let place = (y - top) as usize * self.still.size.width as usize + x as usize;
                rows[place] |= self.pixel(x, y, suspects);
            }
        }
    }

    fn pixel(&self, x: u32, y: u32, suspects: &Suspects) -> u8 {
        let own = Window {
            x,
            y,
            width: 1,
            height: 1,
        };
        let range = self.range(own);
        let around = self.beam(own, range);
        let most = self.causes(&around, range, suspects);
        if most == 0 || !(self.still.antialiased && self.still.depths.has_samples()) {
            return most;
        }
        // The pixel's whole beam is reached; is one of its rays?
        let (left, upper) = (f64::from(x), f64::from(y));
        let centre = (0.5, 0.5, self.still.depths.centre(x, y));
        let mut found = 0;
        for (right, down, depth) in std::iter::once(centre).chain(self.still.depths.samples(x, y)) {
            let range = Range::of(depth);
            let ray = self.ray(left + right, upper + down, (0.0, 0.0), range);
            found |= self.causes(&ray, range, suspects);
            if found == most {
                break;
            }
        }
        found
    }

    /// The causes that reach a beam, added up.
    fn causes(&self, beam: &Beam, range: Range, suspects: &Suspects) -> u8 {
        let is_seen = |&ball: &u32| self.shows(beam, range, self.ball(ball, false));
        let casts = |&(lamp, ball): &(u32, u32)| {
            let lamp = &self.lamps[lamp as usize];
            lamp.may_be_blocked(self.ball(ball, false), beam)
        };
        let code = |holds: bool, cause: Cause| if holds { cause as u8 } else { 0 };
        code(suspects.seen.iter().any(is_seen), Cause::Seen)
            | code(
                range.any && suspects.casting.iter().any(casts),
                Cause::Shadowed,
            )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::influence::Depths;
    use decor_api::{Camera, Layer, Size};
    use glam::DVec3;

    #[test]
    fn a_windows_beam_holds_all_of_its_rays() {
        let (eye, aim) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-4.0, 0.5, 9.0));
        let size = Size {
            width: 101,
            height: 37,
        };
        let layer = Layer {
            window: Window::EMPTY,
            colour: None,
            depth: None,
            depth_quantum: (0.0, 0.0),
        };
        for angles in [(120.0, 80.0), (1e-3, 1e-3), (179.0, 10.0)] {
            let camera = Camera::look_at(eye, aim, DVec3::Y, angles).unwrap();
            let mut still = Still {
                camera: &camera,
                size,
                lights: &[],
                shadows: true,
                antialiased: true,
                depths: Depths::at_centres(&layer),
                optical: &[],
                slender: &[],
            };
            for inset in [0.0, 0.5] {
                still.antialiased = inset == 0.0;
                let tracer = Tracer::new(&still, &[]);
                let window = Window {
                    x: 70,
                    y: 3,
                    width: 31,
                    height: 30,
                };
                let beam = tracer.beam(window, Range::of(1.0));
                for (i, j) in (0..=10).flat_map(|i| (0..=10).map(move |j| (i, j))) {
                    let at = |from: f64, length: f64, k: i32| {
                        from + inset + (length - 2.0 * inset) * f64::from(k) / 10.0
                    };
                    let ray = camera.direction(size, at(70.0, 31.0, i), at(3.0, 30.0, j));
                    assert!(beam.direction.distance(ray.normalize()) <= beam.spread);
                }
            }
        }
    }
}

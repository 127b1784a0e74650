//! From tiles to pixels: a tile is a wide beam, and what does not reach it is
//! not asked again inside of it.

use decor_api::{Bounds, Sphere, Window};
use glam::DVec3;
use rayon::prelude::*;

use super::beam::Beam;
use super::border::{Tile, borders};
use super::depths::Range;
use super::lamp::Lamp;
use super::{Cause, Changed, Mask, Solid, Still};
use crate::motion::screen_box;
use crate::plan::BLOCK;

/// Sides of the squares that are asked as a whole, in pixels.
const SIDES: [u32; 2] = [BLOCK, 8];

/// The side of the smallest squares where only blocks are asked for.
const SMALLEST: u32 = 2;

/// The sides of all squares that are asked as a whole, from the largest.
fn sides(by_blocks: Option<u32>) -> Vec<u32> {
    let mut sides = SIDES.to_vec();
    if let Some(side) = by_blocks {
        sides.extend([side, SMALLEST]);
    }
    // At the largest, wholes are asked for: others are parts.
    sides.retain(|side| (2..=BLOCK).contains(side));
    sides.sort_unstable_by_key(|side| std::cmp::Reverse(*side));
    sides.dedup();
    sides
}

/// A renderer's rays are rounded: never by more than this part of a pixel.
const RAY_ERROR_PX: f64 = 0.02;

/// What may be seen, or may block a lamp, in some part of the picture: numbers
/// of wholes and lamps, or of parts and sources.
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

pub(super) struct Tracer<'a> {
    still: &'a Still<'a>,
    /// Each lamp, and the range of its sources.
    lamps: Vec<(Lamp, std::ops::Range<u32>)>,
    sources: Vec<Lamp>,
    /// Relative to the eye: what encloses each object, and for each the range of
    /// its parts.
    wholes: Vec<(Sphere, std::ops::Range<u32>)>,
    parts: Vec<Part>,
    /// Sides of the squares that are asked as a whole, from the largest.
    sides: Vec<u32>,
}

/// What encloses a part of an object: a ball, and a box in it where one is known.
/// Relative to the eye.
pub(super) struct Part {
    pub ball: Sphere,
    pub solid: Option<Solid>,
}

impl Part {
    /// The parts of an object that has an end.
    pub fn all_of(object: &Changed, eye: DVec3) -> Vec<Self> {
        let within = |ball: &Sphere| Self {
            ball: relative(ball, eye),
            solid: None,
        };
        if !object.boxes.is_empty() {
            let boxes = object.boxes.iter().map(|solid| solid.from(eye));
            let parts = boxes.map(|solid| Self {
                ball: solid.ball(),
                solid: Some(solid),
            });
            parts.collect()
        } else if object.parts.is_empty() {
            object.whole.as_sphere().map(within).into_iter().collect()
        } else {
            object.parts.iter().map(within).collect()
        }
    }
}

/// A ball as it is seen from `eye`.
fn relative(ball: &Sphere, eye: DVec3) -> Sphere {
    Sphere {
        centre: ball.centre - eye,
        // What the subtraction rounds away.
        radius: ball.radius + 1e-14 * (ball.centre.abs().max_element() + eye.length()),
    }
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
    let rows = SIDES[0] as usize * size.width as usize;
    causes
        .par_chunks_mut(rows.max(1))
        .enumerate()
        .for_each(|(number, rows)| {
            let y = number as u32 * SIDES[0];
            let band = Window {
                x: 0,
                y,
                width: size.width,
                height: SIDES[0].min(size.height - y),
            };
            let everything = tracer.everything();
            for x in (0..size.width).step_by(SIDES[0] as usize) {
                let window = Window {
                    x,
                    width: SIDES[0].min(size.width - x),
                    ..band
                };
                if !still.depths.may_change(window) {
                    continue;
                }
                let mut tile = Tile::new(window);
                tracer.square(window, 0, &everything, y, rows, &mut tile);
            }
        });
    if let Some(side) = still.by_blocks
        && still.antialiased
    {
        causes = borders(&tracer, size, side, causes);
    }
    Mask::from_causes(size, causes)
}

impl<'a> Tracer<'a> {
    pub fn new(still: &'a Still<'a>, changed: &[Changed]) -> Self {
        let eye = still.camera.eye;
        let (mut lamps, mut sources) = (Vec::new(), Vec::new());
        let lights = still.lights.iter().filter(|_| still.shadows);
        for light in lights {
            let Some(lamp) = Lamp::of(light, eye) else {
                continue;
            };
            let first = sources.len() as u32;
            sources.extend(Lamp::sources(light, eye));
            lamps.push((lamp, first..sources.len() as u32));
        }
        let (mut wholes, mut parts) = (Vec::new(), Vec::new());
        for object in changed {
            let Bounds::Sphere(whole) = &object.whole else {
                continue;
            };
            let first = parts.len() as u32;
            parts.extend(Part::all_of(object, eye));
            wholes.push((relative(whole, eye), first..parts.len() as u32));
        }
        Self {
            still,
            lamps,
            sources,
            wholes,
            parts,
            sides: sides(still.by_blocks),
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
                self.lamps.iter().any(|(lamp, _)| {
                    let mut parts = self.parts.iter();
                    parts.any(|part| lamp.may_be_blocked(&part.ball, &beam))
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
    pub fn beam(&self, window: Window, range: Range) -> Beam {
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
        let pairs = left.casting.iter().flat_map(|&(lamp, object)| {
            let (lamp, sources) = &self.lamps[lamp as usize];
            // Who casts nothing in the light of all sources does not in one's.
            let by_some =
                move |part: &u32| sources.len() < 2 || self.is_between(&beam, lamp, *part);
            let parts = parts(object).filter(by_some);
            parts.flat_map(move |part| sources.clone().map(move |source| (source, part)))
        });
        let parts = Suspects {
            seen: left.seen.iter().flat_map(|&o| parts(o)).collect(),
            casting: pairs.collect(),
        };
        self.reached(&beam, range, &parts, false)
    }

    /// Who of `suspects` matters to a beam.
    fn reached(&self, beam: &Beam, range: Range, suspects: &Suspects, whole: bool) -> Suspects {
        let mut left = Suspects::default();
        if whole {
            let is_seen = |&&o: &&u32| self.shows(beam, range, &self.wholes[o as usize].0);
            left.seen.extend(suspects.seen.iter().filter(is_seen));
        } else {
            let is_seen = |&&part: &&u32| self.shows_part(beam, range, part);
            left.seen.extend(suspects.seen.iter().filter(is_seen));
        }
        if !range.any {
            return left;
        }
        let casting = suspects.casting.iter();
        if whole {
            left.casting.extend(casting.filter(|(lamp, object)| {
                let ball = &self.wholes[*object as usize].0;
                self.lamps[*lamp as usize].0.may_be_blocked(ball, beam)
            }));
        } else {
            left.casting
                .extend(casting.filter(|pair| self.casts(beam, **pair)));
        }
        left
    }

    /// Can anything be seen in a window, or stand between a lamp and what lies in it
    /// at any of these distances, from one to another? Nothing that begins beyond
    /// `hidden_beyond` is seen.
    pub fn reaches(
        &self,
        window: Window,
        hidden_beyond: Option<f64>,
        distances: &[(f64, f64)],
    ) -> bool {
        let range = |near: f64, far: f64| Range {
            near,
            far,
            any: true,
            gap: false,
        };
        let open = self.beam(window, range(0.0, hidden_beyond.unwrap_or(f64::INFINITY)));
        let hides = hidden_beyond.is_some();
        let shows = |part: &Part| {
            let solid = part.solid.as_ref();
            open.may_show(&part.ball, hides)
                && solid.is_none_or(|solid| open.may_show_box(solid, hides))
        };
        let parts = |whole: &std::ops::Range<u32>| whole.start as usize..whole.end as usize;
        let mut wholes = self.wholes.iter();
        if wholes.any(|(whole, own)| {
            open.may_show(whole, hides) && self.parts[parts(own)].iter().any(shows)
        }) {
            return true;
        }
        let pairs: Vec<(u32, u32)> = self.everything().casting;
        let blocks = |beam: &Beam, (lamp, object): (u32, u32)| {
            let ball = &self.wholes[object as usize].0;
            self.lamps[lamp as usize].0.may_be_blocked(ball, beam)
        };
        distances.iter().any(|&(near, far)| {
            let beam = self.beam(window, range(near, far));
            let mut left = pairs.clone();
            left.retain(|&pair| blocks(&beam, pair));
            // A box is asked about the ball around what it may shade: short pieces.
            const MOST_PIECES: f64 = 64.0;
            let ratio = (far - near) / (2.0 * beam.spread * far);
            let pieces = if ratio.is_nan() {
                1.0
            } else {
                ratio.ceil().clamp(1.0, MOST_PIECES)
            };
            let at = |k: f64| near + (far - near) * (k / pieces);
            !left.is_empty()
                && (0..pieces as u32).any(|k| {
                    let k = f64::from(k);
                    let end = if k + 1.0 < pieces { at(k + 1.0) } else { far };
                    let beam = self.beam(window, range(if k > 0.0 { at(k) } else { near }, end));
                    left.iter().any(|&pair| {
                        let sources = self.lamps[pair.0 as usize].1.clone();
                        let own = &self.wholes[pair.1 as usize].1;
                        blocks(&beam, pair)
                            && sources.into_iter().any(|source| {
                                own.clone().any(|part| self.casts(&beam, (source, part)))
                            })
                    })
                })
        })
    }

    /// Surfaces hide what is behind them where all of them are known.
    fn shows(&self, beam: &Beam, range: Range, ball: &Sphere) -> bool {
        beam.may_show(ball, self.hides(range))
    }

    fn hides(&self, range: Range) -> bool {
        range.any && !range.gap && !self.guesses()
    }

    fn shows_part(&self, beam: &Beam, range: Range, part: u32) -> bool {
        let Part { ball, solid } = &self.parts[part as usize];
        self.shows(beam, range, ball)
            && solid
                .as_ref()
                .is_none_or(|solid| beam.may_show_box(solid, self.hides(range)))
    }

    fn casts(&self, beam: &Beam, (source, part): (u32, u32)) -> bool {
        self.is_between(beam, &self.sources[source as usize], part)
    }

    /// May a part stand between a lamp and a point of a beam?
    fn is_between(&self, beam: &Beam, lamp: &Lamp, part: u32) -> bool {
        let Part { ball, solid } = &self.parts[part as usize];
        // The box first: it is asked about in less time.
        let by_box = |solid: &Solid| lamp.may_be_blocked_by(solid, beam);
        solid.as_ref().is_none_or(by_box) && lamp.may_be_blocked(ball, beam)
    }

    /// Marks the pixels of a block as far as `tile`, which is the block, needs it.
    /// `rows` begin with the block's own.
    pub fn within(&self, window: Window, rows: &mut [u8], tile: &mut Tile) {
        let left = self.remaining(window, &self.everything(), true);
        let smaller = |side: &u32| *side < window.width.max(window.height);
        let level = self.sides.iter().position(smaller);
        let level = level.unwrap_or(self.sides.len());
        self.square(window, level, &left, window.y, rows, tile);
    }

    /// Marks the pixels of a window, which is cut into squares of the side number
    /// `level`. At the largest, suspects are wholes; at smaller ones, parts. `rows`
    /// begin with the picture's row `top`.
    fn square(
        &self,
        window: Window,
        level: usize,
        suspects: &Suspects,
        top: u32,
        rows: &mut [u8],
        tile: &mut Tile,
    ) {
        if suspects.is_empty() {
            return;
        }
        let Some(&side) = self.sides.get(level) else {
            return self.pixels(window, suspects, top, rows, tile);
        };
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
                if self.is_done(tile, cell) {
                    continue;
                }
                let left = self.remaining(cell, suspects, level == 0);
                let mut own = Tile::new(cell);
                // The smallest square that holds a block, or is one, stands for it.
                let is_within = self.still.by_blocks.is_some_and(|block| side < block);
                let tile = if is_within { &mut *tile } else { &mut own };
                self.square(cell, level + 1, &left, top, rows, tile);
            }
        }
    }

    fn is_done(&self, tile: &Tile, cell: Window) -> bool {
        self.still.by_blocks.is_some() && tile.is_done(cell)
    }

    fn pixels(
        &self,
        cell: Window,
        suspects: &Suspects,
        top: u32,
        rows: &mut [u8],
        tile: &mut Tile,
    ) {
        if suspects.is_empty() {
            return;
        }
        for y in cell.y..cell.bottom() {
            for x in cell.x..cell.right() {
                if self.is_done(tile, Window::pixel(x, y)) {
                    continue;
                }
                let place = (y - top) as usize * self.still.size.width as usize + x as usize;
                let causes = self.pixel(x, y, suspects);
                if causes != 0 {
                    tile.mark(Window::pixel(x, y));
                }
                rows[place] |= causes;
            }
        }
    }

    fn pixel(&self, x: u32, y: u32, suspects: &Suspects) -> u8 {
        let own = Window::pixel(x, y);
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
        let is_seen = |&part: &u32| self.shows_part(beam, range, part);
        let casts = |&pair: &(u32, u32)| self.casts(beam, pair);
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
                by_blocks: None,
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

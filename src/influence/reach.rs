//! What can matter in a block before any depth is known: a surface lies somewhere in
//! the boxes of the objects, and that alone rules most of a picture out.

use decor_api::{Bounds, Light, Size, Sphere, Window};
use rayon::prelude::*;

use super::beam::Beam;
use super::trace::{Part, Tracer};
use super::{Changed, Still};
use crate::plan::{BLOCK, BlockSet};

/// Rounding of distances, as a share.
const ROUNDING: f64 = 1e-9;

/// Tests of a ball that a reach may take: what it saves costs as much.
const MOST_TESTS: usize = 20_000_000;

/// The blocks in which anything of `changed` can be seen, or can shade what lies in
/// `receivers`: the objects of the décor. `still` needs no depth. `None`: perhaps all
/// of them, or it would take too long to say.
pub fn reach(still: &Still<'_>, changed: &[Changed], receivers: &[Changed]) -> Option<BlockSet> {
    let places = Places::of(still, receivers);
    if changed.iter().any(|c| c.whole == Bounds::Unbounded) {
        return None;
    }
    let size = still.size;
    let mut all = BlockSet::none(size, BLOCK);
    all.insert(size.window());
    let windows: Vec<Window> = all.windows().collect();
    let tests = (changed.len() * (1 + still.lights.len()) + places.parts.len()) * windows.len();
    if tests > MOST_TESTS {
        return None;
    }
    let tracer = Tracer::new(still, changed);
    let is_reached = |window: &&Window| {
        let distances = places.along(&tracer, **window);
        tracer.reaches(**window, None, &distances)
    };
    let reached: Vec<&Window> = windows.par_iter().filter(is_reached).collect();
    let mut blocks = BlockSet::none(size, BLOCK);
    reached
        .into_iter()
        .for_each(|window| blocks.insert(*window));
    Some(blocks)
}

/// Where the surfaces of the décor can be: in the boxes of its objects.
pub struct Places {
    pub(super) parts: Vec<Part>,
    /// Anywhere: an object has no end.
    pub(super) endless: bool,
}

impl Places {
    /// Of these objects.
    pub fn of(still: &Still<'_>, receivers: &[Changed]) -> Self {
        let eye = still.camera.eye;
        let parts = receivers.iter().flat_map(|c| Part::all_of(c, eye));
        Self {
            parts: parts.collect(),
            endless: receivers.iter().any(|c| c.whole == Bounds::Unbounded),
        }
    }

    /// How many parts they have.
    pub(super) fn count(&self) -> usize {
        self.parts.len()
    }

    /// At which distances along the rays of a window: from one to another, ascending
    /// and apart.
    pub(super) fn along(&self, tracer: &Tracer<'_>, window: Window) -> Vec<(f64, f64)> {
        if self.endless {
            return vec![(0.0, f64::INFINITY)];
        }
        let beam = tracer.beam(window, super::depths::Range::of(0.0));
        let mut found: Vec<(f64, f64)> = self.parts.iter().filter_map(|p| p.along(&beam)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut apart: Vec<(f64, f64)> = Vec::new();
        for (near, far) in found {
            match apart.last_mut() {
                Some(last) if !(near > last.1) => last.1 = last.1.max(far),
                _ => apart.push((near, far)),
            }
        }
        apart
    }
}

impl Part {
    /// At which distances from the eye a point of it can lie on a ray of the beam. All
    /// of these are near the middle ray, by the spread times the distance.
    fn along(&self, beam: &Beam) -> Option<(f64, f64)> {
        let Sphere { centre, radius } = self.ball;
        let margin = (beam.spread + ROUNDING) * (centre.length() + radius);
        let r = radius + margin;
        let middle = centre.dot(beam.direction);
        let off_squared = (centre - beam.direction * middle).length_squared();
        if off_squared > r * r {
            return None;
        }
        let half = (r * r - off_squared).sqrt();
        let (mut near, mut far) = (middle - half, middle + half);
        if far < 0.0 {
            return None;
        }
        if let Some(solid) = &self.solid {
            let (enters, leaves) = solid.along_ray(glam::DVec3::ZERO, beam.direction, margin)?;
            (near, far) = (near.max(enters), far.min(leaves));
        }
        if near > far {
            return None;
        }
        // Not a number is anywhere.
        let near = if near > 0.0 { near } else { 0.0 };
        let far = if far >= near { far } else { f64::INFINITY };
        Some((near * (1.0 - ROUNDING), far * (1.0 + ROUNDING)))
    }
}

/// Can `thing`, an object of the décor, matter to what the frame shows of the décor in
/// a window? Where it can be seen there, or can shade what is.
pub fn matters(still: &Still<'_>, thing: &Changed, places: &Places, window: Window) -> bool {
    let things = std::slice::from_ref(thing);
    if thing.whole == Bounds::Unbounded {
        return true;
    }
    let tracer = Tracer::new(still, things);
    let mut distances = places.along(&tracer, window);
    let depths = &still.depths;
    let is_certain = !still.antialiased || depths.has_samples();
    let mut hidden_beyond = None;
    if is_certain && depths.knows(window) {
        let range = depths.range(window, 0, still.size);
        let (absolute, relative) = depths.quantum();
        let near = range.near * (1.0 - relative) - absolute;
        let far = range.far * (1.0 + relative) + absolute;
        distances.retain_mut(|(from, to)| {
            (*from, *to) = (from.max(near), to.min(far));
            range.any && !(*from > *to)
        });
        hidden_beyond = (range.any && !range.gap).then_some(far);
    }
    tracer.reaches(window, hidden_beyond, &distances)
}

/// Can `caster` shade anything of `receiver`?
pub fn shades(lights: &[Light], caster: &Changed, receiver: &Changed) -> bool {
    let balls: Vec<Bounds> = if receiver.boxes.is_empty() {
        vec![receiver.whole]
    } else {
        let balls = receiver.boxes.iter().map(|solid| solid.ball());
        balls
            .map(|ball| Bounds::sphere(ball.centre, ball.radius))
            .collect()
    };
    lights.iter().any(|light| {
        let mut balls = balls.iter();
        balls.any(|ball| super::may_shade(light, &caster.whole, ball))
    })
}

/// A window with the pixels around it, which antialiasing looks at.
pub fn with_ring(window: Window, size: Size) -> Window {
    let (x, y) = (window.x.saturating_sub(1), window.y.saturating_sub(1));
    Window {
        x,
        y,
        width: window.right().saturating_add(1) - x,
        height: window.bottom().saturating_add(1) - y,
    }
    .intersection(size.window())
}

//! The distances of the décor's surfaces, and what lies between two of them.

use decor_api::{Layer, Size, Window};

use super::Ranges;
use crate::plan::BlockSet;

/// The décor's depth over the picture.
#[derive(Clone, Copy, Debug)]
pub struct Depths<'a> {
    centres: &'a Layer,
    samples: Option<(&'a Layer, u32)>,
    /// Where anything can change, and where depth is known.
    within: Option<(&'a BlockSet, &'a BlockSet)>,
    ranges: Option<&'a Ranges>,
}

static NOWHERE: Layer = Layer {
    window: Window::EMPTY,
    colour: None,
    depth: None,
    depth_quantum: (0.0, 0.0),
};

/// Distances along the rays of some pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Range {
    pub near: f64,
    pub far: f64,
    /// Is there a surface at all?
    pub any: bool,
    /// Is nothing seen along some of the rays?
    pub gap: bool,
}

impl Range {
    /// Of one ray.
    pub fn of(depth: f64) -> Self {
        let mut range = Self::NONE;
        range.add(depth);
        range
    }

    pub const NONE: Self = Self {
        near: f64::INFINITY,
        far: 0.0,
        any: false,
        gap: false,
    };

    fn add(&mut self, depth: f64) {
        if (0.0..f64::INFINITY).contains(&depth) {
            self.near = self.near.min(depth);
            self.far = self.far.max(depth);
            self.any = true;
        } else if depth == f64::INFINITY {
            self.gap = true;
        } else {
            // Not a distance: it may be anywhere.
            (self.near, self.far, self.any) = (0.0, f64::INFINITY, true);
        }
    }

    /// As [`Self::add`], without a branch: most of the time goes here.
    fn add_all(&mut self, depths: &[f64]) {
        let (mut near, mut far) = (f64::INFINITY, -1.0_f64);
        let (mut gap, mut odd) = (false, false);
        for &depth in depths {
            let is_gap = depth == f64::INFINITY;
            let finite = if is_gap { -1.0 } else { depth };
            gap |= is_gap;
            odd |= !(depth >= 0.0);
            near = if depth < near { depth } else { near };
            far = if finite > far { finite } else { far };
        }
        self.gap |= gap;
        if odd {
            self.add(f64::NAN);
        } else if near < f64::INFINITY {
            self.add(near);
            self.add(far);
        }
    }

    /// Of both.
    pub fn union(self, other: Self) -> Self {
        Self {
            near: self.near.min(other.near),
            far: self.far.max(other.far),
            any: self.any || other.any,
            gap: self.gap || other.gap,
        }
    }

    /// With what may lie between the centres: as far beyond the range as it is
    /// wide, and to the end of the world beside nothing.
    pub fn extended(self) -> Self {
        if !self.any {
            return self;
        }
        let width = self.far - self.near;
        Self {
            near: (self.near - width).max(0.0),
            far: if self.gap {
                f64::INFINITY
            } else {
                self.far + width
            },
            ..self
        }
    }
}

impl<'a> Depths<'a> {
    /// The depth at the pixels' centres. Pixels outside of the layer's window
    /// are of unknown depth.
    pub fn at_centres(centres: &'a Layer) -> Self {
        Self {
            centres,
            samples: None,
            within: None,
            ranges: None,
        }
    }

    /// Nobody knows any.
    pub fn unknown() -> Depths<'static> {
        Depths::at_centres(&NOWHERE)
    }

    /// And at `per_side`² places in every pixel, evenly spaced: `samples` is the
    /// whole picture so many times as large.
    pub fn with_samples(centres: &'a Layer, samples: &'a Layer, per_side: u32) -> Self {
        Self {
            centres,
            samples: (per_side > 0).then_some((samples, per_side)),
            ..Self::at_centres(centres)
        }
    }

    /// Of use in the blocks `reached` only: nothing [reaches](super::reach) the
    /// others, at whatever depth their surfaces are. In those `known`, which hold
    /// them, it is known.
    #[must_use]
    pub fn within(self, reached: &'a BlockSet, known: &'a BlockSet) -> Self {
        Self {
            within: Some((reached, known)),
            ..self
        }
    }

    /// With ranges that were found before, of these very depths.
    #[must_use]
    pub fn with_ranges(self, ranges: &'a Ranges) -> Self {
        Self {
            ranges: Some(ranges),
            ..self
        }
    }

    /// Is the depth of every sample known?
    pub fn has_samples(&self) -> bool {
        self.samples.is_some()
    }

    /// Can anything change in a tile, which lies in one block?
    pub(super) fn may_change(&self, tile: Window) -> bool {
        self.within.is_none_or(|(reached, _)| reached.touches(tile))
    }

    /// Are the depths of a window those of its surfaces?
    pub(super) fn knows(&self, window: Window) -> bool {
        self.within.is_none_or(|(_, known)| known.contains(window))
    }

    /// How exact they are.
    pub(super) fn quantum(&self) -> (f64, f64) {
        let (a, b) = self.centres.depth_quantum;
        let (c, d) = self.samples.map_or((0.0, 0.0), |s| s.0.depth_quantum);
        (a.max(c), b.max(d))
    }

    /// The depth at a pixel's centre; NaN where nobody knows.
    pub(super) fn centre(&self, x: u32, y: u32) -> f64 {
        at(self.centres, x, y)
    }

    /// The places in pixel (x, y), from 0 to 1 to the right and downwards, and
    /// the depth at each, but for the centre.
    pub(super) fn samples(&self, x: u32, y: u32) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
        let samples = self.samples.into_iter();
        samples.flat_map(move |(layer, n)| {
            let place = move |k: u32| (f64::from(k) + 0.5) / f64::from(n);
            (0..n * n).map(move |k| {
                let (i, j) = (k % n, k / n);
                (place(i), place(j), at(layer, x * n + i, y * n + j))
            })
        })
    }

    /// The depths in `window`, and in the pixels around it that are at most
    /// `ring` away.
    pub(super) fn range(&self, window: Window, ring: u32, size: Size) -> Range {
        let found = self
            .ranges
            .and_then(|ranges| ranges.of_window(window, ring));
        found.unwrap_or_else(|| self.search(window, ring, size))
    }

    /// The same, not yet known.
    pub(super) fn search(&self, window: Window, ring: u32, size: Size) -> Range {
        let mut range = Range::NONE;
        let columns = window.x.saturating_sub(ring)..(window.right() + ring).min(size.width);
        for y in window.y.saturating_sub(ring)..(window.bottom() + ring).min(size.height) {
            add_row(&mut range, self.centres, columns.clone(), y);
        }
        if let Some((layer, n)) = self.samples {
            for y in window.y * n..window.bottom() * n {
                add_row(&mut range, layer, window.x * n..window.right() * n, y);
            }
        }
        range
    }
}

fn at(layer: &Layer, x: u32, y: u32) -> f64 {
    match &layer.depth {
        Some(depth) if layer.window.contains(x, y) => {
            depth.get(layer.index(x, y)).copied().unwrap_or(f64::NAN)
        }
        _ => f64::NAN,
    }
}

fn add_row(range: &mut Range, layer: &Layer, columns: std::ops::Range<u32>, y: u32) {
    let window = layer.window;
    let is_inside = !columns.is_empty()
        && window.contains(columns.start, y)
        && window.contains(columns.end - 1, y);
    let row = match &layer.depth {
        Some(depth) if is_inside => {
            let first = layer.index(columns.start, y);
            depth.get(first..first + columns.len())
        }
        _ => None,
    };
    match row {
        Some(row) => range.add_all(row),
        None => columns.for_each(|x| range.add(at(layer, x, y))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(depth: &[f64]) -> Layer {
        Layer {
            window: Window {
                x: 0,
                y: 0,
                width: 3,
                height: (depth.len() / 3) as u32,
            },
            colour: None,
            depth: Some(depth.to_vec()),
            depth_quantum: (0.0, 0.0),
        }
    }

    const SIZE: Size = Size {
        width: 3,
        height: 2,
    };

    fn pixel(x: u32, y: u32) -> Window {
        Window {
            x,
            y,
            width: 1,
            height: 1,
        }
    }

    #[test]
    fn a_range_holds_the_neighbours() {
        let inf = f64::INFINITY;
        let layer = layer(&[4.0, 5.0, 9.0, inf, 7.0, 6.0]);
        let depths = Depths::at_centres(&layer);
        let own = depths.range(pixel(1, 0), 0, SIZE);
        assert_eq!((own.near, own.far, own.gap), (5.0, 5.0, false));
        let right = depths.range(pixel(2, 0), 1, SIZE).extended();
        assert_eq!((right.near, right.far, right.gap), (1.0, 13.0, false));
        let left = depths.range(pixel(0, 0), 1, SIZE).extended();
        assert_eq!((left.near, left.far, left.gap), (1.0, inf, true));
    }

    #[test]
    fn what_is_not_known_may_be_anywhere() {
        let layer = layer(&[4.0, f64::NAN, 9.0]);
        let depths = Depths::at_centres(&layer);
        for window in [pixel(1, 0), pixel(1, 1)] {
            let range = depths.range(window, 0, SIZE);
            assert_eq!((range.near, range.far), (0.0, f64::INFINITY));
        }
        let nothing = Layer {
            depth: None,
            ..layer.clone()
        };
        assert!(Depths::at_centres(&nothing).range(pixel(0, 0), 0, SIZE).any);
    }

    #[test]
    fn samples_lie_inside_their_pixel() {
        let centres = layer(&[1.0; 6]);
        let fine = Layer {
            window: Window {
                x: 0,
                y: 0,
                width: 6,
                height: 4,
            },
            depth: Some((0..24).map(f64::from).collect()),
            ..layer(&[])
        };
        let depths = Depths::with_samples(&centres, &fine, 2);
        let got: Vec<_> = depths.samples(1, 1).collect();
        let want = [
            (0.25, 0.25, 14.0),
            (0.75, 0.25, 15.0),
            (0.25, 0.75, 20.0),
            (0.75, 0.75, 21.0),
        ];
        assert_eq!(got, want);
        assert_eq!(depths.range(pixel(1, 1), 0, SIZE).far, 21.0);
    }
}

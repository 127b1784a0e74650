//! The merge: a fast layer into the décor, pixel by pixel, nearest wins.
//!
//! Thesis, III-3-2-1. Two depths closer than both adapters' exactness are a tie,
//! and the fast object gets it, the same way every time. With antialiasing a
//! fast object's edge covers part of a pixel: it is laid over the décor by its
//! coverage.

use std::ops::Range;

use decor_api::{Layer, Window};

use crate::dissolve::Backdrop;

/// A rectangle of a finished frame that replaces the décor's.
#[derive(Clone, Debug, PartialEq)]
pub struct Patch {
    /// Where it goes.
    pub window: Window,
    /// Linear red, green, blue, premultiplied by coverage, and coverage.
    pub colour: Vec<[f32; 4]>,
    /// The distance along the ray, where it is wanted.
    pub depth: Option<Vec<f64>>,
}

/// A part of a row where something fast is seen.
#[derive(Clone, Copy, Debug)]
pub struct Run<'a> {
    /// Its first column.
    pub x: u32,
    /// Its row.
    pub y: u32,
    /// What is seen there.
    pub colour: &'a [[f32; 4]],
    /// The distance along the ray, where it is wanted; else empty.
    pub depth: &'a [f64],
}

/// Merges a fast layer's window into the décor, which covers the whole picture.
/// The patch is the part of the window where anything fast is at all.
///
/// `antialiased`: coverage decides how much of a pixel is the fast object's. If
/// not, a pixel belongs to one or the other.
pub fn merge(
    decor: Backdrop<'_>,
    fast_colour: &Layer,
    fast_depth: &Layer,
    antialiased: bool,
) -> Patch {
    let fast = Fast::of(fast_colour, fast_depth, antialiased);
    let window = fast.extent();
    let width = window.width as usize;
    let mut colour = vec![[0.0; 4]; window.pixels()];
    let mut depth = vec![f64::INFINITY; window.pixels()];
    for (k, y) in (window.y..window.bottom()).enumerate() {
        let row = k * width..(k + 1) * width;
        decor.row(window.x, y, &mut colour[row.clone()], &mut depth[row]);
    }
    merge_onto(decor, fast_colour, fast_depth, antialiased, true, |run| {
        let from = (run.y - window.y) as usize * width + (run.x - window.x) as usize;
        let into = from..from + run.colour.len();
        colour[into.clone()].copy_from_slice(run.colour);
        depth[into].copy_from_slice(run.depth);
    });
    Patch {
        window,
        colour,
        depth: Some(depth),
    }
}

/// The same onto a frame that shows the décor already: `lay` is told of every run
/// of pixels where something fast is seen, row by row. Nothing is copied that
/// does not change; with depths only where `with_depth` asks for them.
///
/// One core does it: frames are many, and several are merged at once.
pub fn merge_onto(
    decor: Backdrop<'_>,
    fast_colour: &Layer,
    fast_depth: &Layer,
    antialiased: bool,
    with_depth: bool,
    mut lay: impl FnMut(Run<'_>),
) {
    let fast = Fast::of(fast_colour, fast_depth, antialiased);
    let quantum = decor.depth_quantum();
    let quantum = (
        quantum.0 + fast_depth.depth_quantum.0,
        quantum.1 + fast_depth.depth_quantum.1,
    );
    let width = fast.window.width as usize;
    // What is read of a row stays in the nearest cache until it is used.
    let mut dissolved = vec![f64::INFINITY; width];
    let mut shown = vec![Shown::Decor; width];
    let mut both = Vec::new();
    let mut nearest = Vec::new();
    for y in fast.window.y..fast.window.bottom() {
        let Some(columns) = fast.columns(y) else {
            continue;
        };
        let left = fast.window.x + columns.start as u32;
        let row = fast.index(fast.window.x, y);
        let part = row + columns.start..row + columns.end;
        let (over, near) = (&fast.colour[part.clone()], &fast.depth[part]);
        let behind = decor.depths_of(left, y, &mut dissolved[..columns.len()]);
        let shown = &mut shown[..columns.len()];
        for ((shown, &near), &behind) in shown.iter_mut().zip(near).zip(behind) {
            *shown = if wins(near, behind, quantum) {
                Shown::Fast
            } else {
                Shown::Decor
            };
        }
        if antialiased {
            for (x, (shown, fast_pixel)) in shown.iter_mut().zip(over).enumerate() {
                let coverage = fast_pixel[3];
                let beside = || {
                    near[x] == f64::INFINITY
                        && wins(fast.edge_depth(left + x as u32, y), behind[x], quantum)
                };
                if coverage <= 0.0 {
                    *shown = Shown::Decor;
                } else if coverage < 1.0 && (*shown == Shown::Fast || beside()) {
                    *shown = Shown::Both;
                } else if *shown == Shown::Decor && beside() {
                    *shown = Shown::Fast;
                }
            }
        }
        // Pixels that follow each other mostly show the same.
        let mut x = 0;
        while x < shown.len() {
            let (start, what) = (x, shown[x]);
            let others = shown[start..].iter().position(|&shown| shown != what);
            x = others.map_or(shown.len(), |many| start + many);
            let run = start..x;
            let colour = match what {
                Shown::Decor => continue,
                Shown::Fast => &over[run.clone()],
                Shown::Both => {
                    both.resize(run.len(), [0.0; 4]);
                    decor.colours(left + start as u32, y, &behind[run.clone()], &mut both);
                    for (below, fast) in both.iter_mut().zip(&over[run.clone()]) {
                        *below = laid_over(*fast, *below);
                    }
                    &both[..]
                }
            };
            nearest.clear();
            if with_depth {
                let depths = near[run.clone()].iter().zip(&behind[run]);
                nearest.extend(depths.map(|(near, behind)| near.min(*behind)));
            }
            lay(Run {
                x: left + start as u32,
                y,
                colour,
                depth: &nearest,
            });
        }
    }
}

/// Lays a layer of which all is nearer than the décor over it, by its coverage alone.
/// `lay` is told of every run of pixels where anything of it is seen. As in
/// [`merge_onto`], a pixel belongs to one or the other where nothing is `antialiased`:
/// the décor's colours need not be there then.
pub fn lay_over(
    decor: Backdrop<'_>,
    fast: &Layer,
    antialiased: bool,
    mut lay: impl FnMut(Run<'_>),
) {
    let shown = |pixel: &[f32; 4]| Shown::by_coverage(pixel[3], antialiased);
    let width = (fast.window.width as usize).max(1);
    let rows = fast.colour.as_deref().unwrap_or_default().chunks(width);
    let mut depth = vec![f64::INFINITY; width];
    let mut both = Vec::new();
    for (y, row) in (fast.window.y..).zip(rows) {
        let mut from = 0;
        for run in row.chunk_by(|a, b| shown(a) == shown(b)) {
            let x = fast.window.x + from as u32;
            from += run.len();
            let colour = match shown(&run[0]) {
                Shown::Decor => continue,
                Shown::Fast => run,
                Shown::Both => {
                    both.resize(run.len(), [0.0; 4]);
                    let depth = &mut depth[..run.len()];
                    decor.depths(x, y, depth);
                    decor.colours(x, y, depth, &mut both);
                    for (below, over) in both.iter_mut().zip(run) {
                        *below = laid_over(*over, *below);
                    }
                    &both[..]
                }
            };
            lay(Run {
                x,
                y,
                colour,
                depth: &[],
            });
        }
    }
}

/// What is seen in a pixel.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Shown {
    Decor,
    Fast,
    /// The décor through the edge of something fast.
    Both,
}

impl Shown {
    /// Where nothing of the décor is nearer.
    fn by_coverage(coverage: f32, antialiased: bool) -> Self {
        match coverage {
            some if some > 0.0 && some < 1.0 && antialiased => Self::Both,
            some if some > 0.0 => Self::Fast,
            _ => Self::Decor,
        }
    }
}

/// A fast layer, its colour and its depth.
struct Fast<'a> {
    window: Window,
    colour: &'a [[f32; 4]],
    depth: &'a [f64],
    antialiased: bool,
}

impl<'a> Fast<'a> {
    fn of(colour: &'a Layer, depth: &'a Layer, antialiased: bool) -> Self {
        debug_assert_eq!(colour.window, depth.window);
        Self {
            window: colour.window,
            colour: colour.colour.as_deref().unwrap_or_default(),
            depth: depth.depth.as_deref().unwrap_or_default(),
            antialiased,
        }
    }

    /// The columns of a row, counted from the window's left, where anything may
    /// be: with antialiasing also beside what has a depth in a row beside.
    fn columns(&self, y: u32) -> Option<Range<usize>> {
        let Window { width, height, .. } = self.window;
        let (width, row) = (width as usize, y - self.window.y);
        let around = u32::from(self.antialiased);
        let mut found: Option<Range<usize>> = None;
        for row in row.saturating_sub(around)..(row + around + 1).min(height) {
            let from = row as usize * width;
            let near = &self.depth[from..from + width];
            let is_there = |depth: &f64| *depth != f64::INFINITY;
            let Some(first) = near.iter().position(is_there) else {
                continue;
            };
            let end = 1 + near.iter().rposition(is_there).unwrap_or(first);
            found = Some(match found {
                None => first..end,
                Some(found) => found.start.min(first)..found.end.max(end),
            });
        }
        let around = around as usize;
        found.map(|f| f.start.saturating_sub(around)..(f.end + around).min(width))
    }

    fn index(&self, x: u32, y: u32) -> usize {
        (y - self.window.y) as usize * self.window.width as usize + (x - self.window.x) as usize
    }

    /// The part of the window where anything is: with antialiasing also beside
    /// what has a depth.
    fn extent(&self) -> Window {
        let window = self.window;
        let mut extent = Window::EMPTY;
        for y in window.y..window.bottom() {
            if let Some(columns) = self.columns(y) {
                extent = extent.union(Window {
                    x: window.x + columns.start as u32,
                    y,
                    width: columns.len() as u32,
                    height: 1,
                });
            }
        }
        extent
    }

    /// The depth of a pixel of which the edge of something covers a part, but not
    /// the centre: that of the nearest neighbour that has one.
    fn edge_depth(&self, x: u32, y: u32) -> f64 {
        let Window { width, height, .. } = self.window;
        let (x, y) = (x - self.window.x, y - self.window.y);
        let mut nearest = f64::INFINITY;
        for row in y.saturating_sub(1)..(y + 2).min(height) {
            for column in x.saturating_sub(1)..(x + 2).min(width) {
                let at = row as usize * width as usize + column as usize;
                nearest = nearest.min(self.depth[at]);
            }
        }
        nearest
    }
}

/// Is the fast object before the décor, or as near as can be told? Without a
/// branch: several pixels are compared at once.
#[inline]
fn wins(fast: f64, decor: f64, quantum: (f64, f64)) -> bool {
    let farther = if fast > decor { fast } else { decor };
    // Where the décor has nothing, the limit is infinite, or not a number where
    // depths are exact: nothing is beyond it.
    let is_behind = fast > decor + (quantum.0 + quantum.1 * farther);
    (fast < f64::INFINITY) & !is_behind
}

/// Porter and Duff's *over*, premultiplied.
fn laid_over(over: [f32; 4], below: [f32; 4]) -> [f32; 4] {
    if over[3] >= 1.0 {
        return over;
    }
    let rest = 1.0 - over[3];
    std::array::from_fn(|k| over[k] + rest * below[k])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FAR: f64 = f64::INFINITY;

    fn layer(x: u32, colour: &[[f32; 4]], depth: &[f64]) -> Layer {
        Layer {
            window: Window {
                x,
                y: 0,
                width: colour.len() as u32,
                height: 1,
            },
            colour: Some(colour.to_vec()),
            depth: Some(depth.to_vec()),
            depth_quantum: (0.0, 1e-6),
        }
    }

    const RED: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
    const BLUE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];

    #[test]
    fn the_nearest_wins_and_a_tie_is_the_fast_objects() {
        let decor = layer(0, &[BLUE; 5], &[1.0, 2.0, 3.0, FAR, 3.0]);
        let fast = layer(0, &[RED; 5], &[2.0, 2.000_001, 2.0, 9.0, FAR]);
        let patch = merge(Backdrop::plain(&decor), &fast, &fast, false);
        // The last pixel has nothing fast.
        assert_eq!(patch.window.width, 4);
        assert_eq!(patch.colour, [BLUE, RED, RED, RED]);
        assert_eq!(patch.depth.as_deref(), Some(&[1.0, 2.0, 2.0, 9.0][..]));
        let mut runs = Vec::new();
        merge_onto(Backdrop::plain(&decor), &fast, &fast, false, false, |run| {
            assert_eq!((run.y, run.depth), (0, &[][..]));
            runs.push((run.x, run.colour.to_vec()));
        });
        // What shows the décor is left alone.
        assert_eq!(runs, [(1, vec![RED; 3])]);
    }

    #[test]
    fn an_edge_is_laid_over_by_its_coverage() {
        let half = [0.5, 0.0, 0.0, 0.5];
        let decor = layer(0, &[BLUE; 3], &[5.0, 5.0, 1.0]);
        // The middle pixel is covered by half, but its centre shows the décor;
        // the last one has nothing fast beside it.
        let fast = layer(0, &[RED, half, half], &[2.0, FAR, FAR]);
        let patch = merge(Backdrop::plain(&decor), &fast, &fast, true);
        assert_eq!(patch.colour, [RED, [0.5, 0.0, 0.5, 1.0]]);
    }

    #[test]
    fn what_is_before_all_is_laid_over_by_its_coverage() {
        let half = [0.5, 0.0, 0.0, 0.5];
        let mut decor = layer(0, &[BLUE; 6], &[5.0; 6]);
        let mut fast = layer(1, &[RED, RED, half, [0.0; 4], RED], &[FAR; 5]);
        (decor.depth, fast.depth) = (None, None);
        let mut runs = Vec::new();
        lay_over(Backdrop::plain(&decor), &fast, true, |run| {
            assert_eq!((run.y, run.depth), (0, &[][..]));
            runs.push((run.x, run.colour.to_vec()));
        });
        let mixed = vec![[0.5, 0.0, 0.5, 1.0]];
        assert_eq!(runs, [(1, vec![RED; 2]), (3, mixed), (5, vec![RED])]);
        // Without antialiasing, colours of the décor may have been let go.
        (decor.colour, runs) = (None, Vec::new());
        lay_over(Backdrop::plain(&decor), &fast, false, |run| {
            runs.push((run.x, run.colour.to_vec()));
        });
        assert_eq!(runs, [(1, vec![RED, RED, half]), (5, vec![RED])]);
    }

    #[test]
    fn windows_may_begin_anywhere() {
        let decor = layer(0, &[BLUE; 4], &[5.0; 4]);
        let fast = layer(2, &[RED; 2], &[2.0, FAR]);
        let patch = merge(Backdrop::plain(&decor), &fast, &fast, false);
        assert_eq!((patch.window.x, patch.window.width), (2, 1));
        assert_eq!(patch.colour, [RED]);
    }

    /// The merge in so many words: every pixel of the window by itself.
    fn in_words(decor: &Layer, fast: &Layer, antialiased: bool) -> Vec<[f32; 4]> {
        let window = fast.window;
        let (colour, depth) = (fast.colour.as_ref().unwrap(), fast.depth.as_ref().unwrap());
        let pixel = |x: u32, y: u32| {
            let at = decor.index(x, y);
            let below = decor.colour.as_ref().unwrap()[at];
            let over = colour[fast.index(x, y)];
            let mut near = depth[fast.index(x, y)];
            if antialiased && near == FAR {
                for row in y.saturating_sub(1)..y + 2 {
                    for column in x.saturating_sub(1)..x + 2 {
                        if window.contains(column, row) {
                            near = near.min(depth[fast.index(column, row)]);
                        }
                    }
                }
            }
            let behind = decor.depth.as_ref().unwrap()[at];
            match antialiased {
                _ if near == FAR || near > behind => below,
                true => laid_over(over, below),
                false => over,
            }
        };
        let rows = window.y..window.bottom();
        rows.flat_map(|y| (window.x..window.right()).map(move |x| (x, y)))
            .map(|(x, y)| pixel(x, y))
            .collect()
    }

    proptest! {
        #[test]
        fn a_patch_laid_onto_the_decor_is_the_merge(
            antialiased: bool,
            window in (0_u32..6, 0_u32..5, 1_u32..8, 1_u32..7),
            pixels in prop::collection::vec((0_u8..6, 0_u8..4), 64..65),
        ) {
            let (x, y, width, height) = window;
            let grey = |value: u8| [f32::from(value), 0.0, 0.0, 1.0];
            let far = |value: u8| if value == 5 { FAR } else { f64::from(value) };
            let place = |x, y, width, height| Window { x, y, width, height };
            let whole = place(0, 0, 16, 12);
            let decor = Layer {
                window: whole,
                colour: Some((0..whole.pixels()).map(|i| grey(i as u8)).collect()),
                depth: Some((0..whole.pixels()).map(|i| far((i * 7 % 6) as u8)).collect()),
                depth_quantum: (0.0, 0.0),
            };
            let window = place(x, y, width, height);
            let some = &pixels[..window.pixels()];
            let coverage = |(d, c): &(u8, u8)| if *d == 5 { f32::from(*c) / 4.0 } else { 1.0 };
            let fast = Layer {
                window,
                colour: Some(some.iter().map(|p| [9.0 * coverage(p), 1.0, 1.0, coverage(p)]).collect()),
                depth: Some(some.iter().map(|(d, _)| far(*d)).collect()),
                depth_quantum: (0.0, 0.0),
            };
            let patch = merge(Backdrop::plain(&decor), &fast, &fast, antialiased);
            prop_assert_eq!(patch.colour.len(), patch.window.pixels());
            prop_assert_eq!(patch.depth.as_ref().map(Vec::len), Some(patch.window.pixels()));
            let mut shown = decor.clone();
            let picture = shown.colour.as_mut().unwrap();
            for (k, y) in (patch.window.y..patch.window.bottom()).enumerate() {
                for x in patch.window.x..patch.window.right() {
                    let from = k * patch.window.width as usize + (x - patch.window.x) as usize;
                    picture[y as usize * 16 + x as usize] = patch.colour[from];
                }
            }
            let words = in_words(&decor, &fast, antialiased);
            for (k, (x, y)) in (y..y + height).flat_map(|y| (x..x + width).map(move |x| (x, y))).enumerate() {
                // Where nothing covers, nothing is laid over.
                let expected = if antialiased && coverage(&some[k]) == 0.0 {
                    decor.colour.as_ref().unwrap()[y as usize * 16 + x as usize]
                } else {
                    words[k]
                };
                prop_assert_eq!(shown.colour.as_ref().unwrap()[y as usize * 16 + x as usize], expected);
            }
        }
    }
}

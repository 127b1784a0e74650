//! The merge: a fast layer into the décor, pixel by pixel, nearest wins.
//!
//! Thesis, III-3-2-1. Two depths closer than both adapters' exactness are a tie,
//! and the fast object gets it, the same way every time. With antialiasing a
//! fast object's edge covers part of a pixel: it is laid over the décor by its
//! coverage.

use decor_api::{Layer, Window};
use rayon::prelude::*;

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

/// Merges a fast layer's window into the décor, which covers the whole picture.
/// Rows are done in parallel, each by itself: the result does not depend on the
/// number of threads.
///
/// `antialiased`: coverage decides how much of a pixel is the fast object's. If
/// not, a pixel belongs to one or the other.
pub fn merge(
    decor: Backdrop<'_>,
    fast_colour: &Layer,
    fast_depth: &Layer,
    antialiased: bool,
) -> Patch {
    let window = fast_colour.window;
    debug_assert_eq!(window, fast_depth.window);
    let width = window.width as usize;
    let over_colour = fast_colour.colour.as_deref().unwrap_or_default();
    let over_depth = fast_depth.depth.as_deref().unwrap_or_default();
    let quantum = decor.depth_quantum();
    let quantum = (
        quantum.0 + fast_depth.depth_quantum.0,
        quantum.1 + fast_depth.depth_quantum.1,
    );

    let mut colour = vec![[0.0; 4]; window.pixels()];
    let mut depth = vec![f64::INFINITY; window.pixels()];
    if width == 0 {
        return Patch {
            window,
            colour,
            depth: Some(depth),
        };
    }
    let rows = colour
        .par_chunks_mut(width)
        .zip(depth.par_chunks_mut(width));
    rows.zip(0..window.height)
        .for_each(|((colour, depth), row)| {
            decor.row(window.x, window.y + row, colour, depth);
            let over = row as usize * width;
            for x in 0..width {
                let fast = over_colour[over + x];
                let coverage = if antialiased { fast[3] } else { 1.0 };
                let near = if antialiased && coverage > 0.0 {
                    edge_depth(over_depth, window, x, row as usize)
                } else {
                    over_depth[over + x]
                };
                if coverage > 0.0 && wins(near, depth[x], quantum) {
                    colour[x] = if antialiased {
                        laid_over(fast, colour[x])
                    } else {
                        fast
                    };
                    depth[x] = over_depth[over + x].min(depth[x]);
                }
            }
        });
    Patch {
        window,
        colour,
        depth: Some(depth),
    }
}

/// Is the fast object before the décor, or as near as can be told?
fn wins(fast: f64, decor: f64, quantum: (f64, f64)) -> bool {
    if fast == f64::INFINITY {
        return false;
    }
    if decor == f64::INFINITY {
        return true;
    }
    fast <= decor + (quantum.0 + quantum.1 * fast.max(decor))
}

/// The depth of a fast pixel, also where its edge covers a part of the pixel
/// but not the centre: then that of the nearest neighbour that has one.
fn edge_depth(depth: &[f64], window: Window, x: usize, y: usize) -> f64 {
    let (width, height) = (window.width as usize, window.height as usize);
    let own = depth[y * width + x];
    if own != f64::INFINITY {
        return own;
    }
    let mut nearest = f64::INFINITY;
    for row in y.saturating_sub(1)..(y + 2).min(height) {
        for column in x.saturating_sub(1)..(x + 2).min(width) {
            nearest = nearest.min(depth[row * width + column]);
        }
    }
    nearest
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
        assert_eq!(patch.colour, [BLUE, RED, RED, RED, BLUE]);
        assert_eq!(patch.depth.unwrap(), [1.0, 2.0, 2.0, 9.0, 3.0]);
    }

    #[test]
    fn an_edge_is_laid_over_by_its_coverage() {
        let half = [0.5, 0.0, 0.0, 0.5];
        let decor = layer(0, &[BLUE; 3], &[5.0, 5.0, 1.0]);
        // The middle pixel is covered by half, but its centre shows the décor.
        let fast = layer(0, &[RED, half, half], &[2.0, FAR, FAR]);
        let patch = merge(Backdrop::plain(&decor), &fast, &fast, true);
        assert_eq!(patch.colour, [RED, [0.5, 0.0, 0.5, 1.0], BLUE]);
    }

    #[test]
    fn windows_may_begin_anywhere() {
        let decor = layer(0, &[BLUE; 4], &[5.0; 4]);
        let fast = layer(2, &[RED; 2], &[2.0, FAR]);
        let patch = merge(Backdrop::plain(&decor), &fast, &fast, false);
        assert_eq!(patch.window.x, 2);
        assert_eq!(patch.colour, [RED, BLUE]);
    }
}

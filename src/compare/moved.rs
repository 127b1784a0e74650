//! Is B only A moved by a pixel? The commonest fault of a renderer's crop or of a
//! camera is better said by name than shown as a hundred thousand wrong pixels.

use super::metrics::difference;
use super::picture::{Form, Picture};

/// As far as is looked, in columns and in rows.
const FARTHEST: i64 = 2;

/// By how many columns (to the right) and rows (down) B is A moved, where every
/// pixel that both then have is within `level`. The shortest way, if there is
/// more than one. Nothing where B is not A moved, or is too small to tell.
pub fn moved(a: &Picture, b: &Picture, level: f64) -> Option<(i64, i64)> {
    let (width, height) = (i64::from(a.size.width), i64::from(a.size.height));
    let small = width.min(height) < 4 * FARTHEST;
    if small || a.size != b.size || a.values.len() != b.values.len() {
        return None;
    }
    let whole_steps = a.form != Form::Exr && b.form != Form::Exr;
    let at = |picture: &Picture, x: i64, y: i64| picture.values[(y * width + x) as usize];
    let equal = |x: i64, y: i64, dx: i64, dy: i64| {
        let (a, b) = (at(a, x, y), at(b, x + dx, y + dy));
        (0..3).all(|k| difference(a[k], b[k], whole_steps) <= level)
    };
    // A wrong pixel at the edge of a plain picture moves out of sight: only what
    // is wrong farther inside can be explained by a movement.
    let inside = |x: i64, y: i64| equal(x, y, 0, 0);
    let wrong_inside =
        (FARTHEST..height - FARTHEST).any(|y| (FARTHEST..width - FARTHEST).any(|x| !inside(x, y)));
    if !wrong_inside {
        return None;
    }
    let mut ways: Vec<(i64, i64)> = (-FARTHEST..=FARTHEST)
        .flat_map(|dy| (-FARTHEST..=FARTHEST).map(move |dx| (dx, dy)))
        .filter(|&way| way != (0, 0))
        .collect();
    ways.sort_by_key(|(dx, dy)| dx * dx + dy * dy);
    ways.into_iter().find(|&(dx, dy)| {
        (0.max(-dy)..height.min(height - dy))
            .all(|y| (0.max(-dx)..width.min(width - dx)).all(|x| equal(x, y, dx, dy)))
    })
}

//! Few windows around many objects: a picture in a call has its own price.

use decor_api::{Size, Window};

use super::blocks::BLOCK;

/// What one more picture in a call costs, in pixels: two windows become one
/// where that traces fewer more pixels than this.
const PICTURE_PIXELS: usize = 20_000;

/// Windows that contain all of `windows`: cheap together. The greedy choice,
/// always the pair that wins most; few objects are fast. `antialiased`: on the
/// renderers' grid, where pixels depend on their neighbours.
pub fn gathered(windows: &[Window], size: Size, antialiased: bool) -> Vec<Window> {
    let grid = if antialiased { BLOCK } else { 1 };
    let mut left: Vec<Window> = windows
        .iter()
        .map(|window| window.on_grid(grid, size))
        .filter(|window| !window.is_empty())
        .collect();
    left.sort_by_key(|w| (w.y, w.x, w.width, w.height));
    left.dedup();
    // Beyond this many the quadratic search would cost more than it wins.
    if left.len() > 64 {
        return vec![left.into_iter().fold(Window::EMPTY, Window::union)];
    }
    loop {
        let mut best: Option<(usize, usize, usize)> = None;
        for a in 0..left.len() {
            for b in a + 1..left.len() {
                let apart = left[a].pixels() + left[b].pixels() + PICTURE_PIXELS;
                let together = left[a].union(left[b]).pixels();
                let won = apart.saturating_sub(together);
                if won > best.map_or(0, |(won, ..)| won) {
                    best = Some((won, a, b));
                }
            }
        }
        let Some((_, a, b)) = best else { return left };
        let other = left.swap_remove(b);
        left[a] = left[a].union(other);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: Size = Size {
        width: 1024,
        height: 1024,
    };

    fn at(x: u32, y: u32, side: u32) -> Window {
        Window {
            x,
            y,
            width: side,
            height: side,
        }
    }

    #[test]
    fn near_windows_become_one_and_far_ones_do_not() {
        let near = gathered(&[at(10, 10, 50), at(70, 40, 30)], SIZE, true);
        assert_eq!(
            near,
            [Window {
                x: 0,
                y: 0,
                width: 128,
                height: 96
            }]
        );
        let near = gathered(&[at(10, 10, 50), at(70, 40, 30)], SIZE, false);
        assert_eq!(near, [at(10, 10, 50).union(at(70, 40, 30))]);
        assert_eq!(
            gathered(&[at(0, 0, 32), at(900, 900, 32)], SIZE, true).len(),
            2
        );
        assert!(gathered(&[Window::EMPTY], SIZE, true).is_empty());
    }

    #[test]
    fn every_window_is_contained() {
        let many: Vec<Window> = (0..200)
            .map(|k| at(k * 5 % 900, k * 37 % 900, 20))
            .collect();
        for few in [&many[..40], &many[..]] {
            let out = gathered(few, SIZE, false);
            for window in few {
                assert!(out.iter().any(|w| w.intersection(*window) == *window));
            }
        }
    }
}

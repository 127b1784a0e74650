//! A layer: colour, coverage and depth of a window of the picture.

/// The size of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Size {
    /// Pixels in a row, ≥ 1.
    pub width: u32,
    /// Rows, ≥ 1.
    pub height: u32,
}

impl Size {
    /// Pixels in all.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The window that is the whole picture.
    pub fn window(self) -> Window {
        Window {
            x: 0,
            y: 0,
            width: self.width,
            height: self.height,
        }
    }
}

/// A rectangle of pixels inside a picture; may be empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    /// The leftmost column.
    pub x: u32,
    /// The topmost row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Window {
    /// No pixel at all.
    pub const EMPTY: Self = Self {
        x: 0,
        y: 0,
        width: 0,
        height: 0,
    };

    /// One pixel.
    pub fn pixel(x: u32, y: u32) -> Self {
        Self {
            x,
            y,
            width: 1,
            height: 1,
        }
    }

    /// Is there no pixel in it?
    pub fn is_empty(self) -> bool {
        self.width == 0 || self.height == 0
    }

    /// Pixels in it.
    pub fn pixels(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// One past the rightmost column.
    pub fn right(self) -> u32 {
        self.x + self.width
    }

    /// One past the lowest row.
    pub fn bottom(self) -> u32 {
        self.y + self.height
    }

    /// Is the pixel (x, y) of the picture inside?
    pub fn contains(self, x: u32, y: u32) -> bool {
        (self.x..self.right()).contains(&x) && (self.y..self.bottom()).contains(&y)
    }

    /// The smallest window around both.
    pub fn union(self, other: Self) -> Self {
        if self.is_empty() {
            return other;
        }
        if other.is_empty() {
            return self;
        }
        let (x, y) = (self.x.min(other.x), self.y.min(other.y));
        Self {
            x,
            y,
            width: self.right().max(other.right()) - x,
            height: self.bottom().max(other.bottom()) - y,
        }
    }

    /// What both have in common.
    pub fn intersection(self, other: Self) -> Self {
        let (x, y) = (self.x.max(other.x), self.y.max(other.y));
        let right = self.right().min(other.right());
        let bottom = self.bottom().min(other.bottom());
        if right <= x || bottom <= y {
            return Self::EMPTY;
        }
        Self {
            x,
            y,
            width: right - x,
            height: bottom - y,
        }
    }

    /// Grown to multiples of `grid` on all sides, then cut at `size`.
    pub fn on_grid(self, grid: u32, size: Size) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        let down = |v: u32| v / grid * grid;
        let up = |v: u32| v.div_ceil(grid).saturating_mul(grid);
        let (x, y) = (down(self.x), down(self.y));
        let grown = Self {
            x,
            y,
            width: up(self.right()) - x,
            height: up(self.bottom()) - y,
        };
        grown.intersection(size.window())
    }
}

/// What a renderer gives back of one frame: a window of the picture, row by
/// row from the upper left. `colour` and `depth` are there where they were
/// asked for, each with one entry a pixel of the window.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// Which part of the picture.
    pub window: Window,
    /// Linear red, green, blue multiplied by coverage, and the coverage:
    /// 0 where nothing is, 1 where nothing shows through.
    pub colour: Option<Vec<[f32; 4]>>,
    /// The distance from the eye along the ray at the pixel's centre, in scene
    /// units; +∞ where nothing is.
    pub depth: Option<Vec<f64>>,
    /// Two depths closer than `depth_quantum.0 + depth_quantum.1 · depth` may
    /// be one: how exact the adapter's depth is.
    pub depth_quantum: (f64, f64),
}

impl Layer {
    /// The entry of pixel (x, y) of the picture.
    ///
    /// # Panics
    /// Debug builds: where the pixel is outside the window.
    pub fn index(&self, x: u32, y: u32) -> usize {
        debug_assert!(self.window.contains(x, y));
        (y - self.window.y) as usize * self.window.width as usize + (x - self.window.x) as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_grow_to_the_grid_and_stay_inside() {
        let size = Size {
            width: 205,
            height: 157,
        };
        let window = Window {
            x: 33,
            y: 31,
            width: 1,
            height: 2,
        };
        assert_eq!(
            window.on_grid(32, size),
            Window {
                x: 32,
                y: 0,
                width: 32,
                height: 64
            }
        );
        let corner = Window {
            x: 200,
            y: 150,
            width: 5,
            height: 7,
        };
        assert_eq!(
            corner.on_grid(32, size),
            Window {
                x: 192,
                y: 128,
                width: 13,
                height: 29
            }
        );
        assert!(Window::EMPTY.on_grid(32, size).is_empty());
    }

    #[test]
    fn union_and_intersection() {
        let a = Window {
            x: 0,
            y: 0,
            width: 10,
            height: 10,
        };
        let b = Window {
            x: 5,
            y: 8,
            width: 10,
            height: 10,
        };
        assert_eq!(
            a.union(b),
            Window {
                x: 0,
                y: 0,
                width: 15,
                height: 18
            }
        );
        assert_eq!(
            a.intersection(b),
            Window {
                x: 5,
                y: 8,
                width: 5,
                height: 2
            }
        );
        assert_eq!(a.union(Window::EMPTY), a);
        assert!(a.intersection(Window { x: 10, ..a }).is_empty());
    }
}

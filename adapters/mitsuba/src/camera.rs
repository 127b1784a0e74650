//! The camera as Mitsuba's sensor, and the way back from its depth.
//!
//! Mitsuba's world is right-handed and its picture runs to the left along x.
//! Coordinates are handed over as they are, and x of the camera points to the
//! left in the film's left-handed world: the picture comes out right.

use decor_api::{AdapterError, Camera, Size, Window};
use glam::DVec3;

use crate::units::Units;
use crate::unsupported;
use crate::xml::{matrix, number};

/// Mitsuba accepts a camera whose axes are this much longer or shorter than 1:
/// pixels may be so far from squares.
const SQUARE: f64 = 4e-4;

/// The camera over a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sensor {
    camera: Camera,
    size: Size,
    units: Units,
    /// How much higher than wide a pixel is.
    aspect: f64,
}

impl Sensor {
    /// Refuses pixels that are not squares: Mitsuba has no others.
    pub fn new(camera: &Camera, size: Size, units: Units) -> Result<Self, AdapterError> {
        let (fx, fy) = camera.focal(size);
        let aspect = fx / fy;
        if !((1.0 - SQUARE)..=(1.0 + SQUARE)).contains(&aspect) {
            return Err(unsupported(&format!(
                "pixels that are {aspect} times as high as wide: they must be squares"
            )));
        }
        Ok(Self {
            camera: *camera,
            size,
            units,
            aspect,
        })
    }

    /// Its element: `per_side`² samples in every pixel, at the middles of a
    /// grid. `enlarged`: so many times as many pixels in a row and a column,
    /// which asks for the same samples one by one.
    pub fn text(&self, window: Option<Window>, per_side: u32, enlarged: u32) -> String {
        let Camera {
            forward,
            right,
            up,
            half_width,
            ..
        } = self.camera;
        let mut film = String::new();
        let mut whole = |name: &str, value: u32| {
            film.push_str(&format!("<integer name=\"{name}\" value=\"{value}\"/>"));
        };
        whole("width", self.size.width * enlarged);
        whole("height", self.size.height * enlarged);
        if let Some(window) = window {
            whole("crop_offset_x", window.x * enlarged);
            whole("crop_offset_y", window.y * enlarged);
            whole("crop_width", window.width * enlarged);
            whole("crop_height", window.height * enlarged);
        }
        format!(
            "<sensor type=\"perspective\">\n\
             <float name=\"fov\" value=\"{}\"/><string name=\"fov_axis\" value=\"x\"/>\n\
             <float name=\"near_clip\" value=\"{}\"/><float name=\"far_clip\" value=\"{}\"/>\n\
             <transform name=\"to_world\">{}</transform>\n\
             <sampler type=\"stratified\"><integer name=\"sample_count\" value=\"{}\"/>\
             <boolean name=\"jitter\" value=\"false\"/></sampler>\n\
             <film type=\"hdrfilm\">{film}\n\
             <string name=\"file_format\" value=\"openexr\"/>\
             <string name=\"pixel_format\" value=\"rgba\"/>\
             <string name=\"component_format\" value=\"float32\"/><rfilter type=\"box\"/></film>\n\
             </sensor>\n",
            number(2.0 * half_width.atan().to_degrees()),
            number(self.units.near),
            number(self.units.far),
            matrix([-right, up * self.aspect, forward], DVec3::ZERO),
            per_side * per_side,
        )
    }

    /// The distance from the eye of what Mitsuba's ray through the centre of
    /// pixel (x, y) met at `t`; nothing was met where it is 0.
    pub fn distance(&self, x: u32, y: u32, t: f32) -> f64 {
        if t <= 0.0 || !t.is_finite() {
            return f64::INFINITY;
        }
        let centre = |v: u32| f64::from(v) + 0.5;
        let way = self.camera.direction(self.size, centre(x), centre(y));
        // Mitsuba normalises before the aspect of the pixels is applied.
        let up = self.camera.up * self.camera.up.dot(way);
        let square = way - up + up / self.aspect;
        let stretch = way.length() / square.length();
        (f64::from(t) * stretch + self.units.near * way.length()) / self.units.scale
    }

    /// Rectangles just before the eye that hide all but `shown`: pixels behind
    /// them cost next to nothing, and the others are the whole picture's own.
    pub fn mask(&self, shown: &dyn Fn(u32, u32) -> bool, grid: u32) -> String {
        let mut text = String::new();
        let mut open: Vec<Window> = Vec::new();
        for y in (0..self.size.height).step_by(grid as usize) {
            let height = grid.min(self.size.height - y);
            let mut row: Vec<Window> = Vec::new();
            for x in (0..self.size.width).step_by(grid as usize) {
                let width = grid.min(self.size.width - x);
                match row.last_mut() {
                    _ if shown(x, y) => {}
                    Some(last) if last.right() == x => last.width += width,
                    _ => row.push(Window {
                        x,
                        y,
                        width,
                        height,
                    }),
                }
            }
            // A run below one of the same columns makes that one higher.
            for run in &mut row {
                let above = open
                    .iter()
                    .position(|o| (o.x, o.width) == (run.x, run.width));
                if let Some(k) = above {
                    let above = open.swap_remove(k);
                    run.y = above.y;
                    run.height += above.height;
                }
            }
            for done in open.drain(..) {
                text.push_str(&self.cover(done));
            }
            open = row;
        }
        for done in open {
            text.push_str(&self.cover(done));
        }
        text
    }

    /// A rectangle that covers a window; at the picture's border it sticks out.
    fn cover(&self, window: Window) -> String {
        let edge = |v: u32, end: u32| match v {
            0 => -1.0,
            v if v == end => f64::from(v) + 1.0,
            v => f64::from(v),
        };
        let at = |x: u32, y: u32| {
            let (x, y) = (edge(x, self.size.width), edge(y, self.size.height));
            self.camera.direction(self.size, x, y) * (2.0 * self.units.near)
        };
        let first = at(window.x, window.y);
        let across = at(window.right(), window.y) - first;
        let down = at(window.x, window.bottom()) - first;
        let middle = first + (across + down) * 0.5;
        format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\">{}</transform>\
             <bsdf type=\"null\"/></shape>\n",
            matrix([across * 0.5, down * 0.5, self.camera.forward], middle)
        )
    }
}

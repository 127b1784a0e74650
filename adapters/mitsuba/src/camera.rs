//! The camera as Mitsuba's sensor, and the way back from its depth.
//!
//! Mitsuba's world is right-handed and its picture runs to the left along x.
//! Coordinates are handed over as they are, and x of the camera points to the
//! left in the film's left-handed world: the picture comes out right.

use decor_api::{AdapterError, Camera, Size, Window};
use glam::{DMat3, DVec3};

use crate::units::Units;
use crate::unsupported;
use crate::xml::{matrix, number};

/// Mitsuba accepts a camera whose axes are this much longer or shorter than 1:
/// pixels may be so far from squares.
const SQUARE: f64 = 4e-4;

/// Beyond that the world is squeezed in the camera's stead. Where things are and
/// how far stays exact; how surfaces face a light changes by as much, which is
/// taken for the same up to here.
const SQUEEZED: f64 = 0.03;

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
    pub fn new(camera: &Camera, size: Size, units: Units) -> Self {
        Self {
            camera: *camera,
            size,
            units,
            aspect: aspect(camera, size),
        }
    }

    /// Refuses light where pixels are too far from squares, which are all that
    /// Mitsuba has.
    pub fn refuse_light(&self) -> Result<(), AdapterError> {
        if (self.aspect - 1.0).abs() <= SQUEEZED {
            return Ok(());
        }
        Err(unsupported(&format!(
            "light in pixels that are {} times as high as wide: they must be squares",
            self.aspect
        )))
    }

    /// Its element: `per_side`² samples in every pixel, at the middles of a
    /// grid. `enlarged`: so many times as many pixels in a row and a column,
    /// which asks for the same samples one by one.
    pub fn text(&self, window: Option<Window>, per_side: u32, enlarged: u32) -> String {
        let Camera {
            forward,
            right,
            mut up,
            half_width,
            ..
        } = self.camera;
        if is_nearly_square(self.aspect) {
            up *= self.aspect;
        }
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
            matrix([-right, up, forward], DVec3::ZERO),
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
        // Mitsuba's ray is of length 1 before the aspect of the pixels is applied.
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
        let squeezed = squeeze(&self.camera, self.size);
        let at = |x: u32, y: u32| {
            let (x, y) = (edge(x, self.size.width), edge(y, self.size.height));
            squeezed * self.camera.direction(self.size, x, y) * (2.0 * self.units.near)
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

/// How much higher than wide a pixel is.
fn aspect(camera: &Camera, size: Size) -> f64 {
    let (fx, fy) = camera.focal(size);
    fx / fy
}

fn is_nearly_square(aspect: f64) -> bool {
    (aspect - 1.0).abs() <= SQUARE
}

/// What is done to the world, seen from the eye, before the camera looks: none
/// where pixels are square, or nearly so.
pub(crate) fn squeeze(camera: &Camera, size: Size) -> DMat3 {
    let aspect = aspect(camera, size);
    if is_nearly_square(aspect) {
        return DMat3::IDENTITY;
    }
    let up = camera.up;
    let along = |axis: f64| up * (axis * (aspect.recip() - 1.0));
    DMat3::IDENTITY + DMat3::from_cols(along(up.x), along(up.y), along(up.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_squeezed_world_is_as_high_as_its_pixels_are_wide() {
        let size = Size {
            width: 100,
            height: 50,
        };
        let camera = Camera::look_at(
            DVec3::ZERO,
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::Y,
            (60.0, 60.0),
        );
        let camera = camera.unwrap();
        let by = squeeze(&camera, size);
        assert!((by * camera.right - camera.right).length() < 1e-12);
        assert!((by * camera.up - camera.up * 0.5).length() < 1e-12);
    }

    #[test]
    fn a_mask_hides_all_but_what_is_shown() {
        let units = Units {
            scale: 1.0,
            near: 1.0,
            far: 10.0,
        };
        let size = Size {
            width: 100,
            height: 70,
        };
        let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::Y, (60.0, 44.0)).unwrap();
        let sensor = Sensor::new(&camera, size, units);
        let covers = |shown: &dyn Fn(u32, u32) -> bool| sensor.mask(shown, 32).lines().count();
        assert_eq!(covers(&|_, _| true), 0);
        assert_eq!(covers(&|_, _| false), 1);
        // One block inside: above, left, right, below.
        assert_eq!(covers(&|x, y| (x, y) == (32, 32)), 4);
        assert_eq!(covers(&|x, _| x == 32), 2);
    }
}

//! A frame with what the segmentation saw in it: ellipses coloured by class,
//! motion as lines, windows and blocks, a legend.

use std::convert::Infallible;

use decor_api::{Size, Window};
use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::ascii::FONT_7X13;
use embedded_graphics::pixelcolor::Rgb888;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Line, Polyline, PrimitiveStyle, Rectangle};
use embedded_graphics::text::Text;
use glam::DVec2;
use image::{Rgb, RgbImage};

use crate::explain::{Explained, Explanation};
use crate::segmentation::Class;

/// The picture is enlarged to about so many columns.
const WIDTH: u32 = 960;

/// Points on an ellipse.
const POINTS: usize = 96;

/// The colour of a class. Told apart also without red and green.
fn colour(class: Class) -> Rgb888 {
    match class {
        Class::Immobile => Rgb888::new(120, 170, 255),
        Class::Clipped => Rgb888::new(170, 170, 170),
        Class::Slow => Rgb888::new(255, 215, 60),
        Class::Fast => Rgb888::new(255, 80, 40),
    }
}

const WINDOW: Rgb888 = Rgb888::new(255, 150, 220);
const BLOCK: [u8; 3] = [190, 90, 255];

/// Draws the explanation over the frame's picture.
pub fn draw(frame: &RgbImage, explanation: &Explanation) -> RgbImage {
    let scale = (WIDTH / frame.width().max(1)).max(1);
    let mut canvas = Canvas::over(frame, scale);
    for block in &explanation.blocks {
        canvas.tint(*block, scale);
    }
    for window in &explanation.windows {
        canvas.outline(*window, scale);
    }
    // What matters most is drawn last.
    let mut objects: Vec<&Explained> = explanation.objects.iter().collect();
    objects.sort_by_key(|object| object.class);
    for object in objects {
        canvas.object(object, scale);
    }
    canvas.legend(explanation);
    canvas.picture
}

struct Canvas {
    picture: RgbImage,
    /// Rows of the frame; the legend is below.
    frame_height: u32,
}

impl OriginDimensions for Canvas {
    fn size(&self) -> embedded_graphics::prelude::Size {
        embedded_graphics::prelude::Size::new(self.picture.width(), self.picture.height())
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I>(&mut self, pixels: I) -> Result<(), Infallible>
    where
        I: IntoIterator<Item = Pixel<Rgb888>>,
    {
        for Pixel(point, colour) in pixels {
            let (Ok(x), Ok(y)) = (u32::try_from(point.x), u32::try_from(point.y)) else {
                continue;
            };
            if let Some(pixel) = self.picture.get_pixel_mut_checked(x, y) {
                *pixel = Rgb([colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}

/// Lines of the legend.
const LEGEND_ROWS: u32 = 2;
const ROW: u32 = 18;

impl Canvas {
    fn over(frame: &RgbImage, scale: u32) -> Self {
        let (width, height) = (frame.width() * scale, frame.height() * scale);
        let picture = RgbImage::from_fn(width, height + LEGEND_ROWS * ROW + 6, |x, y| {
            if y >= height {
                return Rgb([20, 20, 24]);
            }
            // Dimmed, so that the lines stand out.
            let Rgb(c) = *frame.get_pixel(x / scale, y / scale);
            Rgb(c.map(|v| (u16::from(v) * 5 / 8) as u8))
        });
        Self {
            picture,
            frame_height: height,
        }
    }

    fn tint(&mut self, block: Window, scale: u32) {
        for y in block.y * scale..block.bottom() * scale {
            for x in block.x * scale..block.right() * scale {
                let pixel = self.picture.get_pixel_mut(x, y);
                for (channel, tint) in pixel.0.iter_mut().zip(BLOCK) {
                    *channel = ((u16::from(*channel) * 3 + u16::from(tint)) / 4) as u8;
                }
            }
        }
    }

    fn outline(&mut self, window: Window, scale: u32) {
        let at = Point::new((window.x * scale) as i32, (window.y * scale) as i32);
        let size =
            embedded_graphics::prelude::Size::new(window.width * scale, window.height * scale);
        let Ok(()) = Rectangle::new(at, size)
            .into_styled(PrimitiveStyle::with_stroke(WINDOW, 1))
            .draw(self);
    }

    fn object(&mut self, object: &Explained, scale: u32) {
        let stroke = PrimitiveStyle::with_stroke(colour(object.class), 2);
        // Not into the legend.
        let frame = embedded_graphics::prelude::Size::new(self.picture.width(), self.frame_height);
        let mut canvas = self.clipped(&Rectangle::new(Point::zero(), frame));
        if let Some(outline) = &object.outline_px {
            let points: Vec<Point> = (0..=POINTS)
                .map(|k| {
                    let angle = k as f64 / POINTS as f64 * std::f64::consts::TAU;
                    point(outline.point(angle), scale)
                })
                .collect();
            let Ok(()) = Polyline::new(&points).into_styled(stroke).draw(&mut canvas);
        }
        if let Some((from, to)) = object.path_px {
            let line = Line::new(point(from, scale), point(to, scale));
            let Ok(()) = line
                .into_styled(PrimitiveStyle::with_stroke(colour(object.class), 3))
                .draw(&mut canvas);
        }
    }

    fn legend(&mut self, explanation: &Explanation) {
        let white = MonoTextStyle::new(&FONT_7X13, Rgb888::WHITE);
        let mut x = 8;
        let y = self.frame_height as i32 + ROW as i32 - 4;
        for class in Class::ALL {
            let count = explanation
                .objects
                .iter()
                .filter(|o| o.class == class)
                .count();
            let swatch = Rectangle::new(
                Point::new(x, y - 10),
                embedded_graphics::prelude::Size::new(12, 12),
            );
            let Ok(()) = swatch
                .into_styled(PrimitiveStyle::with_fill(colour(class)))
                .draw(self);
            let label = format!("{class} {count}");
            let Ok(_) = Text::new(&label, Point::new(x + 18, y), white).draw(self);
            x += 18 + 7 * label.len() as i32 + 18;
        }
        let label = format!(
            "frame {} of the period from {}; lines: motion since then; pink: rendered windows; violet: blocks of the full scene",
            explanation.frame, explanation.start
        );
        let Ok(_) = Text::new(&label, Point::new(8, y + ROW as i32), white).draw(self);
    }
}

/// A point of the frame on the canvas; far outside it stays outside.
fn point(px: DVec2, scale: u32) -> Point {
    // The drawing library squares lengths in 32 bits.
    let limit = 5e3;
    let v = (px * f64::from(scale)).clamp(DVec2::splat(-limit), DVec2::splat(limit));
    Point::new(v.x as i32, v.y as i32)
}

/// A picture of `size`, for frames that nobody rendered.
pub fn blank(size: Size) -> RgbImage {
    RgbImage::from_pixel(size.width, size.height, Rgb([90, 90, 90]))
}

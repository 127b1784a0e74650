//! FLIP, the difference that is seen when two pictures are flipped between:
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, *FLIP: A
//! Difference Evaluator for Alternating Images*, Proceedings of the ACM on
//! Computer Graphics and Interactive Techniques 3(2), HPG 2020. The form for low
//! dynamic range (LDR-FLIP), with the separated filters that its authors publish.
//!
//! Two things are compared: colour, after what the eye at this distance cannot
//! resolve is filtered out, and features (edges and points) of the lightness. The
//! second amplifies the first: error = colour^(1 − feature).

use std::f32::consts::PI;
use std::ops::Range;
use std::sync::LazyLock;

use rayon::prelude::*;

use super::filter::{Plane, TILE, parts, widened};
use super::mask::Mask;
use super::seen::Seen;

/// The evaluator's own default: a display of 3840 pixels and 0.7 m, seen from
/// 0.7 m. Pixels per degree of the visual field.
pub const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// The errors of all pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flip {
    /// Their mean, 0..1: what is quoted as *the* FLIP of two pictures.
    pub mean: f64,
    /// The largest.
    pub max: f64,
}

/// The mean and the largest error of the pixels that count; 0 where there are
/// none.
pub fn flip(seen: &Seen, mask: Option<&Mask>, pixels_per_degree: f32) -> Flip {
    let (mut sum, mut max, mut count) = (0.0_f64, 0.0_f64, 0_u64);
    for (k, &error) in map(seen, pixels_per_degree).iter().enumerate() {
        if mask.is_none_or(|mask| mask.counts(k)) {
            sum += f64::from(error);
            max = max.max(f64::from(error));
            count += 1;
        }
    }
    Flip {
        mean: sum / count.max(1) as f64,
        max,
    }
}

/// The error of every pixel, 0..1, row by row.
pub fn map(seen: &Seen, pixels_per_degree: f32) -> Vec<f32> {
    let kernels = Kernels::new(pixels_per_degree);
    let mut errors = vec![0.0; seen.width * seen.height];
    if seen.width > 0 {
        errors
            .par_chunks_mut(TILE * seen.width)
            .enumerate()
            .for_each(|(k, band)| {
                let rows = k * TILE..(k * TILE + TILE).min(seen.height);
                for columns in parts(0..seen.width) {
                    tile(seen, &columns, &rows, &kernels, band);
                }
            });
    }
    errors
}

/// Fills the tile's part of `band`, the rows of the whole picture's width; it has
/// zeros, which is what stays where nothing in reach differs.
fn tile(
    seen: &Seen,
    columns: &Range<usize>,
    rows: &Range<usize>,
    kernels: &Kernels,
    band: &mut [f32],
) {
    let margin = kernels.radius;
    if !seen.differs(
        widened(columns, margin, seen.width),
        widened(rows, margin, seen.height),
    ) {
        return;
    }
    let of = |picture: &[[f32; 3]]| Features::new(seen, picture, columns, rows, kernels);
    let (a, b) = (of(&seen.a), of(&seen.b));
    let scale = ColourScale::new();
    for (y, k) in (0..rows.len()).zip((0..).step_by(columns.len())) {
        let row = &mut band[y * seen.width + columns.start..][..columns.len()];
        for (error, k) in row.iter_mut().zip(k..) {
            let colour = scale.difference(a.lab[k], b.lab[k]);
            let edge = (a.edge[k] - b.edge[k]).abs();
            let point = (a.point[k] - b.point[k]).abs();
            let feature = (edge.max(point) / 2.0_f32.sqrt()).sqrt();
            *error = colour.powf(1.0 - feature).clamp(0.0, 1.0);
        }
    }
}

/// What is seen of one picture's tile.
struct Features {
    /// CIELAB after the eye's filter, with Hunt's adjustment.
    lab: Vec<[f32; 3]>,
    /// The lightness's gradient.
    edge: Vec<f32>,
    /// Its second derivative.
    point: Vec<f32>,
}

impl Features {
    fn new(
        seen: &Seen,
        picture: &[[f32; 3]],
        columns: &Range<usize>,
        rows: &Range<usize>,
        kernels: &Kernels,
    ) -> Self {
        // Beyond the edge, the edge's pixel goes on.
        let margin = kernels.radius;
        let inside = |k: usize, end: usize| k.saturating_sub(margin).min(end - 1);
        let (wide, high) = (
            columns.start..columns.end + 2 * margin,
            rows.start..rows.end + 2 * margin,
        );
        let planes = opponent_planes(wide, high, |x, y| {
            picture[inside(y, seen.height) * seen.width + inside(x, seen.width)]
        });
        let [luminance, red_green, blue_yellow] = &planes;
        let luminance_seen = luminance.filtered(&kernels.luminance, &kernels.luminance);
        let red_green = red_green.filtered(&kernels.red_green, &kernels.red_green);
        let [narrow, broad] = kernels
            .blue_yellow
            .each_ref()
            .map(|kernel| blue_yellow.filtered(kernel, kernel));
        let lab = (0..luminance_seen.values.len())
            .map(|k| {
                let blue_yellow = narrow.values[k] + broad.values[k];
                adapted([luminance_seen.values[k], red_green.values[k], blue_yellow])
            })
            .collect();
        let lightness = Plane {
            width: luminance.width,
            values: luminance
                .values
                .iter()
                .map(|y| (y + 16.0) / 116.0)
                .collect(),
        };
        let smooth = lightness.across(&kernels.smooth);
        let length = |derivative: &[f32]| -> Vec<f32> {
            let x = lightness.filtered(derivative, &kernels.smooth);
            let y = smooth.down(derivative);
            let pairs = x.values.iter().zip(&y.values);
            pairs.map(|(x, y)| (x * x + y * y).sqrt()).collect()
        };
        Self {
            lab,
            edge: length(&kernels.first),
            point: length(&kernels.second),
        }
    }
}

/// Luminance, red–green and blue–yellow (YCxCz) of a rectangle.
fn opponent_planes(
    columns: Range<usize>,
    rows: Range<usize>,
    colour: impl Fn(usize, usize) -> [f32; 3],
) -> [Plane<f32>; 3] {
    let mut planes = [(); 3].map(|()| Plane {
        width: columns.len(),
        values: Vec::with_capacity(columns.len() * rows.len()),
    });
    for y in rows {
        for x in columns.clone() {
            let ycxcz = opponent(xyz(colour(x, y).map(linear)));
            for (plane, value) in planes.iter_mut().zip(ycxcz) {
                plane.values.push(value);
            }
        }
    }
    planes
}

/// The filters for a distance, all of one length: the shorter ones end in zeros.
struct Kernels {
    /// From the middle to the end.
    radius: usize,
    luminance: Vec<f32>,
    red_green: Vec<f32>,
    /// The eye's filter for blue–yellow is a sum of two.
    blue_yellow: [Vec<f32>; 2],
    /// The lightness, smoothed, and its derivatives.
    smooth: Vec<f32>,
    first: Vec<f32>,
    second: Vec<f32>,
}

impl Kernels {
    /// The contrast sensitivity functions (table 1 of the paper) as Gaussians in
    /// space, and the derivatives of one as wide as an edge that is seen (0.082
    /// degrees).
    fn new(pixels_per_degree: f32) -> Self {
        const WIDEST: f32 = 0.04;
        const EDGE_DEGREES: f32 = 0.082;
        let eye = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil();
        let deviation = 0.5 * EDGE_DEGREES * pixels_per_degree;
        let features = (3.0 * deviation).ceil();
        let radius = eye.max(features) as usize;
        let over = |reach: f32, weight: &dyn Fn(f32) -> f32| -> Vec<f32> {
            (0..=2 * radius)
                .map(|k| k as f32 - radius as f32)
                .map(|x| if x.abs() <= reach { weight(x) } else { 0.0 })
                .collect()
        };
        let gaussian = |height: f32, b: f32| {
            over(eye, &move |x| {
                let degrees = x / pixels_per_degree;
                height * (-PI * PI * degrees * degrees / b).exp()
            })
        };
        // Applied twice, across and down: each has the root of the height.
        let root = |a: f32, b: f32| gaussian((a * (PI / b).sqrt()).sqrt(), b);
        let (narrow, broad) = (root(34.1, 0.04), root(13.5, 0.025));
        let sums = [&narrow, &broad].map(|kernel| kernel.iter().sum::<f32>());
        let whole = (sums[0] * sums[0] + sums[1] * sums[1]).sqrt();
        let g = move |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        let curvature = move |x: f32| (x * x / (deviation * deviation) - 1.0) * g(x);
        Self {
            radius,
            luminance: balanced(gaussian(1.0, 0.0047)),
            red_green: balanced(gaussian(1.0, 0.0053)),
            blue_yellow: [narrow, broad].map(|kernel| kernel.iter().map(|w| w / whole).collect()),
            smooth: balanced(over(features, &g)),
            first: balanced(over(features, &move |x| -x * g(x))),
            second: balanced(over(features, &curvature)),
        }
    }
}

/// Scales the positive weights to a sum of 1 and the negative ones to −1.
fn balanced(mut kernel: Vec<f32>) -> Vec<f32> {
    let above: f32 = kernel.iter().filter(|&&w| w > 0.0).sum();
    let below: f32 = kernel.iter().filter(|&&w| w < 0.0).sum();
    for weight in &mut kernel {
        if *weight > 0.0 {
            *weight /= above;
        } else if *weight < 0.0 {
            *weight /= -below;
        }
    }
    kernel
}

/// The white of sRGB (D65), as XYZ.
const WHITE: [f32; 3] = [0.950_428_55, 1.0, 1.088_900_4];

/// The inverse of sRGB's transfer function. Those of 8 bits are looked up:
/// powers are the dearest part of the whole.
fn linear(value: f32) -> f32 {
    static BYTES: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|byte| to_linear(byte as f32 / 255.0)));
    let byte = (value * 255.0).round();
    if byte / 255.0 == value {
        BYTES[byte as u8 as usize]
    } else {
        to_linear(value)
    }
}

fn to_linear(value: f32) -> f32 {
    if value <= 0.040_45 {
        value / 12.92
    } else {
        ((value + 0.055) / 1.055).powf(2.4)
    }
}

fn xyz([r, g, b]: [f32; 3]) -> [f32; 3] {
    const MATRIX: [[f32; 3]; 3] = [
        [0.412_386_56, 0.357_591_5, 0.180_450_49],
        [0.212_636_8, 0.715_183, 0.072_180_2],
        [0.019_330_62, 0.119_197_16, 0.950_372_6],
    ];
    MATRIX.map(|[x, y, z]| x * r + y * g + z * b)
}

/// Linear red, green and blue, cut to 0..1.
fn rgb([x, y, z]: [f32; 3]) -> [f32; 3] {
    const MATRIX: [[f32; 3]; 3] = [
        [3.241_003_3, -1.537_398_9, -0.498_615_86],
        [-0.969_224_33, 1.875_930_1, 0.041_554_224],
        [0.055_639_423, -0.204_011_2, 1.057_148_9],
    ];
    MATRIX.map(|[r, g, b]| (r * x + g * y + b * z).clamp(0.0, 1.0))
}

/// YCxCz: CIELAB without its cube roots, so that it may be filtered.
fn opponent(xyz: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [0, 1, 2].map(|k| xyz[k] / WHITE[k]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponent([y, cx, cz]: [f32; 3]) -> [f32; 3] {
    let y = (y + 16.0) / 116.0;
    [
        (y + cx / 500.0) * WHITE[0],
        y * WHITE[1],
        (y - cz / 200.0) * WHITE[2],
    ]
}

fn lab(xyz: [f32; 3]) -> [f32; 3] {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = [0, 1, 2].map(|k| {
        let value = xyz[k] / WHITE[k];
        if value > DELTA * DELTA * DELTA {
            value.cbrt()
        } else {
            value / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Hunt's effect: colours are seen less where it is dark.
fn hunt([l, a, b]: [f32; 3]) -> [f32; 3] {
    [l, 0.01 * l * a, 0.01 * l * b]
}

/// A filtered YCxCz as it is perceived.
fn adapted(ycxcz: [f32; 3]) -> [f32; 3] {
    hunt(lab(xyz(rgb(from_opponent(ycxcz)))))
}

/// The distance of two colours for large differences: lightness by itself, then
/// the rest.
fn hyab(a: [f32; 3], b: [f32; 3]) -> f32 {
    (a[0] - b[0]).abs() + ((a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
}

/// How a distance of colours becomes an error of 0..1.
struct ColourScale {
    /// The greatest distance, of green and blue, after the exponent.
    greatest: f32,
}

impl ColourScale {
    const EXPONENT: f32 = 0.7;
    /// This part of the distances gets …
    const USUAL: f32 = 0.4;
    /// … this part of the errors: all else is compressed.
    const USUAL_ERROR: f32 = 0.95;

    fn new() -> Self {
        let [green, blue] = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|rgb| hunt(lab(xyz(rgb))));
        Self {
            greatest: hyab(green, blue).powf(Self::EXPONENT),
        }
    }

    fn difference(&self, a: [f32; 3], b: [f32; 3]) -> f32 {
        let distance = hyab(a, b).powf(Self::EXPONENT);
        let usual = Self::USUAL * self.greatest;
        if distance < usual {
            distance * Self::USUAL_ERROR / usual
        } else {
            let beyond = (distance - usual) / (self.greatest - usual);
            Self::USUAL_ERROR + beyond * (1.0 - Self::USUAL_ERROR)
        }
    }
}

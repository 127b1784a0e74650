//! What decor's own work costs per pixel: merging, encoding, writing, on pixels
//! that the probe has rendered.

use std::path::Path;

use decor_api::{Layer, PictureFormat, Size, Window};
use nix::time::ClockId;

use super::sample::{BLOCK, Measured, Question, cpu_s};
use crate::dissolve::Backdrop;
use crate::frames::{Encoder, Ground};
use crate::merge::merge;
use crate::plan::{Costs, Pass};
use crate::stage::Stage;

/// Seconds per pixel; `None` where there was nothing to try it on.
#[derive(Clone, Copy, Debug, Default)]
pub struct CoreCosts {
    merge: Option<f64>,
    encode: Option<f64>,
    write: Option<f64>,
}

impl CoreCosts {
    /// Takes the place of what is built in.
    pub fn put_into(self, costs: &mut Costs) {
        let set = |cost: &mut f64, measured: Option<f64>| *cost = measured.unwrap_or(*cost);
        set(&mut costs.merge_pixel_s, self.merge);
        set(&mut costs.encode_pixel_s, self.encode);
        set(&mut costs.write_pixel_s, self.write);
    }
}

/// Measures them on one thread; gives the seconds that it took as well.
pub fn measure(stage: &Stage, samples: &[Measured]) -> (CoreCosts, f64) {
    let Some(layer) = picture(samples) else {
        return (CoreCosts::default(), 0.0);
    };
    // A pool of one: the time of its thread is the time of the work.
    let Ok(pool) = rayon::ThreadPoolBuilder::new().num_threads(1).build() else {
        return (CoreCosts::default(), 0.0);
    };
    pool.install(|| {
        let before = cpu_s(ClockId::CLOCK_THREAD_CPUTIME_ID);
        let costs = of_layer(stage, &layer);
        (costs, cpu_s(ClockId::CLOCK_THREAD_CPUTIME_ID) - before)
    })
}

fn of_layer(stage: &Stage, layer: &Layer) -> CoreCosts {
    let size = Size {
        width: layer.window.width,
        height: layer.window.height,
    };
    let encoder = Encoder {
        adapter: &*stage.adapter,
        format: PictureFormat::Png,
    };
    let pixels = size.pixels() as f64;
    let ground = Ground::decor(layer, None, size, &encoder);
    CoreCosts {
        merge: Some(per_pixel(pixels, || {
            std::hint::black_box(merge(Backdrop::plain(layer), layer, layer, false));
        })),
        encode: Some(per_pixel(pixels, || {
            std::hint::black_box(Ground::decor(layer, None, size, &encoder));
        })),
        write: Some(per_pixel(pixels, || {
            let file = encoder.file(&ground, None, &[], Path::new("probe"));
            let _ = std::hint::black_box(file);
        })),
    }
}

/// The least time of a few tries: what disturbs only adds.
fn per_pixel(pixels: f64, mut work: impl FnMut()) -> f64 {
    const TRIES: usize = 4;
    let times = (0..TRIES).map(|_| {
        let before = cpu_s(ClockId::CLOCK_THREAD_CPUTIME_ID);
        work();
        cpu_s(ClockId::CLOCK_THREAD_CPUTIME_ID) - before
    });
    times.fold(f64::INFINITY, f64::min) / pixels
}

/// Rendered colours of the full scene as a picture, with some depth.
fn picture(samples: &[Measured]) -> Option<Layer> {
    let of = Question::Pixels(Pass::Whole);
    let those = samples.iter().filter(|m| m.sample.question == of);
    let mut pictures = those.filter_map(|m| Some((m.picture.as_ref()?, m.sample.blocks())));
    let (layer, blocks) = pictures.next()?;
    let all = layer.colour.as_ref()?;
    let (width, colour) = if blocks.is_empty() {
        (layer.window.width, all.clone())
    } else {
        // One below the other: between them there is nothing.
        let whole = blocks
            .into_iter()
            .filter(|b| b.width == BLOCK && b.height == BLOCK);
        let rows = whole.flat_map(|b| (b.y..b.bottom()).map(move |y| (b.x, y)));
        let pixels = rows.flat_map(|(x, y)| {
            let from = layer.index(x, y);
            all[from..from + BLOCK as usize].iter().copied()
        });
        (BLOCK, pixels.collect())
    };
    let rows = colour.len().checked_div(width as usize)?;
    (rows > 0).then(|| Layer {
        window: Window {
            x: 0,
            y: 0,
            width,
            height: rows as u32,
        },
        depth: Some(vec![1.0; colour.len()]),
        colour: Some(colour),
        depth_quantum: (0.0, 0.0),
    })
}

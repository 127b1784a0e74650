//! What decor itself costs, by pixel: reading what the renderer wrote, merging,
//! dissolving, encoding; and planning, by film. Beside it the machine's memory
//! bandwidth, by a copy: nothing that reads and writes so many bytes is faster.
//!
//! Time is the CPU's, of all threads: another program on the machine does not
//! count.
//!
//! One frame of 1024 by 1024 pixels is 1.05 megapixels: at 20 ms a frame all that
//! it needs may cost 19 ns a pixel.

use std::hint::black_box;
use std::io::Cursor;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use criterion::measurement::{Measurement, ValueFormatter, WallTime};
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use decor::dissolve::{Backdrop, Dissolve};
use decor::film;
use decor::frames::{Encoder, Ground};
use decor::merge::{Patch, merge, merge_onto};
use decor::objects::Cache;
use decor::plan::{Costs, Mode, ShadowWay, Wishes, plan};
use decor::segmentation::Measure;
use decor::stage::Stage;
use decor_api::{Layer, PictureFormat, RunContext, Size, Window};
use decor_povray::PovRay;
use decor_povray::picture::{self, Coding};
use decor_povray::state::{self, Wanted};

/// The CPU time of this process, where it can be told.
struct CpuTime;

impl Measurement for CpuTime {
    type Intermediate = Duration;
    type Value = Duration;

    fn start(&self) -> Duration {
        let clock = nix::time::ClockId::CLOCK_PROCESS_CPUTIME_ID;
        nix::time::clock_gettime(clock).map_or(Duration::ZERO, Duration::from)
    }

    fn end(&self, begun: Duration) -> Duration {
        self.start().saturating_sub(begun)
    }

    fn add(&self, one: &Duration, other: &Duration) -> Duration {
        *one + *other
    }

    fn zero(&self) -> Duration {
        Duration::ZERO
    }

    fn to_f64(&self, value: &Duration) -> f64 {
        value.as_nanos() as f64
    }

    fn formatter(&self) -> &dyn ValueFormatter {
        WallTime.formatter()
    }
}

const SIDE: u32 = 1024;
const SIZE: Size = Size {
    width: SIDE,
    height: SIDE,
};

/// A picture with slopes, edges and grain: pixel (x, y).
fn colour(x: u32, y: u32) -> [f32; 4] {
    let (u, v) = (x as f32 / SIDE as f32, y as f32 / SIDE as f32);
    let tile = if (x / 64 + y / 48).is_multiple_of(2) {
        0.2
    } else {
        0.6
    };
    let grain = (x.wrapping_mul(2_654_435_761) ^ y.wrapping_mul(40_503)) >> 30;
    let grain = grain as f32 * 1e-3;
    [tile * u + grain, 0.7 * v + grain, 0.5 * u * v + 0.1, 1.0]
}

/// The décor: a floor that goes away from the observer.
fn decor() -> Layer {
    let pixels = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    Layer {
        window: SIZE.window(),
        colour: Some(pixels().map(|(x, y)| colour(x, y)).collect()),
        depth: Some(pixels().map(|(_, y)| 1e4 / f64::from(y + 10)).collect()),
        depth_quantum: (0.0, 1e-7),
    }
}

/// A ball in a window of its own size: π/4 of its pixels, with a soft edge.
fn ball(window: Window) -> Layer {
    let radius = f64::from(window.width) / 2.0;
    let pixels = || (0..window.height).flat_map(|y| (0..window.width).map(move |x| (x, y)));
    let from_centre = |x: u32, y: u32| {
        let (dx, dy) = (f64::from(x) + 0.5 - radius, f64::from(y) + 0.5 - radius);
        dx.hypot(dy)
    };
    let shade = |(x, y)| {
        let coverage = (radius - from_centre(x, y)).clamp(0.0, 1.0) as f32;
        [0.9 * coverage, 0.3 * coverage, 0.1 * coverage, coverage]
    };
    let distance = |(x, y)| {
        let inside = from_centre(x, y) < radius;
        if inside { 12.0 } else { f64::INFINITY }
    };
    Layer {
        window,
        colour: Some(pixels().map(shade).collect()),
        depth: Some(pixels().map(distance).collect()),
        depth_quantum: (0.0, 1e-7),
    }
}

fn window(side: u32) -> Window {
    Window {
        x: (SIDE - side) / 2,
        y: (SIDE - side) / 2,
        width: side,
        height: side,
    }
}

/// What a décor has become where one pixel in eight has changed.
fn target(decor: &Layer) -> Layer {
    let mut target = decor.clone();
    for pixel in target.colour.iter_mut().flatten().step_by(8) {
        pixel[0] += 0.01;
    }
    target
}

/// A 16-bit PPM, as POV-Ray writes it.
fn ppm() -> Vec<u8> {
    let mut file = format!("P6\n{SIDE} {SIDE}\n65535\n").into_bytes();
    for y in 0..SIDE {
        for x in 0..SIDE {
            for channel in &colour(x, y)[..3] {
                file.extend(((channel * 65535.0) as u16).to_be_bytes());
            }
        }
    }
    file
}

/// A state file, as POV-Ray writes it: a record for each block of 32 by 32.
fn state_file() -> Vec<u8> {
    let mut file = state::empty();
    for id in 0..(SIDE / 32).pow(2) {
        let place = decor_api::block_window(id, decor_api::BLOCK, SIZE);
        let mut record = b"OBJE".to_vec();
        record.extend(6_u32.to_be_bytes());
        let mut attribute = |key: &[u8; 4], kind: &[u8; 4], length: u32, value: &[u8]| {
            record.extend([&key[..], kind, &length.to_be_bytes(), value].concat());
        };
        let numbers: Vec<u8> = (place.y..place.bottom())
            .flat_map(|y| (place.x..place.right()).map(move |x| colour(x, y)))
            .flat_map(|[r, g, b, _]| [r, g, b, 0.0, 0.0])
            .flat_map(f32::to_be_bytes)
            .collect();
        attribute(b"PBlo", b"VFL4", numbers.len() as u32 / 4, &numbers);
        for (key, value) in [
            (b"PiId", id),
            (b"Left", place.x),
            (b"Top ", place.y),
            (b"Righ", place.right() - 1),
            (b"Bott", place.bottom() - 1),
        ] {
            attribute(key, b"INT4", 4, &value.to_be_bytes());
        }
        file.extend_from_slice(b"POVRAYMS");
        for number in [0x370, record.len() as u32] {
            file.extend(u32::to_be_bytes(number));
        }
        file.extend_from_slice(b"RAWS");
        file.extend(record);
    }
    file
}

fn by_pixel(criterion: &mut Criterion<CpuTime>) {
    let adapter = PovRay::new("povray".into(), "3.7.0.10");
    let decor = decor();
    let per_picture = SIZE.pixels() as u64;
    let mut group = criterion.benchmark_group("core");
    group
        .sample_size(20)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));

    // 32 MiB: more than a cache holds.
    let source = vec![1_u8; 32 << 20];
    let mut copy = source.clone();
    group.throughput(Throughput::Bytes(source.len() as u64));
    group.bench_function("copy of 32 MiB", |b| {
        b.iter(|| copy.copy_from_slice(black_box(&source)));
    });

    group.throughput(Throughput::Elements(per_picture));
    let file = ppm();
    group.bench_function("read P6", |b| {
        b.iter(|| picture::pixels(black_box(&file), SIZE.window(), Coding::Linear));
    });
    group.bench_function("read P6, sRGB", |b| {
        b.iter(|| picture::pixels(black_box(&file), SIZE.window(), Coding::Srgb));
    });
    let file = state_file();
    group.bench_function("read state", |b| {
        let read = |file: &[u8]| state::pixels(Cursor::new(file), SIZE.window(), Wanted::All);
        b.iter(|| read(black_box(&file)));
    });

    merging(&mut group, &decor, &adapter);

    group.throughput(Throughput::Elements(per_picture));
    let target = Arc::new(target(&decor));
    let colours = |layer: &Layer| layer.colour.clone().unwrap_or_default();
    let (before, after) = (colours(&decor), colours(&target));
    let differs = |i: usize| before[i] != after[i];
    group.bench_function("dissolve: begin", |b| {
        b.iter(|| Dissolve::between(&decor, Arc::clone(&target), differs, 25, 7));
    });
    let dissolve = Dissolve::between(&decor, target, differs, 25, 7);

    for format in [PictureFormat::Png, PictureFormat::Png16] {
        let encoder = Encoder {
            adapter: &adapter,
            format,
        };
        let name = format!("{format:?}");
        group.bench_function(format!("{name}: décor, encoded"), |b| {
            b.iter(|| Ground::decor(&decor, None, SIZE, &encoder));
        });
        let ground = Ground::decor(&decor, Some(&dissolve), SIZE, &encoder);
        let at = Path::new("frame.png");
        group.bench_function(format!("{name}: frame, as before"), |b| {
            b.iter(|| encoder.file(&ground, None, &[], at));
        });
        // Another picture than before: the same is not encoded again.
        let mut turn = 0;
        let mut half = || {
            turn = 1 - turn;
            Some((&dissolve, dissolve.total() / 2 + turn))
        };
        group.bench_function(format!("{name}: frame, dissolved"), |b| {
            b.iter(|| encoder.file(&ground, half(), &[], at));
        });
        let whole = || Patch {
            window: SIZE.window(),
            colour: decor.colour.clone().unwrap_or_default(),
            depth: None,
        };
        let (one, mut other) = (whole(), whole());
        other.colour[0][0] += 0.1;
        let empty = Ground::empty(SIZE, &encoder);
        let pair = [[one], [other]];
        let mut turn = 0;
        group.bench_function(format!("{name}: frame, whole"), |b| {
            b.iter(|| {
                turn = 1 - turn;
                encoder.file(&empty, None, &pair[turn], at)
            });
        });
        // A fast object on a sixteenth of the picture.
        let fast = ball(window(SIDE / 4));
        group.bench_function(format!("{name}: frame, dissolved, merged"), |b| {
            b.iter(|| {
                let dissolve = half();
                let backdrop = Backdrop {
                    dissolve,
                    ..Backdrop::plain(&decor)
                };
                let mut canvas = encoder.canvas(&ground, dissolve);
                merge_onto(backdrop, &fast, &fast, true, false, |run| {
                    canvas.lay_row(run.x, run.y, run.colour, run.depth);
                });
                encoder.finish(canvas, at)
            });
        });
    }
    group.finish();
}

/// The merge by itself, into the linear pixels of the décor's copy, and onto a
/// frame in the numbers of its file, as `render` does it.
fn merging(group: &mut BenchmarkGroup<'_, CpuTime>, decor: &Layer, adapter: &PovRay) {
    let encoder = Encoder {
        adapter,
        format: PictureFormat::Png,
    };
    let ground = Ground::decor(decor, None, SIZE, &encoder);
    let mut canvas = encoder.canvas(&ground, None);
    let mut copy = decor.colour.clone().unwrap_or_default();
    for side in [SIDE, SIDE / 4] {
        let fast = ball(window(side));
        group.throughput(Throughput::Elements(u64::from(side).pow(2)));
        for (antialiased, name) in [(false, "merge"), (true, "merge, antialiased")] {
            let backdrop = Backdrop::plain(decor);
            group.bench_function(format!("{name}, {side}²"), |b| {
                b.iter(|| {
                    merge_onto(backdrop, &fast, &fast, antialiased, false, |run| {
                        let from = decor.index(run.x, run.y);
                        copy[from..from + run.colour.len()].copy_from_slice(run.colour);
                    });
                });
            });
            group.bench_function(format!("{name}, {side}², encoded"), |b| {
                b.iter(|| {
                    merge_onto(backdrop, &fast, &fast, antialiased, false, |run| {
                        canvas.lay_row(run.x, run.y, run.colour, run.depth);
                    });
                });
            });
            group.bench_function(format!("{name}, {side}², a patch"), |b| {
                b.iter(|| merge(backdrop, &fast, &fast, antialiased));
            });
        }
    }
}

fn planning(criterion: &mut Criterion<CpuTime>) {
    let work = tempfile::tempdir().expect("a folder");
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/ladybirds/ladybirds.anim");
    let film = film::read(&path, false).expect("a bundled film");
    let adapter = decor::renderers::find("reference").expect("it is always there");
    let run = RunContext::new(work.path());
    let stage = Stage::set(film, adapter, false, &Cache::disabled(), &run).expect("a bundled film");
    let wishes = Wishes {
        mode: Mode::Equivalent,
        threshold_px: 1.0,
        measure: Measure::Bound,
        period: None,
        budget: None,
        shadow_way: ShadowWay::Auto,
        frames: (0, 24),
        with_depth: false,
        fallback: false,
    };
    let mut group = criterion.benchmark_group("core");
    group
        .sample_size(10)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(2));
    group.throughput(Throughput::Elements(25));
    group.bench_function("plan, 25 frames of 100 objects", |b| {
        b.iter(|| plan(&stage, black_box(wishes.clone()), &Costs::default()));
    });
    group.finish();
}

criterion_group! {
    name = benches;
    config = Criterion::default().with_measurement(CpuTime);
    targets = by_pixel, planning
}
criterion_main!(benches);

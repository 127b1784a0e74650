//! What the influence of a frame costs, on one core: a megapixel, two lights,
//! one fast object and a flock of them.
//!
//! `cargo bench --bench influence`.

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use decor::influence::{Changed, Depths, Influence, Still, influence};
use decor_api::{Bounds, Camera, Layer, Light, LightKind, Rgb, Size};
use glam::DVec3;

const SIZE: Size = Size {
    width: 1152,
    height: 912,
};

/// The distance of a wavy floor; +∞ above the horizon.
fn floor(camera: &Camera) -> Layer {
    let depth = (0..SIZE.pixels()).map(|i| {
        let (x, y) = (i as u32 % SIZE.width, i as u32 / SIZE.width);
        let ray = camera.direction(SIZE, f64::from(x) + 0.5, f64::from(y) + 0.5);
        let ray = ray.normalize();
        let distance = -camera.eye.y / ray.y;
        let at = camera.eye + ray * distance;
        if distance > 0.0 && distance < 200.0 {
            distance * (1.0 - 0.02 * (at.x.sin() + at.z.sin()).abs())
        } else {
            f64::INFINITY
        }
    });
    Layer {
        window: SIZE.window(),
        colour: None,
        depth: Some(depth.collect()),
        depth_quantum: (1e-7, 0.0),
    }
}

fn lights() -> Vec<Light> {
    let light = |position: DVec3, kind| Light {
        position,
        colour: Rgb([1.0; 3]),
        kind,
        fade: None,
    };
    let towards = DVec3::ZERO;
    vec![
        light(DVec3::new(-20.0, 30.0, -10.0), LightKind::Point),
        light(DVec3::new(30.0, 50.0, 10.0), LightKind::Sun { towards }),
    ]
}

fn frame(criterion: &mut Criterion) {
    let eye = DVec3::new(0.0, 8.0, -25.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, (60.0, 49.0)).expect("a camera");
    let (layer, lights) = (floor(&camera), lights());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let pool = pool.expect("a thread");
    let mut group = criterion.benchmark_group("influence");
    group.throughput(Throughput::Elements(SIZE.pixels() as u64));
    for (objects, antialiased) in [(1, false), (1, true), (100, false), (100, true)] {
        let still = Still {
            camera: &camera,
            size: SIZE,
            lights: &lights,
            shadows: true,
            antialiased,
            by_blocks: None,
            depths: Depths::at_centres(&layer),
            optical: &[],
            slender: &[],
        };
        let changed: Vec<Changed> = (0..objects)
            .map(|k| {
                let turn = f64::from(k) * 2.4;
                let place = DVec3::new(turn.sin(), 0.0, turn.cos()) * f64::from(k).sqrt();
                let radius = if objects == 1 { 2.0 } else { 0.4 };
                Bounds::sphere(place + DVec3::Y * 4.0, radius).into()
            })
            .collect();
        let run = || match influence(&still, &changed, None) {
            Influence::Confined(mask) => mask.count(),
            Influence::Everything(_) => SIZE.pixels(),
        };
        println!("{objects} objects: {} of {} pixels", run(), SIZE.pixels());
        let name = if antialiased { "antialiased" } else { "plain" };
        group.bench_function(BenchmarkId::new(name, objects), |bencher| {
            bencher.iter(|| pool.install(|| black_box(run())));
        });
    }
    group.finish();
}

criterion_group!(benches, frame);
criterion_main!(benches);

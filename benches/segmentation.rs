//! The whole segmentation, from poses to classes with reasons, on one core: how
//! many objects a second, and whether the cost is linear in their number.

use std::hint::black_box;
use std::path::Path;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use decor::film::{DescriptionId, FrameState, Motion, ObjectId, ObjectState};
use decor::segmentation::{Measure, Rule, segment};
use decor_api::{Bounds, Camera, Pose, Rgb, Size};
use glam::DVec3;

/// A number in [0, 1) for an index: the same cloud in every run.
fn random(seed: u64) -> f64 {
    let mut z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// A frame of a cloud that an observer flies into; half of the objects move.
fn frame(count: usize, number: u32) -> FrameState<'static> {
    let n = f64::from(number);
    let eye = DVec3::new(0.0, 0.0, -400.0 + n);
    let camera = Camera::look_at(eye, eye + DVec3::Z, DVec3::Y, (60.0, 60.0)).expect("a camera");
    let objects = (0..count as u64)
        .map(|k| {
            let at = |axis: u64| random(4 * k + axis) - 0.5;
            let speed = if k % 2 == 0 { 0.0 } else { 0.1 };
            ObjectState {
                id: ObjectId(k as u32),
                name: "",
                description: DescriptionId(0),
                path: Path::new("ball"),
                pose: Pose {
                    position: DVec3::new(600.0 * at(0) + speed * n, 600.0 * at(1), 600.0 * at(2)),
                    angles_deg: DVec3::new(0.0, 360.0 * at(3) + speed * n, 0.0),
                },
                motion: Motion::default(),
            }
        })
        .collect();
    FrameState {
        number,
        camera,
        eye_velocity: DVec3::Z,
        aim: eye + DVec3::Z,
        aim_velocity: DVec3::Z,
        lights: &[],
        shadows: false,
        background: Rgb::default(),
        antialias: None,
        sky: None,
        objects,
    }
}

fn benchmark(criterion: &mut Criterion) {
    let one = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool");
    let size = Size {
        width: 1024,
        height: 1024,
    };
    for measure in [Measure::Bound, Measure::Thesis] {
        let mut group = criterion.benchmark_group(format!("segmentation by {measure:?}"));
        group.sample_size(10);
        for count in [1_000, 10_000, 100_000, 1_000_000] {
            let frames = [frame(count, 0), frame(count, 5)];
            let rule = Rule {
                threshold_px: 1.0,
                measure,
                size,
            };
            let bounds = Bounds::sphere(DVec3::ZERO, 5.0);
            group.throughput(Throughput::Elements(count as u64));
            group.bench_with_input(BenchmarkId::from_parameter(count), &frames, |b, frames| {
                b.iter(|| one.install(|| black_box(segment(frames, |_| bounds, &rule))));
            });
        }
        group.finish();
    }
}

criterion_group!(benches, benchmark);
criterion_main!(benches);

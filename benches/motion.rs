//! What measuring costs: the bound beside the thesis's measure, from 10³ to 10⁶
//! objects on one core, and the tests for clipping (the thesis's appendix B:
//! trigonometric against algebraic).
//!
//! `cargo bench --bench motion`; the plots are in `target/criterion/report`.
//! The thesis (II-6): 100 000 objects in 5.45 s, 18 000 a second.

use criterion::{
    AxisScale, BenchmarkId, Criterion, PlotConfiguration, Throughput, criterion_group,
    criterion_main,
};
use decor::motion::clip::Frustum;
use decor::motion::thesis_clip::{excluded_by_angles, excluded_by_cone, thesis_clip};
use decor::motion::{
    Lenses, ObserverMotion, Sighting, bound_px, bounds_px, first_in_view, project_sphere, thesis_px,
};
use decor_api::{Camera, Pose, Size, Sphere};
use glam::DVec3;
use std::hint::black_box;

const SIZE: Size = Size {
    width: 1920,
    height: 1080,
};

type Object = (Pose, Pose, Sphere);

/// Random numbers (SplitMix64): the same on every machine.
struct Random(u64);

impl Random {
    fn range(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        from + (to - from) * (((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn vector(&mut self, size: f64) -> DVec3 {
        DVec3::new(
            self.range(-size, size),
            self.range(-size, size),
            self.range(-size, size),
        )
    }
}

/// Objects in front of the observer. Moving: every one goes and turns, about a
/// centre that is not its origin; else they stand, and only the observer moves.
fn objects(count: usize, moving: bool) -> Vec<Object> {
    let mut random = Random(42);
    (0..count)
        .map(|_| {
            let z = random.range(5.0, 50.0);
            let position = DVec3::new(random.range(-z, z) * 0.5, random.range(-z, z) * 0.3, z);
            let a = Pose {
                position,
                angles_deg: random.vector(180.0),
            };
            let b = Pose {
                position: position + random.vector(0.05),
                angles_deg: a.angles_deg + random.vector(2.0),
            };
            let centre = random.vector(0.2);
            let sphere = Sphere {
                centre,
                radius: random.range(0.01, 1.0),
            };
            (a, if moving { b } else { a }, sphere)
        })
        .collect()
}

fn cameras() -> (Camera, Camera) {
    let look = |eye: DVec3, aim: DVec3| {
        Camera::look_at(eye, aim, DVec3::Y, (60.0, 36.0)).expect("a camera")
    };
    (
        look(DVec3::ZERO, DVec3::Z),
        look(DVec3::new(0.01, 0.0, 0.05), DVec3::new(0.02, 0.0, 1.05)),
    )
}

fn on_one_core<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(1)
        .build()
        .expect("a pool");
    pool.install(work)
}

fn measures(c: &mut Criterion) {
    let (before, after) = cameras();
    let observer = ObserverMotion::between(&before, &after);
    let lenses = Lenses::between(&before, &after, SIZE);
    let mut group = c.benchmark_group("measure");
    group.plot_config(PlotConfiguration::default().summary_scale(AxisScale::Logarithmic));
    group.sample_size(10);
    for count in [1_000, 10_000, 100_000, 1_000_000] {
        group.throughput(Throughput::Elements(count as u64));
        for (name, moving) in [
            ("bound, objects move", true),
            ("bound, observer moves", false),
        ] {
            let table = objects(count, moving);
            let mut out = vec![0.0; count];
            group.bench_function(BenchmarkId::new(name, count), |b| {
                on_one_core(|| {
                    b.iter(|| bounds_px(&observer, &lenses, |i| table[i], black_box(&mut out)));
                });
            });
        }
        if count <= 100_000 {
            let table = objects(count, true);
            group.bench_function(BenchmarkId::new("thesis, objects move", count), |b| {
                b.iter(|| {
                    table
                        .iter()
                        .map(|(p, q, sphere)| thesis_px(&observer.of(p, q, sphere), &lenses))
                        .sum::<f64>()
                });
            });
        }
    }
    group.finish();
}

fn steps(c: &mut Criterion) {
    let (before, after) = cameras();
    let observer = ObserverMotion::between(&before, &after);
    let lenses = Lenses::between(&before, &after, SIZE);
    let table = objects(1000, true);
    let motions: Vec<_> = table.iter().map(|(p, q, s)| observer.of(p, q, s)).collect();
    let mut group = c.benchmark_group("one step, 1000 objects");
    group.throughput(Throughput::Elements(1000));
    group.bench_function("relative motion", |b| {
        b.iter(|| {
            table
                .iter()
                .map(|(p, q, s)| observer.of(p, q, s).delta.x)
                .sum::<f64>()
        });
    });
    group.bench_function("bound", |b| {
        b.iter(|| motions.iter().map(|m| bound_px(m, &lenses)).sum::<f64>());
    });
    group.bench_function("thesis", |b| {
        b.iter(|| motions.iter().map(|m| thesis_px(m, &lenses)).sum::<f64>());
    });
    group.bench_function("ellipse", |b| {
        b.iter(|| {
            motions
                .iter()
                .filter_map(|m| project_sphere(m.centre_before, m.radius).ellipse().copied())
                .map(|e| e.semi_major)
                .sum::<f64>()
        });
    });
    group.bench_function("first in view, 2 frames", |b| {
        b.iter(|| {
            table
                .iter()
                .filter(|(p, q, sphere)| {
                    let frames = [(before, *p), (after, *q)];
                    let frames = frames.map(|(camera, pose)| Sighting { camera, pose });
                    first_in_view(frames, sphere, SIZE).is_some()
                })
                .count()
        });
    });
    group.finish();
}

/// Appendix B: is a sphere out of the cone, by angles or without.
fn clipping(c: &mut Criterion) {
    let frustum = Frustum::of(&cameras().0, SIZE, 0.0);
    let mut random = Random(7);
    let spheres: Vec<(DVec3, f64)> = (0..1000)
        .map(|_| (random.vector(20.0), random.range(0.01, 2.0)))
        .collect();
    let mut group = c.benchmark_group("clipping, 1000 spheres");
    group.throughput(Throughput::Elements(1000));
    let mut test = |name: &str, excluded: &dyn Fn(DVec3, f64) -> bool| {
        group.bench_function(name, |b| {
            b.iter(|| {
                spheres
                    .iter()
                    .filter(|(centre, r)| excluded(*centre, *r))
                    .count()
            });
        });
    };
    test("trigonometric: three angles", &|c, r| {
        excluded_by_angles(black_box(&frustum), c, r)
    });
    test("algebraic: the thesis's tangent", &|c, r| {
        thesis_clip(black_box(&frustum), c, r)
    });
    test("algebraic: the cone's cosine", &|c, r| {
        excluded_by_cone(black_box(&frustum), c, r)
    });
    test("algebraic: the frustum's planes", &|c, r| {
        black_box(&frustum).excludes(c, r)
    });
    test("algebraic: a sweep along the planes", &|c, r| {
        black_box(&frustum).excludes_sweep(c, c + DVec3::X, r)
    });
    group.finish();
}

criterion_group!(benches, measures, steps, clipping);
criterion_main!(benches);

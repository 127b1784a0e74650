//! The bound against the truth: no point of the sphere moves farther, and few
//! bounds are much larger than they need to be. The thesis's measure beside it.

mod motion_truth;

use decor::motion::{Lenses, RelativeMotion, bound_px, thesis_px};
use glam::{DVec2, DVec3};
use motion_truth::{Case, Random, case, displacement_px, exact_px, farthest, quantile};
use rayon::prelude::*;

/// How many motions the bound has to hold for.
const MOTIONS: u64 = 1_000_000;

#[derive(Default)]
struct Count {
    under: u64,
    decided: u64,
    thesis_under: u64,
    thesis_by_1_percent: u64,
    thesis_measured: u64,
}

impl Count {
    fn and(self, o: Self) -> Self {
        Self {
            under: self.under + o.under,
            decided: self.decided + o.decided,
            thesis_under: self.thesis_under + o.thesis_under,
            thesis_by_1_percent: self.thesis_by_1_percent + o.thesis_by_1_percent,
            thesis_measured: self.thesis_measured + o.thesis_measured,
        }
    }
}

#[test]
fn no_point_moves_farther_than_the_bound() {
    let count = (0..MOTIONS / 1000)
        .into_par_iter()
        .map(|batch| {
            let mut random = Random(batch * 7919 + 1);
            let mut count = Count::default();
            for i in 0..1000 {
                let Case {
                    kind,
                    motion,
                    lenses,
                    ..
                } = case(&mut random);
                let bound = bound_px(&motion, &lenses);
                assert!(!bound.is_nan());
                let (moved, u) = farthest(&motion, &lenses, 0, 24, &mut random);
                // Near the bound, or below what f64 can tell: 106 bits decide.
                if moved > bound * (1.0 - 1e-6) {
                    count.decided += 1;
                    let exact = exact_px(&motion, &lenses, u);
                    if exact > bound {
                        println!("{kind}: {exact:e} > {bound:e}: {motion:?} {lenses:?} {u}");
                        count.under += 1;
                    }
                }
                // The thesis's measure costs more: it looks at one in twenty.
                if i % 20 == 0 {
                    let thesis = thesis_px(&motion, &lenses);
                    count.thesis_measured += 1;
                    count.thesis_under += u64::from(moved > thesis * (1.0 + 1e-9) + 1e-9);
                    count.thesis_by_1_percent += u64::from(moved > thesis * 1.01 + 1e-9);
                }
            }
            count
        })
        .reduce(Count::default, Count::and);
    println!(
        "bound: {} under-estimates in {MOTIONS} motions ({} decided in 106 bits)",
        count.under, count.decided
    );
    println!(
        "thesis: {} under-estimates in {} motions, {} of them by more than 1 %",
        count.thesis_under, count.thesis_measured, count.thesis_by_1_percent
    );
    assert_eq!(count.under, 0);
    assert!(count.thesis_under > 0, "the thesis's measure is no bound");
}

/// A motion with how much too large both measures are.
struct Found {
    ratio: f64,
    kind: &'static str,
    bound: f64,
    thesis: f64,
}

#[test]
fn the_bound_is_seldom_much_too_large() {
    let found: Vec<Found> = (0..200u64)
        .into_par_iter()
        .flat_map_iter(|batch| {
            let mut random = Random(batch * 104_729 + 5);
            (0..100)
                .map(|_| {
                    let Case {
                        kind,
                        motion,
                        lenses,
                        ratio,
                    } = case(&mut random);
                    let (bound, thesis) = (bound_px(&motion, &lenses), thesis_px(&motion, &lenses));
                    let (moved, u) = farthest(&motion, &lenses, 2000, 200, &mut random);
                    let moved = if moved < 1e-6 {
                        exact_px(&motion, &lenses, u)
                    } else {
                        moved
                    };
                    Found {
                        ratio,
                        kind,
                        bound: bound / moved,
                        thesis: thesis / moved,
                    }
                })
                .collect::<Vec<_>>()
        })
        .collect();
    println!("measure / the truth: median, 90 %, 99 %");
    let report = |name: &str, keep: &dyn Fn(&Found) -> bool| {
        let part = || found.iter().filter(|f| keep(f));
        let sorted = |mut v: Vec<f64>| {
            v.sort_by(f64::total_cmp);
            v
        };
        let bound = sorted(part().map(|f| f.bound).collect());
        let thesis = sorted(part().map(|f| f.thesis).collect());
        let q = |v: &[f64]| [0.5, 0.9, 0.99].map(|p| quantile(v, p));
        let ([a, b, c], [d, e, f]) = (q(&bound), q(&thesis));
        println!(
            "{name:>18} ({:5} motions): bound {a:7.4} {b:7.4} {c:8.4}   thesis {d:7.4} {e:7.4} {f:8.4}",
            bound.len()
        );
        (a, d)
    };
    let small = report("R/D <= 0.1", &|f| f.ratio <= 0.1).0;
    let middle = report("0.1 < R/D <= 0.8", &|f| f.ratio > 0.1 && f.ratio <= 0.8).0;
    report("0.8 < R/D", &|f| f.ratio > 0.8);
    let all = report("all", &|_| true).0;
    for step in 0..10 {
        let low = f64::from(step) * 0.1;
        report(&format!("{low:.1} to {:.1}", low + 0.1), &|f| {
            f.ratio > low && f.ratio <= low + 0.1
        });
    }
    let mut kinds: Vec<&str> = found.iter().map(|f| f.kind).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        report(kind, &|f| f.kind == kind);
    }
    assert!(small <= 1.1, "{small}");
    assert!(middle <= 2.5, "{middle}");
    assert!(all <= 1.5, "{all}");
}

#[test]
fn it_is_exact_sideways() {
    let lenses = Lenses::fixed(DVec2::splat(100.0));
    for radius in [0.0, 1e-9, 0.1, 0.8, 0.999] {
        let m = RelativeMotion::in_camera_space(DVec3::Z, DVec3::X * 1e-3, DVec3::ZERO, radius);
        let truth = displacement_px(&m, &lenses, -DVec3::Z);
        let bound = bound_px(&m, &lenses);
        assert!(
            bound >= truth && bound <= truth * (1.0 + 1e-9),
            "{bound} {truth}"
        );
    }
}

#[test]
fn under_parallel_projection_it_holds_and_is_all_but_exact() {
    use decor::motion::bound_orthographic_px;
    let mut ratios: Vec<f64> = (0..20_000u64)
        .into_par_iter()
        .map(|seed| {
            let mut random = Random(seed);
            let Case {
                motion: m, lenses, ..
            } = case(&mut random);
            let bound = bound_orthographic_px(&m, &lenses);
            let cos = (1.0 - m.half_turn.length_squared()).max(0.0).sqrt();
            let mut best = (0.0, DVec3::Z);
            let mut reach = 1.0;
            for i in 0..300 {
                let near = if i < 100 {
                    random.direction()
                } else {
                    best.1 + random.direction() * reach
                };
                let u = near.normalize_or(DVec3::X);
                let w = m.half_turn.cross(u);
                let step = m.delta + m.radius * 2.0 * (cos * w + m.half_turn.cross(w));
                let p = (m.centre_before + m.radius * u).truncate();
                let px = (lenses.after * step.truncate() + lenses.delta * p).length();
                if px > best.0 {
                    best = (px, u);
                } else if i >= 100 {
                    reach *= 0.97;
                }
            }
            assert!(
                best.0 <= bound * (1.0 + 1e-12),
                "{} > {bound}: {m:?} {lenses:?}",
                best.0
            );
            bound / best.0
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    println!(
        "parallel: median {:.4}, 90 % {:.4}",
        quantile(&ratios, 0.5),
        quantile(&ratios, 0.9)
    );
    assert!(quantile(&ratios, 0.5) < 1.05);
}

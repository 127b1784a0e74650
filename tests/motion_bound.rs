//! The bound against the truth: no point of the sphere moves farther, and few
//! bounds are much larger than they need to be.

mod motion_truth;

use decor::motion::bound_px;
use motion_truth::{Case, Random, case, displacement_px, exact_px, farthest, quantile};
use rayon::prelude::*;

/// How many motions the bound has to hold for.
const MOTIONS: u64 = 1_000_000;

#[test]
fn no_point_moves_farther_than_the_bound() {
    let (violations, decided) = (0..MOTIONS / 1000)
        .into_par_iter()
        .map(|batch| {
            let mut random = Random(batch * 7919 + 1);
            let mut count = (0u64, 0u64);
            for _ in 0..1000 {
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
                    count.1 += 1;
                    let exact = exact_px(&motion, &lenses, u);
                    if exact > bound {
                        println!("{kind}: {exact:e} > {bound:e}: {motion:?} {lenses:?} {u}");
                        count.0 += 1;
                    }
                }
            }
            count
        })
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    println!("{MOTIONS} motions, {violations} under-estimates ({decided} decided in 106 bits)");
    assert_eq!(violations, 0);
}

#[test]
fn the_bound_is_seldom_much_too_large() {
    let mut found: Vec<(f64, f64, &str)> = (0..200u64)
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
                    let bound = bound_px(&motion, &lenses);
                    let (moved, u) = farthest(&motion, &lenses, 2000, 200, &mut random);
                    let moved = if moved < 1e-6 {
                        exact_px(&motion, &lenses, u)
                    } else {
                        moved
                    };
                    (ratio, bound / moved, kind)
                })
                .collect::<Vec<_>>()
        })
        .collect();
    found.sort_by(|a, b| a.1.total_cmp(&b.1));
    let report = |name: &str, keep: &dyn Fn(&(f64, f64, &str)) -> bool| {
        let part: Vec<f64> = found.iter().filter(|f| keep(f)).map(|f| f.1).collect();
        let q = |p: f64| quantile(&part, p);
        println!(
            "{name:>18}: {:6} motions, over-estimate {:.4} (median) {:.4} (90 %) {:.4} (99 %) {:.4} (most)",
            part.len(),
            q(0.5),
            q(0.9),
            q(0.99),
            q(1.0)
        );
        q(0.5)
    };
    let small = report("R/D <= 0.1", &|f| f.0 <= 0.1);
    let middle = report("0.1 < R/D <= 0.8", &|f| f.0 > 0.1 && f.0 <= 0.8);
    report("0.8 < R/D", &|f| f.0 > 0.8);
    let all = report("all", &|_| true);
    for step in 0..10 {
        let low = f64::from(step) * 0.1;
        report(&format!("from {low:.1}"), &|f| {
            f.0 > low && f.0 <= low + 0.1
        });
    }
    let mut kinds: Vec<&str> = found.iter().map(|f| f.2).collect();
    kinds.sort_unstable();
    kinds.dedup();
    for kind in kinds {
        report(kind, &|f| f.2 == kind);
    }
    assert!(small <= 1.1 && middle <= 2.5 && all <= 1.5);
}

#[test]
fn it_is_exact_sideways() {
    use decor::motion::{Lenses, RelativeMotion};
    use glam::{DVec2, DVec3};
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

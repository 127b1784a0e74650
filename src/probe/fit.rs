//! From measured calls to costs: each number from the calls that tell it, where
//! the ones before are known.

use super::sample::{Measured, Question, Sample};
use crate::plan::{Costs, Parsed, Pass, PixelCost};

/// The costs that explain the samples; what no sample tells is taken from
/// `known`.
pub fn costs(samples: &[Measured], known: &Costs) -> Costs {
    let mut costs = *known;
    let of = |question: Question| -> Vec<&Measured> {
        let those = samples.iter().filter(|m| m.sample.question == question);
        those.collect()
    };
    calls(&mut costs, &of(Question::Empty));
    sleep(&mut costs, samples);
    own(&mut costs, samples);
    reading(&mut costs, &of(Question::Read));
    if let [canvas] = of(Question::Canvas)[..] {
        let sample = &canvas.sample;
        let rest =
            canvas.cpu_s - before(&costs, sample) - known.colour.of(sample.pixels, sample.covered);
        costs.canvas_pixel_s = (rest / sample.canvas).max(0.0);
    } else {
        costs.canvas_pixel_s = 0.0;
    }
    costs.colour = pixels(&costs, &of(Question::Pixels(Pass::Whole)), known.colour);
    // Without a sample a pass costs what its kin costs, as in plain scenes.
    let dearer = mean(&costs.colour) / mean(&known.colour);
    let kin = |pixel: PixelCost| pixel.times(dearer);
    costs.depth = pixels(&costs, &of(Question::Pixels(Pass::DecorDepth)), known.depth);
    let fast = of(Question::Pixels(Pass::Fast));
    costs.fast = if fast.is_empty() {
        kin(known.fast)
    } else {
        pixels(&costs, &fast, known.fast)
    };
    let fast_depth = of(Question::Pixels(Pass::FastDepth));
    costs.fast_depth = if fast_depth.is_empty() {
        costs.depth
    } else {
        pixels(&costs, &fast_depth, known.fast_depth)
    };
    costs
}

/// A pixel of which half the neighbours are covered.
fn mean(pixel: &PixelCost) -> f64 {
    pixel.of(1.0, 0.5)
}

/// A call with one picture of nothing, and one with three.
fn calls(costs: &mut Costs, samples: &[&Measured]) {
    let fewest =
        |a: &&&Measured, b: &&&Measured| a.sample.pictures().total_cmp(&b.sample.pictures());
    let (Some(few), Some(many)) = (samples.iter().min_by(fewest), samples.iter().max_by(fewest))
    else {
        return;
    };
    let more = many.sample.pictures() - few.sample.pictures();
    if more <= 0.0 {
        return;
    }
    let line = |of: fn(&Measured) -> f64| {
        let slope = ((of(many) - of(few)) / more).max(0.0);
        let start = (of(few) - slope * few.sample.pictures()).max(0.0);
        (start, slope)
    };
    (costs.call_cpu_s, costs.picture_cpu_s) = line(|m| m.cpu_s);
}

/// The sleep that is believed, as a multiple of what the adapter says.
const MOST_SLEEP: f64 = 1.4;

/// How long calls sleep: the least of those with one picture, and of those with
/// the most. What else waited for the cores is in all others.
fn sleep(costs: &mut Costs, samples: &[Measured]) {
    let least = |pictures: f64| {
        let those = samples.iter().filter(|m| m.sample.pictures() == pictures);
        let waits = those.map(|m| (m.wall_s - m.cpu_s - m.own_s).max(0.0));
        waits.min_by(f64::total_cmp)
    };
    let most = samples
        .iter()
        .map(|m| m.sample.pictures())
        .fold(0.0, f64::max);
    let (Some(one), Some(many)) = (least(1.0), least(most)) else {
        return;
    };
    if most > 1.0 {
        // A machine that is busy with something else does not make the renderer
        // sleep longer, it only seems so.
        let (call, picture) = (costs.call_sleep_s, costs.picture_sleep_s);
        let one = one.min(MOST_SLEEP * (call + picture));
        let more = (many - one) / (most - 1.0);
        costs.picture_sleep_s = more.clamp(0.0, one.min(MOST_SLEEP * picture));
        costs.call_sleep_s = one - costs.picture_sleep_s;
    }
}

/// decor's own part in the calls: per call in those of an empty scene, per pixel
/// in the others.
fn own(costs: &mut Costs, samples: &[Measured]) {
    let (mut calls, mut calls_s) = (0.0, 0.0);
    for measured in samples
        .iter()
        .filter(|m| m.sample.question == Question::Empty)
    {
        calls += 1.0;
        calls_s += measured.own_s;
    }
    if calls == 0.0 {
        return;
    }
    costs.own_call_s = calls_s / calls;
    let (mut pixels, mut pixels_s) = (0.0, 0.0);
    for measured in samples {
        if matches!(measured.sample.question, Question::Pixels(_)) {
            pixels += measured.sample.pixels;
            pixels_s += measured.own_s - costs.own_call_s;
        }
    }
    if pixels > 0.0 {
        costs.own_pixel_s = (pixels_s / pixels).max(0.0);
    }
}

/// A call that reads the whole scene and draws next to nothing: what it costs
/// more than an empty one is shared by instances and bytes as in plain scenes.
fn reading(costs: &mut Costs, samples: &[&Measured]) {
    for measured in samples {
        let sample = &measured.sample;
        let before = costs.call_cpu_s + costs.picture_cpu_s * sample.pictures();
        let rest = (measured.cpu_s - before).max(0.0);
        let Parsed { instances, bytes } = sample.parsed;
        let expected = costs.instance_s * instances + costs.byte_s * bytes;
        if expected > 0.0 {
            let factor = rest / expected;
            costs.instance_s *= factor;
            costs.byte_s *= factor;
        }
    }
}

/// What a call costs before it draws anything.
fn before(costs: &Costs, sample: &Sample) -> f64 {
    let reading = costs.instance_s * sample.parsed.instances + costs.byte_s * sample.parsed.bytes;
    costs.call_cpu_s + reading + costs.picture_cpu_s * sample.pictures()
}

/// The cost of a pass's pixels: from a full and an empty part of its pictures,
/// where they are far enough apart to tell what a covered pixel costs more; the
/// two parts of `known`, scaled, where they are not.
fn pixels(costs: &Costs, samples: &[&Measured], known: PixelCost) -> PixelCost {
    // Pixels, covered ones, and what they cost.
    let told: Vec<(f64, f64, f64)> = samples
        .iter()
        .map(|measured| {
            let sample = &measured.sample;
            let before = before(costs, sample) + costs.canvas_pixel_s * sample.canvas;
            let left = (measured.cpu_s - before).max(0.0);
            (sample.pixels, sample.covered, left)
        })
        .collect();
    pixel_cost(&told, known)
}

/// Two parts of the picture are far apart where their shares of covered pixels
/// differ so much.
const FAR_APART: f64 = 0.1;

fn pixel_cost(told: &[(f64, f64, f64)], known: PixelCost) -> PixelCost {
    let expected: f64 = told.iter().map(|&(p, c, _)| known.of(p, c)).sum();
    let measured: f64 = told.iter().map(|&(_, _, s)| s).sum();
    if expected <= 0.0 || measured <= 0.0 {
        return known;
    }
    let scaled = known.times(measured / expected);
    let [(p1, c1, s1), (p2, c2, s2)] = told[..] else {
        return scaled;
    };
    let (share1, share2) = (c1 / p1.max(1.0), c2 / p2.max(1.0));
    if (share1 - share2).abs() < FAR_APART {
        return scaled;
    }
    // A line through two points.
    let (cost1, cost2) = (s1 / p1.max(1.0), s2 / p2.max(1.0));
    let covered_s = (cost1 - cost2) / (share1 - share2);
    let any_s = cost1 - covered_s * share1;
    let all: f64 = p1 + p2;
    if covered_s < 0.0 {
        // The empty part is the dearer one: what covers it is not what costs.
        PixelCost {
            any_s: measured / all,
            covered_s: 0.0,
        }
    } else if any_s < 0.0 {
        PixelCost {
            any_s: 0.0,
            covered_s: measured / (c1 + c2),
        }
    } else {
        PixelCost { any_s, covered_s }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const KNOWN: PixelCost = PixelCost {
        any_s: 1e-7,
        covered_s: 3e-7,
    };

    proptest! {
        #[test]
        fn what_was_measured_is_explained(
            any in 1e-8..1e-5_f64,
            covered in 0.0..1e-5_f64,
            full in 0.0..1.0_f64,
            empty in 0.0..1.0_f64,
        ) {
            let truth = PixelCost { any_s: any, covered_s: covered };
            let told = [full, empty].map(|share| {
                let (pixels, covered) = (16384.0, 16384.0 * share);
                (pixels, covered, truth.of(pixels, covered))
            });
            let found = pixel_cost(&told, KNOWN);
            let total = |cost: PixelCost| told.iter().map(|&(p, c, _)| cost.of(p, c)).sum::<f64>();
            prop_assert!((total(found) / total(truth) - 1.0).abs() < 1e-9);
            prop_assert!(found.any_s >= 0.0 && found.covered_s >= 0.0);
            if (full - empty).abs() > 2.0 * FAR_APART {
                prop_assert!((found.any_s / any - 1.0).abs() < 1e-6);
            }
        }

        #[test]
        fn nonsense_gives_no_nonsense(
            told in proptest::collection::vec((0.0..1e6_f64, 0.0..1e6_f64, 0.0..10.0_f64), 0..4),
        ) {
            let found = pixel_cost(&told, KNOWN);
            prop_assert!(found.any_s.is_finite() && found.any_s >= 0.0);
            prop_assert!(found.covered_s.is_finite() && found.covered_s >= 0.0);
        }
    }
}

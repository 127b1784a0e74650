//! What a table of pairs has, whatever it is written as: the worst first.

use super::metrics::{DepthMetrics, Metrics};
use super::pair::PairReport;
use super::totals::is_worse;
use super::verdict::Verdict;
use super::{Comparison, Entry};

/// The columns' heads.
pub(super) const HEAD: [&str; 10] = [
    "name",
    "max",
    "rms",
    "psnr dB",
    "ssim",
    "flip",
    "differing",
    "share",
    "where",
    "verdict",
];

/// Is this column of numbers, to be set to the right?
pub(super) fn is_number(column: usize) -> bool {
    (1..=7).contains(&column)
}

/// A row, and what has to be said below it.
pub(super) struct Row {
    pub cells: [String; HEAD.len()],
    pub below: Vec<String>,
}

/// The pairs that differ, worst first; of one pair alone, it. Those with numbers,
/// then those without.
pub(super) fn worst_first(comparison: &Comparison) -> (Vec<&PairReport>, Vec<&PairReport>) {
    let mut pairs: Vec<&PairReport> = comparison
        .entries
        .iter()
        .filter_map(|entry| match entry {
            Entry::Pair(pair) => Some(&**pair),
            Entry::Missing { .. } => None,
        })
        .collect();
    // The sort keeps the order of the names among equals.
    pairs.sort_by(|one, other| is_worse(other, one).cmp(&is_worse(one, other)));
    let alone = comparison.entries.len() == 1;
    pairs
        .into_iter()
        .filter(|pair| alone || !pair.identical())
        .partition(|pair| pair.metrics.is_some())
}

/// A pair's row; none where it has no numbers.
pub(super) fn row(pair: &PairReport) -> Option<Row> {
    let metrics = pair.metrics.as_ref()?;
    let depth = metrics.depth.as_ref().filter(|depth| depth.unequal > 0);
    let mut below: Vec<String> = depth.map(depth_words).into_iter().collect();
    if let Some((x, y)) = pair.moved {
        below.push(format!("B is A moved by ({x}, {y}) pixels"));
    }
    Some(Row {
        cells: cells(pair, metrics),
        below,
    })
}

fn cells(pair: &PairReport, metrics: &Metrics) -> [String; HEAD.len()] {
    let verdict = match pair.verdict {
        Verdict::Within if metrics.identical() => "identical",
        verdict => verdict.words(),
    };
    let place = metrics.largest.map(|at| {
        let channel = at.channel.name();
        format!("({}, {}) {channel} {} / {}", at.x, at.y, at.a, at.b)
    });
    let nothing = || "-".to_owned();
    let perceived = metrics.perceived.as_ref();
    let ssim = perceived.and_then(|seen| seen.ssim);
    [
        pair.name.clone(),
        format!("{:.5}", metrics.max),
        format!("{:.6}", metrics.rms()),
        decibels(metrics.psnr()),
        ssim.map_or_else(nothing, |ssim| format!("{:.5}", ssim.mean)),
        perceived.map_or_else(nothing, |seen| format!("{:.5}", seen.flip.mean)),
        metrics.differing.to_string(),
        format!("{:.3} %", 100.0 * metrics.share_above()),
        place.unwrap_or_else(nothing),
        verdict.to_owned(),
    ]
}

pub(super) fn decibels(psnr: f64) -> String {
    if psnr.is_finite() {
        format!("{psnr:.2}")
    } else {
        "inf".to_owned()
    }
}

fn depth_words(depth: &DepthMetrics) -> String {
    let mut words = format!(
        "depth: largest difference {:.2e} ({:.1e} of it), {} pixels differ",
        depth.max_absolute, depth.max_relative, depth.unequal,
    );
    if depth.surface_in_one > 0 {
        words += &format!(", {} have a surface in one only", depth.surface_in_one);
    }
    if depth.not_a_number > 0 {
        words += &format!(", {} are no number", depth.not_a_number);
    }
    if let Some(at) = depth.largest {
        words += &format!("; worst at ({}, {}) {} / {}", at.x, at.y, at.a, at.b);
    }
    words
}

/// Every note once, with the number of pairs it is true of, in alphabetical
/// order.
pub(super) fn notes(comparison: &Comparison) -> Vec<String> {
    let mut counts = std::collections::BTreeMap::<&str, u64>::new();
    for entry in &comparison.entries {
        if let Entry::Pair(pair) = entry {
            for note in &pair.notes {
                *counts.entry(note).or_default() += 1;
            }
        }
    }
    let words = |(note, count)| {
        let pairs = if count == 1 { "pair" } else { "pairs" };
        format!("{note} ({count} {pairs})")
    };
    counts.into_iter().map(words).collect()
}

/// What is to be said of the film as a whole: lengths, looks, flicker. A line
/// each; nothing where all is equal.
pub(super) fn of_the_film(comparison: &Comparison) -> Vec<String> {
    let totals = &comparison.totals;
    let name = |k: usize| comparison.entries.get(k).map_or("", Entry::name);
    let mut lines = Vec::new();
    if totals.missing() > 0 {
        let frames = totals.frames() as usize;
        lines.push(format!(
            "A has {} pictures, B has {}",
            frames + totals.missing_from_b.len(),
            frames + totals.missing_from_a.len()
        ));
    }
    if totals.compared == totals.identical {
        return lines;
    }
    let several = totals.compared > 1;
    if let Some(film) = totals.perceived.filter(|_| several) {
        let mut words = String::new();
        if let (Some(ssim), Some((lowest, k))) = (film.ssim(), film.lowest_ssim) {
            words += &format!("ssim {ssim:.5} (lowest {lowest:.5} in {}); ", name(k));
        }
        if let Some((highest, k)) = film.highest_flip {
            let flip = film.flip();
            words += &format!("flip {flip:.5} (highest {highest:.5} in {})", name(k));
        }
        lines.push(words);
    }
    if let Some(film) = &totals.flicker {
        let all = &film.all;
        let mut words = format!(
            "flicker: from frame to frame {} pixels change in A, {} in B: {} in B only, {} in A only",
            all.changed_a, all.changed_b, all.added, all.lost
        );
        if let Some((most, k)) = film.worst {
            words += &format!("; most in B only: {most} at {}", name(k));
        }
        lines.push(words);
    }
    lines
}

/// The verdict and the film's numbers.
pub(super) fn last_line(comparison: &Comparison) -> String {
    let totals = &comparison.totals;
    let frames = totals.frames();
    let pairs = if frames == 1 { "pair" } else { "pairs" };
    let mut words = format!("{}: {frames} {pairs}", comparison.verdict.words());
    for (verdict, count) in Verdict::ALL.into_iter().zip(totals.pairs) {
        if count > 0 && frames > 1 {
            words += &format!(", {count} {}", verdict.words());
        }
    }
    if totals.missing() > 0 {
        words += &format!(", {} without a partner", totals.missing());
    }
    if totals.compared > 0 {
        if totals.compared == totals.identical {
            words += ", identical";
        } else {
            words += &format!(
                "; max {:.5}, rms {:.6}, psnr {} dB, {:.3} % of the pixels above the tolerance",
                totals.max,
                totals.rms(),
                decibels(totals.psnr()),
                100.0 * totals.share_above(),
            );
        }
    }
    if let Some(worst) = totals.worst.and_then(|k| comparison.entries.get(k)) {
        if frames > 1 {
            words += &format!("; worst {}", worst.name());
        } else if let Entry::Pair(pair) = worst
            && !pair.reasons.is_empty()
        {
            words += &format!("; {}", pair.reasons.join("; "));
        }
    }
    words
}

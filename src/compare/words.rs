//! A comparison in words: a table, worst first, and the verdict in the last line.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::metrics::{DepthMetrics, Metrics};
use super::pair::PairReport;
use super::totals::is_worse;
use super::verdict::Verdict;
use super::{Comparison, Entry};

/// Rows of the table: the worst are what is looked for, `--json` has all.
const ROWS: usize = 20;

/// Writes the table and the verdict.
///
/// # Errors
/// Where `out` cannot be written.
pub fn write(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    if let Some(reason) = &comparison.reason {
        return writeln!(out, "{}: {reason}", comparison.verdict.words());
    }
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
    let (numbers, rest): (Vec<&PairReport>, Vec<&PairReport>) = pairs
        .into_iter()
        .filter(|pair| alone || !pair.identical())
        .partition(|pair| pair.metrics.is_some());
    for pair in rest.iter().take(ROWS) {
        let (name, verdict) = (&pair.name, pair.verdict.words());
        writeln!(out, "{name}: {verdict}: {}", pair.reasons.join("; "))?;
    }
    left_out(rest.len(), "pairs that could not be compared", out)?;
    for (names, side) in [
        (&comparison.totals.missing_from_a, 'A'),
        (&comparison.totals.missing_from_b, 'B'),
    ] {
        for name in names.iter().take(ROWS) {
            writeln!(out, "{name}: missing from {side}")?;
        }
        left_out(names.len(), &format!("missing from {side}"), out)?;
    }
    table(&numbers, out)?;
    left_out(numbers.len(), "pairs that differ", out)?;
    if !alone && comparison.totals.identical > 0 {
        writeln!(out, "identical: {}", comparison.totals.identical)?;
    }
    notes(comparison, out)?;
    last_line(comparison, out)
}

fn left_out(count: usize, what: &str, out: &mut dyn Write) -> io::Result<()> {
    if count > ROWS {
        writeln!(out, "… and {} more {what}", count - ROWS)?;
    }
    Ok(())
}

fn table(pairs: &[&PairReport], out: &mut dyn Write) -> io::Result<()> {
    let header = [
        "name",
        "max",
        "rms",
        "psnr dB",
        "differing",
        "share",
        "where",
        "verdict",
    ];
    let mut rows: Vec<([String; 8], Option<&DepthMetrics>)> = Vec::new();
    for pair in pairs.iter().take(ROWS) {
        if let Some(metrics) = &pair.metrics {
            rows.push((cells(pair, metrics), metrics.depth.as_ref()));
        }
    }
    if rows.is_empty() {
        return Ok(());
    }
    let mut widths = header.map(|word| word.chars().count());
    for (cells, _) in &rows {
        for (width, cell) in widths.iter_mut().zip(cells) {
            *width = cell.chars().count().max(*width);
        }
    }
    let line = |cells: [&str; 8]| {
        let mut text = String::new();
        for (k, (cell, width)) in cells.into_iter().zip(widths).enumerate() {
            // Numbers to the right, words to the left.
            text += &match k {
                1..=5 => format!("{cell:>width$}  "),
                _ => format!("{cell:<width$}  "),
            };
        }
        text.trim_end().to_owned()
    };
    writeln!(out, "{}", line(header))?;
    for (cells, depth) in &rows {
        writeln!(out, "{}", line(cells.each_ref().map(String::as_str)))?;
        if let Some(depth) = depth.filter(|depth| depth.unequal > 0) {
            writeln!(out, "    {}", depth_words(depth))?;
        }
    }
    Ok(())
}

fn cells(pair: &PairReport, metrics: &Metrics) -> [String; 8] {
    let verdict = match pair.verdict {
        Verdict::Within if metrics.identical() => "identical",
        verdict => verdict.words(),
    };
    let place = metrics.largest.map(|at| {
        let channel = at.channel.name();
        format!("({}, {}) {channel} {} / {}", at.x, at.y, at.a, at.b)
    });
    [
        pair.name.clone(),
        format!("{:.5}", metrics.max),
        format!("{:.6}", metrics.rms()),
        decibels(metrics.psnr()),
        metrics.differing.to_string(),
        format!("{:.3} %", 100.0 * metrics.share_above()),
        place.unwrap_or_else(|| "-".to_owned()),
        verdict.to_owned(),
    ]
}

fn decibels(psnr: f64) -> String {
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

/// Every note once, with the number of pairs it is true of.
fn notes(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
    for entry in &comparison.entries {
        if let Entry::Pair(pair) = entry {
            for note in &pair.notes {
                *counts.entry(note).or_default() += 1;
            }
        }
    }
    for (note, count) in counts {
        let pairs = if count == 1 { "pair" } else { "pairs" };
        writeln!(out, "note: {note} ({count} {pairs})")?;
    }
    Ok(())
}

fn last_line(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
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
    writeln!(out, "{words}")
}

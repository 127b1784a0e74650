//! A comparison as comma-separated values: a row for every pair and every picture
//! without a partner, in the order of the names, then one for the film.

use std::io::{self, Write};

use serde::Serialize;

use super::flicker::Flicker;
use super::folders::Side;
use super::metrics::DepthMetrics;
use super::pair::PairReport;
use super::verdict::Verdict;
use super::{Comparison, Entry};

/// A row. What is not known or does not apply is empty.
#[derive(Default, Serialize)]
struct Row<'a> {
    r#type: &'a str,
    name: &'a str,
    verdict: Option<Verdict>,
    missing_from: Option<Side>,
    max: Option<f64>,
    rms: Option<f64>,
    psnr: Option<f64>,
    ssim: Option<f64>,
    flip: Option<f64>,
    differing: Option<u64>,
    share_above: Option<f64>,
    unequal: Option<u64>,
    not_finite: Option<u64>,
    x: Option<u32>,
    y: Option<u32>,
    channel: Option<&'a str>,
    changed_a: Option<u64>,
    changed_b: Option<u64>,
    added: Option<u64>,
    lost: Option<u64>,
    depth_max_absolute: Option<f64>,
    depth_max_relative: Option<f64>,
    depth_surface_in_one: Option<u64>,
    moved_x: Option<i64>,
    moved_y: Option<i64>,
    reasons: String,
}

/// Writes the table.
///
/// # Errors
/// Where `out` cannot be written.
pub fn write(comparison: &Comparison, out: &mut dyn Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    for entry in &comparison.entries {
        table.serialize(match entry {
            Entry::Pair(pair) => of_pair(pair),
            Entry::Missing { name, from } => Row {
                r#type: "missing",
                name,
                verdict: Some(entry.verdict()),
                missing_from: Some(*from),
                ..Row::default()
            },
        })?;
    }
    table.serialize(of_film(comparison))?;
    table.flush()
}

fn of_pair(pair: &PairReport) -> Row<'_> {
    let mut row = Row {
        r#type: "pair",
        name: &pair.name,
        verdict: Some(pair.verdict),
        moved_x: pair.moved.map(|(x, _)| x),
        moved_y: pair.moved.map(|(_, y)| y),
        reasons: pair.reasons.join("; "),
        ..Row::default()
    };
    if let Some(metrics) = &pair.metrics {
        row.max = Some(metrics.max);
        row.rms = Some(metrics.rms());
        row.psnr = Some(metrics.psnr());
        row.differing = Some(metrics.differing);
        row.share_above = Some(metrics.share_above());
        row.unequal = Some(metrics.unequal);
        row.not_finite = Some(metrics.not_finite);
        if let Some(place) = metrics.largest {
            (row.x, row.y) = (Some(place.x), Some(place.y));
            row.channel = Some(place.channel.name());
        }
        if let Some(perceived) = &metrics.perceived {
            row.ssim = perceived.ssim.map(|ssim| ssim.mean);
            row.flip = Some(perceived.flip.mean);
        }
        row.depth(metrics.depth.as_ref());
    }
    row.flicker(pair.flicker.as_ref());
    row
}

fn of_film(comparison: &Comparison) -> Row<'_> {
    let totals = &comparison.totals;
    let mut row = Row {
        r#type: "summary",
        verdict: Some(comparison.verdict),
        reasons: comparison.reason.clone().unwrap_or_default(),
        ..Row::default()
    };
    if totals.compared > 0 {
        row.max = Some(totals.max);
        row.rms = Some(totals.rms());
        row.psnr = Some(totals.psnr());
        row.differing = Some(totals.differing);
        row.share_above = Some(totals.share_above());
        row.unequal = Some(totals.unequal);
        row.not_finite = Some(totals.not_finite);
    }
    if let Some(film) = &totals.perceived {
        row.ssim = film.ssim();
        row.flip = Some(film.flip());
    }
    row.flicker(totals.flicker.as_ref().map(|film| &film.all));
    row.depth(totals.depth.as_ref());
    row
}

impl Row<'_> {
    fn flicker(&mut self, flicker: Option<&Flicker>) {
        self.changed_a = flicker.map(|flicker| flicker.changed_a);
        self.changed_b = flicker.map(|flicker| flicker.changed_b);
        self.added = flicker.map(|flicker| flicker.added);
        self.lost = flicker.map(|flicker| flicker.lost);
    }

    fn depth(&mut self, depth: Option<&DepthMetrics>) {
        self.depth_max_absolute = depth.map(|depth| depth.max_absolute);
        self.depth_max_relative = depth.map(|depth| depth.max_relative);
        self.depth_surface_in_one = depth.map(|depth| depth.surface_in_one);
    }
}

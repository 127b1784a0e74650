//! A comparison as JSON: one object a line, the last the summary.
//!
//! PSNR is null where it is infinite. Any other number that JSON does not have
//! is the string `"nan"`, `"inf"` or `"-inf"`. What could not be measured is
//! null.

use std::path::Path;

use serde::{Serialize, Serializer};

use super::flicker::Flicker;
use super::metrics::{DepthMetrics, Metrics, Place};
use super::pair::PairReport;
use super::totals::FilmPerceived;
use super::verdict::{Tolerances, Verdict};
use super::{Comparison, Entry};

/// A number that JSON may not have.
#[derive(Clone, Copy, Debug)]
struct Number(f64);

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            value if value.is_finite() => serializer.serialize_f64(value),
            value if value.is_nan() => serializer.serialize_str("nan"),
            value if value > 0.0 => serializer.serialize_str("inf"),
            _ => serializer.serialize_str("-inf"),
        }
    }
}

impl From<f32> for Number {
    /// By its shortest decimal digits, so that 0.1 is not 0.10000000149011612.
    fn from(value: f32) -> Self {
        Self(value.to_string().parse().unwrap_or(f64::from(value)))
    }
}

/// A line of the report.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename_all = "lowercase")]
enum Line<'a> {
    Pair(Pair<'a>),
    Missing {
        name: &'a str,
        missing_from: super::folders::Side,
        verdict: Verdict,
    },
    Update {
        name: &'a str,
        action: super::baseline::Action,
    },
    Summary(Summary<'a>),
}

#[derive(Debug, Serialize)]
struct Pair<'a> {
    name: &'a str,
    a: String,
    b: String,
    verdict: Verdict,
    reasons: &'a [String],
    notes: &'a [String],
    size_a: Option<[u32; 2]>,
    size_b: Option<[u32; 2]>,
    identical: bool,
    max: Option<Number>,
    rms: Option<f64>,
    psnr: Option<f64>,
    differing: Option<u64>,
    share_above: Option<f64>,
    unequal: Option<u64>,
    not_finite: Option<u64>,
    tolerance: Number,
    largest: Option<Largest>,
    ssim: Option<f64>,
    flip: Option<f64>,
    flip_max: Option<f64>,
    flicker: Option<Transition>,
    moved: Option<(i64, i64)>,
    depth: Option<Depth>,
    diff: Option<String>,
}

/// Changed pixels of one transition, or of all.
#[derive(Debug, Serialize)]
struct Transition {
    #[serde(skip_serializing_if = "Option::is_none")]
    transitions: Option<u64>,
    pixels: u64,
    changed_a: u64,
    changed_b: u64,
    difference: i64,
    added: u64,
    lost: u64,
    share_added: f64,
}

impl From<&Flicker> for Transition {
    fn from(flicker: &Flicker) -> Self {
        Self {
            transitions: None,
            pixels: flicker.pixels,
            changed_a: flicker.changed_a,
            changed_b: flicker.changed_b,
            difference: flicker.difference(),
            added: flicker.added,
            lost: flicker.lost,
            share_added: flicker.share_added(),
        }
    }
}

/// The pair where a number is worst.
#[derive(Debug, Serialize)]
struct Extreme<'a, T> {
    name: &'a str,
    value: T,
}

#[derive(Debug, Serialize)]
struct Largest {
    x: u32,
    y: u32,
    channel: &'static str,
    a: Number,
    b: Number,
}

#[derive(Debug, Serialize)]
struct Depth {
    max_absolute: Number,
    max_relative: Number,
    surface_in_one: u64,
    not_a_number: u64,
    unequal: u64,
    differing: u64,
    tolerance: Number,
    largest: Option<LargestDepth>,
}

#[derive(Debug, Serialize)]
struct LargestDepth {
    x: u32,
    y: u32,
    a: Number,
    b: Number,
}

#[derive(Debug, Serialize)]
struct Summary<'a> {
    verdict: Verdict,
    status: u8,
    reason: Option<&'a str>,
    a: String,
    b: String,
    frames: u64,
    compared: u64,
    identical: u64,
    within: u64,
    warning: u64,
    failed: u64,
    not_comparable: u64,
    unreadable: u64,
    missing: usize,
    missing_from_a: &'a [String],
    missing_from_b: &'a [String],
    pixels: u64,
    max: Option<Number>,
    rms: Option<f64>,
    psnr: Option<f64>,
    differing: u64,
    share_above: f64,
    unequal: u64,
    not_finite: u64,
    tolerance: Number,
    ssim: Option<f64>,
    ssim_lowest: Option<Extreme<'a, f64>>,
    flip: Option<f64>,
    flip_highest: Option<Extreme<'a, f64>>,
    flicker: Option<Transition>,
    flicker_worst: Option<Extreme<'a, u64>>,
    depth: Option<Depth>,
    worst: Option<Worst<'a>>,
}

#[derive(Debug, Serialize)]
struct Worst<'a> {
    name: &'a str,
    verdict: Verdict,
    max: Option<Number>,
    rms: Option<f64>,
    psnr: Option<f64>,
    differing: Option<u64>,
    largest: Option<Largest>,
}

/// The line of an entry, without its end.
///
/// # Errors
/// None that input can cause; the serializer's.
pub fn entry_line(entry: &Entry, tolerances: &Tolerances) -> serde_json::Result<String> {
    serde_json::to_string(&match entry {
        Entry::Pair(pair) => Line::Pair(pair_line(pair, tolerances)),
        Entry::Missing { name, from } => Line::Missing {
            name,
            missing_from: *from,
            verdict: entry.verdict(),
        },
    })
}

/// The line of a reference that was changed, without its end.
///
/// # Errors
/// None that input can cause; the serializer's.
pub fn change_line(change: &super::baseline::Change) -> serde_json::Result<String> {
    serde_json::to_string(&Line::Update {
        name: &change.name,
        action: change.action,
    })
}

/// The last line, without its end.
///
/// # Errors
/// None that input can cause; the serializer's.
pub fn summary_line(
    a: &Path,
    b: &Path,
    comparison: &Comparison,
    tolerances: &Tolerances,
) -> serde_json::Result<String> {
    let totals = &comparison.totals;
    let [within, warning, failed, not_comparable, unreadable] = totals.pairs;
    let compared = totals.compared > 0;
    let worst = totals.worst.and_then(|k| match comparison.entries.get(k)? {
        Entry::Pair(pair) => Some(pair),
        Entry::Missing { .. } => None,
    });
    let name = |k: usize| comparison.entries.get(k).map_or("", Entry::name);
    let perceived = totals.perceived.as_ref();
    let lowest = perceived.and_then(|film| film.lowest_ssim);
    let highest = perceived.and_then(|film| film.highest_flip);
    let flicker = totals.flicker.as_ref();
    let most = flicker.and_then(|film| film.worst);
    serde_json::to_string(&Line::Summary(Summary {
        verdict: comparison.verdict,
        status: comparison.verdict.status(),
        reason: comparison.reason.as_deref(),
        a: words(a),
        b: words(b),
        frames: totals.frames(),
        compared: totals.compared,
        identical: totals.identical,
        within,
        warning,
        failed,
        not_comparable,
        unreadable,
        missing: totals.missing(),
        missing_from_a: &totals.missing_from_a,
        missing_from_b: &totals.missing_from_b,
        pixels: totals.pixels,
        max: compared.then_some(Number(totals.max)),
        rms: compared.then_some(totals.rms()),
        psnr: finite(totals.psnr()),
        differing: totals.differing,
        share_above: totals.share_above(),
        unequal: totals.unequal,
        not_finite: totals.not_finite,
        tolerance: Number(tolerances.fail.level),
        ssim: perceived.and_then(FilmPerceived::ssim),
        ssim_lowest: lowest.map(|(value, k)| Extreme {
            name: name(k),
            value,
        }),
        flip: perceived.map(FilmPerceived::flip),
        flip_highest: highest.map(|(value, k)| Extreme {
            name: name(k),
            value,
        }),
        flicker: flicker.map(|film| Transition {
            transitions: Some(film.transitions),
            ..Transition::from(&film.all)
        }),
        flicker_worst: most.map(|(value, k)| Extreme {
            name: name(k),
            value,
        }),
        depth: totals.depth.as_ref().map(|d| depth(d, tolerances, false)),
        worst: worst.map(|pair| Worst {
            name: &pair.name,
            verdict: pair.verdict,
            max: pair.metrics.as_ref().map(|m| Number(m.max)),
            rms: pair.metrics.as_ref().map(Metrics::rms),
            psnr: pair.metrics.as_ref().and_then(|m| finite(m.psnr())),
            differing: pair.metrics.as_ref().map(|m| m.differing),
            largest: pair.metrics.as_ref().and_then(largest),
        }),
    }))
}

fn pair_line<'a>(pair: &'a PairReport, tolerances: &Tolerances) -> Pair<'a> {
    let metrics = pair.metrics.as_ref();
    let perceived = metrics.and_then(|m| m.perceived.as_ref());
    let size = |size: decor_api::Size| [size.width, size.height];
    Pair {
        name: &pair.name,
        a: words(&pair.a),
        b: words(&pair.b),
        verdict: pair.verdict,
        reasons: &pair.reasons,
        notes: &pair.notes,
        size_a: pair.sizes.0.map(size),
        size_b: pair.sizes.1.map(size),
        identical: pair.identical(),
        max: metrics.map(|m| Number(m.max)),
        rms: metrics.map(Metrics::rms),
        psnr: metrics.and_then(|m| finite(m.psnr())),
        differing: metrics.map(|m| m.differing),
        share_above: metrics.map(Metrics::share_above),
        unequal: metrics.map(|m| m.unequal),
        not_finite: metrics.map(|m| m.not_finite),
        tolerance: Number(tolerances.fail.level),
        largest: metrics.and_then(largest),
        ssim: perceived.and_then(|seen| seen.ssim).map(|ssim| ssim.mean),
        flip: perceived.map(|seen| seen.flip.mean),
        flip_max: perceived.map(|seen| seen.flip.max),
        flicker: pair.flicker.as_ref().map(Transition::from),
        moved: pair.moved,
        depth: metrics
            .and_then(|m| m.depth.as_ref())
            .map(|d| depth(d, tolerances, true)),
        diff: pair.diff.as_deref().map(words),
    }
}

fn largest(metrics: &Metrics) -> Option<Largest> {
    let Place {
        x,
        y,
        channel,
        a,
        b,
    } = metrics.largest?;
    Some(Largest {
        x,
        y,
        channel: channel.name(),
        a: a.into(),
        b: b.into(),
    })
}

/// `place`: say where. In the film's totals a place would lack its frame.
fn depth(depth: &DepthMetrics, tolerances: &Tolerances, place: bool) -> Depth {
    Depth {
        max_absolute: Number(depth.max_absolute),
        max_relative: Number(depth.max_relative),
        surface_in_one: depth.surface_in_one,
        not_a_number: depth.not_a_number,
        unequal: depth.unequal,
        differing: depth.differing,
        tolerance: Number(tolerances.fail_depth),
        largest: depth.largest.filter(|_| place).map(|at| LargestDepth {
            x: at.x,
            y: at.y,
            a: at.a.into(),
            b: at.b.into(),
        }),
    }
}

fn finite(value: f64) -> Option<f64> {
    value.is_finite().then_some(value)
}

fn words(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

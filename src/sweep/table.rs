//! A sweep as a table: Markdown, or comma-separated values.

use std::io::{self, Write};

use serde::Serialize;

use super::{Against, Swept};

/// The columns' heads.
pub const HEAD: [&str; 14] = [
    "#",
    "setting",
    "wall s",
    "× wall",
    "× CPU",
    "× traced",
    "× wall of full",
    "max",
    "RMS",
    "PSNR dB",
    "SSIM",
    "FLIP",
    "flicker %",
    "motion px",
];

/// The cells of a setting.
pub fn cells(swept: &Swept<'_>, k: usize) -> [String; HEAD.len()] {
    let line = swept.setting_line(k);
    let errors = &line.errors;
    let nothing = || "–".to_owned();
    let times = |value: f64| format!("{value:.2}");
    [
        line.number.to_string(),
        line.name,
        format!("{:.2}", line.wall_s),
        times(line.speedup.wall),
        times(line.speedup.cpu),
        times(line.speedup.traced),
        line.speedup_full
            .map_or_else(nothing, |full| times(full.wall)),
        format!("{:.4}", errors.max),
        format!("{:.5}", errors.rms),
        errors
            .psnr
            .map_or_else(|| "∞".to_owned(), |psnr| format!("{psnr:.2}")),
        errors
            .ssim
            .map_or_else(nothing, |ssim| format!("{ssim:.5}")),
        format!("{:.5}", errors.flip),
        format!("{:.3}", 100.0 * errors.flicker),
        format!("{:.2}", errors.motion_px),
    ]
}

/// What has to be said of single settings: which are one, and why others are beaten.
pub fn notes(swept: &Swept<'_>) -> Vec<String> {
    let name = |k: usize| format!("{} ({})", k + 1, swept.settings[k].setting);
    let why = |k: usize| swept.trades[k].why.as_deref().unwrap_or("nothing is won");
    let mut notes = Vec::new();
    for (k, trade) in swept.trades.iter().enumerate() {
        if swept.settings[k].same_as.is_some() {
            continue;
        }
        if let Some(better) = trade.beaten_by {
            let (one, other) = (name(k), name(better));
            notes.push(format!("{one} is beaten by {other}: {}.", why(k)));
        }
        let mut same = (0..swept.settings.len()).filter(|&j| swept.settings[j].same_as == Some(k));
        if let Some(first) = same.next() {
            let others: Vec<String> = std::iter::once(first).chain(same).map(name).collect();
            let (others, one) = (others.join(", "), name(k));
            notes.push(format!(
                "What was measured of {one} is of {others} too: {}.",
                why(first)
            ));
        }
    }
    notes
}

/// What everything was measured against, in words.
pub fn against(swept: &Swept<'_>) -> String {
    let what = match swept.reference.against {
        Against::Stock => "one plain call of",
        Against::Full => "frame by frame through decor's pool by",
    };
    let abilities = swept.stage.adapter.abilities();
    format!(
        "{what} {} {}, {:.2} s on the clock, {:.2} s of CPU",
        swept.stage.adapter.name(),
        abilities.version,
        swept.reference.price.wall_s,
        swept.reference.price.cpu_s
    )
}

/// Writes Markdown: a table, in bold what no other setting beats, and why the others
/// are beaten.
///
/// # Errors
/// Where `out` cannot be written.
pub fn write_markdown(swept: &Swept<'_>, out: &mut dyn Write) -> io::Result<()> {
    let size = swept.stage.size();
    let (first, last) = swept.frames;
    let runs = match swept.runs {
        1 => "one run each".to_owned(),
        n => format!("medians of {n} runs"),
    };
    writeln!(
        out,
        "`{}`, frames {first} to {last}, {} × {}, {runs}. Against {}. Machine: {}. decor {}.\n",
        swept.film,
        size.width,
        size.height,
        against(swept),
        swept.machine,
        env!("CARGO_PKG_VERSION"),
    )?;
    writeln!(out, "| {} |", HEAD.join(" | "))?;
    let rule = |k: usize| if k == 1 { "---" } else { "---:" };
    let rules: Vec<&str> = (0..HEAD.len()).map(rule).collect();
    writeln!(out, "| {} |", rules.join(" | "))?;
    for k in 0..swept.settings.len() {
        let mut cells = cells(swept, k);
        if swept.trades[k].on_front {
            cells[1] = format!("**{}**", cells[1]);
        }
        writeln!(out, "| {} |", cells.join(" | "))?;
    }
    writeln!(
        out,
        "\nIn bold: no other setting is both as fast, on the clock, and as close, by FLIP."
    )?;
    for note in notes(swept) {
        writeln!(out, "- {note}")?;
    }
    out.flush()
}

/// A row of the comma-separated values. What is not known is empty.
#[derive(Serialize)]
struct Row {
    number: usize,
    mode: String,
    threshold_px: f64,
    period: Option<u32>,
    measure: crate::segmentation::Measure,
    antialias: super::Antialiasing,
    same_plan_as: Option<usize>,
    fallback: bool,
    wall_s: f64,
    cpu_s: f64,
    pixels_traced: u64,
    speedup_wall: f64,
    speedup_cpu: f64,
    speedup_traced: f64,
    speedup_full_wall: Option<f64>,
    max: f64,
    rms: f64,
    psnr: Option<f64>,
    ssim: Option<f64>,
    flip: f64,
    flicker: f64,
    share_above: f64,
    motion_px: f64,
    on_front: bool,
    beaten_by: Option<usize>,
    why: Option<String>,
}

/// Writes comma-separated values, a row a setting.
///
/// # Errors
/// Where `out` cannot be written.
pub fn write_csv(swept: &Swept<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    for k in 0..swept.settings.len() {
        let line = swept.setting_line(k);
        let (setting, errors) = (line.setting, line.errors);
        table.serialize(Row {
            number: line.number,
            mode: setting.mode.to_string(),
            threshold_px: setting.threshold_px,
            period: setting.period,
            measure: setting.measure,
            antialias: setting.antialias,
            same_plan_as: line.same_plan_as,
            fallback: line.fallback,
            wall_s: line.wall_s,
            cpu_s: line.cpu_s,
            pixels_traced: line.pixels_traced,
            speedup_wall: line.speedup.wall,
            speedup_cpu: line.speedup.cpu,
            speedup_traced: line.speedup.traced,
            speedup_full_wall: line.speedup_full.map(|full| full.wall),
            max: errors.max,
            rms: errors.rms,
            psnr: errors.psnr,
            ssim: errors.ssim,
            flip: errors.flip,
            flicker: errors.flicker,
            share_above: errors.share_above,
            motion_px: errors.motion_px,
            on_front: line.on_front,
            beaten_by: line.beaten_by,
            why: line.why,
        })?;
    }
    table.flush()
}

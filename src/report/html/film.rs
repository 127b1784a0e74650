//! The page's parts along the film: the worst frames, the errors, the periods.

use super::{Page, Run, chart, escaped, sections, timeline};
use crate::compare::{Comparison, Entry};

/// What is seen with one comparison only.
fn with(shown: usize, text: &str) -> String {
    let hidden = if shown == 0 { "" } else { " hidden" };
    format!("<div data-shown=\"{shown}\"{hidden}>\n{text}</div>\n")
}

/// The worst frames of each comparison.
pub(super) fn tables(page: &Page<'_>, worst: &[Vec<usize>]) -> String {
    let shown = page.shown.iter().zip(worst).enumerate();
    shown
        .map(|(k, (one, worst))| with(k, &table(one.comparison, worst)))
        .collect()
}

fn table(comparison: &Comparison, worst: &[usize]) -> String {
    let mut rows = String::new();
    let shown = worst.iter().copied().enumerate();
    for (row, k) in shown {
        let Some(Entry::Pair(pair)) = comparison.entries.get(k) else {
            continue;
        };
        let Some(metrics) = &pair.metrics else {
            continue;
        };
        let nothing = || "–".to_owned();
        let five = |value: f64| format!("{value:.5}");
        let seen = metrics.perceived.as_ref();
        let cells = [
            seen.map_or_else(nothing, |seen| five(seen.flip.mean)),
            seen.and_then(|seen| seen.ssim)
                .map_or_else(nothing, |ssim| five(ssim.mean)),
            five(metrics.max),
            format!("{:.2}", metrics.psnr()).replace("inf", "∞"),
            format!("{:.3} %", 100.0 * metrics.share_above()),
            pair.flicker
                .map_or_else(nothing, |flicker| flicker.added.to_string()),
        ];
        rows += &format!(
            "<tr data-frame=\"{row}\"><td>{}</td><td>{}</td><td class=\"{}\">{}</td></tr>\n",
            escaped(&pair.name),
            cells.join("</td><td>"),
            sections::class(pair.verdict),
            pair.verdict.words()
        );
    }
    let mut text = String::new();
    if !rows.is_empty() {
        text += &format!(
            "<div class=\"scroll\" tabindex=\"0\"><table>\n<thead><tr><th>frame</th><th>FLIP</th><th>SSIM</th>\
             <th>max</th><th>PSNR dB</th><th>above</th><th>flicker</th><th>verdict</th></tr></thead>\n\
             <tbody>\n{rows}</tbody>\n</table></div>\n"
        );
    }
    let without = comparison.entries.iter().filter_map(|entry| match entry {
        Entry::Missing { name, from } => {
            Some(format!("{}: missing from {}", escaped(name), from.letter()))
        }
        Entry::Pair(pair) if pair.metrics.is_none() => {
            let reasons = escaped(&pair.reasons.join("; "));
            let name = escaped(&pair.name);
            Some(format!("{name}: {}: {reasons}", pair.verdict.words()))
        }
        Entry::Pair(_) => None,
    });
    for line in without {
        text += &format!("<p class=\"failed\">{line}</p>\n");
    }
    text
}

/// The errors of each comparison, frame by frame.
pub(super) fn errors(page: &Page<'_>) -> String {
    let mut text = String::new();
    for (k, shown) in page.shown.iter().enumerate() {
        let pairs = shown.comparison.entries.iter();
        let errors: Vec<f64> = pairs
            .filter_map(|entry| match entry {
                Entry::Pair(pair) => Some(pair.metrics.as_ref()?.perceived?.flip.mean),
                Entry::Missing { .. } => None,
            })
            .collect();
        if errors.len() > 1 {
            let drawing = chart::by_frame(&errors);
            text += &with(
                k,
                &format!(
                    "<h2>Error along the film</h2>\n<figure tabindex=\"0\">{drawing}</figure>\n"
                ),
            );
        }
    }
    text
}

/// The periods of each film, and its objects where they are known.
pub(super) fn periods(page: &Page<'_>) -> String {
    let mut text = String::new();
    for run in page.runs.iter().filter(|run| !run.periods.is_empty()) {
        let periods = of_run(run);
        text += &match run.shown {
            Some(shown) => with(shown, &periods),
            None => periods,
        };
    }
    text
}

fn of_run(run: &Run) -> String {
    let label = escaped(&run.label);
    let mut text = format!(
        "<h2>Periods of {label}</h2>\n<figure tabindex=\"0\">{}<figcaption>Objects by class: {}. \
         The number is the period's first frame; pale: its frames are rendered \
         whole.</figcaption></figure>\n",
        timeline::periods(run),
        legend()
    );
    if !run.objects.is_empty() {
        let (drawing, left_out) = timeline::objects(run);
        let more = match left_out {
            0 => String::new(),
            n => format!(" {n} more move less, and are left out."),
        };
        text += &format!(
            "<h2>Objects of {label}</h2>\n<figure tabindex=\"0\">{drawing}<figcaption>What each \
             object is in each period: {}.{more}</figcaption></figure>\n",
            legend()
        );
    }
    text
}

fn legend() -> String {
    let item = |class: &&str| {
        format!(
            "<svg viewBox=\"0 0 10 10\" style=\"display:inline;width:.8em\" aria-hidden=\"true\">\
             <rect class=\"{class}\" width=\"10\" height=\"10\"/></svg> {class}"
        )
    };
    timeline::CLASSES
        .iter()
        .map(item)
        .collect::<Vec<_>>()
        .join(", ")
}

//! The page's parts, from the top to the bottom.

use super::{Page, Run, chart, escaped};
use crate::compare::Entry;
use crate::compare::verdict::Verdict;

pub(super) fn heading(page: &Page<'_>) -> String {
    let comparison = page.comparison;
    let totals = &comparison.totals;
    let verdict = comparison.verdict;
    let mut numbers = String::new();
    let mut number = |name: &str, value: String| {
        numbers += &format!("<li><b>{}</b><span>{name}</span></li>\n", escaped(&value));
    };
    number("pairs of frames", totals.frames().to_string());
    if totals.missing() > 0 {
        number("without a partner", totals.missing().to_string());
    }
    number("identical", totals.identical.to_string());
    if totals.compared > 0 {
        let psnr = totals.psnr();
        let psnr = if psnr.is_finite() {
            format!("{psnr:.2} dB")
        } else {
            "∞".to_owned()
        };
        number("largest difference", format!("{:.5}", totals.max));
        number("PSNR", psnr);
        number(
            "above the tolerance",
            format!("{:.3} %", 100.0 * totals.share_above()),
        );
    }
    if let Some(film) = &totals.perceived {
        number("mean FLIP", format!("{:.5}", film.flip()));
        if let Some(ssim) = film.ssim() {
            number("mean SSIM", format!("{ssim:.5}"));
        }
    }
    if let Some(film) = &totals.flicker {
        let share = 100.0 * film.all.share_added();
        number("flicker: changes in B only", format!("{share:.3} %"));
    }
    if let Some(point) = page.points.last().filter(|_| page.points.len() == 2) {
        number(
            "as fast as the plain film",
            format!("{:.2} ×", point.speedup),
        );
    }
    let reason = comparison
        .reason
        .as_deref()
        .map(escaped)
        .unwrap_or_default();
    format!(
        "<h1>{}</h1>\n<p class=\"{}\"><strong>{}</strong> {reason}</p>\n<ul class=\"numbers\">\n{numbers}</ul>\n",
        escaped(&page.title),
        class(verdict),
        verdict.words()
    )
}

fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Within => "within",
        Verdict::Warning => "warning",
        Verdict::Failed => "failed",
        Verdict::NotComparable => "not-comparable",
        Verdict::Unreadable => "unreadable",
    }
}

pub(super) fn curve(page: &Page<'_>) -> String {
    if page.points.is_empty() {
        return String::new();
    }
    format!(
        "<h2>Speed against error</h2>\n<figure>{}<figcaption>Right is faster, low is closer to the \
         plain film. Hollow: another setting is both.</figcaption></figure>\n",
        chart::trade(&page.points)
    )
}

/// The errors by frame and the periods: both along the film.
pub(super) fn film(page: &Page<'_>) -> String {
    let mut text = String::new();
    let errors: Vec<f64> = page
        .comparison
        .entries
        .iter()
        .filter_map(|entry| match entry {
            Entry::Pair(pair) => Some(pair.metrics.as_ref()?.perceived?.flip.mean),
            Entry::Missing { .. } => None,
        })
        .collect();
    if errors.len() > 1 {
        let drawing = chart::by_frame(&errors);
        text += &format!("<h2>Error along the film</h2>\n<figure>{drawing}</figure>\n");
    }
    for run in page.runs.iter().filter(|run| !run.periods.is_empty()) {
        text += &format!(
            "<h2>Periods of {}</h2>\n<figure>{}<figcaption>Objects by class: {}. The number is the \
             period's first frame.</figcaption></figure>\n",
            escaped(&run.label),
            chart::periods(run),
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
    chart::CLASSES
        .iter()
        .map(item)
        .collect::<Vec<_>>()
        .join(", ")
}

pub(super) fn viewer(frames: &[usize]) -> String {
    if frames.is_empty() {
        return String::new();
    }
    let modes = [
        ("slider", "1 Slider"),
        ("side", "2 Side by side"),
        ("flicker", "3 Flicker"),
        ("difference", "4 Difference ×16"),
    ];
    let button = |(mode, words): (&str, &str)| {
        format!(
            "<button type=\"button\" data-mode=\"{mode}\" aria-pressed=\"false\">{words}</button>\n"
        )
    };
    let buttons: String = modes.into_iter().map(button).collect();
    format!(
        "<h2>Frames, worst first</h2>\n<div id=\"viewer\">\n<div class=\"bar\">\n\
         <button type=\"button\" data-step=\"-1\" aria-label=\"Frame before\">←</button>\n\
         <button type=\"button\" data-step=\"1\" aria-label=\"Next frame\">→</button>\n{buttons}</div>\n\
         <p id=\"frame-name\" aria-live=\"polite\"></p>\n\
         <div class=\"stage slider\"><img alt=\"\"><img alt=\"\"></div>\n\
         <input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" aria-label=\"Where A ends and B begins\">\n\
         <p class=\"faint\">A is at the left, B at the right. Keys: <kbd>←</kbd> <kbd>→</kbd> frame, \
         <kbd>1</kbd> to <kbd>4</kbd> ways to look, <kbd>space</kbd> the other picture of the flicker.</p>\n</div>\n"
    )
}

pub(super) fn table(page: &Page<'_>, worst: &[usize]) -> String {
    let mut rows = String::new();
    let shown = worst.iter().copied().enumerate();
    for (row, k) in shown {
        let Some(Entry::Pair(pair)) = page.comparison.entries.get(k) else {
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
            class(pair.verdict),
            pair.verdict.words()
        );
    }
    let mut text = String::new();
    if !rows.is_empty() {
        text += &format!(
            "<div class=\"scroll\"><table>\n<thead><tr><th>frame</th><th>FLIP</th><th>SSIM</th>\
             <th>max</th><th>PSNR dB</th><th>above</th><th>flicker</th><th>verdict</th></tr></thead>\n\
             <tbody>\n{rows}</tbody>\n</table></div>\n"
        );
    }
    let without = page
        .comparison
        .entries
        .iter()
        .filter_map(|entry| match entry {
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

/// How the films were made, on which machine, with which versions.
pub(super) fn runs(page: &Page<'_>) -> String {
    let mut text = String::from("<h2>Made with</h2>\n");
    for run in &page.runs {
        text += &facts(run);
    }
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    text += &format!(
        "<p class=\"faint\">Compared by decor {} on {} ({}), {threads} threads.</p>\n",
        env!("CARGO_PKG_VERSION"),
        std::env::consts::OS,
        std::env::consts::ARCH,
    );
    text
}

fn facts(run: &Run) -> String {
    let facts: Vec<String> = run
        .facts
        .iter()
        .map(|(name, value)| format!("{} {}", escaped(name), escaped(value)))
        .collect();
    format!(
        "<p><b>{}</b>: {}</p>\n",
        escaped(&run.label),
        facts.join(", ")
    )
}

//! The page's parts, from the top to the bottom.

use super::{Page, Run, Shown, chart, escaped};
use crate::compare::verdict::Verdict;

pub(super) fn heading(page: &Page<'_>) -> String {
    let title = escaped(&page.title);
    if let ([], Some(shown)) = (page.numbers.as_slice(), page.shown.first()) {
        return format!("<h1>{title}</h1>\n{}", verdict(page, shown));
    }
    let item = |(name, value): &(String, String)| number_item(name, value);
    let numbers: String = page.numbers.iter().map(item).collect();
    format!("<h1>{title}</h1>\n<ul class=\"numbers\">\n{numbers}</ul>\n")
}

fn number_item(name: &str, value: &str) -> String {
    let (name, value) = (escaped(name), escaped(value));
    format!("<li><b>{value}</b><span>{name}</span></li>\n")
}

fn verdict(page: &Page<'_>, shown: &Shown<'_>) -> String {
    let comparison = shown.comparison;
    let totals = &comparison.totals;
    let verdict = comparison.verdict;
    let mut numbers = String::new();
    let mut number = |name: &str, value: String| numbers += &number_item(name, &value);
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
    if let [_, point] = page.curve.points.as_slice()
        && let Some(speedup) = point.speeds.first()
    {
        number("as fast as the plain film", format!("{speedup:.2} ×"));
    }
    let reason = comparison
        .reason
        .as_deref()
        .map(escaped)
        .unwrap_or_default();
    format!(
        "<p class=\"{}\"><strong>{}</strong> {reason}</p>\n<ul class=\"numbers\">\n{numbers}</ul>\n",
        class(verdict),
        verdict.words()
    )
}

pub(super) fn class(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Within => "within",
        Verdict::Warning => "warning",
        Verdict::Failed => "failed",
        Verdict::NotComparable => "not-comparable",
        Verdict::Unreadable => "unreadable",
    }
}

pub(super) fn curve(page: &Page<'_>) -> String {
    let curve = &page.curve;
    if curve.points.is_empty() {
        return String::new();
    }
    let options = |names: &[String]| {
        let option = |(k, name): (usize, &String)| {
            format!("<option value=\"{k}\">{}</option>", escaped(name))
        };
        names.iter().enumerate().map(option).collect::<String>()
    };
    let mut choice = String::new();
    if curve.speeds.len() > 1 || curve.errors.len() > 1 {
        choice = format!(
            "<div class=\"bar\"><label>Speed by <select id=\"speed\">{}</select></label>\n\
             <label>Error <select id=\"error\">{}</select></label></div>\n",
            options(&curve.speeds),
            options(&curve.errors)
        );
    }
    let mut drawings = String::new();
    for speed in 0..curve.speeds.len() {
        for error in 0..curve.errors.len() {
            let hidden = if (speed, error) == (0, 0) {
                ""
            } else {
                " hidden"
            };
            drawings += &format!(
                "<div data-curve=\"{speed},{error}\"{hidden}>{}</div>\n",
                chart::trade(curve, speed, error)
            );
        }
    }
    format!(
        "<h2>Speed against error</h2>\n{choice}<figure tabindex=\"0\">{drawings}<figcaption>Right \
         is faster, low is closer to the plain film. Hollow: another setting is both.</figcaption>\
         </figure>\n"
    )
}

pub(super) fn table(page: &Page<'_>) -> String {
    let Some(table) = &page.table else {
        return String::new();
    };
    let cell = |tag: &'static str| move |text: &String| format!("<{tag}>{}</{tag}>", escaped(text));
    let head: String = table.head.iter().map(cell("th")).collect();
    let mut rows = String::new();
    for row in &table.rows {
        let cells: String = row.cells.iter().map(cell("td")).collect();
        let class = if row.strong { " class=\"front\"" } else { "" };
        let shown = row
            .shown
            .map_or_else(String::new, |k| format!(" data-choose=\"{k}\""));
        rows += &format!("<tr{class}{shown}>{cells}</tr>\n");
    }
    let item = |note: &String| format!("<li>{}</li>\n", escaped(note));
    let notes: String = table.notes.iter().map(item).collect();
    let notes = if notes.is_empty() {
        notes
    } else {
        format!("<ul class=\"notes\">\n{notes}</ul>\n")
    };
    format!(
        "<h2>Settings</h2>\n<div class=\"scroll settings\" tabindex=\"0\"><table>\n\
         <thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n</table></div>\n{notes}"
    )
}

pub(super) fn viewer(page: &Page<'_>, worst: &[Vec<usize>]) -> String {
    if worst.iter().all(Vec::is_empty) {
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
    let mut choice = String::new();
    let mut keys = "";
    if page.shown.len() > 1 {
        let option = |(k, shown): (usize, &Shown<'_>)| {
            format!("<option value=\"{k}\">{}</option>", escaped(&shown.label))
        };
        let options: String = page.shown.iter().enumerate().map(option).collect();
        choice = format!("<label>Setting <select id=\"shown\">{options}</select></label>\n");
        keys = " <kbd>p</kbd> <kbd>n</kbd> setting,";
    }
    format!(
        "<h2>Frames, worst first</h2>\n<div id=\"viewer\">\n<div class=\"bar\">\n{choice}\
         <button type=\"button\" data-step=\"-1\" aria-label=\"Frame before\">←</button>\n\
         <button type=\"button\" data-step=\"1\" aria-label=\"Next frame\">→</button>\n{buttons}</div>\n\
         <p id=\"frame-name\" aria-live=\"polite\"></p>\n\
         <div class=\"stage slider\"><img alt=\"\"><img alt=\"\"></div>\n\
         <input type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" aria-label=\"Where A ends and B begins\">\n\
         <p class=\"faint\">A is at the left, B at the right. Keys: <kbd>←</kbd> <kbd>→</kbd> frame,{keys} \
         <kbd>1</kbd> to <kbd>4</kbd> ways to look, <kbd>space</kbd> the other picture of the flicker.</p>\n</div>\n"
    )
}

/// How the films were made, on which machine, with which versions.
pub(super) fn runs(page: &Page<'_>) -> String {
    let mut text = String::from("<h2>Made with</h2>\n");
    for run in &page.runs {
        text += &facts(run);
    }
    text += &format!(
        "<p class=\"faint\">Compared by decor {} on: {}.</p>\n",
        env!("CARGO_PKG_VERSION"),
        escaped(&page.machine.to_string()),
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

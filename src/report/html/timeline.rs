//! The drawings of the page along the film, as SVG: the periods, and the objects
//! with their classes.

use std::fmt::Write as _;

use super::chart::WIDTH;
use super::escaped;
use super::run::{Object, Run};

/// The classes in the order they are piled up.
pub const CLASSES: [&str; 4] = ["immobile", "clipped", "slow", "fast"];

/// Room for the objects' names.
const NAMES: f64 = 150.0;
/// How high an object's row is.
const ROW: f64 = 15.0;
/// Rows at most: what moves most comes first.
const ROWS: usize = 60;

/// Where a frame is, in a drawing of so many pixels that begins at `left`.
struct Frames {
    start: u32,
    count: f64,
    left: f64,
}

impl Frames {
    fn of(run: &Run, left: f64) -> Self {
        let start = run.periods.iter().map(|period| period.start).min();
        let end = run.periods.iter().map(|p| p.start.saturating_add(p.length));
        let start = start.unwrap_or(0);
        Self {
            start,
            count: f64::from(end.max().unwrap_or(1).saturating_sub(start).max(1)),
            left,
        }
    }

    /// The left edge of a frame.
    fn x(&self, frame: u32) -> f64 {
        self.left + f64::from(frame.saturating_sub(self.start)) / self.count * (WIDTH - self.left)
    }

    fn width(&self, length: u32) -> f64 {
        (f64::from(length) / self.count * (WIDTH - self.left) - 1.0).max(0.5)
    }
}

/// The periods, a bar each, as high as the film has objects, by class.
pub fn periods(run: &Run) -> String {
    const HIGH: f64 = 84.0;
    let frames = Frames::of(run, 0.0);
    let most = run
        .periods
        .iter()
        .map(|period| period.objects.iter().sum::<u32>());
    let most = f64::from(most.max().unwrap_or(1).max(1));
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {}" role="img" aria-label="Periods of {}">"#,
        HIGH + 20.0,
        escaped(&run.label)
    );
    for period in &run.periods {
        let (x, width) = (frames.x(period.start), frames.width(period.length));
        let mut y = HIGH;
        let words: Vec<String> = CLASSES
            .iter()
            .zip(period.objects)
            .map(|(class, count)| format!("{count} {class}"))
            .collect();
        let last = period.start + period.length.max(1) - 1;
        let mut title = format!("frames {} to {last}: {}", period.start, words.join(", "));
        let mut class = "";
        if let Some(reason) = &period.whole {
            title += &format!("; rendered whole: {}", escaped(reason));
            class = " class=\"whole\"";
        }
        let _ = write!(svg, "<g{class}><title>{title}</title>");
        for (class, count) in CLASSES.iter().zip(period.objects) {
            let high = f64::from(count) / most * HIGH;
            y -= high;
            let _ = write!(
                svg,
                r#"<rect class="{class}" x="{x:.1}" y="{y:.1}" width="{width:.1}" height="{high:.1}"/>"#
            );
        }
        svg += "</g>";
        if width > 24.0 {
            let _ = write!(
                svg,
                r#"<text x="{x:.1}" y="{:.1}">{}</text>"#,
                HIGH + 15.0,
                period.start
            );
        }
    }
    svg + "</svg>"
}

/// The objects one by one, a row each: what is rendered in most frames first, then
/// what is kept although it moves. With the number of those left out.
pub fn objects(run: &Run) -> (String, usize) {
    let weight = |object: &Object, class: &str| {
        let spans = object
            .spans
            .iter()
            .filter(|span| CLASSES[span.class] == class);
        spans.map(|span| span.length).sum::<u32>()
    };
    let mut rows: Vec<&Object> = run.objects.iter().collect();
    rows.sort_by_key(|object| {
        let (fast, slow) = (weight(object, "fast"), weight(object, "slow"));
        std::cmp::Reverse((fast, slow))
    });
    let left_out = rows.len().saturating_sub(ROWS);
    rows.truncate(ROWS);
    let frames = Frames::of(run, NAMES);
    let height = ROW * rows.len() as f64 + 4.0;
    let mut svg = format!(
        r#"<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="Objects of {}">"#,
        escaped(&run.label)
    );
    for (k, object) in rows.iter().enumerate() {
        let y = ROW * k as f64;
        let name = escaped(&object.name);
        let _ = write!(
            svg,
            r#"<text x="{:.1}" y="{:.1}" text-anchor="end">{}</text>"#,
            NAMES - 6.0,
            y + ROW - 4.0,
            shortened(&object.name)
        );
        for span in &object.spans {
            let class = CLASSES[span.class];
            let last = span.start + span.length.max(1) - 1;
            let motion = span
                .motion_px
                .map_or_else(String::new, |px| format!(", {px:.2} px"));
            let _ = write!(
                svg,
                r#"<rect class="{class}" x="{:.1}" y="{:.1}" width="{:.1}" height="{:.1}"><title>{name}, frames {} to {last}: {class}{motion}</title></rect>"#,
                frames.x(span.start),
                y + 1.0,
                frames.width(span.length),
                ROW - 2.0,
                span.start,
            );
        }
    }
    (svg + "</svg>", left_out)
}

/// A name as far as there is room for it.
fn shortened(name: &str) -> String {
    const ROOM: usize = 22;
    if name.chars().count() <= ROOM {
        return escaped(name);
    }
    let end: String = name.chars().take(ROOM - 1).collect();
    escaped(&end) + "…"
}

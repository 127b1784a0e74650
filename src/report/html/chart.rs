//! The drawings of the page, as SVG: speed against error, error by frame, the
//! periods.

use std::fmt::Write as _;

use super::{Point, Run, escaped};

const WIDTH: f64 = 720.0;
/// Room for the labels at the left and at the bottom.
const LEFT: f64 = 64.0;
const BOTTOM: f64 = 36.0;
const TOP: f64 = 26.0;
const RIGHT: f64 = 16.0;

/// A linear axis from 0 to a round number.
struct Axis {
    end: f64,
    step: f64,
}

impl Axis {
    fn to(most: f64) -> Self {
        let most = if most > 0.0 { most } else { 1.0 };
        let power = 10.0_f64.powf(most.log10().floor());
        let step = [0.2, 0.5, 1.0, 2.0, 5.0]
            .into_iter()
            .map(|factor| factor * power)
            .find(|step| most / step <= 6.0)
            .unwrap_or(power);
        Self {
            end: (most / step).ceil() * step,
            step,
        }
    }

    fn ticks(&self) -> impl Iterator<Item = f64> + use<> {
        let count = (self.end / self.step).round() as u32;
        let step = self.step;
        (0..=count).map(move |k| f64::from(k) * step)
    }

    /// Digits enough for the steps.
    fn label(&self, value: f64) -> String {
        let digits = (-self.step.log10().floor()).max(0.0) as usize;
        format!("{value:.digits$}")
    }
}

/// The two axes, and where a value is between them.
struct Plot {
    text: String,
    x: Axis,
    y: Axis,
    height: f64,
}

impl Plot {
    fn new(height: f64, x: Axis, y: Axis, what: &str, names: (&str, &str)) -> Self {
        let mut plot = Self {
            text: format!(r#"<svg viewBox="0 0 {WIDTH} {height}" role="img" aria-label="{what}">"#),
            x,
            y,
            height,
        };
        let (floor, end) = (height - BOTTOM, WIDTH - RIGHT);
        for value in plot.y.ticks() {
            let (_, y) = plot.place(0.0, value);
            let label = plot.y.label(value);
            let text_y = y + 4.0;
            plot.add(&format!(
                r#"<line class="axis" x1="{LEFT}" x2="{end}" y1="{y:.1}" y2="{y:.1}"/><text x="{:.1}" y="{text_y:.1}" text-anchor="end">{label}</text>"#,
                LEFT - 6.0
            ));
        }
        for value in plot.x.ticks() {
            let (x, _) = plot.place(value, 0.0);
            let label = plot.x.label(value);
            plot.add(&format!(
                r#"<text x="{x:.1}" y="{:.1}" text-anchor="middle">{label}</text>"#,
                floor + 16.0
            ));
        }
        let (x_name, y_name) = names;
        plot.add(&format!(
            r#"<text x="{end}" y="{:.1}" text-anchor="end">{x_name}</text><text x="4" y="11">{y_name}</text>"#,
            height - 3.0
        ));
        plot
    }

    fn add(&mut self, text: &str) {
        self.text += text;
    }

    fn place(&self, x: f64, y: f64) -> (f64, f64) {
        let (wide, high) = (WIDTH - LEFT - RIGHT, self.height - BOTTOM - TOP);
        (
            LEFT + x / self.x.end * wide,
            TOP + (1.0 - y / self.y.end) * high,
        )
    }

    fn curve(&mut self, points: impl Iterator<Item = (f64, f64)>) {
        let mut path = String::new();
        for (x, y) in points {
            let (x, y) = self.place(x, y);
            let _ = write!(path, "{x:.1},{y:.1} ");
        }
        self.add(&format!(
            r#"<polyline class="curve" points="{}"/>"#,
            path.trim_end()
        ));
    }

    fn end(mut self) -> String {
        self.text += "</svg>";
        self.text
    }
}

/// Which points no other beats in both: as fast and less wrong, or faster and no
/// more wrong. In the order given.
pub fn front(points: &[Point]) -> Vec<bool> {
    let beats = |one: &Point, other: &Point| {
        one.speedup >= other.speedup
            && one.error <= other.error
            && (one.speedup > other.speedup || one.error < other.error)
    };
    points
        .iter()
        .map(|point| !points.iter().any(|other| beats(other, point)))
        .collect()
}

/// Speed against error; the front is joined, what is beaten is hollow.
pub fn trade(points: &[Point]) -> String {
    let most = |of: fn(&Point) -> f64| points.iter().map(of).fold(0.0, f64::max);
    let mut plot = Plot::new(
        300.0,
        Axis::to(most(|point| point.speedup)),
        Axis::to(most(|point| point.error)),
        "Speed against error",
        ("speed-up against frame by frame", "mean FLIP"),
    );
    let on_front = front(points);
    let mut best: Vec<&Point> = points
        .iter()
        .zip(&on_front)
        .filter_map(|(point, front)| front.then_some(point))
        .collect();
    best.sort_by(|one, other| one.speedup.total_cmp(&other.speedup));
    plot.curve(best.iter().map(|point| (point.speedup, point.error)));
    for (point, front) in points.iter().zip(on_front) {
        let (x, y) = plot.place(point.speedup, point.error);
        let class = if front { "point" } else { "beaten" };
        let label = escaped(&point.label);
        // Away from the nearer edge.
        let (anchor, text_x) = if x > WIDTH / 2.0 {
            ("end", x - 9.0)
        } else {
            ("start", x + 9.0)
        };
        plot.add(&format!(
            r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="5"><title>{label}: {:.2} times as fast, FLIP {:.5}</title></circle><text x="{text_x:.1}" y="{:.1}" text-anchor="{anchor}">{label}</text>"#,
            point.speedup,
            point.error,
            y - 7.0
        ));
    }
    plot.end()
}

/// The error frame by frame.
pub fn by_frame(errors: &[f64]) -> String {
    let most = errors.iter().copied().fold(0.0, f64::max);
    let last = errors.len().saturating_sub(1).max(1) as f64;
    let mut plot = Plot::new(
        180.0,
        Axis::to(last),
        Axis::to(most),
        "Error by frame",
        ("frame, counted from 0", "mean FLIP"),
    );
    plot.curve((0_u32..).map(f64::from).zip(errors.iter().copied()));
    plot.end()
}

/// The periods, a bar each, as high as the film has objects, by class.
pub fn periods(run: &Run) -> String {
    const HIGH: f64 = 84.0;
    let end = run
        .periods
        .iter()
        .map(|period| period.start + period.length);
    let start = run
        .periods
        .iter()
        .map(|period| period.start)
        .min()
        .unwrap_or(0);
    let frames = f64::from(end.max().unwrap_or(1).saturating_sub(start).max(1));
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
        let x = f64::from(period.start - start) / frames * WIDTH;
        let width = (f64::from(period.length) / frames * WIDTH - 1.0).max(0.5);
        let mut y = HIGH;
        let words: Vec<String> = CLASSES
            .iter()
            .zip(period.objects)
            .map(|(class, count)| format!("{count} {class}"))
            .collect();
        let last = period.start + period.length.max(1) - 1;
        let title = format!("frames {} to {last}: {}", period.start, words.join(", "));
        let _ = write!(svg, "<g><title>{title}</title>");
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

/// The classes in the order they are piled up.
pub const CLASSES: [&str; 4] = ["immobile", "clipped", "slow", "fast"];

//! The drawings of the page that have axes, as SVG: speed against error, error by
//! frame.

use std::fmt::Write as _;

use super::{Curve, escaped};

pub(super) const WIDTH: f64 = 720.0;
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
/// more wrong. In the order given; each is a speed and an error.
pub fn front(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |one: &(f64, f64), other: &(f64, f64)| {
        one.0 >= other.0 && one.1 <= other.1 && (one.0 > other.0 || one.1 < other.1)
    };
    points
        .iter()
        .map(|point| !points.iter().any(|other| beats(other, point)))
        .collect()
}

/// More points than these have numbers in place of names, as in the table.
const NAMES: usize = 3;

/// One of the curve's speeds against one of its errors; the front is joined, what is
/// beaten is hollow.
pub fn trade(curve: &Curve, speed: usize, error: usize) -> String {
    let places = curve.points.iter();
    let places: Vec<(f64, f64)> = places.map(|p| (p.speeds[speed], p.errors[error])).collect();
    let most = |of: fn(&(f64, f64)) -> f64| places.iter().map(of).fold(0.0, f64::max);
    let (speed, error) = (&curve.speeds[speed], &curve.errors[error]);
    let mut plot = Plot::new(
        300.0,
        Axis::to(most(|place| place.0)),
        Axis::to(most(|place| place.1)),
        &escaped(&format!("Speed by {speed} against {error}")),
        (
            &escaped(&format!("times as fast as frame by frame, by {speed}")),
            &escaped(error),
        ),
    );
    let on_front = front(&places);
    let mut best: Vec<(f64, f64)> = places
        .iter()
        .zip(&on_front)
        .filter_map(|(place, front)| front.then_some(*place))
        .collect();
    best.sort_by(|one, other| one.0.total_cmp(&other.0));
    plot.curve(best.into_iter());
    // Points at one place share a label.
    let mut labels: Vec<((String, String), Vec<usize>)> = Vec::new();
    for (k, &(x, y)) in places.iter().enumerate() {
        let (x, y) = plot.place(x, y);
        let at = (format!("{x:.0}"), format!("{y:.0}"));
        match labels.iter_mut().find(|(place, _)| *place == at) {
            Some((_, points)) => points.push(k),
            None => labels.push((at, vec![k])),
        }
    }
    for (_, points) in &labels {
        let (at, front) = (places[points[0]], on_front[points[0]]);
        let (x, y) = plot.place(at.0, at.1);
        let class = if front { "point" } else { "beaten" };
        let name = |&k: &usize| {
            if places.len() > NAMES {
                (k + 1).to_string()
            } else {
                escaped(&curve.points[k].label)
            }
        };
        let label = points.iter().map(name).collect::<Vec<_>>().join(", ");
        let names: Vec<String> = points
            .iter()
            .map(|&k| format!("{}: {}", k + 1, escaped(&curve.points[k].label)))
            .collect();
        // Away from the nearer edge.
        let (anchor, text_x) = if x > WIDTH / 2.0 {
            ("end", x - 9.0)
        } else {
            ("start", x + 9.0)
        };
        plot.add(&format!(
            r#"<circle class="{class}" cx="{x:.1}" cy="{y:.1}" r="5"><title>{}. {:.2} times as fast, {} {:.5}</title></circle><text x="{text_x:.1}" y="{:.1}" text-anchor="{anchor}">{label}</text>"#,
            names.join("; "),
            at.0,
            escaped(error),
            at.1,
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

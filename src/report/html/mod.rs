//! A comparison as one HTML file that needs nothing else: no network, no folder
//! beside it. Speed against error, the periods, the frames side by side with the
//! worst first, the machine and the versions.

mod chart;
mod pictures;
mod sections;

use std::path::Path;

use serde_json::Value;

use crate::compare::{Comparison, Entry};

pub use chart::front;
pub use pictures::PictureDataError;

/// What the page shows.
pub struct Page<'a> {
    /// Its heading.
    pub title: String,
    /// The comparison; A is the plain film.
    pub comparison: &'a Comparison,
    /// Settings with their speed and error; the curve is left out where there is
    /// none.
    pub points: Vec<Point>,
    /// How the films were made.
    pub runs: Vec<Run>,
    /// Frames whose pictures are put into the page: the worst.
    pub frames: usize,
}

/// A setting, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What it is called.
    pub label: String,
    /// How many times as fast as frame by frame, by wall time.
    pub speedup: f64,
    /// The film's mean FLIP.
    pub error: f64,
}

/// What is known of how a film was made: from its `decor.json`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// What it is called.
    pub label: String,
    /// What the user chose and what it was made with, in pairs of a word and a
    /// value.
    pub facts: Vec<(String, String)>,
    /// Wall time in seconds.
    pub wall_s: Option<f64>,
    /// The periods.
    pub periods: Vec<Period>,
}

/// A period and its objects by class.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Period {
    /// Its first frame.
    pub start: u32,
    /// Its frames.
    pub length: u32,
    /// Immobile, clipped, slow, fast.
    pub objects: [u32; 4],
}

impl Run {
    /// Reads `decor.json` in the folder of a film's frames; nothing where there is
    /// none, or another program's.
    pub fn read(label: &str, folder: &Path) -> Option<Self> {
        let text = std::fs::read_to_string(folder.join("decor.json")).ok()?;
        Self::of(label, &serde_json::from_str(&text).ok()?)
    }

    /// Takes the summary of `decor render`; nothing where it is none.
    pub fn of(label: &str, summary: &Value) -> Option<Self> {
        summary.get("decor")?;
        const FACTS: [&str; 11] = [
            "film",
            "mode",
            "threshold_px",
            "renderer",
            "renderer_version",
            "decor",
            "frames",
            "format",
            "wall_s",
            "cpu_s",
            "machine",
        ];
        let fact = |name: &&str| match summary.get(*name)? {
            Value::Null => None,
            Value::String(text) => Some(((*name).to_owned(), text.clone())),
            other => Some(((*name).to_owned(), other.to_string())),
        };
        let number = |value: &Value, name: &str| {
            let number = value.get(name).and_then(Value::as_u64);
            number.and_then(|number| u32::try_from(number).ok())
        };
        let period = |period: &Value| {
            let classes = period.get("objects");
            let of_class = |class: &str| {
                classes
                    .and_then(|classes| number(classes, class))
                    .unwrap_or(0)
            };
            Some(Period {
                start: number(period, "start")?,
                length: number(period, "length")?,
                objects: chart::CLASSES.map(of_class),
            })
        };
        let periods = summary.get("periods").and_then(Value::as_array);
        Some(Self {
            label: label.to_owned(),
            facts: FACTS.iter().filter_map(fact).collect(),
            wall_s: summary.get("wall_s").and_then(Value::as_f64),
            periods: periods
                .map(|periods| periods.iter().filter_map(period).collect())
                .unwrap_or_default(),
        })
    }
}

/// The points of a comparison of two films: the plain one, and the other where
/// both times are known.
pub fn points(comparison: &Comparison, plain: Option<&Run>, other: Option<&Run>) -> Vec<Point> {
    let (Some(plain), Some(other)) = (plain, other) else {
        return Vec::new();
    };
    let film = comparison.totals.perceived.as_ref();
    match (plain.wall_s, other.wall_s, film) {
        (Some(whole), Some(wall), Some(film)) if whole > 0.0 && wall > 0.0 => vec![
            Point {
                label: plain.label.clone(),
                speedup: 1.0,
                error: 0.0,
            },
            Point {
                label: other.label.clone(),
                speedup: whole / wall,
                error: film.flip(),
            },
        ],
        _ => Vec::new(),
    }
}

impl Page<'_> {
    /// The file's text.
    ///
    /// # Errors
    /// Where a picture that is to be shown cannot be read any more.
    pub fn html(&self) -> Result<String, PictureDataError> {
        let worst = self.worst();
        let frames = pictures::json(self.comparison, &worst)?;
        let body: String = [
            sections::heading(self),
            sections::curve(self),
            sections::film(self),
            sections::viewer(&worst),
            sections::table(self, &worst),
            sections::runs(self),
        ]
        .concat();
        let title = escaped(&self.title);
        Ok(format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{}</style>\n\
             </head>\n<body>\n{body}<script type=\"application/json\" id=\"frames\">{frames}</script>\n\
             <script>\n{}</script>\n</body>\n</html>\n",
            include_str!("page.css"),
            include_str!("page.js"),
        ))
    }

    /// The numbers, among the entries, of the pairs that are shown: the most
    /// different first, by FLIP, then by the largest difference, then by name.
    fn worst(&self) -> Vec<usize> {
        let key = |entry: &Entry| match entry {
            Entry::Pair(pair) => pair.metrics.as_ref().map(|metrics| {
                let flip = metrics.perceived.map_or(0.0, |seen| seen.flip.mean);
                (flip, metrics.max)
            }),
            Entry::Missing { .. } => None,
        };
        let entries = self.comparison.entries.iter().enumerate();
        let mut pairs: Vec<(usize, (f64, f64))> = entries
            .filter_map(|(k, entry)| Some((k, key(entry)?)))
            .collect();
        pairs.sort_by(|(_, one), (_, other)| {
            let by_flip = other.0.total_cmp(&one.0);
            by_flip.then(other.1.total_cmp(&one.1))
        });
        pairs
            .into_iter()
            .take(self.frames)
            .map(|(k, _)| k)
            .collect()
    }
}

/// Text that HTML takes for text, in attributes too.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped += "&amp;",
            '<' => escaped += "&lt;",
            '>' => escaped += "&gt;",
            '"' => escaped += "&quot;",
            '\'' => escaped += "&#39;",
            c => escaped.push(c),
        }
    }
    escaped
}

//! How a film was made, as the page shows it.

use std::path::Path;

use serde_json::Value;

use super::timeline::CLASSES;

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
    /// The objects one by one, where they are known.
    pub objects: Vec<Object>,
    /// The number of the comparison that it belongs to, where it is to be seen
    /// with that only.
    pub shown: Option<usize>,
}

/// A period and its objects by class.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Period {
    /// Its first frame.
    pub start: u32,
    /// Its frames.
    pub length: u32,
    /// Immobile, clipped, slow, fast.
    pub objects: [u32; 4],
    /// Why its frames are rendered whole, where they are.
    pub whole: Option<String>,
}

/// An object along the film.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Object {
    /// What it is called.
    pub name: String,
    /// Its classes, period by period.
    pub spans: Vec<Span>,
}

/// An object in one period.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// The period's first frame.
    pub start: u32,
    /// Its frames.
    pub length: u32,
    /// Its class: immobile, clipped, slow, fast.
    pub class: usize,
    /// How far it moves in the picture, in pixels; none where that is unbounded.
    pub motion_px: Option<f64>,
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
                objects: CLASSES.map(of_class),
                whole: period
                    .get("whole")
                    .and_then(Value::as_str)
                    .map(str::to_owned),
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
            objects: Vec::new(),
            shown: None,
        })
    }
}

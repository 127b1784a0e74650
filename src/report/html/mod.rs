//! Comparisons as one HTML file that needs nothing else: no network, no folder
//! beside it. Speed against error, the periods, the frames side by side with the
//! worst first, the machine and the versions.

mod chart;
mod film;
mod pictures;
mod run;
mod sections;
mod timeline;

use crate::compare::{Comparison, Entry};
use crate::report::Machine;

pub use chart::front;
pub use pictures::PictureDataError;
pub use run::{Object, Period, Run, Span};

/// What the page shows.
pub struct Page<'a> {
    /// Its heading.
    pub title: String,
    /// What stands first: numbers with their names. Where there are none, those of
    /// the first comparison, and its verdict.
    pub numbers: Vec<(String, String)>,
    /// The comparisons that can be looked at, one at a time; A is the plain film.
    pub shown: Vec<Shown<'a>>,
    /// Settings with their speed and error; left out where there is none.
    pub curve: Curve,
    /// The same in numbers, and what has to be said of them.
    pub table: Option<Table>,
    /// How the films were made.
    pub runs: Vec<Run>,
    /// Where it was measured.
    pub machine: Machine,
}

/// A comparison to look at.
pub struct Shown<'a> {
    /// What it is called.
    pub label: String,
    /// The comparison.
    pub comparison: &'a Comparison,
    /// Frames whose pictures are put into the page: the worst.
    pub frames: usize,
}

/// Settings, measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// The names of the speeds: how many times as fast as frame by frame.
    pub speeds: Vec<String>,
    /// The names of the errors: less is better.
    pub errors: Vec<String>,
    /// The settings.
    pub points: Vec<Point>,
}

/// A setting, measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What it is called.
    pub label: String,
    /// One for each of the curve's speeds.
    pub speeds: Vec<f64>,
    /// One for each of the curve's errors.
    pub errors: Vec<f64>,
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// The columns' heads.
    pub head: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
    /// What has to be said below it.
    pub notes: Vec<String>,
}

/// A row of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// A cell for each column.
    pub cells: Vec<String>,
    /// The number of the comparison that it is of, where that can be looked at.
    pub shown: Option<usize>,
    /// Does it stand out?
    pub strong: bool,
}

/// The curve of a comparison of two films: the plain one, and the other where both
/// times are known.
pub fn curve(comparison: &Comparison, plain: Option<&Run>, other: Option<&Run>) -> Curve {
    let (Some(plain), Some(other)) = (plain, other) else {
        return Curve::default();
    };
    let film = comparison.totals.perceived.as_ref();
    match (plain.wall_s, other.wall_s, film) {
        (Some(whole), Some(wall), Some(film)) if whole > 0.0 && wall > 0.0 => Curve {
            speeds: vec!["wall time".to_owned()],
            errors: vec!["mean FLIP".to_owned()],
            points: vec![
                Point {
                    label: plain.label.clone(),
                    speeds: vec![1.0],
                    errors: vec![0.0],
                },
                Point {
                    label: other.label.clone(),
                    speeds: vec![whole / wall],
                    errors: vec![film.flip()],
                },
            ],
        },
        _ => Curve::default(),
    }
}

impl Page<'_> {
    /// The file's text.
    ///
    /// # Errors
    /// Where a picture that is to be shown cannot be read any more.
    pub fn html(&self) -> Result<String, PictureDataError> {
        let worst: Vec<Vec<usize>> = self.shown.iter().map(Shown::worst).collect();
        let frames = pictures::json(&self.shown, &worst)?;
        let body: String = [
            sections::heading(self),
            sections::curve(self),
            sections::table(self),
            sections::viewer(self, &worst),
            film::tables(self, &worst),
            film::errors(self),
            film::periods(self),
            sections::runs(self),
        ]
        .concat();
        let title = escaped(&self.title);
        Ok(format!(
            "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <link rel=\"icon\" href=\"data:,\">\n<title>{title}</title>\n<style>\n{}</style>\n\
             </head>\n<body>\n<main>\n{body}</main>\n\
             <script type=\"application/json\" id=\"frames\">{frames}</script>\n\
             <script>\n{}</script>\n</body>\n</html>\n",
            include_str!("page.css"),
            include_str!("page.js"),
        ))
    }
}

impl Shown<'_> {
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
        let shown = pairs.into_iter().take(self.frames);
        shown.map(|(k, _)| k).collect()
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

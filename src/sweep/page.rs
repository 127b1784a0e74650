//! A sweep as a page to look at.

use std::path::Path;

use super::{Errors, Measured, SweepError, Swept, table};
use crate::report::html::{Curve, Object, Page, Period, Point, Row, Run, Shown, Span, Table};
use crate::segmentation::Class;

/// Pictures in the page are two a frame: so many frames of each setting, the worst.
const FRAMES: usize = 4;
/// Settings whose frames are in the page: those on the front, the fastest first,
/// then the others; at the end those without any error, which show nothing.
const SHOWN: usize = 8;

/// An error's name, and where it is: less is better.
type Named = (&'static str, fn(&Errors) -> f64);

/// The errors that can be looked at.
const ERRORS: [Named; 6] = [
    ("mean FLIP", |errors| errors.flip),
    ("1 − SSIM", |errors| 1.0 - errors.ssim.unwrap_or(1.0)),
    ("RMS", |errors| errors.rms),
    ("largest difference", |errors| errors.max),
    ("flicker, % of the pixels", |errors| 100.0 * errors.flicker),
    ("motion kept, pixels", |errors| errors.motion_px),
];

impl Swept<'_> {
    /// The page.
    ///
    /// # Errors
    /// Where a frame cannot be read any more.
    pub fn html(&self) -> Result<String, SweepError> {
        let shown = self.shown();
        let page = Page {
            title: format!("{}: speed against accuracy", self.name()),
            numbers: self.numbers(),
            shown: shown
                .iter()
                .map(|&k| Shown {
                    label: format!("{}. {}", k + 1, self.settings[k].setting),
                    comparison: &self.settings[k].comparison,
                    frames: FRAMES,
                })
                .collect(),
            curve: self.curve(),
            table: Some(self.table(&shown)),
            runs: self.runs(&shown),
            machine: self.machine.clone(),
        };
        Ok(page.html()?)
    }

    /// The film's file, without the folders.
    fn name(&self) -> String {
        let name = Path::new(&self.film).file_name();
        name.map_or_else(
            || self.film.clone(),
            |name| name.to_string_lossy().into_owned(),
        )
    }

    /// The settings with frames in the page.
    fn shown(&self) -> Vec<usize> {
        let mut shown = self.front();
        let others = (0..self.settings.len()).filter(|&k| self.settings[k].same_as.is_none());
        let others: Vec<usize> = others.filter(|k| !shown.contains(k)).collect();
        shown.extend(others);
        // The sort keeps the order of the rest.
        shown.sort_by_key(|&k| self.settings[k].errors.max == 0.0);
        shown.truncate(SHOWN);
        shown
    }

    fn numbers(&self) -> Vec<(String, String)> {
        let size = self.stage.size();
        let mut numbers = vec![
            (
                "frames".to_owned(),
                (self.frames.1 - self.frames.0 + 1).to_string(),
            ),
            (
                "pixels".to_owned(),
                format!("{} × {}", size.width, size.height),
            ),
            (
                "frame by frame".to_owned(),
                format!("{:.2} s", self.reference.price.wall_s),
            ),
            ("settings".to_owned(), self.settings.len().to_string()),
        ];
        let best = |allowed: fn(&Errors) -> bool| {
            let speeds = self.settings.iter().filter(|s| allowed(&s.errors));
            speeds
                .map(|setting| self.speedup(setting).wall)
                .max_by(f64::total_cmp)
        };
        let same: fn(&Errors) -> bool = |errors| errors.max == 0.0;
        for (name, allowed) in [
            ("as fast without any difference", same),
            ("as fast with a mean FLIP up to 0.01", |e| e.flip <= 0.01),
            ("as fast at most", |_| true),
        ] {
            if let Some(speedup) = best(allowed) {
                numbers.push((name.to_owned(), format!("{speedup:.2} ×")));
            }
        }
        numbers
    }

    fn curve(&self) -> Curve {
        let point = |one: &Measured| {
            let speedup = self.speedup(one);
            Point {
                label: one.setting.to_string(),
                speeds: vec![speedup.wall, speedup.cpu, speedup.traced],
                errors: ERRORS.iter().map(|(_, of)| of(&one.errors)).collect(),
            }
        };
        Curve {
            speeds: ["wall time", "CPU time", "traced pixels"]
                .map(str::to_owned)
                .to_vec(),
            errors: ERRORS.iter().map(|(name, _)| (*name).to_owned()).collect(),
            points: self.settings.iter().map(point).collect(),
        }
    }

    fn table(&self, shown: &[usize]) -> Table {
        let row = |k: usize| {
            let first = self.settings[k].same_as.unwrap_or(k);
            Row {
                cells: table::cells(self, k).to_vec(),
                shown: shown.iter().position(|&other| other == first),
                strong: self.trades[k].on_front,
            }
        };
        let mut notes = vec![
            format!(
                "Speeds are against {}. Green: no other setting is both as fast, on the clock, \
                 and as close, by FLIP. Chosen rows are shown below.",
                table::against(self)
            ),
            format!(
                "Flicker: pixels that change from one frame to the next by more than {} in the \
                 setting's film only. Motion: how far anything in a décor moves at most.",
                self.level
            ),
        ];
        notes.extend(table::notes(self));
        Table {
            head: table::HEAD.map(str::to_owned).to_vec(),
            rows: (0..self.settings.len()).map(row).collect(),
            notes,
        }
    }

    fn runs(&self, shown: &[usize]) -> Vec<Run> {
        let fact = |name: &str, value: String| (name.to_owned(), value);
        let abilities = self.stage.adapter.abilities();
        let mut facts = vec![
            fact("film", self.film.clone()),
            fact("frames", format!("{} to {}", self.frames.0, self.frames.1)),
            fact("renderer", self.stage.adapter.name().to_owned()),
            fact("version", abilities.version.clone()),
            fact("decor", env!("CARGO_PKG_VERSION").to_owned()),
        ];
        facts.push(fact("runs of each setting", self.runs.to_string()));
        let all = Run {
            label: "All settings".to_owned(),
            facts,
            ..Run::default()
        };
        let of_setting = |(place, &k): (usize, &usize)| {
            let one = &self.settings[k];
            Run {
                label: format!("{}. {}", k + 1, one.setting),
                facts: vec![fact("decor render", one.setting.options())],
                wall_s: Some(one.price.wall_s),
                periods: periods(one),
                objects: self.objects(one),
                shown: Some(place),
            }
        };
        let settings = shown.iter().enumerate().map(of_setting);
        std::iter::once(all).chain(settings).collect()
    }

    fn objects(&self, one: &Measured) -> Vec<Object> {
        let identities = self.stage.film.identities().iter();
        let mut objects: Vec<Object> = identities
            .map(|identity| Object {
                name: identity.name().to_owned(),
                spans: Vec::new(),
            })
            .collect();
        for period in &one.plan.periods {
            for object in &period.objects {
                objects[object.object.0 as usize].spans.push(Span {
                    start: period.start,
                    length: period.len(),
                    class: object.class as usize,
                    motion_px: Some(object.motion_px).filter(|px| px.is_finite()),
                });
            }
        }
        objects
    }
}

fn periods(one: &Measured) -> Vec<Period> {
    let count = |period: &crate::plan::Period, class| {
        u32::try_from(period.count(class)).unwrap_or(u32::MAX)
    };
    let periods = one.plan.periods.iter();
    periods
        .map(|period| Period {
            start: period.start,
            length: period.len(),
            objects: Class::ALL.map(|class| count(period, class)),
            whole: period.whole.as_ref().map(ToString::to_string),
        })
        .collect()
}

//! A sweep as JSON: `sweep.json`, and the lines of `--json`.
//!
//! The same sweep gives the same report but for times, and for what follows from
//! them: speed-ups, and who beats whom.

use serde::Serialize;

use super::{Against, Errors, Measured, Setting, Swept};
use crate::plan::End;
use crate::report::Machine;
use crate::segmentation::Class;

/// How many times as fast as frame by frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Speedup {
    /// On the clock.
    pub wall: f64,
    /// By the seconds of all cores.
    pub cpu: f64,
    /// By the pixels that the renderer was asked for.
    pub traced: f64,
}

/// A setting.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "setting")]
pub struct SettingLine {
    /// Its number, from 1.
    pub number: usize,
    /// Its name.
    pub name: String,
    /// The setting.
    #[serde(flatten)]
    pub setting: Setting,
    /// The options of `decor render` that ask for it.
    pub options: String,
    /// Is every frame rendered whole although something else was asked?
    pub fallback: bool,
    /// The number of the setting before whose plan is the same: what was measured
    /// is its.
    pub same_plan_as: Option<usize>,
    /// Seconds on the clock, planning included; the median of the runs.
    pub wall_s: f64,
    /// Seconds of all cores, likewise.
    pub cpu_s: f64,
    /// Calls of the renderer.
    pub renderer_calls: u64,
    /// Pictures in them.
    pub renderer_frames: u64,
    /// Pixels that the renderer was asked for.
    pub pixels_traced: u64,
    /// How many times as fast as what it was measured against.
    pub speedup: Speedup,
    /// How many times as fast as `full`, where that is among the settings.
    pub speedup_full: Option<Speedup>,
    /// How far its film is from frame by frame.
    pub errors: Errors,
    /// Does no other beat it, by wall time and mean FLIP?
    pub on_front: bool,
    /// The number of one that does.
    pub beaten_by: Option<usize>,
    /// Why.
    pub why: Option<String>,
}

/// A period of a setting's plan.
#[derive(Debug, Serialize)]
struct PeriodLine {
    start: u32,
    length: u32,
    end: End,
    dissolves_until: Option<u32>,
    whole: Option<String>,
    /// The classes of the objects, in the order of `objects` of the sweep: i, c, s,
    /// f for immobile, clipped, slow, fast; - for an object that is not there.
    classes: String,
}

/// What was measured against.
#[derive(Debug, Serialize)]
struct ReferenceLine {
    against: Against,
    wall_s: f64,
    cpu_s: f64,
    pixels_traced: u64,
}

/// The last line: the sweep.
#[derive(Debug, Serialize)]
#[serde(tag = "type", rename = "summary")]
pub struct SweepLine<'a> {
    decor: &'static str,
    film: &'a str,
    frames: u32,
    first_frame: u32,
    width: u32,
    height: u32,
    renderer: &'a str,
    renderer_version: &'a str,
    machine: &'a Machine,
    runs: usize,
    /// A difference above this counts for the share and for the flicker.
    level: f64,
    reference: ReferenceLine,
    settings: usize,
    /// The numbers of the settings that no other beats, the fastest first.
    front: Vec<usize>,
}

/// The whole file.
#[derive(Debug, Serialize)]
struct Whole<'a> {
    #[serde(flatten)]
    sweep: SweepLine<'a>,
    objects: Vec<&'a str>,
    measured: Vec<WithPeriods>,
}

#[derive(Debug, Serialize)]
struct WithPeriods {
    #[serde(flatten)]
    setting: SettingLine,
    periods: Vec<PeriodLine>,
}

impl Swept<'_> {
    /// How many times as fast as frame by frame a setting is.
    pub fn speedup(&self, one: &Measured) -> Speedup {
        let reference = &self.reference;
        ratio(one, reference.price, reference.made.traced())
    }

    /// As fast as `full`, where that was measured.
    pub fn speedup_full(&self, one: &Measured) -> Option<Speedup> {
        let full = self.settings.iter().find(|s| s.setting == Setting::FULL)?;
        Some(ratio(one, full.price, full.made.traced()))
    }

    /// The line of a setting.
    pub fn setting_line(&self, k: usize) -> SettingLine {
        let (one, trade) = (&self.settings[k], &self.trades[k]);
        SettingLine {
            number: k + 1,
            name: one.setting.to_string(),
            setting: one.setting,
            options: one.setting.options(),
            fallback: one.plan.is_fallback(),
            same_plan_as: one.same_as.map(|k| k + 1),
            wall_s: one.price.wall_s,
            cpu_s: one.price.cpu_s,
            renderer_calls: one.made.calls,
            renderer_frames: one.made.pictures,
            pixels_traced: one.made.traced(),
            speedup: self.speedup(one),
            speedup_full: self.speedup_full(one),
            errors: one.errors,
            on_front: trade.on_front,
            beaten_by: trade.beaten_by.map(|k| k + 1),
            why: trade.why.clone(),
        }
    }

    /// The last line.
    pub fn line(&self) -> SweepLine<'_> {
        let reference = &self.reference;
        SweepLine {
            decor: env!("CARGO_PKG_VERSION"),
            film: &self.film,
            frames: self.frames.1 - self.frames.0 + 1,
            first_frame: self.frames.0,
            width: self.stage.size().width,
            height: self.stage.size().height,
            renderer: self.stage.adapter.name(),
            renderer_version: &self.stage.adapter.abilities().version,
            machine: &self.machine,
            runs: self.runs,
            level: self.level,
            reference: ReferenceLine {
                against: reference.against,
                wall_s: reference.price.wall_s,
                cpu_s: reference.price.cpu_s,
                pixels_traced: reference.made.traced(),
            },
            settings: self.settings.len(),
            front: self.front().into_iter().map(|k| k + 1).collect(),
        }
    }

    /// The settings that no other beats, the fastest first; of those with one plan,
    /// the first.
    pub fn front(&self) -> Vec<usize> {
        let mut front: Vec<usize> = (0..self.settings.len())
            .filter(|&k| self.trades[k].on_front && self.settings[k].same_as.is_none())
            .collect();
        let wall = |k: usize| self.settings[k].price.wall_s;
        front.sort_by(|&a, &b| wall(a).total_cmp(&wall(b)));
        front
    }

    /// `sweep.json`: everything, with the classes of all objects.
    ///
    /// # Errors
    /// None that input can cause; the serializer's.
    pub fn json(&self) -> serde_json::Result<String> {
        let identities = self.stage.film.identities();
        let measured = (0..self.settings.len()).map(|k| WithPeriods {
            setting: self.setting_line(k),
            periods: self.periods(&self.settings[k]),
        });
        let whole = Whole {
            sweep: self.line(),
            objects: identities.iter().map(|identity| identity.name()).collect(),
            measured: measured.collect(),
        };
        Ok(serde_json::to_string_pretty(&whole)? + "\n")
    }

    fn periods(&self, one: &Measured) -> Vec<PeriodLine> {
        let objects = self.stage.film.identities().len();
        let periods = one.plan.periods.iter();
        periods
            .map(|period| {
                let mut classes = vec!['-'; objects];
                for object in &period.objects {
                    classes[object.object.0 as usize] = match object.class {
                        Class::Immobile => 'i',
                        Class::Clipped => 'c',
                        Class::Slow => 's',
                        Class::Fast => 'f',
                    };
                }
                PeriodLine {
                    start: period.start,
                    length: period.len(),
                    end: period.end,
                    dissolves_until: period.dissolve_until,
                    whole: period.whole.as_ref().map(ToString::to_string),
                    classes: classes.into_iter().collect(),
                }
            })
            .collect()
    }
}

fn ratio(one: &Measured, whole: crate::plan::Price, traced: u64) -> Speedup {
    Speedup {
        wall: whole.wall_s / one.price.wall_s.max(1e-9),
        cpu: whole.cpu_s / one.price.cpu_s.max(1e-9),
        traced: traced as f64 / one.made.traced().max(1) as f64,
    }
}

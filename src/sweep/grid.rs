//! What a sweep tries: every combination of a few lists.

use std::fmt;

use serde::Serialize;

use crate::plan::{Mode, Wishes};
use crate::segmentation::Measure;

/// The renderer's antialiasing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, clap::ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Antialiasing {
    /// As the film states it.
    AsIs,
    /// None.
    Off,
}

/// The lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Thresholds in pixels; `full` and `exact` have none.
    pub thresholds_px: Vec<f64>,
    /// Frames per décor; `None`: as decor sees fit.
    pub periods: Vec<Option<u32>>,
    /// Measures of motion, for the modes with a threshold.
    pub measures: Vec<Measure>,
    /// Modes.
    pub modes: Vec<Mode>,
    /// With antialiasing, and without.
    pub antialias: Vec<Antialiasing>,
}

/// One of the combinations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// The promise.
    pub mode: Mode,
    /// Objects may move so far, in pixels, and stay in the décor.
    pub threshold_px: f64,
    /// Frames per décor; null: as decor sees fit.
    pub period: Option<u32>,
    /// Which measure of motion decides.
    pub measure: Measure,
    /// With antialiasing, or without.
    pub antialias: Antialiasing,
}

impl Grid {
    /// The combinations that differ, in the order of the lists, the threshold
    /// last.
    pub fn settings(&self) -> Vec<Setting> {
        let mut settings: Vec<Setting> = Vec::new();
        for &antialias in &self.antialias {
            for &mode in &self.modes {
                for &measure in &self.measures {
                    for &period in &self.periods {
                        for &threshold_px in &self.thresholds_px {
                            let setting = Setting {
                                mode,
                                threshold_px,
                                period,
                                measure,
                                antialias,
                            };
                            settings.push(setting.what_matters());
                        }
                    }
                }
            }
        }
        let mut different: Vec<Setting> = Vec::new();
        for setting in settings {
            if !different.contains(&setting) {
                different.push(setting);
            }
        }
        different
    }
}

impl Setting {
    /// Frame by frame through the pool, antialiased as the film is.
    pub const FULL: Self = Self {
        mode: Mode::Full,
        threshold_px: 0.0,
        period: None,
        measure: Measure::Bound,
        antialias: Antialiasing::AsIs,
    };

    /// What has no influence at its default.
    fn what_matters(self) -> Self {
        match self.mode {
            Mode::Full => Self {
                antialias: self.antialias,
                ..Self::FULL
            },
            Mode::Exact => Self {
                threshold_px: 0.0,
                measure: Measure::Bound,
                ..self
            },
            Mode::Equivalent | Mode::Preview => self,
        }
    }

    /// What is asked of the plan.
    pub fn wishes(&self, frames: (u32, u32)) -> Wishes {
        Wishes {
            mode: self.mode,
            threshold_px: self.threshold_px,
            measure: self.measure,
            period: self.period,
            budget: None,
            shadow_way: crate::plan::ShadowWay::Auto,
            frames,
            with_depth: false,
            fallback: true,
        }
    }

    /// The options of `decor render` that ask for it. Antialiasing is the film's.
    pub fn options(&self) -> String {
        let mut words = format!("--mode {}", self.mode);
        if !matches!(self.mode, Mode::Full | Mode::Exact) {
            words += &format!(" --threshold {}", self.threshold_px);
        }
        if let Some(period) = self.period {
            words += &format!(" --period {period}");
        }
        if self.measure == Measure::Thesis {
            words += " --measure thesis";
        }
        words
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.mode)?;
        if !matches!(self.mode, Mode::Full | Mode::Exact) {
            write!(f, " {} px", self.threshold_px)?;
        }
        if let Some(period) = self.period {
            write!(f, ", period {period}")?;
        }
        if self.measure == Measure::Thesis {
            write!(f, ", thesis")?;
        }
        if self.antialias == Antialiasing::Off {
            write!(f, ", not antialiased")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_combinations_that_differ() {
        let grid = Grid {
            thresholds_px: vec![0.5, 1.0, 1.0],
            periods: vec![None, Some(5)],
            measures: vec![Measure::Bound, Measure::Thesis],
            modes: vec![Mode::Full, Mode::Exact, Mode::Preview],
            antialias: vec![Antialiasing::AsIs],
        };
        let words: Vec<String> = grid.settings().iter().map(Setting::to_string).collect();
        let expected = [
            "full",
            "exact",
            "exact, period 5",
            "preview 0.5 px",
            "preview 1 px",
            "preview 0.5 px, period 5",
            "preview 1 px, period 5",
            "preview 0.5 px, thesis",
            "preview 1 px, thesis",
            "preview 0.5 px, period 5, thesis",
            "preview 1 px, period 5, thesis",
        ];
        assert_eq!(words, expected);
        let options = grid.settings()[10].options();
        assert_eq!(
            options,
            "--mode preview --threshold 1 --period 5 --measure thesis"
        );
    }
}

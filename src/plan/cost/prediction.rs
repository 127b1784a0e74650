//! A prediction, and beside it what happened.

use serde::{Deserialize, Serialize};

use super::Price;

/// Where the costs come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum CostsFrom {
    /// A probe of this film, just now.
    Probe,
    /// A probe of this film, kept from an earlier run.
    Cached,
    /// What plain scenes cost.
    BuiltIn,
}

impl std::fmt::Display for CostsFrom {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Probe => "costs from a probe",
            Self::Cached => "costs from an earlier probe",
            Self::BuiltIn => "built-in costs",
        })
    }
}

/// What rendering was to cost, and what it did: from the plan to the last frame,
/// reading the film and probing left out.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Prediction {
    /// Where the costs come from.
    pub costs: CostsFrom,
    /// Predicted seconds on the clock.
    pub predicted_wall_s: f64,
    /// Predicted seconds of all cores.
    pub predicted_cpu_s: f64,
    /// Predicted seconds on the clock of the stock renderer.
    pub baseline_wall_s: f64,
    /// Predicted seconds of all cores of the stock renderer.
    pub baseline_cpu_s: f64,
    /// Earlier renders of the film that corrected what was predicted.
    pub renders_learned_from: u32,
    /// What the costs say, before the correction.
    #[serde(skip)]
    pub uncorrected: Price,
    /// Seconds on the clock, once it is done.
    pub measured_wall_s: Option<f64>,
    /// Seconds of all cores, once it is done.
    pub measured_cpu_s: Option<f64>,
}

impl Prediction {
    /// Before it happens.
    pub fn new(costs: CostsFrom, predicted: Price, baseline: Price) -> Self {
        Self {
            costs,
            predicted_wall_s: predicted.wall_s,
            predicted_cpu_s: predicted.cpu_s,
            baseline_wall_s: baseline.wall_s,
            baseline_cpu_s: baseline.cpu_s,
            renders_learned_from: 0,
            uncorrected: predicted,
            measured_wall_s: None,
            measured_cpu_s: None,
        }
    }

    /// With what was predicted before `renders` earlier renders corrected it.
    #[must_use]
    pub fn uncorrected(self, price: Price, renders: u32) -> Self {
        Self {
            uncorrected: price,
            renders_learned_from: renders,
            ..self
        }
    }

    /// After it happened.
    #[must_use]
    pub fn measured(self, price: Price) -> Self {
        Self {
            measured_wall_s: Some(price.wall_s),
            measured_cpu_s: Some(price.cpu_s),
            ..self
        }
    }

    /// How many times faster than the stock renderer, on the clock.
    pub fn speedup(&self) -> f64 {
        self.baseline_wall_s / self.predicted_wall_s.max(1e-9)
    }
}

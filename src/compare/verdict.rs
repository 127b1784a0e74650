//! From metrics to a verdict, by tolerances as of OpenImageIO's `idiff`: a
//! difference that some pixels may exceed, and one that no pixel may.

use super::metrics::{Levels, Metrics, share};

/// How a comparison ends; the worse is the greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within all tolerances.
    Within,
    /// Outside the tolerances for a warning.
    Warning,
    /// Outside the tolerances, or a frame is missing.
    Failed,
    /// There is nothing to compare: different sizes, an empty folder.
    NotComparable,
    /// A picture or a folder cannot be read.
    Unreadable,
}

impl Verdict {
    /// All, from the best to the worst.
    pub const ALL: [Self; 5] = [
        Self::Within,
        Self::Warning,
        Self::Failed,
        Self::NotComparable,
        Self::Unreadable,
    ];

    /// The exit status: 0 to 4.
    pub fn status(self) -> u8 {
        match self {
            Self::Within => 0,
            Self::Warning => 1,
            Self::Failed => 2,
            Self::NotComparable => 3,
            Self::Unreadable => 4,
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Within => "within",
            Self::Warning => "warning",
            Self::Failed => "failed",
            Self::NotComparable => "not comparable",
            Self::Unreadable => "unreadable",
        }
    }
}

/// A difference, and how many pixels may exceed it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limit {
    /// The difference, in units of the pictures' values.
    pub level: f64,
    /// Percent of the pixels, 0..100.
    pub percent: f64,
}

/// What is tolerated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerances {
    /// More than this fails.
    pub fail: Limit,
    /// One pixel above this fails.
    pub hard_fail: Option<f64>,
    /// The relative difference of depth that takes the place of `fail.level`;
    /// +∞: depth is not judged.
    pub fail_depth: f64,
    /// More than this is a warning.
    pub warn: Option<Limit>,
    /// One pixel above this is a warning.
    pub hard_warn: Option<f64>,
}

impl Default for Tolerances {
    /// Nothing is tolerated, and nothing is a mere warning.
    fn default() -> Self {
        Self {
            fail: Limit {
                level: 0.0,
                percent: 0.0,
            },
            hard_fail: None,
            fail_depth: 0.0,
            warn: None,
            hard_warn: None,
        }
    }
}

/// Tolerances that others judge their pictures by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// Blender's render tests: 1 % of the pixels may differ by more than 0.016.
    Blender,
    /// OpenImageIO's `idiff` without options: whatever differs by more than 1e-6
    /// fails.
    Idiff,
}

impl Preset {
    /// The tolerances.
    pub fn tolerances(self) -> Tolerances {
        let limit = |level, percent| Limit { level, percent };
        match self {
            Self::Blender => Tolerances {
                fail: limit(0.016, 1.0),
                fail_depth: 0.016,
                ..Tolerances::default()
            },
            Self::Idiff => Tolerances {
                fail: limit(1e-6, 0.0),
                fail_depth: 1e-6,
                warn: Some(limit(1e-6, 0.0)),
                ..Tolerances::default()
            },
        }
    }
}

impl Tolerances {
    /// The differences above which pixels have to be counted.
    pub fn levels(&self) -> Levels {
        let warn = self.warn.map_or(f64::INFINITY, |warn| warn.level);
        Levels {
            fail: self.fail.level,
            warn,
            fail_depth: self.fail_depth,
            warn_depth: if self.fail_depth == f64::INFINITY {
                f64::INFINITY
            } else {
                warn
            },
        }
    }

    /// Judges metrics that were measured with [`Tolerances::levels`], and says
    /// why.
    pub fn judge(&self, metrics: &Metrics) -> (Verdict, Vec<String>) {
        let depth = metrics.depth.as_ref();
        let failed = Class {
            limit: Some(self.fail),
            hard: self.hard_fail,
            colour: metrics.differing,
            depth: depth.map_or(0, |depth| depth.differing),
            depth_level: self.fail_depth,
        };
        let reasons = failed.reasons(metrics);
        if !reasons.is_empty() {
            return (Verdict::Failed, reasons);
        }
        let warned = Class {
            limit: self.warn,
            hard: self.hard_warn,
            colour: metrics.above_warn,
            depth: depth.map_or(0, |depth| depth.above_warn),
            depth_level: self.levels().warn_depth,
        };
        let reasons = warned.reasons(metrics);
        if !reasons.is_empty() {
            return (Verdict::Warning, reasons);
        }
        (Verdict::Within, Vec::new())
    }
}

/// One of the two classes of tolerances, and the pixels counted for it.
struct Class {
    limit: Option<Limit>,
    hard: Option<f64>,
    colour: u64,
    depth: u64,
    depth_level: f64,
}

impl Class {
    fn reasons(&self, metrics: &Metrics) -> Vec<String> {
        let mut reasons = Vec::new();
        if let Some(limit) = self.limit {
            for (count, what, level) in [
                (self.colour, "above", limit.level),
                (
                    self.depth,
                    "with a relative depth difference above",
                    self.depth_level,
                ),
            ] {
                // Multiplied out: 1 pixel of 100 is not more than 1 percent.
                if count as f64 * 100.0 > limit.percent * metrics.pixels as f64 {
                    let pixels = if count == 1 { "pixel" } else { "pixels" };
                    let percent = 100.0 * share(count, metrics.pixels);
                    let allowed = limit.percent;
                    reasons.push(format!(
                        "{count} {pixels} ({percent:.3} %, allowed {allowed} %) {what} {level}"
                    ));
                }
            }
        }
        if let Some(hard) = self.hard {
            // Infinity is above every tolerance, infinity included.
            if metrics.max > hard || metrics.max == f64::INFINITY {
                reasons.push(format!(
                    "the largest difference {} is above {hard}",
                    metrics.max
                ));
            }
        }
        reasons
    }
}

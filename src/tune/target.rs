//! What quality is asked for.

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use crate::compare::pair::PairReport;
use crate::sweep::Errors;

/// By what the quality is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Metric {
    /// The film's mean FLIP.
    Flip,
    /// The film's PSNR in decibels: at least so much.
    Psnr,
    /// The film's mean SSIM: at least so much.
    Ssim,
    /// The film's root of the mean square.
    Rms,
    /// The largest difference of a channel in any frame.
    Max,
    /// The share of the pixels that change from frame to frame in this film only.
    Flicker,
    /// How far anything in a décor moves, at most, in pixels.
    Motion,
}

impl Metric {
    const ALL: [(&'static str, Self); 7] = [
        ("flip", Self::Flip),
        ("psnr", Self::Psnr),
        ("ssim", Self::Ssim),
        ("rms", Self::Rms),
        ("max", Self::Max),
        ("flicker", Self::Flicker),
        ("motion", Self::Motion),
    ];

    /// The value of a whole film, as a *loss*: less is better, and but for the
    /// largest difference the film's is the mean of its frames'.
    pub fn loss(self, value: f64) -> f64 {
        match self {
            Self::Psnr => 10.0_f64.powf(-value / 10.0),
            Self::Rms => value * value,
            Self::Ssim => 1.0 - value,
            Self::Flip | Self::Max | Self::Flicker | Self::Motion => value,
        }
    }

    /// The other way. Infinite where the PSNR is.
    pub fn value(self, loss: f64) -> f64 {
        match self {
            Self::Psnr => -10.0 * loss.log10(),
            Self::Rms => loss.max(0.0).sqrt(),
            Self::Ssim => 1.0 - loss,
            Self::Flip | Self::Max | Self::Flicker | Self::Motion => loss,
        }
    }

    /// The loss of a frame; none where it was not measured.
    pub fn loss_of_frame(self, pair: &PairReport) -> Option<f64> {
        let metrics = pair.metrics.as_ref()?;
        match self {
            Self::Psnr | Self::Rms => Some(metrics.mean_square),
            Self::Max => Some(metrics.max),
            Self::Flip => Some(metrics.perceived?.flip.mean),
            Self::Ssim => Some(1.0 - metrics.perceived?.ssim?.mean),
            Self::Flicker => Some(pair.flicker?.share_added()),
            Self::Motion => None,
        }
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::ALL.iter().find(|(_, metric)| metric == self);
        f.write_str(name.map_or("", |(name, _)| name))
    }
}

/// A quality.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// By what it is measured.
    pub metric: Metric,
    /// What it is to be at most; of PSNR and SSIM, at least.
    pub value: f64,
}

impl Target {
    /// Do the errors of a whole film hold it?
    pub fn holds(&self, errors: &Errors) -> bool {
        let value = match self.metric {
            Metric::Flip => errors.flip,
            // None: nothing differs.
            Metric::Psnr => return errors.psnr.is_none_or(|psnr| psnr >= self.value),
            Metric::Ssim => return errors.ssim.is_none_or(|ssim| ssim >= self.value),
            Metric::Rms => errors.rms,
            Metric::Max => errors.max,
            Metric::Flicker => errors.flicker,
            Metric::Motion => errors.motion_px,
        };
        value <= self.value
    }

    /// The loss that it allows.
    pub fn loss(&self) -> f64 {
        self.metric.loss(self.value)
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.metric, self.value)
    }
}

impl FromStr for Target {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let names: Vec<&str> = Metric::ALL.iter().map(|(name, _)| *name).collect();
        let usage = || format!("METRIC=VALUE, with one of {}", names.join(", "));
        let (name, value) = text.split_once('=').ok_or_else(usage)?;
        let metric = Metric::ALL.iter().find(|(known, _)| *known == name.trim());
        let metric = metric.ok_or_else(usage)?.1;
        let value: f64 = value
            .trim()
            .parse()
            .map_err(|_| format!("`{value}` is no number"))?;
        let (least, most) = match metric {
            Metric::Psnr => (0.0, 1000.0),
            Metric::Motion => (0.0, 1e6),
            _ => (0.0, 1.0),
        };
        if !(least..=most).contains(&value) {
            return Err(format!("{name} is from {least} to {most}"));
        }
        Ok(Self { metric, value })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_targets() {
        let target: Target = "flip=0.02".parse().unwrap();
        assert_eq!((target.metric, target.value), (Metric::Flip, 0.02));
        assert_eq!(target.to_string(), "flip=0.02");
        for wrong in ["flip", "flap=1", "psnr=", "flip=2", "max=nan", "flip=-1"] {
            assert!(wrong.parse::<Target>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_loss_is_its_value_the_other_way() {
        for (_, metric) in Metric::ALL {
            for value in [0.25, 0.5, 1.0] {
                let back = metric.value(metric.loss(value));
                assert!((back - value).abs() < 1e-12, "{metric} {value} {back}");
            }
        }
        assert!((Metric::Psnr.loss(40.0) - 1e-4).abs() < 1e-15);
    }
}

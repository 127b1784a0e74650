//! The film's totals: what the pairs come to together.

use super::Entry;
use super::flicker::Flicker;
use super::folders::Side;
use super::metrics::{DepthMetrics, Metrics, psnr, share};
use super::pair::PairReport;
use super::perceived::Perceived;
use super::verdict::Verdict;

/// What the pairs come to together. Means are over all pixels of all compared
/// pairs, not means of the pairs' means.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Totals {
    /// Pairs by verdict, in the order of [`Verdict::ALL`].
    pub pairs: [u64; 5],
    /// Pairs with numbers.
    pub compared: u64,
    /// Pairs without any difference.
    pub identical: u64,
    /// Pictures that A lacks.
    pub missing_from_a: Vec<String>,
    /// Pictures that B lacks.
    pub missing_from_b: Vec<String>,
    /// Pixels of the compared pairs.
    pub pixels: u64,
    /// The largest difference; +∞ where one is not finite.
    pub max: f64,
    /// The sum of the pixels' mean squares.
    squares: f64,
    /// Pixels with any difference.
    pub unequal: u64,
    /// Pixels above the tolerance.
    pub differing: u64,
    /// Pixels with a difference that is not finite.
    pub not_finite: u64,
    /// The depth, where a pair has it. Its place is that of the worst pair.
    pub depth: Option<DepthMetrics>,
    /// SSIM and FLIP, where they were measured.
    pub perceived: Option<FilmPerceived>,
    /// The flicker, where there are two pairs in a row.
    pub flicker: Option<FilmFlicker>,
    /// The number, among the entries, of the compared pair with the worst
    /// verdict, of these the one with the largest difference, then the greatest
    /// RMS, then the first; none where no compared pair differs.
    pub worst: Option<usize>,
}

/// How different a film looks.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmPerceived {
    /// What the SSIM of all windows lacks to 1, summed.
    dissimilar: f64,
    windows: u64,
    /// The FLIP of all pixels, summed.
    flip: f64,
    pixels: u64,
    /// The lowest SSIM of a pair, and its number among the entries.
    pub lowest_ssim: Option<(f64, usize)>,
    /// The highest mean FLIP of a pair, and its number among the entries.
    pub highest_flip: Option<(f64, usize)>,
}

impl FilmPerceived {
    /// The mean SSIM of all windows of all pairs; none where no window fits.
    pub fn ssim(&self) -> Option<f64> {
        (self.windows > 0).then(|| 1.0 - self.dissimilar / self.windows as f64)
    }

    /// The mean FLIP of all pixels of all pairs.
    pub fn flip(&self) -> f64 {
        self.flip / self.pixels.max(1) as f64
    }

    fn add(&mut self, perceived: &Perceived, pixels: u64, entry: usize) {
        if let Some(ssim) = perceived.ssim {
            self.dissimilar += (1.0 - ssim.mean) * ssim.windows as f64;
            self.windows += ssim.windows;
            if self
                .lowest_ssim
                .is_none_or(|(lowest, _)| ssim.mean < lowest)
            {
                self.lowest_ssim = Some((ssim.mean, entry));
            }
        }
        let flip = perceived.flip.mean;
        self.flip += flip * pixels as f64;
        self.pixels += pixels;
        if self.highest_flip.is_none_or(|(highest, _)| flip > highest) {
            self.highest_flip = Some((flip, entry));
        }
    }
}

/// The flicker of a film.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmFlicker {
    /// Transitions from a pair to the next that were looked at.
    pub transitions: u64,
    /// All of them together.
    pub all: Flicker,
    /// The most pixels that a transition adds, and the number of the pair that it
    /// leads to among the entries; none where no transition adds any.
    pub worst: Option<(u64, usize)>,
}

impl FilmFlicker {
    fn add(&mut self, flicker: &Flicker, entry: usize) {
        self.transitions += 1;
        self.all.append(flicker);
        if flicker.added > self.worst.map_or(0, |(most, _)| most) {
            self.worst = Some((flicker.added, entry));
        }
    }
}

impl Totals {
    /// Adds up.
    pub fn of(entries: &[Entry]) -> Self {
        let mut totals = Self::default();
        let mut worst: Option<(usize, &PairReport)> = None;
        for (k, entry) in entries.iter().enumerate() {
            match entry {
                Entry::Missing { name, from } => match from {
                    Side::A => totals.missing_from_a.push(name.clone()),
                    Side::B => totals.missing_from_b.push(name.clone()),
                },
                Entry::Pair(pair) => {
                    totals.add(pair, k);
                    let differs = pair.metrics.as_ref().is_some_and(|m| !m.identical());
                    if differs && worst.is_none_or(|(_, so_far)| is_worse(pair, so_far)) {
                        worst = Some((k, pair));
                    }
                }
            }
        }
        totals.worst = worst.map(|(k, _)| k);
        totals
    }

    fn add(&mut self, pair: &PairReport, entry: usize) {
        self.pairs[usize::from(pair.verdict.status())] += 1;
        let Some(metrics) = &pair.metrics else {
            return;
        };
        self.compared += 1;
        self.identical += u64::from(metrics.identical());
        self.pixels += metrics.pixels;
        self.max = self.max.max(metrics.max);
        self.squares += metrics.mean_square * metrics.pixels as f64;
        self.unequal += metrics.unequal;
        self.differing += metrics.differing;
        self.not_finite += metrics.not_finite;
        if let Some(perceived) = &metrics.perceived {
            let film = self.perceived.get_or_insert_default();
            film.add(perceived, metrics.pixels, entry);
        }
        if let Some(flicker) = &pair.flicker {
            self.flicker.get_or_insert_default().add(flicker, entry);
        }
        if let Some(depth) = &metrics.depth {
            self.depth.get_or_insert_default().append(depth);
        }
    }

    /// Pairs in all.
    pub fn frames(&self) -> u64 {
        self.pairs.iter().sum()
    }

    /// Pictures without a partner.
    pub fn missing(&self) -> usize {
        self.missing_from_a.len() + self.missing_from_b.len()
    }

    /// The worst verdict; a missing picture is a failure.
    pub fn verdict(&self) -> Verdict {
        let of_pairs = Verdict::ALL
            .into_iter()
            .zip(self.pairs)
            .filter(|(_, count)| *count > 0)
            .map(|(verdict, _)| verdict)
            .max()
            .unwrap_or(Verdict::Within);
        if self.missing() > 0 {
            of_pairs.max(Verdict::Failed)
        } else {
            of_pairs
        }
    }

    fn mean_square(&self) -> f64 {
        if self.pixels == 0 {
            0.0
        } else {
            self.squares / self.pixels as f64
        }
    }

    /// The root of the mean square over the whole film.
    pub fn rms(&self) -> f64 {
        self.mean_square().sqrt()
    }

    /// As of [`Metrics::psnr`], over the whole film.
    pub fn psnr(&self) -> f64 {
        psnr(self.mean_square())
    }

    /// The share of the film's pixels above the tolerance, 0..1.
    pub fn share_above(&self) -> f64 {
        share(self.differing, self.pixels)
    }
}

/// Is `one` worse than `other`, strictly?
pub(super) fn is_worse(one: &PairReport, other: &PairReport) -> bool {
    let key = |pair: &PairReport| {
        let number = |of: fn(&Metrics) -> f64| pair.metrics.as_ref().map_or(0.0, of);
        let depth = |m: &Metrics| m.depth.as_ref().map_or(0.0, |depth| depth.differing as f64);
        (
            pair.verdict,
            [number(|m| m.max), number(Metrics::rms), number(depth)],
        )
    };
    // No NaN among them: `Metrics` has none.
    key(one).partial_cmp(&key(other)) == Some(std::cmp::Ordering::Greater)
}

//! A budget: the threshold grows and shrinks so that frames take what they may.
//!
//! Thesis, III-2-4: an application that is ruled by the time it has multiplies
//! the threshold by Q where frames take too long, and divides it again where
//! time is left.

/// By what the threshold is multiplied or divided.
const Q: f64 = std::f64::consts::SQRT_2;

/// Time for a frame, and how far the threshold may go for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Seconds on the clock for each frame, all costs of its period shared out.
    pub frame_s: f64,
    /// The smallest threshold, in pixels.
    pub least_px: f64,
    /// The largest.
    pub most_px: f64,
}

impl Budget {
    /// `threshold_px` within the limits.
    pub fn limited(&self, threshold_px: f64) -> f64 {
        threshold_px.max(self.least_px).min(self.most_px)
    }

    /// The next larger threshold; `None` at the limit.
    pub fn larger(&self, threshold_px: f64) -> Option<f64> {
        (threshold_px < self.most_px).then(|| self.limited(threshold_px * Q))
    }

    /// The next smaller threshold; `None` at the limit.
    pub fn smaller(&self, threshold_px: f64) -> Option<f64> {
        (threshold_px > self.least_px).then(|| self.limited(threshold_px / Q))
    }

    /// The smallest threshold that keeps the budget, looked for from
    /// `threshold_px` on; the largest one where none does. `seconds` prices a
    /// frame, and is asked as seldom as can be.
    pub fn choose<T>(&self, threshold_px: f64, mut price: impl FnMut(f64) -> (f64, T)) -> (f64, T) {
        let mut at = self.limited(threshold_px);
        let (mut seconds, mut chosen) = price(at);
        if seconds > self.frame_s {
            while seconds > self.frame_s
                && let Some(larger) = self.larger(at)
            {
                at = larger;
                (seconds, chosen) = price(at);
            }
        } else {
            while let Some(smaller) = self.smaller(at) {
                let (seconds, less) = price(smaller);
                if seconds > self.frame_s {
                    break;
                }
                (at, chosen) = (smaller, less);
            }
        }
        (at, chosen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BUDGET: Budget = Budget {
        frame_s: 1.0,
        least_px: 0.25,
        most_px: 16.0,
    };

    #[test]
    fn the_smallest_threshold_that_is_fast_enough() {
        // Frames take 4 s at 1 px, and half of it at twice the threshold.
        for from in [0.01, 1.0, 3.7, 16.0, 99.0] {
            let (at, seconds) = BUDGET.choose(from, |px| (4.0 / px, 4.0 / px));
            assert!(seconds <= 1.0, "{at} px from {from}");
            assert!(4.0 / (at / Q) > 1.0, "{at} px from {from}");
        }
    }

    #[test]
    fn limits_hold() {
        assert_eq!(BUDGET.choose(1.0, |_| (9.0, ())).0, 16.0);
        assert_eq!(BUDGET.choose(1.0, |_| (0.1, ())).0, 0.25);
        let fixed = Budget {
            least_px: 2.0,
            most_px: 2.0,
            ..BUDGET
        };
        assert_eq!(fixed.choose(1.0, |_| (9.0, ())).0, 2.0);
    }
}

//! How far a stream plans ahead, and with what threshold: both are learnt from
//! the periods that are over.

use crate::plan::{Budget, Wishes};

/// Frames that are planned ahead at most, where nobody says how many.
const FARTHEST: u32 = 100;

/// Frames that are planned ahead at first.
const FIRST: u32 = 25;

/// So many times a frame has to fit into its budget before the threshold shrinks.
const SPARE: f64 = std::f64::consts::SQRT_2;

/// What the next period is planned with.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    asked: Option<u32>,
    ahead: u32,
    budget: Option<Budget>,
    /// The threshold of the next period, in pixels.
    pub threshold_px: f64,
}

impl Pace {
    /// What the first period is planned with.
    pub fn new(wishes: &Wishes) -> Self {
        let budget = wishes.budget;
        Self {
            asked: wishes.period,
            ahead: FIRST,
            budget,
            threshold_px: budget.map_or(wishes.threshold_px, |budget| {
                budget.limited(wishes.threshold_px)
            }),
        }
    }

    /// Frames that the next period may have.
    pub fn ahead(&self) -> u32 {
        self.asked.unwrap_or(self.ahead)
    }

    /// Is the length of periods free?
    pub fn is_free(&self) -> bool {
        self.asked.is_none()
    }

    /// May the threshold change?
    pub fn adapts(&self) -> bool {
        self.budget.is_some()
    }

    /// A period is over that served so many frames; each took so long.
    ///
    /// A prediction that failed after n frames is not trusted for more than 2n;
    /// one that held, for twice as many as before. Thesis, III-2-4: the threshold
    /// grows where frames take longer than they may, and shrinks where time is
    /// left, by a step at a time. Less than a step of time left is none: the
    /// threshold would go to and fro.
    pub fn learn(&mut self, served: u32, failed: bool, frame_s: f64) {
        let ahead = if failed { served } else { self.ahead };
        self.ahead = ahead.saturating_mul(2).clamp(2, FARTHEST);
        let Some(budget) = self.budget else { return };
        let next = if frame_s > budget.frame_s {
            budget.larger(self.threshold_px)
        } else if frame_s * SPARE < budget.frame_s {
            budget.smaller(self.threshold_px)
        } else {
            None
        };
        self.threshold_px = next.unwrap_or(self.threshold_px);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::Mode;
    use crate::segmentation::Measure;

    fn wishes(period: Option<u32>, budget: Option<Budget>) -> Wishes {
        Wishes {
            mode: Mode::Equivalent,
            threshold_px: 1.0,
            measure: Measure::Bound,
            period,
            budget,
            shadow_way: crate::plan::ShadowWay::Auto,
            frames: (0, 0),
            with_depth: false,
            fallback: true,
        }
    }

    #[test]
    fn trust_is_lost_at_once_and_comes_back_slowly() {
        let mut pace = Pace::new(&wishes(None, None));
        pace.learn(1, true, 0.0);
        assert_eq!(pace.ahead(), 2);
        pace.learn(2, false, 0.0);
        assert_eq!(pace.ahead(), 4);
        pace.learn(70, true, 0.0);
        assert_eq!(pace.ahead(), FARTHEST);
        let mut asked = Pace::new(&wishes(Some(7), None));
        asked.learn(1, true, 0.0);
        assert_eq!(asked.ahead(), 7);
    }

    #[test]
    fn a_budget_goes_a_step_at_a_time_within_its_limits() {
        let budget = Budget {
            frame_s: 1.0,
            least_px: 0.6,
            most_px: 1.5,
        };
        let mut pace = Pace::new(&wishes(None, Some(budget)));
        let mut after = |frame_s: f64| {
            pace.learn(5, false, frame_s);
            pace.threshold_px
        };
        let step = std::f64::consts::SQRT_2;
        assert_eq!(after(0.9), 1.0);
        assert!((after(9.0) - step).abs() < 1e-12);
        assert_eq!(after(9.0), 1.5);
        assert_eq!(after(9.0), 1.5);
        assert!((after(0.1) - 1.5 / step).abs() < 1e-12);
        for _ in 0..9 {
            after(0.1);
        }
        assert_eq!(after(0.1), 0.6);
    }
}

//! What proxies may cost: a purse that holds a little at first, and half of what
//! they have saved later. So they cannot make a film much dearer than it is whole.

/// Passes that saved nothing yet may cost this share of the film.
const RISK: f64 = 0.03;

/// Of what was saved, so much may be spent again.
const AGAIN: f64 = 0.5;

/// Seconds of CPU that may be spent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Purse {
    left_s: f64,
}

impl Purse {
    /// For a film that takes so much whole.
    pub fn for_film(whole_s: f64) -> Self {
        Self {
            left_s: RISK * whole_s,
        }
    }

    /// Pays, where there is enough; what is promised to pay is paid in any case,
    /// and missing later.
    pub fn pay(&mut self, cost_s: f64, promised: bool) -> bool {
        let pays = promised || cost_s <= self.left_s;
        if pays {
            self.left_s -= cost_s;
        }
        pays
    }

    /// So much need not be traced.
    pub fn saved(&mut self, saved_s: f64) {
        self.left_s += AGAIN * saved_s;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_is_not_spent() {
        let mut purse = Purse::for_film(100.0);
        assert!(!purse.pay(3.1, false));
        assert!(purse.pay(2.0, false));
        assert!(!purse.pay(1.1, false), "two of three are spent");
        assert!(purse.pay(0.9, false));
    }

    #[test]
    fn what_was_promised_is_missing_later() {
        let mut purse = Purse::for_film(100.0);
        assert!(purse.pay(10.0, true));
        assert!(!purse.pay(0.1, false));
        purse.saved(14.0);
        assert!(
            !purse.pay(0.1, false),
            "half of what was saved only fills it"
        );
        purse.saved(2.0);
        assert!(purse.pay(0.9, false) && !purse.pay(0.2, false));
    }

    #[test]
    fn a_film_that_saves_nothing_loses_a_few_percent() {
        let mut purse = Purse::for_film(100.0);
        let spent: f64 = (0..1000)
            .map(|_| if purse.pay(0.25, false) { 0.25 } else { 0.0 })
            .sum();
        assert!((spent - 3.0).abs() < 1e-9, "{spent}");
    }
}

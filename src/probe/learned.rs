//! What renders of a film really took, beside what was predicted.
//!
//! A probe computes for half a second, on a machine whose cores may be twice as
//! fast a minute later; a render computes for many, and its prediction is known.
//! So each render corrects the next prediction, by one factor for the cores' time
//! and one for the clock's. The costs that plans are chosen by stay as they were
//! probed: the same command makes the same plan however often it is given.

use serde::{Deserialize, Serialize};

use super::key;
use crate::objects::Cache;
use crate::plan::{CostsFrom, Plan, Price};
use crate::stage::Stage;

/// The kind of its cache entries.
const KIND: &str = "learned-1";

/// How much the newest render counts, where there were others: in proportion, but
/// never less. Machines change.
const NEWEST: f64 = 0.4;

/// A render that took so many times as long as predicted, or as little, was not a
/// question of the costs: the machine slept, or was given away.
const BELIEVED: f64 = 5.0;

/// A probe's small pictures are dearer than those of a long render: the machine and
/// its caches are cold. What renders took of what their probe foretold, the
/// geometric mean of six films and speeds with POV-Ray (0.67 to 1.00 in wall time,
/// 0.71 to 0.99 of CPU).
const AFTER_A_PROBE: Factor = Factor {
    wall: 0.78,
    cpu: 0.83,
    renders: 0,
};

/// Measured by predicted, in renders of one kind.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Factor {
    wall: f64,
    cpu: f64,
    renders: u32,
}

/// What earlier renders of a film say about predictions. Whole frames and layers
/// are different work: each is corrected by its own renders, or, where there
/// were none, by the other's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Learned {
    whole: Option<Factor>,
    layered: Option<Factor>,
    /// What is believed before any render.
    #[serde(skip)]
    before: Option<Factor>,
}

impl Learned {
    /// What is known of a film, with costs of this origin.
    pub fn of(stage: &Stage, from: CostsFrom, cache: &Cache) -> Self {
        let known: Self = cache.get(KIND, &entry(stage, from)).unwrap_or_default();
        let is_probed = from != CostsFrom::BuiltIn && !super::is_in_process(stage);
        Self {
            before: is_probed.then_some(AFTER_A_PROBE),
            ..known
        }
    }

    /// A prediction for `plan`, corrected.
    #[must_use]
    pub fn correct(&self, plan: &Plan, predicted: Price) -> Price {
        self.factor(is_whole(plan))
            .map_or(predicted, |factor| Price {
                wall_s: predicted.wall_s * factor.wall,
                cpu_s: predicted.cpu_s * factor.cpu,
            })
    }

    /// A prediction of the stock renderer's price, which is that of whole frames.
    #[must_use]
    pub fn correct_stock(&self, predicted: Price) -> Price {
        // Its own way to use the cores is not decor's: the cores' speed is what is
        // known.
        let cpu = self.factor(true).map_or(1.0, |factor| factor.cpu);
        Price {
            wall_s: predicted.wall_s * cpu,
            cpu_s: predicted.cpu_s * cpu,
        }
    }

    /// From how many renders is `plan`'s correction?
    pub fn renders(&self, plan: &Plan) -> u32 {
        self.factor(is_whole(plan)).map_or(0, |f| f.renders)
    }

    fn factor(&self, whole: bool) -> Option<Factor> {
        let (own, other) = if whole {
            (self.whole, self.layered)
        } else {
            (self.layered, self.whole)
        };
        own.or(other).or(self.before)
    }

    /// Takes in a render of `plan`: `predicted` is what was said before any
    /// correction.
    fn take(&mut self, whole: bool, predicted: Price, measured: Price) {
        let ratio = |measured: f64, predicted: f64| {
            let ratio = measured / predicted;
            (1.0 / BELIEVED..=BELIEVED)
                .contains(&ratio)
                .then_some(ratio)
        };
        let (Some(wall), Some(cpu)) = (
            ratio(measured.wall_s, predicted.wall_s),
            ratio(measured.cpu_s, predicted.cpu_s),
        ) else {
            return;
        };
        let kept = if whole {
            &mut self.whole
        } else {
            &mut self.layered
        };
        *kept = Some(match *kept {
            None => Factor {
                wall,
                cpu,
                renders: 1,
            },
            Some(before) => {
                let renders = before.renders.saturating_add(1);
                let share = (1.0 / f64::from(renders)).max(NEWEST);
                // Factors: their logarithms have a mean.
                let mean = |old: f64, new: f64| old * (new / old).powf(share);
                Factor {
                    wall: mean(before.wall, wall),
                    cpu: mean(before.cpu, cpu),
                    renders,
                }
            }
        });
    }
}

/// Learns from a finished render of all frames of `plan`.
pub fn learn(
    stage: &Stage,
    plan: &Plan,
    from: CostsFrom,
    (predicted, measured): (Price, Price),
    cache: &Cache,
) {
    // Read again: others may have learned meanwhile.
    let mut learned = Learned::of(stage, from, cache);
    learned.take(is_whole(plan), predicted, measured);
    cache.put(KIND, &entry(stage, from), &learned);
}

/// Are all frames rendered whole?
fn is_whole(plan: &Plan) -> bool {
    plan.periods.iter().all(|period| period.whole.is_some())
}

/// A probe corrects what is built in: what was learned of the one says nothing
/// about the other.
fn entry(stage: &Stage, from: CostsFrom) -> Vec<u8> {
    let mut key = key(stage);
    key.push(u8::from(from == CostsFrom::BuiltIn));
    key
}

#[cfg(test)]
mod tests {
    use super::*;

    fn price(wall_s: f64, cpu_s: f64) -> Price {
        Price { wall_s, cpu_s }
    }

    #[test]
    fn a_machine_that_is_steadily_slower_is_learned_at_once() {
        let mut learned = Learned::default();
        learned.take(true, price(2.0, 4.0), price(3.0, 8.0));
        let factor = learned.factor(true).unwrap();
        assert_eq!((factor.wall, factor.cpu, factor.renders), (1.5, 2.0, 1));
        // Layers borrow it until they have their own.
        assert_eq!(learned.factor(false), learned.factor(true));
        learned.take(false, price(1.0, 1.0), price(1.0, 1.0));
        assert_eq!(learned.factor(false).unwrap().cpu, 1.0);
        assert_eq!(learned.factor(true), Some(factor));
    }

    #[test]
    fn the_first_render_replaces_what_was_believed() {
        let mut learned = Learned {
            before: Some(AFTER_A_PROBE),
            ..Learned::default()
        };
        assert_eq!(learned.factor(false), Some(AFTER_A_PROBE));
        learned.take(true, price(1.0, 1.0), price(1.2, 1.1));
        let factor = learned.factor(false).unwrap();
        assert_eq!((factor.wall, factor.cpu, factor.renders), (1.2, 1.1, 1));
    }

    #[test]
    fn it_follows_a_change_and_is_not_thrown_by_one_render() {
        let mut learned = Learned::default();
        for _ in 0..10 {
            learned.take(false, price(1.0, 1.0), price(1.0, 1.0));
        }
        learned.take(false, price(1.0, 1.0), price(2.0, 2.0));
        let once = learned.factor(false).unwrap().cpu;
        assert!((1.2..1.5).contains(&once), "{once}");
        for _ in 0..5 {
            learned.take(false, price(1.0, 1.0), price(2.0, 2.0));
        }
        let often = learned.factor(false).unwrap().cpu;
        assert!((1.9..=2.0).contains(&often), "{often}");
    }

    #[test]
    fn what_cannot_be_true_is_not_learned() {
        let mut learned = Learned::default();
        for (predicted, measured) in [
            (price(1.0, 1.0), price(100.0, 1.0)),
            (price(0.0, 0.0), price(1.0, 1.0)),
            (price(1.0, 1.0), price(f64::NAN, 1.0)),
            (price(1.0, 1.0), price(1.0, 0.0)),
        ] {
            learned.take(true, predicted, measured);
        }
        assert_eq!(learned, Learned::default());
    }
}

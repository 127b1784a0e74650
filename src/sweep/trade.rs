//! What each setting of a sweep is worth: which no other beats, and why another is
//! beaten.

use super::Measured;
use crate::plan::{Period, Plan};

/// Times that differ by less than this share are alike: two runs of the same differ
/// as much.
const ALIKE: f64 = 0.05;

/// What a setting is worth among the others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trade {
    /// Is no other both as fast and as close to frame by frame, and better in one
    /// of the two? By wall time and mean FLIP.
    pub on_front: bool,
    /// The number of one that is.
    pub beaten_by: Option<usize>,
    /// Why.
    pub why: Option<String>,
}

/// For each setting, in order.
pub fn trades(settings: &[Measured]) -> Vec<Trade> {
    (0..settings.len()).map(|k| trade(settings, k)).collect()
}

fn trade(settings: &[Measured], k: usize) -> Trade {
    let one = &settings[k];
    // Of those that beat it, the closest to frame by frame, then the fastest.
    let best = settings
        .iter()
        .enumerate()
        .filter(|(_, other)| beats(place(other), place(one)))
        .min_by(|(_, a), (_, b)| {
            let by_error = a.errors.flip.total_cmp(&b.errors.flip);
            by_error.then(a.price.wall_s.total_cmp(&b.price.wall_s))
        });
    Trade {
        on_front: best.is_none(),
        beaten_by: best.map(|(k, _)| k),
        why: match (one.same_as, best) {
            (Some(_), _) => Some(same_plan(&one.plan)),
            (None, Some((_, other))) => Some(why(one, other)),
            (None, None) => None,
        },
    }
}

fn place(one: &Measured) -> (f64, f64) {
    (one.price.wall_s, one.errors.flip)
}

/// Is the one no worse in both, and better in one of them?
pub fn beats(one: (f64, f64), other: (f64, f64)) -> bool {
    one.0 <= other.0 && one.1 <= other.1 && one != other
}

fn same_plan(plan: &Plan) -> String {
    match whole_because(plan) {
        Some(reason) => format!("the same plan: every frame is rendered whole, {reason}"),
        None => "the same plan: the same objects stay in the same décors".to_owned(),
    }
}

/// Why every frame is rendered whole, where that is so.
pub fn whole_because(plan: &Plan) -> Option<String> {
    let reasons: Option<Vec<String>> = plan
        .periods
        .iter()
        .map(|period| period.whole.as_ref().map(ToString::to_string))
        .collect();
    let mut reasons = reasons?;
    reasons.dedup();
    Some(match reasons.as_slice() {
        [one] if one == "asked for" => "as asked for".to_owned(),
        [one] => format!("because {one}"),
        many => format!("because of {} reasons, first that {}", many.len(), many[0]),
    })
}

fn dissolves(plan: &Plan) -> bool {
    plan.periods.iter().any(|p| p.dissolve_until.is_some())
}

/// Why `one` is no faster than `other`, which is at least as close.
fn why(one: &Measured, other: &Measured) -> String {
    let slower = one.price.wall_s / other.price.wall_s.max(1e-9);
    let farther = one.errors.flip > other.errors.flip;
    let decors = |plan: &Plan| plan.periods.iter().filter(|p| Period::has_decor(p)).count();
    let pixels = |measured: &Measured| {
        100.0 * measured.made.traced() as f64 / measured.made.full.max(1) as f64
    };
    let (traced, other_traced) = (pixels(one), pixels(other));
    let whole = whole_because(&one.plan);
    let mut parts: Vec<String> = Vec::new();
    if slower < 1.0 + ALIKE {
        parts.push(format!(
            "as fast, as far as a clock can tell ({:.2} s against {:.2} s)",
            one.price.wall_s, other.price.wall_s
        ));
        if let Some(reason) = &whole {
            parts.push(format!("every frame is rendered whole, {reason}"));
        }
    } else if let Some(reason) = &whole {
        parts.push(format!(
            "every frame is rendered whole, {reason}: nothing is saved"
        ));
    } else if traced > other_traced * (1.0 + ALIKE) {
        let (ours, theirs) = (decors(&one.plan), decors(&other.plan));
        let decors = if ours > theirs {
            let plural = if ours == 1 { "" } else { "s" };
            format!(", with {ours} décor{plural} against {theirs}")
        } else {
            String::new()
        };
        parts.push(format!(
            "more is rendered: {traced:.0} % of the pixels against {other_traced:.0} %{decors}"
        ));
    } else if dissolves(&one.plan) && !dissolves(&other.plan) {
        parts.push(format!(
            "its décors dissolve into each other, which takes decor's own time at every frame, \
             there they do not ({traced:.0} % of the pixels are traced against {other_traced:.0} %)"
        ));
    } else if one.made.pictures > other.made.pictures || one.made.calls > other.made.calls {
        parts.push(format!(
            "fewer pixels do not make up for more pictures: {traced:.0} % of the pixels in {} \
             calls with {} pictures, against {other_traced:.0} % in {} with {}",
            one.made.calls, one.made.pictures, other.made.calls, other.made.pictures
        ));
    } else {
        parts.push(format!(
            "no more is rendered ({traced:.0} % of the pixels against {other_traced:.0} %): its \
             frames wait for their décors, or the machine was busy"
        ));
    }
    if farther && whole.is_none() {
        let (ours, theirs) = (one.errors.motion_px, other.errors.motion_px);
        parts.push(if ours > theirs && theirs == 0.0 {
            format!("what its décors keep moves up to {ours:.2} pixels, there nothing is kept that moves")
        } else if ours > theirs {
            format!("what its décors keep moves up to {ours:.2} pixels, there {theirs:.2}")
        } else if one.plan.wishes.mode != other.plan.wishes.mode {
            format!(
                "`{}` is farther off than `{}` by its merge, not by motion",
                one.plan.wishes.mode, other.plan.wishes.mode
            )
        } else {
            "its décors serve other frames".to_owned()
        });
    }
    parts.join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_beats_whom() {
        assert!(beats((1.0, 0.1), (2.0, 0.1)));
        assert!(beats((1.0, 0.1), (1.0, 0.2)));
        assert!(!beats((1.0, 0.2), (2.0, 0.1)));
        assert!(!beats((1.0, 0.1), (1.0, 0.1)));
    }
}

//! Intervals along a ray: the inside of a solid, and the algebra of solids.
//!
//! A list of spans is sorted and disjoint. An end at ±∞ is no surface: the
//! solid has no end there.

use glam::DVec3;

/// Where a line passes through a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// The line's parameter.
    pub t: f64,
    /// Out of the solid; of any length but 0.
    pub normal: DVec3,
    /// The number of the look.
    pub look: u32,
    /// Does the line go into the solid here?
    pub enters: bool,
}

/// A piece of a line that is inside a solid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub enter: Crossing,
    pub leave: Crossing,
}

impl Span {
    /// From `enter` to `leave`, each a parameter and a normal.
    pub fn new(enter: (f64, DVec3), leave: (f64, DVec3), look: u32) -> Self {
        let crossing = |(t, normal), enters| Crossing {
            t,
            normal,
            look,
            enters,
        };
        Self {
            enter: crossing(enter, true),
            leave: crossing(leave, false),
        }
    }

    /// Is something left of it? A film thinner than the rounding of its own
    /// ends is where two faces coincide. False for NaN.
    fn is_solid(&self) -> bool {
        let (a, b) = (self.enter.t, self.leave.t);
        let rounding = if a.is_finite() && b.is_finite() {
            4.0 * f64::EPSILON * a.abs().max(b.abs())
        } else {
            0.0
        };
        b - a > rounding
    }
}

/// What is in one or the other.
pub(crate) fn union(a: Vec<Span>, b: Vec<Span>) -> Vec<Span> {
    if a.is_empty() {
        return b;
    }
    if b.is_empty() {
        return a;
    }
    let mut all = a;
    all.extend(b);
    // A stable sort: of two that start together the first one gives the look.
    all.sort_by(|p, q| p.enter.t.total_cmp(&q.enter.t));
    let mut merged: Vec<Span> = Vec::with_capacity(all.len());
    for span in all {
        match merged.last_mut() {
            Some(last) if span.enter.t <= last.leave.t => {
                if span.leave.t > last.leave.t {
                    last.leave = span.leave;
                }
            }
            _ => merged.push(span),
        }
    }
    merged
}

/// What is in both. Where two faces coincide the first one's is kept.
pub(crate) fn intersection(a: &[Span], b: &[Span]) -> Vec<Span> {
    let mut common = Vec::new();
    let (mut i, mut j) = (0, 0);
    while let (Some(p), Some(q)) = (a.get(i), b.get(j)) {
        let span = Span {
            enter: if q.enter.t > p.enter.t {
                q.enter
            } else {
                p.enter
            },
            leave: if q.leave.t < p.leave.t {
                q.leave
            } else {
                p.leave
            },
        };
        if span.is_solid() {
            common.push(span);
        }
        if p.leave.t < q.leave.t {
            i += 1;
        } else {
            j += 1;
        }
    }
    common
}

/// What is in the first, but not in the second.
pub(crate) fn difference(a: &[Span], b: &[Span]) -> Vec<Span> {
    intersection(a, &complement(b))
}

/// Everything that is outside; the surfaces turn over.
fn complement(spans: &[Span]) -> Vec<Span> {
    let turned = |c: Crossing| Crossing {
        normal: -c.normal,
        enters: !c.enters,
        ..c
    };
    let end = |t, enters| Crossing {
        t,
        normal: DVec3::X,
        look: 0,
        enters,
    };
    let mut outside = Vec::with_capacity(spans.len() + 1);
    let mut enter = end(f64::NEG_INFINITY, true);
    for span in spans {
        if span.enter.t > enter.t {
            outside.push(Span {
                enter,
                leave: turned(span.enter),
            });
        }
        enter = turned(span.leave);
    }
    if enter.t < f64::INFINITY {
        outside.push(Span {
            enter,
            leave: end(f64::INFINITY, false),
        });
    }
    outside
}

/// The first surface that a ray meets after the parameter `after`.
pub(crate) fn first_after(spans: &[Span], after: f64) -> Option<Crossing> {
    spans
        .iter()
        .flat_map(|s| [s.enter, s.leave])
        .find(|c| c.t > after && c.t.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn span(a: f64, b: f64) -> Span {
        Span::new((a, -DVec3::X), (b, DVec3::X), 0)
    }

    fn ends(spans: &[Span]) -> Vec<(f64, f64)> {
        spans.iter().map(|s| (s.enter.t, s.leave.t)).collect()
    }

    fn contains(spans: &[Span], t: f64) -> bool {
        spans.iter().any(|s| s.enter.t <= t && t <= s.leave.t)
    }

    /// Sorted and disjoint, as every list of spans is.
    fn spans() -> impl Strategy<Value = Vec<Span>> {
        (
            any::<bool>(),
            prop::collection::btree_set(-20..20_i32, 0..8),
        )
            .prop_map(|(open, ends)| {
                let mut ends: Vec<f64> = ends.into_iter().map(f64::from).collect();
                if open {
                    ends.insert(0, f64::NEG_INFINITY);
                }
                ends.chunks(2)
                    .map(|e| span(e[0], e.get(1).copied().unwrap_or(f64::INFINITY)))
                    .collect()
            })
    }

    proptest! {
        #[test]
        fn the_algebra_is_that_of_sets(a in spans(), b in spans(), t in -21..21_i32) {
            // Between the ends, where membership is beyond doubt.
            let t = f64::from(t) + 0.5;
            let (in_a, in_b) = (contains(&a, t), contains(&b, t));
            prop_assert_eq!(contains(&union(a.clone(), b.clone()), t), in_a || in_b);
            prop_assert_eq!(contains(&intersection(&a, &b), t), in_a && in_b);
            prop_assert_eq!(contains(&difference(&a, &b), t), in_a && !in_b);
        }

        #[test]
        fn results_are_sorted_and_face_outwards(a in spans(), b in spans()) {
            for list in [union(a.clone(), b.clone()), intersection(&a, &b), difference(&a, &b)] {
                let flat: Vec<f64> = list.iter().flat_map(|s| [s.enter.t, s.leave.t]).collect();
                prop_assert!(flat.windows(2).all(|w| w[0] < w[1]), "{flat:?}");
                for s in &list {
                    prop_assert!(s.enter.enters && !s.leave.enters);
                    if s.enter.t.is_finite() {
                        prop_assert!(s.enter.normal.x < 0.0);
                    }
                    if s.leave.t.is_finite() {
                        prop_assert!(s.leave.normal.x > 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn faces_that_coincide_leave_no_film() {
        let cut = difference(&[span(0.1 + 0.2, 1.0)], &[span(0.0, 1.0 - f64::EPSILON)]);
        assert_eq!(ends(&cut), []);
    }

    #[test]
    fn what_starts_behind_is_seen_from_inside() {
        let inside = [span(-1.0, 2.0)];
        assert_eq!(first_after(&inside, 0.0).map(|c| c.t), Some(2.0));
        assert!(first_after(&[span(f64::NEG_INFINITY, f64::INFINITY)], 0.0).is_none());
    }
}

//! Boxes along the axes: what encloses an object closer than a sphere.

use glam::DVec3;

/// A box along the axes of an object's own coordinates, in scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Its lowest corner.
    pub min: DVec3,
    /// Its highest corner.
    pub max: DVec3,
}

/// Several boxes are taken where they show no more than this share of the one
/// around them all.
const WORTHWHILE: f64 = 0.9;

/// More boxes than this are halved along their longest side before pairs are
/// looked at.
const MOST_PAIRED: usize = 128;

impl Extent {
    /// Its eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|k| {
            let pick = |axis: usize| k >> axis & 1 == 1;
            DVec3::select(
                glam::BVec3::new(pick(0), pick(1), pick(2)),
                self.max,
                self.min,
            )
        })
    }

    /// The box around both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// Half of what its sides measure: how much of a picture it may fill, from
    /// whatever side one looks.
    fn half_area(&self) -> f64 {
        let d = self.max - self.min;
        d.x * d.y + d.y * d.z + d.z * d.x
    }

    /// At most `most` boxes around all of `boxes`, as small as is easily found; the
    /// one around them all where several are no smaller.
    pub fn few(boxes: Vec<Self>, most: usize) -> Vec<Self> {
        let Some(whole) = boxes.iter().copied().reduce(|a, b| a.union(&b)) else {
            return Vec::new();
        };
        let mut boxes = halved(boxes, MOST_PAIRED.max(most));
        while boxes.len() > most.max(1) {
            merge_nearest(&mut boxes);
        }
        // What is not a number is not smaller.
        if share_seen(&boxes, &whole) <= WORTHWHILE {
            boxes
        } else {
            vec![whole]
        }
    }
}

/// How much of what is seen of `whole` along its axes is seen of `boxes`, all in
/// all: from 0 to 1.
fn share_seen(boxes: &[Extent], whole: &Extent) -> f64 {
    const CELLS: usize = 32;
    let sides = whole.max - whole.min;
    // The first cell that a box touches, and the one behind its last.
    let cells = |b: &Extent, axis: usize| {
        let at = |place: f64| (place - whole.min[axis]) / sides[axis] * CELLS as f64;
        let first = at(b.min[axis]).floor().max(0.0) as usize;
        let end = at(b.max[axis]).ceil().max(1.0) as usize;
        first.min(CELLS - 1)..end.min(CELLS)
    };
    let (mut seen, mut all) = (0.0, 0.0);
    for axis in 0..3 {
        let (across, down) = ((axis + 1) % 3, (axis + 2) % 3);
        let area = sides[across] * sides[down];
        let mut grid = [[false; CELLS]; CELLS];
        for b in boxes {
            for row in &mut grid[cells(b, down)] {
                row[cells(b, across)].fill(true);
            }
        }
        let touched = grid.as_flattened().iter().filter(|cell| **cell).count();
        seen += area * touched as f64 / (CELLS * CELLS) as f64;
        all += area;
    }
    seen / all
}

/// At most `limit` boxes: halved at the median of the longest side until few
/// enough are left.
fn halved(mut boxes: Vec<Extent>, limit: usize) -> Vec<Extent> {
    if boxes.len() <= limit {
        return boxes;
    }
    let whole = boxes.iter().copied().reduce(|a, b| a.union(&b));
    let Some(whole) = whole.filter(|_| limit > 1) else {
        return whole.into_iter().collect();
    };
    let axis = (whole.max - whole.min).max_position();
    let middle = |b: &Extent| b.min[axis] + b.max[axis];
    let half = boxes.len() / 2;
    boxes.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)));
    let upper = boxes.split_off(half);
    let mut all = halved(boxes, limit / 2);
    all.extend(halved(upper, limit - limit / 2));
    all
}

/// Joins the two boxes whose union is the least larger than they are.
fn merge_nearest(boxes: &mut Vec<Extent>) {
    let mut best = (f64::INFINITY, 0, 1);
    for (i, a) in boxes.iter().enumerate() {
        for (j, b) in boxes.iter().enumerate().skip(i + 1) {
            let grown = a.union(b).half_area() - a.half_area() - b.half_area();
            if grown < best.0 {
                best = (grown, i, j);
            }
        }
    }
    let (_, i, j) = best;
    let gone = boxes.swap_remove(j);
    boxes[i] = boxes[i].union(&gone);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn around(centre: DVec3, half: f64) -> Extent {
        Extent {
            min: centre - half,
            max: centre + half,
        }
    }

    #[test]
    fn what_lies_together_is_joined() {
        let pair = |x: f64| [around(DVec3::X * x, 1.0), around(DVec3::X * (x + 1.0), 1.0)];
        let few = Extent::few([pair(0.0), pair(50.0)].concat(), 2);
        assert_eq!(few.len(), 2);
        let lengths = few.iter().map(|b| b.max.x - b.min.x);
        assert!(lengths.into_iter().all(|length| length == 3.0));
        // Boxes in one another are no better than the largest.
        let nested = [around(DVec3::ZERO, 2.0), around(DVec3::ZERO, 1.0)];
        assert_eq!(Extent::few(nested.to_vec(), 2), [nested[0]]);
        assert!(Extent::few(Vec::new(), 2).is_empty());
        // A car: a long low box, and a short one on it that lies in it in part.
        let body = Extent {
            min: DVec3::new(-3.0, 0.0, -1.0),
            max: DVec3::new(3.0, 1.0, 1.0),
        };
        let cabin = around(DVec3::Y * 0.8, 1.0);
        assert_eq!(Extent::few(vec![body, cabin], 2), [body, cabin]);
        // What is flat has no width to look at, but has an area.
        let flat = |x: f64| Extent {
            min: DVec3::new(x, 0.0, 0.0),
            max: DVec3::new(x + 1.0, 0.0, 1.0),
        };
        assert_eq!(Extent::few(vec![flat(0.0), flat(9.0)], 2).len(), 2);
    }

    proptest! {
        #[test]
        fn nothing_is_left_out(
            places in prop::collection::vec((-9.0..9.0, -9.0..9.0, -9.0..9.0, 0.0..3.0), 1..300),
            most in 1_usize..20,
        ) {
            let boxes: Vec<Extent> = places
                .into_iter()
                .map(|(x, y, z, half)| around(DVec3::new(x, y, z), half))
                .collect();
            let few = Extent::few(boxes.clone(), most);
            prop_assert!(few.len() <= most);
            for b in boxes {
                prop_assert!(few.iter().any(|f| f.min.cmple(b.min).all() && f.max.cmpge(b.max).all()));
            }
        }
    }
}

//! Trees of solids, and the pieces of a line that are inside of them.

use decor_api::{Csg, Material};

use crate::extent::Extent;
use crate::placement::Placement;
use crate::primitive::Primitive;
use crate::ray::Ray;
use crate::span::{self, Crossing, Span};

/// A tree without transforms and looks: they are in the leaves.
pub(crate) enum Solid {
    Leaf(Box<Leaf>),
    Union(Vec<Solid>),
    Intersection(Vec<Solid>),
    Difference(Box<Solid>, Vec<Solid>),
}

pub(crate) struct Leaf {
    primitive: Primitive,
    placement: Placement,
    look: u32,
}

/// Through one node that only places or paints what is below.
pub(crate) fn descend<'a>(
    node: &'a Csg,
    placement: Placement,
    look: u32,
    looks: &mut Vec<Material>,
) -> (&'a Csg, Placement, u32) {
    match node {
        Csg::Translate(by, node) => (node, placement.translated(*by), look),
        Csg::Rotate(angles_deg, node) => (node, placement.rotated(*angles_deg), look),
        Csg::Scale(factors, node) => (node, placement.scaled(*factors), look),
        Csg::Look(material, node) => {
            looks.push(*material);
            // Fewer looks than nodes, and nodes fit into memory.
            (node, placement, (looks.len() - 1) as u32)
        }
        other => (other, placement, look),
    }
}

impl Solid {
    /// `None` where nothing is inside.
    pub fn of(
        node: &Csg,
        placement: Placement,
        look: u32,
        looks: &mut Vec<Material>,
    ) -> Option<Self> {
        let mut all = |nodes: &[Csg]| -> Vec<Option<Self>> {
            nodes
                .iter()
                .map(|node| Self::of(node, placement, look, looks))
                .collect()
        };
        match node {
            Csg::Union(nodes) => {
                let nodes: Vec<Self> = all(nodes).into_iter().flatten().collect();
                (!nodes.is_empty()).then_some(Self::Union(nodes))
            }
            Csg::Intersection(nodes) => {
                let nodes: Option<Vec<Self>> = all(nodes).into_iter().collect();
                nodes.filter(|n| !n.is_empty()).map(Self::Intersection)
            }
            Csg::Difference(first, rest) => {
                let rest = all(rest).into_iter().flatten().collect();
                let first = Self::of(first, placement, look, looks)?;
                Some(Self::Difference(Box::new(first), rest))
            }
            Csg::Translate(..) | Csg::Rotate(..) | Csg::Scale(..) | Csg::Look(..) => {
                let (node, placement, look) = descend(node, placement, look, looks);
                Self::of(node, placement, look, looks)
            }
            leaf => {
                let primitive = Primitive::of(leaf).filter(|_| placement.is_usable())?;
                Some(Self::Leaf(Box::new(Leaf {
                    primitive,
                    placement,
                    look,
                })))
            }
        }
    }

    /// Is it a mesh by itself: a surface, whether it is closed or not?
    pub fn is_surface(&self) -> bool {
        matches!(self, Self::Leaf(leaf) if matches!(leaf.primitive, Primitive::Mesh(_)))
    }

    pub fn extent(&self) -> Extent {
        let around = |solids: &[Self], join: fn(&Extent, &Extent) -> Extent, start| {
            solids.iter().fold(start, |e, s| join(&e, &s.extent()))
        };
        match self {
            Self::Leaf(leaf) => leaf.placement.extent_outwards(&leaf.primitive.extent()),
            Self::Union(all) => around(all, Extent::union, Extent::EMPTY),
            Self::Intersection(all) => around(all, Extent::intersection, Extent::EVERYTHING),
            Self::Difference(first, _) => first.extent(),
        }
    }

    /// The first surface between `after` and `before`. A mesh that stands for
    /// itself is a surface, whether it is closed or not.
    pub fn nearest(&self, ray: &Ray, after: f64, before: f64) -> Option<Crossing> {
        if let Self::Leaf(leaf) = self
            && let Primitive::Mesh(mesh) = &leaf.primitive
        {
            let inwards = leaf.placement.inwards(ray);
            let found = mesh.nearest(&inwards, after, before, leaf.look)?;
            return Some(outwards(&leaf.placement, found));
        }
        span::first_after(&self.spans(ray), after).filter(|c| c.t < before)
    }

    /// The pieces of the whole line that are inside.
    pub fn spans(&self, ray: &Ray) -> Vec<Span> {
        match self {
            Self::Leaf(leaf) => {
                let inwards = leaf.placement.inwards(ray);
                let mut spans = leaf.primitive.spans(&inwards, leaf.look);
                for span in &mut spans {
                    span.enter = outwards(&leaf.placement, span.enter);
                    span.leave = outwards(&leaf.placement, span.leave);
                }
                spans
            }
            Self::Union(all) => merged(all, ray),
            Self::Intersection(all) => {
                let mut common: Option<Vec<Span>> = None;
                for solid in all {
                    let spans = match common.take() {
                        None => solid.spans(ray),
                        Some(so_far) => span::intersection(&so_far, &solid.spans(ray)),
                    };
                    if spans.is_empty() {
                        return spans;
                    }
                    common = Some(spans);
                }
                common.unwrap_or_default()
            }
            Self::Difference(first, rest) => {
                let whole = first.spans(ray);
                if whole.is_empty() {
                    return whole;
                }
                span::difference(&whole, &merged(rest, ray))
            }
        }
    }
}

fn merged(solids: &[Solid], ray: &Ray) -> Vec<Span> {
    solids.iter().fold(Vec::new(), |so_far, solid| {
        span::union(so_far, solid.spans(ray))
    })
}

fn outwards(placement: &Placement, crossing: Crossing) -> Crossing {
    let normal = placement.normal_outwards(crossing.normal);
    Crossing { normal, ..crossing }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::membership::{contains, trees};
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3000))]

        #[test]
        fn intervals_agree_with_membership(
            tree in trees(),
            origin in crate::membership::vec3(6.0),
            target in crate::membership::vec3(2.0),
        ) {
            prop_assume!(origin.distance(target) > 0.1);
            let ray = Ray { origin, direction: target - origin };
            let solid = Solid::of(&tree, Placement::IDENTITY, 0, &mut Vec::new());
            let spans = solid.as_ref().map_or_else(Vec::new, |s| s.spans(&ray));
            let extent = solid.as_ref().map_or(Extent::EMPTY, Solid::extent).widened();
            for i in 0..150 {
                let t = -1.0 + f64::from(i) * 0.0231;
                let near_an_end = spans.iter().any(|s| {
                    (s.enter.t - t).abs() < 1e-9 || (s.leave.t - t).abs() < 1e-9
                });
                if near_an_end {
                    continue;
                }
                let inside = spans.iter().any(|s| s.enter.t < t && t < s.leave.t);
                prop_assert_eq!(inside, contains(&tree, ray.at(t)), "at {} in {:?}", t, spans);
                if inside {
                    let p = ray.at(t);
                    prop_assert!(p.cmpge(extent.min).all() && p.cmple(extent.max).all());
                }
            }
            for span in &spans {
                for c in [span.enter, span.leave] {
                    if !c.t.is_finite() {
                        continue;
                    }
                    prop_assert!(c.normal.is_finite() && c.normal != DVec3::ZERO);
                    let normal = c.normal.normalize();
                    let side = normal.dot(ray.direction.normalize());
                    prop_assert!(if c.enters { side < 1e-6 } else { side > -1e-6 }, "{:?}", c);
                }
            }
        }
    }
}

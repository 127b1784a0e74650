//! Prototypes made ready: trees of solids, flattened as far as they go.

use std::collections::HashMap;
use std::sync::Arc;

use decor_api::{
    AdapterError, Csg, Geometry, Instance, Material, PrototypeId, PrototypeTable, Scene,
};

use crate::adapter::unsupported;
use crate::extent::Extent;
use crate::placement::Placement;
use crate::ray::Ray;
use crate::solid::{Solid, descend};
use crate::span::Crossing;
use crate::tree::Tree;

/// The geometry of a film's prototypes, ready for rays: made once, shared by
/// all frames and instances.
#[derive(Clone, Default)]
pub struct Models {
    by_id: HashMap<PrototypeId, Arc<Model>>,
}

impl Models {
    /// Prepares the prototypes that the instances of `scenes` name, hidden ones
    /// too.
    ///
    /// # Errors
    /// [`AdapterError::Unsupported`] for a fragment, and for a number that is
    /// not in the table.
    pub fn prepare<'a>(
        prototypes: &PrototypeTable,
        scenes: impl IntoIterator<Item = &'a Scene>,
    ) -> Result<Self, AdapterError> {
        let placed = scenes
            .into_iter()
            .flat_map(|scene| scene.instances.iter().chain(&scene.hidden));
        Self::of_instances(prototypes, placed)
    }

    /// Prepares the prototypes that `instances` name.
    pub(crate) fn of_instances<'a>(
        prototypes: &PrototypeTable,
        instances: impl IntoIterator<Item = &'a Instance>,
    ) -> Result<Self, AdapterError> {
        let mut by_id = HashMap::new();
        for instance in instances {
            let id = instance.prototype;
            if by_id.contains_key(&id) {
                continue;
            }
            if id.0 as usize >= prototypes.len() {
                return Err(unsupported(format!("prototype {}: there is none", id.0)));
            }
            let prototype = prototypes.get(id);
            match &prototype.geometry {
                Geometry::Neutral(tree) => by_id.insert(id, Arc::new(Model::new(tree))),
                Geometry::Fragment(_) => {
                    return Err(unsupported(format!(
                        "{}: only the renderer that it is written for reads it",
                        prototype.path.display()
                    )));
                }
            };
        }
        Ok(Self { by_id })
    }

    pub(crate) fn get(&self, id: PrototypeId) -> Option<&Arc<Model>> {
        self.by_id.get(&id)
    }
}

/// One prototype in its own coordinates.
pub(crate) struct Model {
    /// What a union at the top is made of: each part keeps its own surface, as
    /// in a renderer's union, so that a part seen from inside another, or
    /// through its glass, is there.
    parts: Vec<Solid>,
    tree: Tree,
    looks: Vec<Material>,
    extent: Extent,
}

impl Model {
    pub fn new(tree: &Csg) -> Self {
        let mut looks = vec![Material::default()];
        let mut parts = Vec::new();
        flatten(tree, Placement::IDENTITY, 0, &mut looks, &mut parts);
        let extents: Vec<Extent> = parts.iter().map(Solid::extent).collect();
        Self {
            extent: extents.iter().fold(Extent::EMPTY, |all, e| all.union(e)),
            tree: Tree::new(extents),
            parts,
            looks,
        }
    }

    pub fn extent(&self) -> Extent {
        self.extent
    }

    pub fn look(&self, number: u32) -> &Material {
        &self.looks[number as usize]
    }

    /// The first surface between `after` and `before`; of two at the same
    /// place, the one of the part that is stated first.
    pub fn nearest(&self, ray: &Ray, after: f64, before: f64) -> Option<Crossing> {
        let mut found: Option<(u32, Crossing)> = None;
        self.tree.nearest(ray, after, before, |part, best| {
            let crossing = self.parts[part as usize].nearest(ray, after, best.next_up())?;
            let is_nearer = match &found {
                Some((first, c)) => (crossing.t, part) < (c.t, *first),
                None => crossing.t < before,
            };
            is_nearer.then(|| {
                found = Some((part, crossing));
                crossing.t
            })
        });
        found.map(|(part, crossing)| self.sided(&self.parts[part as usize], ray, crossing))
    }

    /// A mesh of glass: which way its surface is crossed is asked of the whole
    /// mesh, where it is closed, not of the order of a triangle's corners.
    fn sided(&self, part: &Solid, ray: &Ray, crossing: Crossing) -> Crossing {
        if !part.is_surface() || self.look(crossing.look).transmission <= 0.0 {
            return crossing;
        }
        let spans = part.spans(ray);
        let mut all = spans.iter().flat_map(|s| [s.enter, s.leave]);
        all.find(|c| c.t == crossing.t).unwrap_or(crossing)
    }
}

/// Collects the parts of what is a union from the top down.
fn flatten(
    node: &Csg,
    placement: Placement,
    look: u32,
    looks: &mut Vec<Material>,
    parts: &mut Vec<Solid>,
) {
    match node {
        Csg::Union(nodes) => {
            for node in nodes {
                flatten(node, placement, look, looks, parts);
            }
        }
        Csg::Look(..) | Csg::Translate(..) | Csg::Rotate(..) | Csg::Scale(..) => {
            let (node, placement, look) = descend(node, placement, look, looks);
            flatten(node, placement, look, looks, parts);
        }
        _ => parts.extend(Solid::of(node, placement, look, looks)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use decor_api::Rgb;
    use glam::DVec3;

    fn red() -> Material {
        Material {
            colour: Rgb([1.0, 0.0, 0.0]),
            ..Material::default()
        }
    }

    fn ball(x: f64) -> Csg {
        Csg::Sphere {
            centre: DVec3::X * x,
            radius: 1.0,
        }
    }

    fn first(tree: &Csg, origin: DVec3, direction: DVec3) -> Option<(f64, DVec3, Material)> {
        let model = Model::new(tree);
        let hit = model.nearest(&Ray { origin, direction }, 0.0, f64::INFINITY)?;
        Some((hit.t, hit.normal.normalize(), *model.look(hit.look)))
    }

    #[test]
    fn the_innermost_look_wins_and_the_cut_has_the_cutter_s() {
        let blue = Material {
            colour: Rgb([0.0, 0.0, 1.0]),
            ..Material::default()
        };
        let tree = Csg::Look(
            red(),
            Box::new(Csg::Difference(
                Box::new(ball(0.0)),
                vec![Csg::Look(blue, Box::new(ball(-1.0)))],
            )),
        );
        let (t, normal, look) = first(&tree, DVec3::X * -5.0, DVec3::X).unwrap();
        assert_eq!((t, normal, look), (5.0, -DVec3::X, blue));
        let (t, normal, look) = first(&tree, DVec3::X * 5.0, -DVec3::X).unwrap();
        assert_eq!((t, normal, look), (4.0, DVec3::X, red()));
    }

    #[test]
    fn transforms_apply_from_the_inside_out() {
        let tree = Csg::Rotate(
            DVec3::Z * 90.0,
            Box::new(Csg::Translate(
                DVec3::X * 5.0,
                Box::new(Csg::Scale(DVec3::new(1.0, 2.0, 1.0), Box::new(ball(0.0)))),
            )),
        );
        // Stretched along y, moved along x, turned: it lies along x at y = 5.
        let (t, normal, _) = first(&tree, DVec3::new(-9.0, 5.0, 0.0), DVec3::X).unwrap();
        assert!((t - 7.0).abs() < 1e-12, "{t}");
        assert!(normal.distance(-DVec3::X) < 1e-12);
        let (t, ..) = first(&tree, DVec3::ZERO, DVec3::Y * 2.0).unwrap();
        assert!((t - 2.0).abs() < 1e-12, "{t}");
    }

    #[test]
    fn a_scale_of_nothing_is_nothing() {
        let flat = Csg::Scale(DVec3::new(1.0, 0.0, 1.0), Box::new(ball(0.0)));
        assert!(first(&flat, DVec3::X * -5.0, DVec3::X).is_none());
    }

    #[test]
    fn a_union_at_the_top_keeps_its_inner_surfaces() {
        let both = Csg::Union(vec![ball(0.0), ball(0.5)]);
        // From inside both, the nearer of the two surfaces is met first.
        let (t, ..) = first(&both, DVec3::X * 0.25, DVec3::X).unwrap();
        assert_eq!(t, 0.75);
        let merged = Csg::Intersection(vec![both, ball(0.0)]);
        let (t, ..) = first(&merged, DVec3::X * -5.0, DVec3::X).unwrap();
        assert_eq!(t, 4.0);
    }

    #[test]
    fn a_closed_mesh_cuts_and_is_cut() {
        let cube = Csg::Mesh(Arc::new(crate::mesh::tests::cube()));
        let hollow = Csg::Difference(Box::new(ball(0.0)), vec![cube.clone()]);
        assert!(first(&hollow, DVec3::X * -5.0, DVec3::X).is_none());
        let moved = Csg::Translate(DVec3::X, Box::new(cube));
        let half = Csg::Intersection(vec![ball(0.0), moved]);
        let (t, normal, _) = first(&half, DVec3::new(-5.0, 0.1, 0.2), DVec3::X).unwrap();
        assert!((t - 5.0).abs() < 1e-12 && normal == -DVec3::X);
    }
}

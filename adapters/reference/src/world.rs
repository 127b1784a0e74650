//! The posed instances of a frame, and the rays that are cast among them.

use std::sync::Arc;

use decor_api::{AdapterError, Instance, Material, PrototypeTable, Scene};
use glam::{DMat3, DVec3};

use crate::adapter::unsupported;
use crate::extent::Extent;
use crate::model::{Model, Models};
use crate::ray::{Ray, unit};
use crate::tree::Tree;

/// The solids of one frame, ready for rays. What is asked of it is exact to
/// some units in the last place of the coordinates involved.
pub struct World {
    bodies: Vec<Body>,
    tree: Tree,
    reach: f64,
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// From the ray's origin, in scene units; > 0, finite.
    pub distance: f64,
    /// Where.
    pub point: DVec3,
    /// Out of the solid, of length 1; for a mesh, by the order of the
    /// triangle's corners: (b − a) × (c − a).
    pub normal: DVec3,
    /// The number of the instance in the scene's list.
    pub instance: usize,
    /// The look of the surface.
    pub material: Material,
}

/// An instance. Poses are rigid: a ray keeps its parameter, and its length.
struct Body {
    model: Arc<Model>,
    turn: DMat3,
    position: DVec3,
    instance: u32,
}

impl Body {
    /// The difference is taken first: far from the origin it is what keeps its
    /// digits.
    fn inwards(&self, ray: &Ray) -> Ray {
        let back = self.turn.transpose();
        Ray {
            origin: back * (ray.origin - self.position),
            direction: back * ray.direction,
        }
    }
}

/// A surface that a ray meets, as the shading needs it.
pub(crate) struct Found<'a> {
    pub t: f64,
    /// Out of the solid, of length 1.
    pub normal: DVec3,
    /// Does the ray go into the solid here?
    pub enters: bool,
    pub material: &'a Material,
    instance: u32,
}

impl World {
    /// Poses the instances of a scene. One whose pose is not finite is nowhere.
    ///
    /// # Errors
    /// [`AdapterError::Unsupported`] where `models` was not prepared for the
    /// scene.
    pub fn new(models: &Models, scene: &Scene) -> Result<Self, AdapterError> {
        Self::posed(models, &scene.instances)
    }

    /// The same with the instances that are hidden from the camera, behind the
    /// others in the list.
    pub(crate) fn with_hidden(models: &Models, scene: &Scene) -> Result<Self, AdapterError> {
        Self::posed(models, scene.instances.iter().chain(&scene.hidden))
    }

    /// Poses some instances.
    pub(crate) fn posed<'i>(
        models: &Models,
        instances: impl IntoIterator<Item = &'i Instance>,
    ) -> Result<Self, AdapterError> {
        let mut bodies = Vec::new();
        for (number, instance) in (0_u32..).zip(instances) {
            let id = instance.prototype;
            let model = models
                .get(id)
                .ok_or_else(|| unsupported(format!("prototype {}: it is not prepared", id.0)))?;
            let body = Body {
                model: model.clone(),
                turn: DMat3::from_quat(instance.pose.rotation()),
                position: instance.pose.position,
                instance: number,
            };
            if body.turn.is_finite() && body.position.is_finite() {
                bodies.push(body);
            }
        }
        let extents: Vec<Extent> = bodies
            .iter()
            .map(|b| b.model.extent().transformed(&b.turn, b.position))
            .collect();
        let reach = bodies
            .iter()
            .zip(&extents)
            .map(|(b, e)| e.reach().max(b.position.abs().max_element()))
            .fold(0.0, f64::max);
        Ok(Self {
            tree: Tree::new(extents),
            bodies,
            reach,
        })
    }

    /// Prepares the prototypes and poses the instances of one scene. For many
    /// scenes of one film, [`Models::prepare`] does the first once.
    ///
    /// # Errors
    /// As [`Models::prepare`].
    pub fn of(scene: &Scene, prototypes: &PrototypeTable) -> Result<Self, AdapterError> {
        Self::new(&Models::prepare(prototypes, [scene])?, scene)
    }

    /// The first surface in a direction, which may have any length but 0. From
    /// inside a solid, that is its far side. Of two surfaces at the very same
    /// distance it is the one of the instance that is listed first.
    pub fn cast(&self, origin: DVec3, direction: DVec3) -> Option<Hit> {
        let ray = Ray {
            origin,
            direction: unit(direction)?,
        };
        let found = self.nearest(&ray, 0.0, f64::INFINITY)?;
        Some(Hit {
            distance: found.t,
            point: ray.at(found.t),
            normal: found.normal,
            instance: found.instance as usize,
            material: *found.material,
        })
    }

    /// Is there no surface strictly between two points? Surfaces closer to an
    /// end than a billionth of the distance do not count: ends may lie on them.
    pub fn is_clear(&self, from: DVec3, to: DVec3) -> bool {
        let ray = Ray {
            origin: from,
            direction: to - from,
        };
        self.nearest(&ray, 1e-9, 1.0 - 1e-9).is_none()
    }

    /// The first surface with its parameter between `after` and `before`.
    pub(crate) fn nearest(&self, ray: &Ray, after: f64, before: f64) -> Option<Found<'_>> {
        let mut found: Option<(f64, u32, DVec3, bool, u32)> = None;
        self.tree.nearest(ray, after, before, |leaf, best| {
            let body = self.bodies.get(leaf as usize)?;
            let crossing = body
                .model
                .nearest(&body.inwards(ray), after, best.next_up())?;
            let is_nearer = match found {
                Some((t, first, ..)) => (crossing.t, leaf) < (t, first),
                None => crossing.t < before,
            };
            is_nearer.then(|| {
                found = Some((
                    crossing.t,
                    leaf,
                    crossing.normal,
                    crossing.enters,
                    crossing.look,
                ));
                crossing.t
            })
        });
        let (t, leaf, normal, enters, look) = found?;
        let body = &self.bodies[leaf as usize];
        Some(Found {
            t,
            normal: unit(body.turn * normal).unwrap_or(-ray.direction),
            enters,
            material: body.model.look(look),
            instance: body.instance,
        })
    }

    /// The largest absolute coordinate of any instance, for rounding errors.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }
}

//! How much of a light arrives at points of surfaces: the part of the shadow
//! map (thesis III-3-4) that is made anew in every frame.
//!
//! What comes back is a *fraction* of each channel of the light: the caller
//! keeps a picture without light and one per light, and adds
//! `no light + Σ (lightᵢ − no light) · fractionᵢ`.

use std::sync::Arc;

use glam::DVec3;

use crate::prototype::PrototypeTable;
use crate::scene::{Instance, Light, LightKind, NativeFile};

/// A point of a surface, in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// Where it is.
    pub position: DVec3,
    /// The length on the surface that one pixel covers there: two points are
    /// about as far apart, and what is put at one keeps clear of the next.
    pub footprint: f64,
}

/// One light, in one frame.
#[derive(Clone, Debug)]
pub struct ArrivalShot {
    /// The frame's number, for names and messages.
    pub frame: u32,
    /// The light. Its colour and its fading do not matter: they are in the
    /// picture that the fraction is multiplied by.
    pub light: Light,
    /// What may stand in its way. Fractions of two groups of casters do not
    /// multiply under an area light, whose penumbrae overlap: it needs all
    /// casters at once.
    pub casters: Arc<[Instance]>,
    /// Where the light arrives.
    pub points: Arc<[SurfacePoint]>,
}

/// What is asked in one go.
#[derive(Clone, Debug)]
pub struct ArrivalRequest<'a> {
    /// The geometry that the casters name.
    pub prototypes: &'a PrototypeTable,
    /// The film's declarations.
    pub includes: &'a [NativeFile],
    /// Frames and lights, in any order.
    pub shots: Vec<ArrivalShot>,
    /// A short name for kept files, for example `arrival-0000`.
    pub label: String,
}

impl Light {
    /// May the light shine on a point where nothing stands in its way? `false`
    /// is certain: the point is outside of a spot's cone, or it is no place at
    /// all.
    pub fn may_reach(&self, point: DVec3) -> bool {
        let way = point - self.position;
        let LightKind::Spot {
            towards,
            radius_deg,
            falloff_deg,
            ..
        } = self.kind
        else {
            return point.is_finite();
        };
        let axis = towards - self.position;
        let (Some(way), Some(axis)) = (way.try_normalize(), axis.try_normalize()) else {
            return point.is_finite();
        };
        // Rounding must not darken what is just inside.
        let widest = radius_deg.max(falloff_deg).clamp(0.0, 90.0);
        way.dot(axis) >= widest.to_radians().cos() - 1e-9
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Rgb;

    fn lamp(kind: LightKind) -> Light {
        Light {
            position: DVec3::Y * 10.0,
            colour: Rgb([1.0; 3]),
            kind,
            fade: None,
        }
    }

    #[test]
    fn a_spot_reaches_its_cone_alone() {
        let spot = lamp(LightKind::Spot {
            towards: DVec3::ZERO,
            radius_deg: 10.0,
            falloff_deg: 20.0,
            tightness: 3.0,
        });
        let at = |degrees: f64| DVec3::X * 10.0 * degrees.to_radians().tan();
        assert!(spot.may_reach(at(0.0)) && spot.may_reach(at(20.0)));
        assert!(!spot.may_reach(at(20.001)));
        assert!(!spot.may_reach(DVec3::Y * 20.0), "behind");
        assert!(spot.may_reach(spot.position), "nobody knows");
    }

    #[test]
    fn other_lights_reach_every_place() {
        let lamp = lamp(LightKind::Point);
        assert!(lamp.may_reach(DVec3::splat(1e6)));
        assert!(!lamp.may_reach(DVec3::NAN));
    }
}

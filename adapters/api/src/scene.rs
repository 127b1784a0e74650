//! The neutral scene: everything that one frame's picture depends on.

use std::path::PathBuf;

use glam::{DAffine3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

use crate::camera::Camera;
use crate::prototype::PrototypeId;

/// A linear colour: red, green, blue. 1 is white; more is allowed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Rgb(pub [f64; 3]);

/// How fast a light fades with the distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fade {
    /// Where it has its full colour.
    pub distance: f64,
    /// The power of the fall-off (2 is nature's).
    pub power: f64,
}

/// The shape of a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From one point into every direction.
    Point,
    /// Parallel rays, from the light's position towards a point.
    Sun {
        /// Where the rays go.
        towards: DVec3,
    },
    /// A cone of light.
    Spot {
        /// Where the cone's axis goes.
        towards: DVec3,
        /// Half the angle of the full light, in degrees.
        radius_deg: f64,
        /// Half the angle where there is none any more, in degrees.
        falloff_deg: f64,
        /// The exponent of the cosine to the axis.
        tightness: f64,
    },
    /// A rectangle, sampled as a grid without jitter, centred on the position.
    Area {
        /// One whole side.
        u: DVec3,
        /// The other.
        v: DVec3,
        /// Samples along `u`, ≥ 1.
        nu: u32,
        /// Samples along `v`, ≥ 1.
        nv: u32,
    },
}

/// A light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Where it stands.
    pub position: DVec3,
    /// Its linear colour.
    pub colour: Rgb,
    /// Its shape.
    pub kind: LightKind,
    /// `None`: as bright far away as near.
    pub fade: Option<Fade>,
}

/// Where `n` samples of an area light are on a side, from edge to edge (−½ to ½; a single one is
/// in the middle), and the weight of each. The weights are POV-Ray's, in whose
/// terms films describe lights: it halves the side until two samples are next
/// to each other and takes the mean of every pair.
pub fn area_samples(n: u32) -> Vec<(f64, f64)> {
    fn halve(first: usize, last: usize, weight: f64, samples: &mut [(f64, f64)]) {
        if last - first <= 1 {
            samples[first].1 += 0.5 * weight;
            samples[last].1 += 0.5 * weight;
        } else {
            let sum = first + last;
            halve(first, sum / 2, 0.5 * weight, samples);
            halve(sum.div_ceil(2), last, 0.5 * weight, samples);
        }
    }
    if n <= 1 {
        return vec![(0.0, 1.0)];
    }
    let at = |k: u32| f64::from(k) / f64::from(n - 1) - 0.5;
    let mut samples: Vec<(f64, f64)> = (0..n).map(|k| (at(k), 0.0)).collect();
    halve(0, samples.len() - 1, 1.0, &mut samples);
    samples
}

/// Where an object is, and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Moved by this, after the rotation.
    pub position: DVec3,
    /// Turned about x, then y, then z, in degrees, left-handed.
    pub angles_deg: DVec3,
}

impl Pose {
    /// At the origin, not turned.
    pub const IDENTITY: Self = Self {
        position: DVec3::ZERO,
        angles_deg: DVec3::ZERO,
    };

    /// The rotation alone.
    pub fn rotation(&self) -> DQuat {
        rotation(self.angles_deg)
    }

    /// From the object's own coordinates to the world's.
    pub fn transform(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation(), self.position)
    }
}

/// Turned about x, then y, then z, by degrees. A positive angle turns
/// left-handed: thumb of the left hand along the axis, the fingers show the
/// way. In coordinates (that know no hands) this is the usual matrix with the
/// usual sign.
pub fn rotation(angles_deg: DVec3) -> DQuat {
    let half_turns = |degrees: f64| degrees.rem_euclid(360.0).to_radians();
    DQuat::from_rotation_z(half_turns(angles_deg.z))
        * DQuat::from_rotation_y(half_turns(angles_deg.y))
        * DQuat::from_rotation_x(half_turns(angles_deg.x))
}

/// A placed copy of a prototype.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Instance {
    /// Which geometry.
    pub prototype: PrototypeId,
    /// Where.
    pub pose: Pose,
}

/// The renderer's own antialiasing, without jitter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Antialias {
    /// Colour difference between neighbours that asks for more rays.
    pub threshold: f64,
    /// Up to depth² rays a pixel; 1 to 9.
    pub depth: u32,
}

/// A renderer-native file: read once, so that what is rendered is what was
/// looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NativeFile {
    /// Its absolute path. Files that it includes are found beside it, or in the
    /// film's folder.
    pub path: PathBuf,
    /// The film's folder.
    pub root: PathBuf,
    /// Its bytes. POV-Ray's own files are not always UTF-8.
    pub text: Vec<u8>,
}

/// How a finished frame is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    /// PNG with 8 bits a channel.
    Png,
    /// PNG with 16 bits a channel.
    Png16,
    /// OpenEXR, linear.
    Exr,
}

impl PictureFormat {
    /// The ending of its files.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Png | Self::Png16 => "png",
            Self::Exr => "exr",
        }
    }
}

/// One frame's scene. Cheap to clone but for its instances.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// From where it is seen.
    pub camera: Camera,
    /// The lights.
    pub lights: Vec<Light>,
    /// Are shadows cast?
    pub shadows: bool,
    /// The colour where nothing is.
    pub background: Rgb,
    /// Renderer-native declarations, put into every pass, in order.
    pub includes: Vec<NativeFile>,
    /// What surrounds the scene, renderer-native: colour passes only.
    pub sky: Option<NativeFile>,
    /// The placed objects.
    pub instances: Vec<Instance>,
    /// More of them that the camera does not see, but that cast shadows and show
    /// in mirrors: what another layer draws. Depth takes no notice of them.
    pub hidden: Vec<Instance>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_apply_about_x_then_y_then_z() {
        // POV-Ray: `rotate <90, 90, 0>` takes y to z (about x), then z to x (about y).
        let turned = rotation(DVec3::new(90.0, 90.0, 0.0)) * DVec3::Y;
        assert!((turned - DVec3::X).length() < 1e-15, "{turned}");
    }

    #[test]
    fn many_turns_are_one() {
        let a = rotation(DVec3::new(0.0, 30.0, 0.0)) * DVec3::X;
        let b = rotation(DVec3::new(0.0, 30.0 + 360.0 * 1000.0, 0.0)) * DVec3::X;
        assert!((a - b).length() < 1e-12);
    }
}

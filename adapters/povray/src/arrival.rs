//! How much of a light arrives at points of surfaces, asked of POV-Ray: one
//! call that draws [lit receivers](crate::receivers), with the casters hidden
//! from the camera. The colour of a receiver is what arrives.
//!
//! Many frames and lights go into one call, one frame of the call each. The
//! picture is a list of rays, row by row; its first row repeats the second one
//! and is left out.
//!
//! Caustics make more than all of a light arrive; read from 16-bit pictures,
//! which end at 1, that is lost.

use decor_api::process::ProcessCall;
use decor_api::{
    AdapterError, ArrivalRequest, ArrivalShot, Bounds, Instance, Light, LightKind, NativeFile,
    PrototypeTable, Rgb, RunContext, SceneText, Size, SurfacePoint, Window,
};
use glam::DVec3;
use std::path::Path;

use crate::call::{LayerSource, fixed_switches};
use crate::folder::{Folder, fragments, keep_state, read_file, state_switches, take_state};
use crate::light;
use crate::picture::{self, Coding};
use crate::receivers::{Receivers, WHITE};
use crate::scene_text::{Framing, Numbering, Shared, Writer, placed_all, switches};
use crate::state::{self, Wanted};

/// The widest list picture, in pixels.
const WIDEST: u32 = 1024;

/// The name of the pictures, without an ending.
const NAME: &str = "arrival";

/// A shot that POV-Ray has to be asked about.
struct Asked {
    /// Its number in the request.
    shot: usize,
    frame: u32,
    casters: Vec<Instance>,
    light: Light,
    receivers: Receivers,
}

/// A request as POV-Ray is asked it.
pub struct Arrival<'r> {
    request: &'r ArrivalRequest<'r>,
    asked: Vec<Asked>,
}

impl<'r> Arrival<'r> {
    /// Looks at a request: what needs no answer of POV-Ray's is left out.
    pub fn new(request: &'r ArrivalRequest<'r>) -> Self {
        let mut asked = Vec::new();
        for (shot, one) in request.shots.iter().enumerate() {
            if one.casters.is_empty() {
                continue;
            }
            let near = brought_near(one);
            let outside = outside(request.prototypes, &near);
            let receivers = Receivers::of(&near.light, &near.points, outside);
            if !receivers.rays.is_empty() {
                asked.push(Asked {
                    shot,
                    frame: one.frame,
                    casters: near.casters.to_vec(),
                    light: bare(&near.light),
                    receivers,
                });
            }
        }
        Self { request, asked }
    }

    /// The files of the call.
    pub fn text(&self, writer: &Writer<'_>) -> SceneText {
        let prototypes = self.request.prototypes;
        let shared = Shared {
            includes: self.request.includes,
            settings: WHITE,
            ..Shared::placing(prototypes, self.asked.iter().flat_map(|a| &a.casters))
        };
        let frames = self.asked.iter().map(|asked| {
            let mut text = asked.receivers.text.clone();
            text.push_str(&light::light(&asked.light));
            text.push_str(&placed_all(prototypes, &asked.casters, "no_image"));
            text
        });
        writer.files(&shared, frames.collect(), self.numbering())
    }

    /// Asks POV-Ray. One fraction for each point of each shot.
    pub fn run(
        &self,
        program: &Path,
        source: LayerSource,
        writer: &Writer<'_>,
        run: &RunContext,
    ) -> Result<Vec<Vec<[f32; 3]>>, AdapterError> {
        let shots = self.request.shots.iter();
        let mut fractions: Vec<_> = shots.map(|s| vec![[1.0; 3]; s.points.len()]).collect();
        if self.asked.is_empty() {
            return Ok(fractions);
        }
        let folder = Folder::new(run, &self.request.label, &self.text(writer))?;
        self.call(program, source, &folder, run)?;
        for (k, asked) in self.asked.iter().enumerate() {
            let pixels = self.pixels(source, &folder, k)?;
            // The first ray is nobody's.
            for (pixel, &(point, cosine)) in pixels[1..].iter().zip(&asked.receivers.rays) {
                fractions[asked.shot][point] = fraction(*pixel, cosine, source);
            }
        }
        Ok(fractions)
    }

    fn numbering(&self) -> Numbering {
        Numbering::local(self.asked.len())
    }

    /// All frames of a call have one size; the rays that a frame does not have
    /// cost nothing.
    fn size(&self) -> Size {
        let most = self.asked.iter().map(|a| a.receivers.rays.len() + 1).max();
        let most = u32::try_from(most.unwrap_or(1)).unwrap_or(u32::MAX);
        let width = most
            .isqrt()
            .next_multiple_of(state::BLOCK)
            .clamp(state::BLOCK, WIDEST);
        Size {
            width,
            height: most.div_ceil(width) + 1,
        }
    }

    fn call(
        &self,
        program: &Path,
        source: LayerSource,
        folder: &Folder,
        run: &RunContext,
    ) -> Result<(), AdapterError> {
        let numbering = self.numbering();
        let mut args = fixed_switches();
        args.extend(switches(Framing::Full, self.size(), None));
        args.extend(numbering.args());
        let native = self.request.includes.iter();
        let native = native.chain(fragments(self.request.prototypes));
        args.extend(folder.library_switches(native.collect::<Vec<&NativeFile>>().into_iter())?);
        // What a ray starts inside of, POV-Ray asks once a thread, of the first
        // ray: with one thread that is the ray that starts outside.
        args.extend(["+WT1".into(), "+UA".into()]);
        match source {
            LayerSource::StateFile => {
                args.extend(state_switches(NAME));
                for k in 0..self.asked.len() {
                    let suffix = numbering.suffix(k);
                    keep_state(folder, NAME, &suffix, |to| to.write_all(&state::empty()))?;
                }
            }
            LayerSource::Pictures => args.extend([
                "+FN16".into(),
                format!("+O{NAME}.png"),
                "File_Gamma=1".into(),
            ]),
        }
        let call = ProcessCall {
            program,
            args,
            folder: folder.path(),
            doing: describe(&self.asked),
            log: run.keep.then(|| folder.file("povray.log")),
        };
        run.tally.add_call(self.asked.len());
        call.run_well(run)?;
        Ok(())
    }

    /// The pixels of the frame at `k` that hold its rays, and only those.
    fn pixels(
        &self,
        source: LayerSource,
        folder: &Folder,
        k: usize,
    ) -> Result<Vec<[f32; 4]>, AdapterError> {
        let size = self.size();
        let rays = self.asked[k].receivers.rays.len() + 1;
        let rows = u32::try_from(rays).unwrap_or(u32::MAX).div_ceil(size.width);
        let window = Window {
            x: 0,
            y: 1,
            width: size.width,
            height: rows,
        };
        let suffix = self.numbering().suffix(k);
        let bad = |file: &Path, reason: String| AdapterError::BadOutput {
            program: "povray".into(),
            file: file.to_owned(),
            reason,
        };
        let (file, mut pixels) = match source {
            LayerSource::StateFile => {
                let (file, bytes) = take_state(folder, NAME, &suffix)?;
                let pixels = state::pixels(bytes, window, Wanted::All)
                    .map_err(|error| bad(&file, error.to_string()))?;
                (file, pixels)
            }
            LayerSource::Pictures => {
                let file = folder.file(&format!("{NAME}{suffix}.png"));
                let bytes = read_file(&file)?;
                let pixels = picture::pixels(&bytes, window, Coding::Linear)
                    .map_err(|error| bad(&file, error.to_string()))?;
                (file, pixels)
            }
        };
        pixels.truncate(rays);
        let missed = pixels[1..].iter().filter(|p| p[3] < 0.5).count();
        if missed > 0 {
            let reason = format!("{missed} of {} points were not met", rays - 1);
            return Err(bad(&file, reason));
        }
        Ok(pixels)
    }
}

/// Farther from the origin than this, a shot is brought near.
const FAR: f64 = 1e4;

/// The same shot about the origin, where its points lie far from it: POV-Ray's
/// bounding boxes are in single precision, and 1e6 units away it met no small
/// mesh at all.
fn brought_near(shot: &ArrivalShot) -> ArrivalShot {
    let points = || shot.points.iter().map(|p| p.position);
    let there = || points().filter(|p| p.is_finite());
    let (low, high) = there().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let mut near = shot.clone();
    // Nothing is there, or it is near: the differences below would only round.
    if there().next().is_none() || low.abs().max(high.abs()).max_element() < FAR {
        return near;
    }
    let origin = (low * 0.5 + high * 0.5).round();
    near.light.position -= origin;
    if let LightKind::Sun { towards } | LightKind::Spot { towards, .. } = &mut near.light.kind {
        *towards -= origin;
    }
    let moved = |caster: &Instance| {
        let mut caster = *caster;
        caster.pose.position -= origin;
        caster
    };
    near.casters = shot.casters.iter().map(moved).collect();
    let moved = |point: &SurfacePoint| SurfacePoint {
        position: point.position - origin,
        ..*point
    };
    near.points = shot.points.iter().map(moved).collect();
    near
}

/// The light as its shadows need it: white, and as bright far away as near. Its
/// cone does not matter: only points inside are asked about.
fn bare(light: &Light) -> Light {
    let kind = match light.kind {
        LightKind::Spot { .. } => LightKind::Point,
        other => other,
    };
    Light {
        position: light.position,
        colour: Rgb([1.0; 3]),
        kind,
        fade: None,
    }
}

/// A point outside of all casters that have an end.
fn outside(prototypes: &PrototypeTable, shot: &ArrivalShot) -> DVec3 {
    let bounds = shot.casters.iter().filter_map(|caster| {
        match prototypes.get(caster.prototype).bounds.posed(&caster.pose) {
            Bounds::Sphere(sphere) => Some(sphere),
            Bounds::Empty | Bounds::Unbounded => None,
        }
    });
    let highest = bounds.map(|s| s.centre.y + s.radius);
    DVec3::Y * (highest.fold(0.0, f64::max) * 1.001 + 10.0)
}

/// What a receiver's colour says: of the whole light, that falls on it at an
/// angle of `cosine`, so much arrives.
fn fraction(pixel: [f32; 4], cosine: f64, source: LayerSource) -> [f32; 3] {
    // What is nearly all is all: where nothing changed, nothing is to change.
    let step = match source {
        LayerSource::StateFile => 1e-5,
        LayerSource::Pictures => 1.0 / 65535.0,
    };
    [pixel[0], pixel[1], pixel[2]].map(|channel| {
        let share = f64::from(channel) / cosine;
        if (share - 1.0).abs() <= step {
            1.0
        } else {
            share.max(0.0) as f32
        }
    })
}

fn describe(asked: &[Asked]) -> String {
    let frames = asked.iter().map(|a| a.frame);
    match (frames.clone().min(), frames.max()) {
        (Some(first), Some(last)) if first != last => {
            format!("the light that arrives in frames {first} to {last}")
        }
        (Some(first), _) => format!("the light that arrives in frame {first}"),
        _ => "the light that arrives".to_owned(),
    }
}

//! decor's adapter for Mitsuba 3.
//!
//! From request to layers:
//!
//! ```text
//! Csg ─ solid, cut, tessellate ─→ Model
//! request ─ scene_text (geometry, look, light, camera, units) ─→ XML, PLY
//!         ─ call ─→ pictures ─→ layers
//! ```
//!
//! What was found by trying 3.9.1, and decides the design:
//!
//! - The native binary inside the Python package needs no Python. With one or
//!   two threads (`-t`) it hangs for ever in its OpenEXR writer; with three or
//!   more it never did.
//! - Many scenes in one call are rendered one after the other.
//! - `direct` asks one light a sample, drawn by lot. One light alone leaves no
//!   choice: every light is rendered by itself, and the pictures are added.
//! - The `aov` integrator gives colour and depth at once, and takes 10 µs a
//!   sample where `direct` takes 1: colour and depth are two renders.
//! - A crop's rays differ from the full picture's in the last bit: mostly 1e-6,
//!   but a pixel on a shadow's edge may be lit in the one and dark in the other.
//!   A rectangle before the eye hides pixels and leaves the others as they are,
//!   bit for bit: blocks, and windows on their grid, are rendered so; other
//!   windows as crops, which cost less.
//! - Pixels are squares: see [`camera`].
//! - There are no lights without shadows; [`units`] says how they are made.
//! - A `sphere` wants rays of length 1, a torus is a `bsplinecurve`, planes are
//!   large discs (a large `rectangle` is off by 4e-4 of the distance), cones are
//!   meshes, and so is what is cut.

mod call;
mod camera;
mod cut;
mod geometry;
mod health;
mod light;
mod look;
mod picture;
mod scene_text;
mod solid;
mod tessellate;
mod units;
mod xml;

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use decor_api::process::{find_program, version};
use decor_api::{
    Abilities, Adapter, AdapterError, Baseline, DepthKind, Health, Instance, Layer, LayerRequest,
    PrototypeTable, RunContext, SceneText, encode,
};

use crate::call::LayerCall;
use crate::scene_text::Script;
use crate::solid::Model;

const NAME: &str = "mitsuba";

/// How to install Mitsuba.
pub const INSTALL: &str = "install it with `pip install mitsuba` (in a virtual environment), \
                           or name the program in DECOR_MITSUBA";

/// The side of the blocks of [`Region::Blocks`], in pixels, and the grid on which
/// windows are the whole picture's own.
pub use decor_api::BLOCK;

/// Mitsuba behind decor.
#[derive(Debug)]
pub struct Mitsuba {
    program: PathBuf,
    abilities: Abilities,
    /// Solids that were taken apart, by the hash of their content: cutting takes
    /// its time, and a film asks often.
    models: Mutex<HashMap<String, Arc<Model>>>,
}

impl Mitsuba {
    /// Finds Mitsuba: `DECOR_MITSUBA`, or `mitsuba` on the path. Where that is
    /// the script that Python's packages install, the binary in the package is
    /// taken.
    ///
    /// # Errors
    /// [`AdapterError::Missing`], or what goes wrong when it is asked for its
    /// version.
    pub fn find() -> Result<Self, AdapterError> {
        let program = find_program("DECOR_MITSUBA", "mitsuba", INSTALL)?;
        let program = native_binary(&program).unwrap_or(program);
        let version = version(&program, "--help", "Mitsuba version ")?;
        Ok(Self::new(program, &version))
    }

    /// Mitsuba as `program`, of a known version.
    pub fn new(program: PathBuf, version: &str) -> Self {
        Self {
            program,
            abilities: abilities(version),
            models: Mutex::default(),
        }
    }

    /// The program.
    pub fn program(&self) -> &Path {
        &self.program
    }

    fn script(&self, request: &LayerRequest<'_>) -> Result<Script, AdapterError> {
        Script::new(request, &|instance| {
            self.model(request.prototypes, instance)
        })
    }

    fn model(
        &self,
        table: &PrototypeTable,
        instance: &Instance,
    ) -> Result<Arc<Model>, AdapterError> {
        let hash = &table.get(instance.prototype).hash;
        let known = || self.models.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(model) = known().get(hash) {
            return Ok(Arc::clone(model));
        }
        let model = Arc::new(scene_text::model(table, instance)?);
        known().insert(hash.clone(), Arc::clone(&model));
        Ok(model)
    }
}

/// The binary in the package that a script in the folder `bin` belongs to.
fn native_binary(script: &Path) -> Option<PathBuf> {
    let script = script.canonicalize().ok()?;
    let mut start = [0_u8; 2];
    let mut file = std::fs::File::open(&script).ok()?;
    std::io::Read::read_exact(&mut file, &mut start).ok()?;
    if &start != b"#!" {
        return None;
    }
    let libraries = script.parent()?.parent()?.join("lib");
    let mut found: Vec<PathBuf> = std::fs::read_dir(libraries)
        .ok()?
        .flatten()
        .flat_map(|entry| {
            ["site-packages", "dist-packages"]
                .map(|packages| entry.path().join(packages).join("mitsuba/mitsuba"))
        })
        .filter(|binary| binary.is_file())
        .collect();
    found.sort();
    found.pop()
}

fn abilities(version: &str) -> Abilities {
    Abilities {
        version: version.to_owned(),
        csg: true,
        fragments: &[],
        depth_with_colour: false,
        depth: DepthKind::AlongRay,
        sample_position: (0.5, 0.5),
        crop_grid: Some(BLOCK),
        block_mask: true,
        // A mask is made of plates, one for each block.
        finest_block: BLOCK,
        masks_in_crops: false,
        hidden_casters: false,
        ray_list: false,
        coverage: true,
        shadows: true,
        optics: false,
        jobs: call::cores(),
        call_overhead_s: 0.1,
        // A hundred shapes of a few triangles each: 0.1 without any.
        picture_cpu_s: 0.25,
        units: "any unit of length; points and spots fall off with the square of the distance and \
                have their full colour at the fade distance, or at the origin's; a spot's edge is \
                Mitsuba's; nothing mirrors or lets light through; antialiasing is depth² rays in \
                every pixel",
    }
}

impl Adapter for Mitsuba {
    fn name(&self) -> &'static str {
        NAME
    }

    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn scene_text(&self, request: &LayerRequest<'_>) -> Result<SceneText, AdapterError> {
        let files = self.script(request)?.files;
        Ok(SceneText { files })
    }

    fn render(
        &self,
        request: &LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Layer>, AdapterError> {
        if request.shots.is_empty() {
            return Ok(Vec::new());
        }
        let script = self.script(request)?;
        let call = LayerCall {
            program: &self.program,
            request,
            script: &script,
        };
        call.run(run)
    }

    /// Mitsuba has no picture of all lights without noise: they are added, and
    /// the sum is stored, here.
    fn baseline(
        &self,
        request: &Baseline<'_>,
        run: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
        encode::baseline(self, request, run)
    }

    fn encode(&self, linear: f32, max: u32) -> u32 {
        encode::step(linear, max)
    }

    fn health(&self, run: &RunContext) -> Health {
        health::check(self, run)
    }
}

/// Something that it cannot draw.
pub(crate) fn unsupported(what: &str) -> AdapterError {
    AdapterError::Unsupported {
        adapter: NAME.to_owned(),
        what: what.to_owned(),
    }
}

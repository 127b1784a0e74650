//! decor's adapter for POV-Ray 3.7 and 3.8.
//!
//! From request to layers:
//!
//! ```text
//! request → scene_text (solid, light, camera, isolate, depth)
//!         → call (folder, switches, process) → state | picture → layers
//! ```
//!
//! POV-Ray has no depth output ([`depth`] makes one), reads any text inside a
//! fragment ([`survey`] looks at it, [`isolate`] keeps its names to itself), and
//! sleeps for most of a short call: many frames go into one.
//!
//! Developed and tested with 3.7.0.10. Version 3.8 is called the same way but
//! its state file is not relied on; it is untested.

mod arrival;
mod call;
pub mod camera;
mod colours;
pub mod depth;
pub mod encode;
mod extents;
mod folder;
mod health;
mod inlined;
mod inspect;
mod isolate;
mod light;
mod number;
pub mod picture;
pub mod plain;
mod receivers;
mod scene_text;
mod solid;
mod sources;
pub mod state;
mod statements;
mod surroundings;
mod survey;
mod tokens;
pub mod unedited;

use std::path::{Path, PathBuf};

use decor_api::process::{ProcessCall, find_program, version};
use decor_api::{
    Abilities, Adapter, AdapterError, ArrivalRequest, Baseline, DepthKind, Fragment, Geometry,
    Health, Layer, LayerRequest, LayerShot, NativeFile, Output, Picture, PictureFormat,
    PrototypeTable, Region, Rendered, RunContext, Said, SceneText, Surroundings,
};

use crate::arrival::Arrival;
pub use crate::call::LayerSource;
use crate::call::{LayerCall, fixed_switches};
use crate::folder::{Folder, fragments};
pub use crate::number::number;
use crate::scene_text::{Framing, Numbering, Writer, switches};
use crate::sources::{Library, LibraryWords};

/// How to install POV-Ray.
pub const INSTALL: &str = "install it with `apt-get install povray povray-includes`, \
                           or name the program in DECOR_POVRAY";

/// POV-Ray behind decor.
#[derive(Debug)]
pub struct PovRay {
    program: PathBuf,
    abilities: Abilities,
    source: LayerSource,
    library: Library,
    words: LibraryWords,
}

impl PovRay {
    /// Finds POV-Ray: `DECOR_POVRAY`, or `povray` on the path.
    ///
    /// # Errors
    /// [`AdapterError::Missing`], or what goes wrong when it is asked for its
    /// version.
    pub fn find() -> Result<Self, AdapterError> {
        let program = Self::located()?;
        let version = Self::version_of(&program)?;
        Ok(Self::new(program, &version))
    }

    /// Where POV-Ray is: `DECOR_POVRAY`, or `povray` on the path.
    ///
    /// # Errors
    /// [`AdapterError::Missing`].
    pub fn located() -> Result<PathBuf, AdapterError> {
        find_program("DECOR_POVRAY", "povray", INSTALL)
    }

    /// The version that `program` says it has. It sleeps a fifth of a second first.
    ///
    /// # Errors
    /// What goes wrong when it is asked.
    pub fn version_of(program: &Path) -> Result<String, AdapterError> {
        version(program, "--version", "POV-Ray ")
    }

    /// POV-Ray as `program`, of a known version.
    pub fn new(program: PathBuf, version: &str) -> Self {
        // The state file is a format of 3.7; its header is checked at each read.
        let source = if version.starts_with("3.7") {
            LayerSource::StateFile
        } else {
            LayerSource::Pictures
        };
        let library = Library::of_program(&program);
        let mut adapter = Self {
            program,
            abilities: abilities(version),
            source,
            library,
            words: LibraryWords::default(),
        };
        adapter.abilities.block_mask = source == LayerSource::StateFile;
        adapter
    }

    /// The same, with layers read from elsewhere.
    #[must_use]
    pub fn with_source(mut self, source: LayerSource) -> Self {
        self.source = source;
        self.abilities.block_mask = source == LayerSource::StateFile;
        self
    }

    /// The program.
    pub fn program(&self) -> &Path {
        &self.program
    }

    /// The text of [`Adapter::arriving_light`], as [`Adapter::scene_text`] is
    /// that of [`Adapter::render`].
    ///
    /// # Errors
    /// [`AdapterError::BadInput`] where the declarations place something.
    pub fn arrival_text(&self, request: &ArrivalRequest<'_>) -> Result<SceneText, AdapterError> {
        Ok(Arrival::new(request).text(&self.writer(request.includes, None)?))
    }

    /// Where layers are read from.
    pub fn source(&self) -> LayerSource {
        self.source
    }

    fn writer(
        &self,
        includes: &[NativeFile],
        sky: Option<&NativeFile>,
    ) -> Result<Writer<'_>, AdapterError> {
        let around = surroundings::around(includes, None, &self.library)?;
        // Media, photons and the like treat the lights of a group in another way.
        let confined = surroundings::around(includes, sky, &self.library)?
            .unlayerable
            .is_none();
        Ok(Writer {
            library: &self.library,
            precision: self.source.precision(),
            default_changed: around.default,
            stateful: around.stateful,
            light_group: confined,
        })
    }

    /// Text for other renderers is refused, not tried.
    fn refuse_foreign<'f>(
        &self,
        fragments: impl IntoIterator<Item = &'f Fragment>,
    ) -> Result<(), AdapterError> {
        let known = |f: &&Fragment| self.abilities.fragments.contains(&&*f.language);
        match fragments.into_iter().find(|f| !known(f)) {
            None => Ok(()),
            Some(fragment) => Err(AdapterError::Unsupported {
                adapter: "povray".into(),
                what: fragment.file.path.display().to_string(),
            }),
        }
    }

    /// The call for a request, and its text.
    fn layer_call<'a>(
        &'a self,
        request: &'a LayerRequest<'_>,
    ) -> Result<(LayerCall<'a>, SceneText), AdapterError> {
        let writer = self.request_writer(request)?;
        let text = writer.layers(request);
        // Radiosity and the like put more into a state file than a picture.
        let source = if writer.light_group {
            self.source
        } else {
            LayerSource::Pictures
        };
        let call = LayerCall {
            program: &self.program,
            request,
            code: writer.depth_code(request),
            source,
        };
        Ok((call, text))
    }

    fn request_writer(&self, request: &LayerRequest<'_>) -> Result<Writer<'_>, AdapterError> {
        self.refuse_foreign(all_fragments(request.prototypes))?;
        let scene = request.shots.first().map(|shot| &shot.scene);
        match scene {
            Some(scene) => self.writer(&scene.includes, scene.sky.as_ref()),
            None => self.writer(&[], None),
        }
    }
}

/// The fragments of a table.
fn all_fragments(table: &PrototypeTable) -> impl Iterator<Item = &Fragment> {
    table
        .iter()
        .filter_map(|(_, prototype)| match &prototype.geometry {
            Geometry::Fragment(fragment) => Some(fragment),
            Geometry::Neutral(_) => None,
        })
}

/// Tries again where POV-Ray gave up because the machine was too busy to start
/// its threads in time: that says nothing of the scene.
fn patiently<T>(mut call: impl FnMut() -> Result<T, AdapterError>) -> Result<T, AdapterError> {
    const TRIES: usize = 3;
    let starved = |error: &AdapterError| {
        matches!(error, AdapterError::Failed { stderr, .. }
            if stderr.contains("worker thread startup"))
    };
    for _ in 1..TRIES {
        match call() {
            Err(error) if starved(&error) => {
                tracing::warn!("POV-Ray could not start its threads in time; once more");
            }
            other => return other,
        }
    }
    call()
}

fn abilities(version: &str) -> Abilities {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    Abilities {
        version: version.to_owned(),
        csg: true,
        fragments: &["inc", "pov"],
        depth_with_colour: false,
        depth: DepthKind::AlongRay,
        sample_position: (0.5, 0.5),
        crop_grid: Some(state::BLOCK),
        block_mask: true,
        finest_block: state::LEAST,
        masks_in_crops: true,
        hidden_casters: true,
        ray_list: true,
        coverage: true,
        shadows: true,
        optics: true,
        // Most of a short call is sleep: measured with 8, 12 and 16 calls on two
        // cores, 25 frames of 320×240 took 3.5, 2.6 and 2.2 s.
        jobs: 8 * cores,
        call_overhead_s: 0.7,
        picture_cpu_s: 0.006,
        units: "any unit of length; no fall-off of lights unless it is stated",
    }
}

impl Adapter for PovRay {
    fn name(&self) -> &'static str {
        "povray"
    }

    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn scene_text(&self, request: &LayerRequest<'_>) -> Result<SceneText, AdapterError> {
        Ok(self.request_writer(request)?.layers(request))
    }

    fn render(
        &self,
        request: &LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Layer>, AdapterError> {
        self.render_to_read(request, run)?.all()
    }

    fn render_to_read<'a>(
        &'a self,
        request: &'a LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Rendered<'a, Layer>, AdapterError> {
        if request.shots.is_empty() {
            return Ok(Rendered::here(Vec::new()));
        }
        let (call, text) = self.layer_call(request)?;
        patiently(|| call.run(&text, run))
    }

    fn pictures<'a>(
        &'a self,
        request: &'a LayerRequest<'_>,
        format: PictureFormat,
        run: &RunContext,
    ) -> Result<Option<Rendered<'a, Picture>>, AdapterError> {
        let bits = match format {
            PictureFormat::Png => 8,
            PictureFormat::Png16 => 16,
            PictureFormat::Exr => return Ok(None),
        };
        if request.shots.is_empty() || request.output != Output::ColourOverBackground {
            return Ok(None);
        }
        let (call, text) = self.layer_call(request)?;
        let masked = |shot: &LayerShot| matches!(shot.region, Region::Blocks(_));
        if call.source == LayerSource::Pictures && request.shots.iter().any(masked) {
            return Ok(None);
        }
        patiently(|| call.run_encoded(&text, bits, run)).map(Some)
    }

    fn arriving_light(
        &self,
        request: &ArrivalRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Vec<[f32; 3]>>, AdapterError> {
        let writer = self.writer(request.includes, None)?;
        let arrival = Arrival::new(request);
        patiently(|| arrival.run(&self.program, self.source, &writer, run))
    }

    fn inspect(
        &self,
        fragments: &[&Fragment],
        includes: &[NativeFile],
        run: &RunContext,
    ) -> Result<Vec<Said>, AdapterError> {
        self.refuse_foreign(fragments.iter().copied())?;
        let inspection = inspect::Inspection {
            program: &self.program,
            library: &self.library,
            words: &self.words,
        };
        patiently(|| inspection.run(fragments, includes, run))
    }

    fn surroundings(
        &self,
        includes: &[NativeFile],
        sky: Option<&NativeFile>,
    ) -> Result<Surroundings, AdapterError> {
        let around = surroundings::around(includes, sky, &self.library)?;
        Ok(Surroundings {
            unlayerable: around.unlayerable,
            sky_on_objects: around.fog,
        })
    }

    fn baseline(
        &self,
        request: &Baseline<'_>,
        run: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError> {
        let Some((first, scene)) = request.frames.first() else {
            return Ok(Vec::new());
        };
        let numbering = Numbering::of_film(request.film, *first, request.frames.len());
        let text = self.writer(&scene.includes, scene.sky.as_ref())?.whole(
            request.prototypes,
            request.size,
            &request.frames,
            numbering,
        );
        // The pictures outlive the call: the folder is part of `run.work`.
        let mut kept = run.clone();
        kept.keep = true;
        let folder = Folder::new(&kept, "baseline", &text)?;
        let mut args = fixed_switches();
        args.extend(switches(Framing::Full, request.size, request.antialias));
        args.extend(numbering.args());
        let native = scene
            .includes
            .iter()
            .chain(&scene.sky)
            .chain(fragments(request.prototypes));
        args.extend(folder.library_switches(native)?);
        args.push(
            match request.format {
                PictureFormat::Png => "+FN8",
                PictureFormat::Png16 => "+FN16",
                PictureFormat::Exr => "+FE",
            }
            .into(),
        );
        let ending = request.format.extension();
        args.extend([format!("+Oframe.{ending}"), "-UA".into()]);
        let call = ProcessCall {
            program: &self.program,
            args,
            folder: folder.path(),
            doing: "the baseline".into(),
            log: run.keep.then(|| folder.file("povray.log")),
        };
        run.tally.add_call(request.frames.len());
        patiently(|| call.run_well(run))?;
        let file = |k: usize| folder.file(&format!("frame{}.{ending}", numbering.suffix(k)));
        Ok(request
            .frames
            .iter()
            .enumerate()
            .map(|(k, (n, _))| (*n, file(k)))
            .collect())
    }

    fn encode(&self, linear: f32, max: u32) -> u32 {
        encode::srgb(linear, max)
    }

    fn health(&self, run: &RunContext) -> Health {
        health::check(self, run)
    }
}

//! The interface that an adapter implements.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::abilities::Abilities;
use crate::arrival::ArrivalRequest;
use crate::blocks::Blocks;
use crate::bounds::Bounds;
use crate::extent::Extent;
use crate::layer::{Layer, Size, Window};
use crate::prototype::{Fragment, Optics, PrototypeTable};
use crate::rendered::{Picture, Rendered};
use crate::scene::{Antialias, NativeFile, PictureFormat, Scene};
use crate::tally::Tally;

/// What one pass is to give.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Output {
    /// Colour with the background and the sky: coverage is 1 everywhere.
    ColourOverBackground,
    /// Colour and coverage of the objects alone. Where the abilities say no `coverage`,
    /// it may be left at 1 where nothing is: the matte comes from the depth then.
    ColourAlone {
        /// Draw the sky too, where it changes the objects' own colours (fog):
        /// coverage is then not to be had.
        with_sky: bool,
    },
    /// Depth at the pixels' centres, without antialiasing.
    Depth,
}

/// Which part of a frame to render.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Region {
    /// A rectangle. Its values are the full frame's own where its edges are on
    /// the adapter's grid.
    Window(Window),
    /// Blocks of the picture. The layer's window encloses them; outside of them its
    /// values mean nothing.
    Blocks(Blocks),
}

/// One frame of a request.
#[derive(Clone, Debug)]
pub struct LayerShot {
    /// The frame's number, for names and messages.
    pub frame: u32,
    /// What to draw. Layers of one frame share everything but `instances`.
    pub scene: Arc<Scene>,
    /// Where.
    pub region: Region,
}

/// One pass over some frames: what an adapter renders in one go.
#[derive(Clone, Debug)]
pub struct LayerRequest<'a> {
    /// The geometry that the shots' instances name.
    pub prototypes: &'a PrototypeTable,
    /// The size of the whole picture.
    pub size: Size,
    /// What to give.
    pub output: Output,
    /// The renderer's antialiasing, for colour.
    pub antialias: Option<Antialias>,
    /// The frames, in order.
    pub shots: Vec<LayerShot>,
    /// Where the shots are consecutive whole frames of a film from this first to
    /// this last frame: a scene's own clock then runs as in a plain render.
    pub film: Option<(u32, u32)>,
    /// A short name for kept files, for example `decor-0000`.
    pub label: String,
}

impl LayerRequest<'_> {
    /// What is drawn, in words: `depth of frames 3 to 7`.
    pub fn describe(&self) -> String {
        let pass = match self.output {
            Output::ColourOverBackground => "colour",
            Output::ColourAlone { .. } => "the objects' colour",
            Output::Depth => "depth",
        };
        match (self.shots.first(), self.shots.last()) {
            (Some(first), Some(last)) if first.frame != last.frame => {
                format!("{pass} of frames {} to {}", first.frame, last.frame)
            }
            (Some(first), _) => format!("{pass} of frame {}", first.frame),
            _ => pass.to_owned(),
        }
    }
}

/// A plain run of the stock renderer over whole frames.
#[derive(Clone, Debug)]
pub struct Baseline<'a> {
    /// The geometry that the scenes' instances name.
    pub prototypes: &'a PrototypeTable,
    /// The size of the pictures.
    pub size: Size,
    /// The renderer's antialiasing.
    pub antialias: Option<Antialias>,
    /// The film's first and last frame: a scene's clock runs between them.
    pub film: (u32, u32),
    /// The frames to render, consecutive.
    pub frames: Vec<(u32, Arc<Scene>)>,
    /// The format of the pictures, by the renderer's own encoder.
    pub format: PictureFormat,
}

impl<'a> Baseline<'a> {
    /// The same frames as layers.
    pub fn layers(&self) -> LayerRequest<'a> {
        let whole = |(frame, scene): &(u32, Arc<Scene>)| LayerShot {
            frame: *frame,
            scene: Arc::clone(scene),
            region: Region::Window(self.size.window()),
        };
        LayerRequest {
            prototypes: self.prototypes,
            size: self.size,
            output: Output::ColourOverBackground,
            antialias: self.antialias,
            shots: self.frames.iter().map(whole).collect(),
            film: Some(self.film),
            label: "baseline".to_owned(),
        }
    }
}

/// The files of a translated request, by name. The pure half of an adapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SceneText {
    /// File name and content; the first is the one that the renderer is given.
    pub files: Vec<(String, Vec<u8>)>,
}

/// What is known of a fragment once it was looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct Said {
    /// What encloses it.
    pub bounds: Bounds,
    /// Boxes that enclose it together; none where it has no end.
    pub extents: Vec<Extent>,
    /// Does it mirror or let light through?
    pub optics: Optics,
    /// Why it cannot be put into a layer, where it cannot.
    pub unlayerable: Option<String>,
}

/// What is known of the renderer-native files around a scene.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Surroundings {
    /// Why no part of the picture can be kept, where that is so (radiosity, …).
    pub unlayerable: Option<String>,
    /// The sky changes the colour of objects by their distance (fog): layers of
    /// objects are drawn with it.
    pub sky_on_objects: bool,
}

/// Is the renderer there, and does it work?
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Health {
    /// Where it was found.
    pub program: Option<PathBuf>,
    /// Its version.
    pub version: Option<String>,
    /// What works: one line a test, with its result.
    pub checks: Vec<(String, Result<String, String>)>,
    /// How to install what is missing.
    pub install: String,
}

impl Health {
    /// Did everything work?
    pub fn is_good(&self) -> bool {
        self.checks.iter().all(|(_, result)| result.is_ok())
    }
}

/// What goes wrong between decor and a renderer.
#[derive(Debug, thiserror::Error)]
pub enum AdapterError {
    /// The program is not installed.
    #[error("{program} was not found; {install}")]
    Missing {
        /// Its name.
        program: String,
        /// What to do about it.
        install: String,
    },
    /// The program could not be started.
    #[error("{program} could not be started")]
    Start {
        /// Its path.
        program: String,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// The program ended with an error, or was killed.
    #[error("{program} failed ({status}) while rendering {doing}\n{stderr}")]
    Failed {
        /// Its name.
        program: String,
        /// Exit status or signal.
        status: String,
        /// What it was to do.
        doing: String,
        /// The end of what it printed.
        stderr: String,
    },
    /// The program did not end in time; its process group was killed.
    #[error("{program} did not finish {doing} within {} s and was stopped\n{stderr}", limit.as_secs())]
    TimedOut {
        /// Its name.
        program: String,
        /// What it was to do.
        doing: String,
        /// How long it had.
        limit: Duration,
        /// The end of what it printed.
        stderr: String,
    },
    /// The program ended well, but what it wrote is not what was asked for.
    #[error("{program} wrote {}: {reason}", file.display())]
    BadOutput {
        /// Its name.
        program: String,
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The adapter cannot do this.
    #[error("the {adapter} adapter cannot draw {what}")]
    Unsupported {
        /// Its name.
        adapter: String,
        /// What it was asked for.
        what: String,
    },
    /// A file of the user's cannot be used.
    #[error("{}: {reason}", file.display())]
    BadInput {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Reading or writing a file failed.
    #[error("{}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// The user stopped the run.
    #[error("stopped")]
    Cancelled,
}

impl AdapterError {
    /// A file that only another renderer reads.
    pub fn native(adapter: &str, file: &NativeFile) -> Self {
        Self::Unsupported {
            adapter: adapter.to_owned(),
            what: format!(
                "{}: only the renderer that it is written for reads it",
                file.path.display()
            ),
        }
    }

    /// Wraps an error of the file system with the path that it is about.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        |source| Self::Io {
            path: path.to_owned(),
            source,
        }
    }
}

/// Around a render: where to work, how long, and whether to go on.
#[derive(Clone, Debug)]
pub struct RunContext {
    /// A folder that exists and that this run alone uses; adapters make folders
    /// of their own in it.
    pub work: PathBuf,
    /// Scene files, layers and logs are kept in `work` instead of removed.
    pub keep: bool,
    /// How long one call may take.
    pub timeout: Duration,
    /// How many threads one call may use; `None` leaves it to the renderer.
    pub threads: Option<usize>,
    /// Set to stop: running processes are killed.
    pub cancel: Arc<AtomicBool>,
    /// What is counted.
    pub tally: Arc<Tally>,
}

impl RunContext {
    /// A context that works in `work`, keeps nothing and has an hour a call.
    pub fn new(work: impl Into<PathBuf>) -> Self {
        Self {
            work: work.into(),
            keep: false,
            timeout: Duration::from_secs(3600),
            threads: None,
            cancel: Arc::default(),
            tally: Arc::default(),
        }
    }

    /// The same run; what is counted in it is counted apart, too.
    #[must_use]
    pub fn counted_apart(&self) -> Self {
        Self {
            tally: Arc::new(Tally::within(&self.tally)),
            ..self.clone()
        }
    }

    /// Was it asked to stop?
    pub fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }
}

/// One renderer behind decor.
pub trait Adapter: Send + Sync {
    /// The name that `--renderer` knows it by.
    fn name(&self) -> &'static str;

    /// What it can do.
    fn abilities(&self) -> &Abilities;

    /// The request in the renderer's language. Pure and deterministic; runs
    /// where the renderer is not installed. Empty for a renderer in-process.
    ///
    /// # Errors
    /// [`AdapterError::Unsupported`] where the scene has what it cannot draw.
    fn scene_text(&self, request: &LayerRequest<'_>) -> Result<SceneText, AdapterError>;

    /// Renders a request: one layer a shot, in the same order.
    ///
    /// # Errors
    /// Any [`AdapterError`]; no process and no file is left behind.
    fn render(
        &self,
        request: &LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Layer>, AdapterError>;

    /// The same, to be read one after the other: an adapter whose layers are
    /// files leaves them there until they are asked for. One that has no such
    /// method holds all of them.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    fn render_to_read<'a>(
        &'a self,
        request: &'a LayerRequest<'_>,
        run: &RunContext,
    ) -> Result<Rendered<'a, Layer>, AdapterError> {
        Ok(Rendered::here(self.render(request, run)?))
    }

    /// Renders a request for colour over the background into finished pictures,
    /// encoded by the renderer for frames of this `format`: what
    /// [`encode`](Self::encode) makes of the layers, bit for bit, with less to
    /// be written, read and held. `None` where it has no such way: an adapter
    /// without this method has none.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    fn pictures<'a>(
        &'a self,
        request: &'a LayerRequest<'_>,
        format: PictureFormat,
        run: &RunContext,
    ) -> Result<Option<Rendered<'a, Picture>>, AdapterError> {
        let _ = (request, format, run);
        Ok(None)
    }

    /// How much of a light arrives at points of surfaces: for each shot, and for
    /// each of its points, the fraction of each channel of the light that the
    /// casters let through, 1 where nothing is in the way. Points that the light
    /// does not reach anyway ([`Light::may_reach`](crate::Light::may_reach)) have
    /// 1 as well.
    ///
    /// A point *inside* of a caster that weakens light by the way through it
    /// (media, fading glass) is taken to be outside of its matter.
    ///
    /// # Errors
    /// [`AdapterError::Unsupported`] where the abilities say no `ray_list`, which
    /// is what an adapter does that has no such method; else any
    /// [`AdapterError`], and no process and no file is left behind.
    fn arriving_light(
        &self,
        request: &ArrivalRequest<'_>,
        run: &RunContext,
    ) -> Result<Vec<Vec<[f32; 3]>>, AdapterError> {
        let _ = (request, run);
        Err(AdapterError::Unsupported {
            adapter: self.name().to_owned(),
            what: "the light that arrives at points".to_owned(),
        })
    }

    /// Looks at fragments: how large they are, and what keeps them out of
    /// layers. `includes` are the film's declarations. An adapter that has no such
    /// method reads no fragments.
    ///
    /// # Errors
    /// Where a fragment cannot be read by this renderer.
    fn inspect(
        &self,
        fragments: &[&Fragment],
        includes: &[NativeFile],
        run: &RunContext,
    ) -> Result<Vec<Said>, AdapterError> {
        let _ = (includes, run);
        match fragments.first() {
            Some(fragment) => Err(AdapterError::native(self.name(), &fragment.file)),
            None => Ok(Vec::new()),
        }
    }

    /// Looks at the renderer-native files around a scene. An adapter that has no
    /// such method reads none.
    ///
    /// # Errors
    /// [`AdapterError::BadInput`] where one holds a light, a camera or an
    /// object; [`AdapterError::Unsupported`] where it reads none.
    fn surroundings(
        &self,
        includes: &[NativeFile],
        sky: Option<&NativeFile>,
    ) -> Result<Surroundings, AdapterError> {
        match includes.iter().chain(sky).next() {
            Some(file) => Err(AdapterError::native(self.name(), file)),
            None => Ok(Surroundings::default()),
        }
    }

    /// Renders whole frames plainly: one call over all of them, the renderer's
    /// default threads and its own encoder, from the same scene text. Gives the
    /// file of every frame, in `run.work`.
    ///
    /// # Errors
    /// Any [`AdapterError`].
    fn baseline(
        &self,
        request: &Baseline<'_>,
        run: &RunContext,
    ) -> Result<Vec<(u32, PathBuf)>, AdapterError>;

    /// The value of a linear channel in a picture of `max` steps (255 or
    /// 65535), as this renderer encodes it: frames that decor encodes are the
    /// renderer's own, bit for bit.
    fn encode(&self, linear: f32, max: u32) -> u32;

    /// Is the renderer found, and does it work? Takes about a second.
    fn health(&self, run: &RunContext) -> Health;
}

//! What is to be filmed: the film, its objects and its renderer, all read.

use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use decor_api::{
    Adapter, AdapterError, Antialias, Camera, Fragment, NativeFile, Prototype, PrototypeId, Region,
    RunContext, Scene, Size, Sphere, Surroundings, Window,
};

use crate::film::{Film, FilmErrors, FrameState, NamedFile, ObjectState};
use crate::influence::{Changed, parts};
use crate::motion::screen_box;
use crate::objects::{Cache, Library, ObjectError, content_hash};
use crate::plan::{BLOCK, BlockSet, Mode, Wishes, gathered};
use crate::silhouette::silhouette;

/// The side of the smallest blocks that are worth it. Each block costs a renderer
/// something too, also one that is not drawn.
const FINEST: u32 = 8;

/// Pictures with fewer pixels are drawn in usual blocks: there a picture in a call
/// costs more than its pixels, and periods with many small blocks, which are priced by
/// their pixels, turned out dearer than whole frames.
const LARGE_PIXELS: usize = 256 * (BLOCK * BLOCK) as usize;

/// Why there is nothing to film.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum StageError {
    /// The film is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Film(#[from] FilmErrors),
    /// An object is wrong.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Object(#[from] ObjectError),
    /// A file that the film names cannot be read.
    #[error("{} cannot be read", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        #[source]
        source: std::io::Error,
    },
    /// The renderer refuses something around the scene, or failed.
    #[error(transparent)]
    Adapter(#[from] AdapterError),
    /// The film changes its antialiasing on the way.
    #[error("the antialiasing changes in frame {frame}")]
    #[diagnostic(help("state `*antialias` once: it holds for the whole film"))]
    AntialiasChanges {
        /// Where.
        frame: u32,
    },
}

/// A film with everything that it names.
pub struct Stage {
    /// The film.
    pub film: Film,
    /// Its objects.
    pub library: Arc<Library>,
    /// The renderer.
    pub adapter: Arc<dyn Adapter>,
    props: Arc<Props>,
    /// The first and last frame of all, where that is known.
    span: Option<(u32, u32)>,
    is_ever_shaded: OnceLock<bool>,
}

/// What a film names. The scenes of a stream share it.
struct Props {
    /// The prototype of every description, by its number.
    prototypes: Vec<PrototypeId>,
    /// Spheres around each prototype's parts, once they are asked for.
    parts: Vec<OnceLock<Vec<Sphere>>>,
    includes: Vec<NativeFile>,
    skies: Vec<(PathBuf, NativeFile)>,
    /// What the renderer says of each sky; the first is about no sky.
    surroundings: Vec<(Option<PathBuf>, Surroundings)>,
}

impl Stage {
    /// Reads everything that `film` names, for `adapter`.
    ///
    /// # Errors
    /// All that is wrong with the objects, or the first file around them that
    /// cannot be used.
    pub fn set(
        film: Film,
        adapter: Arc<dyn Adapter>,
        allow_outside: bool,
        cache: &Cache,
        run: &RunContext,
    ) -> Result<Self, StageError> {
        let root = film.folder().to_owned();
        let includes: Vec<NativeFile> = film
            .includes()
            .map(|file| read_native(file, &root))
            .collect::<Result<_, _>>()?;
        let mut skies: Vec<(PathBuf, NativeFile)> = Vec::new();
        let mut antialias = None;
        for number in film.scene_numbers() {
            let state = film.frame(number);
            if *antialias.get_or_insert(state.antialias) != state.antialias {
                return Err(StageError::AntialiasChanges { frame: number });
            }
            if let Some(sky) = state.sky
                && !skies.iter().any(|(path, _)| path == sky.file())
            {
                skies.push((sky.file().to_owned(), read_native(sky, &root)?));
            }
        }
        let mut surroundings = vec![(None, adapter.surroundings(&includes, None)?)];
        for (path, sky) in &skies {
            surroundings.push((
                Some(path.clone()),
                adapter.surroundings(&includes, Some(sky))?,
            ));
        }
        let paths: Vec<PathBuf> = film
            .descriptions()
            .iter()
            .map(|d| d.path().to_owned())
            .collect();
        let library = Library::load(
            &root,
            &paths,
            &includes,
            allow_outside,
            &*adapter,
            cache,
            run,
        )?;
        let prototypes = paths.iter().map(|path| library.by_path[path]).collect();
        let parts = vec![OnceLock::new(); library.table.len()];
        let span = Some((*film.frames().start(), *film.frames().end()));
        Ok(Self {
            film,
            library: Arc::new(library),
            adapter,
            props: Arc::new(Props {
                prototypes,
                parts,
                includes,
                skies,
                surroundings,
            }),
            span,
            is_ever_shaded: OnceLock::new(),
        })
    }

    /// The stage of a later scene of the same stream, with its first and last
    /// frame where they are known. Only what the stream had not named before is
    /// read: then everything is read again.
    ///
    /// # Errors
    /// As [`set`](Self::set).
    pub fn follow(
        before: Option<&Self>,
        film: Film,
        span: Option<(u32, u32)>,
        adapter: Arc<dyn Adapter>,
        allow_outside: bool,
        cache: &Cache,
        run: &RunContext,
    ) -> Result<Self, StageError> {
        let stage = match before {
            // A stream's tables only grow.
            Some(before) if before.has_all(&film) => Self {
                film,
                library: Arc::clone(&before.library),
                adapter,
                props: Arc::clone(&before.props),
                span,
                is_ever_shaded: OnceLock::new(),
            },
            _ => Self::set(film, adapter, allow_outside, cache, run)?,
        };
        Ok(Self { span, ..stage })
    }

    /// Was all that `film` names read for this stage?
    fn has_all(&self, film: &Film) -> bool {
        let known = |sky: &NamedFile| self.props.skies.iter().any(|(path, _)| path == sky.file());
        let mut numbers = film.scene_numbers();
        self.props.prototypes.len() == film.descriptions().len()
            && self.props.includes.len() == film.includes().count()
            && numbers.all(|number| film.frame(number).sky.is_none_or(known))
    }

    /// Is what both stages name the same, to the byte? An earlier stage of the
    /// same stream may name less.
    pub fn same_props(&self, earlier: &Self) -> bool {
        if Arc::ptr_eq(&self.props, &earlier.props) {
            return true;
        }
        let hash = |stage: &Self, id: PrototypeId| stage.library.table.get(id).hash.clone();
        let (ours, theirs) = (&self.props, &earlier.props);
        let texts = |files: &[NativeFile]| files.iter().map(fragment_hash).collect::<Vec<_>>();
        let sky = |props: &Props, path: &Path| {
            let found = props.skies.iter().find(|(sky, _)| sky == path);
            found.map(|(_, file)| fragment_hash(file))
        };
        texts(&ours.includes) == texts(&theirs.includes)
            && theirs
                .prototypes
                .iter()
                .zip(&ours.prototypes)
                .all(|(a, b)| hash(earlier, *a) == hash(self, *b))
            && theirs
                .skies
                .iter()
                .filter_map(|(path, file)| Some((sky(ours, path)?, fragment_hash(file))))
                .all(|(a, b)| a == b)
    }

    /// The first and last frame of the film, for what goes by a clock; `None`
    /// for a stream that did not state how long it is.
    pub fn span(&self) -> Option<(u32, u32)> {
        self.span
    }

    /// The film's declarations.
    pub fn includes(&self) -> &[NativeFile] {
        &self.props.includes
    }

    /// The size of the pictures.
    pub fn size(&self) -> Size {
        self.film.size()
    }

    /// The renderer's antialiasing, in all frames.
    pub fn antialias(&self) -> Option<Antialias> {
        self.film.frame(*self.film.frames().start()).antialias
    }

    /// The prototype of an object in a frame.
    pub fn prototype_id(&self, object: &ObjectState<'_>) -> PrototypeId {
        self.props.prototypes[object.description.0 as usize]
    }

    /// The prototype of an object in a frame.
    pub fn prototype(&self, object: &ObjectState<'_>) -> &Prototype {
        self.library.table.get(self.prototype_id(object))
    }

    /// Does the renderer draw blocks of a picture as they are in the whole: by a
    /// mask, or in windows on its grid?
    pub fn draws_blocks(&self) -> bool {
        let can = self.adapter.abilities();
        can.block_mask || can.crop_grid.is_some_and(|grid| BLOCK.is_multiple_of(grid))
    }

    /// The side of the blocks that are drawn again: the smaller, the fewer pixels
    /// beside those that change. With antialiasing pixels of a block depend on each
    /// other: it is the renderer's own. Under shadows, too, where frames are to be the
    /// renderer's own: POV-Ray remembers what was in the way of the last ray to a
    /// light, and asks it first, with less tolerance. So a pixel that a surface all but
    /// shades itself can depend on the pixel before it, and that is another one in
    /// blocks of another side: seen in 5 of 230 random scenes, one pixel each.
    pub fn block_side(&self, wishes: &Wishes) -> u32 {
        let can = self.adapter.abilities();
        let is_own = match wishes.mode {
            Mode::Exact | Mode::Full => true,
            Mode::Equivalent => wishes.threshold_px == 0.0,
            Mode::Preview => false,
        };
        let depends = self.antialias().is_some() || is_own && self.is_ever_shaded();
        let is_large = self.size().pixels() >= LARGE_PIXELS;
        if can.block_mask && is_large && !depends {
            can.finest_block.clamp(FINEST, BLOCK)
        } else {
            BLOCK
        }
    }

    /// No block.
    pub fn no_blocks(&self, wishes: &Wishes) -> BlockSet {
        BlockSet::none(self.size(), self.block_side(wishes))
    }

    /// Do shadows fall in any frame?
    fn is_ever_shaded(&self) -> bool {
        *self.is_ever_shaded.get_or_init(|| {
            let mut scenes = self.film.scene_numbers();
            scenes.any(|number| self.has_shadows(&self.film.frame(number)))
        })
    }

    /// What to ask the renderer for, to have some blocks: themselves, or windows
    /// that hold them.
    pub fn regions(&self, blocks: &BlockSet) -> Vec<Region> {
        if self.adapter.abilities().block_mask {
            return vec![Region::Blocks(blocks.wanted())];
        }
        let windows: Vec<Window> = blocks.windows().collect();
        let windows = gathered(&windows, self.size(), true);
        windows.into_iter().map(Region::Window).collect()
    }

    /// Spheres that enclose an object's prototype together; none where only its
    /// bounds are known.
    pub fn parts(&self, object: &ObjectState<'_>) -> &[Sphere] {
        let id = self.prototype_id(object);
        self.props.parts[id.0 as usize].get_or_init(|| parts(self.library.table.get(id)))
    }

    /// An object where it is, as the influence of what changed sees it.
    pub fn changed(&self, object: &ObjectState<'_>) -> Changed {
        Changed::placed(self.prototype(object), self.parts(object), &object.pose)
    }

    /// The rectangles that an object can be seen in.
    pub fn silhouette(&self, object: &ObjectState<'_>, camera: &Camera) -> Vec<Window> {
        let (prototype, parts) = (self.prototype(object), self.parts(object));
        silhouette(prototype, parts, &object.pose, camera, self.size())
    }

    /// Can it be seen at all? By its sphere alone, which is quick.
    pub fn is_in_view(&self, object: &ObjectState<'_>, camera: &Camera) -> bool {
        !self.sphere_window(object, camera).is_empty()
    }

    /// Can it be seen in some blocks?
    pub fn is_seen_in(&self, object: &ObjectState<'_>, camera: &Camera, blocks: &BlockSet) -> bool {
        // The sphere first: it is quick, and as a rule enough.
        let outlines = || self.silhouette(object, camera);
        blocks.touches(self.sphere_window(object, camera))
            && outlines().into_iter().any(|window| blocks.touches(window))
    }

    fn sphere_window(&self, object: &ObjectState<'_>, camera: &Camera) -> Window {
        let bounds = self.prototype(object).bounds.posed(&object.pose);
        screen_box(&bounds, camera, self.size()).window()
    }

    /// The rectangle around all that can be seen of an object.
    pub fn window(&self, object: &ObjectState<'_>, camera: &Camera) -> Window {
        let windows = self.silhouette(object, camera).into_iter();
        windows.fold(Window::EMPTY, Window::union)
    }

    /// What the renderer says of a frame's surroundings.
    pub fn surroundings(&self, state: &FrameState<'_>) -> &Surroundings {
        let sky = state.sky.map(NamedFile::file);
        let found = self
            .props
            .surroundings
            .iter()
            .find(|(path, _)| path.as_deref() == sky);
        // Every sky of the film was looked at; without one, the first entry is it.
        &found.unwrap_or(&self.props.surroundings[0]).1
    }

    /// The scene of a frame with those of its objects that `select` takes.
    pub fn scene(
        &self,
        state: &FrameState<'_>,
        mut select: impl FnMut(&ObjectState<'_>) -> bool,
    ) -> Scene {
        let instances = state
            .objects
            .iter()
            .filter(|object| select(object))
            .map(|object| self.instance(object))
            .collect();
        let sky = state.sky.and_then(|sky| {
            self.props
                .skies
                .iter()
                .find(|(path, _)| path == sky.file())
                .map(|(_, file)| file.clone())
        });
        Scene {
            camera: state.camera,
            lights: state.lights.to_vec(),
            shadows: state.shadows,
            background: state.background,
            includes: self.props.includes.clone(),
            sky,
            instances,
            hidden: Vec::new(),
        }
    }

    /// A hash of everything that the frames depend on, but for the renderer:
    /// two stages with the same key have the same frames.
    pub fn key(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut add = |bytes: &[u8]| {
            hasher.update(&(bytes.len() as u64).to_le_bytes());
            hasher.update(bytes);
        };
        add(crate::film::jsonl::write(&self.film).as_bytes());
        for (_, prototype) in self.library.table.iter() {
            add(prototype.hash.as_bytes());
        }
        let skies = self.props.skies.iter().map(|(_, file)| file);
        for file in self.props.includes.iter().chain(skies) {
            add(fragment_hash(file).as_bytes());
        }
        add(self.adapter.name().as_bytes());
        add(self.adapter.abilities().version.as_bytes());
        hasher.finalize().to_hex().to_string()
    }
}

/// The hash of a file with all the files that it reads in turn.
fn fragment_hash(file: &NativeFile) -> String {
    content_hash(&Fragment {
        file: file.clone(),
        language: "inc".into(),
    })
}

fn read_native(file: &NamedFile, root: &Path) -> Result<NativeFile, StageError> {
    let text = std::fs::read(file.file()).map_err(|source| StageError::Unreadable {
        path: file.file().to_owned(),
        source,
    })?;
    Ok(NativeFile {
        path: file.file().to_owned(),
        root: root.to_owned(),
        text,
    })
}

//! What is to be filmed: the film, its objects and its renderer, all read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use decor_api::{
    Adapter, AdapterError, Antialias, Fragment, Instance, NativeFile, Prototype, PrototypeId,
    RunContext, Scene, Size, Surroundings,
};

use crate::film::{Film, FilmErrors, FrameState, NamedFile, ObjectState};
use crate::objects::{Cache, Library, ObjectError, content_hash};

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
    pub library: Library,
    /// The renderer.
    pub adapter: Arc<dyn Adapter>,
    /// The prototype of every description, by its number.
    prototypes: Vec<PrototypeId>,
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
        Ok(Self {
            film,
            library,
            adapter,
            prototypes,
            includes,
            skies,
            surroundings,
        })
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
        self.prototypes[object.description.0 as usize]
    }

    /// The prototype of an object in a frame.
    pub fn prototype(&self, object: &ObjectState<'_>) -> &Prototype {
        self.library.table.get(self.prototype_id(object))
    }

    /// What the renderer says of a frame's surroundings.
    pub fn surroundings(&self, state: &FrameState<'_>) -> &Surroundings {
        let sky = state.sky.map(NamedFile::file);
        let found = self
            .surroundings
            .iter()
            .find(|(path, _)| path.as_deref() == sky);
        // Every sky of the film was looked at; without one, the first entry is it.
        &found.unwrap_or(&self.surroundings[0]).1
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
            .map(|object| Instance {
                prototype: self.prototype_id(object),
                pose: object.pose,
            })
            .collect();
        let sky = state.sky.and_then(|sky| {
            self.skies
                .iter()
                .find(|(path, _)| path == sky.file())
                .map(|(_, file)| file.clone())
        });
        Scene {
            camera: state.camera,
            lights: state.lights.to_vec(),
            shadows: state.shadows,
            background: state.background,
            includes: self.includes.clone(),
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
        let skies = self.skies.iter().map(|(_, file)| file);
        for file in self.includes.iter().chain(skies) {
            // With all the files that it reads in turn.
            let fragment = Fragment {
                file: file.clone(),
                language: "inc".into(),
            };
            add(content_hash(&fragment).as_bytes());
        }
        add(self.adapter.name().as_bytes());
        add(self.adapter.abilities().version.as_bytes());
        hasher.finalize().to_hex().to_string()
    }
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

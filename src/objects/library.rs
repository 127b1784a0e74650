//! All descriptions of a film, each content once.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use decor_api::{
    Adapter, AdapterError, Bounds, Csg, Fragment, Geometry, Material, NativeFile, Optics,
    Prototype, PrototypeId, PrototypeTable, RunContext, Said,
};
use rayon::prelude::*;

use super::cache::Cache;
use super::error::{ObjectError, ObjectProblem};
use super::files::{Files, stays_inside};
use super::fragment::{self, KeptSaid};
use super::{mesh_file, neutral};

/// The endings of object descriptions.
pub const ENDINGS: [&str; 8] = ["inc", "pov", "ron", "obj", "ply", "stl", "gltf", "glb"];

/// The endings that a path without one is tried with, in this order.
const TRIED: [&str; 3] = ["inc", "pov", "ron"];

/// Under what the cache keeps what a renderer said of a fragment.
const KIND: &str = "inspection-5";

/// The objects of a film.
#[derive(Clone, Debug, Default)]
pub struct Library {
    /// Every geometry once, in the order of the film.
    pub table: PrototypeTable,
    /// The prototype of every path, as the film writes it.
    pub by_path: HashMap<PathBuf, PrototypeId>,
}

/// A description that was read.
enum Loaded {
    Neutral {
        csg: Csg,
        hash: String,
    },
    Fragment {
        fragment: Fragment,
        hash: String,
        stated: Option<Bounds>,
    },
}

impl Library {
    /// Reads the descriptions at `paths`, relative to `folder` (the film's).
    ///
    /// A path without one of the known endings is tried with `.inc`, `.pov`,
    /// `.ron`, in this order. `includes` are the film's declarations, which
    /// fragments may use. `allow_outside` allows absolute paths and such that
    /// leave their folder through `..`. What the adapter's renderer says of
    /// fragments is asked in one call, and kept in `cache`.
    ///
    /// # Errors
    /// Everything that is wrong with any of the objects.
    pub fn load(
        folder: &Path,
        paths: &[PathBuf],
        includes: &[NativeFile],
        allow_outside: bool,
        adapter: &dyn Adapter,
        cache: &Cache,
        run: &RunContext,
    ) -> Result<Self, ObjectError> {
        let mut seen = HashSet::new();
        let paths: Vec<&PathBuf> = paths.iter().filter(|p| seen.insert(*p)).collect();
        let root = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
        let reader = Reader {
            root,
            allow_outside,
            adapter,
        };
        let loaded: Vec<_> = paths.par_iter().map(|path| reader.load(path)).collect();

        let mut inspector = Inspector {
            includes,
            adapter,
            cache,
            run,
            said: HashMap::new(),
            problems: Vec::new(),
        };
        let read = loaded.iter().zip(&paths);
        inspector.inspect(read.filter_map(|(loaded, path)| match loaded {
            Ok(Loaded::Fragment { fragment, hash, .. }) => {
                Some((hash.as_str(), fragment, path.as_path()))
            }
            _ => None,
        }));

        let mut library = Self::default();
        let mut problems = Vec::new();
        for (loaded, path) in loaded.into_iter().zip(paths) {
            match loaded {
                Ok(loaded) => library.insert(path, loaded, &inspector.said),
                Err(wrong) => problems.extend(wrong),
            }
        }
        problems.append(&mut inspector.problems);
        if problems.is_empty() {
            Ok(library)
        } else {
            Err(ObjectError { problems })
        }
    }

    /// Adds a prototype. A fragment of which nothing is known has its problem
    /// on the list.
    fn insert(&mut self, path: &Path, loaded: Loaded, said: &HashMap<String, Said>) {
        let prototype = match loaded {
            Loaded::Neutral { csg, hash } => Prototype {
                path: path.to_owned(),
                hash,
                bounds: csg.bounds(),
                extents: Vec::new(),
                optics: neutral_optics(&csg),
                geometry: Geometry::Neutral(csg),
                unlayerable: None,
            },
            Loaded::Fragment {
                fragment,
                hash,
                stated,
            } => {
                let Some(said) = said.get(&hash) else {
                    return;
                };
                Prototype {
                    path: path.to_owned(),
                    hash,
                    bounds: stated.unwrap_or(said.bounds),
                    // The renderer's own boxes: it draws nothing beside them,
                    // whatever bounds somebody states.
                    extents: said.extents.clone(),
                    optics: said.optics.clone(),
                    geometry: Geometry::Fragment(fragment),
                    unlayerable: said.unlayerable.clone(),
                }
            }
        };
        let id = self.table.insert(prototype);
        self.by_path.insert(path.to_owned(), id);
    }
}

fn neutral_optics(csg: &Csg) -> Optics {
    if csg.is_optical() {
        Optics::Optical("a material with reflection or transmission".into())
    } else {
        Optics::Opaque
    }
}

/// Reads one description.
struct Reader<'a> {
    root: PathBuf,
    allow_outside: bool,
    adapter: &'a dyn Adapter,
}

impl Reader<'_> {
    fn load(&self, path: &Path) -> Result<Loaded, Vec<ObjectProblem>> {
        if !self.allow_outside && !stays_inside(path) {
            return Err(vec![ObjectProblem::Outside {
                path: path.to_owned(),
                folder: self.root.clone(),
            }]);
        }
        let (file, ending) = self.resolve(path).map_err(|problem| vec![problem])?;
        let mut files = Files::new(self.allow_outside);
        let csg = match &*ending {
            "inc" | "pov" => return self.fragment(path, file, ending, &mut files),
            "ron" => {
                let text = files.read(&file);
                let text = text.map_err(|e| vec![e.into_problem(path)])?;
                neutral::read(&file, &text, &mut files)?
            }
            _ => {
                let bytes = files.read(&file);
                let bytes = bytes.map_err(|e| vec![e.into_problem(path)])?;
                let mesh = mesh_file::read(&file, &bytes, &mut files);
                let mesh = mesh.map_err(|source| {
                    vec![ObjectProblem::Mesh {
                        path: path.to_owned(),
                        source,
                    }]
                })?;
                Csg::Mesh(Arc::new(mesh))
            }
        };
        // What has no look of its own has the same one with every renderer.
        let csg = match csg {
            Csg::Look(..) => csg,
            bare => Csg::Look(Material::default(), Box::new(bare)),
        };
        let hash = files.hash();
        Ok(Loaded::Neutral { csg, hash })
    }

    /// The file of a path, and its ending in lower case.
    fn resolve(&self, path: &Path) -> Result<(PathBuf, String), ObjectProblem> {
        let file = self.root.join(path);
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        let ending = ending.to_string_lossy().into_owned();
        if ENDINGS.contains(&&*ending) {
            return Ok((file, ending));
        }
        let with = |ending: &str| {
            let mut name = file.clone().into_os_string();
            name.push(".");
            name.push(ending);
            PathBuf::from(name)
        };
        for ending in TRIED {
            let file = with(ending);
            if file.is_file() {
                return Ok((file, ending.to_owned()));
            }
        }
        let path = path.to_owned();
        if file.is_file() {
            return Err(ObjectProblem::UnknownEnding { path });
        }
        let tried = TRIED.map(with).to_vec();
        Err(ObjectProblem::Missing { path, tried })
    }

    fn fragment(
        &self,
        path: &Path,
        file: PathBuf,
        language: String,
        files: &mut Files,
    ) -> Result<Loaded, Vec<ObjectProblem>> {
        let text = files.read(&file);
        let text = text.map_err(|e| vec![e.into_problem(path)])?;
        if !self.adapter.abilities().fragments.contains(&&*language) {
            return Err(vec![ObjectProblem::Fragment {
                path: path.to_owned(),
                adapter: self.adapter.name().to_owned(),
                language,
            }]);
        }
        let stated = fragment::stated_bounds(&file, &text).map_err(|e| vec![e.into()])?;
        let fragment = Fragment {
            file: NativeFile {
                path: file,
                root: self.root.clone(),
                text,
            },
            language,
        };
        Ok(Loaded::Fragment {
            hash: fragment::content_hash(&fragment),
            fragment,
            stated,
        })
    }
}

/// A fragment that the renderer is asked about.
struct Asked<'a> {
    hash: &'a str,
    fragment: &'a Fragment,
    path: &'a Path,
    key: Option<Vec<u8>>,
}

/// Asks the cache, and then the renderer, about fragments.
struct Inspector<'a> {
    includes: &'a [NativeFile],
    adapter: &'a dyn Adapter,
    cache: &'a Cache,
    run: &'a RunContext,
    /// By content hash.
    said: HashMap<String, Said>,
    problems: Vec<ObjectProblem>,
}

impl Inspector<'_> {
    fn inspect<'a>(&mut self, fragments: impl Iterator<Item = (&'a str, &'a Fragment, &'a Path)>) {
        let mut unknown: Vec<Asked<'a>> = Vec::new();
        for (hash, fragment, path) in fragments {
            if self.said.contains_key(hash) || unknown.iter().any(|asked| asked.hash == hash) {
                continue;
            }
            let version = &self.adapter.abilities().version;
            let name = self.adapter.name();
            let key = fragment::inspection_key(fragment, self.includes, name, version);
            let kept = key.as_ref().and_then(|key| self.cache.get(KIND, key));
            match kept.map(KeptSaid::into_said) {
                Some(said) => {
                    self.said.insert(hash.to_owned(), said);
                }
                None => unknown.push(Asked {
                    hash,
                    fragment,
                    path,
                    key,
                }),
            }
        }
        self.ask(&unknown);
    }

    /// One call for all. Where it fails because of a fragment, each half is
    /// asked again, so that every bad fragment is named, and no good one.
    fn ask(&mut self, asked: &[Asked<'_>]) {
        if asked.is_empty() {
            return;
        }
        let fragments: Vec<&Fragment> = asked.iter().map(|a| a.fragment).collect();
        match self.adapter.inspect(&fragments, self.includes, self.run) {
            Ok(said) if said.len() == asked.len() => {
                for (said, asked) in said.into_iter().zip(asked) {
                    if let Some(key) = &asked.key {
                        self.cache.put(KIND, key, &KeptSaid::new(&said));
                    }
                    self.said.insert(asked.hash.to_owned(), said);
                }
            }
            Ok(said) => {
                let reason = format!("it spoke of {} fragments", said.len());
                self.fail(asked, self.unfit(reason));
            }
            Err(error) if asked.len() > 1 && is_about_a_fragment(&error) => {
                let (first, second) = asked.split_at(asked.len() / 2);
                self.ask(first);
                self.ask(second);
            }
            Err(error) => self.fail(asked, error),
        }
    }

    fn unfit(&self, reason: String) -> AdapterError {
        AdapterError::BadOutput {
            program: self.adapter.name().to_owned(),
            file: PathBuf::from("inspection"),
            reason,
        }
    }

    fn fail(&mut self, asked: &[Asked<'_>], source: AdapterError) {
        self.problems.push(ObjectProblem::Inspection {
            paths: asked.iter().map(|a| a.path.to_owned()).collect(),
            source,
        });
    }
}

/// Would the call have gone well without one of its fragments?
fn is_about_a_fragment(error: &AdapterError) -> bool {
    matches!(
        error,
        AdapterError::Failed { .. }
            | AdapterError::BadOutput { .. }
            | AdapterError::BadInput { .. }
            | AdapterError::Unsupported { .. }
    )
}

#[cfg(test)]
mod tests;

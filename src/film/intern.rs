//! What scenes name, stored once: descriptions, native files, and the objects'
//! identities across scenes.

use std::collections::HashMap;
use std::path::PathBuf;

use super::draft::{At, DraftObject};
use super::mark::{Faults, Mark};
use super::model::{DescriptionId, Identity, NamedFile, ObjectId, Placed, Tables};
use super::paths::{Folder, writable};
use super::problem::Problem;

/// Builds the tables of a film.
#[derive(Debug)]
pub(super) struct Interner {
    folder: Folder,
    pub(super) tables: Tables,
    /// By path; `None` where the path is wrong, which is said once.
    descriptions: HashMap<String, Option<DescriptionId>>,
    natives: HashMap<String, Option<u32>>,
    /// By display name.
    names: HashMap<String, ObjectId>,
    /// The unnamed objects of every description, in order.
    unnamed: Vec<Vec<ObjectId>>,
    /// In the scene at hand: unnamed objects so far of every description …
    counts: Vec<usize>,
    /// … and the line of every object.
    lines: Vec<Option<usize>>,
}

impl Interner {
    pub(super) fn new(folder: Folder) -> Self {
        Self {
            folder,
            tables: Tables::default(),
            descriptions: HashMap::new(),
            natives: HashMap::new(),
            names: HashMap::new(),
            unnamed: Vec::new(),
            counts: Vec::new(),
            lines: Vec::new(),
        }
    }

    pub(super) fn folder(&self) -> PathBuf {
        self.folder.path().to_owned()
    }

    /// A scene begins: objects are counted anew.
    pub(super) fn begin_scene(&mut self) {
        self.counts.fill(0);
        self.lines.fill(None);
    }

    /// Declarations for the whole film.
    pub(super) fn include(&mut self, path: &At<String>, faults: &mut Faults) -> Option<u32> {
        let id = self.native(path, faults)?;
        if !self.tables.includes.contains(&id) {
            self.tables.includes.push(id);
        }
        Some(id)
    }

    /// A renderer-native file.
    pub(super) fn native(&mut self, path: &At<String>, faults: &mut Faults) -> Option<u32> {
        if let Some(known) = self.natives.get(&path.value) {
            return *known;
        }
        let list = &mut self.tables.natives;
        let id = faults
            .check(path.mark, self.folder.native(&path.value))
            .and_then(|file| push(list, &path.value, file));
        self.natives.insert(path.value.clone(), id);
        id
    }

    fn description(&mut self, path: &At<String>, faults: &mut Faults) -> Option<DescriptionId> {
        if let Some(known) = self.descriptions.get(&path.value) {
            return *known;
        }
        let list = &mut self.tables.descriptions;
        let id = faults
            .check(path.mark, self.folder.description(&path.value))
            .and_then(|file| push(list, &path.value, file))
            .map(DescriptionId);
        if id.is_some() {
            self.unnamed.push(Vec::new());
            self.counts.push(0);
        }
        self.descriptions.insert(path.value.clone(), id);
        id
    }

    /// Places an object of the scene at hand.
    pub(super) fn object(
        &mut self,
        draft: &At<DraftObject>,
        faults: &mut Faults,
    ) -> Option<Placed> {
        let DraftObject {
            path,
            name,
            pose,
            motion,
        } = &draft.value;
        let description = self.description(path, faults);
        let object = match name {
            // A name is looked at even where the path is wrong.
            Some(name) => self.named(name, description, faults),
            None => self.next_unnamed(description?, draft.mark, faults),
        };
        Some(Placed {
            object: object?,
            description: description?,
            pose: *pose,
            motion: *motion,
        })
    }

    fn named(
        &mut self,
        name: &At<String>,
        description: Option<DescriptionId>,
        faults: &mut Faults,
    ) -> Option<ObjectId> {
        if name.value.is_empty() {
            faults.push(name.mark, Problem::EmptyName);
            return None;
        }
        faults.check(name.mark, writable("the name", &name.value))?;
        let id = match self.names.get(&name.value) {
            Some(&id) => id,
            None => self.new_identity(name.value.clone(), true, description?)?,
        };
        let text = || name.value.clone();
        if !self.tables.identities[id.0 as usize].named {
            faults.push(name.mark, Problem::NameTaken { name: text() });
            return None;
        }
        if let Some(line) = self.lines[id.0 as usize] {
            faults.push(name.mark, Problem::SameName { name: text(), line });
            return None;
        }
        self.lines[id.0 as usize] = Some(name.mark.line);
        Some(id)
    }

    fn next_unnamed(
        &mut self,
        description: DescriptionId,
        mark: Mark,
        faults: &mut Faults,
    ) -> Option<ObjectId> {
        let d = description.0 as usize;
        let k = self.counts[d];
        self.counts[d] += 1;
        if let Some(&id) = self.unnamed[d].get(k) {
            return Some(id);
        }
        let name = format!("{}#{k}", self.tables.descriptions[d].path);
        if self.names.contains_key(&name) {
            faults.push(mark, Problem::NameTaken { name });
            return None;
        }
        let id = self.new_identity(name, false, description)?;
        self.unnamed[d].push(id);
        Some(id)
    }

    fn new_identity(
        &mut self,
        name: String,
        named: bool,
        description: DescriptionId,
    ) -> Option<ObjectId> {
        let id = ObjectId(u32::try_from(self.tables.identities.len()).ok()?);
        self.names.insert(name.clone(), id);
        self.lines.push(None);
        self.tables.identities.push(Identity {
            name,
            named,
            description,
        });
        Some(id)
    }
}

fn push(list: &mut Vec<NamedFile>, path: &str, file: PathBuf) -> Option<u32> {
    let id = u32::try_from(list.len()).ok()?;
    let path = path.to_owned();
    list.push(NamedFile { path, file });
    Some(id)
}

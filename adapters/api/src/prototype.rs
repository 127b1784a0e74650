//! Prototypes: a geometry stored once, whatever the number of its instances
//! (the thesis's hash table of descriptions).

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use crate::bounds::Bounds;
use crate::csg::Csg;
use crate::extent::Extent;
use crate::scene::NativeFile;

/// The number of a prototype in its table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PrototypeId(pub u32);

/// Renderer-native text, kept as it was written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fragment {
    /// Where it was read from: what it includes is looked for beside it.
    pub file: NativeFile,
    /// The ending of its file's name (`inc`, `pov`): which renderers read it.
    pub language: String,
}

/// What a prototype is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// A neutral solid (a mesh file is one node of it).
    Neutral(Csg),
    /// Text that only one family of renderers reads.
    Fragment(Fragment),
}

/// Does a pixel that shows the object depend on the object and the lights
/// alone?
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Optics {
    /// Yes: opaque, and mirrors nothing.
    Opaque,
    /// No, or perhaps not: it mirrors, refracts or lets light through. The
    /// reason names what was found.
    Optical(String),
}

impl Optics {
    /// May it mirror or let light through?
    pub fn is_optical(&self) -> bool {
        matches!(self, Self::Optical(_))
    }
}

/// A geometry stored once.
#[derive(Clone, Debug, PartialEq)]
pub struct Prototype {
    /// How the film calls it: the path of its description.
    pub path: PathBuf,
    /// The hash of its content, in hexadecimal.
    pub hash: String,
    /// The geometry.
    pub geometry: Geometry,
    /// What encloses it, in its own coordinates.
    pub bounds: Bounds,
    /// Boxes that enclose it together, where somebody knows some: tighter than the
    /// sphere for what is long, flat, or has wings.
    pub extents: Vec<Extent>,
    /// Does it mirror or let light through?
    pub optics: Optics,
    /// Why it cannot be put into a layer, where it cannot (it uses `clock`, …).
    /// A full frame may still show it.
    pub unlayerable: Option<String>,
}

/// All prototypes of a film. Two descriptions of the same content are one.
#[derive(Clone, Debug, Default)]
pub struct PrototypeTable {
    list: Vec<Arc<Prototype>>,
    by_hash: HashMap<String, PrototypeId>,
}

impl PrototypeTable {
    /// Adds a prototype, or finds the one with the same content.
    pub fn insert(&mut self, prototype: Prototype) -> PrototypeId {
        if let Some(&id) = self.by_hash.get(&prototype.hash) {
            return id;
        }
        let id = PrototypeId(u32::try_from(self.list.len()).expect("fewer than 2³² prototypes"));
        self.by_hash.insert(prototype.hash.clone(), id);
        self.list.push(Arc::new(prototype));
        id
    }

    /// The prototype of that number.
    ///
    /// # Panics
    /// Where the number is from another table.
    pub fn get(&self, id: PrototypeId) -> &Prototype {
        &self.list[id.0 as usize]
    }

    /// All of them, in order.
    pub fn iter(&self) -> impl Iterator<Item = (PrototypeId, &Prototype)> {
        (0..).map(PrototypeId).zip(self.list.iter().map(|p| &**p))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }
}

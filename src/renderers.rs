//! The registry: which adapters there are. A new adapter is one line here.

use std::sync::Arc;

use decor_api::{Adapter, AdapterError};
use decor_povray::PovRay;

use crate::objects::Cache;
use crate::versions::version_of;

/// One adapter, found or not.
pub struct Entry {
    /// The name that `--renderer` knows it by.
    pub name: &'static str,
    /// Looks for its renderer.
    pub find: fn() -> Result<Arc<dyn Adapter>, AdapterError>,
    /// How to install its renderer.
    pub install: &'static str,
}

/// All adapters; the first one is the default.
pub const ADAPTERS: [Entry; 3] = [
    Entry {
        name: "povray",
        find: || Ok(Arc::new(povray()?)),
        install: decor_povray::INSTALL,
    },
    Entry {
        name: "mitsuba",
        find: || Ok(Arc::new(decor_mitsuba::Mitsuba::find()?)),
        install: decor_mitsuba::INSTALL,
    },
    Entry {
        name: "reference",
        find: || Ok(Arc::new(decor_reference::Reference::new())),
        install: "it is part of decor",
    },
];

/// POV-Ray, asked for its version where that is not known from before.
///
/// # Errors
/// As [`PovRay::find`].
pub fn povray() -> Result<PovRay, AdapterError> {
    let program = PovRay::located()?;
    let version = version_of(&program, &Cache::open(), PovRay::version_of)?;
    Ok(PovRay::new(program, &version))
}

/// Is there an adapter of that name, whether its renderer is installed or not?
pub fn is_known(name: &str) -> bool {
    name.starts_with(decor_exec::PREFIX) || ADAPTERS.iter().any(|entry| entry.name == name)
}

/// The adapter of that name; `exec:PROGRAM ARGUMENTS` is that program.
///
/// # Errors
/// [`AdapterError::Missing`] where its renderer is not installed, or where there
/// is no adapter of that name; of a program, whatever goes wrong when it is
/// asked for its abilities.
pub fn find(name: &str) -> Result<Arc<dyn Adapter>, AdapterError> {
    if let Some(command) = name.strip_prefix(decor_exec::PREFIX) {
        return Ok(Arc::new(decor_exec::Exec::find(command)?));
    }
    match ADAPTERS.iter().find(|entry| entry.name == name) {
        Some(entry) => (entry.find)(),
        None => {
            let names: Vec<&str> = ADAPTERS.iter().map(|entry| entry.name).collect();
            Err(AdapterError::Missing {
                program: format!("a renderer named `{name}`"),
                install: format!("there are: {}, exec:PROGRAM", names.join(", ")),
            })
        }
    }
}

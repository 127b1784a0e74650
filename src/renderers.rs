//! The registry: which adapters there are. A new adapter is one line here.

use std::sync::Arc;

use decor_api::{Adapter, AdapterError};

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
        find: || Ok(Arc::new(decor_povray::PovRay::find()?)),
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

/// The adapter of that name.
///
/// # Errors
/// [`AdapterError::Missing`] where its renderer is not installed, or where there
/// is no adapter of that name.
pub fn find(name: &str) -> Result<Arc<dyn Adapter>, AdapterError> {
    match ADAPTERS.iter().find(|entry| entry.name == name) {
        Some(entry) => (entry.find)(),
        None => {
            let names: Vec<&str> = ADAPTERS.iter().map(|entry| entry.name).collect();
            Err(AdapterError::Missing {
                program: format!("a renderer named `{name}`"),
                install: format!("there are: {}", names.join(", ")),
            })
        }
    }
}

//! Is POV-Ray there, and does it do what decor relies on?

use decor_api::{Adapter, AdapterError, Health, RunContext, health};

use crate::{INSTALL, LayerSource, PovRay};

/// Renders a ball in the middle of a tiny picture, and looks at it.
pub fn check(adapter: &PovRay, run: &RunContext) -> Health {
    let said = |name: &str, result: Result<String, AdapterError>| {
        (name.to_owned(), result.map_err(|e| e.to_string()))
    };
    Health {
        program: Some(adapter.program().to_owned()),
        version: Some(adapter.abilities().version.clone()),
        checks: vec![
            said("colour", colour(adapter, run)),
            said("depth", health::depth(adapter, run, 1e-4)),
            said("blocks by the state file", blocks(adapter, run)),
        ],
        install: INSTALL.to_owned(),
    }
}

fn colour(adapter: &PovRay, run: &RunContext) -> Result<String, AdapterError> {
    health::colour(adapter, run)?;
    Ok(match adapter.source() {
        LayerSource::StateFile => "read in single precision".into(),
        LayerSource::Pictures => "read with 16 bits".into(),
    })
}

fn blocks(adapter: &PovRay, run: &RunContext) -> Result<String, AdapterError> {
    match adapter.source() {
        LayerSource::StateFile => health::blocks(adapter, run),
        LayerSource::Pictures => {
            Ok("not relied on with this version: windows are rendered instead".into())
        }
    }
}

//! `decor doctor`: is every renderer there, and does it work?

use std::sync::Arc;

use clap::Args;
use decor_api::{Adapter, AdapterError, RunContext};
use serde_json::json;

use super::{Failure, Status, print_json};
use crate::render::WorkFolder;
use crate::renderers::{ADAPTERS, find};

/// Find the renderers, and test each.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// Only this one, which has to be there: povray, mitsuba, reference or
    /// exec:PROGRAM.
    #[arg(long, value_name = "NAME")]
    renderer: Option<String>,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// Runs the verb. A renderer that is missing is no failure where nobody asked for
/// it; one that is there and does not work is.
pub fn run(args: &DoctorArgs) -> Result<Status, Failure> {
    let work = WorkFolder::new(None)?;
    let run = RunContext::new(&work.path);
    let mut broken = 0;
    if let Some(name) = &args.renderer {
        broken += usize::from(!examine(name, &*find(name)?, &run, args.json)?);
    } else {
        for entry in &ADAPTERS {
            match (entry.find)() {
                Ok(adapter) => {
                    let adapter: Arc<dyn Adapter> = adapter;
                    broken += usize::from(!examine(entry.name, &*adapter, &run, args.json)?);
                }
                Err(error) => missing(entry.name, &error, entry.install, args.json)?,
            }
        }
    }
    if args.json {
        let count = args.renderer.as_ref().map_or(ADAPTERS.len(), |_| 1);
        print_json(&json!({"type": "summary", "renderers": count, "broken": broken}))?;
    }
    Ok(if broken == 0 {
        Status::Done
    } else {
        Status::Renderer
    })
}

fn missing(name: &str, error: &AdapterError, install: &str, as_json: bool) -> Result<(), Failure> {
    if as_json {
        print_json(&json!({
            "type": "renderer", "name": name, "found": false,
            "error": error.to_string(), "install": install,
        }))?;
    } else {
        say!("{name}: {error}");
    }
    Ok(())
}

/// Says how a renderer is: is it well?
fn examine(
    name: &str,
    adapter: &dyn Adapter,
    run: &RunContext,
    as_json: bool,
) -> Result<bool, Failure> {
    let health = adapter.health(run);
    let is_good = health.is_good();
    if as_json {
        let checks: Vec<_> = health
            .checks
            .iter()
            .map(|(what, result)| match result {
                Ok(said) => json!({"check": what, "ok": true, "said": said}),
                Err(said) => json!({"check": what, "ok": false, "said": said}),
            })
            .collect();
        print_json(&json!({
            "type": "renderer", "name": name, "found": true,
            "version": health.version, "program": health.program, "checks": checks,
        }))?;
    } else {
        let program = health.program.map(|p| format!(" at {}", p.display()));
        say!(
            "{name} {}{}",
            health.version.unwrap_or_default(),
            program.unwrap_or_default()
        );
        for (what, result) in &health.checks {
            match result {
                Ok(said) => say!("  ok    {what}: {said}"),
                Err(said) => say!("  FAIL  {what}: {said}"),
            }
        }
    }
    Ok(is_good)
}

//! `decor doctor`: is every renderer there, and does it work?

use clap::Args;
use decor_api::RunContext;
use serde_json::json;

use super::{Failure, Status, print_json};
use crate::render::WorkFolder;
use crate::renderers::ADAPTERS;

/// Find the renderers, and test each.
#[derive(Debug, Args)]
pub struct DoctorArgs {
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// Runs the verb. A renderer that is missing is no failure; one that is there
/// and does not work is.
pub fn run(args: &DoctorArgs) -> Result<Status, Failure> {
    let work = WorkFolder::new(None)?;
    let run = RunContext::new(&work.path);
    let mut broken = 0;
    for entry in &ADAPTERS {
        let adapter = match (entry.find)() {
            Ok(adapter) => adapter,
            Err(error) => {
                if args.json {
                    print_json(&json!({
                        "type": "renderer", "name": entry.name, "found": false,
                        "error": error.to_string(), "install": entry.install,
                    }))?;
                } else {
                    say!("{}: {error}", entry.name);
                }
                continue;
            }
        };
        let health = adapter.health(&run);
        broken += usize::from(!health.is_good());
        if args.json {
            let checks: Vec<_> = health
                .checks
                .iter()
                .map(|(what, result)| match result {
                    Ok(said) => json!({"check": what, "ok": true, "said": said}),
                    Err(said) => json!({"check": what, "ok": false, "said": said}),
                })
                .collect();
            print_json(&json!({
                "type": "renderer", "name": entry.name, "found": true,
                "version": health.version, "program": health.program, "checks": checks,
            }))?;
        } else {
            let program = health.program.map(|p| format!(" at {}", p.display()));
            say!(
                "{} {}{}",
                entry.name,
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
    }
    if args.json {
        print_json(&json!({"type": "summary", "renderers": ADAPTERS.len(), "broken": broken}))?;
    }
    Ok(if broken == 0 {
        Status::Done
    } else {
        Status::Renderer
    })
}

//! `decor adapters`: what each renderer can do.

use clap::Args;
use serde_json::json;

use super::{Failure, Status, print_json};
use crate::renderers::ADAPTERS;

/// List the adapters and their abilities.
#[derive(Debug, Args)]
pub struct AdaptersArgs {
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// Runs the verb.
pub fn run(args: &AdaptersArgs) -> Result<Status, Failure> {
    let mut found = 0;
    for entry in &ADAPTERS {
        let adapter = (entry.find)();
        let abilities = adapter.as_ref().ok().map(|a| a.abilities());
        found += usize::from(abilities.is_some());
        if args.json {
            print_json(&match abilities {
                None => json!({"type": "adapter", "name": entry.name, "found": false}),
                Some(a) => json!({
                    "type": "adapter", "name": entry.name, "found": true, "version": a.version,
                    "csg": a.csg, "fragments": a.fragments, "depth_with_colour": a.depth_with_colour,
                    "crop_grid": a.crop_grid, "block_mask": a.block_mask,
                    "hidden_casters": a.hidden_casters, "ray_list": a.ray_list,
                    "coverage": a.coverage, "shadows": a.shadows, "optics": a.optics,
                    "jobs": a.jobs, "units": a.units,
                }),
            })?;
            continue;
        }
        match abilities {
            None => say!("{}: not found", entry.name),
            Some(a) => {
                let yes = |b: bool| if b { "yes" } else { "no" };
                say!("{} {}", entry.name, a.version);
                say!(
                    "  CSG {}, shadows {}, mirrors and glass {}",
                    yes(a.csg),
                    yes(a.shadows),
                    yes(a.optics)
                );
                say!(
                    "  fragments: {}",
                    if a.fragments.is_empty() {
                        "none".into()
                    } else {
                        a.fragments.join(", ")
                    }
                );
                say!(
                    "  blocks of a picture alone {}, coverage {}",
                    yes(a.block_mask),
                    yes(a.coverage)
                );
                say!(
                    "  hidden casters {}, list of rays {}",
                    yes(a.hidden_casters),
                    yes(a.ray_list)
                );
                say!("  {}", a.units);
            }
        }
    }
    if args.json {
        print_json(&json!({"type": "summary", "adapters": ADAPTERS.len(), "found": found}))?;
    }
    Ok(Status::Done)
}

//! `decor adapters`: what each renderer can do.

use clap::Args;
use decor_api::{Abilities, AdapterError, DepthKind};
use serde_json::{Value, json};

use super::{Failure, Status, print_json};
use crate::renderers::{self, ADAPTERS};

/// List the adapters and their abilities.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor adapters
  decor adapters --json
  decor adapters --renderer 'exec:python3 raycast.py'")]
pub struct AdaptersArgs {
    /// Only this one; exec:PROGRAM asks a program for its abilities.
    #[arg(long, value_name = "NAME")]
    renderer: Option<String>,
    /// One JSON object a line on stdout.
    #[arg(long)]
    json: bool,
}

/// Runs the verb. A renderer that is missing is no failure, unless it was asked
/// for.
pub fn run(args: &AdaptersArgs) -> Result<Status, Failure> {
    if let Some(name) = &args.renderer {
        if !renderers::is_known(name) {
            let error = renderers::find(name).map(|_| ()).map_err(|e| e.to_string());
            return Err(Failure::usage(error.err().unwrap_or_default()));
        }
        let adapter = renderers::find(name)?;
        show(args, name, Ok(adapter.abilities()))?;
        return end(args, 1, 1);
    }
    let mut found = 0;
    for entry in &ADAPTERS {
        let adapter = (entry.find)();
        found += usize::from(adapter.is_ok());
        show(args, entry.name, adapter.as_ref().map(|a| a.abilities()))?;
    }
    end(args, ADAPTERS.len(), found)
}

fn end(args: &AdaptersArgs, adapters: usize, found: usize) -> Result<Status, Failure> {
    if args.json {
        print_json(&json!({"type": "summary", "adapters": adapters, "found": found}))?;
    }
    Ok(Status::Done)
}

fn show(
    args: &AdaptersArgs,
    name: &str,
    abilities: Result<&Abilities, &AdapterError>,
) -> Result<(), Failure> {
    match (abilities, args.json) {
        (Ok(abilities), true) => print_json(&line(name, abilities)),
        (Err(error), true) => print_json(&json!({
            "type": "adapter", "name": name, "found": false, "error": error.to_string(),
        })),
        (Ok(abilities), false) => {
            tell(name, abilities);
            Ok(())
        }
        (Err(error), false) => {
            say!("{name}: {error}");
            Ok(())
        }
    }
}

/// Every ability: one that is added is missed here by the compiler.
fn line(name: &str, abilities: &Abilities) -> Value {
    let Abilities {
        version,
        csg,
        fragments,
        depth_with_colour,
        depth,
        sample_position,
        crop_grid,
        block_mask,
        finest_block,
        masks_in_crops,
        hidden_casters,
        ray_list,
        coverage,
        shadows,
        optics,
        jobs,
        call_overhead_s,
        picture_cpu_s,
        units,
    } = abilities;
    let depth = match depth {
        DepthKind::AlongRay => "along_ray",
        DepthKind::AlongAxis => "along_axis",
    };
    json!({
        "type": "adapter", "name": name, "found": true, "version": version,
        "csg": csg, "fragments": fragments, "depth_with_colour": depth_with_colour,
        "depth": depth, "sample_position": [sample_position.0, sample_position.1],
        "crop_grid": crop_grid, "block_mask": block_mask, "finest_block": finest_block,
        "masks_in_crops": masks_in_crops,
        "hidden_casters": hidden_casters,
        "ray_list": ray_list, "coverage": coverage, "shadows": shadows, "optics": optics,
        "jobs": jobs, "call_overhead_s": call_overhead_s,
        "picture_cpu_s": picture_cpu_s, "units": units,
    })
}

fn tell(name: &str, can: &Abilities) {
    let yes = |b: bool| if b { "yes" } else { "no" };
    say!("{name} {}", can.version);
    say!(
        "  CSG {}, shadows {}, mirrors and glass {}",
        yes(can.csg),
        yes(can.shadows),
        yes(can.optics)
    );
    let fragments = match can.fragments {
        [] => "none".to_owned(),
        endings => endings.join(", "),
    };
    say!("  fragments: {fragments}");
    let crops = match can.crop_grid {
        Some(1) => "anywhere".to_owned(),
        Some(grid) => format!("every {grid} pixels"),
        None => "nowhere".to_owned(),
    };
    say!(
        "  parts identical to the whole: {crops}; blocks of a picture alone {}",
        yes(can.block_mask)
    );
    say!(
        "  hidden casters {}, list of rays {}, coverage {}",
        yes(can.hidden_casters),
        yes(can.ray_list),
        yes(can.coverage)
    );
    say!(
        "  {} at once, {} s a call before any picture, {} s of CPU a picture beside its pixels",
        can.jobs,
        can.call_overhead_s,
        can.picture_cpu_s
    );
    say!("  {}", can.units);
}

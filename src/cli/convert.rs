//! `decor convert`: from one form of a film to the other.

use std::path::{Path, PathBuf};

use clap::Args;

use super::{Failure, Status};
use crate::film::{self, Form};
use crate::frames::write_safely;

/// Turn a film from one form (.anim, .jsonl) into the other.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  decor convert plane.anim plane.jsonl
  decor convert plane.jsonl again.anim")]
pub struct ConvertArgs {
    /// The film.
    from: PathBuf,
    /// What to write: its ending says in which form.
    to: PathBuf,
    /// Object paths may leave the film's folder.
    #[arg(long)]
    allow_outside: bool,
}

/// Runs the verb.
pub fn run(args: &ConvertArgs) -> Result<Status, Failure> {
    let Some(form) = Form::of(&args.to) else {
        return Err(Failure::usage(format!(
            "{}: a film's name ends in .anim or .jsonl",
            args.to.display()
        )));
    };
    let film = film::read(&args.from, args.allow_outside).map_err(Failure::input)?;
    let folder = args.to.parent().filter(|path| !path.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new("."));
    if std::path::absolute(folder).ok().as_deref() != Some(film.folder()) {
        // The paths in a film are relative to where it lies.
        eprintln!(
            "decor: {} names objects relative to {}: it belongs there",
            args.to.display(),
            film.folder().display()
        );
    }
    write_safely(&args.to, form.write(&film).as_bytes())?;
    Ok(Status::Done)
}

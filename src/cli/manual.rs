//! Completions and the manual page, generated from the arguments.

use clap::{Args, CommandFactory as _};

use super::{Cli, Failure, Status};

/// Print shell completions.
#[derive(Debug, Args)]
pub struct CompletionsArgs {
    /// For which shell.
    shell: clap_complete::Shell,
}

/// Runs the verb.
pub fn completions(args: &CompletionsArgs) -> Result<Status, Failure> {
    clap_complete::generate(
        args.shell,
        &mut Cli::command(),
        "decor",
        &mut std::io::stdout(),
    );
    Ok(Status::Done)
}

/// Prints the manual page.
pub fn man() -> Result<Status, Failure> {
    clap_mangen::Man::new(Cli::command())
        .render(&mut std::io::stdout())
        .map_err(|source| Failure::write("stdout".as_ref(), source))?;
    Ok(Status::Done)
}

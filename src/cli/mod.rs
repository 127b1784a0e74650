//! The command line: one file per verb.

/// Prints a line on stdout. A reader that went away wants no more of it: that
/// is no reason to panic, as `println!` does.
macro_rules! say {
    ($($words:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout().lock(), $($words)*);
    }};
}

mod adapters;
mod compare;
mod convert;
mod doctor;
mod explain;
mod failure;
mod film_args;
mod manual;
mod plain;
mod plain_explain;
mod plain_plan;
mod plan;
mod progress;
mod render;
mod stream;
mod sweep;
mod tune;

use clap::{Parser, Subcommand};

pub use failure::{Failure, Status};

/// Renders animations faster, with the renderer you already have.
#[derive(Debug, Parser)]
#[command(
    name = "decor",
    version,
    propagate_version = true,
    arg_required_else_help = true
)]
struct Cli {
    /// Say more (twice: everything).
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Say nothing but errors.
    #[arg(short, long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Debug, Subcommand)]
enum Verb {
    /// Render a film.
    Render(render::RenderArgs),
    /// Show what would be rendered, and what it would cost.
    Plan(plan::PlanArgs),
    /// Explain why each object of a frame has its class.
    Explain(explain::ExplainArgs),
    /// Compare two pictures, or two folders of frames.
    Compare(compare::CompareArgs),
    /// Render scenes from stdin as they arrive.
    Stream(stream::StreamArgs),
    /// Measure what settings win and what they cost.
    Sweep(sweep::SweepArgs),
    /// Find the fastest setting that keeps a quality.
    Tune(tune::TuneArgs),
    /// Turn a film from one form (.anim, .jsonl) into the other.
    Convert(convert::ConvertArgs),
    /// List the adapters and their abilities.
    Adapters(adapters::AdaptersArgs),
    /// Find the renderers, and test each.
    Doctor(doctor::DoctorArgs),
    /// Print shell completions.
    Completions(manual::CompletionsArgs),
    /// Print the manual page.
    Man,
}

/// Runs the program with the arguments of the process; gives its exit status.
pub fn run() -> u8 {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are no errors; they go to stdout.
            let _ = error.print();
            return if error.use_stderr() {
                Status::Usage.code()
            } else {
                Status::Done.code()
            };
        }
    };
    log(cli.verbose, cli.quiet);
    let result = match &cli.verb {
        Verb::Render(args) => render::run(args, cli.quiet),
        Verb::Plan(args) => plan::run(args),
        Verb::Explain(args) => explain::run(args),
        Verb::Compare(args) => return compare::run(args, &mut std::io::stdout().lock()),
        Verb::Stream(args) => stream::run(args, cli.quiet),
        Verb::Sweep(args) => sweep::run(args, cli.quiet),
        Verb::Tune(args) => tune::run(args, cli.quiet),
        Verb::Convert(args) => convert::run(args),
        Verb::Adapters(args) => adapters::run(args),
        Verb::Doctor(args) => doctor::run(args),
        Verb::Completions(args) => manual::completions(args),
        Verb::Man => manual::man(),
    };
    match result {
        Ok(status) => status.code(),
        Err(failure) => {
            let status = failure.status;
            eprintln!("{:?}", miette::Report::from(failure));
            status.code()
        }
    }
}

fn log(verbose: u8, quiet: bool) {
    let level = match (quiet, verbose) {
        (true, _) => "error",
        (_, 0) => "warn",
        (_, 1) => "info",
        _ => "debug",
    };
    let filter = tracing_subscriber::EnvFilter::try_from_env("DECOR_LOG")
        .unwrap_or_else(|_| format!("decor={level},decor_api={level},decor_povray={level}").into());
    // A second subscriber in one process: only tests do that, and need none.
    let _ = tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        .without_time()
        .try_init();
}

/// Prints one JSON object on a line of stdout.
fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    use std::io::Write as _;
    let line = serde_json::to_string(value).map_err(Failure::internal)?;
    let mut out = std::io::stdout().lock();
    writeln!(out, "{line}").map_err(|source| Failure::write("stdout".as_ref(), source))
}

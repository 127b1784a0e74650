//! The program: arguments, call, errors.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(decor::cli::run())
}

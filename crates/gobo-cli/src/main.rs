//! The program `gobo`.
use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(gobo_cli::program(std::env::args_os()))
}

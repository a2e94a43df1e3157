//! The program `gobo`.
use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(gobo::program(std::env::args_os()))
}

//! The command line.
mod cli;

use clap::Parser as _;
use std::{io::IsTerminal as _, process::ExitCode};

fn main() -> ExitCode {
    let arguments = cli::Arguments::parse();
    tracing_subscriber::fmt()
        .with_writer(|| cli::Quiet)
        .with_ansi(std::io::stderr().is_terminal())
        .with_env_filter(
            tracing_subscriber::EnvFilter::try_from_env("GOBO_LOG")
                .unwrap_or_else(|_| tracing_subscriber::EnvFilter::new("gobo=warn")),
        )
        .without_time()
        .init();
    match cli::run(arguments.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let status = failure.status();
            failure.print();
            ExitCode::from(status)
        }
    }
}

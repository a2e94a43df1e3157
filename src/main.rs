//! The command line.
mod cli;

use clap::Parser as _;
use std::{io::IsTerminal as _, process::ExitCode};
use tracing_subscriber::{Layer as _, filter::Targets, prelude::*};

fn main() -> ExitCode {
    let clock = cli::WallClock::start();
    let arguments = cli::Arguments::parse();
    if arguments.command.opens_a_device() {
        cli::name_a_runtime_folder();
    }
    let chosen = std::env::var("GOBO_LOG").ok().and_then(|text| text.parse().ok());
    let warnings = || Targets::new().with_target("gobo", tracing::Level::WARN);
    let messages = tracing_subscriber::fmt::layer()
        .with_writer(|| cli::Quiet)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_filter(chosen.unwrap_or_else(warnings));
    let spans = Targets::new().with_target("gobo", tracing::Level::DEBUG);
    tracing_subscriber::registry().with(messages).with(clock.clone().with_filter(spans)).init();
    cli::give_aborts_a_status();
    cli::hush_decoders();
    match cli::run(arguments.command, &clock) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let status = failure.status();
            failure.print();
            ExitCode::from(status)
        }
    }
}

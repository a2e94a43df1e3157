//! Commands: each is a file with one `run`. Results go to standard output, messages to standard
//! error.
mod arguments;
mod bench;
mod check;
mod claim;
mod contents;
mod curves;
mod export;
mod exr;
mod failure;
mod files;
mod frame;
mod info;
mod inputs;
mod layers;
mod light;
mod look_up;
mod manual;
mod maps;
mod memory;
mod merge;
mod npy;
mod output;
mod pack;
mod part;
mod preview;
mod relight;
mod render;
mod report;
mod runtime_folder;
mod sidecar;
mod specialise;
mod stop;
mod structs;
mod translate;
mod trial;
mod trial_scene;
mod values;
mod verify;
#[cfg(feature = "view")]
mod view;
mod wall_clock;
mod writers;

use arguments::{Arguments, Command};
#[doc(hidden)]
pub use bench::bench_discs;
use clap::Parser as _;
pub use curves::{nodes_warning, nodes_warning_before};
use failure::Failure;
pub use memory::Needs;
use std::{ffi::OsString, io::IsTerminal as _};
use tracing_subscriber::{Layer as _, filter::Targets, prelude::*};
use wall_clock::WallClock;

/// Runs the program `gobo`, once per process: it listens for signals, and sets where messages go.
/// `arguments`: the program's name first. Returns the exit status.
///
/// On Linux a command that opens a device restarts the process if the environment has no `XDG_RUNTIME_DIR`.
pub fn program(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let clock = WallClock::start();
    let arguments = match Arguments::try_parse_from(arguments) {
        Ok(arguments) => arguments,
        Err(error) => {
            // The terminal may be closed.
            let _ = error.print();
            return error.exit_code() as u8;
        }
    };
    if arguments.command.opens_a_device() {
        runtime_folder::name_a_runtime_folder();
    }
    let chosen = std::env::var("GOBO_LOG").ok().and_then(|text| text.parse().ok());
    let warnings = || Targets::new().with_target("gobo", tracing::Level::WARN);
    let messages = tracing_subscriber::fmt::layer()
        .with_writer(|| files::Quiet)
        .with_ansi(std::io::stderr().is_terminal())
        .without_time()
        .with_filter(chosen.unwrap_or_else(warnings));
    let spans = Targets::new().with_target("gobo", tracing::Level::DEBUG);
    // A host that has set its own subscriber keeps it.
    let _ = tracing_subscriber::registry()
        .with(messages)
        .with(clock.clone().with_filter(spans))
        .try_init();
    stop::give_aborts_a_status();
    stop::hush_decoders();
    match run(arguments.command, &clock) {
        Ok(()) => 0,
        Err(failure) => {
            failure.print();
            failure.status()
        }
    }
}

fn run(command: Command, clock: &WallClock) -> Result<(), Failure> {
    stop::listen()?;
    if !matches!(command, Command::View(_)) {
        inputs::watch();
    }
    match command {
        Command::Render(arguments) => render::run(&arguments, clock),
        #[cfg(feature = "view")]
        Command::View(arguments) => view::run(&arguments),
        #[cfg(not(feature = "view"))]
        Command::View(_) => {
            let message = "this program was built without a window: `cargo install --path \
                           crates/gobo-cli --features view` \
                           in a checkout builds one that has it";
            Err(Failure::Usage(message.to_owned()))
        }
        Command::Bench(arguments) => bench::run(&arguments, clock),
        Command::Check { scene } => check::run(&scene),
        Command::Pack { scene, out } => pack::run(&scene, &out),
        Command::Light(arguments) => light::run(&arguments),
        Command::Maps(arguments) => part::run(&arguments),
        Command::Merge { parts, out } => merge::run(&parts, &out),
        Command::Relight(arguments) => relight::run(&arguments),
        Command::Verify { dir } => verify::run(&dir),
        Command::Info(arguments) => info::run(&arguments),
        Command::Export { target, out, scene, set } => {
            export::run(target, &out, scene.as_deref(), &set)
        }
        Command::Man { out } => manual::man(out.as_deref()),
        Command::Completions { shell } => manual::completions(shell),
    }
}

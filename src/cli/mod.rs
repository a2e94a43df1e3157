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
mod wall_clock;
mod writers;

pub(crate) use arguments::Arguments;
use arguments::Command;
use failure::Failure;
pub(crate) use files::Quiet;
pub(crate) use runtime_folder::name_a_runtime_folder;
pub(crate) use stop::{give_aborts_a_status, hush_decoders};
pub(crate) use wall_clock::WallClock;

pub(crate) fn run(command: Command, clock: &WallClock) -> Result<(), Failure> {
    stop::listen()?;
    inputs::watch();
    match command {
        Command::Render(arguments) => render::run(&arguments, clock),
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

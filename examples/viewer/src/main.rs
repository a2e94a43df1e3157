//! Viewer of a scene in a window: `viewer data/smoke.toml`.
//!
//! Drag to orbit, drag with the right or middle button (or with shift) to pan, scroll to zoom; drop another
//! scene on the window to open it. The renderer has its own thread and device, so that the window responds
//! while kernels are compiled.
mod app;
mod inset;
mod knobs;
mod orbit;
mod panels;
mod script;
mod shot;
mod worker;

use app::App;
use clap::{Parser, ValueEnum};
use eframe::egui;
use std::{path::PathBuf, process::ExitCode, sync::mpsc::channel};

/// Shows a scene file of gobo.
#[derive(Clone, Debug, Parser)]
#[command(name = "viewer", version)]
pub struct Arguments {
    /// A .toml, .glb, .gltf, .ply or .csv file
    pub scene: PathBuf,
    /// Which renders; the window's is the system's choice
    #[arg(long, value_enum, default_value = "auto")]
    backend: Backend,
    /// Part of the adapter's name
    #[arg(long)]
    adapter: Option<String>,
    /// Of the window [points]
    #[arg(long, value_names = ["WIDTH", "HEIGHT"], num_args = 2, default_values_t = [1280.0, 800.0])]
    size: Vec<f32>,
    /// Pixels of the picture to one of the window, along an edge
    #[arg(long, default_value_t = 1.0)]
    pub scale: f32,
    /// Writes the window as a PNG file after the last of --frames, and closes it
    #[arg(long)]
    pub screenshot: Option<PathBuf>,
    /// Pictures before the screenshot
    #[arg(long, default_value_t = 1)]
    pub frames: u32,
    /// How far the camera turns before the last of them [degrees]
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true)]
    pub orbit: f32,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Backend {
    Auto,
    Vulkan,
    Metal,
    Dx12,
    Gl,
    Cpu,
}

impl From<Backend> for gobo::host::Backend {
    fn from(backend: Backend) -> Self {
        match backend {
            Backend::Auto => Self::Auto,
            Backend::Vulkan => Self::Vulkan,
            Backend::Metal => Self::Metal,
            Backend::Dx12 => Self::Dx12,
            Backend::Gl => Self::Gl,
            Backend::Cpu => Self::Cpu,
        }
    }
}

fn main() -> ExitCode {
    match run(Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("viewer: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: Arguments) -> Result<(), String> {
    let size = [arguments.size[0], arguments.size[1]];
    let viewport = egui::ViewportBuilder::default().with_title("gobo").with_inner_size(size);
    let options = eframe::NativeOptions { viewport, ..Default::default() };
    let is_script = arguments.screenshot.is_some();
    let (done, outcome) = channel();
    let make: eframe::AppCreator<'_> = Box::new(move |creation| {
        let (backend, adapter) = (arguments.backend.into(), arguments.adapter.clone());
        Ok(Box::new(App::new(&creation.egui_ctx, arguments, backend, adapter, done)))
    });
    eframe::run_native("gobo", options, make).map_err(|error| error.to_string())?;
    match outcome.try_recv() {
        Ok(outcome) => outcome,
        Err(_) if is_script => Err("the window was closed before its picture was taken".to_owned()),
        Err(_) => Ok(()),
    }
}

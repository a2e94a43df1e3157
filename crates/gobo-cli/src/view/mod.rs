//! `gobo view`: a scene in a window.
//!
//! The renderer has its own thread and devices, so that the window responds while kernels are compiled.
mod app;
mod canvas;
mod inset;
mod knobs;
mod orbit;
mod panels;
mod pick;
mod request;
mod script;
mod shot;
#[cfg(test)]
mod tests;
mod time_line;
mod watch;
mod worker;

use super::{arguments::ViewArguments, failure::Failure, output::Output};
use app::App;
use eframe::egui;
use std::sync::mpsc::channel;

pub(super) fn run(arguments: &ViewArguments) -> Result<(), Failure> {
    gobo_scene::watch_files(watch::note);
    if let Some(file) = &arguments.screenshot {
        Output::check(file)?;
    }
    let size = [arguments.size[0], arguments.size[1]];
    let viewport = egui::ViewportBuilder::default().with_title("gobo").with_inner_size(size);
    let options = eframe::NativeOptions { viewport, ..Default::default() };
    let (done, outcome) = channel();
    let (is_script, arguments) = (arguments.screenshot.is_some(), arguments.clone());
    let make: eframe::AppCreator<'_> =
        Box::new(move |creation| Ok(Box::new(App::new(&creation.egui_ctx, arguments, done))));
    eframe::run_native("gobo", options, make).map_err(|error| {
        // winit puts a position in its source before the reason.
        let text = error.to_string();
        Failure::Window(text.rsplit(": ").next().unwrap_or(&text).to_owned())
    })?;
    match outcome.try_recv() {
        Ok(outcome) => outcome,
        Err(_) if is_script => {
            let message = "the window was closed before its picture was taken";
            Err(Failure::Wrong(message.to_owned()))
        }
        Err(_) => Ok(()),
    }
}

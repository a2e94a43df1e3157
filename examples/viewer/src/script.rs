//! Scripted orbit, with a screenshot at the end.
use crate::{Arguments, shot};
use eframe::egui::{ColorImage, Context, ViewportCommand};
use std::{
    path::PathBuf,
    sync::{Arc, mpsc::Sender},
};

pub struct Script {
    file: PathBuf,
    frames: u32,
    /// Rotation before each frame after the first [turns].
    step: f32,
    shown: u32,
    /// Passes of the window since the last picture arrived: after one the picture is on the screen.
    passes: u32,
    done: Sender<Result<(), String>>,
}

impl Script {
    pub fn of(arguments: &Arguments, done: Sender<Result<(), String>>) -> Option<Self> {
        let file = arguments.screenshot.clone()?;
        let frames = arguments.frames.max(1);
        let step = arguments.orbit / 360.0 / (frames.max(2) - 1) as f32;
        Some(Self { file, frames, step, shown: 0, passes: 0, done })
    }

    /// Counts a shown picture; returns the rotation before the next one [turns], if there is one.
    pub fn next(&mut self) -> Option<f32> {
        self.shown += 1;
        (self.shown < self.frames).then_some(self.step)
    }

    /// Called once per pass of the window. `picture`: of the scene.
    pub fn pass(&mut self, context: &Context, picture: Option<&ColorImage>) {
        if self.shown < self.frames {
            return;
        }
        self.passes += 1;
        context.request_repaint();
        if self.passes != 2 {
            return;
        }
        let of_scene = picture.map_or(Err("there is no picture".to_owned()), |picture| {
            shot::check("the picture", picture)
        });
        let (file, done, again) = (self.file.clone(), self.done.clone(), context.clone());
        context.request_screenshot(move |window: Arc<ColorImage>| {
            let outcome = of_scene
                .and_then(|()| shot::save(&file, &window))
                .and_then(|()| shot::check("the window", &window));
            // The receiver exists until the window is closed.
            let _ = done.send(outcome);
            again.send_viewport_cmd(ViewportCommand::Close);
            again.request_repaint();
        });
    }

    /// Ends the script: no further picture is shown.
    pub fn fail(&mut self, context: &Context, problem: &str) {
        // The receiver exists until the window is closed.
        let _ = self.done.send(Err(problem.to_owned()));
        context.send_viewport_cmd(ViewportCommand::Close);
    }
}

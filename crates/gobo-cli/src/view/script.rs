//! Steps until the window's screenshot is taken.
use super::shot;
use crate::{arguments::ViewArguments, failure::Failure};
use eframe::egui::{ColorImage, Context, ViewportCommand};
use std::{
    path::PathBuf,
    sync::{Arc, mpsc::Sender},
};

pub(super) struct Script {
    file: PathBuf,
    frames: u32,
    /// Rotation before each frame after the first [turns].
    step: f32,
    shown: u32,
    /// Passes of the window since the last picture arrived: after one pass the picture is on the screen.
    passes: u32,
    done: Sender<Result<(), Failure>>,
}

impl Script {
    pub(super) fn of(arguments: &ViewArguments, done: Sender<Result<(), Failure>>) -> Option<Self> {
        let file = arguments.screenshot.clone()?;
        let frames = arguments.frames.max(1);
        let step = arguments.orbit / 360.0 / (frames.max(2) - 1) as f32;
        Some(Self { file, frames, step, shown: 0, passes: 0, done })
    }

    /// Counts a picture, or an error beside the last one; returns the rotation before the next one [turns],
    /// if any.
    pub(super) fn next(&mut self) -> Option<f32> {
        self.shown += 1;
        (self.shown < self.frames).then_some(self.step)
    }

    /// Called once per pass of the window. `picture`: of the scene.
    pub(super) fn pass(&mut self, context: &Context, picture: Option<&ColorImage>) {
        if self.shown < self.frames {
            return;
        }
        self.passes += 1;
        context.request_repaint();
        if self.passes != 2 {
            return;
        }
        let of_scene = match picture {
            Some(picture) => shot::check("the picture", picture),
            None => Err(Failure::Wrong("there is no picture".to_owned())),
        };
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
    pub(super) fn fail(&mut self, context: &Context, problem: &str) {
        // The receiver exists until the window is closed.
        let _ = self.done.send(Err(Failure::Wrong(problem.to_owned())));
        context.send_viewport_cmd(ViewportCommand::Close);
    }
}

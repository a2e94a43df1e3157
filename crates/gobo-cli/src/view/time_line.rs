//! Time of the animation: it plays, stands, and is dragged.
use eframe::egui::{Key, Slider, Ui};
use gobo::Scene;
use std::time::Instant;

/// Time line of an animated scene.
#[derive(Debug)]
pub(super) struct TimeLine {
    /// Present time [s].
    pub(super) time: f64,
    /// Time at which it restarts [s].
    end: f64,
    /// Moment of the last step, while it plays.
    moved: Option<Instant>,
}

impl TimeLine {
    pub(super) fn new(end: f64) -> Self {
        Self { time: 0.0, end, moved: None }
    }

    /// The same with another end.
    pub(super) fn with_end(self, end: f64) -> Self {
        Self { time: self.time.min(end), end, ..self }
    }

    /// Goes to a time [s], clamped to the time line.
    pub(super) fn go_to(&mut self, time: f64) {
        self.time = time.max(0.0).min(self.end);
    }

    pub(super) fn plays(&self) -> bool {
        self.moved.is_some()
    }

    pub(super) fn play(&mut self, plays: bool) {
        self.moved = plays.then(Instant::now);
    }

    /// Advances to the present moment, if it plays.
    pub(super) fn go_on(&mut self, now: Instant) {
        if let Some(moved) = &mut self.moved {
            let step = now.duration_since(*moved).as_secs_f64();
            *moved = now;
            self.time = (self.time + step) % self.end;
        }
    }

    /// Steps by some frames, and stands there.
    fn step(&mut self, frames: f64) {
        self.play(false);
        let frame = (self.time * Scene::FRAME_RATE).round() + frames;
        self.go_to(frame / Scene::FRAME_RATE);
    }

    fn take_keys(&mut self, ui: &Ui) {
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |key| ui.input(|input| input.key_pressed(key));
        if pressed(Key::Space) {
            self.play(!self.plays());
        }
        if pressed(Key::ArrowLeft) {
            self.step(-1.0);
        }
        if pressed(Key::ArrowRight) {
            self.step(1.0);
        }
        if pressed(Key::Home) {
            self.time = 0.0;
        }
    }

    pub(super) fn show(&mut self, ui: &mut Ui) {
        self.take_keys(ui);
        ui.horizontal(|ui| {
            let text = if self.plays() { "Pause" } else { "Play" };
            if ui.button(text).on_hover_text("space").clicked() {
                self.play(!self.plays());
            }
            if ui.button("Start").on_hover_text("home").clicked() {
                self.time = 0.0;
            }
            let frame = (self.time * Scene::FRAME_RATE).round();
            let text = format!("{:.2} of {:.2} s, frame {frame}", self.time, self.end);
            ui.spacing_mut().slider_width = (ui.available_width() - 200.0).max(60.0);
            let slider = Slider::new(&mut self.time, 0.0..=self.end).show_value(false);
            if ui.add(slider).on_hover_text("drag; arrows go a frame").dragged() {
                self.play(false);
            }
            ui.label(text);
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn it_plays_by_the_clock_and_starts_anew() {
        let start = Instant::now();
        let mut line = TimeLine { time: 1.5, end: 2.0, moved: Some(start) };
        line.go_on(start + Duration::from_millis(250));
        assert!((line.time - 1.75).abs() < 1e-9, "{line:?}");
        line.go_on(start + Duration::from_millis(750));
        assert!((line.time - 0.25).abs() < 1e-9, "{line:?}");
        line.play(false);
        line.go_on(start + Duration::from_secs(5));
        assert!((line.time - 0.25).abs() < 1e-9, "{line:?}");
    }

    #[test]
    fn steps_end_at_frames_and_at_its_ends() {
        let mut line = TimeLine::new(0.1);
        line.time = 0.05;
        line.step(1.0);
        assert!((line.time - 2.0 / 24.0).abs() < 1e-9 && !line.plays(), "{line:?}");
        line.step(9.0);
        assert_eq!(line.time, 0.1);
        line.step(-9.0);
        assert_eq!(line.time, 0.0);
        assert_eq!(TimeLine { time: 5.0, ..line }.with_end(1.0).time, 1.0);
    }
}

//! State of the window, and its requests to the renderer.
use crate::{
    Arguments,
    knobs::Knobs,
    panels,
    script::Script,
    worker::{Facts, Look, News, Shown, Wish, Worker},
};
use eframe::egui::{self, Color32, ColorImage, PointerButton, TextureHandle, TextureOptions};
use gobo::{Counters, glam::UVec2, host::Backend};
use std::{
    path::PathBuf,
    sync::mpsc::Sender,
    time::{Duration, Instant},
};

/// Time budget of a picture while something changes [ms].
const PATIENCE_MS: f64 = 120.0;
/// Time without a change after which the picture is rendered at full resolution.
const REST: Duration = Duration::from_millis(250);

pub struct App {
    worker: Worker,
    file: PathBuf,
    reading: u64,
    /// Properties of the scene that was read last.
    pub facts: Option<Facts>,
    pub knobs: Option<Knobs>,
    /// Pixels of the picture per pixel of the window, along an edge.
    pub scale: f32,
    /// Size of the area for the picture [pixels].
    space: UVec2,
    asked: Option<Look>,
    number: u64,
    changed: Instant,
    pub shown: Option<Shown>,
    /// Counters of the last picture for which maps were rendered.
    pub counters: Option<Counters>,
    /// Stages, each with the time of its last run [ms].
    pub stages: Vec<(&'static str, f64)>,
    texture: Option<TextureHandle>,
    pub insets: Vec<[TextureHandle; 3]>,
    /// Index of the view whose insets are shown.
    pub view: usize,
    /// Kernels left to compile, their total number, and the one being compiled.
    pub kernels: Option<(usize, usize, &'static str)>,
    pub device: String,
    pub problem: Option<String>,
    /// Time per million pixels of a picture [ms].
    pace: f64,
    script: Option<Script>,
}

impl App {
    pub fn new(
        context: &egui::Context,
        arguments: Arguments,
        backend: Backend,
        adapter: Option<String>,
        done: Sender<Result<(), String>>,
    ) -> Self {
        context.set_theme(egui::Theme::Dark);
        context.all_styles_mut(|style| {
            style.text_styles.insert(egui::TextStyle::Small, egui::FontId::proportional(11.0));
        });
        let worker = Worker::start(context.clone(), backend, adapter);
        let script = Script::of(&arguments, done);
        let mut app = Self {
            worker,
            file: arguments.scene,
            reading: 0,
            facts: None,
            knobs: None,
            scale: arguments.scale.clamp(0.1, 1.0),
            space: UVec2::new(16, 16),
            asked: None,
            number: 0,
            changed: Instant::now(),
            shown: None,
            counters: None,
            stages: Vec::new(),
            texture: None,
            insets: Vec::new(),
            view: 0,
            kernels: None,
            device: String::new(),
            problem: None,
            pace: 0.0,
            script,
        };
        app.read();
        app
    }

    /// Name of the file, for people.
    pub fn name(&self) -> String {
        self.file.file_name().unwrap_or(self.file.as_os_str()).to_string_lossy().into_owned()
    }

    /// Reads the file, for the first time or again.
    pub fn read(&mut self) {
        self.reading += 1;
        (self.knobs, self.facts, self.asked, self.problem) = (None, None, None, None);
        (self.shown, self.texture, self.counters) = (None, None, None);
        self.wish(None);
    }

    fn wish(&mut self, look: Option<Look>) {
        self.number += 1;
        let (file, reading, number) = (self.file.clone(), self.reading, self.number);
        self.worker.wish(Wish { file, reading, look: look.clone(), number });
        self.asked = look;
    }

    fn hear(&mut self, context: &egui::Context) {
        while let Ok(news) = self.worker.news.try_recv() {
            match news {
                News::Device(device) => self.device = device,
                News::Read { reading, facts } if reading == self.reading => {
                    self.knobs = Some(Knobs::of(&facts));
                    self.facts = Some(*facts);
                    self.problem = None;
                }
                News::Read { .. } => {}
                News::Kernels { left, of, name } => {
                    self.kernels = (left > 0).then_some((left, of, name));
                }
                News::Shown(shown) => self.take(context, *shown),
                News::Problem { number, text } if number == self.number => {
                    if let Some(script) = &mut self.script {
                        script.fail(context, &text);
                    }
                    self.kernels = None;
                    self.problem = Some(text);
                }
                News::Problem { .. } => {}
            }
        }
        if !self.worker.is_alive() {
            self.problem = Some("the renderer has stopped: start the viewer again".to_owned());
            if let (Some(script), Some(text)) = (&mut self.script, &self.problem) {
                script.fail(context, text);
            }
        }
    }

    fn take(&mut self, context: &egui::Context, shown: Shown) {
        let load = |name: &str, image: &ColorImage| {
            context.load_texture(name, image.clone(), TextureOptions::LINEAR)
        };
        match &mut self.texture {
            Some(texture) => texture.set(shown.picture.clone(), TextureOptions::LINEAR),
            none => *none = Some(load("picture", &shown.picture)),
        }
        let insets = shown.insets.iter();
        self.insets = insets.map(|i| i.pictures.each_ref().map(|p| load(i.view, p))).collect();
        self.view = self.view.min(self.insets.len().saturating_sub(1));
        let pixels = shown.picture.pixels.len().max(1) as f64;
        self.pace = shown.ms / pixels * 1e6;
        self.problem = None;
        // A frame that keeps all maps has no counts and times of them.
        if shown.counters.views_rendered > 0 || self.counters.is_none() {
            self.counters = Some(shown.counters.clone());
            self.stages.clone_from(&shown.stages);
        }
        for &(stage, ms) in &shown.stages {
            match self.stages.iter_mut().find(|(known, _)| *known == stage) {
                Some((_, known)) => *known = ms,
                None => self.stages.push((stage, ms)),
            }
        }
        let is_last = shown.number == self.number;
        self.shown = Some(shown);
        if let (Some(script), Some(knobs), true) = (&mut self.script, &mut self.knobs, is_last)
            && let Some(turn) = script.next()
        {
            knobs.orbit.turn([turn * 2.0, 0.0]);
        }
    }

    /// Requests a picture if something has changed: at a lower resolution during the change, if the device
    /// is slow.
    fn ask(&mut self, context: &egui::Context) {
        let Some(knobs) = &self.knobs else { return };
        let full = (self.space.as_vec2() * self.scale).as_uvec2().max(UVec2::splat(16));
        let look = knobs.look(full);
        let same = |asked: &Look| {
            Look { camera: gobo::Camera { size: full, ..asked.camera }, ..asked.clone() } == look
        };
        let moved = !self.asked.as_ref().is_some_and(same);
        if moved {
            self.changed = Instant::now();
        }
        let rests = self.script.is_some() || self.shown.is_none() || self.changed.elapsed() >= REST;
        let look = if rests { look } else { knobs.look(full / self.coarseness(full)) };
        if self.asked.as_ref() == Some(&look) || !(moved || rests) {
            if !rests {
                context.request_repaint_after(REST);
            }
            return;
        }
        self.wish(Some(look));
        context.request_repaint_after(REST);
    }

    /// Pixels of the window, along an edge, per pixel of a picture that is rendered in time.
    fn coarseness(&self, size: UVec2) -> u32 {
        let ms = self.pace * f64::from(size.element_product()) / 1e6;
        match ms / PATIENCE_MS {
            0.0..1.0 => 1,
            1.0..4.0 => 2,
            4.0..9.0 => 3,
            _ => 4,
        }
    }

    fn show_picture(&mut self, ui: &mut egui::Ui) {
        let (response, painter) = ui.allocate_painter(ui.available_size(), egui::Sense::drag());
        let points = ui.ctx().pixels_per_point();
        let size = response.rect.size() * points;
        self.space = UVec2::new(size.x as u32, size.y as u32).max(UVec2::splat(16));
        if let Some(texture) = &self.texture {
            let all = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            painter.image(texture.id(), response.rect, all, Color32::WHITE);
        }
        let Some(knobs) = &mut self.knobs else { return };
        let drag = response.drag_delta() / response.rect.height().max(1.0);
        let with_shift = ui.input(|input| input.modifiers.shift);
        let turns = response.dragged_by(PointerButton::Primary) && !with_shift;
        // In the pass in which it starts, a drag includes earlier movement of the pointer.
        if response.dragged() && !response.drag_started() && drag != egui::Vec2::ZERO {
            if turns {
                knobs.orbit.turn([drag.x, drag.y]);
            } else {
                knobs.orbit.pan([drag.x, drag.y]);
            }
        }
        if response.contains_pointer() {
            let (scroll, pinch) =
                ui.input(|input| (input.smooth_scroll_delta().y, input.zoom_delta()));
            let factor = (scroll * 0.004).exp() * pinch;
            if factor != 1.0 {
                knobs.orbit.zoom(factor);
            }
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        self.hear(&context);
        let dropped = context
            .input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(file) = dropped {
            self.file = file;
            self.read();
        }
        egui::Panel::bottom("status").show(ui, |ui| panels::show_status(self, ui));
        egui::Panel::right("knobs").exact_size(300.0).show(ui, |ui| panels::show_knobs(self, ui));
        if self.knobs.as_ref().is_some_and(|knobs| knobs.insets) {
            egui::Panel::bottom("insets").show(ui, |ui| panels::show_insets(self, ui));
        }
        let frame = egui::Frame::new().fill(Color32::BLACK);
        egui::CentralPanel::default().frame(frame).show(ui, |ui| self.show_picture(ui));
        self.ask(&context);
        let picture = self.shown.as_ref().map(|shown| &shown.picture);
        if let Some(script) = &mut self.script {
            script.pass(&context, picture);
        }
    }
}

//! State of the window, and its requests to the renderer.
use super::{
    canvas,
    knobs::Knobs,
    panels,
    pick::Pick,
    request::{Facts, Look, News, Shown, Wish},
    script::Script,
    watch::{self, Watch},
    worker::Worker,
};
use crate::{arguments::ViewArguments, failure::Failure};
use eframe::egui::{
    self, Color32, ColorImage, FontId, PointerButton, TextureHandle, TextureOptions,
};
use gobo::{
    Counters,
    glam::{UVec2, Vec2},
};
use gobo_scene::LoadOptions;
use std::{
    path::PathBuf,
    sync::mpsc::Sender,
    time::{Duration, Instant},
};

/// Time budget of a picture while something changes [ms].
const PATIENCE_MS: f64 = 120.0;
/// Time without a change after which the picture is rendered at full resolution.
const REST: Duration = Duration::from_millis(250);

pub(super) struct App {
    worker: Worker,
    watch: Watch,
    file: PathBuf,
    load: LoadOptions,
    reading: u64,
    /// Properties of the scene that was read last.
    pub(super) facts: Option<Facts>,
    pub(super) knobs: Option<Knobs>,
    /// Pixels of the picture per pixel of the window, along an edge.
    pub(super) scale: f32,
    /// Size of the area for the picture [pixels].
    space: UVec2,
    asked: Option<Look>,
    number: u64,
    changed: Instant,
    pub(super) shown: Option<Shown>,
    /// Counters of the last picture for which maps were rendered.
    pub(super) counters: Option<Counters>,
    /// Stages, each with the time of its last run [ms].
    pub(super) stages: Vec<(&'static str, f64)>,
    /// Pictures on the screen, from the left.
    textures: Vec<TextureHandle>,
    pub(super) insets: Vec<[TextureHandle; 3]>,
    /// Index of the view whose insets are shown.
    pub(super) view: usize,
    /// Kernels left to compile, their total number, and the one being compiled.
    pub(super) kernels: Option<(usize, usize, &'static str)>,
    pub(super) device: String,
    /// Error of the file, until it is read.
    unread: Option<String>,
    /// Error of the last request.
    problem: Option<String>,
    /// Time per million pixels of a picture [ms].
    pace: f64,
    script: Option<Script>,
    /// Position to pick in the first picture that is laid out in the window, right and down, 0..1.
    to_pick: Option<Vec2>,
    /// Options of the first scene, until it is shown.
    start: Option<ViewArguments>,
}

impl App {
    pub(super) fn new(
        context: &egui::Context,
        arguments: ViewArguments,
        done: Sender<Result<(), Failure>>,
    ) -> Self {
        context.set_theme(egui::Theme::Dark);
        context.all_styles_mut(|style| {
            style.text_styles.insert(egui::TextStyle::Small, FontId::proportional(11.0));
        });
        let device = &arguments.device;
        let worker = Worker::start(context.clone(), device.backend(), device.adapter.clone());
        let mut load = LoadOptions::default();
        load.set.clone_from(&arguments.set);
        let mut app = Self {
            worker,
            watch: Watch::new(),
            file: arguments.scene.clone(),
            load,
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
            textures: Vec::new(),
            insets: Vec::new(),
            view: 0,
            kernels: None,
            device: String::new(),
            unread: None,
            problem: None,
            pace: 0.0,
            script: Script::of(&arguments, done),
            to_pick: None,
            start: Some(arguments),
        };
        app.read();
        app
    }

    /// Name of the file, for users.
    pub(super) fn name(&self) -> String {
        self.file.file_name().unwrap_or(self.file.as_os_str()).to_string_lossy().into_owned()
    }

    /// Reads the file, for the first time or again; until that is done, everything stays.
    pub(super) fn read(&mut self) {
        self.reading += 1;
        self.wish(self.asked.clone());
    }

    /// Opens another file.
    fn open(&mut self, file: PathBuf) {
        self.file = file;
        self.load = LoadOptions::default();
        self.watch = Watch::new();
        (self.knobs, self.facts, self.asked) = (None, None, None);
        (self.shown, self.counters, self.unread, self.problem) = (None, None, None, None);
        self.textures.clear();
        self.read();
    }

    /// The present error, if any.
    pub(super) fn problem(&self) -> Option<&str> {
        self.unread.as_deref().or(self.problem.as_deref())
    }

    fn wish(&mut self, look: Option<Look>) {
        self.number += 1;
        let (file, load, number) = (self.file.clone(), self.load.clone(), self.number);
        self.worker.wish(Wish { file, load, reading: self.reading, look: look.clone(), number });
        self.asked = look;
    }

    fn hear(&mut self, context: &egui::Context) {
        while let Ok(news) = self.worker.news.try_recv() {
            match news {
                News::Device(device) => self.device = device,
                News::Read { reading, facts } if reading == self.reading => self.take_facts(*facts),
                News::Unread { reading, text } if reading == self.reading => {
                    self.fail(context, &text);
                    tracing::info!("not read: {text}");
                    self.unread = Some(text);
                }
                News::Kernels { left, of, name } => {
                    self.kernels = (left > 0).then_some((left, of, name));
                }
                News::Shown(shown) => self.take(context, *shown),
                News::Problem { number, text } if number == self.number => {
                    self.fail(context, &text);
                    self.kernels = None;
                    self.problem = Some(text);
                }
                News::Read { .. } | News::Unread { .. } | News::Problem { .. } => {}
            }
        }
        if !self.worker.is_alive() {
            let text = "the renderer has stopped: start the viewer again";
            self.shown = None;
            self.fail(context, text);
            self.problem = Some(text.to_owned());
        }
    }

    /// A script continues after an error beside a picture, and ends after one without.
    fn fail(&mut self, context: &egui::Context, text: &str) {
        match &mut self.script {
            Some(script) if self.shown.is_none() => script.fail(context, text),
            Some(script) => drop(script.next()),
            None => {}
        }
    }

    fn take_facts(&mut self, facts: Facts) {
        let mut knobs = match (self.knobs.take(), &self.facts) {
            (Some(knobs), Some(before)) => knobs.again(before, &facts),
            _ => Knobs::of(&facts),
        };
        if let Some(start) = self.start.take() {
            knobs.beside = start.beside;
            if let Some(line) = &mut knobs.line {
                line.go_to(start.time);
                line.play(start.play);
            }
            if let &[x, y] = &start.pick[..] {
                self.to_pick = Some(Vec2::new(x, y).clamp(Vec2::ZERO, Vec2::ONE));
            }
        }
        tracing::info!("read {}", self.file.display());
        (self.knobs, self.facts, self.asked) = (Some(knobs), Some(facts), None);
        (self.unread, self.problem) = (None, None);
    }

    fn take(&mut self, context: &egui::Context, shown: Shown) {
        let load = |name: &str, image: &ColorImage| {
            context.load_texture(name, image.clone(), TextureOptions::LINEAR)
        };
        self.textures.truncate(shown.pictures.len());
        for (index, (_, picture)) in shown.pictures.iter().enumerate() {
            match self.textures.get_mut(index) {
                Some(texture) => texture.set(picture.clone(), TextureOptions::LINEAR),
                None => self.textures.push(load("picture", picture)),
            }
        }
        let insets = shown.insets.iter();
        self.insets = insets.map(|i| i.pictures.each_ref().map(|p| load(i.view, p))).collect();
        self.view = self.view.min(self.insets.len().saturating_sub(1));
        let pixels: usize = shown.pictures.iter().map(|(_, picture)| picture.pixels.len()).sum();
        let pixels = pixels.max(1) as f64;
        self.pace = shown.ms / pixels * 1e6;
        self.problem = None;
        // A frame that keeps all maps has no counts and times for them.
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
        let is_last = shown.number == self.number && self.to_pick.is_none();
        tracing::info!("shown in {:.0} ms", shown.ms);
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
        let full = self.size_of_a_picture(knobs);
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

    /// Size at full resolution [pixels].
    fn size_of_a_picture(&self, knobs: &Knobs) -> UVec2 {
        let share = if knobs.beside { Vec2::new(0.5, 1.0) } else { Vec2::ONE };
        (self.space.as_vec2() * share * self.scale).as_uvec2().max(UVec2::splat(16))
    }

    /// Pixels of the window per pixel of a picture that is rendered in time, along an edge.
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
        let (response, painter) =
            ui.allocate_painter(ui.available_size(), egui::Sense::click_and_drag());
        let points = ui.ctx().pixels_per_point();
        let size = response.rect.size() * points;
        self.space = UVec2::new(size.x as u32, size.y as u32).max(UVec2::splat(16));
        if let Some(shown) = &self.shown {
            let is_picked = self.knobs.as_ref().is_some_and(|knobs| knobs.pick.is_some());
            let marked = canvas::marked(shown).filter(|_| is_picked);
            canvas::paint(&painter, response.rect, &self.textures, shown, marked);
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
        if let (true, Some(pointer)) = (response.clicked(), response.interact_pointer_pos()) {
            let count = if knobs.beside { 2 } else { 1 };
            let parts = self.shown.as_ref().filter(|shown| shown.pictures.len() == count);
            let rects = (0..count).map(|index| canvas::part(response.rect, index, count));
            let under = rects.into_iter().find(|rect| rect.contains(pointer));
            if let (Some(shown), Some(rect)) = (parts, under) {
                let at = (pointer - rect.min) / rect.size();
                knobs.pick = Some(Pick { camera: shown.camera, at: Vec2::new(at.x, at.y) });
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

    /// A pass of the window.
    pub(super) fn pass(&mut self, ui: &mut egui::Ui) {
        let context = ui.ctx().clone();
        self.hear(&context);
        let dropped = context
            .input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(file) = dropped {
            self.open(file);
        }
        if self.watch.has_changed() {
            self.read();
        }
        context.request_repaint_after(watch::PERIOD);
        let is_answered = self.shown.as_ref().is_none_or(|shown| shown.number == self.number);
        if let Some(line) = self.knobs.as_mut().and_then(|knobs| knobs.line.as_mut())
            && line.plays()
        {
            // A slow device skips moments instead of falling behind.
            if is_answered {
                line.go_on(Instant::now());
            }
            context.request_repaint();
        }
        egui::Panel::bottom("status").show(ui, |ui| panels::show_status(self, ui));
        egui::Panel::right("knobs").exact_size(300.0).show(ui, |ui| panels::show_knobs(self, ui));
        if self.knobs.as_ref().is_some_and(|knobs| knobs.insets) {
            egui::Panel::bottom("insets").show(ui, |ui| panels::show_insets(self, ui));
        }
        if let Some(line) = self.knobs.as_mut().and_then(|knobs| knobs.line.as_mut()) {
            egui::Panel::bottom("time").show(ui, |ui| line.show(ui));
        }
        let frame = egui::Frame::new().fill(Color32::BLACK);
        egui::CentralPanel::default().frame(frame).show(ui, |ui| self.show_picture(ui));
        self.ask(&context);
        let is_shown = self.shown.as_ref().is_some_and(|shown| shown.number == self.number);
        if let (true, Some(shown), Some(knobs)) = (is_shown, &self.shown, &mut self.knobs)
            && let Some(at) = self.to_pick.take()
        {
            knobs.pick = Some(Pick { camera: shown.camera, at });
            context.request_repaint();
        }
        let shown = self.shown.as_ref().and_then(|shown| shown.pictures.first());
        if let Some(script) = &mut self.script {
            script.pass(&context, shown.map(|(_, picture)| picture));
        }
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut egui::Ui, _: &mut eframe::Frame) {
        self.pass(ui);
    }
}

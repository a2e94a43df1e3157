//! The window without a screen: its passes, with the CPU reference.
use super::{app::App, pick::place, watch};
use crate::arguments::{Arguments, Command, ViewArguments};
use clap::Parser as _;
use eframe::egui::{self, Event, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};
use gobo::{
    Receiver,
    glam::{Vec2, Vec3},
};
use std::{
    fs,
    path::PathBuf,
    sync::{Mutex, MutexGuard, PoisonError, mpsc::channel},
    time::{Duration, Instant},
};

/// A floor under half of a red pane, whose edge is at x = 0, and a lamp straight above; `{}` stands for its
/// intensity.
const SCENE: &str = r#"
[camera]
eye = [0, 6, 0.01]
target = [0, 0, 0]
fov_y = 60
size = [64, 64]
[shadow]
size = 64
[[light]]
name = "sun"
kind = "directional"
direction = [0, -1, 0]
intensity = {}
[[material]]
name = "ground"
transfer = "opaque"
[[material]]
name = "glass"
transfer = "filter"
tint = [1, 0.25, 0.25, 1]
[[shape]]
kind = "plane"
material = "ground"
scale = [4, 1, 4]
[[shape]]
kind = "pane"
material = "glass"
translation = [1, 1, 0]
rotation = [90, 0, 0]
scale = [2, 2, 1]
"#;

struct Window {
    context: egui::Context,
    app: App,
    events: Vec<Event>,
    folder: PathBuf,
    _alone: MutexGuard<'static, ()>,
}

/// The list of read files is the process's: one window at a time.
static ALONE: Mutex<()> = Mutex::new(());

impl Window {
    fn new(name: &str, arguments: &[&str]) -> Self {
        let _alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        gobo_scene::watch_files(watch::note);
        let folder = std::env::temp_dir().join(format!("gobo-view-{name}-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let file = folder.join("scene.toml");
        fs::write(&file, SCENE.replace("{}", "1")).unwrap();
        let all = ["gobo", "view", "--backend", "cpu", file.to_str().unwrap()];
        let parsed = Arguments::try_parse_from(all.iter().chain(arguments)).unwrap();
        let Command::View(arguments) = parsed.command else { panic!("{parsed:?}") };
        let context = egui::Context::default();
        let app = Self::app(&context, arguments);
        Self { context, app, events: Vec::new(), folder, _alone }
    }

    fn app(context: &egui::Context, arguments: ViewArguments) -> App {
        let (done, _) = channel();
        App::new(context, arguments, done)
    }

    fn write(&self, text: &str) {
        fs::write(self.folder.join("scene.toml"), text).unwrap();
    }

    fn pass(&mut self) {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(800.0, 600.0)));
        let events = std::mem::take(&mut self.events);
        let input = RawInput { screen_rect, events, ..RawInput::default() };
        let app = &mut self.app;
        let _ = self.context.run_ui(input, |ui| app.pass(ui));
    }

    /// Runs passes until a condition holds.
    fn until(&mut self, what: &str, is_so: impl Fn(&App) -> bool) {
        let start = Instant::now();
        while !is_so(&self.app) {
            let (problem, knobs) = (self.app.problem(), self.app.knobs.as_ref());
            let picked = self.app.shown.as_ref().map(|shown| shown.picked.clone());
            let pick = knobs.and_then(|knobs| knobs.pick);
            let is_late = start.elapsed() > Duration::from_secs(60);
            assert!(!is_late, "{what}: {problem:?}, {pick:?}, {picked:?}");
            self.pass();
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    fn until_shown(&mut self) {
        self.until("a picture", |app| app.shown.is_some());
    }

    fn click(&mut self, at: Pos2) {
        self.events.push(Event::PointerMoved(at));
        self.pass();
        for pressed in [true, false] {
            let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
            self.events.push(Event::PointerButton { pos: at, button, pressed, modifiers });
            self.pass();
        }
    }

    fn pixels(&self) -> Vec<egui::Color32> {
        self.app.shown.as_ref().unwrap().pictures[0].1.pixels.clone()
    }
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[test]
fn files_that_change_are_shown_and_broken_ones_leave_the_picture() {
    let mut window = Window::new("watched", &[]);
    window.until_shown();
    let first = window.pixels();
    window.write("[camera]\nsize = \"large\"\n");
    window.until("an error", |app| app.problem().is_some());
    let text = window.app.problem().unwrap().to_owned();
    assert!(text.contains("scene.toml:2:8") && text.contains('^'), "{text}");
    // The message takes some of its space.
    let is_red = |pixel: &egui::Color32| u16::from(pixel.r()) > 2 * u16::from(pixel.g());
    assert!(first.iter().any(is_red) && window.pixels().iter().any(is_red));
    // It can still be turned.
    let number = |app: &App| app.shown.as_ref().unwrap().number;
    let before = number(&window.app);
    window.app.knobs.as_mut().unwrap().orbit.turn([0.1, 0.0]);
    window.until("a turned picture", |app| number(app) > before);
    assert!(window.pixels().iter().any(is_red));
    assert_eq!(window.app.problem(), Some(&*text));
    let turned = window.app.knobs.as_ref().unwrap().orbit;
    // Mended, and darker: the rotation stays.
    window.write(&SCENE.replace("{}", "0.25"));
    window.until("the file again", |app| {
        app.problem().is_none() && app.facts.as_ref().unwrap().lights[0].intensity < 1.0
    });
    assert_eq!(window.app.knobs.as_ref().unwrap().orbit, turned);
    let before = number(&window.app);
    window.until("the darker picture", |app| number(app) > before);
    let sum = |pixels: &[egui::Color32]| pixels.iter().map(|p| u64::from(p.g())).sum::<u64>();
    let mean = |pixels: &[egui::Color32]| sum(pixels) / pixels.len() as u64;
    assert!(mean(&window.pixels()) < mean(&first));
}

/// Behind the pane a quarter of green and blue is left; beside it everything.
#[test]
fn a_picked_pixel_has_each_lights_share_by_both_receivers() {
    let mut window = Window::new("picked", &["--beside"]);
    window.until("both pictures", |app| {
        app.shown.as_ref().is_some_and(|shown| shown.pictures.len() == 2)
    });
    let shown = window.app.shown.as_ref().unwrap();
    let names: Vec<_> = shown.pictures.iter().map(|(receiver, _)| *receiver).collect();
    assert_eq!(names, [Receiver::Nearest, Receiver::Curve]);
    assert_eq!(shown.pictures[0].1.size, shown.pictures[1].1.size);
    // Points in the right picture, beside its middle, which is some 360 points from the left.
    for (x, expected) in [(300.0, Vec3::ONE), (440.0, Vec3::new(1.0, 0.25, 0.25))] {
        window.click(pos2(x, 200.0));
        window.until("an answer", |app| {
            let pick = app.knobs.as_ref().unwrap().pick;
            let shown = app.shown.as_ref().unwrap();
            pick.is_some()
                && shown.picked.as_ref().is_some_and(|picked| {
                    picked.surface.is_some_and(|[_, at]| (at.x < 0.0) == (x < 360.0))
                })
        });
        let picked = window.app.shown.as_ref().unwrap().picked.clone().unwrap();
        assert_eq!(picked.shares.len(), 2);
        for shares in &picked.shares {
            let share = Vec3::from(shares[0]);
            assert!(share.distance(expected) < 0.02, "{x}: {picked:?}");
        }
        let [_, at] = picked.surface.unwrap();
        assert!(at.y.abs() < 1e-3, "{at}");
    }
}

#[test]
fn a_place_that_is_given_is_picked_in_the_picture_as_it_is_in_the_window() {
    let mut window = Window::new("given", &["--pick", "0.6", "0.5"]);
    let point = |app: &App| app.shown.as_ref()?.picked.as_ref()?.surface.map(|[at, _]| at);
    window.until("an answer", |app| point(app).is_some());
    let found = point(&window.app).unwrap();
    let at = place(&window.app.shown.as_ref().unwrap().camera, found).unwrap();
    assert!(at.distance(Vec2::new(0.6, 0.5)) < 0.01, "{at}");
}

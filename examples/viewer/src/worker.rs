//! The renderer, with its own thread and device, so that the window never waits for it.
use crate::inset::Inset;
use eframe::egui::{self, ColorImage};
use gobo::{Bounds, Camera, Counters, KernelJob, Light, RenderOptions, Renderer, Scene, ShadowSettings, host::Backend, scene};
use std::{
    collections::BTreeMap,
    path::PathBuf,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread::{self, JoinHandle},
    time::Instant,
};

/// Overrides of a scene file's values.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    pub camera: Camera,
    /// Exposure [stops].
    pub exposure: f32,
    pub shadow: ShadowSettings,
    /// Lights that were changed, by index.
    pub lights: BTreeMap<usize, Light>,
    /// Time of the animation [s].
    pub time: f64,
    /// Light whose maps are read back.
    pub maps_of: Option<usize>,
}

/// Request for a picture. A later one replaces one that has not been started.
#[derive(Clone, Debug)]
pub struct Wish {
    pub file: PathBuf,
    /// Number of the reading: the file is read again if it is new.
    pub reading: u64,
    /// Overrides; none for the values of the file.
    pub look: Option<Look>,
    /// Number that returns with the picture.
    pub number: u64,
}

/// Properties of a scene that the window needs.
#[derive(Clone, Debug)]
pub struct Facts {
    pub camera: Camera,
    pub exposure: f32,
    pub shadow: ShadowSettings,
    pub lights: Vec<Light>,
    pub bounds: Bounds,
    /// Whether part of the scene is animated.
    pub moves: bool,
    pub particles: usize,
    pub triangles: usize,
    /// Remarks about the scene, a sentence each.
    pub notes: Vec<String>,
}

/// A picture and its costs.
#[derive(Clone)]
pub struct Shown {
    pub number: u64,
    pub picture: ColorImage,
    pub insets: Vec<Inset>,
    pub counters: Counters,
    /// Time of each stage [ms].
    pub stages: Vec<(&'static str, f64)>,
    /// Memory on the device [bytes].
    pub memory: u64,
    /// Time from the request to the picture [ms].
    pub ms: f64,
}

pub enum News {
    Device(String),
    Read {
        reading: u64,
        facts: Box<Facts>,
    },
    /// Kernels left to compile, their total number, and the one being compiled.
    Kernels {
        left: usize,
        of: usize,
        name: &'static str,
    },
    Shown(Box<Shown>),
    Problem {
        number: u64,
        text: String,
    },
}

#[derive(Default)]
struct Mail {
    wish: Option<Wish>,
    is_over: bool,
}

type Mailbox = Arc<(Mutex<Mail>, Condvar)>;

fn lock(mailbox: &Mailbox) -> MutexGuard<'_, Mail> {
    mailbox.0.lock().unwrap_or_else(PoisonError::into_inner)
}

pub struct Worker {
    mailbox: Mailbox,
    pub news: Receiver<News>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    pub fn start(context: egui::Context, backend: Backend, adapter: Option<String>) -> Self {
        let mailbox = Mailbox::default();
        let (sender, news) = channel();
        let post = Post { sender, context };
        let theirs = Arc::clone(&mailbox);
        let thread = thread::spawn(move || {
            let (renderer, scene, posed, made_for) = (None, None, None, None);
            Bench { post, backend, adapter, renderer, scene, posed, made_for }.work(&theirs);
        });
        Self { mailbox, news, thread: Some(thread) }
    }

    pub fn wish(&self, wish: Wish) {
        lock(&self.mailbox).wish = Some(wish);
        self.mailbox.1.notify_one();
    }

    /// Whether the thread is running.
    pub fn is_alive(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        lock(&self.mailbox).is_over = true;
        self.mailbox.1.notify_one();
        if let Some(thread) = self.thread.take() {
            // A thread that failed has reported its error.
            let _ = thread.join();
        }
    }
}

struct Post {
    sender: Sender<News>,
    context: egui::Context,
}

impl Post {
    fn send(&self, news: News) {
        // Nothing is received after the window has been closed.
        let _ = self.sender.send(news);
        self.context.request_repaint();
    }
}

struct Bench {
    post: Post,
    backend: Backend,
    adapter: Option<String>,
    renderer: Option<Renderer>,
    /// The scene as read, and the number of its reading.
    scene: Option<(u64, Scene)>,
    /// Reading and time to which the animation is set.
    posed: Option<(u64, f64)>,
    /// Reading, nodes and filter for which kernels were compiled.
    made_for: Option<(u64, u32, gobo::model::ShadowFilter)>,
}

impl Bench {
    fn work(mut self, mailbox: &Mailbox) {
        loop {
            let mut mail = lock(mailbox);
            while mail.wish.is_none() && !mail.is_over {
                mail = mailbox.1.wait(mail).unwrap_or_else(PoisonError::into_inner);
            }
            if mail.is_over {
                return;
            }
            let wish = mail.wish.take();
            drop(mail);
            let Some(wish) = wish else { continue };
            match self.show(&wish) {
                Ok(Some(shown)) => self.post.send(News::Shown(Box::new(shown))),
                Ok(None) => {}
                Err(text) => self.post.send(News::Problem { number: wish.number, text }),
            }
        }
    }

    fn show(&mut self, wish: &Wish) -> Result<Option<Shown>, String> {
        let start = Instant::now();
        let text = |error: &dyn std::fmt::Display| error.to_string();
        if self.scene.as_ref().is_none_or(|(reading, _)| *reading != wish.reading) {
            self.scene = None;
            let scene = scene::load(&wish.file).map_err(|error| text(&error))?;
            let facts = Box::new(Facts::of(&scene));
            self.post.send(News::Read { reading: wish.reading, facts });
            self.scene = Some((wish.reading, scene));
        }
        let (Some((reading, scene)), Some(look)) = (&mut self.scene, &wish.look) else {
            return Ok(None);
        };
        if !scene.motions.is_empty() && self.posed != Some((*reading, look.time)) {
            scene.set_time(look.time);
            self.posed = Some((*reading, look.time));
        }
        take_over(scene, look);
        let renderer = match &mut self.renderer {
            Some(renderer) => renderer,
            none => {
                let adapter = self.adapter.as_deref();
                let opened = Renderer::new(self.backend, adapter).map_err(|e| text(&e))?;
                self.post.send(News::Device(opened.device()));
                none.insert(opened)
            }
        };
        let made_for = Some((*reading, look.shadow.curve_nodes(), look.shadow.filter));
        if self.made_for != made_for {
            let jobs = renderer.pending(scene).map_err(|error| text(&error))?;
            make(&self.post, &jobs);
            self.made_for = made_for;
        }
        let maps = look.maps_of.is_some();
        let options =
            RenderOptions { maps, maps_of: look.maps_of, keep: true, ..Default::default() };
        let frame = renderer.render(scene, &options).map_err(|error| {
            // The next request opens a new device.
            self.renderer = None;
            self.made_for = None;
            text(&error)
        })?;
        let size = frame.picture.size.to_array().map(|edge| edge as usize);
        Ok(Some(Shown {
            number: wish.number,
            picture: ColorImage::from_rgb(size, frame.picture.rgb.as_flattened()),
            insets: frame.maps.iter().map(Inset::of).collect(),
            counters: frame.counters,
            stages: frame.stages,
            memory: frame.memory.iter().map(|(_, bytes)| bytes).sum(),
            ms: start.elapsed().as_secs_f64() * 1e3,
        }))
    }
}

fn take_over(scene: &mut Scene, look: &Look) {
    scene.camera = look.camera;
    scene.exposure = look.exposure;
    scene.shadow = look.shadow;
    for (&index, light) in &look.lights {
        if let Some(own) = scene.lights.get_mut(index) {
            own.clone_from(light);
        }
    }
}

/// Compiles kernels on all cores and reports progress. A kernel that the device refuses is an error of the
/// frame that needs it.
fn make(post: &Post, jobs: &[KernelJob]) {
    let (next, left) = (AtomicUsize::new(0), AtomicUsize::new(jobs.len()));
    let of = jobs.len();
    let work = || {
        while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let name = job.name();
            post.send(News::Kernels { left: left.load(Ordering::Relaxed), of, name });
            let _ = job.run();
            left.fetch_sub(1, Ordering::Relaxed);
        }
    };
    let cores = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    thread::scope(|scope| {
        (1..cores.min(of)).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    post.send(News::Kernels { left: 0, of, name: "" });
}

impl Facts {
    fn of(scene: &Scene) -> Self {
        let skipped = scene.skipped.iter().map(|(why, count)| format!("{count} left out: {why}"));
        Self {
            camera: scene.camera,
            exposure: scene.exposure,
            shadow: scene.shadow,
            lights: scene.lights.clone(),
            bounds: scene.bounds(),
            moves: !scene.motions.is_empty(),
            particles: scene.particles.len(),
            triangles: scene.triangles.len(),
            notes: scene.notes.iter().cloned().chain(skipped).collect(),
        }
    }
}

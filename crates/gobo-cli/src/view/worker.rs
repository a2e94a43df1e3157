//! The renderer, with its own thread and devices, so that the window never waits for it.
use super::{
    inset::Inset,
    pick::Pick,
    request::{Facts, Look, News, Picked, Shown, Wish},
};
use crate::{failure::Failure, memory::Needs};
use eframe::egui::{self, ColorImage};
use gobo::{
    KernelJob, Receiver as Reads, Scene,
    host::Backend,
    model::{ReceiverPoint, ShadowFilter},
};
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene as scene;
use std::{
    path::PathBuf,
    sync::{
        Arc, Condvar, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicUsize, Ordering},
        mpsc::{Receiver, Sender, channel},
    },
    thread::{self, JoinHandle},
    time::Instant,
};

#[derive(Default)]
struct Mail {
    wish: Option<Wish>,
    is_over: bool,
}

type Mailbox = Arc<(Mutex<Mail>, Condvar)>;

fn lock(mailbox: &Mailbox) -> MutexGuard<'_, Mail> {
    mailbox.0.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) struct Worker {
    mailbox: Mailbox,
    pub(super) news: Receiver<News>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    pub(super) fn start(context: egui::Context, backend: Backend, adapter: Option<String>) -> Self {
        let mailbox = Mailbox::default();
        let (sender, news) = channel();
        let post = Post { sender, context };
        let theirs = Arc::clone(&mailbox);
        let thread = thread::spawn(move || {
            ViewWorker::new(post, backend, adapter).work(&theirs);
        });
        Self { mailbox, news, thread: Some(thread) }
    }

    pub(super) fn wish(&self, wish: Wish) {
        lock(&self.mailbox).wish = Some(wish);
        self.mailbox.1.notify_one();
    }

    /// Whether the thread is running.
    pub(super) fn is_alive(&self) -> bool {
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

/// A device, and the state that it is prepared for.
struct Stand {
    renderer: Renderer,
    /// Reading, nodes and filter for which kernels were compiled.
    made_for: Option<(u64, u32, ShadowFilter)>,
}

/// A frame of each receiver.
type ReceiverFrames = Vec<(Reads, Frame)>;

/// Key of the answer at a picked pixel.
type Asked = (u64, Look);

struct ViewWorker {
    post: Post,
    backend: Backend,
    adapter: Option<String>,
    /// One stand per receiver, so that the maps of both stay; opened on demand.
    stands: [Option<Stand>; 2],
    /// Number of the last reading, and the file.
    read: Option<(u64, PathBuf)>,
    /// The last scene that could be read.
    scene: Option<Scene>,
    /// Reading and time at which the animation is posed.
    posed: Option<(u64, f64)>,
    picked: Option<(Asked, Picked)>,
}

/// Index of a receiver's stand.
fn stand(reads: Reads) -> usize {
    match reads {
        Reads::Nearest => 0,
        Reads::Curve => 1,
    }
}

impl ViewWorker {
    fn new(post: Post, backend: Backend, adapter: Option<String>) -> Self {
        let (stands, read, scene, posed, picked) = Default::default();
        Self { post, backend, adapter, stands, read, scene, posed, picked }
    }

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
                Err(failure) => {
                    let text = failure.explained();
                    self.post.send(News::Problem { number: wish.number, text });
                }
            }
        }
    }

    /// Reads the file, unless that was done. If it cannot be read, the last scene stays.
    fn read(&mut self, wish: &Wish) {
        let reading = wish.reading;
        if self.read.as_ref().is_some_and(|(known, _)| *known == reading) {
            return;
        }
        if self.read.as_ref().is_some_and(|(_, file)| *file != wish.file) {
            self.scene = None;
        }
        self.read = Some((reading, wish.file.clone()));
        let pixels = Needs { maps: true, picture: true, ..Needs::of(self.backend) };
        let read = scene::load_as(&wish.file, &wish.load).map_err(Failure::from);
        match read.and_then(|scene| pixels.check(&scene).map(|()| scene)) {
            Ok(scene) => {
                let facts = Box::new(Facts::of(&scene));
                self.post.send(News::Read { reading, facts });
                (self.scene, self.posed, self.picked) = (Some(scene), None, None);
            }
            Err(failure) => {
                self.post.send(News::Unread { reading, text: failure.explained() });
            }
        }
    }

    fn show(&mut self, wish: &Wish) -> Result<Option<Shown>, Failure> {
        let start = Instant::now();
        self.read(wish);
        let Some(look) = &wish.look else { return Ok(None) };
        let Some(mut scene) = self.scene.take() else { return Ok(None) };
        let shown = self.show_scene(&mut scene, look, wish.reading);
        self.scene = Some(scene);
        let (frames, picked) = shown?;
        let mut shown = Shown {
            number: wish.number,
            camera: look.camera,
            pictures: Vec::new(),
            insets: Vec::new(),
            counters: Default::default(),
            stages: Vec::new(),
            memory: 0,
            ms: start.elapsed().as_secs_f64() * 1e3,
            picked,
        };
        for (reads, frame) in frames {
            let size = frame.picture.size.to_array().map(|edge| edge as usize);
            let picture = ColorImage::from_rgb(size, frame.picture.rgb.as_flattened());
            shown.pictures.push((reads, picture));
            shown.memory += frame.memory.iter().map(|(_, bytes)| bytes).sum::<u64>();
            if reads == look.shadow.receiver {
                shown.insets = frame.maps.iter().map(Inset::of).collect();
                (shown.counters, shown.stages) = (frame.counters, frame.stages);
            }
        }
        Ok(Some(shown))
    }

    /// A frame of each receiver, and the picked surface.
    fn show_scene(
        &mut self,
        scene: &mut Scene,
        look: &Look,
        reading: u64,
    ) -> Result<(ReceiverFrames, Option<Picked>), Failure> {
        if !scene.motions.is_empty() && self.posed != Some((reading, look.time)) {
            scene.set_time(look.time);
            self.posed = Some((reading, look.time));
        }
        take_over(scene, look);
        let mut frames = Vec::new();
        for reads in look.receivers() {
            scene.shadow.receiver = reads;
            let maps_of = look.maps_of.filter(|_| reads == look.shadow.receiver);
            let maps = maps_of.is_some();
            let options = RenderOptions { maps, maps_of, keep: true, ..Default::default() };
            self.make(scene, reads, reading)?;
            let renderer = self.renderer(reads)?;
            let frame = renderer.render(scene, &options);
            frames.push((reads, self.or_close(reads, frame)?));
        }
        let picked = match look.pick {
            Some(pick) => Some(self.picked(scene, look, pick, reading)?),
            None => None,
        };
        Ok((frames, picked))
    }

    fn renderer(&mut self, reads: Reads) -> Result<&mut Renderer, Failure> {
        let place = &mut self.stands[stand(reads)];
        let open = match place {
            Some(open) => open,
            none => {
                let renderer = Renderer::new(self.backend, self.adapter.as_deref())?;
                self.post.send(News::Device(renderer.device()));
                none.insert(Stand { renderer, made_for: None })
            }
        };
        Ok(&mut open.renderer)
    }

    /// Closes the device after an error: the next request opens a new one.
    fn or_close<T>(&mut self, reads: Reads, result: Result<T, gobo::Error>) -> Result<T, Failure> {
        if result.is_err() {
            self.stands[stand(reads)] = None;
        }
        Ok(result?)
    }

    /// Compiles the kernels of the scene's frame.
    fn make(&mut self, scene: &Scene, reads: Reads, reading: u64) -> Result<(), Failure> {
        let made_for = Some((reading, scene.shadow.curve_nodes(), scene.shadow.filter));
        let is_made = |stand: &Stand| stand.made_for == made_for;
        if self.stands[stand(reads)].as_ref().is_some_and(is_made) {
            return Ok(());
        }
        let renderer = self.renderer(reads)?;
        let jobs = renderer.pending(scene);
        let jobs = self.or_close(reads, jobs)?;
        make(&self.post, &jobs);
        if let Some(stand) = &mut self.stands[stand(reads)] {
            stand.made_for = made_for;
        }
        Ok(())
    }

    /// The surface at a picked pixel, and the light that reaches it.
    fn picked(
        &mut self,
        scene: &mut Scene,
        look: &Look,
        pick: Pick,
        reading: u64,
    ) -> Result<Picked, Failure> {
        // The camera may turn without changing the answer.
        let camera = pick.camera;
        let asked = (reading, Look { camera, exposure: 0.0, maps_of: None, ..look.clone() });
        if let Some((known, picked)) = &self.picked
            && *known == asked
        {
            return Ok(picked.clone());
        }
        let surface = pick.surface(scene);
        let mut picked = Picked::default();
        if let Some(surface) = surface {
            let position = surface.position + scene.origin;
            picked.surface = Some([surface.position, position]);
            let point = ReceiverPoint { position, normal: surface.normal };
            for reads in look.receivers() {
                scene.shadow.receiver = reads;
                let shares = self.renderer(reads)?.light_points(scene, &[point]);
                picked.shares.push(self.or_close(reads, shares)?);
            }
        }
        self.picked = Some((asked, picked.clone()));
        Ok(picked)
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

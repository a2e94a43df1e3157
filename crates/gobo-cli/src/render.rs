//! `gobo render`: frames, maps, and their costs.
use super::{
    arguments::RenderArguments,
    claim::{self, Claim},
    curves::{self, Take},
    exr::{self, Channel},
    failure::Failure,
    files, inputs, layers, maps,
    memory::Needs,
    output::{self, Fill},
    preview::Preview,
    report::{json, kept_json},
    sidecar::{self, FrameFiles, Sidecar},
    stop,
    values::SimulationName,
    wall_clock::WallClock,
};
use gobo::{gpu::Backend, model::Skipped, records::Picture};
use gobo_picture::{Frame, RenderOptions, Renderer};
use gobo_scene as scene;
use image::{DynamicImage, RgbImage};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};

/// Least time of a frame of the CPU reference that is announced [s].
const LONG: f64 = 10.0;

pub(crate) fn run(arguments: &RenderArguments, clock: &WallClock) -> Result<(), Failure> {
    check(arguments)?;
    let mut load = scene::LoadOptions::default();
    load.set.clone_from(&arguments.set);
    load.ground = !arguments.no_ground;
    load.start = false;
    let mut scene = scene::load_as(&arguments.scene, &load)?;
    files::warn(&scene.notes);
    // A picture beside maps is made from them.
    scene.shadow.detail &= !arguments.maps;
    let pixels = u64::from(scene.camera.size.element_product());
    // The CPU reference makes the layers.
    let backend_is_cpu = arguments.layers || arguments.device.backend() == Backend::Cpu;
    let points = if arguments.layers { pixels } else { 0 };
    Needs { maps: arguments.maps, picture: true, points, backend_is_cpu }.check(&scene)?;
    let renderer = arguments.device.renderer()?;
    if !arguments.layers {
        leave_to_device(&mut scene, &renderer, arguments.simulation);
    }
    let inputs = arguments.skip_existing.then(|| sidecar::inputs(&mut scene, arguments));
    let debug = arguments.debug();
    let options = RenderOptions {
        maps: arguments.maps,
        // Layers are made of further maps.
        curves_stay: !arguments.layers,
        keep: true,
        light: arguments.exr,
        debug: &debug,
        ..RenderOptions::default()
    };
    tracing::info!("rendering with {}", renderer.device());
    if arguments.layers && scene.shutter > 0.0 && scene.samples > 1 {
        let help = "--set camera.shutter=0, or leave --layers out";
        return Err(Failure::refused(&arguments.scene, "layers have no open shutter", help));
    }
    let is_named = arguments.maps || arguments.layers;
    let light_names = if is_named { maps::light_names(&scene.lights) } else { Vec::new() };
    let all = arguments.all_frames();
    inputs::check_folder(&arguments.out, |name| sidecar::is_of_frames(name, &all))?;
    files::create_dir(&arguments.out)?;
    if let Some(path) = &arguments.preview {
        Preview::check(path, &arguments.out)?;
    }
    stop::begin_job();
    let frames = arguments.frames();
    let (size, fps) = (scene.camera.size, arguments.fps);
    let preview = |path| Preview::new(path, size, frames.len(), fps);
    let preview = arguments.preview.as_deref().map(preview).transpose()?;
    let strays = files::temporaries(&arguments.out, "frame_");
    let progress = progress_bar(frames.len() as u64);
    let counts = Counts { skipped: scene.skipped.clone(), ..Counts::default() };
    let mut job = Job {
        arguments,
        clock,
        scene,
        renderer,
        options,
        light_names,
        inputs,
        strays,
        preview,
        progress,
        counts,
        is_announced: false,
    };
    // A preview needs its frames in order.
    let may_wait = arguments.preview.is_some();
    let mut others = Vec::new();
    for index in frames {
        if !job.frame(index, may_wait)? {
            others.push(index);
        }
    }
    // Frames of other processes: done by now, or left by a killed one.
    for index in others {
        job.frame(index, true)?;
    }
    job.finish()
}

/// Refuses options that exclude each other.
fn check(arguments: &RenderArguments) -> Result<(), Failure> {
    let is_on_cpu = arguments.device.backend() == Backend::Cpu;
    let simulates_on_device = arguments.simulation == SimulationName::Device;
    let is_scene_file = arguments.scene.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml"));
    let message = if is_on_cpu && !arguments.debug().is_empty() {
        "--debug needs an adapter: leave --backend cpu out"
    } else if is_on_cpu && simulates_on_device {
        "--simulation device needs an adapter: leave --backend cpu out"
    } else if arguments.layers && simulates_on_device {
        "--layers needs particles on the CPU: leave --simulation device out"
    } else if arguments.no_ground && is_scene_file {
        "--no-ground is for models and particle files: remove it, or the shape that is the ground of the \
         scene file"
    } else {
        return Ok(());
    };
    Err(Failure::Usage(message.to_owned()))
}

/// Counts for the warnings at the end of a job.
#[derive(Default)]
struct Counts {
    shrunk: u64,
    nodes_dropped: u64,
    unmasked: u64,
    /// The most of any frame.
    skipped: Skipped,
}

struct Job<'a> {
    arguments: &'a RenderArguments,
    clock: &'a WallClock,
    scene: scene::Scene,
    renderer: Renderer,
    options: RenderOptions<'a>,
    light_names: Vec<String>,
    /// Digest of the inputs, for sidecars.
    inputs: Option<String>,
    /// Temporary files of frames from before this run.
    strays: Vec<PathBuf>,
    preview: Option<Preview>,
    progress: ProgressBar,
    counts: Counts,
    /// Whether the time per frame has been announced.
    is_announced: bool,
}

impl Job<'_> {
    /// Renders a frame, unless it exists already. Returns whether it exists now: not if another process
    /// writes it and `may_wait` is false.
    fn frame(&mut self, index: u32, may_wait: bool) -> Result<bool, Failure> {
        if stop::is_stopped() {
            return Err(Failure::Stopped { frame: index });
        }
        if self.keeps(index)? {
            // Its writer may have been killed between the last file and the removal of its claim.
            if Claim::is_left(&self.arguments.out, &sidecar::stem(index)) {
                drop(self.claim(index)?);
            }
            return Ok(true);
        }
        // With sidecars one process renders a frame, and all others go on; without them each process renders
        // it.
        let mut claim = None;
        if self.inputs.is_some() {
            claim = if may_wait { Some(self.wait(index)?) } else { self.claim(index)? };
            if claim.is_none() {
                return Ok(false);
            }
            if self.keeps(index)? {
                return Ok(true);
            }
        }
        let step = 1.0 / self.arguments.fps;
        let seconds = f64::from(index) / self.arguments.fps;
        self.announce(seconds);
        let frame = self.renderer.render_at(&mut self.scene, seconds, step, &self.options)?;
        self.counts.shrunk = self.counts.shrunk.max(frame.counters.shrunk);
        self.counts.nodes_dropped = self.counts.nodes_dropped.max(frame.counters.nodes_dropped);
        self.counts.unmasked = self.counts.unmasked.max(frame.counters.unmasked_lights);
        for (reason, &count) in &frame.counters.skipped {
            let most = self.counts.skipped.entry(reason).or_default();
            *most = count.max(*most);
        }
        let layers = if self.arguments.layers {
            self.layers(&frame.picture.light, seconds + step)?
        } else {
            Vec::new()
        };
        let claim = claim.map_or_else(|| self.wait(index), Ok)?;
        {
            let _writing = tracing::debug_span!("write").entered();
            self.write(index, &frame, &layers, &claim)?;
            if let Some(preview) = &mut self.preview {
                preview.add(&frame.picture)?;
            }
        }
        self.report(index, |picture| {
            json(index, picture, &frame, &self.scene.soft, &self.clock.take())
        })?;
        Ok(true)
    }

    /// Announces the CPU reference's time before the first frame, which is at a time [s].
    fn announce(&mut self, seconds: f64) {
        if std::mem::replace(&mut self.is_announced, true) || self.renderer.has_device() {
            return;
        }
        if !self.scene.motions.is_empty() {
            self.scene.set_time(seconds);
        }
        let _estimating = tracing::debug_span!("prepare").entered();
        let Some(estimate) = self.renderer.estimate(&self.scene) else { return };
        tracing::info!("the CPU reference: an estimate of {estimate:.2} s a frame");
        if estimate >= LONG {
            let time = match estimate {
                0.0..100.0 => format!("{estimate:.0} s"),
                100.0..6000.0 => format!("{:.0} min", estimate / 60.0),
                _ => format!("{:.0} h", estimate / 3600.0),
            };
            tracing::warn!(
                "the CPU reference will take about {time} a frame: fewer samples, smaller maps and \
                 lights without a \
                 source take less"
            );
        }
    }

    /// Layers of the rendered frame; `whole`: its light, `next`: the time of the next frame [s].
    fn layers(&mut self, whole: &[[f32; 3]], next: f64) -> Result<Vec<Channel>, Failure> {
        let next = (!self.scene.motions.is_empty()).then(|| {
            let mut scene = self.scene.clone();
            scene.set_time(next);
            scene
        });
        layers::of_scene(&mut self.renderer, &self.scene, whole, &self.light_names, next.as_ref())
    }

    /// A claim to write a frame's files; `None` while another process holds it.
    fn claim(&self, index: u32) -> Result<Option<Claim>, Failure> {
        let claim = Claim::attempt(&self.arguments.out, &sidecar::stem(index))?;
        if let Some(claim) = &claim {
            let start = format!(".{}.", sidecar::stem(index));
            let is_of_frame = |path: &&PathBuf| {
                let name = path.file_name().unwrap_or_default();
                name.as_encoded_bytes().starts_with(start.as_bytes())
            };
            claim.sweep(self.strays.iter().filter(is_of_frame).cloned());
        }
        Ok(claim)
    }

    /// Waits for that claim.
    fn wait(&self, index: u32) -> Result<Claim, Failure> {
        loop {
            if let Some(claim) = self.claim(index)? {
                return Ok(claim);
            }
            if stop::is_stopped() {
                return Err(Failure::Stopped { frame: index });
            }
            std::thread::sleep(claim::PAUSE);
        }
    }

    /// Whether the frame exists, complete and from the same inputs; if so, it is reported.
    fn keeps(&mut self, index: u32) -> Result<bool, Failure> {
        let out = &self.arguments.out;
        let Some(inputs) = &self.inputs else { return Ok(false) };
        if !Sidecar::read(out, index).is_some_and(|sidecar| sidecar.holds(out, inputs)) {
            return Ok(false);
        }
        if let Some(preview) = &mut self.preview {
            preview.add_file(&out.join(sidecar::picture(index)))?;
        }
        self.report(index, |picture| kept_json(index, picture))?;
        Ok(true)
    }

    /// Writes all files of a frame.
    fn write(
        &self,
        index: u32,
        frame: &Frame,
        layers: &[Channel],
        claim: &Claim,
    ) -> Result<(), Failure> {
        let out = &self.arguments.out;
        let mut files = FrameFiles::new(out, self.inputs.is_some());
        let stem = sidecar::stem(index);
        if self.arguments.maps {
            let folder = sidecar::maps(index);
            files::create_dir(&out.join(&folder))?;
            claim.sweep(files::temporaries(&out.join(&folder), ""));
            let write =
                |name: &str, contents: Fill<'_>| files.fill(format!("{folder}/{name}"), contents);
            let scene = &self.scene;
            let left = |number, take: Take<'_>| self.renderer.read_curve(number, take);
            maps::write(write, &frame.maps, left, &scene.lights, &self.light_names, scene.origin)?;
        }
        for (mode, image) in &frame.debug {
            files.write(format!("{stem}.{}.png", mode.name()), &maps::png(&image_of(image)))?;
        }
        if self.arguments.exr {
            let name = format!("{stem}.exr");
            let bytes = exr::encode(&out.join(&name), &frame.picture, layers)?;
            files.write(name, &bytes)?;
        }
        // Written last, so that a picture implies a complete frame.
        files.write(sidecar::picture(index), &maps::png(&image_of(&frame.picture)))?;
        match &self.inputs {
            Some(inputs) => files.finish(index, self.arguments.all_frames(), inputs),
            None => Ok(()),
        }
    }

    /// Prints the line of a frame.
    fn report(&self, index: u32, json: impl Fn(&Path) -> String) -> Result<(), Failure> {
        let picture = self.arguments.out.join(sidecar::picture(index));
        let line = if self.arguments.json { json(&picture) } else { picture.display().to_string() };
        self.progress.suspend(|| files::print(&line))?;
        self.progress.inc(1);
        Ok(())
    }

    /// Completes the preview, and warns of inputs that were left out.
    fn finish(self) -> Result<(), Failure> {
        self.progress.finish_and_clear();
        if let (Some(preview), Some(path)) = (self.preview, &self.arguments.preview) {
            preview.finish()?;
            if !self.arguments.json {
                output::print_name(path)?;
            }
        }
        let Counts { shrunk, nodes_dropped, unmasked, skipped } = self.counts;
        if shrunk > 0 {
            tracing::warn!(
                "{shrunk} shadow maps are smaller than they should be: the atlas is full; use a \
                 smaller size for some lights, or a larger texel_budget of [shadow]"
            );
        }
        if let Some(warning) = curves::nodes_warning(&self.scene.shadow, nodes_dropped) {
            tracing::warn!("{warning}");
        }
        if unmasked > 0 {
            tracing::warn!(
                "{unmasked} lights are shaded without a mask: all are taken; raise the limit of [mask], or \
                 give lights a far"
            );
        }
        if !skipped.is_empty() {
            let reasons: Vec<_> =
                skipped.iter().map(|(reason, count)| format!("{count} {reason}")).collect();
            tracing::warn!("left out: {}", reasons.join(", "));
        }
        Ok(())
    }
}

/// Leaves emitters to the adapter, and reports those that it cannot simulate.
fn leave_to_device(scene: &mut scene::Scene, renderer: &Renderer, simulation: SimulationName) {
    /// Number of particle steps per frame from which a software adapter is faster than the scene's own loop.
    const MANY_STEPS: u64 = 1 << 24;
    let Some(most) = renderer.most_simulated() else { return };
    let steps: u64 = scene.motions.iter().map(|motion| motion.most_steps()).sum();
    let is_chosen = !renderer.is_software() || simulation == SimulationName::Device;
    if is_chosen && simulation != SimulationName::Cpu {
        files::warn(&scene.simulate_on_device(most));
    } else if simulation == SimulationName::Auto && steps >= MANY_STEPS {
        // Emitters that it refuses stay on the CPU.
        let _ = scene.simulate_on_device(most);
    }
}

/// Progress bar on standard error, hidden unless that is a terminal.
fn progress_bar(frame_count: u64) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:30} frame {pos}/{len} ({eta} left)");
    ProgressBar::new(frame_count).with_style(style.expect("the template is valid"))
}

fn image_of(picture: &Picture) -> DynamicImage {
    let bytes = picture.rgb.as_flattened().to_vec();
    let image = RgbImage::from_raw(picture.size.x, picture.size.y, bytes);
    DynamicImage::from(image.expect("a picture has all its pixels"))
}

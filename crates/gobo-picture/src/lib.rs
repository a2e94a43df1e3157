//! Rendering of scenes to frames, on a GPU or on the CPU.
#![warn(missing_docs)]
// A browser's wgpu objects stay on their thread.
#![cfg_attr(target_arch = "wasm32", allow(clippy::arc_with_non_send_sync))]
mod emitters;
mod engine;
mod estimate;
mod layers;
pub mod picture;
mod place_order;
mod points;
mod read_maps;
mod relight;
pub mod stage;
mod watch;
mod work;

use engine::GpuEngine;
use glam::Vec3;
#[cfg(feature = "device")]
use gobo::gpu::{Backend, Selection};
use gobo::{
    Error,
    gpu::{Gpu, KernelJob},
    host::Input,
    model::{Counters, MAX_SAMPLES, Scene, View},
    records::GpuEmitted,
    shadows::{Config, check as check_views},
    view::{atlas::AtlasLimits, picture_views, shadow_views},
};
use gobo_reference as reference;
use watch::tell;
use work::{Stages, add_all};

pub use layers::{Surface, SurfaceLayers};
pub use points::PointLookUp;
pub use relight::set_to_relight;
pub use watch::Watch;

pub use crate::picture::debug::DebugMode;
pub use gobo::{
    records::{CurveMap, Picture, ViewMaps},
    view::Receivers,
};

/// Results of one frame, and their costs.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The rendered picture; without pixels if only maps are requested.
    pub picture: Picture,
    /// Debug pictures that were requested.
    pub debug: Vec<(DebugMode, Picture)>,
    /// Maps of all views; empty unless requested.
    pub maps: Vec<ViewMaps>,
    /// Counters of the frame.
    pub counters: Counters,
    /// Stage and its time \[ms\], in order, for all work of the frame; `picture` sums all its samples.
    pub stages: Vec<(&'static str, f64)>,
    /// Stage of the picture and its time \[ms\]; their sum is that of `picture`.
    pub picture_stages: Vec<(&'static str, f64)>,
    /// Buffer or texture and its size \[bytes\].
    pub memory: Vec<(&'static str, u64)>,
}

/// Outputs of a frame besides the picture.
#[derive(Clone, Copy, Debug, Default)]
pub struct RenderOptions<'a> {
    /// Whether to read back the views' maps.
    pub maps: bool,
    /// Light whose maps are read back, if `maps` is set; all lights when `None`.
    pub maps_of: Option<usize>,
    /// Whether the maps read back are [`ViewMaps::sums`] and opaque depths only, to which sums of other
    /// casters can be added. The maps then have no filters, and no picture should be rendered.
    pub sums: bool,
    /// Whether the device's curves are left there, for [`Renderer::read_curve`]: those of the frame's maps
    /// have no texels. The CPU reference returns them all.
    pub curves_stay: bool,
    /// Whether maps stay on the device for the next frame, which then renders only the views that see a
    /// change. The CPU reference renders all views in any case.
    pub keep: bool,
    /// The only sample of each pixel to render, of the scene's samples; all of them when `None`.
    pub sample: Option<u32>,
    /// Whether to read back the picture's linear light, before exposure and tone curve; the CPU reference
    /// always returns it.
    pub light: bool,
    /// Debug pictures. The CPU reference has none.
    pub debug: &'a [DebugMode],
    /// Whether no picture is rendered; the picture and its counters are then empty.
    pub maps_only: bool,
    /// Asked after the maps and after each sample of a picture: of the CPU reference after the maps and at
    /// the end.
    pub watch: Option<Watch<'a>>,
}

impl RenderOptions<'_> {
    /// Samples that are rendered.
    fn samples(&self, scene: &Scene) -> u32 {
        let all = scene.samples.clamp(1, MAX_SAMPLES);
        if self.maps_only { 0 } else { self.sample.map_or(all, |_| 1) }
    }

    /// Whether the maps of a view are requested.
    fn shows(&self, view: &View) -> bool {
        self.maps_of.is_none() || self.maps_of == view.light
    }
}

/// Renders scenes on one device.
#[derive(Debug)]
pub struct Renderer {
    engine: Engine,
}

#[derive(Debug)]
enum Engine {
    Gpu(Box<GpuEngine>),
    Cpu,
}

impl Renderer {
    /// Opens an adapter; `adapter`: part of its name, ignoring case.
    #[cfg(feature = "device")]
    pub fn new(backend: Backend, adapter: Option<&str>) -> Result<Self, Error> {
        let _phase = tracing::debug_span!("device").entered();
        if backend == Backend::Cpu {
            return Ok(Self::on_cpu());
        }
        let selection = Selection { backend, adapter: adapter.map(str::to_owned), tier: None };
        Self::on(Gpu::new(&selection)?)
    }

    /// A renderer on an open device.
    pub fn on(gpu: Gpu) -> Result<Self, Error> {
        Ok(Self { engine: Engine::Gpu(Box::new(GpuEngine::new(gpu)?)) })
    }

    /// A renderer without any device, by the CPU references of the kernels.
    pub fn on_cpu() -> Self {
        Self { engine: Engine::Cpu }
    }

    /// Frees the data that was kept for the next frame.
    pub fn forget(&mut self) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.forget();
        }
    }

    /// Most particles of an emitter that the device simulates, for [`Scene::simulate_on_device`]; `None`
    /// without a device.
    pub fn most_simulated(&self) -> Option<u64> {
        let Engine::Gpu(engine) = &self.engine else { return None };
        let limits = engine.gpu.device.limits();
        let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        Some(bytes / size_of::<GpuEmitted>() as u64)
    }

    /// Whether the adapter is software: the CPU is the device.
    pub fn is_software(&self) -> bool {
        match &self.engine {
            Engine::Gpu(engine) => engine.gpu.adapter.device_type == wgpu::DeviceType::Cpu,
            Engine::Cpu => true,
        }
    }

    /// Description of the device, for people.
    pub fn device(&self) -> String {
        match &self.engine {
            Engine::Gpu(engine) => {
                let gpu = &engine.gpu;
                format!("{} ({}; {})", gpu.adapter.name, gpu.adapter.backend, gpu.tier_reason)
            }
            Engine::Cpu => "the CPU reference".to_owned(),
        }
    }

    /// Changes the configuration of the next frames: for tests and measurements.
    #[doc(hidden)]
    pub fn configure(&mut self, change: impl FnOnce(&mut Config)) {
        if let Engine::Gpu(engine) = &mut self.engine {
            engine.shadows.configure(change);
        }
    }

    /// The kernels that [`Self::render`] of this scene would make before it returns, as jobs for the host's
    /// threads. A first frame may find that it needs a few more. Uploads the casters as `render` does, which
    /// then finds them uploaded.
    ///
    /// # Errors
    /// Those of [`Self::render`].
    pub fn pending(&mut self, scene: &Scene) -> Result<Vec<KernelJob>, Error> {
        check(scene)?;
        match &mut self.engine {
            Engine::Gpu(engine) => engine.pending(scene),
            Engine::Cpu => Ok(Vec::new()),
        }
    }

    /// Renders the frame at a time. Where the scene's shutter is open, each sample is rendered at its own
    /// time around it, in order; the maps and counters are those of the middle sample, the times the sum over
    /// all. `seconds`: from the start; `step`: between two frames \[s\].
    ///
    /// # Errors
    /// Those of [`Self::render`].
    pub fn render_at(
        &mut self,
        scene: &mut Scene,
        seconds: f64,
        step: f64,
        options: &RenderOptions<'_>,
    ) -> Result<Frame, Error> {
        let count = scene.samples.clamp(1, MAX_SAMPLES);
        let open = f64::from(scene.shutter) * step;
        if open == 0.0 || count == 1 || options.maps_only {
            scene.set_time(seconds);
            return self.render(scene, options);
        }
        let mut mean = reference::MeanPicture::new(scene);
        let mut shown = None;
        let (mut stages, mut picture_stages) = (Stages::new(), Stages::new());
        for sample in 0..count {
            let part = (f64::from(sample) + 0.5) / f64::from(count) - 0.5;
            scene.set_time((seconds + open * part).max(0.0));
            let mut sample_options =
                RenderOptions { light: true, sample: Some(sample), watch: None, ..*options };
            let is_middle = sample == count / 2;
            if !is_middle {
                (sample_options.maps, sample_options.debug) = (false, &[]);
            }
            // The next sample has its own.
            sample_options.curves_stay = false;
            let mut frame = self.render(scene, &sample_options)?;
            add_all(&mut stages, std::mem::take(&mut frame.stages));
            add_all(&mut picture_stages, std::mem::take(&mut frame.picture_stages));
            let _phase = tracing::debug_span!("read_back").entered();
            mean.add(frame.picture.light.iter().copied().map(Vec3::from_array));
            if is_middle {
                shown = Some(frame);
            }
            tell(options.watch, sample + 1, count)?;
        }
        let frame = shown.expect("some sample is in the middle");
        let _phase = tracing::debug_span!("read_back").entered();
        Ok(Frame { picture: mean.picture(), stages, picture_stages, ..frame })
    }

    /// Gives the texels of curves of the last frame that stayed on the device
    /// ([`RenderOptions::curves_stay`]) in turn, some rows at a time; nothing where none stayed. `number`:
    /// that of the view in the frame's maps.
    ///
    /// # Errors
    /// Those of `take`, and [`Error::Lost`] and [`Error::Memory`] of the device.
    pub fn read_curve<E: From<Error>>(
        &self,
        number: usize,
        take: impl FnMut(&CurveMap) -> Result<(), E>,
    ) -> Result<(), E> {
        match &self.engine {
            Engine::Gpu(engine) => engine
                .curves
                .as_ref()
                .map_or(Ok(()), |curves| curves.read(&engine.gpu, number, take)),
            Engine::Cpu => Ok(()),
        }
    }

    /// Renders one frame.
    pub fn render(&mut self, scene: &Scene, options: &RenderOptions<'_>) -> Result<Frame, Error> {
        let _phase = tracing::debug_span!("prepare").entered();
        check(scene)?;
        match &mut self.engine {
            Engine::Gpu(engine) => {
                let frame = engine.render(scene, options);
                frame.map_err(|error| engine.cause_of(error))
            }
            Engine::Cpu => render_on_cpu(scene, options),
        }
    }
}

/// Checks that no emitter is left to a device.
fn without_emissions(scene: &Scene) -> Result<(), Error> {
    let problem = "it is left to a device, and there is none";
    let error = Input::Emitter.invalid(0, problem);
    scene.emissions.is_empty().then_some(()).ok_or(error)
}

/// Checks a scene that may not come from a file against the contracts of its fields.
fn check(scene: &Scene) -> Result<(), Error> {
    scene.casters().check()?;
    Ok((0..).zip(&scene.lights).try_for_each(|(index, light)| light.check(index))?)
}

fn render_on_cpu(scene: &Scene, options: &RenderOptions<'_>) -> Result<Frame, Error> {
    without_emissions(scene)?;
    let (views, shrunk) = picture_views(scene, &AtlasLimits::CORE);
    check_views(&views, &scene.shadow)?;
    let _phase = tracing::debug_span!("kernels").entered();
    let clock = std::time::Instant::now();
    let (mut view_maps, mut counters) = reference::render_maps(scene, &views);
    if options.sums {
        reference::add_sums(scene, &mut view_maps);
    }
    counters.shrunk = shrunk as u64;
    let maps_ms = clock.elapsed().as_secs_f64() * 1e3;
    let mut stages = vec![("maps", maps_ms)];
    let mut picture = Picture::default();
    let parts = options.samples(scene) + 1;
    tell(options.watch, 1, parts)?;
    if !options.maps_only {
        let only = options.sample;
        picture = reference::render_samples(scene, &views, &view_maps, &shadow_views, only);
        stages.push(("picture", clock.elapsed().as_secs_f64() * 1e3 - maps_ms));
        tell(options.watch, parts, parts)?;
    }
    view_maps.retain(|maps| options.maps && options.shows(&maps.view));
    let (debug, picture_stages, memory) = Default::default();
    Ok(Frame { picture, debug, maps: view_maps, counters, stages, picture_stages, memory })
}

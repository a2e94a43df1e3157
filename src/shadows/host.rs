//! The library's face: a host's casters and views in, maps to be recorded out.
use super::{
    CasterSet, Config, HostInputs, Maps, Pipeline, PreparedMaps, Room, frame::Uploads,
    host_depths::depth_inputs, kernels::Variant,
};
use crate::{
    error::Error,
    gpu::{
        Constant, Kernel, KernelCache, KernelDesc, Memory, Tier, Timeline, check_alive, missing,
    },
    model::{Casters, Counters, MAX_MAP_SIZE, MAX_PAIRS, MIN_MAP_SIZE, ShadowSettings, View},
    stage::{hits::Features, sort::pair_limit},
};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Shadow maps on one device. Keeps its kernels, and the casters and maps of the last frame, so
/// that the next uploads and renders what has changed only.
#[derive(Debug)]
pub struct Shadows {
    device: wgpu::Device,
    queue: wgpu::Queue,
    engine: Arc<Mutex<Engine>>,
    room: Room,
}

/// What [`Shadows`] and the last [`Prepared`] share.
#[derive(Debug)]
struct Engine {
    pipeline: Pipeline,
    casters: Option<CasterSet>,
    maps: Option<PreparedMaps>,
    /// Of the frame that `maps` are of.
    frame: u64,
}

/// The maps of a frame, ready to be recorded any number of times, until a later
/// [`Shadows::prepare`] takes them over.
#[derive(Debug)]
pub struct Prepared {
    device: wgpu::Device,
    queue: wgpu::Queue,
    engine: Arc<Mutex<Engine>>,
    frame: u64,
    pub(super) caster_count: u64,
    /// Whether some filter depends on the order of its casters.
    pub(super) ordered: bool,
    pub(super) views: Vec<View>,
    pub(super) settings: ShadowSettings,
    maps: Maps,
    memory: Memory,
}

fn lock(engine: &Mutex<Engine>) -> MutexGuard<'_, Engine> {
    engine.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shadows {
    /// On a host's device, of which it keeps handles. It runs on the native tier where the device
    /// was opened with subgroups, texture atomics and 9 storage textures a stage, else on WebGPU's
    /// own limits and features.
    ///
    /// # Errors
    /// Where the device has less than WebGPU's limits, or refuses a kernel.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
    ) -> Result<Self, Error> {
        let native = missing(device, Tier::Native).is_empty();
        let tier = if native { Tier::Native } else { Tier::Core };
        Self::on_tier(device, queue, adapter, tier)
    }

    /// As [`Self::new`], on a tier that the host chooses.
    ///
    /// # Errors
    /// Where the device has less than the tier needs ([`Support`](crate::Support) tells before), or
    /// refuses a kernel.
    pub fn on_tier(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
        tier: Tier,
    ) -> Result<Self, Error> {
        Self::with(device, queue, Config::new(tier, adapter))
    }

    /// With a configuration of its own: for tests and measurements.
    #[doc(hidden)]
    pub fn with(device: &wgpu::Device, queue: &wgpu::Queue, config: Config) -> Result<Self, Error> {
        Self::sharing(device, queue, config, KernelCache::default())
    }

    /// As [`Self::with`], with the kernels of all that render on the device.
    #[doc(hidden)]
    pub fn sharing(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        config: Config,
        cache: KernelCache,
    ) -> Result<Self, Error> {
        check_alive(device)?;
        let (tier, missing) = (config.tier, missing(device, config.tier));
        if !missing.is_empty() {
            return Err(Error::Unsupported { tier, missing });
        }
        let pipeline = Pipeline::sharing(device, config, cache)?;
        let engine = Engine { pipeline, casters: None, maps: None, frame: 0 };
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            engine: Arc::new(Mutex::new(engine)),
            room: Room::new(MAX_PAIRS),
        })
    }

    /// The queue of its device.
    pub(super) fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// A kernel that no frame needs.
    pub(super) fn kernel_of(&self, desc: &KernelDesc) -> Result<Kernel, Error> {
        Ok(lock(&self.engine).pipeline.kernels.other(&self.device, desc, &[])?)
    }

    /// Uploads what has changed of `casters` and allocates the maps of `views`. Maps of the frame
    /// before stay where nothing has changed that they see; the others are rendered when the
    /// [`Prepared`] is recorded. Earlier ones are void from here on.
    ///
    /// # Errors
    /// Where a caster or view is not as its fields say it must be, or the device has no room or is
    /// lost.
    pub fn prepare(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
    ) -> Result<Prepared, Error> {
        self.prepare_with(casters, views, settings, &HostInputs::new())
    }

    /// As [`Self::prepare`], with what the host has on the device already. That is read whenever the
    /// [`Prepared`] is recorded: what changes in the host's buffers asks for no other `prepare`.
    ///
    /// # Errors
    /// As [`Self::prepare`], and where an input is not as it is said to be.
    pub fn prepare_with(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
        inputs: &HostInputs<'_>,
    ) -> Result<Prepared, Error> {
        let prepared = self.plan(casters, views, settings, inputs)?;
        self.kernels().finish()?;
        Ok(prepared)
    }

    /// As [`Self::prepare_with`], but that kernels may not be made yet.
    pub(crate) fn plan(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
        inputs: &HostInputs<'_>,
    ) -> Result<Prepared, Error> {
        check_alive(&self.device)?;
        casters.check()?;
        check(views, settings)?;
        let depths = depth_inputs(views, inputs.depths)?;
        if settings.colored && !inputs.depths.is_empty() {
            let problem = "coloured dithering has depths by channel, which it cannot lower";
            return Err(Error::Invalid { what: "depth map of the host's", index: 0, problem });
        }
        let Self { device, queue, room, .. } = self;
        room.budget = settings.pair_budget.min(pair_limit(device));
        let mut engine = lock(&self.engine);
        let Engine { pipeline, casters: set, maps, frame } = &mut *engine;
        pipeline.config = Config {
            pair_budget: room.budget,
            soften: settings.soften,
            colored: settings.colored,
            nodes: settings.curve_nodes(),
            ..pipeline.config
        };
        let kept = set.take().and_then(|mut set| {
            (set.has_room(inputs.casters) && set.update(queue, casters)).then_some(set)
        });
        let mut new = match kept {
            Some(kept) => kept,
            None => CasterSet::with_room(device, queue, casters, inputs.casters)?,
        };
        new.take_host(device, queue, casters.materials, inputs.casters)?;
        let new = set.insert(new);
        let (pairs, earlier) = (room.pairs, maps.take());
        let request = pipeline.request(device, queue, new, views, pairs);
        let prepared = pipeline.prepare_from(&request.with_depths(&depths), earlier)?;
        *frame += 1;
        let prepared = maps.insert(prepared);
        Ok(Prepared {
            device: device.clone(),
            queue: queue.clone(),
            engine: Arc::clone(&self.engine),
            frame: *frame,
            caster_count: (casters.particles.len() + casters.triangles.len()) as u64,
            ordered: new.is_ordered(),
            views: views.to_vec(),
            settings: *settings,
            maps: prepared.maps.clone(),
            memory: prepared.memory.clone(),
        })
    }

    pub(crate) fn kernels(&self) -> KernelCache {
        lock(&self.engine).pipeline.kernels.cache().clone()
    }

    /// The device, and what its kernels may use.
    pub(super) fn device(&self) -> (&wgpu::Device, Tier) {
        (&self.device, lock(&self.engine).pipeline.config.tier)
    }

    /// Takes over how many pairs a frame needed. Whether it grew: then some casters took the
    /// slower scatter path for lack of room, and the next [`Self::prepare`] has room for them.
    #[expect(clippy::needless_pass_by_value, reason = "what was counted is used up")]
    pub fn grow_from(&mut self, counters: Counters) -> bool {
        let grows = self.room.grow(counters.pairs_needed, counters.pair_room);
        if let Some(maps) = lock(&self.engine).maps.as_mut().filter(|_| grows) {
            maps.forget();
        }
        grows
    }

    /// Gives the casters and maps of the last frame back to the device.
    pub fn forget(&mut self) {
        let mut engine = lock(&self.engine);
        (engine.casters, engine.maps) = (None, None);
        engine.frame += 1;
        self.room.pairs = None;
    }

    /// What the next frames are prepared with, as far as [`ShadowSettings`] do not say it: for
    /// tests and measurements.
    #[doc(hidden)]
    pub fn configure(&mut self, change: impl FnOnce(&mut Config)) {
        change(&mut lock(&self.engine).pipeline.config);
    }

    /// What a frame of the casters of the last [`Self::prepare`] uploads.
    #[doc(hidden)]
    pub fn uploads(&mut self, casters: &Casters<'_>, views: &[View]) -> Result<Uploads, Error> {
        let (device, queue, pairs) = (self.device.clone(), self.queue.clone(), self.room.pairs);
        self.with_casters(|pipeline, set| {
            pipeline.uploads((&device, &queue), set, casters, views, pairs)
        })
    }

    /// The pipeline and the casters of the last frame.
    pub(crate) fn with_casters<T>(
        &mut self,
        act: impl FnOnce(&mut Pipeline, &CasterSet) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let mut engine = lock(&self.engine);
        let Engine { pipeline, casters, .. } = &mut *engine;
        act(pipeline, casters.as_ref().ok_or(Error::Superseded)?)
    }
}

impl Prepared {
    /// Records every stage of every view whose maps must be rendered. Makes nothing and submits
    /// nothing; records nothing where a later [`Shadows::prepare`] has taken the maps over.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        self.record_timed(encoder, &mut Timeline::untimed());
    }

    /// As [`Self::record`], with time stamps around each stage.
    pub fn record_timed(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        let engine = lock(&self.engine);
        if let Ok(maps) = self.current(&engine) {
            maps.record(engine.pipeline.kernels(), encoder, timeline);
            timeline.end(encoder);
        }
    }

    /// Reads the host's casters of `set`, an index, by other bindings of the same layout from the next
    /// [`Self::record`] on: for hosts that write to two buffers in turns.
    ///
    /// # Errors
    /// Where there is no such set, or a later [`Shadows::prepare`] has taken the maps over.
    pub fn rebind(&self, set: usize, bindings: &wgpu::BindGroup) -> Result<(), Error> {
        let engine = lock(&self.engine);
        let host = self.current(&engine)?.host.as_ref();
        let problem = "there is none, or it has no caster";
        let none = Error::Invalid { what: "set of host casters", index: set, problem };
        host.is_some_and(|host| host.rebind(set, bindings)).then_some(()).ok_or(none)
    }

    /// Makes a kernel of this device, or has it already.
    pub(super) fn kernel(&self, variant: Variant, features: Features) -> Result<Kernel, Error> {
        let mut engine = lock(&self.engine);
        let kernel = engine.pipeline.kernels.plan(&self.device, variant, features)?.clone();
        kernel.make()?;
        Ok(kernel)
    }

    /// As [`Self::kernel`], of one that is made for a host that asks.
    pub(super) fn kernel_of(
        &self,
        desc: &KernelDesc,
        constants: &[Constant],
    ) -> Result<Kernel, Error> {
        Ok(lock(&self.engine).pipeline.kernels.other(&self.device, desc, constants)?)
    }

    /// Device and queue that the maps are on.
    pub(super) fn device(&self) -> (&wgpu::Device, &wgpu::Queue) {
        (&self.device, &self.queue)
    }

    /// Records what counts the pairs and no more: where nothing of a scene is known,
    /// [`Self::counters`] tells at a fraction of a frame's time how much room to grow to, so that no
    /// frame takes the slower scatter path for lack of it.
    pub fn record_counts(&self, encoder: &mut wgpu::CommandEncoder) {
        let engine = lock(&self.engine);
        if let Ok(maps) = self.current(&engine) {
            maps.record_counts(engine.pipeline.kernels(), encoder, &mut Timeline::untimed());
        }
    }

    pub(super) fn with_maps<T>(
        &self,
        act: impl FnOnce(&PreparedMaps) -> Result<T, Error>,
    ) -> Result<T, Error> {
        act(self.current(&lock(&self.engine))?)
    }

    fn current<'a>(&self, engine: &'a Engine) -> Result<&'a PreparedMaps, Error> {
        engine.maps.as_ref().filter(|_| engine.frame == self.frame).ok_or(Error::Superseded)
    }

    /// The textures that the maps of all views are in, and where in them each is.
    pub fn maps(&self) -> &Maps {
        &self.maps
    }

    /// Bytes by buffer and texture.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }
}

/// Whether views and settings are as their fields say they must be.
pub(crate) fn check(views: &[View], settings: &ShadowSettings) -> Result<(), Error> {
    let invalid = |index, problem| Err(Error::Invalid { what: "view", index, problem });
    for (index, view) in views.iter().enumerate() {
        let sizes = MIN_MAP_SIZE..=MAX_MAP_SIZE;
        if !(sizes.contains(&view.size.x) && sizes.contains(&view.size.y)) {
            return invalid(index, "its map's size must be 16 to 4096 texels");
        }
        let finite = view.view_from_world.is_finite() && view.far.is_finite();
        if !(finite && view.near >= 0.0 && view.near < view.far) {
            return invalid(index, "its planes must be finite, the near one before the far one");
        }
    }
    if !matches!(settings.curve_nodes(), 0 | 4 | 8 | 16) {
        let problem = "a curve has 4, 8 or 16 nodes";
        return Err(Error::Invalid { what: "setting", index: 0, problem });
    }
    Ok(())
}

//! Interface of the library: casters and views of a host in, [`Prepared`] maps out.
use super::{
    CasterSet, Config, HostInputs, PairCapacity, Pipeline, Prepared, PreparedMaps,
    views::host_depths::depth_inputs,
};
use crate::{
    error::Error,
    gpu::{Kernel, KernelCache, KernelDesc, Tier, check_alive, missing},
    model::{
        Casters, Class, Counters, MAX_BLUR, MAX_MAP_SIZE, MAX_MIPS, MAX_PAIRS, MIN_MAP_SIZE,
        Projection, ShadowSettings, View,
    },
    stage::{features::Features, sort::pair_limit},
};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Shadow maps on one device. Keeps its kernels, and the casters and maps of the last frame, so that the
/// next frame uploads and renders only what has changed.
#[derive(Debug)]
pub struct Shadows {
    device: wgpu::Device,
    queue: wgpu::Queue,
    engine: Arc<Mutex<Engine>>,
    capacity: PairCapacity,
}

/// State shared by [`Shadows`] and the last [`Prepared`].
#[derive(Debug)]
pub(super) struct Engine {
    pub(super) pipeline: Pipeline,
    casters: Option<CasterSet>,
    pub(super) maps: Option<PreparedMaps>,
    /// Number of the frame that `maps` belong to.
    pub(super) frame: u64,
}

impl Engine {
    /// Updates the casters, or makes them anew.
    fn upload(
        &mut self,
        (device, queue): (&wgpu::Device, &wgpu::Queue),
        casters: &Casters<'_>,
        inputs: &HostInputs<'_>,
    ) -> Result<(), Error> {
        let kept = self.casters.take().and_then(|mut set| {
            (set.suffices(inputs) && set.update(queue, casters)).then_some(set)
        });
        self.casters = Some(match kept {
            Some(kept) => kept,
            None => CasterSet::reserving(device, queue, casters, inputs)?,
        });
        Ok(())
    }
}

pub(super) fn lock(engine: &Mutex<Engine>) -> MutexGuard<'_, Engine> {
    engine.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Shadows {
    /// Shadows on a host's device and queue, of which it keeps handles. It runs on the native tier if the
    /// device was opened with subgroups, texture atomics and 9 storage textures a stage, else on WebGPU's
    /// own limits and features.
    ///
    /// # Errors
    /// If the device has less than WebGPU's limits, or refuses a kernel.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
    ) -> Result<Self, Error> {
        let native = missing(device, Tier::Native).is_empty();
        let tier = if native { Tier::Native } else { Tier::Core };
        Self::on_tier(device, queue, adapter, tier)
    }

    /// Like [`Self::new`], on a tier that the host chooses.
    ///
    /// # Errors
    /// If the device has less than the tier needs ([`Support`](crate::Support) reports it beforehand), or
    /// refuses a kernel.
    pub fn on_tier(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
        tier: Tier,
    ) -> Result<Self, Error> {
        Self::with(device, queue, Config::new(tier, adapter))
    }

    /// Shadows with a given configuration: for tests and measurements.
    #[doc(hidden)]
    pub fn with(device: &wgpu::Device, queue: &wgpu::Queue, config: Config) -> Result<Self, Error> {
        Self::sharing(device, queue, config, KernelCache::default())
    }

    /// Like [`Self::with`], with kernels shared by all renderers on the device.
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
            capacity: PairCapacity::new(MAX_PAIRS),
        })
    }

    /// The queue of its device.
    pub(super) fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// A kernel that no frame needs, compiled on demand.
    pub(super) fn kernel_of(&self, desc: &KernelDesc) -> Result<Kernel, Error> {
        let kernel = lock(&self.engine).pipeline.kernels.get(desc, Features::NONE)?;
        kernel.make()?;
        Ok(kernel)
    }

    /// Uploads changes of `casters` and allocates the maps of `views`. Maps of the previous frame are kept
    /// if nothing that they see has changed; the others are rendered when the [`Prepared`] is recorded.
    /// Earlier [`Prepared`] values are invalid from then on.
    ///
    /// # Errors
    /// If a caster or view violates the contract of its fields, or the device is out of memory or lost.
    pub fn prepare(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
    ) -> Result<Prepared, Error> {
        self.prepare_with(casters, views, settings, &HostInputs::new())
    }

    /// Like [`Self::prepare`], with inputs that the host has on the device. They are read whenever the
    /// [`Prepared`] is recorded: changed contents of the host's buffers need no other `prepare`.
    ///
    /// # Errors
    /// Those of [`Self::prepare`], and if an input violates its contract.
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

    /// Like [`Self::prepare_with`], except that kernels may not be compiled yet.
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
        let Self { device, queue, capacity, .. } = self;
        capacity.budget = settings.pair_budget.min(pair_limit(device));
        let mut engine = lock(&self.engine);
        engine.upload((device, queue), casters, inputs)?;
        let Engine { pipeline, casters: set, maps, frame } = &mut *engine;
        pipeline.config = Config {
            pair_budget: capacity.budget,
            soften: settings.soften,
            colored: settings.colored,
            blur: settings.blur,
            mips: settings.mips,
            nodes: settings.curve_nodes(),
            ..pipeline.config
        };
        let new = set.as_mut().ok_or(Error::Superseded)?;
        new.set_host_casters(device, queue, casters.materials, inputs.casters)?;
        let new = &*new;
        let (pairs, earlier) = (capacity.pairs, maps.take());
        let request = pipeline.request(device, queue, new, views, pairs);
        let prepared = pipeline.prepare_from(&request.with_depths(&depths), earlier)?;
        *frame += 1;
        let prepared = maps.insert(prepared);
        Ok(Prepared {
            device: device.clone(),
            queue: queue.clone(),
            kernels: pipeline.kernels.clone(),
            engine: Arc::clone(&self.engine),
            frame: *frame,
            caster_count: (casters.particles.len() + casters.triangles.len()) as u64
                + new.emitted_count(),
            ordered: new.is_ordered(),
            tints: casters
                .materials
                .iter()
                .any(|material| Class::FILTERING.contains(&Class::of(material))),
            views: views.to_vec(),
            settings: *settings,
            maps: prepared.maps.clone(),
            memory: prepared.memory.clone(),
        })
    }

    pub(crate) fn kernels(&self) -> KernelCache {
        lock(&self.engine).pipeline.kernels.cache().clone()
    }

    /// The device, and the tier of its kernels.
    pub(super) fn device(&self) -> (&wgpu::Device, Tier) {
        (&self.device, lock(&self.engine).pipeline.config.tier)
    }

    /// Grows the pair capacity to what a frame needed. Returns whether it grew: then some casters took the
    /// slower scatter path, and the next [`Self::prepare`] has the capacity for them.
    #[expect(clippy::needless_pass_by_value, reason = "what was counted is used up")]
    pub fn grow_from(&mut self, counters: Counters) -> bool {
        let grows = self.capacity.grow(counters.pairs_needed, counters.pair_capacity);
        if let Some(maps) = lock(&self.engine).maps.as_mut().filter(|_| grows) {
            maps.forget();
        }
        grows
    }

    /// Frees the casters and maps of the last frame.
    pub fn forget(&mut self) {
        let mut engine = lock(&self.engine);
        (engine.casters, engine.maps) = (None, None);
        engine.frame += 1;
        self.capacity.pairs = None;
    }

    /// Changes the configuration of the next frames beyond [`ShadowSettings`]: for tests and measurements.
    #[doc(hidden)]
    pub fn configure(&mut self, change: impl FnOnce(&mut Config)) {
        let mut engine = lock(&self.engine);
        let pipeline = &mut engine.pipeline;
        change(&mut pipeline.config);
        pipeline.kernels.follow(pipeline.config.profile);
    }

    /// Uploads changes of `casters` before [`Self::prepare_with`] does, and returns the identity of the set.
    pub(super) fn upload(
        &mut self,
        casters: &Casters<'_>,
        inputs: &HostInputs<'_>,
    ) -> Result<u64, Error> {
        check_alive(&self.device)?;
        casters.check()?;
        let mut engine = lock(&self.engine);
        engine.upload((&self.device, &self.queue), casters, inputs)?;
        engine.casters.as_ref().map(CasterSet::id).ok_or(Error::Superseded)
    }

    /// The casters of the last frame.
    pub(super) fn with_set<T>(
        &mut self,
        act: impl FnOnce(&mut CasterSet) -> T,
    ) -> Result<T, Error> {
        lock(&self.engine).casters.as_mut().map(act).ok_or(Error::Superseded)
    }

    /// The pipeline and the casters of the last frame.
    #[cfg(feature = "picture")]
    pub(crate) fn with_casters<T>(
        &mut self,
        act: impl FnOnce(&mut Pipeline, &CasterSet) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let mut engine = lock(&self.engine);
        let Engine { pipeline, casters, .. } = &mut *engine;
        act(pipeline, casters.as_ref().ok_or(Error::Superseded)?)
    }
}

/// Checks views and settings against the contracts of their fields.
pub(crate) fn check(views: &[View], settings: &ShadowSettings) -> Result<(), Error> {
    let invalid = |index, problem| Err(Error::Invalid { what: "view", index, problem });
    for (index, view) in views.iter().enumerate() {
        let sizes = MIN_MAP_SIZE..=MAX_MAP_SIZE;
        if !(sizes.contains(&view.size.x) && sizes.contains(&view.size.y)) {
            return invalid(index, "its map's size must be 16 to 4096 texels");
        }
        let finite = view.view_from_world.is_finite() && view.far.is_finite();
        let first = match view.projection {
            Projection::Orthographic => f32::MIN,
            Projection::Perspective => 0.0,
        };
        if !(finite && view.near >= first && view.near < view.far) {
            return invalid(index, "its planes must be finite, the near one before the far one");
        }
    }
    if settings.blur > MAX_BLUR || settings.mips > MAX_MIPS {
        let problem = "a blur reaches 16 texels at most, and a filter map has 4 smaller levels";
        return Err(Error::Invalid { what: "setting", index: 0, problem });
    }
    if !matches!(settings.curve_nodes(), 0 | 4 | 8 | 16) {
        let problem = "a curve has 4, 8 or 16 nodes";
        return Err(Error::Invalid { what: "setting", index: 0, problem });
    }
    Ok(())
}

//! Interface of the library: casters and views of a host in, [`Prepared`] maps out.
use super::{
    AreaLevels, CasterSet, Config, HostInputs, LightShelf, PairCapacity, Prepared,
    frame_mark::Marks,
    host_grids,
    prepare::{Frame, FrameMaps, Request},
    statistics::{Planned, Statistics},
    views::host_depths::{DepthViews, depth_inputs},
};
use crate::{
    error::{Error, Input},
    frame::Kernels,
    gpu::{
        FETCH_FEATURES, Kernel, KernelCache, KernelDesc, Shelf, Tier, allocated, check_alive,
        missing,
    },
    model::{
        Casters, Class, Counters, MAX_MAP_SIZE, MAX_PAIRS, MIN_MAP_SIZE, Projection,
        ShadowSettings, View, ViewRole,
    },
    stage::{features::Features, sort::pair_limit},
};
use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};

/// Shadow maps on one device. Keeps its kernels, and the casters and maps of the last frame, so that the
/// next frame uploads and renders only what has changed.
#[derive(Debug)]
pub struct Shadows {
    queue: wgpu::Queue,
    kernels: Kernels,
    config: Config,
    casters: Option<CasterSet>,
    maps: Option<FrameMaps>,
    /// Other objects of the last frame.
    shelf: Shelf,
    /// Objects that bind the host's casters.
    host_shelf: Shelf,
    depth_views: DepthViews,
    light_shelf: Arc<LightShelf>,
    /// Number of the last frame, to which `maps` belong.
    frame: Arc<AtomicU64>,
    marks: Marks,
    capacity: PairCapacity,
    pub(super) statistics: Arc<Statistics>,
}

impl Shadows {
    /// Shadows on a host's device and queue, of which it keeps handles. They run on the best tier that the
    /// device was opened for ([`Tier::of`] gives the adapter's best).
    ///
    /// # Errors
    /// If the device has less than WebGPU's limits, or refuses a kernel.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        adapter: &wgpu::AdapterInfo,
    ) -> Result<Self, Error> {
        let tier = Tier::best(|tier| missing(device, tier).is_empty());
        Self::on_tier(device, queue, adapter, tier.unwrap_or_default())
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
        let tuning = config.tuning.within(&device.limits());
        let config = Config { tuning, ..config };
        Ok(Self::of(queue, Kernels::new(device, tier, tuning, cache), config))
    }

    fn of(queue: &wgpu::Queue, kernels: Kernels, config: Config) -> Self {
        Self {
            queue: queue.clone(),
            marks: Marks::new(kernels.device()),
            kernels,
            config,
            casters: None,
            maps: None,
            shelf: Shelf::new(queue),
            host_shelf: Shelf::new(queue),
            depth_views: DepthViews::default(),
            light_shelf: Arc::new(LightShelf::new(queue)),
            frame: Arc::default(),
            capacity: PairCapacity::new(MAX_PAIRS),
            statistics: Arc::default(),
        }
    }

    /// Further shadows on the same device, for other casters and views, with the same kernels: nothing is
    /// compiled twice. For hosts with several worlds or cameras.
    #[must_use]
    pub fn another(&self) -> Self {
        Self::of(&self.queue, self.kernels.clone(), self.config)
    }

    /// The queue that uploads go to.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The kernels of the device.
    pub fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// Configuration of the last frame.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// A kernel that no frame needs, compiled on demand.
    pub(super) fn kernel_of(&self, desc: &KernelDesc) -> Result<Kernel, Error> {
        let kernel = self.kernels.get(desc, Features::NONE)?;
        kernel.make()?;
        Ok(kernel)
    }

    /// Uploads changes of `casters` and allocates the maps of `views`. Maps of the previous frame are kept if
    /// nothing that they see has changed; the others are rendered when the [`Prepared`] is recorded. Earlier
    /// [`Prepared`] values become invalid: submit their recorded commands first. Maps of a frame that was
    /// recorded and did not run ([`Prepared::record`]) are rendered again: to know it, the device is polled,
    /// which does not wait, but calls the host's callbacks for finished work.
    ///
    /// # Errors
    /// If a caster or view violates the contract of its fields, or the device is out of memory or lost. If
    /// memory is missing for maps or scratch memory, the last [`Prepared`] stays valid.
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
        let prepared = self.prepare_uncompiled(casters, views, settings, inputs)?;
        self.kernels.finish()?;
        Ok(prepared)
    }

    /// Like [`Self::prepare_with`], except that kernels may not be compiled yet.
    pub fn prepare_uncompiled(
        &mut self,
        casters: &Casters<'_>,
        views: &[View],
        settings: &ShadowSettings,
        inputs: &HostInputs<'_>,
    ) -> Result<Prepared, Error> {
        check(views, settings)?;
        let device = self.kernels.device();
        let depths = depth_inputs(device, views, inputs.depths, &mut self.depth_views)?;
        if settings.colored && !inputs.depths.is_empty() {
            let problem = "coloured dithering has depths by channel, which it cannot lower";
            return Err(Input::HostDepth.invalid(0, problem));
        }
        self.upload(casters, inputs)?;
        let fitting = settings.within_curve_budget(views);
        let nodes_dropped = u64::from(settings.curve_nodes() - fitting.curve_nodes());
        self.adopt(&fitting);
        let set = self.casters.as_mut().ok_or(Error::Superseded)?;
        let kernels = self.kernels.with_shelf(&self.host_shelf);
        set.set_host_casters(&kernels, casters.materials, inputs)?;
        let device = self.kernels.device();
        let mut earlier = self.maps.take();
        let has_run = self.marks.has_run(device)?;
        if !has_run {
            // Nor did levels that were recorded with it.
            self.light_shelf.redraw();
        }
        // Sums are reset in each frame.
        if let Some(maps) = earlier.as_mut().filter(|_| !has_run || self.config.toggles.sums) {
            maps.cache.forget();
        }
        let have_run = self.marks.have_run();
        let earlier = earlier.filter(|_| have_run);
        let last = self.frame.load(Ordering::Relaxed);
        let kernels = self.kernels.with_shelf(&self.shelf);
        let request = Request {
            queue: &self.queue,
            kernels: &kernels,
            config: &self.config,
            casters: set,
            views,
            pairs: self.capacity.pairs,
            pages: self.capacity.pages,
            expected: self.capacity.expected(),
            counted_frames: self.capacity.counted_of(casters.count() + set.emitted_count()),
            depths: &depths,
            last: &self.frame,
        };
        let frame = allocated(device, || request.frame(earlier));
        if self.frame.load(Ordering::Relaxed) == last {
            self.marks.keep();
        } else {
            self.marks.turn(device);
        }
        let frame = frame?;
        self.light_shelf.turn();
        if inputs.area_lights {
            let maps = &frame.maps.set.maps;
            let has_faces = views.iter().any(|view| matches!(view.role, ViewRole::Face(_)));
            AreaLevels::request_kernels(&self.kernels, maps, has_faces)?;
        }
        let tints = |material| Class::FILTERING.contains(&Class::of(material));
        let Frame { maps, commands, pair_capacity, page_capacity, culled } = frame;
        let (counted, cache) = (&commands.counted, &maps.cache);
        self.statistics.reserve(device, counted);
        let rendered = cache.pending.len();
        let counters = Counters {
            casters: casters.count() + set.emitted_count(),
            views_rendered: rendered as u64,
            views_kept: (cache.view_count() - rendered) as u64,
            views_searched: cache.searched as u64,
            culled,
            hidden: cache.hidden_count(),
            nodes_dropped,
            pair_capacity,
            page_capacity,
            ..Counters::default()
        };
        let prepared = Prepared {
            queue: self.queue.clone(),
            kernels: self.kernels.clone(),
            frame: self.frame.load(Ordering::Relaxed),
            last: Arc::clone(&self.frame),
            mark: self.marks.current(),
            planned: Planned {
                batches: counted.lists.len(),
                has_host: counted.host.is_some(),
                ordered: set.is_ordered(),
                counters,
            },
            statistics: Arc::clone(&self.statistics),
            commands: Arc::clone(&commands),
            tints: casters.materials.iter().any(tints),
            views: views.to_vec(),
            settings: fitting,
            maps: maps.set.maps.clone(),
            caustics: None,
            light_shelf: Arc::clone(&self.light_shelf),
        };
        self.maps = Some(maps);
        Ok(prepared)
    }

    /// Takes settings over, within what the device can do.
    fn adopt(&mut self, settings: &ShadowSettings) {
        let device = self.kernels.device();
        let can_queue =
            self.config.tier == Tier::Native && device.features().contains(FETCH_FEATURES);
        self.config.toggles.queued &= can_queue;
        self.capacity.budget = settings.pair_budget.min(pair_limit(device));
        self.config.settings = ShadowSettings { pair_budget: self.capacity.budget, ..*settings };
    }

    /// The device, and the tier of its kernels.
    pub(super) fn device(&self) -> (&wgpu::Device, Tier) {
        (self.kernels.device(), self.kernels.tier())
    }

    /// Grows the pair capacity to the number that a frame needed. Returns whether it grew: then some casters
    /// took the slower scatter path, and the next [`Self::prepare`] has room for them.
    pub fn grow_from(&mut self, counters: &Counters) -> bool {
        let grows = self.capacity.grow(counters.pairs_needed, counters.pair_capacity)
            | self.capacity.grow_pages(counters);
        if self.casters.as_ref().is_some_and(|set| set.host().is_some()) {
            self.capacity.see(counters);
        } else {
            self.capacity.count(counters);
        }
        if let Some(maps) = self.maps.as_mut().filter(|_| grows) {
            maps.cache.forget();
        }
        grows
    }

    /// Frees the casters and maps of the last frame.
    pub fn forget(&mut self) {
        (self.casters, self.maps) = (None, None);
        (self.shelf, self.host_shelf) = (Shelf::new(&self.queue), Shelf::new(&self.queue));
        self.light_shelf = Arc::new(LightShelf::new(&self.queue));
        self.frame.fetch_add(1, Ordering::Relaxed);
        self.capacity = PairCapacity::new(self.capacity.budget);
    }

    /// Changes the configuration of the next frames beyond [`ShadowSettings`]: for tests and measurements.
    #[doc(hidden)]
    pub fn configure(&mut self, change: impl FnOnce(&mut Config)) {
        change(&mut self.config);
        self.kernels.follow(self.config.tuning);
    }

    /// Uploads changes of `casters`, or makes their set anew, and returns its identity.
    pub(super) fn upload(
        &mut self,
        casters: &Casters<'_>,
        inputs: &HostInputs<'_>,
    ) -> Result<u64, Error> {
        let (device, queue) = (self.kernels.device(), &self.queue);
        check_alive(device)?;
        casters.check()?;
        let grids = host_grids::with_bricks(device, inputs.grids)?;
        let form = self.config.tuning.record_form;
        let kept = self.casters.take().and_then(|mut set| {
            (set.suffices(inputs, form) && set.update(queue, casters, &grids)).then_some(set)
        });
        let new = || {
            let reserve = || CasterSet::reserving((device, queue), casters, inputs, &grids, form);
            allocated(device, reserve)
        };
        let set = kept.map_or_else(new, Ok)?;
        Ok(self.casters.insert(set).id())
    }

    /// Maps whose levels were made, in all frames since the last [`Self::forget`].
    #[doc(hidden)]
    pub fn levels_made(&self) -> u64 {
        self.light_shelf.levels_made()
    }

    /// The casters of the last frame.
    pub fn casters(&self) -> Result<&CasterSet, Error> {
        self.casters.as_ref().ok_or(Error::Superseded)
    }

    pub(super) fn casters_mut(&mut self) -> Result<&mut CasterSet, Error> {
        self.casters.as_mut().ok_or(Error::Superseded)
    }
}

/// Checks views and settings against the contracts of their fields.
pub fn check(views: &[View], settings: &ShadowSettings) -> Result<(), Error> {
    let invalid = |index, problem| Err(Input::View.invalid(index, problem));
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
        if !(view.scale > 0.0 && view.scale.is_finite()) {
            return invalid(index, "its scale must be above 0 and finite");
        }
        if matches!(view.role, ViewRole::Window { fade, .. } if !(0.0..=0.5).contains(&fade)) {
            return invalid(index, "the fade of its role must be 0 to 0.5");
        }
    }
    let problem = settings.problem();
    problem.map_or(Ok(()), |problem| Err(Input::Setting.invalid(0, problem)))
}

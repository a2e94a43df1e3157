//! Stages of one device, and the preparation of a frame.
use super::{
    CasterSet, Config, Maps, PreparedMaps,
    batch::{
        Batch,
        context::Context,
        plan::{self, PendingView, Plan},
        scratch::Scratch,
    },
    smoothing::{blur::Blur, filter_mips::filter_mips, soften::Soften},
    views::{
        cache::{MapCache, Relocation},
        host_depths::DepthInput,
    },
};
#[cfg(feature = "picture")]
use crate::model::Environment;
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, FETCH_FEATURES, KernelCache, Memory, Tier},
    model::{Class, View},
};
use std::sync::Arc;

/// Kernels of one device; specialised ones are compiled when a scene first needs them.
#[derive(Debug)]
pub struct Pipeline {
    pub(crate) kernels: Kernels,
    /// Configuration of the next frames. Its tier and the adapter's properties must not change.
    pub config: Config,
    may_queue: bool,
    /// Environment of the last picture that had one, and its texels on the device.
    #[cfg(feature = "picture")]
    pub(crate) environment: Option<(Arc<Environment>, wgpu::Texture)>,
}

/// Maps of some views, and their softening.
#[derive(Debug)]
pub(super) struct MapSet {
    pub maps: Maps,
    pub soften: Option<Soften>,
    pub blur: Option<Blur>,
    pub memory: Memory,
}

/// Inputs of one frame.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub device: &'a wgpu::Device,
    pub queue: &'a wgpu::Queue,
    pub casters: &'a CasterSet,
    views: &'a [View],
    /// Expected number of pairs of the largest batch.
    pairs: Option<u32>,
    /// Window of the dither patterns that are softened; 0 if none are [texels].
    window: u32,
    gain: bool,
    colored: bool,
    /// The host's depth maps by view; empty if there are none.
    depths: &'a [Option<DepthInput>],
}

impl<'a> Request<'a> {
    /// The request with depth maps of the host, by view.
    pub(super) fn with_depths(self, depths: &'a [Option<DepthInput>]) -> Self {
        Self { depths, ..self }
    }
}

/// Parts of an earlier frame that are used again.
#[derive(Default)]
struct Reuse {
    /// Maps that keep their rectangles.
    maps: Option<MapSet>,
    /// Maps that move, because the atlas is packed anew.
    relocated: Option<MapSet>,
    scratch: Option<(Arc<Scratch>, Memory)>,
    cache: MapCache,
}

impl Pipeline {
    pub fn new(device: &wgpu::Device, config: Config) -> Result<Self, Error> {
        Self::sharing(device, config, KernelCache::default())
    }

    /// Like [`Self::new`], with kernels shared by all renderers on the device.
    pub fn sharing(
        device: &wgpu::Device,
        config: Config,
        cache: KernelCache,
    ) -> Result<Self, Error> {
        let features = device.features().contains(FETCH_FEATURES);
        let may_queue = config.queued && config.tier == Tier::Native && features;
        let config = Config { queued: may_queue, ..config };
        Ok(Self {
            kernels: Kernels::new(device, config.tier, config.profile, cache),
            config,
            may_queue,
            #[cfg(feature = "picture")]
            environment: None,
        })
    }

    pub fn kernels(&self) -> &Kernels {
        &self.kernels
    }

    /// Allocates the maps of `views` and the frame's scratch memory. `pairs` is the expected number of
    /// pairs of the largest batch; the budget bounds it.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        views: &[View],
        pairs: Option<u32>,
    ) -> Result<PreparedMaps, Error> {
        self.prepare_from(&self.request(device, queue, casters, views, pairs), None)
            .and_then(|prepared| self.finished(prepared))
    }

    /// Like [`Self::prepare`], with the maps of an earlier frame: only those views are recorded whose own
    /// parameters, visible groups or casters within these have changed since it was recorded; the texels of
    /// all others are kept. A view that is rendered has the same bits as in a whole frame of the same
    /// [`CasterSet`], unless pairs go past the budget. If the number of views or a map's size differs, kept
    /// maps are copied to their new rectangles.
    pub fn prepare_again(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        views: &[View],
        pairs: Option<u32>,
        earlier: PreparedMaps,
    ) -> Result<PreparedMaps, Error> {
        self.prepare_from(&self.request(device, queue, casters, views, pairs), Some(earlier))
            .and_then(|prepared| self.finished(prepared))
    }

    pub(super) fn request<'a>(
        &self,
        device: &'a wgpu::Device,
        queue: &'a wgpu::Queue,
        casters: &'a CasterSet,
        views: &'a [View],
        pairs: Option<u32>,
    ) -> Request<'a> {
        Request {
            device,
            queue,
            casters,
            views,
            pairs,
            window: if self.config.soften { casters.dither_window } else { 0 },
            gain: casters.span(Class::LISTS[1].clone()).features.gain,
            colored: self.config.colored && casters.dither_window > 0,
            depths: &[],
        }
    }

    /// Compiles all planned kernels.
    fn finished(&self, prepared: PreparedMaps) -> Result<PreparedMaps, Error> {
        self.kernels.finish()?;
        Ok(prepared)
    }

    /// Prepares a frame whose kernels are planned, but perhaps not compiled yet.
    pub(super) fn prepare_from(
        &mut self,
        request: &Request<'_>,
        earlier: Option<PreparedMaps>,
    ) -> Result<PreparedMaps, Error> {
        self.config.queued &= self.may_queue;
        let nodes = self.config.nodes;
        let &Request { device, queue, casters, views, .. } = request;
        let earlier = earlier.filter(|earlier| self.can_follow(request, earlier));
        let reuse = earlier.map_or_else(Reuse::default, |earlier| Reuse::of(earlier, views));
        let kept = reuse.maps.is_some();
        let set = match reuse.maps {
            Some(set) => set,
            None => MapSet::new(request, &self.config)?,
        };
        let MapSet { maps, soften, blur, memory: maps_memory } = set;
        let maps = Maps { gain: request.gain, ..maps };
        let hides = self.config.hide.then_some(nodes);
        let cache = MapCache::after(reuse.cache, casters, views, hides, request.depths);
        let relocation = reuse.relocated.and_then(|old| {
            Relocation::new(old.maps, old.soften.map(|it| it.raw), cache.kept(), views, &maps)
        });

        let pending: Vec<_> = cache
            .pending
            .iter()
            .map(|&index| PendingView {
                view: &views[index],
                place: maps.places[index],
                groups: cache.groups(index),
                depth: request.depths.get(index).and_then(Option::as_ref),
            })
            .collect();
        let mut plans = plan::batches(&pending, casters, &self.config, kept)?;
        let culled = culled_count(casters, pending.len(), &plans);
        let (mut scratch, mut scratch_memory) = self.scratch(request, reuse.scratch, &plans)?;
        if self.config.count_first {
            let needed = self.count(request, &mut plans, &scratch)?;
            if needed > scratch.pair_capacity {
                let request = &Request { pairs: Some(needed), ..*request };
                (scratch, scratch_memory) = self.scratch(request, None, &plans)?;
            }
        }
        let mut memory = casters.memory();
        for &(name, bytes) in maps_memory.0.iter().chain(&scratch_memory.0) {
            memory.add(name, bytes);
        }
        if let Some(relocation) = &relocation {
            relocation.count(&mut memory);
        }
        let raw = soften.as_ref().map_or(&maps, |soften| &soften.raw);
        if !kept && plans.iter().all(|plan| plan.lists[1].footprint_count == 0) {
            raw.fill_clear(queue);
            plans.iter_mut().for_each(|plan| plan.cleared = true);
        }
        let mut allocator = Allocator { device, memory: &mut memory };
        let host = casters.shared_host();
        let (mut commands, mut counting) = (Commands::new(), Commands::new());
        if let Some(relocation) = &relocation {
            commands.append(relocation.commands(&maps, soften.as_ref().map(|soften| &soften.raw)));
        }
        if let Some(host) = host.as_ref().filter(|_| !plans.is_empty()) {
            commands.append(host.commands());
            counting.append(host.commands());
        }
        let mut counters = Vec::new();
        for plan in &plans {
            let mut context = Context {
                allocator: &mut allocator,
                queue,
                kernels: &self.kernels,
                config: &self.config,
                casters,
                scratch: &scratch,
                camera: false,
                binned_rects: None,
            };
            let batch = Batch::new(&mut context, plan, raw)?;
            commands.append(batch.commands);
            counting.append(batch.counting);
            counters.push(batch.counters);
        }
        let kernels = &self.kernels;
        if let Some(soften) = &soften {
            let over = casters.span(Class::LISTS[1].clone()).features.over;
            let soft = soften.commands(&mut allocator, queue, kernels, &plans, &maps, over)?;
            commands.append(soft);
        }
        if let Some(blur) = &blur {
            commands.append(blur.commands(&mut allocator, queue, kernels, &plans, &maps)?);
        }
        let is_new = relocation.is_some() || !plans.is_empty();
        commands.append(filter_mips(&mut allocator, queue, kernels, views, &maps, is_new)?);
        Ok(PreparedMaps {
            maps,
            commands,
            counting,
            counters,
            host,
            soften,
            blur,
            scratch,
            cache,
            culled,
            maps_memory,
            scratch_memory,
            memory,
        })
    }

    /// Whether maps of `earlier` may be kept.
    fn can_follow(&self, request: &Request<'_>, earlier: &PreparedMaps) -> bool {
        let nodes = self.config.nodes;
        let window = earlier.soften.as_ref().map_or(0, |soften| soften.window);
        // Curves cannot be moved, and all have the same format.
        let same_curves =
            nodes == 0 || (earlier.maps.gain == request.gain && earlier.cache.fits(request.views));
        // Maps with coloured dithering are rendered anew each time.
        !request.colored
            && !earlier.is_colored()
            && window == request.window
            && earlier.blur.as_ref().map_or(0, |blur| blur.radius) == self.config.blur
            && earlier.maps.filters.mip_level_count() == 1 + self.config.mips
            && earlier.maps.nodes == nodes
            && same_curves
    }

    /// Scratch memory of the batches: an earlier frame's if it is large enough.
    fn scratch(
        &self,
        request: &Request<'_>,
        earlier: Option<(Arc<Scratch>, Memory)>,
        plans: &[Plan],
    ) -> Result<(Arc<Scratch>, Memory), Error> {
        let &Request { device, queue, pairs, .. } = request;
        let nodes = self.config.nodes;
        let usable =
            earlier.filter(|(scratch, _)| scratch.fits(device, &self.config, plans, pairs, nodes));
        if let Some(usable) = usable {
            return Ok(usable);
        }
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let scratch = Scratch::new(&mut allocator, queue, &self.config, plans, pairs, nodes)?;
        Ok((Arc::new(scratch), memory))
    }
}

/// Combinations (caster, pending view) that are in no list.
fn culled_count(casters: &CasterSet, view_count: usize, plans: &[Plan]) -> u64 {
    let all: usize = Class::LISTS.map(|list| casters.count(list)).into_iter().sum();
    let listed: u64 = plans.iter().map(Plan::caster_count).sum();
    (all * view_count) as u64 - listed
}

impl MapSet {
    fn new(request: &Request<'_>, config: &Config) -> Result<Self, Error> {
        let &Request { device, queue, views, window, colored, .. } = request;
        let &Config { nodes, blur, mips, .. } = config;
        let mut memory = Memory::default();
        let mut allocator = Allocator { device, memory: &mut memory };
        let mut maps = Maps::new(&mut allocator, queue, views, nodes, colored, window > 0, mips)?;
        let mut soften = None;
        if window > 0 {
            let (soft, softening) = Soften::new(&mut allocator, queue, maps, window)?;
            (maps, soften) = (soft, Some(softening));
        }
        let blur = (blur > 0).then(|| Blur::new(&mut allocator, queue, &maps, blur)).transpose()?;
        Ok(Self { maps, soften, blur, memory })
    }
}

impl Reuse {
    fn of(earlier: PreparedMaps, views: &[View]) -> Self {
        let PreparedMaps { maps, soften, blur, maps_memory, cache, .. } = earlier;
        let PreparedMaps { scratch, scratch_memory, .. } = earlier;
        let set = MapSet { maps, soften, blur, memory: maps_memory };
        let (maps, relocated) =
            if cache.fits(views) { (Some(set), None) } else { (None, Some(set)) };
        Self { maps, relocated, scratch: Some((scratch, scratch_memory)), cache }
    }
}

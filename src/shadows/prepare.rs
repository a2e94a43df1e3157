//! Preparation of a frame: its maps, its scratch memory and its commands.
use super::{
    Config, Maps,
    batch::{
        Batch, BatchInputs,
        batch_plan::{self, BatchPlan, PendingView},
        context::Context,
        scratch::Scratch,
    },
    casters::{CasterSet, host_casters::HostSets},
    pair_capacity::CountedFrames,
    smoothing::{blur::Blur, filter_mips::filter_mips, soften::Soften},
    statistics::Counted,
    views::{
        cache::{MapCache, Relocation},
        host_depths::DepthInput,
    },
};
use crate::{
    error::Error,
    frame::{Commands, Kernels},
    gpu::{Allocator, Memory, allocated},
    model::{Class, View},
    stage::features::Flags,
};
use std::sync::{
    Arc,
    atomic::{AtomicU64, Ordering},
};
use wgpu::Buffer;

/// Maps of some views, and their softening.
#[derive(Debug)]
pub(super) struct MapSet {
    pub maps: Maps,
    soften: Option<Soften>,
    blur: Option<Blur>,
    memory: Memory,
}

/// Maps of a frame, and the state that the next frame takes over with them.
#[derive(Debug)]
pub(super) struct FrameMaps {
    pub set: MapSet,
    scratch: (Arc<Scratch>, Memory),
    pub cache: MapCache,
    made: Option<Made>,
}

/// Commands of a frame.
#[derive(Debug)]
pub(super) struct FrameCommands {
    /// Commands from casters to the maps of all views that must be rendered.
    pub rendering: Commands,
    /// Whether these commands change any map.
    pub draws: bool,
    /// Commands from casters to the number of their pairs.
    pub counting: Commands,
    pub counted: Counted,
    pub memory: Memory,
}

/// Commands of the last frame, and their inputs: the next frame takes them over where only contents differ.
#[derive(Debug)]
struct Made {
    commands: Arc<FrameCommands>,
    plans: Vec<BatchPlan>,
    inputs: Vec<BatchInputs>,
    config: Config,
    /// [`CasterSet::id`].
    casters: u64,
}

/// A frame's maps and commands.
pub(super) struct Frame {
    pub maps: FrameMaps,
    pub commands: Arc<FrameCommands>,
    pub pair_capacity: u32,
    /// Pages of curves; 0 without.
    pub page_capacity: u32,
    /// Combinations (caster, view) that are not projected: their groups are outside the view or wholly
    /// behind an opaque surface.
    pub culled: u64,
}

/// Inputs of one frame.
#[derive(Clone, Copy)]
pub(super) struct Request<'a> {
    pub queue: &'a wgpu::Queue,
    pub kernels: &'a Kernels,
    pub config: &'a Config,
    pub casters: &'a CasterSet,
    pub views: &'a [View],
    /// Expected number of pairs of the largest batch; the budget bounds it.
    pub pairs: Option<u32>,
    /// Expected number of pages of curves.
    pub pages: Option<u32>,
    /// Pairs that casters of the host are expected to need at most, by earlier frames.
    pub expected: Option<u32>,
    /// Earlier frames of as many uploaded casters.
    pub counted_frames: Option<CountedFrames>,
    /// The host's depth maps by view; empty if there are none.
    pub depths: &'a [Option<DepthInput>],
    /// Number of the last frame that was prepared.
    pub last: &'a AtomicU64,
}

/// Maps and memory of an earlier frame that are used again.
#[derive(Default)]
struct Reuse {
    /// Maps that keep their rectangles.
    maps: Option<MapSet>,
    /// Maps that move, because the atlas is packed anew.
    relocated: Option<MapSet>,
    scratch: Option<(Arc<Scratch>, Memory)>,
    cache: MapCache,
    /// The commands, if the maps keep their rectangles.
    made: Option<Made>,
}

impl Reuse {
    fn of(FrameMaps { set, scratch, cache, made }: FrameMaps, views: &[View]) -> Self {
        let scratch = Some(scratch);
        if cache.fits(views) {
            return Self { maps: Some(set), relocated: None, scratch, cache, made };
        }
        Self { maps: None, relocated: Some(set), scratch, cache, made: None }
    }
}

impl MapSet {
    fn new(request: &Request<'_>) -> Result<Self, Error> {
        let &Request { views, config, .. } = request;
        let (window, colored) = (request.window(), request.colored());
        let mut memory = Memory::default();
        let device = request.kernels.device();
        let mut allocator = Allocator::new(device, &mut memory);
        let mut maps = Maps::new(&mut allocator, views, config, colored, window > 0)?;
        let blur = config.settings.blur;
        let mut soften = None;
        if window > 0 {
            let (soft, softening) = Soften::new(&mut allocator, maps, window)?;
            (maps, soften) = (soft, Some(softening));
        }
        let blur = (blur > 0).then(|| Blur::new(&mut allocator, &maps, blur)).transpose()?;
        Ok(Self { maps, soften, blur, memory })
    }

    /// Allocates curves in pages, if the configuration asks for them. `pages`: their number, if known.
    fn add_pages(&mut self, request: &Request<'_>, pages: Option<u32>) -> Result<(), Error> {
        if !self.maps.has_pages() || self.maps.pages.count > 0 {
            return Ok(());
        }
        let count = self.maps.pages.room(pages);
        let device = request.kernels.device();
        let mut allocator = Allocator::new(device, &mut self.memory);
        let maps = &mut self.maps;
        allocated(device, || maps.add_pages(&mut allocator, count))
    }

    /// The maps that casters are rendered into.
    fn raw(&self) -> &Maps {
        self.soften.as_ref().map_or(&self.maps, |soften| &soften.raw)
    }
}

impl<'a> Request<'a> {
    /// Window of the dither patterns that are softened; 0 if none are \[texels\].
    fn window(&self) -> u32 {
        if self.config.settings.soften { self.casters.dither_window } else { 0 }
    }

    fn colored(&self) -> bool {
        self.config.settings.colored && self.casters.dither_window > 0
    }

    /// Whether light may grow along a curve.
    fn grows(&self) -> bool {
        let features = self.casters.span(Class::LISTS[1].clone()).features;
        features.has(Flags::HAS_GAIN) || features.has(Flags::HAS_OVER)
    }

    /// Allocates maps and scratch memory and makes the commands, whose kernels may not be compiled yet. With
    /// the maps of an earlier frame, only views are rendered whose own parameters, visible groups or casters
    /// within these have changed since it was recorded; the texels of all others are kept, or copied to their
    /// new rectangles if the number of views or a map's size differs. A view that is rendered has the same
    /// bits as in a whole frame of the same [`CasterSet`], unless pairs exceed the budget.
    pub(super) fn frame(&self, earlier: Option<FrameMaps>) -> Result<Frame, Error> {
        let &Self { queue, config, casters, views, .. } = self;
        let earlier = earlier.filter(|earlier| self.can_follow(earlier));
        let reuse = earlier.map_or_else(Reuse::default, |earlier| Reuse::of(earlier, views));
        let kept = reuse.maps.is_some();
        let mut set = reuse.maps.map_or_else(|| MapSet::new(self), Ok)?;
        set.maps.gain = self.grows();
        set.maps.clear_sums(queue);
        let hides = config.toggles.hide.then(|| config.nodes());
        let cache = reuse.cache.followed(casters, views, hides, self.depths);
        let relocation = reuse.relocated.and_then(|old| {
            let raw = old.soften.map(|soften| soften.raw);
            Relocation::new(old.maps, raw, cache.kept(), views, &set.maps)
        });
        let mut plans =
            batch_plan::batches(&self.pending(&cache, &set.maps), casters, config, kept)?;
        for list in plans.iter_mut().flat_map(|plan| &mut plan.lists) {
            let has_pages = list.filters && set.maps.has_pages();
            list.features.flags.set(Flags::HAS_PAGES, has_pages);
            let counted = self.counted_frames.filter(|_| list.host.is_none());
            list.expected = if list.host.is_some() {
                self.expected
            } else {
                counted.map(|counted| counted.expected())
            };
            list.had_short_tiles = counted.is_some_and(|counted| counted.had_short_tiles);
        }
        let culled = culled_count(casters, cache.pending.len(), &plans);
        let former = reuse.scratch.as_ref().map(|(scratch, _)| Arc::clone(scratch));
        let (scratch, counted_pages) = self.scratch(reuse.scratch, &mut plans, &set.maps)?;
        let pair_capacity = scratch.0.pair_capacity;
        set.add_pages(self, self.pages.max(counted_pages))?;
        let page_capacity = set.maps.pages.count;
        let same_scratch = former.is_some_and(|former| Arc::ptr_eq(&former, &scratch.0));
        // Up to here the last frame's return value is valid.
        self.last.fetch_add(1, Ordering::Relaxed);
        let made = reuse.made.filter(|made| same_scratch && self.repeats(made, &plans, &scratch.0));
        let made = match made {
            Some(made) => {
                let to = made.inputs.iter().zip(&plans);
                to.for_each(|(inputs, plan)| inputs.write(queue, plan));
                self.kernels.shelf().iter().for_each(|shelf| shelf.overwritten());
                Made { plans, ..made }
            }
            None => self.made(&set, plans, &scratch, relocation.as_ref(), kept)?,
        };
        let commands = Arc::clone(&made.commands);
        let maps = FrameMaps { set, scratch, cache, made: Some(made) };
        Ok(Frame { maps, commands, pair_capacity, page_capacity, culled })
    }

    /// Whether the commands of the last frame serve this one, too.
    fn repeats(&self, made: &Made, plans: &[BatchPlan], scratch: &Scratch) -> bool {
        let host = self.casters.shared_host();
        let is_of = |made: &Option<Arc<HostSets>>| {
            made.as_ref().map(Arc::as_ptr) == host.as_ref().map(Arc::as_ptr)
        };
        let tuning = &self.config.tuning;
        made.config == *self.config
            && self.config.settings.mips == 0
            && made.casters == self.casters.id()
            && is_of(&made.commands.counted.host)
            && made.plans.len() == plans.len()
            && made.plans.iter().zip(plans).all(|(made, plan)| made.is_alike(plan, tuning, scratch))
    }

    /// The commands of a frame.
    fn made(
        &self,
        set: &MapSet,
        mut plans: Vec<BatchPlan>,
        scratch: &(Arc<Scratch>, Memory),
        relocation: Option<&Relocation>,
        kept: bool,
    ) -> Result<Made, Error> {
        let &Self { queue, kernels, config, casters, .. } = self;
        let mut memory = casters.memory();
        memory.add_all(&set.memory);
        memory.add_all(&scratch.1);
        if let Some(relocation) = relocation {
            relocation.count(&mut memory);
        }
        if !kept && !plans.iter().all(BatchPlan::has_depths) {
            set.raw().fill_depths(queue);
        }
        if !kept && plans.iter().all(|plan| plan.lists[1].footprint_count == 0) {
            set.raw().fill_clear(queue);
            plans.iter_mut().for_each(|plan| plan.cleared = true);
        }
        let shelf = kernels.shelf();
        shelf.iter().for_each(|shelf| shelf.turn());
        let allocator = &mut Allocator { shelf, ..Allocator::new(kernels.device(), &mut memory) };
        let (mut rendering, mut counting) = (Commands::new(), Commands::new());
        if let Some(relocation) = relocation {
            let raw = set.soften.as_ref().map(|soften| &soften.raw);
            rendering.append(relocation.commands(&set.maps, raw));
        }
        let host = casters.shared_host();
        if let Some(host) = host.as_ref().filter(|_| !plans.is_empty()) {
            rendering.append(host.commands());
            counting.append(host.commands());
        }
        let (mut lists, mut inputs) = (Vec::new(), Vec::new());
        let batches = plans
            .iter()
            .map(|plan| Batch::new(&mut self.context(allocator, &scratch.0), plan, set.raw()))
            .collect::<Result<Vec<_>, _>>()?;
        // No batch is short of a page that a later one puts back.
        batches.iter().for_each(|batch| rendering.append(batch.releases.clone()));
        for batch in batches {
            rendering.append(batch.commands);
            counting.append(batch.counting);
            lists.push(batch.counters);
            inputs.push(batch.inputs);
        }
        let is_new = relocation.is_some() || !plans.is_empty();
        let views: Vec<_> =
            plans.iter().zip(&inputs).map(|(plan, inputs)| (plan, &inputs.views)).collect();
        rendering.append(self.smoothing(allocator, set, &views, is_new)?);
        let counted = Counted { lists, host };
        let commands =
            Arc::new(FrameCommands { rendering, draws: is_new, counting, counted, memory });
        Ok(Made { commands, plans, inputs, config: *config, casters: casters.id() })
    }

    fn pending<'b>(&'b self, cache: &'b MapCache, maps: &Maps) -> Vec<PendingView<'b>> {
        let pending = cache.pending.iter().map(|&index| PendingView {
            view: &self.views[index],
            slot: maps.slots[index],
            groups: cache.groups(index),
            depth: self.depths.get(index).and_then(Option::as_ref),
        });
        pending.collect()
    }

    pub(super) fn context<'b, 'd>(
        &'b self,
        allocator: &'b mut Allocator<'d>,
        scratch: &'b Arc<Scratch>,
    ) -> Context<'b, 'd> {
        let &Self { queue, kernels, config, casters, .. } = self;
        Context {
            allocator,
            queue,
            kernels,
            config,
            casters,
            scratch,
            camera: false,
            binned_rects: None,
        }
    }

    /// Commands after all batches. `is_new`: whether a filter map has changed.
    fn smoothing(
        &self,
        allocator: &mut Allocator<'_>,
        MapSet { maps, soften, blur, .. }: &MapSet,
        batches: &[(&BatchPlan, &Buffer)],
        is_new: bool,
    ) -> Result<Commands, Error> {
        let &Self { kernels, views, .. } = self;
        let mut commands = Commands::new();
        if let Some(soften) = soften {
            commands.append(soften.commands(kernels, batches, maps)?);
        }
        if let Some(blur) = blur {
            commands.append(blur.commands(kernels, batches, maps)?);
        }
        commands.append(filter_mips(allocator, kernels, views, maps, is_new)?);
        Ok(commands)
    }

    /// Whether maps of `earlier` may be kept.
    fn can_follow(&self, FrameMaps { set, cache, .. }: &FrameMaps) -> bool {
        let (nodes, settings) = (self.config.nodes(), &self.config.settings);
        let window = set.soften.as_ref().map_or(0, |soften| soften.window);
        // Curves cannot be moved, and all have the same format.
        let same_curves = nodes == 0 || (set.maps.gain == self.grows() && cache.fits(self.views));
        // Maps with coloured dithering are rendered anew each time.
        !self.colored()
            && set.raw().colored.is_none()
            && window == self.window()
            && set.blur.as_ref().map_or(0, |blur| blur.radius) == settings.blur
            && set.maps.filters.mip_level_count() == 1 + settings.mips
            && set.maps.nodes == nodes
            && set.maps.sums.is_some() == self.config.toggles.sums
            && set.maps.has_pages_as(self.config)
            && set.maps.pages.suffice(self.pages)
            && same_curves
    }
}

/// Combinations (caster, pending view) that are in no list.
fn culled_count(casters: &CasterSet, view_count: usize, plans: &[BatchPlan]) -> u64 {
    let all: usize = Class::LISTS.map(|list| casters.count(list)).into_iter().sum();
    let listed: u64 = plans.iter().map(BatchPlan::caster_count).sum();
    (all * view_count) as u64 - listed
}

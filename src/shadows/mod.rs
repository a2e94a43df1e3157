//! The whole frame on the GPU: casters and views in, shadow maps out.
//!
//! A guest in its host's renderer: [`Pipeline::prepare`] uploads and allocates,
//! [`Prepared::record`] only records into the host's encoder; nothing here submits or waits.
mod bake;
mod batch;
mod casters;
mod config;
pub(crate) mod context;
pub mod cull;
mod filter;
mod groups;
pub(crate) mod kernels;
pub(crate) mod list;
mod maps;
mod moved;
pub(crate) mod plan;
pub(crate) mod scratch;
mod small;

pub use casters::{CasterSet, Span};
pub use config::Config;
pub use groups::{Extent, Group};
pub use kernels::Kernels;
pub use list::ListCounters;
pub use maps::Maps;
pub use small::{SMALL_SIDE, TriangleExtent};

use crate::{
    error::Error,
    gpu::{Allocator, FETCH_FEATURES, Memory, Tier, Timeline},
    model::View,
};
use bake::Bake;
use batch::Batch;
use context::Context;
use filter::Filter;
use moved::Moved;
use plan::{LISTS, PendingView, Plan};
use scratch::Scratch;
use std::sync::Arc;

/// Kernels of one device; makes the specialised ones when a scene first needs them.
#[derive(Debug)]
pub struct Pipeline {
    pub(crate) kernels: Kernels,
    pub(crate) config: Config,
    /// What the device allows.
    may_queue: bool,
}

/// A scene's maps on the GPU and all it takes to fill them.
#[derive(Debug)]
pub struct Prepared {
    pub maps: Maps,
    batches: Vec<Batch>,
    filter: Option<Filter>,
    scratch: Arc<Scratch>,
    bake: Bake,
    moved: Option<Moved>,
    culled: u64,
    maps_memory: Memory,
    scratch_memory: Memory,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

impl Pipeline {
    pub fn new(device: &wgpu::Device, mut config: Config) -> Result<Self, Error> {
        config.queued &= config.tier == Tier::Native && device.features().contains(FETCH_FEATURES);
        let kernels = Kernels::new(device, config)?;
        Ok(Self { kernels, config, may_queue: config.queued })
    }

    pub fn config(&self) -> &Config {
        &self.config
    }

    /// For the next `prepare`.
    pub fn set_pair_budget(&mut self, pairs: u32) {
        self.config.pair_budget = pairs;
    }

    /// For the next `prepare`.
    pub fn set_scatter_tiny(&mut self, scatter: bool) {
        self.config.scatter_tiny = scatter;
    }

    /// For the next `prepare`.
    pub fn set_soften(&mut self, soften: bool) {
        self.config.soften = soften;
    }

    /// For the next `prepare`.
    pub fn set_colored(&mut self, colored: bool) {
        self.config.colored = colored;
    }

    /// K of the curves, 0 for none; for the next `prepare`.
    pub fn set_nodes(&mut self, nodes: u32) {
        self.config.nodes = nodes;
    }

    /// For the next `prepare`; nothing where it was off from the start.
    pub fn set_queued(&mut self, queued: bool) {
        self.config.queued = queued && self.may_queue;
    }

    /// For the next `prepare_picture`.
    pub fn set_count_cost(&mut self, count_cost: bool) {
        self.config.count_cost = count_cost;
    }

    /// For the next `prepare`.
    pub fn set_hide(&mut self, hide: bool) {
        self.config.hide = hide;
    }

    pub fn kernels(&mut self) -> &mut Kernels {
        &mut self.kernels
    }

    /// Allocates the maps of `views` and what the frame needs on the way. `pairs` is how many
    /// pairs the largest batch is thought to have; the budget bounds it.
    pub fn prepare(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        views: &[View],
        pairs: Option<u32>,
    ) -> Result<Prepared, Error> {
        self.prepare_from(None, device, queue, casters, views, pairs)
    }

    /// As [`Self::prepare`], with the maps of an earlier frame: only those views are recorded
    /// whose own numbers, visible groups or something within these have changed since it was
    /// recorded; the texels of all others stay. A view that is rendered has the same bits as in a
    /// whole frame of the same [`CasterSet`], unless pairs go past the budget. Where the number of
    /// views or a map's size differs, the maps that stay are copied to their new places.
    pub fn prepare_again(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        views: &[View],
        pairs: Option<u32>,
        earlier: Prepared,
    ) -> Result<Prepared, Error> {
        self.prepare_from(Some(earlier), device, queue, casters, views, pairs)
    }

    fn prepare_from(
        &mut self,
        earlier: Option<Prepared>,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        casters: &CasterSet,
        views: &[View],
        pairs: Option<u32>,
    ) -> Result<Prepared, Error> {
        let window = if self.config.soften { casters.dither_window } else { 0 };
        let nodes = self.config.nodes;
        let gain = casters.span(LISTS[1].clone()).features.gain;
        let colored = self.config.colored && casters.dither_window > 0;
        let earlier = earlier
            // Channels are rendered anew each time.
            .filter(|earlier| !colored && !earlier.is_colored())
            .filter(|earlier| earlier.filter.as_ref().map_or(0, |filter| filter.window) == window)
            // Curves stay in their places only, and all are written alike.
            .filter(|earlier| {
                let same_curves = earlier.maps.gain == gain && earlier.bake.fits(views);
                earlier.maps.nodes == nodes && (nodes == 0 || same_curves)
            });
        let (mut old, mut maps, mut scratch) = (None, None, None);
        let mut bake = Bake::default();
        if let Some(earlier) = earlier {
            let of_maps = (earlier.maps, earlier.filter, earlier.maps_memory);
            if earlier.bake.fits(views) {
                maps = Some(of_maps);
            } else {
                old = Some(of_maps);
            }
            bake = earlier.bake;
            scratch = Some((earlier.scratch, earlier.scratch_memory));
        }
        let kept = maps.is_some();
        let (maps, mut filter, maps_memory) = match maps {
            Some(maps) => maps,
            None => new_maps(device, queue, views, window, nodes, colored)?,
        };
        let maps = Maps { gain, ..maps };
        let bake = Bake::after(bake, casters, views, self.config.hide.then_some(nodes));
        let moved = old.and_then(|(old, old_filter, _)| {
            Moved::new(old, old_filter, bake.kept(), views, &maps)
        });
        let pending = bake.pending.iter().map(|&index| PendingView {
            view: &views[index],
            place: maps.places[index],
            groups: bake.groups(index),
        });
        let pending: Vec<_> = pending.collect();
        let all: usize = LISTS.map(|list| casters.span(list).count()).into_iter().sum();
        let mut plans = plan::batches(&pending, casters, &self.config, kept)?;
        let listed: u64 = plans.iter().map(Plan::caster_count).sum();
        let culled = (all * pending.len()) as u64 - listed;

        let usable =
            scratch.filter(|(scratch, _)| scratch.fits(device, &self.config, &plans, pairs, nodes));
        let (scratch, scratch_memory) = if let Some(usable) = usable {
            usable
        } else {
            let mut memory = Memory::default();
            let mut allocator = Allocator { device, memory: &mut memory };
            let scratch = Scratch::new(&mut allocator, queue, &self.config, &plans, pairs, nodes)?;
            (Arc::new(scratch), memory)
        };
        let mut memory = casters.memory.clone();
        for &(name, bytes) in maps_memory.0.iter().chain(&scratch_memory.0) {
            memory.add(name, bytes);
        }
        if let Some(moved) = &moved {
            moved.count(&mut memory);
        }
        let mut allocator = Allocator { device, memory: &mut memory };
        let raw = filter.as_ref().map_or(&maps, |filter| &filter.raw);
        if !kept && plans.iter().all(|plan| plan.lists[1].footprint_count == 0) {
            raw.fill_clear(queue);
            plans.iter_mut().for_each(|plan| plan.cleared = true);
        }
        let mut batches = Vec::with_capacity(plans.len());
        for plan in &plans {
            let mut context = Context {
                allocator: &mut allocator,
                queue,
                kernels: &mut self.kernels,
                config: &self.config,
                casters,
                scratch: &scratch,
                camera: false,
                binned_rects: None,
            };
            batches.push(Batch::new(&mut context, plan, raw)?);
        }
        if let Some(filter) = &mut filter {
            filter.bind(&mut allocator, queue, &self.kernels, &plans, &maps)?;
        }
        Ok(Prepared {
            maps,
            batches,
            filter,
            scratch,
            bake,
            moved,
            culled,
            maps_memory,
            scratch_memory,
            memory,
        })
    }
}

/// Maps of `views`, what softens them, and their sizes.
fn new_maps(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    views: &[View],
    window: u32,
    nodes: u32,
    colored: bool,
) -> Result<(Maps, Option<Filter>, Memory), Error> {
    let mut memory = Memory::default();
    let mut allocator = Allocator { device, memory: &mut memory };
    let maps = Maps::new(&mut allocator, queue, views, nodes, colored)?;
    if window == 0 {
        return Ok((maps, None, memory));
    }
    let (soft, filter) = Filter::new(&mut allocator, queue, maps, window)?;
    Ok((soft, Some(filter), memory))
}

impl Prepared {
    fn is_colored(&self) -> bool {
        self.filter.as_ref().map_or(&self.maps, |filter| &filter.raw).colored.is_some()
    }

    /// Pairs that a batch has room for.
    pub fn pair_capacity(&self) -> u32 {
        self.scratch.pair_capacity
    }

    /// Views that [`Self::record`] renders; the others are as they were.
    pub fn rendered_count(&self) -> usize {
        self.bake.pending.len()
    }

    pub fn view_count(&self) -> usize {
        self.bake.view_count()
    }

    /// (caster, view) that are not even projected: their groups are outside the view or wholly
    /// behind an opaque surface.
    pub fn culled_count(&self) -> u64 {
        self.culled
    }

    /// Of those, the ones behind an opaque surface.
    pub fn hidden_count(&self) -> u64 {
        self.bake.hidden_count()
    }

    /// Has the next [`Pipeline::prepare_again`] render again what this one does, as when pairs
    /// did not fit.
    pub fn forget(&mut self) {
        self.bake.forget();
    }

    /// Records every stage of every view that must be rendered.
    pub fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        if let Some(moved) = &self.moved {
            moved.record(&self.maps, self.filter.as_ref(), encoder);
        }
        for batch in &self.batches {
            batch.record(kernels, encoder, timeline);
        }
        if let Some(filter) = &self.filter {
            filter.record(kernels, encoder, timeline);
        }
        self.bake.mark_recorded();
    }

    /// What the last frame counted; blocks. `(opaque, translucent)`, summed over the batches.
    pub fn read_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<(ListCounters, ListCounters), Error> {
        let mut sums = (ListCounters::default(), ListCounters::default());
        for batch in &self.batches {
            let (opaque, translucent) = batch.read_counters(device, queue)?;
            sums.0.add(&opaque);
            sums.1.add(&translucent);
        }
        Ok(sums)
    }
}

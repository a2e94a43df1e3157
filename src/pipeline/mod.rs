//! The whole frame on the GPU: casters and views in, shadow maps out.
//!
//! A guest in its host's renderer: [`Pipeline::prepare`] uploads and allocates,
//! [`Prepared::record`] only records into the host's encoder; nothing here submits or waits.
mod air;
mod batch;
mod casters;
mod filter;
mod kernels;
mod list;
mod maps;
mod picture;

pub use casters::{CasterSet, Class, Span};
pub use kernels::Kernels;
pub use list::ListCounters;
pub use maps::{MapPlace, Maps};
pub use picture::PreparedPicture;

use crate::{
    error::Error,
    gpu::{Allocator, Memory, Tier, Timeline},
    stage::sort,
    view::View,
};
use batch::Batch;
use filter::Filter;
use list::Scratch;
use std::sync::Arc;

/// How the pipeline runs on a device.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    pub tier: Tier,
    pub sort: sort::Shape,
    /// Pairs that one batch may hold; what does not fit takes the scatter path.
    pub pair_budget: u32,
    /// Whether particles of at most 2x2 texels skip sort and bin. Off on software adapters, whose
    /// atomics cost more than their sort.
    pub scatter_tiny: bool,
    /// Whether dithered surfaces become a grey filter.
    pub soften: bool,
    /// Whether dithered casters block each channel by a threshold of its own.
    pub colored: bool,
}

impl Config {
    pub fn new(tier: Tier, adapter: &wgpu::AdapterInfo) -> Self {
        Self {
            tier,
            sort: sort::Shape::of(adapter),
            pair_budget: 1 << 24,
            scatter_tiny: adapter.device_type != wgpu::DeviceType::Cpu,
            soften: false,
            colored: false,
        }
    }
}

/// Kernels of one device; makes the specialised ones when a scene first needs them.
#[derive(Debug)]
pub struct Pipeline {
    kernels: Kernels,
    config: Config,
}

/// A scene's maps on the GPU and all it takes to fill them.
#[derive(Debug)]
pub struct Prepared {
    pub maps: Maps,
    batches: Vec<Batch>,
    filter: Option<Filter>,
    pair_capacity: u32,
    /// Bytes by buffer and texture.
    pub memory: Memory,
}

impl Pipeline {
    pub fn new(device: &wgpu::Device, config: Config) -> Self {
        Self { kernels: Kernels::new(device, config), config }
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
        let mut memory = casters.memory.clone();
        let mut allocator = Allocator { device, memory: &mut memory };
        let colored = self.config.colored && casters.dither_window > 0;
        let maps = Maps::new(&mut allocator, queue, views, colored)?;
        let plans = batch::plan(views, casters, &maps)?;
        let scratch = Arc::new(Scratch::new(&mut allocator, &self.config, &plans, pairs)?);
        let mut batches = Vec::with_capacity(plans.len());
        for plan in &plans {
            let mut context = batch::Context {
                allocator: &mut allocator,
                queue,
                kernels: &mut self.kernels,
                config: &self.config,
                casters,
                scratch: &scratch,
                camera: false,
            };
            batches.push(Batch::new(&mut context, plan, &maps)?);
        }
        let window = if self.config.soften { casters.dither_window } else { 0 };
        let (maps, filter) = if window > 0 {
            let (maps, filter) =
                Filter::new(&mut allocator, queue, &self.kernels, &plans, &maps, window)?;
            (maps, Some(filter))
        } else {
            (maps, None)
        };
        Ok(Prepared { maps, batches, filter, pair_capacity: scratch.pair_capacity, memory })
    }
}

impl Prepared {
    /// Pairs that a batch has room for.
    pub fn pair_capacity(&self) -> u32 {
        self.pair_capacity
    }

    /// Records every stage of every view.
    pub fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        for batch in &self.batches {
            batch.record(kernels, encoder, timeline);
        }
        if let Some(filter) = &self.filter {
            filter.record(kernels, encoder, timeline);
        }
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

//! Stages from casters to each tile's pairs: project, sort and bin, for one list of one batch.
use super::{
    context::{ChunkBuffers, Context},
    frame::{self, Choices, Conditions, Groups, Part, Role, SortOf, Work},
    host_list::HostChunks,
    kernels::Kernels,
    parts::Parts,
    plan::ListPlan,
    read_back::ReadBack,
    scratch::Scratch,
};
use crate::{
    error::Error,
    gpu::Timeline,
    records::DEPTH_BITS,
    stage::{
        bin::{self, BatchCounters, BinParams},
        formula::{Number, Numbers},
        sort::{SortBindings, SortCount},
    },
};
use wgpu::{BindGroup, Buffer};

/// Counters of one list.
pub type ListCounters = BatchCounters;

impl ListCounters {
    pub(crate) fn add(&mut self, other: &Self) {
        self.pairs_needed = self.pairs_needed.max(other.pairs_needed);
        self.pair_count += other.pair_count;
        self.visible += other.visible;
        self.scattered += other.scattered;
        self.overflowed += other.overflowed;
        self.segment_count += other.segment_count;
        self.merged_count += other.merged_count;
        self.disordered += other.disordered;
        self.in_parts += other.in_parts;
    }
}

/// One list, bound and ready to be recorded.
#[derive(Debug)]
pub(crate) struct List {
    pub footprint_count: u32,
    /// Whether a tile may have more pairs than a segment.
    pub has_segments: bool,
    /// Inputs of sizes and workgroup counts.
    pub numbers: Numbers,
    /// Conditions, but for those of the readers.
    pub conditions: Conditions,
    pub choices: Choices,
    /// Chunks of host casters, whose number is known on the device only.
    pub host_chunks: Option<HostChunks>,
    counters: ReadBack<BatchCounters>,
    depth_sort: Option<SortBindings>,
    tile_sort: Option<SortBindings>,
    /// Index of the pair texture that holds the sorted pairs.
    #[cfg_attr(not(feature = "picture"), expect(dead_code, reason = "only pictures read it"))]
    pub sorted_pairs: usize,
    /// The way of its casters where their pairs may not fit.
    pub parts: Option<Parts>,
    bound: Vec<(Role, BindGroup)>,
}

impl List {
    pub(crate) fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        views: &Buffer,
        view_count: u32,
        tile_count: u32,
    ) -> Result<Self, Error> {
        let scratch: &Scratch = context.scratch;
        let Scratch { keys, pairs, .. } = scratch;
        let device = context.allocator.device;
        let particle_chunks = context.chunk_buffers(plan, &plan.particle_chunks)?;
        let triangle_chunks = context.chunk_buffers(plan, &plan.triangle_chunks)?;
        let host = plan.host.as_ref().zip(context.casters.host());
        let mut host_chunks =
            host.map(|host| HostChunks::new(context, plan, host, views)).transpose()?;
        let counted = ReadBack::<BatchCounters>::new(context.allocator, "counters")?;
        let counters = counted.buffer();
        let shape = context.config.profile.shape;
        let numbers = plan
            .numbers(shape)
            .with(Number::PairCapacity, scratch.pair_capacity)
            .with(Number::TileCount, tile_count)
            .with(Number::ViewCount, view_count);
        let conditions = plan.conditions(shape, scratch.pair_capacity);
        let params = context.uniform("bin_params", &BinParams::of(&numbers));
        let (mut depth_sort, mut tile_sort) = (None, None);
        if plan.footprint_count > 0 {
            let sort = &context.kernels.sort;
            let known = SortCount::Known(plan.footprint_count);
            let mut depth = sort.bind(device, [&keys[0], &keys[1]], known, 0..DEPTH_BITS)?;
            depth.write_count(context.queue, plan.footprint_count);
            let counted = SortCount::FromBuffer {
                counts: counters,
                index: bin::PAIR_COUNT_INDEX,
                capacity: scratch.pair_capacity,
            };
            let bits = bin::TILE_BITS.count(&numbers);
            let tile = sort.bind(device, [&pairs[0], &pairs[1]], counted, 0..bits)?;
            context.allocator.memory.add("histograms", depth.scratch_size() + tile.scratch_size());
            (depth_sort, tile_sort) = (Some(depth), Some(tile));
        }
        if let Some(host) = &mut host_chunks {
            host.count_into(&params, depth_sort.as_ref().and_then(SortBindings::count_buffer));
        }
        let sorted =
            [&depth_sort, &tile_sort].map(|sort| sort.as_ref().map_or(0, SortBindings::result));
        let choices = Choices {
            curves: plan.features.nodes > 0 && !context.camera,
            composed: plan.is_composed(),
            sorted,
        };
        let mut resources =
            context.resources(views).with("bin_params", &params).with("counters", counters);
        for (chunks, names) in [
            (&particle_chunks, ["particle_chunks", "particle_params"]),
            (&triangle_chunks, ["triangle_chunks", "triangle_params"]),
        ] {
            if let Some(ChunkBuffers { chunks, params, .. }) = chunks {
                resources = resources.with(names[0], chunks).with(names[1], params);
            }
        }
        let mut bound = Vec::new();
        for (role, sources) in frame::kernels(conditions) {
            let Some(kernel) = context.kernels.of_list(role) else { continue };
            let mut own = frame::bound(sources, &resources, choices);
            if let (Role::BinCount | Role::BinEmit, Some(rects)) = (role, context.binned_rects) {
                own = own.with("rects", rects);
            }
            bound.push((role, kernel.bind(device, &own)?));
        }
        let parts = Parts::new(context, plan, tile_count, &resources, choices)?;
        Ok(Self {
            footprint_count: plan.footprint_count,
            has_segments: plan.has_segments(),
            numbers,
            conditions,
            choices,
            host_chunks,
            counters: counted,
            depth_sort,
            tile_sort,
            sorted_pairs: sorted[1],
            parts,
            bound,
        })
    }

    /// project: footprints, keys and rectangles.
    pub(crate) fn record_project(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        if self.footprint_count == 0 {
            return;
        }
        if let Some(host) = &self.host_chunks {
            host.record_cull(kernels, encoder, timeline);
        }
        let mut pass = timeline.pass(encoder, "gobo project");
        self.record_steps(Part::Project, kernels, &mut pass);
        if let Some(host) = &self.host_chunks {
            host.record_project(kernels, &mut pass);
        }
    }

    pub(crate) fn counters(&self) -> &Buffer {
        self.counters.buffer()
    }

    /// Records sort and bin, up to the pairs in depth order and the list of overflowing footprints. Returns
    /// false if there is no caster.
    pub(crate) fn record_emit(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) -> bool {
        self.record_sort(kernels, encoder, timeline)
            && self.record_pairs(kernels, encoder, timeline)
    }

    /// Records the sort of footprints front to back. Returns false if there is none.
    pub(crate) fn record_sort(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) -> bool {
        if self.footprint_count == 0 {
            return false;
        }
        self.record_steps(Part::Sort, kernels, &mut timeline.pass(encoder, "gobo sort"));
        true
    }

    /// Records the first steps of bin, after the sort. Returns false if there is no caster.
    pub(crate) fn record_pairs(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) -> bool {
        if self.footprint_count == 0 {
            return false;
        }
        self.record_steps(Part::Pairs, kernels, &mut timeline.pass(encoder, "gobo bin"));
        true
    }

    /// Records the rest of bin: each tile's pairs, and the segments of long tiles.
    pub(crate) fn record_tiles(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        self.record_steps(Part::Tiles, kernels, &mut timeline.pass(encoder, "gobo bin"));
    }

    fn record_steps(&self, part: Part, kernels: &Kernels, pass: &mut wgpu::ComputePass<'_>) {
        for step in frame::steps(part).iter().filter(|step| self.conditions.hold(step.when)) {
            match step.work {
                Work::Sort(of) => {
                    let sort = match of {
                        SortOf::Depth => &self.depth_sort,
                        SortOf::Tile => &self.tile_sort,
                    };
                    sort.iter().for_each(|sort| kernels.sort.record(pass, sort));
                }
                Work::Kernel { role, groups: Groups::Counts(groups), .. } => {
                    let bound = self.bound.iter().find(|(of, _)| *of == role);
                    if let Some(((_, bindings), kernel)) = bound.zip(kernels.of_list(role)) {
                        kernel.record(pass, bindings, groups.map(|n| n.count(&self.numbers)));
                    }
                }
                Work::Kernel { .. } | Work::Clear(_) => {}
            }
        }
    }

    pub(crate) fn counted(&self) -> &ReadBack<ListCounters> {
        &self.counters
    }

    pub(crate) fn read_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<ListCounters, Error> {
        self.counters.read(device, queue)
    }
}

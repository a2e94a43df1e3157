//! Stages from casters to each tile's pairs: project, sort and bin, for one list of one batch.
use super::{
    context::{ChunkBuffers, Chunks, Context},
    host_list::HostChunks,
    kernels::{Kernels, OnDemand},
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
        project::grid,
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
    }
}

/// One list, bound and ready to be recorded.
#[derive(Debug)]
pub(crate) struct List {
    pub footprint_count: u32,
    /// Whether a tile may have more pairs than a segment.
    pub has_segments: bool,
    /// Whether some footprints' pairs may not fit.
    pub may_overflow: bool,
    run_count: u32,
    tile_count: u32,
    particle_chunks: Option<Chunks>,
    triangle_chunks: Option<Chunks>,
    /// Chunks of host casters, whose number is known on the device only.
    pub host_chunks: Option<HostChunks>,
    counters: ReadBack<BatchCounters>,
    depth_sort: Option<SortBindings>,
    tile_sort: Option<SortBindings>,
    /// Index of the pair texture that holds the sorted pairs.
    pub sorted_pairs: usize,
    count: BindGroup,
    scan: BindGroup,
    emit: BindGroup,
    tiles: BindGroup,
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
        let bind_chunks = |kernel: &OnDemand, buffers: ChunkBuffers| {
            let resources = context.resources(views).and(&buffers.resources());
            let bindings = kernel.bind(device, &resources.with("keys", &keys[0]))?;
            Ok::<_, Error>(Chunks { count: buffers.count, bindings })
        };
        let particle_chunks = particle_chunks
            .map(|buffers| bind_chunks(&context.kernels.project_particles, buffers))
            .transpose()?;
        let triangle_chunks = triangle_chunks
            .map(|buffers| bind_chunks(&context.kernels.project_triangles, buffers))
            .transpose()?;
        let host = plan.host.as_ref().zip(context.casters.host());
        let mut host_chunks =
            host.map(|host| HostChunks::new(context, plan, host, views)).transpose()?;
        let counted = ReadBack::<BatchCounters>::new(context.allocator, "counters")?;
        let counters = counted.buffer();
        let curved = plan.features.nodes > 0 && !context.camera;
        let shape = context.config.profile.shape;
        let run_length = bin::run_length(shape, plan.footprint_count);
        let run_count = plan.footprint_count.div_ceil(run_length);
        let params = context.uniform(
            "bin_params",
            &BinParams {
                footprint_count: plan.footprint_count,
                run_length,
                run_count,
                pair_capacity: scratch.pair_capacity,
                tile_count,
                view_count,
                segment_capacity: scratch.segment_capacity,
                segment_length: plan.segment_length(),
            },
        );
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
            let bits = (32 - (tile_count - 1).leading_zeros()).max(1);
            let tile = sort.bind(device, [&pairs[0], &pairs[1]], counted, 0..bits)?;
            context.allocator.memory.add("histograms", depth.scratch_size() + tile.scratch_size());
            (depth_sort, tile_sort) = (Some(depth), Some(tile));
        }
        if let Some(host) = &mut host_chunks {
            host.count_into(&params, depth_sort.as_ref().and_then(SortBindings::count_buffer));
        }
        let sorted_pairs = tile_sort.as_ref().map_or(0, SortBindings::result);
        let kernels = &context.kernels;
        let resources = context
            .resources(views)
            .with("bin_params", &params)
            .with("counters", counters)
            .with("sorted", &keys[depth_sort.as_ref().map_or(0, SortBindings::result)]);
        let binned = match context.binned_rects {
            Some(rects) => resources.clone().with("rects", rects),
            None => resources.clone(),
        };
        let count = kernels.bin_count.bind(device, &binned)?;
        let scan = kernels.bin_scan.bind(device, &resources)?;
        let emit = kernels.bin_emit.bind(device, &binned.with("pairs", &pairs[0]))?;
        let scattered = if curved { &scratch.nothing_scattered } else { &scratch.scattered_tiles };
        let resources = resources.with("pairs", &pairs[sorted_pairs]);
        let tiles =
            kernels.bin_tiles.bind(device, &resources.with("scattered_tiles", scattered))?;
        Ok(Self {
            footprint_count: plan.footprint_count,
            has_segments: plan.has_segments(),
            may_overflow: plan.may_overflow(shape, scratch.pair_capacity),
            run_count,
            tile_count,
            particle_chunks,
            triangle_chunks,
            host_chunks,
            counters: counted,
            depth_sort,
            tile_sort,
            sorted_pairs,
            count,
            scan,
            emit,
            tiles,
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
        if let Some(chunks) = &self.particle_chunks {
            kernels.project_particles.record(&mut pass, &chunks.bindings, grid(chunks.count));
        }
        if let Some(chunks) = &self.triangle_chunks {
            kernels.project_triangles.record(&mut pass, &chunks.bindings, grid(chunks.count));
        }
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
        let Some(depth_sort) = &self.depth_sort else { return false };
        kernels.sort.record(&mut timeline.pass(encoder, "gobo sort"), depth_sort);
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
        let mut pass = timeline.pass(encoder, "gobo bin");
        let runs = [self.run_count.div_ceil(bin::lanes(kernels.profile.shape)), 1, 1];
        kernels.bin_count.record(&mut pass, &self.count, runs);
        kernels.bin_scan.record(&mut pass, &self.scan, [1, 1, 1]);
        kernels.bin_emit.record(&mut pass, &self.emit, runs);
        true
    }

    /// Records the rest of bin: each tile's pairs, and the segments of long tiles.
    pub(crate) fn record_tiles(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let mut pass = timeline.pass(encoder, "gobo bin");
        if let Some(tile_sort) = &self.tile_sort {
            kernels.sort.record(&mut pass, tile_sort);
        }
        let groups = [self.tile_count.div_ceil(bin::TILE_LANES), 1, 1];
        kernels.bin_tiles.record(&mut pass, &self.tiles, groups);
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

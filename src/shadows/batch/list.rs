//! Stages from casters to each tile's pairs: project, sort and bin, for one list of one batch.
use crate::shadows::batch::{
    context::Context, host_chunks::HostChunks, list_plan::ListPlan, parts::Parts, scratch::Scratch,
};
use crate::{
    error::Error,
    frame::{Commands, Sort, SortCount},
    gpu::Resources,
    records::DEPTH_BITS,
    stage::{
        bin::{self, BatchCounters, BinParams},
        features::{Features, Flags},
        project::{self, grid},
    },
};
use wgpu::{Buffer, BufferUsages};

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

/// The commands of one list, stage by stage. Without casters all but `clear` and `tiles` are empty.
#[derive(Debug)]
pub(crate) struct List {
    pub footprint_count: u32,
    /// Resets counters and workgroup counts.
    pub clear: Commands,
    /// Footprints, keys and rectangles.
    pub project: Commands,
    /// Footprints front to back.
    pub sort: Commands,
    /// Pairs in depth order, and the footprints whose pairs did not fit.
    pub pairs: Commands,
    /// Pairs of each tile, and the segments of long tiles.
    pub tiles: Commands,
    /// Index of the pair texture that holds the sorted pairs.
    pub sorted_pairs: usize,
    /// The parts of its tiles, where the pairs may not fit.
    pub parts: Option<Parts>,
    /// Chunks of Gaussians, particles and triangles.
    pub chunks: [Option<Buffer>; 3],
    /// Chunks of host casters, whose number is known on the device only.
    pub host_chunks: Option<HostChunks>,
    pub counters: Buffer,
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
        let counters =
            context.allocator.storage::<BatchCounters>("counters", 1, BufferUsages::COPY_SRC)?;
        let shape = context.config.profile.shape;
        let values = BinParams::new(
            shape,
            plan.footprint_count,
            context.pair_capacity(plan),
            tile_count,
            view_count,
            plan.segment_length(&context.config.profile),
        );
        let chunks = [
            (&project::GAUSSIANS, context.chunk_buffers(plan, &plan.gaussian_chunks)?),
            (&project::PARTICLES, context.chunk_buffers(plan, &plan.particle_chunks)?),
            (&project::TRIANGLES, context.chunk_buffers(plan, &plan.triangle_chunks)?),
        ];
        let params = context.uniform("bin_params", &values);
        let host = plan.host.as_ref().zip(context.casters.host());
        let host = host.map(|host| HostChunks::new(context, plan, host)).transpose()?;
        let kernels = context.kernels;
        let sorts = if plan.footprint_count > 0 {
            let known = SortCount::Known(plan.footprint_count);
            let [a, b] = &scratch.keys;
            let by_depth = Sort::new(kernels, [a, b], known, 0..DEPTH_BITS)?;
            let counted = SortCount::FromBuffer {
                counts: &counters,
                index: bin::PAIR_COUNT_INDEX,
                capacity: scratch.pair_capacity,
            };
            let [a, b] = &scratch.pairs;
            let by_tile = Sort::new(kernels, [a, b], counted, 0..bin::tile_bits(tile_count))?;
            let bytes = by_depth.scratch_size() + by_tile.scratch_size();
            context.allocator.memory.add("histograms", bytes);
            Some((by_depth, by_tile))
        } else {
            None
        };
        let resources =
            context.resources(views).with("bin_params", &params).with("counters", &counters);
        // Of these kernels, only `project` and those of outlines depend on kinds of casters and views.
        const KINDS: Flags = Flags::HAS_BRICKS
            .union(Flags::HAS_GAUSSIANS)
            .union(Flags::HAS_CAPSULES)
            .union(Flags::HAS_VERTEX_COLORS)
            .union(Flags::PARALLEL);
        let kinds = plan.features.flags & KINDS;
        let features = Features::NONE.with(kinds, true);
        let run = |desc, resources: &Resources<'_>, groups: [u32; 3]| {
            kernels.dispatch(desc, features, resources, groups)
        };

        let mut clear = Commands::new();
        for buffer in [&counters, &scratch.dispatches, &scratch.scattered_tiles] {
            clear.clear("gobo clear", buffer);
        }
        let (mut project, mut sort) = (Commands::new(), Commands::new());
        let (mut pairs, mut tiles) = (Commands::new(), Commands::new());
        let (mut sorted, mut of_tiles) = ([0; 2], Vec::new());
        if let Some((by_depth, by_tile)) = sorts {
            sorted = [by_depth.result(), by_tile.result()];
            let resources = resources.clone().with("keys", &scratch.keys[0]);
            let mut dispatches = Vec::new();
            for (desc, buffers) in &chunks {
                if let Some(buffers) = buffers {
                    let resources = resources.clone().and(&buffers.resources());
                    dispatches.push(run(desc, &resources, grid(buffers.count))?);
                }
            }
            if let Some(host) = &host {
                project.append(host.cull(kernels.shelf(), &params, by_depth.count_buffer()));
                let resources = resources.clone().and(&host.buffers.resources());
                // Each takes its own of all chunks.
                for (desc, is_there) in [
                    (&project::GAUSSIANS, host.kinds.gaussians),
                    (&project::PARTICLES, host.kinds.particles),
                ] {
                    if is_there {
                        dispatches.push(run(desc, &resources, grid(host.buffers.count))?);
                    }
                }
            }
            project.pass("gobo project", dispatches);
            sort.pass("gobo sort", by_depth.dispatches);

            let rects = context.binned_rects.unwrap_or(&scratch.rects);
            let resources = resources
                .clone()
                .with("sorted", &scratch.keys[sorted[0]])
                .with("pairs", &scratch.pairs[0])
                .with("rects", rects);
            let [count, emit] = bin::count_and_emit(shape);
            let runs = values.run_groups(shape);
            pairs.pass(
                "gobo bin",
                [
                    run(count, &resources, runs)?,
                    run(&bin::SCAN, &resources, [1, 1, 1])?,
                    run(emit, &resources, runs)?,
                ],
            );
            of_tiles = by_tile.dispatches;
        }
        // Curves take what was scattered themselves.
        let curves = plan.features.nodes > 0 && !context.camera;
        let scattered = if curves { &scratch.nothing_scattered } else { &scratch.scattered_tiles };
        let resources =
            resources.with("pairs", &scratch.pairs[sorted[1]]).with("scattered_tiles", scattered);
        of_tiles.push(run(&bin::TILES, &resources, values.tile_groups())?);
        tiles.pass("gobo bin", of_tiles);
        let parts = Parts::new(context, plan, tile_count, &resources, sorted[0])?;
        Ok(Self {
            footprint_count: plan.footprint_count,
            clear,
            project,
            sort,
            pairs,
            tiles,
            sorted_pairs: sorted[1],
            parts,
            chunks: chunks.map(|(_, buffers)| buffers.map(|buffers| buffers.chunks)),
            host_chunks: host,
            counters,
        })
    }

    /// Commands from casters to the number of their pairs.
    pub(crate) fn counting(&self) -> Commands {
        let mut commands = Commands::new();
        for stage in [&self.clear, &self.project, &self.sort, &self.pairs] {
            commands.append(stage.clone());
        }
        commands
    }
}

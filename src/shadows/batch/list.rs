//! Stages from casters to each tile's pairs: project, sort and bin, for one list of one batch.
use crate::shadows::batch::{
    chunks::Chunks, context::Context, list_plan::ListPlan, parts::Parts, scratch::Scratch,
};
use crate::{
    error::Error,
    frame::{Commands, Dispatch, Sort, SortCount},
    gpu::Resources,
    records::DEPTH_BITS,
    stage::{
        bin::{self, BatchCounters, BinParams},
        buckets,
        features::{Features, Flags},
    },
};
use wgpu::{Buffer, BufferUsages};

/// Kinds of casters and views that a list's kernels depend on, where they project or bin outlines.
const KINDS: Flags = Flags::HAS_BRICKS
    .union(Flags::HAS_GAUSSIANS)
    .union(Flags::HAS_CAPSULES)
    .union(Flags::HAS_VERTEX_COLORS)
    .union(Flags::PARALLEL);

/// Counters of one list.
pub type ListCounters = BatchCounters;

impl ListCounters {
    /// Adds the counts of another list, but keeps the larger number of needed pairs.
    pub fn add(&mut self, other: &Self) {
        self.pairs_needed = self.pairs_needed.max(other.pairs_needed);
        self.pair_count += other.pair_count;
        self.visible += other.visible;
        self.scattered += other.scattered;
        self.overflowed += other.overflowed;
        self.segment_count += other.segment_count;
        self.merged_count += other.merged_count;
        self.disordered += other.disordered;
        self.in_parts += other.in_parts;
        self.short_tiles += other.short_tiles;
    }
}

/// The commands of one list, stage by stage. Without casters, all but `clear` and `tiles` are empty.
#[derive(Debug)]
pub struct List {
    /// Footprints of the list.
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
    /// Which of the two holds the sorted pairs.
    pub sorted_pairs: usize,
    /// The parts of its tiles, where the pairs may not fit.
    pub(crate) parts: Option<Parts>,
    pub(crate) chunks: Chunks,
    /// Counts that the frame writes.
    pub counters: Buffer,
    /// Parameters of bin.
    pub params: Buffer,
}

impl List {
    /// The list of a plan.
    pub fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        views: &Buffer,
        view_count: u32,
        tile_count: u32,
    ) -> Result<Self, Error> {
        let scratch: &Scratch = context.scratch;
        let counters =
            context.allocator.storage::<BatchCounters>("counters", 1, BufferUsages::COPY_SRC)?;
        let curves = plan.features.nodes > 0 && !context.camera;
        let values = BinParams::new(
            context.config.tuning.partition,
            plan.footprint_count,
            context.pair_capacity(plan),
            tile_count,
            view_count,
            plan.segment_length(&context.config.tuning),
        );
        let values = BinParams { adds_scattered: u32::from(curves), ..values };
        let params = context.listed_uniform("bin_params", &values, plan.host.is_some());
        let chunks = Chunks::new(context, plan, &params)?;
        let bucketed =
            context.pair_capacity(plan) > 0 && scratch.has_buckets(plan, &context.config.tuning);
        let sorts = (plan.footprint_count > 0 && !bucketed)
            .then(|| sorts(context, plan, [&params, &counters], tile_count))
            .transpose()?;
        let features = Features::NONE.with(plan.features.flags & KINDS, true);
        let resources =
            context.resources(views).with("bin_params", &params).with("counters", &counters);

        let by_tile = values.tile_groups();
        let mut clear = Commands::new();
        let cleared = context.kernels.dispatch(&bin::CLEAR, Features::NONE, &resources, by_tile)?;
        clear.pass("gobo clear", [cleared]);
        let (mut project, mut sort) = (Commands::new(), Commands::new());
        let (mut pairs, mut of_tiles) = (Commands::new(), Vec::new());
        let mut sorted = [0; 2];
        if plan.footprint_count > 0 {
            let projected = resources.clone().with("keys", &scratch.keys[0]);
            project = chunks.project(context.kernels, features, &projected)?;
        }
        if let Some([depths, tiles]) = sorts {
            sorted = [depths.result(), tiles.result()];
            sort.pass("gobo sort", depths.dispatches);
            let footprints = resources.clone().with("sorted", &scratch.keys[sorted[0]]);
            pairs.pass("gobo bin", bin_pairs(context, features, &footprints, &values)?);
            of_tiles = tiles.dispatches;
        }
        let resources = resources.with("pairs", &scratch.pairs[sorted[1]]);
        if bucketed {
            let resources = resources.clone().with("keys", &scratch.keys[0]);
            let [count, place, emit, order] = buckets(context, features, &resources, &values)?;
            pairs.pass("gobo bin", [count, place]);
            of_tiles.extend([emit, order]);
        } else {
            of_tiles.push(context.kernels.dispatch(&bin::TILES, features, &resources, by_tile)?);
        }
        let mut tiles = Commands::new();
        tiles.pass("gobo bin", of_tiles);
        let parts = Parts::new(context, plan, &values, &resources, sorted[0])?;
        Ok(Self {
            footprint_count: plan.footprint_count,
            clear,
            project,
            sort,
            pairs,
            tiles,
            sorted_pairs: sorted[1],
            parts,
            chunks,
            counters,
            params,
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

/// The sort of the footprints by depth, and of their pairs by tile. `params`: those of bin.
fn sorts(
    context: &mut Context<'_, '_>,
    plan: &ListPlan,
    [params, counters]: [&Buffer; 2],
    tile_count: u32,
) -> Result<[Sort; 2], Error> {
    let (scratch, kernels) = (context.scratch, context.kernels);
    let capacity = plan.footprint_count;
    let of_host =
        SortCount::FromBuffer { counts: params, index: bin::FOOTPRINT_COUNT_INDEX, capacity };
    let known = if plan.host.is_some() { of_host } else { SortCount::Known(capacity) };
    let counted = SortCount::FromBuffer {
        counts: counters,
        index: bin::PAIR_COUNT_INDEX,
        capacity: scratch.pair_capacity,
    };
    let by_depth = Sort::new(kernels, scratch.keys.each_ref(), known, 0..DEPTH_BITS)?;
    let by_tile =
        Sort::new(kernels, scratch.pairs.each_ref(), counted, 0..bin::tile_bits(tile_count))?;
    let bytes = by_depth.scratch_size() + by_tile.scratch_size();
    context.allocator.memory.add("histograms", bytes);
    Ok([by_depth, by_tile])
}

/// The kernels from footprints to each tile's pairs, front to back.
fn buckets(
    context: &Context<'_, '_>,
    features: Features,
    resources: &Resources,
    values: &BinParams,
) -> Result<[Dispatch; 4], Error> {
    let resources = resources.clone().with("rects", &context.scratch.rects);
    let run = |desc, groups: [u32; 3]| context.kernels.dispatch(desc, features, &resources, groups);
    let footprints = [values.footprint_count.div_ceil(buckets::BUCKET_LANES), 1, 1];
    let tiles = [values.tile_count.div_ceil(buckets::BUCKET_LANES), 1, 1];
    Ok([
        run(&buckets::COUNT, footprints)?,
        run(&buckets::PLACE, tiles)?,
        run(&buckets::EMIT, footprints)?,
        run(&buckets::SORT, bin::tile_grid(values.tile_count))?,
    ])
}

/// The kernels from sorted footprints to their pairs, in depth order.
fn bin_pairs(
    context: &Context<'_, '_>,
    features: Features,
    resources: &Resources,
    values: &BinParams,
) -> Result<[Dispatch; 3], Error> {
    let (scratch, partition) = (context.scratch, context.config.tuning.partition);
    let resources = resources
        .clone()
        .with("pairs", &scratch.pairs[0])
        .with("rects", context.binned_rects.unwrap_or(&scratch.rects));
    let run = |desc, groups: [u32; 3]| context.kernels.dispatch(desc, features, &resources, groups);
    let ([count, emit], runs) = (bin::count_and_emit(partition), values.run_groups(partition));
    Ok([run(count, runs)?, run(&bin::SCAN, [1, 1, 1])?, run(emit, runs)?])
}

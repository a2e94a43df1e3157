//! Scratch memory of lists and batches, and its size.
use crate::shadows::{
    Config,
    batch::{batch_plan::BatchPlan, list_plan::ListPlan},
};
use crate::{
    error::Error,
    gpu::{Allocator, RecordForm, Resource, Resources},
    model::TILE_SIZE,
    records::{CURVE_SEGMENT, Footprint, TriangleSetup},
    stage::{
        accumulate::composed_texels,
        bin::{self, DispatchEntry, Segment},
        curve::{partial_bytes, partial_count},
        features::Flags,
        sort::{PAIR_FORMAT, pair_limit},
        tuning::Tuning,
    },
};
use wgpu::{
    Buffer, BufferUsages,
    TextureFormat::{R32Uint, Rgba32Uint},
    TextureUsages,
};

/// Pairs that every frame has room for: 16 MiB of them.
const FREE_PAIRS: u64 = 1 << 20;

/// Scratch memory that lists and batches use one after another.
#[derive(Debug)]
pub struct Scratch {
    /// Scratch resources that kernels of every list use.
    pub resources: Resources,
    /// Depth keys and footprints, before and after a pass of the sort.
    pub keys: [Resource; 2],
    /// Tiles of each footprint.
    pub rects: Resource,
    /// Pairs of a tile and a footprint.
    pub pairs: [Resource; 2],
    /// Room for pairs.
    pub pair_capacity: u32,
    /// Pairs of a part of the tiles, for lists whose pairs may not fit; at least the capacity.
    pub part_room: u32,
    pub(crate) parts: Option<PartBuffers>,
    /// Work of each tile.
    pub tiles: Resource,
    /// Tiles that scattered casters touch.
    pub scattered_tiles: Buffer,
    /// Workgroup counts that the frame writes.
    pub dispatches: Buffer,
    /// Curves of segments.
    pub partials: Buffer,
    /// Transfers of segments to texels, if some list composes them one by one.
    pub composed: Option<Buffer>,
    pub(crate) small: SmallDepths,
    sizes: ScratchSizes,
}

/// Sizes of the scratch memory: the peak over lists and batches.
#[derive(Clone, Copy, Debug)]
struct ScratchSizes {
    /// Where records are.
    form: RecordForm,
    footprints: u64,
    setups: u64,
    tiles: u64,
    /// Tiles of batches with sums.
    summed_tiles: u64,
    /// Tiles of batches with small triangles.
    small_tiles: u64,
    pairs: u32,
    part_room: u32,
    /// Pairs of lists that are binned by buckets.
    bucket_room: u64,
    /// Tiles of batches whose pairs may not fit.
    part_tiles: u64,
    /// Nodes of the curves (K), 0 for none.
    nodes: u32,
    /// Size of the curves of one segment \[bytes\].
    segment_bytes: u64,
    /// Pairs of the shortest segment of a list with curves.
    segment: u32,
    /// Whether some list composes segments one by one.
    composed: bool,
}

impl ScratchSizes {
    /// Sizes for the plans; `limit`: of the pairs.
    fn of(
        config: &Config,
        plans: &[BatchPlan],
        pairs: Option<u32>,
        limit: u32,
        nodes: u32,
        limits: &wgpu::Limits,
    ) -> Self {
        let lists = || plans.iter().flat_map(|plan| &plan.lists);
        let footprints = lists().map(|list| u64::from(list.footprint_count)).max().unwrap_or(0);
        let summed = plans.iter().filter(|plan| !plan.camera);
        // The pairs of one tile of the picture fit in any case.
        let camera = plans.iter().any(|plan| plan.camera);
        let least = if camera { u32::try_from(footprints).unwrap_or(u32::MAX).max(1) } else { 1 };
        let with_small = plans.iter().filter(|plan| !plan.small_chunks.is_empty());
        // An upper bound, or a first guess: a frame reports the pairs that it needed, and the next one is
        // prepared with them.
        let bound = lists().map(|list| list.bound.pairs).max().unwrap_or(0);
        let likely = lists().map(ListPlan::likely_count).max().unwrap_or(0);
        let guess = if bound <= FREE_PAIRS {
            bound.next_power_of_two()
        } else {
            (likely * 5 + 65536).max(FREE_PAIRS)
        };
        let guess = u32::try_from(guess).unwrap_or(u32::MAX);
        let changing = Flags::HAS_OVER | Flags::HAS_VOLUMES;
        let changes = lists().any(|list| list.features.flags.intersects(changing));
        let segment_bytes = partial_bytes(nodes, changes);
        let curved = lists().filter(|list| list.features.nodes > 0);
        let segment =
            curved.map(|list| list.segment_length(&config.tuning)).min().unwrap_or(CURVE_SEGMENT);
        let limit = match nodes {
            0 => limit,
            _ => {
                let sizes = limits.max_storage_buffer_binding_size / segment_bytes;
                let most = (sizes - 1) / 2 * u64::from(segment);
                u32::try_from(most).unwrap_or(u32::MAX).min(limit)
            }
        };
        let pairs =
            pairs.unwrap_or(guess).min(config.settings.pair_budget).clamp(least.min(limit), limit);
        let parts = |list: &&ListPlan| list.may_part(config.tuning.partition, pairs);
        let room = lists().filter(parts).map(ListPlan::part_room).max().unwrap_or(0);
        let buckets = lists().map(|list| list.bucket_room(&config.tuning, pairs));
        let with_parts = plans.iter().filter(|plan| plan.lists.iter().any(|list| parts(&list)));
        Self {
            form: config.tuning.record_form,
            footprints,
            setups: lists().map(|list| u64::from(list.setup_count())).max().unwrap_or(0),
            tiles: plans.iter().map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            summed_tiles: summed.map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            small_tiles: with_small.map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            pairs,
            part_room: u32::try_from(room).unwrap_or(u32::MAX).clamp(pairs, limit),
            bucket_room: buckets.max().unwrap_or(0),
            part_tiles: with_parts.map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            segment_bytes,
            segment,
            nodes,
            composed: lists().any(ListPlan::is_composed),
        }
    }
}

const SUMS: [&str; 4] = ["sum_red", "sum_green", "sum_blue", "nearness"];

/// Optical depth per channel and nearness, one element per texel of a batch. Zero before each batch: new
/// memory is zero, and `resolve` resets it.
fn sums(allocator: &mut Allocator<'_>, config: &Config, texels: u64) -> Result<Resources, Error> {
    let (atomic, none) = (TextureUsages::STORAGE_ATOMIC, BufferUsages::empty());
    let mut all = Resources::new();
    if !config.tier.has_texture_atomics() && config.tuning.record_form == RecordForm::Buffers {
        return Ok(all.with("sums", &allocator.storage::<[u32; 4]>("sums", texels, none)?));
    }
    for name in SUMS {
        all = if config.tier.has_texture_atomics() {
            let usage = atomic | TextureUsages::STORAGE_BINDING;
            all.with(name, &allocator.records(name, R32Uint, texels, usage)?)
        } else {
            all.with(name, &allocator.storage::<u32>(name, texels, none)?)
        };
    }
    Ok(all)
}

/// Buffers of the parts, which all lists use one after another.
#[derive(Debug)]
pub(crate) struct PartBuffers {
    /// Pairs of each tile, then their prefix sum.
    pub tile_pairs: Buffer,
    /// Workgroup counts of `part_next`, which writes those of the other kernels.
    pub turn: Buffer,
}

impl PartBuffers {
    fn new(allocator: &mut Allocator<'_>, tiles: u64) -> Result<Self, Error> {
        let (cleared, indirect) = (BufferUsages::COPY_DST, BufferUsages::INDIRECT);
        Ok(Self {
            tile_pairs: allocator.storage::<u32>("tile_pairs", tiles + 1, cleared)?,
            turn: allocator.storage::<[u32; 4]>("part_turn", 1, indirect)?,
        })
    }
}

/// Most bytes of initial depths, which are copied again and again: they stay in a core's cache.
const FAR_BYTES: u64 = 1 << 20;

/// Depths of a batch, one element per texel, and the initial values of some.
#[derive(Debug)]
pub(crate) struct SmallDepths {
    pub depths: Buffer,
    pub far: Option<Buffer>,
}

impl SmallDepths {
    /// `texels`: 0 if no batch has small triangles.
    fn new(allocator: &mut Allocator<'_>, texels: u64) -> Result<Self, Error> {
        let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let depths = allocator.storage::<u32>("small_depths", texels, usage)?;
        let far_count = texels.min(FAR_BYTES / size_of::<f32>() as u64) as usize;
        let far =
            (texels > 0).then(|| allocator.filled("far_depths", &vec![1.0_f32; far_count], usage));
        Ok(Self { depths, far })
    }
}

impl Scratch {
    /// Memory of batches.
    pub fn new(
        allocator: &mut Allocator<'_>,
        config: &Config,
        plans: &[BatchPlan],
        pairs: Option<u32>,
        nodes: u32,
    ) -> Result<Self, Error> {
        const TEXELS: u64 = (TILE_SIZE * TILE_SIZE) as u64;
        let limits = allocator.device.limits();
        let sizes =
            ScratchSizes::of(config, plans, pairs, pair_limit(allocator.device), nodes, &limits);
        let partition = config.tuning.partition;
        let form = sizes.form;
        let footprints =
            allocator.written::<Footprint>(form, "footprints", Rgba32Uint, sizes.footprints)?;
        let setups =
            allocator.written::<TriangleSetup>(form, "setups", Rgba32Uint, sizes.setups)?;
        let mut of_pairs =
            |name, count| allocator.written::<[u32; 2]>(form, name, PAIR_FORMAT, count);
        // `part_count` writes them 32 at a time.
        let key_room = sizes.footprints.next_multiple_of(32);
        let keys = [of_pairs("keys", key_room)?, of_pairs("keys", key_room)?];
        let rects = of_pairs("rects", sizes.footprints)?;
        let room = u64::from(sizes.part_room);
        let pairs = [of_pairs("pairs", room)?, of_pairs("pairs", room)?];
        // `bin_tiles` writes as many as its workgroups have invocations.
        let tile_room = sizes.tiles.next_multiple_of(bin::TILE_LANES.into());
        let tiles = allocator.written::<[u32; 4]>(form, "tiles", Rgba32Uint, tile_room)?;
        let none = BufferUsages::empty();
        let texels = composed_texels(sizes.part_room);
        let composed = sizes
            .composed
            .then(|| allocator.storage::<[[u32; 4]; 2]>("composed", texels, none))
            .transpose()?;
        let mut words = |name, count| allocator.storage::<u32>(name, count, none);
        let scattered_tiles = words("scattered_tiles", sizes.tiles)?;
        let merged_tiles = words("merged_tiles", sizes.tiles)?;
        let run_offsets = words("run_offsets", bin::max_offsets(partition).into())?;
        let overflow = words("overflow", sizes.footprints)?;
        let tile_cursors = words("tile_cursors", sizes.tiles * sizes.bucket_room.min(1))?;
        let curves = u64::from(nodes > 0);
        let parts = (sizes.part_tiles > 0)
            .then(|| PartBuffers::new(allocator, sizes.part_tiles))
            .transpose()?;
        let shortest = sizes.segment.min(bin::SEGMENT_LENGTH).min(config.tuning.disc_segment);
        let segments = u64::from(sizes.part_room / shortest) + sizes.tiles;
        let partials =
            curves * partial_count(sizes.part_room, sizes.segment) * sizes.segment_bytes / 16;
        let bucketed = allocator.storage::<[[u32; 2]; 2]>("bucketed", sizes.bucket_room, none)?;
        let segments = allocator.storage::<Segment>("segments", 1 + segments, none)?;
        let dispatches = allocator.storage::<[u32; 4]>(
            "dispatches",
            DispatchEntry::COUNT,
            BufferUsages::INDIRECT,
        )?;
        let partials = allocator.storage::<[u32; 4]>("partials", partials, none)?;
        let sums = sums(allocator, config, sizes.summed_tiles * TEXELS)?;
        let small = SmallDepths::new(allocator, sizes.small_tiles * TEXELS)?;
        let resources = sums
            .with("footprints", &footprints)
            .with("rects", &rects)
            .with("setups", &setups)
            .with("tiles", &tiles)
            .with("scattered_tiles", &scattered_tiles)
            .with("merged_tiles", &merged_tiles)
            .with("segments", &segments)
            .with("run_offsets", &run_offsets)
            .with("overflow", &overflow)
            .with("tile_cursors", &tile_cursors)
            .with("bucketed", &bucketed)
            .with("dispatches", &dispatches)
            .with("partials", &partials)
            .with("small_depths", &small.depths);
        Ok(Self {
            resources,
            keys,
            rects,
            pairs,
            pair_capacity: sizes.pairs,
            part_room: sizes.part_room,
            parts,
            tiles,
            scattered_tiles,
            dispatches,
            partials,
            composed,
            small,
            sizes,
        })
    }

    /// Whether a list is binned by buckets.
    pub(crate) fn has_buckets(&self, list: &ListPlan, tuning: &Tuning) -> bool {
        let room = list.bucket_room(tuning, self.pair_capacity);
        list.footprint_count > 0 && (1..=self.sizes.bucket_room).contains(&room)
    }

    /// Whether it is large enough for other plans, with no more pairs than the budget allows.
    pub(crate) fn fits(
        &self,
        device: &wgpu::Device,
        config: &Config,
        plans: &[BatchPlan],
        pairs: Option<u32>,
    ) -> bool {
        let (limits, nodes) = (device.limits(), config.nodes());
        let need = ScratchSizes::of(config, plans, pairs, pair_limit(device), nodes, &limits);
        let sizes = self.sizes;
        need.form == sizes.form
            && need.footprints <= sizes.footprints
            && need.setups <= sizes.setups
            && need.tiles <= sizes.tiles
            && need.summed_tiles <= sizes.summed_tiles
            && need.small_tiles <= sizes.small_tiles
            && need.part_room <= sizes.part_room
            && need.part_tiles <= sizes.part_tiles
            && need.bucket_room <= sizes.bucket_room
            && need.nodes == sizes.nodes
            && need.segment_bytes <= sizes.segment_bytes
            && need.segment >= sizes.segment
            && (sizes.composed || !need.composed)
            && (need.pairs..=config.settings.pair_budget.max(1)).contains(&sizes.pairs)
    }
}

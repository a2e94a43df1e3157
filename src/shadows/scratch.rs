//! Scratch memory of lists and batches, and its size.
use super::{
    Config,
    list::List,
    plan::{ListPlan, Plan},
    small::SmallDepths,
};
use crate::{
    error::Error,
    gpu::{Allocator, Resources, Tier, view},
    model::TILE_SIZE,
    records::{CURVE_SEGMENT, FOOTPRINT_TEXELS, SETUP_TEXELS},
    stage::{
        bin::{self, Dispatch, SEGMENT_LENGTH, Segment},
        curve::partial_bytes,
        sort::{PAIR_FORMAT, pair_limit},
    },
};
use wgpu::{Buffer, BufferUsages, Texture, TextureFormat, TextureUsages, TextureView};

/// Most segments whose transfers fit a storage binding of 128 MiB, 32 bytes a texel.
const MAX_COMPOSED: u64 = (128 << 20) / (32 * (TILE_SIZE * TILE_SIZE) as u64);

/// Capacity that every frame may have [pairs]: 16 MiB of them.
const FREE_PAIRS: u64 = 1 << 20;

/// Scratch memory of lists and batches, which use it one after another.
#[derive(Debug)]
pub(crate) struct Scratch {
    pub footprints: TextureView,
    pub keys: [TextureView; 2],
    pub rects: TextureView,
    pub setups: TextureView,
    pub pairs: [TextureView; 2],
    pub pair_capacity: u32,
    pub tiles: TextureView,
    pub scattered_tiles: Buffer,
    pub merged_tiles: Buffer,
    pub segments: Buffer,
    pub segment_capacity: u32,
    pub run_offsets: Buffer,
    pub overflow: Buffer,
    pub dispatches: Buffer,
    pub sums: Sums,
    /// Curves of segments.
    pub partials: Buffer,
    /// Zeros in place of the scattered tiles, for curves, whose tiles read scattered casters themselves.
    pub nothing_scattered: Buffer,
    /// Transfers of segments to texels, if some list composes them one by one.
    pub composed: Option<Buffer>,
    pub(super) small: SmallDepths,
    sizes: ScratchSizes,
}

/// Sizes of the scratch memory: the peak over lists and batches.
#[derive(Clone, Copy, Debug)]
struct ScratchSizes {
    footprints: u64,
    setups: u64,
    tiles: u64,
    /// Tiles of batches with sums.
    summed_tiles: u64,
    /// Tiles of batches with small triangles.
    small_tiles: u64,
    pairs: u32,
    /// Nodes of the curves (K), 0 for none.
    nodes: u32,
    /// Size of the curves of one segment [bytes].
    segment_bytes: u64,
    /// Whether some list composes segments one by one.
    composed: bool,
}

/// Most segments with partial results for so many pairs: only tiles with more than one segment have them.
pub(crate) fn partial_count(pairs: u32, segment_length: u32) -> u64 {
    2 * u64::from(pairs / segment_length) + 1
}

impl ScratchSizes {
    /// Sizes for the plans; `limit`: of the pairs.
    fn of(
        config: &Config,
        plans: &[Plan],
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
        // An upper bound, or a first guess: a frame reports what it needed, and the next is prepared with
        // it.
        let bound = lists().map(|list| list.bound.pairs).max().unwrap_or(0);
        let likely = lists().map(ListPlan::likely_count).max().unwrap_or(0);
        let guess = if bound <= FREE_PAIRS {
            bound.next_power_of_two()
        } else {
            (likely * 5 + 65536).max(FREE_PAIRS)
        };
        let guess = u32::try_from(guess).unwrap_or(u32::MAX);
        let changes = lists().any(|list| list.features.over || list.features.volumes);
        let segment_bytes = partial_bytes(nodes, changes);
        let limit = match nodes {
            0 => limit,
            _ => {
                let sizes = limits.max_storage_buffer_binding_size / segment_bytes;
                let most = (sizes - 1) / 2 * u64::from(CURVE_SEGMENT);
                u32::try_from(most).unwrap_or(u32::MAX).min(limit)
            }
        };
        Self {
            footprints,
            setups: lists().map(|list| u64::from(list.setup_count())).max().unwrap_or(0),
            tiles: plans.iter().map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            summed_tiles: summed.map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            small_tiles: with_small.map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            pairs: pairs.unwrap_or(guess).min(config.pair_budget).clamp(least.min(limit), limit),
            segment_bytes,
            nodes,
            composed: lists().any(ListPlan::is_composed),
        }
    }
}

const SUMS: [&str; 4] = ["sum_red", "sum_green", "sum_blue", "nearness"];

/// Optical depth per channel and nearness, one element per texel of a batch. Zero before each batch: new
/// memory is, and `resolve` resets it.
#[derive(Debug)]
pub(crate) enum Sums {
    Buffers(Box<[Buffer; 4]>),
    Textures(Box<[Texture; 4]>),
}

impl Sums {
    fn new(allocator: &mut Allocator<'_>, tier: Tier, texels: u64) -> Result<Self, Error> {
        if tier == Tier::Core {
            let [a, b, c, d] =
                SUMS.map(|name| allocator.storage::<u32>(name, texels, BufferUsages::empty()));
            return Ok(Self::Buffers(Box::new([a?, b?, c?, d?])));
        }
        let usage = TextureUsages::STORAGE_ATOMIC | TextureUsages::STORAGE_BINDING;
        let [a, b, c, d] =
            SUMS.map(|name| allocator.records(name, TextureFormat::R32Uint, texels, usage));
        Ok(Self::Textures(Box::new([a?, b?, c?, d?])))
    }

    pub(crate) fn resources(&self) -> Resources<'_> {
        let none = Resources::new();
        match self {
            Self::Buffers(buffers) => {
                SUMS.into_iter().zip(&**buffers).fold(none, |all, (name, sum)| all.with(name, sum))
            }
            Self::Textures(textures) => {
                SUMS.into_iter().zip(&**textures).fold(none, |all, (name, sum)| all.with(name, sum))
            }
        }
    }
}

impl Scratch {
    /// Resources of it that kernels of every list use.
    pub(crate) fn resources(&self) -> Resources<'_> {
        self.sums
            .resources()
            .with("footprints", &self.footprints)
            .with("rects", &self.rects)
            .with("setups", &self.setups)
            .with("tiles", &self.tiles)
            .with("scattered_tiles", &self.scattered_tiles)
            .with("merged_tiles", &self.merged_tiles)
            .with("segments", &self.segments)
            .with("run_offsets", &self.run_offsets)
            .with("overflow", &self.overflow)
            .with("dispatches", &self.dispatches)
            .with("small_depths", &self.small.depths)
    }

    /// Resets the counters of a list to zero.
    pub(crate) fn clear(&self, list: &List, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(list.counters(), 0, None);
        encoder.clear_buffer(&self.dispatches, 0, None);
        encoder.clear_buffer(&self.scattered_tiles, 0, None);
    }

    pub(crate) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        config: &Config,
        plans: &[Plan],
        pairs: Option<u32>,
        nodes: u32,
    ) -> Result<Self, Error> {
        const TEXELS: u64 = (TILE_SIZE * TILE_SIZE) as u64;
        let limits = allocator.device.limits();
        let sizes =
            ScratchSizes::of(config, plans, pairs, pair_limit(allocator.device), nodes, &limits);
        let ScratchSizes { footprints, setups, tiles, small_tiles, pairs: pair_capacity, .. } =
            sizes;
        let curve_count = if nodes == 0 { 0 } else { partial_count(pair_capacity, CURVE_SEGMENT) };
        let segment_capacity = pair_capacity / SEGMENT_LENGTH + tiles as u32;
        let storage = TextureUsages::STORAGE_BINDING;
        let mut records = |name, format, texels| {
            allocator.records(name, format, texels, storage).map(|texture| view(&texture))
        };
        let footprint_texels = footprints * u64::from(FOOTPRINT_TEXELS);
        let footprint_views = records("footprints", TextureFormat::Rgba32Uint, footprint_texels)?;
        let keys =
            [records("keys", PAIR_FORMAT, footprints)?, records("keys", PAIR_FORMAT, footprints)?];
        let rects = records("rects", PAIR_FORMAT, footprints)?;
        let setup_texels = setups * u64::from(SETUP_TEXELS);
        let setups = records("setups", TextureFormat::Rgba32Uint, setup_texels)?;
        let capacity = u64::from(pair_capacity);
        let pairs =
            [records("pairs", PAIR_FORMAT, capacity)?, records("pairs", PAIR_FORMAT, capacity)?];
        let none = BufferUsages::empty();
        let composed = if sizes.composed {
            let segments = partial_count(pair_capacity, SEGMENT_LENGTH);
            // The pair budget's default would need slightly more than a storage binding holds.
            let segments = segments.min(MAX_COMPOSED);
            let texels = segments * u64::from(TILE_SIZE * TILE_SIZE);
            Some(allocator.storage::<[[u32; 4]; 2]>("composed", texels, none)?)
        } else {
            None
        };
        Ok(Self {
            footprints: footprint_views,
            keys,
            rects,
            setups,
            pairs,
            pair_capacity,
            tiles: view(&allocator.records(
                "tiles",
                TextureFormat::Rgba32Uint,
                tiles,
                storage | TextureUsages::TEXTURE_BINDING,
            )?),
            scattered_tiles: allocator.storage::<u32>("scattered_tiles", tiles, none)?,
            merged_tiles: allocator.storage::<u32>("merged_tiles", tiles, none)?,
            segments: allocator.storage::<Segment>(
                "segments",
                u64::from(segment_capacity),
                none,
            )?,
            segment_capacity,
            run_offsets: allocator.storage::<u32>(
                "run_offsets",
                bin::max_runs(config.profile.shape),
                none,
            )?,
            overflow: allocator.storage::<u32>("overflow", footprints, none)?,
            dispatches: allocator.storage::<[u32; 4]>(
                "dispatches",
                Dispatch::COUNT,
                BufferUsages::INDIRECT,
            )?,
            partials: allocator.storage::<[u32; 4]>(
                "partials",
                curve_count * sizes.segment_bytes / 16,
                none,
            )?,
            nothing_scattered: allocator.storage::<u32>(
                "nothing_scattered",
                if nodes == 0 { 1 } else { tiles },
                none,
            )?,
            composed,
            sums: Sums::new(allocator, config.tier, sizes.summed_tiles * TEXELS)?,
            small: SmallDepths::new(allocator, queue, small_tiles * TEXELS)?,
            sizes,
        })
    }

    /// Whether it is large enough for other plans, with no more pairs than the budget allows.
    pub(crate) fn fits(
        &self,
        device: &wgpu::Device,
        config: &Config,
        plans: &[Plan],
        pairs: Option<u32>,
        nodes: u32,
    ) -> bool {
        let limits = device.limits();
        let need = ScratchSizes::of(config, plans, pairs, pair_limit(device), nodes, &limits);
        let sizes = self.sizes;
        need.footprints <= sizes.footprints
            && need.setups <= sizes.setups
            && need.tiles <= sizes.tiles
            && need.summed_tiles <= sizes.summed_tiles
            && need.small_tiles <= sizes.small_tiles
            && need.nodes == sizes.nodes
            && need.segment_bytes <= sizes.segment_bytes
            && (sizes.composed || !need.composed)
            && (need.pairs..=config.pair_budget.max(1)).contains(&sizes.pairs)
    }
}

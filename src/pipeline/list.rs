//! From casters to each tile's pairs: project, sort and bin, for one class of one batch.
use super::{
    Config,
    batch::{Context, Plan},
    casters::Class,
    kernels::Kernels,
    small::SmallDepths,
};
use crate::{
    error::Error,
    footprint::{DEPTH_BITS, FOOTPRINT_TEXELS, SETUP_TEXELS},
    gpu::{Allocator, Tier, Timeline, view},
    stage::{
        bin::{
            self, BatchCounters, BinParams, DISC_SEGMENT, Dispatch, SEGMENT_LENGTH, Segment, Tile,
        },
        curve::{CURVE_SEGMENT, partial_bytes},
        hits::Features,
        project::{Chunk, grid},
        sort::{PAIR_FORMAT, SortBindings, SortCount, pair_limit},
    },
    view::{GpuView, MAX_VIEWS, TILE_SIZE},
};
use wgpu::{
    BindGroup, BindingResource, Buffer, BufferUsages, Texture, TextureFormat, TextureUsages,
    TextureView,
};

/// Segments whose effects on their texels fit a storage binding of 128 MiB, 32 bytes a texel.
const MAX_COMPOSED: u64 = (128 << 20) / (32 * (TILE_SIZE * TILE_SIZE) as u64);

/// What one list counted.
pub type ListCounters = BatchCounters;

impl ListCounters {
    pub(super) fn add(&mut self, other: &Self) {
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

/// What lists and batches write on the way, one after another in the same memory.
#[derive(Debug)]
pub(super) struct Scratch {
    pub footprints: TextureView,
    pub keys: [TextureView; 2],
    pub rects: TextureView,
    pub setups: TextureView,
    pub pairs: [TextureView; 2],
    pub pair_capacity: u32,
    pub tiles: Buffer,
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
    /// For curves, whose tiles take what was scattered themselves: zero.
    pub nothing_scattered: Buffer,
    /// What segments do to texels, where some list composes them one by one.
    pub composed: Option<Buffer>,
    pub small: SmallDepths,
    room: Room,
}

/// What the largest of some lists and batches needs.
#[derive(Clone, Copy, Debug)]
struct Room {
    footprints: u64,
    setups: u64,
    tiles: u64,
    /// Of batches with small triangles.
    small_tiles: u64,
    pairs: u32,
    /// K of the curves, 0 for none.
    nodes: u32,
    /// Some list composes segments one by one.
    composed: bool,
}

/// Partial curves for so many pairs: only tiles with more than one segment have any.
fn partial_count(pairs: u32) -> u64 {
    2 * (u64::from(pairs) / u64::from(CURVE_SEGMENT)) + 1
}

impl Room {
    /// `limit`: of the pairs.
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
        let with_small = plans.iter().filter(|plan| !plan.small_chunks.is_empty());
        // A first guess; a frame that needed more says so, and the next is prepared with it.
        let guess = u32::try_from(footprints * 5 + 65536).unwrap_or(u32::MAX);
        let limit = match nodes {
            0 => limit,
            _ => {
                let room = limits.max_storage_buffer_binding_size / partial_bytes(nodes);
                let most = (room - 1) / 2 * u64::from(CURVE_SEGMENT);
                u32::try_from(most).unwrap_or(u32::MAX).min(limit)
            }
        };
        Self {
            footprints,
            setups: lists().map(|list| u64::from(list.setup_count())).max().unwrap_or(0),
            tiles: plans.iter().map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            small_tiles: with_small.map(|plan| u64::from(plan.tile_count)).max().unwrap_or(0),
            pairs: pairs.unwrap_or(guess).min(config.pair_budget).clamp(1, limit),
            nodes,
            composed: lists().any(ListPlan::is_composed),
        }
    }
}

/// Optical depth per channel and nearness, one element per texel of a batch. Zero before each
/// batch: new memory is, and `resolve` leaves it so.
#[derive(Debug)]
pub(super) enum Sums {
    Buffers(Box<[Buffer; 4]>),
    Textures(Box<[(Texture, TextureView); 4]>),
}

impl Sums {
    fn new(allocator: &mut Allocator<'_>, tier: Tier, texels: u64) -> Result<Self, Error> {
        const NAMES: [&str; 4] = ["sum_red", "sum_green", "sum_blue", "nearness"];
        if tier == Tier::Core {
            let [a, b, c, d] =
                NAMES.map(|name| allocator.storage::<u32>(name, texels, BufferUsages::empty()));
            return Ok(Self::Buffers(Box::new([a?, b?, c?, d?])));
        }
        let usage = TextureUsages::STORAGE_ATOMIC | TextureUsages::STORAGE_BINDING;
        let [a, b, c, d] =
            NAMES.map(|name| allocator.records(name, TextureFormat::R32Uint, texels, usage));
        let with_view = |texture: Texture| {
            let view = view(&texture);
            (texture, view)
        };
        Ok(Self::Textures(Box::new([a?, b?, c?, d?].map(with_view))))
    }

    pub(super) fn resources(&self) -> [BindingResource<'_>; 4] {
        match self {
            Self::Buffers(buffers) => buffers.each_ref().map(Buffer::as_entire_binding),
            Self::Textures(textures) => {
                textures.each_ref().map(|(_, view)| BindingResource::TextureView(view))
            }
        }
    }
}

impl Scratch {
    /// What a list expects to be zero.
    pub(super) fn clear(&self, list: &List, encoder: &mut wgpu::CommandEncoder) {
        encoder.clear_buffer(&list.counters, 0, None);
        encoder.clear_buffer(&self.tiles, 0, None);
        encoder.clear_buffer(&self.scattered_tiles, 0, None);
    }

    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        config: &Config,
        plans: &[Plan],
        pairs: Option<u32>,
        nodes: u32,
    ) -> Result<Self, Error> {
        const TEXELS: u64 = (TILE_SIZE * TILE_SIZE) as u64;
        let limits = allocator.device.limits();
        let room = Room::of(config, plans, pairs, pair_limit(allocator.device), nodes, &limits);
        let Room { footprints, setups, tiles, small_tiles, pairs: pair_capacity, .. } = room;
        let partial_count = if nodes == 0 { 0 } else { partial_count(pair_capacity) };
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
        let composed = if room.composed {
            // Of tiles with more than one segment.
            let segments = 2 * u64::from(pair_capacity / SEGMENT_LENGTH) + 1;
            // The pair budget's default would need a little more than a storage binding holds.
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
            tiles: allocator.storage::<Tile>("tiles", tiles, none)?,
            scattered_tiles: allocator.storage::<u32>("scattered_tiles", tiles, none)?,
            merged_tiles: allocator.storage::<u32>("merged_tiles", tiles, none)?,
            segments: allocator.storage::<Segment>(
                "segments",
                u64::from(segment_capacity),
                none,
            )?,
            segment_capacity,
            run_offsets: allocator.storage::<u32>("run_offsets", bin::MAX_RUNS, none)?,
            overflow: allocator.storage::<u32>("overflow", footprints, none)?,
            dispatches: allocator.storage::<[u32; 4]>(
                "dispatches",
                Dispatch::COUNT,
                BufferUsages::INDIRECT,
            )?,
            partials: allocator.storage::<[u32; 4]>(
                "partials",
                partial_count * partial_bytes(nodes) / 16,
                none,
            )?,
            nothing_scattered: allocator.storage::<u32>(
                "nothing_scattered",
                if nodes == 0 { 1 } else { tiles },
                none,
            )?,
            composed,
            sums: Sums::new(allocator, config.tier, tiles * TEXELS)?,
            small: SmallDepths::new(allocator, queue, small_tiles * TEXELS)?,
            room,
        })
    }

    /// Whether it has room for other plans, and no more pairs than the budget allows.
    pub(super) fn fits(
        &self,
        device: &wgpu::Device,
        config: &Config,
        plans: &[Plan],
        pairs: Option<u32>,
        nodes: u32,
    ) -> bool {
        let limits = device.limits();
        let need = Room::of(config, plans, pairs, pair_limit(device), nodes, &limits);
        let room = self.room;
        need.footprints <= room.footprints
            && need.setups <= room.setups
            && need.tiles <= room.tiles
            && need.small_tiles <= room.small_tiles
            && need.nodes == room.nodes
            && (room.composed || !need.composed)
            && (need.pairs..=config.pair_budget.max(1)).contains(&room.pairs)
    }
}

/// The casters of one class that a batch projects.
#[derive(Clone, Debug)]
pub(super) struct ListPlan {
    pub class: Class,
    pub features: Features,
    pub particle_chunks: Vec<Chunk>,
    /// Those of `particle_chunks` that may have particles for the scatter path.
    pub tiny_chunks: Vec<Chunk>,
    pub triangle_chunks: Vec<Chunk>,
    /// Of particles, then of triangles.
    pub footprint_count: u32,
    pub first_setup: u32,
}

impl ListPlan {
    /// Whether segments are composed one by one: of a shadow view's list.
    pub(super) fn is_composed(&self) -> bool {
        self.class == *Class::FILTERING.start() && self.features.is_composed()
    }

    fn setup_count(&self) -> u32 {
        self.footprint_count - self.first_setup
    }
}

/// One list, bound and ready to be recorded.
#[derive(Debug)]
pub(super) struct List {
    pub footprint_count: u32,
    run_count: u32,
    tile_count: u32,
    particle_chunks: Option<Chunks>,
    triangle_chunks: Option<Chunks>,
    pub counters: Buffer,
    readback: Buffer,
    depth_sort: Option<SortBindings>,
    tile_sort: Option<SortBindings>,
    /// Which of the pair textures holds the sorted pairs.
    pub sorted_pairs: usize,
    count: BindGroup,
    scan: BindGroup,
    emit: BindGroup,
    ranges: BindGroup,
    segments: BindGroup,
    dispatch: BindGroup,
}

/// Chunks on the device.
#[derive(Debug)]
pub(super) struct ChunkBuffers {
    pub count: u32,
    pub chunks: Buffer,
    pub params: Buffer,
}

/// Chunks, bound to the kernel that takes them.
#[derive(Debug)]
pub(super) struct Chunks {
    pub count: u32,
    pub bindings: BindGroup,
}

impl List {
    pub(super) fn new(
        context: &mut Context<'_, '_>,
        plan: &ListPlan,
        views: &Buffer,
        view_count: u32,
        tile_count: u32,
    ) -> Result<Self, Error> {
        let scratch: &Scratch = context.scratch;
        let Scratch { footprints, keys, rects, setups, pairs, .. } = scratch;
        let texture = BindingResource::TextureView;
        let casters = view(&context.casters.casters);
        let triangles = view(&context.casters.triangles);
        let particle_buffers = context.chunk_buffers(plan, &plan.particle_chunks)?;
        let particle_chunks = particle_buffers.map(|ChunkBuffers { count, chunks, params }| {
            let resources = [
                params.as_entire_binding(),
                views.as_entire_binding(),
                context.casters.materials.as_entire_binding(),
                chunks.as_entire_binding(),
                texture(&casters),
                texture(footprints),
                texture(&keys[0]),
                texture(rects),
            ];
            let kernel = &context.kernels.project_particles;
            Chunks { count, bindings: kernel.bind(context.allocator.device, &resources) }
        });
        let triangle_buffers = context.chunk_buffers(plan, &plan.triangle_chunks)?;
        let triangle_chunks = triangle_buffers.map(|ChunkBuffers { count, chunks, params }| {
            let resources = [
                params.as_entire_binding(),
                views.as_entire_binding(),
                chunks.as_entire_binding(),
                texture(&triangles),
                texture(footprints),
                texture(&keys[0]),
                texture(rects),
                texture(setups),
            ];
            let kernel = &context.kernels.project_triangles;
            Chunks { count, bindings: kernel.bind(context.allocator.device, &resources) }
        });
        let copied = BufferUsages::COPY_SRC;
        let counters = context.allocator.storage::<BatchCounters>("counters", 1, copied)?;
        let device = context.allocator.device;
        let readback = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("counters_readback"),
            size: size_of::<BatchCounters>() as u64,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let curved = plan.features.nodes > 0 && !context.camera;
        let run_length = bin::run_length(plan.footprint_count);
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
                segment_length: match plan.features {
                    _ if context.camera => SEGMENT_LENGTH,
                    Features { nodes: 1.., .. } => CURVE_SEGMENT,
                    Features { plain: true, .. } => DISC_SEGMENT,
                    _ => SEGMENT_LENGTH,
                },
            },
        );
        let (mut depth_sort, mut tile_sort) = (None, None);
        if plan.footprint_count > 0 {
            let sort = &context.kernels.sort;
            let known = SortCount::Known(plan.footprint_count);
            let mut depth = sort.bind(device, [&keys[0], &keys[1]], known, 0..DEPTH_BITS)?;
            depth.write_count(context.queue, plan.footprint_count);
            let counted = SortCount::FromBuffer {
                counts: &counters,
                index: bin::PAIR_COUNT_INDEX,
                capacity: scratch.pair_capacity,
            };
            let bits = (32 - (tile_count - 1).leading_zeros()).max(1);
            let tile = sort.bind(device, [&pairs[0], &pairs[1]], counted, 0..bits)?;
            context.allocator.memory.add("histograms", depth.scratch_size() + tile.scratch_size());
            (depth_sort, tile_sort) = (Some(depth), Some(tile));
        }
        let sorted = texture(&keys[depth_sort.as_ref().map_or(0, SortBindings::result)]);
        let sorted_pairs = tile_sort.as_ref().map_or(0, SortBindings::result);
        let kernels = &context.kernels;
        let count = kernels.bin_count.bind(
            device,
            &[
                params.as_entire_binding(),
                sorted.clone(),
                texture(rects),
                scratch.run_offsets.as_entire_binding(),
                counters.as_entire_binding(),
            ],
        );
        let scan = kernels.bin_scan.bind(
            device,
            &[
                params.as_entire_binding(),
                scratch.run_offsets.as_entire_binding(),
                counters.as_entire_binding(),
            ],
        );
        let emit = kernels.bin_emit.bind(
            device,
            &[
                params.as_entire_binding(),
                views.as_entire_binding(),
                sorted,
                texture(rects),
                scratch.run_offsets.as_entire_binding(),
                counters.as_entire_binding(),
                scratch.overflow.as_entire_binding(),
                texture(&pairs[0]),
            ],
        );
        let ranges = kernels.bin_ranges.bind(
            device,
            &[
                counters.as_entire_binding(),
                texture(&pairs[sorted_pairs]),
                scratch.tiles.as_entire_binding(),
            ],
        );
        let segments = kernels.bin_segments.bind(
            device,
            &[
                params.as_entire_binding(),
                views.as_entire_binding(),
                counters.as_entire_binding(),
                if curved { &scratch.nothing_scattered } else { &scratch.scattered_tiles }
                    .as_entire_binding(),
                scratch.tiles.as_entire_binding(),
                scratch.segments.as_entire_binding(),
                scratch.merged_tiles.as_entire_binding(),
            ],
        );
        let dispatch = kernels
            .bin_dispatch
            .bind(device, &[counters.as_entire_binding(), scratch.dispatches.as_entire_binding()]);
        Ok(Self {
            footprint_count: plan.footprint_count,
            run_count,
            tile_count,
            particle_chunks,
            triangle_chunks,
            counters,
            readback,
            depth_sort,
            tile_sort,
            sorted_pairs,
            count,
            scan,
            emit,
            ranges,
            segments,
            dispatch,
        })
    }

    /// project: footprints, keys and rectangles.
    pub(super) fn record_project(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        if self.footprint_count == 0 {
            return;
        }
        let mut pass = timeline.pass(encoder, "project");
        if let Some(chunks) = &self.particle_chunks {
            kernels.project_particles.record(&mut pass, &chunks.bindings, grid(chunks.count));
        }
        if let Some(chunks) = &self.triangle_chunks {
            kernels.project_triangles.record(&mut pass, &chunks.bindings, grid(chunks.count));
        }
    }

    /// sort and bin, up to the pairs in depth order and the list of those that did not fit.
    /// False where there is no caster.
    pub(super) fn record_emit(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) -> bool {
        let Some(depth_sort) = &self.depth_sort else { return false };
        kernels.sort.record(&mut timeline.pass(encoder, "sort"), depth_sort);
        let mut pass = timeline.pass(encoder, "bin");
        let runs = [self.run_count.div_ceil(bin::LANES), 1, 1];
        kernels.bin_count.record(&mut pass, &self.count, runs);
        kernels.bin_scan.record(&mut pass, &self.scan, [1, 1, 1]);
        kernels.bin_emit.record(&mut pass, &self.emit, runs);
        kernels.bin_dispatch.record(&mut pass, &self.dispatch, [1, 1, 1]);
        true
    }

    /// The rest of bin: each tile's pairs, and the segments of long tiles.
    pub(super) fn record_tiles(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let mut pass = timeline.pass(encoder, "bin");
        if let Some(tile_sort) = &self.tile_sort {
            kernels.sort.record(&mut pass, tile_sort);
            kernels.bin_ranges.record(&mut pass, &self.ranges, [bin::RANGE_GROUPS, 1, 1]);
        }
        let tiles = [self.tile_count.div_ceil(bin::TILE_LANES), 1, 1];
        kernels.bin_segments.record(&mut pass, &self.segments, tiles);
        kernels.bin_dispatch.record(&mut pass, &self.dispatch, [1, 1, 1]);
    }

    pub(super) fn read_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<ListCounters, Error> {
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(&self.counters, 0, &self.readback, 0, self.readback.size());
        queue.submit([encoder.finish()]);
        self.readback.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        let lost = |error: &dyn std::fmt::Display| Error::Lost(error.to_string());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| lost(&e))?;
        let bytes = self.readback.slice(..).get_mapped_range().map_err(|e| lost(&e))?;
        let counters = bytemuck::pod_read_unaligned(&bytes);
        drop(bytes);
        self.readback.unmap();
        Ok(counters)
    }
}

/// Views of the batch in a uniform array.
pub(super) fn view_array(views: &[GpuView]) -> Vec<GpuView> {
    let mut array = views.to_vec();
    array.resize(MAX_VIEWS, bytemuck::Zeroable::zeroed());
    array
}

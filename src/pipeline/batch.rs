//! A batch: as many views as share the scratch memory at once, from casters to maps.
use super::{
    Config,
    casters::{CasterSet, Class, Span},
    kernels::{Kernels, Variant},
    list::{ChunkBuffers, Chunks, List, ListCounters, ListPlan, Scratch, view_array},
    maps::Maps,
};
use crate::{
    error::Error,
    footprint::{FOOTPRINT_TEXELS, ROW},
    gpu::{Allocator, Timeline, array_view, view},
    stage::{
        accumulate::TINY_GROUPS,
        bin::Dispatch,
        hits::Features,
        project::{CHUNK_SIZE, Chunk, ProjectParams},
    },
    view::{GpuView, MAX_VIEWS, View},
};
use std::{
    ops::{Range, RangeInclusive},
    sync::Arc,
};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages};

/// Tiles of a batch: one map of 4096x4096 texels, whose sums just fit a storage binding.
const MAX_TILES: u32 = 65536;

/// What a batch will do, known on the CPU.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub views: Vec<GpuView>,
    pub tile_count: u32,
    /// Opaque, translucent.
    pub lists: [ListPlan; 2],
}

/// What `prepare` works with.
pub(super) struct Context<'a, 'd> {
    pub allocator: &'a mut Allocator<'d>,
    pub queue: &'a wgpu::Queue,
    pub kernels: &'a mut Kernels,
    pub config: &'a Config,
    pub casters: &'a CasterSet,
    pub scratch: &'a Arc<Scratch>,
    /// The lists are the camera's: all is seen, in order.
    pub camera: bool,
}

impl Context<'_, '_> {
    pub(super) fn uniform<T: bytemuck::NoUninit>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> Buffer {
        let buffer = self.allocator.uniform::<T>(name);
        self.queue.write_buffer(&buffer, 0, bytemuck::bytes_of(value));
        buffer
    }

    /// `None` where there are no chunks.
    pub(super) fn chunk_buffers(
        &mut self,
        plan: &ListPlan,
        chunks: &[Chunk],
    ) -> Result<Option<ChunkBuffers>, Error> {
        if chunks.is_empty() {
            return Ok(None);
        }
        let scatter = self.config.scatter_tiny && plan.class == Class::Translucent && !self.camera;
        let params = self.uniform(
            "project_params",
            &ProjectParams {
                chunk_count: chunks.len() as u32,
                scatter: u32::from(scatter),
                first_setup: plan.first_setup,
                unseen: u32::from(self.camera),
            },
        );
        let none = BufferUsages::empty();
        let buffer = self.allocator.storage::<Chunk>("chunks", chunks.len() as u64, none)?;
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(chunks));
        Ok(Some(ChunkBuffers { count: chunks.len() as u32, chunks: buffer, params }))
    }
}

/// What a shadow view lists: what blocks light, and what filters it.
const LISTS: [RangeInclusive<Class>; 2] =
    [Class::Opaque..=Class::Dithered, Class::Translucent..=Class::Translucent];

/// Cuts the views into batches and lists their casters.
pub(super) fn plan(views: &[View], casters: &CasterSet, maps: &Maps) -> Result<Vec<Plan>, Error> {
    let per_view =
        LISTS.map(|list| casters.span(list).count()).into_iter().max().unwrap_or(0) as u64;
    let most_footprints = u64::from(ROW * 8192 / FOOTPRINT_TEXELS);
    if per_view > most_footprints {
        return Err(Error::Limit {
            limit: "casters of one class",
            have: most_footprints,
            need: per_view,
            remedy: "split the scene",
        });
    }
    let mut plans = Vec::new();
    let mut batch: Vec<GpuView> = Vec::new();
    let mut tile_count = 0;
    for (view, place) in views.iter().zip(&maps.places) {
        let tiles = view.tiles().element_product();
        let mut gpu_view = view.to_gpu(tile_count, place.origin, place.layer);
        let full = tile_count + tiles > MAX_TILES
            || batch.len() == MAX_VIEWS
            || batch.first().is_some_and(|v| v.perspective != gpu_view.perspective)
            || per_view * (batch.len() as u64 + 1) > most_footprints;
        if full && !batch.is_empty() {
            plans.push(Plan::new(std::mem::take(&mut batch), tile_count, casters));
            tile_count = 0;
            gpu_view.first_tile = 0;
        }
        batch.push(gpu_view);
        tile_count += tiles;
    }
    if !batch.is_empty() {
        plans.push(Plan::new(batch, tile_count, casters));
    }
    Ok(plans)
}

impl Plan {
    fn new(views: Vec<GpuView>, tile_count: u32, casters: &CasterSet) -> Self {
        let perspective = views[0].perspective > 0.0;
        let has_opaque = casters.span(LISTS[0].clone()).count() > 0;
        let [blocking, filtering] = LISTS.map(|list| {
            let span = casters.span(list.clone());
            let features = span.features.of_views(perspective, has_opaque);
            ListPlan::new(*list.start(), Span { features, ..span }, views.len() as u32)
        });
        let first = casters.span(LISTS[1].clone()).particles.start;
        let may_be_tiny = |chunk: &&Chunk| {
            let extent = &casters.extents()[((chunk.first_caster - first) / CHUNK_SIZE) as usize];
            extent.may_be_tiny(&views[chunk.view as usize])
        };
        let tiny_chunks = filtering.particle_chunks.iter().filter(may_be_tiny).copied().collect();
        let lists = [blocking, ListPlan { tiny_chunks, ..filtering }];
        Self { views, tile_count, lists }
    }

    /// Of the picture: what is solid, and all else that is seen.
    pub(super) fn of_camera(view: GpuView, tile_count: u32, casters: &CasterSet) -> Self {
        let solid = casters.span(Class::Opaque..=Class::Opaque);
        let clear = casters.span(Class::Dithered..=Class::Unseen);
        let features = Features { plain: false, ..clear.features };
        let lists = [
            ListPlan::new(
                Class::Opaque,
                Span { features: solid.features.of_views(false, false), ..solid },
                1,
            ),
            ListPlan::new(Class::Translucent, Span { features, ..clear }, 1),
        ];
        Self { views: vec![view], tile_count, lists }
    }
}

impl ListPlan {
    /// A span of casters, in every view.
    fn new(class: Class, span: Span, view_count: u32) -> Self {
        let mut footprint_count = 0;
        let mut list = |range: Range<u32>| {
            let mut chunks = Vec::new();
            for view in 0..view_count {
                for first_caster in range.clone().step_by(CHUNK_SIZE as usize) {
                    let count = (range.end - first_caster).min(CHUNK_SIZE);
                    let first_footprint = footprint_count;
                    chunks.push(Chunk { view, first_caster, count, first_footprint });
                    footprint_count += count;
                }
            }
            chunks
        };
        let Span { particles, triangles, features } = span;
        let particle_chunks = list(particles);
        let triangle_chunks = list(triangles);
        let first_setup = particle_chunks.iter().map(|chunk| chunk.count).sum();
        Self {
            class,
            features,
            particle_chunks,
            tiny_chunks: Vec::new(),
            triangle_chunks,
            footprint_count,
            first_setup,
        }
    }
}

/// A batch, bound and ready to be recorded.
#[derive(Debug)]
pub(super) struct Batch {
    scratch: Arc<Scratch>,
    tile_count: u32,
    /// What finds the opaque depths: tiles, segments, overflow, resolve.
    blocking: [Variant; 4],
    opaque: ClassBatch,
    translucent: ClassBatch,
}

/// A class's list and the bindings of the kernels that read it.
#[derive(Debug)]
struct ClassBatch {
    list: List,
    features: Features,
    /// Of tiny particles; translucent only.
    tiny: Option<Chunks>,
    overflow: BindGroup,
    tiles: BindGroup,
    segments: BindGroup,
    resolve: BindGroup,
}

impl Batch {
    pub(super) fn new(
        context: &mut Context<'_, '_>,
        plan: &Plan,
        maps: &Maps,
    ) -> Result<Self, Error> {
        let views = context.allocator.uniform::<[GpuView; MAX_VIEWS]>("views");
        let array = view_array(&plan.views);
        context.queue.write_buffer(&views, 0, bytemuck::cast_slice(&array));
        let view_count = plan.views.len() as u32;
        let mut list =
            |i: usize| List::new(context, &plan.lists[i], &views, view_count, plan.tile_count);
        let (opaque, translucent) = (list(0)?, list(1)?);
        let blocking = blocking(maps.colored.is_some());
        let tiny = if context.config.scatter_tiny { &plan.lists[1].tiny_chunks[..] } else { &[] };
        let tiny = context.chunk_buffers(&plan.lists[1], tiny)?;
        Ok(Self {
            scratch: Arc::clone(context.scratch),
            tile_count: plan.tile_count,
            blocking,
            opaque: ClassBatch::opaque(context, maps, opaque, plan.lists[0].features, &views),
            translucent: ClassBatch::translucent(
                context,
                maps,
                translucent,
                plan.lists[1].features,
                &views,
                tiny,
            ),
        })
    }

    pub(super) fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        use Variant as V;
        let Self { opaque, translucent, .. } = self;
        let [tiles_of, segments_of, overflow_of, resolve_of] = self.blocking;
        let tiles = [self.tile_count, 1, 1];
        let dispatches = &self.scratch.dispatches;
        let segments = Dispatch::Segment.offset();
        let merged = Dispatch::Merged.offset();
        // Without opaque casters the opaque depth stays what `Maps` filled in: 1.
        if opaque.list.footprint_count > 0 {
            self.record_lists(opaque, kernels, encoder, timeline, None, overflow_of);
            let mut pass = timeline.pass(encoder, "occlude");
            let kernel = |variant| kernels.get(variant, opaque.features);
            kernel(tiles_of).record(&mut pass, &opaque.tiles, tiles);
            kernel(segments_of).record_indirect(&mut pass, &opaque.segments, dispatches, segments);
            let resolve = &opaque.resolve;
            kernel(resolve_of).record_indirect(&mut pass, resolve, dispatches, merged);
        }

        let tiny = Some(V::AccumulateTiny);
        self.record_lists(translucent, kernels, encoder, timeline, tiny, V::AccumulateOverflow);
        let mut pass = timeline.pass(encoder, "accumulate");
        let kernel = |variant| kernels.get(variant, translucent.features);
        kernel(V::AccumulateTiles).record(&mut pass, &translucent.tiles, tiles);
        kernel(V::AccumulateSegments).record_indirect(
            &mut pass,
            &translucent.segments,
            dispatches,
            segments,
        );
        drop(pass);
        let mut pass = timeline.pass(encoder, "resolve");
        kernel(V::ResolveTiles).record_indirect(
            &mut pass,
            &translucent.resolve,
            dispatches,
            merged,
        );
    }

    fn record_lists(
        &self,
        class: &ClassBatch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
        tiny: Option<Variant>,
        overflow: Variant,
    ) {
        timeline.step(encoder, "clear");
        self.scratch.clear(&class.list, encoder);
        class.list.record_project(kernels, encoder, timeline);
        if let (Some(variant), Some(chunks)) = (tiny, &class.tiny) {
            let mut pass = timeline.pass(encoder, "accumulate");
            let kernel = kernels.get(variant, class.features);
            kernel.record(&mut pass, &chunks.bindings, [chunks.count.min(TINY_GROUPS), 1, 1]);
        }
        if class.list.record_emit(kernels, encoder, timeline) {
            let stage = if tiny.is_some() { "accumulate" } else { "occlude" };
            let mut pass = timeline.pass(encoder, stage);
            kernels.get(overflow, class.features).record_indirect(
                &mut pass,
                &class.overflow,
                &self.scratch.dispatches,
                Dispatch::Overflow.offset(),
            );
        }
        class.list.record_tiles(kernels, encoder, timeline);
    }

    /// `(opaque, translucent)`
    pub(super) fn read_counters(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
    ) -> Result<(ListCounters, ListCounters), Error> {
        Ok((
            self.opaque.list.read_counters(device, queue)?,
            self.translucent.list.read_counters(device, queue)?,
        ))
    }
}

/// Resources that the bindings of a class share.
struct Shared<'a> {
    views: BindingResource<'a>,
    materials: BindingResource<'a>,
    dispatches: BindingResource<'a>,
    tiles: BindingResource<'a>,
    segments: BindingResource<'a>,
    merged_tiles: BindingResource<'a>,
    scattered_tiles: BindingResource<'a>,
    overflow: BindingResource<'a>,
    pairs: BindingResource<'a>,
    footprints: BindingResource<'a>,
    rects: BindingResource<'a>,
    sums: [BindingResource<'a>; 4],
}

impl<'a> Shared<'a> {
    fn new(context: &'a Context<'_, '_>, list: &List, views: &'a Buffer) -> Self {
        let scratch = context.scratch;
        Self {
            views: views.as_entire_binding(),
            materials: context.casters.materials.as_entire_binding(),
            dispatches: scratch.dispatches.as_entire_binding(),
            tiles: scratch.tiles.as_entire_binding(),
            segments: scratch.segments.as_entire_binding(),
            merged_tiles: scratch.merged_tiles.as_entire_binding(),
            scattered_tiles: scratch.scattered_tiles.as_entire_binding(),
            overflow: scratch.overflow.as_entire_binding(),
            pairs: BindingResource::TextureView(&scratch.pairs[list.sorted_pairs]),
            footprints: BindingResource::TextureView(&scratch.footprints),
            rects: BindingResource::TextureView(&scratch.rects),
            sums: scratch.sums.resources(),
        }
    }

    /// `[views, materials]`, then `own`, then what hit tests read.
    fn hits<const N: usize>(
        &self,
        own: [&BindingResource<'a>; N],
        hit: &[BindingResource<'a>],
    ) -> Vec<BindingResource<'a>> {
        let mut all = vec![self.views.clone(), self.materials.clone()];
        all.extend(own.map(Clone::clone));
        all.extend_from_slice(hit);
        all
    }

    fn summed(&self, rest: Vec<BindingResource<'a>>) -> Vec<BindingResource<'a>> {
        self.sums.iter().cloned().chain(rest).collect()
    }
}

/// Tiles, segments, overflow, resolve.
fn blocking(colored: bool) -> [Variant; 4] {
    use Variant as V;
    if colored {
        [V::ColoredTiles, V::ColoredSegments, V::ColoredOverflow, V::ColoredResolve]
    } else {
        [V::OccludeTiles, V::OccludeSegments, V::OccludeOverflow, V::ResolveOpaque]
    }
}

impl ClassBatch {
    fn opaque(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
    ) -> Self {
        let device = context.allocator.device;
        let variants = blocking(maps.colored.is_some());
        for variant in variants {
            context.kernels.make(device, variant, features);
        }
        let shared = Shared::new(context, &list, views);
        let casters = view(&context.casters.casters);
        let images = array_view(&context.casters.images);
        let opaques = array_view(&maps.opaques);
        let texture = BindingResource::TextureView;
        let hit = [texture(&casters), texture(&context.scratch.setups), texture(&images)];
        let bind = |variant, resources: Vec<BindingResource<'_>>| {
            context.kernels.get(variant, features).bind(device, &resources)
        };
        let Shared { dispatches, tiles, segments, overflow, scattered_tiles, pairs, .. } = &shared;
        let Shared { footprints, rects, merged_tiles, .. } = &shared;
        let colored = maps.colored.as_ref().map(array_view);
        let depths = std::iter::once(&opaques).chain(&colored).map(BindingResource::TextureView);
        let depths: Vec<_> = depths.collect();
        let mut to_map = shared.hits([tiles, pairs, footprints], &hit);
        to_map.extend_from_slice(&depths);
        let mut resolve =
            vec![shared.views.clone(), dispatches.clone(), merged_tiles.clone(), tiles.clone()];
        resolve.extend(depths);
        let to_sums = shared.hits([dispatches, segments, pairs, footprints], &hit);
        let rest = shared.hits([dispatches, overflow, scattered_tiles, rects, footprints], &hit);
        let [tiles_of, segments_of, overflow_of, resolve_of] = variants;
        let (tiles, segments, overflow, resolve) = (
            bind(tiles_of, to_map),
            bind(segments_of, shared.summed(to_sums)),
            bind(overflow_of, shared.summed(rest)),
            bind(resolve_of, shared.summed(resolve)),
        );
        Self { list, features, tiny: None, overflow, tiles, segments, resolve }
    }

    fn translucent(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        tiny: Option<ChunkBuffers>,
    ) -> Self {
        use Variant as V;
        let device = context.allocator.device;
        for variant in [
            V::AccumulateTiles,
            V::AccumulateSegments,
            V::AccumulateTiny,
            V::AccumulateOverflow,
            V::ResolveTiles,
        ] {
            context.kernels.make(device, variant, features);
        }
        let shared = Shared::new(context, &list, views);
        let casters = view(&context.casters.casters);
        let images = array_view(&context.casters.images);
        let opaques = array_view(&maps.opaques);
        let filters = array_view(&maps.filters);
        let nearests = array_view(&maps.nearests);
        let texture = BindingResource::TextureView;
        let hit = [
            texture(&casters),
            texture(&context.scratch.setups),
            texture(&images),
            texture(&opaques),
        ];
        let bind = |variant, resources: Vec<BindingResource<'_>>| {
            context.kernels.get(variant, features).bind(device, &resources)
        };
        let Shared { dispatches, tiles, segments, overflow, scattered_tiles, pairs, .. } = &shared;
        let Shared { footprints, rects, merged_tiles, .. } = &shared;
        let outputs = [texture(&filters), texture(&nearests)];
        let mut to_map = shared.hits([tiles, pairs, footprints], &hit);
        to_map.extend(outputs.clone());
        let mut resolve =
            vec![shared.views.clone(), dispatches.clone(), merged_tiles.clone(), tiles.clone()];
        resolve.extend(outputs);
        let to_sums = shared.hits([dispatches, segments, pairs, footprints], &hit);
        let rest = shared.hits([dispatches, overflow, scattered_tiles, rects, footprints], &hit);
        let tiny = tiny.map(|ChunkBuffers { count, chunks, params }| {
            let counters = list.counters.as_entire_binding();
            let chunks = chunks.as_entire_binding();
            let own = [&chunks, scattered_tiles, &counters, rects, footprints];
            let mut resources = shared.hits(own, &hit);
            resources.insert(0, params.as_entire_binding());
            Chunks { count, bindings: bind(V::AccumulateTiny, shared.summed(resources)) }
        });
        let (tiles, segments, overflow, resolve) = (
            bind(V::AccumulateTiles, to_map),
            bind(V::AccumulateSegments, shared.summed(to_sums)),
            bind(V::AccumulateOverflow, shared.summed(rest)),
            bind(V::ResolveTiles, shared.summed(resolve)),
        );
        Self { list, features, tiny, overflow, tiles, segments, resolve }
    }
}

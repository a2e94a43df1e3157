//! A batch: as many views as share the scratch memory at once, from casters to maps.
use super::{
    Config,
    casters::{CasterSet, Class},
    kernels::{Kernels, Variant},
    list::{ChunkBuffers, Chunks, List, ListCounters, ListPlan, Scratch, view_array},
    maps::Maps,
    small::{SmallTriangles, copy_depths},
};
use crate::{
    atlas::MapPlace,
    error::Error,
    footprint::{FOOTPRINT_TEXELS, ROW},
    gpu::{Allocator, Timeline, array_view, view},
    stage::{
        accumulate::TINY_GROUPS,
        bin::{Dispatch, tile_grid},
        curve::CURVE_SEGMENT,
        hits::Features,
        project::{Chunk, ProjectParams},
    },
    view::{GpuView, MAX_VIEWS, TILE_SIZE, View},
};
use std::{ops::RangeInclusive, sync::Arc};
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
    /// The maps hold something already.
    pub kept: bool,
    /// The maps have been filled with what they are without translucent casters.
    pub cleared: bool,
    /// Of opaque triangles that are in no list.
    pub small_chunks: Vec<Chunk>,
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
        let may_scatter = plan.class == *Class::FILTERING.start() && !plan.is_composed();
        let scatter = self.config.scatters() && may_scatter && !self.camera;
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
pub(super) const LISTS: [RangeInclusive<Class>; 2] = [Class::BLOCKING, Class::FILTERING];

/// A view to be rendered.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen<'a> {
    pub view: &'a View,
    pub place: MapPlace,
    /// Indices of the groups that it may see, in order.
    pub groups: &'a [u32],
}

/// Cuts the views into batches and lists their casters. `nodes`: K of the curves, 0 for none;
/// `kept`: the maps hold something already.
pub(super) fn plan(
    views: &[Seen<'_>],
    casters: &CasterSet,
    nodes: u32,
    kept: bool,
) -> Result<Vec<Plan>, Error> {
    let most_footprints = u64::from(ROW * 8192 / FOOTPRINT_TEXELS);
    let mut plans = Vec::new();
    let mut batch = Vec::new();
    let mut footprints = [0; 2];
    let mut tile_count = 0;
    for seen in views {
        let Seen { view, place, groups } = *seen;
        let listed = LISTS.map(|list| count(casters, groups, &list));
        if let Some(&need) = listed.iter().find(|&&listed| listed > most_footprints) {
            return Err(Error::Limit {
                limit: "casters of one class in a view",
                have: most_footprints,
                need,
                remedy: "split the scene",
            });
        }
        let tiles = view.tiles().element_product();
        let mut gpu_view = view.to_gpu(tile_count, place.origin, place.layer);
        let full = tile_count + tiles > MAX_TILES
            || batch.len() == MAX_VIEWS
            || batch
                .first()
                .is_some_and(|(v, _): &(GpuView, _)| v.perspective != gpu_view.perspective)
            || (0..2).any(|i| footprints[i] + listed[i] > most_footprints);
        if full && !batch.is_empty() {
            plans.push(Plan::new(std::mem::take(&mut batch), tile_count, casters, nodes, kept));
            (tile_count, footprints) = (0, [0; 2]);
            gpu_view.first_tile = 0;
        }
        batch.push((gpu_view, groups));
        tile_count += tiles;
        footprints = [0, 1].map(|i| footprints[i] + listed[i]);
    }
    if !batch.is_empty() {
        plans.push(Plan::new(batch, tile_count, casters, nodes, kept));
    }
    Ok(plans)
}

/// Casters of a list in groups.
fn count(casters: &CasterSet, groups: &[u32], list: &RangeInclusive<Class>) -> u64 {
    let groups = groups.iter().map(|&group| &casters.groups()[group as usize]);
    groups.filter(|group| list.contains(&group.class)).map(|group| group.casters.len() as u64).sum()
}

impl Plan {
    /// (caster, view) that are projected.
    pub(super) fn caster_count(&self) -> u64 {
        let listed: u64 = self.lists.iter().map(|list| u64::from(list.footprint_count)).sum();
        listed + self.small_chunks.iter().map(|chunk| u64::from(chunk.count)).sum::<u64>()
    }

    /// `nodes`: K of the curves, 0 for none.
    fn new(
        seen: Vec<(GpuView, &[u32])>,
        tile_count: u32,
        casters: &CasterSet,
        nodes: u32,
        kept: bool,
    ) -> Self {
        let (views, groups): (Vec<_>, Vec<_>) = seen.into_iter().unzip();
        let perspective = views[0].perspective > 0.0;
        let has_opaque = casters.span(LISTS[0].clone()).count() > 0;
        let [mut blocking, filtering] = LISTS.map(|list| {
            let features = casters.span(list.clone()).features.of_views(perspective, has_opaque);
            ListPlan::new(&list, features, casters, &groups)
        });
        let small_chunks = blocking.take_triangles(|chunk| {
            let small = casters.triangle_group(chunk.first_caster).triangles;
            small.is_some_and(|extent| extent.is_small(&views[chunk.view as usize]))
        });
        blocking.features.small = !small_chunks.is_empty();
        let tiny_chunks = filtering.tiny(casters, &groups, &views);
        let features = Features { nodes, ..filtering.features };
        let lists = [blocking, ListPlan { tiny_chunks, features, ..filtering }];
        Self { views, tile_count, lists, small_chunks, kept, cleared: false }
    }

    /// Of the picture: what is solid, and all else that is seen.
    pub(super) fn of_camera(view: GpuView, tile_count: u32, casters: &CasterSet) -> Self {
        let visible = casters.visible(&view);
        let list = |list: RangeInclusive<Class>, solid: bool| {
            let features = casters.span(list.clone()).features;
            let features = if solid {
                features.of_views(false, false)
            } else {
                Features { plain: false, ..features }
            };
            ListPlan::new(&list, features, casters, &[&visible])
        };
        let lists = [list(Class::SOLID, true), list(Class::BLENDED, false)];
        let small_chunks = Vec::new();
        Self { views: vec![view], tile_count, lists, small_chunks, kept: false, cleared: false }
    }
}

impl ListPlan {
    /// Of the classes of `list`, what each view may see.
    fn new(
        list: &RangeInclusive<Class>,
        features: Features,
        casters: &CasterSet,
        visible: &[&[u32]],
    ) -> Self {
        let mut footprint_count = 0;
        let mut chunks_of = |is_triangles| {
            let mut chunks = Vec::new();
            for (view, groups) in (0..).zip(visible) {
                let groups = groups.iter().map(|&group| &casters.groups()[group as usize]);
                for group in groups {
                    if group.is_triangles() == is_triangles && list.contains(&group.class) {
                        let count = group.casters.len() as u32;
                        let (first_caster, first_footprint) =
                            (group.casters.start, footprint_count);
                        chunks.push(Chunk { view, first_caster, count, first_footprint });
                        footprint_count += count;
                    }
                }
            }
            chunks
        };
        let particle_chunks = chunks_of(false);
        let triangle_chunks = chunks_of(true);
        let first_setup = particle_chunks.iter().map(|chunk| chunk.count).sum();
        Self {
            class: *list.start(),
            features,
            particle_chunks,
            tiny_chunks: Vec::new(),
            triangle_chunks,
            footprint_count,
            first_setup,
        }
    }

    /// Those of the particles' chunks that may have tiny ones.
    fn tiny(&self, casters: &CasterSet, visible: &[&[u32]], views: &[GpuView]) -> Vec<Chunk> {
        let groups = casters.groups();
        let extents = visible.iter().flat_map(|visible| {
            let listed = visible.iter().map(|&group| &groups[group as usize]);
            listed
                .filter(|group| group.class == Class::Translucent && !group.is_triangles())
                .map(|group| &group.extent)
        });
        let chunks = self.particle_chunks.iter().zip(extents);
        chunks
            .filter(|(chunk, extent)| extent.may_be_tiny(&views[chunk.view as usize]))
            .map(|(chunk, _)| *chunk)
            .collect()
    }

    /// Takes the chunks out that `is_taken` says.
    fn take_triangles(&mut self, is_taken: impl FnMut(&Chunk) -> bool) -> Vec<Chunk> {
        let (taken, mut rest): (Vec<_>, Vec<_>) =
            std::mem::take(&mut self.triangle_chunks).into_iter().partition(is_taken);
        self.footprint_count = self.first_setup;
        for chunk in &mut rest {
            chunk.first_footprint = self.footprint_count;
            self.footprint_count += chunk.count;
        }
        self.triangle_chunks = rest;
        taken
    }
}

/// A batch, bound and ready to be recorded.
#[derive(Debug)]
pub(super) struct Batch {
    scratch: Arc<Scratch>,
    views: Vec<GpuView>,
    tile_count: u32,
    /// What finds the opaque depths: tiles, segments, overflow, resolve.
    blocking: [Variant; 4],
    kept: bool,
    cleared: bool,
    opaques: wgpu::Texture,
    small: Option<SmallTriangles>,
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
        let may_scatter = context.config.scatters() && !plan.lists[1].is_composed();
        let tiny = if may_scatter { &plan.lists[1].tiny_chunks[..] } else { &[] };
        let tiny = context.chunk_buffers(&plan.lists[1], tiny)?;
        Ok(Self {
            scratch: Arc::clone(context.scratch),
            views: plan.views.clone(),
            tile_count: plan.tile_count,
            blocking,
            kept: plan.kept,
            cleared: plan.cleared,
            opaques: maps.opaques.clone(),
            small: SmallTriangles::new(context, &plan.small_chunks, &views)?,
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
        let tiles = tile_grid(self.tile_count);
        let dispatches = &self.scratch.dispatches;
        let segments = Dispatch::Segment.offset();
        let merged = Dispatch::Merged.offset();
        if let Some(small) = &self.small {
            let texels = self.tile_count * TILE_SIZE * TILE_SIZE;
            small.record(&self.scratch, texels, kernels, encoder, timeline);
            if opaque.list.footprint_count == 0 {
                timeline.step(encoder, "occlude");
                copy_depths(&self.scratch, &self.views, &self.opaques, encoder);
            }
        }
        // Without opaque casters the opaque depth of new maps stays what `Maps` filled in: 1.
        let has_old_depths = self.kept && self.small.is_none();
        let by_channel = self.blocking[0] == V::ColoredTiles && self.small.is_some();
        if opaque.list.footprint_count > 0 || has_old_depths || by_channel {
            self.record_lists(opaque, kernels, encoder, timeline, None, overflow_of);
            let mut pass = timeline.pass(encoder, "occlude");
            let kernel = |variant| kernels.get(variant, opaque.features);
            kernel(tiles_of).record(&mut pass, &opaque.tiles, tiles);
            kernel(segments_of).record_indirect(&mut pass, &opaque.segments, dispatches, segments);
            let resolve = &opaque.resolve;
            kernel(resolve_of).record_indirect(&mut pass, resolve, dispatches, merged);
        }

        // `prepare` may have filled the maps with what they are without translucent casters.
        if translucent.list.footprint_count == 0 && self.cleared {
            return;
        }
        let tiny = Some(V::AccumulateTiny);
        self.record_lists(translucent, kernels, encoder, timeline, tiny, V::AccumulateOverflow);
        let mut pass = timeline.pass(encoder, "accumulate");
        let kernel = |variant| kernels.get(variant, translucent.features);
        kernel(V::AccumulateTiles).record(&mut pass, &translucent.tiles, tiles);
        // A tile has each footprint once: few make no second segment of a curve.
        let curved = translucent.features.nodes > 0;
        if curved && translucent.list.footprint_count <= CURVE_SEGMENT {
            return;
        }
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
        let small = context.scratch.small.depths.as_entire_binding();
        let hit = [texture(&casters), texture(&context.scratch.setups), texture(&images)];
        let bind = |variant, resources: Vec<BindingResource<'_>>| {
            context.kernels.get(variant, features).bind(device, &resources)
        };
        let Shared { dispatches, tiles, segments, overflow, scattered_tiles, pairs, .. } = &shared;
        let Shared { footprints, rects, merged_tiles, .. } = &shared;
        let colored = maps.colored.as_ref().map(array_view);
        let colored = colored.as_ref().map(texture);
        let mut to_map = shared.hits([tiles, pairs, footprints], &hit);
        to_map.extend([texture(&opaques), small.clone()]);
        let mut resolve = vec![
            shared.views.clone(),
            dispatches.clone(),
            merged_tiles.clone(),
            tiles.clone(),
            texture(&opaques),
            small,
        ];
        to_map.extend(colored.clone());
        resolve.extend(colored);
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
        let curves = array_view(&maps.curves);
        let counters = list.counters.as_entire_binding();
        let partials = context.scratch.partials.as_entire_binding();
        let curved = features.nodes > 0;
        let mut outputs = vec![texture(&filters), texture(&nearests)];
        let mut resolve =
            vec![shared.views.clone(), dispatches.clone(), merged_tiles.clone(), tiles.clone()];
        let (mut to_map, to_sums);
        if curved {
            outputs.push(texture(&curves));
            resolve.push(partials.clone());
            let own = [tiles, scattered_tiles, &counters, pairs, footprints];
            to_map = shared.summed(shared.hits(own, &hit));
            let own = [dispatches, segments, &partials, &counters, pairs, footprints];
            to_sums = shared.hits(own, &hit);
        } else if let Some(composed) =
            context.scratch.composed.as_ref().filter(|_| features.is_composed())
        {
            let composed = composed.as_entire_binding();
            resolve.push(composed.clone());
            to_map = shared.hits([tiles, pairs, footprints], &hit);
            let own = [dispatches, segments, tiles, &composed, pairs, footprints];
            to_sums = shared.summed(shared.hits(own, &hit));
        } else {
            to_map = shared.hits([tiles, pairs, footprints], &hit);
            to_sums = shared.summed(shared.hits([dispatches, segments, pairs, footprints], &hit));
        }
        to_map.extend(outputs.clone());
        resolve.extend(outputs);
        let rest = shared.hits([dispatches, overflow, scattered_tiles, rects, footprints], &hit);
        let tiny = tiny.map(|ChunkBuffers { count, chunks, params }| {
            let chunks = chunks.as_entire_binding();
            let own = [&chunks, scattered_tiles, &counters, rects, footprints];
            let mut resources = shared.hits(own, &hit);
            resources.insert(0, params.as_entire_binding());
            Chunks { count, bindings: bind(V::AccumulateTiny, shared.summed(resources)) }
        });
        let (tiles, segments, overflow, resolve) = (
            bind(V::AccumulateTiles, to_map),
            bind(V::AccumulateSegments, to_sums),
            bind(V::AccumulateOverflow, shared.summed(rest)),
            bind(V::ResolveTiles, shared.summed(resolve)),
        );
        Self { list, features, tiny, overflow, tiles, segments, resolve }
    }
}

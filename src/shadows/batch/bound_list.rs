//! The kernels that read a list, bound: what blocks light, or what filters it.
use crate::{
    gpu::{Timeline, array_view, view},
    shadows::{
        context::{ChunkBuffers, Chunks, Context},
        kernels::{Kernels, Variant},
        list::List,
        maps::Maps,
        scratch::Scratch,
    },
    stage::{
        accumulate::TINY_GROUPS,
        bin::{Dispatch, tile_grid},
        hits::Features,
    },
};
use wgpu::{BindGroup, BindingResource, Buffer};

/// A list and the bindings of the kernels that read it.
#[derive(Debug)]
pub(super) struct BoundList {
    pub list: List,
    pub readers: Readers,
    pub features: Features,
    /// Of tiny particles; of what filters only.
    tiny: Option<Chunks>,
    overflow: BindGroup,
    tiles: BindGroup,
    segments: BindGroup,
    resolve: BindGroup,
}

/// The kernels that read a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Readers {
    /// As the timeline calls it.
    pub stage: &'static str,
    pub tiles: Variant,
    pub segments: Variant,
    pub overflow: Variant,
    pub resolve: Variant,
}

impl Readers {
    const OCCLUDE: Self = Self {
        stage: "occlude",
        tiles: Variant::OccludeTiles,
        segments: Variant::OccludeSegments,
        overflow: Variant::OccludeOverflow,
        resolve: Variant::ResolveOpaque,
    };
    /// Where dithering is coloured.
    pub(super) const COLORED: Self = Self {
        stage: "occlude",
        tiles: Variant::ColoredTiles,
        segments: Variant::ColoredSegments,
        overflow: Variant::ColoredOverflow,
        resolve: Variant::ColoredResolve,
    };
    const ACCUMULATE: Self = Self {
        stage: "accumulate",
        tiles: Variant::AccumulateTiles,
        segments: Variant::AccumulateSegments,
        overflow: Variant::AccumulateOverflow,
        resolve: Variant::ResolveTiles,
    };

    fn all(self) -> [Variant; 4] {
        [self.tiles, self.segments, self.overflow, self.resolve]
    }
}

impl BoundList {
    pub(super) fn blocking(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
    ) -> Self {
        let device = context.allocator.device;
        let readers = if maps.colored.is_some() { Readers::COLORED } else { Readers::OCCLUDE };
        for variant in readers.all() {
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
        let (tiles, segments, overflow, resolve) = (
            bind(readers.tiles, to_map),
            bind(readers.segments, shared.summed(to_sums)),
            bind(readers.overflow, shared.summed(rest)),
            bind(readers.resolve, shared.summed(resolve)),
        );
        Self { list, readers, features, tiny: None, overflow, tiles, segments, resolve }
    }

    pub(super) fn filtering(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        tiny: Option<ChunkBuffers>,
    ) -> Self {
        let device = context.allocator.device;
        let readers = Readers::ACCUMULATE;
        for variant in readers.all().into_iter().chain([Variant::AccumulateTiny]) {
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
        let (mut to_map, mut to_sums);
        if curved {
            outputs.push(texture(&curves));
            resolve.push(partials.clone());
            let own = [tiles, scattered_tiles, &counters, footprints, pairs];
            to_map = shared.summed(shared.hits(own, &hit));
            let own = [dispatches, segments, &partials, &counters, footprints];
            to_sums = shared.hits(own, &hit);
            // Before the opaque depths, where the tiles' kernel has them too.
            to_sums.insert(to_sums.len() - 1, pairs.clone());
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
            Chunks { count, bindings: bind(Variant::AccumulateTiny, shared.summed(resources)) }
        });
        let (tiles, segments, overflow, resolve) = (
            bind(readers.tiles, to_map),
            bind(readers.segments, to_sums),
            bind(readers.overflow, shared.summed(rest)),
            bind(readers.resolve, shared.summed(resolve)),
        );
        Self { list, readers, features, tiny, overflow, tiles, segments, resolve }
    }

    /// From casters to segments; what takes the scatter path is added on the way.
    pub(super) fn record_lists(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let Self { list, readers, features, .. } = self;
        timeline.step(encoder, "clear");
        scratch.clear(list, encoder);
        list.record_project(kernels, encoder, timeline);
        if let Some(chunks) = &self.tiny {
            let mut pass = timeline.pass(encoder, readers.stage);
            let kernel = kernels.get(Variant::AccumulateTiny, *features);
            kernel.record(&mut pass, &chunks.bindings, [chunks.count.min(TINY_GROUPS), 1, 1]);
        }
        if list.record_emit(kernels, encoder, timeline) {
            let mut pass = timeline.pass(encoder, readers.stage);
            kernels.get(readers.overflow, *features).record_indirect(
                &mut pass,
                &self.overflow,
                &scratch.dispatches,
                Dispatch::Overflow.offset(),
            );
        }
        list.record_tiles(kernels, encoder, timeline);
    }

    pub(super) fn record_tiles(
        &self,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
        tile_count: u32,
    ) {
        let kernel = kernels.get(self.readers.tiles, self.features);
        kernel.record(pass, &self.tiles, tile_grid(tile_count));
    }

    pub(super) fn record_segments(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
    ) {
        let kernel = kernels.get(self.readers.segments, self.features);
        let offset = Dispatch::Segment.offset();
        kernel.record_indirect(pass, &self.segments, &scratch.dispatches, offset);
    }

    pub(super) fn record_resolve(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
    ) {
        let kernel = kernels.get(self.readers.resolve, self.features);
        let offset = Dispatch::Merged.offset();
        kernel.record_indirect(pass, &self.resolve, &scratch.dispatches, offset);
    }
}

/// Resources that the bindings of a list share.
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
            tiles: BindingResource::TextureView(&scratch.tiles),
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

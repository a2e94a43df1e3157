//! The kernels that read a list, bound: what blocks light, or what filters it.
use crate::{
    error::Error,
    gpu::{Resources, Timeline},
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
use wgpu::{BindGroup, Buffer};

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
    ) -> Result<Self, Error> {
        let readers = if maps.colored.is_some() { Readers::COLORED } else { Readers::OCCLUDE };
        Self::new(context, maps, list, readers, features, views, None)
    }

    /// `tiny`: chunks of tiny particles.
    pub(super) fn filtering(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        tiny: Option<ChunkBuffers>,
    ) -> Result<Self, Error> {
        Self::new(context, maps, list, Readers::ACCUMULATE, features, views, tiny)
    }

    fn new(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        readers: Readers,
        features: Features,
        views: &Buffer,
        tiny: Option<ChunkBuffers>,
    ) -> Result<Self, Error> {
        let device = context.allocator.device;
        let variants =
            readers.all().into_iter().chain(tiny.as_ref().map(|_| Variant::AccumulateTiny));
        for variant in variants {
            context.kernels.make(device, variant, features)?;
        }
        let scratch = context.scratch;
        let partials = match &scratch.composed {
            Some(composed) if features.is_composed() => composed,
            _ => &scratch.partials,
        };
        let resources = context
            .resources(views)
            .and(&maps.resources())
            .with("pairs", &scratch.pairs[list.sorted_pairs])
            .with("counters", &list.counters)
            .with("partials", partials);
        let bind = |variant, resources: &Resources<'_>| {
            context.kernels.get(variant, features).bind(device, resources)
        };
        let tiny = tiny.map(|buffers| {
            let bindings =
                bind(Variant::AccumulateTiny, &resources.clone().and(&buffers.resources()))?;
            Ok::<_, Error>(Chunks { count: buffers.count, bindings })
        });
        let (tiny, overflow, tiles, segments, resolve) = (
            tiny.transpose()?,
            bind(readers.overflow, &resources)?,
            bind(readers.tiles, &resources)?,
            bind(readers.segments, &resources)?,
            bind(readers.resolve, &resources)?,
        );
        Ok(Self { list, readers, features, tiny, overflow, tiles, segments, resolve })
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

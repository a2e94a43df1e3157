//! Bindings of the kernels that read a list of blocking or of filtering casters.
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
    /// Chunks of tiny particles, uploaded ones and the host's; only if the list filters.
    tiny: Vec<Chunks>,
    /// Bindings are `None` for kernels that the list never needs.
    overflow: Option<BindGroup>,
    tiles: Option<BindGroup>,
    segments: Option<BindGroup>,
    resolve: Option<BindGroup>,
}

/// The kernels that read a list.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Readers {
    /// Name of the stage in the timeline.
    pub stage: &'static str,
    pub tiles: Variant,
    pub segments: Variant,
    pub overflow: Variant,
    pub resolve: Variant,
}

impl Readers {
    const OCCLUDE: Self = Self {
        stage: "gobo occlude",
        tiles: Variant::OccludeTiles,
        segments: Variant::OccludeSegments,
        overflow: Variant::OccludeOverflow,
        resolve: Variant::ResolveOpaque,
    };
    /// Readers for coloured dithering.
    pub(super) const COLORED: Self = Self {
        stage: "gobo occlude",
        tiles: Variant::ColoredTiles,
        segments: Variant::ColoredSegments,
        overflow: Variant::ColoredOverflow,
        resolve: Variant::ColoredResolve,
    };
    const ACCUMULATE: Self = Self {
        stage: "gobo accumulate",
        tiles: Variant::AccumulateTiles,
        segments: Variant::AccumulateSegments,
        overflow: Variant::AccumulateOverflow,
        resolve: Variant::ResolveTiles,
    };
}

impl BoundList {
    pub(super) fn blocking(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        is_read: bool,
    ) -> Result<Self, Error> {
        let readers = if maps.colored.is_some() { Readers::COLORED } else { Readers::OCCLUDE };
        Self::new(context, maps, list, readers, features, views, &[], is_read)
    }

    /// `tiny`: chunks that may have tiny particles.
    pub(super) fn filtering(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        features: Features,
        views: &Buffer,
        tiny: &[&ChunkBuffers],
        is_read: bool,
    ) -> Result<Self, Error> {
        Self::new(context, maps, list, Readers::ACCUMULATE, features, views, tiny, is_read)
    }

    /// `is_read`: whether the list is recorded.
    #[expect(clippy::too_many_arguments, reason = "each is another owner's")]
    fn new(
        context: &mut Context<'_, '_>,
        maps: &Maps,
        list: List,
        readers: Readers,
        features: Features,
        views: &Buffer,
        tiny: &[&ChunkBuffers],
        is_read: bool,
    ) -> Result<Self, Error> {
        let device = context.allocator.device;
        // Segments of one tile, or scattered casters, are merged with its pairs; the tiles of curves read
        // scattered casters themselves.
        let may_scatter = list.may_overflow || !tiny.is_empty();
        let is_merged = list.has_segments || (may_scatter && features.nodes == 0);
        let needed = [
            (Variant::AccumulateTiny, is_read && !tiny.is_empty()),
            (readers.overflow, is_read && list.may_overflow),
            (readers.tiles, is_read),
            (readers.segments, is_read && is_merged),
            (readers.resolve, is_read && is_merged),
        ];
        for (variant, _) in needed.into_iter().filter(|(_, is_needed)| *is_needed) {
            context.kernels.plan(device, variant, features)?;
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
            .with("counters", list.counters())
            .with("partials", partials);
        let bind = |i: usize, resources: &Resources<'_>| {
            let (variant, is_needed) = needed[i];
            let kernel = is_needed.then(|| context.kernels.get(variant, features));
            kernel.map(|kernel| kernel.bind(device, resources)).transpose()
        };
        let mut tiny_chunks = Vec::new();
        for buffers in tiny {
            let bindings = bind(0, &resources.clone().and(&buffers.resources()))?;
            tiny_chunks.extend(bindings.map(|bindings| Chunks { count: buffers.count, bindings }));
        }
        let [overflow, tiles, segments, resolve] = [1, 2, 3, 4].map(|i| bind(i, &resources));
        let (overflow, tiles, segments, resolve) = (overflow?, tiles?, segments?, resolve?);
        Ok(Self { list, readers, features, tiny: tiny_chunks, overflow, tiles, segments, resolve })
    }

    /// Records the stages from casters to segments; casters on the scatter path are added on the way.
    pub(super) fn record_lists(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let Self { list, readers, features, .. } = self;
        timeline.step(encoder, "gobo clear");
        scratch.clear(list, encoder);
        list.record_project(kernels, encoder, timeline);
        for chunks in &self.tiny {
            let mut pass = timeline.pass(encoder, readers.stage);
            let kernel = kernels.get(Variant::AccumulateTiny, *features);
            kernel.record(&mut pass, &chunks.bindings, [chunks.count.min(TINY_GROUPS), 1, 1]);
        }
        let is_emitted = list.record_emit(kernels, encoder, timeline);
        if let Some(overflow) = self.overflow.as_ref().filter(|_| is_emitted) {
            let mut pass = timeline.pass(encoder, readers.stage);
            kernels.get(readers.overflow, *features).record_indirect(
                &mut pass,
                overflow,
                &scratch.dispatches,
                Dispatch::Overflow.offset(),
            );
        }
        list.record_tiles(kernels, encoder, timeline);
    }

    /// Records the stages from casters to pairs.
    pub(super) fn record_counts(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        timeline.step(encoder, "gobo clear");
        scratch.clear(&self.list, encoder);
        self.list.record_project(kernels, encoder, timeline);
        self.list.record_emit(kernels, encoder, timeline);
    }

    pub(super) fn record_tiles(
        &self,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
        tile_count: u32,
    ) {
        if let Some(tiles) = &self.tiles {
            let kernel = kernels.get(self.readers.tiles, self.features);
            kernel.record(pass, tiles, tile_grid(tile_count));
        }
    }

    pub(super) fn record_segments(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
    ) {
        if let Some(segments) = &self.segments {
            let kernel = kernels.get(self.readers.segments, self.features);
            let offset = Dispatch::Segment.offset();
            kernel.record_indirect(pass, segments, &scratch.dispatches, offset);
        }
    }

    pub(super) fn record_resolve(
        &self,
        scratch: &Scratch,
        kernels: &Kernels,
        pass: &mut wgpu::ComputePass<'_>,
    ) {
        if let Some(resolve) = &self.resolve {
            let kernel = kernels.get(self.readers.resolve, self.features);
            let offset = Dispatch::Merged.offset();
            kernel.record_indirect(pass, resolve, &scratch.dispatches, offset);
        }
    }
}

//! A batch: as many views as share the scratch memory at once, from casters to maps.
mod bound_list;

use super::{
    context::{Context, view_uniform},
    host_depths::Imports,
    kernels::Kernels,
    list::{List, ListCounters},
    maps::Maps,
    plan::Plan,
    read_back::ReadBack,
    scratch::Scratch,
    small::{SmallTriangles, copy_depths},
};
use crate::{error::Error, gpu::Timeline, model::TILE_SIZE, records::GpuView};
use bound_list::BoundList;
use std::sync::Arc;

/// A batch, bound and ready to be recorded.
#[derive(Debug)]
pub(super) struct Batch {
    scratch: Arc<Scratch>,
    views: Vec<GpuView>,
    tile_count: u32,
    reads_blocking: bool,
    reads_filtering: bool,
    opaques: wgpu::Texture,
    small: Option<SmallTriangles>,
    imports: Imports,
    blocking: BoundList,
    filtering: BoundList,
}

impl Batch {
    pub(super) fn new(
        context: &mut Context<'_, '_>,
        plan: &Plan,
        maps: &Maps,
    ) -> Result<Self, Error> {
        let views = view_uniform(context.allocator, context.queue, &plan.views);
        let view_count = plan.views.len() as u32;
        let mut list =
            |i: usize| List::new(context, &plan.lists[i], &views, view_count, plan.tile_count);
        let (blocking, filtering) = (list(0)?, list(1)?);
        let may_scatter = context.scatters(&plan.lists[1]);
        let tiny = if may_scatter { &plan.lists[1].tiny_chunks[..] } else { &[] };
        let tiny = context.chunk_buffers(&plan.lists[1], tiny)?;
        let host = filtering.host_chunks.as_ref().filter(|_| may_scatter);
        let host = host.map(|host| host.buffers.clone());
        let tiny: Vec<_> = tiny.iter().chain(&host).collect();
        let small = SmallTriangles::new(context, &plan.small_chunks, &views)?;
        // Without opaque casters the opaque depth of new maps stays 1, as `Maps` initialised it.
        let has_old_depths = plan.kept && small.is_none();
        let by_channel = maps.colored.is_some() && small.is_some();
        let reads_blocking = blocking.footprint_count > 0 || has_old_depths || by_channel;
        // `prepare` may have filled the maps with their values without filtering casters.
        let reads_filtering = filtering.footprint_count > 0 || !plan.cleared;
        let is_rendered = reads_blocking || small.is_some();
        let imports = Imports::new(context, maps, &plan.views, &plan.depths, is_rendered)?;
        Ok(Self {
            scratch: Arc::clone(context.scratch),
            views: plan.views.clone(),
            tile_count: plan.tile_count,
            opaques: maps.opaques.clone(),
            reads_blocking,
            reads_filtering,
            small,
            imports,
            blocking: BoundList::blocking(
                context,
                maps,
                blocking,
                plan.lists[0].features,
                &views,
                reads_blocking,
            )?,
            filtering: BoundList::filtering(
                context,
                maps,
                filtering,
                plan.lists[1].features,
                &views,
                &tiny,
                reads_filtering,
            )?,
        })
    }

    pub(super) fn record(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        self.record_blocking(kernels, encoder, timeline);
        if self.reads_filtering {
            self.filtering.record(&self.scratch, kernels, encoder, timeline);
        }
    }

    /// Records the counting of both lists' pairs, without touching a map.
    pub(super) fn record_counts(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        for bound in [&self.blocking, &self.filtering] {
            bound.record_counts(&self.scratch, kernels, encoder, timeline);
        }
    }

    fn record_blocking(
        &self,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        let Self { scratch, blocking, .. } = self;
        let is_listed = blocking.list.footprint_count > 0;
        if let Some(small) = &self.small {
            let texels = self.tile_count * TILE_SIZE * TILE_SIZE;
            small.record(scratch, texels, kernels, encoder, timeline);
            if !is_listed {
                timeline.step(encoder, "gobo occlude");
                copy_depths(scratch, &self.views, &self.opaques, encoder);
            }
        }
        if self.reads_blocking {
            blocking.record(scratch, kernels, encoder, timeline);
        }
        if !self.imports.is_empty() {
            self.imports.record(kernels, &mut timeline.pass(encoder, "gobo import"));
        }
    }

    /// Counters of the opaque and of the translucent list.
    pub(super) fn counted(&self) -> [&ReadBack<ListCounters>; 2] {
        [&self.blocking, &self.filtering].map(|bound| bound.list.counted())
    }
}

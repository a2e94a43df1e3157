//! Camera list: visible casters of some classes, with memory of its own.
use super::bands::TileRect;
use crate::{
    error::Error,
    frame::Kernels,
    gpu::{Allocator, Resources, Timeline, view},
    shadows::{
        CasterSet, Config, context::Context, kernels::Variant, list::List, plan::Plan,
        scratch::Scratch,
    },
    stage::{
        features::Features,
        shade::{NO_LIST, PointBatch, point_grid},
        sort::PAIR_FORMAT,
    },
};
use std::sync::Arc;
use wgpu::{BindGroup, Buffer, TextureUsages};

#[derive(Debug)]
pub(super) struct CameraList {
    pub list: List,
    pub scratch: Arc<Scratch>,
    pub features: Features,
    /// Footprint of the first triangle.
    pub first_setup: u32,
    /// Bindings of each part, if the list is binned in parts.
    clips: Vec<BindGroup>,
}

impl CameraList {
    #[expect(clippy::too_many_arguments, reason = "each is another owner's")]
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        kernels: &Kernels,
        config: &Config,
        casters: &CasterSet,
        plan: &Plan,
        views: &Buffer,
        pairs: Option<u32>,
        parts: &[TileRect],
    ) -> Result<Self, Error> {
        let plans = std::slice::from_ref(plan);
        let scratch = Arc::new(Scratch::new(allocator, queue, config, plans, pairs, 0)?);
        let own = &plan.lists[0];
        let is_clipped = parts.len() > 1 && own.footprint_count > 0;
        let clipped = is_clipped
            .then(|| {
                let texels = u64::from(own.footprint_count);
                let usage = TextureUsages::STORAGE_BINDING;
                allocator.records("clipped_rects", PAIR_FORMAT, texels, usage)
            })
            .transpose()?
            .map(|texture| view(&texture));
        let mut context = Context {
            allocator,
            queue,
            kernels,
            config,
            casters,
            scratch: &scratch,
            camera: true,
            binned_rects: clipped.as_ref(),
        };
        let list = List::new(&mut context, own, views, 1, plan.tile_count)?;
        let mut clips = Vec::new();
        if let Some(clipped) = &clipped {
            let batch =
                PointBatch { first: 0, count: own.footprint_count, has_normals: 0, list: NO_LIST };
            let batch = context.uniform("point_batch", &batch);
            for part in parts {
                let band = context.uniform("band", &part.band(0, 0));
                let resources = Resources::new()
                    .with("rects", &scratch.rects)
                    .with("clipped_rects", clipped)
                    .with("point_batch", &batch)
                    .with("band", &band);
                let device = context.allocator.device;
                let kernel = context.kernels.of(Variant::ShadeClip, Features::NONE)?;
                clips.push(kernel.bind(device, &resources)?);
            }
        }
        let (features, first_setup) = (own.features, own.first_setup);
        Ok(Self { list, scratch, features, first_setup, clips })
    }

    /// Records the footprints, front to back.
    pub(super) fn record_footprints(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        self.list.project.record(encoder, timeline);
        self.list.sort.record(encoder, timeline);
    }

    /// Records the pairs of a part of the tiles.
    pub(super) fn record_pairs(
        &self,
        part: usize,
        kernels: &Kernels,
        encoder: &mut wgpu::CommandEncoder,
        timeline: &mut Timeline,
    ) {
        self.list.clear.record(encoder, timeline);
        if let Some(clip) = self.clips.get(part) {
            let mut pass = timeline.pass(encoder, "gobo bin");
            let groups = point_grid(self.list.footprint_count);
            kernels.known(Variant::ShadeClip, Features::NONE).record(&mut pass, clip, groups);
        }
        self.list.pairs.record(encoder, timeline);
        self.list.tiles.record(encoder, timeline);
    }
}

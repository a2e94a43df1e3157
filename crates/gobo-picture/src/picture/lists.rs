//! Camera list: visible casters of some classes, with memory of its own.
use super::bands::TileRect;
use crate::stage::shade::CLIP;
use gobo::{
    Error,
    frame::{Commands, Dispatch},
    gpu::Allocator,
    shadows::{
        Shadows,
        batch::{batch_plan::BatchPlan, context::Context, list::List, scratch::Scratch},
    },
    stage::{
        features::{Features, Flags},
        light_points::{PointBatch, point_grid},
        sort::PAIR_FORMAT,
    },
};
use std::sync::Arc;
use wgpu::Buffer;

#[derive(Debug)]
pub(super) struct CameraList {
    pub list: List,
    pub scratch: Arc<Scratch>,
    pub features: Features,
    /// Footprint of the first triangle.
    pub first_setup: u32,
    /// Footprint with setup 0, modulo 2^32.
    pub setup_origin: u32,
    /// The clipping to each part, if the list is binned in parts.
    clips: Vec<Dispatch>,
}

impl CameraList {
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        shadows: &Shadows,
        plan: &BatchPlan,
        views: &Buffer,
        pairs: Option<u32>,
        parts: &[TileRect],
    ) -> Result<Self, Error> {
        let (queue, kernels) = (shadows.queue(), shadows.kernels());
        let config = shadows.config();
        let plans = std::slice::from_ref(plan);
        let scratch = Arc::new(Scratch::new(allocator, config, plans, pairs, 0)?);
        let camera_list = &plan.lists[0];
        let is_clipped = parts.len() > 1 && camera_list.footprint_count > 0;
        let clipped = is_clipped
            .then(|| {
                let (form, count) = (config.tuning.record_form, camera_list.footprint_count);
                allocator.written::<[u32; 2]>(form, "clipped_rects", PAIR_FORMAT, count.into())
            })
            .transpose()?;
        let mut context = Context {
            allocator,
            queue,
            kernels,
            config,
            casters: shadows.casters()?,
            scratch: &scratch,
            camera: true,
            binned_rects: clipped.as_ref(),
        };
        let list = List::new(&mut context, camera_list, views, 1, plan.tile_count)?;
        let mut clips = Vec::new();
        if let Some(clipped) = &clipped {
            let batch = PointBatch::of(0, camera_list.footprint_count);
            let batch = context.allocator.uniform("point_batch", &batch);
            let groups = point_grid(camera_list.footprint_count);
            let gaussians = camera_list.features.has(Flags::HAS_GAUSSIANS);
            let features = Features::NONE.with(Flags::HAS_GAUSSIANS, gaussians);
            for part in parts {
                let band = context.allocator.uniform("band", &part.band(0, 0));
                let resources = scratch
                    .resources
                    .clone()
                    .with("clipped_rects", clipped)
                    .with("point_batch", &batch)
                    .with("band", &band);
                clips.push(kernels.dispatch(&CLIP, features, &resources, groups)?);
            }
        }
        let (features, first_setup) = (camera_list.features, camera_list.first_setup);
        let setup_origin = camera_list.setup_origin();
        Ok(Self { list, scratch, features, first_setup, setup_origin, clips })
    }

    /// The footprints, front to back.
    pub(super) fn footprints(&self) -> Commands {
        let mut commands = self.list.project.clone();
        commands.append(self.list.sort.clone());
        commands
    }

    /// The pairs of a part of the tiles.
    pub(super) fn pairs(&self, part: usize) -> Commands {
        let mut commands = self.list.clear.clone();
        if let Some(clip) = self.clips.get(part) {
            commands.pass("gobo bin", [clip.clone()]);
        }
        commands.append(self.list.pairs.clone());
        commands.append(self.list.tiles.clone());
        commands
    }
}

//! Context of `prepare`, and the buffers that several of its parts need.
use crate::shadows::{
    Config,
    batch::{list_plan::ListPlan, scratch::Scratch},
    casters::CasterSet,
};
use crate::{
    error::Error,
    frame::Kernels,
    gpu::{Allocator, Resource, Resources},
    records::{GpuView, MAX_VIEWS},
    stage::{
        features::Flags,
        project::{Chunk, ProjectParams},
    },
};
use glam::Vec2;
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages};

/// Context of `prepare`.
#[derive(Debug)]
pub struct Context<'a, 'd> {
    /// Allocates buffers and textures.
    pub allocator: &'a mut Allocator<'d>,
    /// Queue for uploads.
    pub queue: &'a wgpu::Queue,
    /// The kernels.
    pub kernels: &'a Kernels,
    /// The configuration of the frame.
    pub config: &'a Config,
    /// The casters.
    pub casters: &'a CasterSet,
    /// Memory that batches share.
    pub scratch: &'a Arc<Scratch>,
    /// Whether the lists are the camera's, where everything is visible and in order.
    pub camera: bool,
    /// Tile rectangles of the footprints, if only some of them are binned at a time.
    pub binned_rects: Option<&'a Resource>,
}

impl Context<'_, '_> {
    /// Resources that all lists share.
    pub(crate) fn resources(&self, views: &Buffer) -> Resources {
        self.casters.resources().and(&self.scratch.resources).with("views", views)
    }

    /// Uploads chunks; `None` if there are none.
    pub(crate) fn chunk_buffers(
        &mut self,
        plan: &ListPlan,
        chunks: &[Chunk],
    ) -> Result<Option<ChunkBuffers>, Error> {
        if chunks.is_empty() {
            return Ok(None);
        }
        let params = self.project_params(plan, chunks.len() as u32);
        self.chunk_buffers_with(&params, chunks).map(Some)
    }

    /// Buffers for `count` chunks that a kernel writes and counts.
    pub(crate) fn written_chunk_buffers(
        &mut self,
        plan: &ListPlan,
        count: u32,
    ) -> Result<ChunkBuffers, Error> {
        let first_gaussian = plan.host_setup_origin();
        let params = ProjectParams { first_gaussian, ..self.project_params(plan, 0) };
        let params = self.listed_uniform("project_params", &params, true);
        let none = BufferUsages::empty();
        let chunks = self.allocator.storage::<Chunk>("chunks", u64::from(count), none)?;
        Ok(ChunkBuffers { count, chunks, params })
    }

    /// Parameters of a list. `of_host`: a kernel replaces their counts before any other reads them.
    pub(crate) fn listed_uniform<T: bytemuck::NoUninit>(
        &mut self,
        name: &'static str,
        value: &T,
        of_host: bool,
    ) -> Buffer {
        let written = if of_host { BufferUsages::STORAGE } else { BufferUsages::COPY_DST };
        self.allocator.filled(name, std::slice::from_ref(value), BufferUsages::UNIFORM | written)
    }

    fn project_params(&self, plan: &ListPlan, chunk_count: u32) -> ProjectParams {
        // Only by distance are all bricks of a grid in order along each ray of the camera.
        let by_distance = if plan.camera {
            plan.features.has(Flags::HAS_BRICKS)
        } else {
            plan.filters && plan.features.has(Flags::HAS_OVER)
        };
        ProjectParams {
            chunk_count,
            scatter: u32::from(self.scatters(plan)),
            first_setup: plan.setup_origin(),
            first_gaussian: 0,
            include_non_casters: u32::from(plan.camera),
            by_distance: u32::from(by_distance),
        }
    }

    /// Whether tiny particles of the list skip sort and bin.
    pub(crate) fn scatters(&self, plan: &ListPlan) -> bool {
        self.config.scatters() && plan.filters && !plan.is_composed()
    }

    /// Room for the pairs of a list: none where all filtering casters are scattered.
    pub(crate) fn pair_capacity(&self, plan: &ListPlan) -> u32 {
        let scatters_all =
            self.config.toggles.sums && plan.filters && !plan.camera && !plan.sums_in_tiles();
        if scatters_all { 0 } else { self.scratch.pair_capacity }
    }

    pub(crate) fn chunk_buffers_with(
        &mut self,
        params: &ProjectParams,
        chunks: &[Chunk],
    ) -> Result<ChunkBuffers, Error> {
        let params = self.allocator.uniform("project_params", params);
        let count = chunks.len() as u32;
        let none = BufferUsages::empty();
        // Few sizes, so that frames with similar numbers of chunks share buffers.
        let room = u64::from(count).next_power_of_two();
        let buffer = self.allocator.storage::<Chunk>("chunks", room, none)?;
        self.queue.write_buffer(&buffer, 0, bytemuck::cast_slice(chunks));
        Ok(ChunkBuffers { count, chunks: buffer, params })
    }
}

/// Chunks on the device.
#[derive(Clone, Debug)]
pub(crate) struct ChunkBuffers {
    pub count: u32,
    pub chunks: Buffer,
    pub params: Buffer,
}

impl ChunkBuffers {
    pub(crate) fn resources(&self) -> Resources {
        Resources::new().with("chunks", &self.chunks).with("project_params", &self.params)
    }
}

/// The views of a batch in a uniform array.
pub fn view_uniform(allocator: &mut Allocator<'_>, views: &[GpuView]) -> Buffer {
    let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
    allocator.filled("views", &padded(views, MAX_VIEWS), usage)
}

/// `values`, followed by zeros up to `count`.
pub(super) fn padded<T: bytemuck::Zeroable + Copy>(values: &[T], count: usize) -> Vec<T> {
    let mut all = Vec::with_capacity(count);
    all.extend_from_slice(values);
    all.resize(count, T::zeroed());
    all
}

/// Workgroups of `edge` x `edge` texels that cover the largest map of a batch, and its views in z.
pub(crate) fn map_groups(views: &[GpuView], edge: u32) -> [u32; 3] {
    let largest = views.iter().fold(Vec2::ZERO, |size, view| size.max(view.size)).as_uvec2();
    [largest.x.div_ceil(edge), largest.y.div_ceil(edge), views.len() as u32]
}

//! Opaque triangles of a few texels, written straight to the depths of their texels.
use super::{context::Context, plan::Plan, scratch::Scratch};
use crate::{
    error::Error,
    frame::Commands,
    gpu::Allocator,
    model::{Bounds, Material, TILE_SIZE, Transfer, Triangle},
    records::GpuView,
    stage::{
        features::Features,
        occlude,
        project::{ProjectParams, grid},
    },
};
use wgpu::{Buffer, BufferUsages};

/// Largest side of a small triangle's bounding square [texels].
pub const SMALL_SIDE: f32 = 22.0;

/// Extent of a chunk's triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleExtent {
    /// Bounding box, world space [m].
    pub bounds: Bounds,
    /// Longest edge [m].
    pub longest: f32,
    /// Whether all have the `opaque` transfer.
    pub opaque: bool,
    /// Whether some belong to a volume, whose back faces matter beyond the far plane too.
    pub volume: bool,
}

impl TriangleExtent {
    pub(super) fn of<'a>(
        triangles: impl Iterator<Item = &'a Triangle>,
        materials: &[Material],
    ) -> Self {
        let none = Self { bounds: Bounds::EMPTY, longest: 0.0, opaque: true, volume: false };
        triangles.fold(none, |extent, triangle| {
            let [a, b, c] = triangle.positions;
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            let bounds = [a, b, c].iter().fold(extent.bounds, |all, &p| all.with_sphere(p, 0.0));
            let material = &materials[triangle.material as usize];
            Self {
                bounds,
                longest: extent.longest.max(longest),
                opaque: extent.opaque && material.transfer == Transfer::Opaque,
                volume: extent.volume || material.is_volume(),
            }
        })
    }

    /// Whether every triangle is opaque, wholly beyond the near plane and small in the view.
    pub(super) fn is_small(&self, view: &GpuView) -> bool {
        if !self.opaque {
            return false;
        }
        if view.perspective == 0.0 {
            return self.longest * view.scale <= SMALL_SIDE;
        }
        let center = -view.view_from_world.transform_point3(self.bounds.center()).z;
        let nearest = center - self.bounds.radius() * 1.001;
        // A step of 1 m changes x / z by at most (1 + |x / z|) / z.
        let steepest = view.size.length() * 0.5 / view.scale;
        nearest > view.near && self.longest * view.scale * (1.0 + steepest) / nearest <= SMALL_SIDE
    }
}

/// Depths of a batch, one element per texel, and their initial values.
#[derive(Debug)]
pub(super) struct SmallDepths {
    pub depths: Buffer,
    far: Option<Buffer>,
}

impl SmallDepths {
    /// `texels`: 0 if no batch has small triangles.
    pub(super) fn new(
        allocator: &mut Allocator<'_>,
        queue: &wgpu::Queue,
        texels: u64,
    ) -> Result<Self, Error> {
        let usage = BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let depths = allocator.storage::<u32>("small_depths", texels, usage)?;
        let far = if texels > 0 {
            let far = allocator.storage::<u32>("far_depths", texels, usage)?;
            queue.write_buffer(&far, 0, bytemuck::cast_slice(&vec![1.0_f32; texels as usize]));
            Some(far)
        } else {
            None
        };
        Ok(Self { depths, far })
    }
}

/// Commands that write the small triangles of a batch; `None` if there are none.
pub(super) fn small_triangles(
    context: &mut Context<'_, '_>,
    plan: &Plan,
    views: &Buffer,
) -> Result<Option<Commands>, Error> {
    const LABEL: &str = "gobo occlude";
    let SmallDepths { depths, far } = &context.scratch.small;
    let Some(far) = far.as_ref().filter(|_| !plan.small_chunks.is_empty()) else {
        return Ok(None);
    };
    let chunk_count = plan.small_chunks.len() as u32;
    let params = ProjectParams { chunk_count, ..ProjectParams::default() };
    let buffers = context.chunk_buffers_with(&params, &plan.small_chunks)?;
    let resources = context.resources(views).and(&buffers.resources());
    let kernels = context.kernels;
    let small = kernels.dispatch(&occlude::SMALL, Features::NONE, &resources, grid(chunk_count))?;
    let mut commands = Commands::new();
    let bytes = u64::from(plan.tile_count * TILE_SIZE * TILE_SIZE) * 4;
    commands.copy_buffer(LABEL, (far, 0), (depths, 0), bytes);
    commands.pass(LABEL, [small]);
    Ok(Some(commands))
}

/// Copies the depths to the maps of `views`, for batches without other opaque casters.
pub(super) fn copy_depths(
    commands: &mut Commands,
    scratch: &Scratch,
    views: &[GpuView],
    opaques: &wgpu::Texture,
) {
    const BYTES: u32 = 4; // of a texel
    for view in views {
        let width = view.tiles_x * TILE_SIZE;
        let height = (view.size.y as u32).next_multiple_of(TILE_SIZE);
        let source = wgpu::TexelCopyBufferInfo {
            buffer: &scratch.small.depths,
            layout: wgpu::TexelCopyBufferLayout {
                offset: u64::from(view.first_tile * TILE_SIZE * TILE_SIZE * BYTES),
                bytes_per_row: Some(width * BYTES),
                rows_per_image: None,
            },
        };
        let (x, y, z) = (view.origin.x, view.origin.y, view.layer);
        let target = wgpu::TexelCopyTextureInfo {
            origin: wgpu::Origin3d { x, y, z },
            ..opaques.as_image_copy()
        };
        let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
        commands.copy_buffer_to_texture("gobo occlude", &source, target, size);
    }
}

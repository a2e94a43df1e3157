//! Opaque triangles of a few texels, written straight to the depths of their texels.
use super::{
    batch_plan::BatchPlan,
    context::Context,
    scratch::{Scratch, SmallDepths},
};
use crate::{
    error::Error,
    frame::Commands,
    model::TILE_SIZE,
    records::GpuView,
    stage::{
        features::Features,
        occlude,
        project::{ProjectParams, grid},
    },
};
use wgpu::Buffer;

/// Commands that write the small triangles of a batch, and the buffer of their chunks; `None` without small
/// triangles.
pub(in crate::shadows) fn small_triangles(
    context: &mut Context<'_, '_>,
    plan: &BatchPlan,
    views: &Buffer,
) -> Result<Option<(Commands, Buffer)>, Error> {
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
    for at in (0..bytes).step_by(far.size() as usize) {
        commands.copy_buffer(LABEL, (far, 0), (depths, at), far.size().min(bytes - at));
    }
    commands.pass(LABEL, [small]);
    Ok(Some((commands, buffers.chunks)))
}

/// Copies the depths to the maps of `views`, for batches without other opaque casters.
pub(in crate::shadows) fn copy_depths(
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

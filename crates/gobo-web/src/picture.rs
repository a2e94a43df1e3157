//! A picture in memory, for the test that compares a browser's with a native one.
use crate::{Knobs, Show, ShowError};
use gobo::{Error, wgpu};

/// Picture of a scene, `size` pixels: rgba, row by row, once the device has drawn it.
///
/// # Errors
/// Those of [`Show::draw`], or the picture cannot be read.
pub async fn picture(
    (device, queue): (&wgpu::Device, &wgpu::Queue),
    show: &mut Show,
    [width, height]: [u32; 2],
    knobs: &Knobs,
) -> Result<Vec<u8>, ShowError> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    while show.step(knobs, [width, height])?.is_some() {}
    let view = texture.create_view(&Default::default());
    show.draw(&view, format, [width, height], knobs)?;
    let row = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let staging = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("picture"),
        size: u64::from(row) * u64::from(height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    let mut encoder = device.create_command_encoder(&Default::default());
    let to = wgpu::TexelCopyBufferInfo { buffer: &staging, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    let (done, mapped) = futures_channel::oneshot::channel();
    staging.map_async(wgpu::MapMode::Read, .., |result| {
        // A receiver that has gone away is ignored.
        let _ = done.send(result);
    });
    let lost = |error: &dyn std::fmt::Display| Error::Lost(error.to_string());
    // A browser answers without polling.
    if cfg!(not(target_arch = "wasm32")) {
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| lost(&error))?;
    }
    mapped.await.map_err(|error| lost(&error))?.map_err(|error| lost(&error))?;
    let bytes = staging.get_mapped_range(..).map_err(|error| lost(&error))?;
    let rows = bytes.chunks_exact(row as usize);
    Ok(rows.flat_map(|row| &row[..width as usize * 4]).copied().collect())
}

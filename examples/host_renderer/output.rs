//! Read-back from the device, and pictures.
use crate::{Result, raster::SIZE};
use gobo::wgpu;
use std::path::Path;

/// Contents of a buffer, after all commands submitted before. Blocks.
pub(crate) fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<u8>> {
    let (send, received) = std::sync::mpsc::channel();
    wgpu::util::DownloadBuffer::read_buffer(device, queue, &buffer.slice(..), move |bytes| {
        // The receiver waits below.
        let _ = send.send(bytes.map(|bytes| bytes.to_vec()));
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(received.recv()??)
}

/// The picture, four bytes per pixel. Blocks.
pub(crate) fn read_picture(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    picture: &wgpu::Texture,
) -> Result<Vec<u8>> {
    let row = SIZE[0] * 4;
    assert!(row.is_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT));
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * SIZE[1]),
        usage: wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None };
    encoder.copy_texture_to_buffer(
        picture.as_image_copy(),
        wgpu::TexelCopyBufferInfo { buffer: &buffer, layout },
        picture.size(),
    );
    queue.submit([encoder.finish()]);
    read(device, queue, &buffer)
}

/// Saves a picture as `out/host_renderer/frame_20.png`.
pub(crate) fn save(number: u32, picture: &[u8]) -> Result<()> {
    let folder = Path::new("out/host_renderer");
    std::fs::create_dir_all(folder)?;
    let path = folder.join(format!("frame_{number:02}.png"));
    image::save_buffer(&path, picture, SIZE[0], SIZE[1], image::ExtendedColorType::Rgba8)?;
    println!("{}", path.display());
    Ok(())
}

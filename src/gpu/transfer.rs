//! Transfers of buffers and textures to the device and back. Reading blocks: for tests, benches and the
//! CLI, never for a frame.
use super::Gpu;
use crate::error::Error;

/// A buffer with contents. A device without memory for it reports that as for every other buffer;
/// `wgpu::util` would panic.
pub(crate) fn filled<T: bytemuck::NoUninit>(
    device: &wgpu::Device,
    label: &str,
    data: &[T],
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let bytes: &[u8] = bytemuck::cast_slice(data);
    let size = (bytes.len() as u64).next_multiple_of(wgpu::COPY_BUFFER_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size.max(wgpu::COPY_BUFFER_ALIGNMENT),
        usage: usage | wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: true,
    });
    if let Ok(mut mapped) = buffer.get_mapped_range_mut(..) {
        mapped.slice(..bytes.len()).copy_from_slice(bytes);
        drop(mapped);
        buffer.unmap();
    }
    buffer
}

impl Gpu {
    /// A buffer of `elements`.
    pub fn upload<T: bytemuck::NoUninit>(
        &self,
        label: &str,
        data: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        filled(&self.device, label, data, usage)
    }

    /// An array of `len` elements (at least one: WebGPU has no empty bindings).
    pub fn storage<T>(&self, label: &str, len: usize) -> wgpu::Buffer {
        use wgpu::BufferUsages as Use;
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: (len.max(1) * size_of::<T>()) as u64,
            usage: Use::STORAGE | Use::COPY_SRC | Use::COPY_DST,
            mapped_at_creation: false,
        })
    }

    /// A 2D texture that kernels read and write, and that the CPU fills and reads back.
    pub fn texture(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        self.texture_array(label, [width, height, 1], format)
    }

    /// Like [`Self::texture`], with layers.
    pub fn texture_array(
        &self,
        label: &str,
        [width, height, layers]: [u32; 3],
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        use wgpu::TextureUsages as Use;
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: Use::STORAGE_BINDING | Use::TEXTURE_BINDING | Use::COPY_SRC | Use::COPY_DST,
            view_formats: &[],
        })
    }

    /// Fills the texture with `texels`, row by row, all layers.
    pub fn write_texture<T: bytemuck::NoUninit>(&self, texture: &wgpu::Texture, texels: &[T]) {
        let size = texture.size();
        self.queue.write_texture(
            texture.as_image_copy(),
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(size.width * texel_size(texture)),
                rows_per_image: Some(size.height),
            },
            size,
        );
    }

    /// [`Self::try_read`] for tests, where a failing device is a failing test.
    pub fn read<T: bytemuck::AnyBitPattern>(&self, buffer: &wgpu::Buffer) -> Vec<T> {
        self.try_read(buffer).unwrap_or_else(|error| panic!("{error}"))
    }

    /// [`Self::try_read_texture`] for tests, where a failing device is a failing test.
    pub fn read_texture<T: bytemuck::AnyBitPattern>(&self, texture: &wgpu::Texture) -> Vec<T> {
        self.try_read_texture(texture).unwrap_or_else(|error| panic!("{error}"))
    }

    /// The whole buffer, after all commands submitted before.
    pub fn try_read<T: bytemuck::AnyBitPattern>(
        &self,
        buffer: &wgpu::Buffer,
    ) -> Result<Vec<T>, Error> {
        phase!("read_back");
        let bytes = self.read_back(buffer.size(), |encoder, to| {
            encoder.copy_buffer_to_buffer(buffer, 0, to, 0, buffer.size());
        })?;
        Ok(bytemuck::cast_slice(&bytes).to_vec())
    }

    /// Every texel, row by row, all layers, after all commands submitted before.
    pub fn try_read_texture<T: bytemuck::AnyBitPattern>(
        &self,
        texture: &wgpu::Texture,
    ) -> Result<Vec<T>, Error> {
        phase!("read_back");
        let size = texture.size();
        let rows = u64::from(size.height) * u64::from(size.depth_or_array_layers);
        let bytes = rows as usize * (size.width * texel_size(texture)) as usize;
        let mut texels = Vec::with_capacity(bytes / size_of::<T>().max(1));
        self.read_rows(texture, |row| texels.extend_from_slice(row))?;
        Ok(texels)
    }

    /// Calls back with every row of texels in turn, all layers, after all commands submitted before.
    pub fn read_rows<T: bytemuck::AnyBitPattern>(
        &self,
        texture: &wgpu::Texture,
        mut take: impl FnMut(&[T]),
    ) -> Result<(), Error> {
        // A texture may exceed the largest buffer, and the remaining memory.
        const MOST: u64 = 64 << 20;
        let size = texture.size();
        let most = self.device.limits().max_buffer_size.min(MOST);
        for (origin, part) in parts(size, most / padded_row(texture, size.width)) {
            self.read_part(texture, origin, part, |rows| rows.iter().for_each(|row| take(row)))?;
        }
        Ok(())
    }

    /// Gives the rows of texels of a part of a texture, at most as large as a buffer, layer by layer, after
    /// all commands submitted before.
    fn read_part<T: bytemuck::AnyBitPattern, R>(
        &self,
        texture: &wgpu::Texture,
        origin: wgpu::Origin3d,
        part: wgpu::Extent3d,
        take: impl FnOnce(&[&[T]]) -> R,
    ) -> Result<R, Error> {
        self.read_parts(texture, &[origin], part, take)
    }

    /// Gives the rows of texels of parts of a texture of the same size, together at most as large as a
    /// buffer, one part after the other, layer by layer, after all commands submitted before.
    pub fn read_parts<T: bytemuck::AnyBitPattern, R>(
        &self,
        texture: &wgpu::Texture,
        origins: &[wgpu::Origin3d],
        part: wgpu::Extent3d,
        take: impl FnOnce(&[&[T]]) -> R,
    ) -> Result<R, Error> {
        if origins.is_empty() {
            return Ok(take(&[]));
        }
        let row = part.width as usize * texel_size(texture) as usize;
        let padded = padded_row(texture, part.width);
        let rows = u64::from(part.height) * u64::from(part.depth_or_array_layers);
        let all = rows * padded * origins.len() as u64;
        let bytes = self.read_back(all, |encoder, buffer| {
            for (i, &origin) in (0..).zip(origins) {
                let layout = wgpu::TexelCopyBufferLayout {
                    offset: i * rows * padded,
                    bytes_per_row: Some(padded as u32),
                    rows_per_image: Some(part.height),
                };
                let from = wgpu::TexelCopyTextureInfo { origin, ..texture.as_image_copy() };
                let to = wgpu::TexelCopyBufferInfo { buffer, layout };
                encoder.copy_texture_to_buffer(from, to, part);
            }
        })?;
        let lines = bytes.chunks_exact(padded as usize);
        let rows: Vec<_> = lines.map(|line| bytemuck::cast_slice(&line[..row])).collect();
        Ok(take(&rows))
    }

    fn read_back(
        &self,
        size: u64,
        copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
    ) -> Result<wgpu::BufferView, Error> {
        let bytes = read_back(&self.device, &self.queue, size, copy);
        self.check()?;
        bytes
    }
}

/// A buffer for copies that the CPU reads.
pub(crate) fn staging(device: &wgpu::Device, label: &'static str, size: u64) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size,
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}

/// The bytes that `copy` copies to a buffer of a size \[bytes\], after all commands submitted before. Blocks.
pub(crate) fn read_back(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    size: u64,
    copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer),
) -> Result<wgpu::BufferView, Error> {
    phase!("read_back");
    let staging = staging(device, "readback", size);
    let mut encoder = device.create_command_encoder(&Default::default());
    copy(&mut encoder, &staging);
    let submission = queue.submit([encoder.finish()]);
    // get_mapped_range returns the outcome.
    staging.map_async(wgpu::MapMode::Read, .., |_| ());
    let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
    device.poll(wait).map_err(|error| Error::Lost(error.to_string()))?;
    staging.get_mapped_range(..).map_err(|error| Error::Lost(error.to_string()))
}

/// Parts of a texture of at most `most` rows, in order: whole layers, or rows of one layer.
fn parts(size: wgpu::Extent3d, most: u64) -> Vec<(wgpu::Origin3d, wgpu::Extent3d)> {
    let most = u32::try_from(most.max(1)).unwrap_or(u32::MAX);
    let height = size.height.clamp(1, most);
    let layers = if height == size.height { most / height } else { 1 };
    let mut parts = Vec::new();
    for z in (0..size.depth_or_array_layers).step_by(layers as usize) {
        let depth_or_array_layers = layers.min(size.depth_or_array_layers - z);
        for y in (0..size.height).step_by(height as usize) {
            let height = height.min(size.height - y);
            let part = wgpu::Extent3d { height, depth_or_array_layers, ..size };
            parts.push((wgpu::Origin3d { x: 0, y, z }, part));
        }
    }
    parts
}

/// Size of a row of `width` texels in a buffer \[bytes\].
fn padded_row(texture: &wgpu::Texture, width: u32) -> u64 {
    u64::from(width * texel_size(texture))
        .next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT.into())
}

/// Size of a texel \[bytes\].
fn texel_size(texture: &wgpu::Texture) -> u32 {
    texture.format().block_copy_size(None).expect("a colour format")
}

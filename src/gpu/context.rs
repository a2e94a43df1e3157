//! A device for tests, benches and the CLI. Hosts with a renderer pass their own.
use crate::error::Error;
use wgpu::util::DeviceExt as _;

#[derive(Debug)]
pub struct Gpu {
    pub device: wgpu::Device,
    pub queue: wgpu::Queue,
    pub adapter: wgpu::AdapterInfo,
}

impl Gpu {
    /// Any adapter, with WebGPU's own limits and features.
    pub fn headless() -> Result<Self, Error> {
        let instance =
            wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = pollster::block_on(instance.request_adapter(&Default::default()))
            .map_err(|_| Error::Adapter { wanted: None, found: Vec::new() })?;
        let info = adapter.get_info();
        let (device, queue) = pollster::block_on(adapter.request_device(&Default::default()))
            .map_err(|source| Error::Device { adapter: info.name.clone(), source })?;
        Ok(Self { device, queue, adapter: info })
    }

    pub fn upload<T: bytemuck::NoUninit>(
        &self,
        label: &str,
        data: &[T],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        self.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(label),
            contents: bytemuck::cast_slice(data),
            usage,
        })
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

    /// A 2d texture that kernels read and write and the CPU fills and reads back.
    pub fn texture(
        &self,
        label: &str,
        [width, height]: [u32; 2],
        format: wgpu::TextureFormat,
    ) -> wgpu::Texture {
        use wgpu::TextureUsages as Use;
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: Use::STORAGE_BINDING | Use::TEXTURE_BINDING | Use::COPY_SRC | Use::COPY_DST,
            view_formats: &[],
        })
    }

    /// `texels` fill the texture row by row, all layers.
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

    /// Blocks. For tests, benches and the CLI, never for a frame.
    pub fn read<T: bytemuck::AnyBitPattern>(&self, buffer: &wgpu::Buffer) -> Vec<T> {
        let staging = self.staging(buffer.size());
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, buffer.size());
        let bytes = self.submit_and_map(encoder, &staging);
        bytemuck::cast_slice(&bytes).to_vec()
    }

    /// Every texel, row by row, all layers. Blocks, as [`Self::read`] does.
    pub fn read_texture<T: bytemuck::AnyBitPattern>(&self, texture: &wgpu::Texture) -> Vec<T> {
        let size = texture.size();
        let row = size.width * texel_size(texture);
        let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let rows = u64::from(size.height) * u64::from(size.depth_or_array_layers);
        let staging = self.staging(rows * u64::from(padded));
        let mut encoder = self.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            texture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &staging,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(padded),
                    rows_per_image: Some(size.height),
                },
            },
            size,
        );
        self.submit_and_map(encoder, &staging)
            .chunks_exact(padded as usize)
            .flat_map(|texels| bytemuck::cast_slice(&texels[..row as usize]).to_vec())
            .collect()
    }

    fn staging(&self, size: u64) -> wgpu::Buffer {
        self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size,
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }

    fn submit_and_map(
        &self,
        encoder: wgpu::CommandEncoder,
        staging: &wgpu::Buffer,
    ) -> wgpu::BufferView {
        let submission = self.queue.submit([encoder.finish()]);
        staging.slice(..).map_async(wgpu::MapMode::Read, |mapped| mapped.expect("staging maps"));
        self.device
            .poll(wgpu::PollType::Wait { submission_index: Some(submission), timeout: None })
            .expect("the device answers");
        staging.get_mapped_range(..).expect("staging is mapped")
    }
}

/// [bytes]
fn texel_size(texture: &wgpu::Texture) -> u32 {
    texture.format().block_copy_size(None).expect("a colour format")
}

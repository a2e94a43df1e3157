//! Allocation of buffers and textures, each counted by name and checked against the device's limits.
use super::{RecordForm, Resource, Shelf, transfer::filled};
use crate::{error::Error, records::ROW};
use glam::UVec3;
use std::sync::Arc;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// Bytes by buffer or texture name, in order of allocation.
#[derive(Clone, Debug, Default)]
pub struct Memory(pub Vec<(&'static str, u64)>);

impl Memory {
    /// Adds bytes to those of a name.
    pub fn add(&mut self, name: &'static str, bytes: u64) {
        match self.0.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += bytes,
            None => self.0.push((name, bytes)),
        }
    }

    /// Adds all of `other`.
    pub fn add_all(&mut self, other: &Self) {
        other.0.iter().for_each(|&(name, bytes)| self.add(name, bytes));
    }

    /// Sum over all names \[bytes\].
    pub fn total(&self) -> u64 {
        self.0.iter().map(|(_, bytes)| bytes).sum()
    }
}

/// An earlier frame's object if it `suffices` and nothing else holds it, or else a new one.
pub fn reused<T, E>(
    former: &mut Option<Arc<T>>,
    suffices: impl Fn(&T) -> bool,
    new: impl FnOnce() -> Result<T, E>,
) -> Result<Arc<T>, E> {
    let unshared = former.take().filter(|former| Arc::strong_count(former) == 1);
    let kept = unshared.filter(|former| suffices(former));
    let taken = kept.map_or_else(|| new().map(Arc::new), Ok)?;
    Ok(Arc::clone(former.insert(taken)))
}

/// Allocates for `prepare`; never for `record`.
#[derive(Debug)]
pub struct Allocator<'a> {
    /// The device.
    pub device: &'a wgpu::Device,
    /// Allocated bytes, by name.
    pub memory: &'a mut Memory,
    /// Objects of the last frame, for objects that last one frame.
    pub shelf: Option<&'a Shelf>,
}

impl<'a> Allocator<'a> {
    /// An allocator for objects that last longer than a frame.
    pub fn new(device: &'a wgpu::Device, memory: &'a mut Memory) -> Self {
        Self { device, memory, shelf: None }
    }

    /// An array of `len` elements (at least one: WebGPU has no empty bindings).
    pub fn storage<T>(
        &mut self,
        name: &'static str,
        len: u64,
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, Error> {
        let size = len.max(1) * size_of::<T>() as u64;
        let limits = self.device.limits();
        check("max_storage_buffer_binding_size", limits.max_storage_buffer_binding_size, size)?;
        Ok(self.buffer(name, size, usage | BufferUsages::STORAGE | BufferUsages::COPY_DST))
    }

    /// A buffer with contents.
    pub fn filled<T: bytemuck::NoUninit>(
        &mut self,
        name: &'static str,
        data: &[T],
        usage: BufferUsages,
    ) -> wgpu::Buffer {
        self.memory.add(name, size_of_val(data) as u64);
        match self.shelf {
            Some(shelf) => shelf.filled(self.device, name, data, usage),
            None => filled(self.device, name, data, usage),
        }
    }

    /// A uniform buffer with contents.
    pub fn uniform<T: bytemuck::NoUninit>(
        &mut self,
        name: &'static str,
        value: &T,
    ) -> wgpu::Buffer {
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        self.filled(name, std::slice::from_ref(value), usage)
    }

    /// A uniform buffer that holds one `T`, written before each frame that changes it.
    pub fn rewritten_uniform<T>(&mut self, name: &'static str) -> wgpu::Buffer {
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        self.buffer(name, size_of::<T>() as u64, usage)
    }

    fn buffer(&mut self, name: &'static str, size: u64, usage: BufferUsages) -> wgpu::Buffer {
        self.memory.add(name, size);
        let desc = wgpu::BufferDescriptor {
            label: Some(name),
            size,
            // The export of a frame reads every resource.
            usage: usage | BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        };
        match self.shelf {
            Some(shelf) => shelf.buffer(self.device, &desc),
            None => self.device.create_buffer(&desc),
        }
    }

    /// A texture of records, [`ROW`] texels wide.
    pub fn records(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        texels: u64,
        usage: TextureUsages,
    ) -> Result<wgpu::Texture, Error> {
        let rows = texels.div_ceil(u64::from(ROW)).max(1);
        // Never a power of two: llvmpipe recompiles a kernel, for seconds, where the height of a bound
        // texture changes between powers of two and other numbers.
        let most = u64::from(self.device.limits().max_texture_dimension_2d);
        let rows = (rows..=most).find(|rows| !rows.is_power_of_two()).unwrap_or(rows);
        self.texture(name, format, [u64::from(ROW), rows, 1], usage)
    }

    /// Records of a kernel, in a buffer of `T` or in a texture of `format`.
    pub fn written<T>(
        &mut self,
        form: RecordForm,
        name: &'static str,
        format: TextureFormat,
        count: u64,
    ) -> Result<Resource, Error> {
        match form {
            RecordForm::Buffers => {
                Ok((&self.storage::<T>(name, count, BufferUsages::empty())?).into())
            }
            RecordForm::Textures => {
                let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
                let texels = count * (size_of::<T>() as u64 / texel);
                let usage = TextureUsages::STORAGE_BINDING;
                Ok((&view(&self.records(name, format, texels, usage)?)).into())
            }
        }
    }

    /// A texture array of width, height and layers \[texels\].
    pub fn texture(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        size: [u64; 3],
        usage: TextureUsages,
    ) -> Result<wgpu::Texture, Error> {
        self.texture_with_levels(name, format, size, 1, usage)
    }

    /// A volume texture of width, height and depth \[texels\].
    pub fn volume(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        size: UVec3,
    ) -> Result<wgpu::Texture, Error> {
        let edge = u64::from(self.device.limits().max_texture_dimension_3d);
        check("max_texture_dimension_3d", edge, u64::from(size.max_element()))?;
        let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
        let texels = size.to_array().map(u64::from).iter().product::<u64>();
        self.memory.add(name, texels * texel);
        let usage = TextureUsages::TEXTURE_BINDING
            | TextureUsages::STORAGE_BINDING
            | TextureUsages::COPY_DST
            | TextureUsages::COPY_SRC;
        Ok(self.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d { width: size.x, height: size.y, depth_or_array_layers: size.z },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format,
            usage,
            view_formats: &[],
        }))
    }

    /// As [`Self::texture`], with `levels`, each half the size of the one before.
    pub fn texture_with_levels(
        &mut self,
        name: &'static str,
        format: TextureFormat,
        [width, height, layers]: [u64; 3],
        levels: u32,
        usage: TextureUsages,
    ) -> Result<wgpu::Texture, Error> {
        let limits = self.device.limits();
        let edge = u64::from(limits.max_texture_dimension_2d);
        check("max_texture_dimension_2d", edge, width.max(height))?;
        check("max_texture_array_layers", u64::from(limits.max_texture_array_layers), layers)?;
        let texel = u64::from(format.block_copy_size(None).unwrap_or(4));
        let texels = (0..levels).map(|level| (width >> level).max(1) * (height >> level).max(1));
        self.memory.add(name, texels.sum::<u64>() * layers * texel);
        let desc = wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d {
                width: width as u32,
                height: height as u32,
                depth_or_array_layers: layers as u32,
            },
            mip_level_count: levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_SRC,
            view_formats: &[],
        };
        Ok(match self.shelf {
            Some(shelf) => shelf.texture(self.device, &desc),
            None => self.device.create_texture(&desc),
        })
    }
}

fn check(limit: &'static str, have: u64, need: u64) -> Result<(), Error> {
    let remedy = "use fewer casters, views or pairs, smaller maps or another adapter";
    Error::check_limit(limit, have, need, remedy)
}

/// Writes `bytes` from the first texel on, and pads their last row with zeros.
pub fn write_records(queue: &wgpu::Queue, texture: &wgpu::Texture, mut bytes: Vec<u8>) {
    let texel = texture.format().block_copy_size(None).unwrap_or(4);
    let row = ROW * texel;
    let rows = (bytes.len() as u32).div_ceil(row).min(texture.height());
    bytes.resize((rows * row) as usize, 0);
    queue.write_texture(
        texture.as_image_copy(),
        &bytes,
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row), rows_per_image: None },
        wgpu::Extent3d { height: rows, ..texture.size() },
    );
}

/// View of the whole texture, in the form that kernels bind.
pub fn view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// View of a level of the whole texture.
pub fn level_view(
    texture: &wgpu::Texture,
    level: u32,
    dimension: wgpu::TextureViewDimension,
) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(dimension),
        base_mip_level: level,
        mip_level_count: Some(1),
        ..Default::default()
    })
}

/// View of all layers as an array, even of a single layer.
pub fn array_view(texture: &wgpu::Texture) -> wgpu::TextureView {
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

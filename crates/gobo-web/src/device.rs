//! Buffers within the device's limits.
use bytemuck::Pod;
use gobo::wgpu::{self, BufferUsages, util::DeviceExt as _};

/// Error of a scene that this device cannot show.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the {what} take {} MiB, and a buffer of this browser's device holds {} MiB: show a smaller file, \
     or render it with the \
     program", bytes >> 20, most >> 20
)]
pub struct TooLarge {
    what: &'static str,
    bytes: u64,
    most: u64,
}

/// Makes buffers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Buffers<'a>(pub(crate) &'a wgpu::Device);

impl Buffers<'_> {
    /// Whether a buffer of `bytes` can be bound.
    pub(crate) fn check(&self, what: &'static str, bytes: u64) -> Result<(), TooLarge> {
        let limits = self.0.limits();
        let most = limits.max_buffer_size.min(limits.max_storage_buffer_binding_size);
        if bytes > most { Err(TooLarge { what, bytes, most }) } else { Ok(()) }
    }

    fn of<T: Pod>(
        &self,
        what: &'static str,
        values: &[T],
        usage: BufferUsages,
    ) -> Result<wgpu::Buffer, TooLarge> {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        self.check(what, bytes.len() as u64)?;
        // A binding is never empty.
        let none = vec![0; size_of::<T>().next_multiple_of(16)];
        Ok(self.0.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(what),
            contents: if bytes.is_empty() { &none } else { bytes },
            usage: usage | BufferUsages::COPY_DST,
        }))
    }

    pub(crate) fn storage<T: Pod>(
        &self,
        what: &'static str,
        values: &[T],
    ) -> Result<wgpu::Buffer, TooLarge> {
        self.of(what, values, BufferUsages::STORAGE)
    }

    pub(crate) fn vertices<T: Pod>(
        &self,
        what: &'static str,
        values: &[T],
    ) -> Result<wgpu::Buffer, TooLarge> {
        self.of(what, values, BufferUsages::VERTEX)
    }

    pub(crate) fn uniform(&self, what: &'static str, size: usize) -> wgpu::Buffer {
        self.0.create_buffer(&wgpu::BufferDescriptor {
            label: Some(what),
            size: size as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        })
    }
}

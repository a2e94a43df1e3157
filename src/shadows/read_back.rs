//! What kernels count, and how the CPU learns of it.
use crate::{error::Error, gpu::Allocator};
use std::marker::PhantomData;
use wgpu::{Buffer, BufferUsages};

/// Counters on the device, and room to read them into.
#[derive(Debug)]
pub(crate) struct ReadBack<T> {
    buffer: Buffer,
    readback: Buffer,
    counters: PhantomData<T>,
}

impl<T: bytemuck::Pod> ReadBack<T> {
    pub(crate) fn new(allocator: &mut Allocator<'_>, name: &'static str) -> Result<Self, Error> {
        let readback = allocator.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("counters_readback"),
            size: size_of::<T>() as u64,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let buffer = allocator.storage::<T>(name, 1, BufferUsages::COPY_SRC)?;
        Ok(Self { buffer, readback, counters: PhantomData })
    }

    pub(crate) fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// After all that was submitted before. Waits.
    pub(crate) fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<T, Error> {
        let Self { buffer, readback, .. } = self;
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.copy_buffer_to_buffer(buffer, 0, readback, 0, readback.size());
        queue.submit([encoder.finish()]);
        readback.slice(..).map_async(wgpu::MapMode::Read, |_| ());
        let lost = |error: &dyn std::fmt::Display| Error::Lost(error.to_string());
        device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| lost(&e))?;
        let bytes = readback.slice(..).get_mapped_range().map_err(|e| lost(&e))?;
        let counters = bytemuck::pod_read_unaligned(&bytes);
        drop(bytes);
        readback.unmap();
        Ok(counters)
    }
}

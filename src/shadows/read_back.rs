//! Read-back of the counters of kernels.
use crate::{error::Error, gpu::Allocator};
use std::{
    marker::PhantomData,
    sync::{
        Arc,
        atomic::{AtomicU8, Ordering::SeqCst},
    },
};
use wgpu::{Buffer, BufferUsages};

/// Counters on the device, and a buffer to read them into.
#[derive(Debug)]
pub(crate) struct ReadBack<T> {
    buffer: Buffer,
    readback: Buffer,
    /// State of `readback`: [`IDLE`] and so on.
    state: Arc<AtomicU8>,
    counters: PhantomData<T>,
}

const IDLE: u8 = 0;
/// A recording copies counters into it.
const COPIED: u8 = 1;
const MAPPING: u8 = 2;
const MAPPED: u8 = 3;
const FAILED: u8 = 4;

impl<T: bytemuck::Pod> ReadBack<T> {
    pub(crate) fn new(allocator: &mut Allocator<'_>, name: &'static str) -> Result<Self, Error> {
        let readback = allocator.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("counters_readback"),
            size: size_of::<T>() as u64,
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let buffer = allocator.storage::<T>(name, 1, BufferUsages::COPY_SRC)?;
        Ok(Self { buffer, readback, state: Arc::new(AtomicU8::new(IDLE)), counters: PhantomData })
    }

    pub(crate) fn buffer(&self) -> &Buffer {
        &self.buffer
    }

    /// Records the copy, for [`Self::is_ready`] after the submission. Does nothing while an earlier copy
    /// has not been taken.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        if self.state.compare_exchange(IDLE, COPIED, SeqCst, SeqCst).is_ok() {
            let Self { buffer, readback, .. } = self;
            encoder.copy_buffer_to_buffer(buffer, 0, readback, 0, readback.size());
        }
    }

    /// Whether [`Self::take`] has the counters recorded last. Does not wait; call it after the submission.
    pub(crate) fn is_ready(&self) -> bool {
        if self.state.compare_exchange(COPIED, MAPPING, SeqCst, SeqCst).is_ok() {
            let state = Arc::clone(&self.state);
            self.readback.map_async(wgpu::MapMode::Read, .., move |result| {
                state.store(if result.is_ok() { MAPPED } else { FAILED }, SeqCst);
            });
        }
        matches!(self.state.load(SeqCst), MAPPED | FAILED)
    }

    /// The counters, once [`Self::is_ready`].
    pub(crate) fn take(&self) -> Result<T, Error> {
        if self.state.swap(IDLE, SeqCst) != MAPPED {
            return Err(Error::Lost("its counters cannot be read".to_owned()));
        }
        let lost = |error: wgpu::MapRangeError| Error::Lost(error.to_string());
        let bytes = self.readback.get_mapped_range(..).map_err(lost)?;
        let counters = bytemuck::pod_read_unaligned(&bytes);
        drop(bytes);
        self.readback.unmap();
        Ok(counters)
    }

    /// The counters after all commands submitted before. Blocks.
    pub(crate) fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<T, Error> {
        // A copy recorded for `take` comes first.
        if self.is_ready() || self.state.load(SeqCst) == MAPPING {
            self.wait(device)?;
            self.take()?;
        }
        let mut encoder = device.create_command_encoder(&Default::default());
        self.record(&mut encoder);
        queue.submit([encoder.finish()]);
        self.is_ready();
        self.wait(device)?;
        self.take()
    }

    fn wait(&self, device: &wgpu::Device) -> Result<(), Error> {
        loop {
            let done = device.poll(wgpu::PollType::wait_indefinitely());
            done.map_err(|error| Error::Lost(error.to_string()))?;
            if self.state.load(SeqCst) != MAPPING {
                return Ok(());
            }
            // Another waiting thread has the result, and is about to run the callback.
            std::thread::yield_now();
        }
    }
}

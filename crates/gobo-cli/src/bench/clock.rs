//! Time of one frame [ms]: by GPU timestamps, or by the wall clock where these are meaningless.
use crate::failure::Failure;
use gobo::{
    Error,
    gpu::{Gpu, has_timestamps},
    wgpu,
};
use std::time::Instant;

pub(super) struct Clock {
    stamps: Option<Stamps>,
}

struct Stamps {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
}

impl Clock {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let features =
            wgpu::Features::TIMESTAMP_QUERY | wgpu::Features::TIMESTAMP_QUERY_INSIDE_ENCODERS;
        let has = gpu.has(features) && has_timestamps(gpu);
        let stamps = has.then(|| Stamps {
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("frame"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("frame_ticks"),
                size: 16,
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
        });
        Self { stamps }
    }

    pub(super) fn has_stamps(&self) -> bool {
        self.stamps.is_some()
    }

    pub(super) fn name(&self) -> &'static str {
        if self.has_stamps() { "timestamps" } else { "wall" }
    }

    /// Time of the commands that `record` records. Recording itself is not timed: a host does it while the
    /// GPU is busy with the previous frame.
    pub(super) fn time(
        &self,
        gpu: &Gpu,
        record: impl FnOnce(&mut wgpu::CommandEncoder),
    ) -> Result<f64, Failure> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        if let Some(stamps) = &self.stamps {
            encoder.write_timestamp(&stamps.set, 0);
        }
        record(&mut encoder);
        if let Some(stamps) = &self.stamps {
            encoder.write_timestamp(&stamps.set, 1);
            encoder.resolve_query_set(&stamps.set, 0..2, &stamps.resolved, 0);
        }
        let commands = encoder.finish();
        let _kernels = tracing::debug_span!("kernels").entered();
        let started = Instant::now();
        gpu.queue.submit([commands]);
        gpu.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| Error::Lost(error.to_string()))?;
        let wall = started.elapsed().as_secs_f64() * 1e3;
        gpu.check()?;
        let Some(stamps) = &self.stamps else { return Ok(wall) };
        let ticks: Vec<u64> = gpu.try_read(&stamps.resolved)?;
        let period = f64::from(gpu.queue.get_timestamp_period());
        Ok(ticks[1].saturating_sub(ticks[0]) as f64 * period * 1e-6)
    }
}

/// Median, least and largest [ms].
#[derive(Clone, Copy, Debug)]
pub(super) struct Times {
    pub(super) median: f64,
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Times {
    pub(super) fn new(mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        let middle = times.len() / 2;
        let median = if times.len() % 2 == 1 {
            times[middle]
        } else {
            (times[middle - 1] + times[middle]) * 0.5
        };
        Self { median, min: times[0], max: times[times.len() - 1] }
    }
}

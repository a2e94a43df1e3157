//! Submits commands and waits for them, so that each stage has a time.
use gobo::gpu::{Gpu, Timeline, add_time, has_timestamps};

/// Stages and their times \[ms\], in order of first appearance.
pub(super) type Stages = Vec<(&'static str, f64)>;

/// Work that is submitted to a device, and the times of its stages.
#[derive(Debug)]
pub(super) struct Work {
    timeline: Timeline,
    stages: Stages,
}

impl Work {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let timeline = if has_timestamps(gpu) {
            Timeline::new(&gpu.device, &gpu.queue).split(&gpu.device, &gpu.queue)
        } else {
            Timeline::stepped(&gpu.device, &gpu.queue)
        };
        Self { timeline, stages: Vec::new() }
    }

    /// Submits what `record` records, and waits until it is done.
    pub(super) fn submit<T>(
        &mut self,
        gpu: &Gpu,
        record: impl FnOnce(&mut wgpu::CommandEncoder, &mut Timeline) -> T,
    ) -> T {
        self.timeline.reset();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let recorded = record(&mut encoder, &mut self.timeline);
        self.timeline.finish(&mut encoder);
        let commands = encoder.finish();
        let _phase = tracing::debug_span!("kernels").entered();
        gpu.queue.submit([commands]);
        // `Gpu::check` tells of a lost device.
        let _ = gpu.device.poll(wgpu::PollType::wait_indefinitely());
        for (stage, ms) in self.timeline.read(&gpu.device) {
            add_time(&mut self.stages, stage, ms);
        }
        recorded
    }

    /// Stages and their times since the last call.
    pub(super) fn take(&mut self) -> Stages {
        std::mem::take(&mut self.stages)
    }
}

/// Adds the times of further stages.
pub(super) fn add_all(sum: &mut Stages, more: Stages) {
    more.into_iter().for_each(|(stage, ms)| add_time(sum, stage, ms));
}

//! Milliseconds per stage or kernel, by GPU timestamps or by the wall clock.
use super::Gpu;
use std::time::Instant;

/// Timestamps that one frame may write: the most of a query set in WebGPU.
const MAX_STAMPS: u32 = 4096;

/// A host's own timer of compute passes, for [`Timeline::profiled`].
pub trait Profiler: std::fmt::Debug + Send {
    /// Called before a pass: `label` is `gobo sort` and the like. The pass writes the timestamps.
    fn begin(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        label: &'static str,
    ) -> Option<wgpu::ComputePassTimestampWrites<'_>>;

    /// Called after the pass, before the next begins.
    fn end(&mut self, encoder: &mut wgpu::CommandEncoder);
}

/// Begins one compute pass per stage, with timestamps at its begin and end.
#[derive(Debug)]
pub struct Timeline {
    timer: Timer,
    passes: Vec<Timed>,
    by_kernel: bool,
    /// Where passes are submitted one by one.
    split: Option<(wgpu::Device, wgpu::Queue)>,
    /// Passes for which there are no timestamps left.
    untimed: u32,
}

/// Subject of a time: a label, and a kernel where each dispatch is timed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Timed {
    label: &'static str,
    kernel: Option<&'static str>,
}

impl Timed {
    fn stage(&self) -> &'static str {
        self.label.strip_prefix(PREFIX).unwrap_or(self.label)
    }
}

/// Time of a kernel in a stage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KernelTime {
    /// Label of its passes, without `gobo`.
    pub stage: &'static str,
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Dispatches in the frame.
    pub dispatches: u32,
    /// Sum over its dispatches \[ms\].
    pub ms: f64,
}

/// Source of the times.
#[derive(Debug)]
enum Timer {
    None,
    Queries(Box<Queries>),
    Steps(Box<Steps>),
    /// The host's profiler, and whether it has begun a pass.
    Host(Box<dyn Profiler>, bool),
}

/// Whether a device's timestamps mark the end of work. A software adapter takes them when it reads commands,
/// and some drivers write 0. Blocks for an empty pass.
pub fn has_timestamps(gpu: &Gpu) -> bool {
    if gpu.adapter.device_type == wgpu::DeviceType::Cpu {
        return false;
    }
    let mut timeline = Timeline::new(&gpu.device, &gpu.queue);
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    drop(timeline.pass(&mut encoder, "gobo timestamps"));
    timeline.finish(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    timeline.ticks(&gpu.device).is_some_and(|ticks| are_written(&ticks))
}

fn are_written(ticks: &[u64]) -> bool {
    ticks.iter().any(|&tick| tick != 0)
}

/// Prefix of all labels.
const PREFIX: &str = "gobo ";

/// One submission per stage, timed by the wall clock.
#[derive(Debug)]
struct Steps {
    device: wgpu::Device,
    queue: wgpu::Queue,
    times: Vec<(Timed, f64)>,
    open: Option<Timed>,
}

impl Steps {
    /// Submits the commands recorded so far and waits.
    fn run(&mut self, encoder: &mut wgpu::CommandEncoder) {
        // Before the first stage these are uploads.
        let open = self.open.take();
        let commands = recorded(&self.device, encoder);
        let work = || {
            self.queue.submit([commands]);
            // A lost device is the host's to notice.
            let _ = self.device.poll(wgpu::PollType::wait_indefinitely());
        };
        let Some(timed) = open else { return work() };
        phase!("kernels");
        let started = Instant::now();
        work();
        self.times.push((timed, started.elapsed().as_secs_f64() * 1e3));
    }
}

/// The commands recorded so far; `encoder` begins anew.
fn recorded(device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder) -> wgpu::CommandBuffer {
    let empty = device.create_command_encoder(&Default::default());
    std::mem::replace(encoder, empty).finish()
}

/// Adds a time to the stage `label`, or appends the stage.
pub fn add_time(times: &mut Vec<(&'static str, f64)>, label: &'static str, ms: f64) {
    let stage = label.strip_prefix(PREFIX).unwrap_or(label);
    match times.iter_mut().find(|(known, _)| *known == stage) {
        Some((_, sum)) => *sum += ms,
        None => times.push((stage, ms)),
    }
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Length of one tick \[ns\].
    period: f32,
}

impl Timeline {
    /// A timeline by timestamps. Without `TIMESTAMP_QUERY` the stages run untimed.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let has = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = has.then(|| {
            let buffer = |label, usage| {
                device.create_buffer(&wgpu::BufferDescriptor {
                    label: Some(label),
                    size: u64::from(MAX_STAMPS) * 8,
                    usage,
                    mapped_at_creation: false,
                })
            };
            use wgpu::BufferUsages as Use;
            Queries {
                set: device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("stages"),
                    ty: wgpu::QueryType::Timestamp,
                    count: MAX_STAMPS,
                }),
                resolved: buffer("stage_ticks", Use::QUERY_RESOLVE | Use::COPY_SRC),
                readback: buffer("stage_ticks_readback", Use::MAP_READ | Use::COPY_DST),
                period: queue.get_timestamp_period(),
            }
        });
        Self::by(queries.map_or(Timer::None, |queries| Timer::Queries(Box::new(queries))))
    }

    /// A timeline that measures nothing.
    pub fn untimed() -> Self {
        Self::by(Timer::None)
    }

    /// A timeline measured by the host's profiler.
    pub fn profiled(profiler: impl Profiler + 'static) -> Self {
        Self::by(Timer::Host(Box::new(profiler), false))
    }

    fn by(timer: Timer) -> Self {
        Self { timer, passes: Vec::new(), by_kernel: false, split: None, untimed: 0 }
    }

    /// Gives each dispatch a pass, and so a time, of its own. An untimed timeline does not.
    pub fn by_kernel(mut self) -> Self {
        self.by_kernel = self.is_timed();
        self
    }

    /// Submits each pass by itself, without waiting, so that `record` does more than record: drivers reset a
    /// device whose submission runs for longer than some seconds.
    pub fn split(mut self, device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        self.split = Some((device.clone(), queue.clone()));
        self
    }

    /// Whether each dispatch has a pass of its own.
    pub(crate) fn is_by_kernel(&self) -> bool {
        self.by_kernel
    }

    /// Passes of the frame without a time, since it has more passes than timestamps.
    pub fn untimed_passes(&self) -> u32 {
        self.untimed
    }

    /// A timeline for adapters with meaningless timestamps, if frames may wait: it submits and waits between
    /// the stages, so that `record` does more than record.
    pub fn stepped(device: &wgpu::Device, queue: &wgpu::Queue) -> Self {
        let (device, queue) = (device.clone(), queue.clone());
        let steps = Steps { device, queue, times: Vec::new(), open: None };
        Self::by(Timer::Steps(Box::new(steps)))
    }

    /// Whether each pass has a time.
    pub fn is_timed(&self) -> bool {
        !matches!(self.timer, Timer::None)
    }

    /// Forgets the stages, before the next frame.
    pub fn reset(&mut self) {
        self.passes.clear();
        self.untimed = 0;
        if let Timer::Steps(steps) = &mut self.timer {
            steps.times.clear();
        }
    }

    /// Assigns commands recorded next, outside a pass, to `label`. Only a stepped timeline uses it.
    pub fn step(&mut self, encoder: &mut wgpu::CommandEncoder, label: &'static str) {
        self.step_of(encoder, Timed { label, kernel: None });
    }

    fn step_of(&mut self, encoder: &mut wgpu::CommandEncoder, timed: Timed) {
        self.end(encoder);
        if let Some((device, queue)) = &self.split {
            queue.submit([recorded(device, encoder)]);
        }
        if let Timer::Steps(steps) = &mut self.timer {
            steps.run(encoder);
            steps.open = Some(timed);
        }
    }

    /// Called after a pass.
    pub(crate) fn end(&mut self, encoder: &mut wgpu::CommandEncoder) {
        if let Timer::Host(profiler, open @ true) = &mut self.timer {
            *open = false;
            profiler.end(encoder);
        }
    }

    /// Begins a compute pass of the stage `label`, with timestamps if the timeline takes them.
    pub fn pass<'e>(
        &mut self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &'static str,
    ) -> wgpu::ComputePass<'e> {
        self.timed_pass(encoder, Timed { label, kernel: None })
    }

    /// Like [`Self::pass`], for a dispatch of `kernel` alone.
    pub(crate) fn kernel_pass<'e>(
        &mut self,
        encoder: &'e mut wgpu::CommandEncoder,
        label: &'static str,
        kernel: &'static str,
    ) -> wgpu::ComputePass<'e> {
        self.timed_pass(encoder, Timed { label, kernel: Some(kernel) })
    }

    fn timed_pass<'e>(
        &mut self,
        encoder: &'e mut wgpu::CommandEncoder,
        timed: Timed,
    ) -> wgpu::ComputePass<'e> {
        self.step_of(encoder, timed);
        let (label, first) = (timed.label, 2 * self.passes.len() as u32);
        let timestamp_writes = match &mut self.timer {
            Timer::Queries(queries) if first + 2 <= MAX_STAMPS => {
                self.passes.push(timed);
                Some(wgpu::ComputePassTimestampWrites {
                    query_set: &queries.set,
                    beginning_of_pass_write_index: Some(first),
                    end_of_pass_write_index: Some(first + 1),
                })
            }
            Timer::Host(profiler, open) => {
                *open = true;
                profiler.begin(encoder, label)
            }
            Timer::Queries(_) => {
                self.untimed += 1;
                None
            }
            Timer::None | Timer::Steps(_) => None,
        };
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some(label),
            timestamp_writes,
        })
    }

    /// Called after the last pass: makes the timestamps readable.
    pub fn finish(&mut self, encoder: &mut wgpu::CommandEncoder) {
        self.end(encoder);
        if let Timer::Steps(steps) = &mut self.timer {
            steps.run(encoder);
        }
        let count = 2 * self.passes.len() as u32;
        if let (Timer::Queries(queries), 1..) = (&self.timer, count) {
            encoder.resolve_query_set(&queries.set, 0..count, &queries.resolved, 0);
            let bytes = u64::from(count) * 8;
            encoder.copy_buffer_to_buffer(&queries.resolved, 0, &queries.readback, 0, bytes);
        }
    }

    /// Stages in order of first appearance and their times \[ms\]; none where the driver writes no
    /// timestamps. Blocks until the frame is done.
    pub fn read(&self, device: &wgpu::Device) -> Vec<(&'static str, f64)> {
        let mut times = Vec::new();
        for (timed, ms) in self.times(device) {
            add_time(&mut times, timed.label, ms);
        }
        times
    }

    /// Kernels by stage, in order of first appearance, of a timeline [by kernel](Self::by_kernel). Blocks
    /// until the frame is done.
    pub fn read_kernels(&self, device: &wgpu::Device) -> Vec<KernelTime> {
        kernel_times(&self.times(device))
    }

    /// Times of all passes \[ms\].
    fn times(&self, device: &wgpu::Device) -> Vec<(Timed, f64)> {
        match &self.timer {
            Timer::Steps(steps) => steps.times.clone(),
            Timer::Queries(queries) => {
                let ticks = self.ticks(device).filter(|ticks| are_written(ticks));
                ticks.map_or_else(Vec::new, |ticks| times(&self.passes, &ticks, queries.period))
            }
            Timer::None | Timer::Host(..) => Vec::new(),
        }
    }

    /// Ticks at the begin and the end of each pass; `None` without passes, or if they cannot be read.
    fn ticks(&self, device: &wgpu::Device) -> Option<Vec<u64>> {
        let Timer::Queries(queries) = &self.timer else { return None };
        if self.passes.is_empty() {
            return None;
        }
        let slice = queries.readback.slice(..self.passes.len() as u64 * 16);
        slice.map_async(wgpu::MapMode::Read, |_| ());
        if device.poll(wgpu::PollType::wait_indefinitely()).is_err() {
            return None;
        }
        let bytes = slice.get_mapped_range().ok();
        let ticks = bytes.map(|bytes| bytemuck::pod_collect_to_vec(&bytes));
        queries.readback.unmap();
        ticks
    }
}

/// Times of passes \[ms\] by their ticks; `period`: length of a tick \[ns\].
fn times(passes: &[Timed], ticks: &[u64], period: f32) -> Vec<(Timed, f64)> {
    let ms = |stamps: &[u64]| stamps[1].saturating_sub(stamps[0]) as f64 * f64::from(period) * 1e-6;
    passes.iter().copied().zip(ticks.chunks_exact(2).map(ms)).collect()
}

/// Sums of the times of kernels by stage, without passes that belong to no kernel.
fn kernel_times(times: &[(Timed, f64)]) -> Vec<KernelTime> {
    let mut sums: Vec<KernelTime> = Vec::new();
    for &(timed, ms) in times {
        let Some(kernel) = timed.kernel else { continue };
        let stage = timed.stage();
        match sums.iter_mut().find(|sum| (sum.stage, sum.kernel) == (stage, kernel)) {
            Some(sum) => (sum.dispatches, sum.ms) = (sum.dispatches + 1, sum.ms + ms),
            None => sums.push(KernelTime { stage, kernel, dispatches: 1, ms }),
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::{KernelTime, Timed, add_time, are_written, kernel_times, times};

    #[test]
    fn zeros_are_no_times() {
        assert!(!are_written(&[0; 6]));
        assert!(are_written(&[0, 0, 7, 7]), "a pass may take less than a tick");
    }

    #[test]
    fn passes_of_a_stage_and_of_a_kernel_are_added() {
        let of = |label, kernel| Timed { label, kernel: Some(kernel) };
        let passes = [of("gobo sort", "count"), of("gobo bin", "count"), of("gobo sort", "count")];
        let is = times(&passes, &[1_000, 3_000, 3_000, 3_500, 9_000, 8_000], 2.0);
        let mut stages = Vec::new();
        is.iter().for_each(|(timed, ms)| add_time(&mut stages, timed.label, *ms));
        assert_eq!(stages, [("sort", 0.004), ("bin", 0.001)]);
        let sum = |stage, dispatches, ms| KernelTime { stage, kernel: "count", dispatches, ms };
        assert_eq!(kernel_times(&is), [sum("sort", 2, 0.004), sum("bin", 1, 0.001)]);
    }
}

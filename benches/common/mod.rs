//! Scene and timing that the benchmarks share.
use gobo::{
    frame::{Commands, Kernels, Sort, SortCount},
    glam::{Mat4, UVec2, Vec3, Vec4},
    gpu::{Gpu, KernelCache, RecordForm, Resource, Timeline},
    model::{Particle, Projection, View, ViewRole},
    stage::{
        sort::{PAIR_FORMAT, pair_texture_size},
        tuning::Tuning,
    },
    wgpu::{self, BufferUsages},
};
use gobo_reference::Pair;
use std::time::Duration;

/// Edge of the map [texels].
pub(crate) const SIZE: u32 = 1024;

/// Steele et al. 2014, `SplitMix64`.
pub(crate) fn mix(seed: u64) -> u64 {
    let z = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

/// Soft discs, evenly over the map of [`view`].
pub(crate) fn particles(count: u32, footprint: f32) -> Vec<Particle> {
    let one = |id| {
        let unit = |salt: u64| (mix(u64::from(id) * 8 + salt) >> 40) as f32 / (1 << 24) as f32;
        let part = Vec3::new(unit(1), unit(2), unit(3));
        Particle {
            center: Vec3::new(-1.0, -1.0, -1.9) + part * Vec3::new(2.0, 2.0, 1.8),
            radius: footprint * (0.75 + 0.5 * unit(4)) / SIZE as f32,
            color: Vec4::new(unit(5), unit(6), unit(7), 0.02),
            rotation: 0.0,
            material: 0,
            id,
        }
    };
    (1..=count).map(one).collect()
}

pub(crate) fn view() -> View {
    View {
        role: ViewRole::Whole,
        light: Some(0),
        name: "0",
        projection: Projection::Orthographic,
        size: UVec2::splat(SIZE),
        near: 0.0,
        far: 2.0,
        view_from_world: Mat4::IDENTITY,
        scale: SIZE as f32 * 0.5,
    }
}

pub(crate) fn pairs(count: u32) -> Vec<Pair> {
    (0..count).map(|value| Pair { key: (mix(u64::from(value)) >> 32) as u32, value }).collect()
}

/// A sort on the device.
pub(crate) struct PairSort {
    /// The unsorted pairs, the copy that is sorted, and the result.
    pub(crate) records: [Resource; 3],
    commands: Commands,
}

impl PairSort {
    /// Sorts by the lower `bits`.
    pub(crate) fn new(gpu: &Gpu, pairs: &[Pair], bits: u32) -> Self {
        let tuning = Tuning::of(&gpu.adapter).within(&gpu.device.limits());
        let kernels = Kernels::new(&gpu.device, gpu.tier, tuning, KernelCache::default());
        let size = pair_texture_size(pairs.len() as u32);
        let mut all = pairs.to_vec();
        all.resize((size[0] * size[1]) as usize, Pair::default());
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST;
        let [unsorted, first, second] =
            ["unsorted", "pairs", "sorted_pairs"].map(|name| match tuning.record_form {
                RecordForm::Buffers => Resource::from(&gpu.upload(name, &all, usage)),
                RecordForm::Textures => {
                    let texture = gpu.texture(name, size, PAIR_FORMAT);
                    gpu.write_texture(&texture, &all);
                    (&texture).into()
                }
            });
        let known = SortCount::Known(pairs.len() as u32);
        let sort = Sort::new(&kernels, [&first, &second], known, 0..bits).expect("the pairs fit");
        kernels.finish().expect("the kernels are made");
        let result = if sort.result() == 0 { first.clone() } else { second };
        let mut commands = Commands::new();
        commands.pass("sort", sort.dispatches);
        Self { records: [unsorted, first, result], commands }
    }

    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, timeline: &mut Timeline) {
        timeline.step(encoder, "copy");
        match &self.records {
            [Resource::Buffer(from), Resource::Buffer(to), _] => {
                encoder.copy_buffer_to_buffer(from, 0, to, 0, from.size());
            }
            [Resource::Texture(from), Resource::Texture(to), _] => {
                let [source, target] = [from, to].map(|it| it.as_image_copy());
                encoder.copy_texture_to_texture(source, target, from.size());
            }
            _ => unreachable!("all are of one form"),
        }
        self.commands.record(encoder, timeline);
    }
}

/// Timestamps; without them, or on a software adapter, where they mean nothing, the wall clock.
pub(crate) fn timeline(gpu: &Gpu) -> Timeline {
    let is_software = gpu.adapter.device_type == wgpu::DeviceType::Cpu;
    if is_software || !gpu.has(wgpu::Features::TIMESTAMP_QUERY) {
        Timeline::stepped(&gpu.device, &gpu.queue)
    } else {
        Timeline::new(&gpu.device, &gpu.queue)
    }
}

/// Time of one stage in `frames` frames.
pub(crate) fn stage_time(
    gpu: &Gpu,
    timeline: &mut Timeline,
    stage: &str,
    frames: u64,
    mut record: impl FnMut(&mut wgpu::CommandEncoder, &mut Timeline),
) -> Duration {
    let mut ms = 0.0;
    for _ in 0..frames {
        timeline.reset();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        record(&mut encoder, timeline);
        timeline.finish(&mut encoder);
        gpu.queue.submit([encoder.finish()]);
        let times = timeline.read(&gpu.device);
        gpu.check().expect("the device works");
        ms += times.iter().find(|(name, _)| *name == stage).expect("the stage is timed").1;
    }
    Duration::from_secs_f64(ms * 1e-3)
}

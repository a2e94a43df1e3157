//! Tuning for a device, decided here and nowhere else. Kernels read it by overrides and `choice::` imports.
//! Code that only llvmpipe needs is in `wgsl/llvmpipe/` and [`super::llvmpipe`]; without it only speed is
//! lost.
use super::{
    accumulate::is_plain,
    bin::{DISC_SEGMENT, WIDE_DISC_SEGMENT},
    buckets::BUCKET_PAIRS,
    llvmpipe,
    sort::Partition,
};
use crate::gpu::{Choice, Constant, KernelDesc, RecordForm, Tier};

/// Reads and writes records in textures on every tier.
pub const IN_TEXTURES: [Choice; 3] = [
    Choice::new("records", "records/in_textures.wgsl"),
    Choice::new("writes", "records/write_textures.wgsl"),
    Choice::by_tier("sums", "sums/by_channel.wgsl", Tier::Native, "sums/textures.wgsl"),
];
/// Bytes that a device must be able to bind for records to be in buffers: the sums of a map of 8192 x 8192,
/// twice the records of 16 million casters.
pub const MOST_BOUND: u64 = 1 << 30;

/// Tiles that a workgroup walks on llvmpipe. WGSL: `wgsl/llvmpipe/choices.wgsl`.
pub const TILE_RUN: u32 = 4;

/// Tuning of kernels for a device. No choice changes a bit of the maps, except `scatter_tiny` and
/// `disc_segment`, which change their rounding, and `queued`, which changes where nodes of curves end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tuning {
    /// Partition of the work of sort and bin.
    pub partition: Partition,
    /// Pairs of a segment of soft discs.
    pub disc_segment: u32,
    /// Most pairs of a list that is binned by buckets, without a sort; none on software adapters, whose
    /// atomics cost more.
    pub bucket_pairs: u32,
    /// Whether particles of at most 2x2 texels skip sort and bin. Not on software adapters, whose
    /// atomics cost more than their sort.
    pub scatter_tiny: bool,
    /// Whether invocations hold columns of four or eight texels, with the nodes of their curves in
    /// registers, and all loops over them unrolled. On llvmpipe, which loads workgroup memory slowly. Not on
    /// SwiftShader, whose compiler takes minutes for such a kernel, and in a browser takes the process with
    /// it.
    pub columns: bool,
    /// Whether walks visit particles and triangles in loops of their own. On software adapters, which
    /// take both sides of a branch; elsewhere it doubles the code of a kernel.
    pub kinds_apart: bool,
    /// Whether subgroups may have more than 32 lanes.
    pub wide: bool,
    /// Whether soft discs are collected in batches of eight, one for each lane of a subgroup. On software
    /// adapters with such subgroups, on the native tier, if the device has
    /// [`FETCH_FEATURES`](crate::gpu::FETCH_FEATURES).
    pub queued: bool,
    /// Whether tiles alternate between two cores.
    pub interleaved: bool,
    /// Where records are. In textures on software adapters, where reads of buffers take ten times as long.
    pub record_form: RecordForm,
    /// Whether sampled textures are read as storage textures: on software adapters, where that takes a
    /// third of the time.
    pub loaded: bool,
}

impl Tuning {
    /// The tuning of an adapter.
    pub fn of(adapter: &wgpu::AdapterInfo) -> Self {
        let is_software = adapter.device_type == wgpu::DeviceType::Cpu;
        let is_swiftshader = adapter.driver.starts_with("SwiftShader")
            || adapter.backend == wgpu::Backend::BrowserWebGpu;
        let lanes = [adapter.subgroup_min_size, adapter.subgroup_max_size];
        Self {
            partition: if is_software { Partition::Serial } else { Partition::Wide },
            disc_segment: if is_software { DISC_SEGMENT } else { WIDE_DISC_SEGMENT },
            bucket_pairs: if is_software { 0 } else { BUCKET_PAIRS },
            scatter_tiny: !is_software,
            columns: is_software && !is_swiftshader,
            kinds_apart: is_software,
            wide: adapter.subgroup_max_size > 32,
            queued: is_software && lanes == [8, 8],
            interleaved: is_software,
            record_form: if is_software { RecordForm::Textures } else { RecordForm::Buffers },
            loaded: is_software,
        }
    }

    /// Values of the overrides.
    pub fn constants(&self) -> [Constant; 3] {
        let flag = |is: bool| f64::from(u8::from(is));
        [
            ("WIDE", flag(self.wide)),
            ("KINDS_APART", flag(self.kinds_apart)),
            // Where the loop is unrolled.
            ("CELLS_AT_ONCE", if self.columns { 5.0 } else { 1.0 }),
        ]
    }

    /// Workgroups in z that share the texels of a tile. WGSL: `SHARES`.
    pub fn tile_shares(&self, desc: &KernelDesc) -> u32 {
        let has = |name| desc.choices().any(|choice| choice.name == name);
        match (has("rows"), has("column")) {
            _ if self.columns => 1,
            (true, _) => 4,
            (false, true) => 2,
            (false, false) => 1,
        }
    }

    /// The tuning of a device.
    #[must_use]
    pub fn within(self, limits: &wgpu::Limits) -> Self {
        let is_small = limits.max_storage_buffer_binding_size < MOST_BOUND;
        let record_form = if is_small { RecordForm::Textures } else { self.record_form };
        Self { record_form, ..self }
    }

    /// Tiles that a workgroup of a kernel walks. One where visits cost no more than the search for empty
    /// tiles.
    pub fn tile_run(&self, desc: &KernelDesc) -> u32 {
        if self.columns && !is_plain(desc) { TILE_RUN } else { 1 }
    }

    /// Choices that replace a kernel's own.
    pub fn choices(&self, desc: &KernelDesc) -> Vec<Choice> {
        let chosen = [
            (self.interleaved, &[llvmpipe::INTERLEAVED][..]),
            (self.loaded, &[llvmpipe::LOADED]),
            (self.record_form == RecordForm::Textures, &IN_TEXTURES),
            (self.columns, &llvmpipe::COLUMNS),
            (self.tile_run(desc) > 1, &[llvmpipe::RUNS]),
        ];
        chosen.into_iter().filter(|(is, _)| *is).flat_map(|(_, choices)| choices).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ON_GPUS: Tuning = Tuning {
        partition: Partition::Wide,
        disc_segment: WIDE_DISC_SEGMENT,
        bucket_pairs: BUCKET_PAIRS,
        scatter_tiny: true,
        columns: false,
        kinds_apart: false,
        wide: false,
        queued: false,
        interleaved: false,
        record_form: RecordForm::Buffers,
        loaded: false,
    };

    /// 128 MiB are WebGPU's default; sums of a map of 8192 x 8192 are 1 GiB.
    #[test]
    fn records_are_in_buffers_where_all_of_them_can_be_bound() {
        use RecordForm::{Buffers, Textures};
        for (max_storage_buffer_binding_size, form) in [
            (128 << 20, Textures),
            ((1 << 30) - 1, Textures),
            (1 << 30, Buffers),
            (u64::MAX, Buffers),
        ] {
            let limits = wgpu::Limits { max_storage_buffer_binding_size, ..Default::default() };
            let found = ON_GPUS.within(&limits);
            let what = format!("{max_storage_buffer_binding_size} bytes");
            assert_eq!(found.record_form, form, "{what}");
            assert_eq!(Tuning { record_form: Buffers, ..found }, ON_GPUS, "{what}");
            let on_cpus = Tuning { record_form: Textures, ..ON_GPUS };
            assert_eq!(on_cpus.within(&limits), on_cpus, "{what}");
        }
    }
}

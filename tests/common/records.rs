//! Records that kernels read and write, in buffers or textures.
use gobo::{
    gpu::{Choice, Gpu, RecordForm, Resource, Tier},
    records::ROW,
    stage::tuning::IN_TEXTURES,
    wgpu::{BufferUsages, TextureFormat},
};

/// Where tests of kernels have their records: both forms on some tier.
pub(crate) fn form_of(tier: Tier) -> RecordForm {
    if tier == Tier::Core { RecordForm::Textures } else { RecordForm::Buffers }
}

/// Choices of kernels that read and write them there.
pub(crate) fn choices_of(tier: Tier) -> &'static [Choice] {
    match form_of(tier) {
        RecordForm::Textures => &IN_TEXTURES,
        RecordForm::Buffers => &[],
    }
}

/// `records` where kernels of a tier read and write them, and behind them `rest`, up to the end of a
/// texture's row.
pub(crate) fn records<T: bytemuck::NoUninit>(
    gpu: &Gpu,
    tier: Tier,
    (name, format): (&str, TextureFormat),
    records: &[T],
    rest: T,
) -> Resource {
    let texel = format.block_copy_size(None).unwrap() as usize;
    let rows = size_of_val(records).div_ceil(texel * ROW as usize).max(1);
    let mut all = records.to_vec();
    all.resize(rows * ROW as usize * texel / size_of::<T>(), rest);
    match form_of(tier) {
        RecordForm::Buffers => {
            let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
            (&gpu.upload(name, &all, usage)).into()
        }
        RecordForm::Textures => {
            let texture = gpu.texture(name, [ROW, rows as u32], format);
            gpu.write_texture(&texture, &all);
            (&texture).into()
        }
    }
}

/// All that [`records`] holds.
pub(crate) fn read_records<T: bytemuck::AnyBitPattern>(gpu: &Gpu, records: &Resource) -> Vec<T> {
    match records {
        Resource::Buffer(buffer) => gpu.read(buffer),
        Resource::Texture(texture) => gpu.read_texture(texture),
        Resource::View(view) => gpu.read_texture(view.texture()),
    }
}

//! A handmade batch: two views in a poisoned atlas, their tiles and sums, and a kernel's outputs.
use crate::common::records::choices_of;
use gobo::{
    glam::{Mat4, UVec2, Vec2, Vec3},
    gpu::{Constant, Gpu, KernelDesc, Resource, Resources, Tier},
    records::{CasterRecord, Footprint, GpuView, MAX_VIEWS, ROLE_WHOLE, ROW},
    stage::{
        bin::Segment,
        features::{Features, Flags},
        tuning::Tuning,
    },
    wgpu::{self, BufferUsages, TextureFormat as Format, TextureUsages as Use},
};
use std::ops::Range;

pub(super) const TILE: u32 = 16;
/// Texels of a tile.
pub(super) const TEXELS: u32 = TILE * TILE;
/// Initial words of every output, to show words that a kernel does not write.
pub(super) const POISON: u32 = 0xdead_beef;
/// Optical depth 1 in fixed point.
pub(super) const FIXED_ONE: f64 = 65536.0;
/// Bits of depth 1, from which nearness counts down.
pub(super) const ONE_BITS: u32 = 0x3f80_0000;
/// Size of the atlas [texels], and its layers: larger than the maps in it.
pub(super) const ATLAS: [u32; 3] = [96, 80, 2];
/// Tiles of both views.
pub(super) const TILES: u32 = 8;

/// A view of 3 x 2 tiles in the middle of one layer, and one of 2 x 1 in the other.
pub(super) fn views() -> [GpuView; 2] {
    let view = |size: UVec2, origin, layer, first_tile| GpuView {
        view_from_world: Mat4::IDENTITY,
        size: size.as_vec2() * TILE as f32,
        scale: 1.0,
        perspective: 0.0,
        near: 0.0,
        far: 1.0,
        first_tile,
        tiles_x: size.x,
        origin,
        layer,
        light: 0,
        role: ROLE_WHOLE,
        role_index: 0,
        role_count: 1,
        fade: 0.0,
    };
    let (first, second) = (UVec2::new(3, 2), UVec2::new(2, 1));
    [view(first, UVec2::new(16, 32), 0, 0), view(second, UVec2::new(48, 16), 1, 6)]
}

/// Place of a tile by its number: its view, and its first texel there.
pub(super) fn place_of(tile: u32) -> (usize, UVec2) {
    let view = usize::from(tile >= 6);
    let (index, width) = [(tile, 3), (tile.wrapping_sub(6), 2)][view];
    (view, UVec2::new(index % width, index / width) * TILE)
}

/// Texel `i` of a tile: its position in the view, and its index in the atlas.
pub(super) fn texel_of(tile: u32, i: u32) -> (Vec2, usize) {
    let (view, corner) = place_of(tile);
    let texel = corner + UVec2::new(i % TILE, i / TILE);
    let GpuView { origin, layer, .. } = views()[view];
    let at = origin + texel;
    (texel.as_vec2() + 0.5, ((layer * ATLAS[1] + at.y) * ATLAS[0] + at.x) as usize)
}

/// Record of a tile. `merged`: 0, or 1 + its first segment.
pub(super) fn tile_record(tile: u32, [first, end]: [u32; 2], merged: u32) -> [u32; 4] {
    let (view, corner) = place_of(tile);
    let place = corner / TILE;
    [first, end, merged, view as u32 | place.x << 8 | place.y << 20]
}

/// Records of all tiles, each with its run of pairs; other kernels finish the tile `merged`.
pub(super) fn tile_records(runs: &[Range<u32>; TILES as usize], merged: u32) -> Vec<[u32; 4]> {
    let record = |(tile, run): (u32, &Range<u32>)| {
        tile_record(tile, [run.start, run.end], u32::from(tile == merged))
    };
    (0..).zip(runs).map(record).collect()
}

/// A record texture; the texels after `texels` are poison.
pub(super) fn records<const N: usize>(
    gpu: &Gpu,
    name: &str,
    format: Format,
    texels: &[[u32; N]],
) -> wgpu::Texture {
    let texture = gpu.texture(name, [ROW, (texels.len() as u32).div_ceil(ROW).max(1)], format);
    let mut all = texels.to_vec();
    all.resize((ROW * texture.height()) as usize, [POISON; N]);
    gpu.write_texture(&texture, &all);
    texture
}

/// Records where the device's kernels read them; poison follows.
pub(super) fn in_form<const N: usize>(
    gpu: &Gpu,
    name: &str,
    format: Format,
    words: &[[u32; N]],
) -> Resource {
    crate::common::records::records(gpu, gpu.tier, (name, format), words, [POISON; N])
}

/// Casters where the device's kernels read them.
pub(super) fn casters(gpu: &Gpu, casters: &[CasterRecord]) -> Resource {
    in_form::<4>(gpu, "casters", Format::Rgba32Uint, bytemuck::cast_slice(casters))
}

/// Pairs of a tile, which no walk reads, and a footprint.
pub(super) fn pairs(gpu: &Gpu, footprints: &[u32]) -> Resource {
    let pairs: Vec<_> = footprints.iter().map(|&id| [POISON, id]).collect();
    in_form(gpu, "pairs", Format::Rg32Uint, &pairs)
}

/// A soft disc, or an opaque one, of an orthographic view.
pub(super) fn disc(center: Vec2, radius: f32, depth: f32, color: Vec3, opacity: f32) -> Footprint {
    let key = (depth * 65534.0) as u32;
    let mut footprint =
        Footprint { center, radius, depth, red_green: 0, blue_slope: 0, thin: 0, caster: 0 };
    footprint.set_opacity(color, gobo::Transfer::Filter as u32, 1.0, opacity);
    footprint.thin |= key << 16;
    footprint
}

pub(super) fn view_buffer(gpu: &Gpu) -> wgpu::Buffer {
    upload_views(gpu, views())
}

pub(super) fn upload_views(gpu: &Gpu, [first, second]: [GpuView; 2]) -> wgpu::Buffer {
    let mut all = vec![first; MAX_VIEWS];
    all[1] = second;
    gpu.upload("views", &all, BufferUsages::UNIFORM)
}

/// `all` segments, of which the first `count` are counted.
pub(super) fn segments_of(gpu: &Gpu, count: usize, all: &[Segment]) -> wgpu::Buffer {
    let header = Segment { tile: count as u32, ..Segment::default() };
    gpu.upload("segments", &[&[header], all].concat(), BufferUsages::STORAGE)
}

/// Indirect dispatches; only the workgroups of number `which` count.
pub(super) fn dispatches(gpu: &Gpu, which: usize, count: u32) -> wgpu::Buffer {
    let mut all = [[POISON; 4]; 3];
    all[which][3] = count;
    gpu.upload("dispatches", &all, BufferUsages::STORAGE)
}

/// The maps that a kernel writes.
pub(super) struct Outputs {
    pub(super) filters: wgpu::Texture,
    pub(super) nearests: wgpu::Texture,
}

impl Outputs {
    pub(super) fn poisoned(gpu: &Gpu) -> Self {
        let texels = ATLAS.iter().product::<u32>() as usize;
        let filters = gpu.texture_array("filters", ATLAS, Format::Rgba16Float);
        gpu.write_texture(&filters, &vec![[POISON; 2]; texels]);
        let nearests = gpu.texture_array("nearests", ATLAS, Format::R32Float);
        gpu.write_texture(&nearests, &vec![POISON; texels]);
        Self { filters, nearests }
    }

    /// Filter and nearest depth of each texel; `None` where neither was written.
    pub(super) fn read(&self, gpu: &Gpu) -> Vec<Option<([f64; 4], f32)>> {
        let filters: Vec<[u32; 2]> = gpu.read_texture(&self.filters);
        let nearests: Vec<u32> = gpu.read_texture(&self.nearests);
        let texel = |(filter, nearest): ([u32; 2], u32)| {
            if (filter, nearest) == ([POISON; 2], POISON) {
                return None;
            }
            let halves: [half::f16; 4] = bytemuck::cast(filter);
            Some((halves.map(half::f16::to_f64), f32::from_bits(nearest)))
        };
        filters.into_iter().zip(nearests).map(texel).collect()
    }
}

/// Sums of a batch's texels: red, green, blue, nearness.
pub(super) enum Sums {
    Buffers([wgpu::Buffer; 4]),
    Textures([wgpu::Texture; 4]),
}

const SUMS: [&str; 4] = ["sum_red", "sum_green", "sum_blue", "nearness"];

impl Sums {
    /// `texels`: all tiles of the batch, one after another. Poison follows.
    pub(super) fn new(gpu: &Gpu, tier: Tier, texels: &[[u32; 4]]) -> Self {
        let words = |i: usize| {
            let mut words: Vec<u32> = texels.iter().map(|texel| texel[i]).collect();
            words.resize(ROW as usize, POISON);
            words
        };
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        match tier.has_texture_atomics() {
            false => Self::Buffers([0, 1, 2, 3].map(|i| gpu.upload(SUMS[i], &words(i), usage))),
            true => Self::Textures([0, 1, 2, 3].map(|i| {
                let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
                    label: Some(SUMS[i]),
                    size: wgpu::Extent3d { width: ROW, height: 1, depth_or_array_layers: 1 },
                    mip_level_count: 1,
                    sample_count: 1,
                    dimension: wgpu::TextureDimension::D2,
                    format: Format::R32Uint,
                    usage: Use::STORAGE_ATOMIC
                        | Use::STORAGE_BINDING
                        | Use::COPY_SRC
                        | Use::COPY_DST,
                    view_formats: &[],
                });
                gpu.write_texture(&texture, &words(i));
                texture
            })),
        }
    }

    pub(super) fn resources(&self) -> Resources {
        (0..4).fold(Resources::new(), |resources, i| match self {
            Self::Buffers(buffers) => resources.with(SUMS[i], &buffers[i]),
            Self::Textures(textures) => resources.with(SUMS[i], &textures[i]),
        })
    }

    pub(super) fn read(&self, gpu: &Gpu) -> Vec<[u32; 4]> {
        let words: [Vec<u32>; 4] = [0, 1, 2, 3].map(|i| match self {
            Self::Buffers(buffers) => gpu.read(&buffers[i]),
            Self::Textures(textures) => gpu.read_texture(&textures[i]),
        });
        (0..words[0].len()).map(|texel| [0, 1, 2, 3].map(|i: usize| words[i][texel])).collect()
    }
}

/// Runs a kernel for soft discs once.
pub(super) fn run(
    gpu: &Gpu,
    desc: &'static KernelDesc,
    tier: Tier,
    constants: &[Constant],
    resources: &Resources,
    groups: [u32; 3],
) {
    let discs = Features::NONE
        .with(Flags::HAS_PARTICLES | Flags::HAS_FACING | Flags::HAS_OPAQUE, true)
        .constants();
    let constants = [constants, &discs].concat();
    run_all(gpu, tier, &constants, resources, &[(desc, groups)]);
}

/// Runs kernels, one after another, in their form for GPUs.
pub(super) fn run_all(
    gpu: &Gpu,
    tier: Tier,
    constants: &[Constant],
    resources: &Resources,
    kernels: &[(&'static KernelDesc, [u32; 3])],
) {
    let tuning = Tuning { columns: false, ..Tuning::of(&gpu.adapter) };
    let constants = [constants, &tuning.constants()].concat();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
    for &(desc, groups) in kernels {
        let kernel =
            gpu.kernels.kernel(&gpu.device, desc, tier, choices_of(tier), &constants).unwrap();
        let bindings = kernel.bind(&gpu.device, resources).unwrap();
        kernel.record(&mut pass, &bindings, groups);
    }
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
}

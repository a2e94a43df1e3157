//! Means of images over areas that a sample of a picture sees: without a step where an area is a whole number
//! of times as long as wide, about the area's middle, and alike by kernel and CPU reference.
use crate::common::{TIERS, gpu, scenes::Chance, wgsl_files};
use gobo::{
    glam::{Vec2, Vec4},
    gpu::{Gpu, Library},
    model::Texture,
    records::{image_level_count, image_levels},
    wgpu::{self, BufferUsages},
};
use gobo_reference::texture::Image;
use std::f32::consts::TAU;

const EDGE: u32 = 64;
/// Distance of two ratios on both sides of a whole number.
const STEP: f32 = 2e-6;
/// Most that light changes over [`STEP`]: taps move by less than 1e-5 texels and weights by as much, between
/// texels that differ by at most 1; the rest is for roundings of 32-bit places.
const CONTINUOUS: f32 = 1e-4;
/// Most that the kernel differs from its reference: llvmpipe decodes sRGB bytes by a cubic.
const DECODED: f32 = 4e-3;

/// An area in an image \[uv\].
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Area {
    uv: Vec2,
    right: Vec2,
    down: Vec2,
}

impl Area {
    /// An area `ratio` times as long as wide, which is `width` texels.
    fn new(uv: Vec2, angle: f32, width: f32, ratio: f32) -> Self {
        let along = Vec2::from_angle(angle) / EDGE as f32;
        Self { uv, right: along * (width * ratio), down: along.perp() * width }
    }
}

const KERNEL: &str = "
import package::hit::texture::sample_area;

struct Area {
    uv: vec2<f32>,
    right: vec2<f32>,
    down: vec2<f32>,
}

@group(0) @binding(0) var<storage, read> areas: array<Area>;
@group(0) @binding(1) var<storage, read_write> found: array<vec4<f32>>;
@group(0) @binding(2) var images: texture_2d_array<f32>;

@compute @workgroup_size(64)
fn test_area(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&areas) {
        let it = areas[id.x];
        let size = vec2<f32>(textureDimensions(images));
        found[id.x] = sample_area(images, 0u, size, it.uv, it.right, it.down, true).rgba;
    }
}
";

/// Each texel's grey, by its place.
fn image(grey: impl FnMut(u32) -> u8) -> Texture {
    let rgba = (0..EDGE * EDGE).map(grey).flat_map(|grey| [grey, grey, grey, 255]).collect();
    Texture { name: "image".to_owned(), width: EDGE, height: EDGE, rgba }
}

fn noise(chance: &mut Chance) -> Texture {
    image(|_| 255 * chance.below(2) as u8)
}

/// The image with its means, as uploads have it.
fn upload(gpu: &Gpu, image: &Texture) -> wgpu::TextureView {
    let levels = image_levels(image);
    let of_level =
        |edge: u32| wgpu::Extent3d { width: edge, height: edge, depth_or_array_layers: 1 };
    let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: of_level(EDGE),
        mip_level_count: image_level_count((EDGE, EDGE).into()),
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba8UnormSrgb,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let all = std::iter::once(&image.rgba).chain(levels.iter().map(|level| &level.rgba));
    for (mip_level, rgba) in (0..).zip(all) {
        let edge = EDGE >> mip_level;
        let layout =
            wgpu::TexelCopyBufferLayout { bytes_per_row: Some(4 * edge), ..Default::default() };
        let into = wgpu::TexelCopyTextureInfo { mip_level, ..texture.as_image_copy() };
        gpu.queue.write_texture(into, rgba, layout, of_level(edge));
    }
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

fn by_kernel(image: &Texture, areas: &[Area]) -> Vec<Vec4> {
    let mut files = wgsl_files();
    files.push(("test_area.wgsl".to_owned(), KERNEL.to_owned()));
    let leak = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let files: Vec<_> = files.into_iter().map(|(path, text)| (leak(path), leak(text))).collect();
    let linked = Library::new(&files).unwrap().link("test_area.wgsl", "test_area", &[]).unwrap();
    let gpu = gpu(TIERS[0]);
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(linked.wgsl.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("test_area"),
        compilation_options: Default::default(),
        cache: None,
    });
    let found = gpu.storage::<Vec4>("found", areas.len());
    let count = areas.len().div_ceil(64) as u32;
    let areas = gpu.upload("areas", areas, BufferUsages::STORAGE);
    let view = upload(&gpu, image);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: areas.as_entire_binding() },
            wgpu::BindGroupEntry { binding: 1, resource: found.as_entire_binding() },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::TextureView(&view),
            },
        ],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(count, 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&found)
}

fn by_reference(image: &Texture, areas: &[Area]) -> Vec<Vec4> {
    let image = Image::new(image);
    areas.iter().map(|it| image.sample_area(it.uv, it.right, it.down, true).rgba).collect()
}

/// Compilers that divide or round otherwise find another number of taps there.
#[test]
fn light_has_no_step_where_a_ratio_is_whole() {
    let mut chance = Chance::new(3);
    let noise = noise(&mut chance);
    let mut areas = Vec::new();
    for case in 0..3000 {
        let (uv, angle) = (Vec2::new(chance.unit(), chance.unit()), chance.within(0.0, TAU));
        let (width, whole) = (chance.within(1.01, 5.0), [1.0, 2.0, 3.0, 4.0][case % 4]);
        areas.extend([-0.5, 0.5].map(|side| Area::new(uv, angle, width, whole + side * STEP)));
    }
    for (name, found) in [("CPU", by_reference(&noise, &areas)), ("GPU", by_kernel(&noise, &areas))]
    {
        let apart = found.as_chunks().0.iter().map(|[a, b]| (*a - *b).abs().max_element());
        let (beyond, worst) = apart.fold((0, 0.0_f32), |(n, w), it| {
            (n + usize::from(it > CONTINUOUS || it.is_nan()), w.max(it))
        });
        assert_eq!(beyond, 0, "{name}: of {} ratios, {worst} at most", areas.len() / 2);
    }
}

#[test]
fn kernel_and_reference_find_the_same_mean() {
    let mut chance = Chance::new(4);
    let noise = noise(&mut chance);
    let areas: Vec<_> = (0..3000)
        .map(|_| {
            let uv = Vec2::new(chance.unit(), chance.unit());
            let (width, ratio) = (chance.within(0.2, 6.0), chance.within(0.2, 6.0));
            Area::new(uv, chance.within(0.0, TAU), width, ratio)
        })
        .collect();
    let pairs = by_kernel(&noise, &areas).into_iter().zip(by_reference(&noise, &areas));
    for ((found, expected), area) in pairs.zip(&areas) {
        let apart = (found - expected).abs().max_element();
        assert!(apart <= DECODED, "{found} for {expected}: {} {}", area.right, area.down);
    }
}

/// The mean of a slope is its value in the middle, whatever the number of taps and their weights.
#[test]
fn taps_are_about_the_middle() {
    let slope = image(|i| (64 + 2 * (i % EDGE)) as u8);
    let linear = Image::new(&slope);
    let mut chance = Chance::new(5);
    for _ in 0..3000 {
        let uv = Vec2::new(chance.within(0.45, 0.55), chance.unit());
        let area = Area::new(uv, chance.within(0.0, TAU), 1.0, chance.within(1.0, 4.0));
        let found = linear.sample_area(area.uv, area.right, area.down, true).rgba.x;
        // A curve over a few texels: values on both sides of the middle.
        let side = Vec2::new(0.5 / EDGE as f32, 0.0);
        let [low, high] = [uv - side, uv + side].map(|uv| linear.sample(uv, true).x);
        assert!((low..=high).contains(&found), "{found} not in {low}..{high}: {}", area.right);
    }
}

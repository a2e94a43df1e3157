//! Splats that never leave the GPU, in two renderers' own buffers: the 32-byte splats that antimatter15's and
//! three.js viewers sort, and the arrays that 3DGS trains. gobo reads both in place, and they cast one
//! coloured shadow, also on each other. The same Gaussians, uploaded, must give the same maps.
//!
//! `cargo run --example host_splats`
mod cloud;
mod light;

use cloud::{Arrays, Packed, ring};
use gobo::{
    Bounds, CasterCount, Casters, Gaussian, HostCasters, HostInputs, Light, Material, Prepared,
    ShadowSettings, Shadows, Shape, Support, Tier, View,
    glam::Vec3,
    host::PointBuffers,
    light_views,
    wgpu::{self, BufferUsages, util::DeviceExt as _},
};
use half::f16;
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Splats of each host.
const COUNT: u32 = 4000;
/// Edge of the grid of points on the floor, and of its picture.
const GRID: u32 = 160;
const SCALE: u32 = 3;
/// Largest difference of a filter: two steps of half floats below 1. A device's `exp` and `normalize` differ
/// from the CPU's in their last bits.
const TOLERANCE: f32 = 1.0 / 1024.0;

fn main() -> Result<()> {
    let settings = ShadowSettings { size: 256, ..Default::default() };
    let adapter = wgpu::Instance::default().request_adapter(&Default::default());
    let adapter = pollster::block_on(adapter)?;
    let tier = Tier::of(&adapter);
    let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: settings.features(tier),
        required_limits: settings.limits(tier, settings.size),
        ..Default::default()
    }))?;
    Support::of(&device, &adapter.get_info(), &settings).check(tier)?;

    // Two renderers' buffers.
    let packed: Vec<Packed> = ring(COUNT, 1).iter().map(Packed::new).collect();
    let arrays = Arrays::new(&ring(COUNT, 2));
    let order: Vec<u32> = (0..COUNT).rev().collect();
    let storage = |contents: &[u8]| {
        let usage = BufferUsages::STORAGE;
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: None,
            contents,
            usage,
        })
    };
    let of_packed = [bytemuck::cast_slice(&packed), bytemuck::cast_slice(&order)].map(storage);
    let of_arrays = arrays.bytes().map(storage);

    // In gobo's form.
    let mut shadows = Shadows::on_tier(&device, &queue, &adapter.get_info(), tier)?;
    let (layout, packed_bindings) = bind(&device, &of_packed);
    let packed_loader =
        shadows.gaussian_loader("packed.wgsl", include_str!("packed.wgsl"), &layout)?;
    let (layout, array_bindings) = bind(&device, &of_arrays);
    let array_loader =
        shadows.gaussian_loader("arrays.wgsl", include_str!("arrays.wgsl"), &layout)?;
    let count = CasterCount::Fixed(COUNT);
    let sets = [
        HostCasters::new(&packed_loader, &packed_bindings, count, &[0]).least_alpha(0.01),
        HostCasters::new(&array_loader, &array_bindings, count, &[0]).least_alpha(0.01),
    ];
    let materials = [Material { shape: Shape::Gaussian, ..Material::default() }];
    let casters = Casters { materials: &materials, in_order: true, ..Casters::default() };
    let lights =
        [Light::directional(Vec3::new(0.3, -1.0, 0.15)), Light::point(Vec3::new(-2.2, 2.6, -0.6))];
    let bounds = Bounds { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 2.0, 3.0) };
    let views: Vec<View> = (0..)
        .zip(&lights)
        .map(|(i, light)| light_views(i, light, settings.size, None, &bounds))
        .collect::<std::result::Result<Vec<_>, _>>()?
        .concat();
    let inputs = HostInputs::new().casters(&sets);
    let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs)?;
    let found = filters(&device, &queue, &prepared)?;
    let counters = prepared.counters()?;
    println!("{} splats, {} skipped", counters.casters, counters.skipped.len());
    let floor = floor_light(&device, &queue, &prepared, &lights)?;
    save(&floor)?;
    let on_splats = light::splat_shares(&device, &queue, &prepared, (&lights, 0), &of_packed[0])?;

    // The same, uploaded.
    let sorted = order.iter().map(|&id| packed[id as usize].gaussian(id));
    let gaussians: Vec<Gaussian> = sorted.chain(arrays.gaussians()).collect();
    let casters = Casters { gaussians: &gaussians, ..casters };
    let expected = filters(&device, &queue, &shadows.prepare(&casters, &views, &settings)?)?;
    let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let equal = found.iter().zip(&expected).filter(|(a, b)| a == b).count();
    println!("{equal} of {} texels are equal, the others within {apart}", found.len());
    let colored = floor.iter().filter(|[r, _, b]| (r - b).abs() > 0.1).count();
    println!("{colored} of {} points on the floor are in coloured light", floor.len());
    let shaded = on_splats.iter().filter(|share| share[2] < 0.9).count();
    println!("{shaded} of {COUNT} packed splats are in the shadow of others");
    let is_share = |share: &f32| (0.0..=1.0 + 1e-6).contains(share);
    if shaded == 0 || !on_splats.iter().flatten().all(is_share) {
        return Err("no splat is in the shadow of others, or some share of light is none".into());
    }
    if found.len() != expected.len() || apart.is_nan() || apart > TOLERANCE {
        return Err("uploaded, the same splats cast another shadow".into());
    }
    if colored < 500 || counters.casters != u64::from(2 * COUNT) {
        return Err("the splats cast no coloured shadow, or are not all there".into());
    }
    Ok(())
}

/// Layout and bind group of read-only buffers, from binding 0 on.
fn bind(
    device: &wgpu::Device,
    buffers: &[wgpu::Buffer],
) -> (wgpu::BindGroupLayout, wgpu::BindGroup) {
    let entry = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let entries: Vec<_> = (0..buffers.len() as u32).map(entry).collect();
    let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    });
    let bound = (0..).zip(buffers).map(|(binding, buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    });
    let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &bound.collect::<Vec<_>>(),
    });
    (layout, group)
}

/// Red, green and blue of all texels of the recorded maps.
fn filters(device: &wgpu::Device, queue: &wgpu::Queue, prepared: &Prepared) -> Result<Vec<f32>> {
    let texture = &prepared.maps().filters;
    let size = texture.size();
    let row = (size.width * 8).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(row * size.height * size.depth_or_array_layers),
        usage: BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(row),
        rows_per_image: Some(size.height),
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder)?;
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, size);
    queue.submit([encoder.finish()]);
    let texels: Vec<[f16; 4]> = bytemuck::pod_collect_to_vec(&read(device, queue, &buffer)?);
    Ok(texels.iter().flat_map(|texel| [0, 1, 2].map(|c| texel[c].to_f32())).collect())
}

/// Half of the sun and half of the lamp at a grid of points on the floor.
fn floor_light(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    prepared: &Prepared,
    lights: &[Light],
) -> Result<Vec<[f32; 3]>> {
    let at = |i: u32| (i as f32 + 0.5) / GRID as f32 * 6.0 - 3.0;
    let points: Vec<_> = (0..GRID * GRID).map(|i| [at(i % GRID), 0.0, at(i / GRID)]).collect();
    let positions = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("positions"),
        contents: bytemuck::cast_slice(&points),
        usage: BufferUsages::STORAGE,
    });
    let points = PointBuffers { count: GRID * GRID, positions: &positions, normals: None };
    let lit = prepared.light_points(lights, &[0, 1], &points)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    lit.record(&mut encoder);
    queue.submit([encoder.finish()]);
    let shares: Vec<[[f32; 3]; 2]> =
        bytemuck::pod_collect_to_vec(&read(device, queue, lit.shares())?);
    Ok(shares.iter().map(|[sun, lamp]| [0, 1, 2].map(|c| 0.5 * (sun[c] + lamp[c]))).collect())
}

/// Contents of a buffer, after all commands submitted before. Blocks.
fn read(device: &wgpu::Device, queue: &wgpu::Queue, buffer: &wgpu::Buffer) -> Result<Vec<u8>> {
    let (send, received) = std::sync::mpsc::channel();
    wgpu::util::DownloadBuffer::read_buffer(device, queue, &buffer.slice(..), move |bytes| {
        // The receiver waits below.
        let _ = send.send(bytes.map(|bytes| bytes.to_vec()));
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(received.recv()??)
}

/// The floor from above, as `out/host_splats/floor.png`.
fn save(floor: &[[f32; 3]]) -> Result<()> {
    let folder = Path::new("out/host_splats");
    std::fs::create_dir_all(folder)?;
    let edge = GRID * SCALE;
    let pixels: Vec<u8> = (0..edge * edge)
        .flat_map(|i| floor[(i / edge / SCALE * GRID + i % edge / SCALE) as usize])
        .map(|light| (light.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8)
        .collect();
    let path = folder.join("floor.png");
    image::save_buffer(&path, &pixels, edge, edge, image::ExtendedColorType::Rgb8)?;
    println!("{}", path.display());
    Ok(())
}

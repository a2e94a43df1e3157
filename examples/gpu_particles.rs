//! Smoke that never leaves the GPU: a compute kernel moves it, gobo reads the kernel's buffer, and points on
//! the floor below are lit through it. Finally the same smoke, read back and uploaded, must give the same
//! bits.
//!
//! `cargo run --example gpu_particles`
#[path = "common/kernel.rs"]
mod kernel;
#[path = "common/particles.rs"]
mod particles;

use gobo::{
    Bounds, CasterCount, Casters, HostCasters, HostInputs, Light, Material, Particle, Prepared,
    ShadowSettings, Shadows, Support, Tier, View,
    glam::{Vec3, Vec4},
    host::PointBuffers,
    wgpu::{self, BufferUsages, util::DeviceExt as _},
};
use kernel::{Kernel, bind};
use std::{error::Error, time::Instant};

const CAPACITY: u32 = 20_000;
const FRAMES: u32 = 60;
/// Edge of the grid of points on the floor.
const GRID: u32 = 24;

/// The simulation, with a layout of its own.
const SIMULATION: &str = "
struct Smoke { place: vec3<f32>, radius: f32, color: vec4<f32> }
struct Frame { number: u32, born: u32, capacity: u32 }
@group(0) @binding(0) var<storage, read_write> smoke: array<Smoke>;
@group(0) @binding(1) var<storage, read_write> alive: array<u32>;
@group(0) @binding(2) var<uniform> frame: Frame;

@compute @workgroup_size(64)
fn move_smoke(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = id.x;
    let before = min(frame.number * frame.born, frame.capacity);
    let after = min(before + frame.born, frame.capacity);
    if i == 0u { alive[0] = after; }
    if i >= before && i < after {
        let turn = chance(3u * i) * 6.2831853;
        let place = vec3(cos(turn), 0.0, sin(turn)) * 0.25 * sqrt(chance(3u * i + 1u));
        smoke[i] = Smoke(place, 0.03, vec4(0.75, 0.8, 0.9, 0.25));
    } else if i < before {
        var one = smoke[i];
        let swirl = vec3(-one.place.z, 0.0, one.place.x) * 0.04;
        one.place += swirl + vec3(0.004, 0.02 + 0.015 * chance(3u * i + 2u), 0.0);
        one.radius *= 1.02;
        one.color.a *= 0.985;
        smoke[i] = one;
    }
}";

/// The loader: gobo reads casters through it.
const LOADER: &str = "
struct Smoke { place: vec3<f32>, radius: f32, color: vec4<f32> }
@group(1) @binding(0) var<storage, read> smoke: array<Smoke>;

fn load_caster(index: u32) -> Caster {
    let one = smoke[index];
    return Caster(one.place, one.radius, one.color, 0.0, 0u, index);
}";

fn main() -> Result<(), Box<dyn Error>> {
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
    let buffer = |label, size, usage| {
        let (label, mapped_at_creation) = (Some(label), false);
        device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
    };
    let storage = BufferUsages::STORAGE;
    let smoke = buffer("smoke", u64::from(CAPACITY) * 32, storage | BufferUsages::COPY_SRC);
    let alive = buffer("alive", 4, storage | BufferUsages::COPY_SRC);
    let frame = buffer("frame", 16, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
    let text = [include_str!("common/chance.wgsl"), SIMULATION].concat();
    let simulation = Kernel::new(&device, text, &[&smoke, &alive, &frame]);

    // The smoke in gobo's form.
    let layout = particles::layout(&device);
    let bindings = bind(&device, &layout, &[&smoke]);
    let mut shadows = Shadows::on_tier(&device, &queue, &adapter.get_info(), tier)?;
    let loader = shadows.caster_loader("smoke.wgsl", LOADER, &layout)?;
    let count = CasterCount::Indirect { buffer: &alive, offset: 0, capacity: CAPACITY };
    let sets = [HostCasters::new(&loader, &bindings, count, &[0]).least_alpha(0.01)];
    let materials = [Material::default()];
    let casters = Casters { materials: &materials, ..Casters::default() };
    let lights =
        [Light::directional(Vec3::new(0.3, -1.0, 0.2)), Light::point(Vec3::new(-1.5, 2.5, 0.4))];
    let bounds = Bounds { min: Vec3::new(-2.5, 0.0, -2.5), max: Vec3::new(2.5, 4.0, 2.5) };
    let views: Vec<View> = (0..)
        .zip(&lights)
        .map(|(i, light)| gobo::light_views(i, light, settings.size, None, &bounds))
        .collect::<Result<Vec<_>, _>>()?
        .concat();

    // Done once, as long as lights and materials stay.
    let inputs = HostInputs::new().casters(&sets);
    let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs)?;
    let made = || device.get_internal_counters().hal.buffers.read();
    let (mut recording, mut before) = (0.0, 0);
    for number in 0..FRAMES {
        queue.write_buffer(&frame, 0, bytemuck::bytes_of(&[number, 400, CAPACITY, 0]));
        let mut encoder = device.create_command_encoder(&Default::default());
        simulation.record(&mut encoder, CAPACITY);
        let start = Instant::now();
        prepared.record(&mut encoder)?;
        recording += start.elapsed().as_secs_f64() * 1e6 / f64::from(FRAMES);
        queue.submit([encoder.finish()]);
        device.poll(wgpu::PollType::wait_indefinitely())?;
        if number == 0 {
            before = made(); // what `prepare` staged is gone
        }
    }
    let left = made() - before;
    println!("{FRAMES} frames, {recording:.0} us each to record, {left} buffers made on the way");
    let counters = prepared.counters()?;
    println!("{} particles, {} skipped", counters.casters, counters.skipped.len());
    let through = shares(&device, &queue, &prepared, &lights)?;

    // The same smoke, uploaded by the CPU.
    let bytes = read(&device, &queue, &smoke)?;
    let [alive] = bytemuck::pod_read_unaligned::<[u32; 1]>(&read(&device, &queue, &alive)?);
    let records: Vec<[f32; 8]> = bytemuck::pod_collect_to_vec(&bytes);
    let particle = |(id, r): (u32, &[f32; 8])| Particle {
        center: Vec3::new(r[0], r[1], r[2]),
        radius: r[3],
        color: Vec4::new(r[4], r[5], r[6], r[7]),
        id,
        ..Particle::default()
    };
    let particles: Vec<_> = (0..alive).zip(&records).map(particle).collect();
    let casters = Casters { particles: &particles, in_order: true, ..casters };
    let prepared = shadows.prepare(&casters, &views, &settings)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder)?;
    queue.submit([encoder.finish()]);
    let expected = shares(&device, &queue, &prepared, &lights)?;

    let dark = through.iter().filter(|share| share[0] < 0.7).count();
    println!("{dark} of {} points are in the smoke's shadow", through.len());
    let same = through.iter().flatten().map(|x| x.to_bits());
    if !same.eq(expected.iter().flatten().map(|x| x.to_bits())) {
        return Err("uploaded, the same smoke casts another shadow".into());
    }
    if dark < 20 || alive != CAPACITY || left != 0 {
        return Err("the smoke casts no shadow, is not all there, or left something behind".into());
    }
    println!("uploaded, the same smoke casts the same shadow, bit for bit");
    Ok(())
}

/// Share of each light at a grid of points on the floor.
fn shares(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    prepared: &Prepared,
    lights: &[Light],
) -> Result<Vec<[f32; 3]>, Box<dyn Error>> {
    let at = |i: u32| (i as f32 + 0.5) / GRID as f32 * 4.0 - 2.0;
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
    Ok(bytemuck::pod_collect_to_vec(&read(device, queue, lit.shares())?))
}

fn read(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    buffer: &wgpu::Buffer,
) -> Result<Vec<u8>, Box<dyn Error>> {
    let (send, received) = std::sync::mpsc::channel();
    wgpu::util::DownloadBuffer::read_buffer(device, queue, &buffer.slice(..), move |bytes| {
        // The receiver waits below.
        let _ = send.send(bytes.map(|bytes| bytes.to_vec()));
    });
    device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(received.recv()??)
}

//! Smoke on voxels that never leaves the GPU: a compute kernel moves two blobs through a volume texture each
//! frame, and gobo makes bricks of it in place. Finally the same voxels, uploaded, must cast the same shadow.
//!
//! `cargo run --example host_grid`
use gobo::{
    Bounds, Brick, Casters, Grid, HostGrid, HostInputs, Light, Material, Prepared, ShadowSettings,
    Shadows, Shape, Support, Tier, View,
    glam::{Affine3A, IVec3, Vec3},
    host::PointBuffers,
    light_views,
    wgpu::{self, BufferUsages, TextureUsages, util::DeviceExt as _},
};
use std::path::Path;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Voxels along each axis.
const EDGE: u32 = 64;
/// Edge of a voxel [m].
const VOXEL: f32 = 3.0 / EDGE as f32;
const FRAMES: u32 = 24;
/// Edge of the grid of points on the floor, and of its picture.
const POINTS: u32 = 120;
const SCALE: u32 = 3;
/// Largest difference of a light's share: a ray is measured from the middle of an uploaded grid's bricks, or
/// from that of the texture's whole extent.
const TOLERANCE: f32 = 1.0 / 1024.0;

/// A minimal simulation.
const SIMULATION: &str = "
@group(0) @binding(0) var smoke: texture_storage_3d<r32float, write>;
@group(0) @binding(1) var<uniform> time: vec4<f32>;

fn blob(at: vec3<f32>, center: vec3<f32>, radius: f32) -> f32 {
    let off = at - center;
    let swirl = sin(9.0 * off.x + 4.0 * time.x) * sin(8.0 * off.y) * sin(9.0 * off.z);
    return max(1.0 - length(off) / radius + 0.35 * swirl, 0.0);
}

@compute @workgroup_size(4, 4, 4)
fn move_smoke(@builtin(global_invocation_id) id: vec3<u32>) {
    let size = textureDimensions(smoke);
    if any(id >= size) { return; }
    let at = (vec3<f32>(id) + 0.5) / vec3<f32>(size);
    let turn = vec3(cos(time.x), 0.0, sin(time.x)) * 0.22;
    let density = blob(at, 0.5 + turn, 0.2) + blob(at, 0.5 - turn, 0.14);
    textureStore(smoke, id, vec4(density, 0.0, 0.0, 0.0));
}";

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
    let smoke = device.create_texture(&wgpu::TextureDescriptor {
        label: Some("smoke"),
        size: wgpu::Extent3d { width: EDGE, height: EDGE, depth_or_array_layers: EDGE },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D3,
        format: wgpu::TextureFormat::R32Float,
        usage: TextureUsages::STORAGE_BINDING
            | TextureUsages::TEXTURE_BINDING
            | TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let time = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("time"),
        size: 16,
        usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let simulation = Simulation::new(&device, &smoke, &time);

    // The smoke in gobo's form: blue is absorbed most.
    let corner = Vec3::new(-1.5, 0.2, -1.5);
    let grid = Grid {
        world_from_index: Affine3A::from_translation(corner)
            * Affine3A::from_scale(Vec3::splat(VOXEL)),
        factor: 6.0,
        extinction: Vec3::new(0.25, 0.6, 1.0),
        ..Grid::default()
    };
    let grids = [HostGrid::new(&smoke, &grid)];
    let materials = [Material { shape: Shape::Brick, ..Material::default() }];
    let casters = Casters { materials: &materials, in_order: true, ..Casters::default() };
    let lights =
        [Light::directional(Vec3::new(0.3, -1.0, 0.2)), Light::point(Vec3::new(-1.8, 4.0, 0.4))];
    let bounds = Bounds { min: Vec3::new(-3.0, 0.0, -3.0), max: Vec3::new(3.0, 3.5, 3.0) };
    let views: Vec<View> = (0..)
        .zip(&lights)
        .map(|(i, light)| light_views(i, light, settings.size, None, &bounds))
        .collect::<std::result::Result<Vec<_>, _>>()?
        .concat();
    let mut shadows = Shadows::on_tier(&device, &queue, &adapter.get_info(), tier)?;

    // Done once, as long as lights, materials and the grid's transform stay.
    let inputs = HostInputs::new().grids(&grids);
    let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs)?;
    let points = floor();
    let mut darkest = Vec::new();
    for frame in 0..FRAMES {
        let seconds = frame as f32 * 0.1;
        queue.write_buffer(&time, 0, bytemuck::bytes_of(&[seconds, 0.0, 0.0, 0.0]));
        let mut encoder = device.create_command_encoder(&Default::default());
        simulation.record(&mut encoder);
        prepared.record(&mut encoder)?;
        queue.submit([encoder.finish()]);
        if frame % (FRAMES / 2) == 0 {
            darkest.push(darkest_point(&shares(&device, &queue, &prepared, &lights, &points)?));
        }
    }
    let counters = prepared.counters()?;
    let skipped = counters.skipped.len();
    println!("{} bricks with smoke, {skipped} kinds of voxels skipped", counters.casters);
    let through = shares(&device, &queue, &prepared, &lights, &points)?;
    darkest.push(darkest_point(&through));
    save(&through)?;

    // The same smoke, uploaded by the CPU.
    let voxels = read_voxels(&device, &queue, &smoke)?;
    let at = |v: IVec3| voxels[((v.z as u32 * EDGE + v.y as u32) * EDGE + v.x as u32) as usize];
    let bricks = Brick::of_voxels(IVec3::ZERO, IVec3::splat(EDGE as i32 - 1), at);
    let brick_count = bricks.len() as u64;
    let uploaded = [Grid { bricks, ..grid.clone() }];
    let casters = Casters { grids: &uploaded, ..casters };
    let prepared = shadows.prepare(&casters, &views, &settings)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder)?;
    queue.submit([encoder.finish()]);
    let expected = shares(&device, &queue, &prepared, &lights, &points)?;
    let differences =
        through.iter().zip(&expected).flat_map(|(a, b)| [0, 1, 2].map(|c| (a[c] - b[c]).abs()));
    let apart = differences.fold(0.0, f32::max);
    let shaded = through.iter().filter(|share| share[2] < 0.7).count();
    println!("{shaded} of {} points are in the smoke's shadow", through.len());
    println!("darkest at {darkest:?} in three frames; uploaded, light differs by {apart} at most");
    if apart.is_nan() || apart > TOLERANCE {
        return Err("uploaded, the same smoke casts another shadow".into());
    }
    let moves = darkest.windows(2).all(|two| two[0] != two[1]);
    if shaded < 300 || !moves || counters.casters != brick_count || skipped != 0 {
        return Err("the smoke casts no shadow, stands still, or is not all there".into());
    }
    Ok(())
}

struct Simulation(wgpu::ComputePipeline, wgpu::BindGroup);

impl Simulation {
    fn new(device: &wgpu::Device, smoke: &wgpu::Texture, time: &wgpu::Buffer) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("simulation"),
            source: wgpu::ShaderSource::Wgsl(SIMULATION.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("simulation"),
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let view = smoke.create_view(&Default::default());
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry {
                    binding: 0,
                    resource: wgpu::BindingResource::TextureView(&view),
                },
                wgpu::BindGroupEntry { binding: 1, resource: time.as_entire_binding() },
            ],
        });
        Self(pipeline, bindings)
    }

    fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.0);
        pass.set_bind_group(0, &self.1, &[]);
        pass.dispatch_workgroups(EDGE / 4, EDGE / 4, EDGE / 4);
    }
}

/// Points on the floor.
fn floor() -> Vec<[f32; 3]> {
    let at = |i: u32| (i as f32 + 0.5) / POINTS as f32 * 6.0 - 3.0;
    (0..POINTS * POINTS).map(|i| [at(i % POINTS), 0.0, at(i / POINTS)]).collect()
}

/// Mean share of both lights at each point.
fn shares(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    prepared: &Prepared,
    lights: &[Light],
    points: &[[f32; 3]],
) -> Result<Vec<[f32; 3]>> {
    let positions = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("positions"),
        contents: bytemuck::cast_slice(points),
        usage: BufferUsages::STORAGE,
    });
    let points = PointBuffers { count: POINTS * POINTS, positions: &positions, normals: None };
    let lit = prepared.light_points(lights, &[0, 1], &points)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    lit.record(&mut encoder);
    queue.submit([encoder.finish()]);
    let shares: Vec<[[f32; 3]; 2]> =
        bytemuck::pod_collect_to_vec(&read(device, queue, lit.shares())?);
    Ok(shares.iter().map(|[sun, lamp]| [0, 1, 2].map(|c| 0.5 * (sun[c] + lamp[c]))).collect())
}

fn darkest_point(shares: &[[f32; 3]]) -> usize {
    let blue = |i: &usize| shares[*i][2];
    (0..shares.len()).min_by(|a, b| blue(a).total_cmp(&blue(b))).unwrap_or(0)
}

fn read_voxels(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    texture: &wgpu::Texture,
) -> Result<Vec<f32>> {
    let buffer = device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: u64::from(EDGE * EDGE * EDGE * 4),
        usage: BufferUsages::COPY_SRC | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let layout = wgpu::TexelCopyBufferLayout {
        offset: 0,
        bytes_per_row: Some(EDGE * 4),
        rows_per_image: Some(EDGE),
    };
    let mut encoder = device.create_command_encoder(&Default::default());
    let to = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(texture.as_image_copy(), to, texture.size());
    queue.submit([encoder.finish()]);
    Ok(bytemuck::pod_collect_to_vec(&read(device, queue, &buffer)?))
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

/// The floor from above, as `out/host_grid/floor.png`.
fn save(floor: &[[f32; 3]]) -> Result<()> {
    let folder = Path::new("out/host_grid");
    std::fs::create_dir_all(folder)?;
    let edge = POINTS * SCALE;
    let pixels: Vec<u8> = (0..edge * edge)
        .flat_map(|i| floor[(i / edge / SCALE * POINTS + i % edge / SCALE) as usize])
        .map(|light| (light.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8)
        .collect();
    let path = folder.join("floor.png");
    image::save_buffer(&path, &pixels, edge, edge, image::ExtendedColorType::Rgb8)?;
    println!("{}", path.display());
    Ok(())
}

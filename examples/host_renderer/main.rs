//! A host with a renderer of its own: it rasterizes depth maps, moves smoke on the GPU and shades in a
//! forward pass that evaluates gobo's light look-up at each point. Lights come and go. The picture of frame
//! 20 must equal, byte for byte, the one with smoke and solids uploaded by the CPU.
//!
//! `cargo run --example host_renderer` writes pictures to `out/host_renderer/`
#[path = "../common/kernel.rs"]
mod kernel;
mod output;
mod raster;

use gobo::{
    Bounds, CasterCount, CasterLoader, Casters, HostCasters, HostDepth, HostInputs, Light,
    Material, Particle, Prepared, ShadowSettings, Shadows, Tier, Transfer, Triangle, View,
    glam::{Mat4, Vec2, Vec3, Vec4},
    host::LightBindings,
    wgpu::{self, BufferUsages},
};
use kernel::{Kernel, bind};
use output::{read, read_picture, save};
use raster::{HostLight, MAP, Raster, Vertex, layout_of};
use std::error::Error;

const FRAMES: u32 = 60;
const CAPACITY: u32 = 6000;
/// Particles born per frame.
const BORN: u32 = 150;
/// Frames that are written as pictures.
const PICTURES: [u32; 3] = [5, 20, 50];

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let mut host = Host::open()?;
    let mut frame = host.prepare(&lights_of(0))?;
    let text = frame.prepared.maps().wgsl(1, "gobo_")?;
    let Host { device, queue, smoke, .. } = &host;
    let layout = &frame.bound.layout;
    let raster = Raster::new(device, queue, &host.vertices, smoke, &text, layout);
    host.depths = Some(raster.depths.clone());
    frame = host.prepare(&lights_of(0))?;
    for number in 0..FRAMES {
        if frame.since != since(number) {
            frame = Frame { since: since(number), ..host.prepare(&lights_of(number))? };
        }
        let target = raster.target();
        host.queue.write_buffer(&host.number, 0, bytemuck::bytes_of(&[number, BORN, CAPACITY, 0]));
        let mut encoder = host.device.create_command_encoder(&Default::default());
        host.simulation.record(&mut encoder, CAPACITY);
        raster.draw_depths(&mut encoder, &frame.depth_matrices());
        frame.prepared.record(&mut encoder)?;
        let alive = CAPACITY.min((number + 1) * BORN);
        raster.draw(&mut encoder, &target, &frame.host_lights(), &frame.bound.group, alive);
        host.queue.submit([encoder.finish()]);
        host.device.poll(wgpu::PollType::wait_indefinitely())?;
        if PICTURES.contains(&number) {
            let picture = read_picture(&host.device, &host.queue, &target)?;
            save(number, &picture)?;
            if number == 20 {
                host.compare(&raster, &frame, alive, &picture)?;
            }
        }
    }
    println!("{FRAMES} frames, the lights of which changed {} times", host.prepared_count - 2);
    Ok(())
}

/// First frame with the lights of a frame.
fn since(number: u32) -> u32 {
    [45, 35, 15].into_iter().find(|&start| number >= start).unwrap_or(0)
}

/// Lights of a frame: a permanent sun, a red lamp, a blue one that appears, a red one that vanishes.
fn lights_of(number: u32) -> Vec<Light> {
    let spot = |place: Vec3, color: Vec3| Light { color, ..Light::spot(place, Vec3::NEG_Y, 1.25) };
    let red = spot(Vec3::new(-1.0, 4.6, 0.4), Vec3::new(9.0, 3.5, 2.0));
    let blue = spot(Vec3::new(1.1, 5.2, -0.5), Vec3::new(3.0, 5.0, 11.0));
    let sun = Light { color: Vec3::splat(0.35), ..Light::directional(Vec3::NEG_Y) };
    match since(number) {
        0 => vec![sun, red],
        15 => vec![sun, red, blue],
        35 => vec![sun, blue],
        _ => vec![blue, red],
    }
}

/// Projection of the host's depth maps: gobo's views, but reversed z.
fn host_matrix(view: &View) -> Mat4 {
    let reversed = Mat4::from_cols(Vec4::X, Vec4::Y, Vec4::NEG_Z, Vec4::new(0.0, 0.0, 1.0, 1.0));
    reversed * view.clip_from_world()
}

/// Bindings that are valid as long as the lights stay.
struct Frame {
    lights: Vec<Light>,
    views: Vec<View>,
    prepared: Prepared,
    bound: LightBindings,
    since: u32,
}

impl Frame {
    fn depth_matrices(&self) -> Vec<Mat4> {
        self.views.iter().map(host_matrix).collect()
    }

    fn host_lights(&self) -> Vec<HostLight> {
        let host_light = |light: &Light| {
            let place = match light.kind {
                gobo::LightKind::Directional { direction } => (-direction).extend(0.0),
                gobo::LightKind::Spot { position, .. } | gobo::LightKind::Point { position } => {
                    position.extend(1.0)
                }
            };
            HostLight { place: place.to_array(), color: light.color.extend(1.0).to_array() }
        };
        self.lights.iter().map(host_light).collect()
    }
}

struct Host {
    device: wgpu::Device,
    queue: wgpu::Queue,
    opened: (Tier, wgpu::AdapterInfo),
    shadows: Shadows,
    loader: CasterLoader,
    vertices: Vec<Vertex>,
    smoke: wgpu::Buffer,
    alive: wgpu::Buffer,
    number: wgpu::Buffer,
    simulation: Kernel,
    bindings: wgpu::BindGroup,
    /// Depth maps, once there are lights.
    depths: Option<wgpu::Texture>,
    prepared_count: u32,
}

fn settings() -> ShadowSettings {
    ShadowSettings { size: MAP, ..Default::default() }
}

/// Materials of the smoke and of the solids.
fn materials() -> [Material; 2] {
    [Material::default(), Material { transfer: Transfer::Opaque, ..Material::default() }]
}

/// A floor and two shelves over it, two triangles each. Seen from the lights, none of their edges is within
/// 1/256 texel of a texel's centre: there a rasterizer, which snaps corners, may differ from gobo.
fn solids() -> Vec<Vertex> {
    let quad = |middle: Vec3, half: Vec2, color: [f32; 3]| {
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (-1.0, -1.0), (1.0, 1.0), (1.0, -1.0)].map(
            |(x, z)| {
                let place = (middle + Vec3::new(x * half.x, 0.0, z * half.y)).to_array();
                Vertex { place, normal: [0.0, 1.0, 0.0], color }
            },
        )
    };
    [
        quad(Vec3::ZERO, Vec2::splat(4.0), [0.8, 0.78, 0.75]),
        quad(Vec3::new(-1.2, 0.7, 0.5), Vec2::new(0.51, 0.37), [0.7, 0.6, 0.3]),
        quad(Vec3::new(1.13, 1.2, -0.4), Vec2::new(0.437, 0.527), [0.4, 0.7, 0.5]),
    ]
    .concat()
}

impl Host {
    fn open() -> Result<Self> {
        let settings = settings();
        let adapter = wgpu::Instance::default().request_adapter(&Default::default());
        let adapter = pollster::block_on(adapter)?;
        let tier = Tier::of(&adapter);
        let (device, queue) =
            pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
                required_features: settings.features(tier),
                required_limits: settings.limits(tier, MAP),
                ..Default::default()
            }))?;
        let buffer = |size, usage| {
            let (label, mapped_at_creation) = (None, false);
            device.create_buffer(&wgpu::BufferDescriptor { label, size, usage, mapped_at_creation })
        };
        let smoke =
            buffer(u64::from(CAPACITY) * 32, BufferUsages::STORAGE | BufferUsages::COPY_SRC);
        let alive = buffer(4, BufferUsages::STORAGE);
        let number = buffer(16, BufferUsages::UNIFORM | BufferUsages::COPY_DST);
        let text = [include_str!("../common/chance.wgsl"), include_str!("smoke.wgsl")].concat();
        let simulation = Kernel::new(&device, text, &[&smoke, &alive, &number]);
        let layout = layout_of(&device, wgpu::BufferBindingType::Storage { read_only: true });
        let bindings = bind(&device, &layout, &[&smoke]);
        let shadows = Shadows::on_tier(&device, &queue, &adapter.get_info(), tier)?;
        let loader = shadows.caster_loader("load.wgsl", include_str!("load.wgsl"), &layout)?;
        let (vertices, depths, prepared_count) = (solids(), None, 0);
        Ok(Self {
            device,
            queue,
            opened: (tier, adapter.get_info()),
            shadows,
            loader,
            vertices,
            smoke,
            alive,
            number,
            simulation,
            bindings,
            depths,
            prepared_count,
        })
    }

    fn views(lights: &[Light]) -> Result<Vec<View>> {
        let bounds = Bounds { min: Vec3::new(-4.0, 0.0, -4.0), max: Vec3::new(4.0, 4.0, 4.0) };
        let views =
            (0..).zip(lights).map(|(i, light)| gobo::light_views(i, light, MAP, None, &bounds));
        Ok(views.collect::<std::result::Result<Vec<_>, _>>()?.concat())
    }

    /// Prepares the host's smoke and depth maps, for these lights.
    fn prepare(&mut self, lights: &[Light]) -> Result<Frame> {
        let views = Self::views(lights)?;
        let count = CasterCount::Indirect { buffer: &self.alive, offset: 0, capacity: CAPACITY };
        let sets = [HostCasters::new(&self.loader, &self.bindings, count, &[0]).least_alpha(0.01)];
        let depth = |(index, texture)| {
            let columns = host_matrix(&views[index]).to_cols_array_2d();
            HostDepth::new(index, texture).layer(index as u32).clip_from_world(columns)
        };
        let maps =
            self.depths.iter().flat_map(|texture| (0..views.len()).map(move |i| (i, texture)));
        let depths: Vec<_> = maps.map(depth).collect();
        let inputs = HostInputs::new().casters(&sets).depths(&depths);
        let materials = materials();
        let casters = Casters { materials: &materials, ..Casters::default() };
        let prepared = self.shadows.prepare_with(&casters, &views, &settings(), &inputs)?;
        let chosen: Vec<_> = (0..lights.len()).collect();
        let bound = prepared.bind_lights(lights, &chosen)?;
        self.prepared_count += 1;
        Ok(Frame { lights: lights.to_vec(), views, prepared, bound, since: 0 })
    }

    /// Compares the picture with that of uploaded casters, and with that without any.
    fn compare(&self, raster: &Raster, frame: &Frame, alive: u32, picture: &[u8]) -> Result<()> {
        let records: Vec<[f32; 8]> =
            bytemuck::pod_collect_to_vec(&read(&self.device, &self.queue, &self.smoke)?);
        let particle = |(id, r): (u32, &[f32; 8])| Particle {
            center: Vec3::new(r[0], r[1], r[2]),
            radius: r[3],
            color: Vec4::new(r[4], r[5], r[6], r[7]),
            id,
            ..Particle::default()
        };
        let particles: Vec<_> = (0..alive).zip(&records).map(particle).collect();
        let triangles: Vec<_> = self
            .vertices
            .chunks_exact(3)
            .map(|corners| Triangle {
                normals: [Vec3::Y; 3],
                ..Triangle::flat([0, 1, 2].map(|i| corners[i].place), 1)
            })
            .collect();
        let materials = materials();
        let none = Casters { materials: &materials, ..Casters::default() };
        let all = Casters { particles: &particles, triangles: &triangles, in_order: true, ..none };
        let mut differing = [all, none].into_iter().map(|casters| {
            let (tier, info) = &self.opened;
            let mut shadows = Shadows::on_tier(&self.device, &self.queue, info, *tier)?;
            let prepared = shadows.prepare(&casters, &frame.views, &settings())?;
            let chosen: Vec<_> = (0..frame.lights.len()).collect();
            let bound = prepared.bind_lights(&frame.lights, &chosen)?;
            let target = raster.target();
            let mut encoder = self.device.create_command_encoder(&Default::default());
            prepared.record(&mut encoder)?;
            raster.draw(&mut encoder, &target, &frame.host_lights(), &bound.group, alive);
            self.queue.submit([encoder.finish()]);
            let other = read_picture(&self.device, &self.queue, &target)?;
            let pixels = picture.chunks_exact(4).zip(other.chunks_exact(4));
            Ok::<_, Box<dyn Error>>(pixels.filter(|(a, b)| a != b).count())
        });
        let (Some(uploaded), Some(unshadowed)) = (differing.next(), differing.next()) else {
            return Err("two pictures were asked for".into());
        };
        let (uploaded, unshadowed) = (uploaded?, unshadowed?);
        println!("frame 20: {uploaded} pixels differ from the CPU's, {unshadowed} from no shadows");
        if uploaded > 0 || unshadowed < 4000 {
            return Err("frame 20 is not that of the CPU, or has no shadows".into());
        }
        Ok(())
    }
}

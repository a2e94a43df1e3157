//! Inputs of a host on the device: casters in its buffers, and depth maps.
mod border;
mod casters;
mod clip;
mod depths;
mod emitters;
mod gaussian_records;
mod gaussians;
mod grids;
mod kernels;
mod layouts;
mod levels;
mod moving;
mod numbers;
mod profiler;
mod rendered;
mod splat_light;
mod statistics;
mod submissions;
mod warm_up;
mod wrong;

use crate::common::scenes::Chance;
use gobo::{
    Bounds, CasterCount, CasterLoader, Casters, HostCasters, HostInputs, Light, Material, Particle,
    Prepared, ShadowSettings, Shadows, View,
    glam::{Vec3, Vec4},
    gpu::Gpu,
    light_views,
    wgpu::{self, BufferUsages},
};

/// An unusual layout: positions in one buffer, colours as half floats and the rest in another.
pub(super) const WGSL: &str = "
// Names that the library has, too.
struct Chunk { place: vec4<f32>, }
const ROW: u32 = 3u;
@group(1) @binding(4) var<storage, read> casters: array<Chunk>;
@group(1) @binding(1) var<storage, read> looks: array<array<u32, ROW + 4u>>;

fn is_usable(row: u32) -> vec4<f32> {
    return bitcast<vec4<f32>>(vec4(looks[row][0], looks[row][1], looks[row][2], looks[row][3]));
}

fn load_caster(index: u32) -> Caster {
    let place = casters[index].place;
    let look = looks[index];
    return Caster(place.xyz, place.w, is_usable(index), bitcast<f32>(look[4]), look[5], look[6]);
}
";

/// Particles in the host's buffers.
pub(super) struct HostBuffers {
    pub(super) layout: wgpu::BindGroupLayout,
    pub(super) bindings: wgpu::BindGroup,
    places: wgpu::Buffer,
    looks: wgpu::Buffer,
}

fn places(particles: &[Particle]) -> Vec<[f32; 4]> {
    particles.iter().map(|p| p.center.extend(p.radius).to_array()).collect()
}

fn looks(particles: &[Particle]) -> Vec<[u32; 7]> {
    let look = |p: &Particle| {
        let [r, g, b, a] = p.color.to_array().map(f32::to_bits);
        [r, g, b, a, p.rotation.to_bits(), p.material, p.id]
    };
    particles.iter().map(look).collect()
}

impl HostBuffers {
    pub(super) fn new(gpu: &Gpu, particles: &[Particle]) -> Self {
        // A buffer cannot be empty.
        let or_one = |particles: &[Particle]| {
            if particles.is_empty() { vec![Particle::default()] } else { particles.to_vec() }
        };
        let particles = or_one(particles);
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_DST;
        let places = gpu.upload("places", &places(&particles), usage);
        let looks = gpu.upload("looks", &looks(&particles), usage);
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
        let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: None,
            entries: &[entry(1), entry(4)],
        });
        let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &layout,
            entries: &[(1, &looks), (4, &places)].map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            }),
        });
        Self { layout, bindings, places, looks }
    }

    pub(super) fn write(&self, gpu: &Gpu, particles: &[Particle]) {
        gpu.queue.write_buffer(&self.places, 0, bytemuck::cast_slice(&places(particles)));
        gpu.queue.write_buffer(&self.looks, 0, bytemuck::cast_slice(&looks(particles)));
    }

    pub(super) fn loader(&self, shadows: &Shadows) -> CasterLoader {
        shadows.caster_loader("host.wgsl", WGSL, &self.layout).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// Layout and bind group of read-only buffers, from binding 0 on.
pub(super) fn bound(
    gpu: &Gpu,
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
    let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &entries,
    });
    let bound = (0..).zip(buffers).map(|(binding, buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    });
    let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &layout,
        entries: &bound.collect::<Vec<_>>(),
    });
    (layout, bindings)
}

/// Shadows on the tier's device; tiny casters as on a GPU.
pub(super) fn shadows(gpu: &Gpu) -> Shadows {
    let mut shadows = crate::common::shadows(gpu);
    shadows.configure(|config| config.toggles.scatter_tiny = true);
    shadows
}

/// A lamp amid the casters, all whose faces see some, and a spot.
pub(super) fn views() -> Vec<View> {
    let bounds = Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let lights = [
        Light::point(Vec3::new(0.3, 0.2, -0.1)),
        Light::spot(Vec3::new(3.0, 4.0, 2.5), Vec3::new(-3.0, -4.0, -2.5), 0.5),
        Light::directional(Vec3::new(0.2, -1.0, 0.3)),
    ];
    let views = (0..).zip(&lights).map(|(i, light)| light_views(i, light, 64, None, &bounds));
    views.collect::<Result<Vec<_>, _>>().unwrap().concat()
}

/// Particles of two materials in a ball of radius 2 [m], sorted in space, so that most views can cull most
/// groups.
pub(super) fn particles(count: usize, seed: u64) -> Vec<Particle> {
    let mut chance = Chance::new(seed);
    let particle = |id| {
        let center = loop {
            let p = chance.vec3(-2.0, 2.0);
            if p.length() <= 2.0 {
                break p;
            }
        };
        Particle {
            center,
            radius: 0.002 * 200_f32.powf(chance.unit()),
            color: chance.vec3(0.0, 1.0).extend(chance.within(0.01, 0.8)),
            rotation: chance.within(-7.0, 7.0),
            material: chance.below(2) as u32,
            id,
        }
    };
    let mut particles: Vec<_> = (0..count as u32).map(particle).collect();
    particles.sort_by_key(|particle| particle.center.floor().as_ivec3().to_array());
    particles
}

pub(super) fn materials() -> Vec<Material> {
    use gobo::{Shape, Transfer};
    let tint = Vec4::new(0.9, 0.7, 0.8, 0.9);
    vec![
        Material { tint, ..Material::default() },
        Material { shape: Shape::Quad, transfer: Transfer::Smoke, ..Material::default() },
        Material { transfer: Transfer::Opaque, ..Material::default() },
        Material { transfer: Transfer::Over, ..Material::default() },
        Material { transfer: Transfer::Gain, ..Material::default() },
        Material { transfer: Transfer::None, ..Material::default() },
    ]
}

/// The bits of all texels of all maps.
#[derive(Debug, PartialEq)]
pub(super) struct Bits {
    pub(super) filters: Vec<[u16; 4]>,
    nearests: Vec<u32>,
    pub(super) opaques: Vec<u32>,
    curves: Vec<[[u32; 2]; 2]>,
}

impl Bits {
    /// Share of texels whose light differs by more than two steps of halves.
    pub(super) fn share_apart(&self, other: &Self) -> f64 {
        let pairs = self.filters.iter().zip(&other.filters);
        let is_apart = |(a, b): &(&[u16; 4], &[u16; 4])| (0..3).any(|c| a[c].abs_diff(b[c]) > 2);
        pairs.filter(is_apart).count() as f64 / self.filters.len() as f64
    }
}

/// Fails with the list of differences.
pub(super) fn assert_equal(found: &Bits, expected: &Bits, what: &str) {
    fn apart<T: Copy + PartialEq>(found: &[T], expected: &[T]) -> (usize, Option<(usize, T, T)>) {
        assert_eq!(found.len(), expected.len());
        let both = found.iter().zip(expected).enumerate();
        let mut apart = both.filter(|(_, (a, b))| a != b).map(|(texel, (&a, &b))| (texel, a, b));
        let first = apart.next();
        (first.map_or(0, |_| 1 + apart.count()), first)
    }
    let filters = apart(&found.filters, &expected.filters);
    let nearests = apart(&found.nearests, &expected.nearests);
    let opaques = apart(&found.opaques, &expected.opaques);
    let curves = apart(&found.curves, &expected.curves);
    assert!(
        found == expected,
        "{what}: texels apart, and the first: filters {filters:x?}, nearest depths {nearests:x?}, \
         opaque ones {opaques:x?}, curves {curves:x?}"
    );
}

pub(super) fn submit(gpu: &Gpu, prepared: &Prepared) -> Bits {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
    bits(gpu, prepared)
}

/// Its maps, after what was submitted.
pub(super) fn bits(gpu: &Gpu, prepared: &Prepared) -> Bits {
    let maps = prepared.maps();
    // Unused nodes are zeros where no caster ever was.
    let known = |node: [u32; 2]| if node[0] >> 16 == 0 { [0; 2] } else { node };
    let pairs: Vec<[[u32; 2]; 2]> = gpu.read_texture(&maps.curves);
    let bits = Bits {
        filters: gpu.read_texture(&maps.filters),
        nearests: gpu.read_texture(&maps.nearests),
        opaques: gpu.read_texture(&maps.opaques),
        curves: pairs.into_iter().map(|pair| pair.map(known)).collect(),
    };
    gpu.check().unwrap();
    bits
}

/// An indirect count, at most `capacity`.
pub(super) fn counted<'a>(buffer: &'a wgpu::Buffer, capacity: u32) -> CasterCount<'a> {
    CasterCount::Indirect { buffer, offset: 8, capacity }
}

pub(super) fn count_buffer(gpu: &Gpu, count: u32) -> wgpu::Buffer {
    gpu.upload("count", &[77, 88, count, 99], BufferUsages::STORAGE | BufferUsages::COPY_DST)
}

/// Maps of uploaded casters, in the given order.
pub(super) fn uploaded(
    gpu: &Gpu,
    shadows: &mut Shadows,
    particles: &[Particle],
    settings: &ShadowSettings,
) -> Bits {
    let materials = materials();
    let casters =
        Casters { particles, materials: &materials, in_order: true, ..Casters::default() };
    submit(gpu, &shadows.prepare(&casters, &views(), settings).unwrap())
}

/// Maps of host casters, in addition to the uploaded `others`.
pub(super) fn on_device(
    shadows: &mut Shadows,
    others: &[Particle],
    sets: &[HostCasters<'_>],
    settings: &ShadowSettings,
) -> Prepared {
    let materials = materials();
    let casters =
        Casters { particles: others, materials: &materials, in_order: true, ..Casters::default() };
    let inputs = HostInputs::new().casters(sets);
    shadows.prepare_with(&casters, &views(), settings, &inputs).unwrap()
}

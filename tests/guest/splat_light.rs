//! A host's kernel places the points at which its splats are lit: each splat ignores itself, and no other.
use super::{ShadowSettings, Vec3, submit};
use crate::common::{TIERS, gpu, scenes::Chance};
use gobo::{
    Bounds, Casters, Gaussian, Light, Material, Prepared, Receiver, Shadows, Shape,
    glam::Quat,
    gpu::Gpu,
    host::{PointBuffers, SPLAT_POINT_WGSL},
    light_views,
    wgpu::{self, BufferUsages},
};

/// Rounding of the sum of the filter's weights.
const WEIGHTS: f32 = 5e-7;

const KERNEL: &str = "
struct Splat { center: vec3<f32>, opacity: f32, rotation: vec4<f32>, sigma: vec3<f32>, pad: u32 }
@group(0) @binding(0) var<storage, read> splats: array<Splat>;
@group(0) @binding(1) var<storage, read_write> points: array<f32>;
@group(0) @binding(2) var<uniform> light: SplatLight;

@compute @workgroup_size(64)
fn place_points(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&splats) { return; }
    let own = splats[id.x];
    let at = splat_point(light, own.center, own.rotation, own.sigma, own.opacity);
    points[3u * id.x] = at.x;
    points[3u * id.x + 1u] = at.y;
    points[3u * id.x + 2u] = at.z;
}
";

fn lights() -> [Light; 3] {
    [
        Light::directional(Vec3::new(0.2, -1.0, 0.3)),
        Light::spot(Vec3::new(3.0, 4.0, 2.5), Vec3::new(-3.0, -4.0, -2.5), 0.5),
        Light::point(Vec3::new(0.3, 2.2, -0.1)),
    ]
}

fn prepared(gpu: &Gpu, shadows: &mut Shadows, gaussians: &[Gaussian]) -> Prepared {
    let bounds = Bounds { min: Vec3::splat(-1.5), max: Vec3::splat(1.5) };
    let lights = lights();
    let views = (0..).zip(&lights).map(|(i, light)| light_views(i, light, 128, None, &bounds));
    let views = views.collect::<Result<Vec<_>, _>>().unwrap().concat();
    let materials = [Material { shape: Shape::Gaussian, ..Material::default() }];
    let casters = Casters { gaussians, materials: &materials, ..Casters::default() };
    let settings =
        ShadowSettings { receiver: Receiver::Curve, nodes: 8, ..ShadowSettings::default() };
    let prepared = shadows.prepare(&casters, &views, &settings).unwrap();
    submit(gpu, &prepared);
    prepared
}

/// Share of a light that reaches each splat, by the host's kernel.
fn shares(gpu: &Gpu, prepared: &Prepared, light: usize, splats: &[Gaussian]) -> Vec<[f32; 3]> {
    let records: Vec<[f32; 12]> = splats
        .iter()
        .map(|g| {
            let ([x, y, z, w], s, c) = (g.rotation.to_array(), g.sigma, g.center);
            [c.x, c.y, c.z, g.opacity, x, y, z, w, s.x, s.y, s.z, 0.0]
        })
        .collect();
    let of_light = prepared.splat_light(&lights(), light).unwrap();
    let positions = gpu.storage::<[f32; 3]>("positions", splats.len());
    let buffers = [
        gpu.upload("splats", &records, BufferUsages::STORAGE),
        positions.clone(),
        gpu.upload("light", &[of_light], BufferUsages::UNIFORM),
    ];
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(format!("{SPLAT_POINT_WGSL}{KERNEL}").into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    let entries = (0..).zip(&buffers).map(|(binding, buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    });
    let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries.collect::<Vec<_>>(),
    });
    let count = splats.len() as u32;
    let points = PointBuffers { count, positions: &positions, normals: None };
    let lit = prepared.light_points(&lights(), &[light], &points).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(count.div_ceil(64), 1, 1);
    }
    lit.record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    let shares: Vec<[f32; 3]> = gpu.read(lit.shares());
    gpu.check().unwrap();
    shares
}

fn is_all(share: [f32; 3]) -> bool {
    share.into_iter().all(|share| (share - 1.0).abs() <= WEIGHTS)
}

/// Needles, pancakes and balls, seen from the side, lengthwise and at an angle, one at a time.
#[test]
fn a_lone_splat_gets_all_light() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let mut shadows = super::shadows(&gpu);
        let mut chance = Chance::new(4);
        let sun = Vec3::new(0.2, -1.0, 0.3).normalize();
        for n in 0..24 {
            let long = 0.02 * 20_f32.powf(chance.unit());
            let thin = long * [1.0, 0.1, 0.004][n % 3];
            let axis = chance.vec3(-1.0, 1.0).normalize_or(Vec3::X);
            let rotation = match n % 4 {
                0 => Quat::from_rotation_arc(Vec3::X, sun),
                1 => Quat::from_rotation_arc(Vec3::Z, sun),
                _ => Quat::from_axis_angle(axis, chance.within(0.0, 3.0)),
            };
            let splat = Gaussian {
                center: chance.vec3(-0.9, 0.9),
                rotation,
                sigma: [Vec3::new(long, thin, thin), Vec3::new(long, long, thin)][n / 3 % 2],
                color: Vec3::new(0.8, 0.5, 0.1),
                opacity: chance.within(0.3, 1.0),
                ..Gaussian::default()
            };
            let prepared = prepared(&gpu, &mut shadows, &[splat]);
            for light in 0..lights().len() {
                let shares = shares(&gpu, &prepared, light, &[splat]);
                assert!(is_all(shares[0]), "{tier} light {light} {splat:?}: {shares:?}");
            }
        }
    }
}

/// The splat behind gets the light that the one in front transmits: 1 - 0.6 (1 - c) in its middle.
#[test]
fn a_splat_is_tinted_by_those_in_front() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = super::shadows(&gpu);
    let color = Vec3::new(0.9, 0.4, 0.1);
    let expected = 1.0 - 0.6 * (1.0 - color);
    for (light, of) in lights().iter().enumerate() {
        let ray = match of.kind {
            gobo::LightKind::Directional { direction } => direction.normalize(),
            gobo::LightKind::Spot { position, .. } | gobo::LightKind::Point { position } => {
                -position.normalize()
            }
        };
        let front =
            Gaussian { sigma: Vec3::splat(0.15), color, opacity: 0.6, ..Gaussian::default() };
        let behind = Gaussian { center: ray * 0.8, sigma: Vec3::splat(0.03), ..front };
        let all = [behind, front];
        let prepared = prepared(&gpu, &mut shadows, &all);
        let [found, alone] = shares(&gpu, &prepared, light, &all)[..] else { unreachable!() };
        let apart = (Vec3::from_array(found) - expected).abs().max_element();
        // Texels of the filter are off the middle.
        assert!(apart < 0.02, "{light}: {found:?} {expected}");
        assert!(is_all(alone), "{light}: {alone:?}");
    }
    let prepared = prepared(&gpu, &mut shadows, &[]);
    assert!(prepared.splat_light(&lights(), 3).is_err());
}

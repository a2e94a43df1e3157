//! Light look-up in a shader of the host.
use super::light_points::{BLUE, RED, layers, prepared, through};
use crate::common::{TIERS, gpu};
use gobo::{
    Bounds, Casters, Error, HostInputs, Light, LightKind, Prepared, Receiver, ShadowSettings,
    glam::Vec3,
    gpu::Gpu,
    host::{Input, LightBindings, PointBuffers},
    light_views,
    model::Source,
    wgpu,
};
use gobo_scene::Scene;
use wgpu::BufferUsages;

/// A host shader with names that the library also has.
const HOST: &str = r#"
struct Light { light: f32 }
struct GpuView { size: f32 }
const NODES: u32 = 3u;
@group(0) @binding(0) var<storage, read> positions: array<f32>;
@group(0) @binding(1) var<storage, read_write> shares: array<f32>;
var<private> receives: u32;
fn shadow(light: Light) -> f32 { return light.light; }
fn receive(view: GpuView) -> f32 { return view.size; }

@compute @workgroup_size(4)
fn look(@builtin(global_invocation_id) id: vec3<u32>) {
    let at = 3u * id.x;
    let position = vec3(positions[at], positions[at + 1u], positions[at + 2u]);
    let light = shadow(Light(0.0)) + receive(GpuView(0.0)) + f32(NODES - 3u);
    let share = my_light_at(1u, position) + my_light_through(0u, position, vec3(0.0)) + light;
    shares[at] = share.r;
    shares[at + 1u] = share.g;
    shares[at + 2u] = share.b;
}
"#;

/// Sums of the shares of both lights at four positions, by the host's shader and by the stage.
fn looked_up(
    gpu: &Gpu,
    prepared: &Prepared,
    lights: &[Light],
    text: &str,
    bound: &LightBindings,
) -> [Vec<Vec3>; 2] {
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl((text.to_owned() + HOST).into()),
    });
    let own = |binding, read_only| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Storage { read_only },
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    };
    let own = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[own(0, true), own(1, false)],
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: &[Some(&own), None, Some(&bound.layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: Some(&layout),
        module: &module,
        entry_point: Some("look"),
        compilation_options: Default::default(),
        cache: None,
    });
    let vectors = [[0.0_f32, 3.0, 0.1], [0.1, 1.5, 0.1], [0.0, 0.5, 0.2], [-0.3, 0.1, 0.1]];
    let positions = gpu.upload("positions", &vectors, BufferUsages::STORAGE);
    let shares = gpu.storage::<[f32; 3]>("shares", 4);
    let buffers = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &own,
        entries: &[(0, &positions), (1, &shares)].map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        }),
    });
    let points = PointBuffers { count: 4, positions: &positions, normals: None };
    let lit = prepared.light_points(lights, &[0, 1], &points).unwrap();
    let mut encoder = device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    bound.record(&mut encoder);
    lit.record(&mut encoder);
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &buffers, &[]);
    pass.set_bind_group(2, &bound.group, &[]);
    pass.dispatch_workgroups(1, 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    let shares: Vec<[f32; 3]> = gpu.read(&shares);
    let expected: Vec<[f32; 3]> = gpu.read(lit.shares());
    assert!(gpu.check().is_ok());
    let sums = expected.chunks(2).map(|both| Vec3::from(both[0]) + Vec3::from(both[1]));
    [shares.into_iter().map(Vec3::from).collect(), sums.collect()]
}

fn assert_alike([found, expected]: &[Vec<Vec3>; 2]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs().max_element() < 1e-6, "{found} {expected}");
    }
}

#[test]
fn a_shader_of_the_hosts_sees_what_the_stage_sees() {
    let gpu = gpu(TIERS[0]);
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let (prepared, lights) = prepared(&gpu, receiver);
        let text = prepared.maps().wgsl(2, "my_").unwrap();
        let bound = prepared.bind_lights(&lights, &[0, 1]).unwrap();
        let sums = looked_up(&gpu, &prepared, &lights, &text, &bound);
        assert_alike(&sums);
        let below = 2.0 * through(RED) * through(BLUE);
        assert!((sums[0][3] - below).abs().max_element() < 2e-3, "{sums:?}");
    }
}

/// Frame after frame in the same bind group, and in one more for a host that binds twice.
#[test]
fn bindings_have_the_lights_of_their_frame() {
    let gpu = gpu(TIERS[0]);
    let scene = layers(Receiver::Nearest);
    let mut shadows = crate::common::shadows(&gpu);
    let Scene { particles, materials, .. } = &scene;
    let casters = Casters { particles, materials, ..Casters::default() };
    let settings = ShadowSettings::default();
    let bounds = Bounds { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) };
    let (mut groups, mut shares) = (Vec::new(), Vec::new());
    for frame in 0..3 {
        let mut lights = scene.lights.clone();
        let position = Vec3::new(0.4 * frame as f32, 4.0, 0.0);
        lights[1].kind = LightKind::Point { position };
        lights[1].source = Some(Source::Sphere { radius: 0.2 + 0.1 * frame as f32 });
        let views: Vec<_> = (0..)
            .zip(&lights)
            .flat_map(|(index, light)| light_views(index, light, 64, None, &bounds).unwrap())
            .collect();
        let inputs = HostInputs::new().area_lights();
        let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs).unwrap();
        let text = prepared.maps().area_wgsl(2, "my_").unwrap();
        let dimmed = [Light { source: None, ..lights[0].clone() }, lights[1].clone()];
        let bound = prepared.bind_area_lights(&lights, &[0, 1]).unwrap();
        let other = prepared.bind_area_lights(&dimmed, &[1, 0]).unwrap();
        assert!(bound.group != other.group, "both are alive");
        let sums = looked_up(&gpu, &prepared, &lights, &text, &bound);
        assert_alike(&sums);
        groups.push(bound.group);
        shares.push(sums[0].clone());
    }
    assert!(groups[0] == groups[1] && groups[1] == groups[2]);
    assert!(shares[0] != shares[1] && shares[1] != shares[2], "the lamp moves");
}

#[test]
fn a_prefix_is_the_beginning_of_a_name() {
    let gpu = gpu(TIERS[0]);
    let (prepared, _) = prepared(&gpu, Receiver::Nearest);
    for bad in ["9", "__x", "a-b", "a ", "_", "é"] {
        let error = prepared.maps().wgsl(0, bad).unwrap_err();
        assert!(matches!(error, Error::Invalid { what: Input::Prefix, .. }), "{bad}: {error}");
    }
    for good in ["", "gobo_", "G9"] {
        let text = prepared.maps().wgsl(1, good).unwrap();
        let module = naga::front::wgsl::parse_str(&text).unwrap();
        assert!(module.overrides.is_empty(), "a host's shader has its own overrides");
        let is_ours = |name: &Option<String>| name.as_deref().is_some_and(|n| n.starts_with(good));
        assert!(module.functions.iter().all(|(_, function)| is_ours(&function.name)));
        assert!(module.global_variables.iter().all(|(_, global)| is_ours(&global.name)));
        assert!(module.constants.iter().all(|(_, constant)| is_ours(&constant.name)));
        let structs = module.types.iter().filter(|(_, ty)| ty.name.is_some());
        assert!(structs.map(|(_, ty)| &ty.name).all(is_ours));
    }
}

//! Light look-up in a shader of the host.
use super::light_points::{BLUE, RED, prepared, through};
use crate::common::{TIERS, gpu};
use gobo::{
    Error, Receiver,
    glam::Vec3,
    host::{Input, PointBuffers},
    wgpu,
};
use wgpu::BufferUsages;

/// A host shader with names that the library has, too.
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

#[test]
fn a_shader_of_the_hosts_sees_what_the_stage_sees() {
    let gpu = gpu(TIERS[0]);
    let device = &gpu.device;
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let (prepared, lights) = prepared(&gpu, receiver);
        let text = prepared.maps().wgsl(2, "my_").unwrap();
        let bound = prepared.bind_lights(&lights, &[0, 1]).unwrap();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl((text + HOST).into()),
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
            entries: &[(0, &positions), (1, &shares)].map(|(binding, buffer)| {
                wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
            }),
        });
        let points = PointBuffers { count: 4, positions: &positions, normals: None };
        let lit = prepared.light_points(&lights, &[0, 1], &points).unwrap();
        let mut encoder = device.create_command_encoder(&Default::default());
        prepared.record(&mut encoder).unwrap();
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
        for (i, share) in shares.iter().enumerate() {
            let sum = Vec3::from(expected[2 * i]) + Vec3::from(expected[2 * i + 1]);
            assert!(
                (Vec3::from(*share) - sum).abs().max_element() < 1e-6,
                "{shares:?} {expected:?}"
            );
        }
        let below = 2.0 * through(RED) * through(BLUE);
        assert!((Vec3::from(shares[3]) - below).abs().max_element() < 2e-3, "{shares:?}");
        assert!(gpu.check().is_ok());
    }
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

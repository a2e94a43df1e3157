//! Strands on devices whose divisions are not exact: WGSL allows 2.5 units in the last place.
use crate::common::{TIERS, gpu, wgsl_files};
use gobo::{gpu::Library, wgpu};

const COUNT: usize = 24;
/// Share of the light that a diameter absorbs.
const ALPHA: f64 = 0.5;

/// A tip of 30 cm, 20 cm thick, that points away from the light: rays within its own angle never leave its
/// cone.
const ROOT: &str = "
import package::hit::capsule::{CapsuleSetup, capsule_way, way_absorbed};
import package::records::record::CasterRecord;
import package::records::view::GpuView;

@group(0) @binding(0) var<storage, read_write> absorbed: array<f32>;

@compute @workgroup_size(1)
fn absorb(@builtin(workgroup_id) texel: vec3<u32>) {
    var view: GpuView;
    view.size = vec2(128.0);
    view.scale = 128.0;
    view.perspective = 1.0;
    view.near = 0.01;
    view.far = 10.0;
    let along = vec3(0.0, 0.0, 1.0);
    let least = vec2(0.7071 / view.scale);
    var record: CasterRecord;
    let tip = CapsuleSetup(along, along, 0.3, along, along, vec2(0.1, -0.1 / 0.3), least, record);
    let way = capsule_way(view, tip, vec2(65.0 + f32(texel.x) * 0.5, 64.0), 1.0);
    absorbed[texel.x] = way_absorbed(way, vec3(log(2.0))).x;
}";

/// Absorbed share at `COUNT` texels, with each quotient multiplied by `error`.
fn absorbed(error: &str) -> Vec<f32> {
    let mut files = wgsl_files();
    let capsule = files.iter_mut().find(|(path, _)| path == "hit/capsule.wgsl").expect("a file");
    capsule.1 = capsule.1.replace(" / ", &format!(" * {error} / "));
    files.push(("absorb.wgsl".to_owned(), ROOT.to_owned()));
    let leak = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let files: Vec<_> = files.into_iter().map(|(path, text)| (leak(path), leak(text))).collect();
    let linked = Library::new(&files).unwrap().link("absorb.wgsl", "absorb", &[]).unwrap();
    let gpu = gpu(TIERS[0]);
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(linked.wgsl.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("absorb"),
        compilation_options: Default::default(),
        cache: None,
    });
    let absorbed = gpu.storage::<f32>("absorbed", COUNT);
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: absorbed.as_entire_binding() }],
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let mut pass = encoder.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(COUNT as u32, 1, 1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
    gpu.read(&absorbed)
}

/// The transmittance is `(1 - alpha) ^ s`, where `s` is the integral of `dl / (2 r)` from the plane at 1 m to
/// the cone.
#[test]
fn a_tip_seen_from_its_end_absorbs_whatever_divisions_round() {
    for error in ["1.0", "0.9999998", "1.0000003"] {
        for (i, found) in absorbed(error).into_iter().enumerate() {
            let slope = (1.0 + 0.5 * i as f64) / 128.0;
            // The radius is (1.3 m - z) / 3.
            let leaves = 1.3 / (1.0 + 3.0 * slope);
            let inside = 1.5 * (1.0 + slope * slope).sqrt() * (0.3 / (1.3 - leaves)).ln();
            let expected = if leaves > 1.0 { 1.0 - (1.0 - ALPHA).powf(inside) } else { 0.0 };
            let wrong = (f64::from(found) - expected).abs();
            assert!(wrong < 1e-3, "{error}, texel {i}: {found} instead of {expected}");
        }
    }
}

//! The light that reaches each packed splat, in the order of the host's own buffer.
use crate::{COUNT, Result, read};
use gobo::{
    Light, Prepared,
    host::{PointBuffers, SPLAT_POINT_WGSL},
    wgpu::{self, BufferUsages, util::DeviceExt as _},
};

/// Shares of light `index`, rgb, splat by splat.
pub(crate) fn splat_shares(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    prepared: &Prepared,
    (lights, index): (&[Light], usize),
    splats: &wgpu::Buffer,
) -> Result<Vec<[f32; 3]>> {
    let positions = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("places"),
        size: u64::from(COUNT) * 12,
        usage: BufferUsages::STORAGE,
        mapped_at_creation: false,
    });
    let light = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("light"),
        contents: bytemuck::bytes_of(&prepared.splat_light(lights, index)?),
        usage: BufferUsages::UNIFORM,
    });
    let text = format!("{SPLAT_POINT_WGSL}{}", include_str!("places.wgsl"));
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("places"),
        source: wgpu::ShaderSource::Wgsl(text.into()),
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("places"),
        layout: None,
        module: &module,
        entry_point: None,
        compilation_options: Default::default(),
        cache: None,
    });
    let bound = (0..).zip([splats, &positions, &light]).map(|(binding, buffer)| {
        wgpu::BindGroupEntry { binding, resource: buffer.as_entire_binding() }
    });
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &bound.collect::<Vec<_>>(),
    });
    let points = PointBuffers { count: COUNT, positions: &positions, normals: None };
    let lit = prepared.light_points(lights, &[index], &points)?;
    let mut encoder = device.create_command_encoder(&Default::default());
    {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &bindings, &[]);
        pass.dispatch_workgroups(COUNT.div_ceil(64), 1, 1);
    }
    lit.record(&mut encoder);
    queue.submit([encoder.finish()]);
    Ok(bytemuck::pod_collect_to_vec(&read(device, queue, lit.shares())?))
}

//! Kernels of the host.
use gobo::wgpu;

/// A kernel of 64 invocations a workgroup, with its buffers.
pub(crate) struct Kernel(wgpu::ComputePipeline, wgpu::BindGroup);

impl Kernel {
    /// `buffers`: of group 0, from binding 0 on.
    pub(crate) fn new(device: &wgpu::Device, text: String, buffers: &[&wgpu::Buffer]) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            cache: None,
        });
        let bindings = bind(device, &pipeline.get_bind_group_layout(0), buffers);
        Self(pipeline, bindings)
    }

    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, invocations: u32) {
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&self.0);
        pass.set_bind_group(0, &self.1, &[]);
        pass.dispatch_workgroups(invocations.div_ceil(64), 1, 1);
    }
}

/// Bind group of buffers, from binding 0 on.
pub(crate) fn bind(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: &[&wgpu::Buffer],
) -> wgpu::BindGroup {
    let resources = buffers.iter().map(|buffer| buffer.as_entire_binding());
    let entries: Vec<_> = (0..)
        .zip(resources)
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor { label: None, layout, entries: &entries })
}

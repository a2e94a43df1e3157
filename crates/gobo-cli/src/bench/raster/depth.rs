//! The baseline of `occlude`: a depth-only pass over opaque triangles, without a fragment stage.
use gobo::{
    Error,
    gpu::Gpu,
    model::{Triangle, View},
    wgpu,
};

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Triangles per draw: bounds the size of a vertex buffer.
const DRAW_TRIANGLES: usize = 1 << 21;

#[derive(Debug)]
pub(crate) struct DepthPass {
    pipeline: wgpu::RenderPipeline,
    bindings: wgpu::BindGroup,
    draws: Vec<(wgpu::Buffer, u32)>,
    opaque: wgpu::Texture,
    target: wgpu::TextureView,
}

impl DepthPass {
    pub(crate) fn new(gpu: &Gpu, triangles: &[Triangle], view: &View) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::include_wgsl!("triangles.wgsl"));
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("raster_depth"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("corner"),
                compilation_options: Default::default(),
                buffers: &[Some(wgpu::VertexBufferLayout {
                    array_stride: 12,
                    step_mode: wgpu::VertexStepMode::Vertex,
                    attributes: &wgpu::vertex_attr_array![0 => Float32x3],
                })],
            },
            primitive: Default::default(),
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Less),
                stencil: Default::default(),
                bias: Default::default(),
            }),
            multisample: Default::default(),
            fragment: None,
            multiview_mask: None,
            cache: None,
        });
        let uniform =
            gpu.upload("raster_view", &[view.clip_from_world()], wgpu::BufferUsages::UNIFORM);
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("raster_depth"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let draws = triangles.chunks(DRAW_TRIANGLES).map(|triangles| {
            let corners: Vec<_> =
                triangles.iter().flat_map(|triangle| triangle.positions).collect();
            let usage = wgpu::BufferUsages::VERTEX;
            (gpu.upload("raster_triangles", &corners, usage), corners.len() as u32)
        });
        let draws = draws.collect();
        let opaque = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("raster_opaque"),
            size: wgpu::Extent3d {
                width: view.size.x,
                height: view.size.y,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: DEPTH,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let target = opaque.create_view(&wgpu::TextureViewDescriptor::default());
        Self { pipeline, bindings, draws, opaque, target }
    }

    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        let mut pass = super::begin(encoder, None, &self.target, true);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bindings, &[]);
        for (corners, count) in &self.draws {
            pass.set_vertex_buffer(0, corners.slice(..));
            pass.draw(0..*count, 0..1);
        }
    }

    pub(crate) fn read(&self, gpu: &Gpu) -> Result<Vec<f32>, Error> {
        gpu.try_read_texture(&self.opaque)
    }
}

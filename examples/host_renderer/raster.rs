//! The host's own renderer: rasterized depth maps, and a forward pass that evaluates gobo's light.
use crate::kernel::bind;
use bytemuck::{Pod, Zeroable};
use gobo::{
    glam::{Mat3, Mat4, Vec3, Vec4},
    wgpu::{self, BufferUsages, TextureFormat, TextureUsages, util::DeviceExt as _},
};

pub(crate) const SIZE: [u32; 2] = [320, 180];
const DEPTH: TextureFormat = TextureFormat::Depth32Float;
const COLOR: TextureFormat = TextureFormat::Rgba8UnormSrgb;
/// Edge of a depth map [texels].
pub(crate) const MAP: u32 = 256;
pub(crate) const MAPS: u32 = 4;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Vertex {
    pub(crate) place: [f32; 3],
    pub(crate) normal: [f32; 3],
    pub(crate) color: [f32; 3],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(crate) struct HostLight {
    pub(crate) place: [f32; 4],
    pub(crate) color: [f32; 4],
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Camera {
    clip_from_world: Mat4,
    right: Vec4,
    up: Vec4,
    lights: [HostLight; 4],
    light_count: [u32; 4],
}

pub(crate) struct Raster {
    device: wgpu::Device,
    queue: wgpu::Queue,
    vertices: wgpu::Buffer,
    vertex_count: u32,
    /// Depth maps with reversed z, a layer each.
    pub(crate) depths: wgpu::Texture,
    depth_pipeline: wgpu::RenderPipeline,
    /// Matrix and target of each depth map.
    depth_views: Vec<(wgpu::Buffer, wgpu::BindGroup, wgpu::TextureView)>,
    solid: wgpu::RenderPipeline,
    veil: wgpu::RenderPipeline,
    camera: wgpu::Buffer,
    camera_group: wgpu::BindGroup,
    smoke_group: wgpu::BindGroup,
    zbuffer: wgpu::TextureView,
}

const ATTRIBUTES: [wgpu::VertexAttribute; 3] =
    wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Float32x3];

fn buffer_entry(ty: wgpu::BufferBindingType) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding: 0,
        visibility: wgpu::ShaderStages::VERTEX_FRAGMENT | wgpu::ShaderStages::COMPUTE,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    }
}

/// Layout for `buffer` alone, at binding 0.
pub(crate) fn layout_of(
    device: &wgpu::Device,
    ty: wgpu::BufferBindingType,
) -> wgpu::BindGroupLayout {
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: None,
        entries: &[buffer_entry(ty)],
    })
}

impl Raster {
    /// `light_text`, `light_layout`: gobo's, in group 1.
    pub(crate) fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        vertices: &[Vertex],
        smoke: &wgpu::Buffer,
        light_text: &str,
        light_layout: &wgpu::BindGroupLayout,
    ) -> Self {
        let uniform = layout_of(device, wgpu::BufferBindingType::Uniform);
        let storage = layout_of(device, wgpu::BufferBindingType::Storage { read_only: true });
        let texture = |[width, height]: [u32; 2], layers| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: None,
                size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: DEPTH,
                usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let depths = texture([MAP; 2], MAPS);
        let uniform_buffer = |size| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size,
                usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let depth_views = (0..MAPS).map(|layer| {
            let matrix = uniform_buffer(64);
            let group = bind(device, &uniform, &[&matrix]);
            let view = depths.create_view(&wgpu::TextureViewDescriptor {
                dimension: Some(wgpu::TextureViewDimension::D2),
                base_array_layer: layer,
                array_layer_count: Some(1),
                ..Default::default()
            });
            (matrix, group, view)
        });
        let module = |text: &str| {
            device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: None,
                source: wgpu::ShaderSource::Wgsl(text.into()),
            })
        };
        let forward = module(&(light_text.to_owned() + include_str!("host.wgsl")));
        let depth_module = module(include_str!("depth.wgsl"));
        let pipeline = |groups: &[Option<&wgpu::BindGroupLayout>],
                        module: &wgpu::ShaderModule,
                        [vertex, fragment]: [&str; 2]| {
            let is_veil = fragment == "veil";
            let attributes = wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: if fragment.is_empty() { &ATTRIBUTES[..1] } else { &ATTRIBUTES },
            };
            let attributes = [Some(attributes)];
            let blend = is_veil.then_some(wgpu::BlendState::ALPHA_BLENDING);
            let targets = [Some(wgpu::ColorTargetState {
                format: COLOR,
                blend,
                write_mask: wgpu::ColorWrites::ALL,
            })];
            let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: groups,
                immediate_size: 0,
            });
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(vertex),
                layout: Some(&layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: if is_veil { &[] } else { &attributes },
                },
                primitive: wgpu::PrimitiveState {
                    topology: if is_veil {
                        wgpu::PrimitiveTopology::TriangleStrip
                    } else {
                        wgpu::PrimitiveTopology::TriangleList
                    },
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(!is_veil),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: Default::default(),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: (!fragment.is_empty()).then(|| wgpu::FragmentState {
                    module,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &targets,
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        let camera = uniform_buffer(size_of::<Camera>() as u64);
        let groups = [Some(&uniform), Some(light_layout), Some(&storage)];
        Self {
            vertices: device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: None,
                contents: bytemuck::cast_slice(vertices),
                usage: BufferUsages::VERTEX,
            }),
            vertex_count: vertices.len() as u32,
            depth_views: depth_views.collect(),
            depth_pipeline: pipeline(&[Some(&uniform)], &depth_module, ["depth", ""]),
            solid: pipeline(&groups[..2], &forward, ["solid", "lit"]),
            veil: pipeline(&groups, &forward, ["puff", "veil"]),
            camera_group: bind(device, &uniform, &[&camera]),
            smoke_group: bind(device, &storage, &[smoke]),
            camera,
            zbuffer: texture(SIZE, 1).create_view(&Default::default()),
            depths,
            device: device.clone(),
            queue: queue.clone(),
        }
    }

    /// Draws the first layers of `depths`.
    pub(crate) fn draw_depths(&self, encoder: &mut wgpu::CommandEncoder, matrices: &[Mat4]) {
        for (matrix, (buffer, group, view)) in matrices.iter().zip(&self.depth_views) {
            self.queue.write_buffer(buffer, 0, bytemuck::bytes_of(matrix));
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                depth_stencil_attachment: Some(cleared(view)),
                ..Default::default()
            });
            pass.set_pipeline(&self.depth_pipeline);
            pass.set_bind_group(0, group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.draw(0..self.vertex_count, 0..1);
        }
    }

    pub(crate) fn target(&self) -> wgpu::Texture {
        self.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: SIZE[0], height: SIZE[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: COLOR,
            usage: TextureUsages::RENDER_ATTACHMENT | TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    }

    /// Draws the picture. `light_group`: gobo's, for `lights`; `smoke_count`: number of drawn particles.
    pub(crate) fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::Texture,
        lights: &[HostLight],
        light_group: &wgpu::BindGroup,
        smoke_count: u32,
    ) {
        let (eye, middle) = (Vec3::new(2.6, 2.1, 4.2), Vec3::new(0.0, 0.75, 0.0));
        let aspect = SIZE[0] as f32 / SIZE[1] as f32;
        let forward = (middle - eye).normalize();
        let right = forward.cross(Vec3::Y).normalize();
        let up = right.cross(forward);
        let axes = Mat3::from_cols(right, up, -forward).transpose();
        let view_from_world = Mat4::from_mat3(axes) * Mat4::from_translation(-eye);
        // Infinite, reversed.
        let near = 0.1;
        let clip_from_view =
            Mat4::from_cols(Vec4::X * (2.5 / aspect), Vec4::Y * 2.5, Vec4::NEG_W, Vec4::Z * near);
        let mut all = [HostLight::default(); 4];
        all[..lights.len()].copy_from_slice(lights);
        let camera = Camera {
            clip_from_world: clip_from_view * view_from_world,
            right: right.extend(0.0),
            up: up.extend(0.0),
            lights: all,
            light_count: [lights.len() as u32, 0, 0, 0],
        };
        self.queue.write_buffer(&self.camera, 0, bytemuck::bytes_of(&camera));
        let target = target.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r: 0.02, g: 0.025, b: 0.04, a: 1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(cleared(&self.zbuffer)),
            ..Default::default()
        });
        pass.set_bind_group(0, &self.camera_group, &[]);
        pass.set_bind_group(1, light_group, &[]);
        pass.set_pipeline(&self.solid);
        pass.set_vertex_buffer(0, self.vertices.slice(..));
        pass.draw(0..self.vertex_count, 0..1);
        pass.set_pipeline(&self.veil);
        pass.set_bind_group(2, &self.smoke_group, &[]);
        pass.draw(0..4, 0..smoke_count);
    }
}

/// Depth attachment cleared to the farthest depth of reversed z.
fn cleared(view: &wgpu::TextureView) -> wgpu::RenderPassDepthStencilAttachment<'_> {
    wgpu::RenderPassDepthStencilAttachment {
        view,
        depth_ops: Some(wgpu::Operations {
            load: wgpu::LoadOp::Clear(0.0),
            store: wgpu::StoreOp::Store,
        }),
        stencil_ops: None,
    }
}

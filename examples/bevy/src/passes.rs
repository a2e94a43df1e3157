//! The two draws: the sun's light on what Bevy drew, and the smoke itself.
use crate::smoke::{CAPACITY, STRUCT, Smoke};
use bevy::math::{Mat4, Vec3};
use gobo::wgpu::{self, BufferUsages, ShaderStages as Stages};

/// Of the picture before tone mapping: that of a camera with `Hdr`.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// How much brighter the sun is than the light from everywhere.
const SUN: f32 = 3.5;

/// As `light.wgsl` has it.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Params {
    clip_from_world: [[f32; 4]; 4],
    world_from_clip: [[f32; 4]; 4],
    right: [f32; 4],
    up: [f32; 4],
    sun: [f32; 4],
}

pub struct Passes {
    layout: wgpu::BindGroupLayout,
    params: wgpu::Buffer,
    smoke: wgpu::Buffer,
    sun: wgpu::RenderPipeline,
    particles: wgpu::RenderPipeline,
}

impl Passes {
    /// `text` and `lights`: gobo's, for group 1.
    pub fn new(
        device: &wgpu::Device,
        text: &str,
        lights: &wgpu::BindGroupLayout,
        smoke: &Smoke,
    ) -> Self {
        let texture = |sample_type| wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let float = wgpu::TextureSampleType::Float { filterable: false };
        let kinds = [
            (Stages::VERTEX_FRAGMENT, buffer(wgpu::BufferBindingType::Uniform)),
            (Stages::FRAGMENT, texture(float)),
            (Stages::FRAGMENT, texture(wgpu::TextureSampleType::Depth)),
            (Stages::FRAGMENT, texture(float)),
            (Stages::VERTEX_FRAGMENT, buffer(wgpu::BufferBindingType::Storage { read_only: true })),
        ];
        let entries: Vec<_> = (0..)
            .zip(kinds)
            .map(|(binding, (visibility, ty))| wgpu::BindGroupLayoutEntry {
                binding,
                visibility,
                ty,
                count: None,
            })
            .collect();
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("light"),
            entries: &entries,
        });
        let text = [text, STRUCT, include_str!("light.wgsl")].concat();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("light"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("light"),
            bind_group_layouts: &[Some(&layout), Some(lights)],
            immediate_size: 0,
        });
        let pipeline = |vertex, fragment, blend, topology| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(fragment),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some(fragment),
                    compilation_options: Default::default(),
                    targets: &[Some(wgpu::ColorTargetState {
                        format: FORMAT,
                        blend,
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                primitive: wgpu::PrimitiveState { topology, ..Default::default() },
                depth_stencil: None,
                multisample: Default::default(),
                multiview_mask: None,
                cache: None,
            })
        };
        use wgpu::PrimitiveTopology::{TriangleList, TriangleStrip};
        let over = Some(wgpu::BlendState::ALPHA_BLENDING);
        let sun = pipeline("corner", "add_sun", None, TriangleList);
        let particles = pipeline("particle_corner", "shade_particle", over, TriangleStrip);
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("light"),
            size: size_of::<Params>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { layout, params, smoke: smoke.particles.clone(), sun, particles }
    }

    /// `axes` of the camera: right and up. `sun`: the unit direction of its rays.
    pub fn write(&self, queue: &wgpu::Queue, clip_from_world: Mat4, axes: [Vec3; 2], sun: Vec3) {
        let params = Params {
            clip_from_world: clip_from_world.to_cols_array_2d(),
            world_from_clip: clip_from_world.inverse().to_cols_array_2d(),
            right: axes[0].extend(0.0).to_array(),
            up: axes[1].extend(0.0).to_array(),
            sun: sun.extend(SUN).to_array(),
        };
        queue.write_buffer(&self.params, 0, bytemuck::bytes_of(&params));
    }

    /// `inputs`: picture, depth and normals of Bevy's prepass.
    pub fn record(
        &self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        inputs: [&wgpu::TextureView; 3],
        target: &wgpu::TextureView,
        lights: &wgpu::BindGroup,
    ) {
        let texture = wgpu::BindingResource::TextureView;
        let [picture, depths, normals] = inputs;
        let resources = [
            self.params.as_entire_binding(),
            texture(picture),
            texture(depths),
            texture(normals),
            self.smoke.as_entire_binding(),
        ];
        let entries: Vec<_> = (0..)
            .zip(resources)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let own = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("light"),
            layout: &self.layout,
            entries: &entries,
        });
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations::default(),
            })],
            ..Default::default()
        });
        pass.set_bind_group(0, &own, &[]);
        pass.set_bind_group(1, lights, &[]);
        pass.set_pipeline(&self.sun);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&self.particles);
        pass.draw(0..4, 0..CAPACITY);
    }
}

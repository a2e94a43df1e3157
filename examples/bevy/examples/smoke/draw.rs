//! The draw of the smoke, lit by gobo's maps.
use crate::smoke::{CAPACITY, STRUCT};
use bevy::{
    core_pipeline::{Core3dSystems, prepass::ViewPrepassTextures, schedule::Core3d},
    math::Mat4,
    prelude::*,
    render::{
        Render, RenderApp, RenderStartup, RenderSystems,
        renderer::{RenderContext, RenderDevice, RenderQueue, ViewQuery},
        view::{ExtractedView, ViewTarget},
    },
};
use bevy_gobo::{
    GoboSystems, Guest,
    gobo::{
        self,
        wgpu::{self, BufferUsages, ShaderStages as Stages},
    },
};

/// Format of the picture before tone mapping: that of a camera with `Hdr`.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The same as in `draw.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Params {
    clip_from_world: [[f32; 4]; 4],
    right: [f32; 4],
    up: [f32; 4],
}

/// Makes, moves and draws the smoke.
pub struct SmokePlugin;

impl Plugin for SmokePlugin {
    fn build(&self, app: &mut App) {
        let Some(render_app) = app.get_sub_app_mut(RenderApp) else { return };
        render_app
            .add_systems(RenderStartup, open.after(GoboSystems::Open))
            .add_systems(
                Render,
                bind.after(GoboSystems::Prepare).in_set(RenderSystems::PrepareResources),
            )
            .add_systems(
                Core3d,
                draw.after(Core3dSystems::MainPass).before(Core3dSystems::EarlyPostProcess),
            );
    }
}

#[derive(Resource)]
struct Drawn {
    particles: wgpu::Buffer,
    pass: Option<Pass>,
}

struct Pass {
    layout: wgpu::BindGroupLayout,
    params: wgpu::Buffer,
    pipeline: wgpu::RenderPipeline,
    lights: wgpu::BindGroup,
}

fn open(mut commands: Commands, guest: Option<ResMut<Guest>>, device: Res<RenderDevice>) {
    let (Some(mut guest), device) = (guest, device.wgpu_device()) else { return };
    let particles = crate::smoke::particles(device);
    let made = guest.add(|shadows, _| crate::smoke::Smoke::new(device, &particles, shadows));
    match made {
        Ok(()) => commands.insert_resource(Drawn { particles, pass: None }),
        Err(error) => error!("no smoke: {error}"),
    }
}

/// Binds gobo's maps; their layout stays the same.
fn bind(guest: Option<Res<Guest>>, drawn: Option<ResMut<Drawn>>, device: Res<RenderDevice>) {
    let (Some(guest), Some(mut drawn)) = (guest, drawn) else { return };
    if let Err(error) = drawn.bind(&guest, device.wgpu_device()) {
        error!("no smoke: {error}");
        drawn.pass = None;
    }
}

impl Drawn {
    fn bind(&mut self, guest: &Guest, device: &wgpu::Device) -> Result<(), gobo::Error> {
        let Some((prepared, lights)) = guest.maps() else { return Ok(()) };
        let bound = prepared.bind_lights(lights, &[0])?;
        match &mut self.pass {
            Some(pass) => pass.lights = bound.group,
            None => {
                let text = prepared.maps().wgsl(1, "gobo_")?;
                self.pass = Some(Pass::new(device, &text, &bound.layout, bound.group.clone()));
            }
        }
        Ok(())
    }
}

impl Pass {
    /// `text` and `layout`: gobo's, for group 1.
    fn new(
        device: &wgpu::Device,
        text: &str,
        layout: &wgpu::BindGroupLayout,
        lights: wgpu::BindGroup,
    ) -> Self {
        let buffer = |ty| wgpu::BindingType::Buffer {
            ty,
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let depths = wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Depth,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        };
        let kinds = [
            (Stages::VERTEX_FRAGMENT, buffer(wgpu::BufferBindingType::Uniform)),
            (Stages::FRAGMENT, depths),
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
        let own = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("smoke"),
            entries: &entries,
        });
        let text = [text, STRUCT, include_str!("draw.wgsl")].concat();
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("smoke"),
            source: wgpu::ShaderSource::Wgsl(text.into()),
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("smoke"),
            bind_group_layouts: &[Some(&own), Some(layout)],
            immediate_size: 0,
        });
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("smoke"),
            layout: Some(&pipeline_layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: None,
                compilation_options: Default::default(),
                targets: &[Some(wgpu::ColorTargetState {
                    format: FORMAT,
                    blend: Some(wgpu::BlendState::ALPHA_BLENDING),
                    write_mask: wgpu::ColorWrites::ALL,
                })],
            }),
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::TriangleStrip,
                ..Default::default()
            },
            depth_stencil: None,
            multisample: Default::default(),
            multiview_mask: None,
            cache: None,
        });
        let params = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("smoke"),
            size: size_of::<Params>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self { layout: own, params, pipeline, lights }
    }
}

/// Draws once per camera, before its post processing.
fn draw(
    view: ViewQuery<(&ViewTarget, &ViewPrepassTextures, &ExtractedView)>,
    drawn: Option<Res<Drawn>>,
    device: Res<RenderDevice>,
    queue: Res<RenderQueue>,
    mut context: RenderContext,
) {
    let (target, prepass, view) = view.into_inner();
    let Some(drawn) = drawn else { return };
    let (Some(pass), Some(depths)) = (&drawn.pass, prepass.depth_only_view()) else { return };
    let world_from_view = view.world_from_view.to_matrix();
    let clip_from_world: Mat4 =
        view.clip_from_world.unwrap_or_else(|| view.clip_from_view * world_from_view.inverse());
    let params = Params {
        clip_from_world: clip_from_world.to_cols_array_2d(),
        right: world_from_view.x_axis.to_array(),
        up: world_from_view.y_axis.to_array(),
    };
    queue.write_buffer(&pass.params, 0, bytemuck::bytes_of(&params));
    let own = device.wgpu_device().create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("smoke"),
        layout: &pass.layout,
        entries: &[
            wgpu::BindGroupEntry { binding: 0, resource: pass.params.as_entire_binding() },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(depths),
            },
            wgpu::BindGroupEntry { binding: 2, resource: drawn.particles.as_entire_binding() },
        ],
    });
    let encoder = context.command_encoder();
    let mut pass_encoder = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("smoke"),
        color_attachments: &[Some(wgpu::RenderPassColorAttachment {
            view: target.main_texture_view(),
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        })],
        ..Default::default()
    });
    pass_encoder.set_bind_group(0, &own, &[]);
    pass_encoder.set_bind_group(1, &pass.lights, &[]);
    pass_encoder.set_pipeline(&pass.pipeline);
    pass_encoder.draw(0..4, 0..CAPACITY);
}

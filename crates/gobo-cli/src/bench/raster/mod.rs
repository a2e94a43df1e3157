//! The baseline: the same maps by the raster pipeline, in the two ways that renderers use.
//!
//! - [`Recipe::OnePass`] (Wicked Engine): light-facing quads; colour is multiplied into an RGBA16F
//!   target, the nearest depth goes to its alpha by a MIN blend; depth test against the opaque map,
//!   which is read-only.
//! - [`Recipe::TwoPass`] (`StarCraft II`): the nearest depth by a pass that writes a depth buffer, then
//!   the colour.
//!
//! The casters are soft discs, or splats, whose quads are the rectangles along an ellipse's axes, with the
//! `filter` transfer, in directional views. Values that depend only on the caster and the view (the
//! enlargement of casters smaller than a texel, `a(1 - c)`, a splat's axes) are computed once, at the upload:
//! the raster path gets for free what `project` computes in every frame.
pub(crate) mod agree;
pub(crate) mod depth;
pub(crate) mod ellipse;
mod quads;

pub(crate) use quads::Inputs;

use agree::Map;
use bytemuck::{Pod, Zeroable};
use gobo::{
    Error,
    glam::{Mat4, Vec2},
    gpu::Gpu,
    model::View,
    wgpu,
};
use half::f16;
use quads::Draws;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Recipe {
    OnePass,
    TwoPass,
}

/// Vertex input of the quads. The faster one depends on the driver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Geometry {
    /// A strip of four vertices per instance.
    Instances,
    /// Four vertices and six indices per quad.
    Indexed,
}

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct ViewUniform {
    clip_from_world: Mat4,
    clip_per_metre: Vec2,
    pad: Vec2,
}

/// Format in which the product is blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Precision {
    /// RGBA16F, like the recipes.
    Half,
    /// RGBA32F, if the device can blend it: slower, and only to compare maps.
    Float,
}

impl Precision {
    fn format(self) -> wgpu::TextureFormat {
        match self {
            Self::Half => wgpu::TextureFormat::Rgba16Float,
            Self::Float => wgpu::TextureFormat::Rgba32Float,
        }
    }
}

const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Pipelines, casters and targets of one case.
#[derive(Debug)]
pub(crate) struct Raster {
    geometry: Geometry,
    precision: Precision,
    one_pass: wgpu::RenderPipeline,
    filter_only: wgpu::RenderPipeline,
    depth_only: wgpu::RenderPipeline,
    indices: Option<wgpu::Buffer>,
    targets: Vec<RasterTarget>,
}

/// A view's maps.
#[derive(Debug)]
struct RasterTarget {
    draws: Draws,
    bindings: wgpu::BindGroup,
    size: [u32; 2],
    filter: wgpu::Texture,
    opaque: wgpu::TextureView,
    nearest: wgpu::Texture,
}

impl Raster {
    /// Builds the baseline for views of the same scale.
    pub(crate) fn new(
        gpu: &Gpu,
        geometry: Geometry,
        precision: Precision,
        inputs: &Inputs,
        views: &[View],
    ) -> Self {
        let device = &gpu.device;
        let module = device.create_shader_module(wgpu::include_wgsl!("casters.wgsl"));
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("raster"),
            entries: &[wgpu::BindGroupLayoutEntry {
                binding: 0,
                visibility: wgpu::ShaderStages::VERTEX,
                ty: wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: None,
                },
                count: None,
            }],
        });
        let pipeline =
            |entry, target| pipeline(device, &module, &layout, inputs, geometry, entry, target);
        let target = wgpu::ColorTargetState { blend: Some(BLEND), ..precision.format().into() };
        let one_pass = pipeline("filter_and_depth", Some(target.clone()));
        let filter_only = pipeline("filter_only", Some(target));
        let depth_only = pipeline("depth_only", None);
        let draws = inputs.draws(gpu, geometry, views).into_iter();
        let targets = views
            .iter()
            .zip(draws)
            .map(|(view, draws)| RasterTarget::new(gpu, &layout, precision, view, draws));
        Self {
            geometry,
            precision,
            one_pass,
            filter_only,
            depth_only,
            indices: (geometry == Geometry::Indexed).then(|| inputs.indices(gpu)),
            targets: targets.collect(),
        }
    }

    pub(crate) fn geometry(&self) -> Geometry {
        self.geometry
    }

    /// Records every view's maps.
    pub(crate) fn record(&self, encoder: &mut wgpu::CommandEncoder, recipe: Recipe) {
        for target in &self.targets {
            let color = &target.filter.create_view(&wgpu::TextureViewDescriptor::default());
            if recipe == Recipe::TwoPass {
                let depth = &target.nearest.create_view(&wgpu::TextureViewDescriptor::default());
                let mut pass = begin(encoder, None, depth, true);
                self.draw(&mut pass, &self.depth_only, target);
            }
            let pipeline = match recipe {
                Recipe::OnePass => &self.one_pass,
                Recipe::TwoPass => &self.filter_only,
            };
            let mut pass = begin(encoder, Some(color), &target.opaque, false);
            self.draw(&mut pass, pipeline, target);
        }
    }

    fn draw(
        &self,
        pass: &mut wgpu::RenderPass<'_>,
        pipeline: &wgpu::RenderPipeline,
        target: &RasterTarget,
    ) {
        pass.set_pipeline(pipeline);
        pass.set_bind_group(0, &target.bindings, &[]);
        for (vertices, quads) in &target.draws {
            pass.set_vertex_buffer(0, vertices.slice(..));
            match &self.indices {
                Some(indices) => {
                    pass.set_index_buffer(indices.slice(..), wgpu::IndexFormat::Uint32);
                    pass.draw_indexed(0..quads * 6, 0, 0..1);
                }
                None => pass.draw(0..4, 0..*quads),
            }
        }
    }

    /// Maps of each view after a frame by `recipe`.
    pub(crate) fn read(&self, gpu: &Gpu, recipe: Recipe) -> Result<Vec<Map>, Error> {
        let maps = self.targets.iter().map(|target| {
            let texels: Vec<[f32; 4]> = match self.precision {
                Precision::Half => gpu
                    .try_read_texture::<[u16; 4]>(&target.filter)?
                    .into_iter()
                    .map(|texel| texel.map(|bits| f16::from_bits(bits).to_f32()))
                    .collect(),
                Precision::Float => gpu.try_read_texture(&target.filter)?,
            };
            let nearest = match recipe {
                Recipe::OnePass => texels.iter().map(|texel| texel[3]).collect(),
                Recipe::TwoPass => gpu.try_read_texture(&target.nearest)?,
            };
            let filter = texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect();
            Ok(Map { width: target.size[0], filter, nearest })
        });
        maps.collect()
    }
}

impl RasterTarget {
    fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        precision: Precision,
        view: &View,
        draws: Draws,
    ) -> Self {
        use wgpu::TextureUsages as Use;
        let texture = |label, format, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d {
                    width: view.size.x,
                    height: view.size.y,
                    depth_or_array_layers: 1,
                },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: usage | Use::RENDER_ATTACHMENT,
                view_formats: &[],
            })
        };
        let uniform = ViewUniform {
            clip_from_world: view.clip_from_world(),
            clip_per_metre: 2.0 * view.scale / view.size.as_vec2(),
            pad: Vec2::ZERO,
        };
        let buffer = gpu.upload("raster_view", &[uniform], wgpu::BufferUsages::UNIFORM);
        let bindings = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("raster"),
            layout,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: buffer.as_entire_binding() }],
        });
        let opaque = texture("raster_opaque", DEPTH, Use::empty())
            .create_view(&wgpu::TextureViewDescriptor::default());
        // Without opaque casters the opaque depth is always 1.
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        drop(begin(&mut encoder, None, &opaque, true));
        gpu.queue.submit([encoder.finish()]);
        Self {
            draws,
            bindings,
            size: view.size.to_array(),
            filter: texture("raster_filter", precision.format(), Use::COPY_SRC),
            opaque,
            nearest: texture("raster_nearest", DEPTH, Use::COPY_SRC),
        }
    }
}

/// Multiplies the colour, and keeps the minimum of alpha.
const BLEND: wgpu::BlendState = wgpu::BlendState {
    color: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Zero,
        dst_factor: wgpu::BlendFactor::Src,
        operation: wgpu::BlendOperation::Add,
    },
    alpha: wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Min,
    },
};

fn pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::BindGroupLayout,
    inputs: &Inputs,
    geometry: Geometry,
    entry: &str,
    color: Option<wgpu::ColorTargetState>,
) -> wgpu::RenderPipeline {
    let writes_depth = color.is_none();
    let colors = color.map(|color| [Some(color)]);
    use wgpu::{PrimitiveTopology as Topology, VertexStepMode as Step};
    let (topology, step_mode) = match geometry {
        Geometry::Instances => (Topology::TriangleStrip, Step::Instance),
        Geometry::Indexed => (Topology::TriangleList, Step::Vertex),
    };
    let (corner, vertices) = inputs.vertices();
    let is_splat = f64::from(u8::from(matches!(inputs, Inputs::Splats(_))));
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(entry),
        layout: Some(&device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(entry),
            bind_group_layouts: &[Some(layout)],
            immediate_size: 0,
        })),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(corner),
            compilation_options: Default::default(),
            buffers: &[Some(wgpu::VertexBufferLayout { step_mode, ..vertices })],
        },
        primitive: wgpu::PrimitiveState { topology, ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(writes_depth),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &[("IS_SPLAT", is_splat)],
                ..Default::default()
            },
            targets: colors.as_ref().map_or(&[], |colors| &colors[..]),
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// Begins a pass; the depth is cleared and written, or read-only.
fn begin<'e>(
    encoder: &'e mut wgpu::CommandEncoder,
    color: Option<&wgpu::TextureView>,
    depth: &wgpu::TextureView,
    writes_depth: bool,
) -> wgpu::RenderPass<'e> {
    let colors = color.map(|view| {
        [Some(wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                store: wgpu::StoreOp::Store,
            },
        })]
    });
    encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("raster"),
        color_attachments: colors.as_ref().map_or(&[], |colors| &colors[..]),
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: depth,
            depth_ops: writes_depth.then_some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(1.0),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        timestamp_writes: None,
        occlusion_query_set: None,
        multiview_mask: None,
    })
}

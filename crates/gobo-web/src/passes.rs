//! Pipelines of the page's own renderer, each made on demand.
use crate::{looks::Class, triangles::ATTRIBUTES, triangles::Corner};
use gobo::wgpu::{
    self, BindGroupLayout, BlendComponent, BlendFactor::*, BlendOperation, ColorTargetState,
    CompareFunction, TextureFormat,
};
use std::collections::HashMap;

/// Format of light before exposure and tone curve.
pub(crate) const LIGHT: TextureFormat = TextureFormat::Rgba16Float;
pub(crate) const DEPTH: TextureFormat = TextureFormat::Depth32Float;
/// Samples of a pixel.
pub(crate) const SAMPLES: u32 = 4;

const CORNERS: [Option<wgpu::VertexBufferLayout<'static>>; 1] = [Some(wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &ATTRIBUTES,
})];

/// A pass over casters that are drawn alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Pass {
    Sky,
    Solid,
    SolidSprites,
    PaneFilter,
    PaneGlow,
    Cover,
    Bricks,
    Sprites,
}

impl Pass {
    pub(crate) fn of(class: Class) -> &'static [Self] {
        match class {
            Class::Solid => &[Self::Solid],
            Class::Pane => &[Self::PaneFilter, Self::PaneGlow],
            Class::Cover => &[Self::Cover],
        }
    }

    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Sky => "sky",
            Self::Solid => "solid triangles",
            Self::SolidSprites => "solid sprites",
            Self::PaneFilter => "filters of panes",
            Self::PaneGlow => "light of panes",
            Self::Cover => "covering triangles",
            Self::Bricks => "voxels",
            Self::Sprites => "sprites",
        }
    }

    const fn text(self) -> &'static str {
        match self {
            Self::Sky => include_str!("../wgsl/screen.wgsl"),
            Self::Solid | Self::PaneFilter | Self::PaneGlow | Self::Cover => {
                include_str!("../wgsl/triangles.wgsl")
            }
            Self::Bricks => include_str!("../wgsl/bricks.wgsl"),
            Self::SolidSprites | Self::Sprites => include_str!("../wgsl/sprites.wgsl"),
        }
    }

    const fn entries(self) -> [&'static str; 2] {
        match self {
            Self::Sky => ["screen_corner", "sky_pixel"],
            Self::Solid => ["triangle_corner", "triangle_solid"],
            Self::PaneFilter => ["triangle_corner", "triangle_filter"],
            Self::PaneGlow => ["triangle_corner", "triangle_glow"],
            Self::Cover => ["triangle_corner", "triangle_cover"],
            Self::Bricks => ["brick_corner", "brick_ray"],
            Self::SolidSprites => ["sprite_corner", "sprite_solid"],
            Self::Sprites => ["sprite_corner", "sprite_blended"],
        }
    }

    fn blend(self) -> Option<wgpu::BlendState> {
        let both = |src_factor, dst_factor| {
            let part = BlendComponent { src_factor, dst_factor, operation: BlendOperation::Add };
            Some(wgpu::BlendState { color: part, alpha: part })
        };
        match self {
            Self::Sky | Self::Solid | Self::SolidSprites => None,
            Self::PaneFilter => both(Zero, Src),
            Self::PaneGlow => both(One, One),
            Self::Cover | Self::Bricks | Self::Sprites => both(One, OneMinusSrcAlpha),
        }
    }

    const fn writes_depth(self) -> bool {
        matches!(self, Self::Solid | Self::SolidSprites)
    }

    const fn reads_depth(self) -> bool {
        // A ray through voxels itself ends at solid surfaces.
        !matches!(self, Self::Sky | Self::Bricks)
    }

    const fn is_of_triangles(self) -> bool {
        matches!(self, Self::Solid | Self::PaneFilter | Self::PaneGlow | Self::Cover)
    }
}

/// Layouts of bind groups.
#[derive(Clone, Debug)]
pub(crate) struct Layouts {
    pub(crate) frame: BindGroupLayout,
    pub(crate) sky: BindGroupLayout,
    pub(crate) image: BindGroupLayout,
    pub(crate) sprites: BindGroupLayout,
    pub(crate) bricks: BindGroupLayout,
    pub(crate) tone: BindGroupLayout,
}

impl Layouts {
    pub(crate) fn new(device: &wgpu::Device) -> Self {
        use wgpu::BindingType::{Buffer, Sampler, Texture};
        let buffer = |ty| Buffer { ty, has_dynamic_offset: false, min_binding_size: None };
        let uniform = buffer(wgpu::BufferBindingType::Uniform);
        let storage = buffer(wgpu::BufferBindingType::Storage { read_only: true });
        let texture = |sample_type, multisampled| Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled,
        };
        let float = |filterable| wgpu::TextureSampleType::Float { filterable };
        let layout = |label, types: &[wgpu::BindingType]| {
            let entry = |(binding, &ty)| wgpu::BindGroupLayoutEntry {
                binding,
                visibility: wgpu::ShaderStages::VERTEX_FRAGMENT,
                ty,
                count: None,
            };
            let entries: Vec<_> = (0..).zip(types).map(entry).collect();
            let label = Some(label);
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label,
                entries: &entries,
            })
        };
        let depth = texture(wgpu::TextureSampleType::Depth, true);
        let filtering = Sampler(wgpu::SamplerBindingType::Filtering);
        Self {
            frame: layout("frame", &[uniform, storage]),
            sky: layout("sky", &[texture(float(false), false)]),
            image: layout("image", &[texture(float(true), false), filtering]),
            sprites: layout("sprites", &[storage, storage]),
            bricks: layout("bricks", &[storage, storage, storage, storage, depth]),
            tone: layout("tone", &[uniform, texture(float(false), false)]),
        }
    }

    fn of(&self, pass: Pass) -> &BindGroupLayout {
        match pass {
            Pass::Sky => &self.sky,
            Pass::Bricks => &self.bricks,
            Pass::SolidSprites | Pass::Sprites => &self.sprites,
            _ => &self.image,
        }
    }
}

/// Pipelines around one text of the light look-up.
#[derive(Debug, Default)]
pub(crate) struct Passes {
    made: HashMap<Pass, wgpu::RenderPipeline>,
}

impl Passes {
    pub(crate) fn get(&self, pass: Pass) -> Option<&wgpu::RenderPipeline> {
        self.made.get(&pass)
    }

    /// Makes a pipeline. `look_up`: the text of the light look-up, and its layout.
    pub(crate) fn make(
        &mut self,
        device: &wgpu::Device,
        layouts: &Layouts,
        (text, light): (&str, &BindGroupLayout),
        pass: Pass,
    ) {
        let source = [text, include_str!("../wgsl/frame.wgsl"), pass.text()].concat();
        let groups = [Some(&layouts.frame), Some(light), Some(layouts.of(pass))];
        let target = ColorTargetState {
            format: LIGHT,
            blend: pass.blend(),
            write_mask: wgpu::ColorWrites::ALL,
        };
        let is_strip = matches!(pass, Pass::SolidSprites | Pass::Sprites);
        let pipeline = pipeline(device, &source, pass.entries(), &groups, target, |of| {
            of.label = Some(pass.name());
            if is_strip {
                of.primitive.topology = wgpu::PrimitiveTopology::TriangleStrip;
            }
            if pass.is_of_triangles() {
                of.vertex.buffers = &CORNERS;
            }
            of.depth_stencil = Some(wgpu::DepthStencilState {
                format: DEPTH,
                depth_write_enabled: Some(pass.writes_depth()),
                depth_compare: Some(match pass.reads_depth() {
                    true => CompareFunction::GreaterEqual,
                    false => CompareFunction::Always,
                }),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            });
            of.multisample.count = SAMPLES;
        });
        self.made.insert(pass, pipeline);
    }
}

/// The pipeline that shows light on a target of this format.
pub(crate) fn tone_pipeline(
    device: &wgpu::Device,
    layouts: &Layouts,
    format: TextureFormat,
) -> wgpu::RenderPipeline {
    let source = include_str!("../wgsl/tone.wgsl");
    let groups = [Some(&layouts.tone)];
    pipeline(device, source, ["tone_corner", "tone_pixel"], &groups, format.into(), |_| ())
}

fn pipeline(
    device: &wgpu::Device,
    source: &str,
    [vertex, fragment]: [&str; 2],
    groups: &[Option<&BindGroupLayout>],
    target: ColorTargetState,
    change: impl for<'a> FnOnce(&mut wgpu::RenderPipelineDescriptor<'a>),
) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(fragment),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(fragment),
        bind_group_layouts: groups,
        immediate_size: 0,
    });
    let targets = [Some(target)];
    let mut descriptor = wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some(vertex),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &targets,
        }),
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    };
    change(&mut descriptor);
    device.create_render_pipeline(&descriptor)
}

//! Depth maps as a host's rasterizer writes them, in several conventions and formats.
use gobo::{
    View,
    glam::{DMat4, DVec4},
    gpu::Gpu,
    model::Projection,
    wgpu::{self, TextureFormat, TextureUsages},
};

/// Convention of a host's depth map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Convention {
    pub(super) name: &'static str,
    pub(super) reversed: bool,
    pub(super) infinite: bool,
    /// Extra width of the window, relative to the view's [share].
    pub(super) wider: f64,
}

pub(super) const USUAL: Convention =
    Convention { name: "usual", reversed: false, infinite: false, wider: 1.0 };
pub(super) const CONVENTIONS: [Convention; 4] = [
    USUAL,
    Convention { name: "reversed", reversed: true, ..USUAL },
    Convention { name: "infinite and reversed", reversed: true, infinite: true, ..USUAL },
    Convention { name: "wider", reversed: false, infinite: false, wider: 1.4 },
];

impl Convention {
    /// The host's projection with its own near and far planes.
    pub(super) fn clip_from_view(self, view: &View) -> DMat4 {
        let half = view.size.as_dvec2() * 0.5 / f64::from(view.scale) * self.wider;
        let (near, far) = (0.5 * f64::from(view.near).max(0.1), 1.7 * f64::from(view.far));
        let is_perspective = view.projection == Projection::Perspective;
        // Depth of the near plane and of the far one.
        let (first, last) = if self.reversed { (1.0, 0.0) } else { (0.0, 1.0) };
        let across = |x: f64, y: f64| [DVec4::X * x, DVec4::Y * y];
        let [x, y] = across(1.0 / half.x, 1.0 / half.y);
        if !is_perspective {
            let slope = (last - first) / (far - near);
            let z = DVec4::new(0.0, 0.0, -slope, 0.0);
            return DMat4::from_cols(x, y, z, DVec4::new(0.0, 0.0, first - slope * near, 1.0));
        }
        // depth = a + b / distance
        let b = if self.infinite {
            (first - last) * near
        } else {
            (first - last) / (1.0 / near - 1.0 / far)
        };
        let a = if self.infinite { last } else { last - b / far };
        let z = DVec4::new(0.0, 0.0, -a, -1.0);
        DMat4::from_cols(x, y, z, DVec4::new(0.0, 0.0, b, 0.0))
    }

    /// Largest distance between neighbouring values of 24-bit depth [m].
    pub(super) fn step(self, view: &View, distance: f64) -> f64 {
        let clip = self.clip_from_view(view);
        let depth = |distance: f64| {
            let at = clip * DVec4::new(0.0, 0.0, -distance, 1.0);
            at.z / at.w
        };
        let slope = (depth(distance * 1.001) - depth(distance)).abs() / (distance * 0.001);
        2_f64.powi(-24) / slope
    }

    pub(super) fn empty(self) -> f32 {
        if self.reversed { 0.0 } else { 1.0 }
    }
}

/// A tilted plane across the views' axes: distances along the axis of a view [m].
#[derive(Clone, Copy)]
pub(super) struct Plane {
    pub(super) middle: f64,
    pub(super) tilt: f64,
}

impl Plane {
    /// Distance along the ray through a point of the window in -1..1.
    pub(super) fn distance(self, view: &View, x: f64, y: f64) -> f64 {
        let half = view.size.as_dvec2() * 0.5 / f64::from(view.scale);
        let across = x * half.x + 0.3 * y * half.y;
        match view.projection {
            Projection::Orthographic => self.middle + self.tilt * across,
            Projection::Perspective => self.middle / (1.0 - self.tilt * across),
        }
    }
}

/// Depths that the host's rasterizer would write for a plane; clear depth in the left eighth.
pub(super) fn rendered(
    view: &View,
    plane: Plane,
    convention: Convention,
    [width, height]: [u32; 2],
) -> Vec<f32> {
    let clip = convention.clip_from_view(view);
    let texel = |i: u32| {
        let x = (f64::from(i % width) + 0.5) / f64::from(width) * 2.0 - 1.0;
        let y = 1.0 - (f64::from(i / width) + 0.5) / f64::from(height) * 2.0;
        if x < -0.75 * convention.wider.recip() {
            return convention.empty();
        }
        let distance = plane.distance(view, x * convention.wider, y * convention.wider);
        let at = clip * DVec4::new(0.0, 0.0, -distance, 1.0);
        (at.z / at.w) as f32
    };
    (0..width * height).map(texel).collect()
}

/// A texture of three layers, the middle one with the depths.
pub(super) fn host_texture(
    gpu: &Gpu,
    format: TextureFormat,
    size: [u32; 2],
    depths: &[f32],
) -> wgpu::Texture {
    let [width, height] = size;
    let of = |format, layers, usage| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width, height, depth_or_array_layers: layers },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: usage | TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        })
    };
    let source = of(TextureFormat::R32Float, 3, TextureUsages::COPY_DST);
    let wrong = vec![0.123_f32; depths.len()];
    gpu.write_texture(&source, &[&wrong, depths, &wrong].concat());
    if format == TextureFormat::R32Float {
        return source;
    }
    let target = of(format, 3, TextureUsages::RENDER_ATTACHMENT);
    draw_depths(gpu, &source, &target);
    target
}

/// Draws the depths to the middle layer.
fn draw_depths(gpu: &Gpu, source: &wgpu::Texture, target: &wgpu::Texture) {
    const WGSL: &str = "
        @group(0) @binding(0) var source: texture_2d<f32>;
        @vertex fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4<f32> {
            return vec4(f32(i & 1u) * 4.0 - 1.0, f32(i >> 1u) * 4.0 - 1.0, 0.5, 1.0);
        }
        @fragment fn depth(@builtin(position) at: vec4<f32>) -> @builtin(frag_depth) f32 {
            return textureLoad(source, vec2<u32>(at.xy), 0).x;
        }";
    let device = &gpu.device;
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Wgsl(WGSL.into()),
    });
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: None,
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: Some(wgpu::DepthStencilState {
            format: target.format(),
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Always),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[],
        }),
        multiview_mask: None,
        cache: None,
    });
    let layer = |texture: &wgpu::Texture| {
        texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2),
            base_array_layer: 1,
            array_layer_count: Some(1),
            ..Default::default()
        })
    };
    let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: wgpu::BindingResource::TextureView(&layer(source)),
        }],
    });
    let mut encoder = device.create_command_encoder(&Default::default());
    let target = layer(target);
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
            view: &target,
            depth_ops: Some(wgpu::Operations {
                load: wgpu::LoadOp::Clear(0.3),
                store: wgpu::StoreOp::Store,
            }),
            stencil_ops: None,
        }),
        ..Default::default()
    });
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &bindings, &[]);
    pass.draw(0..3, 0..1);
    drop(pass);
    gpu.queue.submit([encoder.finish()]);
}

/// The host's matrix from world space, in columns.
pub(super) fn world(convention: Convention, view: &View) -> [[f32; 4]; 4] {
    let clip_from_world = convention.clip_from_view(view) * view.view_from_world.as_dmat4();
    clip_from_world.as_mat4().to_cols_array_2d()
}

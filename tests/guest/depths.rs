//! Depth maps of the host's become opaque depths, whatever their convention is.
use super::{ShadowSettings, Vec3, materials, shadows, submit};
use crate::common::{
    TIERS, gpu,
    scenes::{flat_view, pane, particle},
};
use gobo::{
    Bounds, Casters, Error, HostDepth, HostInputs, Light, Particle, Projection, Triangle, View,
    glam::{DMat4, DVec3, DVec4, Mat4, Vec4},
    gpu::Gpu,
    light_views,
    wgpu::{self, TextureFormat, TextureUsages},
};

/// What a host renders a view with.
#[derive(Clone, Copy, Debug)]
struct Convention {
    name: &'static str,
    reversed: bool,
    infinite: bool,
    /// How much wider than the view [share].
    wider: f64,
}

const USUAL: Convention =
    Convention { name: "usual", reversed: false, infinite: false, wider: 1.0 };
const CONVENTIONS: [Convention; 4] = [
    USUAL,
    Convention { name: "reversed", reversed: true, ..USUAL },
    Convention { name: "infinite and reversed", reversed: true, infinite: true, ..USUAL },
    Convention { name: "wider", reversed: false, infinite: false, wider: 1.5 },
];

impl Convention {
    /// Planes of the host's own, apart from the view's.
    fn clip_from_view(self, view: &View) -> DMat4 {
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

    /// How far apart distances are that 24 bits of depth tell from each other, at worst [m].
    fn step(self, view: &View, distance: f64) -> f64 {
        let clip = self.clip_from_view(view);
        let depth = |distance: f64| {
            let at = clip * DVec4::new(0.0, 0.0, -distance, 1.0);
            at.z / at.w
        };
        let slope = (depth(distance * 1.001) - depth(distance)).abs() / (distance * 0.001);
        2_f64.powi(-24) / slope
    }

    fn empty(self) -> f32 {
        if self.reversed { 0.0 } else { 1.0 }
    }
}

/// A plane across the views' axes, tilted: distances along the axis of a view [m].
#[derive(Clone, Copy)]
struct Plane {
    middle: f64,
    tilt: f64,
}

impl Plane {
    /// Along the ray through a point of the window in -1..1.
    fn distance(self, view: &View, x: f64, y: f64) -> f64 {
        let half = view.size.as_dvec2() * 0.5 / f64::from(view.scale);
        let across = x * half.x + 0.3 * y * half.y;
        match view.projection {
            Projection::Orthographic => self.middle + self.tilt * across,
            Projection::Perspective => self.middle / (1.0 - self.tilt * across),
        }
    }
}

/// What the host's rasterizer would leave of a plane: nothing in the left eighth.
fn rendered(
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

/// A texture of three layers, of which the middle one has the depths.
fn host_texture(gpu: &Gpu, format: TextureFormat, size: [u32; 2], depths: &[f32]) -> wgpu::Texture {
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

/// The middle layer.
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

fn views() -> [View; 2] {
    let bounds = Bounds { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };
    let spot = Light::spot(Vec3::new(3.0, 4.0, 2.5), Vec3::new(-3.0, -4.0, -2.5), 0.8);
    let sun = Light::directional(Vec3::new(0.3, -1.0, 0.2));
    [spot, sun].map(|light| light_views(0, &light, 64, None, &bounds).unwrap().remove(0))
}

/// `Z` of the only view.
fn opaque_depths(
    gpu: &Gpu,
    view: &View,
    casters: &Casters<'_>,
    depths: &[HostDepth<'_>],
) -> Vec<f32> {
    let mut shadows = shadows(gpu);
    let settings = ShadowSettings::default();
    let inputs = HostInputs::new().depths(depths);
    let views = [view.clone()];
    let prepared = shadows.prepare_with(casters, &views, &settings, &inputs).unwrap();
    let bits = submit(gpu, &prepared);
    let (width, size) = (prepared.maps().opaques.width() as usize, view.size.as_usizevec2());
    let rows = bits.opaques.chunks(width).take(size.y);
    rows.flat_map(|row| &row[..size.x]).map(|&bits| f32::from_bits(bits)).collect()
}

fn world(convention: Convention, view: &View) -> [[f32; 4]; 4] {
    let clip_from_world = convention.clip_from_view(view) * view.view_from_world.as_dmat4();
    clip_from_world.as_mat4().to_cols_array_2d()
}

#[test]
fn a_plane_is_where_paper_says_in_each_format_and_convention() {
    use TextureFormat::{Depth24Plus, Depth32Float, R32Float};
    for tier in TIERS {
        let gpu = gpu(tier);
        for (view, convention) in
            views().iter().flat_map(|view| CONVENTIONS.map(|convention| (view.clone(), convention)))
        {
            let (near, far) = (f64::from(view.near), f64::from(view.far));
            let plane = Plane { middle: near + 0.6 * (far - near), tilt: 0.1 };
            for format in [R32Float, Depth32Float, Depth24Plus] {
                let depths = rendered(&view, plane, convention, [64, 64]);
                let texture = host_texture(&gpu, format, [64, 64], &depths);
                let columns = world(convention, &view);
                let depth = HostDepth::new(0, &texture).layer(1).clip_from_world(columns);
                let found = opaque_depths(&gpu, &view, &Casters::default(), &[depth]);
                let mut surface = 0;
                for (i, &found) in found.iter().enumerate() {
                    let at = |i: usize| (i as f64 + 0.5) / 32.0 - 1.0;
                    let (x, y) = (at(i % 64), -at(i / 64));
                    // The nearest texel of a map that is wider.
                    let host = |at: f64| {
                        (((at / convention.wider + 1.0) * 32.0).floor() + 0.5) / 32.0 - 1.0
                    };
                    let (hx, hy) = (host(x) * convention.wider, -host(-y) * convention.wider);
                    let distance = plane.distance(&view, hx, hy);
                    let is_empty = host(x) < -0.75 / convention.wider;
                    let expected = if is_empty { 1.0 } else { (distance - near) / (far - near) };
                    surface += usize::from(!is_empty);
                    // Written, stored and read, each rounded.
                    let tolerance = 4e-6 + 2.0 * convention.step(&view, distance) / (far - near);
                    assert!(
                        (f64::from(found) - expected).abs() < tolerance && tolerance < 4e-5,
                        "{tier} {format:?} {} {:?} {i}: {found} {expected}",
                        convention.name,
                        view.projection
                    );
                }
                assert!((3000..4096).contains(&surface), "{surface}");
            }
        }
    }
}

#[test]
fn maps_of_any_size_cover_the_view() {
    let gpu = gpu(TIERS[0]);
    let [view, _] = views();
    let (near, far) = (f64::from(view.near), f64::from(view.far));
    let plane = Plane { middle: near + 0.4 * (far - near), tilt: 0.0 };
    for size in [[7, 5], [33, 64], [300, 200]] {
        let depths = rendered(&view, plane, USUAL, size);
        let texture = host_texture(&gpu, TextureFormat::R32Float, size, &depths);
        let depth = HostDepth::new(0, &texture).layer(1).clip_from_world(world(USUAL, &view));
        let found = opaque_depths(&gpu, &view, &Casters::default(), &[depth]);
        for (i, &found) in found.iter().enumerate() {
            let column = ((i % 64) as f64 + 0.5) / 64.0 * f64::from(size[0]);
            let is_empty = (column.floor() + 0.5) / f64::from(size[0]) * 2.0 - 1.0 < -0.75;
            let expected = if is_empty { 1.0 } else { 0.4 };
            assert!((found - expected).abs() < 1e-5, "{size:?} {i}: {found}");
        }
    }
}

/// With the view's own matrix; beside opaque triangles the nearer counts, instead of them the map.
#[test]
fn maps_lower_what_triangles_left_or_replace_it() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let view = flat_view(64, 32.0);
        let materials = materials();
        // In front of the map's plane in the middle, behind it around.
        let triangles: Vec<Triangle> = [pane(0.2, 0.5, 2), pane(0.8, 2.0, 2)].concat();
        let particles: Vec<Particle> = [0.1, 0.3, 0.6]
            .map(|depth: f32| {
                particle(Vec3::Z * (-10.0 * depth), 0.6, Vec4::new(0.5, 0.6, 0.7, 0.8))
            })
            .to_vec();
        let casters = Casters {
            particles: &particles,
            triangles: &triangles,
            materials: &materials,
            ..Casters::default()
        };
        let texture = host_texture(&gpu, TextureFormat::R32Float, [64, 64], &[0.5; 64 * 64]);
        let depth = HostDepth::new(0, &texture).layer(1);
        let none = opaque_depths(&gpu, &view, &casters, &[]);
        let beside = opaque_depths(&gpu, &view, &casters, &[depth]);
        let instead = opaque_depths(&gpu, &view, &casters, &[depth.instead()]);
        let (middle, edge) = (32 * 64 + 32, 3 * 64 + 3);
        let close = |a: f32, b: f32| (a - b).abs() < 1e-5;
        assert!(close(none[middle], 0.2) && close(none[edge], 0.8));
        assert!(close(beside[middle], 0.2) && close(beside[edge], 0.5));
        assert!(instead.iter().all(|&depth| close(depth, 0.5)));

        // What is behind the map filters nothing, frame after frame while it moves.
        let mut shadows = shadows(&gpu);
        let (views, settings) = ([view.clone()], ShadowSettings::default());
        let through = |hits: i32| 0.8_f32.mul_add(0.5 - 1.0, 1.0).powi(hits);
        for inputs in [[depth], [depth.instead()]] {
            let inputs = HostInputs::new().depths(&inputs);
            let discs = Casters { triangles: &[], ..casters };
            let prepared = shadows.prepare_with(&discs, &views, &settings, &inputs).unwrap();
            for (z, hits) in [(0.5_f32, 2), (0.2, 1), (0.05, 0), (0.9, 3), (1.0, 3)] {
                gpu.write_texture(&texture, &vec![z; 3 * 64 * 64]);
                let width = prepared.maps().filters.width() as usize;
                let bits = submit(&gpu, &prepared);
                let red = half::f16::from_bits(bits.filters[32 * width + 32][0]).to_f32();
                assert!((red - through(hits)).abs() < 1e-2, "{tier} {z}: {red}");
                let found = f32::from_bits(bits.opaques[0]);
                assert!(close(found, z), "{tier} {z}: {found}");
            }
            gpu.write_texture(&texture, &[0.5; 3 * 64 * 64]);
        }
        // Without it, its depths are gone.
        let discs = Casters { triangles: &[], ..casters };
        let prepared = shadows.prepare(&discs, &views, &settings).unwrap();
        let bits = submit(&gpu, &prepared);
        assert!(bits.opaques.iter().all(|&bits| bits == 1.0_f32.to_bits()));
    }
}

#[test]
fn maps_that_cannot_be_used_are_named() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let [view, sun] = views();
    let of = |format, usage, samples| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: wgpu::Extent3d { width: 64, height: 64, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: samples,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let bound = TextureUsages::TEXTURE_BINDING;
    let depth = TextureFormat::Depth32Float;
    let good = of(depth, bound, 1);
    let colours = of(TextureFormat::Rgba8Unorm, bound, 1);
    let many = of(depth, bound | TextureUsages::RENDER_ATTACHMENT, 4);
    let unread = of(depth, TextureUsages::RENDER_ATTACHMENT, 1);
    let moved = |by: Vec3| {
        let own = view.clip_from_world();
        (own * Mat4::from_translation(by)).to_cols_array_2d()
    };
    let narrow = world(Convention { wider: 0.9, ..USUAL }, &view);
    let behind = (view.clip_from_world() * Mat4::from_scale(Vec3::NEG_ONE)).to_cols_array_2d();
    let on_view = |texture| HostDepth::new(0, texture);
    let mut error = |wrong: HostDepth<'_>, colored| {
        let inputs = [HostDepth::new(1, &good), wrong];
        let inputs = HostInputs::new().depths(&inputs);
        let (views, casters) = ([view.clone(), sun.clone()], Casters::default());
        let settings = ShadowSettings { colored, ..ShadowSettings::default() };
        shadows.prepare_with(&casters, &views, &settings, &inputs).map(|_| ()).unwrap_err()
    };
    for (wrong, problem) in [
        (HostDepth::new(2, &good), "not among the views"),
        (HostDepth::new(1, &good), "one already"),
        (on_view(&colours), "format"),
        (on_view(&many), "one sample"),
        (on_view(&unread), "TEXTURE_BINDING"),
        (on_view(&good).layer(1), "no such layer"),
        (on_view(&good).clip_from_world(moved(Vec3::X)), "along the view's own rays"),
        (on_view(&good).clip_from_world(narrow), "cover"),
        (on_view(&good).clip_from_world(behind), "see"),
        (on_view(&good).clip_from_world([[f32::NAN; 4]; 4]), "finite"),
    ] {
        let message = error(wrong, false).to_string();
        assert!(message.starts_with("depth map of the host's 1 "), "{message}");
        assert!(message.contains(problem), "{problem}: {message}");
    }
    let colored = error(on_view(&good), true);
    assert!(matches!(colored, Error::Invalid { .. }), "{colored}");
    assert!(gpu.check().is_ok());
}

/// The matrices of the test are what they say: near and far planes have their depths.
#[test]
fn conventions_are_what_they_say() {
    for (view, convention) in
        views().iter().flat_map(|view| CONVENTIONS.map(|convention| (view.clone(), convention)))
    {
        let clip = convention.clip_from_view(&view);
        let depth = |distance: f64| {
            let at = clip * DVec3::new(0.0, 0.0, -distance).extend(1.0);
            at.z / at.w
        };
        let near = 0.5 * f64::from(view.near).max(0.1);
        let far = if convention.infinite { 1e12 } else { 1.7 * f64::from(view.far) };
        let [first, last] = if convention.reversed { [1.0, 0.0] } else { [0.0, 1.0] };
        let is_infinite = convention.infinite && view.projection == Projection::Orthographic;
        assert!((depth(near) - first).abs() < 1e-9, "{convention:?}");
        assert!(is_infinite || (depth(far) - last).abs() < 1e-9, "{convention:?}");
    }
}

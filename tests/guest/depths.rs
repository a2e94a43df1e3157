//! Depth maps of the host become opaque depths, in any convention.
use super::{
    ShadowSettings, Vec3, materials,
    rendered::{CONVENTIONS, Convention, Plane, USUAL, host_texture, rendered, world},
    shadows, submit,
};
use crate::common::{
    TIERS, Tier, gpu,
    scenes::{Chance, flat_view, pane, particle},
    tiers,
};
use gobo::{
    Bounds, Casters, Error, HostDepth, HostInputs, Light, Particle, Triangle, View,
    glam::{DVec3, Mat4, UVec2, Vec2, Vec4},
    gpu::{Gpu, Kernel, Resources},
    light_views,
    model::Projection,
    records::ImportParams,
    stage::import,
    wgpu::{self, TextureFormat, TextureUsages},
};
use gobo_reference::import::ClipRay;

pub(super) fn views() -> [View; 2] {
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

#[test]
fn a_plane_is_where_paper_says_in_each_format_and_convention() {
    use TextureFormat::{Depth24Plus, Depth32Float, R32Float};
    for tier in tiers(Tier::Native) {
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
                    // The nearest texel of a wider map.
                    let host = |at: f64| {
                        (((at / convention.wider + 1.0) * 32.0).floor() + 0.5) / 32.0 - 1.0
                    };
                    let (hx, hy) = (host(x) * convention.wider, -host(-y) * convention.wider);
                    let distance = plane.distance(&view, hx, hy);
                    let is_empty = host(x) < -0.75 / convention.wider;
                    let expected = if is_empty { 1.0 } else { (distance - near) / (far - near) };
                    surface += usize::from(!is_empty);
                    // Written, stored and read, rounded each time.
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

/// With the view's own matrix: beside opaque triangles the nearer depth wins; without them, the map's.
#[test]
fn maps_lower_what_triangles_left_or_replace_it() {
    for tier in tiers(Tier::Native) {
        let gpu = gpu(tier);
        let view = flat_view(64, 32.0);
        let materials = materials();
        // In front of the map's plane in its centre, behind it elsewhere.
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

        // Casters behind the map filter nothing, frame after frame, while the map moves.
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

/// The test's matrices map near and far planes to their depths.
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

/// All texels, and their neighbours, which must stay poisoned.
#[test]
fn kernel_equals_reference() {
    const POISON: f32 = -7.0;
    let gpu = gpu(TIERS[0]);
    let kernel = Kernel::new(&gpu.device, &import::DEPTHS, gpu.tier, &[], &[]).unwrap();
    let mut chance = Chance::new(8);
    for (view, convention) in
        views().iter().flat_map(|view| CONVENTIONS.map(|convention| (view.clone(), convention)))
    {
        for replaces in [0, 1] {
            let host_size = [37, 21];
            let depths: Vec<f32> = (0..37 * 21)
                .map(|_| match chance.below(8) {
                    0 => convention.empty(),
                    1 => f32::NAN,
                    _ => chance.unit(),
                })
                .collect();
            let params = ImportParams {
                clip_from_view: convention.clip_from_view(&view).as_mat4(),
                size: Vec2::new(50.0, 30.0),
                host_size: Vec2::new(37.0, 21.0),
                scale: view.scale,
                perspective: f32::from(u8::from(view.projection == Projection::Perspective)),
                near: view.near,
                far: view.far,
                origin: UVec2::new(5, 9),
                layer: 1,
                replaces,
                empty: convention.empty(),
                pad_0: 0,
                pad_1: 0,
                pad_2: 0,
            };
            let before: Vec<f32> = (0..2 * 64 * 64).map(|_| chance.unit()).collect();
            let mut expected: Vec<f32> = before.clone();
            expected[..64 * 64].fill(POISON);
            let opaques = gpu.texture_array("opaques", [64, 64, 2], TextureFormat::R32Float);
            gpu.write_texture(&opaques, &expected);
            let host = gpu.texture("host", host_size, TextureFormat::R32Float);
            gpu.write_texture(&host, &depths);
            let of_params = gpu.upload("params", &[params], wgpu::BufferUsages::UNIFORM);
            let resources = Resources::new()
                .with("import_params", &of_params)
                .with("host_depths", &host)
                .with("opaques", &opaques);
            let bindings = kernel.bind(&gpu.device, &resources).unwrap();
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            let groups = import::grid(UVec2::new(50, 30));
            kernel.record(&mut encoder.begin_compute_pass(&Default::default()), &bindings, groups);
            gpu.queue.submit([encoder.finish()]);
            for (x, y) in (0..30).flat_map(|y| (0..50).map(move |x| (x, y))) {
                let ray = ClipRay::new(&params, Vec2::new(x as f32, y as f32) + 0.5);
                let at = ray.host_texel(&params);
                let depth = ray.light_depth(&params, depths[(at.y * 37 + at.x) as usize]);
                let own = &mut expected[64 * 64 + ((y + 9) * 64 + x + 5) as usize];
                *own = if replaces == 1 { depth } else { own.min(depth) };
            }
            let found: Vec<f32> = gpu.read_texture(&opaques);
            let apart = |(a, b): (&f32, &f32)| (a - b).abs();
            let worst = found.iter().zip(&expected).map(apart).fold(0.0, f32::max);
            assert!(worst < 2e-5, "{convention:?} {worst}");
            assert!(found.iter().zip(&before).any(|pair| apart(pair) > 0.1));
        }
    }
}

//! Numbers of a host outside their ranges: each is an error that names it, or is counted.
use super::{HostBuffers, bound, materials, particles, shadows, submit, views};
use crate::common::{TIERS, gpu, own_gpu, two_devices};
use gobo::{
    Bounds, Camera, CasterCount, Casters, Error, Grid, HostCasters, HostDepth, HostGrid,
    HostInputs, Light, Particle, ShadowSettings, Triangle,
    glam::{Vec2, Vec3},
    host::{FilterFormat, Input, LightMasks, MapLayout, MaskView, PointBuffers},
    light_views,
    model::{Cascades, LightKind, MaskSettings, Shadow, emitter::Forces},
    wgpu::{self, BufferUsages},
};

/// Asserts that an error names an input and its problem.
fn assert_named(error: &Error, what: &str, problem: &str) {
    let text = error.to_string();
    assert!(text.starts_with(what) && text.contains(problem), "{what} {problem}: {text}");
}

#[test]
fn forces_out_of_range_are_named() {
    type Change = fn(&mut Forces);
    let gpu = gpu(TIERS[0]);
    let shadows = shadows(&gpu);
    assert!(Forces::default().problem().is_none());
    shadows.simulation(&Forces::default()).unwrap();
    let wrong: [(&str, Change); 33] = [
        ("rate", |it| it.rate = -1.0),
        ("rate", |it| it.rate = f64::NAN),
        ("rate", |it| it.rate = 0.0),
        ("rate", |it| it.rate = f64::INFINITY),
        ("lifetime", |it| it.lifetime = [0.0, 1.0]),
        ("lifetime", |it| it.lifetime = [2.0, 1.0]),
        ("lifetime", |it| it.lifetime[1] = f32::NAN),
        ("lifetime", |it| it.lifetime[1] = 1e9),
        ("position", |it| it.position.x = f32::NAN),
        ("extent", |it| it.extent.y = f32::INFINITY),
        ("extent", |it| it.extent.y = -1.0),
        ("velocity", |it| it.velocity.z = f32::NEG_INFINITY),
        ("spread", |it| it.spread = -1.0),
        ("gravity", |it| it.gravity = f32::NAN),
        ("buoyancy", |it| it.buoyancy = f32::INFINITY),
        ("drag", |it| it.drag = -0.1),
        ("drag", |it| it.drag = f32::NAN),
        ("wind", |it| it.wind.x = 1e8),
        ("turbulence", |it| it.turbulence = f32::NAN),
        ("frequency", |it| it.frequency = 0.0),
        ("frequency", |it| it.frequency = f32::INFINITY),
        ("evolve", |it| it.evolve = f32::NAN),
        ("ground", |it| it.ground = Some(f32::NAN)),
        ("box", |it| it.boxes = vec![[Vec3::ONE, Vec3::ZERO]]),
        ("box", |it| it.boxes = vec![[Vec3::ZERO, Vec3::NAN]]),
        ("8 boxes", |it| it.boxes = vec![[Vec3::ZERO, Vec3::ONE]; 9]),
        ("bounce", |it| it.bounce = 1.5),
        ("slide", |it| it.slide = f32::NAN),
        ("path", |it| it.path = vec![[0.0, f32::NAN, 0.0, 0.0]]),
        ("path", |it| it.path = vec![[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]]),
        ("path", |it| it.path = vec![[f32::NAN, 0.0, 0.0, 0.0]; 2]),
        ("path", |it| it.path = (0..40).map(|i| [i as f32 * 1e-5, 0.0, 0.0, 0.0]).collect()),
        ("origin", |it| it.origin.y = f32::NAN),
    ];
    for (problem, change) in wrong {
        let mut forces = Forces::default();
        change(&mut forces);
        assert_named(&shadows.simulation(&forces).unwrap_err(), "emitter 0 ", problem);
    }
    // Also rates that no device requests.
    for rate in [-1.0, f64::NAN, 0.0] {
        assert_eq!(Forces { rate, ..Forces::default() }.started(1000), 0);
    }
    gpu.check().unwrap();
}

#[test]
fn lights_and_boxes_out_of_range_are_named() {
    type Change = fn(&mut (Light, Camera, Bounds));
    let sun = |change: fn(&mut Cascades)| {
        let mut cascades = Cascades::default();
        change(&mut cascades);
        Light { cascades: Some(cascades), ..Light::directional(Vec3::NEG_Y) }
    };
    let check = |light: Light, problem: &str| {
        let bounds = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE };
        let error = light_views(3, &light, 64, Some(&Camera::default()), &bounds).unwrap_err();
        assert_named(&error.into(), "light 3 ", problem);
    };
    check(sun(|it| it.lambda = f32::NAN), "lambda");
    check(sun(|it| it.lambda = 1.5), "lambda");
    check(sun(|it| it.fade = -0.1), "fade");
    check(sun(|it| it.fade = f32::NAN), "fade");
    check(sun(|it| it.range = Some(0.0)), "range");
    check(sun(|it| it.range = Some(f32::INFINITY)), "range");
    let lamp = || Light::point(Vec3::Y * 4.0);
    check(Light { intensity: f32::NAN, ..lamp() }, "intensity");
    check(Light { intensity: -1.0, ..lamp() }, "intensity");
    check(Light { color: Vec3::new(1.0, f32::INFINITY, 1.0), ..lamp() }, "color");
    check(Light { near: Some(0.0), ..lamp() }, "near");
    check(Light { near: Some(f32::NAN), ..lamp() }, "near");
    check(Light { near: Some(2.0), far: Some(2.0), ..lamp() }, "far");
    check(Light { far: Some(f32::NAN), ..lamp() }, "far");
    let kind = LightKind::Point { position: Vec3::Y };
    let further = Shadow { kind, near: Some(-1.0), far: None, size: None, cascades: None };
    check(Light { shadows: vec![further], ..lamp() }, "near");

    let wrong: [(&str, Change); 9] = [
        ("box", |it| it.2.min.x = f32::NAN),
        ("box", |it| it.2.max.z = f32::INFINITY),
        ("box", |it| it.2.max.y = f32::MAX),
        ("camera", |it| it.1.eye.x = f32::NAN),
        ("camera", |it| it.1.target = it.1.eye),
        ("camera", |it| it.1.up = Vec3::ZERO),
        ("camera", |it| it.1.fov_y = 0.0),
        ("camera", |it| it.1.fov_y = f32::NAN),
        ("camera", |it| it.1.size.y = 0),
    ];
    for (problem, change) in wrong {
        let bounds = Bounds { min: Vec3::NEG_ONE, max: Vec3::ONE };
        let mut it = (sun(|_| ()), Camera::default(), bounds);
        light_views(3, &it.0, 64, Some(&it.1), &it.2).unwrap();
        change(&mut it);
        let error = light_views(3, &it.0, 64, Some(&it.1), &it.2).unwrap_err();
        assert_named(&error.into(), "light 3 ", problem);
    }
    // Nothing to shadow is no error.
    light_views(3, &lamp(), 64, None, &Bounds::EMPTY).unwrap();
}

#[test]
fn casters_out_of_range_are_named() {
    type Change = fn(&mut (Particle, Triangle));
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let materials = materials();
    let wrong: [(&str, &str, Change); 12] = [
        ("particle 0 ", "centre", |it| it.0.center.x = 1e8),
        ("particle 0 ", "centre", |it| it.0.center.x = f32::NAN),
        ("particle 0 ", "radius", |it| it.0.radius = 1e30),
        ("particle 0 ", "radius", |it| it.0.radius = f32::NAN),
        ("particle 0 ", "alpha", |it| it.0.color.w = f32::NAN),
        ("particle 0 ", "alpha", |it| it.0.color.w = -0.5),
        ("particle 0 ", "alpha", |it| it.0.color.w = 1.5),
        ("particle 0 ", "colour", |it| it.0.color.y = 2.0),
        ("particle 0 ", "rotation", |it| it.0.rotation = f32::INFINITY),
        ("triangle 0 ", "corners", |it| it.1.positions[2].z = f32::NAN),
        ("triangle 0 ", "normals", |it| it.1.normals[1].z = f32::NAN),
        ("triangle 0 ", "texture coordinates", |it| it.1.uvs[0] = Vec2::NAN),
    ];
    let mut prepare = |particle, triangle| {
        let (particles, triangles) = ([particle], [triangle]);
        let casters = Casters {
            particles: &particles,
            triangles: &triangles,
            materials: &materials,
            ..Casters::default()
        };
        shadows.prepare(&casters, &views(), &ShadowSettings::default())
    };
    let right = (Particle::default(), Triangle::flat([Vec3::X, Vec3::Y, Vec3::Z], 2));
    prepare(right.0, right.1).unwrap();
    for (what, problem, change) in wrong {
        let mut it = right;
        change(&mut it);
        assert_named(&prepare(it.0, it.1).unwrap_err(), what, problem);
    }
}

#[test]
fn what_a_host_says_of_a_set_is_checked() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let loader = host.loader(&shadows);
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let set = HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(4), &[0]);
    let mut prepare = |set| {
        let sets = [set];
        let inputs = HostInputs::new().casters(&sets);
        shadows.prepare_with(&casters, &views(), &ShadowSettings::default(), &inputs)
    };
    let around = |min, max| set.bounds(Bounds { min, max });
    prepare(around(Vec3::NEG_ONE, Vec3::ONE).least_alpha(0.5)).unwrap();
    prepare(set.bounds(Bounds::EMPTY)).unwrap();
    for (set, problem) in [
        (around(Vec3::NAN, Vec3::ONE), "box"),
        (around(Vec3::NEG_ONE, Vec3::splat(f32::INFINITY)), "box"),
        (around(Vec3::ONE, Vec3::NEG_ONE), "box"),
        (set.least_alpha(f32::NAN), "alpha"),
        (set.least_alpha(-0.1), "alpha"),
    ] {
        assert_named(&prepare(set).unwrap_err(), "set of host casters 0 ", problem);
    }
}

/// NaN that the host's WGSL makes when it runs, in each number of a caster.
#[test]
fn casters_with_nan_of_the_device_are_counted() {
    for tier in TIERS {
        let gpu = gpu(tier);
        let mut shadows = shadows(&gpu);
        let minus = gpu.upload("minus", &[-1.0_f32; 16], BufferUsages::STORAGE);
        let (layout, bindings) = bound(&gpu, &[minus]);
        let wgsl = "
@group(1) @binding(0) var<storage, read> minus: array<f32>;
fn load_caster(index: u32) -> Caster {
    let zero = minus[index] + 1.0;
    var nan = sqrt(minus[index]);
    if index % 2u == 1u { nan = zero / zero; }
    var caster = Caster(vec3(0.0, 0.1 * f32(index), 0.0), 0.3, vec4(0.5), 0.0, 0u, index);
    switch index / 2u {
        case 0u: { caster.center.x = nan; }
        case 1u: { caster.center.z = nan; }
        case 2u: { caster.radius = nan; }
        case 3u: { caster.color.r = nan; }
        case 4u: { caster.color.b = nan; }
        case 5u: { caster.color.a = nan; }
        case 6u: { caster.rotation = nan; }
        default: {}
    }
    return caster;
}";
        let loader = shadows.caster_loader("nan.wgsl", wgsl, &layout).unwrap();
        let materials = materials();
        let casters = Casters { materials: &materials, ..Casters::default() };
        let sets = [HostCasters::new(&loader, &bindings, CasterCount::Fixed(16), &[0])];
        let inputs = HostInputs::new().casters(&sets);
        let settings = ShadowSettings::default();
        let prepared = shadows.prepare_with(&casters, &views(), &settings, &inputs).unwrap();
        submit(&gpu, &prepared);
        let counters = prepared.counters().unwrap();
        let skipped: u64 = counters.skipped.values().sum();
        assert_eq!((counters.casters, skipped), (2, 14), "{tier:?} {counters:?}");
    }
}

fn texture(gpu: &gobo::Gpu, dimension: wgpu::TextureDimension) -> wgpu::Texture {
    let is_volume = dimension == wgpu::TextureDimension::D3;
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d {
            width: 64,
            height: 64,
            depth_or_array_layers: if is_volume { 8 } else { 1 },
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension,
        format: wgpu::TextureFormat::R32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    })
}

/// Also textures that were read in the frame before.
#[test]
fn destroyed_textures_are_named() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (views, settings) = (views(), ShadowSettings::default());
    let materials = [gobo::Material { shape: gobo::Shape::Brick, ..Default::default() }];
    let casters = Casters { materials: &materials, ..Casters::default() };
    let lights = [Light::point(Vec3::new(0.3, 0.2, -0.1))];
    let [depth, seen] = [(); 2].map(|()| texture(&gpu, wgpu::TextureDimension::D2));
    let density = texture(&gpu, wgpu::TextureDimension::D3);
    let (grid, mut masks) = (Grid::default(), LightMasks::new());
    let mask_view = MaskView::new(views[6].clip_from_world().to_cols_array_2d(), &seen);
    let (depths, grids) = ([HostDepth::new(6, &depth)], [HostGrid::new(&density, &grid)]);
    let of_depths = HostInputs::new().depths(&depths);
    let of_grids = HostInputs::new().grids(&grids);
    let mut all = || {
        let of_grids = shadows.prepare_with(&casters, &views, &settings, &of_grids);
        let of_depths = shadows.prepare_with(&casters, &views, &settings, &of_depths);
        let prepared = shadows.prepare(&casters, &views, &settings).unwrap();
        let of_masks =
            masks.prepare(&prepared, &lights, &[0], &mask_view, &MaskSettings::default());
        [of_grids.map(drop), of_depths.map(drop), of_masks]
    };
    for _ in 0..2 {
        assert!(all().iter().all(Result::is_ok), "{:?}", all());
    }
    [&depth, &seen, &density].into_iter().for_each(wgpu::Texture::destroy);
    let wanted = ["host grid 0 ", "depth map of the host's 0 ", "view of masks 0 "];
    for (result, what) in all().into_iter().zip(wanted) {
        assert_named(&result.unwrap_err(), what, "destroyed");
    }
    gpu.check().unwrap();
}

#[test]
fn masks_out_of_range_are_named() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (views, materials) = (views(), materials());
    let casters = Casters { materials: &materials, ..Casters::default() };
    let prepared = shadows.prepare(&casters, &views, &ShadowSettings::default()).unwrap();
    let depth = texture(&gpu, wgpu::TextureDimension::D2);
    let view = MaskView::new(views[6].clip_from_world().to_cols_array_2d(), &depth);
    let lights = [Light::point(Vec3::ZERO)];
    for sensitivity in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let settings = MaskSettings { sensitivity, ..MaskSettings::default() };
        let error = LightMasks::new().prepare(&prepared, &lights, &[0], &view, &settings);
        assert_named(&error.unwrap_err(), "mask setting 0 ", "sensitivity");
    }
}

#[test]
fn every_call_says_that_a_device_is_lost() {
    let gpu = own_gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (views, materials) = (views(), materials());
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let loader = host.loader(&shadows);
    let sets = [HostCasters::new(&loader, &host.bindings, CasterCount::Fixed(4), &[0])];
    let inputs = HostInputs::new().casters(&sets);
    let casters = Casters { materials: &materials, ..Casters::default() };
    let settings = ShadowSettings::default();
    let prepared = shadows.prepare_with(&casters, &views, &settings, &inputs).unwrap();
    let positions = gpu.upload("positions", &[0.0_f32; 3], BufferUsages::STORAGE);
    let points = PointBuffers { count: 1, positions: &positions, normals: None };
    let depth = texture(&gpu, wgpu::TextureDimension::D2);
    let seen = MaskView::new(views[6].clip_from_world().to_cols_array_2d(), &depth);
    let lights = [Light::point(Vec3::new(0.3, 0.2, -0.1))];
    let mut all = || {
        vec![
            prepared.bind_lights(&lights, &[0]).map(drop),
            prepared.bind_area_lights(&lights, &[0]).map(drop),
            prepared.light_points(&lights, &[0], &points).map(drop),
            prepared.converted(&MapLayout::new(FilterFormat::Rgba8Unorm)).map(drop),
            LightMasks::new().prepare(&prepared, &lights, &[0], &seen, &MaskSettings::default()),
            prepared.rebind(0, &host.bindings),
            shadows.caster_loader("host.wgsl", super::WGSL, &host.layout).map(drop),
            shadows.simulation(&Forces::default()).map(drop),
            prepared.counters().map(drop),
            shadows.statistics().map(drop),
        ]
    };
    assert!(all().iter().all(Result::is_ok), "{:?}", all());
    gpu.device.destroy();
    for (call, result) in all().into_iter().enumerate() {
        assert!(matches!(result, Err(Error::Lost(_))), "{call}: {result:?}");
    }
    let pending = shadows.pending(&casters, &views, &settings, &inputs);
    assert!(matches!(pending, Err(Error::Lost(_))), "{pending:?}");
}

#[test]
fn layouts_of_another_device_are_errors() {
    let [gpu, other] = two_devices();
    let foreign = HostBuffers::new(&other, &particles(4, 1));
    let shadows = shadows(&gpu);
    let error = shadows.caster_loader("host.wgsl", super::WGSL, &foreign.layout).unwrap_err();
    assert!(matches!(error, Error::Kernel(gobo::KernelError::OtherLayout { .. })), "{error:?}");
    // Bindings of another device.
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let loader = host.loader(&shadows);
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let sets = [HostCasters::new(&loader, &foreign.bindings, CasterCount::Fixed(4), &[0])];
    let inputs = HostInputs::new().casters(&sets);
    let mut shadows = shadows;
    let prepared = shadows.prepare_with(&casters, &views(), &ShadowSettings::default(), &inputs);
    let error = prepared.unwrap_err();
    assert!(matches!(error, Error::Invalid { what: Input::HostCasters, .. }), "{error:?}");
    gpu.check().unwrap();
}

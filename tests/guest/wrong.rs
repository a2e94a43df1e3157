//! Invalid host casters are errors with a position.
use super::{
    HostBuffers, HostCasters, HostInputs, ShadowSettings, WGSL, count_buffer, materials, particles,
    shadows, views,
};
use crate::common::{TIERS, gpu, own_gpu, two_devices};
use gobo::{
    Bounds, CasterCount, Casters, Error, Light, Material, Receiver, View,
    glam::{UVec2, Vec3},
    host::{FilterFormat, Input, LightMasks, MapLayout, MaskView, PointBuffers},
    light_views,
    model::{MaskSettings, ShadowFilter, ViewRole},
    wgpu::{self, BufferUsages},
};

#[test]
fn errors_point_into_the_hosts_text() {
    let gpu = gpu(TIERS[0]);
    let shadows = shadows(&gpu);
    let host = HostBuffers::new(&gpu, &particles(1, 1));
    let error = |text: &str| {
        let error = shadows.caster_loader("smoke.wgsl", text, &host.layout).unwrap_err();
        assert!(matches!(error, Error::Kernel(_)), "{error:?}");
        error.to_string()
    };
    let line = |of: &str| 1 + WGSL.lines().position(|line| line.contains(of)).unwrap();
    for (from, to) in [
        // Invalid WGSL, an unknown name, a wrong type.
        ("let place = casters", "let = casters"),
        ("place.xyz, place.w, is_usable", "place.xyz, placed.w, is_usable"),
        ("let look = looks[index]", "let look: f32 = looks[index]"),
    ] {
        let message = error(&WGSL.replace(from, to));
        let at = format!("smoke.wgsl:{}:", line(from));
        assert!(message.contains(&at), "{at} {message}");
    }
    // Errors that only validation finds are reported at the function.
    let message = error(&WGSL.replace("Caster(place.xyz, ", "Caster(place.xy, "));
    let at = format!("smoke.wgsl:{}:", line("fn load_caster"));
    assert!(message.contains(&at), "{at} {message}");
    let none = error("fn unload() {}");
    assert!(
        none.contains("load_caster") && none.contains("wgsl/load/load_casters.wgsl:"),
        "{none}"
    );
    // Bindings that do not match the layout.
    assert!(error(&WGSL.replace("@group(1) @binding(4)", "@group(1) @binding(5)")).contains("5"));
    assert!(error(&WGSL.replace("@group(1) @binding(4)", "@group(0) @binding(99)")).contains("99"));
    assert!(gpu.check().is_ok());
}

#[test]
fn sets_that_cannot_be_used_are_named() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let loader = host.loader(&shadows);
    let counts = count_buffer(&gpu, 4);
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let set = |count, materials| HostCasters::new(&loader, &host.bindings, count, materials);
    let good = set(CasterCount::Fixed(4), &[0][..]);
    let at = |offset| CasterCount::Indirect { buffer: &counts, offset, capacity: 4 };
    let mut error = |wrong: HostCasters<'_>| {
        let sets = [good, wrong];
        let inputs = HostInputs::new().casters(&sets);
        shadows.prepare_with(&casters, &views(), &ShadowSettings::default(), &inputs).unwrap_err()
    };
    for (wrong, problem) in [
        (set(CasterCount::Fixed(4), &[]), "no material"),
        (set(CasterCount::Fixed(4), &[6]), "not among"),
        (set(CasterCount::Fixed(4), &[5]), "casts nothing"),
        (set(CasterCount::Fixed(4), &[0, 2]), "two sets"),
        (set(at(2), &[0]), "multiple of 4"),
        (set(at(16), &[0]), "ends before"),
    ] {
        let message = error(wrong).to_string();
        assert!(message.starts_with("set of host casters 1 "), "{message}");
        assert!(message.contains(problem), "{message}");
    }
    let uniform = gpu.upload("count", &[4_u32; 4], BufferUsages::UNIFORM);
    let counted = CasterCount::Indirect { buffer: &uniform, offset: 0, capacity: 4 };
    assert!(matches!(error(set(counted, &[0])), Error::Kernel(_)));
    assert!(matches!(error(set(CasterCount::Fixed(u32::MAX), &[0])), Error::Limit { .. }));
    // More records than a storage binding of the core tier.
    let past = error(set(CasterCount::Fixed((128 << 20) / 32), &[0]));
    let Error::Limit { limit, have, need, .. } = past else { panic!("{past}") };
    assert_eq!((limit, have), ("max_storage_buffer_binding_size", 128 << 20));
    assert_eq!(need, have + 2 * 32 * 1024);
    assert!(gpu.check().is_ok());
}

#[test]
fn a_loader_of_another_device_is_refused() {
    let [gpu, other] = two_devices();
    let foreign_loader = HostBuffers::new(&other, &particles(4, 1)).loader(&shadows(&other));
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let sets = [HostCasters::new(&foreign_loader, &host.bindings, CasterCount::Fixed(4), &[0])];
    let inputs = HostInputs::new().casters(&sets);
    let prepared =
        shadows(&gpu).prepare_with(&casters, &views(), &ShadowSettings::default(), &inputs);
    assert!(matches!(prepared.unwrap_err(), Error::Kernel(_)));
    assert!(gpu.check().is_ok());
}

#[test]
fn numbers_out_of_range_are_named() {
    type Change = fn(&mut (Vec<Material>, Vec<View>, ShadowSettings));
    let gpu = gpu(TIERS[0]);
    let wrong: [(&str, &str, Change); 17] = [
        ("material 1 ", "tint", |it| it.0[1].tint.x = f32::NAN),
        ("material 1 ", "tint", |it| it.0[1].tint.y = 1.5),
        ("material 0 ", "alpha", |it| it.0[0].tint.w = 3.0),
        ("material 0 ", "reflectivity", |it| it.0[0].reflectivity = 2.0),
        ("material 0 ", "pattern", |it| it.0[0].pattern_scale = 0),
        ("material 0 ", "emission", |it| it.0[0].emission.z = f32::NEG_INFINITY),
        ("material 0 ", "attenuation", |it| it.0[0].attenuation_color.x = -1.0),
        ("material 0 ", "distance", |it| it.0[0].attenuation_distance = f32::NAN),
        ("view 1 ", "scale", |it| it.1[1].scale = f32::NAN),
        ("view 0 ", "scale", |it| it.1[0].scale = 0.0),
        ("view 1 ", "fade", |it| {
            it.1[1].role = ViewRole::Window { index: 0, count: 1, fade: f32::NAN };
        }),
        ("setting", "bias", |it| it.2.bias = Some(f32::NAN)),
        ("setting", "bias", |it| it.2.normal_bias = -1.0),
        ("setting", "taps", |it| it.2.filter = ShadowFilter::Pcf { taps: 0 }),
        ("setting", "nodes", |it| (it.2.receiver, it.2.nodes) = (Receiver::Curve, 0)),
        ("setting", "budget", |it| it.2.pair_budget = u32::MAX),
        ("setting", "blur", |it| it.2.blur = 17),
    ];
    let all = || (materials(), views().to_vec(), ShadowSettings::default());
    for (what, problem, change) in wrong {
        let mut inputs = all();
        change(&mut inputs);
        let (materials, views, settings) = inputs;
        let casters = Casters { materials: &materials, ..Casters::default() };
        let error = shadows(&gpu).prepare(&casters, &views, &settings).unwrap_err().to_string();
        assert!(error.starts_with(what) && error.contains(problem), "{what} {problem}: {error}");
    }
    let (materials, views, settings) = all();
    let casters = Casters { materials: &materials, ..Casters::default() };
    shadows(&gpu).prepare(&casters, &views, &settings).unwrap();
    assert!(gpu.check().is_ok());
}

/// A bind group of another layout is found when it is passed, not when the host finishes its commands.
#[test]
fn bindings_of_another_layout_are_refused() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let host = HostBuffers::new(&gpu, &particles(4, 1));
    let loader = host.loader(&shadows);
    let layout = gpu
        .device
        .create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: None, entries: &[] });
    let desc = wgpu::BindGroupDescriptor { label: None, layout: &layout, entries: &[] };
    let other = gpu.device.create_bind_group(&desc);
    let materials = materials();
    let casters = Casters { materials: &materials, ..Casters::default() };
    let mut prepare = |bindings| {
        let sets = [HostCasters::new(&loader, bindings, CasterCount::Fixed(4), &[0])];
        let inputs = HostInputs::new().casters(&sets);
        shadows.prepare_with(&casters, &views(), &ShadowSettings::default(), &inputs)
    };
    let is_refused = |error: &Error| {
        let of_casters = matches!(error, Error::Invalid { what: Input::HostCasters, .. });
        of_casters && error.to_string().contains("layout")
    };
    assert!(is_refused(&prepare(&other).unwrap_err()));
    let prepared = prepare(&host.bindings).unwrap();
    assert!(is_refused(&prepared.rebind(0, &other).unwrap_err()));
    // Even if the rest of the set is the same.
    assert!(is_refused(&prepare(&other).unwrap_err()));
    let prepared = prepare(&host.bindings).unwrap();
    prepared.rebind(0, &host.bindings).unwrap();
    super::submit(&gpu, &prepared);
}

#[test]
fn nothing_reads_maps_that_were_taken_over() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (materials, particles) = (materials(), particles(20, 1));
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let settings = ShadowSettings { size: 16, ..ShadowSettings::default() };
    let bounds = Bounds { min: Vec3::splat(-2.5), max: Vec3::splat(2.5) };
    let lights = [Light::spot(Vec3::Y * 4.0, Vec3::NEG_Y, 0.9)];
    let views = light_views(0, &lights[0], 16, None, &bounds).unwrap();
    let mut prepare = || shadows.prepare(&casters, &views, &settings).unwrap();
    let positions = gpu.upload("positions", &[0.0_f32; 3], BufferUsages::STORAGE);
    let points = PointBuffers { count: 1, positions: &positions, normals: None };
    let depth = gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 16, height: 16, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Depth32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    });
    let columns = views[0].clip_from_world().to_cols_array_2d();
    let seen = MaskView::new(columns, &depth);
    let layout = MapLayout::new(FilterFormat::Rgba8Unorm);
    let read = |prepared: &gobo::Prepared| {
        let masks = MaskSettings::default();
        [
            prepared.bind_lights(&lights, &[0]).map(drop),
            prepared.bind_area_lights(&lights, &[0]).map(drop),
            prepared.light_points(&lights, &[0], &points).map(drop),
            prepared.converted(&layout).map(drop),
            LightMasks::new().prepare(prepared, &lights, &[0], &seen, &masks),
            prepared.rebind(0, &HostBuffers::new(&gpu, &[]).bindings),
        ]
    };
    let first = prepare();
    assert!(read(&first)[..5].iter().all(Result::is_ok));
    let second = prepare();
    for (i, result) in read(&first).into_iter().enumerate() {
        assert!(matches!(result, Err(Error::Superseded)), "{i}: {result:?}");
    }
    assert!(read(&second)[..5].iter().all(Result::is_ok));
    assert!(gpu.check().is_ok());
}

/// Maps that exceed the memory, and the last maps after them.
#[test]
fn no_memory_is_an_error_and_keeps_the_last_maps() {
    let gpu = own_gpu(TIERS[0]);
    let mut shadows = shadows(&gpu);
    let (materials, particles) = (materials(), particles(200, 3));
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let settings = ShadowSettings { size: 64, ..ShadowSettings::default() };
    let small = shadows.prepare(&casters, &views(), &settings).unwrap();
    let before = super::submit(&gpu, &small);
    // 128 GiB of filters, and as much of depths: more than a card has.
    let large: Vec<View> = (0..128)
        .flat_map(|_| views())
        .take(1024)
        .map(|view| View { size: UVec2::splat(4096), ..view })
        .collect();
    let error = shadows.prepare(&casters, &large, &settings).unwrap_err();
    assert!(matches!(error, Error::Memory(_)), "{error}");
    assert!(gpu.check().is_ok(), "the host's handler hears of it");
    assert!(super::submit(&gpu, &small) == before);
    let again = shadows.prepare(&casters, &views(), &settings).unwrap();
    assert!(super::submit(&gpu, &again) == before);
}

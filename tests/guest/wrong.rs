//! Invalid host casters are errors with a position.
use super::{
    HostBuffers, HostCasters, HostInputs, ShadowSettings, WGSL, count_buffer, materials, particles,
    shadows, views,
};
use crate::common::{TIERS, gpu, two_devices};
use gobo::{
    CasterCount, Casters, Error, Material, Receiver, View, model::ShadowFilter, wgpu::BufferUsages,
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
    let wrong: [(&str, &str, Change); 16] = [
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
        ("setting", "bias", |it| it.2.bias = f32::NAN),
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

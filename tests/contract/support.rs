//! Required features and limits of a device, and invalid calls: each is an error of its own type.
use crate::common::{
    TIERS, gpu, own_gpu,
    scenes::{empty, light, material, particle},
    two_devices,
};
use gobo::{
    Bounds, Casters, Error, Light, LightKind, ShadowSettings, Shadows, Support, Tier, Transfer,
    glam::{Vec3, Vec4},
    gpu::{Kernel, KernelError, Resources, Selection},
    host::{Input, Missing, Need, Requirement},
    light_views,
    model::InvalidLight,
    shadows::Config,
    stage::bin,
    wgpu::{self, AdapterInfo, Device, Features, Limits, Queue},
};
use gobo_picture::{RenderOptions, Renderer};
use gobo_scene::Scene;

fn open(features: Features, limits: Limits) -> (Device, Queue, AdapterInfo) {
    let adapters = gobo::gpu::adapters(&Selection::default());
    let adapter = adapters.first().expect("there is an adapter");
    let request = adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: features,
        required_limits: limits,
        ..Default::default()
    });
    let (device, queue) = pollster::block_on(request).unwrap();
    (device, queue, adapter.get_info())
}

fn limits_of(missing: &[Missing]) -> Vec<&'static str> {
    let name = |missing: &Missing| match missing.requirement {
        Requirement::Limit { name, .. } => Some(name),
        _ => None,
    };
    missing.iter().filter_map(name).collect()
}

#[test]
fn a_device_opened_as_the_settings_say_runs() {
    let settings = ShadowSettings::default();
    for &tier in Tier::ALL {
        let (device, queue, info) = open(settings.features(tier), settings.limits(tier, 4096));
        let support = Support::of(&device, &info, &settings);
        assert_eq!(support.tier, Some(tier));
        support.check(tier).unwrap();
        let mut shadows = Shadows::new(&device, &queue, &info).unwrap();
        shadows.configure(|config| assert_eq!(config.tier, tier));
        // Optional features are listed, but are no reason to refuse.
        let comfort = support.missing.iter().filter(|missing| missing.needed_for > Need::Native);
        assert!(comfort.count() > 0, "{:?}", support.missing);
    }
}

#[test]
fn native_without_its_features_is_refused_with_their_names() {
    let (device, queue, info) = open(Features::empty(), Limits::default());
    let support = Support::of(&device, &info, &ShadowSettings::default());
    assert_eq!(support.tier, Some(Tier::Core));
    let of_support = support.check(Tier::Native).unwrap_err();
    let of_shadows = Shadows::on_tier(&device, &queue, &info, Tier::Native).unwrap_err();
    for error in [of_support, of_shadows] {
        let text = error.to_string();
        let Error::Unsupported { tier: Tier::Native, missing } = error else { panic!("{text}") };
        let features = missing.iter().filter_map(|missing| match missing.requirement {
            Requirement::Feature(feature) => Some(feature),
            _ => None,
        });
        assert_eq!(features.fold(Features::empty(), Features::union), Tier::Native.features());
        for Missing { requirement, needed_for, .. } in &missing {
            let is_subgroup = *requirement == Requirement::Feature(Features::SUBGROUP);
            let need = if is_subgroup { Need::Subgroups } else { Need::Native };
            assert_eq!(*needed_for, need, "{requirement:?}");
        }
        assert_eq!(limits_of(&missing), ["max_storage_textures_per_shader_stage"]);
        assert!(text.contains("SUBGROUP") && text.contains("is 4 and must be 9"), "{text}");
    }
    let of_subgroups = support.check(Tier::Subgroups).unwrap_err().to_string();
    assert!(
        of_subgroups.contains("SUBGROUP") && !of_subgroups.contains("ATOMIC"),
        "{of_subgroups}"
    );
    assert!(Shadows::on_tier(&device, &queue, &info, Tier::Core).is_ok());
}

/// With too few storage textures, the features alone do not make it native.
#[test]
fn limits_choose_the_tier_too() {
    let (device, queue, info) = open(Tier::Native.features(), Limits::default());
    let support = Support::of(&device, &info, &ShadowSettings::default());
    assert_eq!(support.tier, Some(Tier::Subgroups));
    assert!(Shadows::on_tier(&device, &queue, &info, Tier::Native).is_err());
    let mut shadows = Shadows::new(&device, &queue, &info).unwrap();
    shadows.configure(|config| assert_eq!(config.tier, Tier::Subgroups));
}

#[test]
fn small_limits_are_all_named() {
    let few = Limits { max_storage_buffers_per_shader_stage: 7, ..Limits::default() };
    let small = Limits { max_texture_dimension_2d: 4096, ..few.clone() };
    let names = ["max_texture_dimension_2d", "max_storage_buffers_per_shader_stage"];
    for (limits, named) in [
        (few, &names[1..]),
        (small, &names[..]),
        (Limits::downlevel_defaults(), &["max_texture_dimension_2d"][..]),
    ] {
        let (device, queue, info) = open(Features::empty(), limits);
        let support = Support::of(&device, &info, &ShadowSettings::default());
        assert_eq!(support.tier, None);
        let error = Shadows::new(&device, &queue, &info).unwrap_err();
        let Error::Unsupported { tier: Tier::Core, missing } = error else { panic!("{error}") };
        for name in named {
            assert!(limits_of(&missing).contains(name), "{missing:?}");
            assert!(limits_of(&support.missing).contains(name), "{support:?}");
        }
        assert!(missing.iter().all(|missing| missing.needed_for == Need::Core));
    }
}

const BOX: Bounds = Bounds { min: Vec3::splat(-2.0), max: Vec3::splat(2.0) };

#[test]
fn a_direction_of_any_length_works_and_none_is_refused() {
    let along = Vec3::new(0.36, -0.8, 0.48);
    let unit = light_views(0, &Light::directional(along), 64, None, &BOX).unwrap();
    for length in [1e-38, 1e-3, 0.5, 2.0, 1e30] {
        let views = light_views(0, &Light::directional(along * length), 64, None, &BOX).unwrap();
        let apart = views[0].view_from_world.to_cols_array();
        let apart = apart.iter().zip(unit[0].view_from_world.to_cols_array());
        assert!(apart.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max) < 1e-5, "{length}");
    }
    let spot = |direction, angle| LightKind::Spot { position: Vec3::Y, direction, angle };
    for (kind, problem) in [
        (LightKind::Directional { direction: Vec3::ZERO }, "direction"),
        (LightKind::Directional { direction: Vec3::NAN }, "direction"),
        (LightKind::Directional { direction: Vec3::new(0.0, f32::INFINITY, 0.0) }, "direction"),
        (spot(Vec3::ZERO, 1.0), "direction"),
        (spot(Vec3::NEG_Y, 0.0), "angle"),
        (spot(Vec3::NEG_Y, f32::NAN), "angle"),
        (spot(Vec3::NEG_Y, 3.2), "angle"),
        (LightKind::Point { position: Vec3::NAN }, "position"),
    ] {
        let InvalidLight { index, problem: found, .. } =
            light_views(7, &light(kind), 64, None, &BOX).unwrap_err();
        assert!(index == 7 && found.contains(problem), "{kind:?}: {found}");
        // A further shadow counts too.
        let mut lamp = Light::point(Vec3::Y);
        let size = Some(64);
        lamp.shadows =
            vec![gobo::model::Shadow { kind, near: None, far: None, size, cascades: None }];
        assert!(light_views(7, &lamp, 64, None, &BOX).is_err());
    }
}

#[test]
fn maps_of_no_or_too_many_texels_are_refused() {
    let gpu = gpu(TIERS[0]);
    let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter).unwrap();
    let (particles, materials) =
        ([particle(Vec3::ZERO, 0.1, Vec4::ONE)], [material(Transfer::Filter)]);
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    for size in [0, 15, 4097, 20_000, u32::MAX] {
        let views = light_views(0, &Light::point(Vec3::Y * 3.0), size, None, &BOX).unwrap();
        let error = shadows.prepare(&casters, &views, &ShadowSettings::default()).unwrap_err();
        assert!(
            matches!(error, Error::Invalid { what: Input::View, index: 0, .. }),
            "{size}: {error}"
        );
    }
}

/// A scene made by a program, on the GPU and on the CPU.
#[test]
fn a_scene_that_cannot_be_rendered_is_an_error() {
    let mut good = empty(vec![material(Transfer::Filter)]);
    good.particles = vec![particle(Vec3::ZERO, 0.1, Vec4::ONE)];
    good.lights = vec![Light::directional(Vec3::NEG_Y)];
    let changed = |change: fn(&mut Scene)| {
        let mut scene = good.clone();
        change(&mut scene);
        scene
    };
    for mut renderer in [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on_cpu()] {
        let mut error = |change| {
            renderer.render(&changed(change), &RenderOptions::default()).unwrap_err().to_string()
        };
        assert!(error(|scene| scene.particles[0].material = 1).starts_with("particle 0 "));
        assert!(error(|scene| scene.materials[0].texture = Some(0)).starts_with("material 0 "));
        let unaimed = |scene: &mut Scene| {
            scene.lights[0].kind = LightKind::Directional { direction: Vec3::ZERO };
        };
        assert!(error(unaimed).starts_with("light 0 "));
        for change in [|s: &mut Scene| s.shadow.size = 0, |s: &mut Scene| s.shadow.size = 20_000] {
            assert!(error(change).starts_with("view 0 "));
        }
        renderer.render(&good, &RenderOptions::default()).unwrap();
    }
}

#[test]
fn kernels_of_another_device_are_refused_or_made_again() {
    let [own, other] = two_devices();
    let kernel = Kernel::new(&own.device, &bin::SCAN, Tier::Core, &[], &[]).unwrap();
    match kernel.bind(&other.device, &Resources::new()) {
        Err(KernelError::OtherDevice { kernel: "bin_scan" }) => {}
        wrong => panic!("{wrong:?}"),
    }
    let config = Config::new(Tier::Core, &own.adapter);
    // The cache knows each kernel's device.
    let cache = own.kernels.clone();
    cache.kernel(&own.device, &bin::SCAN, Tier::Core, &[], &[]).unwrap();
    let mut shadows = Shadows::sharing(&other.device, &other.queue, config, cache).unwrap();
    let (particles, materials) =
        ([particle(Vec3::ZERO, 0.5, Vec4::splat(0.5))], [material(Transfer::Filter)]);
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let views = light_views(0, &Light::directional(Vec3::NEG_Y), 64, None, &BOX).unwrap();
    let prepared = shadows.prepare(&casters, &views, &ShadowSettings::default()).unwrap();
    let mut encoder = other.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    other.queue.submit([encoder.finish()]);
    assert_eq!(prepared.counters().unwrap().visible, 1);
    assert!(other.check().is_ok());
}

#[test]
fn a_lost_device_is_an_error() {
    let gpu = own_gpu(TIERS[0]);
    let mut shadows = Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter).unwrap();
    let (particles, materials) =
        ([particle(Vec3::ZERO, 0.5, Vec4::splat(0.5))], [material(Transfer::Filter)]);
    let casters = Casters { particles: &particles, materials: &materials, ..Casters::default() };
    let views = light_views(0, &Light::directional(Vec3::NEG_Y), 64, None, &BOX).unwrap();
    let settings = ShadowSettings::default();
    let prepared = shadows.prepare(&casters, &views, &settings).unwrap();
    gpu.device.destroy();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    gpu.queue.submit([encoder.finish()]);
    assert!(matches!(prepared.counters(), Err(Error::Lost(_))));
    assert!(matches!(shadows.prepare(&casters, &views, &settings), Err(Error::Lost(_))));
    assert!(matches!(Shadows::new(&gpu.device, &gpu.queue, &gpu.adapter), Err(Error::Lost(_))));
}

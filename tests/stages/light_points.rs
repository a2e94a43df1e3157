//! Light at points: the look-up against closed forms and against its CPU reference.
use crate::common::{
    TIERS, gpu, map_frame,
    scenes::{Chance, empty, light, material, particle, random_discs, triangle},
    two_devices,
};
use gobo::{
    Bounds, Casters, Error, Light, LightKind, Material, Prepared, Receiver, ShadowSettings,
    Transfer,
    glam::{Vec3, Vec4},
    gpu::Gpu,
    host::PointBuffers,
    light_views,
    model::{Profile, ReceiverPoint},
    view::shadow_views,
    wgpu::BufferUsages,
};
use gobo_picture::Renderer;
use gobo_reference::light_points;
use gobo_scene::Scene;

/// Rounding of a map's storage: 12 bits of a curve's light, f16 of a filter.
const ROUNDING: f32 = 1e-3;
pub(super) const RED: Vec4 = Vec4::new(1.0, 0.2, 0.4, 0.5);
pub(super) const BLUE: Vec4 = Vec4::new(0.1, 0.3, 0.9, 0.6);

pub(super) fn through(color: Vec4) -> Vec3 {
    Vec3::ONE - color.w * (Vec3::ONE - color.truncate())
}

/// A red disc at y = 1 and a blue one at y = 2, over an opaque floor at y = 0, under a sun and a lamp.
pub(super) fn layers(receiver: Receiver) -> Scene {
    let flat = Material { profile: Profile::Flat, ..material(Transfer::Filter) };
    let mut scene = empty(vec![flat, material(Transfer::Opaque)]);
    scene.particles =
        vec![particle(Vec3::Y, 3.0, RED), particle(Vec3::new(0.0, 2.0, 0.0), 3.0, BLUE)];
    let corner = |x: f32, z: f32| Vec3::new(x, 0.0, z) * 3.0;
    let [a, b, c, d] =
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| corner(x, z));
    scene.triangles = vec![triangle([a, b, c], 1), triangle([a, c, d], 1)];
    scene.shadow.receiver = receiver;
    scene.lights = vec![
        // Its length does not matter.
        Light::directional(Vec3::NEG_Y * 1e-3),
        Light::point(Vec3::new(0.0, 4.0, 0.0)),
    ];
    scene
}

fn at(y: f32, normal: Vec3) -> ReceiverPoint {
    ReceiverPoint { position: Vec3::new(0.1, y, -0.2), normal }
}

fn renderers() -> [Renderer; 3] {
    [Renderer::on(gpu(TIERS[0])).unwrap(), Renderer::on(gpu(TIERS[1])).unwrap(), Renderer::on_cpu()]
}

#[test]
fn layers_are_as_paper_says() {
    let both = through(RED) * through(BLUE);
    let points = [
        at(3.0, Vec3::ZERO),
        at(1.5, Vec3::ZERO),
        at(0.5, Vec3::ZERO),
        at(0.0, Vec3::Y),
        at(-0.5, Vec3::ZERO),
        // A point far below everything in the scene.
        at(-40.0, Vec3::ZERO),
    ];
    for (receiver, between) in [(Receiver::Nearest, both), (Receiver::Curve, through(BLUE))] {
        let scene = layers(receiver);
        let expected = [Vec3::ONE, between, both, both, Vec3::ZERO, Vec3::ZERO];
        for mut renderer in renderers() {
            let shares = renderer.light_points(&scene, &points).unwrap();
            assert_eq!(shares.len(), points.len() * 2);
            for (i, share) in shares.iter().enumerate() {
                let apart = (Vec3::from_array(*share) - expected[i / 2]).abs().max_element();
                let device = renderer.device();
                assert!(apart <= ROUNDING, "{receiver:?} {i}: {share:?} {device}");
            }
        }
    }
}

/// Between panes 5 mm apart, under a sun that crosses texels of 6 mm at a slant.
#[test]
fn light_between_close_panes_is_that_of_the_panes_above() {
    const GAP: f32 = 0.005;
    const COUNT: usize = 6;
    let mut scene = empty(vec![
        Material { tint: Vec4::new(0.6, 0.6, 0.6, 1.0), ..material(Transfer::Filter) },
        material(Transfer::Opaque),
    ]);
    let plane = |y: f32, half: f32, material| {
        let corner = |x: f32, z: f32| Vec3::new(x * half, y, z * half);
        let [a, b, c, d] =
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| corner(x, z));
        [triangle([a, b, c], material), triangle([a, c, d], material)]
    };
    scene.triangles.extend(plane(0.0, 1.5, 1));
    let height = |i: usize| 0.3 + GAP * i as f32;
    for i in 0..COUNT {
        scene.triangles.extend(plane(height(i), 0.5, 0));
    }
    scene.shadow = ShadowSettings {
        size: 512,
        receiver: Receiver::Curve,
        nodes: 16,
        ..ShadowSettings::default()
    };
    scene.lights = vec![Light::directional(Vec3::new(0.2, -1.0, 0.1))];
    let points: Vec<_> = (0..=COUNT)
        .flat_map(|i| (0..5).map(move |k| (i, k as f32)))
        .map(|(i, k)| ReceiverPoint {
            position: Vec3::new(0.05 * k - 0.1, height(i) - 0.5 * GAP, 0.03 * k),
            normal: Vec3::ZERO,
        })
        .collect();
    for mut renderer in renderers() {
        let shares = renderer.light_points(&scene, &points).unwrap();
        for (i, share) in shares.iter().enumerate() {
            let expected = 0.6_f32.powi((COUNT - i / 5) as i32);
            // The filter's outer texels see the slant.
            let apart = (share[0] - expected).abs();
            assert!(apart <= 0.03, "{i}: {} for {expected}, {}", share[0], renderer.device());
        }
    }
}

/// A probe is a receiver: the views' planes enclose it, at any distance.
#[test]
fn nothing_between_is_light() {
    let mut scene = layers(Receiver::Curve);
    scene.triangles.clear();
    scene.particles.truncate(1);
    for mut renderer in renderers() {
        let points = [at(-40.0, Vec3::ZERO), at(40.0, Vec3::ZERO)];
        let sun = renderer.light_points(&scene, &points).unwrap();
        let expected = [through(RED), through(RED), Vec3::ONE, Vec3::ONE];
        for (share, expected) in sun.iter().zip(expected) {
            let apart = (Vec3::from_array(*share) - expected).abs().max_element();
            assert!(apart <= ROUNDING, "{share:?} {}", renderer.device());
        }
    }
}

/// Rule 1, with Z = 1 where nothing is opaque: a light ends at its own far plane.
#[test]
fn no_light_gets_behind_a_given_far_plane() {
    let mut scene = layers(Receiver::Curve);
    scene.triangles.clear();
    let (position, direction) = (Vec3::new(0.0, 4.0, 0.0), Vec3::NEG_Y);
    scene.lights.push(light(LightKind::Spot { position, direction, angle: 1.0 }));
    // The sun's planes begin at the top of the upper disc's bounds, y = 5.
    for (light, far) in scene.lights.iter_mut().zip([5.0, 4.0, 4.0]) {
        light.far = Some(far);
    }
    let points = [1.5, 0.2, -0.5, -40.0].map(|y| at(y, Vec3::ZERO));
    let expected = [through(BLUE), through(RED) * through(BLUE), Vec3::ZERO, Vec3::ZERO];
    for mut renderer in renderers() {
        let shares = renderer.light_points(&scene, &points).unwrap();
        for (i, share) in shares.iter().enumerate() {
            let apart = (Vec3::from_array(*share) - expected[i / 3]).abs().max_element();
            assert!(apart <= ROUNDING, "{i}: {share:?} {}", renderer.device());
        }
    }
}

/// Points in the open and on surfaces, some of them facing away from the lights.
fn random_points(count: usize, chance: &mut Chance) -> Vec<ReceiverPoint> {
    let point = |i| {
        let normal = chance.vec3(-1.0, 1.0).normalize_or(Vec3::Y);
        let normal = if i % 3 == 0 { Vec3::ZERO } else { normal };
        ReceiverPoint { position: chance.vec3(-1.9, 1.9), normal }
    };
    (0..count).map(point).collect()
}

fn crowd(receiver: Receiver) -> Scene {
    let glass = Material { tint: Vec4::new(0.9, 0.5, 0.7, 0.3), ..material(Transfer::Filter) };
    let mut scene = empty(vec![glass, material(Transfer::Opaque)]);
    scene.particles = random_discs(400, 11);
    let corner = |x: f32, z: f32| Vec3::new(x, -0.5, z);
    scene.triangles = vec![triangle([corner(-1.0, -1.0), corner(1.0, -0.8), corner(0.2, 1.0)], 1)];
    scene.shadow.receiver = receiver;
    scene.lights = [
        LightKind::Directional { direction: Vec3::new(0.3, -1.0, 0.2) },
        LightKind::Point { position: Vec3::new(0.2, 0.3, 0.1) },
        LightKind::Spot {
            position: Vec3::new(1.0, 4.0, 0.5),
            direction: Vec3::new(-1.0, -4.0, 0.0),
            angle: 1.0,
        },
    ]
    .map(light)
    .to_vec();
    scene.lights[0].cascades = Some(gobo::model::Cascades::default());
    scene
}

/// Kernel and CPU reference read the same maps, so that only the look-up is compared.
#[test]
fn kernel_equals_reference() {
    let mut chance = Chance::new(5);
    let points = random_points(3000, &mut chance);
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let scene = crowd(receiver);
        let views = shadow_views(&scene);
        for tier in TIERS {
            let maps = map_frame(tier, &scene).maps;
            let expected = light_points(&scene, &views, &maps, &shadow_views, &points);
            let mut renderer = Renderer::on(gpu(tier)).unwrap();
            // As in `map_frame`.
            renderer.configure(|config| config.toggles.queued &= receiver == Receiver::Nearest);
            let actual = renderer.light_points(&scene, &points).unwrap();
            assert_eq!(actual.len(), 9000);
            let apart = |a: &[f32; 3], b: &[f32; 3]| {
                (Vec3::from_array(*a) - Vec3::from_array(*b)).abs().max_element()
            };
            let worst = actual.iter().zip(&expected).map(|(a, b)| apart(a, b)).fold(0.0, f32::max);
            assert!(worst <= 1e-3, "{receiver:?} {tier}: {worst}");
            // Other points have other shares, and some shares are neither 0 nor 1.
            let wrong = actual.iter().zip(&expected[3..]).filter(|(a, b)| apart(a, b) > 0.05);
            assert!(wrong.count() > 1000);
            let grey = actual.iter().filter(|share| share[0] > 0.05 && share[0] < 0.95).count();
            assert!(grey > 1000, "{grey}");
        }
    }
}

/// Maps of the [`layers`], on a device of the host.
pub(super) fn prepared(gpu: &Gpu, receiver: Receiver) -> (Prepared, Vec<Light>) {
    let scene = layers(receiver);
    let bounds = Bounds { min: Vec3::splat(-3.0), max: Vec3::splat(3.0) };
    let views: Vec<_> = (0..)
        .zip(&scene.lights)
        .flat_map(|(index, light)| light_views(index, light, 64, None, &bounds).unwrap())
        .collect();
    let mut shadows = crate::common::shadows(gpu);
    let settings = ShadowSettings { receiver, ..ShadowSettings::default() };
    let Scene { particles, materials, .. } = &scene;
    let casters = Casters { particles, materials, ..Casters::default() };
    (shadows.prepare(&casters, &views, &settings).unwrap(), scene.lights)
}

#[test]
fn a_host_asks_for_its_own_points_and_lights() {
    let gpu = gpu(TIERS[0]);
    let (prepared, mut lights) = prepared(&gpu, Receiver::Curve);
    // Without shadows, so that it has no views.
    lights.push(Light { casts: false, ..Light::directional(Vec3::X) });
    let upload = |vectors: &[[f32; 3]]| gpu.upload("vectors", vectors, BufferUsages::STORAGE);
    let positions = upload(&[[0.0, 1.5, 0.1], [0.0, 0.2, 0.1]]);
    let points = PointBuffers { count: 2, positions: &positions, normals: None };
    let lit = prepared.light_points(&lights, &[2, 1], &points).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    prepared.record(&mut encoder).unwrap();
    lit.record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    let shares: Vec<[f32; 3]> = gpu.read(lit.shares());
    let expected = [Vec3::ONE, through(BLUE), Vec3::ONE, through(RED) * through(BLUE)];
    for (share, expected) in shares.iter().zip(expected) {
        assert!(
            (Vec3::from_array(*share) - expected).abs().max_element() <= ROUNDING,
            "{shares:?}"
        );
    }
    assert_eq!(shares.len(), 4);
    assert!(lit.memory().total() > 48);

    let empty = PointBuffers { count: 0, ..points };
    let none = prepared.light_points(&lights, &[0], &empty).unwrap();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    none.record(&mut encoder);
    gpu.queue.submit([encoder.finish()]);
    assert!(gpu.check().is_ok());
}

#[test]
fn what_cannot_be_looked_up_is_named() {
    let gpu = gpu(TIERS[0]);
    let (prepared, mut lights) = prepared(&gpu, Receiver::Curve);
    let positions = gpu.upload("positions", &[[0.0_f32; 3]; 4], BufferUsages::STORAGE);
    let short = gpu.upload("normals", &[[0.0_f32; 3]; 3], BufferUsages::STORAGE);
    let points = PointBuffers { count: 4, positions: &positions, normals: None };
    let error = |lights: &[Light], chosen: &[usize], points: &PointBuffers<'_>| {
        prepared.light_points(lights, chosen, points).unwrap_err()
    };
    assert!(error(&lights, &[0, 2], &points).to_string().starts_with("light 2 "));
    let few = PointBuffers { normals: Some(&short), ..points };
    assert!(error(&lights, &[0], &few).to_string().starts_with("point 3 "));
    lights[1].kind = LightKind::Point { position: Vec3::NAN };
    assert!(matches!(error(&lights, &[1], &points), Error::Light(_)));
    let uniform = gpu.upload("uniform", &[[0.0_f32; 3]; 4], BufferUsages::UNIFORM);
    let odd = PointBuffers { positions: &uniform, ..points };
    assert!(matches!(error(&lights, &[0], &odd), Error::Kernel(_)));
    let [own, other] = two_devices();
    let (of_own, lights) = self::prepared(&own, Receiver::Nearest);
    let foreign = other.upload("foreign", &[[0.0_f32; 3]; 4], BufferUsages::STORAGE);
    let foreign = PointBuffers { count: 4, positions: &foreign, normals: None };
    assert!(matches!(of_own.light_points(&lights, &[0], &foreign), Err(Error::Kernel(_))));
    assert!(own.check().is_ok() && gpu.check().is_ok());
}

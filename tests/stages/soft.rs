//! Area lights: look-up and CPU reference against many points on the light, and pictures of both.
use crate::common::{
    TIERS, area_truth,
    area_truth::degrees,
    gpu, reference_picture, render,
    scenes::{Chance, empty, light, material, triangle},
};
use gobo::{
    Camera, Light, LightKind, Material, Receiver, Transfer, Triangle,
    glam::{DVec3, UVec2, Vec3, Vec4},
    gpu::Tier,
    model::{Air, MaskSettings, ReceiverPoint, Source},
};
use gobo_picture::Renderer;
use gobo_scene::Scene;

pub(super) const GROUND: u32 = 0;
pub(super) const RED: u32 = 1;
pub(super) const GREEN: u32 = 2;

/// Pane with a corner and two edges, as two triangles.
pub(super) fn sheet(corner: Vec3, right: Vec3, up: Vec3, material: u32) -> [Triangle; 2] {
    let far = corner + right + up;
    [[corner, corner + right, far], [corner, far, corner + up]].map(|p| triangle(p, material))
}

pub(super) fn block(low: Vec3, high: Vec3) -> Vec<Triangle> {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| axis * (high - low));
    let sides = [(low, x, y), (low + z, x, y), (low, x, z), (low + y, x, z), (low, y, z)];
    let sides = sides.into_iter().chain([(low + x, y, z)]);
    sides.flat_map(|(corner, right, up)| sheet(corner, right, up, GROUND)).collect()
}

/// A ground of 12 x 12 m at y = 0.
pub(super) fn ground() -> Scene {
    let glass = |tint| Material { tint, ..material(Transfer::Filter) };
    let mut scene = empty(vec![
        material(Transfer::Opaque),
        glass(Vec4::new(0.9, 0.1, 0.2, 1.0)),
        glass(Vec4::new(0.2, 0.8, 0.3, 0.9)),
    ]);
    let corner = Vec3::new(-6.0, 0.0, -6.0);
    scene.triangles = sheet(corner, Vec3::X * 12.0, Vec3::Z * 12.0, GROUND).to_vec();
    scene
}

/// A box on the ground and one above it, a lattice, and two panes, one behind the other.
fn crowd() -> Scene {
    let mut scene = ground();
    let mut add = |low, high| scene.triangles.extend(block(low, high));
    add(Vec3::new(-1.2, 0.0, -0.4), Vec3::new(-0.7, 0.6, 0.1));
    add(Vec3::new(0.3, 0.4, -1.0), Vec3::new(0.6, 0.7, -0.6));
    for i in 0..4 {
        let x = -0.5 + 0.25 * i as f32;
        add(Vec3::new(x, 0.8, 0.2), Vec3::new(x + 0.06, 0.82, 1.0));
    }
    let glass = [(Vec3::new(0.5, 0.9, 0.2), RED), (Vec3::new(0.8, 0.5, 0.4), GREEN)];
    for (corner, material) in glass {
        scene.triangles.extend(sheet(corner, Vec3::X * 0.7, Vec3::Z * 0.7, material));
    }
    scene
}

/// Points on the ground.
pub(super) fn grid(count: usize, half: f32) -> Vec<ReceiverPoint> {
    let at = |i: usize| ((i as f32 + 0.5) / count as f32 * 2.0 - 1.0) * half;
    let point = |i| Vec3::new(at(i % count), 0.0, at(i / count));
    let on_ground = |i| ReceiverPoint { position: point(i), normal: Vec3::Y };
    (0..count * count).map(on_ground).collect()
}

pub(super) fn spot(position: Vec3, source: impl Fn(Vec3) -> Source) -> Light {
    let direction = -position;
    Light {
        source: Some(source(direction)),
        size: Some(512),
        ..light(LightKind::Spot { position, direction, angle: 1.1 })
    }
}

/// One source of each kind, at different positions.
pub(super) fn sources() -> Vec<(&'static str, Light)> {
    let size = Some(512);
    let point = |position, source| Light { source, size, ..light(LightKind::Point { position }) };
    let sun = |angle: f64| {
        let kind = LightKind::Directional { direction: Vec3::new(-0.5, -1.0, -0.4) };
        Light {
            source: Some(Source::Sun { angle: degrees(angle) }),
            size: Some(1024),
            ..light(kind)
        }
    };
    vec![
        ("sphere", spot(Vec3::new(0.8, 3.0, 0.9), |_| Source::Sphere { radius: 0.3 })),
        (
            "disc",
            spot(Vec3::new(-1.0, 2.8, 0.6), |direction| Source::Disc { radius: 0.4, direction }),
        ),
        (
            "rect",
            spot(Vec3::new(1.2, 2.6, 1.2), |direction| Source::Rect {
                width: 0.6,
                height: 0.2,
                direction,
            }),
        ),
        ("lamp", point(Vec3::new(0.3, 2.0, 0.4), Some(Source::Sphere { radius: 0.25 }))),
        (
            "panel",
            point(
                Vec3::new(-0.2, 2.5, 0.1),
                Some(Source::Rect { width: 0.5, height: 0.5, direction: Vec3::NEG_Y }),
            ),
        ),
        ("small sun", sun(5.0)),
        ("large sun", sun(10.0)),
    ]
}

fn shares(renderer: &mut Renderer, scene: &Scene, points: &[ReceiverPoint]) -> Vec<Vec3> {
    let shares = renderer.light_points(scene, points).unwrap();
    shares.into_iter().map(Vec3::from_array).collect()
}

pub(super) fn on_tier(tier: Tier, scene: &Scene, points: &[ReceiverPoint]) -> Vec<Vec3> {
    shares(&mut Renderer::on(gpu(tier)).unwrap(), scene, points)
}

/// Light by the kernels' look-up.
pub(super) fn on_gpu(scene: &Scene, points: &[ReceiverPoint]) -> Vec<Vec3> {
    on_tier(TIERS[0], scene, points)
}

fn on_cpu(scene: &Scene, points: &[ReceiverPoint]) -> Vec<Vec3> {
    shares(&mut Renderer::on_cpu(), scene, points)
}

/// Mean absolute error over points and channels.
pub(super) fn mean_error(scene: &Scene, points: &[ReceiverPoint], found: &[Vec3]) -> f64 {
    let apart = |(point, found): (&ReceiverPoint, &Vec3)| {
        let truth = area_truth::share(scene, &scene.lights[0], point.position, point.normal);
        (truth - found.as_dvec3()).abs().element_sum() / 3.0
    };
    points.iter().zip(found).map(apart).sum::<f64>() / points.len() as f64
}

/// Mean errors of the look-up for [`sources`], as measured, and a fifth more.
const ACCURACY: [f64; 7] = [0.0186, 0.0101, 0.0158, 0.0144, 0.0108, 0.006, 0.005];
/// Mean error of the reference: half that of its points along a straight edge, as most receivers are in no
/// penumbra.
const MEAN_OF_POINTS: f64 = 0.007;

fn assert_accurate(sources: impl Iterator<Item = (usize, (&'static str, Light))>) {
    let mut scene = crowd();
    // No point is inside a box.
    let mut points = grid(36, 1.8);
    points.retain(|p| {
        !(-1.25..-0.65).contains(&p.position.x) || !(-0.45..0.15).contains(&p.position.z)
    });
    for (number, (name, source)) in sources {
        scene.lights = vec![source.clone()];
        let soft = mean_error(&scene, &points, &on_gpu(&scene, &points));
        let reference = mean_error(&scene, &points, &on_cpu(&scene, &points));
        let hard = Scene { lights: vec![Light { source: None, ..source }], ..scene.clone() };
        let hard = mean_error(&scene, &points, &on_gpu(&hard, &points));
        println!("{name}: {soft:.4}, of one point {hard:.4}, reference {reference:.4}");
        assert!(soft < ACCURACY[number], "{name}: {soft}");
        assert!(soft < 0.5 * hard, "{name}: {soft} {hard}");
        assert!(reference < MEAN_OF_POINTS, "{name}: {reference}");
    }
}

#[test]
fn a_sphere_and_a_panel_are_as_many_points_of_them() {
    assert_accurate(sources().into_iter().enumerate().filter(|(i, _)| [0, 4].contains(i)));
}

#[test]
#[ignore = "a thousand points on each of seven lights: make test-all"]
fn sources_are_as_many_points_of_them() {
    assert_accurate(sources().into_iter().enumerate());
}

/// A long panel above bars that run along it: sharp across them, whatever the orientation of the map.
#[test]
fn a_panel_may_be_turned_against_the_map() {
    let (along, across) = (Vec3::new(0.88, 0.0, 0.475), Vec3::new(-0.475, 0.0, 0.88));
    let mut scene = ground();
    for i in -4..=4 {
        let middle = Vec3::Y * 0.7 + across * (0.25 * i as f32);
        let corner = middle - along * 1.5 - across * 0.03;
        scene.triangles.extend(sheet(corner, along * 3.0, across * 0.06, GROUND));
    }
    let source = Source::Rect { width: 0.35, height: 0.1, direction: Vec3::NEG_Y + across * 0.2 };
    let position = Vec3::new(0.1, 2.1, -0.1);
    let kind = LightKind::Point { position };
    scene.lights = vec![Light { source: Some(source), size: Some(512), ..light(kind) }];
    let points = grid(16, 1.0);
    let error = mean_error(&scene, &points, &on_gpu(&scene, &points));
    assert!(error < 0.015, "{error}");
}

#[test]
fn without_a_size_the_bits_are_those_of_a_point() {
    let points = grid(24, 1.8);
    for (name, source) in sources() {
        let none = match source.source.unwrap() {
            Source::Sphere { .. } => Source::Sphere { radius: 0.0 },
            Source::Disc { direction, .. } => Source::Disc { radius: 0.0, direction },
            Source::Rect { direction, .. } => Source::Rect { width: 0.0, height: 0.0, direction },
            _ => Source::Sun { angle: 0.0 },
        };
        let with = |source: Option<Source>, of: &Light| {
            let lights = vec![Light { source, size: Some(96), ..of.clone() }];
            let scene = Scene { lights, ..crowd() };
            (on_cpu(&scene, &points), on_gpu(&scene, &points))
        };
        let (point, sized) = (with(None, &source), with(source.source, &source));
        assert_eq!(with(Some(none), &source), point, "{name}");
        assert_ne!(sized.0, point.0, "{name}");
        assert_ne!(sized.1, point.1, "{name}");
    }
}

/// Mean and 99th percentile of errors at points of a ground: of kernels and of the CPU reference, without
/// normals and with them.
fn errors_on_ground(scene: &Scene, points: &[ReceiverPoint]) -> [[[f64; 2]; 2]; 2] {
    let truth: Vec<_> = points
        .iter()
        .map(|p| area_truth::share(scene, &scene.lights[0], p.position, p.normal))
        .collect();
    let bare = points.iter().map(|&p| ReceiverPoint { normal: Vec3::ZERO, ..p });
    let all: Vec<_> = bare.chain(points.iter().copied()).collect();
    // The reference renders a map for each of 64 points of the light.
    let mut coarse = scene.clone();
    coarse.lights[0].size = Some(256);
    [on_gpu(scene, &all), on_cpu(&coarse, &all)].map(|found| {
        let (bare, with) = found.split_at(points.len());
        [bare, with].map(|found| {
            let apart = |(a, b): (&Vec3, &DVec3)| (a.as_dvec3() - b).abs().to_array();
            let mut errors: Vec<f64> = found.iter().zip(&truth).flat_map(apart).collect();
            errors.sort_by(f64::total_cmp);
            let mean = errors.iter().sum::<f64>() / errors.len() as f64;
            [mean, errors[errors.len() * 99 / 100]]
        })
    })
}

/// A floor that rises towards the lamp does not occlude itself, although its slope is not given.
#[test]
fn points_without_normals_are_lit_as_their_surface() {
    let root = crate::common::root();
    let scene = gobo_scene::load(&root.join("data/soft_glass.toml")).unwrap();
    let floor = |x: f32, z: f32| ReceiverPoint {
        position: Vec3::new(x, 0.0, z) - scene.origin,
        normal: Vec3::Y,
    };
    let points: Vec<_> = (0..26 * 26)
        .map(|i| floor((i % 26) as f32 * 0.13 - 1.6, (i / 26) as f32 * 0.13 + 0.1))
        .collect();
    for [bare, with] in errors_on_ground(&scene, &points) {
        println!("without normals {bare:.4?}, with {with:.4?}");
        assert!(bare[0] < 0.012 && bare[1] < 0.08, "{bare:?}");
    }
}

/// Under each kind of light, below boxes and a lattice.
#[test]
fn surfaces_are_found_under_each_kind_of_light() {
    let mut scene = crowd();
    let mut points = grid(20, 1.8);
    points.retain(|p| {
        !(-1.25..-0.65).contains(&p.position.x) || !(-0.45..0.15).contains(&p.position.z)
    });
    for (name, source) in sources() {
        scene.lights = vec![source];
        for [bare, with] in errors_on_ground(&scene, &points) {
            println!("{name}: without normals {bare:.4?}, with {with:.4?}");
            assert!(
                bare[0] < 1.3 * with[0] && bare[1] < 1.5 * with[1],
                "{name}: {bare:?} {with:?}"
            );
        }
    }
}

/// Largest mean difference between look-up and reference in maps of 128 texels a side, for [`sources`].
const IN_THE_AIR: [f32; 7] = [0.0075, 0.01, 0.0105, 0.018, 0.015, 0.009, 0.0265];

/// All sources at once, with cascades and viewpoints, at points on the ground and in the air: tiers differ by
/// rounding.
#[test]
fn every_tier_is_as_many_points_of_all_lights() {
    let mut chance = Chance::new(9);
    let mut points = grid(28, 1.9);
    points.extend((0..800).map(|i| {
        let normal = chance.vec3(-1.0, 1.0).normalize_or(Vec3::Y);
        let normal = if i % 2 == 0 { Vec3::ZERO } else { normal };
        let at = chance.vec3(-1.8, 1.8);
        ReceiverPoint { position: at.with_y(0.25 * (at.y + 1.8)), normal }
    }));
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        let mut scene = crowd();
        scene.shadow.receiver = receiver;
        let small = |(_, light)| Light { size: Some(128), ..light };
        scene.lights = sources().into_iter().map(small).collect();
        scene.lights[5].cascades = Some(gobo::model::Cascades::default());
        for (light, viewpoints) in [(0, 4), (2, 3), (5, 3)] {
            scene.lights[light].viewpoints = viewpoints;
        }
        let expected = on_cpu(&scene, &points);
        let [core, native] = TIERS.map(|tier| on_tier(tier, &scene, &points));
        assert_eq!(core, on_gpu(&scene, &points));
        let apart = |a: &Vec3, b: &Vec3| (*a - *b).abs().max_element();
        let worst = core.iter().zip(&native).map(|(a, b)| apart(a, b)).fold(0.0, f32::max);
        assert!(worst <= 1e-3, "{receiver:?}: {worst}");
        for (light, most) in IN_THE_AIR.into_iter().enumerate() {
            let of_light = || (light..core.len()).step_by(7);
            let errors = of_light().map(|i| (core[i] - expected[i]).abs().element_sum() / 3.0);
            let mean = errors.sum::<f32>() / points.len() as f32;
            println!("{receiver:?}, light {light}: {mean:.4}");
            assert!(mean < most, "{receiver:?}, light {light}: {mean}");
            let grey = of_light().filter(|&i| expected[i].y > 0.05 && expected[i].y < 0.95);
            assert!(grey.count() > 100, "{receiver:?}, light {light}");
        }
    }
}

/// Pictures through the maps, through masks, and through air.
#[test]
fn pictures_are_the_mean_of_those_of_the_lights_points() {
    let mut scene = crowd();
    scene.camera = Camera {
        eye: Vec3::new(1.4, 2.4, 2.6),
        target: Vec3::Y * 0.2,
        size: UVec2::new(80, 60),
        ..scene.camera
    };
    scene.shadow.receiver = Receiver::Curve;
    let lit = [(1, 8.0, 1), (2, 8.0, 3), (6, 1.0, 3)];
    let lit = lit.map(|(i, intensity, viewpoints)| Light {
        size: Some(192),
        intensity,
        viewpoints,
        ..sources()[i].1.clone()
    });
    scene.lights = lit.to_vec();
    let mask = MaskSettings { half: false, ..MaskSettings::default() };
    let scattering = Vec3::splat(0.05);
    let air = Air { scattering, extinction: scattering, ambient: 0.0, anisotropy: 0.0, steps: 12 };
    for (mask, air) in [(None, None), (Some(mask), None), (None, Some(air))] {
        let mut scene = scene.clone();
        (scene.mask, scene.air) = (mask, air);
        let expected = reference_picture(&scene);
        let found = render(TIERS[0], &scene).picture;
        let mean_apart = |found: &[[u8; 3]]| {
            let apart = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).map(|c| a[c].abs_diff(b[c])).max();
            let steps = found.iter().zip(&expected.rgb).filter_map(apart);
            steps.map(f64::from).sum::<f64>() / found.len() as f64
        };
        scene.lights.iter_mut().for_each(|light| light.source = None);
        let hard = mean_apart(&render(TIERS[0], &scene).picture.rgb);
        let mean = mean_apart(&found.rgb);
        println!("{mean:.2} of 255, of points {hard:.2}");
        assert!(mean < 0.75, "{mean}");
        // Masks are blurred themselves, and the air hides a lot.
        let is_plain = scene.mask.is_none() && scene.air.is_none();
        assert!(!is_plain || hard > 0.9, "lights without a size would pass: {hard}");
    }
}

//! Lights with several viewpoints.
use super::soft::{ground, on_gpu, sheet, spot};
use crate::common::{TIERS, files::read, gpu, scenes::material};
use gobo::{
    Camera, Light, LightKind, Material, Transfer,
    glam::{Vec2, Vec3, Vec4},
    model::{ReceiverPoint, Shadow, Source},
    view::shadow_views,
};
use gobo_picture::Renderer;
use gobo_scene::{Scene, SceneError, load};
use std::ops::Range;

/// Offsets of the viewpoints from the light, along two axes of its source [m].
fn offsets(light: &Light, axes: [Vec3; 2]) -> Vec<[f32; 2]> {
    let at = |kind| match kind {
        LightKind::Spot { position, .. } => position,
        _ => panic!("{kind:?}"),
    };
    let offset = |shadow: Shadow| axes.map(|axis| axis.dot(at(shadow.kind) - at(light.kind)));
    light.all_shadows().map(offset).collect()
}

/// The middles of equal parts have the variance of the whole, less that of a part.
#[test]
fn parts_have_the_mean_and_variance_of_the_source() {
    let direction = Vec3::NEG_Y;
    let axes = [Vec3::X, Vec3::Z];
    let sources = [
        (Source::Rect { width: 0.9, height: 0.2, direction }, [0.81 / 12.0, 0.04 / 12.0]),
        (Source::Disc { radius: 0.4, direction }, [0.04; 2]),
        (Source::Sphere { radius: 0.4 }, [0.04; 2]),
    ];
    for (source, whole) in sources {
        for count in 1..=9_u32 {
            let at = spot(Vec3::Y * 3.0, |_| source);
            let light = Light { viewpoints: count, ..at };
            if light.check(0).is_err() {
                assert_eq!((count, matches!(source, Source::Rect { .. })), (2, false));
                continue;
            }
            let offsets = offsets(&light, axes);
            assert_eq!(offsets.len(), count as usize);
            let mean = |of: &dyn Fn(&[f32; 2]) -> f32| {
                offsets.iter().map(of).sum::<f32>() / offsets.len() as f32
            };
            let apart = offsets.iter().enumerate().all(|(i, a)| !offsets[..i].contains(a));
            assert!(apart, "{source:?}, {count}: {offsets:?}");
            let variances = [0, 1].map(|axis| mean(&|at| at[axis] * at[axis]));
            for axis in [0, 1] {
                assert!(mean(&|at| at[axis]).abs() < 1e-5, "{source:?}, {count}");
                // Variance of a rectangle's part: the whole's over the square of the parts along the axis; of
                // a disc's: the whole's over their number.
                let part = match source {
                    Source::Rect { width, height, .. } => {
                        let edge = [width, height][axis];
                        let parts = (1.0 - 12.0 * variances[axis] / (edge * edge)).powf(-0.5);
                        assert!((parts - parts.round()).abs() < 1e-2, "{count}: {parts}");
                        whole[axis] / (parts * parts)
                    }
                    // A sphere's parts overlap: their middles have .85 of the remaining variance.
                    Source::Sphere { .. } => whole[axis] * (0.15 + 0.85 / count as f32),
                    _ => whole[axis] / count as f32,
                };
                let sum = variances[axis] + part;
                assert!((sum - whole[axis]).abs() < 1e-5, "{source:?}, {count}: {sum}");
            }
        }
    }
}

/// From every side the parts of a point light's sphere have its variance; the six maps of each are from its
/// middle.
#[test]
fn parts_of_a_bulb_are_around_it() {
    for viewpoints in [4, 8] {
        let source = Some(Source::Sphere { radius: 0.4 });
        let light = Light { source, viewpoints, ..Light::point([1.0, 2.0, 3.0]) };
        light.check(0).unwrap();
        let at = |shadow: Shadow| match shadow.kind {
            LightKind::Point { position } => position - Vec3::new(1.0, 2.0, 3.0),
            other => panic!("{other:?}"),
        };
        let places: Vec<Vec3> = light.all_shadows().map(at).collect();
        assert_eq!(places.len(), viewpoints as usize);
        let part = 0.04 * (0.15 + 0.85 / viewpoints as f32);
        for side in [Vec3::X, Vec3::Y, Vec3::new(0.6, 0.0, -0.8), Vec3::ONE.normalize()] {
            let mean = |of: &dyn Fn(f32) -> f32| {
                places.iter().map(|place| of(place.dot(side))).sum::<f32>() / places.len() as f32
            };
            assert!(mean(&|x| x).abs() < 1e-5 && (mean(&|x| x * x) + part - 0.04).abs() < 1e-5);
        }
        let scene = Scene { lights: vec![light], ..ground() };
        let views = shadow_views(&scene);
        assert_eq!(views.len(), 6 * viewpoints as usize);
        let is_there = |(i, view): (usize, &gobo::View)| {
            view.position().distance(places[i / 6] + Vec3::new(1.0, 2.0, 3.0)) < 1e-5
        };
        assert!(views.iter().enumerate().all(is_there));
    }
}

/// A further shadow can only reduce the viewpoints' light, whatever their number.
#[test]
fn further_shadows_follow_the_viewpoints() {
    let mut scene = ground();
    let tint = |r, g, b| Material { tint: Vec4::new(r, g, b, 1.0), ..material(Transfer::Filter) };
    scene.materials.extend([tint(0.5, 1.0, 0.5), tint(1.0, 0.5, 0.25)]);
    let pane = |y, index| sheet(Vec3::new(-3.0, y, -3.0), Vec3::X * 6.0, Vec3::Z * 6.0, index);
    let lower = scene.materials.len() as u32 - 2;
    scene.triangles.extend(pane(1.0, lower));
    scene.triangles.extend(pane(2.5, lower + 1));
    let (position, direction) = (Vec3::Y * 3.0, Vec3::NEG_Y);
    let at = spot(position, |direction| Source::Disc { radius: 0.3, direction });
    // The light's maps begin behind the upper pane, the further one's in front of it.
    let narrow = LightKind::Spot { position, direction, angle: 0.2 };
    let upper = Shadow { kind: narrow, near: Some(0.1), far: None, size: Some(64), cascades: None };
    let point = |x| ReceiverPoint { position: Vec3::new(x, 0.0, 0.0), normal: Vec3::Y };
    let points = [point(0.0), point(0.8)];
    for viewpoints in [1, 3, 9] {
        let further = vec![upper, upper];
        let lamp = Light { near: Some(1.0), viewpoints, ..at.clone() };
        scene.lights = vec![Light { shadows: further, ..lamp }];
        let views = shadow_views(&scene);
        let names: Vec<_> = views.iter().map(|view| view.name).collect();
        let numbers: Vec<_> = views.iter().map(|it| it.shadow_index(&scene.lights[0])).collect();
        let all = ["0", "p1_0", "p2_0", "p3_0", "p4_0", "p5_0", "p6_0", "p7_0", "p8_0"];
        let of_light = &all[..viewpoints as usize];
        assert_eq!(names, [of_light, &["s1_0", "s2_0"]].concat());
        assert_eq!(numbers, (0..names.len()).collect::<Vec<_>>());
        let expected = [Vec3::new(0.5, 0.5, 0.125), Vec3::new(0.5, 1.0, 0.5)];
        for (found, expected) in on_gpu(&scene, &points).into_iter().zip(expected) {
            let error = (found - expected).abs().max_element();
            assert!(error < 4e-3, "{viewpoints}: {found}, not {expected}");
        }
    }
}

fn fault(text: &str, words: &[&str]) {
    let error: SceneError = read(text).unwrap_err();
    let error = format!("{error} {error:?}");
    assert!(words.iter().all(|word| error.contains(word)), "{error}");
}

#[test]
fn the_scene_file_gives_viewpoints() {
    let lamp = "[[light]]\nkind = 'spot'\nposition = [0, 1, 0]\ndirection = [0, -1, 0]\n";
    let disc = |more: &str| format!("{lamp}source = {{ kind = 'disc', radius = 0.1{more} }}\n");
    assert_eq!(read(&disc("")).unwrap().lights[0].viewpoints, 1);
    assert_eq!(read(&disc(", viewpoints = 7")).unwrap().lights[0].viewpoint_count(), 7);
    let nothing = "source = { kind = 'disc', radius = 0, viewpoints = 7 }\n";
    assert_eq!(read(&format!("{lamp}{nothing}")).unwrap().lights[0].viewpoint_count(), 1);
    fault(&disc(", viewpoints = 10"), &["5:", "1 to 9 viewpoints"]);
    fault(&disc(", viewpoints = 2"), &["5:", "viewpoints", "1 or 3 to 9"]);
    let point = "[[light]]\nkind = 'point'\nposition = [0, 1, 0]\n\
        source = { kind = 'sphere', radius = 0.1, viewpoints = 5 }\n";
    fault(point, &["4:", "viewpoints", "1, 4 or 8"]);
    let many: String = (0..10)
        .map(|i| {
            disc(", viewpoints = 7").replace("[[light]]", &format!("[[light]]\nname = 'l{i}'"))
        })
        .collect();
    fault(&many, &["70 viewpoints of sources", "64"]);
}

/// Points of the floor in a part of the scene's picture, every third pixel.
fn floor_points(scene: &Scene, columns: Range<u32>, rows: Range<u32>) -> Vec<ReceiverPoint> {
    let Camera { eye, target, fov_y, size, .. } = scene.camera;
    let forward = (target - eye).normalize();
    let right = forward.cross(Vec3::Y).normalize();
    let up = right.cross(forward);
    let per_pixel = (fov_y * 0.5).tan() * 2.0 / size.y as f32;
    let middle = size.as_vec2() * 0.5;
    let pixels = rows.step_by(3).flat_map(|y| columns.clone().step_by(3).map(move |x| [x, y]));
    let point = |[x, y]: [u32; 2]| {
        let at = (Vec2::new(x as f32, y as f32) + 0.5 - middle) * per_pixel;
        let ray = forward + right * at.x - up * at.y;
        let position = eye - ray * ((eye.y + scene.origin.y) / ray.y);
        ReceiverPoint { position, normal: Vec3::Y }
    };
    pixels.map(point).collect()
}

/// The shadow of a man behind a screen of coloured glass, compared with the mean of point suns: his penumbra
/// has the colours of the panes in front of it.
#[test]
fn penumbrae_have_the_colors_of_the_glass_before_them() {
    const SUNS: usize = 26;
    let path = crate::common::root().join("data/gallery/screens.toml");
    let mut scene = load(&path).unwrap();
    let mut points = floor_points(&scene, 470..500, 400..425);
    points.extend(floor_points(&scene, 451..463, 413..425));
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut light = |scene: &Scene| renderer.light_points(scene, &points).unwrap();
    let found = light(&scene);
    let sun = scene.lights[0].clone();
    let LightKind::Directional { direction } = sun.kind.with_unit_direction() else { panic!() };
    let Some(Source::Sun { angle }) = sun.source else { panic!() };
    let (right, up) = direction.any_orthonormal_pair();
    let mut truth = vec![Vec3::ZERO; points.len()];
    for i in 0..SUNS {
        // A Vogel spiral.
        let radius = ((i as f32 + 0.5) / SUNS as f32).sqrt() * (0.5 * angle).tan();
        let at = Vec2::from_angle(i as f32 * 2.399_963) * radius;
        let kind = LightKind::Directional { direction: direction + right * at.x + up * at.y };
        scene.lights[0] = Light { kind, source: None, ..sun.clone() };
        let mean = |(sum, light): (&mut Vec3, [f32; 3])| *sum += Vec3::from(light) / SUNS as f32;
        truth.iter_mut().zip(light(&scene)).for_each(mean);
    }
    let errors = truth.iter().zip(&found).map(|(a, b)| (*a - Vec3::from(*b)).abs().max_element());
    let worst = errors.fold(0.0, f32::max);
    println!("{worst:.3}");
    // A sun's share of 1/26, and half as much for the look-up.
    assert!(worst < 0.08, "{worst}");
    let is_partial = |light: &&Vec3| light.y > 0.05 && light.y < 0.4;
    assert!(truth.iter().filter(is_partial).count() > 20);
}

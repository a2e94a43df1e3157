//! Area lights: shadows of single shapes, against closed forms and many points on the light.
use super::soft::{
    GREEN, GROUND, RED, block, grid, ground, mean_error, on_gpu, sheet, sources, spot,
};
use crate::common::{area_truth, area_truth::degrees, scenes::light};
use gobo::{
    Light, LightKind, Receiver,
    glam::{DVec3, Vec3},
    model::{ReceiverPoint, Source},
};
use gobo_scene::{Scene, load_with};

/// Under a straight edge at height h, a square light at height H has a transmittance of `x / w + 1/2` at
/// distance x from the edge's shadow, where `w = edge h / (H - h)`.
#[test]
fn penumbrae_widen_with_the_distance() {
    let mut widths = Vec::new();
    for height in [0.2_f32, 0.4, 0.8, 1.6] {
        let mut scene = ground();
        // The edge is in the middle of no block.
        let edge = 0.0137;
        let corner = Vec3::new(edge - 3.0, height, -3.0);
        scene.triangles.extend(sheet(corner, Vec3::X * 3.0, Vec3::Z * 6.0, GROUND));
        let source = |direction| Source::Rect { width: 0.4, height: 0.4, direction };
        let light = spot(Vec3::Y * 3.0, source);
        scene.lights = vec![Light { size: Some(1024), ..light }];
        let expected = 0.4 * height / (3.0 - height);
        let count = 400;
        let shadow = edge * 3.0 / (3.0 - height);
        let at = |i: usize| (i as f32 / count as f32 - 0.5) * 4.0 * expected;
        let points: Vec<_> = (0..count)
            .map(|i| ReceiverPoint {
                position: Vec3::new(shadow + at(i), 0.0, 0.07),
                normal: Vec3::Y,
            })
            .collect();
        let found = on_gpu(&scene, &points);
        let mut error = 0.0;
        for (i, share) in found.iter().enumerate() {
            let truth = (at(i) / expected + 0.5).clamp(0.0, 1.0);
            error += (share.x - truth).abs() / count as f32;
            assert!(i == 0 || share.x >= found[i - 1].x - 2e-3, "{height}: no step back at {i}");
        }
        assert!(error < 0.02, "{height}: {error}");
        // From 10% to 90% of the light.
        let first = |least: f32| found.iter().position(|share| share.x >= least).unwrap();
        widths.push((at(first(0.9)) - at(first(0.1))) / (0.8 * expected));
    }
    for width in &widths {
        assert!((0.85..1.2).contains(width), "{widths:?}");
    }
}

/// A pane's shadow crosses from one face of a cube to the next. Each face sees the pane from the side at its
/// own angle, which may show as a step of 1/25.
#[test]
fn faces_of_a_cube_share_their_penumbrae() {
    let mut scene = ground();
    let corner = Vec3::new(0.4, 1.0, -0.6);
    scene.triangles.extend(sheet(corner, Vec3::X * 1.2, Vec3::Z * 1.2, RED));
    let kind = LightKind::Point { position: Vec3::new(0.0, 2.0, 0.0) };
    let source = Some(Source::Sphere { radius: 0.4 });
    scene.lights = vec![Light { source, size: Some(256), ..light(kind) }];
    // Past 2 m the ground is in the next face.
    let at = |i: usize| Vec3::new(1.0 + i as f32 * 0.01, 0.0, 0.3);
    let points: Vec<_> =
        (0..180).map(|i| ReceiverPoint { position: at(i), normal: Vec3::Y }).collect();
    let found = on_gpu(&scene, &points);
    let error = mean_error(&scene, &points, &found);
    assert!(error < 0.02, "{error}");
    for (i, pair) in found.windows(2).enumerate() {
        let step = (pair[1] - pair[0]).abs().max_element();
        assert!(step < 0.04, "{step} at {}", points[i].position);
    }
}

/// A post in front of red glass: light that passes the post is as red as the glass, in the middle of the
/// post's shadow and beside it.
#[test]
fn shadows_before_glass_keep_its_color() {
    let mut scene = ground();
    scene.triangles.extend(block(Vec3::new(-0.06, 0.0, -0.51), Vec3::new(0.06, 1.4, -0.39)));
    scene.triangles.extend(sheet(Vec3::new(-0.6, 0.0, -0.1), Vec3::X * 1.2, Vec3::Y * 1.2, RED));
    let kind = LightKind::Point { position: Vec3::new(0.0, 1.8, -1.2) };
    let source = Some(Source::Sphere { radius: 0.1 });
    scene.lights = vec![Light { source, size: Some(1024), ..light(kind) }];
    let across = |z: f32| (-40..=40).map(move |i| Vec3::new(i as f32 * 0.01, 0.0, z));
    let points: Vec<_> = [0.3, 0.7, 1.1, 1.5]
        .into_iter()
        .flat_map(across)
        .map(|position| ReceiverPoint { position, normal: Vec3::Y })
        .collect();
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        scene.shadow.receiver = receiver;
        let found = on_gpu(&scene, &points);
        let error = mean_error(&scene, &points, &found);
        // Light absorbed by the glass: nine tenths of the green.
        let greens: Vec<f32> = found.iter().filter(|v| v.x > 0.05).map(|v| v.y / v.x).collect();
        let worst = greens.iter().copied().fold(0.0, f32::max);
        let mean = greens.iter().sum::<f32>() / greens.len() as f32;
        println!("{receiver:?}: error {error:.4}, green {mean:.3}, at most {worst:.3}");
        assert!(greens.len() > 200 && error < 0.025, "{receiver:?}: {error}");
        assert!((mean - 1.0 / 9.0).abs() < 0.06 && worst < 0.4, "{receiver:?}: {mean} {worst}");
    }
}

/// Deep in the shadow of a slanted roof, blocks differ in depth, and so in the radii of their penumbrae.
#[test]
fn a_slanted_roof_lets_nothing_through() {
    let mut scene = ground();
    let corner = Vec3::new(-3.0, 1.2, -3.0);
    scene.triangles.extend(sheet(corner, Vec3::new(6.0, 1.5, 0.0), Vec3::Z * 6.0, GROUND));
    scene.lights = vec![sources().swap_remove(5).1];
    let mut points = grid(60, 0.6);
    for point in &mut points {
        point.position += Vec3::new(-0.95, 0.0, -0.75);
    }
    let brightest = |shares: Vec<Vec3>| shares.iter().map(|v| v.max_element()).fold(0.0, f32::max);
    let through = brightest(on_gpu(&scene, &points));
    assert!(through < 2e-4, "{through}");
    scene.triangles.truncate(2);
    assert_eq!(brightest(on_gpu(&scene, &points)), 1.0);
}

/// A narrow slat that rises from end to end: along its shadow, penumbrae pass from one level to the next.
#[test]
fn a_rising_slat_has_an_even_shadow() {
    let mut scene = ground();
    let (low, along) = (Vec3::new(-1.5, 0.3, -0.2), Vec3::new(3.0, 1.5, 0.4));
    let across = Vec3::Z * 0.12;
    scene.triangles.extend(sheet(low, along, across, GROUND));
    // Texels of 14 mm: windows are rounded up.
    scene.lights = vec![Light { size: Some(1152), ..sources().swap_remove(5).1 }];
    let direction = Vec3::new(-0.5, -1.0, -0.4);
    let on_slat = |i: usize| low + along * (0.05 + 0.9 * i as f32 / 400.0) + across * 0.5;
    let below = |p: Vec3| p + direction * p.y;
    let points: Vec<_> = (0..400)
        .map(|i| ReceiverPoint { position: below(on_slat(i)).with_y(0.0), normal: Vec3::Y })
        .collect();
    let found = on_gpu(&scene, &points);
    let errors: Vec<f64> = points
        .iter()
        .zip(&found)
        .map(|(point, found)| {
            let truth = area_truth::share(&scene, &scene.lights[0], point.position, point.normal);
            f64::from(found.x) - truth.x
        })
        .collect();
    let steps = found.windows(2).map(|pair| (pair[1].x - pair[0].x).abs()).fold(0.0, f32::max);
    let worst = errors.iter().fold(0.0_f64, |worst, error| worst.max(error.abs()));
    let mean = errors.iter().map(|error| error.abs()).sum::<f64>() / errors.len() as f64;
    assert!(mean < 0.02 && worst < 0.1 && steps < 0.06, "{mean}, {worst}, {steps}");
}

/// A wide pane that rises from the ground: where its blocks pass from one level to the next, and to the map,
/// its whole tint counts, however it is shared between them.
#[test]
fn a_rising_pane_has_an_even_shadow() {
    let (low, along) = (Vec3::new(-1.5, 0.03, -1.2), Vec3::new(3.0, 1.57, 0.3));
    let across = Vec3::Z * 2.4;
    let position = Vec3::new(0.1, 2.4, 0.2);
    let source = Some(Source::Sphere { radius: 0.15 });
    let lamp = Light { source, size: Some(512), ..light(LightKind::Point { position }) };
    let direction = Vec3::new(-0.5, -1.0, -0.4);
    let source = Some(Source::Sun { angle: degrees(6.0) });
    let kind = LightKind::Directional { direction };
    let sun = Light { source, size: Some(1024), ..light(kind) };
    for receiver in [Receiver::Nearest, Receiver::Curve] {
        for light in [&lamp, &sun] {
            let mut scene = ground();
            scene.shadow.receiver = receiver;
            scene.triangles.extend(sheet(low, along, across, RED));
            scene.lights = vec![light.clone()];
            let below = |p: Vec3| match light.kind {
                LightKind::Directional { direction } => p + direction * p.y,
                _ => position + (p - position) * (position.y / (position.y - p.y)),
            };
            let on_pane = |i: usize| low + along * (0.04 + 0.88 * i as f32 / 500.0) + across * 0.5;
            let points: Vec<_> = (0..500)
                .map(|i| ReceiverPoint { position: below(on_pane(i)).with_y(0.0), normal: Vec3::Y })
                .collect();
            let tint = Vec3::new(0.9, 0.1, 0.2);
            let worst = on_gpu(&scene, &points)
                .iter()
                .map(|found| (*found - tint).abs().max_element())
                .fold(0.0, f32::max);
            println!("{receiver:?}, {:?}: {worst:.4}", light.source);
            assert!(worst < 0.05, "{receiver:?}, {:?}: {worst}", light.source);
        }
    }
}

/// Light at points in rows along the shadow of a bar between two panes, from one end of its penumbra to the
/// other: mean error, and the part of it that changes along the rows.
fn along_a_bar(scene: &Scene, rows: &[Vec<ReceiverPoint>]) -> (f64, f64) {
    let (mut mean, mut ripple) = (0.0, 0.0_f64);
    for points in rows {
        let found = on_gpu(scene, points);
        let error = |(point, found): (&ReceiverPoint, &Vec3)| {
            let truth = area_truth::share(scene, &scene.lights[0], point.position, point.normal);
            found.as_dvec3() - truth
        };
        let errors: Vec<_> = points.iter().zip(&found).map(error).collect();
        let count = errors.len() as f64;
        mean += errors.iter().map(|e| e.abs().element_sum() / 3.0).sum::<f64>() / count;
        let even = errors.iter().sum::<DVec3>() / count;
        let square = errors.iter().map(|e| (e - even).length_squared() / 3.0).sum::<f64>() / count;
        ripple = ripple.max(square.sqrt());
    }
    (mean / rows.len() as f64, ripple)
}

/// Blocks of a map that did not overlap would show as beads along bars thinner than they are.
#[test]
#[ignore = "many bars: make test-all"]
fn thin_slanted_bars_have_no_beads() {
    let suns = sources();
    let disc = |radius| move |direction| Source::Disc { radius, direction };
    let lights = [
        ("wide disc", spot(Vec3::new(-0.3, 3.0, 0.2), disc(0.35))),
        ("disc", spot(Vec3::new(-0.3, 3.0, 0.2), disc(0.12))),
        ("sun", suns[6].1.clone()),
    ];
    for (name, light) in lights {
        for (width, turn) in [(0.03_f32, 0.12_f32), (0.06, 0.4)] {
            let mut scene = ground();
            // Smaller, for finer texels of the sun.
            for position in scene.triangles.iter_mut().flat_map(|own| &mut own.positions) {
                *position *= 0.5;
            }
            let height = 0.9;
            let (along, across) =
                (Vec3::new(turn.cos(), 0.0, turn.sin()), Vec3::new(-turn.sin(), 0.0, turn.cos()));
            let end = Vec3::Y * height - along * 2.0;
            let half = across * (0.5 * width);
            scene.triangles.extend(sheet(end + half, along * 4.0, across, RED));
            scene.triangles.extend(sheet(end - half, along * 4.0, -across, GREEN));
            scene.triangles.extend(sheet(end - half, along * 4.0, 2.0 * half, GROUND));
            scene.lights = vec![light.clone()];
            // Shadow on the ground of a point on the bar, and the radius of its penumbra.
            let (shadow, radius): (Box<dyn Fn(Vec3) -> Vec3>, f32) = match light.kind {
                LightKind::Directional { direction } => {
                    (Box::new(move |p| p - direction * (p.y / direction.y)), 0.11)
                }
                LightKind::Spot { position, .. } | LightKind::Point { position } => {
                    let Some(Source::Disc { radius, .. }) = light.source else { panic!() };
                    let far = position.y / (position.y - height);
                    (Box::new(move |p: Vec3| position + (p - position) * far), radius * (far - 1.0))
                }
            };
            let row = |off: f32| {
                let at = |i: usize| {
                    let on_bar = Vec3::Y * height + along * (i as f32 / 150.0 - 0.5);
                    shadow(on_bar) + across * (off * radius)
                };
                let point = |i| ReceiverPoint { position: at(i).with_y(0.0), normal: Vec3::Y };
                (0..150).map(point).collect::<Vec<_>>()
            };
            let rows: Vec<_> = [-1.0, -0.6, 0.0, 0.4, 0.9].map(row).into();
            let (mean, ripple) = along_a_bar(&scene, &rows);
            println!("{name}, {width} m: {mean:.4}, ripple {ripple:.4}");
            assert!(mean < 0.014 && ripple < 0.009, "{name}, {width} m: {mean} {ripple}");
        }
    }
}

/// The lamp in the box of glass, from one viewpoint.
fn soft_box() -> Scene {
    let path = crate::common::root().join("data/soft_box.toml");
    load_with(&path, &[("shadow.soft_detail".to_owned(), "false".to_owned())]).unwrap()
}

/// Behind a lead bar whose penumbra is where one level hands over to the next, and which covers all texels of
/// the map around the point.
#[test]
fn a_bar_in_a_fade_is_not_as_sharp_as_the_map() {
    let scene = soft_box();
    let points: Vec<_> = (0..17)
        .map(|i| ReceiverPoint {
            position: Vec3::new(-2.55, 1.8 + 0.025 * i as f32, 2.32),
            normal: Vec3::X,
        })
        .collect();
    for (point, found) in points.iter().zip(on_gpu(&scene, &points)) {
        let truth = area_truth::share(&scene, &scene.lights[0], point.position, point.normal);
        let error = (truth - found.as_dvec3()).abs().max_element();
        assert!(error < 0.1, "{truth} {found} at {}", point.position);
    }
}

/// Largest error of a channel over points.
fn worst_error(scene: &Scene, points: &[ReceiverPoint]) -> f64 {
    let found = on_gpu(scene, points);
    let apart = |(point, found): (&ReceiverPoint, &Vec3)| {
        let truth = area_truth::share(scene, &scene.lights[0], point.position, point.normal);
        (truth - found.as_dvec3()).abs().max_element()
    };
    points.iter().zip(&found).map(apart).fold(0.0, f64::max)
}

/// The map holds nothing behind a lead bar. The walls of a corner there have light from both sides of the
/// bar, and neither shades itself or the other.
#[test]
fn a_corner_behind_a_bar_is_lit_from_both_sides() {
    let scene = soft_box();
    let on_walls = |i: usize| {
        let (height, along) = (1.2 + 0.1 * (i / 24) as f32, -2.54 + 0.02 * (i % 24 / 2) as f32);
        if i.is_multiple_of(2) {
            ReceiverPoint { position: Vec3::new(-2.55, height, along), normal: Vec3::X }
        } else {
            ReceiverPoint { position: Vec3::new(along, height, -2.55), normal: Vec3::Z }
        }
    };
    let worst = worst_error(&scene, &(0..24 * 10).map(on_walls).collect::<Vec<_>>());
    // A level's window is a box: off by up to 0.1 in the narrowest channel of a bar's penumbra.
    assert!(worst < 0.11, "{worst}");
}

/// Behind a lead bar and behind a wall that the bar hides from the map's centre: as dark as beside the bar.
#[test]
fn a_floor_behind_a_bar_and_a_wall_is_dark() {
    let scene = soft_box();
    let on_floor = |i: usize| {
        let (x, z) = (-2.67 - 0.03 * (i % 8) as f32, 2.2 + 0.03 * (i / 8) as f32);
        ReceiverPoint { position: Vec3::new(x, 0.0, z), normal: Vec3::Y }
    };
    let worst = worst_error(&scene, &(0..8 * 16).map(on_floor).collect::<Vec<_>>());
    assert!(worst < 0.02, "{worst}");
    // Away from the wall, past the place where the penumbra's level takes over from the map.
    let on_floor = |i: usize| {
        let x = -3.05 - 0.004 * i as f32;
        ReceiverPoint { position: Vec3::new(x, 0.0, -0.9184 * x), normal: Vec3::Y }
    };
    let worst = worst_error(&scene, &(0..40).map(on_floor).collect::<Vec<_>>());
    assert!(worst < 0.12, "{worst}");
}

/// A rectangle of a point light, whose map stands still, turns past 8 degrees off the vertical, aslant to the
/// axes of the world: its light changes as little there as anywhere else.
#[test]
fn rectangles_turn_without_a_step_near_the_vertical() {
    let direction = |degrees: f32| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        Vec3::new(0.8 * sine, -cosine, 0.6 * sine)
    };
    let mut scene = ground();
    let corner = Vec3::new(-0.31, 0.5, -0.26);
    let (along, across) = (Vec3::new(0.75, 0.0, -0.29), Vec3::new(0.22, 0.0, 0.56));
    scene.triangles.extend(sheet(corner, along, across, GROUND));
    let points = grid(40, 0.9);
    let lit = |step: u32| {
        let source = Some(Source::Rect {
            width: 0.6,
            height: 0.2,
            direction: direction(6.0 + 0.5 * step as f32),
        });
        let kind = LightKind::Point { position: Vec3::Y * 3.0 };
        let lights = vec![Light { source, size: Some(512), ..light(kind) }];
        on_gpu(&Scene { lights, ..scene.clone() }, &points)
    };
    let lights: Vec<Vec<Vec3>> = (0..9).map(lit).collect();
    for (step, pair) in lights.windows(2).enumerate() {
        let changes = pair[0].iter().zip(&pair[1]).map(|(a, b)| (*a - *b).abs().max_element());
        let most = changes.fold(0.0, f32::max);
        assert!(most < 0.02, "step {step}: {most}");
    }
}

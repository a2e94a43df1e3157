//! Area lights whose penumbrae are a few texels of the map, and contact under another penumbra.
use super::soft::{GROUND, grid, ground, on_gpu, sheet, spot};
use crate::common::{area_truth, area_truth::degrees, scenes::light};
use gobo::{
    Light, LightKind,
    glam::Vec3,
    model::{ReceiverPoint, Source},
};
use gobo_scene::{Scene, load};

/// Points on a light: in a penumbra they are off by 0.01 at most.
const PLACES: usize = 256;

/// Share of the light's points visible from each point, and the look-up's error.
fn truths_and_errors(scene: &Scene, points: &[ReceiverPoint], places: usize) -> Vec<[f64; 2]> {
    let light = &scene.lights[0];
    let apart = |(p, found): (&ReceiverPoint, Vec3)| {
        let truth = area_truth::share_of_places(scene, light, p.position, p.normal, places).x;
        [truth, (truth - f64::from(found.x)).abs()]
    };
    points.iter().zip(on_gpu(scene, points)).map(apart).collect()
}

fn mean(errors: &[f64]) -> f64 {
    errors.iter().sum::<f64>() / errors.len() as f64
}

/// Mean error at the points that see part of the light.
pub(super) fn error_in_penumbrae(scene: &Scene, points: &[ReceiverPoint]) -> f64 {
    let all = truths_and_errors(scene, points, PLACES);
    let partial = all.iter().filter(|[truth, _]| (0.02..0.98).contains(truth));
    let errors: Vec<f64> = partial.map(|[_, error]| *error).collect();
    assert!(errors.len() > 100, "{}", errors.len());
    mean(&errors)
}

/// A pane at a height, rotated against the map.
fn pane(height: f32) -> Scene {
    let (along, across) = (Vec3::new(0.77, 0.0, -0.23), Vec3::new(0.18, 0.0, 0.57));
    let middle = Vec3::new(0.0137, height, 0.021);
    let mut scene = ground();
    scene.triangles.extend(sheet(middle - (along + across) * 0.5, along, across, GROUND));
    scene
}

/// The short side of a rectangle has a penumbra of 0.7 to 2.8 texels, the long side of 2.2 to 8.3.
#[test]
fn small_spots_of_rectangles_are_soft() {
    // Below a texel an edge is as soft as the map's texels: 0.03 elsewhere.
    for (height, size, most) in [
        (0.15, 512, 0.045),
        (0.2, 512, 0.03),
        (0.25, 512, 0.018),
        (0.3, 512, 0.015),
        (0.4, 512, 0.012),
        (0.5, 512, 0.012),
        (0.15, 1024, 0.02),
    ] {
        let mut scene = pane(height);
        let source = |direction| Source::Rect { width: 0.6, height: 0.2, direction };
        let lamp = spot(Vec3::new(0.3, 3.0, 0.2), source);
        scene.lights = vec![Light { size: Some(size), ..lamp }];
        let error = error_in_penumbrae(&scene, &grid(100, 0.9));
        println!("{size}, {height} m: {error:.4}");
        assert!(error < most, "{size}, {height} m: {error}");
    }
}

/// The sun in a map of 20 m, 2 cm a texel: radii of penumbrae of 1.1 to 2 texels.
#[test]
fn a_sun_is_soft_where_its_penumbra_is_wider_than_texels() {
    // A texel is lit or not: an edge is known to half a texel, averaged over the penumbra's edge and over
    // viewpoints.
    for (height, size, viewpoints, most) in [
        (4.0, 1024, 1, 0.072),
        (5.5, 1024, 1, 0.045),
        (7.0, 1024, 1, 0.036),
        (4.0, 1024, 6, 0.05),
        (5.5, 1024, 6, 0.03),
        (7.0, 1024, 6, 0.03),
        (4.0, 2048, 1, 0.03),
    ] {
        let mut scene = pane(height);
        let kind = LightKind::Directional { direction: Vec3::new(-0.5, -1.0, -0.4) };
        let source = Some(Source::Sun { angle: degrees(0.53) });
        scene.lights = vec![Light { source, viewpoints, size: Some(size), ..light(kind) }];
        let mut points = grid(110, 0.65);
        points.iter_mut().for_each(|p| p.position -= Vec3::new(0.5, 0.0, 0.4) * height);
        let error = error_in_penumbrae(&scene, &points);
        println!("{size}, {viewpoints}, {height} m: {error:.4}");
        assert!(error < most, "{size}, {viewpoints}, {height} m: {error}");
    }
}

/// A tube of 1.2 m x 4 cm above slats of 4 cm, diagonally and across.
#[test]
fn tubes_shine_through_blinds() {
    // Along slats and the map, all viewpoints see the edges in the same rows of texels.
    for (angle, height, size, viewpoints, most) in [
        (0.5, 0.3, 512, 1, 0.022),
        (0.5, 0.6, 512, 1, 0.056),
        (1.57, 0.6, 512, 1, 0.0115),
        (0.5, 0.3, 512, 4, 0.02),
        (0.5, 0.6, 512, 4, 0.02),
        (1.57, 0.6, 512, 4, 0.02),
        (0.0, 0.3, 512, 4, 0.055),
        (0.0, 0.6, 512, 4, 0.02),
        (0.0, 0.3, 1024, 4, 0.02),
    ] {
        let (sine, cosine) = f32::sin_cos(angle);
        let (along, across) = (Vec3::new(cosine, 0.0, -sine), Vec3::new(sine, 0.0, cosine));
        let mut scene = ground();
        for i in -9..=9 {
            let middle = Vec3::new(0.0137, height, 0.021) + across * (0.1 * i as f32);
            let corner = middle - along - across * 0.02;
            scene.triangles.extend(sheet(corner, along * 2.0, across * 0.04, GROUND));
        }
        let direction = Vec3::new(0.0, -1.0, 0.05);
        let source = Some(Source::Rect { width: 1.2, height: 0.04, direction });
        let kind = LightKind::Spot { position: Vec3::new(0.1, 2.4, -0.1), direction, angle: 1.1 };
        scene.lights = vec![Light { source, viewpoints, size: Some(size), ..light(kind) }];
        let all = truths_and_errors(&scene, &grid(40, 0.6), PLACES);
        let errors: Vec<f64> = all.iter().map(|[_, error]| *error).collect();
        let error = mean(&errors);
        println!("{size}, {viewpoints}, {angle}, {height} m: {error:.4}");
        assert!(error < most, "{size}, {viewpoints}, {angle}, {height} m: {error}");
    }
}

/// A ball and four posts on the floor under a lattice: their shadows meet them within its penumbrae.
#[test]
fn contact_under_another_penumbra() {
    let path = crate::common::root().join("data/soft_lattice.toml");
    let mut scene = load(&path).unwrap();
    let at = |i: usize| (i as f32 + 0.5) / 60.0 * 2.6;
    let floor = |i: usize| Vec3::new(at(i % 60) - 1.5, 0.0, at(i / 60) - 1.45) - scene.origin;
    let points: Vec<_> =
        (0..60 * 60).map(|i| ReceiverPoint { position: floor(i), normal: Vec3::Y }).collect();
    assert_eq!(scene.lights[0].viewpoints, 4);
    // With one viewpoint, the lamp's middle, the map lacks the posts that bars hide from it.
    let chosen = scene.lights[0].size;
    for (viewpoints, size, limits) in
        [(4, chosen, [0.01, 0.05, 0.2]), (1, Some(1872), [0.0135, 0.1, 0.56])]
    {
        (scene.lights[0].viewpoints, scene.lights[0].size) = (viewpoints, size);
        let all = truths_and_errors(&scene, &points, 64);
        let mut errors: Vec<f64> = all.iter().map(|[_, error]| *error).collect();
        errors.sort_by(f64::total_cmp);
        let found = [mean(&errors), errors[errors.len() * 99 / 100], errors[errors.len() - 1]];
        println!("{viewpoints}: {found:.3?}");
        assert!(found.iter().zip(limits).all(|(found, most)| *found < most), "{found:?}");
    }
}

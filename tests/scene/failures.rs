//! Scenes that show where other systems fail: data/gallery/failures.toml against the chords of two spheres,
//! and seams.toml.
use crate::common::{TIERS, gpu};
use gobo::{
    Receiver, View,
    glam::{DVec2, UVec2, Vec3},
    model::ReceiverPoint,
    records::ViewMaps,
    view::shadow_views,
};
use gobo_picture::Renderer;
use gobo_reference as reference;
use gobo_scene as scene;
use gobo_scene::Scene;
use std::path::Path;

/// Rows of the scene [m].
const AIR: f32 = -3.7;
const GROUND: f32 = 0.0;
const OURS: f32 = 3.7;

/// The scene and its maps.
struct Failures {
    scene: Scene,
    views: Vec<View>,
    maps: Vec<ViewMaps>,
}

fn failures() -> Failures {
    let path = Path::new(crate::common::ROOT).join("data/gallery/failures.toml");
    let mut scene = scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    // The visible dust casts no shadow.
    scene.particles.clear();
    scene.samples = 1;
    let views = shadow_views(&scene);
    let maps = reference::render_maps(&scene, &views).0;
    Failures { scene, views, maps }
}

/// Shares of the sun at points of the ground, by the curve.
fn shares(failures: &Failures, points: &[(f32, f32)]) -> Vec<Vec3> {
    let Failures { scene, views, maps } = failures;
    let point =
        |&(x, z): &(f32, f32)| ReceiverPoint { position: Vec3::new(x, 0.0, z), normal: Vec3::Y };
    let points: Vec<_> = points.iter().map(point).collect();
    let shares = reference::light_points(scene, views, maps, &shadow_views, &points);
    shares.into_iter().map(Vec3::from).collect()
}

/// Length of the sunbeam to a point of the ground inside a sphere [m].
fn chord(center: DVec2, x: f32) -> f64 {
    const RADIUS: f64 = 1.1;
    let toward = DVec2::new(-1.0, 0.36).normalize();
    let from = DVec2::new(f64::from(x), 0.0) - center;
    let middle = -from.dot(toward);
    let half = (RADIUS * RADIUS - from.length_squared() + middle * middle).max(0.0).sqrt();
    (middle + half).max(0.0) - (middle - half).max(0.0)
}

fn exact(x: f32) -> Vec3 {
    let [first, second] = [(-4.2, 1.784), (0.2, 0.2)].map(|(x, y)| DVec2::new(x, y));
    let depth = chord(first, x) / 3.0 + chord(second, x) / 0.6;
    Vec3::new(0.72, 0.52, 0.34).powf(depth as f32)
}

/// Light that the ground sends straight up, in the middle row and in ours.
fn seen(failures: &Failures, x: f32) -> [Vec3; 2] {
    const HEIGHT: f32 = 40.0;
    let middle = (GROUND + OURS) / 2.0;
    let mut scene = failures.scene.clone();
    scene.camera.eye = Vec3::new(x, HEIGHT, middle);
    scene.camera.target = Vec3::new(x, 0.0, middle);
    scene.camera.up = Vec3::NEG_Z;
    // 101 pixels; the rows are 40 off the middle one.
    scene.camera.size = UVec2::new(9, 101);
    scene.camera.fov_y = 2.0 * (middle / HEIGHT * 50.5 / 40.0).atan();
    let Failures { views, maps, .. } = &failures;
    let light = reference::render_picture(&scene, views, maps, &shadow_views).light;
    [10, 90].map(|row| light[row * 9 + 4].into())
}

#[test]
fn rows_fail_as_they_say_and_ours_does_not() {
    let failures = failures();
    let found = shares(&failures, &[(-1.3, OURS), (1.6, OURS), (2.0, OURS), (2.0, AIR)]);
    // In front of the second cloud's shadow, in its centre, and behind it.
    for (x, found) in [-1.3, 1.6, 2.0].into_iter().zip(&found) {
        let exact = exact(x);
        assert!((*found - exact).abs().max_element() < 0.02, "{x}: {found} {exact}");
    }
    // The air between the clouds counts as dust.
    assert!(found[3].x < 0.4 * found[2].x, "{found:?}");
    // The light has not reached the second cloud yet, but the cloud's part below the ground counts.
    let [ground, ours] = seen(&failures, -0.9);
    assert!(ground.x < 0.75 * ours.x, "{ground} {ours}");
    // Behind the cloud there is no difference.
    let [ground, ours] = seen(&failures, 2.0);
    assert!((ground - ours).abs().max_element() < 0.05 * ours.x, "{ground} {ours}");
}

/// data/gallery/seams.toml: light between clear spheres and the dust behind them.
#[test]
fn dust_behind_clear_spheres_has_a_hole_by_the_nearest_depth_only() {
    let path = Path::new(crate::common::ROOT).join("data/gallery/seams.toml");
    let mut scene = scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
    let sun = Vec3::new(0.8, -0.42, -0.75).normalize();
    let center = Vec3::new(-4.13, 2.30, 1.64) - scene.origin;
    let behind = ReceiverPoint { position: center + sun * 0.6, normal: Vec3::ZERO };
    // Through the middle of a sphere of 0.9 m.
    let formula = Vec3::new(0.95, 0.88, 0.8).powf(0.9 / 1.5);
    let mut renderer = Renderer::on(gpu(TIERS[0])).unwrap();
    let mut light = |receiver| {
        scene.shadow.receiver = receiver;
        Vec3::from(renderer.light_points(&scene, &[behind]).unwrap()[0])
    };
    let by_curve = light(Receiver::Curve);
    assert!((by_curve - formula).abs().max_element() < 5e-3, "{by_curve}, not {formula}");
    let by_nearest = light(Receiver::Nearest);
    assert!(by_nearest.max_element() < 0.2, "{by_nearest}");
}

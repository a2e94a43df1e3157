//! No light is missing from the list of a cluster that it reaches: 64-bit points against the lists.
use super::{camera, grid, reaches, stage};
use crate::common::scenes::Chance;
use gobo::{
    glam::{DVec3, Vec2, Vec3},
    model::{Light, LightKind},
    records::Reach,
};
use gobo_reference::cluster::assign;
use gobo_scene::Scene;

/// Whether a light reaches a point, in 64 bits, from the definitions of range and cone.
fn is_lit(light: &Light, point: DVec3) -> bool {
    let (position, cone) = match light.kind {
        LightKind::Directional { .. } => return true,
        LightKind::Spot { position, direction, angle } => (position, Some((direction, angle))),
        LightKind::Point { position } => (position, None),
    };
    let away = point - position.as_dvec3();
    light.far.is_none_or(|far| away.length() < f64::from(far))
        && cone.is_none_or(|(direction, angle)| {
            away.angle_between(direction.as_dvec3()) < f64::from(angle) * 0.5
        })
}

/// Over points in the frustum: number of pairs (light, point) that shine, number of those that the lists
/// miss, and mean length of the lists.
fn missed(scene: &Scene, reaches: &[Reach]) -> (u32, u32, f64) {
    let (camera, grid) = (camera(scene), grid(scene));
    let clusters = assign(&grid, reaches, u32::MAX);
    let world_from_view = camera.view_from_world.as_dmat4().inverse();
    let mut chance = Chance::new(99);
    let (mut shining, mut missed, mut listed) = (0, 0, 0);
    const POINTS: usize = 4000;
    for _ in 0..POINTS {
        let pixel = Vec2::new(chance.unit(), chance.unit()) * camera.size.as_vec2();
        let distance = camera.near * (camera.far / camera.near).powf(chance.unit());
        let depth = (distance - camera.near) / (camera.far - camera.near);
        let slope = ((pixel - camera.size.as_vec2() * 0.5) / camera.scale).as_dvec2();
        let ray = DVec3::new(slope.x, -slope.y, -1.0);
        let point = world_from_view.transform_point3(ray * f64::from(distance));
        let cluster = grid.cluster(pixel, depth).expect("inside");
        let list = clusters.lists[cluster as usize].as_ref().expect("it fits");
        listed += list.len();
        for (index, light) in (0..).zip(&scene.lights) {
            if is_lit(light, point) {
                shining += 1;
                missed += u32::from(!list.contains(&index));
            }
        }
    }
    (shining, missed, listed as f64 / POINTS as f64)
}

#[test]
fn no_light_is_missed() {
    let mut scene = stage(200);
    let cameras = [
        (Vec3::new(4.0, 3.0, 6.0), Vec3::ZERO, 0.8),
        (Vec3::new(0.1, 0.2, 0.3), Vec3::new(-1.0, -0.4, 0.0), 2.6),
        (Vec3::new(0.0, 9.0, 0.01), Vec3::ZERO, 0.05),
    ];
    for (eye, target, fov_y) in cameras {
        (scene.camera.eye, scene.camera.target, scene.camera.fov_y) = (eye, target, fov_y);
        let (shining, missed, mean) = missed(&scene, &reaches(&scene));
        assert!(shining > 10_000, "{shining}");
        assert_eq!(missed, 0, "of {shining}, seen from {eye}");
        // Lists are worthwhile: of 200 lights, 50 have no end and 25 of those no direction.
        assert!(mean < 80.0, "{mean} lights a point");
    }
}

#[test]
fn no_light_is_missed_far_from_the_origin() {
    let mut scene = stage(100);
    let away = Vec3::new(3e5, -1e5, 2e5);
    scene.camera.eye += away;
    scene.camera.target += away;
    scene.particles.clear();
    for triangle in &mut scene.triangles {
        triangle.positions = triangle.positions.map(|p| p + away);
    }
    for light in &mut scene.lights {
        if let LightKind::Point { position } | LightKind::Spot { position, .. } = &mut light.kind {
            *position += away;
        }
    }
    assert_eq!(missed(&scene, &reaches(&scene)).1, 0);
}

/// The check can fail: spheres and cones that are too small lose light.
#[test]
fn a_light_that_reaches_too_short_is_noticed() {
    let scene = stage(200);
    let mut small = reaches(&scene);
    for reach in &mut small {
        reach.per_radius *= 1.3;
    }
    assert!(missed(&scene, &small).1 > 0);
    let mut narrow = reaches(&scene);
    for plane in narrow.iter_mut().flat_map(|reach| &mut reach.planes) {
        plane[3] = -1500;
    }
    assert!(missed(&scene, &narrow).1 > 0);
}

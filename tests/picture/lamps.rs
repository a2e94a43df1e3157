//! Falloff of lamps towards the edge of a cone and the end of a range, as shares of the light of a lamp
//! without either.
use crate::common::{
    Tier, reference_picture, render,
    scenes::{empty, material, triangle},
    tiers,
};
use gobo::{
    glam::{DVec3, UVec2, Vec3},
    model::{Light, Transfer},
};
use gobo_scene::Scene;

const EYE: f32 = 6.0;
const SIZE: UVec2 = UVec2::new(64, 48);
const LAMP: Vec3 = Vec3::new(0.5, 3.0, 0.2);
const WAY: Vec3 = Vec3::new(0.1, -1.0, -0.2);

/// A floor from above.
fn stage(light: Light) -> Scene {
    let mut scene = empty(vec![material(Transfer::Opaque)]);
    scene.camera.eye = Vec3::Y * EYE;
    (scene.camera.target, scene.camera.up) = (Vec3::ZERO, Vec3::NEG_Z);
    (scene.camera.fov_y, scene.camera.size) = (60_f32.to_radians(), SIZE);
    scene.samples = 1;
    let corner = |x: f32, z: f32| Vec3::new(20.0 * x, 0.0, 20.0 * z);
    for last in [corner(1.0, -1.0), corner(-1.0, 1.0)] {
        let floor = triangle([corner(-1.0, -1.0), last, corner(1.0, 1.0)], 0);
        scene.triangles.push(gobo::model::Triangle { normals: [Vec3::Y; 3], ..floor });
    }
    scene.lights = vec![Light { casts: false, intensity: 20.0, ..light }];
    scene
}

/// Point of the floor at a pixel's middle.
fn floor(pixel: usize) -> DVec3 {
    let size = SIZE.as_dvec2();
    let slope = 30_f64.to_radians().tan() * 2.0 / size.y;
    let [x, y] = [pixel % SIZE.x as usize, pixel / SIZE.x as usize].map(|at| at as f64 + 0.5);
    f64::from(EYE) * slope * DVec3::new(x - 0.5 * size.x, 0.0, y - 0.5 * size.y)
}

/// Falloff by the square of the share of the cosines (`KHR_lights_punctual`), or by a cubic from 0.85 of the
/// angle on.
fn cone(point: DVec3, angle: f64, inner: Option<f64>) -> f64 {
    let cosine = (point - LAMP.as_dvec3()).normalize().dot(WAY.as_dvec3().normalize());
    let outer = (0.5 * angle).cos();
    let share = |inner: f64| ((cosine - outer) / ((0.5 * inner).cos() - outer)).clamp(0.0, 1.0);
    match inner {
        Some(inner) => share(inner).powi(2),
        None => share(0.85 * angle).powi(2) * (3.0 - 2.0 * share(0.85 * angle)),
    }
}

/// `1 - (d / end)^4` (`KHR_lights_punctual`).
fn window(point: DVec3, end: f64) -> f64 {
    (1.0 - (point.distance(LAMP.as_dvec3()) / end).powi(4)).max(0.0)
}

#[test]
fn light_falls_by_its_cone_and_range() {
    type Share = Box<dyn Fn(DVec3) -> f64>;
    let spot = |angle| Light::spot(LAMP, WAY, angle);
    let point = || Light::point(LAMP);
    let all: [(&str, Light, Share); 7] = [
        ("a cone", spot(1.0), Box::new(|at| cone(at, 1.0, None))),
        (
            "an inner cone",
            Light { inner_angle: Some(0.4), ..spot(1.0) },
            Box::new(|at| cone(at, 1.0, Some(0.4))),
        ),
        (
            "an inner cone of nothing",
            Light { inner_angle: Some(0.0), ..spot(1.2) },
            Box::new(|at| cone(at, 1.2, Some(0.0))),
        ),
        ("a range", Light { end: Some(4.0), ..point() }, Box::new(|at| window(at, 4.0))),
        ("far", Light { far: Some(4.0), ..point() }, Box::new(|at| window(at, 4.0).powi(2))),
        (
            "a range before far",
            Light { end: Some(3.5), far: Some(5.0), ..point() },
            Box::new(|at| window(at, 3.5)),
        ),
        (
            "both",
            Light { inner_angle: Some(0.6), end: Some(3.5), ..spot(1.3) },
            Box::new(|at| cone(at, 1.3, Some(0.6)) * window(at, 3.5)),
        ),
    ];
    let pictures = |light: &Light| {
        let scene = stage(light.clone());
        let of_tiers = tiers(Tier::Native).into_iter().map(|tier| render(tier, &scene).picture);
        [reference_picture(&scene)].into_iter().chain(of_tiers).collect::<Vec<_>>()
    };
    let plain = pictures(&point());
    for (what, light, share) in all {
        for (found, plain) in pictures(&light).iter().zip(&plain) {
            for (pixel, (found, plain)) in found.light.iter().zip(&plain.light).enumerate() {
                let (found, expected) = (f64::from(found[1] / plain[1]), share(floor(pixel)));
                // Two numbers of 11 bits.
                assert!(
                    (found - expected).abs() < 2e-3,
                    "{what}, {pixel}: {found}, not {expected}"
                );
            }
        }
    }
}

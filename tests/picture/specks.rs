//! Single wrong pixels on surfaces seen or lit at grazing angles.
use crate::common::{
    Tier, reference_picture, render,
    scenes::{empty, light, material, triangle},
    tiers,
};
use gobo::{
    glam::{UVec2, Vec3, Vec4},
    model::{Light, LightKind, Material, Receiver, Source, Transfer, Triangle},
    records::Picture,
};
use gobo_scene::Scene;
use std::f32::consts::PI;

fn pictures(scene: &Scene) -> Vec<Picture> {
    let cpu = reference_picture(scene);
    tiers(Tier::Native).into_iter().map(|tier| render(tier, scene).picture).chain([cpu]).collect()
}

fn middle(picture: &Picture) -> Vec3 {
    let at = picture.size.y / 2 * picture.size.x + picture.size.x / 2;
    Vec3::from(picture.light[at as usize])
}

/// A facet at a ball's silhouette faces the eye, while its interpolated normal does not. Light from the front
/// of both is scattered by the cosine.
#[test]
fn a_normal_that_looks_away_from_the_eye_is_no_other_side() {
    let tint = Vec4::new(0.5, 0.5, 0.5, 1.0);
    let mut scene = empty(vec![Material { tint, roughness: 1.0, ..material(Transfer::Opaque) }]);
    scene.camera.eye = Vec3::new(0.0, 0.0, 5.0);
    scene.camera.size = UVec2::splat(33);
    let sun = LightKind::Directional { direction: Vec3::NEG_X };
    scene.lights = vec![Light { intensity: PI, casts: false, ..light(sun) }];
    let normal = Vec3::new(1.0, 0.0, -0.15).normalize();
    let (near, far) = (Vec3::new(-0.3, 0.0, 1.5), Vec3::new(0.3, 0.0, -1.5));
    let corners = [near - Vec3::Y, near + Vec3::Y, far];
    let facet = Triangle { normals: [normal; 3], ..triangle(corners, 0) };
    let face = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    assert!(face.dot(normal).abs() > 0.9 * face.length(), "{face}");
    scene.triangles.push(facet);
    // Everything except the mirrored share.
    let scattered = 0.5 * 0.96 * normal.x;
    for picture in pictures(&scene) {
        let lit = middle(&picture);
        // And a highlight.
        assert!(lit.x >= 0.98 * scattered && lit.x < 3.0 * scattered, "{lit}");
    }
}

/// Reflection of the sky: Schlick 1994 by the angle to the surface that the facets approximate; rough
/// surfaces have no grazing reflection.
#[test]
fn a_rim_shines_by_its_normal_and_its_roughness() {
    let (near, far) = (Vec3::new(-0.15, 0.0, 1.5), Vec3::new(0.15, 0.0, -1.5));
    let corners = [near - Vec3::Y, near + Vec3::Y, far];
    let face = Vec3::new(1.0, 0.0, 0.1).normalize();
    let smooth = Vec3::new(0.8, 0.0, 0.6);
    let schlick = |cosine: f32| 0.04 + 0.96 * (1.0 - cosine).powi(5);
    let cases = [
        (face, 0.0, schlick(face.z)),
        (smooth, 0.0, schlick(smooth.z)),
        // It points away from the eye.
        (Vec3::new(0.99, 0.0, -0.14), 0.0, 1.0),
        (face, 1.0, 0.04),
        (smooth, 1.0, 0.04),
    ];
    for (normal, roughness, mirrored) in cases {
        let clear = Material { transmission: 1.0, roughness, ..material(Transfer::Filter) };
        let black = Material { tint: Vec4::W, ..material(Transfer::Opaque) };
        let mut scene = empty(vec![clear, black]);
        scene.camera.eye = Vec3::new(0.0, 0.0, 5.0);
        scene.camera.size = UVec2::splat(33);
        scene.background = Vec3::ONE;
        scene.triangles.push(Triangle { normals: [normal; 3], ..triangle(corners, 0) });
        let behind = [(-9.0, -9.0), (9.0, -9.0), (0.0, 9.0)];
        let behind = behind.map(|(x, y)| Vec3::new(x, y, -3.0));
        scene.triangles.push(triangle(behind, 1));
        for picture in pictures(&scene) {
            let seen = middle(&picture).x;
            assert!((seen - mirrored).abs() < 0.01, "{normal} {roughness}: {seen} for {mirrored}");
        }
    }
}

/// A floor, seen from straight above, under a slanted sun.
fn floor(size: u32, across: f32) -> Scene {
    let white = material(Transfer::Opaque);
    let green_blocked = Vec4::new(1.0, 0.0, 0.0, 1.0);
    let gel = Material { tint: green_blocked, visible: false, ..material(Transfer::Filter) };
    let mut scene = empty(vec![Material { roughness: 1.0, ..white }, gel]);
    scene.shadow.size = size;
    scene.shadow.bias = Some(0.05);
    let sun = LightKind::Directional { direction: Vec3::new(1.0, -1.0, 0.0).normalize() };
    scene.lights = vec![Light { intensity: PI, ..light(sun) }];
    scene.camera.size = UVec2::splat(32);
    scene.camera.fov_y = 2.0 * (0.5 * across / 4.0_f32).atan();
    quad(&mut scene, Vec3::ZERO, Vec3::X * 0.5, Vec3::NEG_Z * 0.5, 0);
    scene
}

fn quad(scene: &mut Scene, middle: Vec3, x: Vec3, y: Vec3, material: u32) {
    let corner = |u: f32, v: f32| middle + x * u + y * v;
    let (a, b, c, d) = (corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0));
    let normals = [x.cross(y).normalize(); 3];
    for corners in [[a, b, c], [a, c, d]] {
        scene.triangles.push(Triangle { normals, ..triangle(corners, material) });
    }
}

/// Pixels of a camera above `x` with more green than a share of the red: a single number if all pictures
/// agree.
fn green_pixels(scene: &mut Scene, x: f32, share: f32) -> Vec<usize> {
    scene.camera.eye = Vec3::new(x, 4.0, 0.0);
    scene.camera.target = Vec3::new(x, 0.0, 0.0);
    scene.camera.up = Vec3::NEG_Z;
    let is_green = |light: &&[f32; 3]| {
        assert!(light[0] > 0.5, "{light:?}");
        light[1] > share * light[0]
    };
    let counts = pictures(scene).into_iter().map(|p| p.light.iter().filter(is_green).count());
    let mut counts: Vec<_> = counts.collect();
    assert!(counts.len() > 1);
    counts.dedup();
    counts
}

/// The tint of a pane that stands on a floor begins right behind it, closer than the bias, and not in front
/// of it.
#[test]
fn a_pane_tints_the_floor_from_where_it_stands() {
    let sun = Some(Source::Sun { angle: 1e-3 });
    let cases =
        [Receiver::Nearest, Receiver::Curve].map(|receiver| [(receiver, None), (receiver, sun)]);
    for (receiver, source) in cases.into_iter().flatten() {
        let mut scene = floor(256, 0.005);
        scene.shadow.receiver = receiver;
        scene.lights[0].source = source;
        quad(&mut scene, Vec3::Y * 0.25, Vec3::Z * 0.5, Vec3::Y * 0.25, 1);
        assert_eq!(green_pixels(&mut scene, 0.02, 0.02), [0], "{receiver:?} {source:?}");
        assert_eq!(green_pixels(&mut scene, -0.02, 0.98), [32 * 32], "{receiver:?} {source:?}");
    }
}

/// The floor under a caster that lies on it is tinted in every texel, closer than the bias, for any slant of
/// the light.
#[test]
fn what_lies_on_a_floor_tints_all_of_it() {
    let mut scene = floor(64, 0.2);
    quad(&mut scene, Vec3::Y * 0.002, Vec3::X * 0.25, Vec3::NEG_Z * 0.25, 1);
    assert_eq!(green_pixels(&mut scene, 0.0, 0.02), [0]);
}

/// A ball of few smooth-shaded facets: on the light's side they are lit by the cosine, up to the ball's own
/// terminator, and a facet that points away from the light cuts no notch in it.
#[test]
fn facets_cut_no_notches_in_a_terminator() {
    let tint = Vec4::new(0.5, 0.5, 0.5, 1.0);
    let mut scene = empty(vec![Material { tint, roughness: 1.0, ..material(Transfer::Opaque) }]);
    scene.camera.eye = Vec3::new(0.0, 0.0, 5.0);
    scene.camera.size = UVec2::splat(65);
    let toward = Vec3::new(0.9, 0.3, 0.2).normalize();
    let sun = LightKind::Directional { direction: -toward };
    scene.lights = vec![Light { intensity: PI, ..light(sun) }];
    let at = |i: u32, j: u32| {
        let (around, down) = (i as f32 * PI / 8.0, j as f32 * PI / 8.0);
        Vec3::new(down.sin() * around.cos(), down.cos(), down.sin() * around.sin())
    };
    for (i, j) in (0..8).flat_map(|j| (0..16).map(move |i| (i, j))) {
        let corners = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
        for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
            let positions = [corners[a], corners[b], corners[c]];
            if (positions[1] - positions[0]).cross(positions[2] - positions[0]).length() > 1e-3 {
                scene.triangles.push(Triangle { normals: positions, ..triangle(positions, 0) });
            }
        }
    }
    let slope = (0.5 * scene.camera.fov_y).tan() / 32.5;
    for picture in pictures(&scene) {
        let mut judged = 0;
        for (i, light) in picture.light.iter().enumerate() {
            let x = (i % 65) as f32 - 32.0;
            let ray = Vec3::new(x * slope, (32.0 - (i / 65) as f32) * slope, -1.0).normalize();
            // Point where the ray meets the ball; its rim belongs to the facets.
            let (nearest, eye) = (-ray.dot(scene.camera.eye), scene.camera.eye);
            let off = eye.length_squared() - nearest * nearest;
            if off > 0.85 {
                continue;
            }
            let normal = eye + ray * (nearest - (1.0 - off).sqrt());
            let cosine = normal.dot(toward).max(0.0);
            // A facet's normals are off the ball's by up to 0.02, and the rough ball has some shine.
            let above = light[0] - 0.5 * cosine;
            assert!((-0.03..0.06).contains(&above), "{i}: {light:?} for {}", 0.5 * cosine);
            judged += 1;
        }
        assert!(judged > 300, "{judged}");
    }
}

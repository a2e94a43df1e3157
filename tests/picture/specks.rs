//! Single pixels that are wrong where surfaces are seen or lit at grazing angles.
use crate::common::{
    TIERS, render,
    scenes::{empty, light, material, triangle},
};
use gobo::{
    glam::{UVec2, Vec3, Vec4},
    model::{Light, LightKind, Material, Transfer, Triangle},
    records::Picture,
    reference,
    scene::Scene,
    view::shadow_views,
};
use std::f32::consts::PI;

fn pictures(scene: &Scene) -> Vec<Picture> {
    let views = shadow_views(scene);
    let (maps, _) = reference::render_maps(scene, &views);
    let twin = reference::render_picture(scene, &views, &maps);
    TIERS.map(|tier| render(tier, scene).picture).into_iter().chain([twin]).collect()
}

fn middle(picture: &Picture) -> Vec3 {
    let at = picture.size.y / 2 * picture.size.x + picture.size.x / 2;
    Vec3::from(picture.light[at as usize])
}

/// A facet at a ball's silhouette: it faces the eye, the normal of the ball that it stands for does
/// not. Light that meets both from the front is scattered as the cosine says.
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
    let scattered = 0.5 * normal.x;
    for picture in pictures(&scene) {
        let lit = middle(&picture);
        // And a highlight.
        assert!(lit.x >= 0.98 * scattered && lit.x < 3.0 * scattered, "{lit}");
    }
}

//! Scenes far from the origin, where positions lose their last digits.
use crate::common::scenes::{empty, material, particle, triangle};
use gobo::{
    glam::{Vec3, Vec4},
    model::Transfer,
    scene::Scene,
};

fn smoke_at(away: f32, radius: f32) -> Scene {
    let mut scene = empty(vec![material(Transfer::Filter)]);
    let center = Vec3::new(away, 0.0, 0.0);
    scene.particles = vec![particle(center, radius, Vec4::ONE)];
    scene
}

#[test]
fn smoke_far_from_the_origin_is_warned_of() {
    assert_eq!(smoke_at(100.0, 0.1).rounding_warning(), None);
    assert_eq!(smoke_at(10_000.0, 10.0).rounding_warning(), None);
    let warning = smoke_at(10_000.0, 0.1).rounding_warning().expect("a warning");
    assert!(warning.contains("10000 m") && warning.contains("1.19 mm"), "{warning}");
}

#[test]
fn triangles_far_from_the_origin_are_warned_of() {
    let pane = |at: Vec3| {
        let mut scene = empty(vec![material(Transfer::Filter)]);
        scene.triangles = vec![triangle([at, at + Vec3::X, at + Vec3::Y], 0)];
        scene
    };
    assert_eq!(pane(Vec3::X * 100.0).rounding_warning(), None);
    assert!(pane(Vec3::X * 1e5).rounding_warning().is_some());
    assert_eq!(empty(Vec::new()).rounding_warning(), None);
}

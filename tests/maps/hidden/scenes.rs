//! Scenes with hidden casters.
use super::{ground, square};
use crate::common::scenes::{Chance, empty, light, material, particle, triangle};
use gobo::{
    glam::{Vec3, Vec4},
    model::{Light, LightKind, Material, Particle, Transfer, Triangle},
};
use gobo_scene::Scene;

/// Particles in a ball.
pub(super) fn cloud(
    chance: &mut Chance,
    center: Vec3,
    count: usize,
    material: u32,
) -> Vec<Particle> {
    let one = |_| {
        let color = chance.vec3(0.0, 1.0).extend(chance.within(0.05, 0.9));
        let radius = 0.01 * 30_f32.powf(chance.unit());
        Particle { material, ..particle(center + chance.vec3(-0.5, 0.5), radius, color) }
    };
    (0..count).map(one).collect()
}

fn lights() -> Vec<Light> {
    let sun = LightKind::Directional { direction: Vec3::new(0.2, -1.0, 0.1).normalize() };
    let (position, direction) = (Vec3::new(0.5, 4.0, 0.5), Vec3::NEG_Y);
    let spot = LightKind::Spot { position, direction, angle: 1.2 };
    let bulb = LightKind::Point { position: Vec3::new(-0.3, 3.0, 0.2) };
    let far = |kind| Light { near: Some(0.1), far: Some(20.0), ..light(kind) };
    vec![light(sun), far(spot), far(bulb)]
}

fn materials() -> Vec<Material> {
    vec![
        material(Transfer::Filter),
        material(Transfer::Opaque),
        Material { tint: Vec4::new(0.2, 0.5, 1.0, 0.5), ..material(Transfer::Dither) },
        Material {
            attenuation_color: Vec3::new(0.5, 0.2, 0.8),
            attenuation_distance: 1.0,
            ..material(Transfer::Filter)
        },
    ]
}

/// Smoke above a ground and as much below it, at the same position.
pub(super) fn smoke_and_ground() -> Scene {
    let mut chance = Chance::new(5);
    let mut scene = empty(materials());
    scene.shadow.size = 128;
    scene.lights = lights();
    scene.particles = cloud(&mut chance, Vec3::Y, 200, 0);
    scene.particles.extend(cloud(&mut chance, Vec3::NEG_Y * 2.0, 150, 0));
    scene.triangles = ground(12.0).map(|t| triangle(t, 1)).into();
    scene
}

/// A box of triangles.
pub(super) fn crate_at(center: Vec3, edge: f32, material: u32, id: u32) -> Vec<Triangle> {
    let mut triangles = Vec::new();
    for axis in 0..3 {
        let [x, y, z] = [0, 1, 2].map(|i| Vec3::AXES[(axis + i) % 3] * edge);
        for side in [-0.5, 0.5] {
            let (x, y) = if side > 0.0 { (x, y) } else { (y, x) };
            let both = square(center - (x + y) * 0.5 + z * side, x, y);
            triangles.extend(both.map(|t| Triangle { id, ..triangle(t, material) }));
        }
    }
    triangles
}

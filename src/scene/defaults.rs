//! What a scene has where its file says nothing.
use super::{Bounds, Camera, Scene, document::KindOfShape, shapes};
use crate::{
    caster::{Material, Transfer},
    counters::Skipped,
    light::{Light, LightKind},
    settings::ShadowSettings,
};
use glam::{Mat4, UVec2, Vec3, Vec4};

pub(super) fn empty_scene() -> Scene {
    Scene {
        camera: camera(&Bounds::EMPTY),
        shadow: ShadowSettings::default(),
        lights: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        particles: Vec::new(),
        triangles: Vec::new(),
        ambient: Vec3::new(0.18, 0.20, 0.24),
        background: Vec3::new(0.52, 0.62, 0.75),
        skipped: Skipped::new(),
    }
}

/// Of a particle file on its own.
pub(super) fn particle_material() -> Material {
    Material {
        name: "particles".to_owned(),
        tint: Vec4::new(0.35, 0.6, 0.9, 0.35),
        ..Material::default()
    }
}

pub(super) fn sun() -> Light {
    Light {
        name: "sun".to_owned(),
        kind: LightKind::Directional { direction: Vec3::new(-0.4, -1.0, -0.3).normalize() },
        color: Vec3::ONE,
        intensity: 3.0,
        near: None,
        far: None,
        size: None,
        casts: true,
        cascades: 1,
    }
}

/// A three-quarter view from slightly above that holds the whole box.
pub(super) fn camera(bounds: &Bounds) -> Camera {
    let (center, radius) =
        if bounds.is_empty() { (Vec3::ZERO, 1.0) } else { (bounds.center(), bounds.radius()) };
    let fov_y = 45f32.to_radians();
    let distance = radius.max(1e-3) / (fov_y * 0.5).sin();
    Camera {
        eye: center + Vec3::new(0.55, 0.45, 0.8).normalize() * distance,
        target: center,
        up: Vec3::Y,
        fov_y,
        size: UVec2::new(960, 540),
    }
}

/// A light-grey floor just under what a bare model or particle file holds, to receive its shadow.
pub(super) fn add_ground(scene: &mut Scene) {
    let bounds = scene.bounds();
    if bounds.is_empty() {
        return;
    }
    let extent = (bounds.max - bounds.min).max_element().max(1e-3);
    let center = bounds.center();
    let place = Vec3::new(center.x, bounds.min.y - extent * 1e-3, center.z);
    let transform = Mat4::from_translation(place) * Mat4::from_scale(Vec3::splat(extent * 3.0));
    let material = scene.materials.len() as u32;
    scene.materials.push(Material {
        name: "ground".to_owned(),
        transfer: Transfer::Opaque,
        tint: Vec4::new(0.72, 0.72, 0.70, 1.0),
        ..Material::default()
    });
    scene.triangles.extend(shapes::shape(KindOfShape::Plane, transform, material));
}

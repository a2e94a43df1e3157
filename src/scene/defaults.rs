//! What a scene has where its file says nothing.
use super::{Bounds, Camera, Scene, document::KindOfShape, shapes};
use crate::model::{
    ClusterSettings, Light, LightKind, Material, ShadowSettings, Skipped, Transfer,
};
use glam::{Mat4, UVec2, Vec3, Vec4};

impl Scene {
    /// No casters and no lights; all else as where a file says nothing.
    pub fn empty() -> Self {
        empty_scene()
    }
}

pub(super) fn empty_scene() -> Scene {
    Scene {
        camera: camera(&Bounds::EMPTY),
        shadow: ShadowSettings::default(),
        clusters: ClusterSettings::default(),
        lights: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        animated: Vec::new(),
        displaced: Vec::new(),
        particles: Vec::new(),
        triangles: Vec::new(),
        ambient: Vec3::new(0.18, 0.20, 0.24),
        background: Vec3::new(0.52, 0.62, 0.75),
        air: None,
        skipped: Skipped::new(),
        notes: Vec::new(),
    }
}

/// Of a particle file on its own.
pub(super) const PARTICLE_MATERIAL: &str = r#"
[[material]]
name = "particles"
tint = [0.35, 0.6, 0.9, 0.35]
"#;

/// [`sun`] as a scene file says it.
pub(super) const SUN: &str = r#"
[[light]]
name = "sun"
kind = "directional"
direction = [-0.4, -1, -0.3]
intensity = 3
"#;

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
        cascades: None,
        shadows: Vec::new(),
        shafts: true,
    }
}

/// A three-quarter view from slightly above that holds the whole box.
pub(super) fn camera(bounds: &Bounds) -> Camera {
    let mut camera = Camera {
        eye: Vec3::ONE,
        target: bounds.or_unit().center(),
        up: Vec3::Y,
        fov_y: 45f32.to_radians(),
        size: UVec2::new(960, 540),
    };
    camera.eye = eye(&camera, bounds);
    camera
}

/// From where the sphere around the box fits into the picture.
pub(super) fn eye(camera: &Camera, bounds: &Bounds) -> Vec3 {
    let radius = bounds.or_unit().radius().max(1e-3);
    let aspect = camera.size.x as f32 / camera.size.y as f32;
    let half = (camera.fov_y * 0.5).tan() * aspect.min(1.0);
    let distance = radius * (1.0 + half * half).sqrt() / half;
    // Far from the origin a short way would be lost in rounding.
    let distance = distance.max(camera.target.abs().max_element() * 1e-4);
    camera.target + Vec3::new(0.55, 0.45, 0.8).normalize() * distance
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
    scene.triangles.extend(shapes::shape(KindOfShape::Plane, 0, transform, material, u32::MAX));
}

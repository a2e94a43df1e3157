//! Stands in for the scene reader.
use super::{Bounds, Scene, SceneError};
use std::path::Path;

pub fn load(path: &Path) -> Result<Scene, SceneError> {
    load_with(path, &[])
}

pub fn load_with(path: &Path, _set: &[(String, String)]) -> Result<Scene, SceneError> {
    std::fs::read(path)
        .map_err(|error| SceneError::Read { path: path.to_owned(), source: error })?;
    use glam::{UVec2, Vec3};
    Ok(Scene {
        camera: super::Camera {
            eye: Vec3::ONE,
            target: Vec3::ZERO,
            up: Vec3::Y,
            fov_y: 0.8,
            size: UVec2::new(40, 24),
        },
        shadow: crate::settings::ShadowSettings { size: 32, ..Default::default() },
        lights: [
            ("key/light", None, crate::light::LightKind::Directional { direction: Vec3::NEG_Y }),
            ("lamp", Some(16), crate::light::LightKind::Point { position: Vec3::Y * 2.0 }),
        ]
        .map(|(name, size, kind)| crate::light::Light {
            name: name.to_owned(),
            kind,
            color: Vec3::ONE,
            intensity: 1.0,
            near: None,
            far: None,
            size,
            casts: true,
            cascades: 1,
        })
        .to_vec(),
        materials: Vec::new(),
        textures: Vec::new(),
        particles: Vec::new(),
        triangles: Vec::new(),
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        skipped: Default::default(),
    })
}

impl Scene {
    pub fn summary(&self) -> String {
        format!("{:?}", self.bounds() == Bounds::EMPTY)
    }
}

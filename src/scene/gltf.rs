use super::{Camera, SceneError};
use crate::{caster::{Material, Texture, Triangle}, counters::Skipped, light::Light};
use glam::Mat4;
use std::path::Path;
#[derive(Debug, Default)]
pub(super) struct Model { pub materials: Vec<Material>, pub textures: Vec<Texture>, pub triangles: Vec<Triangle>, pub lights: Vec<Light>, pub camera: Option<Camera>, pub skipped: Skipped }
pub(super) fn load(_path: &Path, _transform: Mat4) -> Result<Model, SceneError> { Ok(Model::default()) }

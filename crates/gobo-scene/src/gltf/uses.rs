//! Texture coordinates of a primitive in its material.
use glam::Vec2;

/// A primitive's use of its material.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Uses {
    /// Index into the model's materials.
    pub(crate) material: u32,
    pub(crate) uv_set: u32,
    offset: Vec2,
    rotation: f32,
    scale: Vec2,
}

impl Uses {
    /// `KHR_texture_transform`: scale, then rotation (counterclockwise, v points down), then offset.
    pub(crate) fn transform_uv(&self, uv: Vec2) -> Vec2 {
        let (uv, (sin, cos)) = (uv * self.scale, self.rotation.sin_cos());
        self.offset + Vec2::new(cos * uv.x + sin * uv.y, cos * uv.y - sin * uv.x)
    }

    pub(super) fn new(material: u32, info: Option<&gltf::texture::Info<'_>>) -> Self {
        let mut uses =
            Self { material, uv_set: 0, offset: Vec2::ZERO, rotation: 0.0, scale: Vec2::ONE };
        let Some(info) = info else { return uses };
        uses.uv_set = info.tex_coord();
        if let Some(transform) = info.texture_transform() {
            uses.uv_set = transform.tex_coord().unwrap_or(uses.uv_set);
            uses.offset = transform.offset().into();
            uses.rotation = transform.rotation();
            uses.scale = transform.scale().into();
        }
        uses
    }

    pub(super) fn has_same_uvs(&self, other: &Self) -> bool {
        self.uv_set == other.uv_set
            && self.offset == other.offset
            && self.rotation == other.rotation
            && self.scale == other.scale
    }
}

//! Clear coats of glTF materials (`KHR_materials_clearcoat`): lacquer and varnish.
use super::{
    details::{add_normals, data_image},
    texture::{Textures, image},
};
use crate::SceneError;
use ::gltf::Document;
use gobo::model;
use serde_json::Value;

/// Clear coat of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coat {
    /// Covered share of the surface.
    factor: f32,
    roughness: f32,
    /// Texture whose red channel multiplies the factor.
    share: Option<usize>,
    /// Texture whose green channel multiplies the roughness.
    rough: Option<usize>,
    /// Texture of its normals, of which x and y are times the number.
    normals: Option<(usize, f32)>,
    /// The texture coordinates of its first texture, if it has any.
    uv_set: Option<u32>,
    /// Whether textures have coordinates or a transform of their own.
    is_placed: bool,
}

/// Coats by material; `None` without.
pub(crate) fn all(root: &Value) -> Vec<Option<Coat>> {
    let of_material = |material: &Value| {
        let table = material.get("extensions")?.get("KHR_materials_clearcoat")?;
        let number = |key: &str| {
            let number = table.get(key).and_then(Value::as_f64).unwrap_or(0.0);
            number.clamp(0.0, 1.0) as f32
        };
        let index = |key: &str| table.get(key)?.get("index")?.as_u64()?.try_into().ok();
        let keys = ["clearcoatTexture", "clearcoatRoughnessTexture", "clearcoatNormalTexture"];
        let scale = || {
            let scale = table.get(keys[2])?.get("scale")?.as_f64()?;
            Some(scale.clamp(-100.0, 100.0) as f32)
        };
        let place = |texture: &Value| {
            let set = texture.get("texCoord").and_then(Value::as_u64).unwrap_or(0);
            (set, texture.pointer("/extensions/KHR_texture_transform").cloned())
        };
        let places: Vec<_> = keys.iter().filter_map(|key| table.get(key)).map(place).collect();
        let set = places.first().map(|(set, _)| *set);
        let base = material.pointer("/pbrMetallicRoughness/baseColorTexture");
        let usual = base.map_or((set.unwrap_or(0), None), place);
        let factor = number("clearcoatFactor");
        (factor > 0.0).then(|| Coat {
            factor,
            roughness: number("clearcoatRoughnessFactor"),
            share: index(keys[0]),
            rough: index(keys[1]),
            normals: index(keys[2]).map(|texture| (texture, scale().unwrap_or(1.0))),
            uv_set: set.and_then(|set| u32::try_from(set).ok()),
            is_placed: places.iter().any(|place| *place != usual),
        })
    };
    let materials = root.get("materials").and_then(Value::as_array).into_iter().flatten();
    materials.map(of_material).collect()
}

impl Coat {
    /// The texture coordinates of its first texture, if it has any.
    pub(super) fn uv_set(&self) -> Option<u32> {
        self.uv_set
    }

    /// Whether its textures have other coordinates than a set without a transform.
    pub(super) fn has_other_uvs(&self, uv_set: u32) -> bool {
        self.is_placed || self.uv_set.is_some_and(|own| own != uv_set)
    }

    /// The material of the coat.
    pub(super) fn material(
        &self,
        name: &str,
        document: &Document,
        textures: &mut Textures<'_>,
    ) -> Result<model::Material, SceneError> {
        let [share, rough] = [self.share, self.rough].map(|texture| image(document, texture));
        let normals =
            self.normals.and_then(|(index, by)| Some((image(document, Some(index))?, by)));
        let texture = match share.is_some() || rough.is_some() {
            true => {
                // Infinity, which no factor is, tells these numbers from those of other images.
                let numbers = [f32::INFINITY, self.factor, self.roughness];
                let images = [share.as_ref(), rough.as_ref()];
                let shares = |[share, rough]: [[f32; 4]; 2]| {
                    [self.factor * share[0], self.roughness * rough[1], 0.0]
                };
                Some(textures.add_data(images, numbers, |images| data_image(images, shares))?)
            }
            false => None,
        };
        let emissive_texture = match &normals {
            Some((image, factor)) => Some(add_normals(textures, image, *factor)?),
            None => None,
        };
        Ok(model::Material {
            name: format!("{name} (coat)"),
            texture,
            emissive_texture,
            reflectivity: self.factor,
            roughness: self.roughness,
            ..model::Material::default()
        })
    }
}

//! Clear coats of glTF materials (`KHR_materials_clearcoat`): lacquer and varnish.
use serde_json::Value;

/// Clear coat of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coat {
    /// Covered share of the surface.
    pub(super) factor: f32,
    pub(super) roughness: f32,
    /// Texture whose red channel multiplies the factor.
    pub(super) share: Option<usize>,
    /// Texture whose green channel multiplies the roughness.
    pub(super) rough: Option<usize>,
    /// Texture of its normals, of which x and y are times the number.
    pub(super) normals: Option<(usize, f32)>,
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
}

//! Diffuse transmission of glTF materials (`KHR_materials_diffuse_transmission`): leaves, cloth and paper.
use glam::Vec3;
use serde_json::Value;

/// Diffuse transmission of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Diffuse {
    /// Transmitted share of the light that is not mirrored.
    pub(crate) factor: f32,
    pub(crate) color: Vec3,
    /// Texture whose alpha multiplies the factor.
    pub(crate) share: Option<usize>,
    /// Texture whose rgb multiplies the colour.
    pub(crate) tint: Option<usize>,
    /// Whether a texture has coordinates or a transform of its own.
    pub(crate) is_placed: bool,
}

/// Diffuse transmission by material; `None` without.
pub(crate) fn all(root: &Value) -> Vec<Option<Diffuse>> {
    let of_material = |material: &Value| {
        let table = material.get("extensions")?.get("KHR_materials_diffuse_transmission")?;
        let number = |value: &Value| value.as_f64().map(|number| number.clamp(0.0, 1.0) as f32);
        let factor = table.get("diffuseTransmissionFactor").and_then(number).unwrap_or(0.0);
        let color = table.get("diffuseTransmissionColorFactor").and_then(Value::as_array);
        let channel = |i: usize| color.and_then(|color| number(color.get(i)?)).unwrap_or(1.0);
        let texture = |key: &str| table.get(key);
        let index = |key: &str| texture(key)?.get("index")?.as_u64()?.try_into().ok();
        let base = material.pointer("/pbrMetallicRoughness/baseColorTexture");
        let place = |texture: &Value| {
            let set = texture.get("texCoord").and_then(Value::as_u64).unwrap_or(0);
            (set, texture.pointer("/extensions/KHR_texture_transform").cloned())
        };
        let keys = ["diffuseTransmissionTexture", "diffuseTransmissionColorTexture"];
        let usual = base.map_or((0, None), place);
        let is_placed = keys.iter().filter_map(|key| texture(key)).any(|t| place(t) != usual);
        (factor > 0.0).then(|| Diffuse {
            factor,
            color: Vec3::from([0, 1, 2].map(channel)),
            share: index(keys[0]),
            tint: index(keys[1]),
            is_placed,
        })
    };
    let materials = root.get("materials").and_then(Value::as_array).into_iter().flatten();
    materials.map(of_material).collect()
}

impl Diffuse {
    /// Share that the near side does not scatter, unless a texture states it.
    pub(crate) fn lacks(&self) -> f32 {
        if self.share.is_some() { 0.0 } else { self.factor }
    }
}

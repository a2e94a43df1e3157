//! Primitives of splats in the JSON of a glTF file: `KHR_gaussian_splatting`.
use super::error::quoted;
use serde_json::Value;

const EXTENSION: &str = "KHR_gaussian_splatting";

/// A primitive of splats: its accessors.
#[derive(Clone, Debug)]
pub(super) struct SplatPrimitive {
    /// Index of the mesh.
    pub(super) mesh: usize,
    pub(super) position: usize,
    pub(super) rotation: usize,
    pub(super) scale: usize,
    pub(super) opacity: usize,
    pub(super) color: usize,
    /// Coefficients of higher spherical harmonics.
    pub(super) harmonics: usize,
}

/// Takes the primitives of splats out of the document: the `gltf` crate refuses the names of their attributes.
pub(super) fn take(root: &mut Value) -> Result<Vec<SplatPrimitive>, (String, &'static str)> {
    let mut taken = Vec::new();
    let meshes = root.get_mut("meshes").and_then(Value::as_array_mut);
    for (mesh, value) in meshes.into_iter().flatten().enumerate() {
        let Some(primitives) = value.get_mut("primitives").and_then(Value::as_array_mut) else {
            continue;
        };
        for primitive in primitives.extract_if(.., |primitive| extension(primitive).is_some()) {
            taken.push(splat_primitive(mesh, &primitive)?);
        }
    }
    Ok(taken)
}

fn extension(primitive: &Value) -> Option<&Value> {
    primitive.get("extensions")?.get(EXTENSION)
}

fn splat_primitive(
    mesh: usize,
    primitive: &Value,
) -> Result<SplatPrimitive, (String, &'static str)> {
    let compressed = extension(primitive).and_then(|named| named.get("extensions")?.as_object());
    if let Some(name) = compressed.and_then(|extensions| extensions.keys().next()) {
        let message =
            format!("mesh {mesh}: its splats need {}, which gobo does not read", quoted(name));
        return Err((message, "export the splats without compression"));
    }
    let attribute = |name: &str| {
        let index = primitive.get("attributes").and_then(|all| all.get(name)?.as_u64());
        let missing = || {
            let message = format!("mesh {mesh}: its splats have no attribute {}", quoted(name));
            (message, "export the file again")
        };
        index.map(|index| index as usize).ok_or_else(missing)
    };
    let named = |name: &str| attribute(&format!("{EXTENSION}:{name}"));
    let attributes = primitive.get("attributes").and_then(Value::as_object);
    let names = attributes.into_iter().flat_map(serde_json::Map::keys);
    Ok(SplatPrimitive {
        mesh,
        position: attribute("POSITION")?,
        rotation: named("ROTATION")?,
        scale: named("SCALE")?,
        opacity: named("OPACITY")?,
        color: named("SH_DEGREE_0_COEF_0")?,
        harmonics: names.filter(|name| name.contains(":SH_DEGREE_")).count().saturating_sub(1),
    })
}

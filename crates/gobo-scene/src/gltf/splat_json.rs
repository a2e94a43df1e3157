//! Primitives of splats in the JSON of a glTF file: `KHR_gaussian_splatting`.
use crate::error::quoted;
use serde_json::Value;

const EXTENSION: &str = "KHR_gaussian_splatting";

/// Highest degree of spherical harmonics.
const MOST_DEGREES: usize = 4;

/// Extensions for an SPZ file in a view: a draft, and its later name.
pub(crate) const SPZ: [&str; 2] =
    ["KHR_gaussian_splatting_compression_spz_2", "KHR_gaussian_splatting_compression_spz"];

/// A primitive of splats.
#[derive(Clone, Debug)]
pub(crate) struct SplatPrimitive {
    /// Index of the mesh.
    pub(crate) mesh: usize,
    pub(crate) stored: Stored,
}

/// Storage of a primitive's splats.
#[derive(Clone, Debug)]
pub(crate) enum Stored {
    /// In accessors.
    Attributes {
        position: usize,
        rotation: usize,
        scale: usize,
        opacity: usize,
        color: usize,
        /// Coefficients of higher spherical harmonics, of whole degrees.
        harmonics: Vec<usize>,
        /// Number of attributes of such coefficients.
        named: usize,
    },
    /// In an SPZ file, in a view.
    Spz { view: usize },
}

/// Takes the primitives of splats out of the document: the `gltf` crate refuses the names of their
/// attributes.
pub(crate) fn take(root: &mut Value) -> Result<Vec<SplatPrimitive>, (String, &'static str)> {
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
    if let Some((name, packed)) = compressed.and_then(|all| all.iter().next()) {
        if !SPZ.contains(&name.as_str()) {
            let message =
                format!("mesh {mesh}: its splats need {}, which gobo does not read", quoted(name));
            return Err((message, "export the splats without compression"));
        }
        let view = packed.get("bufferView").and_then(Value::as_u64);
        let missing =
            || (format!("mesh {mesh}: {name} has no bufferView"), "export the file again");
        let view = view.ok_or_else(missing)? as usize;
        return Ok(SplatPrimitive { mesh, stored: Stored::Spz { view } });
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
    let of_degree = |degree: usize| -> Option<Vec<usize>> {
        let name = |i: usize| format!("SH_DEGREE_{degree}_COEF_{i}");
        (0..=2 * degree).map(|i| named(&name(i)).ok()).collect()
    };
    let stored = Stored::Attributes {
        position: attribute("POSITION")?,
        rotation: named("ROTATION")?,
        scale: named("SCALE")?,
        opacity: named("OPACITY")?,
        color: named("SH_DEGREE_0_COEF_0")?,
        harmonics: (1..=MOST_DEGREES).map_while(of_degree).flatten().collect(),
        named: names.filter(|name| name.contains(":SH_DEGREE_")).count().saturating_sub(1),
    };
    Ok(SplatPrimitive { mesh, stored })
}

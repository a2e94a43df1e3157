//! The JSON of a glTF file, adapted to the `gltf` crate, which refuses some valid files and ignores some
//! relevant parts.
use super::ignored::Ignored;
use crate::{
    error::{Fault, quoted},
    limits,
};
use serde_json::{Map, Value, json};

/// Extensions that this module or the `gltf` crate supports.
pub(crate) const EXTENSIONS: [&str; 23] = [
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_gaussian_splatting",
    "KHR_gaussian_splatting_compression_spz",
    "KHR_gaussian_splatting_compression_spz_2",
    "KHR_lights_punctual",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

const EXPORT_AGAIN: &str = "check it with a glTF validator, or export it again";

/// Parses and adapts the JSON. Also returns its ignored parts, and the number of textures without an image of
/// a supported kind.
pub(crate) fn parse(bytes: &[u8]) -> Result<(Value, Ignored, usize), Fault> {
    if !limits::has_memory(parsed_size(bytes)) {
        let message = format!("no memory for {} MiB of JSON", bytes.len() >> 20);
        return Err((message, "use a smaller file, or a machine with more memory"));
    }
    let mut root: Value = serde_json::from_slice(bytes)
        .map_err(|error| (format!("not valid JSON: {error}"), EXPORT_AGAIN))?;
    check_version(&root)?;
    check_required(&mut root)?;
    remove_extras(&mut root);
    let ignored = Ignored::take(&mut root);
    if let Some(scenes) = list(&mut root, "scenes") {
        for scene in scenes.iter_mut().filter_map(Value::as_object_mut) {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    let unread = pick_sources(&mut root);
    keep_channels_of_nodes(&mut root);
    Ok((root, ignored, unread))
}

/// Upper estimate of the parsed document's size \[bytes\], held twice: as values and in the crate's types.
fn parsed_size(text: &[u8]) -> u64 {
    let size = |byte: &u8| match byte {
        b'{' => 600,
        b',' | b':' | b'[' => 100,
        _ => 1,
    };
    text.iter().map(size).sum()
}

/// Gives accessors without data, whose items are zeros, a sparse item of zeros: the `gltf` crate refuses them
/// otherwise.
pub(crate) fn add_zeros(root: &mut Value) {
    let Some(accessors) = list(root, "accessors") else { return };
    let has_data =
        |accessor: &Value| accessor.get("bufferView").is_some() || accessor.get("sparse").is_some();
    if accessors.iter().all(has_data) {
        return;
    }
    // As long as the largest item.
    let zeros = format!("data:application/octet-stream;base64,{}==", "A".repeat(86));
    let mut push = |key: &str, item: Value| {
        let items = root.as_object_mut()?.entry(key).or_insert_with(|| json!([]));
        let items = items.as_array_mut()?;
        items.push(item);
        Some(items.len() - 1)
    };
    let buffer = push("buffers", json!({ "byteLength": 64, "uri": zeros }));
    let view = push("bufferViews", json!({ "buffer": buffer, "byteLength": 64 }));
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": view, "componentType": 5121 },
        "values": { "bufferView": view },
    });
    for accessor in list(root, "accessors").into_iter().flatten() {
        if let Some(accessor) = accessor.as_object_mut()
            && !accessor.contains_key("bufferView")
        {
            accessor.entry("sparse").or_insert_with(|| sparse.clone());
        }
    }
}

/// Keeps the animation channels of nodes. Channels without a node, or of other properties
/// (`KHR_animation_pointer`), are valid, but the `gltf` crate panics at their paths and refuses files where
/// they name no node.
fn keep_channels_of_nodes(root: &mut Value) {
    const PATHS: [&str; 4] = ["translation", "rotation", "scale", "weights"];
    let moves_node = |channel: &Value| {
        let Some(target) = channel.get("target") else { return true };
        let path = target.get("path").and_then(Value::as_str);
        target.get("node").is_some() && path.is_some_and(|path| PATHS.contains(&path))
    };
    for animation in list(root, "animations").into_iter().flatten() {
        if let Some(channels) = list(animation, "channels") {
            channels.retain(moves_node);
        }
    }
}

fn list<'a>(root: &'a mut Value, key: &str) -> Option<&'a mut Vec<Value>> {
    root.get_mut(key)?.as_array_mut()
}

/// Refuses a file of a later version, unless its `minVersion` says that it can be read as 2.0.
fn check_version(root: &Value) -> Result<(), Fault> {
    let word = |key| root.get("asset").and_then(|asset| asset.get(key)).and_then(Value::as_str);
    let Some(version) = word("version") else {
        return Err(("has no asset.version".to_owned(), EXPORT_AGAIN));
    };
    let number = |version: &str| {
        let (major, minor) = version.split_once('.')?;
        Some((major.parse::<u32>().ok()?, minor.parse::<u32>().ok()?))
    };
    let least =
        word("minVersion").unwrap_or(if version.starts_with("2.") { "2.0" } else { version });
    match number(least) {
        Some((2, 0)) => Ok(()),
        _ => Err((format!("needs glTF {}", quoted(least)), "export it as glTF 2.0")),
    }
}

fn check_required(root: &mut Value) -> Result<(), Fault> {
    let required = root.get("extensionsRequired").and_then(Value::as_array).into_iter().flatten();
    let mut required = required.filter_map(Value::as_str);
    if let Some(name) = required.find(|name| !EXTENSIONS.contains(name)) {
        let message = format!("requires {}, which gobo does not read", quoted(name));
        return Err((message, remedy(name)));
    }
    // The crate refuses files that require an extension that only this module supports.
    if let Some(root) = root.as_object_mut() {
        root.remove("extensionsRequired");
    }
    Ok(())
}

/// Remedy for images that are not read.
pub(crate) const OTHER_IMAGES: &str = "export with PNG, JPEG, WebP or KTX2 textures";

/// Remedy for an extension that is not read.
pub(crate) fn remedy(name: &str) -> &'static str {
    match name {
        _ if name.starts_with("EXT_texture_") => OTHER_IMAGES,
        _ if name.starts_with("KHR_gaussian_splatting") => "export the splats without compression",
        _ => "export without compression or optional extensions",
    }
}

/// Removes `extras`, which may be of any type; the crate accepts objects only.
fn remove_extras(value: &mut Value) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(remove_extras),
        Value::Object(object) => {
            object.remove("extras");
            object.values_mut().for_each(remove_extras);
        }
        _ => {}
    }
}

/// Chooses the image of each texture: that of `EXT_texture_webp`, or else its own, or else that of
/// `KHR_texture_basisu`; a texture without an image is white. Returns the number of textures with an image of
/// another extension only.
fn pick_sources(root: &mut Value) -> usize {
    let white = list(root, "images").map_or(0, |images| images.len());
    let (mut needs_white, mut unread) = (false, 0);
    for texture in list(root, "textures").into_iter().flatten().filter_map(Value::as_object_mut) {
        let plain = texture.get("source").cloned();
        let webp = source_of(texture, "EXT_texture_webp");
        if let Some(source) = webp.or(plain).or_else(|| source_of(texture, "KHR_texture_basisu")) {
            texture.insert("source".to_owned(), source);
        } else {
            unread += usize::from(texture.contains_key("extensions"));
            texture.insert("source".to_owned(), white.into());
            needs_white = true;
        }
    }
    if needs_white && let Some(root) = root.as_object_mut() {
        let images = root.entry("images").or_insert_with(|| Value::Array(Vec::new()));
        if let Some(images) = images.as_array_mut() {
            images.push(serde_json::json!({ "uri": WHITE }));
        }
    }
    unread
}

fn source_of(texture: &Map<String, Value>, extension: &str) -> Option<Value> {
    texture.get("extensions")?.get(extension)?.get("source").cloned()
}

/// A PNG of one white texel.
const WHITE: &str = "data:image/png;base64,\
    iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGP4DwABAQEAsTj2FAAAAABJRU5ErkJggg==";

/// Indices of the accessors that `EXT_mesh_gpu_instancing` gives a node.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Instancing {
    pub(crate) translation: Option<usize>,
    pub(crate) rotation: Option<usize>,
    pub(crate) scale: Option<usize>,
}

/// Instancing of each node; empty if no node has instances.
pub(crate) fn instancing(root: &Value) -> Vec<Option<Instancing>> {
    let of_node = |node: &Value| {
        let attributes =
            node.get("extensions")?.get("EXT_mesh_gpu_instancing")?.get("attributes")?;
        let accessor = |name| attributes.get(name)?.as_u64().map(|index| index as usize);
        Some(Instancing {
            translation: accessor("TRANSLATION"),
            rotation: accessor("ROTATION"),
            scale: accessor("SCALE"),
        })
    };
    let nodes = root.get("nodes").and_then(Value::as_array).into_iter().flatten();
    let all: Vec<_> = nodes.map(of_node).collect();
    if all.iter().all(Option::is_none) { Vec::new() } else { all }
}

/// Dispersion of each material (`KHR_materials_dispersion`): 20 over its Abbe number, 0 for none, at most 20.
pub(crate) fn dispersion(root: &Value) -> Vec<f32> {
    let of_material = |material: &Value| {
        let table = material.get("extensions")?.get("KHR_materials_dispersion")?;
        let number = table.get("dispersion")?.as_f64()? as f32;
        Some(number.clamp(0.0, 20.0))
    };
    let materials = root.get("materials").and_then(Value::as_array).into_iter().flatten();
    materials.map(|material| of_material(material).unwrap_or(0.0)).collect()
}

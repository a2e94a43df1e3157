//! Variants of a glTF file's materials (`KHR_materials_variants`) and hidden nodes (`KHR_node_visibility`),
//! resolved in its JSON.
use crate::{error::quoted, plain::nearest};
use serde_json::Value;
use std::{collections::BTreeSet, path::Path};

const EXTENSION: &str = "KHR_materials_variants";

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value.get(key).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

fn names(root: &Value) -> Vec<&str> {
    let own = root.get("extensions").and_then(|all| all.get(EXTENSION));
    own.map_or(&[][..], |own| list(own, "variants"))
        .iter()
        .map(|variant| variant.get("name").and_then(Value::as_str).unwrap_or_default())
        .collect()
}

/// Gives primitives the materials of a variant; without a name they keep their own. Returns a note about
/// unused variants, or the problem and the remedy.
pub(crate) fn choose(
    root: &mut Value,
    path: &Path,
    variant: Option<&str>,
) -> Result<Option<String>, (String, String)> {
    let names = names(root);
    let Some(variant) = variant else {
        let listed: Vec<String> = names.iter().take(12).map(|name| quoted(name)).collect();
        let note = "materials have variants, which `variant` of a [[mesh]] chooses";
        let path = path.display();
        return Ok((!listed.is_empty()).then(|| format!("{path}: {note}: {}", listed.join(", "))));
    };
    let Some(index) = names.iter().position(|name| *name == variant) else {
        let message = format!("has no variant {}", quoted(variant));
        let help = nearest(variant, names.iter().copied());
        let none = || "remove `variant`: the file has none".to_owned();
        return Err((message, help.unwrap_or_else(none)));
    };
    let meshes = root.get_mut("meshes").and_then(Value::as_array_mut).into_iter().flatten();
    let lists = meshes.filter_map(|mesh| mesh.get_mut("primitives")?.as_array_mut());
    for primitive in lists.flatten() {
        let own = primitive.get("extensions").and_then(|all| all.get(EXTENSION));
        let mappings = own.map_or(&[][..], |own| list(own, "mappings"));
        let is_chosen = |mapping: &&Value| {
            list(mapping, "variants").iter().any(|other| other.as_u64() == Some(index as u64))
        };
        let material = mappings.iter().find(is_chosen).and_then(|mapping| mapping.get("material"));
        if let (Some(material), Some(primitive)) = (material.cloned(), primitive.as_object_mut()) {
            primitive.insert("material".to_owned(), material);
        }
    }
    Ok(None)
}

/// Removes meshes and lights from hidden nodes and the nodes below them; returns their number.
pub(crate) fn hide(root: &mut Value) -> usize {
    let nodes = list(root, "nodes");
    let is_hidden = |node: &Value| {
        let own = node.get("extensions").and_then(|all| all.get("KHR_node_visibility"));
        own.and_then(|own| own.get("visible")?.as_bool()) == Some(false)
    };
    let mut waiting: Vec<usize> =
        nodes.iter().enumerate().filter(|(_, node)| is_hidden(node)).map(|(i, _)| i).collect();
    let mut hidden = BTreeSet::new();
    while let Some(i) = waiting.pop() {
        if let Some(node) = nodes.get(i).filter(|_| hidden.insert(i)) {
            let children = list(node, "children").iter().filter_map(Value::as_u64);
            waiting.extend(children.map(|child| child as usize));
        }
    }
    let animations = root.get_mut("animations").and_then(Value::as_array_mut).into_iter().flatten();
    for channels in animations.filter_map(|animation| animation.get_mut("channels")?.as_array_mut())
    {
        channels.retain(|channel| {
            let target = channel.get("target");
            let path = target.and_then(|target| target.get("path")?.as_str());
            let node = target.and_then(|target| target.get("node")?.as_u64());
            path != Some("weights") || !node.is_some_and(|node| hidden.contains(&(node as usize)))
        });
    }
    let nodes = root.get_mut("nodes").and_then(Value::as_array_mut);
    let mut count = 0;
    for node in nodes.into_iter().flatten().enumerate().filter(|(i, _)| hidden.contains(i)) {
        let Some(node) = node.1.as_object_mut() else { continue };
        count += usize::from(node.remove("mesh").is_some());
        // Properties of a mesh alone.
        node.remove("skin");
        node.remove("weights");
        if let Some(extensions) = node.get_mut("extensions").and_then(Value::as_object_mut) {
            extensions.remove("KHR_lights_punctual");
            extensions.remove("EXT_mesh_gpu_instancing");
        }
    }
    count
}

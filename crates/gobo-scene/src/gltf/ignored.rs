//! Parts of a glTF file that are not read, each named once in a note.
use super::json::EXTENSIONS;
use crate::error::quoted;
use serde_json::{Map, Value};
use std::{collections::BTreeSet, path::Path};

/// Parts of a document that are not read.
#[derive(Debug, Default)]
pub(crate) struct Ignored {
    extensions: BTreeSet<String>,
    attributes: BTreeSet<String>,
    /// Properties, in words.
    properties: BTreeSet<&'static str>,
}

/// Attributes of a primitive that the `gltf` crate knows: these words alone, or with the number of a set.
const WORDS: [&str; 3] = ["POSITION", "NORMAL", "TANGENT"];
const SETS: [&str; 4] = ["COLOR_", "TEXCOORD_", "JOINTS_", "WEIGHTS_"];

/// Sampler modes without effect: the wrap mode of a sampler that repeats, and the filter of one that does not
/// interpolate.
const REPEAT: u64 = 10497;
const NEAREST: u64 = 9728;

impl Ignored {
    /// Collects ignored parts, and removes attributes that the `gltf` crate refuses.
    pub(crate) fn take(root: &mut Value) -> Self {
        let mut ignored = Self::default();
        ignored.extensions(root);
        let used = root.get("extensionsUsed").and_then(Value::as_array).into_iter().flatten();
        let used = used.filter_map(Value::as_str).filter(|name| !EXTENSIONS.contains(name));
        ignored.extensions.extend(used.map(str::to_owned));
        ignored.attributes(root);
        ignored.properties(root);
        ignored
    }

    /// Collects the extensions of all objects, as some files do not list them.
    fn extensions(&mut self, value: &Value) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| self.extensions(item)),
            Value::Object(object) => {
                let names = object.get("extensions").and_then(Value::as_object);
                let names = names.into_iter().flat_map(Map::keys);
                let unread = names.filter(|name| !EXTENSIONS.contains(&name.as_str()));
                self.extensions.extend(unread.cloned());
                object.values().for_each(|inner| self.extensions(inner));
            }
            _ => {}
        }
    }

    fn attributes(&mut self, root: &mut Value) {
        let meshes = root.get_mut("meshes").and_then(Value::as_array_mut);
        let lists = meshes.into_iter().flatten().filter_map(|mesh| mesh.get_mut("primitives"));
        for primitive in lists.filter_map(Value::as_array_mut).flatten() {
            let is_splat = |all: &Value| all.get("KHR_gaussian_splatting").is_some();
            if primitive.get("extensions").is_some_and(is_splat) {
                continue;
            }
            let targets = primitive.get("targets").and_then(Value::as_array).into_iter().flatten();
            let moved = targets.filter_map(Value::as_object).flat_map(Map::keys);
            let spare = moved.filter(|name| !WORDS.contains(&name.as_str()));
            self.attributes.extend(spare.map(|name| format!("{name} of morph targets")));
            let names = attributes_of(primitive, "/attributes").map(|all| all.keys().cloned());
            let names: Vec<String> = names.into_iter().flatten().collect();
            for name in names.into_iter().filter(|name| !is_known(name) || is_spare(name)) {
                if !is_known(&name) {
                    let packed = "/extensions/KHR_draco_mesh_compression/attributes";
                    for place in ["/attributes", packed] {
                        attributes_of(primitive, place).map(|all| all.remove(&name));
                    }
                }
                self.attributes.insert(name);
            }
        }
    }

    fn properties(&mut self, root: &Value) {
        let list =
            |key: &str| root.get(key).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
        let mut note = |is_there: bool, words| {
            if is_there {
                self.properties.insert(words);
            }
        };
        let of_samplers = |key: &str, is_other: fn(u64) -> bool| {
            let value = |sampler: &Value| sampler.get(key).and_then(Value::as_u64);
            list("samplers").iter().filter_map(value).any(is_other)
        };
        let wraps = ["wrapS", "wrapT"].map(|key| of_samplers(key, |mode| mode != REPEAT));
        note(wraps.contains(&true), "wrap modes of samplers (textures repeat)");
        let is_sharp = of_samplers("magFilter", |filter| filter == NEAREST);
        note(is_sharp, "filters of samplers (textures are smooth)");
        note(list("animations").len() > 1, "animations behind the first");
        note(list("scenes").len() > 1, "scenes other than the default");
    }

    /// Sentences that name them.
    pub(crate) fn notes(&self, path: &Path) -> Vec<String> {
        let quotes = |names: &BTreeSet<String>| names.iter().map(|name| quoted(name)).collect();
        let words = self.properties.iter().map(|&words| words.to_owned()).collect();
        let kinds: [(&str, Vec<String>); 3] = [
            ("extensions", quotes(&self.extensions)),
            ("attributes", quotes(&self.attributes)),
            ("properties", words),
        ];
        let named = kinds.into_iter().filter(|(_, names)| !names.is_empty());
        named
            .map(|(kind, names)| {
                format!("{}: {kind} not read: {}", path.display(), names.join(", "))
            })
            .collect()
    }
}

fn attributes_of<'a>(primitive: &'a mut Value, place: &str) -> Option<&'a mut Map<String, Value>> {
    primitive.pointer_mut(place)?.as_object_mut()
}

fn is_known(name: &str) -> bool {
    let is_number = |set: &str| set.parse::<u32>().is_ok();
    WORDS.contains(&name) || SETS.iter().any(|word| name.strip_prefix(word).is_some_and(is_number))
}

/// Whether it is a set of colours after the first.
fn is_spare(name: &str) -> bool {
    name.starts_with("COLOR_") && name != "COLOR_0"
}

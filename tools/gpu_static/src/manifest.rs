//! Exported kernels, as `gobo export --target spirv` describes them.
use crate::{
    Failure,
    limits::{Limits, Scene},
};
use ash::vk;
use serde::Deserialize;
use std::{collections::BTreeMap, path::Path};

#[derive(Deserialize)]
struct Manifest {
    kernels: Vec<Kernel>,
}

#[derive(Deserialize)]
struct Kernel {
    id: String,
    name: String,
    tier: String,
    file: Option<String>,
    #[serde(default)]
    entry_point: String,
    bindings: Vec<Binding>,
    constants: BTreeMap<String, f64>,
    #[serde(default)]
    specialisation: BTreeMap<String, u32>,
}

#[derive(Deserialize)]
struct Binding {
    binding: u32,
    kind: String,
}

/// A kernel with values of its flags.
pub struct Case {
    /// The kernel's id, and behind `:` the name of the scene whose flags it has.
    pub id: String,
    pub file: String,
    pub entry_point: String,
    pub bindings: Vec<(u32, vk::DescriptorType)>,
    /// Ids of specialisation constants, and their values.
    pub flags: Vec<(u32, bool)>,
}

/// Kernels of the manifest in `dir` that scenes use on GPUs. `all`: also those that few use.
pub fn cases(dir: &Path, limits: &Limits, all: bool) -> Result<Vec<Case>, Failure> {
    let path = dir.join("manifest.json");
    let text =
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let Manifest { kernels } = serde_json::from_str(&text)?;
    let known = |name: &String| kernels.iter().any(|kernel| kernel.name == *name);
    let named = limits.unused.iter().chain(limits.scenes.iter().flat_map(|scene| &scene.kernels));
    if let Some(name) = named.into_iter().find(|name| !known(name)) {
        return Err(format!("limits.toml: no kernel is called {name}").into());
    }
    let mut cases = Vec::new();
    for kernel in kernels.iter().filter(|kernel| kernel.file.is_some()) {
        let is_below =
            kernels.iter().any(|it| it.name == kernel.name && rank(&it.tier) > rank(&kernel.tier));
        let short = kernel.id.trim_end_matches(&format!("_{}", kernel.tier));
        let seldom = limits.seldom.iter().any(|end| short.ends_with(end)) || is_below;
        if limits.unused.contains(&kernel.name) || (seldom && !all) {
            continue;
        }
        let scenes: Vec<_> =
            limits.scenes.iter().filter(|scene| scene.kernels.contains(&kernel.name)).collect();
        if scenes.is_empty() {
            cases.push(case(kernel, None)?);
        }
        for scene in scenes.into_iter().filter(|scene| all || !scene.seldom) {
            cases.push(case(kernel, Some(scene))?);
        }
    }
    Ok(cases)
}

/// Place of a tier among those that a device may have.
fn rank(tier: &str) -> usize {
    ["core", "subgroups", "native"].iter().position(|it| *it == tier).unwrap_or_default()
}

fn case(kernel: &Kernel, scene: Option<&Scene>) -> Result<Case, Failure> {
    let Kernel { id, file, entry_point, bindings, constants, specialisation, .. } = kernel;
    let flag = |(name, &id): (&String, &u32)| {
        let own = constants.get(name).is_some_and(|&value| value != 0.0);
        // Subgroups of 32.
        let own = own && name != "WIDE";
        (id, scene.and_then(|scene| scene.flags.get(name).copied()).unwrap_or(own))
    };
    let binding = |it: &Binding| {
        let kind = match it.kind.as_str() {
            "uniform" => vk::DescriptorType::UNIFORM_BUFFER,
            "storage" => vk::DescriptorType::STORAGE_BUFFER,
            "storage_texture" => vk::DescriptorType::STORAGE_IMAGE,
            "texture" => vk::DescriptorType::SAMPLED_IMAGE,
            other => return Err(format!("{id}: a binding is a {other}")),
        };
        Ok((it.binding, kind))
    };
    Ok(Case {
        id: scene.map_or_else(|| id.clone(), |scene| format!("{id}:{}", scene.name)),
        file: file.clone().unwrap_or_default(),
        entry_point: entry_point.clone(),
        bindings: bindings.iter().map(binding).collect::<Result<_, _>>()?,
        flags: specialisation.iter().map(flag).collect(),
    })
}

//! `gobo export`: kernels and a manifest for engines without wgpu.
use super::{
    failure::Failure,
    files, frame,
    look_up::{self, LookUp},
    output,
    translate::{Kernel, translate},
    values::Target,
    writers::BufferSizes,
};
use gobo::{
    Error,
    gpu::{Access, Binding, BindingKind, Constant, FEW_TURNS, KernelDesc, Tier},
    wgpu::{TextureFormat, TextureSampleType, TextureViewDimension},
};
use gobo_picture::stage::variants;
use serde::Serialize;
use std::{
    collections::{BTreeMap, HashMap},
    path::Path,
};

#[derive(Serialize)]
struct Manifest {
    gobo: &'static str,
    language: &'static str,
    kernels: Vec<KernelEntry>,
    /// Light look-ups for the host's shaders.
    look_ups: Vec<LookUp>,
}

#[derive(Serialize)]
struct KernelEntry {
    /// Unique id.
    id: String,
    name: &'static str,
    /// `core`, `subgroups` or `native`: a device takes the variant of its highest tier of each name.
    tier: &'static str,
    #[serde(flatten)]
    outcome: Outcome,
    bindings: Vec<BindingEntry>,
    /// Values of the overrides; defaults of those in `specialisation`.
    constants: BTreeMap<String, f64>,
    /// Overrides that can be specialised, with their ids in SPIR-V.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    specialisation: BTreeMap<String, u32>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome {
    Written {
        file: String,
        entry_point: String,
        workgroup_size: [u32; 3],
        /// Required features beyond core WebGPU.
        features: Vec<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        buffer_sizes: Option<BufferSizes>,
    },
    Unsupported {
        unsupported: String,
    },
}

#[derive(Serialize)]
pub(super) struct BindingEntry {
    group: u32,
    binding: u32,
    /// Index among the resources of its kind, for languages with few slots.
    #[serde(skip_serializing_if = "Option::is_none")]
    slot: Option<u8>,
    name: &'static str,
    #[serde(flatten)]
    kind: BoundKind,
}

/// Kinds by WebGPU's names.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum BoundKind {
    /// `size` of the struct [bytes].
    Uniform {
        size: u64,
    },
    /// `element_size` of the array [bytes].
    Storage {
        access: &'static str,
        element_size: u64,
    },
    StorageTexture {
        access: &'static str,
        format: String,
        dimension: &'static str,
    },
    Texture {
        sample: &'static str,
        dimension: &'static str,
    },
}

/// A variant of a kernel with other constants.
struct Cut {
    /// Suffix of its id.
    suffix: &'static str,
    constants: Vec<Constant>,
}

/// Exported variants of a kernel, the kernel itself first.
fn cuts(desc: &KernelDesc) -> Vec<Cut> {
    let mut cuts = vec![Cut { suffix: "", constants: Vec::new() }];
    if desc.constants.iter().any(|&(name, _)| name == "NODES") {
        let cut = |(suffix, nodes)| Cut { suffix, constants: vec![("NODES", nodes)] };
        cuts.extend([("_n4", 4.0), ("_n16", 16.0)].map(cut));
    }
    cuts
}

/// Unique id of a kernel.
fn id(desc: &KernelDesc, suffix: &str, tier: Tier) -> String {
    let tier = if tier == Tier::Core { String::new() } else { format!("_{tier}") };
    format!("{}{suffix}{tier}", desc.name)
}

pub(crate) fn run(
    target: Target,
    out: &Path,
    scene: Option<&Path>,
    set: &[(String, String)],
) -> Result<(), Failure> {
    if let Some(scene) = scene {
        write_json(&out.join("frame.json"), &frame::write(target, scene, set, out)?)?;
    }
    files::create_dir(out)?;
    let mut kernels = Vec::new();
    for (desc, tier) in variants() {
        for cut in cuts(desc) {
            kernels.push(export(desc, tier, &cut, target, out)?);
        }
    }
    let look_ups = look_up::write(target, out)?;
    let (gobo, language) = (env!("CARGO_PKG_VERSION"), target.version());
    let manifest = Manifest { gobo, language, kernels, look_ups };
    // The manifest is written last, so all files that it names exist.
    write_json(&out.join("manifest.json"), &manifest)
}

fn write_json(path: &Path, value: &impl Serialize) -> Result<(), Failure> {
    let json = serde_json::to_string_pretty(value).expect("plain data is JSON");
    output::write(path, json.as_bytes())?;
    files::print(&path.display().to_string())
}

fn export(
    desc: &'static KernelDesc,
    tier: Tier,
    cut: &Cut,
    target: Target,
    out: &Path,
) -> Result<KernelEntry, Failure> {
    let id = id(desc, cut.suffix, tier);
    let linked = desc.link(tier).map_err(Error::from)?;
    let given = [&cut.constants, desc.constants].concat();
    let wgsl = linked.unrolled(linked.wgsl.clone(), &given, FEW_TURNS);
    let kernel = Kernel::new(desc.entry, wgsl, &given, target)
        .map_err(|reason| Failure::Wrong(format!("{id}: {reason}")))?;
    let mut slots = HashMap::new();
    let outcome = match translate(&kernel) {
        Ok(translation) => {
            let file = format!("{id}.{}", target.extension());
            output::write(&out.join(&file), &translation.source)?;
            files::print(&out.join(&file).display().to_string())?;
            slots = translation.slots;
            Outcome::Written {
                file,
                entry_point: translation.entry_point,
                workgroup_size: translation.workgroup_size,
                features: translation.features,
                buffer_sizes: translation.sizes,
            }
        }
        Err(reason) => {
            tracing::warn!("{id} cannot be {}: {reason}", target.version());
            Outcome::Unsupported { unsupported: reason }
        }
    };
    let bindings = linked.bindings().map_err(Error::from)?;
    Ok(KernelEntry {
        id,
        name: desc.name,
        tier: tier.name(),
        outcome,
        bindings: bindings.iter().map(|it| binding_entry(it, &kernel, &slots)).collect(),
        constants: kernel.constants,
        specialisation: kernel.open,
    })
}

pub(super) fn binding_entry(
    binding: &Binding,
    kernel: &Kernel,
    slots: &HashMap<u32, u8>,
) -> BindingEntry {
    let size = || kernel.sizes.get(&binding.number).copied().unwrap_or_default();
    let kind = match binding.kind {
        BindingKind::Uniform => BoundKind::Uniform { size: size() },
        BindingKind::Storage { access } => {
            BoundKind::Storage { access: access_word(access), element_size: size() }
        }
        BindingKind::StorageTexture { access, format, dimension } => BoundKind::StorageTexture {
            access: access_word(access),
            format: format_name(format),
            dimension: dimension_word(dimension),
        },
        BindingKind::Texture { sample, dimension } => {
            BoundKind::Texture { sample: sample_word(sample), dimension: dimension_word(dimension) }
        }
    };
    let slot = slots.get(&binding.number).copied();
    BindingEntry { group: 0, binding: binding.number, slot, name: binding.name, kind }
}

/// WebGPU's name of a format, such as `rgba8unorm-srgb`.
pub(super) fn format_name(format: TextureFormat) -> String {
    let name = format!("{format:?}").to_lowercase();
    name.strip_suffix("srgb").map_or(name.clone(), |linear| format!("{linear}-srgb"))
}

fn access_word(access: Access) -> &'static str {
    match access {
        Access::Read => "read",
        Access::Write => "write",
        Access::ReadWrite => "read_write",
        Access::Atomic => "atomic",
    }
}

fn dimension_word(dimension: TextureViewDimension) -> &'static str {
    match dimension {
        TextureViewDimension::D1 => "1d",
        TextureViewDimension::D2 => "2d",
        TextureViewDimension::D2Array => "2d-array",
        TextureViewDimension::Cube => "cube",
        TextureViewDimension::CubeArray => "cube-array",
        TextureViewDimension::D3 => "3d",
    }
}

fn sample_word(sample: TextureSampleType) -> &'static str {
    match sample {
        TextureSampleType::Float { filterable: true } => "float",
        TextureSampleType::Float { filterable: false } => "unfilterable-float",
        TextureSampleType::Depth => "depth",
        TextureSampleType::Sint => "sint",
        TextureSampleType::Uint => "uint",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names in the list of the WebGPU specification, section 6.3.
    #[test]
    fn formats_have_the_names_of_webgpu() {
        for (format, name) in [
            (TextureFormat::Rgba8UnormSrgb, "rgba8unorm-srgb"),
            (TextureFormat::Rgba8Unorm, "rgba8unorm"),
            (TextureFormat::Rgba16Float, "rgba16float"),
            (TextureFormat::Rg32Uint, "rg32uint"),
            (TextureFormat::R32Float, "r32float"),
        ] {
            assert_eq!(format_name(format), name);
        }
    }
}

//! `gobo export`: kernels and a manifest for engines without wgpu.
use super::{
    arguments::Target,
    failure::Failure,
    files,
    translate::{Kernel, translate},
    writers::BufferSizes,
};
use gobo::{
    error::Error,
    gpu::{Access, Binding, BindingKind, Tier},
    stage::variants,
    wgpu::{TextureSampleType, TextureViewDimension},
};
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
}

#[derive(Serialize)]
struct KernelEntry {
    name: &'static str,
    /// `core`, or `native` for the variant that needs `features`.
    tier: &'static str,
    #[serde(flatten)]
    outcome: Outcome,
    bindings: Vec<BindingEntry>,
    /// Values that are compiled in.
    constants: BTreeMap<String, f64>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome {
    Written {
        file: String,
        entry_point: String,
        workgroup_size: [u32; 3],
        /// Beyond core WebGPU.
        features: Vec<&'static str>,
        #[serde(skip_serializing_if = "Option::is_none")]
        buffer_sizes: Option<BufferSizes>,
    },
    Unsupported {
        unsupported: String,
    },
}

#[derive(Serialize)]
struct BindingEntry {
    group: u32,
    binding: u32,
    /// Place within the resource's own kind, in a language that has few.
    #[serde(skip_serializing_if = "Option::is_none")]
    slot: Option<u8>,
    name: &'static str,
    #[serde(flatten)]
    kind: Kind,
}

/// Names of WebGPU.
#[derive(Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Kind {
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

pub(crate) fn run(target: Target, out: &Path) -> Result<(), Failure> {
    files::create_dir(out)?;
    let (mut stems, mut kernels) = (files::Unique::default(), Vec::new());
    for (desc, tier) in variants() {
        // The variants of a kernel share its name.
        let stem = match tier {
            Tier::Core => stems.of(desc.name),
            Tier::Native => stems.of(&format!("{}_native", desc.name)),
        };
        let linked = desc.link(tier).map_err(Error::from)?;
        let kernel = Kernel::new(desc.entry, linked.wgsl.clone(), desc.constants)
            .map_err(|reason| Failure::Wrong(format!("{stem}: {reason}")))?;
        let mut slots = HashMap::new();
        let outcome = match translate(&kernel, target) {
            Ok(translation) => {
                let file = format!("{stem}.{}", target.extension());
                files::write(&out.join(&file), &translation.source)?;
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
                tracing::warn!("{stem} cannot be {}: {reason}", target.version());
                Outcome::Unsupported { unsupported: reason }
            }
        };
        let bindings = linked.bindings().map_err(Error::from)?;
        kernels.push(KernelEntry {
            name: desc.name,
            tier: match tier {
                Tier::Core => "core",
                Tier::Native => "native",
            },
            outcome,
            bindings: bindings.iter().map(|it| binding_entry(it, &kernel, &slots)).collect(),
            constants: kernel.constants,
        });
    }
    let manifest =
        Manifest { gobo: env!("CARGO_PKG_VERSION"), language: target.version(), kernels };
    let json = serde_json::to_string_pretty(&manifest).expect("plain data is JSON");
    // Last: it names files that are there.
    let path = out.join("manifest.json");
    files::write(&path, json.as_bytes())?;
    files::print(&path.display().to_string())
}

fn binding_entry(binding: &Binding, kernel: &Kernel, slots: &HashMap<u32, u8>) -> BindingEntry {
    let size = || kernel.sizes.get(&binding.number).copied().unwrap_or_default();
    let kind = match binding.kind {
        BindingKind::Uniform => Kind::Uniform { size: size() },
        BindingKind::Storage { access } => {
            Kind::Storage { access: access_word(access), element_size: size() }
        }
        BindingKind::StorageTexture { access, format, dimension } => Kind::StorageTexture {
            access: access_word(access),
            format: format!("{format:?}").to_lowercase(),
            dimension: dimension_word(dimension),
        },
        BindingKind::Texture { sample, dimension } => {
            Kind::Texture { sample: sample_word(sample), dimension: dimension_word(dimension) }
        }
    };
    let slot = slots.get(&binding.number).copied();
    BindingEntry { group: 0, binding: binding.number, slot, name: binding.name, kind }
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

//! `gobo export`: kernels and a manifest for engines without wgpu.
use super::{
    arguments::Target,
    failure::Failure,
    files,
    translate::{BufferSizes, translate},
};
use gobo::{
    gpu::{Access, Binding, BindingKind, KernelDesc, Tier},
    stage::KERNELS,
    wgpu::{TextureSampleType, TextureViewDimension},
};
use serde::Serialize;
use std::{collections::BTreeMap, path::Path};

#[derive(Serialize)]
struct Manifest {
    gobo: &'static str,
    language: &'static str,
    /// In dispatch order.
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
    constants: BTreeMap<&'static str, f64>,
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
    name: &'static str,
    #[serde(flatten)]
    kind: Kind,
}

/// Words are WebGPU's.
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
    let mut stems = files::Unique::default();
    let mut kernels = Vec::with_capacity(KERNELS.len());
    for desc in KERNELS {
        // The variants of a kernel share its name.
        let stem = match desc.tier {
            Tier::Core => stems.of(desc.name),
            Tier::Native => stems.of(&format!("{}_native", desc.name)),
        };
        let outcome = match translate(desc, target) {
            Ok(kernel) => {
                let file = format!("{stem}.{}", target.extension());
                files::write(&out.join(&file), &kernel.source)?;
                files::print(&out.join(&file).display().to_string())?;
                Outcome::Written {
                    file,
                    entry_point: kernel.entry_point,
                    workgroup_size: kernel.workgroup_size,
                    features: kernel.features,
                    buffer_sizes: kernel.sizes,
                }
            }
            Err(reason) => {
                tracing::warn!("{stem} cannot be {}: {reason}", target.version());
                Outcome::Unsupported { unsupported: reason }
            }
        };
        kernels.push(entry(desc, outcome));
    }
    let manifest =
        Manifest { gobo: env!("CARGO_PKG_VERSION"), language: target.version(), kernels };
    let json = serde_json::to_string_pretty(&manifest).expect("plain data is JSON");
    // Last: it names files that are there.
    let path = out.join("manifest.json");
    files::write(&path, json.as_bytes())?;
    files::print(&path.display().to_string())
}

fn entry(desc: &KernelDesc, outcome: Outcome) -> KernelEntry {
    KernelEntry {
        name: desc.name,
        tier: match desc.tier {
            Tier::Core => "core",
            Tier::Native => "native",
        },
        outcome,
        bindings: (0..).zip(desc.bindings).map(binding_entry).collect(),
        constants: desc.constants.iter().copied().collect(),
    }
}

fn binding_entry((binding, desc): (u32, &Binding)) -> BindingEntry {
    let kind = match desc.kind {
        BindingKind::Uniform { size } => Kind::Uniform { size },
        BindingKind::Storage { access, size } => {
            Kind::Storage { access: access_word(access), element_size: size }
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
    BindingEntry { group: 0, binding, name: desc.name, kind }
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

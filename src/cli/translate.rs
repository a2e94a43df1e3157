//! One kernel in another shading language, its override constants resolved.
use super::arguments::Target;
use gobo::gpu::KernelDesc;
use naga::{
    Module, ResourceBinding, ShaderStage, back,
    proc::{BoundsCheckPolicies, BoundsCheckPolicy},
    valid::{
        Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
    },
};

/// Where MSL finds the sizes of runtime arrays: the last slot that Metal has.
const MSL_SIZES_SLOT: u8 = 30;

pub(crate) struct Translation {
    pub(crate) source: Vec<u8>,
    /// As the target names it.
    pub(crate) entry_point: String,
    pub(crate) workgroup_size: [u32; 3],
    /// Beyond core WebGPU, by the names that wgpu gives them.
    pub(crate) features: Vec<&'static str>,
    /// MSL only: the buffers whose sizes [bytes, u32 each] the host passes in `MSL_SIZES_SLOT`.
    pub(crate) sizes: Option<BufferSizes>,
}

#[derive(Debug, serde::Serialize)]
pub(crate) struct BufferSizes {
    slot: u8,
    buffers: Vec<String>,
}

impl Target {
    pub(crate) fn extension(self) -> &'static str {
        match self {
            Self::Spirv => "spv",
            Self::Hlsl => "hlsl",
            Self::Msl => "metal",
            Self::Glsl => "comp",
            Self::Wgsl => "wgsl",
        }
    }

    /// What the manifest says of the files.
    pub(crate) fn version(self) -> &'static str {
        match self {
            Self::Spirv => "SPIR-V 1.3",
            Self::Hlsl => "HLSL, shader model 6.0",
            Self::Msl => "Metal Shading Language 3.1",
            Self::Glsl => "GLSL 4.50",
            Self::Wgsl => "WGSL",
        }
    }

    fn capabilities(self) -> Capabilities {
        match self {
            Self::Spirv => back::spv::supported_capabilities(),
            Self::Hlsl => back::hlsl::supported_capabilities(),
            Self::Msl => back::msl::supported_capabilities(),
            Self::Glsl => back::glsl::supported_capabilities(),
            Self::Wgsl => Capabilities::all(),
        }
    }
}

/// What wgpu guarantees, too: an index out of bounds does no harm.
const BOUNDS: BoundsCheckPolicies = BoundsCheckPolicies {
    index: BoundsCheckPolicy::Restrict,
    buffer: BoundsCheckPolicy::Restrict,
    image_load: BoundsCheckPolicy::ReadZeroSkipWrite,
    binding_array: BoundsCheckPolicy::Restrict,
};

/// The error says why the target cannot express the kernel.
pub(crate) fn translate(desc: &KernelDesc, target: Target) -> Result<Translation, String> {
    let wgsl = with_constants(desc)?;
    let mut module = parse(&wgsl)?;
    if let Some((_, open)) = module.overrides.iter().next() {
        return Err(format!("{} has no value", open.name.as_deref().unwrap_or("an override")));
    }
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    let capabilities = target.capabilities();
    let info = validate(&module, capabilities).map_err(|reason| {
        // What is valid WGSL is only too much for the target.
        match validate(&module, Capabilities::all()) {
            Ok(_) => {
                format!("the target lacks {}", needed(&module, Capabilities::all()).join(", "))
            }
            Err(_) => reason,
        }
    })?;
    let Some(entry_point) = module.entry_points.iter().find(|entry| entry.name == desc.name) else {
        return Err(format!("no entry point is named {}", desc.name));
    };
    let workgroup_size = entry_point.workgroup_size;
    let features = needed(&module, capabilities);
    let (source, entry_point, sizes) = match target {
        Target::Spirv => spirv(&module, &info, desc.name),
        Target::Hlsl => hlsl(&module, &info, desc.name),
        Target::Msl => msl(&module, &info, desc.name),
        Target::Glsl => glsl(&module, &info, desc.name),
        Target::Wgsl => Ok((wgsl.into_bytes(), desc.name.to_owned(), None)),
    }?;
    Ok(Translation { source, entry_point, workgroup_size, features, sizes })
}

fn parse(wgsl: &str) -> Result<Module, String> {
    naga::front::wgsl::parse_str(wgsl).map_err(|error| error.emit_to_string(wgsl))
}

/// The linked source, each `override` a `const` with the kernel's value. naga's own resolution
/// leaves the lengths of workgroup arrays open, and its WGSL loses them.
fn with_constants(desc: &KernelDesc) -> Result<String, String> {
    let mut wgsl = desc.wgsl();
    let overrides = parse(&wgsl)?.overrides;
    for &(name, value) in desc.constants {
        let is_it = |constant: &naga::Override| constant.name.as_deref() == Some(name);
        if !overrides.iter().any(|(_, constant)| is_it(constant)) {
            return Err(format!("{name} is no override"));
        }
        let start = wgsl
            .match_indices("override ")
            .find(|(at, keyword)| {
                wgsl[at + keyword.len()..]
                    .trim_start()
                    .strip_prefix(name)
                    .is_some_and(|rest| rest.trim_start().starts_with(':'))
            })
            .map(|(at, _)| at)
            .ok_or_else(|| format!("the override {name} has no type"))?;
        let end = start + wgsl[start..].find(';').unwrap_or_default();
        let ty = wgsl[start..end].split([':', '=']).nth(1).unwrap_or_default().trim();
        let literal = match ty {
            "bool" => (value != 0.0).to_string(),
            // Shortest decimal that reads back as the same number.
            _ => format!("{ty}({value})"),
        };
        let constant = format!("const {name}: {ty} = {literal}");
        wgsl.replace_range(start..end, &constant);
    }
    Ok(wgsl)
}

fn validate(module: &Module, capabilities: Capabilities) -> Result<ModuleInfo, String> {
    Validator::new(ValidationFlags::all(), capabilities)
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .map_err(|error| error.into_inner().to_string())
}

/// The features without which the kernel is not valid.
fn needed(module: &Module, capabilities: Capabilities) -> Vec<&'static str> {
    [
        ("SUBGROUP", Capabilities::SUBGROUP),
        ("TEXTURE_ATOMIC", Capabilities::TEXTURE_ATOMIC),
        ("SHADER_INT64", Capabilities::SHADER_INT64),
        ("TEXTURE_INT64_ATOMIC", Capabilities::TEXTURE_INT64_ATOMIC),
        ("SHADER_F64", Capabilities::FLOAT64),
        ("SHADER_F16", Capabilities::SHADER_FLOAT16),
    ]
    .into_iter()
    .filter(|&(_, feature)| validate(module, capabilities - feature).is_err())
    .map(|(name, _)| name)
    .collect()
}

type Written = (Vec<u8>, String, Option<BufferSizes>);

fn spirv(module: &Module, info: &ModuleInfo, name: &str) -> Result<Written, String> {
    let options = back::spv::Options {
        // The first with subgroup operations: Vulkan 1.1.
        lang_version: (1, 3),
        flags: back::spv::WriterFlags::LABEL_VARYINGS,
        bounds_check_policies: BOUNDS,
        ..Default::default()
    };
    let pipeline = back::spv::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: name.to_owned(),
    };
    let words = back::spv::write_vec(module, info, &options, Some(&pipeline))
        .map_err(|error| error.to_string())?;
    Ok((words.iter().flat_map(|word| word.to_le_bytes()).collect(), name.to_owned(), None))
}

fn hlsl(module: &Module, info: &ModuleInfo, name: &str) -> Result<Written, String> {
    let options = back::hlsl::Options {
        // The first with wave operations.
        shader_model: back::hlsl::ShaderModel::V6_0,
        ..Default::default()
    };
    let pipeline =
        back::hlsl::PipelineOptions { entry_point: Some((ShaderStage::Compute, name.to_owned())) };
    let mut text = String::new();
    let reflection = back::hlsl::Writer::new(&mut text, &options, &pipeline)
        .write(module, info, None)
        .map_err(|error| error.to_string())?;
    let entry_point = only(reflection.entry_point_names)?;
    Ok((text.into_bytes(), entry_point, None))
}

fn msl(module: &Module, info: &ModuleInfo, name: &str) -> Result<Written, String> {
    let slots = resources(module).into_iter().map(|(binding, is_texture, mutable)| {
        let slot = Some(binding.binding as u8);
        let (buffer, texture) = if is_texture { (None, slot) } else { (slot, None) };
        (binding, back::msl::BindTarget { buffer, texture, mutable, ..Default::default() })
    });
    let resources = back::msl::EntryPointResources {
        resources: slots.collect(),
        sizes_buffer: Some(MSL_SIZES_SLOT),
        ..Default::default()
    };
    let options = back::msl::Options {
        // The first with texture atomics.
        lang_version: (3, 1),
        per_entry_point_map: [(name.to_owned(), resources)].into(),
        fake_missing_bindings: false,
        bounds_check_policies: BOUNDS,
        ..Default::default()
    };
    let pipeline = back::msl::PipelineOptions {
        entry_point: Some((ShaderStage::Compute, name.to_owned())),
        ..Default::default()
    };
    let (text, translated) = back::msl::write_string(module, info, &options, &pipeline)
        .map_err(|error| error.to_string())?;
    let entry_point = only(translated.entry_point_names)?;
    let runtime_arrays = module.global_variables.iter().filter(|(_, global)| {
        global.binding.is_some()
            && module.types[global.ty].inner.is_dynamically_sized(&module.types)
    });
    let buffers: Vec<_> =
        runtime_arrays.map(|(_, global)| global.name.clone().unwrap_or_default()).collect();
    let sizes = (!buffers.is_empty()).then_some(BufferSizes { slot: MSL_SIZES_SLOT, buffers });
    Ok((text.into_bytes(), entry_point, sizes))
}

fn glsl(module: &Module, info: &ModuleInfo, name: &str) -> Result<Written, String> {
    let bindings = resources(module).into_iter().map(|(at, ..)| (at, at.binding as u8));
    let options = back::glsl::Options {
        version: back::glsl::Version::Desktop(450),
        writer_flags: back::glsl::WriterFlags::empty(),
        binding_map: bindings.collect(),
        ..Default::default()
    };
    let pipeline = back::glsl::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: name.to_owned(),
        multiview: None,
    };
    let mut text = String::new();
    back::glsl::Writer::new(&mut text, module, info, &options, &pipeline, BOUNDS)
        .and_then(|mut writer| writer.write())
        .map_err(|error| error.to_string())?;
    Ok((text.into_bytes(), "main".to_owned(), None))
}

/// Where each resource is bound, whether it is a texture, and whether it is written.
fn resources(module: &Module) -> Vec<(ResourceBinding, bool, bool)> {
    use naga::{AddressSpace, ImageClass, StorageAccess, TypeInner};
    let globals = module.global_variables.iter().filter_map(|(_, global)| {
        let binding = global.binding?;
        let writes =
            |access: StorageAccess| access.intersects(StorageAccess::STORE | StorageAccess::ATOMIC);
        Some(match module.types[global.ty].inner {
            TypeInner::Image { class: ImageClass::Storage { access, .. }, .. } => {
                (binding, true, writes(access))
            }
            TypeInner::Image { .. } => (binding, true, false),
            _ => {
                let mutable =
                    matches!(global.space, AddressSpace::Storage { access } if writes(access));
                (binding, false, mutable)
            }
        })
    });
    globals.collect()
}

fn only<E: std::fmt::Display>(names: Vec<Result<String, E>>) -> Result<String, String> {
    match names.into_iter().next() {
        Some(name) => name.map_err(|error| error.to_string()),
        None => Err("the target has no entry point".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;
    use gobo::gpu::{Source, Tier};

    const fn kernel(source: &'static [Source]) -> KernelDesc {
        KernelDesc {
            name: "add",
            sources: source,
            bindings: &[],
            constants: &[("STEP", 3.0)],
            tier: Tier::Core,
        }
    }

    #[test]
    fn constants_are_resolved() {
        let desc = kernel(&[Source {
            path: "add.wgsl",
            text:
                "override STEP: u32; @group(0) @binding(0) var<storage, read_write> x: array<u32>;
                @compute @workgroup_size(STEP * 2u) fn add() { x[STEP] = x[0] + STEP; }",
        }]);
        for &target in Target::value_variants() {
            let kernel = translate(&desc, target).unwrap();
            assert_eq!(kernel.workgroup_size, [6, 1, 1], "{target:?}");
            assert_eq!(kernel.features, [""; 0]);
            let text = String::from_utf8_lossy(&kernel.source);
            assert!(!text.contains("override"), "{target:?} {text}");
        }
    }

    #[test]
    fn what_a_target_cannot_express_has_a_reason() {
        let desc = kernel(&[Source {
            path: "add.wgsl",
            text:
                "override STEP: u32; @group(0) @binding(0) var<storage, read_write> x: array<f64>;
                @compute @workgroup_size(STEP) fn add() { x[0] = x[1] + 1.0lf; }",
        }]);
        let reason = translate(&desc, Target::Msl).err().unwrap();
        assert_eq!(reason, "the target lacks SHADER_F64");
        assert_eq!(translate(&desc, Target::Spirv).unwrap().features, ["SHADER_F64"]);
    }

    #[test]
    fn an_open_constant_has_a_reason() {
        let desc = kernel(&[Source {
            path: "add.wgsl",
            text: "override STEP: u32; override OPEN: u32;
                @compute @workgroup_size(STEP, OPEN) fn add() {}",
        }]);
        assert_eq!(translate(&desc, Target::Wgsl).err().unwrap(), "OPEN has no value");
    }

    #[test]
    fn what_is_no_kernel_has_a_reason() {
        let desc = kernel(&[Source { path: "add.wgsl", text: "fn add() { return 1; }" }]);
        assert!(translate(&desc, Target::Wgsl).is_err());
    }
}

//! One kernel in another shading language, its override constants resolved.
use super::arguments::Target;
use gobo::gpu::KernelDesc;
use naga::{
    Module, ResourceBinding, ShaderStage,
    back::{self, PipelineConstants},
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
    let wgsl = desc.wgsl();
    let module = naga::front::wgsl::parse_str(&wgsl).map_err(|e| e.emit_to_string(&wgsl))?;
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
    let features = needed(&module, capabilities);
    let constants: PipelineConstants =
        desc.constants.iter().map(|&(name, value)| (name.to_owned(), value)).collect();
    let entry_point = (ShaderStage::Compute, desc.name);
    let (module, info) =
        back::pipeline_constants::process_overrides(&module, &info, Some(entry_point), &constants)
            .map_err(|error| error.to_string())?;
    let workgroup_size = module.entry_points[0].workgroup_size;
    let (source, entry_point, sizes) = write(&module, &info, desc.name, target)?;
    Ok(Translation { source, entry_point, workgroup_size, features, sizes })
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
        ("SHADER_F16", Capabilities::SHADER_FLOAT16),
    ]
    .into_iter()
    .filter(|&(_, feature)| validate(module, capabilities - feature).is_err())
    .map(|(name, _)| name)
    .collect()
}

type Written = (Vec<u8>, String, Option<BufferSizes>);

fn write(
    module: &Module,
    info: &ModuleInfo,
    name: &str,
    target: Target,
) -> Result<Written, String> {
    match target {
        Target::Spirv => spirv(module, info, name),
        Target::Hlsl => hlsl(module, info, name),
        Target::Msl => msl(module, info, name),
        Target::Glsl => glsl(module, info, name),
        Target::Wgsl => {
            let flags = back::wgsl::WriterFlags::empty();
            let text = back::wgsl::write_string(module, info, flags).map_err(|e| e.to_string())?;
            Ok((text.into_bytes(), name.to_owned(), None))
        }
    }
}

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

//! Writers of a kernel's module in other shading languages.
use super::{specialise::specialised, values::Target};
use naga::{
    Module, ResourceBinding, ShaderStage, back,
    proc::{BoundsCheckPolicies, BoundsCheckPolicy},
    valid::ModuleInfo,
};
use std::collections::{BTreeMap, HashMap};

/// Slot of the sizes of runtime arrays in MSL: the last one of Metal.
const MSL_SIZES_SLOT: u8 = 30;

/// Bounds checks as wgpu guarantees them: an index out of bounds is harmless.
const BOUNDS: BoundsCheckPolicies = BoundsCheckPolicies {
    index: BoundsCheckPolicy::Restrict,
    buffer: BoundsCheckPolicy::Restrict,
    image_load: BoundsCheckPolicy::ReadZeroSkipWrite,
    binding_array: BoundsCheckPolicy::Restrict,
};

/// The same where devices check buffers and images, as wgpu assumes on Vulkan: checks of the address of each
/// load would double the code of some kernels.
const ROBUST: BoundsCheckPolicies = BoundsCheckPolicies {
    index: BoundsCheckPolicy::Restrict,
    buffer: BoundsCheckPolicy::Unchecked,
    image_load: BoundsCheckPolicy::Unchecked,
    binding_array: BoundsCheckPolicy::Restrict,
};

#[derive(Debug, serde::Serialize)]
pub(crate) struct BufferSizes {
    slot: u8,
    buffers: Vec<String>,
}

pub(super) type Exported = (Vec<u8>, String, Option<BufferSizes>);

pub(super) fn spirv(
    module: &Module,
    info: &ModuleInfo,
    name: &str,
    open: &BTreeMap<String, u32>,
) -> Result<Exported, String> {
    let options = back::spv::Options {
        // The first version with subgroup operations: Vulkan 1.1.
        lang_version: (1, 3),
        // With names, which identify the constants that stay open.
        flags: back::spv::WriterFlags::LABEL_VARYINGS | back::spv::WriterFlags::DEBUG,
        bounds_check_policies: ROBUST,
        // naga's own zeroing stores each word, which takes some compilers minutes.
        zero_initialize_workgroup_memory: back::spv::ZeroInitializeWorkgroupMemoryMode::Native,
        ..Default::default()
    };
    let pipeline = back::spv::PipelineOptions {
        shader_stage: ShaderStage::Compute,
        entry_point: name.to_owned(),
    };
    let words = back::spv::write_vec(module, info, &options, Some(&pipeline))
        .map_err(|error| error.to_string())?;
    let words = specialised(&words, open);
    Ok((words.iter().flat_map(|word| word.to_le_bytes()).collect(), name.to_owned(), None))
}

pub(super) fn hlsl(module: &Module, info: &ModuleInfo, name: &str) -> Result<Exported, String> {
    let options = back::hlsl::Options {
        // The first model with wave operations.
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

pub(super) fn msl(
    module: &Module,
    info: &ModuleInfo,
    name: &str,
    slots: &Slots,
) -> Result<Exported, String> {
    let slots = resources(module).into_iter().map(|Bound { at: binding, kind, mutable }| {
        let slot = slots.get(&binding.binding).copied();
        let is_texture = matches!(kind, SlotKind::Texture | SlotKind::Image);
        let (buffer, texture) = if is_texture { (None, slot) } else { (slot, None) };
        (binding, back::msl::BindTarget { buffer, texture, mutable, ..Default::default() })
    });
    let resources = back::msl::EntryPointResources {
        resources: slots.collect(),
        sizes_buffer: Some(MSL_SIZES_SLOT),
        ..Default::default()
    };
    let options = back::msl::Options {
        // The first version with texture atomics.
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

pub(super) fn glsl(
    module: &Module,
    info: &ModuleInfo,
    name: &str,
    slots: &Slots,
) -> Result<Exported, String> {
    let slot = |bound: &Bound| Some((bound.at, *slots.get(&bound.at.binding)?));
    let bindings = resources(module).iter().filter_map(slot).collect();
    let options = back::glsl::Options {
        version: back::glsl::Version::Desktop(450),
        writer_flags: back::glsl::WriterFlags::empty(),
        binding_map: bindings,
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

pub(super) type Slots = HashMap<u32, u8>;

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum SlotKind {
    Uniform,
    Storage,
    Texture,
    /// A storage texture.
    Image,
}

struct Bound {
    at: ResourceBinding,
    kind: SlotKind,
    /// Whether the kernel writes it.
    mutable: bool,
}

/// Resources by binding number.
fn resources(module: &Module) -> Vec<Bound> {
    use naga::{AddressSpace, ImageClass, StorageAccess, TypeInner};
    let writes =
        |access: StorageAccess| access.intersects(StorageAccess::STORE | StorageAccess::ATOMIC);
    let globals = module.global_variables.iter().filter_map(|(_, global)| {
        let (kind, mutable) = match (&module.types[global.ty].inner, global.space) {
            (&TypeInner::Image { class: ImageClass::Storage { access, .. }, .. }, _) => {
                (SlotKind::Image, writes(access))
            }
            (TypeInner::Image { .. }, _) => (SlotKind::Texture, false),
            (_, AddressSpace::Storage { access }) => (SlotKind::Storage, writes(access)),
            _ => (SlotKind::Uniform, false),
        };
        Some(Bound { at: global.binding?, kind, mutable })
    });
    let mut bound: Vec<_> = globals.collect();
    bound.sort_by_key(|bound| bound.at.binding);
    bound
}

/// Slots of the resources: MSL counts buffers and textures, GLSL each kind.
pub(super) fn slots(module: &Module, target: Target) -> Slots {
    let mut counts = HashMap::<SlotKind, u8>::new();
    let mut slot = |bound: Bound| {
        let kind = match (target, bound.kind) {
            (Target::Msl, SlotKind::Uniform) => SlotKind::Storage,
            (Target::Msl, SlotKind::Image) => SlotKind::Texture,
            (_, kind) => kind,
        };
        let count = counts.entry(kind).or_default();
        *count += 1;
        (bound.at.binding, *count - 1)
    };
    resources(module).into_iter().map(&mut slot).collect()
}

fn only<E: std::fmt::Display>(names: Vec<Result<String, E>>) -> Result<String, String> {
    match names.into_iter().next() {
        Some(name) => name.map_err(|error| error.to_string()),
        None => Err("the target has no entry point".to_owned()),
    }
}

//! One kernel in another shading language, its override constants resolved.
use super::arguments::Target;
use gobo::gpu::Constant;
use naga::{
    Module, ResourceBinding, ShaderStage, back,
    proc::{BoundsCheckPolicies, BoundsCheckPolicy},
    valid::{
        Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
    },
};
use std::collections::{BTreeMap, HashMap};

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
    /// Where the language has few: of each binding, its place among the kernel's resources of its
    /// kind.
    pub(crate) slots: HashMap<u32, u8>,
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

/// A kernel, its override constants resolved.
#[derive(Debug)]
pub(crate) struct Kernel {
    name: &'static str,
    wgsl: String,
    /// Values of the overrides.
    pub(crate) constants: BTreeMap<String, f64>,
    /// By binding, of a uniform the whole, of an array an element [bytes].
    pub(crate) sizes: HashMap<u32, u64>,
}

impl Kernel {
    /// Each `override` becomes a `const`: naga's own resolution leaves the lengths of workgroup
    /// arrays open, and its WGSL loses them.
    pub(crate) fn new(
        name: &'static str,
        mut wgsl: String,
        given: &[Constant],
    ) -> Result<Self, String> {
        let mut constants = BTreeMap::new();
        for (_, open) in parse(&wgsl)?.overrides.iter() {
            let name = open.name.as_deref().unwrap_or_default();
            let (start, end, ty, usual) = declaration(&wgsl, name)
                .ok_or_else(|| format!("the override {name} has no type"))?;
            let is_it = |(known, _): &&Constant| *known == name;
            let value = given.iter().find(is_it).map(|constant| constant.1).or(usual);
            let value = value.ok_or_else(|| format!("{name} has no value"))?;
            let literal = match ty.as_str() {
                "bool" => (value != 0.0).to_string(),
                // Shortest decimal that reads back as the same number.
                _ => format!("{ty}({value})"),
            };
            wgsl.replace_range(start..end, &format!("const {name}: {ty} = {literal}"));
            constants.insert(name.to_owned(), value);
        }
        let sizes = sizes(&parse(&wgsl)?);
        Ok(Self { name, wgsl, constants, sizes })
    }
}

/// Where an override is declared, its type and its usual value.
fn declaration(wgsl: &str, name: &str) -> Option<(usize, usize, String, Option<f64>)> {
    let declared = format!("override {name}:");
    let start = wgsl.find(&declared)?;
    let end = start + wgsl[start..].find(';')?;
    let (ty, usual) = match wgsl[start + declared.len()..end].split_once('=') {
        Some((ty, usual)) => (ty, usual.trim()),
        None => (&wgsl[start + declared.len()..end], ""),
    };
    let usual = match usual {
        "true" => Some(1.0),
        "false" => Some(0.0),
        number => number.trim_end_matches('u').parse().ok(),
    };
    Some((start, end, ty.trim().to_owned(), usual))
}

fn sizes(module: &Module) -> HashMap<u32, u64> {
    let mut layouter = naga::proc::Layouter::default();
    if layouter.update(module.to_ctx()).is_err() {
        return HashMap::new();
    }
    let size = |(_, global): (_, &naga::GlobalVariable)| {
        let size = match module.types[global.ty].inner {
            naga::TypeInner::Array { stride, .. }
                if global.space != naga::AddressSpace::Uniform =>
            {
                stride
            }
            _ => layouter[global.ty].size,
        };
        Some((global.binding?.binding, u64::from(size)))
    };
    module.global_variables.iter().filter_map(size).collect()
}

/// The error says why the target cannot express the kernel.
pub(crate) fn translate(kernel: &Kernel, target: Target) -> Result<Translation, String> {
    let (name, wgsl) = (kernel.name, &kernel.wgsl);
    let mut module = parse(wgsl)?;
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
    let Some(entry_point) = module.entry_points.iter().find(|entry| entry.name == name) else {
        return Err(format!("no entry point is named {name}"));
    };
    let workgroup_size = entry_point.workgroup_size;
    let features = needed(&module, capabilities);
    let slots = match target {
        Target::Msl | Target::Glsl => slots(&module, target),
        Target::Spirv | Target::Hlsl | Target::Wgsl => HashMap::new(),
    };
    let (source, entry_point, sizes) = match target {
        Target::Spirv => spirv(&module, &info, name),
        Target::Hlsl => hlsl(&module, &info, name),
        Target::Msl => msl(&module, &info, name, &slots),
        Target::Glsl => glsl(&module, &info, name, &slots),
        Target::Wgsl => Ok((wgsl.clone().into_bytes(), name.to_owned(), None)),
    }?;
    Ok(Translation { source, entry_point, workgroup_size, features, sizes, slots })
}

fn parse(wgsl: &str) -> Result<Module, String> {
    naga::front::wgsl::parse_str(wgsl).map_err(|error| error.emit_to_string(wgsl))
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

fn msl(module: &Module, info: &ModuleInfo, name: &str, slots: &Slots) -> Result<Written, String> {
    let slots = resources(module).into_iter().map(|Bound { at: binding, kind, mutable }| {
        let slot = slots.get(&binding.binding).copied();
        let is_texture = matches!(kind, Kind::Texture | Kind::Image);
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

fn glsl(module: &Module, info: &ModuleInfo, name: &str, slots: &Slots) -> Result<Written, String> {
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

type Slots = HashMap<u32, u8>;

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Kind {
    Uniform,
    Storage,
    Texture,
    /// A storage texture.
    Image,
}

struct Bound {
    at: ResourceBinding,
    kind: Kind,
    /// It is written.
    mutable: bool,
}

/// By number.
fn resources(module: &Module) -> Vec<Bound> {
    use naga::{AddressSpace, ImageClass, StorageAccess, TypeInner};
    let writes =
        |access: StorageAccess| access.intersects(StorageAccess::STORE | StorageAccess::ATOMIC);
    let globals = module.global_variables.iter().filter_map(|(_, global)| {
        let (kind, mutable) = match (&module.types[global.ty].inner, global.space) {
            (&TypeInner::Image { class: ImageClass::Storage { access, .. }, .. }, _) => {
                (Kind::Image, writes(access))
            }
            (TypeInner::Image { .. }, _) => (Kind::Texture, false),
            (_, AddressSpace::Storage { access }) => (Kind::Storage, writes(access)),
            _ => (Kind::Uniform, false),
        };
        Some(Bound { at: global.binding?, kind, mutable })
    });
    let mut bound: Vec<_> = globals.collect();
    bound.sort_by_key(|bound| bound.at.binding);
    bound
}

/// MSL counts buffers and textures, GLSL each kind.
fn slots(module: &Module, target: Target) -> Slots {
    let mut counts = HashMap::<Kind, u8>::new();
    let mut slot = |bound: Bound| {
        let kind = match (target, bound.kind) {
            (Target::Msl, Kind::Uniform) => Kind::Storage,
            (Target::Msl, Kind::Image) => Kind::Texture,
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;

    const OPEN: &str = "override STEP: u32; override SIDE: u32 = 2u;
        @group(0) @binding(40) var<uniform> way: vec4<f32>;
        @group(0) @binding(50) var<storage, read_write> x: array<u32>;
        @compute @workgroup_size(STEP * SIDE) fn add() { x[STEP] = x[0] + STEP + u32(way.x); }";

    fn kernel(wgsl: &str) -> Result<Kernel, String> {
        Kernel::new("add", wgsl.to_owned(), &[("STEP", 3.0)])
    }

    #[test]
    fn constants_are_resolved() {
        let add = kernel(OPEN).unwrap();
        assert_eq!(add.constants, [("SIDE".to_owned(), 2.0), ("STEP".to_owned(), 3.0)].into());
        assert_eq!(add.sizes, [(40, 16), (50, 4)].into());
        for &target in Target::value_variants() {
            let kernel = translate(&add, target).unwrap();
            assert_eq!(kernel.workgroup_size, [6, 1, 1], "{target:?}");
            assert_eq!(kernel.features, [""; 0]);
            let text = String::from_utf8_lossy(&kernel.source);
            assert!(!text.contains("override"), "{target:?} {text}");
        }
    }

    #[test]
    fn slots_are_few_where_the_language_has_few() {
        let add = kernel(OPEN).unwrap();
        assert_eq!(translate(&add, Target::Msl).unwrap().slots, [(40, 0), (50, 1)].into());
        assert_eq!(translate(&add, Target::Glsl).unwrap().slots, [(40, 0), (50, 0)].into());
        assert_eq!(translate(&add, Target::Spirv).unwrap().slots, [].into());
    }

    #[test]
    fn what_a_target_cannot_express_has_a_reason() {
        let add = kernel(
            "override STEP: u32; @group(0) @binding(0) var<storage, read_write> x: array<f64>;
            @compute @workgroup_size(STEP) fn add() { x[0] = x[1] + 1.0lf; }",
        )
        .unwrap();
        let reason = translate(&add, Target::Msl).err().unwrap();
        assert_eq!(reason, "the target lacks SHADER_F64");
        assert_eq!(translate(&add, Target::Spirv).unwrap().features, ["SHADER_F64"]);
    }

    #[test]
    fn an_open_constant_has_a_reason() {
        let open = "override STEP: u32; override OPEN: u32;
            @compute @workgroup_size(STEP, OPEN) fn add() {}";
        assert_eq!(kernel(open).err().unwrap(), "OPEN has no value");
    }

    #[test]
    fn what_is_no_kernel_has_a_reason() {
        assert!(
            kernel("fn add() { return 1; }").and_then(|add| translate(&add, Target::Wgsl)).is_err()
        );
    }
}

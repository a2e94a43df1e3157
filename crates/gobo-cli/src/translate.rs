//! Translation of a kernel to another shading language. Flags stay override constants if the language has
//! them; other constants are resolved.
use super::{
    specialise,
    values::Target,
    writers::{BufferSizes, glsl, hlsl, msl, slots, spirv},
};
use gobo::gpu::{Constant, ENABLED};
use naga::{
    Module, back,
    valid::{
        Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
    },
};
use std::collections::{BTreeMap, HashMap};

pub(crate) struct Translation {
    pub(crate) source: Vec<u8>,
    /// Name of the entry point in the target.
    pub(crate) entry_point: String,
    pub(crate) workgroup_size: [u32; 3],
    /// Required features beyond core WebGPU, by wgpu's names.
    pub(crate) features: Vec<&'static str>,
    /// MSL only: the buffers whose sizes [bytes, u32 each] the host passes in `MSL_SIZES_SLOT`.
    pub(crate) sizes: Option<BufferSizes>,
    /// For languages with few slots: index of each binding among the kernel's resources of its kind.
    pub(crate) slots: HashMap<u32, u8>,
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

    /// Version of the language, for the manifest.
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

/// A kernel in WGSL, the source of all targets.
#[derive(Debug)]
pub(crate) struct Kernel {
    name: String,
    wgsl: String,
    target: Target,
    /// Values of the overrides.
    pub(crate) constants: BTreeMap<String, f64>,
    /// Overrides that stay open, by their ids in SPIR-V.
    pub(crate) open: BTreeMap<String, u32>,
    /// Size by binding: of a whole uniform, or of an array's element [bytes].
    pub(crate) sizes: HashMap<u32, u64>,
}

impl Kernel {
    /// Turns each closed `override` into a `const`: naga's own resolution leaves the lengths of workgroup
    /// arrays open, and its WGSL loses them.
    pub(crate) fn new(
        name: &str,
        mut wgsl: String,
        given: &[Constant],
        target: Target,
    ) -> Result<Self, String> {
        let (mut constants, mut flags) = (BTreeMap::new(), BTreeMap::new());
        let overrides = parse(&wgsl)?.overrides;
        // Lengths of arrays are overrides without a name.
        for name in overrides.iter().filter_map(|(_, open)| open.name.as_deref()) {
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
            let id = specialise::ids().find(|&(known, _)| known == name && ty == "bool");
            let keyword = match (target, id) {
                // `specialise` turns naga's translation of it into a specialisation constant.
                (Target::Spirv, Some(_)) => "var<private>",
                (Target::Wgsl, Some(_)) => "override",
                _ => "const",
            };
            wgsl.replace_range(start..end, &format!("{keyword} {name}: {ty} = {literal}"));
            constants.insert(name.to_owned(), value);
            flags.extend(id.filter(|_| keyword != "const").map(|(name, id)| (name.to_owned(), id)));
        }
        let sizes = sizes(&parse(&wgsl)?);
        Ok(Self { name: name.to_owned(), wgsl, target, constants, open: flags, sizes })
    }
}

/// Range of an override's declaration, its type and its default.
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

/// Translates a kernel. The error is the reason why the target cannot express it.
pub(crate) fn translate(kernel: &Kernel) -> Result<Translation, String> {
    let Kernel { name, wgsl, target, .. } = kernel;
    let (name, target) = (name.as_str(), *target);
    let mut module = parse(wgsl)?;
    naga::compact::compact(&mut module, naga::compact::KeepUnused::No);
    let capabilities = target.capabilities();
    let info = validate(&module, capabilities).map_err(|reason| {
        // The kernel is valid WGSL, but exceeds the target.
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
    let mut features = needed(&module, capabilities);
    let is_shared = |global: &naga::GlobalVariable| global.space == naga::AddressSpace::WorkGroup;
    if target == Target::Spirv && module.global_variables.iter().any(|(_, it)| is_shared(it)) {
        features.push("VK_KHR_zero_initialize_workgroup_memory");
    }
    let slots = match target {
        Target::Msl | Target::Glsl => slots(&module, target),
        Target::Spirv | Target::Hlsl | Target::Wgsl => HashMap::new(),
    };
    let (source, entry_point, sizes) = match target {
        Target::Spirv => spirv(&module, &info, name, &kernel.open),
        Target::Hlsl => hlsl(&module, &info, name),
        Target::Msl => msl(&module, &info, name, &slots),
        Target::Glsl => glsl(&module, &info, name, &slots),
        Target::Wgsl => Ok((enabled(wgsl, &features).into_bytes(), name.to_owned(), None)),
    }?;
    Ok(Translation { source, entry_point, workgroup_size, features, sizes, slots })
}

/// WGSL with the `enable` directives that browsers want, if they know all its features.
fn enabled(wgsl: &str, features: &[&str]) -> String {
    let head = if features == ["SUBGROUP"] { ENABLED } else { "" };
    format!("{head}{wgsl}")
}

fn parse(wgsl: &str) -> Result<Module, String> {
    naga::front::wgsl::parse_str(wgsl).map_err(|error| error.emit_to_string(wgsl))
}

fn validate(module: &Module, capabilities: Capabilities) -> Result<ModuleInfo, String> {
    // Open flags are uniform, but their stand-ins are private variables. The tests validate the original
    // kernels in full.
    let flags = ValidationFlags::all() - ValidationFlags::CONTROL_FLOW_UNIFORMITY;
    Validator::new(flags, capabilities)
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .map_err(|error| error.into_inner().to_string())
}

/// Features that the kernel requires.
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

#[cfg(test)]
mod tests {
    use super::*;
    use clap::ValueEnum as _;

    const OPEN: &str = "override STEP: u32; override SIDE: u32 = 2u;
        @group(0) @binding(40) var<uniform> way: vec4<f32>;
        @group(0) @binding(50) var<storage, read_write> x: array<u32>;
        @compute @workgroup_size(STEP * SIDE) fn add() { x[STEP] = x[0] + STEP + u32(way.x); }";

    fn kernel(wgsl: &str, target: Target) -> Result<Kernel, String> {
        Kernel::new("add", wgsl.to_owned(), &[("STEP", 3.0)], target)
    }

    #[test]
    fn constants_are_resolved() {
        for &target in Target::value_variants() {
            let add = kernel(OPEN, target).unwrap();
            assert_eq!(add.constants, [("SIDE".to_owned(), 2.0), ("STEP".to_owned(), 3.0)].into());
            assert_eq!(add.sizes, [(40, 16), (50, 4)].into());
            assert_eq!(add.open, [].into());
            let kernel = translate(&add).unwrap();
            assert_eq!(kernel.workgroup_size, [6, 1, 1], "{target:?}");
            assert_eq!(kernel.features, [""; 0]);
            let text = String::from_utf8_lossy(&kernel.source);
            assert!(!text.contains("override"), "{target:?} {text}");
        }
    }

    #[test]
    fn flags_stay_open_where_the_language_has_such() {
        let flagged = OPEN.replace("x[STEP] =", "if HAS_GAIN { x[1] = 1u; } x[STEP] =")
            + "override HAS_GAIN: bool = false;";
        for &target in Target::value_variants() {
            let add = kernel(&flagged, target).unwrap();
            let is_open = matches!(target, Target::Spirv | Target::Wgsl);
            assert_eq!(add.open.contains_key("HAS_GAIN"), is_open, "{target:?}");
            assert_eq!(add.constants["HAS_GAIN"], 0.0);
            let source = translate(&add).unwrap().source;
            let text = String::from_utf8_lossy(&source);
            assert_eq!(text.contains("override HAS_GAIN"), target == Target::Wgsl);
            if target == Target::Spirv {
                let words: &[u32] = bytemuck::cast_slice(&source);
                // OpSpecConstantFalse, three words; no private variable is left.
                assert_eq!(words.iter().filter(|&&word| word == 3 << 16 | 49).count(), 1);
                assert_eq!(words.iter().filter(|&&word| word == 5 << 16 | 59).count(), 0);
            }
        }
    }

    #[test]
    fn slots_are_few_where_the_language_has_few() {
        let slots = |target| translate(&kernel(OPEN, target).unwrap()).unwrap().slots;
        assert_eq!(slots(Target::Msl), [(40, 0), (50, 1)].into());
        assert_eq!(slots(Target::Glsl), [(40, 0), (50, 0)].into());
        assert_eq!(slots(Target::Spirv), [].into());
    }

    #[test]
    fn what_a_target_cannot_express_has_a_reason() {
        let add = |target| {
            let wgsl =
                "override STEP: u32; @group(0) @binding(0) var<storage, read_write> x: array<f64>;
                @compute @workgroup_size(STEP) fn add() { x[0] = x[1] + 1.0lf; }";
            translate(&kernel(wgsl, target).unwrap())
        };
        assert_eq!(add(Target::Msl).err().unwrap(), "the target lacks SHADER_F64");
        assert_eq!(add(Target::Spirv).unwrap().features, ["SHADER_F64"]);
    }

    #[test]
    fn an_open_constant_has_a_reason() {
        let open = "override STEP: u32; override OPEN: u32;
            @compute @workgroup_size(STEP, OPEN) fn add() {}";
        assert_eq!(kernel(open, Target::Spirv).err().unwrap(), "OPEN has no value");
    }

    #[test]
    fn what_is_no_kernel_has_a_reason() {
        assert!(
            kernel("fn add() { return 1; }", Target::Wgsl).and_then(|add| translate(&add)).is_err()
        );
    }
}

//! Every kernel is valid on its tier and says all its overrides, and every WGSL file is used.
use crate::common::parse;
use gobo::{
    gpu::Tier,
    stage::{KERNELS, sort::SERIAL_SCATTER},
};
use naga::valid::{Capabilities, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator};
use std::path::Path;

/// `pack2x16float` and its kind are core WebGPU; naga counts them as a capability.
const CORE: Capabilities = Capabilities::SHADER_FLOAT16_IN_FLOAT32;
const NATIVE: Capabilities = CORE.union(Capabilities::SUBGROUP).union(Capabilities::TEXTURE_ATOMIC);

fn is_valid(module: &naga::Module, capabilities: Capabilities) -> Result<(), String> {
    Validator::new(ValidationFlags::all(), capabilities)
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .map(|_| ())
        .map_err(|error| format!("{:?}", error.into_inner()))
}

#[test]
fn kernels_are_valid_on_their_tier() {
    for desc in KERNELS {
        let module = parse(desc);
        let capabilities = match desc.tier {
            Tier::Core => CORE,
            Tier::Native => NATIVE,
        };
        is_valid(&module, capabilities).unwrap_or_else(|error| panic!("{}: {error}", desc.name));
        let entry_points: Vec<_> = module.entry_points.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(entry_points, [desc.name]);
        let mut overrides: Vec<_> =
            module.overrides.iter().map(|(_, o)| o.name.as_deref().unwrap()).collect();
        let mut constants: Vec<_> = desc.constants.iter().map(|(name, _)| *name).collect();
        overrides.sort_unstable();
        constants.sort_unstable();
        assert_eq!(overrides, constants, "{}", desc.name);
    }
}

/// The check can fail: some native kernel is refused as a core one.
#[test]
fn native_kernels_are_not_core() {
    let native = KERNELS.iter().filter(|desc| desc.tier == Tier::Native);
    assert!(native.map(|desc| is_valid(&parse(desc), CORE)).any(|valid| valid.is_err()));
}

#[test]
fn every_wgsl_file_is_used() {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/wgsl"));
    let mut orphans = Vec::new();
    for dir in [root.to_owned(), root.join("common")] {
        for path in dir.read_dir().unwrap().map(|entry| entry.unwrap().path()) {
            let name = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
            let used = KERNELS.iter().flat_map(|desc| desc.sources).any(|s| s.path == name);
            if path.is_file() && !used {
                orphans.push(name);
            }
        }
    }
    assert_eq!(orphans, [""; 0], "in no kernel");
}

#[test]
fn errors_name_their_file() {
    let desc = &SERIAL_SCATTER;
    let source = desc.sources.last().unwrap();
    let line = 1 + source.text.lines().position(|l| l.contains("places[digit];")).unwrap();
    let wgsl = desc.wgsl().replace("places[digit];", "spaces[digit];");
    let error = naga::front::wgsl::parse_str(&wgsl).unwrap_err();
    let offset = error.location(&wgsl).unwrap().offset as usize;
    assert_eq!(desc.locate(offset), Some((source.path, line)));
}

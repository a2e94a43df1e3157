//! Modules as WGSL, which browsers compile.
use naga::{
    Module,
    back::wgsl::{WriterFlags, write_string},
    valid::{
        Capabilities, ModuleInfo, ShaderStages, SubgroupOperationSet, ValidationFlags, Validator,
    },
};

/// First lines of WGSL with subgroups in browsers. Their compilers only see that values of single lanes
/// decide a branch, although these come from ballots, which all lanes share.
pub const ENABLED: &str = "enable subgroups;\ndiagnostic(off, subgroup_uniformity);\n\n";

/// The WGSL of a module.
///
/// # Errors
/// The reason why it has none.
pub fn printed(module: &Module) -> Result<String, String> {
    let info = validated(module, Capabilities::all())?;
    let text = write_string(module, &info, WriterFlags::empty());
    text.map_err(|error| error.to_string())
}

/// The WGSL of a module for browsers.
#[cfg_attr(not(target_arch = "wasm32"), allow(dead_code, reason = "a test asks it"))]
pub fn for_browsers(module: &Module) -> Result<String, String> {
    let text = printed(module)?;
    let has_subgroups = validated(module, Capabilities::all() - Capabilities::SUBGROUP).is_err();
    Ok(format!("{}{text}", if has_subgroups { ENABLED } else { "" }))
}

fn validated(module: &Module, capabilities: Capabilities) -> Result<ModuleInfo, String> {
    let flags = ValidationFlags::all() - ValidationFlags::CONTROL_FLOW_UNIFORMITY;
    Validator::new(flags, capabilities)
        .subgroup_stages(ShaderStages::COMPUTE)
        .subgroup_operations(SubgroupOperationSet::all())
        .validate(module)
        .map_err(|error| error.into_inner().to_string())
}

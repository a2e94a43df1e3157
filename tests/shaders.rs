//! Every kernel is valid core WebGPU and says all its overrides.
use crate::common::parse;
use gobo::stage::{KERNELS, sort::SERIAL_SCATTER};
use naga::valid::{Capabilities, ValidationFlags, Validator};

#[test]
fn kernels_are_core_webgpu() {
    for desc in KERNELS {
        let module = parse(desc);
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&module)
            .unwrap_or_else(|e| panic!("{}", e.emit_to_string_with_path(&desc.wgsl(), desc.name)));
        let entry_points: Vec<_> = module.entry_points.iter().map(|e| e.name.as_str()).collect();
        assert_eq!(entry_points, [desc.name]);
        let overrides: Vec<_> =
            module.overrides.iter().map(|(_, o)| o.name.as_deref().unwrap()).collect();
        let constants: Vec<_> = desc.constants.iter().map(|(name, _)| *name).collect();
        assert_eq!(overrides, constants, "{}", desc.name);
    }
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

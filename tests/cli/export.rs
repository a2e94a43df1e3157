//! Exported kernels for engines without wgpu: every one is written, and well formed.
use super::commands::{Folder, files};
use serde_json::Value;
use std::fs;

#[test]
fn export_writes_every_kernel() {
    let folder = Folder::new("export");
    for target in ["spirv", "hlsl", "msl", "glsl", "wgsl"] {
        folder.run(&["export", "--target", target, "-o", target]);
        let dir = folder.0.join(target);
        let manifest = fs::read_to_string(dir.join("manifest.json")).unwrap();
        let manifest: Value = serde_json::from_str(&manifest).unwrap();
        let kernels = manifest["kernels"].as_array().unwrap();
        assert_eq!(kernels.len(), gobo::stage::variants().count());
        let mut expected = vec!["manifest.json".to_owned()];
        for (kernel, (desc, tier)) in kernels.iter().zip(gobo::stage::variants()) {
            let linked = desc.link(tier).unwrap();
            assert_eq!(kernel["name"], desc.name);
            let bindings = kernel["bindings"].as_array().unwrap();
            assert_eq!(bindings.len(), linked.bindings().unwrap().len());
            let has_slots = matches!(target, "msl" | "glsl") && kernel["file"].is_string();
            assert!(bindings.iter().all(|it| it["slot"].is_u64() == has_slots), "{bindings:?}");
            let sized = |it: &Value| it["size"].is_u64() || it["element_size"].is_u64();
            let sizes = |it: &&Value| ["uniform", "storage"].map(Value::from).contains(&it["kind"]);
            assert!(bindings.iter().filter(sizes).all(sized), "{bindings:?}");
            let constants = kernel["constants"].as_object().unwrap();
            assert_eq!(constants.len(), linked.overrides().count());
            let Some(file) = kernel["file"].as_str() else {
                assert_ne!(kernel["unsupported"].as_str().unwrap(), "");
                continue;
            };
            let size = &kernel["workgroup_size"];
            assert!((0..3).all(|axis| size[axis].as_u64() > Some(0)), "{kernel}");
            let source = fs::read(dir.join(file)).unwrap();
            well_formed(target, &source, kernel["entry_point"].as_str().unwrap())
                .unwrap_or_else(|error| panic!("{target}/{file}: {error}"));
            expected.push(file.to_owned());
        }
        expected.sort();
        assert_eq!(files(&dir), expected);
    }
}

fn well_formed(target: &str, source: &[u8], entry_point: &str) -> Result<(), String> {
    if target == "spirv" {
        let magic = source.starts_with(&0x0723_0203_u32.to_le_bytes());
        return if magic && source.len().is_multiple_of(4) {
            Ok(())
        } else {
            Err("no SPIR-V".to_owned())
        };
    }
    let text = str::from_utf8(source).map_err(|error| error.to_string())?;
    if !text.contains(&format!("{entry_point}(")) {
        return Err(format!("no function {entry_point}"));
    }
    if target == "wgsl" {
        let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
        if !module.overrides.is_empty() || module.entry_points[0].name != entry_point {
            return Err(format!("{:?}", module.overrides));
        }
    }
    Ok(())
}

#[test]
fn malformed_sources_are_noticed() {
    assert!(well_formed("spirv", b"\x03\x02\x23\x07", "main").is_ok());
    assert!(well_formed("spirv", b"\x07\x23\x02\x03", "main").is_err());
    assert!(well_formed("glsl", b"void other() {}", "main").is_err());
    assert!(well_formed("wgsl", b"@compute @workgroup_size(1) fn a() {", "a").is_err());
    assert!(
        well_formed("wgsl", b"override N: u32; @compute @workgroup_size(N) fn a() {}", "a")
            .is_err()
    );
}

//! Exported kernels for engines without wgpu: all are written, and well formed.
use super::commands::{Folder, files};
use gobo::gpu::{KernelDesc, Tier};
use serde_json::{Map, Value, json};
use std::{fs, path::Path};

/// First lines of kernels for browsers with subgroups.
const ENABLED: &[u8] = b"enable subgroups;\ndiagnostic(off, subgroup_uniformity);\n";

/// Whether an exported kernel is the variant of a tier, and not one with other constants.
fn is_variant(kernel: &Value, desc: &KernelDesc, tier: Tier) -> bool {
    kernel["name"] == desc.name && kernel["tier"] == tier.name()
}

#[test]
fn export_writes_every_kernel() {
    assert_exported(&["wgsl"]);
}

#[test]
#[ignore = "as many kernels in four more languages: make test-all"]
fn export_writes_every_kernel_in_other_languages() {
    assert_exported(&["spirv", "hlsl", "msl", "glsl"]);
}

fn assert_exported(targets: &[&str]) {
    let folder = Folder::new(&format!("export-{}", targets[0]));
    let variants: Vec<_> = gobo_picture::stage::variants()
        .map(|(desc, tier)| {
            let linked = desc.link(tier).unwrap();
            (desc, tier, linked.bindings().unwrap().len(), linked.overrides().count())
        })
        .collect();
    for &target in targets {
        folder.run(&["export", "--target", target, "-o", target]);
        let dir = folder.0.join(target);
        let manifest = json(&dir.join("manifest.json"));
        let kernels = manifest["kernels"].as_array().unwrap();
        let mut expected = vec!["manifest.json".to_owned()];
        assert!(kernels.len() > variants.len());
        for &(desc, tier, binding_count, constant_count) in &variants {
            let own: Vec<_> = kernels.iter().filter(|it| is_variant(it, desc, tier)).collect();
            assert!(!own.is_empty(), "{}", desc.name);
            for kernel in own {
                let bindings = kernel["bindings"].as_array().unwrap();
                assert_eq!(bindings.len(), binding_count);
                let has_slots = matches!(target, "msl" | "glsl") && kernel["file"].is_string();
                assert!(bindings.iter().all(|it| it["slot"].is_u64() == has_slots), "{bindings:?}");
                let sized = |it: &Value| it["size"].is_u64() || it["element_size"].is_u64();
                let sizes =
                    |it: &&Value| ["uniform", "storage"].map(Value::from).contains(&it["kind"]);
                assert!(bindings.iter().filter(sizes).all(sized), "{bindings:?}");
                let constants = kernel["constants"].as_object().unwrap();
                assert_eq!(constants.len(), constant_count);
                let Some(file) = kernel["file"].as_str() else {
                    assert_ne!(kernel["unsupported"].as_str().unwrap(), "");
                    continue;
                };
                assert_eq!(file.split('.').next().unwrap(), kernel["id"]);
                let size = &kernel["workgroup_size"];
                assert!((0..3).all(|axis| size[axis].as_u64() > Some(0)), "{kernel}");
                let source = fs::read(dir.join(file)).unwrap();
                let open = kernel["specialisation"].as_object().map_or(0, Map::len);
                if target == "wgsl" {
                    // Texture atomics are not WGSL in browsers, and naga does not know `enable subgroups;`.
                    let is_enabled = source.starts_with(ENABLED);
                    assert_eq!(is_enabled, kernel["features"] == json!(["SUBGROUP"]), "{file}");
                    assert!(is_enabled || tier != Tier::Subgroups, "{file}");
                }
                let source = source.strip_prefix(ENABLED).unwrap_or(&source);
                well_formed(target, source, kernel["entry_point"].as_str().unwrap(), open)
                    .unwrap_or_else(|error| panic!("{target}/{file}: {error}"));
                expected.push(file.to_owned());
            }
        }
        let document = include_str!("../../docs/export.md");
        let flags = kernels.iter().filter_map(|it| it["specialisation"].as_object());
        for flag in flags.flat_map(Map::keys) {
            assert!(document.contains(&format!("`{flag}`")), "docs/export.md lacks {flag}");
        }
        let look_ups = manifest["look_ups"].as_array().unwrap();
        assert_eq!(look_ups.len(), if target == "spirv" { 0 } else { 7 });
        for look_up in look_ups {
            let file = look_up["file"].as_str().unwrap();
            let text = fs::read_to_string(dir.join(file)).unwrap();
            for name in ["gobo_light_through(", "gobo_light_at("] {
                assert!(text.contains(name), "{target}/{file} has no {name}");
            }
            assert!(look_up["bindings"].as_array().unwrap().len() > 3, "{look_up}");
            expected.push(file.to_owned());
        }
        expected.sort();
        assert_eq!(files(&dir), expected);
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_recorded_frame_is_whole() {
    let folder = Folder::new("export-frame");
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/ash/scenes/five.toml");
    folder.run(&["export", "--target", "wgsl", "-o", "out", "--scene", scene]);
    let dir = folder.0.join("out");
    let frame = json(&dir.join("frame.json"));
    assert_eq!(faults(&dir, &frame), [""; 0]);
    let text = frame.to_string();
    for (from, to, wanted) in [
        ("\"name\":\"rects\"", "\"name\":\"areas\"", "binds areas"),
        ("\"id\":\"bin_scan\"", "\"id\":\"bin_scam\"", "bin_scan"),
        ("\"rects\":\"rects\"", "\"rocts\":\"rects\"", "bin_count binds rects"),
        ("/views.bin", "/news.bin", "news.bin"),
    ] {
        assert!(text.contains(from), "{from}");
        let wrong = serde_json::from_str(&text.replace(from, to)).unwrap();
        let found = faults(&dir, &wrong);
        assert!(found.iter().any(|it| it.contains(wanted)), "{from}: {found:?}");
    }
}

/// Names in a recorded frame that are not defined, and files that are missing.
fn faults(dir: &Path, frame: &Value) -> Vec<String> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut faults = Vec::new();
    for (_, tier) in frame["tiers"].as_object().unwrap() {
        let known = |list_name: &str, key: &str, name: &Value| {
            list(&tier[list_name]).iter().any(|it| it[key] == *name)
        };
        let mut check = |is_known: bool, what: String| {
            if !is_known {
                faults.push(what);
            }
        };
        let is_resource = |name: &Value| known("resources", "name", name);
        let files = [(&tier["resources"], "initial"), (&tier["kernels"], "file")];
        for (all, key) in files {
            for entry in list(all) {
                let file = &entry[key];
                check(file.as_str().is_none_or(|file| dir.join(file).is_file()), file.to_string());
            }
        }
        let commands = list(&tier["commands"]);
        check(commands.len() > 25, "commands".to_owned());
        for command in commands {
            let (clear, copy) = (&command["clear"], &command["copy_buffer"]);
            let names = [clear, &copy["from"], &copy["to"]];
            for name in names.into_iter().filter(|name| !name.is_null()) {
                check(is_resource(name), name.to_string());
            }
            for dispatch in list(&command["dispatches"]) {
                let id = &dispatch["kernel"];
                check(known("kernels", "id", id), id.to_string());
                let kernels = list(&tier["kernels"]);
                let kernel = kernels.iter().find(|it| it["id"] == *id).cloned().unwrap_or_default();
                for binding in list(&kernel["bindings"]) {
                    let name = binding["name"].as_str().unwrap();
                    let bound = &dispatch["bind"][name];
                    check(is_resource(bound), format!("{} binds {name}", id.as_str().unwrap()));
                }
                let (groups, counts) = (&dispatch["groups"], &dispatch["indirect"]["buffer"]);
                check(groups.is_array() || is_resource(counts), format!("groups of {dispatch}"));
            }
        }
    }
    faults
}

/// `open`: number of constants with ids.
fn well_formed(target: &str, source: &[u8], entry_point: &str, open: usize) -> Result<(), String> {
    if target == "spirv" {
        let words: Vec<_> = source.as_chunks().0.iter().map(|&it| u32::from_le_bytes(it)).collect();
        if words.first() != Some(&0x0723_0203) || !source.len().is_multiple_of(4) {
            return Err("no SPIR-V".to_owned());
        }
        // Decorations with 1, which is SpecId.
        let ids = words.windows(3).filter(|it| it[0] == 4 << 16 | 71 && it[2] == 1).count();
        return if ids == open { Ok(()) } else { Err(format!("{ids} of {open} constants")) };
    }
    let text = str::from_utf8(source).map_err(|error| error.to_string())?;
    if !text.contains(&format!("{entry_point}(")) {
        return Err(format!("no function {entry_point}"));
    }
    if target == "wgsl" {
        let module = naga::front::wgsl::parse_str(text).map_err(|e| e.emit_to_string(text))?;
        if module.overrides.len() != open || module.entry_points[0].name != entry_point {
            return Err(format!("{:?}", module.overrides));
        }
    }
    Ok(())
}

#[test]
fn malformed_sources_are_noticed() {
    assert!(well_formed("spirv", b"\x03\x02\x23\x07", "main", 0).is_ok());
    assert!(well_formed("spirv", b"\x07\x23\x02\x03", "main", 0).is_err());
    assert!(well_formed("glsl", b"void other() {}", "main", 0).is_err());
    assert!(well_formed("wgsl", b"@compute @workgroup_size(1) fn a() {", "a", 0).is_err());
    assert!(
        well_formed("wgsl", b"override N: u32; @compute @workgroup_size(N) fn a() {}", "a", 0)
            .is_err()
    );
}

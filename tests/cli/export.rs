//! Exported kernels for engines without wgpu: every one is written, and well formed.
use super::commands::{Folder, files};
use gobo::gpu::{KernelDesc, Tier};
use serde_json::{Map, Value};
use std::{
    collections::{HashMap, HashSet},
    fs,
    path::Path,
};

/// Name and tier of what is exported, without what is only cut otherwise.
fn is_variant(kernel: &Value, desc: &KernelDesc, tier: Tier) -> bool {
    let tier = if tier == Tier::Core { "core" } else { "native" };
    kernel["name"] == desc.name && kernel["tier"] == tier
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
    let variants: Vec<_> = gobo::stage::variants()
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
        let mut expected = vec!["manifest.json".to_owned(), "passes.json".to_owned()];
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
                well_formed(target, &source, kernel["entry_point"].as_str().unwrap(), open)
                    .unwrap_or_else(|error| panic!("{target}/{file}: {error}"));
                expected.push(file.to_owned());
            }
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
        let passes = json(&dir.join("passes.json"));
        assert_eq!(faults(&manifest, &passes), [""; 0], "{target}");
        assert_holes_are_found(&manifest, &passes);
    }
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}

/// What a frame of `passes` would miss.
fn faults(manifest: &Value, passes: &Value) -> Vec<String> {
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let keys =
        |value: &Value| -> HashSet<String> { value.as_object().unwrap().keys().cloned().collect() };
    let resources: HashSet<_> =
        list(&passes["resources"]).iter().map(|it| text(&it["name"])).collect();
    let (conditions, traits) = (keys(&passes["conditions"]), keys(&passes["traits"]));
    let mut numbers = keys(&passes["numbers"]);
    let mut faults = Vec::new();
    let mut check = |is_known: bool, what: String| {
        if !is_known {
            faults.push(what);
        }
    };
    let mut formulas = Vec::new();
    for definition in list(&passes["definitions"]) {
        let formula = text(&definition["formula"]);
        check(names(&formula).all(|it| numbers.contains(it)), formula.clone());
        numbers.insert(text(&definition["name"]));
    }
    for resource in list(&passes["resources"]) {
        for key in ["count", "width", "height", "layers"] {
            formulas.push(text(&resource[key]));
        }
        formulas.extend(list(&resource["words"]).iter().map(text));
    }
    let steps: Vec<Value> = list(&passes["lists"])
        .iter()
        .flat_map(|it| list(&it["steps"]))
        .flat_map(|step| if step["sort"].is_string() { list(&step["steps"]) } else { vec![step] })
        .collect();
    check(steps.len() > 25, "steps".to_owned());
    for step in steps {
        for when in list(&step["when"]) {
            check(conditions.contains(&text(&when)), when.to_string());
        }
        for name in list(&step["clear"]) {
            check(resources.contains(&text(&name)), name.to_string());
        }
        formulas.extend(list(&step["groups"]).iter().map(text));
        check(
            step["clear"].is_array() || step["groups"].is_array() || step["indirect"].is_object(),
            format!("groups of {step}"),
        );
        let mut bound = HashMap::new();
        for (binding, source) in step["bind"].as_object().cloned().unwrap_or_default() {
            let per_digit = source["digit"].as_str().is_some();
            let names = match &source {
                Value::String(name) => vec![name.clone()],
                of if per_digit => vec![text(&of["digit"])],
                of if of["trait"].is_string() => vec![text(&of["then"]), text(&of["otherwise"])],
                of => [list(&of["of"]), list(&of["digits"])].concat().iter().map(text).collect(),
            };
            check(!names.is_empty(), source.to_string());
            for name in names {
                check(resources.contains(&name), name);
            }
            bound.insert(binding, source);
        }
        for choice in list(&step["kernels"]) {
            for it in list(&choice["traits"]) {
                check(traits.contains(&text(&it)), it.to_string());
            }
            for tier in ["core", "native"] {
                let id = &choice[tier];
                let kernels = list(&manifest["kernels"]);
                let Some(kernel) = kernels.iter().find(|it| it["id"] == *id) else {
                    check(false, format!("kernel {id}"));
                    continue;
                };
                for binding in list(&kernel["bindings"]) {
                    let name = text(&binding["name"]);
                    check(bound.contains_key(&name), format!("{id} binds {name}"));
                }
            }
        }
    }
    for formula in formulas {
        check(names(&formula).all(|it| numbers.contains(it)), formula.clone());
    }
    faults
}

/// Of a formula, but for functions.
fn names(formula: &str) -> impl Iterator<Item = &str> {
    let functions = ["div_up", "min", "max", "power", "bits", "rows"];
    let words = formula.split(|c: char| !c.is_ascii_alphanumeric() && c != '_');
    let is_name = |word: &&str| word.starts_with(|c: char| c.is_ascii_alphabetic());
    words.filter(is_name).filter(move |word| !functions.contains(word))
}

/// Asserts that [`faults`] finds a hole.
fn assert_holes_are_found(manifest: &Value, passes: &Value) {
    let text = passes.to_string();
    for (from, to, wanted) in [
        ("\"name\":\"rects\"", "\"name\":\"areas\"", "rects"),
        ("\"bin_scan\"", "\"bin_scam\"", "kernel \"bin_scam\""),
        ("\"rects\":\"rects\"", "\"rocts\":\"rects\"", "binds rects"),
        ("\"tile_count\":", "\"tile_counts\":", "tile_count"),
        ("\"merged\":", "\"emerged\":", "\"merged\""),
    ] {
        assert!(text.contains(from), "{from}");
        let wrong = serde_json::from_str(&text.replace(from, to)).unwrap();
        let found = faults(manifest, &wrong);
        assert!(found.iter().any(|it| it.contains(wanted)), "{from}: {found:?}");
    }
}

/// `open`: how many constants have ids.
fn well_formed(target: &str, source: &[u8], entry_point: &str, open: usize) -> Result<(), String> {
    if target == "spirv" {
        let words: Vec<_> = source.as_chunks().0.iter().map(|&it| u32::from_le_bytes(it)).collect();
        if words.first() != Some(&0x0723_0203) || !source.len().is_multiple_of(4) {
            return Err("no SPIR-V".to_owned());
        }
        // Decorations by 1, which is SpecId.
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

//! docs/stages.md has a section for each stage, with all its kernels.
use gobo_picture::stage::kernels;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

const PARTS: [&str; 4] = ["**Principle.**", "**Formula.**", "**Kernels.**", "**Cost.**"];

/// Sections of a text, each with its name.
fn sections(text: &str) -> Vec<(&str, &str)> {
    text.split("\n## ").skip(1).map(|section| section.split_once('\n').unwrap()).collect()
}

/// Stages: files of the folders `stage/` with kernels of their own.
fn stages() -> BTreeSet<String> {
    let folders = ["src/stage", "crates/gobo-picture/src/stage"];
    let entries =
        folders.map(|folder| Path::new(crate::common::ROOT).join(folder).read_dir().unwrap());
    let mut stages = BTreeSet::new();
    for path in entries.into_iter().flatten().map(|entry| entry.unwrap().path()) {
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let text =
            fs::read_to_string(if path.is_dir() { path.join("kernels.rs") } else { path }).unwrap();
        let has_kernels = text.contains("KernelDesc =");
        // Neither the list of all kernels nor that of one adapter.
        if has_kernels && !["mod", "llvmpipe"].contains(&name.as_str()) {
            stages.insert(name);
        }
    }
    stages
}

/// Omissions and errors of a text.
fn faults(text: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let found: BTreeSet<String> =
        sections(text).iter().map(|(name, _)| (*name).to_owned()).collect();
    for name in stages().symmetric_difference(&found) {
        faults.push(format!("{name} is a section or a stage, not both"));
    }
    for (name, section) in sections(text) {
        let missing = PARTS.iter().filter(|part| !section.contains(**part));
        faults.extend(missing.map(|part| format!("{name} has no {part}")));
    }
    let mut entries = BTreeMap::<_, BTreeSet<_>>::new();
    for desc in kernels() {
        entries.entry(desc.root).or_default().insert(desc.entry);
    }
    // A file with several entry points does not say which kernels a stage has.
    for entry in entries.values().filter(|of_file| of_file.len() > 1).flatten() {
        if !text.contains(&format!("`{entry}`")) {
            faults.push(format!("{entry} is nowhere"));
        }
    }
    for desc in kernels() {
        if !crate::common::WGSL
            .iter()
            .any(|folder| text.contains(&format!("`{folder}/{}`", desc.root)))
        {
            faults.push(format!("{} is nowhere", desc.root));
        }
    }
    faults
}

#[test]
fn every_stage_has_its_section() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/stages.md");
    let text = fs::read_to_string(path).unwrap();
    let found = faults(&text);
    assert!(found.is_empty(), "{}", found.join("\n"));
    for wrong in [
        text.replace("## bin\n", "## binning\n"),
        text.replacen("**Cost.**", "", 1),
        text.replace("`wgsl/bin/bin.wgsl`", ""),
    ] {
        assert!(!faults(&wrong).is_empty());
    }
}

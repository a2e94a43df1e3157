//! `make fuzz` gives odd values to the keys of all tables: each table is in one of the scenes that it begins
//! with.
use gobo_scene as scene;
use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

/// Files in a folder of the project, and in folders below it, whose names have this ending.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let mut pending = vec![Path::new(crate::common::ROOT).join(folder)];
    let mut found = Vec::new();
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|own| own == extension) {
            found.push(path);
        }
    }
    found
}

/// Names of the tables that the parser reads.
fn tables() -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for file in files("crates/gobo-scene/src", "rs") {
        let text = fs::read_to_string(file).unwrap();
        for call in [".one(\"", ".many(\""] {
            let after = text.split(call).skip(1).filter_map(|rest| rest.split('"').next());
            names.extend(after.map(str::to_owned));
        }
    }
    names
}

/// Names of the tables in scenes of a folder.
fn read(folder: &str) -> BTreeSet<String> {
    let keys = files(folder, "toml").into_iter().flat_map(|path| scene::asked_keys(&path).unwrap());
    // `light.0.source.kind` is a key of the tables `light` and `source`.
    let names = keys.flat_map(|key| {
        let mut parts: Vec<_> = key.split('.').map(str::to_owned).collect();
        parts.pop();
        parts
    });
    names.collect()
}

#[test]
fn every_table_is_in_a_seed() {
    let seeds = include_str!("../../examples/fuzz/seeds.rs");
    let folders = ["data", "data/issues", "data/gallery", "examples/fuzz"];
    let list = folders.map(|folder| format!("{folder:?}")).join(", ");
    assert!(seeds.contains(&list), "the fuzzer begins with other folders than {list}");
    let (tables, others) = (tables(), read("data"));
    assert!(tables.len() > 20, "{tables:?}");
    let all: BTreeSet<_> = others.union(&read("examples/fuzz")).cloned().collect();
    let missing = |read: &BTreeSet<String>| tables.difference(read).cloned().collect::<Vec<_>>();
    assert_eq!(missing(&all), [""; 0]);
    // The check finds a table that only the fuzzer's own scene has.
    assert!(missing(&others).contains(&"trail".to_owned()));
}

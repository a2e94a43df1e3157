//! Existence of files that comments and documents name.
use std::{
    fs,
    path::{Path, PathBuf},
};

const FOLDERS: [&str; 8] =
    ["src/", "crates/", "wgsl/", "tests/", "docs/", "benches/", "examples/", "tools/"];

fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|entry| files(&entry)).collect()
}

/// Paths of files in comments of Rust and WGSL, and in the text of documents.
fn named<'a>(name: &str, text: &'a str) -> Vec<&'a str> {
    let is_document = Path::new(name).extension().is_some_and(|extension| extension == "md");
    let lines = text.lines().filter_map(|line| {
        if is_document { Some(line) } else { line.split_once("//").map(|(_, comment)| comment) }
    });
    lines
        .flat_map(|line| line.split(|c: char| !(c.is_alphanumeric() || "_/.-*".contains(c))))
        .map(|word| word.trim_end_matches(['.', '-']))
        .map(|word| word.trim_start_matches("../"))
        .filter(|word| FOLDERS.iter().any(|folder| word.starts_with(folder)))
        // Patterns and folders are no files. `x` stands for the name of a stage.
        .filter(|word| !word.contains("/x."))
        .filter(|word| !word.contains('*') && word.rsplit('/').next().unwrap().contains('.'))
        .collect()
}

fn missing(root: &Path, name: &str, text: &str) -> Vec<String> {
    named(name, text)
        .into_iter()
        .filter(|path| !root.join(path).exists())
        .map(|path| format!("{name} names {path}"))
        .collect()
}

#[test]
fn files_that_are_named_exist() {
    let root = Path::new(crate::common::ROOT);
    let mut found = Vec::new();
    let crates =
        ["cli", "picture", "reference", "scene"].map(|name| format!("crates/gobo-{name}/src"));
    let parts = ["src", "wgsl", "docs", "benches", "examples", "README.md", "CONTRIBUTING.md"];
    for part in parts.into_iter().chain(crates.iter().map(String::as_str)) {
        for file in files(&root.join(part)) {
            let Ok(text) = fs::read_to_string(&file) else { continue };
            found.extend(missing(root, &file.to_string_lossy(), &text));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_file_that_is_gone_is_noticed() {
    let root = Path::new(crate::common::ROOT);
    assert_eq!(missing(root, "x.wgsl", "// CPU reference: src/cpu/bin.rs.").len(), 1);
    assert_eq!(missing(root, "x.md", "in [this](../docs/none.md) one").len(), 1);
    for fine in ["// Rust: src/lib.rs.", "\"src/none.rs\"", "// `wgsl/sort_*.wgsl`, src/model"] {
        assert!(missing(root, "x.rs", fine).is_empty(), "{fine}");
    }
}

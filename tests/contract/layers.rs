//! The folders of `src/` form layers: a file imports from its own folder and from those below.
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// Folders that each folder or file of `src/` may import from, besides itself. New dependencies must be
/// added here.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("model", &[]),
    ("records", &["model"]),
    ("reference", &["model", "records"]),
    ("view", &["model", "records"]),
    ("gpu", &["model", "records"]),
    ("stage", &["gpu", "model", "records"]),
    ("frame", &["gpu", "model", "records", "stage"]),
    ("shadows", &["frame", "gpu", "model", "records", "stage", "view"]),
    ("picture", &["frame", "gpu", "model", "records", "shadows", "stage", "view"]),
    ("scene", &["model", "records", "view"]),
    ("render", &["gpu", "model", "picture", "records", "reference", "shadows", "stage", "view"]),
];

fn folder(path: &Path) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn files(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|entry| files(&entry)).collect()
}

/// First segments of the paths that begin with `crate::`, apart from comments and macros.
fn imports(source: &str) -> BTreeSet<String> {
    let code: Vec<_> = source.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    let code = code.join("\n");
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        // `pub(crate)` and `$crate` are none.
        if code[..at].ends_with('$') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        if let Some(tree) = rest.strip_prefix('{') {
            found.extend(heads(tree));
        } else {
            found.insert(word(rest));
        }
    }
    found.remove("");
    found
}

fn word(text: &str) -> String {
    text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// First segments of the branches of a `use` tree, up to its closing brace.
fn heads(tree: &str) -> Vec<String> {
    let mut heads = Vec::new();
    let (mut depth, mut start) = (0, 0);
    for (at, c) in tree.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => {
                heads.push(word(tree[start..at].trim_start()));
                break;
            }
            '}' => depth -= 1,
            ',' if depth == 0 => {
                heads.push(word(tree[start..at].trim_start()));
                start = at + 1;
            }
            _ => {}
        }
    }
    heads
}

/// Modules and re-exported macros of the crate's root.
fn modules() -> BTreeSet<String> {
    let entries = fs::read_dir(folder(Path::new("src"))).unwrap();
    entries
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| !["lib", "main", "cli"].contains(&name.as_str()))
        .collect()
}

/// `from -> to: file` for every import that [`MAY_IMPORT`] does not name.
fn faults(module: &str, file: &str, source: &str) -> Vec<String> {
    let modules = modules();
    let allowed = MAY_IMPORT.iter().find(|(name, _)| *name == module).map_or(&[][..], |row| row.1);
    imports(source)
        .into_iter()
        .filter(|to| modules.contains(to) && to != module && !allowed.contains(&to.as_str()))
        .map(|to| format!("{module} -> {to}: {file}"))
        .collect()
}

#[test]
fn no_folder_imports_from_above() {
    let mut found = Vec::new();
    for module in modules() {
        let path = folder(Path::new("src")).join(&module);
        let path = if path.is_dir() { path } else { path.with_extension("rs") };
        for file in files(&path) {
            let source = fs::read_to_string(&file).unwrap();
            found.extend(faults(&module, &file.to_string_lossy(), &source));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn an_arrow_upwards_is_found() {
    for source in [
        "use crate::shadows::Maps;",
        "use crate::{\n    model::{Light, View},\n    shadows::{Maps, kernels::{Kernels, Variant}},\n};",
        "fn f() -> crate::shadows::Maps {}",
    ] {
        assert_eq!(faults("view", "x.rs", source), ["view -> shadows: x.rs"], "{source}");
    }
    for source in ["// crate::shadows::Maps", "use crate::model::View;", "$crate::shadows::x!()"] {
        assert!(faults("view", "x.rs", source).is_empty(), "{source}");
    }
}

#[test]
fn the_layers_have_no_circle() {
    let mut left: BTreeMap<_, BTreeSet<_>> =
        MAY_IMPORT.iter().map(|(from, to)| (*from, to.iter().copied().collect())).collect();
    assert_eq!(left.len(), modules().len(), "every folder has a row");
    while !left.is_empty() {
        let free: Vec<_> =
            left.iter().filter(|(_, to)| to.is_empty()).map(|(from, _)| *from).collect();
        assert!(!free.is_empty(), "a circle: {left:?}");
        for name in free {
            left.remove(name);
            left.values_mut().for_each(|to| {
                to.remove(name);
            });
        }
    }
}

/// Code for a driver's quirks can be deleted as a folder: nothing outside of it imports from it, and in
/// Rust only the code that chooses it names it. (That it changes no bit: `maps::pipeline`.)
#[test]
fn nothing_hangs_on_what_is_for_llvmpipe_alone() {
    let (inside, outside): (Vec<_>, Vec<_>) = files(&folder(Path::new("wgsl")))
        .into_iter()
        .partition(|file| file.parent().unwrap().ends_with("llvmpipe"));
    assert!(!inside.is_empty());
    for file in outside {
        let source = fs::read_to_string(&file).unwrap();
        assert!(!source.contains("package::llvmpipe"), "{}", file.display());
    }
    let may = ["stage/llvmpipe.rs", "stage/mod.rs", "stage/profile.rs", "stage/accumulate.rs"];
    for file in files(&folder(Path::new("src"))) {
        let source = fs::read_to_string(&file).unwrap();
        let named = source.contains("llvmpipe::") || source.contains("llvmpipe/");
        let is_listed = may.iter().any(|path| file.ends_with(path));
        assert!(!named || is_listed, "{}", file.display());
    }
}

//! The folders of `src/` and the crates above them form layers: a file imports from its own folder and from
//! those below.
use super::sources::{Module, Source, arrows, files, sources};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// Imports of each folder and crate, besides its own. New dependencies must be added here.
const MAY_IMPORT: &[(&str, &[&str])] = &[
    ("model", &[]),
    ("records", &["model"]),
    ("view", &["model"]),
    ("gpu", &["model", "records"]),
    ("stage", &["gpu", "model", "records"]),
    ("frame", &["gpu", "stage"]),
    ("shadows", &["frame", "gpu", "model", "records", "stage", "view"]),
    ("gobo_reference", &["model", "records"]),
    ("gobo_scene", &["model", "records", "view"]),
    (
        "gobo_picture",
        &["frame", "gobo_reference", "gpu", "model", "records", "shadows", "stage", "view"],
    ),
];

/// Folders whose declarations the files of each folder name.
fn dependencies(sources: &BTreeMap<Module, Source>) -> BTreeMap<String, BTreeSet<String>> {
    let mut found = BTreeMap::<_, BTreeSet<_>>::new();
    for (from, to) in arrows(sources) {
        let folder = |module: &Module| module.first().cloned();
        let all = found.entry(folder(&from)).or_default();
        all.extend(to.iter().filter_map(folder).filter(|to| Some(to) != from.first()));
    }
    found.into_iter().filter_map(|(from, to)| Some((from?, to))).collect()
}

fn may_import() -> BTreeMap<String, BTreeSet<String>> {
    let row = |&(from, to): &(&str, &[&str])| {
        (from.to_owned(), to.iter().map(|&to| to.to_owned()).collect())
    };
    MAY_IMPORT.iter().map(row).collect()
}

#[test]
fn folders_import_from_those_below() {
    let mut found = dependencies(&sources());
    found.remove("gobo_cli"); // the program, above all
    assert_eq!(found, may_import());
}

#[test]
fn an_arrow_upwards_is_found() {
    for text in [
        "use crate::shadows::Maps;",
        "use crate::{shadows::{self}, std::fmt};",
        "fn f() -> crate::shadows::Maps {}",
        "use super::shadows::Maps;",
        "use crate::Maps;",
    ] {
        let root = Source::of(&[], "pub use shadows::Maps;");
        let sources = BTreeMap::from([
            (vec![], root),
            (vec!["shadows".to_owned()], Source::of(&["shadows".to_owned()], "pub struct Maps;")),
            (vec!["view".to_owned()], Source::of(&["view".to_owned()], text)),
        ]);
        let found = dependencies(&sources);
        assert_eq!(found["view"], BTreeSet::from(["shadows".to_owned()]), "{text}");
    }
}

#[test]
fn the_layers_have_no_circle() {
    let mut left = may_import();
    while !left.is_empty() {
        let free: Vec<_> =
            left.iter().filter(|(_, to)| to.is_empty()).map(|(from, _)| from.clone()).collect();
        assert!(!free.is_empty(), "a circle: {left:?}");
        for name in free {
            left.remove(&name);
            left.values_mut().for_each(|to| {
                to.remove(&name);
            });
        }
    }
}

/// Code for a driver's quirks can be deleted as a folder: no file outside imports from it, and in Rust only
/// the code that chooses it names it. (That it changes no bit: `maps::pipeline`.)
#[test]
fn nothing_hangs_on_what_is_for_llvmpipe_alone() {
    let root = Path::new(crate::common::ROOT);
    let (inside, outside): (Vec<_>, Vec<_>) = files(&root.join("wgsl"))
        .into_iter()
        .partition(|file| file.parent().unwrap().ends_with("llvmpipe"));
    assert!(!inside.is_empty());
    for file in outside {
        let source = fs::read_to_string(&file).unwrap();
        assert!(!source.contains("package::llvmpipe"), "{}", file.display());
    }
    let may = ["stage/llvmpipe.rs", "stage/mod.rs", "stage/tuning.rs", "stage/accumulate.rs"];
    for file in files(&root.join("src")) {
        let source = fs::read_to_string(&file).unwrap();
        let named = source.contains("llvmpipe::") || source.contains("llvmpipe/");
        let is_listed = may.iter().any(|path| file.ends_with(path));
        assert!(!named || is_listed, "{}", file.display());
    }
}

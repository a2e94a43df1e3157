//! Files that import each other in a cycle can only be understood together: cycles stay small.
use super::sources::{Module, Source, arrows, sources};
use std::collections::{BTreeMap, BTreeSet};

/// Most files in a cycle.
const MAX_CIRCLE: usize = 4;

/// Sets of files that reach each other.
fn circles(arrows: &BTreeMap<Module, BTreeSet<Module>>) -> Vec<BTreeSet<Module>> {
    let reached = |from: &Module| {
        let (mut seen, mut open) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(file) = open.pop() {
            let new: Vec<_> = arrows[&file].iter().filter(|&to| seen.insert(to.clone())).collect();
            open.extend(new.into_iter().cloned());
        }
        seen
    };
    let all: BTreeMap<_, _> = arrows.keys().map(|file| (file, reached(file))).collect();
    let circle = |file: &Module| -> BTreeSet<Module> {
        all[file].iter().filter(|to| all[to].contains(file)).cloned().collect()
    };
    let circles: BTreeSet<_> = arrows.keys().map(circle).collect();
    circles.into_iter().filter(|circle| !circle.is_empty()).collect()
}

#[test]
fn no_circle_of_files_is_large() {
    let arrows = arrows(&sources());
    assert!(arrows.values().map(BTreeSet::len).sum::<usize>() > 1000, "{arrows:?}");
    for circle in circles(&arrows) {
        let names: Vec<_> = circle.iter().map(|file| file.join("/")).collect();
        assert!(names.len() <= MAX_CIRCLE, "{} files: {names:?}", names.len());
    }
}

#[test]
fn circles_are_found_through_what_is_passed_on() {
    let source = |module: &str, text: &str| {
        let module: Module = module.split('/').map(str::to_owned).collect();
        (module.clone(), Source::of(&module, text))
    };
    let sources = BTreeMap::from([
        source("a", "mod b; #[path = \"../z.rs\"] mod c; pub use b::{B, C as D};"),
        source("a/b", "use crate::{e::{self, E}, f}; use super::c::Z; mod tests { use crate::g; }"),
        source("e", "use std::fmt; fn g(_: super::a::D) {}"),
        source("f", "pub(crate) use crate::e::F;"),
        source("g", "// crate::e\nuse crate::e::E;"),
    ]);
    let arrows = arrows(&sources);
    let names =
        |files: &BTreeSet<Module>| files.iter().map(|file| file.join("/")).collect::<Vec<_>>();
    assert_eq!(names(&arrows[&vec!["a".to_owned(), "b".to_owned()]]), ["e", "f"]);
    let found: Vec<_> = circles(&arrows).iter().map(names).collect();
    assert_eq!(found, [["a/b", "e"]]);
}

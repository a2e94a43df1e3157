//! docs/pipeline.md lists the names that kernels import from each `choice::`.
use crate::common::{ROOT, WGSL};
use std::{collections::BTreeSet, fs, path::Path};

/// Name and item of each import from `choice::` in a text.
fn imports(text: &str) -> Vec<(String, String)> {
    let rests = text.split("import choice::").skip(1);
    let imports = rests.filter_map(|rest| rest.split_once(';')?.0.split_once("::"));
    imports
        .flat_map(|(name, items)| {
            let items = items.split([',', '{', '}']).map(str::trim);
            items
                .filter(|item| !item.is_empty())
                .map(move |item| (name.to_owned(), item.to_owned()))
        })
        .collect()
}

fn collect(path: &Path, found: &mut BTreeSet<(String, String)>) {
    if path.is_dir() {
        for entry in path.read_dir().unwrap() {
            collect(&entry.unwrap().path(), found);
        }
    } else if path.extension().is_some_and(|extension| extension == "wgsl") {
        found.extend(imports(&fs::read_to_string(path).unwrap()));
    }
}

/// Words in back quotes.
fn quoted(cell: &str) -> Vec<String> {
    cell.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

/// Choices and items of each row of the table.
fn rows(page: &str) -> Vec<(Vec<String>, Vec<String>)> {
    let (_, table) = page.split_once("| `choice::` |").expect("a table of choices");
    let rows = table.split("\n\n").next().unwrap().lines().filter(|line| line.starts_with("| `"));
    rows.map(|row| {
        let cells: Vec<_> = row.split('|').collect();
        (quoted(cells[1]), quoted(cells[2]))
    })
    .collect()
}

/// Imports that the page lacks, and choices that no kernel imports.
fn faults(page: &str) -> Vec<String> {
    let mut imported = BTreeSet::new();
    for folder in WGSL {
        collect(&Path::new(ROOT).join(folder), &mut imported);
    }
    let rows = rows(page);
    let is_listed = |(name, item): &(String, String)| {
        rows.iter().any(|(names, items)| names.contains(name) && items.contains(item))
    };
    let is_imported = |name: &&String| imported.iter().any(|(choice, _)| choice == *name);
    let missing = imported.iter().filter(|import| !is_listed(import));
    let unused = rows.iter().flat_map(|(names, _)| names).filter(|name| !is_imported(name));
    missing
        .map(|(name, item)| format!("docs/pipeline.md lacks {item} of choice::{name}"))
        .chain(unused.map(|name| format!("no kernel imports from choice::{name}")))
        .collect()
}

#[test]
fn choices_are_documented() {
    let page = fs::read_to_string(Path::new(ROOT).join("docs/pipeline.md")).unwrap();
    assert_eq!(faults(&page), [""; 0]);
    assert_eq!(faults(&page.replace("`tile_number`", "")).len(), 1);
    assert_eq!(faults(&page.replace("| `order` |", "| `turn` |")).len(), 2);
}

//! Files that import each other form small circles only.
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};

/// Most files of a circle, in folders where there are larger ones than elsewhere.
const LARGER: &[(&str, usize)] = &[("gpu", 6), ("reference", 6), ("scene", 20)];
const USUAL: usize = 4;

type Modules = BTreeMap<Vec<String>, String>;

fn words(path: &str) -> Vec<String> {
    path.split("::").map(|word| word.trim().to_owned()).collect()
}

/// Modules of `src/` by their paths, with their code: without comments and tests.
fn modules() -> Modules {
    fn add(folder: &Path, root: &Path, found: &mut Modules) {
        for entry in fs::read_dir(folder).unwrap() {
            let path: PathBuf = entry.unwrap().path();
            if path.is_dir() {
                add(&path, root, found);
                continue;
            }
            let name = path.strip_prefix(root).unwrap().with_extension("");
            let mut name: Vec<_> =
                name.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            if ["mod", "lib", "main"].contains(&name.last().unwrap().as_str()) {
                name.pop();
            }
            let text = fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap();
            let lines = code.lines().map(|line| line.split("//").next().unwrap());
            found.insert(name, lines.collect::<Vec<_>>().join("\n"));
        }
    }
    let (root, mut found) = (Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), Modules::new());
    add(&root, &root, &mut found);
    found
}

/// Paths of a `use` tree.
fn leaves(tree: &str) -> Vec<String> {
    let Some((prefix, rest)) = tree.split_once('{') else {
        return vec![tree.split(" as ").next().unwrap().trim().to_owned()];
    };
    // A text may begin a line with "use", too.
    let Some(end) = rest.rfind('}') else { return Vec::new() };
    let body = &rest[..end];
    let (mut depth, mut start, mut found) = (0, 0, Vec::new());
    for (at, c) in body.char_indices().chain([(body.len(), ',')]) {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            let branch = body[start..at].trim();
            start = at + 1;
            let all = if branch.is_empty() { Vec::new() } else { leaves(branch) };
            found.extend(all.into_iter().map(|leaf| format!("{}{leaf}", prefix.trim())));
        }
    }
    found
}

/// Paths that a module's `use` items import, or that it re-exports.
fn imports(code: &str, only_public: bool) -> Vec<String> {
    let mut found = Vec::new();
    for item in code.split(';') {
        let Some(at) = item.rfind("use ") else { continue };
        let before = item[..at].rsplit('\n').next().unwrap().trim();
        let is_item = before.is_empty() || before.starts_with("pub");
        if is_item && (before.starts_with("pub") || !only_public) {
            found.extend(leaves(&item[at + 4..]));
        }
    }
    found
}

/// The module that declares what a path names, as `from` sees it.
fn resolved(modules: &Modules, from: &[String], path: &str, depth: u32) -> Option<Vec<String>> {
    let path = words(path);
    let (mut at, mut rest) = match path[0].as_str() {
        "crate" => (Vec::new(), &path[1..]),
        "self" => (from.to_vec(), &path[1..]),
        "super" => {
            let ups = path.iter().take_while(|word| *word == "super").count();
            (from[..from.len().checked_sub(ups)?].to_vec(), &path[ups..])
        }
        child => {
            let inner = [from, &[child.to_owned()]].concat();
            modules.contains_key(&inner).then_some((inner, &path[1..]))?
        }
    };
    while let [word, others @ ..] = rest {
        let inner = [&at[..], std::slice::from_ref(word)].concat();
        if !modules.contains_key(&inner) {
            let exported = imports(&modules[&at], true);
            let ends = |leaf: &&String| leaf.rsplit("::").next() == Some(word);
            let next = exported.iter().find(ends).filter(|_| depth < 4);
            return next
                .and_then(|leaf| resolved(modules, &at, leaf, depth + 1))
                .or_else(|| modules.contains_key(&at).then_some(at));
        }
        (at, rest) = (inner, others);
    }
    Some(at)
}

/// Modules that each module imports from; folders' own files that only re-export import nothing.
fn arrows(modules: &Modules) -> BTreeMap<Vec<String>, BTreeSet<Vec<String>>> {
    let declares = |code: &str| {
        let is_item = |line: &str| {
            ["fn ", "struct ", "enum ", "impl ", "const ", "static "].iter().any(|word| {
                let line = line.trim_start_matches("pub ");
                line.strip_prefix("pub(crate) ").unwrap_or(line).starts_with(word)
            })
        };
        code.lines().any(is_item)
    };
    let of = |(name, code): (&Vec<String>, &String)| {
        let imported = imports(code, false).into_iter();
        let targets = imported.filter_map(|path| resolved(modules, name, &path, 0));
        let targets = targets.filter(|to| declares(code) && !to.is_empty() && to != name);
        (name.clone(), targets.collect())
    };
    modules.iter().map(of).collect()
}

/// Sets of more than one module of which each reaches each.
fn circles(arrows: &BTreeMap<Vec<String>, BTreeSet<Vec<String>>>) -> Vec<BTreeSet<Vec<String>>> {
    let reached = |from: &Vec<String>| {
        let (mut seen, mut left) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(next) = left.pop() {
            for to in arrows.get(&next).into_iter().flatten() {
                if seen.insert(to.clone()) {
                    left.push(to.clone());
                }
            }
        }
        seen
    };
    let reach: BTreeMap<_, _> = arrows.keys().map(|from| (from, reached(from))).collect();
    let circle = |from: &Vec<String>| -> BTreeSet<Vec<String>> {
        let back = |to: &&Vec<String>| reach.get(to).is_some_and(|seen| seen.contains(from));
        reach[from].iter().filter(back).cloned().collect()
    };
    let all: BTreeSet<_> = arrows.keys().map(circle).filter(|circle| circle.len() > 1).collect();
    all.into_iter().collect()
}

#[test]
fn circles_of_files_are_small() {
    let mut faults = Vec::new();
    for circle in circles(&arrows(&modules())) {
        let folder = &circle.first().unwrap()[0];
        let most = LARGER.iter().find(|(name, _)| name == folder).map_or(USUAL, |row| row.1);
        if circle.len() > most {
            let names: Vec<_> = circle.iter().map(|name| name.join("::")).collect();
            faults.push(format!("{} files: {}", names.len(), names.join(", ")));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_circle_is_found() {
    let sources = [
        ("a", "mod b; mod c;\npub use b::B;"),
        ("a::b", "use super::c::C;\npub struct B;"),
        ("a::c", "use crate::{a::B, other::{Thing, More}};\npub struct C;"),
        ("other", "use std::fmt;\nstruct Thing;"),
    ];
    let modules: Modules =
        sources.iter().map(|(name, code)| (words(name), (*code).to_owned())).collect();
    let circle: BTreeSet<_> = ["a::b", "a::c"].map(words).into();
    assert_eq!(circles(&arrows(&modules)), [circle]);
}

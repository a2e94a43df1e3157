//! Files that import from each other in a circle are understood together only: circles stay small.
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};

/// Files of the largest circle.
const MAX_CIRCLE: usize = 4;

type Module = Vec<String>;

/// Modules of `src/` and their sources, without unit tests and comments.
fn sources() -> BTreeMap<Module, String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = BTreeMap::new();
    let mut folders = vec![root.clone()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let inside = path.strip_prefix(&root).unwrap().with_extension("");
            let mut module: Module =
                inside.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            if ["mod", "lib", "main"].contains(&&*module[module.len() - 1]) {
                module.pop();
            }
            let source = fs::read_to_string(&path).unwrap();
            let code = source.split("#[cfg(test)]\nmod tests").next().unwrap();
            let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            found
                .entry(module)
                .or_insert_with(String::new)
                .push_str(&lines.collect::<Vec<_>>().join("\n"));
        }
    }
    found
}

/// Paths of a `use` tree.
fn paths(tree: &str) -> Vec<Module> {
    let (mut paths, mut stack, mut path) = (Vec::new(), Vec::new(), Module::new());
    let mut word = String::new();
    let mut is_done = false; // a brace closed: what is in it was counted
    for c in tree.chars().chain([',']) {
        match c {
            ':' if !word.is_empty() => path.push(std::mem::take(&mut word)),
            '{' => stack.push(path.clone()),
            ',' | '}' => {
                if !word.trim().is_empty() {
                    let name = word.split(" as ").next().unwrap().trim().to_owned();
                    paths.push(path.iter().cloned().chain([name]).collect());
                } else if !is_done && !path.is_empty() && stack.last() != Some(&path) {
                    paths.push(path.clone());
                }
                word.clear();
                is_done = c == '}';
                if is_done {
                    stack.pop();
                }
                path = stack.last().cloned().unwrap_or_default();
            }
            ':' | '\n' => {}
            _ => {
                is_done = false;
                word.push(c);
            }
        }
        word = word.trim_start().to_owned();
    }
    paths
}

/// The imports of a module: whether it passes them on, and their paths from the root.
fn imports(module: &[String], source: &str) -> Vec<(bool, Module)> {
    let mut all = Vec::new();
    for statement in source.split(';') {
        let Some(at) = statement.rfind("use ").filter(|&at| {
            let before = statement[..at].trim_end_matches(')').trim_end();
            at == 0 || statement[..at].ends_with(['\n', ' ']) || before.ends_with("pub")
        }) else {
            continue;
        };
        let passes_on =
            statement[..at].trim_end().rsplit('\n').next().unwrap().trim().starts_with("pub");
        for path in paths(&statement[at + 4..]) {
            let mut from = match &*path[0] {
                "crate" => Module::new(),
                "super" => module[..module.len().saturating_sub(1)].to_vec(),
                _ => module.to_vec(),
            };
            let is_word = |part: &String| ["crate", "super", "self"].contains(&&**part);
            for part in &path[usize::from(is_word(&path[0]))..] {
                if part == "super" {
                    from.pop();
                } else {
                    from.push(part.clone());
                }
            }
            all.push((passes_on, from));
        }
    }
    all
}

/// Files that each file takes names from, seen through `pub use`.
fn arrows(sources: &BTreeMap<Module, String>) -> BTreeMap<Module, BTreeSet<Module>> {
    let of: BTreeMap<_, _> =
        sources.iter().map(|(module, source)| (module, imports(module, source))).collect();
    let owner = |path: &[String]| -> Option<Module> {
        let mut path = path.to_vec();
        for _ in 0..8 {
            let length = (1..=path.len()).rev().find(|&n| sources.contains_key(&path[..n]))?;
            let (file, rest) = path.split_at(length);
            // A module of another folder, by `#[path]`.
            if rest.first().is_some_and(|name| sources[file].contains(&format!("mod {name};"))) {
                return None;
            }
            let passed = rest.first().and_then(|name| {
                let mut on = of[&file.to_vec()].iter().filter(|(passes_on, _)| *passes_on);
                on.find(|(_, to)| to.last() == Some(name)).map(|(_, to)| to.clone())
            });
            match passed {
                Some(to) => path = to,
                None => return Some(file.to_vec()),
            }
        }
        None
    };
    let of_file = |(module, imports): (&&Module, &Vec<(bool, Module)>)| {
        let used = imports.iter().filter(|(passes_on, _)| !passes_on);
        let to: BTreeSet<_> = used.filter_map(|(_, path)| owner(path)).collect();
        ((**module).clone(), to.into_iter().filter(|to| to != *module).collect())
    };
    of.iter().map(of_file).collect()
}

/// Files that reach each other.
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
        (module.split('/').map(str::to_owned).collect(), text.to_owned())
    };
    let sources = BTreeMap::from([
        source("a", "mod b;\npub use b::{B, C as D};"),
        source("a/b", "use crate::{e::{self, E}, f};"),
        source("e", "use super::a::B;\nuse std::fmt;"),
        source("f", "pub(crate) use crate::e::F;"),
    ]);
    let arrows = arrows(&sources);
    let names =
        |files: &BTreeSet<Module>| files.iter().map(|file| file.join("/")).collect::<Vec<_>>();
    assert_eq!(names(&arrows[&vec!["a".to_owned(), "b".to_owned()]]), ["e", "f"]);
    let found: Vec<_> = circles(&arrows).iter().map(names).collect();
    assert_eq!(found, [["a/b", "e"]]);
}

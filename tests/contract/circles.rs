//! Files of `src/` depend on each other in one direction, apart from small circles.
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::Path,
};
use syn::visit::{Visit, visit_item_mod, visit_path};

/// Most files of a circle.
const MAX_FILES: usize = 4;

/// What a file declares and names. Unit tests count as no part of it.
#[derive(Default)]
struct Names {
    /// Paths in the code, except those that are only handed on: `pub use`.
    used: Vec<Vec<String>>,
    /// Paths of all that the file imports.
    imported: Vec<Vec<String>>,
}

impl Names {
    fn of(source: &str) -> Self {
        let mut names = Self::default();
        names.visit_file(&syn::parse_file(source).unwrap());
        names
    }
}

impl<'a> Visit<'a> for Names {
    fn visit_item_mod(&mut self, module: &'a syn::ItemMod) {
        if module.attrs.iter().all(|attribute| !attribute.path().is_ident("cfg")) {
            visit_item_mod(self, module);
        }
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        let before = self.imported.len();
        branches(&item.tree, &[], &mut self.imported);
        if matches!(item.vis, syn::Visibility::Inherited) {
            self.used.extend_from_slice(&self.imported[before..]);
        }
    }

    /// `pub(super)` names a file without using it.
    fn visit_visibility(&mut self, _: &'a syn::Visibility) {}

    fn visit_path(&mut self, path: &'a syn::Path) {
        self.used.push(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        visit_path(self, path);
    }
}

/// Paths of a tree, each with the name it has in the file at last.
fn branches(tree: &syn::UseTree, before: &[String], found: &mut Vec<Vec<String>>) {
    let with = |name: &syn::Ident| [before, &[name.to_string()]].concat();
    match tree {
        syn::UseTree::Path(path) => branches(&path.tree, &with(&path.ident), found),
        syn::UseTree::Name(name) => found.push(with(&name.ident)),
        syn::UseTree::Rename(name) => found.push(with(&name.ident)),
        syn::UseTree::Glob(_) => found.push(before.to_vec()),
        syn::UseTree::Group(group) => {
            group.items.iter().for_each(|tree| branches(tree, before, found));
        }
    }
}

/// Files by their path of modules.
type Files = BTreeMap<Vec<String>, Names>;

/// Files of `src/` except the program's root, which only calls the library.
fn files() -> Files {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/src"));
    let (mut pending, mut files) = (vec![root.to_owned()], Files::new());
    while let Some(path) = pending.pop() {
        if path.is_dir() {
            pending.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        let name = path.strip_prefix(root).unwrap().with_extension("");
        let mut name: Vec<_> = name.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
        if ["lib", "mod"].contains(&name.last().unwrap().as_str()) {
            name.pop();
        }
        files.insert(name, Names::of(&fs::read_to_string(path).unwrap()));
    }
    files
}

/// The file that declares what a path of `file` leads to, through files that only hand it on.
fn target<'a>(files: &'a Files, file: &[String], path: &[String]) -> Option<&'a Vec<String>> {
    let mut at = match path[0].as_str() {
        "crate" => Vec::new(),
        "super" => file[..file.len().checked_sub(1)?].to_vec(),
        "self" => file.to_vec(),
        _ => [file, &path[..1]].concat(),
    };
    let is_child = !["crate", "super", "self"].contains(&path[0].as_str());
    if is_child && !files.contains_key(&at) {
        return None;
    }
    for (i, name) in path.iter().enumerate().skip(1) {
        let inner = [&at[..], std::slice::from_ref(name)].concat();
        if name == "super" {
            at.pop();
        } else if files.contains_key(&inner) {
            at = inner;
        } else {
            let imported = &files.get(&at)?.imported;
            let known = imported.iter().find(|known| known.last() == Some(name));
            return match known.filter(|_| at != file) {
                Some(known) => target(files, &at, &[known, &path[i + 1..]].concat()),
                // A module that stands elsewhere, or a name of the file's own.
                None if path.len() > i + 1 && name.starts_with(char::is_lowercase) => None,
                None => files.get_key_value(&at).map(|(at, _)| at),
            };
        }
    }
    files.get_key_value(&at).map(|(at, _)| at)
}

/// Sets of files each of which leads to all others of its set.
fn circles(files: &Files) -> Vec<Vec<&Vec<String>>> {
    let targets = |file, names: &Names| -> BTreeSet<&Vec<String>> {
        names.used.iter().filter_map(|path| target(files, file, path)).collect()
    };
    let arrows: BTreeMap<_, _> =
        files.iter().map(|(file, names)| (file, targets(file, names))).collect();
    let reached = |from| {
        let (mut reached, mut pending) = (BTreeSet::new(), vec![from]);
        while let Some(file) = pending.pop() {
            pending.extend(arrows[file].iter().filter(|file| reached.insert(**file)));
        }
        reached
    };
    let reached: BTreeMap<_, _> = files.keys().map(|file| (file, reached(file))).collect();
    let mut circles: Vec<Vec<_>> = Vec::new();
    for file in files.keys() {
        let is_in = |circle: &&mut Vec<&Vec<String>>| {
            reached[circle[0]].contains(file) && reached[file].contains(circle[0])
        };
        match circles.iter_mut().find(is_in) {
            Some(circle) => circle.push(file),
            None => circles.push(vec![file]),
        }
    }
    circles.retain(|circle| circle.len() > 1);
    circles
}

#[test]
fn circles_of_files_are_small() {
    let files = files();
    let larger = circles(&files).into_iter().filter(|circle| circle.len() > MAX_FILES);
    let names: Vec<_> =
        larger.map(|circle| circle.iter().map(|file| file.join("/")).collect::<Vec<_>>()).collect();
    assert_eq!(names, [[""; 0]; 0]);
}

/// The check can fail: three files, the second of which hands on what the third declares.
#[test]
fn a_circle_is_found() {
    let name =
        |path: &str| path.split('/').filter(|it| !it.is_empty()).map(str::to_owned).collect();
    let circle = |last: &str| {
        let sources = [
            ("", "mod a;"),
            ("a", "mod b; mod c; pub use c::{Of as It, Other};"),
            ("a/b", "use super::Other; fn f(_: Other) {}"),
            ("a/c", last),
        ];
        let files = sources.into_iter().map(|(path, source)| (name(path), Names::of(source)));
        circles(&files.collect()).into_iter().map(|circle| circle.len()).collect::<Vec<_>>()
    };
    assert_eq!(circle("pub struct Of; pub struct Other;"), [0; 0]);
    for back in ["use super::b::f;", "fn g() { super::b::f(); }", "fn g(_: crate::a::b::T<u32>) {}"]
    {
        assert_eq!(circle(&format!("pub struct Of; pub struct Other; {back}")), [2], "{back}");
    }
    assert_eq!(circle("#[cfg(test)] mod tests { use super::super::b::f; }"), [0; 0]);
}

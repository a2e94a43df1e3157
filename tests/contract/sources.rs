//! The files of all crates as modules, and their imports. A module of the library has its path there, a
//! module of another crate the path after the crate's name.
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
};
use syn::visit::{self, Visit};

/// Path of a module from the crate's root, or of a name in one.
pub(super) type Module = Vec<String>;

/// Crates beside the library: first segment of their paths, and folder.
pub(super) const CRATES: &[(&str, &str)] = &[
    ("gobo_cli", "gobo-cli"),
    ("gobo_picture", "gobo-picture"),
    ("gobo_reference", "gobo-reference"),
    ("gobo_scene", "gobo-scene"),
];

/// Imports and exports of a file.
#[derive(Debug, Default)]
pub(super) struct Source {
    /// The file's module.
    module: Module,
    /// The file's crate: its name, or empty for the library.
    root: Module,
    /// Imported paths, from the root.
    pub(super) used: Vec<Module>,
    /// Names that others may import through it, each with its path from the root.
    pub(super) passed: Vec<(String, Module)>,
    /// Modules of another folder, by `#[path]`.
    pub(super) elsewhere: Vec<String>,
}

impl Source {
    /// Reads a file, without its unit tests.
    pub(super) fn of(module: &[String], text: &str) -> Self {
        let is_crate = |name: &&String| CRATES.iter().any(|(own, _)| own == name);
        let root = module.first().filter(is_crate).into_iter().cloned().collect();
        let mut source = Self { module: module.to_vec(), root, ..Self::default() };
        source.visit_file(&syn::parse_file(text).unwrap());
        source
    }

    /// Absolute path of written segments; `None` in another crate, or for a name that a `use` introduced.
    fn absolute(&self, path: &[String]) -> Option<Module> {
        let mut from = match path[0].as_str() {
            "crate" => self.root.clone(),
            "gobo" => Module::new(),
            "self" | "super" => self.module.clone(),
            name if CRATES.iter().any(|(own, _)| *own == name) => vec![name.to_owned()],
            _ => return None,
        };
        let is_named = !["self", "super"].contains(&path[0].as_str());
        for part in path.iter().skip(usize::from(is_named)) {
            match part.as_str() {
                "self" => {}
                "super" => drop(from.pop()),
                _ => from.push(part.clone()),
            }
        }
        Some(from)
    }

    fn visit_tree(&mut self, passes_on: bool, before: &[String], tree: &syn::UseTree) {
        let with = |ident: &syn::Ident| [before, &[ident.to_string()]].concat();
        // The name that others know it by; `None` for all names of a module.
        let (name, path) = match tree {
            syn::UseTree::Path(path) => {
                return self.visit_tree(passes_on, &with(&path.ident), &path.tree);
            }
            syn::UseTree::Group(group) => {
                let trees = group.items.iter();
                return trees.for_each(|tree| self.visit_tree(passes_on, before, tree));
            }
            syn::UseTree::Name(name) => (Some(&name.ident), with(&name.ident)),
            syn::UseTree::Rename(rename) => (Some(&rename.rename), with(&rename.ident)),
            syn::UseTree::Glob(_) => (None, before.to_vec()),
        };
        // `use child::Name` names a module's own child.
        let path = self.absolute(&path).unwrap_or_else(|| [&self.module[..], &path].concat());
        self.passed.extend(name.map(|name| (name.to_string(), path.clone())));
        if !passes_on || name.is_none() {
            self.used.push(path);
        }
    }
}

impl Visit<'_> for Source {
    fn visit_item_mod(&mut self, item: &syn::ItemMod) {
        if item.attrs.iter().any(|attribute| attribute.path().is_ident("path")) {
            self.elsewhere.push(item.ident.to_string());
        }
        if item.ident != "tests" {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &syn::ItemUse) {
        let passes_on = !matches!(item.vis, syn::Visibility::Inherited);
        self.visit_tree(passes_on, &[], &item.tree);
    }

    fn visit_path(&mut self, path: &syn::Path) {
        let segments: Vec<_> =
            path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.used.extend(self.absolute(&segments));
        visit::visit_path(self, path);
    }

    fn visit_visibility(&mut self, _: &syn::Visibility) {}
}

/// All files of `folder`.
pub(super) fn files(folder: &Path) -> Vec<PathBuf> {
    if folder.is_file() {
        return vec![folder.to_owned()];
    }
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries.flat_map(|entry| files(&entry)).collect()
}

/// The modules of all crates.
pub(super) fn sources() -> BTreeMap<Module, Source> {
    let root = Path::new(crate::common::ROOT);
    let beside = CRATES.iter().flat_map(|&(name, folder)| {
        modules(&root.join("crates").join(folder).join("src"), &[name.to_owned()])
    });
    modules(&root.join("src"), &[]).into_iter().chain(beside).collect()
}

/// The modules of the crate whose files are in a folder.
fn modules(folder: &Path, root: &[String]) -> Vec<(Module, Source)> {
    let of_file = |file: PathBuf| {
        let inside = file.strip_prefix(folder).unwrap().with_extension("");
        let inside = inside.iter().map(|part| part.to_string_lossy().into_owned());
        let mut module: Module = root.iter().cloned().chain(inside).collect();
        if ["mod", "lib", "main"].contains(&module[module.len() - 1].as_str()) {
            module.pop();
        }
        let source = Source::of(&module, &fs::read_to_string(&file).unwrap());
        (module, source)
    };
    let is_module = |file: &PathBuf| {
        file.extension().is_some_and(|extension| extension == "rs") && !file.ends_with("main.rs")
    };
    files(folder).into_iter().filter(is_module).map(of_file).collect()
}

/// Files whose declarations each file names, also through `pub use`.
pub(super) fn arrows(sources: &BTreeMap<Module, Source>) -> BTreeMap<Module, BTreeSet<Module>> {
    let declared_in = |path: &Module| -> Option<Module> {
        let mut path = path.clone();
        for _ in 0..8 {
            let length = (0..=path.len()).rev().find(|&n| sources.contains_key(&path[..n]))?;
            let (file, rest) = path.split_at(length);
            let source = &sources[file];
            if rest.first().is_some_and(|name| source.elsewhere.contains(name)) {
                return None;
            }
            let passed = rest.first().and_then(|name| {
                let (_, to) = source.passed.iter().find(|(passed, _)| passed == name)?;
                Some([to, &rest[1..]].concat())
            });
            match passed {
                Some(to) => path = to,
                None => return Some(file.to_vec()),
            }
        }
        None
    };
    let of_file = |(module, source): (&Module, &Source)| {
        let to: BTreeSet<_> = source.used.iter().filter_map(declared_in).collect();
        (module.clone(), to.into_iter().filter(|to| to != module).collect())
    };
    sources.iter().map(of_file).collect()
}
